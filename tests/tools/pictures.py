"""Pictures that tests read and write: OpenEXR with channels of any name, and PNG."""

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


def write_png(path, image):
    """RGB (or grey, of two axes) of 8 bits."""
    height, width = image.shape[:2]
    rows = np.concatenate([np.zeros((height, 1), np.uint8), image.reshape(height, -1)], axis=1)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">2I5B", width, height, 8, 2 if image.ndim == 3 else 0, 0, 0, 0)
    parts = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + parts)


def read_png(path):
    """Of 8 bits, not interlaced, by the filters of the PNG specification (clause 9)."""
    data, at, packed = path.read_bytes(), 8, b""
    while at < len(data):
        (size,), kind = struct.unpack_from(">I", data, at), data[at + 4 : at + 8]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack_from(">2I2B", data, at + 8)
        if kind == b"IDAT":
            packed += data[at + 8 : at + 8 + size]
        at += 12 + size
    assert depth == 8 and colour in (0, 2)
    channels = 3 if colour == 2 else 1
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + width * channels).astype(int)
    out = np.zeros((height + 1, width + 1, channels), int)
    for y in range(height):
        values = rows[y, 1:].reshape(width, channels)
        for x in range(width):
            left, above, corner = out[y + 1, x], out[y, x + 1], out[y, x]
            near = left + above - corner
            nearest = np.where(
                (abs(near - left) <= abs(near - above)) & (abs(near - left) <= abs(near - corner)),
                left,
                np.where(abs(near - above) <= abs(near - corner), above, corner),
            )
            added = (0, left, above, (left + above) // 2, nearest)[rows[y, 0]]
            out[y + 1, x + 1] = (values[x] + added) & 255
    return out[1:, 1:].astype(np.uint8)
