"""Who runs tasks: the workers of Dask, or the processes or threads of an executor of concurrent.futures."""

from __future__ import annotations

import concurrent.futures
import contextlib
import os
import socket
import threading
import time
import uuid
from collections.abc import Iterable
from typing import Any, Callable, Protocol

from ..errors import Error, UsageError
from . import tasks
from .tasks import Outcome

#: Seconds that a failed call waits for tasks that are running, as they write into the folder.
LAST_WAIT = 60.0
#: What shows that a worker can run tasks, in words that need no fvv there.
_PROBE = (
    "(__import__('socket').gethostname(), __import__('os').getpid(), "
    "__import__('fvv._core', fromlist=['_core']).library_version, __import__('fsspec').__name__)"
)
_HOST = "__import__('socket').gethostname()"
#: Workers that are asked one by one when not all of them reply.
_MOST_ASKED = 256


class Future(Protocol):
    """What futures of Dask and of concurrent.futures have in common."""

    def add_done_callback(self, fn: Callable[[Any], object], /) -> Any: ...
    def result(self, timeout: Any = None) -> Any: ...
    def done(self) -> bool: ...


class Late(Exception):
    """A call that did not return in time."""


def within(seconds: float, call: Callable[[], Any]) -> Any:
    """What call returns or raises; `Late` when it does not return in time: it goes on in a thread that ends with the process."""
    found: list[Any] = []
    raised: list[Exception] = []

    def work() -> None:
        try:
            found.append(call())
        except Exception as error:
            raised.append(error)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(seconds)
    if raised:
        raise raised[0]
    if not found:
        raise Late
    return found[0]


class Pool:
    """An executor, whose workers cannot be told apart."""

    def __init__(self, executor: concurrent.futures.Executor, timeout: float) -> None:
        self._executor = executor
        self._timeout = timeout

    def probe(self) -> bool:
        """Whether all workers are threads of this process."""
        first = self._executor.submit(tasks.run, tasks.VERSION, tasks.nothing)
        try:
            outcome: Outcome = first.result(timeout=self._timeout)
        except (TimeoutError, concurrent.futures.TimeoutError):
            first.cancel()
            raise Error(f"no worker began a first task within {self._timeout:g} s") from None
        except ModuleNotFoundError as error:
            raise without_fvv(error) from error
        if outcome.error is not None:
            raise tasks.placed(outcome.error, "looking at workers", outcome.place)
        place = outcome.place
        return place is not None and (place.host, place.process) == (socket.gethostname(), os.getpid())

    def submit(self, name: str, call: Callable[..., Any], arguments: tuple[Any, ...], _: set[str]) -> Future:
        return self._executor.submit(call, *arguments)

    def has_others(self, _: set[str]) -> bool:
        return False

    def forget(self, _: Any) -> None:
        """A result has arrived."""

    def check_alive(self) -> None:
        """A pool raises when its processes are lost."""

    def have_forgotten(self, _: float) -> bool:
        """Whether tasks will not run: a pool loses none."""
        return False

    def cancel(self, pending: Iterable[Any]) -> None:
        """Waits for a bounded time for tasks that run, as their worker may be lost, and never for one that is cancelled."""
        running = [task for task in pending if not task.cancel()]
        concurrent.futures.wait(running, timeout=LAST_WAIT)


