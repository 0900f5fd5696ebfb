"""From recordings of a board walk to cameras in the world."""

from __future__ import annotations

import concurrent.futures
import dataclasses
import os
from collections.abc import Callable, Mapping, Sequence

import numpy
from fvv.errors import Error, UsageError
from numpy.typing import NDArray

from ..choices import LENSES, UPS
from ..opencv import named, quiet
from .adjustment import Bundle, adjust
from .boards import Board, Corners
from .lenses import FEWEST_VIEWS, Lens, choose
from .poses import FEWEST_SHARED, Pose, camera_poses, groups
from .recordings import Recording
from .world import Placement, place

Floats = NDArray[numpy.float64]

#: What is being done, how much of it is done, and of how much.
Progress = Callable[[str, int, int], object]

#: Columns and rows of cells in which coverage is counted.
CELLS = (16, 9)
#: Least part of the cells that corners should cover; below it the report warns.
COVERED = 0.5
#: Cameras that stand still, without which those that move have nothing to be found by.
FEWEST_STILL = 3


@dataclasses.dataclass(frozen=True)
class Options:
    """How to calibrate. Frames are numbers that all recordings share."""

    first: int = 0
    step: int = 1  #: Every step-th frame is looked at.
    last: int | None = None
    lens: str = "auto"  #: One of choices.LENSES.
    moving: tuple[str, ...] = ()  #: Cameras that do not stand still: only their lenses are found.
    up: str = "+y"
    floor: int | None = None  #: A frame in which the board lies on the floor.
    distance: tuple[str, str, float] | None = None  #: Two cameras and the metres between them.


@dataclasses.dataclass(frozen=True)
class Moment:
    """A moving camera in one frame."""

    lens: Lens
    pose: Pose
    matches: int  #: Points of the scene by which the pose was found.
    rms: float  #: Their root mean square distance in pixels.


@dataclasses.dataclass(frozen=True)
class CalibratedCamera:
    """A camera, and how well its numbers fit."""

    id: int
    name: str
    lens: Lens
    pose: Pose  #: From the world to the camera.
    r_max: float  #: fvv.md clause 9.3.
    views: int  #: Frames in which the board was used.
    pixels: Floats  #: (corners, 2) where corners were found.
    residuals: Floats  #: (corners, 2) pixels, projected minus found.
    held_out: Mapping[
        str, float
    ]  #: Error in pixels of the lens models that were compared, of views not used for them.
    per_frame: Mapping[int, Moment | None] | None = (
        None  #: Of a camera that moves; None in a frame: not found.
    )

    @property
    def rms(self) -> float:
        """Root mean square distance in pixels."""
        return float(numpy.sqrt((self.residuals**2).sum(axis=1).mean()))

    @property
    def covered(self) -> float:
        """Part of the picture's cells in which a corner was found, 0 to 1."""
        columns, rows = CELLS
        x = numpy.clip(self.pixels[:, 0] * columns / self.lens.width, 0, columns - 1).astype(int)
        y = numpy.clip(self.pixels[:, 1] * rows / self.lens.height, 0, rows - 1).astype(int)
        return len(set(zip(x.tolist(), y.tolist()))) / (columns * rows)


@dataclasses.dataclass(frozen=True)
class Calibration:
    """Cameras in the world, in metres."""

    cameras: tuple[CalibratedCamera, ...]  #: In the order of the recordings.
    up: str
    boards: Mapping[int, Pose]  #: From the board to the world, by frame.
    rejected: int  #: Corners that were found and not used.
    warnings: tuple[str, ...]

    @property
    def rms(self) -> float | None:
        """Root mean square distance in pixels over all corners; None of a calibration that was read from a file."""
        apart = numpy.concatenate([camera.residuals for camera in self.cameras])
        return None if not len(apart) else float(numpy.sqrt((apart**2).sum(axis=1).mean()))

    def camera(self, name: str) -> CalibratedCamera:
        """`UsageError`: there is none of this name."""
        for camera in self.cameras:
            if camera.name == name:
                return camera
        raise UsageError(f"camera {name}: expected one of {', '.join(one.name for one in self.cameras)}")


