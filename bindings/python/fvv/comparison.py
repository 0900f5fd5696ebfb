"""How far two sequences of meshes are apart."""

from __future__ import annotations

import dataclasses
import operator
import os
from collections.abc import Callable, Sequence
from typing import Any, Generic, TypeVar, Union

import numpy

from . import _core
from ._core import Mesh
from .clip import Clip
from .errors import UsageError
from .meshes import mesh_arrays

Value = TypeVar("Value")
#: (positions, indices[, normals[, uvs]]): (vertices, 3) numbers, (faces, 3) vertices, (vertices, 3) or None, (vertices, 2) or None: these do not count.
Arrays = Sequence[Any]
#: A path of a stream, a capture.json or its folder; a clip; a mesh; or a list of meshes, one for each frame.
Comparable = Union[str, "os.PathLike[str]", Clip, Mesh, Arrays, Sequence[Union[Mesh, Arrays]]]


@dataclasses.dataclass(frozen=True)
class Ways(Generic[Value]):
    """From A to B, from B to A, and the worse of the two."""

    a_to_b: Value
    b_to_a: Value
    symmetric: Value


@dataclasses.dataclass(frozen=True)
class Figures:
    """Of distances in the unit of the comparison, or of angles in degrees."""

    rms: float
    mean: float
    p99: float
    max: float  #: Of distances the Hausdorff distance.


@dataclasses.dataclass(frozen=True)
class PointError:
    """Mean squared error, and PSNR for the peak of the comparison: infinite for equal sets."""

    mse: float
    psnr: float  #: Decibels.


@dataclasses.dataclass(frozen=True)
class Errors:
    """The figures that docs/tools/fvvcompare.md defines."""

    distance: Ways[Figures]  #: Point to surface.
    d1: Ways[PointError]  #: Point to point.
    d2: Ways[PointError]  #: Point to plane.
    normals: Ways[Figures]  #: Degrees between smooth normals.
    turned: Ways[float]  #: Share of samples where the other surface shows its other side, 0 to 1.


@dataclasses.dataclass(frozen=True)
class Compared:
    """A frame of one of the sequences."""

    frame: int  #: Its number.
    vertices: int
    faces: int


@dataclasses.dataclass(frozen=True)
class Motion:
    """Of a frame against the one before: the difference of the vertices' motions."""

    rms: float
    max: float
    motion: float  #: rms motion of A, to compare with.


@dataclasses.dataclass(frozen=True)
class FrameComparison(Errors):
    """A pair of frames."""

    a: Compared
    b: Compared
    temporal: Motion | None  #: None: the faces change, or it is the first frame.


@dataclasses.dataclass(frozen=True)
class Temporal(Motion):
    """Of all pairs of frames that follow each other while neither sequence changes its faces."""

    pairs: int
    by_order: int  #: Of these: pairs whose vertices have one order; others are matched by nearness.
    furthest_match: float  #: Distance of vertices that were matched by nearness.


@dataclasses.dataclass(frozen=True)
class Comparison(Errors):
    """What `fvv.compare` found, over all frames that were compared."""

    frames_a: int  #: Frames of A that have a mesh.
    frames_b: int  #: The same of B.
    unit: str  #: "metres", or "unknown": units of the source.
    peak: float  #: Of PSNR, in the unit.
    temporal: Temporal | None  #: None: no two frames have constant faces.
    frames: tuple[FrameComparison, ...]  #: Those that were compared.
    losses: tuple[str, ...]  #: A line for each frame that could not be compared.
    warnings: tuple[str, ...]  #: Frames without a partner, damage.


