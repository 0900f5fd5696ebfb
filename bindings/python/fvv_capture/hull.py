"""Visual hulls: the largest body whose outlines fit into the masks of all cameras.

A point is inside when no camera, or at most `HullOptions.missed` of them, sees it outside its mask. The work is done by the
library's octree and marching cubes; docs/tools/fvvcapture-hull.md describes them."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Sequence
from typing import Any, Union

import numpy
from fvv import Camera, hulls
from fvv.errors import UsageError
from numpy.typing import ArrayLike, NDArray

Mask = Union[NDArray[Any], None]
#: Lowest and highest corner of a box along the axes of the world, (3,) metres each.
Bounds = tuple[NDArray[numpy.float64], NDArray[numpy.float64]]
#: Pixels that a cell covers when neither cell nor max_error is given.
DEFAULT_ERROR = 4.0


@dataclasses.dataclass(frozen=True)
class HullOptions:
    """How a hull is carved."""

    cell: float | None = None  #: Side of the smallest cells in metres.
    #: The same in pixels, of the camera that is nearest to the bounds. Without both: `DEFAULT_ERROR`.
    max_error: float | None = None
    #: Cameras that may see a point outside their masks although it is inside: masks with holes do not cut the hull.
    missed: int = 0
    #: Cameras that must have a point inside their masks. What fewer see is outside.
    least_views: int = 3
    #: The ground: a vector up, and the height of the ground along it in metres. Nothing below it is inside.
    floor: tuple[ArrayLike, float] | None = None
    #: Components of less than this fraction of the largest one's volume are dropped, cavities are filled; 1: only the
    #: largest one is kept.
    min_share: float = 0.001
    #: Rounds of smoothing (Taubin 1995) that keep vertices on the outlines; 0: none.
    smoothing: int = 0
    #: Pixels by which smoothing may move a vertex off the outlines.
    tolerance: float = 0.5

    def __post_init__(self) -> None:
        for name in ("cell", "max_error"):
            value = getattr(self, name)
            if value is not None and not (value > 0 and math.isfinite(value)):
                raise UsageError(f"{name}: expected a number above 0, found {value}")
        if self.cell is not None and self.max_error is not None:
            raise UsageError("cell: expected either cell or max_error, found both")
        for name, least in (("missed", 0), ("least_views", 1), ("smoothing", 0)):
            if getattr(self, name) < least:
                raise UsageError(f"{name}: expected {least} or more, found {getattr(self, name)}")
        if not 0 <= self.min_share <= 1:
            raise UsageError(f"min_share: expected 0 to 1, found {self.min_share}")
        if not self.tolerance >= 0:
            raise UsageError(f"tolerance: expected 0 or more pixels, found {self.tolerance}")

    def _as_dict(self) -> dict[str, Any]:
        floor = None
        if self.floor is not None:
            up = numpy.asarray(self.floor[0], numpy.float64)
            length = float(numpy.linalg.norm(up)) if up.shape == (3,) else 0.0
            if not (length > 0 and math.isfinite(length) and math.isfinite(self.floor[1])):
                raise UsageError(
                    f"floor: expected a vector up of 3 numbers and a height in metres, found {self.floor}"
                )
            floor = ((up / length).tolist(), float(self.floor[1]))
        return {
            "missed": self.missed,
            "least_views": self.least_views,
            "floor": floor,
            "min_share": self.min_share,
            "smoothing": self.smoothing,
            "tolerance": self.tolerance,
        }


@dataclasses.dataclass(frozen=True)
class Grid:
    """The points at which a hull was sampled, and where its surface crosses the edges between them."""

    origin: NDArray[numpy.float64]  #: (3,) metres, of point (0, 0, 0).
    cell: float  #: Metres between neighbours along each axis.
    counts: tuple[int, int, int]  #: Points along x, y, z. Point (i, j, k) has the number (k * y + j) * x + i.
    occupancy: NDArray[
        numpy.uint8
    ]  #: A bit for each point in the order of numbers, lowest bit first: 1 inside.
    edges: NDArray[
        numpy.uint64
    ]  #: (V,) of each vertex: 3 * the number of a point + axis, to the next point on it.
    offsets: NDArray[numpy.float32]  #: (V,) where on that edge the vertex was before smoothing, 0 to 1.

    def inside(self) -> NDArray[numpy.bool_]:
        """(z, y, x): whether each point is inside."""
        count = self.counts[0] * self.counts[1] * self.counts[2]
        bits = numpy.unpackbits(self.occupancy, count=count, bitorder="little")
        return bits.astype(bool).reshape(self.counts[::-1])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes all fields as arrays of an .npz."""
        fields = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        numpy.savez_compressed(path, **fields)


