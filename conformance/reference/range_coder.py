"""The adaptive binary range coder: clause 2.4 of spec/fvv.md."""


def probability(context):
    """Of a 1, in units of 2^-12."""
    return sum(context) // 32


def adapt(context, one):
    fast, slow = context
    if one:
        context[:] = fast + (65536 - fast) // 16, slow + (65536 - slow) // 128
    else:
        context[:] = fast - fast // 16, slow - slow // 128


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
        bound = (self.range >> 12) * probability(context)
        one = self.code < bound
        adapt(context, one)
        return self._decide(bound, one)

    def even(self):
        # Not _decide: half of an odd range leaves one value unused.
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


class RangeEncoder:
    """Takes the place of a decoder that finds the given decisions; data() returns the bytes in which it would find them."""

    def __init__(self, decisions):
        self.decisions, self.low, self.range, self.shift = iter(decisions), 0, (1 << 32) - 1, 0

    def _encode(self, one, bound):
        # low has all bits that were written, as one integer: no carry has to be propagated.
        self.low += 0 if one else bound
        while self.range < 1 << 24:
            self.range *= 256
            self.low *= 256
            self.shift += 1
        return one

    def decision(self, context):
        one = next(self.decisions)
        bound = (self.range >> 12) * probability(context)
        self.range = bound if one else self.range - bound
        adapt(context, one)
        return self._encode(one, bound)

    def even(self):
        one = next(self.decisions)
        self.range //= 2
        return self._encode(one, self.range)

    def ends(self):
        return next(self.decisions, None) is None

    def data(self):
        """Three zero bytes at the end are left out."""
        first = (self.low + self.range - 1) >> 24
        return first.to_bytes(self.shift + 1, "big")
