"""The whole way from recordings to a capture folder or a stream: what the command fvvcapture does."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import tempfile
import time
import warnings
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy
from fvv import mux, recordings
from fvv.errors import DamagedError, Error, LossWarning, UsageError
from fvv.interop.optional_import import optional_import
from fvv.outputs import FileOutput, FolderOutput, commit_all

from . import agreement, footage, pipeline, synchronise
from .cameras import Calibration, read_calibration
from .footage import Recording, Timeline
from .keying import Key
from .pipeline import Executors, FrameResult, NothingInCommon, Options, Progress, Work
from .report import SILHOUETTE_WARNING, chart, describe_frames, leave_one_out, need_matplotlib
from .sheet import draw
from .synchronise import synchronised

cv2: Any = optional_import("cv2", "capture")

#: A key below this confidence is named in a warning.
LOW_CONFIDENCE = 0.35
#: Metres between which what people do is high: less than a child lies, or more than a player reaches with a jump, is another unit.
HEIGHTS = 0.5, 3.6
#: Frames of the preview sheet.
SHEET_FRAMES = 4


@dataclasses.dataclass(frozen=True)
class Request:
    """What to make, and of what. Paths are those of files that exist."""

    recordings: str  #: A folder: see `footage.find`.
    calibration: str | Sequence[str]  #: See `cameras.read_calibration`.
    output: str  #: A folder for a capture, or a name ending in .fvv.
    plates: str | None = None  #: Recordings of the empty stage, named alike. None: the median of each clip.
    masks: str | None = None  #: Masks of another program, named alike, in place of keying.
    rate: Fraction | None = None  #: Frames a second; None: that of the videos.
    offsets: Mapping[str, float] = dataclasses.field(
        default_factory=dict
    )  #: Pictures, by name of the recording.
    synchronise: synchronise.Method | None = None  #: How to find offsets of those that are not given.
    accept_offsets: bool = False  #: Go on where offsets that were found are not certain.
    recording_names: Sequence[
        str
    ] = ()  #: Of recordings, plates and masks, where it is not the camera's: "{camera}_take".
    units: str | None = None  #: Of the calibration, where its format does not say.
    up: str | None = None  #: "+y", ...: in place of what the calibration says.
    cameras: Sequence[str] = ()  #: Names; empty: all that have recordings.
    exclude: Sequence[str] = ()  #: Names of cameras that are left out.
    frames: tuple[int, int | None] | None = None  #: First and last; None: the last that all have.
    places: Mapping[str, tuple[int, int]] = dataclasses.field(
        default_factory=dict
    )  #: `place` of capture.md, by camera.
    name: str = ""  #: Of the scene.
    sound: str | None = None  #: Name of the recording whose sound is taken.
    sheet: str | None = None  #: A PNG of pictures and mattes.
    chart: str | None = None  #: A PNG of the report, which needs matplotlib.
    held_out: int = 0  #: Frames that each camera in turn is predicted at from the others.
    options: Options = dataclasses.field(default_factory=Options)
    mux: Mapping[str, Any] = dataclasses.field(default_factory=dict)  #: Options of `fvv.mux` for a stream.
    force: bool = False


class UncertainOffsets(Error):
    """Offsets that were found are not certain; without outputs."""


@dataclasses.dataclass
class Result:
    """What was made."""

    report: dict[str, Any]  #: As report.json; spec/fvvcapture.schema.json.
    warnings: list[str]


@dataclasses.dataclass(frozen=True)
class _Shoot:
    """Cameras with their recordings, on one time line."""

    entries: list[dict[str, Any]]  #: As in capture.json, without pictures.
    names: list[str]  #: Of the cameras; also of their folders.
    recordings: list[Recording]
    masks: dict[str, Recording]  #: That are given, by name of the recording; empty: pictures are keyed.
    line: Timeline
    numbers: list[int]
    found: dict[str, synchronise.Offset]


def process(
    request: Request, jobs: int = 1, client: Any = None, progress: Progress = lambda stage, done, count: None
) -> Result:
    """Makes a capture or a stream. jobs: processes at once; client: of Dask, in place of them. progress: called with what is
    done, how much, and of how much.

    Raises `UsageError`, `DamagedError`, OSError; then nothing is left of the outputs. Warnings are in the result.
    """
    began = time.perf_counter()
    notes: list[str] = []
    outputs: list[FileOutput | FolderOutput] = []
    scratch: tempfile.TemporaryDirectory[str] | None = None
    try:
        # Refused before the work, not after it.
        sheet = FileOutput(request.sheet, request.force) if request.sheet else None
        if sheet is not None:
            outputs.append(sheet)
        picture = FileOutput(request.chart, request.force) if request.chart else None
        if picture is not None:
            outputs.append(picture)
            need_matplotlib()
        stream: FileOutput | None = None
        if request.output.endswith(".fvv"):
            stream = FileOutput(request.output, request.force)
            outputs.append(stream)
            place = os.path.dirname(os.path.realpath(request.output))
            scratch = tempfile.TemporaryDirectory(prefix=".fvvcapture-", dir=place)
            target, final = scratch.name, None
        else:
            folder = FolderOutput(request.output, "fvvcapture", request.force)
            outputs.append(folder)
            assert folder.temporary is not None
            target, final = folder.temporary, request.output
        calibration = read_calibration(request.calibration, units=request.units)
        if not calibration.unit_known:
            notes.append("the calibration does not say its unit of length: pass --units")
        with Executors(jobs, client) as run:
            shoot = _shoot(request, calibration, progress, notes)
            work, how = _work(request, shoot, target, run, progress)
            doubts = _doubts(request, shoot, work, progress)
            notes += agreement.sentences(doubts, shoot.names)
            try:
                work = pipeline.prepare(work, shoot.numbers, run, progress)
            except NothingInCommon as error:
                raise Error("; ".join([str(error), *notes])) from error
            if sheet is not None:
                sheet.write(_sheet(work, shoot))
            results = pipeline.make(work, shoot.numbers, shoot.names, run, progress)
        for keyer in work.keyers:
            if keyer is not None:
                os.unlink(keyer)
        text = _capture(request, calibration, shoot, results, final)
        _write(os.path.join(target, "capture.json"), text.encode())
        _warn(shoot, results, notes)
        height = _height(results, request.up or calibration.up)
        if calibration.unit_known and not HEIGHTS[0] <= height <= HEIGHTS[1]:
            notes.append(
                f"the action is {height:.3g} m high: if these are people, the calibration's unit is wrong, or the square of its board"
            )
        report = describe_frames(results, shoot.names, how)
        report["offsets"] = {
            name: {"pictures": offset, **_found_offset(shoot.found.get(name), name in shoot.line.clocks)}
            for name, offset in shoot.line.offsets.items()
        }
        assert work.bounds is not None
        report["height"] = height
        report["doubts"] = [
            {"camera": shoot.names[d.camera], "frame": n, "iou": d.iou, "gain": d.gain, "cause": d.cause}
            for n, found in doubts.items()
            for d in found
        ]
        report["bounds"] = {"low": list(work.bounds[0]), "high": list(work.bounds[1])}
        if stream is not None:
            report["mux"] = _mux(
                os.path.join(target, "capture.json"), stream, request, shoot.numbers, notes, progress
            )
        if request.held_out:
            report["held_out"] = _held_out(
                request, calibration, shoot, results, target, stream, notes, progress
            )
        report["seconds"]["all"] = time.perf_counter() - began
        report["warnings"] = notes
        if stream is None:
            _write(os.path.join(target, "report.json"), (json.dumps(report, indent=1) + "\n").encode())
        if picture is not None:
            picture.write(chart(report))
        commit_all(outputs)
        return Result(report, notes)
    finally:
        for output in outputs:
            output.discard()
        if scratch is not None:
            scratch.cleanup()


def _held_out(
    request: Request,
    calibration: Calibration,
    shoot: _Shoot,
    results: Sequence[FrameResult],
    target: str,
    stream: FileOutput | None,
    notes: list[str],
    progress: Progress,
) -> list[dict[str, Any]]:
    """Of some frames each camera, predicted from the others."""
    # Names of files are absolute in here, as the folder has a temporary name.
    text = _capture(request, calibration, shoot, results, None)
    described = os.path.join(target, "held_out.json")
    _write(described, text.encode())
    clip = os.path.join(target, "held_out.fvv") if stream is None else stream.temporary
    try:
        if clip is None:
            raise UsageError(
                f"{request.output}: --held-out needs a file that can be read back", file=request.output
            )
        if stream is None:
            _mux(described, clip, request, shoot.numbers, notes, progress)
        else:
            stream.flush()
        reader = recordings.Footage(text, described)
        return leave_one_out(clip, reader, pipeline.spread(shoot.numbers, request.held_out), progress)
    finally:
        os.unlink(described)
        if stream is None and clip is not None and os.path.exists(clip):
            os.unlink(clip)


def _write(path: str, content: bytes) -> None:
    with open(path, "wb") as file:
        file.write(content)


def _shoot(request: Request, calibration: Calibration, progress: Progress, notes: list[str]) -> _Shoot:
    progress("read recordings", 0, 1)
    names = [entry["name"] for entry in calibration.entries]
    for name in [*request.cameras, *request.exclude, *request.places]:
        if name not in names:
            raise UsageError(f"there is no camera {name} in the calibration: {', '.join(names)}")
    recordings = footage.find(request.recordings, request.recording_names, request.exclude)
    matched, unused = footage.match_cameras(names, recordings)
    wanted = [
        i
        for i in sorted(matched)
        if (not request.cameras or names[i] in request.cameras) and names[i] not in request.exclude
    ]
    missing = [name for i, name in enumerate(names) if i not in matched and name not in request.exclude]
    if missing:
        notes.append(f"cameras without a recording are left out: {', '.join(missing)}")
    if unused:
        notes.append(f"recordings without a calibrated camera are left out: {', '.join(unused)}")
    entries = [dict(calibration.entries[i]) for i in wanted]
    chosen = [matched[i] for i in wanted]
    if not chosen:
        raise UsageError("expected a camera or more, found none of those wanted")
    for entry, recording in zip(entries, chosen):
        entry.pop("pictures", None)
        entry.pop("masks", None)
        expected = (entry["width"], entry["height"])
        if recording.size != expected and entry["name"] not in request.places:
            raise UsageError(
                f"{recording.path}: expected pictures of {expected[0]} x {expected[1]}, the size of the calibration, found "
                f"{recording.size[0]} x {recording.size[1]}; if they are cut out of it, pass --place {entry['name']}=X,Y",
                file=recording.path,
            )
    masks = _given_masks(request, chosen)
    rate = footage.common_rate(chosen, request.rate)
    line, found = _timeline(request, chosen, rate, progress, notes)
    numbers = list(range(line.first, line.first + line.count))
    if request.frames is not None:
        first = request.frames[0]
        last = line.first + line.count - 1 if request.frames[1] is None else request.frames[1]
        if not line.first <= first <= last < line.first + line.count:
            raise UsageError(
                f"--frames: expected frames from {line.first} to {line.first + line.count - 1}, "
                f"which all recordings have, found {first}-{last}"
            )
        numbers = list(range(first, last + 1))
    return _Shoot(entries, [str(e["name"]) for e in entries], chosen, masks, line, numbers, found)


def _timeline(
    request: Request, chosen: Sequence[Recording], rate: Fraction, progress: Progress, notes: list[str]
) -> tuple[Timeline, dict[str, synchronise.Offset]]:
    """By the offsets that were given, and by those that are found for the other recordings."""
    names = {r.name for r in chosen}
    offsets = {name: value for name, value in request.offsets.items() if name in names}
    found: dict[str, synchronise.Offset] = {}
    drifts: dict[str, float] = {}
    if request.synchronise is not None:
        # The clock of the sound that is sent is the take's.
        order = sorted(chosen, key=lambda r: r.name != request.sound)
        found = synchronised(order, request.synchronise, rate, progress)
        weak = [n for n, o in found.items() if o.confidence < synchronise.TRUSTED and n not in offsets]
        if weak:
            note = f"offsets by {request.synchronise} are not certain: " + ", ".join(
                f"{name} {found[name].confidence:.2f}" for name in weak
            )
            if not request.accept_offsets:
                raise UncertainOffsets(
                    f"{note}; nothing is written: pass --offset CAMERA=N for them, try another way to --synchronise, or "
                    "--accept-offsets"
                )
            notes.append(note)
        for name in names - set(offsets):
            offset = found[name].seconds * float(rate)
            # What pictures tell is right to half a picture, as a whole number is.
            offsets[name] = (
                offset if request.synchronise in ("sound", "timecode") else math.floor(offset + 0.5)
            )
            drifts[name] = found[name].drift
    line = footage.timeline(chosen, rate, offsets, drifts)
    _warn_of_time(chosen, line, drifts, notes)
    return line, found


def _warn_of_time(
    chosen: Sequence[Recording], line: Timeline, drifts: Mapping[str, float], notes: list[str]
) -> None:
    for name, end in line.ends.items():
        last = line.first + line.count - 1
        notes.append(f"{name} ends after frame {end - 1}: frames {end} to {last} are made without it")
    for recording in chosen:
        drift = drifts.get(recording.name, 0.0)
        if recording.ticks is None and abs(drift) * line.count > 0.5:
            notes.append(
                f"{recording.name}: its clock drifts by {1e6 * drift:.0f} ppm, {abs(drift) * line.count:.1f} pictures over the take, which "
                "pictures in a folder cannot follow: pass --frames for a part, or a video"
            )


def _given_masks(request: Request, recordings: Sequence[Recording]) -> dict[str, Recording]:
    if request.masks is None:
        return {}
    masks = footage.find(request.masks, request.recording_names)
    missing = [r.name for r in recordings if r.name not in masks]
    if missing:
        raise UsageError(
            f"{request.masks}: expected masks of each camera, found none of {', '.join(missing)}",
            file=request.masks,
        )
    return masks


def _head(rate: Fraction, first: int, count: int) -> dict[str, Any]:
    return {
        "fvv_capture": 1,
        "frame_rate": f"{rate.numerator}/{rate.denominator}",
        "frames": {"first": first, "count": count},
        "units": "metres",
    }


def _entries(shoot: _Shoot, request: Request, relative_to: str | None = None) -> list[dict[str, Any]]:
    """Cameras of a capture.json with their pictures, and masks that are given."""
    first = shoot.numbers[0]
    out = []
    for entry, recording in zip(shoot.entries, shoot.recordings):
        place = request.places.get(entry["name"])
        made = {
            **_until(entry, shoot.line.ends.get(recording.name), shoot.numbers),
            "pictures": _placed(footage.source(recording, shoot.line, first, relative_to), place),
        }
        mask = shoot.masks.get(recording.name)
        if mask is not None:
            named = dataclasses.replace(mask, name=recording.name)
            source = footage.source(named, shoot.line, first, relative_to)
            made["masks"] = _placed(source, place if mask.size == recording.size else None)
        out.append(made)
    return out


def _until(entry: dict[str, Any], end: int | None, numbers: Sequence[int]) -> dict[str, Any]:
    """A camera that has no pictures from a frame on: not calibrated from there."""
    if end is None or end > numbers[-1]:
        return entry
    given = {one["frame"]: one for one in entry.get("per_frame", [])}
    frames = [given.get(n, {"frame": n}) if n < end else {"frame": n, "calibrated": False} for n in numbers]
    return {**entry, "per_frame": frames}


def _placed(source: dict[str, Any] | str, place: tuple[int, int] | None) -> dict[str, Any] | str:
    if place is None:
        return source
    return {**({"pattern": source} if isinstance(source, str) else source), "place": list(place)}


def _work(
    request: Request, shoot: _Shoot, target: str, run: Executors, progress: Progress
) -> tuple[Work, list[dict[str, Any] | None]]:
    """Without bounds; and how each camera is keyed."""
    line, numbers = shoot.line, shoot.numbers
    problems, _ = pipeline.open_footage(_description(request, shoot, numbers[0], len(numbers))).check()
    if problems:
        raise DamagedError("; ".join(problems[:4]))
    keyers: list[str | None] = [None] * len(shoot.recordings)
    how: list[dict[str, Any] | None] = [None] * len(shoot.recordings)
    if not shoot.masks:
        keyers = [os.path.join(target, f"keyer-{i}") for i in range(len(shoot.recordings))]
        how = _learn(request, shoot, [k for k in keyers if k is not None], run, progress)
    middle = numbers[len(numbers) // 2]
    late = tuple(line.place(r.name, middle) - line.picture(r.name, middle) for r in shoot.recordings)
    # Of all frames: moments at either end of the wanted ones lie between pictures too.
    text = _description(request, shoot, line.first, line.count)
    return Work(text, target, tuple(keyers), request.options, late=late), how


def _doubts(
    request: Request, shoot: _Shoot, work: Work, progress: Progress
) -> dict[int, list[agreement.Doubt]]:
    """Cameras that do not agree with the others in the middle frame, by frame."""
    frame = shoot.numbers[len(shoot.numbers) // 2]
    progress("compare cameras", 0, 1)
    cameras, _, masks = pipeline.keys_of(work, frame)
    options = request.options.hull
    box = request.options.bounds
    # Cameras that look at something else leave nothing in common; the others do.
    for missed in range(options.missed, 1 + len(cameras) // 3):
        found = None if box is not None else pipeline.common_box(cameras, masks, options, missed)
        if found is not None:
            low, high = found
            box = (low[0], low[1], low[2]), (high[0], high[1], high[2])
    if box is None:
        return {}
    line = shoot.line

    def later(index: int, by: int) -> Any:
        if not line.first <= frame + by < line.first + line.count:
            return None
        return pipeline.mask_of(work, index, frame + by)

    return {frame: agreement.find(cameras, masks, box, options, shoot.names, later)}


def _description(request: Request, shoot: _Shoot, first: int, count: int) -> str:
    """capture.json without meshes, of other frames than the ones wanted."""
    other = dataclasses.replace(shoot, numbers=list(range(first, first + count)))
    return pipeline.without_meshes(_entries(other, request), _head(shoot.line.rate, first, count))


def _learn(
    request: Request,
    shoot: _Shoot,
    paths: Sequence[str],
    run: Executors,
    progress: Progress,
) -> list[dict[str, Any] | None]:
    """Backgrounds and colours, from all that was filmed and not from the frames that are wanted alone: the longer, the less of the
    action stays in the background."""
    text = _description(request, shoot, shoot.line.first, shoot.line.count)
    empty = _empty_stage(request, shoot) if request.plates is not None else [None] * len(paths)
    calls = [(text, i, path, request.options.key, stage) for i, (path, stage) in enumerate(zip(paths, empty))]
    found: list[dict[str, Any] | None] = []
    for how in run.map(pipeline.learn_keyer, calls):
        found.append(how)
        progress("learn backgrounds", len(found), len(calls))
    return found


def _empty_stage(request: Request, shoot: _Shoot) -> list[str]:
    """For each camera the description of its pictures of the empty stage."""
    assert request.plates is not None
    plates = footage.find(request.plates, request.recording_names, request.exclude)
    out = []
    for entry, recording in zip(shoot.entries, shoot.recordings):
        plate = plates.get(recording.name)
        if plate is None:
            raise UsageError(
                f"{request.plates}: expected a recording of {recording.name}, found {', '.join(plates)}"
            )
        if plate.size != recording.size:
            raise UsageError(
                f"{plate.path}: expected pictures of {recording.size[0]} x {recording.size[1]}, found "
                f"{plate.size[0]} x {plate.size[1]}",
                file=plate.path,
            )
        count = min(plate.count, pipeline.PLATE_PICTURES)
        line = Timeline(shoot.line.rate, {plate.name: 0}, 0, count, {plate.name: 0})
        shown = {k: v for k, v in entry.items() if k != "per_frame"}
        shown["pictures"] = _placed(footage.source(plate, line, 0), request.places.get(entry["name"]))
        out.append(pipeline.without_meshes([shown], _head(shoot.line.rate, 0, count)))
    return out


def _sheet(work: Work, shoot: _Shoot) -> bytes:
    """A PNG of some frames."""
    frames = pipeline.spread(shoot.numbers, SHEET_FRAMES)
    reader = pipeline.open_footage(work.description)
    keys: list[list[Key]] = [[] for _ in shoot.names]
    pictures: list[list[Any]] = [[] for _ in shoot.names]
    for number in frames:
        _, found, masks = pipeline.keys_of(work, number)
        for index, (key, mask) in enumerate(zip(found, masks)):
            picture = reader.picture(index, number)
            if key is None:  # a given mask, or none at a frame without a calibration
                mask = numpy.zeros(picture.shape[:2], numpy.uint8) if mask is None else mask
                key = Key(mask, mask, mask, 1.0, 0, 0.0, "given")
            keys[index].append(key)
            pictures[index].append(picture)
    drawn = draw(keys, pictures, shoot.names, frames)
    done, data = cv2.imencode(".png", drawn[:, :, ::-1])
    if not done:
        raise Error("OpenCV cannot encode the sheet")
    return bytes(data.tobytes())


def _capture(
    request: Request,
    calibration: Calibration,
    shoot: _Shoot,
    results: Sequence[FrameResult],
    final: str | None,
) -> str:
    """The text of capture.json. final: the folder that it is going to be in, from which names are relative; None: they are absolute."""
    base = None if final is None else os.path.realpath(final)
    entries = _entries(shoot, request, base)
    if not shoot.masks:
        for entry, name in zip(entries, shoot.names):
            entry["masks"] = f"{pipeline.mask_name(name).replace('%', '%%')}/%04d.png"
    out = _head(shoot.line.rate, shoot.numbers[0], len(shoot.numbers))
    if request.name:
        out["name"] = request.name
    if not calibration.unit_known:
        out["units"] = "unknown"
    out["up"] = request.up or calibration.up
    empty = [r.number for r in results if r.empty]
    out["meshes"] = {"pattern": "meshes/%04d.ply", **({"empty": empty} if empty else {})}
    out["cameras"] = entries
    if request.sound is not None:
        by_name = {r.name: r for r in shoot.recordings}
        if request.sound not in by_name:
            raise UsageError(f"sound of {request.sound}: expected one of {', '.join(by_name)}")
        recording = by_name[request.sound]
        start = Fraction(shoot.line.picture(recording.name, shoot.numbers[0])) / shoot.line.rate
        path = recording.path if base is None else os.path.relpath(recording.path, base)
        out["audio"] = [{"file": path, "offset": f"{start.numerator}/{start.denominator}"}]
    return json.dumps(out, indent=1) + "\n"


def _found_offset(found: synchronise.Offset | None, has_clock: bool) -> dict[str, Any]:
    if found is None:
        return {}
    out = {"seconds": found.seconds, "confidence": found.confidence, "residual": found.residual}
    return {**out, "drift_ppm": 1e6 * found.drift} if has_clock else out


def _height(results: Sequence[FrameResult], up: str) -> float:
    """Metres along the axis that points up, the median of all frames with a mesh."""
    axis = "xyz".index(up[1])
    return float(numpy.median([result.size[axis] for result in results if not result.empty]))


def _warn(shoot: _Shoot, results: Sequence[FrameResult], notes: list[str]) -> None:
    empty = [r.number for r in results if r.empty]
    if empty:
        notes.append(f"{len(empty)} of {len(results)} frames have no mesh, such as {empty[0]}")
    for index, name in enumerate(shoot.names):
        low = [r for r in results if (c := r.confidence[index]) is not None and c < LOW_CONFIDENCE]
        if low:
            worst = min(low, key=lambda r: r.confidence[index] or 0.0)
            notes.append(
                f"{name}: the key of {len(low)} of {len(results)} frames is not certain, least in frame {worst.number} "
                f"({worst.confidence[index]:.2f})"
            )
        off = [r for r in results if (v := r.iou[index]) is not None and v < SILHOUETTE_WARNING]
        if off:
            least = min(off, key=lambda r: r.iou[index] or 0.0)
            notes.append(
                f"{name}: in {len(off)} of {len(results)} frames the mesh does not fill the silhouette, least in frame "
                f"{least.number} (IoU {least.iou[index]:.2f})"
            )


def _mux(
    capture: str,
    target: str | FileOutput,
    request: Request,
    numbers: Sequence[int],
    notes: list[str],
    progress: Progress,
) -> dict[str, Any]:
    """Packs the capture; losses become notes."""
    options: dict[str, Any] = {"frames": f"{numbers[0]}-{numbers[-1]}", **request.mux}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = mux(
            capture,
            target,
            # Selected, because recordings are longer than what all of them have.
            **options,
            progress=lambda done, count: progress("encode", done, count),
        )
    for warning in caught:
        if issubclass(warning.category, LossWarning):
            notes.append(f"mux: {warning.message}")
        else:
            warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    return found
