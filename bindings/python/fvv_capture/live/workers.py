"""Processes that make masks and hulls of frames. Pictures and masks are in memory that they share; each has a frame at a time."""

from __future__ import annotations

import contextlib
import dataclasses
import multiprocessing
import multiprocessing.connection
import os
import signal
import time
from collections.abc import Sequence
from multiprocessing.shared_memory import SharedMemory
from typing import Any

import numpy
from fvv import Camera
from fvv.errors import Error
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

from .. import hull, pipeline
from ..keying import Keyer

cv2: Any = optional_import("cv2", "capture")

#: Frames that may wait in a process beside the one that it makes.
AHEAD = 2
#: Settings of the C library with which a process keeps its memory: tables as large as pictures come and go with each frame.
KEEPING = {"MALLOC_MMAP_THRESHOLD_": str(1 << 30), "MALLOC_TRIM_THRESHOLD_": str(1 << 30)}


@dataclasses.dataclass(frozen=True)
class Setting:
    """What a process needs to know."""

    cameras: Sequence[Camera]
    keyers: Sequence[Keyer]
    quick: Sequence[Keyer]  #: For frames that get coarser cells than usual.
    hull: hull.HullOptions
    bounds: tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclasses.dataclass(frozen=True)
class Made:
    """What became of a frame."""

    number: int
    slot: int
    positions: bytes  #: Three float32 a vertex.
    faces: bytes  #: Three uint32 a face.
    seconds: float  #: That it took.
    failure: str  #: Empty: none.


class Slots:
    """Memory for the pictures and masks of some frames, as a record of spec/frame-pipe.md has them."""

    def __init__(self, cameras: Sequence[Camera], count: int, name: str | None = None) -> None:
        """name: of memory that exists."""
        self._sizes = [(camera.height, camera.width) for camera in cameras]
        self._size = sum(4 * height * width for height, width in self._sizes)
        self._memory = SharedMemory(name, name is None, self._size * count if name is None else 0)
        self._is_owner = name is None

    @property
    def name(self) -> str:
        return self._memory.name

    def bytes_of(self, slot: int) -> memoryview:
        assert self._memory.buf is not None
        return self._memory.buf[slot * self._size : (slot + 1) * self._size]

    def images(self, slot: int) -> list[tuple[NDArray[numpy.uint8], NDArray[numpy.uint8]]]:
        """The picture and the mask of each camera."""
        out = []
        at = slot * self._size
        for height, width in self._sizes:
            picture: NDArray[numpy.uint8] = numpy.ndarray(
                (height, width, 3), numpy.uint8, self._memory.buf, at
            )
            mask: NDArray[numpy.uint8] = numpy.ndarray(
                (height, width), numpy.uint8, self._memory.buf, at + 3 * height * width
            )
            out.append((picture, mask))
            at += 4 * height * width
        return out

    def close(self) -> None:
        self._memory.close()
        if self._is_owner:
            self._memory.unlink()


def _make(setting: Setting, slots: Slots, mattes: list[NDArray[numpy.uint8]], slot: int, scale: float) -> Any:
    masks = []
    keyers = setting.keyers if scale == 1 else setting.quick
    for keyer, matte, (picture, mask) in zip(keyers, mattes, slots.images(slot)):
        mask[:] = keyer.mask(picture, matte)
        masks.append(mask)
    options = setting.hull
    scaled = dataclasses.replace(
        options,
        cell=None if options.cell is None else options.cell * scale,
        max_error=None if options.max_error is None else options.max_error * scale,
    )
    return hull.carve(setting.cameras, masks, setting.bounds, scaled)


def _work(setting: Setting, name: str, channel: multiprocessing.connection.Connection) -> None:
    """A process: takes (number, slot, scale), sends `Made`."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # who began it ends it, after the frames that are there
    cv2.setNumThreads(1)  # processes are what runs at once
    slots = Slots(setting.cameras, 0, name)
    try:
        mattes = [pipeline.volume_pixels(camera, setting.bounds) for camera in setting.cameras]
        with contextlib.suppress(Error):
            for scale in (4.0, 1.0):
                _make(setting, slots, mattes, 0, scale)  # the first call of many functions takes long
        channel.send(None)  # it is ready
        while True:
            task = channel.recv()
            if task is None:
                return
            number, slot, scale = task
            start = time.perf_counter()
            try:
                made = _make(setting, slots, mattes, slot, scale)
                positions = numpy.ascontiguousarray(made.positions, "<f4").tobytes()
                faces = numpy.ascontiguousarray(made.indices, "<u4").tobytes()
                channel.send(Made(number, slot, positions, faces, time.perf_counter() - start, ""))
            except Error as error:
                channel.send(Made(number, slot, b"", b"", time.perf_counter() - start, str(error)))
    except (EOFError, BrokenPipeError):
        return  # who began it is gone, or ends it
    finally:
        slots.close()


class Workers:
    """Some processes."""

    def __init__(self, count: int, setting: Setting, slots: Slots) -> None:
        context = multiprocessing.get_context("spawn")
        self._channels: list[multiprocessing.connection.Connection] = []
        self._processes: list[Any] = []
        self._waiting = [0] * count
        self._seconds = 0.0  # that a frame takes, about
        former = {key: os.environ.get(key) for key in KEEPING}
        os.environ.update({key: value for key, value in KEEPING.items() if former[key] is None})
        try:
            self._start(context, count, setting, slots)
        finally:
            for key, value in former.items():
                if value is None:
                    os.environ.pop(key, None)

    def _start(self, context: Any, count: int, setting: Setting, slots: Slots) -> None:
        for number in range(count):
            own, other = context.Pipe()
            process = context.Process(
                target=_work, args=(setting, slots.name, other), name=f"frames {number}", daemon=True
            )
            process.start()
            other.close()
            self._channels.append(own)
            self._processes.append(process)
        for channel in self._channels:  # a start takes seconds, in which frames would be lost
            self._receive(channel)

    def is_busy(self, patience: float) -> bool:
        """Whether a frame that is given now would take longer, in seconds, though a process that has none takes any."""
        least = min(self._waiting)
        return least > AHEAD or (least > 0 and (least + 1) * self._seconds > patience)

    @property
    def waiting(self) -> int:
        """Frames that were given and are not back."""
        return sum(self._waiting)

    def give(self, number: int, slot: int, scale: float) -> None:
        """To the process with the least work. Not while all are busy."""
        one = self._waiting.index(min(self._waiting))
        self._waiting[one] += 1
        self._channels[one].send((number, slot, scale))

    def take(self, timeout: float) -> list[Made]:
        """What is done, after a wait of at most some seconds. Raises `Error` when a process has ended."""
        out = []
        for channel in multiprocessing.connection.wait(self._channels, timeout):
            assert isinstance(channel, multiprocessing.connection.Connection)
            made = self._receive(channel)
            self._seconds += (made.seconds - self._seconds) / (4 if self._seconds else 1)
            out.append(made)
            self._waiting[self._channels.index(channel)] -= 1
        return out

    def _receive(self, channel: multiprocessing.connection.Connection) -> Any:
        try:
            return channel.recv()
        except (EOFError, ConnectionResetError):
            raise Error("a process that makes frames has ended unexpectedly") from None

    def close(self) -> None:
        for channel in self._channels:
            try:
                channel.send(None)
            except OSError:
                continue
        for process in self._processes:
            process.join(5)
            if process.is_alive():
                process.kill()
                process.join()
        for channel in self._channels:
            channel.close()
