"""What cameras filmed: a video or a folder of pictures for each, brought to common frames, in a take and in a board walk alike.

Pictures are read by the reader that fvvmux uses, so that both see the same pixels: conversion of colours, rotation, and
which picture of a video belongs to a frame are those of spec/capture.md, "Pictures".
"""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy
from fvv import recordings
from fvv.errors import DamagedError, UsageError
from numpy.typing import NDArray

VIDEOS = (
    ".mp4", ".mov", ".m4v", ".mkv", ".webm", ".avi", ".mpg", ".mpeg", ".ts", ".mts", ".m2ts", ".wmv", ".mxf", ".ivf",
)  # fmt: skip
STILLS = (".png", ".jpg", ".jpeg", ".exr")
#: Those of a board too, which are not sent and which OpenCV reads.
BOARD_STILLS = (*STILLS, ".tif", ".tiff", ".bmp")


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
    timecode: str = ""  #: Of the first picture, where the camera wrote one.

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


def video(path: str, name: str) -> Recording:
    """A video. Raises OSError and `DamagedError`."""
    facts = recordings.video_facts(path)
    ticks = facts["ticks"]
    return Recording(
        name,
        path,
        (facts["width"], facts["height"]),
        len(ticks),
        tick=Fraction(*facts["tick"]),
        ticks=ticks,
        timecode=facts["timecode"],
    )


def names_of(pattern: str) -> re.Pattern[str]:
    """What a recording's name has to be, of a pattern such as "{camera}_take". Raises `UsageError`."""
    if pattern.count("{camera}") != 1:
        raise UsageError(
            f"name {pattern!r}: expected {{camera}} once, as in {{camera}}_take; the scene's name is a title"
        )
    before, after = pattern.split("{camera}")
    return re.compile(f"{re.escape(before)}(.+){re.escape(after)}", re.IGNORECASE)


def entries(
    path: str | os.PathLike[str], names: Sequence[str] = (), exclude: Sequence[str] = ()
) -> dict[str, str]:
    """The videos and folders in a folder, by the name of their camera: what stands at {camera} in the first of `names`, such as
    "{camera}_take", that fits theirs, else all of it. Nothing is opened. Raises OSError, and `UsageError` where two are of one
    camera."""
    root = os.path.abspath(os.fspath(path))
    wanted = [names_of(name) for name in names]
    out: dict[str, str] = {}
    for entry in sorted(os.listdir(root)):
        full = os.path.join(root, entry)
        stem, suffix = os.path.splitext(entry)
        is_folder = os.path.isdir(full)
        if entry.startswith(".") or not (is_folder or suffix.lower() in VIDEOS):
            continue
        whole = entry if is_folder else stem
        camera = next((match[1] for one in wanted if (match := one.fullmatch(whole))), whole)
        if camera in exclude or (is_folder and not any(_is_still(f) for f in os.listdir(full))):
            continue
        if camera in out:
            raise UsageError(
                f"{full}: expected one recording of each camera, found {out[camera]} too", file=full
            )
        out[camera] = full
    if not out:
        raise UsageError(
            f"{root}: expected a video or a folder of numbered pictures for each camera, found none",
            file=root,
        )
    return out


def _is_still(file: str) -> bool:
    return file.lower().endswith(BOARD_STILLS) and not file.startswith(".")


def find(
    path: str | os.PathLike[str], names: Sequence[str] = (), exclude: Sequence[str] = ()
) -> dict[str, Recording]:
    """The recordings in a folder, by the name of their camera: a video NAME.mp4 (.mov, .mkv, ...) or a folder NAME of numbered
    pictures (PNG, JPEG, OpenEXR) for each. Other files are ignored, and those of cameras in `exclude` are not opened.

    Raises OSError, `UsageError` for folders that cannot be understood, and `DamagedError` for files that cannot be read.
    """
    out: dict[str, Recording] = {}
    for camera, full in entries(path, names, exclude).items():
        try:
            recording = _folder(full, camera) if os.path.isdir(full) else video(full, camera)
        except DamagedError as error:
            raise DamagedError(f"{error}; --exclude {camera} goes on without it", file=full) from error
        if recording is not None:
            out[camera] = recording
    if not out:
        root = os.path.abspath(os.fspath(path))
        raise UsageError(
            f"{root}: expected a video or a folder of numbered pictures for each camera, found none",
            file=root,
        )
    return out


