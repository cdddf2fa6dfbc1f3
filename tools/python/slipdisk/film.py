"""Films of results: `slipdisk film`, frames drawn with matplotlib and made into MP4 or GIF by ffmpeg; docs/plots.md.

film("drum.h5", "drum.mp4", frames="::2", color="spin")
"""
from __future__ import annotations

import argparse
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from . import library as lib
from . import plot_style as style
from .arguments import checked
from .plot import default_output, pair, region_of, tell
from .plot_scene import Scene, extent
from .plot_source import Drawable, Source, usual_quantity

ENDINGS = (".mp4", ".gif")
DPI = 100
LONG = 1280  # pixels of the longer side
PARALLEL = 100_000  # disks in all frames from which on several processes draw
MOST = 5_000_000  # positions looked at to find the limits


def frame_list(text, n, path):
    """Numbers of the frames of FIRST:LAST:STEP, by Python's rules for slices; a single number is one frame."""
    words = text.split(":") if text else [""]
    try:
        numbers = [int(word) if word else None for word in words]
        if len(numbers) > 3 or (len(numbers) == 1 and text and numbers[0] is None) or (len(numbers) == 3 and numbers[2] == 0):
            raise ValueError
    except ValueError:
        raise lib.UserError(f"--frames {text}: expected FIRST:LAST:STEP as of a slice in Python, or one number") from None
    if text and len(numbers) == 1:
        number = numbers[0] + n if numbers[0] < 0 else numbers[0]
        found = [number] if 0 <= number < n else []
    else:
        found = list(range(n))[slice(*numbers)]
    if not found:
        raise lib.UserError(f"--frames {text or ''}: no frame of {path} is among them; it has {n}".replace("--frames :", path + ":"))
    return found


