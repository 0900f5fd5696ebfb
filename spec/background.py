"""A slow, plain decoder of backgrounds, written from clauses 8.2, 8.3, 8.6 and 18 of spec/fvv.md alone.

Knows meshes in the raw profile. Uses nothing of libfvv, so that prose and library are held against each other.

    python3 spec/background.py STREAM.fvv     # what each BACK chunk says, a line for each thing
"""

import math
import pathlib
import struct
import sys
import zlib

LIGHTS = ("directional", "point", "spot")
CODECS = ("jpeg", "png")
NO_PICTURE = 2**32 - 1


class Broken(ValueError):
    """The number of the rule that is broken, and a sentence."""


def demand(condition, issue, text):
    if not condition:
        raise Broken(f"FVV-{issue}: {text}")


def chunks(stream):
    """Type, flags, track, time and payload of all chunks, in order; the container is taken to be in order."""
    at = 24
    while at < len(stream):
        flags, _, track, time, size = struct.unpack_from("<BBHqQ", stream, at + 4)
        yield stream[at : at + 4], flags, track, time, stream[at + 32 : at + 32 + size]
        at += 32 + (size + 7) // 8 * 8


def raw_mesh(payload, origin, step):
    """Positions in metres, texture coordinates (or none) and faces of a raw MESH payload."""
    profile, attributes, bits, _, vertices, faces, reserved = struct.unpack_from("<4B3I", payload)
    demand(profile in (0, 1, 4), 8005, f"mesh of profile {profile} does not stand alone")
    if profile != 0:
        raise NotImplementedError("only raw meshes are decoded here")
    textured = attributes & 1
    demand(reserved == 0, 3001, "reserved field")
    demand(len(payload) == 16 + 12 * vertices + 12 * faces + 8 * vertices * textured, 3004, "size")
    numbers = struct.unpack_from(f"<{3 * vertices}i", payload, 16)
    positions = [
        tuple(o + step * i for o, i in zip(origin, numbers[v : v + 3])) for v in range(0, 3 * vertices, 3)
    ]
    at = 16 + 12 * vertices
    texture = None
    if textured:
        indices = struct.unpack_from(f"<{2 * vertices}I", payload, at)
        texture = [(u * 2.0**-bits, v * 2.0**-bits) for u, v in zip(indices[::2], indices[1::2])]
        at += 8 * vertices
    corners = struct.unpack_from(f"<{3 * faces}I", payload, at)
    return positions, texture, [corners[f : f + 3] for f in range(0, 3 * faces, 3)]


def picture_size(codec, file):
    """Width and height that a PNG or JPEG file tells."""
    if codec == 1:
        demand(file[:8] == b"\x89PNG\r\n\x1a\n" and file[12:16] == b"IHDR", 8006, "no PNG")
        demand(file[-12:-4] == b"\0\0\0\0IEND", 8006, "PNG without IEND")
        return struct.unpack_from(">II", file, 16)
    demand(file[:2] == b"\xff\xd8" and file[-2:] == b"\xff\xd9", 8006, "no JPEG")
    at = 2
    while file[at + 1] not in (0xC0, 0xC1, 0xC2):
        at += 2 + struct.unpack_from(">H", file, at + 2)[0]
    height, width = struct.unpack_from(">HH", file, at + 5)
    return width, height


def part_lines(entry, mesh, pictures, origin, step):
    _, picture, *colour, flags, reserved, u, v, width, height = struct.unpack("<II3H2B4d", entry)
    demand(flags < 8 and reserved == 0, 8001, "flags of a part")
    demand(picture == NO_PICTURE or picture < pictures, 8005, f"picture {picture} of {pictures}")
    demand(
        all(map(math.isfinite, (u, v))) and 0 < width < math.inf and 0 < height < math.inf, 8005, "texture"
    )
    positions, texture, faces = raw_mesh(mesh, origin, step)
    demand(picture == NO_PICTURE or texture, 8005, "a picture and no texture coordinates")
    shown = "none" if picture == NO_PICTURE else picture
    yield f"part picture {shown} colour {colour} flags {flags}"
    for i, p in enumerate(positions):
        place = f" shows {u + width * texture[i][0]!r} {v + height * texture[i][1]!r}" if texture else ""
        yield f"vertex {p[0]!r} {p[1]!r} {p[2]!r}{place}"
    for f in faces:
        yield f"face {f[0]} {f[1]} {f[2]}"


