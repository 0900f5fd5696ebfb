"""One stream from many processes and machines, with the bytes of a single run (docs/encoding/parts.md)."""

from __future__ import annotations

import concurrent.futures
import contextlib
import functools
import hashlib
import importlib
import json
import os
import tempfile
import time
import uuid
import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, Callable

from . import _core
from .errors import LossWarning, UsageError
from .options import camera_names, option_texts

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ._options import PlanOptions

_PLAN = "plan.cbor"
_KEY = "plan.json"
#: Seconds that a failed call waits for groups that are being encoded, as they write into the folder.
_LAST_WAIT = 60.0


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
    progress: Callable[[int, int], object] | None = None,
    **options: Unpack[PlanOptions],
) -> dict[str, Any]:
    """Packs a capture into a stream as `fvv.mux` does, with the same bytes, each group of frames as a task of its own.

    client: a `dask.distributed.Client`, or a `concurrent.futures.Executor`, whose tasks may be in other processes.
    capture, out, work: paths or URLs of fsspec ("s3://bucket/capture") that all workers reach. Where capture is not a
    local path, each task copies the files that it reads to a temporary folder: planning the whole capture, a group its own.
    work: a folder for the plan and the parts. It stays, and a later call with the same arguments continues with the
    groups that are missing. None: a folder beside out, which is removed at the end.
    cameras, options: as `fvv.mux` has them, without verify and segments. force: replaces an existing file.
    threads: of a task; planning takes all of its machine. retries: how often a group is tried again after an OSError; Dask
    repeats the groups of workers that die by itself.
    progress: called with frames done and frames in all, by the calling thread.

    Returns "frames", "groups", "bytes", "warnings", and "seconds": of "plan", of "encode" (a list, of each group; 0 of those
    that were there) and of "merge", as the workers measured them. What cannot be kept is a `LossWarning`. Raises
    `UsageError`, `DamagedError` for files of the capture that cannot be used, `OSError`, and what the client
    raises when its workers are lost; no file out is left then.
    """
    source, target = _url(capture), _url(out)
    if "verify" in options or "segments" in options:
        raise UsageError(
            "verify and segments: are options of fvv.mux; write the stream first, and read it then"
        )
    texts = option_texts(options)
    _refuse_existing(target, force)
    _refuse_input(target, source)
    folder = f"{target}.{uuid.uuid4().hex}.parts" if work is None else _url(work)
    executor = client.get_executor(pure=False) if hasattr(client, "get_executor") else client
    run = _Run(executor, source, folder, threads, retries, progress)
    try:
        run.plan(camera_names(cameras), texts)
        run.encode()
        size, losses, merging = executor.submit(_merge, folder, run.digest, target, force).result()
    finally:
        run.cancel()
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


class _Run:
    """The tasks of one call."""

    def __init__(
        self,
        executor: concurrent.futures.Executor,
        capture: str,
        work: str,
        threads: int,
        retries: int,
        progress: Callable[[int, int], object] | None,
    ) -> None:
        self._executor = executor
        self._capture = capture
        self._work = work
        self._threads = threads
        self._retries = retries
        self._progress = progress
        self._pending: dict[concurrent.futures.Future[float], tuple[int, int]] = {}
        self.frames: list[int] = []
        self.seconds: list[float] = []
        self.planning = 0.0
        self.digest = ""
        self._encoded = 0  # frames

    def plan(self, cameras: list[str], options: dict[str, str]) -> None:
        task = self._executor.submit(_plan, self._capture, self._work, cameras, options)
        self.digest, self.frames, self.planning = task.result()

    def encode(self) -> None:
        self.seconds = [0.0] * len(self.frames)
        self._done(0)
        for group in range(1, len(self.frames)):
            self._submit(group, 0)
        while self._pending:
            finished, _ = concurrent.futures.wait(
                self._pending, return_when=concurrent.futures.FIRST_COMPLETED
            )
            # In order, so that of groups that fail together the first one is reported.
            for task in sorted(finished, key=self._pending.__getitem__):
                group, tries = self._pending.pop(task)
                try:
                    self.seconds[group] = task.result()
                except OSError:
                    if tries == self._retries:
                        raise
                    self._submit(group, tries + 1)
                else:
                    self._done(group)

    def cancel(self) -> None:
        """Waits for tasks that cannot be cancelled, as they write into the folder; for a while, as their worker may be lost.

        `concurrent.futures.wait` never returns for a task that is cancelled unless its executor has noticed, which Dask's does not.
        """
        running = [task for task in self._pending if not task.cancel()]
        concurrent.futures.wait(running, timeout=_LAST_WAIT)

    def _submit(self, group: int, tries: int) -> None:
        task = self._executor.submit(_encode, self._capture, self._work, self.digest, group, self._threads)
        self._pending[task] = (group, tries)

    def _done(self, group: int) -> None:
        self._encoded += self.frames[group]
        if self._progress is not None:
            self._progress(self._encoded, sum(self.frames))


