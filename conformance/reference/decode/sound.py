"""Packets of sound: clause 20.2 of spec/fvv.md."""

import math
import struct
from fractions import Fraction

from ..container import demand

MOVES = 2


class Packets:
    """An AUDI payload: start and pre-roll count, and the packets."""

    def __init__(self, payload, flags):
        demand(len(payload) >= 16, 4305, "size")
        self.start, count, self.preroll = struct.unpack_from("<qII", payload)
        at = 16
        if flags & MOVES:
            at += 24
            demand(len(payload) >= at, 4305, "size")
            position = struct.unpack_from("<3d", payload, 16)
            demand(all(map(math.isfinite, position)), 4305, "a position that is not finite")
        demand(count > 0 and at + 2 * count <= len(payload), 4305, f"{count} packets")
        sizes = struct.unpack_from(f"<{count}H", payload, at)
        demand(all(sizes), 4305, "an empty packet")
        end = at + 2 * count + sum(sizes)
        demand(end <= len(payload), 4305, "sizes of the packets")
        demand(self.preroll < count, 4305, "nothing but pre-roll")
        self.count, self.data = count, payload[at + 2 * count : end]


class Track:
    """An audio track in one group."""

    def __init__(self, audio):
        self.audio, self.end, self.seen = audio, None, False

    def lose(self):
        self.end = None

    def add(self, chunk, key, group):
        """The Packets of an AUDI chunk."""
        first, self.seen = not self.seen, True
        packets = Packets(chunk.payload, self.audio.flags)
        duration, tick = self.audio.duration, group.block.scene.tick
        begin = packets.start + packets.preroll * duration
        last = packets.start + (packets.count - 1) * duration
        rate = self.audio.rate
        demand(first or not key, 4306, "the key flag in a chunk that is not the first")
        demand(first or not packets.preroll, 4306, "pre-roll in a chunk that is not the first")
        demand(self.end is None or packets.start == self.end, 4306, "start after the chunk before")
        demand(Fraction(begin, rate) >= chunk.time * tick, 4306, "start before the time of the chunk")
        demand(Fraction(last, rate) < group.end * tick, 4306, "a packet after the group")
        self.end = packets.start + packets.count * duration
        return packets
