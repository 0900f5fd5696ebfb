"""First poses of cameras and boards: each view of the board by itself, cameras that share views, and a tree of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy
from fvv.errors import Error
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

from .boards import Board, Corners
from .lenses import Lens, pose_of

cv2: Any = optional_import("cv2", "capture")
csgraph: Any = optional_import("scipy.sparse.csgraph", "capture")

Floats = NDArray[numpy.float64]

#: Views that two cameras must share to be connected: one alone may be the wrong one of a plane's two poses.
FEWEST_SHARED = 3
#: Shared views from which the pose of one camera to another is taken; more do not make it better before the adjustment.
MOST_CANDIDATES = 24


@dataclasses.dataclass(frozen=True)
class Pose:
    """From one set of axes to another: rotation @ x + translation."""

    rotation: Floats  #: (3, 3)
    translation: Floats  #: (3,) metres

    def __call__(self, points: Floats) -> Floats:
        """(points, 3)."""
        return points @ self.rotation.T + self.translation

    def after(self, other: Pose) -> Pose:
        """First `other`, then this."""
        return Pose(self.rotation @ other.rotation, self(other.translation[None])[0])

    def inverse(self) -> Pose:
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    @property
    def centre(self) -> Floats:
        """(3,): where a camera with this pose is."""
        return -self.rotation.T @ self.translation

    @staticmethod
    def identity() -> Pose:
        return Pose(numpy.eye(3), numpy.zeros(3))


#: The corners that each camera sees, by its name and the frame.
Views = Mapping[str, Mapping[int, Corners]]


def single_poses(lenses: Mapping[str, Lens], board: Board, views: Views) -> dict[str, dict[int, Pose]]:
    """From the board's axes to the camera's, for each view by itself."""
    out: dict[str, dict[int, Pose]] = {}
    for name, seen in views.items():
        out[name] = {}
        for frame, view in seen.items():
            rotation, translation = pose_of(lenses[name], board.points[view.ids], view.pixels)
            out[name][frame] = Pose(cv2.Rodrigues(rotation)[0], translation)
    return out


def groups(views: Views) -> list[list[str]]:
    """Cameras that are connected by shared views, the largest group first."""
    names = list(views)
    _, labels = csgraph.connected_components(_shared(views) >= FEWEST_SHARED, directed=False)
    found = [[name for name, label in zip(names, labels) if label == one] for one in sorted(set(labels))]
    return sorted(found, key=len, reverse=True)


def camera_poses(
    lenses: Mapping[str, Lens], board: Board, views: Views
) -> tuple[dict[str, Pose], dict[int, Pose]]:
    """First poses of all cameras, in the axes of the one that shares most views, and of the board in each frame in which a
    camera sees it; that camera is the first of those returned. `Error` names the groups of cameras that no shared view connects.

    The tree has the pairs that share most views: an error of a pair is carried to all cameras beyond it."""
    parts = groups(views)
    if len(parts) > 1:
        lines = "; ".join(", ".join(part) for part in parts)
        raise Error(
            f"cameras are not connected: expected {FEWEST_SHARED} frames or more in which the board is seen by cameras of both groups, "
            f"found groups {lines}"
        )
    single = single_poses(lenses, board, views)
    names = list(views)
    shared = _shared(views)
    tree = csgraph.minimum_spanning_tree(
        numpy.where(shared >= FEWEST_SHARED, 1.0 / numpy.maximum(shared, 1), 0)
    )
    linked = (tree + tree.T).tocsr()
    root = int(shared.sum(axis=1).argmax())
    order, before = csgraph.breadth_first_order(linked, root, directed=False)
    cameras = {names[root]: Pose.identity()}
    for index in order[1:]:
        name, known = names[index], names[before[index]]
        step = _relative(lenses[name], board, views[name], single[known], single[name])
        cameras[name] = step.after(cameras[known])
    return cameras, board_poses(lenses, board, views, cameras, single)


def board_poses(
    lenses: Mapping[str, Lens],
    board: Board,
    views: Views,
    cameras: Mapping[str, Pose],
    single: Mapping[str, Mapping[int, Pose]],
) -> dict[int, Pose]:
    """From the board's axes to the world's, by frame: of the poses that the cameras give alone the one with the smallest error
    in all of them."""
    seen_by: dict[int, list[str]] = {}
    for name, seen in views.items():
        for frame in seen:
            seen_by.setdefault(frame, []).append(name)
    out: dict[int, Pose] = {}
    for frame in sorted(seen_by):
        names = seen_by[frame]
        candidates = [cameras[name].inverse().after(single[name][frame]) for name in names]
        errors = [
            sum(
                view_error(lenses[name], board, views[name][frame], cameras[name].after(pose))
                for name in names
            )
            for pose in candidates
        ]
        out[frame] = candidates[int(numpy.argmin(errors))]
    return out


def _shared(views: Views) -> NDArray[numpy.int64]:
    """(cameras, cameras): frames in which both see the board; 0 on the diagonal."""
    sets: Sequence[set[int]] = [set(seen) for seen in views.values()]
    out = numpy.array([[len(a & b) for b in sets] for a in sets])
    numpy.fill_diagonal(out, 0)
    return out


def _relative(
    lens: Lens, board: Board, views: Mapping[int, Corners], known: Mapping[int, Pose], own: Mapping[int, Pose]
) -> Pose:
    """From the axes of a known camera to those of another, whose lens and views these are: of the poses that the shared views give
    the one with the smallest median error in the others."""
    frames = sorted(set(known) & set(own))
    frames = frames[:: -(-len(frames) // MOST_CANDIDATES)]
    candidates = [own[frame].after(known[frame].inverse()) for frame in frames]
    errors = [
        numpy.median([view_error(lens, board, views[frame], pose.after(known[frame])) for frame in frames])
        for pose in candidates
    ]
    return candidates[int(numpy.argmin(errors))]


def view_error(lens: Lens, board: Board, view: Corners, pose: Pose) -> float:
    """Mean distance in pixels between projected and found corners; the picture's width if the board is behind the camera."""
    points = pose(board.points[view.ids])
    if points[:, 2].min() <= 0:
        return float(lens.width)
    apart = numpy.linalg.norm(lens.project(points)[0] - view.pixels, axis=1).mean()
    return float(min(apart, lens.width))
