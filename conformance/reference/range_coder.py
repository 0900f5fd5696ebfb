"""The adaptive binary range decoder: clause 2.4 of spec/fvv.md."""


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
