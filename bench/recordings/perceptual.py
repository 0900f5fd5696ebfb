"""How unlike two pictures look to a person who changes between them: FLIP (Andersson and others, "FLIP: A Difference Evaluator for
Alternating Images", 2020), by its authors' package, with their default distance of 67 pixels a degree. 0: alike, 1: black and white."""

import flip_evaluator
import numpy as np

# Pixels around the mask that FLIP's filters reach.
AROUND = 16
GREY = 128


def flip(a, b, mask):
    """The mean over mask, of two pictures (height, width, 3) of 8 bits; everything else is the same grey in both."""
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    box = tuple(slice(max(0, ends[0] - AROUND), ends[-1] + AROUND + 1) for ends in (rows, columns))
    inside = mask[box]
    pictures = [np.where(inside[..., None], p[box], GREY).astype(np.float32) / 255 for p in (a, b)]
    found, _, _ = flip_evaluator.evaluate(*pictures, "LDR", applyMagma=False, computeMeanError=False)
    return float(found[..., 0][inside].mean())