# ---- tasks, on the workers -----------------------------------------------------------------------------------


def _plan(
    capture: str, work: str, cameras: list[str], options: dict[str, str]
) -> tuple[str, list[int], float]:
    """Makes plan and first group, unless they are there. Returns the digest of the plan, the frames of each group and
    the seconds that it took."""
    start = time.monotonic()
    files, folder = _filesystem(work)
    with _Capture(capture) as found:
        key = hashlib.sha256(found.description())
        key.update(json.dumps([_core.library_version, cameras, sorted(options.items())]).encode())
        if files.exists(_inside(folder, _KEY)):
            known = json.loads(files.cat_file(_inside(folder, _KEY)))
            if known["key"] != key.hexdigest():
                raise UsageError(f"{work}: has the plan of another capture or with other options", file=work)
            return known["plan"], known["frames"], 0.0
        found.fetch(lambda: _core.files_of(found.path))
        files.makedirs(folder, exist_ok=True)
        with _written(_inside(work, _part(0))) as path, _written(_inside(work, _report(0))) as report:
            plan = _core.PartPlan.make(found.path, cameras, options, path)
            _write(report, plan.first_report.encode())
    content = plan.data
    frames = [plan.frames_of(group) for group in range(plan.group_count)]
    with _written(_inside(work, _PLAN)) as path:
        _write(path, content)
    digest = hashlib.sha256(content).hexdigest()
    with _written(_inside(work, _KEY)) as path:
        _write(path, json.dumps({"key": key.hexdigest(), "plan": digest, "frames": frames}).encode())
    return digest, frames, time.monotonic() - start


def _encode(capture: str, work: str, digest: str, group: int, threads: int) -> float:
    """Encodes a group, unless it is there: a stream is named last, so one that has its name is whole. Returns the seconds
    that it took."""
    start = time.monotonic()
    files, folder = _filesystem(work)
    if files.exists(_inside(folder, _part(group))):
        return 0.0
    with _Capture(capture) as found:
        plan = (_loaded if found.is_copied else _kept)(work, digest, found.path)
        found.fetch(lambda: plan.files_of(group))
        with _written(_inside(work, _part(group))) as path, _written(_inside(work, _report(group))) as report:
            _write(report, plan.encode(group, threads, path).encode())
    return time.monotonic() - start


def _merge(work: str, digest: str, out: str, force: bool) -> tuple[int, list[str], float]:
    """Returns the bytes of the stream, all warnings, and the seconds that it took."""
    start = time.monotonic()
    files, folder = _filesystem(work)
    plan = _loaded(work, digest, "")
    names = {os.path.basename(name) for name in files.ls(folder, detail=False)}
    plan.check_complete(work, [_part(group) in names for group in range(plan.group_count)])
    with tempfile.TemporaryDirectory() as copies, _written(out) as path:

        def open_part(group: int) -> tuple[str, str]:
            part = _inside(folder, _part(group))
            if not _is_local(files):
                files.get_file(part, os.path.join(copies, "part.fvv"))
                part = os.path.join(copies, "part.fvv")
            return part, files.cat_file(_inside(folder, _report(group))).decode()

        size, losses = plan.merge(open_part, path)
        _refuse_existing(out, force)
    return size, losses, time.monotonic() - start


def _loaded(work: str, digest: str, capture: str) -> _core.PartPlan:
    return _core.PartPlan.load(_plan_bytes(work, digest), _inside(work, _PLAN), capture)


#: That of a long capture takes a good part of a second.
_kept = functools.lru_cache(maxsize=1)(_loaded)


@functools.lru_cache(maxsize=1)
def _plan_bytes(work: str, digest: str) -> bytes:
    files, folder = _filesystem(work)
    content: bytes = files.cat_file(_inside(folder, _PLAN))
    if hashlib.sha256(content).hexdigest() != digest:
        raise UsageError(f"{work}: the plan was replaced by another call", file=work)
    return content


# ---- storage -------------------------------------------------------------------------------------------------