def compare(
    a: Comparable,
    b: Comparable,
    frames: int | range | None = None,
    *,
    start: int | None = None,
    samples: int = 50000,
    points: str = "vertices",
    peak: float | None = None,
    threads: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Comparison:
    """Measures how far b is from a, with the figures of `fvvcompare` (docs/tools/fvvcompare.md).

    a, b: a path of a stream, a capture.json or its folder; an open clip; a mesh, or a list of meshes, as `fvv.Mesh` or
    (positions, indices[, normals[, uvs]]). Meshes in memory are numbered from 0, and have the unit and the frame rate of the other.
    frames: numbers of a; None: all. start: the number of a that the first frame of b shows.
    samples: points of each surface and frame, besides its vertices.
    points: where D1 and D2 are taken: "vertices", or "samples", which means both.
    peak: of PSNR, in the unit; None: the diagonal of a's bounding box.
    threads: None: one for each processor. The figures are the same.
    progress: called with the number of pairs of frames that are done, and of all.

    The GIL is released. Raises OSError, `UsageError` for arguments, and `DamagedError` when nothing can be compared.
    """
    if samples < 1 or samples > 100_000_000:
        raise UsageError(f"samples: expected 1 to 100000000, found {samples}")
    if points not in ("vertices", "samples"):
        raise UsageError(f"points: expected vertices or samples, found {points}")
    if peak is not None and not 0 < peak < float("inf"):
        raise UsageError(f"peak: expected a number above 0, found {peak}")
    if threads is not None and not 1 <= threads <= 256:
        raise UsageError(f"threads: expected 1 to 256, found {threads}")
    found = _core.compare(
        _given("a", a), _given("b", b), _numbers(frames), start, samples, points == "samples", peak, threads or 0, progress
    )  # fmt: skip
    temporal = found["temporal"]
    return Comparison(
        **_errors(found),
        frames_a=found["frames_a"],
        frames_b=found["frames_b"],
        unit="unknown" if found["scale_unknown"] else "metres",
        peak=found["peak"],
        temporal=None if temporal is None else Temporal(**temporal),
        frames=tuple(_frame(frame) for frame in found["frames"]),
        losses=found["losses"],
        warnings=found["warnings"],
    )


def _frame(found: dict[str, Any]) -> FrameComparison:
    temporal = found["temporal"]
    return FrameComparison(
        **_errors(found),
        a=Compared(**found["a"]),
        b=Compared(**found["b"]),
        temporal=None if temporal is None else Motion(**temporal),
    )


def _errors(found: dict[str, Any]) -> dict[str, Any]:
    def ways(name: str, kind: Callable[..., Any]) -> Ways[Any]:
        return Ways(**{way: kind(**figures) for way, figures in found[name].items()})

    return {
        "distance": ways("distance", Figures),
        "d1": ways("d1", PointError),
        "d2": ways("d2", PointError),
        "normals": ways("normals", Figures),
        "turned": Ways(**found["turned"]),
    }


def _numbers(frames: int | range | None) -> tuple[int, int] | None:
    if frames is None:
        return None
    if not isinstance(frames, range):
        frames = range(operator.index(frames), operator.index(frames) + 1)
    if frames.step != 1 or not frames or frames[0] < 0 or frames[-1] > 2**31 - 1:
        raise UsageError(
            f"frames: expected a number, or a range with step 1 of numbers from 0, found {frames}"
        )
    return frames[0], frames[-1]


def _given(argument: str, value: Comparable) -> Any:
    if isinstance(value, Clip):
        return value._stream
    if isinstance(value, (str, os.PathLike)):
        os.stat(value)  # for the usual exceptions
        return os.fspath(value)
    if isinstance(value, Mesh) or _is_arrays(value):
        value = [value]
    try:
        meshes = list(value)
    except TypeError:
        meshes = []
    if not meshes or not all(isinstance(mesh, Mesh) or _is_arrays(mesh) for mesh in meshes):
        raise UsageError(
            f"{argument}: expected a path, a clip, an fvv.Mesh, (positions, indices), or a list of these"
        )
    return [mesh_arrays(mesh, argument) for mesh in meshes]


def _is_arrays(value: Any) -> bool:
    """Whether it is (positions, indices[, normals[, uvs]]): its first item is a table of numbers, which no mesh is."""
    if not isinstance(value, (tuple, list)) or not 2 <= len(value) <= 4:
        return False
    return not isinstance(value[0], (Mesh, tuple)) and len(numpy.shape(value[0])) == 2
