"""Lengths, angles and speeds, each with its uncertainty."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Union

import numpy
from numpy.typing import ArrayLike

from ..errors import UsageError
from ..frames import Frame
from .objects import ObjectPaths, Vector, is_number, metadata_of
from .surface import Pick, cast, local_points, origin_of, pieces, unit

_SIGMAS = 1.96
_LEAST_FACING = 0.15  # where a ray runs along the surface, a shift of that moves what it meets by more
_CENTRE_PART = 0.5  # of the deviation of a surface: that of its centre


@dataclasses.dataclass(frozen=True)
class Measurement:
    """A value that is known to within its uncertainty."""

    value: float  #: In the unit of the function that returns it.
    uncertainty: float  #: In the same unit.


@dataclasses.dataclass(frozen=True)
class Point:
    """A place that is known to within its uncertainty."""

    position: ArrayLike  #: (3,) metres.
    uncertainty: float  #: Metres.


@dataclasses.dataclass(frozen=True)
class Floor:
    """A level plane."""

    up: Vector  #: (3,) unit vector.
    level: float  #: Metres along up.
    uncertainty: float  #: Metres.


@dataclasses.dataclass(frozen=True)
class Motion:
    """Of a point at one time."""

    seconds: float  #: When.
    velocity: Vector  #: (3,) metres a second.
    speed: Measurement  #: Metres a second.
    acceleration: Measurement  #: Metres a second squared.


def _is_stated(value: object) -> bool:
    if not isinstance(value, dict) or "vertex" not in value:
        return False
    return all(is_number(x) and x >= 0 for x in (value.get(key, 0) for key in ("vertex", "pixels", "metres")))


@dataclasses.dataclass(frozen=True)
class MeshError:
    """How exact the meshes of a stream are, as it says (the key `mesh_error` of META)."""

    vertex: float  #: Metres on each axis, the most that a vertex is off.
    pixels: (
        float | None
    )  #: rms between the surfaces, at the camera that sees a place sharpest; None: not decimated so.
    metres: float | None  #: The same as a length.

    @classmethod
    def of(cls, metadata: Sequence[str]) -> MeshError | None:
        """Of the texts of META; None: they do not say."""
        stated = metadata_of(metadata, "mesh_error", _is_stated)
        return cls(stated["vertex"], stated.get("pixels"), stated.get("metres")) if stated else None


def _pixel(frame: Frame, position: Vector) -> float | None:
    """Metres that a pixel of the transmitted pictures covers at a place, of the camera that sees it sharpest."""
    scales = {}
    for key in frame.pictures:
        picture = frame.pictures[key]
        scales[key] = picture.pixels.shape[1] / picture.source[2]
    least = math.inf
    for key in frame.cameras:
        camera = frame.cameras[key]
        x, y = camera.project(position)
        scale = scales.get(camera.id) if scales else 1.0
        if scale and 0 <= x < camera.width and 0 <= y < camera.height:
            sharpest = max(float(camera.K[0, 0]), float(camera.K[1, 1]))
            least = min(least, float(camera.depth(position)) / (sharpest * scale))
    return least if least < math.inf else None


def _deviation(frame: Frame, position: ArrayLike) -> float | None:
    """How far meshes are off what they were made from at a place: a standard deviation in metres."""
    stated = MeshError.of(frame._description.metadata)
    if stated is None:
        return None
    if stated.metres is not None:
        return stated.metres
    if stated.pixels is None:
        return stated.vertex / math.sqrt(3)
    pixel = _pixel(frame, numpy.asarray(position, numpy.float64))
    return None if pixel is None else stated.pixels * pixel


def _bulge(frame: Frame, picked: Pick) -> float | None:
    """By how much a hull is larger than the body at a place, at most; the body is taken to be round."""
    mesh = frame.meshes[picked.track]
    behind = cast(
        local_points(mesh),
        mesh.indices,
        picked.position - origin_of(mesh),
        -picked.normal,
        leave_out=picked.face,
    )
    if behind is None:
        return None
    slant = 1.0
    for key in frame.cameras:
        ray = unit(frame.cameras[key].centre - picked.position)
        if ray is not None:
            slant = min(slant, abs(float(ray @ picked.normal)))
    along = math.sqrt(1 - slant * slant)
    return min(behind[1], behind[1] / 2 * (1 / along - 1)) if along > 0 else behind[1]


def point(frame: Frame, picked: Pick, *, hull: bool = False) -> Point | None:
    """A pick with its uncertainty, from what the stream says of its meshes; None: it says nothing, or no camera sees the place.

    hull: the meshes are visual hulls; by how much they bulge is estimated from the directions of the cameras.
    """
    deviation = _deviation(frame, picked.position)
    bulge = _bulge(frame, picked) if hull else 0.0
    if deviation is None or bulge is None:
        return None
    along = max(picked.facing, _LEAST_FACING)
    return Point(picked.position, math.hypot(_SIGMAS * deviation, bulge) / along)


def centre(frame: Frame, identifier: int) -> Point | None:
    """The centre of an object; None: it is not there, touches others, is in several pieces, or its uncertainty is unknown."""
    found = [piece for piece in pieces(frame) if identifier in piece.objects]
    if len(found) != 1 or len(found[0].objects) != 1:
        return None
    deviation = _deviation(frame, found[0].centre)
    return None if deviation is None else Point(found[0].centre, _CENTRE_PART * _SIGMAS * deviation)


def path(frame: Frame, identifier: int) -> dict[int, Point | None]:
    """Ticks, and the centre of an object over the whole stream, by the path that the stream gives, without decoding.

    frame: any, for what its cameras see. None in place of a point where the object touches others; empty: the stream names no
    objects, or nothing is known of their uncertainty.
    """
    objects = ObjectPaths.of(frame._description.metadata)
    points: dict[int, Point | None] = {}
    if objects is None:
        return points
    for ticks, place in objects.path(identifier).items():
        deviation = _deviation(frame, place)
        if deviation is None:
            return {}
        uncertainty = math.hypot(_CENTRE_PART * _SIGMAS * deviation, _SIGMAS * objects.rounding)
        points[ticks] = Point(place, uncertainty) if len(objects.together(identifier, ticks)) == 1 else None
    return points


def _way(a: Point, b: Point) -> Vector:
    return numpy.asarray(b.position, numpy.float64) - numpy.asarray(a.position, numpy.float64)


def distance(a: Point, b: Point) -> Measurement:
    """Metres between two points."""
    return Measurement(float(numpy.linalg.norm(_way(a, b))), math.hypot(a.uncertainty, b.uncertainty))


def angle(at: Point, a: Point, b: Point) -> Measurement | None:
    """Degrees between two points as seen from a third one; None: one of them is as near to it as they are uncertain."""
    one, other = _way(at, a), _way(at, b)
    sizes = [float(numpy.linalg.norm(one)), float(numpy.linalg.norm(other))]
    if any(size <= math.hypot(p.uncertainty, at.uncertainty) for size, p in zip(sizes, (a, b))):
        return None
    cosine = float(one @ other) / (sizes[0] * sizes[1])
    parts = [a.uncertainty / sizes[0], b.uncertainty / sizes[1], *(at.uncertainty / size for size in sizes)]
    spread = math.sqrt(sum(x * x for x in parts))
    return Measurement(math.degrees(math.acos(max(-1.0, min(1.0, cosine)))), math.degrees(spread))


def floor(frame: Frame) -> Floor | None:
    """The plane through the lowest place of the meshes; None: up or the uncertainty is unknown, or there is no mesh."""
    name = frame._description.up
    if name is None:
        return None
    up = numpy.array([(-1.0 if name[0] == "-" else 1.0) * (axis == name[-1]) for axis in "xyz"])
    lowest: tuple[float, Vector] | None = None
    for mesh in frame.meshes.values():
        used = local_points(mesh)[numpy.unique(mesh.indices)] + origin_of(mesh)
        if len(used):
            place = used[int((used @ up).argmin())]
            if lowest is None or float(place @ up) < lowest[0]:
                lowest = (float(place @ up), place)
    deviation = _deviation(frame, lowest[1]) if lowest else None
    return Floor(up, lowest[0], _SIGMAS * deviation) if lowest and deviation is not None else None


def height(of: Point, over: Floor) -> Measurement:
    """Metres of a point over a floor."""
    value = float(numpy.asarray(of.position, numpy.float64) @ over.up) - over.level
    return Measurement(value, math.hypot(of.uncertainty, over.uncertainty))


def _student(freedom: int) -> float:
    """Student's t for 95 of 100, within 0.02 from 4 degrees of freedom on."""
    return _SIGMAS + 2.37 / freedom + 2.8 / freedom**2


