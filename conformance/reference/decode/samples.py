"""Video samples: FVV-4201 to 4206, clauses 10.4 to 10.12 of spec/fvv.md."""

import struct

from ..container import demand
from ..openexr import LINES, MAGIC
from .records import obus

UNEXPECTED = set(range(0xD0, 0xDB))  # JPEG markers that do not precede a frame header: RSTm, SOI, EOI, SOS
FRAME_HEADERS = set(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


def jpeg_size(data, issue):
    """Width and height of a JPEG file of 8 bits and 1 or 3 components."""
    demand(data[:2] == b"\xff\xd8" and data[-2:] == b"\xff\xd9", issue, "no SOI, or no EOI")
    at = 2
    while True:
        demand(at + 4 <= len(data) and data[at] == 0xFF, issue, "no marker before the frame header")
        marker = data[at + 1]
        if marker == 0xFF:
            at += 1
        else:
            demand(marker >= 0xC0, issue, f"marker {marker:02X}, which is reserved")
            demand(marker not in UNEXPECTED, issue, "no frame header before the first scan")
            size = int.from_bytes(data[at + 2 : at + 4], "big")
            demand(size >= 2 and at + 2 + size <= len(data), issue, "a segment is cut")
            if marker in FRAME_HEADERS:
                break
            at += 2 + size
    demand(size >= 8, issue, "the frame header is cut")
    bits, height, width, components = struct.unpack_from(">BHHB", data, at + 4)
    demand(size == 8 + 3 * components, issue, "size of the frame header")
    demand(bits == 8 and components in (1, 3), issue, f"{bits} bits, {components} components")
    return width, height


def jpeg(data, key, video):
    demand(key, 4201, "no key flag")
    demand(jpeg_size(data, 4201) == (video.width, video.height), 4201, "size of the picture")


def nal_units(data, issue):
    at = 0
    demand(data, issue, "no NAL unit")
    while at < len(data):
        demand(at + 4 <= len(data), issue, "a length is cut")
        size = int.from_bytes(data[at : at + 4], "big")
        at += 4
        demand(0 < size <= len(data) - at, issue, f"a NAL unit of {size} bytes")
        demand(data[at] < 128, issue, "the forbidden bit")
        yield data[at : at + size]
        at += size


def avc(data, key, video):
    kinds = [unit[0] & 31 for unit in nal_units(data, 4202)]
    demand((5 in kinds) == key, 4202, "IDR picture and key flag")


def hevc(data, key, video):
    pictures, random_access = 0, False
    for unit in nal_units(data, 4203):
        demand(len(unit) >= 2 and unit[1] & 7, 4203, "a NAL unit header")
        kind = unit[0] >> 1 & 63
        demand(not 6 <= kind <= 9, 4203, "a leading picture")
        if kind < 32:
            demand(len(unit) > 2, 4203, "an empty slice segment")
            pictures += unit[2] >> 7
        random_access |= 16 <= kind <= 23
    demand(pictures == 1, 4203, f"{pictures} pictures")
    demand(random_access == key, 4203, "IRAP picture and key flag")


def superframe(data):
    """The frames of a VP9 sample."""
    last = data[-1]
    count, width = (last & 7) + 1, (last >> 3 & 3) + 1
    size = 2 + count * width
    if last & 0xE0 != 0xC0 or size > len(data) or data[-size] != last:
        return [data]
    sizes = [int.from_bytes(data[len(data) - size + 1 + i * width :][:width], "little") for i in range(count)]
    demand(all(sizes) and sum(sizes) == len(data) - size, 4204, "the index of a superframe")
    frames, at = [], 0
    for n in sizes:
        frames.append(data[at : at + n])
        at += n
    return frames


def vp9_frame(data):
    """(key, shown) of a VP9 frame."""
    bits = int.from_bytes(data[:5].ljust(5, b"\0"), "big")
    demand(bits >> 38 == 2, 4204, "frame marker")
    at = 36
    if bits >> 36 & 3 == 3:
        at -= 1
        demand(not bits >> at & 1, 4204, "reserved bit")
    if bits >> at - 1 & 1:  # show_existing_frame
        return False, True
    key, shown = not bits >> at - 2 & 1, bool(bits >> at - 3 & 1)
    if key:
        demand((bits >> at - 28 & 0xFFFFFF) == 0x498342 and 8 * len(data) >= 40 - at + 28, 4204, "sync code")
    return key, shown


def vp9(data, key, video):
    demand(data, 4204, "no frame")
    frames = [vp9_frame(frame) for frame in superframe(data)]
    demand([shown for _, shown in frames] == [False] * (len(frames) - 1) + [True], 4204, "shown frames")
    demand(frames[0][0] == key, 4204, "key frame and key flag")


def av1(data, key, video):
    sequence, frames = (
        False,
        [],
    )  # whether a sequence header precedes; (key and shown, shown, after a sequence header)
    for kind, body in obus(data, 4205):
        demand(kind not in (2, 8), 4205, "a temporal delimiter or a tile list")
        if kind == 1:
            demand(body and not body[0] & 8, 4205, "sequence header")
            sequence = True
        elif kind in (3, 6):
            demand(body, 4205, "an empty frame header")
            existing, frame_type, shown = body[0] >> 7, body[0] >> 5 & 3, body[0] >> 4 & 1
            starts = not existing and frame_type == 0 and shown
            frames.append((bool(existing or shown), bool(starts and sequence)))
    demand(sum(shown for shown, _ in frames) == 1, 4205, "shown frames")
    demand(frames[0][1] == key, 4205, "key frame and key flag")


ATTRIBUTES = {
    b"channels": b"chlist",
    b"compression": b"compression",
    b"dataWindow": b"box2i",
    b"displayWindow": b"box2i",
    b"lineOrder": b"lineOrder",
    b"pixelAspectRatio": b"float",
    b"screenWindowCenter": b"v2f",
    b"screenWindowWidth": b"float",
}
SIZES = {b"box2i": 16, b"compression": 1, b"lineOrder": 1, b"float": 4, b"v2f": 8, b"int": 4}
CHANNELS = b"".join(name + struct.pack("<xiB3xii", 1, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"


def exr_text(data, at):
    end = data.find(b"\0", at, at + 32)
    demand(end > at, 4206, "a name of an attribute or of its type")
    return data[at:end], end + 1


def exr_header(data):
    """The attributes that clause 10.12 names, and the offset after the header."""
    at, found = 8, {}
    while True:
        demand(at < len(data), 4206, "the header is cut")
        if data[at] == 0:
            return found, at + 1
        name, at = exr_text(data, at)
        kind, at = exr_text(data, at)
        demand(at + 4 <= len(data), 4206, "the header is cut")
        (size,) = struct.unpack_from("<i", data, at)
        at += 4
        demand(0 <= size <= len(data) - at, 4206, "the size of an attribute")
        if name in ATTRIBUTES or name in (b"tiles", b"type", b"chunkCount"):
            demand(name not in found, 4206, f"{name} twice")
            demand(ATTRIBUTES.get(name, kind) == kind, 4206, f"{name} of type {kind}")
            demand(SIZES.get(kind, size) == size, 4206, f"{name} of {size} bytes")
            found[name] = kind, data[at : at + size]
        at += size


def oexr(data, key, video):
    demand(key, 4206, "no key flag")
    demand(data[:8] == MAGIC + struct.pack("<i", 2), 4206, "magic number or version")
    found, at = exr_header(data)
    demand(ATTRIBUTES.keys() <= found.keys() and b"tiles" not in found, 4206, "attributes")
    window = struct.pack("<4i", 0, 0, video.width - 1, video.height - 1)
    demand(found[b"dataWindow"][1] == found[b"displayWindow"][1] == window, 4206, "windows")
    channels = found[b"channels"][1]
    plain = bytearray(channels)
    for i in range(3):  # pLinear and its reserved bytes have no effect
        plain[18 * i + 6 : 18 * i + 10] = bytes(len(plain[18 * i + 6 : 18 * i + 10]))
    demand(bytes(plain) == CHANNELS, 4206, "channels")
    demand(found[b"lineOrder"][1] == b"\0", 4206, "line order")
    compression = found[b"compression"][1][0]
    demand(compression in LINES, 4206, f"compression {compression}")
    lines = LINES[compression]
    blocks = -(-video.height // lines)
    kind, value = found.get(b"type", (b"string", b"scanlineimage"))
    demand(kind == b"string" and value == b"scanlineimage", 4206, "type")
    kind, value = found.get(b"chunkCount", (b"int", struct.pack("<i", blocks)))
    demand(kind == b"int" and value == struct.pack("<i", blocks), 4206, "chunkCount")
    demand(at + 8 * blocks <= len(data), 4206, "the offset table is cut")
    expected = at + 8 * blocks
    for block in range(blocks):
        (offset,) = struct.unpack_from("<Q", data, at + 8 * block)
        demand(offset == expected and offset + 8 <= len(data), 4206, f"offset of block {block}")
        y, size = struct.unpack_from("<2i", data, offset)
        most = 6 * video.width * min(lines, video.height - y)
        demand(y == block * lines and 0 < size <= most, 4206, f"block {block}")
        demand(compression or size == most, 4206, f"size of block {block}")
        expected += 8 + size
    demand(expected == len(data), 4206, "bytes after the last block")


SAMPLES = {b"jpeg": jpeg, b"avc1": avc, b"hvc1": hevc, b"vp09": vp9, b"av01": av1, b"oexr": oexr}


def check_sample(data, key, video):
    SAMPLES[video.codec](data, key, video)