def camera_of(recording: Recording) -> dict[str, Any]:
    """A camera for capture.json that has the recording's size and nothing else to say."""
    width, height = recording.size
    return {
        "id": 0,
        "width": width,
        "height": height,
        "intrinsics": {"fx": 1000, "fy": 1000, "cx": width / 2, "cy": height / 2},
        "rotation": numpy.eye(3).tolist(),
        "translation": [0, 0, 0],
    }


def pictures(
    recording: Recording,
    rate: Fraction,
    offset: int = 0,
    first: int = 0,
    step: int = 1,
    last: int | None = None,
    repeat: bool = False,
) -> Iterator[tuple[int, NDArray[numpy.uint8]]]:
    """Frame numbers and pictures, (height, width, 3), of frames first, first + step, ... up to last; frame i shows the picture
    that is nearest to (i + offset) / rate. A frame that has no picture of its own, because the camera dropped it or had not
    begun, is left out: what moves must not be seen where it was before. repeat: it shows the picture before."""
    count = length(recording, rate)
    line = Timeline(rate, {recording.name: offset}, 0, count, {recording.name: offset})
    camera = {**camera_of(recording), "pictures": source(recording, line, 0)}
    numbers = range(-offset, count - offset)
    head = {
        "fvv_capture": 1,
        "frame_rate": f"{rate.numerator}/{rate.denominator}",
        "frames": {"first": 0, "count": max(1, count - offset)},
        "units": "metres",
        "cameras": [camera],
    }
    reader = recordings.Footage(json.dumps(head), os.path.join(os.sep, "capture.json"))
    there = None if repeat else _own_frames(recording, rate)
    for number in numbers:
        if last is not None and number > last:
            return
        if number < max(first, 0) or (number - first) % step:
            continue
        if there is None or number + offset in there:
            yield number, reader.picture(0, number)


def _own_frames(recording: Recording, rate: Fraction) -> set[int] | None:
    """Frames after the first picture's that a picture is nearest to; None: all, of a folder."""
    if recording.ticks is None:
        return None
    frames = numpy.floor(recording.ticks * float(recording.tick * rate) + 0.5).astype(int)
    return set(frames.tolist())


def common_rate(recordings: Sequence[Recording], given: Fraction | None = None) -> Fraction:
    """Frames a second of all recordings: the lowest of their rates. Others are it, to 0.1 %, or a whole multiple, of which each
    frame takes the nearest picture. Raises `UsageError` when they are something else, or do not say."""
    rates = {r.name: rate for r in recordings if (rate := r.rate()) is not None}
    if given is None and not rates:
        raise UsageError("expected a frame rate (--fps), because pictures in folders have none")
    lowest = min(rates.values(), default=Fraction(0))
    wanted = given if given is not None else next(r for r in rates.values() if _times(r, lowest) == 1)
    if any(not _times(rate, wanted) for rate in rates.values()):
        found = ", ".join(f"{name} {float(rate):.6g}" for name, rate in rates.items())
        raise UsageError(
            f"expected videos of one frame rate ({float(wanted):.6g}) or whole multiples of it, found {found}; convert the "
            "others, or pass --cameras"
        )
    return wanted


def _times(rate: Fraction, wanted: Fraction) -> int:
    """rate / wanted where that is a whole number, to 0.1 %; else 0."""
    ratio = rate / wanted
    whole = round(ratio)
    return whole if whole > 0 and abs(ratio / whole - 1) <= Fraction(1, 1000) else 0


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
    """Which picture of each recording belongs to which frame: that of frame i is number i + offset, counted from 0; of a recording
    with a clock of its own it is the one nearest to i (1 + drift) + shift."""

    rate: Fraction
    offsets: dict[str, int]  #: Pictures, by name; of clocks that drift at the frame `first`.
    first: int  #: First frame.
    count: int  #: Frames from there on.
    shifts: Mapping[str, float] = dataclasses.field(
        default_factory=dict
    )  #: `offsets` before they are rounded.
    clocks: Mapping[str, tuple[float, float]] = dataclasses.field(
        default_factory=dict
    )  #: (drift, shift in frames) of recordings whose clocks drift.
    ends: Mapping[str, int] = dataclasses.field(
        default_factory=dict
    )  #: The first frame that a recording has no more, of those that end before the others.

    def picture(self, name: str, frame: int) -> int:
        """The number of the picture of a frame."""
        return math.floor(self.place(name, frame) + 0.5)

    def place(self, name: str, frame: int) -> float:
        """The same between pictures: 7.3 is at three tenths of the time from picture 7 to picture 8."""
        drift, shift = self.clocks.get(name, (0.0, self.shifts[name]))
        return frame * (1 + drift) + shift


