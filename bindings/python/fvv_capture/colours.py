"""Colour models of a subject and of the background near each place, learnt from a clip."""

from __future__ import annotations

import numpy

from .arrays import Flags, Floats, Picture

BINS = 16
# Square roots: dark colours differ by few levels.
ROOTS = (numpy.sqrt(numpy.arange(256) / 256) * BINS).astype(numpy.int32)
#: Cells along the longer side of a picture; each has a model of the background around it.
CELLS = 20
#: Samples that a model of the background around a cell needs before it is believed alone.
ENOUGH = 1500
FLOOR = 1e-5


def _bins(colour: Picture) -> Floats:
    index = ROOTS[colour]
    bins: Floats = (index[..., 0] * BINS + index[..., 1]) * BINS + index[..., 2]
    return bins


def _table(colours: Picture) -> Floats:
    """Probability of each bin, (4096,), smoothed over neighbouring bins."""
    cube = numpy.bincount(_bins(colours).ravel(), minlength=BINS**3).reshape(BINS, BINS, BINS)
    cube = cube.astype(numpy.float32)
    for axis in range(3):
        padded = numpy.pad(cube, [(1, 1) if a == axis else (0, 0) for a in range(3)], mode="edge")
        low, high = numpy.take(padded, range(BINS), axis), numpy.take(padded, range(2, BINS + 2), axis)
        cube = 0.25 * low + 0.5 * cube + 0.25 * high
    table: Floats = (cube / max(float(cube.sum()), 1e-9)).ravel()
    return table


class ColourModel:
    """How much more a colour is the subject's than that of the background around a place.

    Both are histograms over the square roots of levels. The background's are taken in cells: a colour that is far away in the
    picture says little about a place.
    """

    def __init__(self, subject: Picture, background: Picture, seen: Flags) -> None:
        """subject: (n, 3) RGB of the subject, n > 0; background: (height, width, 3), believed where `seen` (height, width)."""
        h, w = seen.shape
        self._cell = -(-max(h, w) // CELLS)
        wanted = _table(subject)
        everywhere = (
            _table(background[seen]) if seen.any() else numpy.full(BINS**3, BINS**-3.0, numpy.float32)
        )
        rows, columns = -(-h // self._cell), -(-w // self._cell)
        self._log = numpy.empty((rows, columns, BINS**3), numpy.float32)
        margin = 2 * self._cell
        for row in range(rows):
            for column in range(columns):
                top, left = row * self._cell, column * self._cell
                area = (
                    slice(max(0, top - margin), top + self._cell + margin),
                    slice(max(0, left - margin), left + self._cell + margin),
                )
                near = background[area][seen[area]]
                part = 0.8 * min(1.0, len(near) / ENOUGH)
                table = part * _table(near) + (1 - part) * everywhere if len(near) else everywhere
                self._log[row, column] = numpy.log(wanted + FLOOR) - numpy.log(table + FLOOR)

    def ratio(self, colours: Picture) -> Floats:
        """log p(colour | subject) / p(colour | background nearby) of colours (..., height, width, 3): (..., height, width)."""
        h, w = colours.shape[-3:-1]
        rows = (numpy.arange(h) // self._cell)[:, None]
        columns = (numpy.arange(w) // self._cell)[None, :]
        ratio: Floats = self._log[rows, columns, _bins(colours)]
        return ratio