#: Seconds and where a point is then; None: it is not known.
Sample = Union[tuple[float, Point], None]


def motion(samples: Sequence[Sample], around: int = 2) -> list[Motion | None]:
    """Speed and acceleration of a point over time, by the parabola that fits best around each sample.

    around: how many samples before and after each are used. None where one of them is missing. Uncertainties contain how
    badly the parabola fits: they are large where a ball bounces.
    """
    if around < 2:
        raise UsageError(f"around: expected an integer of 2 or more, found {around}")
    out: list[Motion | None] = []
    for i in range(len(samples)):
        used = [one for one in samples[max(0, i - around) : i + around + 1] if one is not None]
        out.append(_parabola(used, around) if len(used) == 2 * around + 1 else None)
    return out


def _parabola(samples: list[tuple[float, Point]], middle: int) -> Motion | None:
    seconds = numpy.array([time for time, _ in samples]) - samples[middle][0]
    powers = seconds[:, None] ** numpy.arange(3)
    normal = powers.T @ powers
    if not abs(numpy.linalg.det(normal)) > 0:
        return None
    inverse = numpy.linalg.inv(normal)
    places = numpy.array([numpy.asarray(p.position, numpy.float64) for _, p in samples])
    values = places - places[middle]
    fit = inverse @ powers.T @ values
    freedom = 3 * (len(samples) - 3)
    squares = float(((values - powers @ fit) ** 2).sum())
    spread = max(max(p.uncertainty for _, p in samples), _student(freedom) * math.sqrt(squares / freedom))
    return Motion(
        samples[middle][0],
        fit[1],
        Measurement(float(numpy.linalg.norm(fit[1])), spread * math.sqrt(inverse[1, 1])),
        Measurement(float(numpy.linalg.norm(2 * fit[2])), 2 * spread * math.sqrt(inverse[2, 2])),
    )
