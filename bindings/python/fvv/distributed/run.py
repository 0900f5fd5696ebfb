"""A call's tasks: which are running, which are tried again and where, and what the caller hears of them."""

from __future__ import annotations

import asyncio
import concurrent.futures
import dataclasses
import queue
import time
import uuid
from typing import Any, Callable

from ..errors import Error, UsageError
from . import tasks
from .tasks import Outcome
from .workers import Cluster, Future, Pool, without_fvv

#: Seconds between two looks at workers and at progress, while tasks are running.
POLL = 1.0
#: Seconds for the result of a task that has ended to arrive, before others are looked at.
RESULT = 10.0
#: Called with frames done and frames in all.
Frames = Callable[[int, int], object]
#: Called with the name of a stage, the part of it that is done, and seconds since it began.
Stage = Callable[[str, float, float], object]


@dataclasses.dataclass
class Task:
    """One piece of work, whatever the number of its tries."""

    name: str
    call: Callable[..., Any]
    arguments: tuple[Any, ...]
    order: int = 0  #: Of tasks that fail together the first one is reported.
    usage_is_final: bool = False  #: A `UsageError` is that of the caller's arguments, wherever they are read.
    tries: int = 0
    failed: set[str] = dataclasses.field(default_factory=set)  #: Addresses of workers.


