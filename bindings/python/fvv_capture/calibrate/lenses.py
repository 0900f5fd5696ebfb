"""Intrinsics of a camera: the lens model, its projection with derivatives, and a first estimate from views of a board."""

from __future__ import annotations

import dataclasses
import math

import numpy
from fvv import Camera
from fvv.errors import Error, UsageError
from numpy.typing import NDArray

from ..choices import LENSES
from ..opencv import cv2, fisheye_flag, reason, undistorted
from .boards import FEWEST_CORNERS, Board, Corners

Floats = NDArray[numpy.float64]

COEFFICIENTS = {"radtan5": 5, "radtan8": 8, "fisheye": 4}
#: Views below which the intrinsics of a camera are not determined well.
FEWEST_VIEWS = 6
#: Views of a first estimate; more take longer, and the adjustment uses all.
MOST_VIEWS = 40
#: Estimates that begin where the one before ended, as long as each lessens the error by this part.
MOST_RESTARTS, RESTART_GAIN = 8, 1e-3
#: A lens with more coefficients must leave this part of the held-out error, or less.
WORTH = 0.95
#: Corners this many times the median distance off are outliers of a first estimate, if they are this many pixels off.
OUTLIER, LEAST_OUTLIER = 6.0, 0.6
#: The lens is trusted this much farther from the axis than the farthest corner that was seen: one more square of a board, because
#: only its inner corners are found.
BEYOND_SEEN = 1.1


