"""Delta frames: clauses 8.7 to 8.9 of spec/fvv.md, after key meshes in the raw profile."""

import struct
from collections import defaultdict

from .container import Numbers, crc32c, demand, payloads
from .mesh import read_raw
from .range_coder import RangeDecoder

STATE_MAX = 1 << 30
AXES = range(3)


def divide(a, b):
    """Rounds towards 0."""
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


class Levels:
    """Clause 8.8: levels of vertices in coding order, and stencils of (node, weight)."""

    def __init__(self, positions, faces):
        self.positions = positions
        self.stencils = [[] for _ in positions]
        point = {}
        self.node = node = [point.setdefault(tuple(p), vertex) for vertex, p in enumerate(positions)]
        self.twins = [vertex for vertex in range(len(positions)) if node[vertex] != vertex]
        self.neighbours = {vertex: set() for vertex in point.values()}
        for corners in faces:
            for a, b in zip(corners, corners[1:] + corners[:1]):
                self._join(node[a], node[b])
        passes = []
        while len(passes) < 48:
            taken = self._choose()
            connected = sum(1 for around in self.neighbours.values() if around)
            if connected <= 24 or len(taken) < connected // 6:
                break
            for vertex in taken:
                self._take_out(vertex)
            passes.append(taken)
        survivors = sorted(self.neighbours)
        for former, vertex in zip(survivors, survivors[1:]):
            self.stencils[vertex] = [(former, 1 << 16)]
        for vertex in self.twins:
            self.stencils[vertex] = [(node[vertex], 1 << 16)]
        self.levels = [survivors]
        for number in range(len(passes), 0, -1):
            if number % 3 == 0:
                self.levels.append([])
            self.levels[-1] += passes[number - 1]
        if self.twins:
            self.levels.append(self.twins)

    def _join(self, a, b):
        if a != b:
            self.neighbours[a].add(b)
            self.neighbours[b].add(a)

    def _choose(self):
        taken = set()
        for vertex, around in sorted(self.neighbours.items()):
            if 1 <= len(around) <= 8 and not around & taken:
                taken.add(vertex)
        return sorted(taken)

    def _take_out(self, vertex):
        around = self.neighbours.pop(vertex)
        nearest = sorted(around, key=lambda node: (self._squared(vertex, node), node))
        for other in nearest:
            self.neighbours[other].remove(vertex)
            self._join(nearest[0], other)
        differences = [self._difference(vertex, node) for node in nearest[:6]]
        shift = max(0, max(abs(x) for u in differences for x in u).bit_length() - 9)
        offsets = [[x >> shift for x in u] for u in differences]
        self.stencils[vertex] = list(zip(nearest, Weights(offsets).weights))

    def _difference(self, vertex, node):
        return [self.positions[node][a] - self.positions[vertex][a] for a in AXES]

    def _squared(self, vertex, node):
        return sum(d * d for d in self._difference(vertex, node))


