"""A slow, plain decoder of delta frames, written from clauses 2.4 and 8.7 to 8.9 of spec/fvv.md alone.

Knows meshes in the raw profile and delta frames behind them. Uses nothing of libfvv, so that prose and library are
held against each other.

    python3 spec/delta.py STREAM.fvv     # the CRC-32C of the positions of each mesh frame
"""

import pathlib
import struct
import sys
from collections import defaultdict

LATTICE_MAX = 1 << 28
AXES = range(3)


def divide(a, b):
    """Rounds towards 0."""
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


class RangeDecoder:
    """Clause 2.4."""

    def __init__(self, data):
        self.data, self.taken, self.range, self.code = data, 0, (1 << 32) - 1, 0
        for _ in range(4):
            self._take()

    def _take(self):
        self.code = self.code * 256 + (self.data[self.taken] if self.taken < len(self.data) else 0)
        self.taken += 1

    def _decide(self, bound, one):
        if one:
            self.range = bound
        else:
            self.code -= bound
            self.range -= bound
        while self.range < 1 << 24:
            self.range *= 256
            self._take()
        return int(one)

    def decision(self, context):
        fast, slow = context
        bound = (self.range >> 12) * ((fast + slow) // 32)
        one = self.code < bound
        if one:
            context[:] = fast + (65536 - fast) // 16, slow + (65536 - slow) // 128
        else:
            context[:] = fast - fast // 16, slow - slow // 128
        return self._decide(bound, one)

    def even(self):
        # Not _decide: half of an odd range leaves one value over, which nobody uses.
        self.range //= 2
        one = self.code < self.range
        if not one:
            self.code -= self.range
        while self.range < 1 << 24:
            self.range *= 256
            self._take()
        return int(one)

    def ends(self):
        return self.taken == len(self.data) + 3


class Levels:
    """Clause 8.8: levels of vertices, and stencils of (node, weight)."""

    def __init__(self, positions):
        self.positions = positions
        self.least = [min(p[a] for p in positions) for a in AXES]
        self.levels, self.shifts = [], []
        self.stencils = [[] for _ in positions]
        self._find_levels()
        self._find_stencils()

    def _cell(self, vertex, shift):
        return tuple(self.positions[vertex][a] - self.least[a] >> shift for a in AXES)

    def _from_centre(self, vertex, shift):
        side = 1 << shift
        offsets = [2 * ((self.positions[vertex][a] - self.least[a]) % side) - side for a in AXES]
        return sum(d * d for d in offsets)

    def _find_levels(self):
        n = len(self.positions)
        extent = max(max(p[a] for p in self.positions) - self.least[a] for a in AXES)
        nodes = set()
        for shift in range(max(extent.bit_length() - 3, 0), 0, -1):
            cells = defaultdict(list)
            for vertex in range(n):
                cells[self._cell(vertex, shift)].append(vertex)
            if n < 192 or 3 * len(cells) > n:
                break
            if len(cells) < (2 * len(nodes) if nodes else 64):
                continue
            free = [members for members in cells.values() if not nodes.intersection(members)]
            level = sorted(min(m, key=lambda v: (self._from_centre(v, shift), v)) for m in free)
            self._add(level, shift, nodes)
        points = {tuple(self.positions[v]) for v in nodes}
        level = []
        for vertex in range(n):
            if vertex not in nodes and tuple(self.positions[vertex]) not in points:
                points.add(tuple(self.positions[vertex]))
                level.append(vertex)
        self._add(level, 0, nodes)
        self.twins = [vertex for vertex in range(n) if vertex not in nodes]
        if self.twins:
            self.levels.append(self.twins)

    def _add(self, level, shift, nodes):
        self.levels.append(level)
        self.shifts.append(shift)
        nodes.update(level)

    def _find_stencils(self):
        earlier = list(self.levels[0])
        for level, shift in zip(self.levels[1 : len(self.shifts)], self.shifts):
            nodes = defaultdict(list)
            for node in earlier:
                nodes[self._cell(node, shift)].append(node)
            for vertex in level:
                x, y, z = self._cell(vertex, shift)
                around = [(x + i, y + j, z + k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
                near = [node for cell in around for node in nodes.get(cell, ())]
                near = sorted(near, key=lambda node: (self._squared(vertex, node), node))[:6]
                offsets = [self._offset(vertex, node, max(shift - 8, 0)) for node in near]
                self.stencils[vertex] = list(zip(near, weights(offsets)))
            earlier += level
        place = {tuple(self.positions[v]): v for v in earlier}
        for vertex in self.twins:
            self.stencils[vertex] = [(place[tuple(self.positions[vertex])], 1 << 16)]

    def _offset(self, vertex, node, shift):
        return [self.positions[node][a] - self.positions[vertex][a] >> shift for a in AXES]

    def _squared(self, vertex, node):
        return sum(d * d for d in self._offset(vertex, node, 0))


def weights(offsets):
    q = [(1 << 30) // (1 + sum(x * x for x in u)) for u in offsets]
    w = [(x << 12) // sum(q) for x in q]
    w[0] += (1 << 12) - sum(w)
    m = [sum(x * u[a] for x, u in zip(w, offsets)) for a in AXES]
    c = [[(sum(x * u[a] * u[b] for x, u in zip(w, offsets)) << 12) - m[a] * m[b] for b in AXES] for a in AXES]
    trace = sum(c[a][a] for a in AXES)
    h = 0
    while trace >> h >= 1 << 17:
        h += 1
    k = [[c[a][b] + (trace // 8 + 1 if a == b else 0) >> h for b in AXES] for a in AXES]

    def minor(a, b):
        a1, a2, b1, b2 = (a + 1) % 3, (a + 2) % 3, (b + 1) % 3, (b + 2) % 3
        return k[a1][b1] * k[a2][b2] - k[a1][b2] * k[a2][b1]

    d = sum(k[0][b] * minor(0, b) for b in AXES) >> 16
    g = [divide(-sum(minor(a, b) * m[b] for b in AXES), d) if d > 0 else 0 for a in AXES]
    result = []
    for x, u in zip(w, offsets):
        correction = sum(((u[a] << 12) - m[a]) * g[a] for a in AXES) >> h
        correction = max(-(1 << 18), min(1 << 18, correction))
        result.append(x * ((1 << 16) + correction) >> 12)
    result[0] += (1 << 16) - sum(result)
    return result


class Sequence:
    """A key mesh and the frames behind it; positions are those of the frame that was added last."""

    def __init__(self, positions):
        self.positions = [list(p) for p in positions]
        self.hierarchy = Levels(positions)
        # Of each level, by what chooses the context.
        self.contexts = [defaultdict(lambda: [32768, 32768]) for _ in self.hierarchy.levels]
        self.before = [[0] * 3 for _ in positions]
        self.frame = 0

    def add(self, payload):
        """Decodes a whole MESH payload of profile 2."""
        numbers = Numbers(payload, 16)
        self.frame += 1
        assert numbers.next() == self.frame
        assert numbers.next() == len(self.hierarchy.levels)
        coded = [(numbers.next(), numbers.next()) for _ in self.hierarchy.levels]
        self.motion = [[0] * 3 for _ in self.positions]
        self.now = [[0] * 3 for _ in self.positions]
        at = numbers.at
        for level, contexts, (step, size) in zip(self.hierarchy.levels, self.contexts, coded):
            decoder = RangeDecoder(payload[at : at + size]) if size else None
            at += size
            for vertex in level:
                self._move(vertex, decoder, contexts, step)
            assert not decoder or decoder.ends()
        assert at == len(payload)
        self.before = self.now

    def _move(self, vertex, decoder, contexts, step):
        place, motion = self.positions[vertex], self.motion[vertex]
        stencil = self.hierarchy.stencils[vertex]
        near = [node for node, weight in stencil[:4] if weight]
        before_axis = 0
        for a in AXES:
            predicted = sum(weight * self.motion[node][a] for node, weight in stencil) + (1 << 15) >> 16
            motion[a] = max(-LATTICE_MAX, min(LATTICE_MAX, place[a] + predicted)) - place[a]
            if decoder:
                around = around_class(sum(min(self.now[node][a], 15) for node in near))
                some = (a, around, min(self.before[vertex][a], 2), min(before_axis, 2))
                residual = decode_residual(decoder, contexts, some, around)
                self.now[vertex][a] = abs(residual)
                before_axis += abs(residual)
                motion[a] += residual * step
            place[a] += motion[a]
            assert abs(place[a]) <= LATTICE_MAX


def around_class(total):
    return total if total < 3 else 3 if total < 5 else 4 if total < 9 else 5


def decode_residual(decoder, contexts, some, around):
    if not decoder.decision(contexts["some", some]):
        return 0
    digits = 0
    while decoder.decision(contexts["more", around, digits]):
        digits += 1
        assert digits < 30
    magnitude = 1
    for i in range(digits):
        magnitude = 2 * magnitude + (decoder.even() if i else decoder.decision(contexts["first", digits]))
    return -magnitude if decoder.even() else magnitude


class Numbers:
    """ULEB128 one after the other."""

    def __init__(self, data, at):
        self.data, self.at = data, at

    def next(self):
        value = shift = 0
        while True:
            byte = self.data[self.at]
            self.at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value


def mesh_payloads(stream):
    """Payloads of all MESH chunks, in order; the container is taken to be in order."""
    at = 24
    while at < len(stream):
        size = struct.unpack_from("<Q", stream, at + 16)[0]
        if stream[at : at + 4] == b"MESH":
            yield stream[at + 32 : at + 32 + size]
        at += 32 + (size + 7) // 8 * 8


def raw_positions(payload):
    return [
        list(struct.unpack_from("<3i", payload, 16 + 12 * v))
        for v in range(struct.unpack_from("<I", payload, 4)[0])
    ]


def decode(stream):
    """Positions of each mesh frame of a stream of one mesh track."""
    sequence = None
    for payload in mesh_payloads(stream):
        if payload[0] == 2:
            sequence.add(payload)
        else:
            assert payload[0] == 0
            sequence = Sequence(raw_positions(payload))
        yield [list(p) for p in sequence.positions]


def position_crcs(stream):
    """CRC-32C of the positions of each frame as i32, x y z for each vertex."""
    for positions in decode(stream):
        yield f"{crc32c(b''.join(struct.pack('<3i', *p) for p in positions)):08x}"


if __name__ == "__main__":
    print("\n".join(position_crcs(pathlib.Path(sys.argv[1]).read_bytes())))