@dataclasses.dataclass(frozen=True)
class Lens:
    """Intrinsics, as fvv.md clause 9.1 defines them, without skew."""

    model: str  #: "radtan5", "radtan8" or "fisheye".
    width: int
    height: int
    parameters: (
        Floats  #: fx, fy, cx, cy, then the coefficients; the centre of the top left pixel is (0.5, 0.5).
    )

    @property
    def name(self) -> str:
        """The model as capture.json has it."""
        return "fisheye" if self.model == "fisheye" else "radtan"

    @property
    def matrix(self) -> Floats:
        """(3, 3)."""
        fx, fy, cx, cy = self.parameters[:4]
        return numpy.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])

    @property
    def coefficients(self) -> Floats:
        """k1 k2 p1 p2 k3 (k4 k5 k6), or k1 k2 k3 k4 of fisheye."""
        return self.parameters[4:]

    def project(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """points: (points, 3) in the camera's axes. Returns pixels, (points, 2); their derivatives by the points, (points, 2, 3);
        and by the parameters, (points, 2, parameters). By OpenCV."""
        zero = numpy.zeros(3)
        points = points.reshape(-1, 1, 3)
        count = len(self.coefficients)
        if self.model == "fisheye":
            pixels, jacobian = cv2.fisheye.projectPoints(points, zero, zero, self.matrix, self.coefficients)
            jacobian = jacobian.reshape(-1, 2, jacobian.shape[1])
            # f, c, k, rotation, translation, skew
            return pixels.reshape(-1, 2), jacobian[:, :, 11:14], jacobian[:, :, :8]
        pixels, jacobian = cv2.projectPoints(points, zero, zero, self.matrix, self.coefficients)
        jacobian = jacobian.reshape(-1, 2, jacobian.shape[1])
        # rotation, translation, f, c, coefficients
        return pixels.reshape(-1, 2), jacobian[:, :, 3:6], jacobian[:, :, 6 : 10 + count]

    def rays(self, pixels: Floats) -> Floats:
        """(pixels, 2) to (pixels, 2): x / z and y / z in the camera's axes."""
        pixels = numpy.ascontiguousarray(pixels, float).reshape(-1, 1, 2)
        if self.model == "fisheye":
            out: Floats = cv2.fisheye.undistortPoints(pixels, self.matrix, self.coefficients)
        else:
            out = undistorted(pixels, self.matrix, self.coefficients)
        return out.reshape(-1, 2)

    def scaled(self, by: float) -> Lens:
        """The lens after a zoom: both focal lengths times `by`."""
        parameters = self.parameters.copy()
        parameters[:2] *= by
        return dataclasses.replace(self, parameters=parameters)

    def r_max(self, seen: Floats) -> float:
        """The radius of validity (fvv.md clause 9.3). seen: (corners, 2) pixels at which corners of boards were found. Beyond the
        farthest of them the polynomial is not determined: r_max is BEYOND_SEEN times its radius, and at most the radius up to
        which the lens can be inverted."""
        radii = numpy.linalg.norm(self.rays(seen), axis=1)
        if self.model == "fisheye":
            radii = numpy.arctan(radii)
        limit = self.camera(0, numpy.eye(3), numpy.zeros(3)).r_max
        return float(min(BEYOND_SEEN * radii.max(), limit))

    def holds(self, seen: Floats) -> bool:
        """The lens can be inverted up to the farthest of `seen`, (corners, 2) pixels, and a little beyond."""
        radius = BEYOND_SEEN * float(numpy.linalg.norm(self.rays(seen), axis=1).max())
        limit = self.camera(0, numpy.eye(3), numpy.zeros(3)).r_max
        return limit >= (math.atan(radius) if self.model == "fisheye" else radius)

    def camera(
        self, id: int, rotation: Floats, translation: Floats, name: str = "", r_max: float | None = None
    ) -> Camera:
        """The camera of fvv with this lens."""
        return Camera(
            id,
            self.matrix,
            rotation,
            translation,
            (self.width, self.height),
            self.coefficients,
            self.name,
            name,
            r_max,
        )


def pose_of(lens: Lens, points: Floats, pixels: Floats) -> tuple[Floats, Floats]:
    """Rotation vector and translation from the axes of points, (points, 3) of a plane z = 0, to the camera's.

    Of the two poses that a plane may have (Collins and Bartoli, 2014: cv2.SOLVEPNP_IPPE) the one with the smaller error,
    refined by Levenberg and Marquardt's method."""
    rays = lens.rays(pixels)
    nothing = numpy.zeros(4)
    found, rotations, translations, _ = cv2.solvePnPGeneric(
        points, rays, numpy.eye(3), nothing, flags=cv2.SOLVEPNP_IPPE
    )
    if not found:
        raise Error("a view of the board has no pose")
    rotation, translation = cv2.solvePnPRefineLM(
        points, rays, numpy.eye(3), nothing, rotations[0], translations[0]
    )
    return rotation.reshape(3), translation.reshape(3)


def view_residuals(lens: Lens, board: Board, view: Corners) -> Floats:
    """(corners, 2) pixels: projected minus found, with the pose that fits this view best."""
    points = board.points[view.ids]
    rotation, translation = pose_of(lens, points, view.pixels)
    matrix, _ = cv2.Rodrigues(rotation)
    return lens.project(points @ matrix.T + translation)[0] - view.pixels


def spread(views: list[Corners], most: int) -> list[Corners]:
    """At most `most` views that differ in place, size and slant: each the farthest from those that were taken before."""
    if len(views) <= most:
        return views
    signs = []
    for view in views:
        centre = view.pixels.mean(axis=0)
        moved = view.pixels - centre
        covariance = moved.T @ moved / len(moved)
        signs.append([*centre, *(3 * numpy.sqrt(numpy.diag(covariance))), covariance[0, 1] / 30])
    places = numpy.array(signs)
    taken = [int(numpy.argmax([len(view.ids) for view in views]))]
    distance = numpy.linalg.norm(places - places[taken[0]], axis=1)
    while len(taken) < most:
        taken.append(int(distance.argmax()))
        distance = numpy.minimum(distance, numpy.linalg.norm(places - places[taken[-1]], axis=1))
    return [views[i] for i in sorted(taken)]


def estimate(model: str, board: Board, views: list[Corners], size: tuple[int, int]) -> Lens:
    """The lens that fits views of a board best, by cv2.calibrateCamera (Zhang, 2000) or cv2.fisheye.calibrate. size: width and
    height in pixels. `Error`: OpenCV finds none."""
    width, height = size
    points = [board.points[view.ids].astype(numpy.float32).reshape(-1, 1, 3) for view in views]
    pixels = [view.pixels.astype(numpy.float32).reshape(-1, 1, 2) for view in views]
    try:
        if model == "fisheye":
            guess = numpy.array([[width / 2.5, 0, width / 2], [0, width / 2.5, height / 2], [0, 0, 1.0]])
            flags = (
                fisheye_flag("CALIB_RECOMPUTE_EXTRINSIC")
                | fisheye_flag("CALIB_FIX_SKEW")
                | fisheye_flag("CALIB_USE_INTRINSIC_GUESS")
            )
            _, matrix, found, _, _ = cv2.fisheye.calibrate(
                [one.astype(float).reshape(1, -1, 3) for one in points],  # in a row: 5.0 refuses columns
                [one.astype(float).reshape(1, -1, 2) for one in pixels],
                size,
                guess,
                numpy.zeros(4),
                flags=flags,
                criteria=(cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-9),
            )
        else:
            flags = cv2.CALIB_RATIONAL_MODEL if model == "radtan8" else 0
            rms, matrix, found, _, _ = cv2.calibrateCamera(points, pixels, size, None, None, flags=flags)
            # OpenCV 5 may stop far from the minimum of a rational lens, whatever its criteria; from there it goes on.
            for _ in range(MOST_RESTARTS):
                before = rms
                rms, matrix, found, _, _ = cv2.calibrateCamera(
                    points, pixels, size, matrix, found, flags=flags | cv2.CALIB_USE_INTRINSIC_GUESS
                )
                if rms > (1 - RESTART_GAIN) * before:
                    break
    except cv2.error as error:
        raise Error(f"OpenCV finds no {model} lens for {len(views)} views: {reason(error)}") from error
    parameters = [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]]
    coefficients = found.reshape(-1)[: COEFFICIENTS[model]]
    lens = Lens(model, width, height, numpy.array([*parameters, *coefficients], float))
    if not (numpy.isfinite(lens.parameters).all() and lens.parameters[:2].min() > 0):
        raise Error(f"OpenCV finds no {model} lens for {len(views)} views: its numbers are not finite")
    return lens


