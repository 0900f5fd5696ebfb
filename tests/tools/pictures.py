"""Pictures in OpenEXR with channels of any name, which tests read and write."""

import struct
import zlib

import numpy as np
from reference import openexr


def write_exr(path, channels):
    """An uncompressed file of {name: array of float16 or float32}."""
    height, width = next(iter(channels.values())).shape
    names = sorted(channels)
    kinds = {np.float16: openexr.HALF, np.float32: openexr.FLOAT}
    entries = b"".join(openexr.channel(n, kinds[channels[n].dtype.type]) for n in names) + b"\0"
    blocks = []
    for y in range(height):
        line = b"".join(channels[n][y].tobytes() for n in names)
        blocks.append(struct.pack("<2i", y, len(line)) + line)
    path.write_bytes(openexr.assembled(openexr.header(width, height, openexr.NONE, channels=entries), blocks))


def read_exr(path):
    """Channels of a file with scan lines of float32 in blocks of 16 lines, ZIP, by the layout that OpenEXR documents."""
    data = path.read_bytes()
    assert data[:8] == struct.pack("<2I", 20000630, 2)
    at, attributes = 8, {}
    while data[at]:
        name, kind, rest = data[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 2
        (size,) = struct.unpack_from("<I", data, at)
        attributes[name.decode()] = data[at + 4 : at + 4 + size]
        at += 4 + size
    assert attributes["compression"] == b"\3"
    left, top, right, bottom = struct.unpack("<4i", attributes["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    names, rest = [], attributes["channels"]
    while rest[0]:
        name, rest = rest.split(b"\0", 1)
        assert struct.unpack_from("<I", rest) == (2,)  # float
        names.append(name.decode())
        rest = rest[16:]
    rows = np.zeros((height, len(names), width), np.float32)
    blocks = (height + 15) // 16
    for offset in struct.unpack_from(f"<{blocks}Q", data, at + 1):
        y, size = struct.unpack_from("<2i", data, offset)
        lines = min(16, height - y)
        packed = data[offset + 8 : offset + 8 + size]
        if size < lines * len(names) * width * 4:
            bytes_ = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
            bytes_[1:] -= 128
            bytes_ = (np.cumsum(bytes_) & 255).astype(np.uint8)
            half = (len(bytes_) + 1) // 2
            packed = np.zeros_like(bytes_)
            packed[0::2], packed[1::2] = bytes_[:half], bytes_[half:]
            packed = packed.tobytes()
        rows[y : y + lines] = np.frombuffer(packed, "<f4").reshape(lines, len(names), width)
    return {name: rows[:, i] for i, name in enumerate(names)}
