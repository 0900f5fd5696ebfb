"""What workers do: planning a stream, encoding its groups, merging them. Also how an error gets the place where it happened."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import hashlib
import json
import os
import pickle
import socket
import sys
import tempfile
import time
from typing import Any, Callable

from .. import _core
from ..errors import UsageError
from .storage import (
    Capture,
    filesystem,
    inside,
    is_local,
    make_folder,
    refuse_existing,
    write,
    written,
)

VERSION: str = _core.library_version
PLAN = "plan.cbor"
KEY = "plan.json"
#: What a call's merging wrote: a worker that dies after it has given the stream its name is followed by one that finds it done.
MERGED = "merged.json"
PROGRESS = "progress.json"
#: Seconds between two reports of progress.
INTERVAL = 1.0


@dataclasses.dataclass(frozen=True)
class Place:
    """Who ran a task."""

    host: str
    process: int
    address: str | None  #: Of a worker of Dask.
    version: str  #: Of fvv.

    def __str__(self) -> str:
        worker = f"worker {self.address}, " if self.address else ""
        return f"{worker}host {self.host}, process {self.process}"


@dataclasses.dataclass
class Outcome:
    """What a task returns, also when it fails: an exception alone would not say where."""

    place: Place | None  #: None: it is not known, or it reached no worker.
    value: Any = None
    error: Exception | None = None
    is_foreign: bool = False  #: The worker has another version of fvv.


def here() -> Place:
    address = None
    dask = sys.modules.get("distributed")
    if dask is not None:
        with contextlib.suppress(ValueError):  # not on a worker
            address = dask.get_worker().address
    return Place(socket.gethostname(), os.getpid(), address, VERSION)


def run(version: str, task: Callable[..., Any], *arguments: Any) -> Outcome:
    """version: of the caller's fvv, which has to be this one."""
    place = here()
    if version != VERSION:
        text = (
            f"has fvv {VERSION}, and the process that began has {version}: install the same version on both"
        )
        return Outcome(place, error=UsageError(text), is_foreign=True)
    try:
        return Outcome(place, task(*arguments))
    except Exception as error:
        return Outcome(place, error=_sendable(error))


def _sendable(error: Exception) -> Exception:
    """Without causes, and as text where it cannot be sent."""
    error.__cause__ = error.__context__ = None
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


def placed(error: Exception, what: str, place: Place | None) -> Exception:
    """The same exception with what was done, and where if it was not in this process, as part of its text."""
    own = here()
    if place is not None and (place.host, place.process, place.address) != (own.host, own.process, None):
        what += f"; {place}"
    if isinstance(error, OSError) and error.strerror is not None:
        error.strerror = f"{error.strerror} ({what})"
    else:
        error.args = (f"{error} ({what})",)
    return error


def nothing() -> None:
    """Shows that a worker is there."""


def executing(dask_worker: Any) -> list[str]:
    """The keys of tasks that a worker of Dask executes, cancelled ones among them."""
    return [str(task.key) for task in dask_worker.state.executing]


class Progress:
    """How far a task is, in a file of its folder that the caller reads. Failures to write it are left out."""

    def __init__(self, work: str, wanted: bool) -> None:
        self._work = work
        self._wanted = wanted
        self._last = 0.0

    def report(self, stage: str, part: float) -> None:
        if not self._wanted or time.monotonic() - self._last < INTERVAL:
            return
        with contextlib.suppress(Exception):
            files, folder = filesystem(self._work)
            files.pipe_file(inside(folder, PROGRESS), json.dumps([stage, part]).encode())
        self._last = time.monotonic()


def progress_of(work: str) -> tuple[str, float] | None:
    try:
        files, folder = filesystem(work)
        stage, part = json.loads(files.cat_file(inside(folder, PROGRESS)))
        return str(stage), float(part)
    except Exception:
        return None


