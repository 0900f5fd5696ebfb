"""Colours of key meshes: the encoder of clause 19 of spec/fvv.md."""

from reference.colours import around, cell_of

from .coder import Encoder, contexts
from .packing import pack

WEIGHT = (0, 4, 2, 1)


def occupied(positions, size):
    return sorted({cell_of(p, size) for p in positions}, key=lambda cell: cell[::-1])


class Values:
    """Encodes the values of cells, as reference.colours.Decoder reads them."""

    def __init__(self, first):
        self.encoder, self.table, self.first = Encoder(), contexts(), first
        self.values, self.sizes, self.last = {}, {}, None

    def _expected(self, cell, c):
        known = [(other, WEIGHT[m]) for other, m in around(cell).items() if other in self.values]
        if not known:
            return (self.values[self.last][c] if self.last else self.first[c]), 4
        total = sum(w for _, w in known)
        mean = (2 * sum(w * self.values[o][c] for o, w in known) + total) // (2 * total)
        r = 2 * sum(w * self.sizes[o][c] for o, w in known) // total
        return mean, sum(r >= least for least in (1, 2, 4, 8))

    def add(self, cell, values):
        sizes = []
        for c, value in enumerate(values):
            expected, kind = self._expected(cell, c)
            residual = value - expected
            others = sum(size > 0 for size in sizes)
            self.encoder.decision(self.table["some", c, kind, others], residual != 0)
            if residual:
                self._magnitude(c == 0, kind, abs(residual))
                self.encoder.even(residual < 0)
            sizes.append(abs(residual))
        self.values[cell], self.sizes[cell], self.last = list(values), sizes, cell

    def _magnitude(self, luma, kind, magnitude):
        digits = magnitude.bit_length() - 1
        for i in range(digits):
            self.encoder.decision(self.table["more", luma, kind, i], 1)
        if digits < 10:
            self.encoder.decision(self.table["more", luma, kind, digits], 0)
        for i in range(digits):
            self.encoder.even(magnitude >> (digits - 1 - i) & 1)


def payload(shape, value_of, size=20, luma_step=4, chroma_step=8, mesh_track=1, data=None, **fields):
    """A COLR payload. value_of(cell): its Y, Co and Cg in steps; data: changes the right bytes."""
    coder = Values((128 // luma_step if luma_step else 0, 0, 0))
    cells = occupied(shape.positions, size or 1)
    for cell in cells:
        coder.add(cell, value_of(cell))
    values = {"luma_step": luma_step, "chroma_step": chroma_step, "mesh_track": mesh_track}
    values |= {"vertex_count": len(shape.positions), "cell_size": size, "cell_count": len(cells)}
    coded = coder.encoder.data()
    return pack("COLR payload", **values | fields) + (data(coded) if data else coded)
