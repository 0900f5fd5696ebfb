"""Fast meshes: clause 8.11 of spec/fvv.md, and Appendix A of the glTF extension EXT_meshopt_compression, which it cites.

Uses nothing of meshoptimizer either.
"""

import struct

from .container import Numbers, crc32c, demand, payloads, unzigzag
from .mesh import NORMALS, TEXTURE, Mesh, raw_data

MASK = (1 << 32) - 1
BLOCK, GROUP, TAIL, TABLE = 256, 16, 32, 16


class Vertices:
    """Mode 0, attributes. modes: the header bits of all groups, so that tests can see what a stream uses."""

    def __init__(self, data, count, stride):
        demand(data[0] == 0xA0, 3025, "first byte of the vertex stream")
        demand(not any(data[len(data) - TAIL : len(data) - stride]), 3025, "tail of the vertex stream")
        self.data, self.at, self.modes = data, 1, []
        before, self.elements = list(data[len(data) - stride :]), []
        for first in range(0, count, BLOCK):
            size = min(BLOCK, count - first)
            columns = [self._deltas(-(-size // GROUP))[:size] for _ in range(stride)]
            for deltas in zip(*columns):
                before = [(byte + unzigzag(delta)) % 256 for byte, delta in zip(before, deltas)]
                self.elements.append(bytes(before))
        demand(self.at == len(data) - TAIL, 3025, "end of the vertex stream")

    def _take(self, size):
        demand(self.at + size <= len(self.data) - TAIL, 3025, "the vertex stream is cut")
        taken = self.data[self.at : self.at + size]
        self.at += size
        return taken

    def _deltas(self, groups):
        header = self._take(-(-groups // 4))
        modes = [header[g // 4] >> 2 * (g % 4) & 3 for g in range(groups)]
        self.modes += modes
        return [delta for mode in modes for delta in self._group(mode)]

    def _group(self, mode):
        if mode == 0:
            return [0] * GROUP
        if mode == 3:
            return list(self._take(GROUP))
        bits = 2 * mode
        packed = int.from_bytes(self._take(GROUP * bits // 8), "big")
        small = [packed >> bits * (GROUP - 1 - i) & (1 << bits) - 1 for i in range(GROUP)]
        return [self._take(1)[0] if value == (1 << bits) - 1 else value for value in small]


class Fifo:
    """The last 16 entries; 0 is the newest."""

    def __init__(self, empty):
        self.entries = [empty] * 16

    def push(self, entry):
        self.entries = [entry, *self.entries[:15]]

    def __getitem__(self, index):
        return self.entries[index]


class Faces:
    """Mode 1, triangles."""

    def __init__(self, data, count):
        demand(data[0] == 0xE1, 3026, "first byte of the index stream")
        self.codes, self.table = data[1 : 1 + count], data[len(data) - TABLE :]
        demand(self.table[14:] == bytes(2), 3026, "end of the table")
        demand(not any(15 in (pair >> 4, pair & 15) for pair in self.table), 3026, "a half-byte of 15")
        self.numbers = Numbers(data[: len(data) - TABLE], 1 + count, 3026)
        self.next_vertex = self.last = 0
        self.edges, self.recent = Fifo((MASK, MASK)), Fifo(MASK)
        self.faces = [self._on_edge(code) if code < 0xF0 else self._free(code) for code in self.codes]
        demand(self.numbers.at == len(data) - TABLE, 3026, "end of the index stream")

    def _new(self):
        self.next_vertex = self.next_vertex + 1 & MASK
        return self.next_vertex - 1 & MASK

    def _far(self):
        number = self.numbers.next()
        demand(number <= MASK, 3026, "a number of more than 32 bits")
        self.last = self.last + unzigzag(number) & MASK
        return self.last

    def _on_edge(self, code):
        a, b = self.edges[code >> 4]
        what = code & 15
        if what == 0:
            c = self._new()
        elif what < 13:
            c = self.recent[what]
        elif what == 15:
            c = self._far()
        else:
            c = self.last = self.last + (1 if what == 14 else -1) & MASK
        if what == 0 or what >= 13:
            self.recent.push(c)
        self.edges.push((c, b))
        self.edges.push((a, c))
        return a, b, c

    def _free(self, code):
        if code < 0xFE:
            pair = self.table[code & 15]
            a = self._new()
        else:
            demand(self.numbers.at < len(self.numbers.data), 3026, "the index stream is cut")
            pair = self.numbers.data[self.numbers.at]
            self.numbers.at += 1
            if pair == 0:
                self.next_vertex = 0
            a = self._new() if code == 0xFE else self._far()
        b, c = (self._corner(half) for half in (pair >> 4, pair & 15))
        self.recent.push(a)
        for half, vertex in (pair >> 4, b), (pair & 15, c):
            if half in (0, 15):
                self.recent.push(vertex)
        for edge in (b, a), (c, b), (a, c):
            self.edges.push(edge)
        return a, b, c

    def _corner(self, half):
        if half == 0:
            return self._new()
        return self._far() if half == 15 else self.recent[half - 1]


def split(payload):
    """The bytes of the vertex stream and of the index stream, and those of one vertex, of a MESH payload of profile 4."""
    _, attributes, _, _, vertices, faces = struct.unpack_from("<4B2I", payload)
    demand(len(payload) >= 20, 3023, "no size of the vertex stream")
    (size,) = struct.unpack_from("<I", payload, 16)
    stride, rest = 12 + 8 * bin(attributes).count("1"), payload[20:]
    demand(size <= len(rest), 3023, "the vertex stream is cut")
    demand(33 + stride * -(-vertices // 64) <= size and 17 + faces <= len(rest) - size, 3024, "density")
    return rest[:size], rest[size:], stride


def streams(payload):
    """The decoded vertex and index streams of a whole MESH payload of profile 4."""
    vertices, faces = struct.unpack_from("<2I", payload, 4)
    vertex_stream, index_stream, stride = split(payload)
    return Vertices(vertex_stream, vertices, stride), Faces(index_stream, faces)


def decode(payload):
    """The Mesh of a whole payload."""
    vertices, faces = streams(payload)
    _, attributes, texture_bits, normal_bits = payload[:4]
    pairs, at = [], 12
    for attribute in (TEXTURE, NORMALS):
        there = attributes & attribute
        pairs.append([struct.unpack_from("<2I", e, at) for e in vertices.elements] if there else [])
        at += 8 if there else 0
    positions = [struct.unpack_from("<3i", e) for e in vertices.elements]
    return Mesh(positions, faces.faces, pairs[0], texture_bits, pairs[1], normal_bits)


def listing(stream):
    """For each mesh frame the CRC-32C of its data in the raw profile."""
    for payload in payloads(stream, b"MESH"):
        yield f"{crc32c(raw_data(decode(payload))):08x}"
