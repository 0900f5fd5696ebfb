"""Shapes, and MESH payloads in the raw and fast profiles: clauses 8.3 and 8.11 of spec/fvv.md."""

import math
import struct
from typing import NamedTuple

from reference.container import uleb128, zigzag

from .packing import pack

TEXTURE, NORMALS = 1, 2
RAW, DRACO, DELTA, FAST = 0, 1, 2, 4


class Shape(NamedTuple):
    """positions: lattice points; faces: triples of vertices; texture, normals: two indices of each vertex, or nothing."""

    positions: list
    faces: list
    texture: list = ()
    texture_bits: int = 0
    normals: list = ()
    normal_bits: int = 0

    def header(self, profile, **fields):
        values = {"profile": profile, "vertex_count": len(self.positions), "face_count": len(self.faces)}
        values["attributes"] = (TEXTURE if self.texture else 0) | (NORMALS if self.normals else 0)
        values |= {"texture_bits": self.texture_bits, "normal_bits": self.normal_bits}
        return pack("MESH payload", **values | fields)

    def moved(self, x=0, y=0, z=0):
        return self._replace(positions=[(a + x, b + y, c + z) for a, b, c in self.positions])


TETRAHEDRON = Shape(
    [(100, 100, 100), (100, -100, -100), (-100, 100, -100), (-100, -100, 100)],
    [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)],
)
OCTAHEDRON = Shape(
    [(90, 0, 0), (-90, 0, 0), (0, 90, 0), (0, -90, 0), (0, 0, 90), (0, 0, -90)],
    [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)],
)
TRIANGLE = Shape([(0, 0, 0), (50, 0, 0), (0, 50, 0)], [(0, 1, 2)])


MOST = 1 << 28  # of a lattice index
FAR = Shape(
    [(MOST, MOST, MOST), (-MOST, -MOST, MOST), (MOST, -MOST, -MOST), (-MOST, MOST, -MOST)], TETRAHEDRON.faces
)
BEYOND = FAR._replace(positions=[(MOST + 1, 0, 0), *FAR.positions[1:]])
CORNER = TETRAHEDRON._replace(
    positions=[(x + MOST - 100, y + MOST - 100, z + MOST - 100) for x, y, z in TETRAHEDRON.positions]
)
BEYOND_CORNER = CORNER._replace(positions=[(x + 1, y, z) for x, y, z in CORNER.positions])


def ball(rings, sectors, radius=500):
    """A sphere: two poles and rings of vertices between them."""
    positions = [(0, 0, radius)]
    for ring in range(1, rings):
        polar = math.pi * ring / rings
        for sector in range(sectors):
            angle = 2 * math.pi * sector / sectors
            x, y = (radius * math.sin(polar) * f(angle) for f in (math.cos, math.sin))
            positions.append((round(x), round(y), round(radius * math.cos(polar))))
    positions.append((0, 0, -radius))
    last, faces = len(positions) - 1, []
    for sector in range(sectors):
        after = (sector + 1) % sectors
        faces.append((0, 1 + sector, 1 + after))
        for ring in range(rings - 2):
            a, b = 1 + sectors * ring + sector, 1 + sectors * ring + after
            faces += [(a, a + sectors, b), (b, a + sectors, b + sectors)]
        below = last - sectors
        faces.append((last, below + after, below + sector))
    return Shape(positions, faces)


def holed_hubs(sectors):
    """Poles of many faces, and two rings with holes between them: a decoder of edgebreaker renumbers the poles again and
    again."""
    positions, last = ball(3, sectors, 30 * sectors).positions, 1 + 2 * sectors
    faces = []
    for i in range(sectors):
        after = (i + 1) % sectors
        a, b, c, d = 1 + i, 1 + after, 1 + sectors + i, 1 + sectors + after
        quad = [(0, a, b), (last, d, c), (a, c, d), (a, d, b)]
        faces += [face for k, face in enumerate(quad) if k < 2 or (4 * i + k) % 5]
    return Shape(positions, faces)


def grid(columns, rows, size=10):
    """A bumpy sheet of columns x rows vertices."""
    positions = [
        (size * x + y % 2, size * y + x % 3, (x * y * 7 + x) % 5) for y in range(rows) for x in range(columns)
    ]
    faces = []
    for y in range(rows - 1):
        for x in range(columns - 1):
            a = columns * y + x
            faces += [(a, a + 1, a + columns), (a + 1, a + columns + 1, a + columns)]
    return Shape(positions, faces)


