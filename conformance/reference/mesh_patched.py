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


def left_out(data, faces):
    """For each of the faces of the base mesh whether the bytes of `absent` leave it out."""
    numbers, flags, absent = Numbers(data, 0, 3034), [], False
    while numbers.at < len(data):
        first = numbers.at == 0
        length = numbers.next()
        demand(first or length, 3034, "a run of no face")
        demand(len(flags) + length <= faces, 3034, "runs of too many faces")
        flags += [absent] * length
        absent = not absent
    demand(len(flags) == faces, 3034, f"runs of {len(flags)} faces, expected {faces}")
    return flags


def runs(flags):
    """The lengths of the runs of equal flags; the first is that of faces that remain."""
    lengths, absent = [0], False
    for flag in flags:
        if flag != absent:
            lengths.append(0)
            absent = not absent
        lengths[-1] += 1
    return lengths
