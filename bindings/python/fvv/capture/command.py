"""The command fvvcapture. Exit codes are those of all tools: 0 done, 1 failed, 2 usage, 3 done with a warning."""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from fractions import Fraction
from typing import Any

from .. import __version__
from ..command import DONE, LOSS, exit_code
from ..errors import UsageError
from ..friends.needed import needed
from .progress import Show

EXAMPLES = """examples:
  fvvcapture videos --calibration room.json -o players.fvv
  fvvcapture videos --calibration room.json --plate empty --sheet look.png -o capture
  fvvcapture videos --calibration room.qca.txt --up +z --frames 0-49 --key difference -o capture
  fvvcapture pictures --masks mattes --calibration sparse/0 --units metres --fps 25 -o players.fvv
  fvvcapture take --walk board --board 8x6 --square 0.08 --dictionary 4x4_100 --plate empty --synchronise sound -o take.fvv
  fvvcapture calibrate board_videos --board 8x6 --square 0.08 --marker 0.06 -o room.json
docs/fvvcapture.md explains all of it."""


def _pair(text: str, option: str, kind: Any) -> tuple[str, Any]:
    name, sign, value = text.rpartition("=")
    if not sign or not name:
        raise UsageError(f"{option}: expected NAME=VALUE, found {text}")
    try:
        return name, kind(value)
    except ValueError as error:
        raise UsageError(f"{option}: expected NAME=VALUE, found {text}: {error}") from None


def _numbers(text: str, option: str, count: int) -> tuple[float, ...]:
    try:
        found = tuple(float(part) for part in text.split(","))
    except ValueError:
        found = ()
    if len(found) != count:
        raise UsageError(f"{option}: expected {count} numbers with commas, found {text}")
    return found


def _frames(text: str) -> tuple[int, int | None]:
    first, dash, last = text.partition("-")
    try:
        return int(first), int(last) if last else (None if dash else int(first))
    except ValueError:
        raise UsageError(f"--frames: expected A-B or A-, found {text}") from None