def torus(segments, sides, radius=400):
    """A ring, which has a handle."""
    positions, faces = [], []
    for i in range(segments):
        for k in range(sides):
            around, angle = 2 * math.pi * i / segments, 2 * math.pi * k / sides
            out = radius * (3 + math.cos(angle))
            positions.append(
                tuple(map(round, (out * math.cos(around), out * math.sin(around), radius * math.sin(angle))))
            )
            a, b = i * sides + k, i * sides + (k + 1) % sides
            c, d = ((corner + sides) % (segments * sides) for corner in (a, b))
            faces += [(a, c, d), (a, d, b)]
    return Shape(positions, faces)


def holed(columns, rows, every):
    """A sheet from which some faces are missing, so that it has more than one border."""
    sheet = grid(columns, rows)
    faces = [face for i, face in enumerate(sheet.faces) if (i * i + 3 * i) % every]
    used = sorted({vertex for face in faces for vertex in face})
    number = {vertex: i for i, vertex in enumerate(used)}
    faces = [tuple(number[vertex] for vertex in face) for face in faces]
    return Shape([sheet.positions[vertex] for vertex in used], faces)


def together(*shapes):
    """Shapes beside each other, in one mesh."""
    positions, faces = [], []
    for i, shape in enumerate(shapes):
        faces += [tuple(vertex + len(positions) for vertex in face) for face in shape.faces]
        positions += shape.moved(z=2000 * i).positions
    return Shape(positions, faces)


def strip(triangles):
    """Triangles that share no vertex."""
    positions = [(20 * i + x, y, i % 7) for i in range(triangles) for x, y in ((0, 0), (10, 0), (0, 10))]
    return Shape(positions, [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(triangles)])


def textured(shape, bits=8):
    most = 1 << bits
    texture = [((i * 37) % (most + 1), (i * 101) % (most + 1)) for i in range(len(shape.positions))]
    return shape._replace(texture=texture, texture_bits=bits)


def with_normals(shape, bits=6):
    most = (1 << bits) - 2
    normals = [((i * 11) % (most + 1), (i * 29 + 3) % (most + 1)) for i in range(len(shape.positions))]
    return shape._replace(normals=normals, normal_bits=bits)


def table(form, values):
    return b"".join(struct.pack(form, *value) for value in values)


def raw(shape, **fields):
    """A payload of profile 0. fields: other values of the header."""
    data = table("<3i", shape.positions) + table("<2I", shape.texture) + table("<2I", shape.normals)
    return shape.header(RAW, **fields) + data + table("<3I", shape.faces)


def columns_of(elements, stride):
    """Differences of each byte of the elements to the element before, by byte; the first element is the baseline."""
    before, out = elements[0], [[] for _ in range(stride)]
    for element in elements:
        for i in range(stride):
            change = (element[i] - before[i] + 128) % 256 - 128
            out[i].append(zigzag(change))
        before = element
    return out


