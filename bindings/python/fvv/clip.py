"""Clips with random access."""

from __future__ import annotations

import json
import os
import re
import threading
import weakref
from collections.abc import Iterator
from fractions import Fraction
from typing import Any, overload

import numpy
from numpy.typing import NDArray

from . import _core
from ._core import Camera, Mesh, Picture, Sound
from .environment import Environment
from .errors import DamagedError, UsageError
from .frames import ATLAS, ByCamera, Frame, Weights
from .player import INLINE_LIMIT, Player, Server, inline_player, script_of
from .records import Check, Description, Limits, Problem, Rung, Texturing, Track
from .sources import Readable, Source, opened_elsewhere

#: Of a clip: all frames.
EVERY = slice(None)


def _given(limits: Limits | None) -> dict[str, int]:
    return {} if limits is None else limits.given()


class ClipFrame(Frame):
    """A frame of a clip."""

    def __init__(self, clip: Clip, index: int) -> None:
        super().__init__()
        self._clip = clip
        #: The place in the clip: `clip[frame.index]` is this frame.
        self.index = index
        self._place: tuple[int, int, int] | None = None
        self._known: Description | None = None

    def __reduce__(self) -> tuple[object, ...]:
        return ClipFrame, (self._clip, self.index)

    @property
    def _stream(self) -> _core.Stream:
        return self._clip._stream

    def _located(self) -> tuple[int, int, int]:
        if self._place is None:
            self._place = self._stream.frame(self.index)
        return self._place

    @property
    def _description(self) -> Description:
        if self._known is None:
            self._known = self._clip._description_of(self._located()[2])
        return self._known

    @property
    def ticks(self) -> int:
        return self._located()[0]

    @property
    def number(self) -> int:
        return self._stream.number(self.index) if self._place is None else self._place[1]

    @property
    def intact(self) -> bool:
        """Whether everything of the frame arrived. Its other attributes raise `DamagedError` if not."""
        try:
            self._located()
        except DamagedError:
            return False
        return True

    def _load_mesh(self, track: int) -> Mesh | None:
        return self._stream.mesh(self.index, track)

    def _load_cameras(self) -> ByCamera[Camera]:
        loaded = {i: self._stream.camera(self.index, i) for i, _ in self._description.cameras}
        return ByCamera(self._description, [i for i, c in loaded.items() if c is not None], loaded.get)

    def _load_pictures(self) -> ByCamera[Picture]:
        shown = [i for i in self._stream.picture_cameras(self.index) if i != ATLAS]
        return ByCamera(self._description, shown, lambda i: self._stream.picture(self.index, i))

    def _load_atlas(self) -> Picture | None:
        self._located()
        return self._stream.picture(self.index, ATLAS)

    def _load_visibility(self, mesh_track: int, camera: int) -> Weights | None:
        return self._stream.visibility(self.index, mesh_track, camera)

    def _draw_mesh(self) -> NDArray[numpy.uint8] | None:
        from .view import render

        mesh = self.mesh
        if mesh is None or not mesh.vertex_count:
            return None
        low, high = mesh.positions.min(axis=0).astype(float), mesh.positions.max(axis=0).astype(float)
        size = float(numpy.linalg.norm(high - low)) or 1.0
        # From above and aside, on whichever axes the world has.
        up = numpy.zeros(3)
        axis = "xyz".index(self._description.up[1]) if self._description.up else 1
        up[axis] = -1 if (self._description.up or "+")[0] == "-" else 1
        aside = numpy.roll(up, 1) + numpy.roll(up, 2)
        eye = (low + high) / 2 + size * (1.25 * aside / 2**0.5 + 0.75 * up)
        pose = (eye, (low + high) / 2, up)
        drawn = render(
            self._clip,
            self,
            pose,
            size=(640, 480),
            background=(250, 250, 248),
            pictures=False,
            layers=True,  # which has warnings as texts
        )
        return drawn.pixels

    @property
    def environment(self) -> Environment | None:
        """The static environment around the action, of all environment tracks of the rung; None: the stream has none. Meshes are
        decoded at each use: keep it."""
        found = self._stream.environment(self.index)
        return None if found is None else Environment._of(found)

    def __repr__(self) -> str:
        return f"<fvv frame {self.number} of {self._clip.name}>"


