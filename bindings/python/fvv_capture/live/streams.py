"""Pictures of cameras as they come: anything that FFmpeg opens, read by PyAV. Files are played at their own speed."""

from __future__ import annotations

import dataclasses
import gc
import os
import shlex
import threading
import time
from collections.abc import Mapping, Sequence
from typing import Any, Callable

import numpy
from fvv.errors import UsageError
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

from .. import footage
from .moments import Moments

av: Any = optional_import("av", "live")

#: Seconds after which a camera that was lost is opened again.
AGAIN = 1.0
#: What is about us and not for FFmpeg.
_OWN = ("format", "loop")


@dataclasses.dataclass(frozen=True)
class Source:
    """Where the pictures of a camera come from."""

    name: str  #: Of the camera.
    address: str  #: A file, a device, or a URL.
    format: str | None = None  #: Of FFmpeg, where it is not found out: "v4l2".
    loop: bool = False  #: A file begins again at its end.
    options: Mapping[str, str] = dataclasses.field(
        default_factory=dict
    )  #: Of FFmpeg's demuxers and protocols.

    @property
    def is_file(self) -> bool:
        return os.path.isfile(self.address)


def sources(path: str, names: Sequence[str], exclude: Sequence[str]) -> list[Source]:
    """Of the cameras with these names, in their order.

    path: a folder of videos; or a text file with a line NAME ADDRESS [OPTION=VALUE ...] for each camera, quoted as in a shell, in which # begins a
    comment. Raises OSError and `UsageError`.
    """
    if os.path.isdir(path):
        found = {name: Source(name, file) for name, file in footage.entries(path, (), exclude).items()}
        folders = [source.address for source in found.values() if not source.is_file]
        if folders:
            raise UsageError(f"{folders[0]}: expected a video, found a folder", file=folders[0])
    else:
        found = _listed(path)
    unknown = [name for name in found if name not in names]
    if unknown:
        raise UsageError(
            f"{path}: there is no camera {unknown[0]} in the calibration: {', '.join(names)}", file=path
        )
    return [found[name] for name in names if name in found and name not in exclude]


def _listed(path: str) -> dict[str, Source]:
    found: dict[str, Source] = {}
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            try:
                words = shlex.split(line, comments=True)
            except ValueError as error:
                raise UsageError(f"{path}:{number}: {error}", file=path) from None
            if not words:
                continue
            pairs = [word.partition("=") for word in words[2:]]
            if len(words) < 2 or not all(key and sign for key, sign, _ in pairs):
                raise UsageError(f"{path}:{number}: expected NAME ADDRESS [OPTION=VALUE ...]", file=path)
            if words[0] in found:
                raise UsageError(f"{path}:{number}: camera {words[0]} has a line before", file=path)
            given = {key: value for key, _, value in pairs}
            # Names of files are relative to the list.
            beside = os.path.join(os.path.dirname(os.path.abspath(path)), words[1])
            address = beside if os.path.isfile(beside) else words[1]
            options = {key: value for key, value in given.items() if key not in _OWN}
            found[words[0]] = Source(
                words[0], address, given.get("format"), given.get("loop", "0") != "0", options
            )
    if not found:
        raise UsageError(f"{path}: expected a camera or more, found none", file=path)
    return found


class CameraReader(threading.Thread):
    """Puts the pictures of one camera into moments, and opens it again when it is lost."""

    def __init__(
        self,
        index: int,
        source: Source,
        size: tuple[int, int],
        moments: Moments[NDArray[numpy.uint8]],
        shift: float,
        patience: float,
        tell: Callable[[str, str], object],
    ) -> None:
        """shift: seconds by which its pictures are older than they look. patience: seconds without a picture after which it counts
        as lost. tell: is called with the kind of an event and a sentence, on this thread."""
        super().__init__(name=f"camera {source.name}", daemon=True)
        self._index, self._source, self._size = index, source, size
        self._moments, self._shift, self._patience, self._tell = moments, shift, patience, tell
        self._stop_wanted = threading.Event()
        self._wrong_size: tuple[int, int] | None = None
        self._is_away = False
        self.epoch = 0.0  #: When the show began, on the monotonic clock. Set before it starts.
        self.pictures = 0  #: That were decoded.
        self.stops = 0  #: How often it was lost.

    def stop(self) -> None:
        self._stop_wanted.set()

    def run(self) -> None:
        source, played = self._source, 0.0
        while not self._stop_wanted.is_set():
            why = "it ended"
            try:
                played = self._play(played)
            except (av.error.FFmpegError, OSError, ValueError) as error:
                why = str(error)
            gc.collect()  # PyAV's containers are in cycles, and their memory is not Python's: nothing else would free it
            if source.is_file and (not source.loop or why != "it ended"):
                if why != "it ended":
                    self._lost(why)
                break
            if not source.is_file:
                self._lost(why)
                self._stop_wanted.wait(AGAIN)
        self._moments.end(self._index)

    def _lost(self, why: str) -> None:
        if not self._is_away and not self._stop_wanted.is_set():
            self.stops += 1
            self._tell("stopped", f"camera {self._source.name}: {why}")
        self._is_away = True

    def _play(self, before: float) -> float:
        """Until the stream ends. before: seconds of the file that were played in rounds before. Returns these and this round."""
        source = self._source
        with av.open(
            source.address,
            format=source.format,
            options=dict(source.options),
            timeout=None if source.is_file else (self._patience, self._patience),
        ) as container:
            if not container.streams.video:
                raise ValueError("expected a video, found none")
            stream = container.streams.video[0]
            stream.thread_count = (
                1  # cameras are decoded at once, and threads that decode ahead delay pictures
            )
            rate = stream.average_rate or stream.guessed_rate
            spacing = 1 / float(rate) if rate else 0.0
            start = zero = end = 0.0
            for count, frame in enumerate(container.decode(stream)):
                if self._stop_wanted.is_set():
                    break
                now = time.monotonic() - self.epoch
                shown = frame.time
                if shown is None:  # bare pictures, as in a file .h264
                    shown = count * spacing if source.is_file else now
                if count == 0:
                    # A file's first picture was taken when the show began, a stream's when it came.
                    start, zero = shown, before if source.is_file else now
                    if self._is_away:
                        self._is_away = False
                        self._tell("back", f"camera {source.name}: sends pictures again")
                at = zero + shown - start
                end = at + spacing
                if source.is_file and self._stop_wanted.wait(max(0.0, at - now)):
                    break
                self.pictures += 1
                self._take(frame, at - self._shift, spacing)
            return end

    def _take(self, frame: Any, at: float, spacing: float) -> None:
        number = self._moments.place(at, spacing)
        if number is None or not self._moments.wants(self._index, number):
            return
        size = (frame.width, frame.height)
        if size != self._size:
            if size != self._wrong_size:
                self._tell(
                    "size",
                    f"camera {self._source.name}: expected pictures of {self._size[0]} x {self._size[1]}, found "
                    f"{size[0]} x {size[1]}",
                )
            self._wrong_size = size
            return
        self._wrong_size = None
        self._moments.put(self._index, number, frame.to_ndarray(format="rgb24"))
