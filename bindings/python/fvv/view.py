"""Pictures of a clip from anywhere."""

from __future__ import annotations

import dataclasses
import math
import operator
import warnings
from collections.abc import Iterable, Sequence
from typing import Any, Literal, Union, overload

import numpy
from numpy.typing import NDArray

from . import _core
from ._core import Camera
from .clip import Clip, ClipFrame
from .errors import UsageError
from .frames import Key

#: A camera, the identifier or name of one of the clip's, or (eye, target) or (eye, target, up): points of three numbers in
#: metres, and a direction.
Pose = Union[Camera, Key, Sequence[Any]]
#: Red, green and blue, 0 to 255.
Rgb = Sequence[int]


@dataclasses.dataclass(frozen=True)
class Rendering:
    """What `fvv.render(..., layers=True)` returns: arrays of the picture's height and width."""

    pixels: NDArray[numpy.uint8]  #: (height, width, 3) red, green, blue, sRGB.
    values: NDArray[numpy.float32]  #: The same before rounding, 1 for white, and beyond where the stream is.
    depth: NDArray[
        numpy.float32
    ]  #: (height, width) metres along the camera's z axis; infinity: no surface of the mesh.
    coverage: NDArray[numpy.float32]  #: (height, width) share of each pixel that shows the mesh, 0 to 1.
    weights: NDArray[
        numpy.float32
    ]  #: (height, width, sources): of each camera at the pixel's centre; they add up to 1, or to 0.
    sources: tuple[int, ...]  #: Identifiers of the cameras that texture was taken from.
    losses: tuple[str, ...]  #: What is lost of the frame: a line for each picture or visibility.
    warnings: tuple[str, ...]  #: What is strange about the frame.


@overload
def render(
    clip: Clip,
    frame: int | ClipFrame,
    pose: Pose,
    *,
    size: tuple[int, int] | None = None,
    samples: int = 1,
    focal: float | None = None,
    sources: Iterable[Key] | None = None,
    exclude: Iterable[Key] = (),
    pictures: bool | None = None,
    environment: bool = True,
    background: Rgb = (0, 0, 0),
    unseen: Rgb | None = None,
    blend: str | None = None,
    threshold: float | None = None,
    best: int | None = None,
    inset: float | None = None,
    visible_by: str | None = None,
    threads: int | None = None,
    layers: Literal[False] = False,
) -> NDArray[numpy.uint8]: ...


@overload
def render(
    clip: Clip,
    frame: int | ClipFrame,
    pose: Pose,
    *,
    size: tuple[int, int] | None = None,
    samples: int = 1,
    focal: float | None = None,
    sources: Iterable[Key] | None = None,
    exclude: Iterable[Key] = (),
    pictures: bool | None = None,
    environment: bool = True,
    background: Rgb = (0, 0, 0),
    unseen: Rgb | None = None,
    blend: str | None = None,
    threshold: float | None = None,
    best: int | None = None,
    inset: float | None = None,
    visible_by: str | None = None,
    threads: int | None = None,
    layers: Literal[True],
) -> Rendering: ...


