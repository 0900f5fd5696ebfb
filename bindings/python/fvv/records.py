"""Plain values: limits, tracks, rungs, problems and the result of a check."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from typing import Any

TRACK_KINDS = {
    1: "mesh",
    2: "video",
    3: "calibration",
    4: "visibility",
    5: "environment",
    6: "data",
    7: "audio",
    8: "colours",
}
UP_AXES = {0: None, 1: "+x", 2: "+y", 3: "+z", 4: "-x", 5: "-y", 6: "-z"}


@dataclasses.dataclass(frozen=True)
class Limits:
    """What a reader accepts. None is the default of the library (fvv_limits in fvv/types.h)."""

    max_payload: int | None = None  #: Bytes of a chunk: 256 MiB.
    max_vertices: int | None = None  #: Of a mesh: 4 Mi.
    max_faces: int | None = None  #: Of a mesh: 8 Mi.
    max_cameras: int | None = None  #: 1024.
    max_tracks: int | None = None  #: 256.
    max_dimension: int | None = None  #: Width or height of a picture: 16384 pixels.
    max_groups: int | None = None  #: Of a file: 4 Mi.
    max_group_chunks: int | None = None  #: Of a group: 1 Mi.
    max_text: int | None = None  #: Bytes of a name: 1 MiB.
    max_environment: int | None = None  #: Parts, pictures or lights of an environment: 1024.
    max_picture_memory: int | None = None  #: Bytes that decoding all video tracks may take: 4 GiB.

    def given(self) -> dict[str, int]:
        """Those that are not None, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}


@dataclasses.dataclass(frozen=True)
class Track:
    """A track as the stream declares it."""

    id: int
    kind: str  #: "mesh", "video", "calibration", "visibility", "environment", "data", "audio" or "colours".
    name: str
    alternate_group: int  #: 0: none. Tracks that share another number show the same thing.
    rank: int  #: Among these: 0 is the best.
    bit_rate: int  #: Bits per second, nominal; 0: not stated.
    size: int  #: Pixels of a video frame or faces of a mesh, nominal; 0: not stated.
    time_base: Fraction  #: Seconds per tick of times in its payloads.
    selected: bool  #: It belongs to the rung that is read.


@dataclasses.dataclass(frozen=True)
class Rung:
    """One quality of a stream that has several."""

    number: int  #: 0 is the best.
    bit_rate: int  #: Bits per second, nominal; 0: not stated.
    size: int  #: Pixels of all video frames of one time; 0: not stated.
    scale: float | None  #: Of a side of a camera's picture; None: no tiles.
    tracks: tuple[int, ...]  #: Identifiers.


@dataclasses.dataclass(frozen=True)
class Texturing:
    """How players mix the colours of cameras (clause 17.5)."""

    blend: str  #: "viewer", by the direction of the viewer, or "paper", by the normal.
    threshold: float  #: The least cosine between the normal and the direction to a camera.
    best: int  #: The most cameras that are mixed at a point.
    inset: float  #: Metres from the mesh inward to the surface that the cameras show.
    unseen: tuple[
        int, int, int
    ]  #: Red, green, blue, 0 to 255, of what no camera shows and that has no colours.


@dataclasses.dataclass(frozen=True)
class Problem:
    """Damage that was met."""

    status: str  #: "damaged", "truncated", "invalid", ...
    issue: int | None  #: The number n of FVV-n in spec/issues.md.
    chunk: str | None  #: The four characters of the chunk's type, such as "MESH".
    offset: int | None  #: Bytes from the start of the stream, of the field that is wrong.
    chunk_offset: int | None  #: The same of the header of its chunk.
    text: str  #: The whole line.

    def __str__(self) -> str:
        return self.text


@dataclasses.dataclass(frozen=True)
class Check:
    """What `fvv.check` found."""

    problems: tuple[Problem, ...]  #: The first 1000.
    problem_count: int  #: All, also those that `problems` leaves out.
    bytes: int
    chunks: int
    groups: int
    frames: int
    whole_frames: int  #: Every chunk arrived undamaged and, with decode, every mesh decodes.
    whole: tuple[tuple[int, int], ...]  #: Ticks of the first and the last frame of each run of whole frames.
    complete: bool  #: The footer was read. A live stream has none.
    format: tuple[int, int]  #: Version that the writer followed.

    @property
    def ok(self) -> bool:
        """Nothing is wrong and nothing is missing."""
        return not self.problem_count and self.complete


@dataclasses.dataclass(frozen=True)
class Description:
    """A configuration block: what holds for the groups after it."""

    time_base: Fraction  #: Seconds per tick.
    frame_duration: int  #: Ticks, nominal.
    origin: tuple[float, float, float]  #: Metres: the lattice point 0 0 0.
    step: float  #: Metres between neighbouring lattice points.
    up: str | None  #: The axis of the world that points up, such as "+y"; None: not stated.
    scale_unknown: bool  #: Lengths are in a unit that is not known, rather than metres.
    tracks: tuple[Track, ...]
    rungs: tuple[Rung, ...]  #: The qualities to choose from, best first.
    cameras: tuple[tuple[int, str], ...]  #: Identifiers and names.
    meshes: tuple[int, ...]  #: Mesh tracks of the rung that is read.
    metadata: tuple[str, ...]  #: JSON texts, as they were sent.
    texturing: Texturing  #: How players mix the colours of cameras.

    @classmethod
    def of(cls, raw: dict[str, Any]) -> Description:
        """From what the core returns of a configuration."""
        tracks = [
            Track(i, TRACK_KINDS.get(kind, str(kind)), name, group, rank, rate, size, Fraction(*base), chosen)
            for i, kind, name, group, rank, rate, size, base, chosen in raw["tracks"]
        ]
        return cls(
            time_base=Fraction(*raw["time_base"]),
            frame_duration=raw["frame_duration"],
            origin=tuple(raw["origin"]),
            step=raw["step"],
            up=UP_AXES.get(raw["up"]),
            scale_unknown=raw["scale_unknown"],
            tracks=tuple(tracks),
            rungs=tuple(Rung(n, rate, size, scale, tuple(ids)) for n, rate, size, scale, ids in raw["rungs"]),
            cameras=tuple(raw["cameras"]),
            meshes=tuple(raw["meshes"]),
            metadata=tuple(raw["metadata"]),
            texturing=Texturing(*raw["texturing"]),
        )

    def camera(self, key: object) -> int | None:
        """The identifier of a camera by identifier or name; None: there is none."""
        for identifier, name in self.cameras:
            if (isinstance(key, str) and key == name) or (not isinstance(key, str) and key == identifier):
                return identifier
        return None