class Clip:
    """A stream with random access, from `fvv.open`. A sequence of frames.

    Threads may share a clip and then take turns; clips of their own run at the same time. Frames, meshes and arrays that
    were read stay valid after `close`; what was not read raises `UsageError` then.

    Processes have a clip each: one that was forked opens the source again, and so does one that receives a pickled clip, which
    is its path or URL. `UsageError` where that cannot be, as with most file objects.
    """

    def __init__(self, source: Readable, *, rung: int = 0, limits: Limits | None = None) -> None:
        if rung < 0:
            raise UsageError(f"rung {rung}: expected 0 or more")
        self.rung = rung
        self._limits = limits
        self._closed = False
        self._open(Source(source))

    def _open(self, source: Source) -> None:
        self._source, self.name = source, source.name
        self._opened = _core.Stream(source.core, self.name, self.rung, _given(self._limits))
        self._process = os.getpid()
        self._lock = threading.Lock()
        self._server: Server | None = None
        self._descriptions: dict[int, Description] = {}
        self._description: Description | None = None

    @property
    def _stream(self) -> _core.Stream:
        """Of this process: what one that was forked inherits cannot be used."""
        if self._process != os.getpid():
            with _after_fork:
                if self._process != os.getpid():
                    self._require_open()
                    self._open(self._source.after_fork())
        return self._opened

    def _require_size(self, size: int) -> None:
        found = self.size
        if found == size:
            return
        self.close()
        raise UsageError(
            f"{self.name}: has {found} bytes here, expected the {size} of the clip that was pickled",
            file=self.name,
        )

    def __reduce__(self) -> tuple[object, ...]:
        self._require_open()
        return _opened_again, (self._source.portable(), self.rung, self._limits, self._stream.byte_count)

    def close(self) -> None:
        """Releases the source, and ends what `show` serves. May be called again."""
        self._closed = True
        if self._process == os.getpid():
            self._opened.close()
        with self._lock:
            server, self._server = self._server, None
        if server is not None:
            server.close()

    @property
    def closed(self) -> bool:
        """Whether `close` was called."""
        return self._closed

    def __enter__(self) -> Clip:
        if self.closed:
            raise UsageError("the clip is closed", file=self.name)
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __len__(self) -> int:
        return len(self._stream)

    @overload
    def __getitem__(self, index: int) -> ClipFrame: ...

    @overload
    def __getitem__(self, index: slice) -> list[ClipFrame]: ...

    def __getitem__(self, index: int | slice) -> ClipFrame | list[ClipFrame]:
        self._require_open()
        if isinstance(index, slice):
            return [ClipFrame(self, i) for i in range(*index.indices(len(self)))]
        found = index + len(self) if index < 0 else index
        if not 0 <= found < len(self):
            raise IndexError(_beyond(self.name, index, len(self)))
        return ClipFrame(self, found)

    def __iter__(self) -> Iterator[ClipFrame]:
        self._require_open()
        for i in range(len(self)):
            yield ClipFrame(self, i)

    def at(self, seconds: float | Fraction) -> ClipFrame:
        """The frame that is shown at a time: the last one that begins no later. `UsageError` before the first frame and from
        the end on."""
        base = self._configuration().time_base
        try:
            exact = Fraction(seconds) / base
        except (ValueError, OverflowError, TypeError):
            raise UsageError(
                f"at: expected seconds, a finite number, found {seconds!r}", file=self.name
            ) from None
        # A thousandth of a tick is for floats that miss a frame's time by their last bit.
        ticks = float(exact) + 1e-3
        start, end = self._stream.span()
        if not start <= ticks < end:
            raise UsageError(
                f"{self.name}: nothing is shown at {float(seconds):g} s: the clip is from {float(start * base):g} s to before "
                f"{float(end * base):g} s",
                file=self.name,
            )
        return ClipFrame(self, self._stream.at(int(ticks // 1)))

    @property
    def start(self) -> float:
        """The time at which the clip begins, in seconds."""
        return float(self._stream.span()[0] * self._configuration().time_base)

    @property
    def duration(self) -> float:
        """Seconds from the start of the first group to the end of the last."""
        start, end = self._stream.span()
        return float((end - start) * self._configuration().time_base)

    @property
    def rate(self) -> Fraction:
        """Frames per second, nominal."""
        found = self._configuration()
        return 1 / (found.time_base * found.frame_duration)

    @property
    def time_base(self) -> Fraction:
        """Seconds per tick."""
        return self._configuration().time_base

    @property
    def tracks(self) -> tuple[Track, ...]:
        """All tracks of the first configuration."""
        return self._configuration().tracks

    @property
    def rungs(self) -> tuple[Rung, ...]:
        """The qualities to choose from, best first: `fvv.open(..., rung=rungs[i].number)`."""
        return self._configuration().rungs

    @property
    def up(self) -> str | None:
        """The world's axis that points up: "+x", "+y", "+z", "-x", "-y" or "-z". None: not stated."""
        return self._configuration().up

    @property
    def texturing(self) -> Texturing:
        """How players mix the colours of cameras."""
        return self._configuration().texturing

    @property
    def metadata(self) -> list[Any]:
        """The JSON documents of the stream; one that is no JSON is a str."""
        return [_parsed(text) for text in self._configuration().metadata]

    @property
    def audio(self) -> list[Sound]:
        """The sound: for each track its packets without a gap, and a further entry after each gap."""
        return self._stream.sounds()

    @property
    def problems(self) -> list[Problem]:
        """The damage that was met so far. `fvv.check` looks for all of it."""
        return [Problem(*found) for found in self._stream.problems()]

    @property
    def size(self) -> int:
        """Bytes of the stream. With `read_at` a clip is a `ReadAt` itself."""
        self._require_open()
        return self._stream.byte_count

    def read_at(self, offset: int, size: int) -> bytes:
        """Exactly size bytes of the stream from offset. `UsageError` beyond its end."""
        if offset < 0 or size < 0:
            raise UsageError(f"{size} bytes at {offset}: expected 0 or more", file=self.name)
        return self._stream.read_at(offset, size)

    def chunks(self, group: int | None = None) -> NDArray[numpy.void]:
        """Where the bytes are: a structured array, (chunks,), of all groups in order of the stream, or of one group.

        Fields: `group` (number in the file), `type` (four characters, as bytes), `track`, `key` (bool: decodes alone), `time`
        (ticks of `time_base`), `offset` (bytes from the start of the stream to the chunk's header), `size` (bytes of payload,
        without the header). A group whose table is damaged is left out and becomes one of `problems`; asked for alone it
        raises `DamagedError`.
        """
        if group is not None and group < 0:
            raise UsageError(f"group {group}: expected 0 or more", file=self.name)
        return self._stream.chunks(group)

    def show(
        self,
        *,
        width: int | str = "100%",
        inline: bool | None = None,
        player: str | os.PathLike[str] | None = None,
    ) -> Player:
        """The clip in `<fvv-player>`, for notebooks: what the last line of a cell returns is shown.

        width: pixels, or a length of CSS; the height follows, 16:9. inline: True, the stream is part of the page and plays
        without Python, `UsageError` above 64 MiB; False, it is served to this computer until `close`, and only browsers on this
        computer play it; None, inline up to 64 MiB. player: path of a script by js/player/bundle.mjs in place of the package's.
        """
        self._require_open()
        script = script_of(None if player is None else os.fspath(player))
        side = f"{width}px" if isinstance(width, int) else width
        if not re.fullmatch(r"\d+(\.\d+)?(px|%|em|rem|vw)", side):
            raise UsageError(f"width {width!r}: expected pixels, or a length of CSS such as 50%")
        title = os.path.basename(self.name)
        if self.size <= INLINE_LIMIT if inline is None else inline:
            return inline_player(self._stream, title, side, script)
        with self._lock:
            if self._server is None:
                self._server = Server(self._stream, title, script)
                weakref.finalize(self, self._server.close)
        return Player(f'src="{self._server.url}"', side, self._server.url)

    def to_xarray(self, frames: slice = EVERY) -> Any:
        """An `xarray.Dataset` of calibrations over time, and of the meshes where their faces do not change
        (`fvv.interop.clip_to_xarray`)."""
        from .interop import clip_to_xarray

        return clip_to_xarray(self, frames)

    def to_dicts(self, frames: slice = EVERY) -> Iterator[dict[str, Any]]:
        """Each frame as a dict of plain values and arrays (`fvv.interop.clip_to_dicts`)."""
        from .interop import clip_to_dicts

        return clip_to_dicts(self, frames)

    def to_usd(self, path: str | os.PathLike[str], frames: slice = EVERY, *, force: bool = False) -> None:
        """Writes meshes and cameras over time as a USD file (`fvv.interop.usd.export`)."""
        from .interop.usd import export

        export(self, path, frames, force=force)

    def __repr__(self) -> str:
        return f"<fvv.Clip {self.name}{': closed' if self.closed else ''}>"

    def _require_open(self) -> None:
        if self.closed:
            raise UsageError("the clip is closed", file=self.name)

    def _configuration(self) -> Description:
        self._require_open()
        if self._description is None:
            self._description = Description.of(self._stream.configuration())
        return self._description

    def _description_of(self, group: int) -> Description:
        offset = self._stream.configuration_offset(group)
        with self._lock:
            found = self._descriptions.get(offset)
        if found is None:
            found = Description.of(self._stream.configuration(group))
            with self._lock:
                self._descriptions[offset] = found
        return found


def _beyond(name: str, index: int, count: int) -> str:
    if not count:
        return f"{name}: there is no frame {index}: the clip has none"
    there = (
        "1 frame, number 0 or -1"
        if count == 1
        else f"{count} frames, 0 to {count - 1}, or -{count} to -1 from the end"
    )
    return f"{name}: there is no frame {index}: the clip has {there}"


#: Held while a forked process opens a clip again. No process inherits it locked.
_after_fork = threading.Lock()


def _renew_lock() -> None:
    global _after_fork
    _after_fork = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_renew_lock)


def _opened_again(portable: Readable, rung: int, limits: Limits | None, size: int) -> Clip:
    """A pickled clip, in the process that receives it."""
    clip = Clip(opened_elsewhere(portable), rung=rung, limits=limits)
    clip._require_size(size)
    return clip


def _parsed(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def check(source: Readable, *, decode: bool = True, limits: Limits | None = None) -> Check:
    """Reads all of a stream and returns everything that is wrong with it, as `fvvinfo --check` does. decode: decode meshes,
    visibility and environments and check video samples too, not only structure."""
    what = Source(source)
    found = _core.check(what.core, what.name, decode, _given(limits))
    problems = tuple(Problem(*problem) for problem in found.pop("problems"))
    found["whole"] = tuple(found["whole"])
    return Check(problems=problems, **found)