def _length(text: str, option: str) -> float:
    """Metres of "8mm", "0.8cm", "0.008m" or "0.008"."""
    for unit, metres in (("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)):
        if text.endswith(unit):
            text, scale = text[: -len(unit)], metres
            break
    else:
        scale = 1.0
    try:
        value = float(text) * scale
    except ValueError:
        value = 0.0
    if not value > 0:
        raise UsageError(f"{option}: expected a length such as 8mm, found {text}")
    return value


def parser() -> argparse.ArgumentParser:
    """The arguments of fvvcapture, without those of its command `calibrate`."""
    out = argparse.ArgumentParser(
        prog="fvvcapture",
        description="Makes a capture for fvvmux, or a stream, of what calibrated cameras filmed: keying, visual hulls. "
        "fvvcapture calibrate makes the calibration.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    out.add_argument("--version", action="version", version=f"fvvcapture {__version__}")
    out.add_argument(
        "recordings", metavar="FOLDER", help="a video, or a folder of numbered pictures, for each camera"
    )
    files = out.add_argument_group("files")
    files.add_argument("--calibration", metavar="FILE", nargs="+",
                       help="of fvvcapture calibrate, a capture.json, COLMAP, OpenCV, nerfstudio, Qualisys, Middlebury, K/R/t text, Panoptic")  # fmt: skip
    files.add_argument(
        "-o", "--output", metavar="OUT", required=True, help="a folder for the capture, or NAME.fvv"
    )
    files.add_argument(
        "--plate", metavar="FOLDER", help="recordings of the empty stage; default: the median of each clip"
    )
    files.add_argument("--masks", metavar="FOLDER", help="masks of another program, in place of keying")
    files.add_argument(
        "--sheet", metavar="PNG", help="pictures with the outlines of their keys, to look at first"
    )
    files.add_argument("--chart", metavar="PNG", help="the report as a picture")
    files.add_argument(
        "--json", action="store_true", help="print the report as JSON (spec/fvvcapture.schema.json)"
    )
    files.add_argument("--force", action="store_true", help="replace outputs that exist (docs/outputs.md)")
    board = out.add_argument_group(
        "calibration of a board, in place of --calibration (docs/fvvcapture-calibrate.md)"
    )
    board.add_argument("--walk", metavar="FOLDER", help="films of a board that is carried through the volume")
    board.add_argument("--board", metavar="CxR", help="squares of the board in a row and in a column")
    board.add_argument("--square", type=float, metavar="METRES", help="side of a square")
    board.add_argument(
        "--marker", type=float, metavar="METRES", help="side of a marker; default: 3/4 of the square"
    )
    board.add_argument(
        "--dictionary", metavar="NAME", help="of the markers: 4x4_100; without it a chessboard"
    )
    board.add_argument(
        "--on-floor", type=int, metavar="FRAME", help="frame in which the board lies on the floor"
    )
    shoot = out.add_argument_group("cameras and time")
    shoot.add_argument(
        "--cameras", metavar="A,B", default="", help="names; default: all that have recordings"
    )
    shoot.add_argument("--exclude", metavar="A,B", default="", help="names of cameras to leave out")
    shoot.add_argument("--frames", metavar="A-B", help="of the frames that all cameras have; A-: to the end")
    shoot.add_argument("--fps", metavar="N[/D]", help="pictures a second; folders do not say")
    shoot.add_argument("--offset", metavar="CAM=PICTURES", action="append", default=[],
                       help="by which a recording begins earlier than the others")  # fmt: skip
    shoot.add_argument(
        "--synchronise", choices=("sound", "flash", "motion"), help="find offsets that are not given"
    )
    shoot.add_argument("--place", metavar="CAM=X,Y", action="append", default=[],
                       help="where the pictures are in the calibrated ones, if they are cut")  # fmt: skip
    shoot.add_argument(
        "--units", help="of the calibration, if its format does not say: metres, millimetres, ..."
    )
    shoot.add_argument(
        "--up", choices=("+x", "-x", "+y", "-y", "+z", "-z"), help="axis of the world that points up"
    )
    shoot.add_argument("--sound", metavar="CAM", help="the recording whose sound is taken")
    shoot.add_argument("--name", default="", help="of the scene")
    key = out.add_argument_group("keying (docs/fvvcapture-keying.md)")
    key.add_argument("--key", choices=("auto", "chroma", "difference", "both"), default="auto")
    key.add_argument("--backing", metavar="R,G,B", help="colour of the screen; default: measured")
    key.add_argument(
        "--shadows", choices=("drop", "keep"), default="drop", help="shadows are no part of the action"
    )
    key.add_argument(
        "--refine",
        choices=("none", "edge", "graph"),
        default="none",
        help="edge: outlines follow edges; graph: the least cut, slow",
    )
    hull = out.add_argument_group("visual hull (docs/fvvcapture-hull.md)")
    hull.add_argument("--cell", metavar="LENGTH", help="of the finest grid: 8mm")
    hull.add_argument("--max-error", metavar="PIXELS", type=float, help="in place of --cell; default 4")
    hull.add_argument(
        "--missed", metavar="K", type=int, default=0, help="silhouettes that may miss a point; default 0"
    )
    hull.add_argument("--least-views", metavar="N", type=int, help="cameras that must see a point; default 3")
    hull.add_argument("--bounds", metavar="X,Y,Z,X,Y,Z", help="low and high corner in metres; default: found")
    hull.add_argument(
        "--floor", metavar="METRES", type=float, help="height below which nothing is; needs --up"
    )
    hull.add_argument("--min-share", metavar="SHARE", type=float, default=0.02,
                      help="components below this share of the largest are dropped; default 0.02")  # fmt: skip
    hull.add_argument(
        "--smoothing", metavar="N", type=int, default=0, help="rounds, within the silhouettes; default 0"
    )
    hull.add_argument("--grids", action="store_true", help="keep grids/NNNN.npz beside the meshes")
    run = out.add_argument_group("running")
    run.add_argument("--jobs", metavar="N", type=int, default=os.cpu_count() or 1, help="processes at once")
    run.add_argument(
        "--dask", metavar="ADDRESS", help="scheduler of a Dask cluster that reaches the same paths"
    )
    run.add_argument("--held-out", metavar="N", type=int, default=0,
                     help="predict each camera from the others at N frames, and report its PSNR")  # fmt: skip
    run.add_argument("--mux", metavar="OPTION=VALUE", action="append", default=[],
                     help="option of fvvmux for NAME.fvv: scale=0.5")  # fmt: skip
    return out


def request_of(given: argparse.Namespace) -> Any:
    """A `process.Request`. Raises `UsageError`."""
    from .hull import DEFAULT_ERROR, HullOptions
    from .keying import KeyOptions
    from .pipeline import Options
    from .process import Request

    backing = None
    if given.backing is not None:
        red, green, blue = (int(v) for v in _numbers(given.backing, "--backing", 3))
        backing = (red, green, blue)
    if given.cell is not None and given.max_error is not None:
        raise UsageError("expected --cell or --max-error, not both")
    cell = None if given.cell is None else _length(given.cell, "--cell")
    error = given.max_error if given.max_error is not None or cell is not None else DEFAULT_ERROR
    floor = None
    if given.floor is not None:
        if given.up is None:
            raise UsageError("--floor: expected with --up")
        axis = [0.0, 0.0, 0.0]
        axis["xyz".index(given.up[1])] = 1.0 if given.up[0] == "+" else -1.0
        floor = (tuple(axis), given.floor)
    views = {} if given.least_views is None else {"least_views": given.least_views}
    hull = HullOptions(
        cell=cell, max_error=error, missed=given.missed, floor=floor, min_share=given.min_share,
        smoothing=given.smoothing, **views,
    )  # fmt: skip
    bounds = None
    if given.bounds is not None:
        box = _numbers(given.bounds, "--bounds", 6)
        if not all(low < high for low, high in zip(box[:3], box[3:])):
            raise UsageError(f"--bounds: expected the low corner before the high one, found {given.bounds}")
        bounds = ((box[0], box[1], box[2]), (box[3], box[4], box[5]))
    options = Options(
        key=KeyOptions(mode=given.key, backing=backing, shadows=given.shadows == "drop", refine=given.refine),
        hull=hull,
        bounds=bounds,
        keep_grids=given.grids,
    )
    rate = None
    if given.fps is not None:
        try:
            rate = Fraction(given.fps)
        except (ValueError, ZeroDivisionError):
            rate = Fraction(0)
        if rate <= 0:
            raise UsageError(f"--fps: expected a number above 0 or a fraction, found {given.fps}")
    mux = dict(_pair(text, "--mux", str) for text in given.mux)
    if mux and not given.output.endswith(".fvv") and not given.held_out:
        raise UsageError("--mux: expected with -o NAME.fvv")
    if given.jobs < 1:
        raise UsageError(f"--jobs: expected 1 or more, found {given.jobs}")
    places = {}
    for text in given.place:
        name, value = _pair(text, "--place", str)
        x, y = _numbers(value, "--place", 2)
        places[name] = (int(x), int(y))
    return Request(
        given.recordings,
        given.calibration if len(given.calibration) > 1 else given.calibration[0],
        given.output,
        plates=given.plate,
        masks=given.masks,
        rate=rate,
        offsets=dict(_pair(text, "--offset", float) for text in given.offset),
        synchronise=given.synchronise,
        units=given.units,
        up=given.up,
        cameras=[name for name in given.cameras.split(",") if name],
        exclude=[name for name in given.exclude.split(",") if name],
        frames=None if given.frames is None else _frames(given.frames),
        places=places,
        name=given.name,
        sound=given.sound,
        sheet=given.sheet,
        held_out=given.held_out,
        options=options,
        mux={name.replace("-", "_"): value for name, value in mux.items()},
        force=given.force,
    )


def run(given: argparse.Namespace) -> int:
    """Calibrates if there are films of a board, and makes the capture or the stream."""
    if (given.calibration is None) == (given.walk is None):
        raise UsageError("expected --calibration, or --walk with --board and --square")
    show = Show()
    with tempfile.TemporaryDirectory(prefix="fvvcapture-") as scratch:
        if given.walk is not None:
            given.calibration = [_calibrate(given, os.path.join(scratch, "calibration.json"), show)]
        return _make(given, show)


def _calibrate(given: argparse.Namespace, path: str, show: Show) -> str:
    """Calibrates by films of a board, and returns the path of the calibration."""
    from .calibrate.boards import parse_board
    from .calibrate.calibration import Options, calibrate
    from .calibrate.files import write_calibration
    from .calibrate.recordings import recordings_of

    if given.board is None or given.square is None:
        raise UsageError("--walk: expected --board and --square")
    board = parse_board(given.board, given.square, given.marker, given.dictionary, False)
    options = Options(up=given.up or "+y", floor=given.on_floor)
    found = calibrate(recordings_of(given.walk, {}), board, options, show)
    for warning in found.warnings:
        print(f"fvvcapture: warning: {warning}", file=sys.stderr)
    write_calibration(path, found)
    return path


def _make(given: argparse.Namespace, show: Show) -> int:
    from ..outputs import FileOutput
    from .process import process
    from .report import chart, text

    request = request_of(given)
    client: Any = None
    picture = FileOutput(given.chart, given.force) if given.chart else None
    try:
        if given.dask is not None:
            try:
                client = needed("dask.distributed", "dask").Client(given.dask)
            except ImportError as error:
                raise UsageError(f"--dask: {error}") from error
        result = process(request, given.jobs, client, show)
        if picture is not None:
            picture.write(chart(result.report))
            picture.commit()
    finally:
        show.clear()
        if client is not None:
            client.close()
        if picture is not None:
            picture.discard()
    print(json.dumps(result.report, indent=1) if given.json else text(result.report))
    for note in result.warnings:
        print(f"fvvcapture: warning: {note}", file=sys.stderr)
    return LOSS if result.warnings else DONE


def main(arguments: list[str] | None = None) -> int:
    """Runs fvvcapture and returns its exit code; errors are one line on standard error."""
    arguments = sys.argv[1:] if arguments is None else arguments

    def run_command() -> int:
        if arguments[:1] != ["calibrate"]:
            return run(parser().parse_args(arguments))
        from .calibrate import command

        calibration = argparse.ArgumentParser(
            prog="fvvcapture calibrate", description="Calibrates cameras from a board.", allow_abbrev=False
        )
        command.add_arguments(calibration)
        return command.run(calibration.parse_args(arguments[1:]))

    return exit_code("fvvcapture", run_command)