class Weights:
    """Clause 8.8: the weights of a stencil, by the offsets of its nodes, and the numbers on the way to them."""

    def __init__(self, offsets):
        self.u = u = offsets
        self.q = [(1 << 30) // (1 + sum(x * x for x in v)) for v in u]
        self.w = w = [(x << 12) // sum(self.q) for x in self.q]
        w[0] += (1 << 12) - sum(w)
        self.m = m = [sum(x * v[a] for x, v in zip(w, u)) for a in AXES]
        spread = [[sum(x * v[a] * v[b] for x, v in zip(w, u)) << 12 for b in AXES] for a in AXES]
        self.c = c = [[spread[a][b] - m[a] * m[b] for b in AXES] for a in AXES]
        self.t = sum(c[a][a] for a in AXES)
        self.h = h = max(0, self.t.bit_length() - 17)
        self.k = k = [[c[a][b] + (self.t // 32 + 1 if a == b else 0) >> h for b in AXES] for a in AXES]

        def minor(a, b):
            a1, a2, b1, b2 = (a + 1) % 3, (a + 2) % 3, (b + 1) % 3, (b + 2) % 3
            return k[a1][b1] * k[a2][b2] - k[a1][b2] * k[a2][b1]

        self.d = d = sum(k[0][b] * minor(0, b) for b in AXES) >> 16
        self.g = [divide(-sum(minor(a, b) * m[b] for b in AXES), d) if d > 0 else 0 for a in AXES]
        self.corrections = [self._correction(v) for v in u]
        self.weights = [x * ((1 << 16) + y) >> 12 for x, y in zip(w, self.corrections)]
        self.weights[0] += (1 << 16) - sum(self.weights)

    def _correction(self, v):
        correction = sum(((v[a] << 12) - self.m[a]) * self.g[a] for a in AXES) >> self.h
        return max(-(1 << 18), min(1 << 18, correction))


def predicted(former, moved, step):
    """Clause 8.9, on one axis: former state, (weight, motion) of each node of the stencil, step of the level."""
    state = former + (sum(weight * motion for weight, motion in moved) + (1 << 15) >> 16)
    multiple = max(g for g in (1, 2, 4) if step % g == 0)
    state = (state + multiple // 2) // multiple * multiple
    return max(-STATE_MAX, min(STATE_MAX, state))


def places(levels):
    """Clause 8.14: for each level what its contexts are kept under, twins or its distance from the last other level."""
    others = len(levels.levels) - bool(levels.twins)
    return [others - 1 - i for i in range(others)] + ["twins"] * bool(levels.twins)


def replaced(rows, kept, fresh):
    """Rows of vertices: those that are kept, then those of a patch."""
    return [rows[vertex] for vertex in kept] + fresh


class Sequence:
    """A key mesh and the delta frames after it: clause 8.9."""

    def __init__(self, key):
        self.states = [[4 * x for x in p] for p in key.positions]
        # A table for each level; its key is what selects the context.
        self.tables = defaultdict(lambda: defaultdict(lambda: [32768, 32768]))
        self._begin(key.positions, key.faces)
        self.before = [[0] * 3 for _ in key.positions]
        self.last = [[0] * 3 for _ in key.positions]
        self.frame = 0

    def _begin(self, positions, faces):
        self.hierarchy = Levels(positions, faces)
        self.contexts = [self.tables[place] for place in places(self.hierarchy)]

    def replace(self, kept, patch, faces):
        """Clause 8.14: goes on with other faces, the vertices that are kept, by number, and the positions of a patch."""
        nothing = [[0] * 3 for _ in patch]
        self.states = replaced(self.states, kept, [[4 * x for x in p] for p in patch])
        self.before = replaced(self.before, kept, nothing)
        self.last = replaced(self.last, kept, [list(row) for row in nothing])
        self._begin(self.positions(), faces)
        for vertex in self.hierarchy.twins:
            if vertex >= len(kept):
                self.states[vertex] = list(self.states[self.hierarchy.node[vertex]])

    def positions(self):
        """The positions of the last frame."""
        return [[x + 2 >> 2 for x in state] for state in self.states]

    def check_number(self, payload, at):
        """Of the delta_mesh( ) at an offset of a MESH payload. Returns the numbers behind it."""
        numbers = Numbers(payload, at, 3021)
        number = numbers.next()
        demand(number == self.frame + 1, 3019, f"delta frame {number}, expected {self.frame + 1}")
        return numbers

    def add(self, payload, at=16):
        """Decodes the delta_mesh( ) that is in a MESH payload from an offset on."""
        numbers = self.check_number(payload, at)
        self.frame += 1
        count = numbers.next()
        demand(count == len(self.hierarchy.levels), 3020, f"{count} levels")
        coded = [(numbers.next(), numbers.next()) for _ in self.hierarchy.levels]
        demand(all(1 <= step < 1 << 18 for step, _ in coded), 3020, "a step")
        at, levels = numbers.at, []
        demand(at + sum(size for _, size in coded) == len(payload), 3021, "sizes of the levels")
        for step, size in coded:
            levels.append((step, RangeDecoder(payload[at : at + size]) if size else None))
            at += size
        self.move(levels)

    def move(self, coded):
        """coded: for each level its step, and a decoder of its decisions or None."""
        self.motion = [[0] * 3 for _ in self.states]
        self.now = [[0] * 3 for _ in self.states]
        for level, contexts, (step, decoder) in zip(self.hierarchy.levels, self.contexts, coded):
            for vertex in level:
                self._move(vertex, decoder, contexts, step)
            demand(not decoder or decoder.ends(), 3022, "end of a level")
        self.before = self.now

    def _move(self, vertex, decoder, contexts, step):
        stencil = self.hierarchy.stencils[vertex]
        around = [node for node, weight in stencil[:4] if weight]
        before_axis = 0
        for a in AXES:
            former = self.states[vertex][a]
            state = predicted(former, [(weight, self.motion[node][a]) for node, weight in stencil], step)
            if decoder:
                residual = self.residual(vertex, a, around, before_axis, decoder, contexts)
                self.now[vertex][a] = residual
                if residual:
                    self.last[vertex][a] = sign(residual)
                before_axis += abs(residual)
                state += residual * step
            demand(abs(state) <= STATE_MAX, 3006, "a position outside the lattice")
            self.states[vertex][a] = state
            self.motion[vertex][a] = min(state - former, (1 << 31) - 1)

    def residual(self, vertex, a, around, before_axis, decoder, contexts):
        near = [self.now[node][a] for node in around]
        magnitudes = around_class(sum(min(abs(x), 15) for x in near))
        some = (a, magnitudes, min(abs(self.before[vertex][a]), 2), min(before_axis, 2))
        if not decoder.decision(contexts["some", some]):
            return 0
        magnitude = decode_magnitude(decoder, contexts, magnitudes)
        signs = (a, self.last[vertex][a], sign(sum(sign(x) for x in near)))
        return -magnitude if decoder.decision(contexts["negative", signs]) else magnitude


def sign(x):
    return (x > 0) - (x < 0)


def around_class(total):
    return total if total < 3 else 3 if total < 5 else 4 if total < 9 else 5


def decode_magnitude(decoder, contexts, around):
    digits = 0
    while decoder.decision(contexts["more", around, digits]):
        digits += 1
        demand(digits < 30, 3022, "a magnitude of 2^30")
    magnitude = 1
    for i in range(digits):
        magnitude = 2 * magnitude + (decoder.even() if i else decoder.decision(contexts["first", digits]))
    return magnitude


def decode(stream):
    """Yields the positions of each mesh frame of a stream of one mesh track."""
    sequence = None
    for payload in payloads(stream, b"MESH"):
        if payload[0] == 2:
            sequence.add(payload)
        else:
            sequence = Sequence(read_raw(payload))
        yield sequence.positions()


def listing(stream):
    """CRC-32C of the positions of each frame as i32, x y z for each vertex."""
    for positions in decode(stream):
        yield f"{crc32c(b''.join(struct.pack('<3i', *p) for p in positions)):08x}"
