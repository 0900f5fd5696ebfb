"""The encoder of the range coder: clause 2.4 of spec/fvv.md."""

from collections import defaultdict

from reference.range_coder import adapt, probability


class Encoder:
    """Takes decisions in the order in which a decoder makes them; data() returns the bytes."""

    def __init__(self):
        # low keeps all bits that were written, as one integer: no carry has to be propagated.
        self.low, self.range, self.shift = 0, (1 << 32) - 1, 0

    def _encode(self, one, bound):
        self.low += 0 if one else bound
        while self.range < 1 << 24:
            self.range *= 256
            self.low *= 256
            self.shift += 1

    def decision(self, context, one):
        bound = (self.range >> 12) * probability(context)
        self.range = bound if one else self.range - bound
        adapt(context, one)
        self._encode(one, bound)

    def even(self, one):
        self.range //= 2
        self._encode(one, self.range)

    def data(self):
        """The three zero bytes at the end are left out."""
        first = (self.low + self.range - 1) >> 24
        return first.to_bytes(self.shift + 1, "big")


def contexts():
    """Contexts that begin with even odds, by what selects them."""
    return defaultdict(lambda: [32768, 32768])