def light_line(entry):
    kind, flags, reserved, *values = struct.unpack("<2B6s13d", entry)
    demand(flags < 2 and not any(reserved), 8001, "flags of a light")
    demand(kind < 3, 8008, f"light of type {kind}")
    position, direction, colour = values[:3], values[3:6], values[6:9]
    intensity, reach, inner, outer = values[9:]
    demand(all(map(math.isfinite, values)) and min(intensity, reach) >= 0, 8008, "a light's numbers")
    demand(all(0 <= c <= 1 for c in colour), 8008, "colour of a light")
    demand(kind != 0 or not (any(position) or reach), 8008, "a directional light has no place")
    length = math.hypot(*direction)
    demand(length == 0 if kind == 1 else abs(length - 1) <= 1e-4, 8008, "direction of a light")
    demand(0 <= inner < outer <= math.pi / 2 if kind == 2 else inner == outer == 0, 8008, "cone of a light")
    return (
        f"light {LIGHTS[kind]} shadows {flags} position {position} direction {direction} colour {colour} "
        f"intensity {intensity!r} range {reach!r} cone {inner!r} {outer!r}"
    )


def lines(payload):
    """What a BACK payload says."""
    demand(len(payload) >= 48, 8001, "header")
    *origin, step, parts, pictures, lights, reserved = struct.unpack_from("<4d4I", payload)
    demand(reserved == 0 and parts + lights > 0, 8001, "header")
    demand(step > 0 and all(math.isfinite(abs(o) + step * 2**28) for o in origin), 8002, "lattice")
    picture_table = 48 + 48 * parts
    light_table = picture_table + 16 * pictures
    at = light_table + 112 * lights
    demand(at <= len(payload), 8001, "tables")
    yield f"lattice {origin} step {step!r}"
    for i in range(parts):
        entry = payload[48 + 48 * i : 96 + 48 * i]
        size = struct.unpack_from("<I", entry)[0]
        demand(0 < size <= len(payload) - at, 8001, "size of a mesh")
        yield from part_lines(entry, payload[at : at + size], pictures, origin, step)
        at += size
    for i in range(pictures):
        codec, reserved, width, height, size = struct.unpack_from("<B3sIII", payload, picture_table + 16 * i)
        demand(not any(reserved) and 0 < size <= len(payload) - at, 8001, "picture")
        demand(codec < 2, 8007, f"codec {codec}")
        file = payload[at : at + size]
        demand(picture_size(codec, file) == (width, height), 8006, "size of a picture")
        yield f"picture {CODECS[codec]} {width} x {height} of {size} bytes, CRC-32 {zlib.crc32(file):08x}"
        at += size
    demand(at == len(payload), 8001, "bytes behind the last picture")
    for i in range(lights):
        yield light_line(payload[light_table + 112 * i : light_table + 112 * (i + 1)])


def decode(stream):
    """What each BACK chunk says, as lines; that a track says one thing under one configuration is checked."""
    said, digest = {}, None
    for kind, flags, track, time, payload in chunks(stream):
        if kind == b"GRUP":
            digest = struct.unpack_from("<I", payload, 4)[0]
        if kind != b"BACK":
            continue
        demand(flags & 2, 8003, "no key flag")
        demand(said.setdefault((digest, track), payload) == payload, 8004, "another background than before")
        yield f"track {track} time {time}"
        yield from lines(payload)


if __name__ == "__main__":
    for line in decode(pathlib.Path(sys.argv[1]).read_bytes()):
        print(line)
