"""The viewer's page and its chunks, read as docs/view.md describes them."""
import base64
import json
import pathlib
import re
import struct
import zlib

import numpy

TYPES = {"f64": "<f8", "f32": "<f4", "i32": "<i4", "u32": "<u4", "i16": "<i2", "u16": "<u2", "i8": "i1", "u8": "u1"}


class Chunk:
    def __init__(self, stream):
        data = zlib.decompress(stream)
        length, = struct.unpack("<I", data[:4])
        assert (4 + length) % 8 == 0
        self.head = json.loads(data[4:4 + length])
        self.columns, self.quanta = {}, {}
        for c in self.head["columns"]:
            kind, n, at = numpy.dtype(TYPES[c["type"]]), c["count"], 4 + length + c["offset"]
            assert c["offset"] % 8 == 0 and at + n * kind.itemsize <= len(data)
            stored = data[at:at + n * kind.itemsize]
            if c["shuffle"]:
                stored = numpy.frombuffer(stored, "u1").reshape(kind.itemsize, n).T.tobytes()
            stored = numpy.frombuffer(stored, kind)
            self.columns[c["name"]] = c["zero"] + c["scale"] * stored.astype(float) if c["scale"] != 1 or c["zero"] else stored
            self.quanta[c["name"]] = c["scale"] if kind.kind != "f" else 0

    def __getitem__(self, name):
        return self.columns[name]

    def __contains__(self, name):
        return name in self.columns


class Page:
    def __init__(self, path):
        text = pathlib.Path(path).read_text(encoding="utf-8")
        meta = re.findall(r'<script type="application/json" id="slipdisk-meta">(.*?)</script>', text, re.DOTALL)
        assert len(meta) == 1
        self.text, self.meta = text, json.loads(meta[0])
        self.frames, self.static, self.series, self.marks = [], None, None, []
        for name, more, data in re.findall(
                r'<script type="text/plain" class="slipdisk-chunk" data-name="(\w+)"([^>]*)>([^<]*)</script>', text):
            chunk = Chunk(base64.b64decode(data, validate=True))
            if name == "frame":
                self.frames.append(chunk)
                self.marks.append({key: float(value) for key, value in re.findall(r'data-(\w+)="([^"]*)"', more)})
            else:
                assert getattr(self, name) is None
                setattr(self, name, chunk)
