"""From streams of cameras to a stream of hulls, while they are filmed. Nothing is lost silently: each frame is packed, or an event."""

from __future__ import annotations

import dataclasses
import math
import os
import queue
import threading
import time
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, Callable

import numpy
from fvv.errors import UsageError
from fvv.outputs import Target
from fvv.writer import pack_pipe
from numpy.typing import NDArray

from .. import footage, hull
from ..cameras import Calibration
from ..clean_plate import plate_of
from ..keying import Keyer, KeyOptions
from .fineness import Fineness
from .frame_pipe import FramePipe, PipeClosed
from .moments import Moment, Moments
from .streams import CameraReader, Source
from .workers import AHEAD, Made, Setting, Slots, Workers

#: Seconds for which a frame is waited for after it was filmed.
PATIENCE = 0.5
#: A show of unknown length.
MOST_FRAMES = 10_000_000
#: Pictures of the empty stage that are read.
PLATE_PICTURES = 34
#: Seconds in which the encoder may take nothing at the start, and bytes of pictures that wait for it.
PLANNING, MOST_MEMORY = 1.5, 512 << 20
#: Seconds beyond `Show.idle` after which the encoder takes the show for hung.
HUNG = 30.0
#: Part of the longest delay that a hull may take.
SHARE = 0.3
#: Seconds between looks at what came.
TICK = 0.004


@dataclasses.dataclass(frozen=True)
class Event:
    """Something that viewers, or the crew, may notice."""

    kind: str  #: Those of `fvv.writer.OnEvent`, and "stopped", "back", "size" of a camera, "coarser" and "finer" of hulls.
    frame: int | None  #: None: it is about no single frame.
    age: float  #: Of the frame, in seconds.
    text: str


@dataclasses.dataclass(frozen=True)
class Show:
    """What to make, and of what."""

    calibration: Calibration
    sources: Sequence[Source]  #: Of cameras of the calibration.
    rate: Fraction  #: Frames a second.
    bounds: tuple[tuple[float, float, float], tuple[float, float, float]]  #: Where the action is, in metres.
    key: KeyOptions
    hull: hull.HullOptions
    plates: str | None = None  #: Films of the empty stage, by name of the camera.
    offsets: Mapping[str, float] = dataclasses.field(
        default_factory=dict
    )  #: Frames by which a camera is late.
    jobs: int = 2  #: Processes that make frames.
    max_delay: float = 2.0  #: Seconds from light to the last byte of a group.
    idle: float = 10.0  #: Seconds without a whole frame after which the show ends.
    name: str = ""
    mux: Mapping[str, Any] = dataclasses.field(default_factory=dict)  #: Options of `fvv.Writer`.


@dataclasses.dataclass
class Summary:
    """What was made."""

    mux: dict[str, Any]  #: As `pack_pipe` returns it.
    frames: int = 0  #: That were filmed.
    hulls: int = 0  #: That were made.
    seconds: float = 0.0  #: From the first frame to the end.
    delays: list[float] = dataclasses.field(default_factory=list)  #: From light to the hull.
    coarsest: int = 0  #: Step of the cell.
    cameras: dict[str, dict[str, int]] = dataclasses.field(default_factory=dict)
    end: str = ""  #: Why it ended.
    troubled: bool = False  #: A frame was lost, or a camera stopped.


def keyers(show: Show) -> tuple[list[Keyer], list[Keyer]]:
    """Of each camera, by its empty stage or the colour of the screen; and those that work at half the size."""
    fine, quick = [], []
    plates = None if show.plates is None else footage.find(show.plates)
    for source in show.sources:
        plate = None
        if plates is not None:
            found = plates.get(source.name)
            if found is None:
                raise UsageError(
                    f"{show.plates}: expected a recording of {source.name}, found {', '.join(plates)}",
                    file=show.plates,
                )
            pictures = footage.pictures(found, found.rate() or show.rate, last=PLATE_PICTURES - 1)
            plate = plate_of(picture for _, picture in pictures)
        elif show.key.backing is None:
            raise UsageError(
                "expected films of the empty stage (--plate), or the colour of the screen (--backing)"
            )
        entry = next(e for e in show.calibration.entries if e["name"] == source.name)
        half = min(show.key.work_side, max(int(entry["width"]), int(entry["height"]))) // 2
        fine.append(Keyer(plate, show.key))
        quick.append(Keyer(plate, dataclasses.replace(show.key, work_side=max(64, half))))
    return fine, quick