class Cluster:
    """The workers of a client of Dask."""

    def __init__(self, client: Any, timeout: float) -> None:
        self._client = client
        self._timeout = timeout
        self._call = uuid.uuid4().hex[:12]
        self._count = 0
        self._alone: float | None = None  # since when there is no worker
        self._most = 0  # workers at a time

    def probe(self) -> bool:
        """Whether all workers are in this process. Raises `UsageError` with the names of those that cannot run tasks."""
        if not self._workers():
            # A cluster that adapts starts workers when there is a task.
            first = self._client.submit(eval, _HOST, pure=False)
            with contextlib.suppress(Exception):
                first.result(timeout=self._timeout)
            first.cancel()
            if not self._workers():
                raise Error(f"no worker began a first task within {self._timeout:g} s")
        found = self._ask(_PROBE)
        wrong = []
        for worker, reply in sorted(found.items()):
            if isinstance(reply, Late):
                wrong.append(f"worker {worker}: did not reply within {self._timeout:g} s")
            elif isinstance(reply, Exception):
                wrong.append(f"worker {worker}{self._host_of(worker)}: {_cannot_import(reply)}")
            elif reply[2] != tasks.VERSION:
                wrong.append(f"worker {worker}, host {reply[0]}: has fvv {reply[2]}")
        if wrong:
            raise UsageError(
                f"{'; '.join(wrong)}. This process has fvv {tasks.VERSION}: install the same version on all workers, "
                'as pip install "fvv[dask]" does, or close those without'
            )
        own = (socket.gethostname(), os.getpid())
        return all(tuple(reply[:2]) == own for reply in found.values())

    def submit(
        self, name: str, call: Callable[..., Any], arguments: tuple[Any, ...], avoid: set[str]
    ) -> Future:
        self._count += 1
        key = f"fvv-{self._call}-{self._count}-{name.replace(' ', '-')}"
        where: dict[str, Any] = {}
        if others := self._others(avoid):
            # If these are lost, any other.
            where = {"workers": others, "allow_other_workers": True}
        future: Future = self._client.submit(call, *arguments, key=key, pure=False, **where)
        return future

    def has_others(self, avoid: set[str]) -> bool:
        """Whether there is a worker besides these, or was one that may come back."""
        return bool(self._others(avoid)) or len(avoid) < self._most

    def forget(self, future: Any) -> None:
        """A result has arrived. Dask would repeat the task when the worker that keeps the result dies."""
        future.release()

    def check_alive(self) -> None:
        """Raises `Error` when there has been no worker for too long, or no scheduler."""
        if self._client.status == "closed":
            raise Error("the connection to the scheduler of Dask is closed")
        if self._workers():
            self._alone = None
            return
        now = time.monotonic()
        if self._alone is None:
            self._alone = now
        elif now - self._alone > self._timeout:
            raise Error(f"no worker is left, and none came back within {self._timeout:g} s")

    def have_forgotten(self, seconds: float) -> bool:
        """Whether tasks will not run although there are workers: none has ended for this many seconds, and no worker executes
        anything. Dask loses some that are submitted while their worker dies."""
        if seconds < self._timeout:
            return False
        try:
            found = within(self._timeout, lambda: self._client.run(tasks.executing, on_error="ignore"))
        except Exception:  # it is not known
            return False
        return bool(found) and not any(found.values())

    def cancel(self, pending: Iterable[Any]) -> None:
        """Waits for a bounded time until no worker executes these tasks, as they write into the folder."""
        futures = list(pending)
        if not futures:
            return
        end = time.monotonic() + LAST_WAIT
        with contextlib.suppress(Exception):
            within(LAST_WAIT, lambda: self._client.cancel(futures, force=True))
        keys = {str(future.key) for future in futures}
        while (left := end - time.monotonic()) > 0:
            try:
                found = within(
                    min(left, self._timeout), lambda: self._client.run(tasks.executing, on_error="ignore")
                )
            except Exception:  # it is not known
                return
            if keys.isdisjoint(key for own in found.values() for key in own):
                return
            time.sleep(0.1)

    def _workers(self) -> list[str]:
        """Addresses. Empty, too, when the scheduler does not reply."""
        try:
            found = list(within(self._timeout, self._client.ncores))
        except Exception:
            return []
        self._most = max(self._most, len(found))
        return found

    def _others(self, avoid: set[str]) -> list[str]:
        """Workers besides those, on other hosts where there are some; none where nothing is to be avoided."""
        if not avoid:
            return []
        others = [worker for worker in self._workers() if worker not in avoid]
        hosts = {_address(worker) for worker in avoid}
        return [worker for worker in others if _address(worker) not in hosts] or others

    def _ask(self, words: str) -> dict[str, Any]:
        """The value of an expression on each worker; for those without one, an exception."""

        def ask(**where: Any) -> dict[str, Any]:
            found: dict[str, Any] = self._client.run(eval, words, on_error="return", **where)
            return found

        end = time.monotonic() + self._timeout
        try:
            while True:
                found: dict[str, Any] = within(self._timeout, ask)
                # Those that are just ending are no workers any more.
                there = self._workers()
                found = {worker: reply for worker, reply in found.items() if worker in there}
                lost = [reply for reply in found.values() if isinstance(reply, OSError)]
                if (found and not lost) or time.monotonic() > end:
                    return found
                time.sleep(0.5)
        except Late:
            pass
        # Which of them does not reply?
        found = {}

        def ask_one(worker: str) -> None:
            try:
                found.update(within(self._timeout, lambda: ask(workers=[worker])))
            except Exception as error:
                found[worker] = error

        asked = [
            threading.Thread(target=ask_one, args=(worker,), daemon=True)
            for worker in self._workers()[:_MOST_ASKED]
        ]
        for thread in asked:
            thread.start()
        for thread in asked:
            thread.join()
        return found

    def _host_of(self, worker: str) -> str:
        with contextlib.suppress(Exception):
            name = within(self._timeout, lambda: self._client.run(eval, _HOST, workers=[worker]))[worker]
            return f", host {name}"
        return ""


def _address(worker: str) -> str:
    """Of its host: "tcp://10.0.0.1:1234" is on "tcp://10.0.0.1"."""
    return worker.rpartition(":")[0]


def _cannot_import(error: Exception) -> str:
    missing = getattr(error, "name", None)
    if isinstance(error, ModuleNotFoundError) and missing in ("fvv", "fsspec"):
        return f"has no {missing}"
    return f"cannot load fvv: {error}"


def without_fvv(error: Exception) -> UsageError:
    """For a task that a worker could not read."""
    return UsageError(
        f"a worker has no fvv, or one of another version: {error}; this process has fvv {tasks.VERSION}: install the same "
        "version there"
    )


def workers_of(client: Any, timeout: float) -> Pool | Cluster:
    return Cluster(client, timeout) if hasattr(client, "get_executor") else Pool(client, timeout)
