"""--live: a running simulation over HTTP: the numbers, the same result in every bit, and what is refused."""
import http.client
import json
import os
import re
import signal
import socket
import subprocess
import threading
import time
import unittest

import h5py
import numpy

from results_common import LONG, Folder, assert_same, deck_arguments, run, start, steps_for, wait_for
from view_page import Chunk

ADDRESS = re.compile(r"live: http://127\.0\.0\.1:(\d+)/([0-9a-f]{32})/$")
ENDLESS = deck_arguments(1000, 10**12, frames=0)


class Live(Folder):
    def serve(self, *words, **more):
        """The process, once it has told its address."""
        self.process = start(*words, **more)
        self.addCleanup(self.end)
        line = self.process.stderr.readline()
        while line.startswith("warning: "):
            line = self.process.stderr.readline()
        found = ADDRESS.match(line.strip())
        self.assertTrue(found, line)
        self.port, self.token = int(found[1]), found[2]
        return self.process

    def end(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()

    def ask(self, path, method="GET", host=None, token=None, prefix=None, headers=()):
        """(status, headers, body)"""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=LONG)
        connection.putrequest(method, prefix if prefix is not None else f"/{token or self.token}/{path}", skip_host=True)
        if host != "":
            connection.putheader("Host", host or f"127.0.0.1:{self.port}")
        for name, value in headers:
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer.status, answer.headers, body

    def chunk(self, path):
        status, headers, body = self.ask(path)
        self.assertIn(status, (200, 204))
        return Chunk(body) if status == 200 else None

    def status(self):
        return json.loads(self.ask("status")[2])

    def frame(self, after=-1):
        """The first that is newer."""
        found = []
        wait_for(lambda: found.append(self.chunk(f"frame?after={after}")) or found[-1])
        return found[-1]


class Numbers(Live):
    def test_frames_series_and_the_end(self):
        process = self.serve("view", *deck_arguments(1000, steps_for(3), frames=0), "--live", cwd=self.folder)
        meta = json.loads(self.ask("meta")[2])
        self.assertEqual((meta["kind"], meta["disks"]), ("live", 3))
        fixed = self.chunk("static")
        numpy.testing.assert_array_equal(fixed["radius"], [1, 1, 1])
        frames = [self.frame()]
        for _ in range(3):
            frames.append(self.frame(frames[-1].head["step"]))
        self.assertEqual(sorted(f.head["step"] for f in frames), [f.head["step"] for f in frames])
        for f in frames:
            self.assertEqual(len(f["x"]), 3)
            numpy.testing.assert_allclose(f["y"][1:], -numpy.sqrt(3), atol=1e-3)  # the supports
        wait_for(lambda: self.status()["finished"])
        last, rows = self.frame(), self.chunk("series?from=0")
        self.assertEqual(last.head["step"], self.status()["step"])
        self.assertEqual(self.ask(f"frame?after={last.head['step']}")[0], 204)
        self.assertEqual(rows.head["from"], 0)
        names = {s["name"] for s in meta["series"]}
        self.assertEqual(set(rows.columns), names | {"time"})
        self.assertEqual(rows["time"][-1], last.head["time"])
        count = len(rows["time"])
        numpy.testing.assert_array_equal(self.chunk("series?from=1")["time"], rows["time"][1:])
        self.assertEqual(self.ask(f"series?from={count}")[0], 204)
        self.assertEqual(self.chunk(f"series?from={count + 5}").head["from"], 0)  # rows that are gone: all anew
        status, headers, page = self.ask("")
        self.assertIn(b'id="slipdisk-meta"', page)
        self.assertIsNone(process.poll())  # it stays
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=LONG)
        self.assertEqual((process.returncode, out), (0, ""))
        self.assertIn("the run has come to its end", err)
        self.assertEqual(list(self.folder.iterdir()), [])  # nothing is written
        with self.assertRaises(OSError):
            self.ask("status")

    def test_same_bits_as_without(self):
        words = deck_arguments(1000, steps_for(2), frames=1000)
        self.run_ok("run", *words, "-o", self.folder / "alone.h5", "--quiet")
        process = self.serve("run", *words, "-o", self.result, "--quiet", "--live")
        after, seen = -1, []
        try:
            while process.poll() is None:
                frame = self.chunk(f"frame?after={after}")
                if frame:
                    after = frame.head["step"]
                    seen.append(frame)
                self.chunk("series?from=0")
                if self.status()["finished"]:
                    break
        except (OSError, http.client.HTTPException):
            pass  # it has ended
        process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 0)
        self.assertGreater(len(seen), 2)
        assert_same(self, self.folder / "alone.h5", self.result)
        with h5py.File(self.result) as file:
            position = file["particles/disks/position"]
            stored = dict(zip(position["step"][:], position["value"][:]))
        for frame in seen:
            if frame.head["step"] in stored:
                numpy.testing.assert_allclose(frame["x"], stored[frame.head["step"]][:, 0], rtol=6e-8, atol=1e-30)

    def test_stopped_run_goes_on_and_is_shown_again(self):
        process = self.serve("run", *ENDLESS, "-o", self.result, "--quiet", "--live")
        self.frame()
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 75)
        process = self.serve("resume", self.result, "--quiet", "--live")
        first = self.frame()
        self.assertGreaterEqual(first.head["step"], self.checkpoints()[-1])
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 75)

    def test_page_that_asks_is_told_of_the_stop(self):
        process = self.serve("view", *ENDLESS, "--live")
        self.frame()
        process.send_signal(signal.SIGINT)
        told = []
        wait_for(lambda: told.append(self.status()) or told[-1]["stopped"])
        process.communicate(timeout=LONG)
        self.assertEqual(process.returncode, 75)
        self.assertFalse(told[-1]["finished"])

    def test_nobody_asks(self):
        began = time.monotonic()
        self.serve("run", *deck_arguments(1000, 2000), "-o", self.result, "--quiet", "--live").communicate(timeout=LONG)
        self.assertEqual(self.process.returncode, 0)
        self.assertTrue(self.result.exists())
        self.assertLess(time.monotonic() - began, LONG)


