"""slipdisk film: films have the frames, the size and the length that were asked for, and show the disks."""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from plot_common import make, program

from slipdisk import film  # noqa: E402
from slipdisk.library import UserError  # noqa: E402
from slipdisk.plot_source import Source  # noqa: E402

HERE = None


def setUpModule():
    global HERE
    folder = tempfile.TemporaryDirectory()
    unittest.addModuleCleanup(folder.cleanup)
    HERE = pathlib.Path(folder.name)
    make(HERE, ("shaken", "three", "cemented"), sweep=False)


def probe(path):
    out = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", path], capture_output=True, text=True,
                         check=True).stdout
    stream, = json.loads(out)["streams"]
    return stream


def pixels(path, k, size):
    """[height][width][3] of frame k."""
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", path, "-vf", f"select=eq(n\\,{k})", "-frames:v", "1", "-f", "rawvideo", "-pix_fmt",
                          "rgb24", "-"], capture_output=True, check=True).stdout
    return np.frombuffer(raw, np.uint8).reshape(size[1], size[0], 3)


class Films(unittest.TestCase):
    def run_it(self, *words, status=0, **more):
        done = subprocess.run([program(), "film", *map(str, words)], cwd=HERE, capture_output=True, text=True, timeout=600, **more)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        return done.stdout, done.stderr

    def test_mp4(self):
        out, err = self.run_it("shaken.h5", "--frames", "1::2", "--fps", 4, "--color", "spin", "--network")
        source = Source(HERE / "shaken.h5")
        n = len(range(1, source.n_frames, 2))
        stream = probe(HERE / "shaken.mp4")
        self.assertEqual((stream["codec_name"], stream["pix_fmt"], int(stream["nb_read_frames"])), ("h264", "yuv420p", n))
        self.assertAlmostEqual(float(stream["duration"]), n / 4, delta=0.3)
        self.assertEqual((stream["width"] % 2, stream["height"] % 2), (0, 0))
        self.assertIn(f"shaken.mp4: {n} frames, {n / 4:.3g} s, {stream['width']} x {stream['height']} pixels", out)
        self.assertEqual(err, "")

    def test_gif(self):
        self.run_it("three.h5", "-o", "small.gif", "--frames", ":5", "--size", "301x201", "--fps", 5)
        stream = probe(HERE / "small.gif")
        self.assertEqual((stream["codec_name"], stream["width"], stream["height"], int(stream["nb_read_frames"])), ("gif", 301, 201, 5))
        self.assertAlmostEqual(float(stream["duration"]), 1, delta=0.05)

    def test_frames_show_the_disks(self):
        """Where a disk is, its colour is seen; frames are in the order of the file."""
        source = Source(HERE / "shaken.h5")
        ks = [0, source.n_frames - 1]
        film.film(source, str(HERE / "two.mp4"), frames=f"::{ks[1]}", color="moved", size=(640, 480), fps=5)
        with film.style.look():
            canvas = film.Canvas(source, ks, "moved", size=(640, 480))
            for n, k in enumerate(ks):
                drawn = canvas.draw(k)[:, :, :3].astype(int)
                self.assertLess(np.abs(drawn - pixels(HERE / "two.mp4", n, (640, 480))).mean(), 3)
            i = int(np.argmax(source.radius))
            angle = source.frame("angle", k)[i] + np.pi
            at = source.place(k)[i] + 0.5 * source.radius[i] * np.array([np.cos(angle), np.sin(angle)])
            x, y = canvas.scene.ax.transData.transform(at)
            moved = np.hypot(*(source.place(k, True)[i] - source.place(ks[0], True)[i]))
            wanted = np.array(canvas.scene.disks.cmap(canvas.scene.norm(moved))[:3]) * 255
        self.assertLess(np.abs(drawn[480 - 1 - int(y), int(x)] - wanted).max(), 8)
        self.assertGreater(np.abs(canvas.draw(ks[0]).astype(int) - canvas.draw(ks[1])).mean(), 1)

    def test_many_processes_draw_the_same(self):
        source = Source(HERE / "shaken.h5")
        ks = list(range(source.n_frames))
        canvas = film.Canvas(source, ks, "spin", size=(320, 240), region=(-0.1, 0.1, 0, 0.2))
        self.assertEqual((canvas.scene.ax.get_xlim(), canvas.scene.ax.get_ylim()), ((-0.1, 0.1), (0, 0.2)))
        alone = list(film._all_frames(canvas, ks))
        before, film.PARALLEL = film.PARALLEL, 1
        self.addCleanup(setattr, film, "PARALLEL", before)
        self.assertEqual(list(film._all_frames(canvas, ks)), alone)
        self.assertGreater(len(set(alone)), len(ks) // 2)

    def test_each_break_flashes_once(self):
        source = Source(HERE / "cemented.h5")
        ks = list(range(1, source.n_frames, 3))
        canvas, times = film.Canvas(source, ks, "speed", size=(320, 240)), source.breaks["time"]
        seen = 0
        for k in ks:
            canvas.draw(k)
            seen += len(canvas.scene.cracks.get_xdata())
        self.assertGreater(seen, 3)
        self.assertEqual(seen, ((times > source.frame_times[0]) & (times <= source.frame_times[ks[-1]] * (1 + 1e-12))).sum())

    def test_mistakes(self):
        for words, said in ((["--frames", "a:b"], "expected a frame"), (["--frames", "1"], "a film needs two frames"),
                            (["--frames", "900:"], "no frame"), (["-o", "a.avi"], "expected .mp4 or .gif"), (["--size", "301x200"], "even"),
                            (["--fps", "0"], "frames per second"), (["--color", "group", "--size", "x"], "WIDTHxHEIGHT")):
            with self.subTest(words):
                _, err = self.run_it("shaken.h5", *words, status=2)
                self.assertIn(said, err)
        before = sorted(HERE.iterdir())
        self.run_it("shaken.h5", "-o", "nowhere/a.mp4", status=4)
        self.assertEqual(sorted(HERE.iterdir()), before)

    def test_without_ffmpeg(self):
        python = os.environ.get("SLIPDISK_PYTHON") or sys.executable
        before = sorted(HERE.iterdir())
        _, err = self.run_it("shaken.h5", "-o", "none.mp4", status=4, env={**os.environ, "PATH": "/nowhere", "SLIPDISK_PYTHON": python})
        self.assertIn("films need the program ffmpeg", err)
        self.assertEqual(sorted(HERE.iterdir()), before)

    def test_failing_ffmpeg_leaves_nothing(self):
        folder = HERE / "bin"
        folder.mkdir()
        (folder / "ffmpeg").write_text('#!/bin/sh\nhead -c 1000 >/dev/null\neval last=\\${$#}\necho half > "$last"\necho no space left >&2\nexit 1\n')
        (folder / "ffmpeg").chmod(0o755)
        before = sorted(HERE.iterdir())
        _, err = self.run_it("shaken.h5", "-o", "bad.mp4", status=4, env={**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"})
        self.assertIn("bad.mp4: ffmpeg: no space left", err)
        self.assertEqual(sorted(HERE.iterdir()), before)

    def test_ranges(self):
        self.assertEqual(film.frame_list("::3", 10, ""), [0, 3, 6, 9])
        self.assertEqual(film.frame_list("-3:", 10, ""), [7, 8, 9])
        self.assertEqual(film.frame_list(None, 3, ""), [0, 1, 2])
        self.assertEqual(film.frame_list("-1", 10, ""), [9])
        for text in ("a", "::0", "1:2:3:4", "10"):
            with self.assertRaises(UserError):
                film.frame_list(text, 10, "x.h5")


if __name__ == "__main__":
    unittest.main()
