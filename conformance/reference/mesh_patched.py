"""Patched frames: clause 8.14 of spec/fvv.md."""

from .container import Numbers, demand


class Parts:
    """The parts of a whole MESH payload of profile 5. delta: offset of its delta_mesh( )."""

    def __init__(self, payload):
        numbers = Numbers(payload, 16, 3033)
        absent, patch = numbers.next(), numbers.next()
        at = numbers.at
        demand(at + absent + patch <= len(payload), 3033, "sizes of runs and patch")
        self.absent, self.patch = payload[at : at + absent], payload[at + absent : at + absent + patch]
        self.delta = at + absent + patch


def changed(before, data):
    """The flags of faces that are left out, by those of the previous frame and the bytes of `absent`."""
    numbers, after, change = Numbers(data, 0, 3034), [], False
    while numbers.at < len(data):
        first = numbers.at == 0
        length = numbers.next()
        demand(first or length, 3034, "a run of no face")
        demand(len(after) + length <= len(before), 3034, "runs of too many faces")
        after += [flag != change for flag in before[len(after) : len(after) + length]]
        change = not change
    demand(len(after) == len(before), 3034, f"runs of {len(after)} faces, expected {len(before)}")
    return after


def runs(before, after):
    """The lengths that lead from the flags of one frame to those of the next."""
    lengths, change = [0], False
    for old, new in zip(before, after):
        if (old != new) != change:
            lengths.append(0)
            change = not change
        lengths[-1] += 1
    return lengths
