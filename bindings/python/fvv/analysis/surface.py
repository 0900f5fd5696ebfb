"""What a ray meets, and the pieces of meshes."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy
from numpy.typing import ArrayLike, NDArray

from .._core import Mesh
from ..errors import UsageError
from ..frames import Frame
from .objects import ObjectPaths, Vector

_EDGE = 1e-9  # by so much barycentric coordinates may be below 0
_OWN_SURFACE = 1e-4  # of the way to a camera: what is nearer does not hide the point
_APART = 1.01  # weights fall with the square of this less the cosine between the rays to camera and viewer


@dataclasses.dataclass(frozen=True)
class Pick:
    """What a ray meets first."""

    time: int  #: Ticks.
    frame: int  #: The frame's number.
    track: int  #: The mesh track.
    position: Vector  #: (3,) metres, in the coordinates of the stream.
    normal: Vector  #: (3,) of the face, outwards by its winding.
    face: int  #: Row of `Mesh.indices`.
    barycentric: Vector  #: (3,) weights of the corners of the face; together 1.
    distance: float  #: Metres from the origin of the ray.
    facing: float  #: Cosine of the angle between the ray and the normal, either way.
    object: int | None  #: The identifier of the object; None: none, or several.
    touching: tuple[int, ...]  #: Those of the objects that the piece is, if they are several.
    camera: int | None  #: The camera that gives most of the colour there for a viewer at the ray's origin.


@dataclasses.dataclass(frozen=True)
class Piece:
    """Faces of a mesh that share vertices; vertices at one place are one."""

    objects: tuple[int, ...]  #: Identifiers of the objects that it is: one, several that touch, or none.
    centre: Vector  #: (3,) metres: of its surface, by area.
    area: float  #: Square metres.
    radius: float  #: Metres from the centre to the furthest corner.
    faces: NDArray[numpy.intp]  #: Rows of `Mesh.indices`.
    track: int  #: The mesh track.


def local_points(mesh: Mesh) -> Vector:
    """Positions from the mesh's own origin, in doubles."""
    return numpy.asarray(mesh.step * mesh.lattice.astype(numpy.float64))


def origin_of(mesh: Mesh) -> Vector:
    return numpy.asarray(mesh.origin, numpy.float64)


def cast(
    points: Vector,
    faces: NDArray[Any],
    origin: Vector,
    direction: Vector,
    least: float = 0,
    most: float = math.inf,
    leave_out: int = -1,
) -> tuple[int, float, float, float] | None:
    """The first face on a ray, its distance in lengths of direction, and the weights of its second and third corner."""
    if not len(faces):
        return None
    a = points[faces[:, 0]]
    b = points[faces[:, 1]] - a
    c = points[faces[:, 2]] - a
    p = numpy.cross(direction, c)
    volume = (b * p).sum(axis=1)
    with numpy.errstate(divide="ignore", invalid="ignore"):
        t = origin - a
        u = (t * p).sum(axis=1) / volume
        q = numpy.cross(t, b)
        v = (q @ direction) / volume
        distance = (c * q).sum(axis=1) / volume
        met = (volume != 0) & (u >= -_EDGE) & (v >= -_EDGE) & (u + v <= 1 + _EDGE)
        met &= (distance >= least) & (distance <= most)
    if leave_out >= 0:
        met[leave_out] = False
    if not met.any():
        return None
    face = int(numpy.where(met, distance, math.inf).argmin())
    return face, float(distance[face]), float(u[face]), float(v[face])


def unit(vector: ArrayLike) -> Vector | None:
    array = numpy.asarray(vector, numpy.float64)
    size = float(numpy.linalg.norm(array))
    return array / size if size > 0 else None


def pick(
    frame: Frame, origin: ArrayLike, direction: ArrayLike, *, blend: str = "viewer", threshold: float = 0.05
) -> Pick | None:
    """What a ray meets first of the meshes of a frame, from either side; None: nothing.

    origin, direction: in the coordinates of the stream; the direction has any length. blend, threshold: by which players weight
    cameras (clause 17.5 of the format), for `Pick.camera`; the defaults are those of streams that say nothing.

    Raises `UsageError` for a ray that has no direction, or numbers that are not finite.
    """
    start, along = numpy.asarray(origin, numpy.float64), unit(direction)
    if (
        start.shape != (3,)
        or along is None
        or along.shape != (3,)
        or not numpy.isfinite([start, along]).all()
    ):
        raise UsageError(
            f"pick: expected a ray of finite numbers with a direction, found {origin!r} and {direction!r}"
        )
    best: tuple[Mesh, int, float, float, float] | None = None
    for mesh in frame.meshes.values():
        most = best[2] if best else math.inf
        hit = cast(local_points(mesh), mesh.indices, start - origin_of(mesh), along, most=most)
        if hit and (not best or hit[1] < best[2]):
            best = (mesh, *hit)
    if not best:
        return None
    mesh, face, distance, u, v = best
    u, v = max(0.0, u), max(0.0, v)
    total = max(1.0, u + v)
    weights = numpy.array([max(0.0, 1 - (u + v) / total), u / total, v / total])
    corners = local_points(mesh)[mesh.indices[face]]
    local = weights @ corners
    normal = unit(numpy.cross(corners[1] - corners[0], corners[2] - corners[0]))
    assert normal is not None  # rays meet no face without an area
    found = ObjectPaths.of(frame._description.metadata)
    objects = found.at(_piece_of(mesh, face).centre, frame.ticks) if found else ()
    return Pick(
        time=frame.ticks,
        frame=frame.number,
        track=mesh.track,
        position=origin_of(mesh) + local,
        normal=normal,
        face=face,
        barycentric=weights,
        distance=distance,
        facing=abs(float(normal @ along)),
        object=objects[0] if len(objects) == 1 else None,
        touching=objects if len(objects) > 1 else (),
        camera=_camera(frame, mesh, face, local, normal, start, blend, threshold),
    )


