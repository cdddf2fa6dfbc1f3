#!/usr/bin/env python3
"""Makes the pages ratchet.html and packing.html, each one file that opens without a network.

    python3 tools/play/bundle.py build/play    takes slipdisk.mjs and slipdisk.wasm there

Both have the frame frame.html, into which each puts its own parts. Style sheets, scripts and texts
that it names are put in as they are: those of this folder, of the viewer (src/app/view/page) and of
the folder of the engine. The module and the worker become one text, which the page starts as a
worker; the bytes of the engine follow, compressed.
"""
import base64
import gzip
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
VIEWER = HERE.parents[1] / "src/app/view/page"
PAGES = "ratchet.html", "packing.html"
LIMIT = 2_000_000  # bytes of a page
STYLE = re.compile(r'<link rel="stylesheet" href="([^"]+)">')
SCRIPT = re.compile(r'<script src="([^"]+)"></script>')
PART = re.compile(r"^<!-- (\w+) -->\n", re.M)
PUT = re.compile(r"^<!-- put: (\w+) -->\n", re.M)
TEXT = re.compile(r'<(script|pre)([^>]*) data-from="([^"]+)"></\1>')


def read(name, folder):
    """The bytes of a file of the folder of the engine, of this one, or of the viewer."""
    for place in folder, HERE, VIEWER:
        if (place / name).is_file():
            return (place / name).read_bytes()
    raise SystemExit(f"bundle.py: {name} is missing: tools/play.sh builds the engine")


def script(text):
    """A script that cannot end its element too early."""
    return re.sub(r"</(?=script)", r"<\\/", text, flags=re.I)


def text_of(names, folder):
    """Texts one after the other; WebAssembly as base64 of gzip, which the module unpacks."""
    if names.endswith(".wasm"):
        return base64.b64encode(gzip.compress(read(names, folder), mtime=0)).decode()
    return "\n".join(plain(read(name, folder).decode()) for name in names.split())


def plain(text):
    """A module as a plain script: a page that is a file can start no worker of modules."""
    text = re.sub(r"^export (?=(async |function|class|const))", "", text, flags=re.M)
    return text.replace("import.meta.url", "location.href")


def framed(page):
    """The frame of both pages, with the parts of this one; a line before each part has its name."""
    words = PART.split((HERE / page).read_text())
    parts = dict(zip(words[1::2], words[2::2]))
    return PUT.sub(lambda m: parts.pop(m[1]), (HERE / "frame.html").read_text())


def bundle(page, folder):
    """The page with all that it names."""
    text = framed(page)
    text = STYLE.sub(lambda m: f"<style>\n{read(m[1], folder).decode()}</style>", text)
    text = SCRIPT.sub(lambda m: f"<script>\n{script(read(m[1], folder).decode())}</script>", text)

    def put(m):
        inside = text_of(m[3], folder)
        return f"<{m[1]}{m[2]}>{script(inside) if m[1] == 'script' else inside}</{m[1]}>"

    return TEXT.sub(put, text)


def main():
    if len(sys.argv) != 2 or sys.argv[1] in ("-h", "--help"):
        raise SystemExit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    for page in PAGES:
        data = bundle(page, folder).encode()
        if len(data) > LIMIT:
            raise SystemExit(f"bundle.py: {page} has {len(data)} bytes, more than {LIMIT}")
        (folder / page).write_bytes(data)
        print(f"page    {folder / page} ({len(data) / 1e3:.0f} kB)")


if __name__ == "__main__":
    main()