class _Writer(threading.Thread):
    """Writes records on a thread of its own, so that a full pipe stops nothing else."""

    def __init__(self, pipe: FramePipe, slots: Slots, free: Callable[[int], object]) -> None:
        super().__init__(name="records", daemon=True)
        self._pipe, self._slots, self._free = pipe, slots, free
        self._queue: queue.SimpleQueue[tuple[int, int, Made | str] | None] = queue.SimpleQueue()
        self.is_closed = False

    def put(self, number: int, filmed: int, content: Made | str) -> None:
        self._queue.put((number, filmed, content))

    def end(self) -> None:
        self._queue.put(None)

    def run(self) -> None:
        try:
            while (item := self._queue.get()) is not None:
                number, filmed, content = item
                if isinstance(content, str):
                    self._pipe.lost(number, content)
                    continue
                self._pipe.frame(
                    number, filmed, content.positions, content.faces, self._slots.bytes_of(content.slot)
                )
                self._free(content.slot)
            self._pipe.end()
        except PipeClosed:
            self.is_closed = True


class _Packer(threading.Thread):
    """The encoder."""

    def __init__(
        self, pipe: int, target: Target, force: bool, show: Show, tell: Callable[[Event], object]
    ) -> None:
        super().__init__(name="encoder", daemon=True)
        self._arguments = (pipe, target)
        options = {"max_delay": show.max_delay, "idle": show.idle + HUNG, "force": force, **show.mux}
        self._options: dict[str, Any] = options
        self._tell = tell
        self.summary: dict[str, Any] | None = None
        self.failure: BaseException | None = None

    def run(self) -> None:
        try:
            self.summary = pack_pipe(
                *self._arguments,
                on_event=lambda kind, frame, age, text: self._tell(Event(kind, frame, age, text)),
                **self._options,
            )
        except BaseException as error:  # raised again by who began it
            self.failure = error
        finally:
            os.close(self._arguments[0])


