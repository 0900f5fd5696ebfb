"""The pictures of a board walk: a video or a folder of pictures for each camera, by frame number.

Videos go by time, as those of a take (`footage.pictures`), so that pictures that a camera dropped shift nothing. Folders have a
picture for each frame, in the order of their names; they may be of kinds that a take cannot have.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from fractions import Fraction

import numpy
from fvv.errors import Error, UsageError
from numpy.typing import NDArray

from .. import footage
from ..opencv import cv2, named
from ..synchronise import TRUSTED, Method, synchronised

Bytes = NDArray[numpy.uint8]
Progress = Callable[[str, int, int], object]


@dataclasses.dataclass(frozen=True)
class Recording:
    """What one camera recorded."""

    name: str
    path: str  #: A video, or a folder of pictures in the order of their names.
    offset: int = 0  #: Added to a frame's number for the number of its picture.
    film: footage.Recording | None = None  #: Of a video, what `footage.video` says of it.
    rate: Fraction = Fraction(1)  #: Of a video: frames a second.

    def frames(self, first: int = 0, step: int = 1, last: int | None = None) -> Iterator[tuple[int, Bytes]]:
        """Frame numbers and grey pictures, (height, width), of frames first, first + step, ... up to last. Frames that the
        recording does not have are left out. `Error` names the file of a picture that cannot be read."""
        return self._files(first, step, last) if self.film is None else self._video(first, step, last)

    def _files(self, first: int, step: int, last: int | None) -> Iterator[tuple[int, Bytes]]:
        for index, name in enumerate(pictures_of(self.path)):
            frame = index - self.offset
            if last is not None and frame > last:
                return
            if frame < first or (frame - first) % step:
                continue
            path = os.path.join(self.path, name)
            with named(path, frame):  # one that has too many pixels for OpenCV
                # Nothing in a capture goes by Exif.
                grey = cv2.imread(path, cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
            if grey is None:
                raise Error(f"{path}: frame {frame}: is no picture that can be read", file=path)
            yield frame, grey

    def _video(self, first: int, step: int, last: int | None) -> Iterator[tuple[int, Bytes]]:
        assert self.film is not None
        for frame, picture in footage.pictures(self.film, self.rate, self.offset, first, step, last):
            with named(self.path, frame):
                grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
            yield frame, grey

    def count(self) -> int:
        """Pictures that it has."""
        return len(pictures_of(self.path)) if self.film is None else self.film.count


def pictures_of(folder: str) -> list[str]:
    """Names of the pictures in a folder: by the last number in their names where all have one, else by name."""
    names = [name for name in os.listdir(folder) if name.lower().endswith(footage.BOARD_STILLS)]

    def order(name: str) -> tuple[int, str]:
        digits = "".join(one if one.isdigit() else " " for one in os.path.splitext(name)[0]).split()
        return (int(digits[-1]) if digits else -1, name)

    return sorted(names, key=order)


def recordings_of(
    folder: str,
    offsets: Mapping[str, int] | None = None,
    names: Sequence[str] = (),
    exclude: Sequence[str] = (),
) -> list[Recording]:
    """The recordings in a folder, by camera: see `footage.entries`. offsets: frames by camera. `UsageError` if there is nothing to
    read, two recordings are of one camera, videos differ in their rates, or an offset is of no camera."""
    if not os.path.isdir(folder):
        raise UsageError(
            f"{folder}: expected a folder with a video or a folder of pictures for each camera", file=folder
        )
    found = footage.entries(folder, names, exclude)
    offsets = offsets or {}
    for camera in offsets:
        if camera not in found:
            raise UsageError(
                f"offset {camera}: expected one of {', '.join(found)}, found no such camera", file=folder
            )
    films = {camera: footage.video(path, camera) for camera, path in found.items() if not os.path.isdir(path)}
    moving = any(film.count > 1 for film in films.values())
    rate = footage.common_rate(list(films.values())) if moving else Fraction(1)
    return [
        Recording(camera, path, offsets.get(camera, 0), films.get(camera), rate)
        for camera, path in found.items()
    ]


def in_step(
    recordings: Sequence[Recording],
    method: Method,
    given: Collection[str] = (),
    progress: Progress | None = None,
) -> tuple[list[Recording], list[str]]:
    """The same recordings with offsets that are found for those that are not in `given`, and warnings. Folders of pictures have no
    time. `UsageError`: there is one."""
    folders = [one.name for one in recordings if one.film is None]
    if folders:
        raise UsageError(f"expected videos to synchronise, found pictures of {', '.join(folders)}")
    films = [one.film for one in recordings if one.film is not None]
    rate = recordings[0].rate
    found = synchronised(films, method, rate, progress or (lambda stage, done, count: None))
    warnings = [
        f"camera {name}: its offset by {method} is not certain ({one.confidence:.2f}): pass one"
        for name, one in found.items()
        if one.confidence < TRUSTED and name not in given
    ]
    return [
        one
        if one.name in given
        else dataclasses.replace(one, offset=round(found[one.name].seconds * float(rate)))
        for one in recordings
    ], warnings
