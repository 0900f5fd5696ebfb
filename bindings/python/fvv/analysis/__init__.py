"""What is where in a frame: picks of the surface, objects over time, and measurements with their uncertainty.

The rules are those of `@fvv/analysis` for JavaScript, and tests hold both to the same cases. Uncertainties are half of the width of
the interval that holds the true value in 95 of 100 cases. What is not known to be right to some figure is None.
"""

from __future__ import annotations

from .measure import (
    Floor,
    Measurement,
    MeshError,
    Motion,
    Point,
    angle,
    centre,
    distance,
    floor,
    height,
    motion,
    path,
    point,
)
from .objects import ObjectPaths
from .surface import Pick, Piece, pick, pieces

__all__ = [
    "Floor",
    "Measurement",
    "MeshError",
    "Motion",
    "ObjectPaths",
    "Pick",
    "Piece",
    "Point",
    "angle",
    "centre",
    "distance",
    "floor",
    "height",
    "motion",
    "path",
    "pick",
    "pieces",
    "point",
]