@dataclasses.dataclass(frozen=True)
class Hull:
    """A closed surface: each edge has two faces, each vertex one fan of them. Without faces when nothing is inside."""

    positions: NDArray[numpy.float64]  #: (V, 3) metres.
    indices: NDArray[numpy.uint32]  #: (F, 3), counter-clockwise seen from outside.
    grid: Grid
    components: int  #: Bodies that are left.
    dropped: int  #: Bodies and cavities that were dropped for min_share.


def _prepared(cameras: Sequence[Camera], masks: Sequence[Mask]) -> tuple[list[Camera], list[Mask]]:
    """What the core takes; it checks numbers and sizes."""
    return list(cameras), [None if mask is None else numpy.ascontiguousarray(mask) for mask in masks]


def _mesh(positions: Any, indices: Any) -> tuple[Any, Any, None, None]:
    return (
        numpy.ascontiguousarray(positions, numpy.float64).reshape(-1, 3),
        numpy.ascontiguousarray(indices, numpy.uint32).reshape(-1, 3),
        None,
        None,
    )


def bounds(
    cameras: Sequence[Camera],
    masks: Sequence[Mask],
    missed: int = 0,
    least_views: int = 3,
    floor: tuple[ArrayLike, float] | None = None,
) -> Bounds:
    """A box around the hull, found from the cameras and masks of one frame alone, in any unit.

    The search begins with a cube around the point nearest to all optical axes that reaches to the farthest camera, and
    carves it coarsely again and again. cameras, masks, and other arguments: as `carve` and `HullOptions` have them.
    `Error` when nothing is inside."""
    options = HullOptions(missed=missed, least_views=least_views, floor=floor)
    low, high = hulls.hull_bounds(*_prepared(cameras, masks), options._as_dict())
    return numpy.array(low), numpy.array(high)


def carve(
    cameras: Sequence[Camera],
    masks: Sequence[Mask],
    bounds: tuple[ArrayLike, ArrayLike] | None = None,
    options: HullOptions | None = None,
) -> Hull:
    """The visual hull of one frame (Laurentini 1994), by octree (Szeliski 1993) and marching cubes.

    masks: one for each camera, uint8 or bool (height, width) of its picture, not 0 inside; None for a camera without one
    in this frame. Cameras may see a part of the scene: outside of their pictures they say nothing. Lenses are taken into
    account. bounds: nothing outside of it is carved; None: as `bounds()` finds it, `Error` when nothing is inside.
    `UsageError` for wrong arguments, and for cells so small that the grid exceeds 2^30 points."""
    options = options or HullOptions()
    corners = None
    if bounds is not None:
        low, high = (numpy.asarray(corner, numpy.float64) for corner in bounds)
        if (
            low.shape != (3,)
            or high.shape != (3,)
            or not (numpy.isfinite([low, high]).all() and (low < high).all())
        ):
            raise UsageError(
                f"bounds: expected a lowest and a highest corner of 3 numbers each, found {bounds}"
            )
        corners = low.tolist(), high.tolist()
    max_error = options.max_error if options.max_error or options.cell else DEFAULT_ERROR
    made = hulls.hull_carve(*_prepared(cameras, masks), corners, options.cell, max_error, options._as_dict())
    grid = Grid(
        numpy.array(made["origin"]),
        made["cell"],
        made["counts"],
        made["occupancy"],
        made["edges"],
        made["offsets"],
    )
    return Hull(made["positions"], made["indices"], grid, made["components"], made["dropped"])


def coverage(positions: ArrayLike, indices: ArrayLike, camera: Camera) -> NDArray[numpy.uint8]:
    """(height, width) of the camera's picture: 255 where the mesh covers the centre of a pixel, else 0.

    positions: (V, 3) metres; indices: (F, 3). Faces count from both sides."""
    return hulls.coverage(_mesh(positions, indices), camera)


def silhouette_iou(
    positions: ArrayLike, indices: ArrayLike, cameras: Sequence[Camera], masks: Sequence[Mask]
) -> list[float | None]:
    """For each camera the intersection over union of its mask and what the mesh covers; None for a camera without a mask,
    and when both are empty."""
    return hulls.silhouette_iou(_mesh(positions, indices), *_prepared(cameras, masks))