def held_out_errors(board: Board, views: list[Corners], size: tuple[int, int], model: str) -> Floats:
    """(2,) root mean squares in pixels over views that the lens was not estimated from: each half with the lens of the other."""
    out = []
    for half in range(2):
        lens = estimate(model, board, views[half::2], size)
        apart = numpy.concatenate([view_residuals(lens, board, view) for view in views[1 - half :: 2]])
        out.append(math.sqrt(float((apart**2).sum(axis=1).mean())))
    return numpy.array(out)


def without_outliers(board: Board, views: list[Corners], lens: Lens) -> list[Corners]:
    """The views without corners that are far from where the lens has them: a wrong corner of a board that is seen at a grazing
    angle would decide which lens is better."""
    lengths = [numpy.linalg.norm(view_residuals(lens, board, view), axis=1) for view in views]
    bound = max(OUTLIER * float(numpy.median(numpy.concatenate(lengths))), LEAST_OUTLIER)
    out = []
    for view, length in zip(views, lengths):
        kept = length <= bound
        if kept.mean() > 0.7 and kept.sum() >= FEWEST_CORNERS:
            out.append(Corners(view.ids[kept], view.pixels[kept]))
    return out


def choose(
    model: str, board: Board, views: list[Corners], size: tuple[int, int]
) -> tuple[Lens, dict[str, float]]:
    """A first estimate, and the held-out error of the models that were compared: with "auto" those of radtan5 and radtan8, of
    which the larger is taken only if it leaves at most WORTH of the error of the smaller in both halves of the views, and can be
    inverted where corners were seen. `Error`: too few views are left without outliers."""
    if model not in LENSES:
        raise UsageError(f"lens: expected one of {', '.join(LENSES)}, found {model}")
    views = spread(views, MOST_VIEWS)
    first = "radtan5" if model == "auto" else model
    found = len(views)
    for _ in range(2):
        smaller = estimate(first, board, views, size)
        views = without_outliers(board, views, smaller)
        if len(views) < FEWEST_VIEWS:
            raise Error(
                f"expected {FEWEST_VIEWS} views or more that one lens explains, found {len(views)} of {found}"
            )
    smaller = estimate(first, board, views, size)
    if model != "auto":
        return smaller, {}
    errors = held_out_errors(board, views, size, "radtan5")
    compared = {"radtan5": _mean(errors)}
    try:
        others = held_out_errors(board, views, size, "radtan8")
        larger = estimate("radtan8", board, views, size)
    except Error:  # eight coefficients are too many for half of these views
        return smaller, compared
    compared["radtan8"] = _mean(others)
    # A rational lens that fits and folds within the part that was seen has fitted noise.
    seen = numpy.concatenate([view.pixels for view in views])
    worth = bool((others <= WORTH * errors).all()) and larger.holds(seen)
    return (larger if worth else smaller), compared


def _mean(errors: Floats) -> float:
    return math.sqrt(float((errors**2).mean()))
