"""Static environments and lights: clause 18 of spec/fvv.md, with meshes in the raw profile."""

import math
import struct
import zlib

from .container import FLAGS, chunks, demand
from .mesh import read_raw

LIGHTS = ("directional", "point", "spot")
CODECS = ("jpeg", "png")
NO_PICTURE = 2**32 - 1


def read_mesh(payload, origin, step):
    """Positions in metres, texture coordinates (or none) and faces of a raw MESH payload."""
    demand(payload[0] in (0, 1, 4), 8005, f"mesh of profile {payload[0]}, which is no key mesh")
    if payload[0] != 0:
        raise NotImplementedError("only raw meshes are decoded here")
    mesh = read_raw(payload)
    positions = [tuple(o + step * i for o, i in zip(origin, point)) for point in mesh.positions]
    texture = [(u * 2.0**-mesh.texture_bits, v * 2.0**-mesh.texture_bits) for u, v in mesh.texture]
    return positions, texture or None, mesh.faces


def picture_size(codec, file):
    """Width and height according to a PNG or JPEG file."""
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
    positions, texture, faces = read_mesh(mesh, origin, step)
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
    """A line for each thing in a BACK payload."""
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
    demand(at == len(payload), 8001, "bytes after the last picture")
    for i in range(lights):
        yield light_line(payload[light_table + 112 * i : light_table + 112 * (i + 1)])


def listing(stream):
    """The lines of each BACK chunk. Checks that a track has one environment under one configuration."""
    first, digest = {}, None
    for kind, flags, track, time, payload in chunks(stream):
        if kind == b"GRUP":
            digest = struct.unpack_from("<I", payload, 4)[0]
        if kind != b"BACK":
            continue
        demand(flags & FLAGS["key"], 8003, "no key flag")
        demand(first.setdefault((digest, track), payload) == payload, 8004, "another environment than before")
        yield f"track {track} time {time}"
        yield from lines(payload)
