"""Video samples in OpenEXR: clause 10.12 of spec/fvv.md, and OpenEXR's file layout.

Has the compressions none, ZIPS and ZIP (zlib over bytes that were split into two halves and made differences); PIZ
is left to OpenEXR.
"""

import struct
import zlib

from .container import Part, Stream, crc32c, payloads, structure

NONE, ZIPS, ZIP = 0, 2, 3
LINES = {NONE: 1, ZIPS: 1, ZIP: 16, 4: 32}
MAGIC, VERSION = bytes([0x76, 0x2F, 0x31, 0x01]), 2
HALF, FLOAT = 1, 2


def attribute(name, kind, value):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def channel(name, kind=HALF, sampling=1):
    return name.encode() + b"\0" + struct.pack("<iB3xii", kind, 0, sampling, sampling)


def header(width, height, compression, **changed):
    """Attributes of a sample. changed: other values by name, None to leave an attribute out."""
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    values = {
        "channels": ("chlist", b"".join(map(channel, "BGR")) + b"\0"),
        "compression": ("compression", bytes([compression])),
        "dataWindow": ("box2i", window),
        "displayWindow": ("box2i", window),
        "lineOrder": ("lineOrder", b"\0"),
        "pixelAspectRatio": ("float", struct.pack("<f", 1)),
        "screenWindowCenter": ("v2f", struct.pack("<2f", 0, 0)),
        "screenWindowWidth": ("float", struct.pack("<f", 1)),
    }
    for name, value in changed.items():
        values[name] = value if value is None or isinstance(value, tuple) else (values[name][0], value)
    return b"".join(attribute(name, *value) for name, value in values.items() if value) + b"\0"


def packed(raw):
    """ZIP: even bytes before odd ones, each byte minus the one before plus 128, and zlib; raw when no smaller."""
    split = raw[0::2] + raw[1::2]
    differences = split[:1] + bytes((b - a + 128) & 255 for a, b in zip(split, split[1:]))
    data = zlib.compress(differences)
    return data if len(data) < len(raw) else raw


def unpacked(data, size):
    if len(data) == size:
        return data
    differences = zlib.decompress(data)
    if len(differences) != size:
        raise ValueError(f"a block has {len(differences)} bytes, expected {size}")
    split = bytearray(differences[:1])
    for difference in differences[1:]:
        split.append((split[-1] + difference - 128) & 255)
    raw = bytearray(size)
    raw[0::2], raw[1::2] = split[: (size + 1) // 2], split[(size + 1) // 2 :]
    return bytes(raw)


def assembled(attributes, blocks):
    """A file of attributes and blocks, with the table of the blocks' offsets."""
    head = MAGIC + struct.pack("<i", VERSION) + attributes
    table, offset = b"", len(head) + 8 * len(blocks)
    for block in blocks:
        table += struct.pack("<Q", offset)
        offset += len(block)
    return head + table + b"".join(blocks)


def write(width, height, pixels, compression=NONE, **changed):
    """A sample. pixels: height rows of width (R, G, B); changed: as of header."""
    blocks = []
    for first in range(0, height, LINES[compression]):
        raw = b"".join(
            struct.pack(f"<{width}e", *(pixel[c] for pixel in row))
            for row in pixels[first : first + LINES[compression]]
            for c in (2, 1, 0)
        )
        data = raw if compression == NONE else packed(raw)
        blocks.append(struct.pack("<2i", first, len(data)) + data)
    return assembled(header(width, height, compression, **changed), blocks)


def read(sample):
    """The half floats of a sample as bytes, R G B of each pixel, rows from the top."""
    if sample[:8] != MAGIC + struct.pack("<i", VERSION):
        raise ValueError("no OpenEXR file of one part with scan lines")
    at, found = 8, {}
    while sample[at]:
        end = sample.index(b"\0", at)
        name, at = sample[at:end].decode(), end + 1
        at = sample.index(b"\0", at) + 1
        (size,) = struct.unpack_from("<i", sample, at)
        found[name], at = sample[at + 4 : at + 4 + size], at + 4 + size
    _, _, right, bottom = struct.unpack("<4i", found["dataWindow"])
    width, height, compression = right + 1, bottom + 1, found["compression"][0]
    lines, at = LINES[compression], at + 1
    out = []
    for index, first in enumerate(range(0, height, lines)):
        (offset,) = struct.unpack_from("<Q", sample, at + 8 * index)
        y, size = struct.unpack_from("<2i", sample, offset)
        if y != first:
            raise ValueError(f"block {index} begins with line {y}, expected {first}")
        rows = min(lines, height - first)
        raw = unpacked(sample[offset + 8 : offset + 8 + size], rows * width * 6)
        for row in range(rows):
            line = raw[row * width * 6 : (row + 1) * width * 6]
            planes = [line[c * width * 2 : (c + 1) * width * 2] for c in (2, 1, 0)]
            out += [plane[2 * x : 2 * x + 2] for x in range(width) for plane in planes]
    return b"".join(out)


def listing(stream):
    """CRC-32C of the half floats of each sample, R G B of each pixel, rows from the top."""
    for sample in payloads(stream, b"VPKT"):
        yield f"{crc32c(read(sample)):08x}"


def bars(width, height, frame):
    """Light from below black to the largest half, 65504, with the smallest steps."""
    special = [0.0, -0.0, 2.0**-24, -(2.0**-24), 2.0**-14, 1.0, -0.25, 65504.0, -65504.0, 1 + 2.0**-10]
    rows = []
    for y in range(height):
        row = []
        for x in range(width):
            value = 2.0 ** ((x - y + 2 * frame) % 19 - 12)
            row.append((value, special[(x + y * width + frame) % len(special)], 0.18 + x / 8))
        rows.append(row)
    return rows


def bars_stream():
    """The stream of conformance/openexr: one camera of 22 x 21 pixels, one group of three frames: none, ZIPS, ZIP."""
    width, height = 22, 21
    stream = Stream()
    stream.scene()
    stream.track(1, 2, "hdr")
    camera = {"width": width, "height": height, "fx": 20.0, "fy": 20.0, "cx": 11.0, "cy": 10.5}
    camera |= {
        "rotation": (1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0),
        "translation": (0, 0, 2.0),
        "r_max": float("inf"),
    }
    stream.chunk("CAMR", structure("CAMR payload", {"id": 3, **camera}))
    video = {"codec": b"oexr", "width": width, "height": height, "shows": 0, "bit_depth": 16}
    video |= {"colour_primaries": 1, "transfer_characteristics": 8, "matrix_coefficients": 0, "full_range": 1}
    stream.chunk("VCFG", structure("VCFG payload", video), track=1)
    whole = (0, 0, width, height)
    tile = structure("TILE entry", {"camera": 3, "source": whole, "destination": whole})
    stream.chunk("TILE", structure("TILE payload", {"count": 1}) + tile, track=1)
    stream.begin_group(0, 3)
    for frame, compression in enumerate((NONE, ZIPS, ZIP)):
        sample = write(width, height, bars(width, height, frame), compression)
        stream.chunk("VPKT", [Part(sample, "sample", "OpenEXR")], track=1, time=frame, key=True)
    stream.end_group()
    return stream.finish()
