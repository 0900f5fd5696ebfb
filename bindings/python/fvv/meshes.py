"""Meshes from arrays, and their decimation."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any, Union

import numpy
from numpy.typing import NDArray

from . import _core
from ._core import Camera, Mesh
from .errors import UsageError
from .options import current_name

Array = NDArray[Any]
#: positions, indices, and normals and uvs or None.
MeshArrays = tuple[Array, Array, Union[Array, None], Union[Array, None]]
#: A `Mesh`, a tuple (positions, indices[, normals[, uvs]]), or an object with `vertices` and `faces`, such as a mesh of
#: trimesh. positions: (vertices, 3) metres; indices: (faces, 3), counter-clockwise seen from outside; normals:
#: (vertices, 3) of any length; uvs: (vertices, 2), (0, 0) at the top left corner of the atlas.
MeshLike = Any


def _contiguous(values: Any, name: str, columns: int, kinds: str, wide: str) -> Array:
    """values as an array that the core reads: contiguous, in native byte order, narrow types widened."""
    try:
        array = numpy.asarray(values)
    except ValueError as error:
        raise UsageError(f"{name}: expected an array of shape (..., {columns}): {error}") from None
    if not array.size:
        return numpy.zeros((0, columns), wide)
    if array.dtype.kind in kinds:
        narrow = array.dtype.itemsize < 4 or (array.dtype.kind == "f" and array.dtype.itemsize > 8)
        array = array.astype(wide) if narrow else array.astype(array.dtype.newbyteorder("="), copy=False)
    return numpy.ascontiguousarray(array)


def mesh_arrays(mesh: MeshLike, where: str) -> Mesh | MeshArrays:
    """What the core takes. Types and shapes are checked there. where begins messages."""
    if isinstance(mesh, Mesh):
        return mesh
    if isinstance(mesh, (tuple, list)) and 2 <= len(mesh) <= 4:
        parts = [*mesh, None, None]
    elif not isinstance(mesh, (tuple, list)) and hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        parts = [mesh.vertices, mesh.faces, None, None]
    else:
        raise UsageError(
            f"{where}: expected an fvv.Mesh, (positions, indices[, normals[, uvs]]) or an object with vertices and "
            f"faces, found {type(mesh).__name__}"
        )

    def floats(values: Any, name: str, columns: int) -> Array:
        # Integers are fine as coordinates: they are exact as float64.
        array = numpy.asarray(values) if not isinstance(values, numpy.ndarray) else values
        if array.dtype.kind in "iu":
            array = array.astype("float64")
        return _contiguous(array, f"{where}: {name}", columns, "f", "float64")

    try:
        return (
            floats(parts[0], "positions", 3),
            _contiguous(parts[1], f"{where}: indices", 3, "iu", "int64"),
            None if parts[2] is None else floats(parts[2], "normals", 3),
            None if parts[3] is None else floats(parts[3], "uvs", 2),
        )
    except ValueError as error:
        if isinstance(error, UsageError):
            raise
        raise UsageError(f"{where}: {error}") from None


@dataclasses.dataclass(frozen=True)
class Decimated:
    """What `fvv.decimate` made of a mesh."""

    positions: NDArray[numpy.float64]  #: (vertices, 3) metres.
    indices: NDArray[numpy.uint32]  #: (faces, 3)
    normals: NDArray[numpy.float64] | None  #: (vertices, 3), those of the source.
    uvs: NDArray[numpy.float64] | None  #: (vertices, 2), likewise.
    vertices: NDArray[numpy.uint32]  #: (vertices,): the vertex of the source that each comes from.
    unchanged: bool  #: The error allows no fewer faces: it is the source.
    rms: float  #: Metres between the surfaces, by area, in the worse direction.
    max: float  #: Metres, at the worst place.
    rms_pixels: float | None  #: The same in pixels of the cameras; None: there are none.
    max_pixels: float | None  #: At the worst place.

    def mesh(self) -> tuple[Array, Array, Array | None, Array | None]:
        """What `Writer.add` takes."""
        return self.positions, self.indices, self.normals, self.uvs


def decimate(
    mesh: MeshLike,
    max_error: str | float | None = None,
    *,
    triangles: int | None = None,
    cameras: Iterable[Camera] = (),
    scale: float = 1,
    step: float | None = None,
    min_component: int = 0,
    budget: str | float | None = None,
) -> Decimated:
    """As few triangles as an error allows, as `fvvmux` decimates (docs/encoding/budget.md).

    max_error: rms distance between the surfaces: pixels of the cameras ("0.15px" or 0.15), at the camera that sees a place
    sharpest, or a length ("1mm"). triangles: how many to aim at, at any error, in place of an error.
    scale: of the pictures that are sent, times those of the cameras. step: metres, of the lattice that positions are
    rounded to later, which counts as an error too; None: none. min_component: pieces with fewer faces are dropped.
    budget: the former name of max_error.

    Raises `UsageError` for a mesh with indices out of range, coordinates that are not finite, or no faces.
    """
    if budget is not None and max_error is None:
        current_name("budget", stacklevel=2)
        max_error = budget
    if (max_error is None) == (triangles is None):
        raise UsageError("decimate: expected either max_error or triangles")
    if not 0 < scale <= 1:
        raise UsageError(f"scale: expected a number above 0 and at most 1, found {scale}")
    if step is not None and not 0 < step < float("inf"):
        raise UsageError(f"step: expected metres above 0, found {step}")
    if not 0 <= min_component < 1 << 32:
        raise UsageError(f"min_component: expected 0 to 4294967295, found {min_component}")
    text = None if max_error is None else str(max_error)
    found = _core.decimate(
        mesh_arrays(mesh, "mesh"), text, triangles, list(cameras), scale, step, min_component
    )
    return Decimated(**found)
