"""What cameras filmed: a video or a folder of pictures for each, brought to common frames.

Pictures are read by the reader that fvvmux uses, so that both see the same pixels: conversion of colours, rotation, and
which picture of a video belongs to a frame are those of spec/capture.md, "Pictures".
"""

from __future__ import annotations

import dataclasses
import math
import os
import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy
from fvv import recordings
from fvv.errors import DamagedError, UsageError
from numpy.typing import NDArray

VIDEOS = (".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi", ".mpg", ".mpeg", ".ts", ".mts", ".m2ts", ".wmv")
STILLS = (".png", ".jpg", ".jpeg", ".exr")


@dataclasses.dataclass(frozen=True)
class Recording:
    """The pictures of one camera."""

    name: str
    path: str  #: Of the video or of the folder, absolute.
    size: tuple[int, int]  #: Width and height of the pictures, as they are shown.
    count: int  #: Pictures.
    pattern: str | None = None  #: Of a folder: the pictures' path with %0Nd for the number. None: a video.
    first: int = 0  #: Number of the first picture of a folder.
    tick: Fraction = Fraction(1)  #: Of a video: seconds.
    ticks: NDArray[numpy.int64] | None = (
        None  #: Of a video: when each picture is shown, the first at 0. None: a folder.
    )

    def rate(self) -> Fraction | None:
        """Pictures a second; None for folders and single pictures. A rate within 0.05 % of a usual one is that one."""
        if self.ticks is None or self.count < 2:
            return None
        gaps = numpy.diff(self.ticks)
        # Files round their times, so that single gaps differ; long ones are pictures that are missing.
        usual = gaps[gaps < 1.5 * float(numpy.median(gaps))]
        measured = 1 / (Fraction(int(usual.sum()), len(usual)) * self.tick)
        for whole in range(1, 1001):
            for rate in (Fraction(whole), Fraction(whole * 1000, 1001)):
                if abs(measured / rate - 1) < Fraction(1, 2000):
                    return rate
        return measured.limit_denominator(10000)


def _folder(path: str, name: str) -> Recording | None:
    """The stills of a folder; None: there are none."""
    files = sorted(f for f in os.listdir(path) if f.lower().endswith(STILLS) and not f.startswith("."))
    if not files:
        return None
    found: dict[tuple[str, str], list[tuple[int, str]]] = {}
    for file in files:
        match = re.fullmatch(r"(.*?)(\d+)([^\d]*)", file)
        if match is None:
            raise UsageError(
                f"{os.path.join(path, file)}: expected a number in the name of each picture", file=path
            )
        found.setdefault((match[1], match[3]), []).append((int(match[2]), match[2]))
    if len(found) > 1:
        names = " and ".join(sorted(f"{a}N{b}" for a, b in found))
        raise UsageError(f"{path}: expected pictures of one series, found {names}", file=path)
    (before, after), numbers = next(iter(found.items()))
    numbers.sort()
    values = [number for number, _ in numbers]
    missing = sorted(set(range(values[0], values[-1] + 1)) - set(values))
    if missing:
        raise DamagedError(
            f"{path}: picture {missing[0]} is missing, one of {len(missing)} between {values[0]} and {values[-1]}",
            file=path,
        )
    width = len(numbers[0][1])
    digits = "%d" if width == 1 else f"%0{width}d"
    if width > 9 or any(len(text) != max(width, len(str(number))) for number, text in numbers):
        raise UsageError(f"{path}: expected numbers of one width of at most 9 digits", file=path)
    pattern = os.path.join(path, before).replace("%", "%%") + digits + after.replace("%", "%%")
    size = recordings.picture_size(os.path.join(path, files[0]))
    return Recording(name, path, size, len(values), pattern, values[0])


def _video(path: str, name: str) -> Recording:
    facts = recordings.video_facts(path)
    ticks = facts["ticks"]
    return Recording(
        name,
        path,
        (facts["width"], facts["height"]),
        len(ticks),
        tick=Fraction(*facts["tick"]),
        ticks=ticks,
    )


def find(path: str | os.PathLike[str]) -> dict[str, Recording]:
    """The recordings in a folder, by name: a video NAME.mp4 (.mov, .mkv, ...) or a folder NAME of numbered pictures (PNG,
    JPEG, OpenEXR) for each camera. Other files are ignored.

    Raises OSError, `UsageError` for folders that cannot be understood, and `DamagedError` for files that cannot be read.
    """
    root = os.path.abspath(os.fspath(path))
    out: dict[str, Recording] = {}
    for entry in sorted(os.listdir(root)):
        if entry.startswith("."):
            continue
        full = os.path.join(root, entry)
        stem, suffix = os.path.splitext(entry)
        if os.path.isdir(full):
            recording = _folder(full, entry)
        elif suffix.lower() in VIDEOS:
            recording = _video(full, stem)
        else:
            continue
        if recording is None:
            continue
        if recording.name in out:
            raise UsageError(
                f"{full}: expected one recording of each camera, found {out[recording.name].path} too",
                file=full,
            )
        out[recording.name] = recording
    if not out:
        raise UsageError(
            f"{root}: expected a video or a folder of numbered pictures for each camera, found none",
            file=root,
        )
    return out