def _camera(
    frame: Frame,
    mesh: Mesh,
    face: int,
    local: Vector,
    normal: Vector,
    eye: Vector,
    blend: str,
    threshold: float,
) -> int | None:
    place = origin_of(mesh) + local
    towards_eye = unit(eye - place)
    best: tuple[float, int] | None = None
    for key in frame.cameras:
        camera = frame.cameras[key]
        ray = unit(camera.centre - origin_of(mesh) - local)
        facing = float(ray @ normal) if ray is not None else 0.0
        if camera.id not in frame.pictures or not facing > 0 or facing < threshold:
            continue
        x, y = camera.project(place)
        if not (0 <= x < camera.width and 0 <= y < camera.height) or not _sees(
            frame, mesh, face, local, camera.centre
        ):
            continue
        if blend == "paper" or towards_eye is None or ray is None:
            weight = facing
        else:
            weight = (facing - threshold) / (1 - threshold) / (_APART - float(ray @ towards_eye)) ** 2
        if weight > 0 and (best is None or weight > best[0]):
            best = (weight, camera.id)
    return best[1] if best else None


def _sees(frame: Frame, mesh: Mesh, face: int, local: Vector, centre: Vector) -> bool:
    """Whether nothing of the meshes is between a point of a face and a camera."""
    way = centre - origin_of(mesh) - local
    return all(
        cast(
            local_points(other),
            other.indices,
            local + (origin_of(mesh) - origin_of(other)),
            way,
            least=_OWN_SURFACE,
            most=1,
            leave_out=face if other.track == mesh.track else -1,
        )
        is None
        for other in frame.meshes.values()
    )


def _labels(mesh: Mesh) -> NDArray[numpy.intp]:
    """The number of the piece of each face, by the order of their first faces."""
    _, alike = numpy.unique(mesh.lattice, axis=0, return_inverse=True)
    faces = alike.reshape(-1)[mesh.indices]
    least = numpy.arange(int(alike.max()) + 1 if alike.size else 0)
    while len(faces):
        low = least[faces].min(axis=1)
        former = least.copy()
        for corner in range(3):
            numpy.minimum.at(least, faces[:, corner], low)
        least = least[least]
        if (least == former).all():
            break
    roots = least[faces[:, 0]] if len(faces) else numpy.zeros(0, numpy.intp)
    _, first, number = numpy.unique(roots, return_index=True, return_inverse=True)
    return numpy.asarray(numpy.argsort(numpy.argsort(first))[number.reshape(-1)])


def _describe(mesh: Mesh, faces: NDArray[numpy.intp]) -> Piece:
    points, corners = local_points(mesh), mesh.indices[faces]
    a = points[corners[:, 0]]
    b, c = points[corners[:, 1]] - a, points[corners[:, 2]] - a
    areas = numpy.linalg.norm(numpy.cross(b, c), axis=1) / 2
    area = float(areas.sum())
    centre = areas @ (a + (b + c) / 3) / area if area > 0 else numpy.zeros(3)
    radius = float(numpy.linalg.norm(points[corners.ravel()] - centre, axis=1).max())
    return Piece((), origin_of(mesh) + centre, area, radius, faces, mesh.track)


def _pieces_of(mesh: Mesh) -> list[Piece]:
    labels = _labels(mesh)
    count = int(labels.max()) + 1 if len(labels) else 0
    return [_describe(mesh, numpy.flatnonzero(labels == i)) for i in range(count)]


def _piece_of(mesh: Mesh, face: int) -> Piece:
    labels = _labels(mesh)
    return _describe(mesh, numpy.flatnonzero(labels == labels[face]))


def pieces(frame: Frame) -> list[Piece]:
    """The pieces of the meshes of a frame, in the order of their first faces, with the objects that they are."""
    found = ObjectPaths.of(frame._description.metadata)
    return [
        dataclasses.replace(piece, objects=found.at(piece.centre, frame.ticks) if found else ())
        for mesh in frame.meshes.values()
        for piece in _pieces_of(mesh)
    ]
