"""The command fvvcapture. Exit codes are those of all tools: 0 done, 1 failed, 2 usage, 3 done with a warning."""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from fractions import Fraction
from typing import Any

from fvv import __version__
from fvv.command import DONE, LOSS, exit_code
from fvv.errors import UsageError
from fvv.interop.optional_import import optional_import

from .arguments import calibrate_parser, capture_parser, listed, live_parser
from .progress import Show


def pair_of(text: str, option: str, kind: Any) -> tuple[str, Any]:
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


def backing_of(given: argparse.Namespace) -> tuple[int, int, int] | None:
    """The colour of the screen. Raises `UsageError`, as all of these."""
    if given.backing is None:
        return None
    red, green, blue = (int(v) for v in _numbers(given.backing, "--backing", 3))
    return red, green, blue


def hull_of(given: argparse.Namespace, smoothing: int = 0) -> Any:
    """A `hull.HullOptions`."""
    from .hull import DEFAULT_ERROR, HullOptions

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
    return HullOptions(
        cell=cell, max_error=error, missed=given.missed, floor=floor, min_share=given.min_share,
        smoothing=smoothing, **views,
    )  # fmt: skip


def bounds_of(given: argparse.Namespace) -> Any:
    """Low and high corner; None: they are not given."""
    if given.bounds is None:
        return None
    box = _numbers(given.bounds, "--bounds", 6)
    if not all(low < high for low, high in zip(box[:3], box[3:])):
        raise UsageError(f"--bounds: expected the low corner before the high one, found {given.bounds}")
    return (box[0], box[1], box[2]), (box[3], box[4], box[5])


def rate_of(given: argparse.Namespace) -> Fraction | None:
    """Frames a second; None: they are not given."""
    if given.fps is None:
        return None
    try:
        rate = Fraction(given.fps)
    except (ValueError, ZeroDivisionError):
        rate = Fraction(0)
    if rate <= 0:
        raise UsageError(f"--fps: expected a number above 0 or a fraction, found {given.fps}")
    return rate


def mux_of(given: argparse.Namespace) -> dict[str, str]:
    """Options of fvvmux, by the names of Python."""
    return {
        name.replace("-", "_"): value for name, value in (pair_of(text, "--mux", str) for text in given.mux)
    }


def request_of(given: argparse.Namespace) -> Any:
    """A `process.Request`."""
    from .keying import KeyOptions
    from .pipeline import Options
    from .process import Request

    backing, hull, bounds = backing_of(given), hull_of(given, given.smoothing), bounds_of(given)
    options = Options(
        key=KeyOptions(mode=given.key, backing=backing, shadows=given.shadows == "drop", refine=given.refine),
        hull=hull,
        bounds=bounds,
        keep_grids=given.grids,
        refined=given.surface == "refined",
    )
    rate, mux = rate_of(given), mux_of(given)
    if mux and not given.output.endswith(".fvv") and not given.held_out:
        raise UsageError("--mux: expected with -o NAME.fvv")
    if given.jobs is not None and given.jobs < 1:
        raise UsageError(f"--jobs: expected 1 or more, found {given.jobs}")
    places = {}
    for text in given.place:
        name, value = pair_of(text, "--place", str)
        x, y = _numbers(value, "--place", 2)
        places[name] = (int(x), int(y))
    return Request(
        given.recordings,
        given.calibration if len(given.calibration) > 1 else given.calibration[0],
        given.output,
        plates=given.plate,
        masks=given.masks,
        rate=rate,
        offsets=dict(pair_of(text, "--offset", float) for text in given.offset),
        synchronise=given.synchronise,
        units=given.units,
        up=given.up,
        cameras=listed(given.cameras),
        exclude=listed(given.exclude),
        frames=None if given.frames is None else _frames(given.frames),
        places=places,
        name=given.title,
        accept_offsets=given.accept_offsets,
        recording_names=given.name,
        sound=given.sound,
        sheet=given.sheet,
        chart=given.chart,
        held_out=given.held_out,
        options=options,
        mux=mux,
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
    from fvv.recordings import has_sound

    from .calibrate.boards import parse_board
    from .calibrate.calibration import Options, calibrate
    from .calibrate.files import write_calibration
    from .calibrate.recordings import in_step, recordings_of

    if given.board is None or given.square is None:
        raise UsageError("--walk: expected --board and --square")
    board = parse_board(given.board, given.square, given.marker, given.dictionary, False)
    options = Options(up=given.up or "+y", floor=given.on_floor)
    recordings = recordings_of(given.walk, {}, given.name, listed(given.exclude))
    warnings: list[str] = []
    # Films of a board often have no sound; they are in step then, or calibrate says which is not.
    if given.synchronise is not None and (
        given.synchronise != "sound" or all(has_sound(one.path) for one in recordings)
    ):
        recordings, warnings = in_step(recordings, given.synchronise, (), show)
    found = calibrate(recordings, board, options, show)
    for warning in [*warnings, *found.warnings]:
        print(f"fvvcapture: warning: {warning}", file=sys.stderr)
    write_calibration(path, found)
    return path


def _make(given: argparse.Namespace, show: Show) -> int:
    from .process import UncertainOffsets, process
    from .report import text

    request = request_of(given)
    client: Any = None
    try:
        if given.dask is not None:
            try:
                client = optional_import("dask.distributed", "dask").Client(given.dask)
            except ImportError as error:
                raise UsageError(f"--dask: {error}") from error
        result = process(request, given.jobs or os.cpu_count() or 1, client, show)
    except UncertainOffsets as error:
        print(f"fvvcapture: {error}", file=sys.stderr)
        return LOSS
    finally:
        show.clear()
        if client is not None:
            client.close()
    print(json.dumps(result.report, indent=1) if given.json else text(result.report))
    for note in result.warnings:
        print(f"fvvcapture: warning: {note}", file=sys.stderr)
    return LOSS if result.warnings else DONE


def main(arguments: list[str] | None = None) -> int:
    """Runs fvvcapture and returns its exit code; errors are one line on standard error."""
    arguments = sys.argv[1:] if arguments is None else arguments

    def run_command() -> int:
        if arguments[:1] == ["live"]:
            given = live_parser(__version__).parse(arguments[1:])
            from .live import command as live  # after the help, which needs neither OpenCV nor PyAV

            return live.run(given)
        if arguments[:1] != ["calibrate"]:
            return run(capture_parser(__version__).parse(arguments))
        given = calibrate_parser(__version__).parse(arguments[1:])
        from .calibrate import command  # after the help, which needs no OpenCV

        return command.run(given)

    return exit_code("fvvcapture", run_command)