class Canvas:
    """A picture of fixed size in which only disks, walls, contacts and time are drawn anew for each frame."""

    def __init__(self, source, ks, color=None, network=False, size=None, region=None):
        few = ks if len(ks) * len(source.radius) <= MOST else [ks[i] for i in np.unique(np.linspace(0, len(ks) - 1, MOST // len(source.radius))
                                                                                         .astype(int))]
        (x0, x1), (y0, y1) = extent(source, few, region)
        low = y1 - y0 < 0.5 * (x1 - x0)
        aside, above = (0.3, 1.4) if low else (1.6, 0.55)  # inches for the colour bar, the time and the rim
        if size is None:
            scale = min((LONG / DPI - aside) / (x1 - x0), (LONG / DPI - above) / (y1 - y0), (960 / DPI - above) / (y1 - y0))
            size = [int((edge * scale + more) * DPI) // 2 * 2 for edge, more in ((x1 - x0, aside), (y1 - y0, above))]
            size = [max(edge, 320) for edge in size]
        width, height = ((edge + 0.01) / DPI for edge in size)  # edges are cut to whole pixels
        picture = Figure((width, height), dpi=DPI)
        self.canvas = FigureCanvasAgg(picture)
        self.size = self.canvas.get_width_height()
        below = 1.0 if low else 0.15
        ax = picture.add_axes([0.15 / width, below / height, 1 - aside / width, 1 - above / height])
        ax.set(xticks=[], yticks=[])
        ax.spines[:].set_visible(False)
        if color is None and usual_quantity(source) == "pressure":
            color = "speed"  # it is there without measuring each frame
        ax.set(xlim=(x0, x1), ylim=(y0, y1))
        ax.set_aspect("equal")
        self.scene = Scene(source, ax, few, color, network, first=ks[0], region=region)
        self.scene.before = dict(zip(ks[1:], ks))
        ax.apply_aspect()
        x, y, right, top = ax.get_position().extents
        self.scene.colour_bar(picture.add_axes([x, y - 0.35 / height, right - x, 0.18 / height] if low else
                                               [right + 0.15 / width, y, 0.22 / width, top - y]), low)
        self.time = ax.text(0, 1.01, "t = 0", transform=ax.transAxes, fontsize=10, va="bottom")
        self.scene.resize()
        if network:  # the same widths in all frames
            means = [source.measured(k)["frames"]["mean_force"][0] for k in (ks[0], ks[len(ks) // 2], ks[-1])]
            self.scene.mean_force = float(np.nanmax([*means, 0.0])) or None
        self.moving = [*self.scene.moving, self.time]
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw()
        self.background = self.canvas.copy_from_bbox(picture.bbox)
        times = source.frame_times
        step = np.diff(times[ks]).min(initial=np.inf) if len(ks) > 1 else np.inf
        digits = int(np.clip(2 - np.floor(np.log10(step)), 0, 9)) if np.isfinite(step) and step > 0 else 3
        self.text = f"t = {{:{len(f'{times[ks[-1]]:.{digits}f}')}.{digits}f}}"
        self.times = times

    def draw(self, k):
        """Pixels [height][width][4] of frame k."""
        self.scene.show(k)
        self.time.set_text(self.text.format(self.times[k]))
        self.canvas.restore_region(self.background)
        renderer = self.canvas.get_renderer()
        for artist in self.moving:
            artist.draw(renderer)
        return np.asarray(self.canvas.buffer_rgba())


def _begin_worker(canvas):
    global _CANVAS
    _CANVAS = canvas
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the first process ends all


def _draw(k):
    return _CANVAS.draw(k).tobytes()


def _all_frames(canvas, ks):
    """Pixels of the frames in their order; drawn by a process per core when there is much to draw."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
    if cores < 2 or len(ks) * len(canvas.scene.source.radius) < PARALLEL:
        yield from (canvas.draw(k).tobytes() for k in ks)
        return
    with multiprocessing.get_context("fork").Pool(min(cores, len(ks)), _begin_worker, (canvas,)) as pool:
        for first in range(0, len(ks), 4 * cores):  # so that no more than these wait in memory
            yield from pool.imap(_draw, ks[first:first + 4 * cores])


def _ffmpeg(words, frames, path):
    """Feeds frames into ffmpeg."""
    program = shutil.which("ffmpeg")
    if program is None:
        raise lib.FileError("films need the program ffmpeg, which is not found (apt install ffmpeg)")
    with tempfile.TemporaryFile() as said:
        with subprocess.Popen([program, "-hide_banner", "-loglevel", "error", "-y", "-nostdin", *words], stdin=subprocess.PIPE, stderr=said) as process:
            try:
                for frame in frames:
                    process.stdin.write(frame)
                process.stdin.close()
            except BrokenPipeError:
                pass  # what ffmpeg says is told below
            except BaseException:
                process.kill()
                raise
            status = process.wait()
        if status:
            said.seek(0)
            lines = said.read().decode("utf-8", "replace").strip().splitlines()
            raise lib.FileError(f"{path}: ffmpeg: {lines[-1] if lines else f'status {status}'}")


@checked
def film(result: Drawable, output: lib.StrPath, *, frames: str | None = None, color: str | None = None, network: bool = False,
         fps: lib.Positive | None = None, size: tuple[int, int] | None = None, region: Sequence[float] | None = None, dark: bool = False,
         progress: Callable[[int, int], object] | None = None) -> tuple[int, float, tuple[int, int]]:
    """Makes a film of frames (text FIRST:LAST:STEP as a slice, all by default); fps: by default so many that it takes ten
    seconds, from 5 to 30. Returns (frames, fps, size)."""
    ending = style.check_ending(output, ENDINGS)
    if size and ending == ".mp4" and (size[0] % 2 or size[1] % 2):
        raise lib.UserError(f"--size {size[0]}x{size[1]}: expected even numbers, as MP4 needs them")
    source = Source.of(result)
    ks = frame_list(frames, source.n_frames, source.path)
    if len(ks) < 2:
        raise lib.UserError(f"{source.path}: a film needs two frames, there {'is one' if len(ks) == 1 else 'is none'}; set frames in a phase "
                            "of the deck, or see slipdisk plot")
    fps = fps or float(np.clip(np.round(len(ks) / 10), 5, 30))
    with style.look(dark), style.written(output) as part:
        canvas = Canvas(source, ks, color, network, size, region)
        raw = ["-f", "rawvideo", "-pix_fmt", "rgba", "-s", "{}x{}".format(*canvas.size), "-r", f"{fps:g}", "-i", "-"]

        def drawn(numbers):
            for n, pixels in enumerate(_all_frames(canvas, numbers)):
                if progress:
                    progress(n + 1, len(numbers))
                yield pixels
        if ending == ".mp4":
            _ffmpeg([*raw, "-an", "-c:v", "libx264", "-preset", "fast", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart", part],
                    drawn(ks), output)
        else:
            with tempfile.TemporaryDirectory(prefix="slipdisk-film-") as folder:  # the colours of a few frames, then the film
                palette = os.path.join(folder, "palette.png")
                few = [ks[i] for i in np.unique(np.linspace(0, len(ks) - 1, 8).astype(int))]
                _ffmpeg([*raw, "-vf", "palettegen=stats_mode=full", palette], drawn(few), output)
                _ffmpeg([*raw, "-i", palette, "-lavfi", "[0:v][1:v]paletteuse=dither=none", part], drawn(ks), output)
    return len(ks), fps, canvas.size


def show_progress(done, total):
    print(f"\r{done} of {total} frames", end="\n" if done == total else "", file=sys.stderr, flush=True)


def make(a):
    output = a.output or default_output(a.file, ".mp4")
    n, fps, size = film(a.file, output, frames=a.frames, color=a.color, network=a.network, fps=a.fps, size=a.size, region=a.region, dark=a.dark,
                        progress=show_progress if sys.stderr.isatty() else None)
    print(f"{output}: {n} frames, {n / fps:.3g} s, {size[0]} x {size[1]} pixels")


def main(words=None):
    parser = argparse.ArgumentParser(prog="slipdisk film", allow_abbrev=False)
    parser.add_argument("file")
    parser.add_argument("--output")
    parser.add_argument("--frames")
    parser.add_argument("--color")
    parser.add_argument("--network", action="store_true")
    parser.add_argument("--fps", type=float)
    parser.add_argument("--size", type=lambda text: pair(text, int))
    parser.add_argument("--region", type=region_of)
    parser.add_argument("--dark", action="store_true")
    a = parser.parse_args(words)
    return tell("film", lambda: make(a))


if __name__ == "__main__":
    sys.exit(main())
