"""The world's axes: which way is up, where the origin is, and how long a metre is."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy
from fvv.errors import Error, UsageError
from numpy.typing import NDArray

from ..choices import UPS
from .boards import Board
from .poses import Pose

Floats = NDArray[numpy.float64]


@dataclasses.dataclass(frozen=True)
class Placement:
    """From the axes of the adjustment to the world's: scale * rotation @ x + translation."""

    scale: float
    rotation: Floats  #: (3, 3)
    translation: Floats  #: (3,)

    def camera(self, pose: Pose) -> Pose:
        """From the new world to the camera; pose is from the old one."""
        rotation = pose.rotation @ self.rotation.T
        return Pose(rotation, self.scale * pose.translation - rotation @ self.translation)

    def board(self, pose: Pose) -> Pose:
        """From the board, in metres of the new world, to the new world."""
        return Pose(
            self.rotation @ pose.rotation, self.scale * self.rotation @ pose.translation + self.translation
        )


def place(
    cameras: Mapping[str, Pose],
    boards: Mapping[int, Pose],
    board: Board,
    up: str = "+y",
    floor: int | None = None,
    distance: tuple[str, str, float] | None = None,
) -> Placement:
    """The world's axes.

    up: the axis that points up. floor: a frame in which the board lies on the floor: the floor's height is then 0, and the origin
    is under the middle of the board. Without it, up is the mean of what the cameras call up, and the origin is the point nearest
    to their optical axes: good if the cameras are held level and look at the stage. distance: two cameras and the metres
    between their centres, in place of the scale that the board's squares give.

    The axis after `up` (x after z, y after x, z after y) points from the origin to the first camera, as far as it is horizontal:
    the result does not depend on how the board lay. `UsageError` for a frame or a camera that is not there."""
    if up not in UPS:
        raise UsageError(f"up: expected one of {', '.join(UPS)}, found {up}")
    scale = 1.0 if distance is None else _scale(cameras, *distance)
    centres = numpy.array([pose.centre for pose in cameras.values()])
    if floor is None:
        upwards = sum(-pose.rotation[1] for pose in cameras.values())
        length = float(numpy.linalg.norm(upwards))
        if length < 0.3 * len(cameras):
            raise Error(
                "up: the cameras do not agree which way is up, so that it needs a frame in which the board lies on the floor (--floor)"
            )
        upwards = numpy.asarray(upwards) / length
        origin = _nearest_to_axes(cameras)
    else:
        if floor not in boards:
            raise UsageError(f"floor: expected a frame in which cameras see the board, found {floor}")
        upwards = boards[floor].rotation[:, 2]
        middle = numpy.array([[board.columns * board.square / 2, board.rows * board.square / 2, 0.0]])
        origin = boards[floor](middle)[0]
        if (centres.mean(axis=0) - origin) @ upwards < 0:  # the print faces the cameras
            upwards = -upwards
    towards = centres[0] - origin
    towards = towards - upwards * (towards @ upwards)
    length = float(numpy.linalg.norm(towards))
    if length < 1e-6:  # the first camera is right above
        towards = numpy.cross(upwards, numpy.eye(3)[int(numpy.abs(upwards).argmin())])
        length = float(numpy.linalg.norm(towards))
    towards = towards / length
    axis = "xyz".index(up[1])
    sign = 1.0 if up[0] == "+" else -1.0
    rotation = numpy.zeros((3, 3))
    rotation[axis] = sign * upwards
    rotation[(axis + 1) % 3] = towards
    rotation[(axis + 2) % 3] = numpy.cross(rotation[axis], towards)
    return Placement(scale, rotation, -scale * rotation @ origin)


def _scale(cameras: Mapping[str, Pose], first: str, second: str, metres: float) -> float:
    for name in (first, second):
        if name not in cameras:
            raise UsageError(f"distance: expected cameras among {', '.join(cameras)}, found {name}")
    found = float(numpy.linalg.norm(cameras[first].centre - cameras[second].centre))
    if not metres > 0 or found < 1e-6:
        raise UsageError(
            f"distance: expected two cameras and the metres between them, found {first} {second} {metres}"
        )
    return metres / found


def _nearest_to_axes(cameras: Mapping[str, Pose]) -> Floats:
    """(3,): the point with the least sum of squared distances to the optical axes; the cameras' mean centre if they are parallel."""
    normal = numpy.zeros((3, 3))
    right = numpy.zeros(3)
    for pose in cameras.values():
        across = numpy.eye(3) - numpy.outer(pose.rotation[2], pose.rotation[2])
        normal += across
        right += across @ pose.centre
    if numpy.linalg.eigvalsh(normal)[0] < 1e-3 * len(cameras):
        middle: Floats = numpy.mean([pose.centre for pose in cameras.values()], axis=0)
        return middle
    return numpy.linalg.solve(normal, right)
