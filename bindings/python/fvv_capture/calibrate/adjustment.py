"""Bundle adjustment: lenses, poses of cameras and poses of the board together, such that all corners are where they were found."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

from .boards import FEWEST_CORNERS, Board, Corners
from .lenses import Lens
from .poses import Pose, Views, view_error

cv2: Any = optional_import("cv2", "capture")
sparse: Any = optional_import("scipy.sparse", "capture")
linalg: Any = optional_import("scipy.sparse.linalg", "capture")

Floats = NDArray[numpy.float64]
Ints = NDArray[numpy.int64]

#: Pixels from which a residual counts less than its square, before anything is rejected.
FIRST_SCALE = 2.0
#: The same afterwards, in standard deviations of the residuals; corners beyond REJECTED of them are rejected.
SCALE, REJECTED = 3.0, 5.0
#: Residuals of a corner that are never rejected, in pixels: pictures of a renderer have next to no noise.
ALWAYS_KEPT = 0.15
#: Views that are this part of the picture's width off before anything is adjusted are of another board, or of another moment.
FIRST_BOUND = 0.05
ROUNDS = 4
MOST_STEPS = 60


@dataclasses.dataclass
class Bundle:
    """What is adjusted, and what it is adjusted to."""

    board: Board
    lenses: dict[str, Lens]
    cameras: dict[str, Pose]  #: From the world to the camera. The first is kept: it is the world.
    boards: dict[int, Pose]  #: From the board to the world, by frame.
    views: dict[str, dict[int, Corners]]  #: Of these frames only.
    rejected: int = 0  #: Corners that were found and are not used.

    def residuals(self) -> dict[str, tuple[Floats, Floats]]:
        """By camera: the pixels of its corners, (corners, 2), and projected minus found, (corners, 2)."""
        out = {}
        for name, seen in self.views.items():
            pixels = [numpy.zeros((0, 2))]
            apart = [numpy.zeros((0, 2))]
            for frame, view in seen.items():
                points = self.cameras[name](self.boards[frame](self.board.points[view.ids]))
                pixels.append(view.pixels)
                apart.append(self.lenses[name].project(points)[0] - view.pixels)
            out[name] = (numpy.concatenate(pixels), numpy.concatenate(apart))
        return out

    def rms(self) -> float:
        """Root mean square distance in pixels over all corners."""
        apart = numpy.concatenate([one for _, one in self.residuals().values()])
        return float(numpy.sqrt((apart**2).sum(axis=1).mean()))


def adjust(
    board: Board,
    lenses: Mapping[str, Lens],
    cameras: Mapping[str, Pose],
    boards: Mapping[int, Pose],
    views: Views,
    fixed_lenses: bool = False,
    progress: Callable[[int, int], object] | None = None,
) -> Bundle:
    """Minimises a robust sum of reprojection errors (Triggs et al., 2000: Bundle Adjustment, a Modern Synthesis), rejects
    corners that are far off, and repeats until none is. A frame in which one camera alone sees the board counts as well: it
    determines that camera's lens. The first camera stays where it is.

    A camera may be left with no views, which its caller has to refuse. fixed_lenses: only poses are adjusted. progress: called with rounds that are done, and the most that there may be."""
    bundle = Bundle(
        board,
        dict(lenses),
        dict(cameras),
        dict(boards),
        {name: {f: v for f, v in seen.items() if f in boards} for name, seen in views.items()},
    )
    _reject_views(bundle)
    scale = FIRST_SCALE
    for turn in range(ROUNDS):
        if progress is not None:
            progress(turn, ROUNDS)
        if not all(bundle.views.values()):  # a camera without views has no pose; its caller counts them
            return bundle
        _Minimiser(bundle, scale, fixed_lenses).run()
        dropped, scale = _reject(bundle)
        if turn and not dropped:
            break
    if progress is not None:
        progress(ROUNDS, ROUNDS)
    return bundle


def _reject_views(bundle: Bundle) -> None:
    """Leaves out views that are far off with the first poses, or behind their camera."""
    for name, seen in bundle.views.items():
        lens, camera = bundle.lenses[name], bundle.cameras[name]
        for frame, view in list(seen.items()):
            off = view_error(lens, bundle.board, view, camera.after(bundle.boards[frame]))
            if off > FIRST_BOUND * lens.width:
                del seen[frame]
                bundle.rejected += len(view.ids)
    _forget(bundle)


def _forget(bundle: Bundle) -> None:
    """Leaves out boards that no view shows."""
    for frame in [f for f in bundle.boards if not any(f in seen for seen in bundle.views.values())]:
        del bundle.boards[frame]


def _reject(bundle: Bundle) -> tuple[int, float]:
    """Leaves out corners that are far off. Returns how many, and the scale of the robust sum for the next round."""
    lengths = numpy.concatenate([numpy.linalg.norm(one, axis=1) for _, one in bundle.residuals().values()])
    # The median of the length of a normal error in two dimensions is 1.1774 of its standard deviation.
    deviation = float(numpy.median(lengths)) / 1.1774
    bound = max(REJECTED * deviation, ALWAYS_KEPT)
    dropped = 0
    for name, (_, apart) in bundle.residuals().items():
        kept = numpy.linalg.norm(apart, axis=1) <= bound
        dropped += int((~kept).sum())
        start = 0
        rest: dict[int, Corners] = {}
        for frame, view in bundle.views[name].items():
            own = kept[start : start + len(view.ids)]
            start += len(view.ids)
            if own.sum() >= FEWEST_CORNERS:
                rest[frame] = Corners(view.ids[own], view.pixels[own])
            else:
                dropped += int(own.sum())
        bundle.views[name] = rest
    _forget(bundle)
    bundle.rejected += dropped
    return dropped, max(SCALE * deviation, 0.03)


class _Minimiser:
    """Levenberg and Marquardt's method with analytic derivatives and sparse normal equations.

    scipy.optimize.least_squares does the same with LSMR in place of a factorisation. The normal equations of a bundle are an
    arrow: each board touches only the cameras that see it, and a factorisation has next to no fill."""

    def __init__(self, bundle: Bundle, scale: float, fixed_lenses: bool) -> None:
        self._bundle = bundle
        self._scale = scale
        self._names = list(bundle.cameras)
        self._frames = list(bundle.boards)
        at = 0
        self._lens_at: dict[str, int | None] = {}
        self._camera_at: dict[str, int | None] = {}
        self._board_at: dict[int, int] = {}
        for i, name in enumerate(self._names):
            self._lens_at[name] = None if fixed_lenses else at
            at += 0 if fixed_lenses else len(bundle.lenses[name].parameters)
            self._camera_at[name] = at if i else None
            at += 6 if i else 0
        for frame in self._frames:
            self._board_at[frame] = at
            at += 6
        self._size = at
        self._gather()

    def _gather(self) -> None:
        """Observations of each camera as arrays: the board's points, pixels, and the index of the frame."""
        self._points: dict[str, Floats] = {}
        self._pixels: dict[str, Floats] = {}
        self._frame: dict[str, Ints] = {}
        number = {frame: i for i, frame in enumerate(self._frames)}
        for name in self._names:
            seen = self._bundle.views[name]
            empty = numpy.zeros((0, 3))
            self._points[name] = numpy.concatenate(
                [empty, *(self._bundle.board.points[v.ids] for v in seen.values())]
            )
            self._pixels[name] = numpy.concatenate([empty[:, :2], *(v.pixels for v in seen.values())])
            counts = [len(v.ids) for v in seen.values()]
            self._frame[name] = numpy.repeat(
                numpy.array([number[f] for f in seen], dtype=numpy.int64), counts
            )

    def run(self) -> None:
        """Adjusts the bundle in place."""
        bundle = self._bundle
        cost = self._cost(bundle)
        damping = 1e-4
        for _ in range(MOST_STEPS):
            normal, gradient = self._equations()
            diagonal = numpy.maximum(normal.diagonal(), 1e-12)
            trial, found = bundle, cost
            while found >= cost:
                if damping > 1e12:
                    return
                step = linalg.spsolve((normal + sparse.diags(damping * diagonal)).tocsc(), -gradient)
                if numpy.isfinite(step).all():
                    trial = self._moved(step)
                    found = self._cost(trial)
                if found >= cost:
                    damping *= 8
            bundle.lenses, bundle.cameras, bundle.boards = trial.lenses, trial.cameras, trial.boards
            gain, cost = cost - found, found
            damping = max(damping / 8, 1e-12)
            if gain < 1e-9 * cost:
                return

    def _cost(self, bundle: Bundle) -> float:
        """2 (sqrt(1 + e^2) - 1) summed over corners, e their distance in units of the scale."""
        total = 0.0
        for name in self._names:
            world = self._in_world(bundle, name)
            points = bundle.cameras[name](world)
            if len(points) and points[:, 2].min() <= 1e-6:
                return float("inf")
            apart = bundle.lenses[name].project(points)[0] - self._pixels[name] if len(points) else points
            squared = (apart**2).sum(axis=1) / self._scale**2
            total += float(2 * (numpy.sqrt(1 + squared) - 1).sum())
        return total if numpy.isfinite(total) else float("inf")

    def _in_world(self, bundle: Bundle, name: str) -> Floats:
        rotations = numpy.array([bundle.boards[frame].rotation for frame in self._frames])
        translations = numpy.array([bundle.boards[frame].translation for frame in self._frames])
        frame = self._frame[name]
        out: Floats = numpy.einsum("nij,nj->ni", rotations[frame], self._points[name]) + translations[frame]
        return out

    def _equations(self) -> tuple[Any, Floats]:
        """J^T W J, sparse, and J^T W r, where W are the weights of the robust sum."""
        bundle = self._bundle
        rows: list[Any] = []
        residuals: list[Floats] = []
        board_rotations = numpy.array([bundle.boards[frame].rotation for frame in self._frames])
        for name in self._names:
            if not len(self._points[name]):
                continue
            world = self._in_world(bundle, name)
            pose = bundle.cameras[name]
            pixels, by_point, by_lens = bundle.lenses[name].project(pose(world))
            apart = pixels - self._pixels[name]
            weights = (1 + (apart**2).sum(axis=1) / self._scale**2) ** -0.25
            by_world = by_point @ pose.rotation
            blocks: list[tuple[Floats, Ints]] = []
            count = len(apart)
            at = self._lens_at[name]
            if at is not None:
                blocks.append((by_lens, _columns(at, by_lens.shape[2], count)))
            at = self._camera_at[name]
            if at is not None:
                # Rotations are turned from the left: the derivative by a small turn w of R x is -[R x] w.
                turned = by_point @ -_cross(pose(world) - pose.translation)
                blocks.append((numpy.concatenate([turned, by_point], axis=2), _columns(at, 6, count)))
            frame = self._frame[name]
            moved = numpy.einsum("nij,nj->ni", board_rotations[frame], self._points[name])
            first = numpy.array([self._board_at[f] for f in self._frames])[frame]
            by_board = numpy.concatenate([by_world @ -_cross(moved), by_world], axis=2)
            blocks.append((by_board, first[:, None] + numpy.arange(6)))
            values = numpy.concatenate([block for block, _ in blocks], axis=2) * weights[:, None, None]
            columns = numpy.concatenate([column for _, column in blocks], axis=1)
            columns = numpy.repeat(columns[:, None], 2, axis=1)
            starts = numpy.arange(2 * count + 1) * columns.shape[2]
            rows.append(
                sparse.csr_matrix(
                    (values.reshape(-1), columns.reshape(-1), starts), shape=(2 * count, self._size)
                )
            )
            residuals.append((apart * weights[:, None]).reshape(-1))
        jacobian = sparse.vstack(rows).tocsr()
        return (jacobian.T @ jacobian).tocsc(), jacobian.T @ numpy.concatenate(residuals)

    def _moved(self, step: Floats) -> Bundle:
        """The bundle after a step; views are shared."""
        bundle = self._bundle
        lenses = dict(bundle.lenses)
        cameras = dict(bundle.cameras)
        for name in self._names:
            at = self._lens_at[name]
            if at is not None:
                parameters = lenses[name].parameters
                lenses[name] = dataclasses.replace(
                    lenses[name], parameters=parameters + step[at : at + len(parameters)]
                )
            at = self._camera_at[name]
            if at is not None:
                cameras[name] = _turned(cameras[name], step[at : at + 6])
        boards = {
            frame: _turned(pose, step[self._board_at[frame] : self._board_at[frame] + 6])
            for frame, pose in bundle.boards.items()
        }
        return Bundle(bundle.board, lenses, cameras, boards, bundle.views, bundle.rejected)


def _columns(at: int, count: int, rows: int) -> Ints:
    return numpy.broadcast_to(numpy.arange(at, at + count), (rows, count))


def _cross(v: Floats) -> Floats:
    """(n, 3) to (n, 3, 3): the matrices with which v x w is a product."""
    out = numpy.zeros((len(v), 3, 3))
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    out[:, 1, 0], out[:, 2, 0], out[:, 2, 1] = v[:, 2], -v[:, 1], v[:, 0]
    return out


def _turned(pose: Pose, step: Floats) -> Pose:
    """step: a rotation vector, applied after the pose's rotation, and a translation, added to its own."""
    rotation = cv2.Rodrigues(step[:3])[0] @ pose.rotation
    u, _, v = numpy.linalg.svd(rotation)  # errors of rounding do not add up
    return Pose(u @ v, pose.translation + step[3:])