#: A recording that ends earlier than most, by this share of the frames that they have, ends alone: the take goes on without it.
SHORT = 0.1


def timeline(
    recordings: Sequence[Recording],
    rate: Fraction,
    offsets: Mapping[str, float],
    drifts: Mapping[str, float] | None = None,
) -> Timeline:
    """The frames that all recordings have; those that one of three or more ends early (`SHORT`) are there too. offsets: pictures by
    which a recording begins earlier than the common time line, by name, 0 where absent; fractions are rounded, because a frame has
    whole pictures. drifts: seconds that a video's clock gains in a second, by name."""
    names = {r.name for r in recordings}
    unknown = [name for name in offsets if name not in names]
    if unknown:
        raise UsageError(f"offset of {unknown[0]}: expected one of {', '.join(sorted(names))}")
    videos = {r.name for r in recordings if r.ticks is not None}
    clocks = {n: (d, offsets.get(n, 0.0)) for n, d in (drifts or {}).items() if d != 0 and n in videos}
    whole = {r.name: math.floor(offsets.get(r.name, 0.0) + 0.5) for r in recordings}
    first = max(0, max(-n for n in whole.values()))
    ends = {
        r.name: math.floor((length(r, rate) - whole[r.name]) / (1 + clocks.get(r.name, (0.0, 0.0))[0]))
        for r in recordings
    }
    usual = sorted(ends.values())[len(ends) // 2]
    short = {name: max(end, 0) for name, end in ends.items() if end < usual - SHORT * max(usual - first, 0)}
    if len(recordings) - len(short) < 3 or len(short) > len(recordings) // 4:
        short = {}
    end = min(e for name, e in ends.items() if name not in short)
    if end <= first or any(e <= first for e in short.values()):
        lengths = ", ".join(f"{r.name} {r.count} (offset {whole[r.name]})" for r in recordings)
        raise UsageError(f"the recordings have no frame in common: {lengths} pictures")
    shifts = {r.name: float(offsets.get(r.name, 0.0)) for r in recordings}
    out = Timeline(rate, whole, first, end - first, shifts, clocks, short)
    return dataclasses.replace(out, offsets={name: out.picture(name, first) - first for name in whole})


def length(recording: Recording, rate: Fraction) -> int:
    """Frame durations from the first picture to the end of the last: more than pictures where some are missing."""
    if recording.ticks is None:
        return recording.count
    return math.floor(int(recording.ticks[-1]) * recording.tick * rate + Fraction(1, 2)) + 1


def source(
    recording: Recording, line: Timeline, first: int, relative_to: str | None = None
) -> dict[str, Any] | str:
    """`pictures` or `masks` of a camera in a capture.json whose frames begin with number first (spec/capture.md). relative_to: the
    folder that names begin at; None: they are absolute."""

    def shown(path: str) -> str:
        return path if relative_to is None else os.path.relpath(path, relative_to)

    if recording.pattern is None:
        name = recording.name
        if name in line.clocks:
            drift, shift = line.clocks[name]
            clock = Fraction(1 + drift).limit_denominator(10**9)
            start = (Fraction(first) * clock + Fraction(shift).limit_denominator(10**4)) / line.rate
            start = start.limit_denominator(10**6)
            return {
                "video": shown(recording.path),
                "start": f"{start.numerator}/{start.denominator}",
                "clock": f"{clock.numerator}/{clock.denominator}",
            }
        start = Fraction(line.picture(name, first)) / line.rate
        return {"video": shown(recording.path), "start": f"{start.numerator}/{start.denominator}"}
    shift = recording.first + line.offsets[recording.name]
    pattern = shown(recording.pattern)
    return {"pattern": pattern, "offset": shift} if shift else pattern