def plan(
    capture: str, work: str, cameras: list[str], options: dict[str, str], wanted: bool
) -> tuple[str, list[int], float]:
    """Makes plan and first group, unless they are there. Returns the digest of the plan, the frames of each group and
    the seconds that it took. wanted: progress is."""
    start = time.monotonic()
    files, folder = filesystem(work)
    progress = Progress(work, wanted)
    with Capture(capture) as found:
        key = hashlib.sha256(found.description())
        key.update(json.dumps([VERSION, cameras, sorted(options.items())]).encode())
        if files.exists(inside(folder, KEY)):
            known = json.loads(files.cat_file(inside(folder, KEY)))
            if known.get("version", VERSION) != VERSION:
                raise UsageError(
                    f"{work}: has a plan of fvv {known['version']}, and this is {VERSION}: give another folder, or continue "
                    "with the version that planned",
                    file=work,
                )
            if known["key"] != key.hexdigest():
                raise UsageError(f"{work}: has the plan of another capture or with other options", file=work)
            return known["plan"], known["frames"], 0.0
        make_folder(work)
        found.fetch(lambda: _core.files_of(found.path), lambda part: progress.report("copy", part))
        progress.report("plan", 0.0)
        with written(inside(work, part_of(0))) as path, written(inside(work, report_of(0))) as report:
            made = _core.PartPlan.make(found.path, cameras, options, path)
            write(report, made.first_report.encode())
    content = made.data
    frames = [made.frames_of(group) for group in range(made.group_count)]
    with written(inside(work, PLAN)) as path:
        write(path, content)
    digest = hashlib.sha256(content).hexdigest()
    with written(inside(work, KEY)) as path:
        known = {"key": key.hexdigest(), "plan": digest, "frames": frames, "version": VERSION}
        write(path, json.dumps(known).encode())
    return digest, frames, time.monotonic() - start


def encode(capture: str, work: str, digest: str, group: int, threads: int) -> float:
    """Encodes a group, unless it is there: a stream is named last, so one that has its name is whole. Returns the seconds
    that it took."""
    start = time.monotonic()
    files, folder = filesystem(work)
    if files.exists(inside(folder, part_of(group))):
        return 0.0
    with Capture(capture) as found:
        planned = (_loaded if found.is_copied else _kept)(work, digest, found.path)
        found.fetch(lambda: planned.files_of(group))
        with (
            written(inside(work, part_of(group))) as path,
            written(inside(work, report_of(group))) as report,
        ):
            write(report, planned.encode(group, threads, path).encode())
    return time.monotonic() - start


def merge(
    work: str, digest: str, out: str, force: bool, call: str, wanted: bool
) -> tuple[int, list[str], float]:
    """Returns the bytes of the stream, all warnings, and the seconds that it took. call: which call's stream it is. wanted:
    progress is."""
    start = time.monotonic()
    files, folder = filesystem(work)
    with contextlib.suppress(FileNotFoundError):
        done = json.loads(files.cat_file(inside(folder, MERGED)))
        target, path = filesystem(out)
        if done["call"] == call and target.exists(path) and target.size(path) == done["bytes"]:
            return done["bytes"], done["warnings"], time.monotonic() - start
    planned = _loaded(work, digest, "")
    names = {os.path.basename(name) for name in files.ls(folder, detail=False)}
    planned.check_complete(work, [part_of(group) in names for group in range(planned.group_count)])
    progress = Progress(work, wanted)
    with tempfile.TemporaryDirectory() as copies, written(out, call) as path:

        def open_part(group: int) -> tuple[str, str]:
            progress.report("merge", group / planned.group_count)
            part = inside(folder, part_of(group))
            if not is_local(files):
                files.get_file(part, os.path.join(copies, "part.fvv"))
                part = os.path.join(copies, "part.fvv")
            return part, files.cat_file(inside(folder, report_of(group))).decode()

        size, losses = planned.merge(open_part, path)
        refuse_existing(out, force)
        with written(inside(work, MERGED)) as note:
            write(note, json.dumps({"call": call, "bytes": size, "warnings": losses}).encode())
    return size, losses, time.monotonic() - start


def _loaded(work: str, digest: str, capture: str) -> _core.PartPlan:
    return _core.PartPlan.load(_plan_bytes(work, digest), inside(work, PLAN), capture)


#: That of a long capture takes a good part of a second.
_kept = functools.lru_cache(maxsize=1)(_loaded)


@functools.lru_cache(maxsize=1)
def _plan_bytes(work: str, digest: str) -> bytes:
    files, folder = filesystem(work)
    content: bytes = files.cat_file(inside(folder, PLAN))
    if hashlib.sha256(content).hexdigest() != digest:
        raise UsageError(f"{work}: the plan was replaced by another call", file=work)
    return content


def part_of(group: int) -> str:
    return f"group-{group}.fvv"


def report_of(group: int) -> str:
    return f"group-{group}.json"
