"""The command `fvvcapture calibrate`: from videos of a board walk to a calibration file."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import json
import os
import sys

from fvv.command import DONE, LOSS
from fvv.errors import UsageError
from fvv.outputs import FileOutput, FolderOutput, commit_all

from ..arguments import listed
from ..progress import Show
from .boards import parse_board
from .calibration import Calibration, Options, Progress, calibrate
from .files import calibration_output, from_description, read_calibration
from .moving import track
from .recordings import in_step, recordings_of
from .report import pictures_output, report


def run(arguments: argparse.Namespace) -> int:
    """Calibrates, writes and reports. Returns the exit code: 0, or 3 if the report has warnings. Errors are raised: `fvv.errors`,
    OSError, ImportError."""
    if arguments.output is None and arguments.report is None and not arguments.json:
        raise UsageError("expected -o, --report or --json: there is nothing to write")
    if arguments.output is not None and not arguments.force and os.path.lexists(arguments.output):
        # Refused before minutes of work.
        raise UsageError(f"{arguments.output}: already exists; --force replaces it", file=arguments.output)
    if arguments.take is None and arguments.zoom:
        raise UsageError("--zoom: expected --take, by which moving cameras are found")
    first, last = _frames(arguments.frames)
    progress = Show()
    try:
        found = _calibrated(arguments, first, last, progress)
        if arguments.take is not None:
            found = track(
                found,
                recordings_of(arguments.take, _offsets(arguments.offset), arguments.name),
                arguments.moving,
                tripod=arguments.tripod,
                zoom=arguments.zoom,
                progress=progress,
            )
    finally:
        progress.clear()
    with contextlib.ExitStack() as ended:
        outputs: list[FileOutput | FolderOutput] = []
        if arguments.report is not None:
            outputs.append(pictures_output(arguments.report, found))
            ended.callback(outputs[-1].discard)
        if arguments.output is not None:
            outputs.append(calibration_output(arguments.output, found, arguments.format, arguments.force))
            ended.callback(outputs[-1].discard)
        commit_all(outputs)
    lost = _print(arguments, found)
    return LOSS if found.warnings or lost else DONE


def _calibrated(
    arguments: argparse.Namespace, first: int, last: int | None, progress: Progress | None
) -> Calibration:
    if arguments.calibration is not None:
        if arguments.take is None or arguments.videos is not None:
            raise UsageError("--calibration: expected --take, and no board walk")
        if arguments.report is not None:
            raise UsageError("--report: expected a board walk, whose errors it shows")
        return from_description(*read_calibration(arguments.calibration))
    if arguments.videos is None:
        raise UsageError("expected FOLDER, the recordings of a board walk, or --calibration")
    if arguments.board is None or arguments.square is None:
        raise UsageError("expected --board and --square")
    if (arguments.moving or arguments.tripod) and arguments.take is None:
        raise UsageError("--moving, --tripod: expected --take, by which their poses are found")
    distance = arguments.distance
    if distance is not None:
        distance = (distance[0], distance[1], _number("--distance", distance[2]))
    options = Options(
        first,
        arguments.step,
        last,
        arguments.lens,
        tuple(arguments.moving),
        arguments.up,
        arguments.floor,
        distance,
    )
    board = parse_board(
        arguments.board, arguments.square, arguments.marker, arguments.dictionary, arguments.legacy
    )
    offsets = _offsets(arguments.offset)
    recordings = recordings_of(arguments.videos, offsets, arguments.name, listed(arguments.exclude))
    warnings: list[str] = []
    if arguments.synchronise is not None:
        recordings, warnings = in_step(recordings, arguments.synchronise, offsets, progress)
    found = calibrate(recordings, board, options, progress)
    return dataclasses.replace(found, warnings=(*warnings, *found.warnings))


def _frames(text: str | None) -> tuple[int, int | None]:
    if text is None:
        return 0, None
    first, dash, last = text.partition("-")
    if not (dash and first.isdigit() and last.isdigit() and int(first) <= int(last)):
        raise UsageError(f"--frames: expected A-B, such as 0-300, found {text}")
    return int(first), int(last)


def _offsets(given: list[str]) -> dict[str, int]:
    out = {}
    for one in given:
        name, equals, frames = one.rpartition("=")
        try:
            out[name] = int(frames)
        except ValueError:
            equals = ""
        if not equals or not name:
            raise UsageError(f"--offset: expected CAMERA=FRAMES, such as left=-3, found {one}")
    return out


def _number(option: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise UsageError(f"{option}: expected a number of metres, found {text}") from None


def _print(arguments: argparse.Namespace, found: Calibration) -> int:
    """Figures on standard output, warnings on standard error. Returns the number of frames without a pose."""
    lost = 0
    for camera in found.cameras:
        missing = [frame for frame, moment in (camera.per_frame or {}).items() if moment is None]
        lost += len(missing)
        if missing:
            print(
                f"fvvcapture: camera {camera.name}: {len(missing)} of {len(camera.per_frame or {})} frames have no pose, the first is "
                f"{missing[0]}",
                file=sys.stderr,
            )
    for warning in found.warnings:
        print(f"fvvcapture: {warning}", file=sys.stderr)
    if arguments.json:
        print(json.dumps(report(found, arguments.output), indent=1))
        return lost
    for camera in found.cameras:
        x, y, z = camera.pose.centre
        line = f"{camera.name}: {camera.lens.model}, at {x:.3f} {y:.3f} {z:.3f} m"
        if len(camera.pixels):
            line += f", rms {camera.rms:.3f} px of {len(camera.pixels)} corners in {camera.views} views, {camera.covered:.0%} covered"
        if camera.per_frame is not None:
            poses = [one for one in camera.per_frame.values() if one is not None]
            line += f", moves: {len(poses)} of {len(camera.per_frame)} frames"
        print(line)
    return lost