def common_rate(recordings: Sequence[Recording], given: Fraction | None = None) -> Fraction:
    """Pictures a second of all recordings. Raises `UsageError` when they differ by more than 0.1 %, or do not say."""
    rates = {r.name: rate for r in recordings if (rate := r.rate()) is not None}
    if given is None and not rates:
        raise UsageError("expected a frame rate (--fps), because pictures in folders have none")
    wanted = given if given is not None else next(iter(rates.values()))
    other = {name: rate for name, rate in rates.items() if abs(rate / wanted - 1) > Fraction(1, 1000)}
    if other:
        found = ", ".join(f"{name} {float(rate):.6g}" for name, rate in rates.items())
        raise UsageError(
            f"expected videos of one frame rate ({float(wanted):.6g}), found {found}; convert the others, or pass --cameras"
        )
    return wanted


def match_cameras(
    names: Sequence[str], recordings: Mapping[str, Recording]
) -> tuple[dict[int, Recording], list[str]]:
    """The recording of each camera of a calibration, by the camera's place in names, and the names of recordings that no camera
    has. Names match exactly, or else in lower case without extension: "Cam01" and "cam01.mp4" are the same camera."""

    def plain(name: str) -> str:
        stem, suffix = os.path.splitext(os.path.basename(name))
        return (stem if suffix.lower() in VIDEOS + STILLS else os.path.basename(name)).lower()

    found: dict[int, Recording] = {}
    used: set[str] = set()
    for i, name in enumerate(names):
        fitting = [name] if name in recordings else [r for r in recordings if plain(r) == plain(name)]
        if len(fitting) == 1 and fitting[0] not in used:
            found[i] = recordings[fitting[0]]
            used.add(fitting[0])
    if not found:
        raise UsageError(
            f"expected recordings with the names of the calibration's cameras ({', '.join(names)}), "
            f"found {', '.join(recordings)}"
        )
    return found, [name for name in recordings if name not in used]


@dataclasses.dataclass(frozen=True)
class Timeline:
    """Which picture of each recording belongs to which frame: that of frame i is number i + offset, counted from 0."""

    rate: Fraction
    offsets: dict[str, int]
    first: int  #: First frame that all recordings have.
    count: int  #: Frames from there on that all recordings have.


def timeline(recordings: Sequence[Recording], rate: Fraction, offsets: Mapping[str, float]) -> Timeline:
    """The frames that all recordings have. offsets: pictures by which a recording begins earlier than the common time line, by
    name, 0 where absent; fractions are rounded, because a frame has whole pictures."""
    names = {r.name for r in recordings}
    unknown = [name for name in offsets if name not in names]
    if unknown:
        raise UsageError(f"offset of {unknown[0]}: expected one of {', '.join(sorted(names))}")
    whole = {r.name: math.floor(offsets.get(r.name, 0.0) + 0.5) for r in recordings}
    first = max(0, max(-n for n in whole.values()))
    end = min(_length(r, rate) - whole[r.name] for r in recordings)
    if end <= first:
        lengths = ", ".join(f"{r.name} {r.count} (offset {whole[r.name]})" for r in recordings)
        raise UsageError(f"the recordings have no frame in common: {lengths} pictures")
    return Timeline(rate, whole, first, end - first)


def _length(recording: Recording, rate: Fraction) -> int:
    """Frame durations from the first picture to the end of the last: more than pictures where some are missing."""
    if recording.ticks is None:
        return recording.count
    return math.floor(int(recording.ticks[-1]) * recording.tick * rate + Fraction(1, 2)) + 1


def source(
    recording: Recording, line: Timeline, first: int, relative_to: str | None = None
) -> dict[str, Any] | str:
    """`pictures` or `masks` of a camera in a capture.json whose frames begin with number first (spec/capture.md). relative_to: the
    folder that names begin at; None: they are absolute."""
    offset = line.offsets[recording.name]

    def shown(path: str) -> str:
        return path if relative_to is None else os.path.relpath(path, relative_to)

    if recording.pattern is None:
        start = Fraction(first + offset) / line.rate
        return {"video": shown(recording.path), "start": f"{start.numerator}/{start.denominator}"}
    shift = recording.first + offset
    pattern = shown(recording.pattern)
    return {"pattern": pattern, "offset": shift} if shift else pattern
