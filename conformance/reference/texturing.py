"""Texturing constants: clause 17.5 of spec/fvv.md."""

import math
import struct
from typing import NamedTuple

from .container import chunks, demand


class Texturing(NamedTuple):
    threshold: float = 0.25
    depth_bias: float = 0.2
    depth_slope: float = 0.5
    best: int = 3
    unseen: tuple = (128, 128, 128)


def decode(payload):
    demand(len(payload) == 32, 6101, "size")
    threshold, bias, slope, best, *unseen = struct.unpack_from("<3d4B", payload)
    demand(payload[28:] == bytes(4), 6101, "reserved bytes")
    demand(0 <= threshold <= 1 and best > 0, 6102, "threshold, or number of cameras")
    demand(all(math.isfinite(x) and x >= 0 for x in (bias, slope)), 6102, "bias or slope")
    return Texturing(threshold, bias, slope, best, tuple(unseen))


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


def weights(constants, cosines):
    """The weight of each camera's colour at a place, by the cosines of those that show it. None: the place is unseen."""
    kept = sorted((c for c in cosines.items() if c[1] >= constants.threshold), key=lambda c: -c[1])
    kept = kept[: constants.best]
    total = sum(cosine for _, cosine in kept)
    return {camera: cosine / total for camera, cosine in kept} if total > 0 else None


def listing(stream):
    """A line for each group: its number, threshold, bias, slope, best, unseen."""
    for number, c in enumerate(groups(stream)):
        numbers = [c.threshold, c.depth_bias, c.depth_slope, c.best, *c.unseen]
        yield " ".join([str(number), *(format(x, "g") for x in numbers)])
