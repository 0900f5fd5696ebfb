"""The command fvvcapture live."""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import signal
import sys
import threading
from fractions import Fraction
from typing import Any

import numpy
from fvv.command import DONE, LOSS
from fvv.errors import UsageError

from ..arguments import listed
from ..cameras import read_calibration
from ..command import backing_of, bounds_of, hull_of, mux_of, pair_of, rate_of
from ..keying import KeyOptions
from .fineness import STEP
from .show import Event, Show, Summary
from .show import run as run_show
from .streams import sources

#: Half of the usual rate of cameras: what two processors hold with seven cameras of 480 x 270.
RATE = Fraction(25, 2)
#: Drift of exposure is slow, and time is short.
DRIFT_SAMPLES = 2000


def show_of(given: argparse.Namespace) -> Show:
    """What to make. Raises `UsageError`."""
    if not given.calibration:
        raise UsageError("expected --calibration")
    paths = given.calibration if len(given.calibration) > 1 else given.calibration[0]
    calibration = read_calibration(paths, units=given.units)
    if given.up is not None:
        calibration = dataclasses.replace(calibration, up=given.up)
    names = [str(entry["name"]) for entry in calibration.entries]
    found = sources(given.sources, names, listed(given.exclude))
    offsets = dict(pair_of(text, "--offset", float) for text in given.offset)
    for name in offsets:
        if name not in [source.name for source in found]:
            raise UsageError(f"--offset: there is no camera {name}")
    if given.jobs is not None and given.jobs < 1:
        raise UsageError(f"--jobs: expected 1 or more, found {given.jobs}")
    for option, value in (("--max-delay", given.max_delay), ("--idle", given.idle)):
        if not value > 0:
            raise UsageError(f"{option}: expected a number above 0, found {value:g}")
    key = KeyOptions(
        mode=given.key,
        backing=backing_of(given),
        shadows=given.shadows == "drop",
        drift_samples=DRIFT_SAMPLES,
    )
    # A stream that is not read back needs no index, which grows.
    mux = {"live": "on", "repeat_configuration": "on"} if given.output == "-" else {}
    return Show(
        calibration,
        found,
        rate_of(given) or RATE,
        bounds_of(given),
        key,
        hull_of(given),
        plates=given.plate,
        offsets=offsets,
        jobs=given.jobs or os.cpu_count() or 1,
        max_delay=given.max_delay,
        idle=given.idle,
        name=given.title,
        mux={**mux, **mux_of(given)},
    )


def as_json(summary: Summary) -> dict[str, Any]:
    """As spec/fvvcapture-live.schema.json has it."""
    delays = summary.delays or [0.0]
    return {
        "fvvcapture_live": 1,
        "frames": summary.frames,
        "hulls": summary.hulls,
        "hulls_per_second": summary.hulls / summary.seconds if summary.seconds else 0.0,
        "hull_delay_median": float(numpy.quantile(delays, 0.5)),
        "hull_delay_p95": float(numpy.quantile(delays, 0.95)),
        "largest_cells": STEP**summary.coarsest,
        "cameras": [{"name": name, **counts} for name, counts in summary.cameras.items()],
        "end": summary.end,
        "mux": {key: value for key, value in summary.mux.items() if key not in ("warned", "warnings")},
        "warnings": summary.mux["warnings"],
    }


def as_text(found: dict[str, Any]) -> str:
    """A summary for people."""
    times = found["mux"]["realtime"]
    lines = [
        f"{found['mux']['frames']} of {found['frames']} frames in the stream, {found['hulls']} hulls, "
        f"{found['hulls_per_second']:.1f} a second; lost {times['lost_frames']}, dropped {times['dropped_frames']}",
        f"from light to hull {found['hull_delay_p95']:.2f} s, to the last byte of a group {times['delay_p95']:.2f} s for 95 % of the "
        f"frames; cells at most {found['largest_cells']:.2f} times as large as given",
        *(
            f"{camera['name']}: {camera['pictures']} pictures, {camera['late']} late, stopped {camera['stops']} times"
            for camera in found["cameras"]
            if camera["late"] or camera["stops"]
        ),
        f"{found['end']}; {found['mux']['bytes']} bytes",
    ]
    return "\n".join(lines)


class _Events:
    """Printed as they come, by any thread: a line of JSON, or of text."""

    def __init__(self, are_json: bool) -> None:
        self._are_json = are_json
        self._lock = threading.Lock()

    def __call__(self, event: Event) -> None:
        if self._are_json:
            line = json.dumps(
                {"event": event.kind, "frame": event.frame, "age": event.age, "text": event.text}
            )
        else:
            frame = "" if event.frame is None else f"frame {event.frame}: "
            line = f"fvvcapture: {frame}{event.kind}: {event.text}"
        with self._lock:
            print(line, file=sys.stderr, flush=True)


def run(given: argparse.Namespace) -> int:
    """Films until the cameras end, or until SIGINT or SIGTERM; the second one kills."""
    show = show_of(given)
    piped = given.output == "-"
    if piped and sys.stdout.isatty():
        raise UsageError("-o -: expected a pipe, found a terminal")
    stopped = threading.Event()

    def stop(number: int, _: object) -> None:
        stopped.set()
        signal.signal(number, signal.SIG_DFL)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, stop)
    target: Any = open(sys.stdout.fileno(), "wb", 0, closefd=False) if piped else given.output  # noqa: SIM115
    summary = run_show(show, target, given.force, _Events(given.json), stopped.is_set)
    found = as_json(summary)
    print(
        json.dumps(found, indent=1) if given.json else as_text(found),
        file=sys.stderr if piped else sys.stdout,
    )
    return LOSS if summary.troubled or found["warnings"] else DONE