def calibrate(
    recordings: Sequence[Recording],
    board: Board,
    options: Options | None = None,
    progress: Progress | None = None,
) -> Calibration:
    """Lenses and poses of all cameras from recordings of a board that is carried through the volume.

    Each picture's corners are found; each camera's lens is estimated from its own views (lenses.choose); poses follow from
    frames that cameras share (poses.camera_poses) and are adjusted together with the lenses (adjustment.adjust); at last the
    world's axes are chosen (world.place). A camera in options.moving gets a lens alone, from its own views; its pose is that of
    its view with most corners, for `track`.

    `UsageError` for options that no recording can fulfil; `Error` names a camera with too few views, cameras that no shared
    view connects, and files that cannot be read."""
    options = options or Options()
    _check(recordings, board, options)
    sizes, views = detect(recordings, board, options, progress)
    for name, seen in views.items():
        if len(seen) < FEWEST_VIEWS:
            raise Error(
                f"camera {name}: expected the board in {FEWEST_VIEWS} frames or more, found it in {len(seen)}; is it the right board "
                "(--board, --dictionary)?"
            )
    lenses: dict[str, Lens] = {}
    compared: dict[str, dict[str, float]] = {}
    for i, name in enumerate(views):
        _tell(progress, "lenses", i, len(views))
        try:
            lenses[name], compared[name] = choose(
                options.lens, board, list(views[name].values()), sizes[name]
            )
        except Error as error:
            raise Error(f"camera {name}: {error}") from error
    _tell(progress, "lenses", len(views), len(views))
    still = {name: seen for name, seen in views.items() if name not in options.moving}
    poses, boards = camera_poses(lenses, board, still)
    bundle = adjust(
        board,
        {name: lenses[name] for name in still},
        poses,
        boards,
        still,
        progress=None if progress is None else lambda done, of: _tell(progress, "adjustment", done, of),
    )
    _check_agreement(bundle)
    alone = {name: _alone(board, lenses[name], views[name]) for name in views if name in options.moving}
    return _placed(recordings, board, options, bundle, alone, compared, views)


