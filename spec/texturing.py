"""A plain reader of texturing constants, written from clauses 4.1, 5 and 17.5 of spec/fvv.md alone.

Uses nothing of libfvv, so that prose and library are held against each other. The container is taken to be in order.

    python3 spec/texturing.py STREAM.fvv     # of each group: threshold, bias, slope, best, unseen
"""

import math
import pathlib
import struct
import sys
from typing import NamedTuple

import tiles


class Texturing(NamedTuple):
    threshold: float = 0.25
    depth_bias: float = 0.2
    depth_slope: float = 0.5
    best: int = 3
    unseen: tuple = (128, 128, 128)


def decode(payload):
    assert len(payload) == 32, "6101"
    threshold, bias, slope, best, *unseen = struct.unpack_from("<3d4B", payload)
    assert payload[28:] == bytes(4), "6101"
    assert 0 <= threshold <= 1 and best > 0, "6102"
    assert all(math.isfinite(x) and x >= 0 for x in (bias, slope)), "6102"
    return Texturing(threshold, bias, slope, best, tuple(unseen))


def groups(stream):
    """Of each group what its configuration block says, or the defaults."""
    told = None
    for kind, _, payload in tiles.chunks(stream):
        if kind == b"SCEN":
            told = None
        elif kind == b"TEXR":
            assert told is None, "6101"
            told = decode(payload)
        elif kind == b"GRUP":
            yield told or Texturing()


def weights(said, cosines):
    """Of the cameras that show a place, by their cosines: what each one's colour counts. None: the place is unseen."""
    kept = sorted((c for c in cosines.items() if c[1] >= said.threshold), key=lambda c: -c[1])[: said.best]
    total = sum(cosine for _, cosine in kept)
    return {camera: cosine / total for camera, cosine in kept} if total > 0 else None


def lines(stream):
    for number, said in enumerate(groups(stream)):
        numbers = [said.threshold, said.depth_bias, said.depth_slope, said.best, *said.unseen]
        yield " ".join([str(number), *(format(x, "g") for x in numbers)])


if __name__ == "__main__":
    print("\n".join(lines(pathlib.Path(sys.argv[1]).read_bytes())))
