"""Static environments and lights: clause 18 of spec/fvv.md."""

import math
import struct

import numpy

from ..container import demand
from . import meshes
from .configuration import lattice_is_valid
from .samples import jpeg_size

NO_PICTURE = 2**32 - 1
MOST, SIDE = 1024, 16384
DIRECTIONAL, POINT, SPOT = range(3)


def png_size(file):
    demand(file[:8] == b"\x89PNG\r\n\x1a\n" and file[8:16] == b"\0\0\0\x0dIHDR", 8006, "no PNG")
    demand(len(file) >= 45 and file[-12:] == b"\0\0\0\0IEND\xae\x42\x60\x82", 8006, "PNG without IEND")
    return struct.unpack_from(">II", file, 16)


def picture_size(codec, file):
    return png_size(file) if codec else jpeg_size(file, 8006)


class Light:
    def __init__(self, entry):
        kind, _, _, *numbers = struct.unpack("<2B6s13d", entry)
        demand(kind <= SPOT, 8008, f"type {kind}")
        position, direction, colour = numbers[:3], numbers[3:6], numbers[6:9]
        intensity, reach, inner, outer = numbers[9:]
        demand(all(map(math.isfinite, numbers)), 8008, "a number that is not finite")
        demand(all(0 <= c <= 1 for c in colour), 8008, "colour")
        demand(intensity >= 0 and reach >= 0, 8008, "intensity or range")
        if kind == DIRECTIONAL:
            demand(not any(position) and not reach, 8008, "a directional light with a position or a range")
        if kind == POINT:
            demand(not any(direction), 8008, "a point light with a direction")
        else:
            demand(abs(math.sqrt(sum(x * x for x in direction)) - 1) <= 1e-4, 8008, "length of a direction")
        if kind == SPOT:
            demand(0 <= inner < outer <= math.pi / 2, 8008, "cones")
        else:
            demand(inner == 0 and outer == 0, 8008, "cones of a light that is no spot")
        self.numbers = numbers


class Environment:
    """A BACK payload. Counts and sizes come first, then each part, picture and light."""

    def __init__(self, payload):
        demand(len(payload) >= 48, 8001, "size")
        *self.origin, self.step, parts, pictures, lights, reserved = struct.unpack_from("<4d4I", payload)
        demand(reserved == 0, 8001, "reserved field")
        demand(max(parts, pictures, lights) <= MOST, 7001, "counts")
        demand(parts + lights > 0, 8001, "nothing")
        tables = 48 + 48 * parts, 48 + 48 * parts + 16 * pictures
        at = tables[1] + 112 * lights
        demand(at <= len(payload), 8001, "the tables are cut")
        self.entries = [payload[i : i + 48] for i in range(48, tables[0], 48)]
        self.files = [payload[i : i + 16] for i in range(tables[0], tables[1], 16)]
        sizes = [int.from_bytes(entry[:4], "little") for entry in self.entries]
        sizes += [int.from_bytes(entry[12:], "little") for entry in self.files]
        demand(all(sizes) and at + sum(sizes) <= len(payload), 8001, "sizes")
        for entry in self.entries:
            demand(entry[14] < 8 and entry[15] == 0, 8001, "flags or reserved byte of a part")
        for entry in self.files:
            demand(not any(entry[1:4]), 8001, "reserved bytes of a picture")
        lamps = [payload[i : i + 112] for i in range(tables[1], tables[1] + 112 * lights, 112)]
        for entry in lamps:
            demand(entry[1] < 2 and not any(entry[2:8]), 8001, "flags or reserved bytes of a light")
        bodies = []
        for size in sizes:
            bodies.append(payload[at : at + size])
            at += size
        demand(lattice_is_valid(self.origin, self.step), 8002, "lattice")
        self.pictures, self.vertices, self.faces = bodies[parts:], 0, 0
        headers = [self._part(entry, body) for entry, body in zip(self.entries, bodies)]
        self._pictures()
        self.lights = [Light(entry) for entry in lamps]
        self.parts = [
            (meshes.independent(header, body), place) for (header, place), body in zip(headers, bodies)
        ]

    def _pictures(self):
        pixels = 0
        for entry, file in zip(self.files, self.pictures):
            codec, width, height = entry[0], *struct.unpack_from("<II", entry, 4)
            demand(codec < 2, 8007, f"codec {codec}")
            demand(width > 0 and height > 0, 8006, "an empty picture")
            demand(picture_size(codec, file) == (width, height), 8006, "size of a picture")
            demand(max(width, height) <= SIDE, 7001, f"{width} x {height} pixels")
            pixels += width * height
            demand(pixels <= SIDE * SIDE, 7001, "pixels of all pictures")

    def _part(self, entry, body):
        picture = int.from_bytes(entry[4:8], "little")
        place = struct.unpack_from("<4d", entry, 16)
        demand(picture == NO_PICTURE or picture < len(self.pictures), 8005, f"picture {picture}")
        demand(all(map(math.isfinite, place)) and min(place[2:]) > 0, 8005, "origin or size of a texture")
        header = meshes.Header(body)
        meshes.check_size(header, body)
        demand(header.profile in meshes.INDEPENDENT, 8005, f"a mesh of profile {header.profile}")
        demand(picture == NO_PICTURE or header.attributes & meshes.TEXTURE, 8005, "no texture coordinates")
        self.vertices, self.faces = self.vertices + header.vertices, self.faces + header.faces
        fits = self.vertices <= meshes.VERTICES and self.faces <= meshes.FACES
        demand(fits, 7001, "too large meshes")
        return header, place

    def arrays(self):
        """Yields the name and bytes of each array of the report."""
        for i, (mesh, place) in enumerate(self.parts):
            yield f"part/{i}/positions", mesh.metres(self.origin, self.step).tobytes()
            yield f"part/{i}/faces", mesh.faces.astype("<u4").tobytes()
            if mesh.texture is not None:
                own = mesh.coordinates().astype(numpy.float64)
                shown = numpy.array(place[:2]) + numpy.array(place[2:]) * own
                yield f"part/{i}/uvs", shown.astype("<f4").tobytes()
        for i, file in enumerate(self.pictures):
            yield f"picture/{i}", file
        for i, light in enumerate(self.lights):
            yield f"light/{i}", struct.pack("<13d", *light.numbers)
