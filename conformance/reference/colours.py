"""Colours of vertices: clause 19 of spec/fvv.md, for raw key meshes and their delta frames."""

import struct
from collections import defaultdict

from .container import chunks, crc32c, demand
from .mesh import read_raw
from .range_coder import RangeDecoder

MOST = 511


def within(least, value, most):
    return min(max(value, least), most)


def cell_of(position, size):
    """Coordinates of a vertex's cell."""
    return tuple(p // size for p in position)


def around(cell):
    """The coordinates of the cells around a cell, with their distances; the cell itself has distance 0."""
    x, y, z = cell
    steps = (-1, 0, 1)
    return {(x + i, y + j, z + k): abs(i) + abs(j) + abs(k) for k in steps for j in steps for i in steps}


class Decoder:
    """The values of cells: clause 19.3."""

    def __init__(self, data, first):
        self.decoder, self.first = RangeDecoder(data), first
        self.contexts = defaultdict(lambda: [32768, 32768])
        self.values, self.magnitudes, self.last = {}, {}, None

    def _expected(self, cell, c):
        known = [(other, (0, 4, 2, 1)[m]) for other, m in around(cell).items() if other in self.values]
        if not known:
            return (self.values[self.last][c] if self.last else self.first[c]), 4
        total = sum(w for _, w in known)
        mean = (2 * sum(w * self.values[o][c] for o, w in known) + total) // (2 * total)
        r = 2 * sum(w * self.magnitudes[o][c] for o, w in known) // total
        return mean, sum(r >= least for least in (1, 2, 4, 8))

    def _magnitude(self, luma, class_of):
        digits = 0
        while digits < 10 and self.decoder.decision(self.contexts["more", luma, class_of, digits]):
            digits += 1
        magnitude = 1
        for _ in range(digits):
            magnitude = 2 * magnitude + self.decoder.even()
        return magnitude

    def add(self, cell):
        values, magnitudes = [], []
        for c in range(3):
            expected, class_of = self._expected(cell, c)
            residual, others = 0, sum(m > 0 for m in magnitudes)
            if self.decoder.decision(self.contexts["some", c, class_of, others]):
                residual = self._magnitude(c == 0, class_of)
            magnitudes.append(residual)
            if residual and self.decoder.even():
                residual = -residual
            values.append(expected + residual)
            demand(abs(values[-1]) <= MOST, 6204, "value")
        self.values[cell], self.magnitudes[cell], self.last = values, magnitudes, cell


def rgb(value, luma_step, chroma_step):
    y = within(0, value[0] * luma_step, 255)
    co, cg = (within(-255, v * chroma_step, 255) for v in value[1:])
    t = y - cg // 2
    b = t - co // 2
    return [within(0, x, 255) for x in (b + co, cg + t, b)]


def vertex_colour(position, size, cells):
    """Clause 19.4. cells: colours by coordinates."""
    own, weights, steps = cell_of(position, size), [], []
    for p, c in zip(position, own):
        h = (64 * (p - size * c) + 32 * size) // (2 * size)
        weights.append((32 - abs(h - 32), abs(h - 32)))
        steps.append(1 if h >= 32 else -1)
    mix = []
    for k in range(8):
        away = [k >> axis & 1 for axis in range(3)]
        other = tuple(c + s * a for c, s, a in zip(own, steps, away))
        weight = weights[0][away[0]] * weights[1][away[1]] * weights[2][away[2]]
        if other in cells:
            mix.append((weight, cells[other]))
    total = sum(w for w, _ in mix)
    return [(total // 2 + sum(w * colour[i] for w, colour in mix)) // total for i in range(3)]


def decode_chunk(payload, positions):
    """R, G, B of each vertex."""
    demand(len(payload) >= 16, 6201, "size")
    luma_step, chroma_step, _, vertex_count, size, cell_count = struct.unpack_from("<BBHIII", payload)
    demand(0 < luma_step <= 64 and 0 < chroma_step <= 64 and 0 < size <= 1 << 24, 6201, "range")
    demand(vertex_count == len(positions), 6202, "vertices")
    occupied = sorted({cell_of(p, size) for p in positions}, key=lambda cell: cell[::-1])
    demand(0 < cell_count <= 65536 and len(occupied) == cell_count, 6203, "cells")
    demand(all(max(axis) - min(axis) < 1022 for axis in zip(*occupied)), 6203, "extent")
    decoder = Decoder(payload[16:], (128 // luma_step, 0, 0))
    for cell in occupied:
        decoder.add(cell)
    demand(decoder.decoder.ends(), 6204, "end")
    cells = {cell: rgb(value, luma_step, chroma_step) for cell, value in decoder.values.items()}
    return [vertex_colour(p, size, cells) for p in positions]


def decode(stream):
    """Yields time and colours of each mesh of a stream with one configuration block; None without colours."""
    frames, key = {}, None
    for chunk in chunks(stream):
        if chunk.kind == b"MESH":
            if chunk.payload[0] != 2:
                key = chunk.time, read_raw(chunk.payload).positions
            frames[chunk.time] = key[0]
        elif chunk.kind == b"COLR":
            demand(key[0] == chunk.time, 6202, "mesh")
            frames["colours", chunk.time] = decode_chunk(chunk.payload, key[1])
    for time in sorted(t for t in frames if isinstance(t, int)):
        yield time, frames.get(("colours", frames[time]))


def listing(stream):
    """For each mesh the CRC-32C of its colours, three bytes for each vertex; "none" without colours."""
    for _, colours in decode(stream):
        yield f"{crc32c(bytes(x for rgb in colours for x in rgb)):08x}" if colours else "none"
