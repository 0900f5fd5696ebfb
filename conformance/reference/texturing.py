"""Texturing constants: clause 17.5 of spec/fvv.md."""

import math
import struct
from typing import NamedTuple

from .container import chunks, demand


class Texturing(NamedTuple):
    threshold: float = 0.05
    depth_bias: float = 0.2
    depth_slope: float = 0.5
    inset: float = 0.0
    best: int = 3
    unseen: tuple = (128, 128, 128)
    blend: int = 0


def decode(payload):
    demand(len(payload) >= 40, 6101, "size")
    threshold, bias, slope, inset, best, *unseen, blend = struct.unpack_from("<4d5B", payload)
    demand(payload[37:40] == bytes(3), 6101, "reserved bytes")
    demand(0 <= threshold <= 1 and best > 0, 6102, "threshold, or number of cameras")
    demand(blend < 2, 6102, "blend")
    demand(all(math.isfinite(x) and x >= 0 for x in (bias, slope, inset)), 6102, "bias, slope or inset")
    return Texturing(threshold, bias, slope, inset, best, tuple(unseen), blend)


def groups(stream):
    """Yields for each group the constants of its configuration block, or the defaults."""
    explicit = None
    for chunk in chunks(stream):
        if chunk.kind == b"SCEN":
            explicit = None
        elif chunk.kind == b"TEXR":
            demand(explicit is None, 6101, "a second TEXR")
            explicit = decode(chunk.payload)
        elif chunk.kind == b"GRUP":
            yield explicit or Texturing()


def place(constants, point, normal, viewer):
    """Where cameras show a point of the surface; normal and the direction to the viewer have unit length."""
    along = constants.inset / max(sum(n * e for n, e in zip(normal, viewer)), 0.5)
    return tuple(p - along * e for p, e in zip(point, viewer))


class Sight(NamedTuple):
    """How a camera stands to a place that it shows: the cosines of the angles between the direction to it and the normal, and
    the viewer; its visibility weight there, 0 to 255; and the pixels of its tile to the nearest border of the tile."""

    facing: float
    direction: float = 1.0
    seen: float = 255.0
    border: float = math.inf


def weight_of(constants, sight):
    """The weight of one camera, before the best are chosen."""
    if sight.border < 0.5 or sight.seen < 127.5:
        return 0.0
    if constants.blend == 1:
        return sight.facing if sight.facing >= constants.threshold else 0.0
    if sight.facing <= constants.threshold:
        return 0.0
    facing = (sight.facing - constants.threshold) / (1 - constants.threshold)
    seen = (sight.seen - 127.5) / 127.5
    border = min(1.0, (sight.border - 0.5) / 8)
    return facing * seen * border / (1.01 - sight.direction) ** 2


def weights(constants, sights):
    """The weight of each camera's colour at a place, by the Sight of those that show it. None: the place is unseen."""
    all_of_them = {camera: weight_of(constants, sight) for camera, sight in sights.items()}
    order = sorted((w for w in all_of_them.items() if w[1] > 0), key=lambda w: -w[1])
    kept, others = order[: constants.best], order[constants.best :]
    less = others[0][1] * 1023 / 1024 if others and constants.blend == 0 else 0.0
    total = sum(weight - less for _, weight in kept)
    return {camera: (weight - less) / total for camera, weight in kept} if kept else None


def listing(stream):
    """A line for each group: its number, threshold, bias, slope, inset, best, unseen, blend."""
    for number, c in enumerate(groups(stream)):
        numbers = [c.threshold, c.depth_bias, c.depth_slope, c.inset, c.best, *c.unseen, c.blend]
        yield " ".join([str(number), *(format(x, "g") for x in numbers)])