def detect(
    recordings: Sequence[Recording], board: Board, options: Options, progress: Progress | None = None
) -> tuple[dict[str, tuple[int, int]], dict[str, dict[int, Corners]]]:
    """Sizes (width, height) of each camera's pictures, and its views of the board by frame. `Error` names a camera whose pictures
    change their size, and one that has no picture in these frames."""
    sizes: dict[str, tuple[int, int]] = {}
    views: dict[str, dict[int, Corners]] = {one.name: {} for one in recordings}
    counts = [-(-one.count() // options.step) for one in recordings]
    done = [0] * len(recordings)

    def look(index: int) -> None:
        recording = recordings[index]
        for frame, grey in recording.frames(options.first, options.step, options.last):
            size = (grey.shape[1], grey.shape[0])
            if sizes.setdefault(recording.name, size) != size:
                first = sizes[recording.name]
                raise Error(
                    f"camera {recording.name}: frame {frame}: expected a picture of {first[0]}x{first[1]}, found {size[0]}x{size[1]}",
                    file=recording.path,
                )
            with named(recording.path, frame):
                found = board.detect(grey)
            if found is not None:
                views[recording.name][frame] = found
            done[index] += 1
            _tell(progress, "corners", min(sum(done), sum(counts)), sum(counts))

    with quiet(), concurrent.futures.ThreadPoolExecutor(min(len(recordings), os.cpu_count() or 1)) as pool:
        for future in [pool.submit(look, index) for index in range(len(recordings))]:
            future.result()
    for recording in recordings:
        if recording.name not in sizes:
            raise Error(f"{recording.path}: has no picture in the frames that are used", file=recording.path)
    return sizes, views


def _check(recordings: Sequence[Recording], board: Board, options: Options) -> None:
    names = [one.name for one in recordings]
    if not names:
        raise UsageError("recordings: expected one or more, found none")
    if options.step < 1 or (options.last is not None and options.last < options.first):
        raise UsageError(
            f"frames: expected first to last and a step of 1 or more, found {options.first}, {options.last}, {options.step}"
        )
    if options.lens not in LENSES:
        raise UsageError(f"lens: expected one of {', '.join(LENSES)}, found {options.lens}")
    if options.up not in UPS:
        raise UsageError(f"up: expected one of {', '.join(UPS)}, found {options.up}")
    if board.ambiguous and len(names) > 1:
        raise UsageError(
            f"board: a chessboard of {board.columns}x{board.rows} squares looks the same after half a turn, so that cameras cannot "
            "agree on its corners; expected an odd sum of columns and rows, or a ChArUco board"
        )
    for name in options.moving:
        if name not in names:
            raise UsageError(f"moving: expected cameras among {', '.join(names)}, found {name}")
    standing = len(names) - len(options.moving)
    if options.moving and standing < FEWEST_STILL:
        raise UsageError(
            f"moving: expected {FEWEST_STILL} cameras or more that stand still, found {standing}"
        )


def _check_agreement(bundle: Bundle) -> None:
    """`Error` names cameras whose views are not those of the others, after all that disagree are rejected."""
    most, *rest = groups(bundle.views)
    if rest:
        names = ", ".join(name for part in rest for name in part)
        raise Error(
            f"camera {names}: expected {FEWEST_SHARED} frames or more in which the board is where {', '.join(most)} see it, found fewer; is it in "
            "step with them (--offset), and does it stand still (--moving)?"
        )
    for name, seen in bundle.views.items():
        if len(seen) < FEWEST_VIEWS:
            raise Error(
                f"camera {name}: expected {FEWEST_VIEWS} frames or more whose corners fit, found {len(seen)}"
            )


def _alone(board: Board, lens: Lens, seen: dict[int, Corners]) -> Bundle:
    """A moving camera's views are adjusted by themselves: the world is that of the camera."""
    _, boards = camera_poses({"": lens}, board, {"": seen})
    return adjust(board, {"": lens}, {"": Pose.identity()}, boards, {"": seen})


def _placed(
    recordings: Sequence[Recording],
    board: Board,
    options: Options,
    bundle: Bundle,
    alone: Mapping[str, Bundle],
    compared: Mapping[str, dict[str, float]],
    views: Mapping[str, Mapping[int, Corners]],
) -> Calibration:
    """The adjusted cameras in the world's axes, with what the report needs."""
    still = {one.name: bundle.cameras[one.name] for one in recordings if one.name in bundle.cameras}
    placement = place(still, bundle.boards, board, options.up, options.floor, options.distance)
    boards = {frame: placement.board(pose) for frame, pose in bundle.boards.items()}
    cameras = []
    warnings = []
    for id, recording in enumerate(recordings):
        name = recording.name
        if name in alone:
            own = alone[name]
            pixels, residuals = own.residuals()[""]
            lens, used = own.lenses[""], own.views[""]
            pose = _pose_by_boards(own, boards, placement)
        else:
            pixels, residuals = bundle.residuals()[name]
            lens, used = bundle.lenses[name], bundle.views[name]
            pose = placement.camera(bundle.cameras[name])
        camera = CalibratedCamera(
            id, name, lens, pose, lens.r_max(pixels), len(used), pixels, residuals, compared[name]
        )
        cameras.append(camera)
        if camera.covered < COVERED:
            warnings.append(
                f"camera {name}: corners cover {camera.covered:.0%} of the picture; expected {COVERED:.0%} or more. Its lens is a guess elsewhere"
            )
        found = sum(len(view.ids) for view in views[name].values())
        if len(pixels) < 0.8 * found:
            warnings.append(
                f"camera {name}: {found - len(pixels)} of {found} corners were rejected; is it in step with the others (--offset)?"
            )
    rejected = bundle.rejected + sum(one.rejected for one in alone.values())
    return Calibration(tuple(cameras), options.up, boards, rejected, tuple(warnings))


def _pose_by_boards(own: Bundle, boards: Mapping[int, Pose], placement: Placement) -> Pose:
    """Of a moving camera: in the first frame in which another camera sees the board as well. `Error`: there is none."""
    for frame, pose in own.boards.items():
        if frame in boards:
            scaled = Pose(pose.rotation, placement.scale * pose.translation)
            return scaled.after(boards[frame].inverse())
    raise Error("a moving camera never sees the board together with one that stands still")


def _tell(progress: Progress | None, what: str, done: int, of: int) -> None:
    if progress is not None:
        progress(what, done, of)