def _description(show: Show, entries: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    cameras = []
    for entry in entries:
        made = {key: value for key, value in entry.items() if key not in ("pictures", "masks")}
        cameras.append({**made, "pictures": f"{entry['id']}/%d", "masks": f"{entry['id']}/mask%d"})
    return {
        "fvv_capture": 1,
        "name": show.name,
        "frame_rate": f"{show.rate.numerator}/{show.rate.denominator}",
        "frames": {"first": 0, "count": MOST_FRAMES},
        "units": "metres" if show.calibration.unit_known else "unknown",
        "up": show.calibration.up,
        "meshes": {"pattern": "%d.ply"},
        "cameras": cameras,
    }


def run(
    show: Show,
    target: Target,
    force: bool = False,
    on_event: Callable[[Event], object] = lambda event: None,
    is_stopped: Callable[[], bool] = lambda: False,
) -> Summary:
    """Until all cameras have ended, is_stopped, or nothing whole came for `Show.idle` seconds. on_event is called on any thread.

    Raises what `fvv.mux` raises, `UsageError` for what does not fit, `Error` if no frame was whole."""
    by_name = {str(entry["name"]): i for i, entry in enumerate(show.calibration.entries)}
    chosen = [by_name[source.name] for source in show.sources]
    entries = [show.calibration.entries[i] for i in chosen]
    moving = [str(entry["name"]) for entry in entries if entry.get("per_frame")]
    if moving:
        raise UsageError(f"camera {moving[0]} moves: expected cameras that stand still")
    cameras = [show.calibration.cameras[i] for i in chosen]
    setting = Setting(cameras, *keyers(show), show.hull, show.bounds)
    return _Run(show, cameras, entries, setting, on_event, is_stopped).run(target, force)


class _Run:
    """The state of a show."""

    def __init__(
        self,
        show: Show,
        cameras: Sequence[Any],
        entries: Sequence[Mapping[str, Any]],
        setting: Setting,
        on_event: Callable[[Event], object],
        is_stopped: Callable[[], bool],
    ) -> None:
        self._show, self._cameras, self._entries, self._setting = show, cameras, entries, setting
        self._on_event, self._is_stopped = on_event, is_stopped
        self._moments: Moments[NDArray[numpy.uint8]] = Moments(len(cameras), float(show.rate), PATIENCE)
        self._fineness = Fineness(float(show.rate), show.jobs)
        self._summary = Summary({})
        self._done: dict[int, tuple[float, Made | str]] = {}  # by number, before their turn
        self._due: dict[int, float] = {}  # of frames that processes have
        self._next = 0
        self._epoch = 0.0
        self._lock = threading.Lock()
        self._free: list[int] = []
        self._rate = float(show.rate)

    def _tell(self, kind: str, text: str) -> None:
        if kind == "stopped":
            self._summary.troubled = True
        self._on_event(Event(kind, None, 0.0, text))

    def run(self, target: Target, force: bool) -> Summary:
        show, summary = self._show, self._summary
        count = self._slot_count()
        self._free = list(range(count))
        slots = Slots(self._cameras, count)
        workers = Workers(show.jobs, self._setting, slots)
        readers = [
            CameraReader(
                i, source, (camera.width, camera.height), self._moments,
                float(show.offsets.get(source.name, 0)) / self._rate, max(1.0, show.idle / 2), self._tell,
            )
            for i, (source, camera) in enumerate(zip(show.sources, self._cameras))
        ]  # fmt: skip
        receiving, sending = os.pipe()
        packer = _Packer(receiving, target, force, show, self._on_event)
        writer: _Writer | None = None
        try:
            packer.start()
            writer = _Writer(FramePipe(sending, _description(show, self._entries)), slots, self._freed)
            writer.start()
            self._epoch = time.monotonic()
            for reader in readers:
                reader.epoch = self._epoch
                reader.start()
            self._film(workers, writer, slots, packer)
        finally:
            for reader in readers:
                reader.stop()
            if writer is not None:
                writer.end()
                writer.join()
            os.close(sending)
            packer.join()
            workers.close()
            slots.close()
        if packer.failure is not None:
            raise packer.failure
        assert packer.summary is not None
        summary.mux = packer.summary
        summary.coarsest = max(summary.coarsest, self._fineness.step)
        for index, (reader, source) in enumerate(zip(readers, show.sources)):
            summary.cameras[source.name] = {
                "pictures": reader.pictures, "late": self._moments.late[index], "stops": reader.stops,
            }  # fmt: skip
        summary.troubled = summary.troubled or bool(packer.summary["warned"])
        return summary

    def _slot_count(self) -> int:
        """For what processes have and make, and what the encoder does not take while it plans the stream."""
        least = (AHEAD + 2) * self._show.jobs
        size = sum(4 * int(camera.width * camera.height) for camera in self._cameras)
        return max(least, min(least + math.ceil(PLANNING * self._rate), MOST_MEMORY // size))

    def _freed(self, slot: int) -> None:
        with self._lock:
            self._free.append(slot)

    def _film(self, workers: Workers, writer: _Writer, slots: Slots, packer: _Packer) -> None:
        """The loop: moments to processes, hulls to the encoder."""
        summary, moments = self._summary, self._moments
        whole = began = time.monotonic()
        while packer.is_alive() and not writer.is_closed:
            now = time.monotonic()
            for moment in moments.take(now - self._epoch):
                if not summary.frames:
                    began = now
                summary.frames += 1
                if self._begin(moment, workers, slots):
                    whole = now
            self._collect(workers.take(TICK))
            self._send(writer)
            if self._is_stopped():
                summary.end = "it was stopped"
                break
            if moments.is_over:
                summary.end = "all cameras ended"
                break
            if now - whole > self._show.idle:
                absent = [self._show.sources[i].name for i in moments.waited_for]
                summary.end = f"no whole frame came for {self._show.idle:g} s"
                if absent and not moments.has_begun:
                    summary.end += f", and no picture of {', '.join(absent)}"
                self._tell("stopped", summary.end)
                break
        while workers.waiting and packer.is_alive():
            self._collect(workers.take(1.0))
        self._send(writer)
        summary.seconds = time.monotonic() - began

    def _begin(self, moment: Moment[NDArray[numpy.uint8]], workers: Workers, slots: Slots) -> bool:
        """Gives a frame to a process, or gives it up. Whether it was whole."""
        if moment.missing:
            names = ", ".join(self._show.sources[i].name for i in moment.missing)
            self._done[moment.number] = (moment.due, f"no picture of {names}")
            return False
        is_busy = workers.is_busy(self._show.max_delay * SHARE)
        with self._lock:
            slot = self._free.pop() if self._free and not is_busy else None
        if slot is None:
            why = "no process was free" if is_busy else "the encoder is behind"
            self._done[moment.number] = (moment.due, why)
            if is_busy:
                self._adapt(self._fineness.load, self._fineness.drop())
            return True
        for (picture, _), found in zip(slots.images(slot), moment.pictures):
            assert found is not None
            picture[:] = found
        self._due[moment.number] = moment.due
        workers.give(moment.number, slot, self._fineness.scale)
        return True

    def _collect(self, made: Sequence[Made]) -> None:
        for one in made:
            due = self._due.pop(one.number)
            if one.failure:
                self._freed(one.slot)
            else:
                self._summary.hulls += 1
                self._summary.delays.append(time.monotonic() - self._epoch - due)
            self._done[one.number] = (due, one.failure or one)
            self._adapt(self._fineness.load, self._fineness.add(one.seconds))

    def _adapt(self, load: float, change: int) -> None:
        if change:
            self._summary.coarsest = max(self._summary.coarsest, self._fineness.step)
            self._tell(
                "coarser" if change > 0 else "finer",
                f"cells of the hull are {self._fineness.scale:.2f} times as large as given, keys of {'half' if self._fineness.step else 'full'} size, as frames took {load:.2f} of the "
                "processes' time",
            )

    def _send(self, writer: _Writer) -> None:
        """Frames whose turn it is."""
        clock = time.time() - time.monotonic() + self._epoch
        while self._next in self._done:
            due, content = self._done.pop(self._next)
            writer.put(self._next, int((clock + due) * 1e6), content)
            self._next += 1