class Run:
    """The tasks of one call."""

    def __init__(
        self,
        workers: Pool | Cluster,
        capture: str,
        work: str,
        threads: int,
        retries: int,
        progress: Frames | None,
        stage: Stage | None,
    ) -> None:
        self._workers = workers
        self._capture = capture
        self._work = work
        self._threads = threads
        self._retries = retries
        self._progress = progress
        self._on_stage = stage
        self._pending: dict[int, tuple[Task, Future]] = {}
        self._finished: queue.SimpleQueue[int] = queue.SimpleQueue()
        self._count = 0
        self._stage = "plan"
        self._part = 0.0
        self._begin = time.monotonic()
        self._looked = 0.0
        self._ended = time.monotonic()  # a task, last
        #: Names what this call leaves behind.
        self.call = uuid.uuid4().hex
        self.frames: list[int] = []
        self.seconds: list[float] = []
        self.planning = 0.0
        self.digest = ""
        self._encoded = 0  # frames

    def plan(self, cameras: list[str], options: dict[str, str]) -> None:
        self._enter("plan")
        wanted = self._on_stage is not None
        arguments = (self._capture, self._work, cameras, options, wanted)
        self._submit(Task("planning", tasks.plan, arguments, usage_is_final=True))
        self._wait(self._planned)
        self._leave()

    def encode(self) -> None:
        self._enter("encode")
        self.seconds = [0.0] * len(self.frames)
        self._done(0)
        for group in range(1, len(self.frames)):
            arguments = (self._capture, self._work, self.digest, group, self._threads)
            self._submit(Task(f"group {group}", tasks.encode, arguments, order=group))
        self._wait(self._group_done)
        self._leave()

    def merge(self, out: str, force: bool) -> tuple[int, list[str], float]:
        self._enter("merge")
        merged: list[tuple[int, list[str], float]] = []
        arguments = (self._work, self.digest, out, force, self.call, self._on_stage is not None)
        self._submit(Task("merging", tasks.merge, arguments, usage_is_final=True))
        self._wait(lambda _, value: merged.append(value))
        self._leave()
        return merged[0]

    def cancel(self) -> None:
        """Ends what is pending, and waits for a bounded time for what cannot be ended."""
        futures = [future for _, future in self._pending.values()]
        self._pending.clear()
        self._workers.cancel(futures)

    # ---- one task ----

    def _submit(self, task: Task) -> None:
        arguments = (tasks.VERSION, task.call, *task.arguments)
        future = self._workers.submit(task.name, tasks.run, arguments, task.failed)
        self._count += 1
        self._expect(self._count, task, future)

    def _submit_again(self) -> None:
        """Submits all pending tasks, as often as a task that fails."""
        pending = list(self._pending.values())
        self._pending.clear()
        self._workers.cancel([future for _, future in pending])
        for task, _ in pending:
            if task.tries >= self._retries:
                raise Error(
                    f"{task.name}: workers are idle, and none began it, submitted {task.tries + 1} times"
                )
            task.tries += 1
            self._submit(task)
        self._ended = time.monotonic()

    def _expect(self, number: int, task: Task, future: Future) -> None:
        self._pending[number] = (task, future)
        future.add_done_callback(lambda _: self._finished.put(number))

    def _wait(self, done: Callable[[Task, Any], object]) -> None:
        """Until no task is pending. done: called with each task and what it returned. Raises the error of the first one that
        fails for good."""
        while self._pending:
            try:
                numbers = {self._finished.get(timeout=POLL)}
            except queue.Empty:
                self._look()
                continue
            while not self._finished.empty():
                numbers.add(self._finished.get())
            ended = [(number, *self._pending.pop(number)) for number in numbers if number in self._pending]
            self._ended = time.monotonic()
            for number, task, future in sorted(ended, key=lambda one: one[1].order):
                outcome = self._outcome(task, future)
                if outcome is None:
                    self._expect(number, task, future)
                elif outcome.error is None:
                    done(task, outcome.value)
                else:
                    self._failed(task, outcome)
            self._look()

    def _outcome(self, task: Task, future: Future) -> Outcome | None:
        """Also of a task that never reached a worker, or whose worker is lost. None: its result was lost with its worker on the
        way here, and Dask repeats it."""
        try:
            outcome: Outcome = future.result(timeout=RESULT)
            self._workers.forget(future)
            return outcome
        except (TimeoutError, asyncio.TimeoutError, concurrent.futures.TimeoutError) as error:
            return Outcome(None, error=error) if future.done() else None
        except (concurrent.futures.CancelledError, asyncio.CancelledError) as error:
            raise Error(f"{task.name}: was cancelled by another than this call: {error}") from error
        except ModuleNotFoundError as error:
            return Outcome(None, error=without_fvv(error), is_foreign=True)
        except Exception as error:
            return Outcome(None, error=error)

    def _failed(self, task: Task, outcome: Outcome) -> None:
        """Tries a task again on another worker, or raises its error."""
        error, place = outcome.error, outcome.place
        assert error is not None
        if place is not None and place.address is not None:
            task.failed.add(place.address)
        is_final = task.usage_is_final and isinstance(error, UsageError) and not outcome.is_foreign
        # The same worker again may help where storage fails for a while, or a worker was lost.
        helps = isinstance(error, OSError) or _is_lost(error) or self._workers.has_others(task.failed)
        if task.tries < self._retries and helps and not is_final:
            task.tries += 1
            self._submit(task)
            return
        if _is_lost(error):
            raise Error(f"{task.name}: the workers that ran it were killed: {error}") from error
        times = f", tried {task.tries + 1} times" if task.tries else ""
        raise tasks.placed(error, task.name + times, place)

    # ---- what the caller hears ----

    def _planned(self, _: Task, value: tuple[str, list[int], float]) -> None:
        self.digest, self.frames, self.planning = value

    def _group_done(self, task: Task, seconds: float) -> None:
        self.seconds[task.order] = seconds
        self._done(task.order)

    def _done(self, group: int) -> None:
        self._encoded += self.frames[group]
        self._part = self._encoded / sum(self.frames)
        if self._progress is not None:
            self._progress(self._encoded, sum(self.frames))

    def _enter(self, stage: str) -> None:
        self._stage, self._part, self._begin, self._looked = stage, 0.0, time.monotonic(), 0.0
        self._ended = self._begin
        self._tell(stage, 0.0)

    def _leave(self) -> None:
        self._tell(self._stage, 1.0)

    def _tell(self, stage: str, part: float) -> None:
        if self._on_stage is not None:
            self._on_stage(stage, part, time.monotonic() - self._begin)

    def _look(self) -> None:
        """Once a second: are there workers, and how far are they?"""
        now = time.monotonic()
        if now - self._looked < POLL:
            return
        self._looked = now
        self._workers.check_alive()
        if self._pending and self._workers.have_forgotten(now - self._ended):
            self._submit_again()
        if self._on_stage is None:
            return
        if self._stage == "encode":
            self._tell("encode", self._part)
            return
        stage, part = tasks.progress_of(self._work) or (self._stage, 0.0)
        known = stage == self._stage or (stage == "copy" and self._stage == "plan")
        self._tell(*((stage, part) if known else (self._stage, 0.0)))


def _is_lost(error: Exception) -> bool:
    """A worker of Dask died with the task, some times over."""
    return type(error).__name__ == "KilledWorker"
