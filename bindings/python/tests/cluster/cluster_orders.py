"""Clusters of two workers on which tasks fail, kill their worker, or meet another version of fvv, in orders drawn by seeds.

Each order is a call of `fvv.distributed.mux` with a script: what happens at the first, second, ... run of each task. It must
return within `BOUND` seconds, with the bytes of a single run where the script lets each task succeed, else with the error of a
task that the script dooms. `python cluster_orders.py COUNT FOLDER [FIRST]` prints the figures as JSON, of seeds from FIRST (0) on.
"""

import contextlib
import json
import os
import pathlib
import random
import shutil
import signal
import sys
import threading
import time
import traceback

import cloudpickle
import dask
import distributed
import fvv
import fvv.distributed
from fvv.distributed import tasks

BOUND = 180.0  # seconds: a worker is restarted four times for a group that kills each of them
GROUPS = 6
OPTIONS = {
    "group": 1,
    "quality": "34dB",
    "keep_geometry": True,
    "texture_inset": "off",
    "match_colours": "off",
}
#: What an error names, by what a task was doomed to.
EXPECTED = {
    "storage": (OSError, "the storage does not answer"),
    "damaged": (fvv.DamagedError, "is damaged"),
    "version": (
        fvv.UsageError,
        f"has fvv {tasks.VERSION}, and the process that began has 0.0.1: install the same",
    ),
    "kill": (fvv.Error, "were killed"),
}
#: Seeds of the default tests: failures, deaths and other versions, with each way to end but that of a group that kills four workers.
SHORT = (1, 3, 9, 23)
FAILURES = ("storage", "damaged", "version")


def script_of(seed):
    """(what happens at each run of each task, by its name; what dooms tasks; retries; whether the plan is there already). After
    the last entry a doomed task goes on with it, any other succeeds."""
    chance = random.Random(seed)
    script, doomed = {}, {}
    kills = 0
    for name in ["plan", *(f"group {i}" for i in range(1, GROUPS)), "merge"]:
        runs = []
        kind = chance.random()
        if kind < 0.1:
            runs = ["storage", "storage"]
        elif kind < 0.3 and (name.startswith("group") or kind < 0.2):
            # A planner's or a merger's own refusal is final at once.
            runs = [chance.choice(FAILURES if name.startswith("group") else ("storage", "version"))]
        if chance.random() < 0.05 and kills < 2:
            runs.insert(chance.randrange(len(runs) + 1), "kill")
            kills += 1
        script[name] = [(run, chance.choice((0, 0, 0.02, 0.2))) for run in runs]
    retries = 2
    if seed % 3 == 0:
        for i in chance.sample(range(1, GROUPS), chance.choice((1, 1, 2, 3))):
            doomed[f"group {i}"] = chance.choice(FAILURES)
    if seed % 40 == 39:
        doomed = {f"group {chance.randrange(1, GROUPS)}": "kill"}
        retries = 0
        script = {}
    for name, kind in doomed.items():
        script[name] = [(kind, chance.choice((0, 0, 0.05)))]
    return script, doomed, retries, seed % 4 != 0


def act(folder, script, doomed, version, task, *arguments):
    """On a worker: the task, or what the script has for this run of it."""
    import time

    import fvv
    from fvv.distributed import tasks

    def fail(kind):
        if kind == "storage":
            raise TimeoutError("the storage does not answer")
        raise fvv.DamagedError(f"{folder}: is damaged", file=folder)

    name = f"group {arguments[3]}" if task is tasks.encode else task.__name__
    runs = script.get(name, [])
    number = 0
    while True:
        try:
            os.close(os.open(os.path.join(folder, f"{name}.{number}"), os.O_CREAT | os.O_EXCL))
            break
        except FileExistsError:
            number += 1
    if number < len(runs) or name in doomed:
        kind, delay = runs[min(number, len(runs) - 1)]
        time.sleep(delay)
        if kind == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        if kind == "version":
            version = "0.0.1"
        else:
            return tasks.run(version, fail, kind)
    return tasks.run(version, task, *arguments)


class Scripted:
    """A client whose tasks follow a script."""

    def __init__(self, client, folder, script, doomed):
        self._client = client
        self._given = (str(folder), script, doomed)

    def __getattr__(self, name):
        return getattr(self._client, name)

    def submit(self, call, *arguments, **where):
        if call is not tasks.run:
            return self._client.submit(call, *arguments, **where)
        return self._client.submit(act, *self._given, *arguments, **where)


@contextlib.contextmanager
def two_workers():
    """Processes that a nanny starts again when they die. The tasks of this module travel by value."""
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    with dask.config.set({"distributed.scheduler.allowed-failures": 3}):
        cluster = distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
        )
        try:
            with distributed.Client(cluster) as client:
                yield client
        finally:
            # Dask looks for a worker that has just gone while it closes, and says so by KeyError; the orders are done then.
            with contextlib.suppress(KeyError):
                cluster.close()


class Hang(Exception):
    """A call that did not return within the bound."""


def bounded(seconds, call):
    """What call returns, or the exception that it raises."""
    found = []

    def run():
        try:
            found.append(call())
        except Exception as error:
            found.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(seconds)
    if not found:
        frame = sys._current_frames().get(thread.ident)
        raise Hang("".join(traceback.format_stack(frame)) if frame else "no frame")
    return found[0]


