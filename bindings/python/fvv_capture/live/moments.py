"""Which pictures of cameras belong to one frame, as they arrive."""

from __future__ import annotations

import dataclasses
import math
import threading
from typing import Generic, TypeVar

Picture = TypeVar("Picture")


@dataclasses.dataclass
class Moment(Generic[Picture]):
    """The pictures of a frame, by camera."""

    number: int
    due: float  #: When it was filmed, on the clock of `Moments`.
    pictures: list[Picture | None]

    @property
    def missing(self) -> list[int]:
        return [camera for camera, picture in enumerate(self.pictures) if picture is None]


class Moments(Generic[Picture]):
    """Frames in the order of time. Several threads may call; times are seconds on one clock that never goes back.

    A frame is whole when all cameras have its picture. It is given up when it is `patience` seconds late, or when every camera has
    ended. Frames begin with the first one of which all cameras may have a picture, which has the number 0.
    """

    def __init__(self, cameras: int, rate: float, patience: float) -> None:
        self._rate, self._patience = rate, patience
        self._lock = threading.Lock()
        self._found: dict[int, list[Picture | None]] = {}
        self._first: list[int | None] = [None] * cameras
        self._ended = [False] * cameras
        self._origin: int | None = None
        self._next = 0
        self.late = [0] * cameras  #: Pictures that came after their frame was given up.

    def place(self, time: float, spacing: float) -> int | None:
        """The frame at which a picture was taken; None: the picture next to it is nearer. spacing: seconds between pictures."""
        at = time * self._rate
        number = math.floor(at + 0.5)
        near = min(0.5, max(spacing * self._rate, 1e-6) / 2)
        return number if -near - 1e-9 <= at - number < near - 1e-9 else None

    def wants(self, camera: int, number: int) -> bool:
        """Whether the picture of a frame is still of use. It need not be converted otherwise."""
        with self._lock:
            self._begin(camera, number)
            if self._origin is not None and number < self._next:
                self.late[camera] += 1
                return False
            row = self._found.get(number)
            return row is None or row[camera] is None

    def put(self, camera: int, number: int, picture: Picture) -> None:
        with self._lock:
            if self._origin is None:
                # One camera may be minutes late: what the others had until then is no part of the show.
                kept = number - math.ceil(2 * self._rate)
                for former in [n for n in self._found if n < kept]:
                    del self._found[former]
            if self._origin is None or number >= self._next:
                row = self._found.setdefault(number, [None] * len(self._first))
                row[camera] = picture

    def end(self, camera: int) -> None:
        """It sends no more."""
        with self._lock:
            self._ended[camera] = True

    @property
    def has_begun(self) -> bool:
        with self._lock:
            return self._origin is not None

    @property
    def waited_for(self) -> list[int]:
        """Cameras that no picture came of."""
        with self._lock:
            return [camera for camera, first in enumerate(self._first) if first is None]

    @property
    def is_over(self) -> bool:
        """All cameras have ended, and all frames were taken."""
        with self._lock:
            return all(self._ended) and not self._found

    def take(self, now: float) -> list[Moment[Picture]]:
        """Frames that are whole or given up, each once."""
        out: list[Moment[Picture]] = []
        with self._lock:
            if self._origin is None:
                return out
            while True:
                due = self._next / self._rate
                row = self._found.get(self._next)
                is_whole = row is not None and all(picture is not None for picture in row)
                is_over = all(self._ended)
                if not is_whole and (not self._found if is_over else now - due <= self._patience):
                    return out
                self._found.pop(self._next, None)
                out.append(
                    Moment(
                        self._next - self._origin, due, row if row is not None else [None] * len(self._first)
                    )
                )
                self._next += 1

    def _begin(self, camera: int, number: int) -> None:
        if self._first[camera] is None:
            self._first[camera] = number
        if self._origin is None and None not in self._first:
            self._origin = self._next = max(number for number in self._first if number is not None)
            for former in [n for n in self._found if n < self._next]:
                del self._found[former]