def vertex_group(deltas, mode):
    """The bytes of a group of 16 deltas in one of the modes 0 to 3."""
    if mode == 0:
        return b""
    if mode == 3:
        return bytes(deltas)
    bits = 2 * mode
    most = (1 << bits) - 1
    packed = 0
    for delta in deltas:
        packed = packed << bits | min(delta, most)
    return packed.to_bytes(16 * bits // 8, "big") + bytes(delta for delta in deltas if delta >= most)


def best_mode(deltas):
    modes = [mode for mode in range(4) if mode or not any(deltas)]
    return min(modes, key=lambda mode: (len(vertex_group(deltas, mode)), mode))


def vertex_stream(elements, stride, mode_of=best_mode):
    """Mode 0 of EXT_meshopt_compression, version 0. mode_of: chooses how a group is packed."""
    columns, out = columns_of(elements, stride), b"\xa0"
    for first in range(0, len(elements), 256):
        for column in columns:
            block = column[first : first + 256]
            block += [0] * (-len(block) % 16)
            groups = [block[i : i + 16] for i in range(0, len(block), 16)]
            modes = [mode_of(group) for group in groups]
            header = [0] * -(-len(modes) // 4)
            for i, mode in enumerate(modes):
                header[i // 4] |= mode << 2 * (i % 4)
            out += bytes(header) + b"".join(vertex_group(g, m) for g, m in zip(groups, modes))
    return out + bytes(32 - stride) + elements[0]


# Corners of the second and third vertex of a face that begins with a new one; 0: new, n: entry n - 1 of the FIFO.
PAIRS = bytes([0x00, 0x76, 0x87, 0x56, 0x67, 0x78, 0xA9, 0x86, 0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0, 0])


class IndexWriter:
    """Mode 1 of EXT_meshopt_compression, version 1. Faces keep their order; their corners are rotated where it helps."""

    def __init__(self):
        self.edges, self.recent = [(-1, -1)] * 16, [-1] * 16
        self.next, self.last = 0, 0
        self.codes, self.data, self.faces = bytearray(), bytearray(), []

    def _push(self, *vertices):
        for vertex in vertices:
            self.recent = [vertex, *self.recent[:15]]

    def _far(self, vertex):
        self.data += uleb128(zigzag((vertex - self.last + 2**31) % 2**32 - 2**31))
        self.last = vertex

    def add(self, face):
        for turn in range(3):
            a, b, c = face[turn:] + face[:turn]
            found = next((i for i, edge in enumerate(self.edges[:15]) if edge == (a, b)), None)
            if found is not None:
                return self._on_edge(found, a, b, c)
        return self._free(*face)

    def _on_edge(self, entry, a, b, c):
        recent = next((i for i in range(1, 13) if self.recent[i] == c), None)
        if c == self.next:
            what, self.next = 0, self.next + 1
        elif recent is not None:
            what = recent
        elif c in (self.last - 1, self.last + 1):
            what, self.last = (13 if c < self.last else 14), c
        else:
            what = 15
            self._far(c)
        self.codes.append(entry << 4 | what)
        if what == 0 or what >= 13:
            self._push(c)
        self.edges = [(a, c), (c, b), *self.edges[:14]]
        self.faces.append((a, b, c))

    def _half(self, vertex):
        if vertex == self.next:
            self.next += 1
            return 0
        # Entry 15 of the FIFO would be the half-byte 16, which there is not; 15 means a number.
        return next((i + 1 for i in range(14) if self.recent[i] == vertex), 15)

    def _free(self, a, b, c):
        new = a == self.next
        if new:
            self.next += 1
        halves = self._half(b), self._half(c)
        pair = halves[0] << 4 | halves[1]
        if new and pair in PAIRS[:14]:
            self.codes.append(0xF0 | PAIRS.index(pair))
        else:
            # A pair of 0 would restart the numbering of new vertices; both corners are written as numbers instead.
            self.codes.append(0xFE if new else 0xFF)
            if pair == 0:
                self.next -= 2
                halves, pair = (15, 15), 255
            self.data.append(pair)
            if not new:
                self._far(a)
            for half, vertex in zip(halves, (b, c)):
                if half == 15:
                    self._far(vertex)
            if halves == (15, 15):
                self.next = max(self.next, 0)
        self._push(a)
        for half, vertex in zip(halves, (b, c)):
            if half in (0, 15):
                self._push(vertex)
        self.edges = [(a, c), (c, b), (b, a), *self.edges[:13]]
        self.faces.append((a, b, c))

    def stream(self):
        return b"\xe1" + bytes(self.codes) + bytes(self.data) + PAIRS


def index_stream(faces):
    """The stream, and the faces as it has them: corners may be rotated."""
    writer = IndexWriter()
    for face in faces:
        writer.add(tuple(face))
    return writer.stream(), writer.faces


def elements_of(shape):
    texture = shape.texture or [()] * len(shape.positions)
    normals = shape.normals or [()] * len(shape.positions)
    return [
        struct.pack("<3i", *p) + struct.pack(f"<{len(t)}I", *t) + struct.pack(f"<{len(n)}I", *n)
        for p, t, n in zip(shape.positions, texture, normals)
    ]


def fast(shape, vertices=None, indices=None, size=None, **fields):
    """A payload of profile 4. vertices, indices: functions of the right streams; size: another size of the first."""
    elements = elements_of(shape)
    first, second = vertex_stream(elements, len(elements[0])), index_stream(shape.faces)[0]
    first = vertices(first) if vertices else first
    second = indices(second) if indices else second
    length = len(first) if size is None else size
    return shape.header(FAST, **fields) + struct.pack("<I", length) + first + second
