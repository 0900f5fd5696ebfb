"""Delta frames: the encoder of clauses 8.7 to 8.9 of spec/fvv.md."""

from collections import defaultdict

from reference.container import uleb128
from reference.mesh_delta import STATE_MAX, Levels, around_class, places, predicted, replaced, sign

from .coder import Encoder, contexts
from .meshes import DELTA


class Motion:
    """The state of a key mesh and its delta frames. Residuals are whole steps, so the positions are those of the
    decoder, within half a step of the target."""

    def __init__(self, key):
        self.states = [[4 * x for x in p] for p in key.positions]
        self.tables = defaultdict(contexts)
        self._begin(key)
        self.before = [[0] * 3 for _ in key.positions]
        self.last = [[0] * 3 for _ in key.positions]
        self.number = 0

    def _begin(self, key):
        self.key = key
        hierarchy = Levels(key.positions, [tuple(face) for face in key.faces])
        self.levels, self.stencils = hierarchy.levels, hierarchy.stencils
        self.contexts = [self.tables[place] for place in places(hierarchy)]
        return hierarchy

    def replace(self, key, kept):
        """Clause 8.14: goes on with another mesh, which has the vertices that are kept, by number, and those of a patch."""
        of_patch = key.positions[len(kept) :]
        self.states = replaced(self.states, kept, [[4 * x for x in p] for p in of_patch])
        self.before = replaced(self.before, kept, [[0] * 3 for _ in of_patch])
        self.last = replaced(self.last, kept, [[0] * 3 for _ in of_patch])
        hierarchy = self._begin(key)
        for vertex in hierarchy.twins:
            if vertex >= len(kept):
                self.states[vertex] = list(self.states[hierarchy.node[vertex]])

    def positions(self):
        return [tuple(x + 2 >> 2 for x in state) for state in self.states]

    def shape(self):
        return self.key._replace(positions=self.positions())

    def frame(self, target, steps=4, still=(), number=None, **change):
        """A MESH payload that moves the vertices to target. steps: quarters, one for each level or for all; still:
        levels without data. change: other values, as of `payload`."""
        steps = [steps] * len(self.levels) if isinstance(steps, int) else steps
        self.number += 1
        self.motion = [[0] * 3 for _ in self.states]
        self.now = [[0] * 3 for _ in self.states]
        data = []
        for i, (level, step) in enumerate(zip(self.levels, steps)):
            encoder = None if i in still else Encoder()
            for vertex in level:
                self._move(vertex, encoder, self.contexts[i], step, target)
            data.append(encoder.data() if encoder else b"")
        self.before = self.now
        return self.payload(steps, data, self.number if number is None else number, **change)

    def payload(self, steps, data, number, count=None, sizes=None, extra=b"", overlong=False, **header):
        """count, sizes: other values than the right ones; extra: bytes at the end; overlong: of the number."""
        numbers = uleb128(number)
        if overlong:
            numbers = numbers[:-1] + bytes([numbers[-1] | 128, 0])
        numbers += uleb128(len(steps) if count is None else count)
        for step, size in zip(steps, sizes or map(len, data)):
            numbers += uleb128(step) + uleb128(size)
        values = {"attributes": 0} if not (self.key.texture or self.key.normals) else {}
        return self.key.header(DELTA, **values | header) + numbers + b"".join(data) + extra

    def _move(self, vertex, encoder, table, step, target):
        stencil = self.stencils[vertex]
        around = [node for node, weight in stencil[:4] if weight]
        done = 0
        for a in range(3):
            former = self.states[vertex][a]
            state = predicted(former, [(weight, self.motion[node][a]) for node, weight in stencil], step)
            if encoder:
                # To the nearest, halves away from 0.
                wanted = 4 * target[vertex][a] - state
                residual = (abs(wanted) + step // 2) // step * sign(wanted)
                self._write(encoder, table, residual, vertex, a, around, done)
                self.now[vertex][a] = residual
                self.last[vertex][a] = sign(residual) or self.last[vertex][a]
                done += abs(residual)
                state += residual * step
            if abs(state) > STATE_MAX:
                raise ValueError("a state is beyond the lattice")
            self.states[vertex][a] = state
            self.motion[vertex][a] = min(state - former, (1 << 31) - 1)

    def _write(self, encoder, table, residual, vertex, a, around, done):
        near = [self.now[node][a] for node in around]
        size = around_class(sum(min(abs(x), 15) for x in near))
        some = (a, size, min(abs(self.before[vertex][a]), 2), min(done, 2))
        encoder.decision(table["some", some], residual != 0)
        if residual:
            write_magnitude(encoder, table, size, abs(residual))
            balance = sign(sum(map(sign, near)))
            encoder.decision(table["negative", (a, self.last[vertex][a], balance)], residual < 0)


def write_magnitude(encoder, table, size, magnitude):
    digits = magnitude.bit_length() - 1
    for i in range(digits):
        encoder.decision(table["more", size, i], 1)
    encoder.decision(table["more", size, digits], 0)
    for i in range(digits):
        bit = magnitude >> (digits - 1 - i) & 1
        if i:
            encoder.even(bit)
        else:
            encoder.decision(table["first", digits], bit)