class _Capture:
    """A capture as local files: itself, or a folder with copies, which is removed at the end."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._files, root = _filesystem(url)
        if self._files.isdir(root):
            root = _inside(root, "capture.json")
        self._root = os.path.dirname(root)
        self._copies: tempfile.TemporaryDirectory[str] | None = None
        #: Of capture.json.
        self.path = root
        if not _is_local(self._files):
            self._copies = tempfile.TemporaryDirectory()
            self.path = os.path.join(self._copies.name, os.path.basename(root))
            try:
                self._files.get_file(root, self.path)
            except BaseException:
                self._copies.cleanup()
                raise

    @property
    def is_copied(self) -> bool:
        return self._copies is not None

    def description(self) -> bytes:
        """The bytes of capture.json."""
        with open(self.path, "rb") as file:
            return file.read()

    def fetch(self, names: Callable[[], Sequence[str]]) -> None:
        """Copies files. names: the paths that are needed, beside `path`; those of files that copied files name are found in
        a second pass. What is missing is left to the one who reads it."""
        for _ in range(0 if self._copies is None else 2):
            for name in names():
                relative = os.path.relpath(name, os.path.dirname(self.path))
                if relative.startswith(os.pardir):
                    raise UsageError(
                        f"{self._url}: names {relative}: of a capture that is copied to the workers, all files are in the "
                        "folder of capture.json",
                        file=self._url,
                    )
                if os.path.exists(name):
                    continue
                os.makedirs(os.path.dirname(name), exist_ok=True)
                with contextlib.suppress(FileNotFoundError):
                    self._files.get_file(_inside(self._root, relative), name)

    def __enter__(self) -> _Capture:
        return self

    def __exit__(self, *_: object) -> None:
        if self._copies is not None:
            self._copies.cleanup()


def _filesystem(url: str) -> tuple[Any, str]:
    """The storage, and the path there."""
    try:
        fsspec = importlib.import_module("fsspec")
    except ImportError:
        raise ImportError("fvv.distributed needs fsspec: pip install fvv[dask]") from None
    files, path = fsspec.core.url_to_fs(url)
    return files, path


def _is_local(files: Any) -> bool:
    return "file" in (files.protocol if isinstance(files.protocol, tuple) else (files.protocol,))


def _url(path: str | os.PathLike[str]) -> str:
    """The same for workers with another current folder."""
    text = os.fspath(path)
    return text.rstrip("/") if "://" in text or "::" in text else os.path.abspath(text)


def _inside(folder: str, name: str) -> str:
    return f"{folder}/{name}"


def _part(group: int) -> str:
    return f"group-{group}.fvv"


def _report(group: int) -> str:
    return f"group-{group}.json"


def _write(path: str, content: bytes) -> None:
    with open(path, "wb") as file:
        file.write(content)


def _refuse_existing(url: str, force: bool) -> None:
    files, path = _filesystem(url)
    if files.isdir(path):
        raise UsageError(f"{url}: is a folder, expected the name of a file", file=url)
    if not force and files.exists(path):
        raise UsageError(f"{url}: already exists; force=True replaces it", file=url)


def _refuse_input(url: str, capture: str) -> None:
    (files, path), (of_capture, root) = _filesystem(url), _filesystem(capture)
    # A path of this machine may be another one on the workers.
    if not (_is_local(files) and _is_local(of_capture) and os.path.exists(path) and os.path.exists(root)):
        return
    with _Capture(capture) as found:
        for name in _core.files_of(found.path):
            if os.path.exists(name) and os.path.samefile(name, path):
                raise UsageError(f"{url}: is read by this call, and cannot be replaced", file=url)


def _remove(folder: str) -> None:
    files, path = _filesystem(folder)
    if files.exists(path):
        files.rm(path, recursive=True)


@contextlib.contextmanager
def _written(url: str) -> Iterator[str]:
    """A local path to write. The file appears under url when it is whole, and replaces what is there."""
    files, path = _filesystem(url)
    folder, name = os.path.split(path)
    partial = _inside(folder, f".{name}.{uuid.uuid4().hex}.partial")
    if _is_local(files):
        try:
            yield partial
            with open(partial, "rb") as file:
                os.fsync(file.fileno())
            os.replace(partial, path)
        finally:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(partial)
        return
    with tempfile.TemporaryDirectory() as local:
        yield os.path.join(local, name)
        try:
            files.put_file(os.path.join(local, name), partial)
            files.mv(partial, path)
        except BaseException:
            with contextlib.suppress(Exception):
                files.rm(partial)
            raise
