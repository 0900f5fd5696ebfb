"""Push reading: for streams that arrive piece by piece."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any, Union

import numpy
from numpy.typing import NDArray

from . import _core
from .clip import _given
from .errors import UsageError
from .frames import ReceivedFrame
from .records import Description, Limits, Problem


@dataclasses.dataclass(frozen=True)
class Configuration:
    """A configuration block arrived: tracks, cameras and lattice from here on."""

    description: Description  #: What holds for the frames after it.


@dataclasses.dataclass(frozen=True)
class FrameEvent:
    """A whole frame arrived."""

    frame: ReceivedFrame  #: It stays valid while the reader goes on.


@dataclasses.dataclass(frozen=True)
class SoundEvent:
    """Sound of one track arrived. Those of a track follow each other without a gap, unless something was lost."""

    track: int
    rate: int  #: Samples per second.
    start: float  #: Seconds of the stream: when the first of `samples` is heard.
    samples: NDArray[numpy.float32]  #: (samples, channels), full scale 1.
    position: (
        tuple[float, float, float] | None
    )  #: Metres, axes of the world: from where; None: from everywhere.


@dataclasses.dataclass(frozen=True)
class Damage:
    """Something is damaged. The rest of its group is left out; the next group continues."""

    problem: Problem  #: What is wrong, and where.
    skipped: int  #: Bytes that were passed over; 0 when a rule is broken and no byte is lost.


@dataclasses.dataclass(frozen=True)
class End:
    """The footer arrived: the stream is complete."""


Event = Union[Configuration, FrameEvent, SoundEvent, Damage, End]


class Reader:
    """Bytes in, events out. Any split of the same bytes gives the same events.

    pictures, visibility, sound: decode these too; without visibility=True, `frame.visibility` raises `UsageError`, and without
    sound=True there are no `SoundEvent`s, which come before the frame of their time or between frames. join: the stream is joined late; it begins with the configuration and then any group.
    """

    def __init__(
        self,
        *,
        name: str = "stream",
        rung: int = 0,
        pictures: bool = True,
        visibility: bool = False,
        sound: bool = False,
        join: bool = False,
        limits: Limits | None = None,
    ) -> None:
        if rung < 0:
            raise UsageError(f"rung {rung}: expected 0 or more")
        self._reader = _core.LiveReader(name, rung, pictures, visibility, sound, join, _given(limits))
        self._has_visibility = visibility
        self._description: Description | None = None

    def feed(self, data: Any) -> list[Event]:
        """Takes bytes, or anything with the buffer protocol, and returns what they complete. Raises an error that ends the
        stream (a later version, a limit) once the events before it were returned."""
        return list(self._events(self._reader.feed(data)))

    def finish(self) -> list[Event]:
        """No more bytes will come: returns what was waiting for them."""
        return list(self._events(self._reader.finish()))

    def _events(self, raw: list[tuple[Any, ...]]) -> Iterator[Event]:
        for kind, *rest in raw:
            if kind == "configuration":
                self._description = Description.of(rest[0])
                yield Configuration(self._description)
            elif kind == "damage":
                yield Damage(Problem(*rest[0]), rest[1])
            elif kind == "sound":
                track, rate, start, samples, position = rest
                yield SoundEvent(track, rate, start / rate, samples, position)
            elif kind == "end":
                yield End()
            elif self._description is not None:
                yield FrameEvent(ReceivedFrame(self._description, rest[0], self._has_visibility))
