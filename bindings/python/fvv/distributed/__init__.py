"""One stream from many processes and machines, with the bytes of a single run (docs/encoding/parts.md)."""

from __future__ import annotations

import errno
import os
import time
import uuid
import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ..errors import LossWarning, UsageError
from ..options import camera_names, option_texts
from . import storage
from .run import Frames, Run, Stage
from .workers import workers_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .._options import PlanOptions

__all__ = ["mux"]

_LAST_FILE = 10.0  # seconds that a worker may take to write one


def mux(
    capture: str | os.PathLike[str],
    out: str | os.PathLike[str],
    client: Any,
    *,
    work: str | os.PathLike[str] | None = None,
    cameras: str | Iterable[int | str] | None = None,
    force: bool = False,
    threads: int = 1,
    retries: int = 2,
    worker_timeout: float = 60.0,
    progress: Frames | None = None,
    stage: Stage | None = None,
    **options: Unpack[PlanOptions],
) -> dict[str, Any]:
    """Packs a capture into a stream as `fvv.mux` does, with the same bytes, each group of frames as a task of its own.

    client: a `dask.distributed.Client`, or a `concurrent.futures.Executor`, whose tasks may be in other processes.
    capture, out, work: paths or URLs of fsspec ("s3://bucket/capture") that all workers reach. Where capture is not a
    local path, each task copies the files that it reads to a temporary folder: planning the whole capture, a group its own.
    work: a folder for the plan and the parts. It stays, and a later call with the same arguments continues with the
    groups that are missing. None: a folder beside out, which is removed at the end.
    cameras, options: as `fvv.mux` has them, without verify and segments. force: replaces an existing file.
    threads: of a task; planning takes all of its machine.
    retries: how often a task that failed is tried again: on another worker of Dask, one of another host if there is one; on
    the same one, or by another executor, after an `OSError` and when the worker was lost.
    worker_timeout: seconds for all workers to reply before the first task, and for one to come back when none is left.
    progress: called with frames done and frames in all, by the calling thread.
    stage: called about once a second, by the calling thread, with "copy", "plan", "encode" or "merge", the part of it that is
    done (0 to 1; of "plan" only 0 and 1 are known) and its seconds.

    Returns "frames", "groups", "bytes", "warnings", and "seconds": of "plan", of "encode" (a list, of each group; 0 of those
    that were there) and of "merge", as the workers measured them. What cannot be kept is a `LossWarning`. Raises
    `UsageError`, also for workers without this version of fvv, `DamagedError` for files of the capture that cannot be used,
    `OSError`, and `Error` when workers are lost: that of the first task that failed, with its name, worker and host. No file
    out is left then.
    """
    source, target = storage.absolute(capture), storage.absolute(out)
    if "verify" in options or "segments" in options:
        raise UsageError(
            "verify and segments: are options of fvv.mux; write the stream first, and read it then"
        )
    texts = option_texts(options)
    folder = f"{target}.{uuid.uuid4().hex}.parts" if work is None else storage.absolute(work)
    for url in (target, folder):
        storage.require_bucket(url)
    storage.refuse_existing(target, force)
    storage.refuse_input(target, source)
    workers = workers_of(client, worker_timeout)
    if not workers.probe():
        _refuse_memory(source, target, folder)
    run = Run(workers, source, folder, threads, retries, progress, stage)
    try:
        run.plan(camera_names(cameras), texts)
        run.encode()
        size, losses, merging = run.merge(target, force)
    finally:
        run.cancel()
        storage.remove_partials(target, run.call)
        if work is None:
            _remove(folder)
    for text in losses:
        warnings.warn(text, LossWarning, stacklevel=2)
    return {
        "frames": sum(run.frames),
        "groups": len(run.frames),
        "bytes": size,
        "warnings": losses,
        "seconds": {"plan": run.planning, "encode": run.seconds, "merge": merging},
    }


def _refuse_memory(*urls: str) -> None:
    for url in urls:
        files, _ = storage.filesystem(url)
        if "memory" in storage.protocols(files):
            raise UsageError(
                f"{url}: is memory of this process, which workers in other processes do not reach; give a folder or a URL "
                "that they reach, or an executor of threads",
                file=url,
            )


def _remove(folder: str) -> None:
    """A failure to do so hides no other. A worker may still write the last file of a group that is not wanted any more."""
    give_up = time.monotonic() + _LAST_FILE
    while True:
        try:
            return storage.remove(folder)
        except Exception as error:
            if getattr(error, "errno", None) != errno.ENOTEMPTY or time.monotonic() > give_up:
                warnings.warn(f"{folder}: cannot be removed: {error}", RuntimeWarning, stacklevel=3)
                return
        time.sleep(0.2)