class Gone(Exception):
    """Dask has not started workers again that were killed."""


class Orders:
    """Runs orders on one cluster, and checks how each ends."""

    def __init__(self, client, folder, tool):
        self.client = client
        self.folder = pathlib.Path(folder)
        self.capture = self.folder / "capture"
        self.whole = self.folder / "whole.fvv"
        # A plan that most orders begin with.
        self.planned = self.folder / "planned"
        if self.planned.exists():
            return
        small = ("--rig", "small", "--cameras", 2, "--size", "96x64", "--frames", GROUPS)
        tool("fvvsynth", "-o", self.capture, *small)
        fvv.mux(self.capture, self.whole, **OPTIONS)
        fvv.distributed.mux(self.capture, self.folder / "first.fvv", client, work=self.planned, **OPTIONS)
        for path in self.planned.iterdir():
            if path.name not in ("plan.cbor", "plan.json", "group-0.fvv", "group-0.json"):
                path.unlink()

    def wait_for_two(self):
        """Workers that were killed are started again; without this a script's task may have no other worker."""
        try:
            self.client.wait_for_workers(2, timeout=60)
        except TimeoutError as error:
            raise Gone from error

    def run(self, seed):
        """ "identical" or the kind of the error. Raises AssertionError for another end, and `Hang`."""
        self.wait_for_two()
        script, doomed, retries, is_planned = script_of(seed)
        place = self.folder / str(seed)
        counts = place / "runs"
        counts.mkdir(parents=True)
        out = place / "out.fvv"
        work = None
        if is_planned:
            work = place / "work"
            shutil.copytree(self.planned, work)
        client = Scripted(self.client, counts, script, doomed)
        found = bounded(
            BOUND,
            lambda: fvv.distributed.mux(
                self.capture, out, client, work=work, retries=retries, worker_timeout=30, **OPTIONS
            ),
        )
        left = sorted(path.name for path in place.iterdir())
        kept = ["runs"] + (["work"] if is_planned else [])
        if not doomed:
            assert isinstance(found, dict), f"seed {seed}: {script}: {found!r}"
            assert out.read_bytes() == self.whole.read_bytes(), f"seed {seed}: other bytes"
            assert left == ["out.fvv", *kept], f"seed {seed}: {left}"
            end = "identical"
        elif isinstance(found, fvv.Error) and "no worker is left" in str(found):
            # Where a group kills each worker and Dask takes too long to start others.
            assert doomed and not self.client.ncores(), f"seed {seed}: {found!r}"
            end = "lost"
        else:
            assert isinstance(found, Exception), f"seed {seed}: {script}: {found!r}"
            assert left == kept, f"seed {seed}: {left}"
            end = self.kind_of(seed, found, doomed)
        removed(place)
        return end

    @staticmethod
    def kind_of(seed, error, doomed):
        text = str(error)
        for name, kind in doomed.items():
            expected, words = EXPECTED[kind]
            # Others that a killed worker had been given count as killed, too.
            if isinstance(error, expected) and words in text and (f"{name}" in text or kind == "kill"):
                assert kind == "kill" or ("worker tcp://" in text and "host " in text), f"seed {seed}: {text}"
                return kind
        raise AssertionError(f"seed {seed}: {doomed}: {error!r}")


def removed(folder):
    """A worker may still write a last file of a group whose run has ended."""
    for left in reversed(range(10)):
        shutil.rmtree(folder, ignore_errors=left > 0)
        if not folder.exists():
            return
        time.sleep(0.5)


def figures(count, folder, tool, progress=lambda seed, end, seconds: None, first=0):
    """dask.orders, dask.hangs, and how the orders ended; and what was wrong, as text. first: seed of the first order."""
    ends = {"identical": 0, "storage": 0, "damaged": 0, "version": 0, "kill": 0, "lost": 0, "wrong": 0}
    hangs, slowest, wrong, seed = 0, 0.0, [], first
    count += first
    while seed < count and not hangs:
        with two_workers() as client:
            orders = Orders(client, folder, tool)
            while seed < count:
                begin = time.monotonic()
                try:
                    end = orders.run(seed)
                except Gone:
                    break  # and begin with another cluster
                except AssertionError as error:
                    end = "wrong"
                    wrong.append(str(error))
                except Hang as error:
                    hangs += 1
                    wrong.append(f"seed {seed}: hangs: {error}")
                    break
                ends[end] += 1
                slowest = max(slowest, time.monotonic() - begin)
                progress(seed, end, time.monotonic() - begin)
                seed += 1
    out = {
        "dask.orders": sum(ends.values()) + hangs,
        "dask.hangs": hangs,
        "dask.orders_slowest_seconds": slowest,
    }
    return {**out, **{f"dask.orders_{end}": number for end, number in ends.items()}}, wrong


if __name__ == "__main__":
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
    from conftest import tool

    result, problems = figures(
        int(sys.argv[1]),
        sys.argv[2],
        tool,
        lambda *done: print("order", *done, file=sys.stderr, flush=True),
        int(sys.argv[3]) if len(sys.argv) > 3 else 0,
    )
    for problem in problems:
        print(problem, file=sys.stderr)
    print(json.dumps(result))
