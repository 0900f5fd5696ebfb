"""What moved between OpenCV 4.7 and 5, and its failures as errors that name the file and the frame."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import numpy
from fvv.errors import Error
from fvv.interop.optional_import import optional_import

from .arrays import Floats

cv2: Any = optional_import("cv2", "capture")


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Without OpenCV's own messages on standard error: each failure becomes an error with the file's name."""
    levels = cv2 if hasattr(cv2, "getLogLevel") else cv2.utils.logging  # the latter since 5.0
    before = levels.getLogLevel()
    levels.setLogLevel(0)
    try:
        yield
    finally:
        levels.setLogLevel(before)


@contextlib.contextmanager
def named(source: str, frame: int | None = None, *, is_file: bool = True) -> Iterator[None]:
    """`Error` with the file, or another source such as a camera, and the frame for what OpenCV and numpy's linear algebra
    cannot do within."""
    try:
        yield
    except (cv2.error, numpy.linalg.LinAlgError) as error:
        place = source if frame is None else f"{source}: frame {frame}"
        raise Error(f"{place}: {reason(error)}", file=source if is_file else None) from error


def reason(error: Exception) -> str:
    """One line: what failed, without the place in the library's own sources."""
    if isinstance(error, cv2.error):
        words = getattr(error, "err", None) or str(error)
        words = " ".join(line.removeprefix("> ") for line in words.splitlines())
        # Of a template the whole declaration.
        function = (getattr(error, "func", None) or "").partition("(")[0].rpartition("::")[2]
        return f"OpenCV {cv2.__version__}: {' '.join(words.split())}" + (f" ({function})" if function else "")
    return f"linear algebra: {error}"


def undistorted(pixels: Floats, matrix: Floats, coefficients: Floats) -> Floats:
    """(points, 1, 2) pixels to x / z and y / z, by as many iterations as they need; the default of OpenCV 4 are five."""
    end = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 60, 1e-10)
    if hasattr(cv2, "undistortPointsIter"):
        out: Floats = cv2.undistortPointsIter(pixels, matrix, coefficients, None, None, end)
        return out
    out = cv2.undistortPoints(pixels, matrix, coefficients, criteria=end)
    return out


def fisheye_flag(name: str) -> int:
    """A flag of cv2.fisheye.calibrate; since 5.0 it shares those of cv2.calibrateCamera."""
    flags = cv2.fisheye if hasattr(cv2.fisheye, name) else cv2
    return int(getattr(flags, name))


def sift(features: int, contrast: float) -> tuple[Any, float]:
    """A detector, and by how much its places are too large on both axes, in pixels: OpenCV enlarges the picture for fine features,
    which moves them by a quarter of a pixel unless that is corrected, as it can be since 4.8."""
    options = {"nfeatures": features, "contrastThreshold": contrast}
    if "enable_precise_upscale" in cv2.SIFT_create.__doc__:
        return cv2.SIFT_create(**options, enable_precise_upscale=True), 0.0
    return cv2.SIFT_create(**options), 0.25
