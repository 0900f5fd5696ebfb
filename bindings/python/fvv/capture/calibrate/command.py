"""The command `fvvcapture calibrate`: from videos of a board walk to a calibration file."""

from __future__ import annotations

import argparse
import json
import os
import sys

from ...command import DONE, LOSS
from ...errors import UsageError
from ..progress import Show
from .boards import parse_board
from .calibration import Calibration, Options, Progress, calibrate
from .files import FORMATS, from_description, read_calibration, write_calibration
from .lenses import MODELS
from .moving import track
from .recordings import recordings_of
from .report import report, write_pictures
from .world import UPS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `run`."""
    parser.add_argument(
        "videos",
        metavar="VIDEOS",
        nargs="?",
        help="folder with a video or a folder of pictures for each camera: the board walk",
    )
    parser.add_argument("-o", "--output", metavar="OUT", help="calibration file to write")
    parser.add_argument("-f", "--force", action="store_true", help="replace OUT if it exists")
    parser.add_argument(
        "--format", choices=FORMATS, default="fvv", help="opencv: OUT is a folder of YAML files"
    )
    parser.add_argument("--board", metavar="CxR", help="squares of the board in a row and in a column")
    parser.add_argument("--square", type=float, metavar="METRES", help="side of a square")
    parser.add_argument(
        "--marker", type=float, metavar="METRES", help="side of a marker; default: 3/4 of the square"
    )
    parser.add_argument(
        "--dictionary", metavar="NAME", help="of the markers, such as 4x4_100; without it a chessboard"
    )
    parser.add_argument("--legacy", action="store_true", help="ChArUco pattern of OpenCV before 4.6")
    parser.add_argument(
        "--lens", choices=MODELS, default="auto", help="default: radtan5, or radtan8 where that is better"
    )
    parser.add_argument(
        "--offset",
        action="append",
        default=[],
        metavar="CAMERA=FRAMES",
        help="a camera that began earlier (positive) or later",
    )
    parser.add_argument("--frames", metavar="A-B", help="frames to use; default: all")
    parser.add_argument("--step", type=int, default=1, metavar="N", help="use every N-th frame")
    parser.add_argument("--up", choices=UPS, default="+y", help="axis of the world that points up")
    parser.add_argument(
        "--floor", type=int, metavar="FRAME", help="frame in which the board lies on the floor"
    )
    parser.add_argument(
        "--distance", nargs=3, metavar=("A", "B", "METRES"), help="metres between two cameras, for the scale"
    )
    parser.add_argument(
        "--moving", action="append", default=[], metavar="CAMERA", help="a camera that does not stand still"
    )
    parser.add_argument(
        "--tripod",
        action="append",
        default=[],
        metavar="CAMERA",
        help="a camera that turns and stays where it is; still in the walk",
    )
    parser.add_argument(
        "--take",
        metavar="VIDEOS",
        help="recordings of the scene, by which the poses of moving cameras are found",
    )
    parser.add_argument("--zoom", action="store_true", help="moving cameras also change their focal length")
    parser.add_argument(
        "--calibration",
        metavar="FILE",
        help="with --take: a calibration that exists, in place of a board walk",
    )
    parser.add_argument("--report", metavar="FOLDER", help="write a picture of each camera's errors there")
    parser.add_argument("--json", action="store_true", help="print the figures as JSON")


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
                recordings_of(arguments.take, _offsets(arguments.offset)),
                arguments.moving,
                tripod=arguments.tripod,
                zoom=arguments.zoom,
                progress=progress,
            )
    finally:
        progress.clear()
    if arguments.report is not None:
        write_pictures(arguments.report, found)
    if arguments.output is not None:
        write_calibration(arguments.output, found, arguments.format, arguments.force)
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
        raise UsageError("expected VIDEOS, the recordings of a board walk, or --calibration")
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
    return calibrate(recordings_of(arguments.videos, _offsets(arguments.offset)), board, options, progress)


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