class Safety(Live):
    def setUp(self):
        super().setUp()
        self.serve("view", *ENDLESS, "--live")

    def test_only_this_machine_can_connect(self):
        with open(f"/proc/{self.process.pid}/net/tcp", encoding="ascii") as table:
            here = [row.split()[1] for row in table if row.split()[3] == "0A" and row.split()[1].endswith(f":{self.port:04X}")]
        self.assertEqual(here, [f"0100007F:{self.port:04X}"])
        with open(f"/proc/{self.process.pid}/net/tcp6", encoding="ascii") as table:
            self.assertNotIn(f":{self.port:04X} ", " ".join(row.split()[1] + " " for row in table))
        for address in "127.0.0.2", socket.gethostbyname(socket.gethostname()):
            if address == "127.0.0.1":
                continue
            with self.assertRaises(OSError):
                socket.create_connection((address, self.port), timeout=5).close()

    def test_wrong_tokens(self):
        other = ("0" if self.token[0] != "0" else "1") + self.token[1:]
        for prefix in ("/", "", "/x", f"/{self.token}", f"/{self.token[:-1]}/", f"/{other}/", f"/{self.token}x/", f"//{self.token}/",
                       f"/{self.token.upper()}x/meta", f"/{self.token}/../meta", f"/{self.token}/no", f"/{self.token}/meta/",
                       f"/{self.token}/..%2f..%2fetc/passwd", f"/{'a' * 5000}/"):
            status, _, body = self.ask("", prefix=prefix)
            self.assertEqual((status, body), (404, b""), prefix)
        self.assertEqual(self.ask("meta")[0], 200)

    def test_other_hosts_and_methods(self):
        for host in "evil.example", f"evil.example:{self.port}", "127.0.0.1.evil.example", "localhost.evil.example", "", "[::1]", "0.0.0.0":
            self.assertIn(self.ask("meta", host=host)[0], (400, 403), host)
        for host in "127.0.0.1:8080", "localhost", "localhost:1234":  # the other end of a tunnel
            self.assertEqual(self.ask("meta", host=host)[0], 200, host)
        for method in "POST", "PUT", "DELETE", "OPTIONS", "HEAD":
            status, headers, _ = self.ask("meta", method=method, headers=[("Content-Length", "0"), ("Origin", "http://evil.example")])
            self.assertEqual(status, 405, method)
            self.assertNotIn("Access-Control-Allow-Origin", headers)

    def test_headers_that_say_two_things(self):
        """Where it is not clear for whom a request is, or where it ends: 400, and the connection ends."""
        own, get = f"127.0.0.1:{self.port}", f"GET /{self.token}/status HTTP/1.1"
        for status, *lines in ((200, f"Host: {own}"), (200, "hOST: LocalHost"), (200, "Host: 127.0.0.1:"), (200, f"Host: {own}", "Content-Length: 0"),
                               (403, "Host: evil:1"), (403, "Host:"), (403, "Host: [::1]:80"),
                               (400,), (400, f"Host: {own}", f"Host: {own}"), (400, f"Host: {own}", "Host: evil"),
                               (400, "Host: evil", f"Host: {own}"), (400, f"Host: {own}", f"hOST: {own}"), (400, "Host: 127.0.0.1:junk"),
                               (400, "Host: 127.0.0.1:1 evil"), (400, "Host: 127.0.0.1:1@evil"), (400, "Host: 127.0.0.1:1:1"),
                               (400, f"Host: {own}", "Content-Length: 0", "Content-Length: 5"),
                               (400, f"Host: {own}", "Content-Length: 0", "Content-Length: 0"), (400, f"Host: {own}", "Content-Length: -1"),
                               (400, f"Host: {own}", "Content-Length: 5", "Transfer-Encoding: chunked"),
                               (400, f"Host: {own}", "Transfer-Encoding: chunked", "Transfer-Encoding: chunked")):
            with socket.create_connection(("127.0.0.1", self.port), timeout=20) as connection:
                connection.sendall("\r\n".join((get, *lines, "", "")).encode())
                answer = connection.recv(1000)
                self.assertEqual(answer.split(b" ", 2)[1], str(status).encode(), lines)
                while status == 400 and answer:  # the end of the connection
                    answer = connection.recv(1000)

    def test_what_browsers_are_told(self):
        for name in "", "meta", "status", "static":
            _, headers, _ = self.ask(name, headers=[("Origin", "http://evil.example")])
            self.assertFalse([key for key in headers if key.lower().startswith("access-control")])
            self.assertEqual(headers["Cross-Origin-Resource-Policy"], "same-origin")
            self.assertEqual(headers["Referrer-Policy"], "no-referrer")
            self.assertEqual(headers["Cache-Control"], "no-store")
            self.assertIn("default-src 'none'", headers["Content-Security-Policy"])

    def test_nonsense_does_no_harm(self):
        for text in (b"\0\1\2\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"GET /" + b"a" * 100000 + b" HTTP/1.1\r\n\r\n"):
            with socket.create_connection(("127.0.0.1", self.port), timeout=20) as connection:
                try:
                    connection.sendall(text)
                    connection.shutdown(socket.SHUT_WR)
                    connection.recv(1000)
                except OSError:
                    pass
        for query in "frame?after=x", "frame?after=99999999999999999999", "frame?after=", "series?from=-5", "series?from=1e3", "frame?&&=":
            self.assertIn(self.ask(query)[0], (200, 204))
        many = [socket.create_connection(("127.0.0.1", self.port), timeout=20) for _ in range(10)]
        self.assertEqual(self.ask("status")[0], 200)
        for connection in many:
            connection.close()
        self.assertIsNone(self.process.poll())

    def test_half_open_connections_do_not_keep_others_out(self):
        """200 that send half a request, or nothing, or trickle, from one address or several: who has the key is answered."""
        for half in (b"", b"GET / HTTP/1.1\r\nHost: loc", b"POST /x HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\n"):
            many, over = [], threading.Event()

            def trickle():
                while not over.wait(0.2):
                    for one in many:
                        try:
                            one.send(b"x")
                        except OSError:
                            pass

            for k in range(200):
                many.append(socket.create_connection(("127.0.0.1", self.port), timeout=20, source_address=(f"127.0.0.{1 + k % 3}", 0)))
                many[-1].sendall(half)
            sender = threading.Thread(target=trickle)
            sender.start()
            try:
                for _ in range(20):
                    self.assertEqual(self.ask("status")[0], 200)
            finally:
                over.set()
                sender.join()
                for one in many:
                    one.close()

    def test_another_server_has_another_token(self):
        first = self.token
        self.end()
        self.serve("view", *ENDLESS, "--live")
        self.assertNotEqual(first, self.token)


class NoPort(Folder):
    def test_run_that_cannot_be_shown_is_run(self):
        source, library = self.folder / "bind.c", self.folder / "bind.so"
        source.write_text("#include <errno.h>\nint bind(int a, const void *b, unsigned c);\n"
                          "int bind(int a, const void *b, unsigned c) { (void)a, (void)b, (void)c; errno = EACCES; return -1; }\n")
        subprocess.run([os.environ.get("CC", "cc"), "-shared", "-fPIC", "-o", library, source], check=True)
        options = os.environ.get("ASAN_OPTIONS", "") + ":verify_asan_link_order=0"
        environment = os.environ | {"LD_PRELOAD": str(library), "ASAN_OPTIONS": options}
        status, _, err = run("run", *deck_arguments(1000, 2000), "-o", self.result, "--quiet", "--live", env=environment)
        self.assertEqual(status, 0, err)
        self.assertIn("warning: --live: no port of 127.0.0.1 can be had: Permission denied; the run goes on without", err)
        self.assertTrue(self.result.exists())
        status, _, err = run("view", *ENDLESS, "--live", env=environment)
        self.assertEqual(status, 4, err)


if __name__ == "__main__":
    unittest.main()
