"""The pictures of a board walk: a video or a folder of pictures for each camera, by frame number."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Mapping

import numpy
from fvv.errors import Error, UsageError
from numpy.typing import NDArray

from ..opencv import cv2, named

Bytes = NDArray[numpy.uint8]

PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
VIDEOS = (".mp4", ".mov", ".mkv", ".avi", ".webm", ".m4v", ".mts", ".ts", ".mxf", ".ivf")


@dataclasses.dataclass(frozen=True)
class Recording:
    """What one camera recorded."""

    name: str
    path: str  #: A video, or a folder of pictures in the order of their names.
    offset: int = 0  #: Added to a frame's number for the number of its picture.

    def frames(self, first: int = 0, step: int = 1, last: int | None = None) -> Iterator[tuple[int, Bytes]]:
        """Frame numbers and grey pictures, (height, width), of frames first, first + step, ... up to last. Frames that the
        recording does not have are left out. `Error` names the file of a picture that cannot be read."""
        return self._files(first, step, last) if os.path.isdir(self.path) else self._video(first, step, last)

    def _files(self, first: int, step: int, last: int | None) -> Iterator[tuple[int, Bytes]]:
        for index, name in enumerate(pictures_of(self.path)):
            frame = index - self.offset
            if last is not None and frame > last:
                return
            if frame < first or (frame - first) % step:
                continue
            path = os.path.join(self.path, name)
            with named(path, frame):  # one that has too many pixels for OpenCV
                grey = cv2.imread(path, cv2.IMREAD_GRAYSCALE)
            if grey is None:
                raise Error(f"{path}: frame {frame}: is no picture that can be read", file=path)
            yield frame, grey

    def _video(self, first: int, step: int, last: int | None) -> Iterator[tuple[int, Bytes]]:
        video = cv2.VideoCapture(self.path)
        try:
            if not video.isOpened():
                raise Error(f"{self.path}: is no video that can be read", file=self.path)
            index = -1
            while True:
                # Decoded one by one: seeking by number is not exact in all containers.
                if not video.grab():
                    break
                index += 1
                frame = index - self.offset
                if last is not None and frame > last:
                    return
                if frame < first or (frame - first) % step:
                    continue
                with named(self.path, frame):
                    good, picture = video.retrieve()
                    if not good:
                        raise Error(f"{self.path}: frame {frame}: cannot be decoded", file=self.path)
                    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
                yield frame, grey
            if index < 0:
                raise Error(f"{self.path}: has no picture that can be decoded", file=self.path)
        finally:
            video.release()

    def count(self) -> int:
        """Pictures that it has, or that a video says it has."""
        if os.path.isdir(self.path):
            return len(pictures_of(self.path))
        video = cv2.VideoCapture(self.path)
        try:
            return max(0, int(video.get(cv2.CAP_PROP_FRAME_COUNT)))
        finally:
            video.release()


def pictures_of(folder: str) -> list[str]:
    """Names of the pictures in a folder: by the last number in their names where all have one, else by name."""
    names = [name for name in os.listdir(folder) if name.lower().endswith(PICTURES)]

    def order(name: str) -> tuple[int, str]:
        digits = "".join(one if one.isdigit() else " " for one in os.path.splitext(name)[0]).split()
        return (int(digits[-1]) if digits else -1, name)

    return sorted(names, key=order)


def recordings_of(folder: str, offsets: Mapping[str, int] | None = None) -> list[Recording]:
    """The recordings in a folder, by name: a video or a folder of pictures for each camera. offsets: frames by camera.
    `UsageError` if there is nothing to read, two recordings have one name, or an offset is of no camera."""
    if not os.path.isdir(folder):
        raise UsageError(
            f"{folder}: expected a folder with a video or a folder of pictures for each camera", file=folder
        )
    found: dict[str, str] = {}
    for name in sorted(os.listdir(folder)):
        path = os.path.join(folder, name)
        stem, extension = os.path.splitext(name)
        if name.startswith("."):
            continue
        if os.path.isdir(path):
            stem = name
            if not pictures_of(path):
                continue
        elif extension.lower() not in VIDEOS:
            continue
        if stem in found:
            raise UsageError(
                f"{folder}: camera {stem}: expected one recording, found {os.path.basename(found[stem])} and {name}",
                file=folder,
            )
        found[stem] = path
    if not found:
        raise UsageError(
            f"{folder}: expected a video or a folder of pictures for each camera, found none", file=folder
        )
    offsets = offsets or {}
    for name in offsets:
        if name not in found:
            raise UsageError(
                f"offset {name}: expected one of {', '.join(found)}, found no such camera", file=folder
            )
    return [Recording(name, path, offsets.get(name, 0)) for name, path in found.items()]