def render(
    clip: Clip,
    frame: int | ClipFrame,
    pose: Pose,
    *,
    size: tuple[int, int] | None = None,
    samples: int = 1,
    focal: float | None = None,
    sources: Iterable[Key] | None = None,
    exclude: Iterable[Key] = (),
    pictures: bool | None = None,
    environment: bool = True,
    background: Rgb = (0, 0, 0),
    unseen: Rgb | None = None,
    blend: str | None = None,
    threshold: float | None = None,
    best: int | None = None,
    inset: float | None = None,
    visible_by: str | None = None,
    threads: int | None = None,
    layers: bool = False,
) -> NDArray[numpy.uint8] | Rendering:
    """Draws a frame from anywhere, textured from the cameras that see each point best: the pixels of `fvvrender`.

    frame: the place in the clip, or a frame of it.
    pose: an `fvv.Camera`; a camera of the clip by identifier or name; or (eye, target) or (eye, target, up) in metres, with
    up as the stream says, else +y. A camera keeps its lens.
    size: width and height in pixels; None: the camera's, or 960 x 540.
    samples: of each pixel along its side: 1, 3, 5 or 7.
    focal: pixels, of (eye, target); None: the width, which is 53 degrees across.
    sources, exclude: cameras to take texture from, and cameras to leave out.
    pictures: False: the mesh has the colours of its vertices, shaded. None: True where the stream has video.
    environment: draw the stream's environment too.
    background, unseen: colours behind all, and of what no camera shows; unseen None: as the stream has it.
    blend ("viewer" or "paper"), threshold (cosine), best (cameras), inset (metres): in place of the stream's.
    visible_by: "bits" of the stream, "depth" maps or "rays"; None: bits where the frame has them, else depth maps.
    threads: None: one for each processor. The picture is the same.
    layers: return a `Rendering` with depth, coverage and weights.

    Returns uint8 (height, width, 3), red, green, blue, sRGB. The GIL is released. The frame that was drawn last stays decoded
    until another one is drawn or the clip is closed: further poses are fast. Warns (RuntimeWarning) of pictures that are
    lost. The method is that of Budd, Grau and Schuebel, "Web delivery of free-viewpoint video of sport events" (BBC R&D White
    Paper 235, 2012), with the weights of Buehler et al., "Unstructured Lumigraph Rendering" (2001).

    Raises `UsageError` for arguments that do not fit, and what reading the frame raises.
    """
    index = _index_of(clip, frame)
    target = _target_of(clip, index, pose)
    if samples not in (1, 3, 5, 7):
        raise UsageError(f"samples: expected 1, 3, 5 or 7, found {samples}")
    if focal is not None and isinstance(target, (int, Camera)):
        raise UsageError("focal: expected with (eye, target) only")
    if size is not None:
        width, height = map(operator.index, size)
        if not (1 <= width <= 16384 and 1 <= height <= 16384):
            raise UsageError(f"size: expected sides of 1 to 16384, found {width} x {height}")
        size = width, height
    _one_of("blend", blend, ("viewer", "paper"))
    _one_of("visible_by", visible_by, ("bits", "depth", "rays"))
    _within("focal", focal, 1e-3, 1e9)
    _within("threshold", threshold, 0, 1)
    _within("best", best, 1, 8)
    _within("inset", inset, 0, 1e6)
    _within("threads", threads, 1, 256)
    left_out = _identifiers(clip, index, "exclude", exclude)
    taken = None if sources is None else _identifiers(clip, index, "sources", sources)
    if taken == []:
        raise UsageError("sources: expected a camera; pictures=False draws without")
    if pictures is None:
        pictures = any(track.kind == "video" for track in clip.tracks)
    options = {
        "size": size,
        "samples": samples,
        "focal": focal,
        "sources": taken,
        "exclude": left_out or None,
        "pictures": pictures,
        "environment": environment,
        "background": _colour("background", background),
        "unseen": None if unseen is None else _colour("unseen", unseen),
        "blend": blend,
        "threshold": threshold,
        "best": best,
        "inset": inset,
        "visible_by": visible_by,
        "threads": threads,
        "layers": layers,
    }
    found = _core.render(clip._stream, index, target, options)
    if layers:
        return Rendering(**found)
    for line in (*found["losses"], *found["warnings"]):
        warnings.warn(line, RuntimeWarning, stacklevel=2)
    pixels: NDArray[numpy.uint8] = found["pixels"]
    return pixels


def _index_of(clip: Clip, frame: int | ClipFrame) -> int:
    if isinstance(frame, ClipFrame):
        if frame._clip is not clip:
            raise UsageError("frame: expected one of this clip", file=clip.name)
        return frame.index
    return clip[operator.index(frame)].index


def _identifier(clip: Clip, index: int, argument: str, key: object) -> int:
    description = clip[index]._description
    found = description.camera(key)
    if found is None:
        known = ", ".join(str(name or i) for i, name in description.cameras) or "none"
        raise UsageError(f"{argument}: camera {key} is not in the stream, which has {known}", file=clip.name)
    return found


def _identifiers(clip: Clip, index: int, argument: str, keys: Iterable[Key]) -> list[int]:
    return [_identifier(clip, index, argument, key) for key in keys]


def _target_of(clip: Clip, index: int, pose: Pose) -> Camera | int | list[float]:
    if isinstance(pose, Camera):
        return pose
    if isinstance(pose, (int, str, numpy.integer)):
        return _identifier(clip, index, "pose", pose)
    try:
        points = [numpy.asarray(point, float) for point in pose]
    except (TypeError, ValueError):
        points = []
    if len(points) not in (2, 3) or any(point.shape != (3,) for point in points):
        raise UsageError(
            "pose: expected a camera, the identifier or name of one, or (eye, target) or (eye, target, up) of 3 numbers each"
        )
    return [float(value) for point in points for value in point]


def _one_of(argument: str, value: str | None, allowed: tuple[str, ...]) -> None:
    if value is not None and value not in allowed:
        raise UsageError(f"{argument}: expected one of {', '.join(allowed)}, found {value}")


def _within(argument: str, value: float | None, least: float, most: float) -> None:
    if value is not None and not least <= value <= most:
        raise UsageError(f"{argument}: expected {least:g} to {most:g}, found {value}")


def _colour(argument: str, value: Rgb) -> list[float]:
    codes = [float(code) for code in value]
    if len(codes) != 3 or not all(0 <= code <= 255 and math.isfinite(code) for code in codes):
        raise UsageError(f"{argument}: expected three numbers from 0 to 255, found {value}")
    return [code / 255 for code in codes]
