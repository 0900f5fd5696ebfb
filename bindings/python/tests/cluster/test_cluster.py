"""fvv.distributed and its workers: who cannot run tasks, what errors name, object stores, progress, and seeded orders of
failures and deaths on a cluster of two."""

import concurrent.futures
import contextlib
import os
import re
import shutil
import threading

import cluster_orders
import fsspec
import fvv
import fvv.distributed
import pytest
from conftest import tool
from fsspec.implementations.memory import MemoryFileSystem
from fvv.distributed import storage, tasks, workers

OPTIONS = cluster_orders.OPTIONS


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("capture") / "in"
    tool("fvvsynth", "-o", folder, "--rig", "small", "--cameras", 2, "--size", "96x64", "--frames", 4)
    return folder


@pytest.fixture(scope="module")
def whole(capture):
    """The bytes that one run writes."""
    out = capture.parent / "whole.fvv"
    fvv.mux(capture, out, **OPTIONS)
    return out.read_bytes()


@pytest.fixture(scope="module")
def orders(tmp_path_factory):
    """A cluster of two workers, and what runs orders on it."""
    with cluster_orders.two_workers() as client:
        yield cluster_orders.Orders(client, tmp_path_factory.mktemp("orders"), tool)


# Orders.


@pytest.mark.parametrize("seed", cluster_orders.SHORT)
def test_orders(orders, seed):
    """Some of each end; ./run bench distributed runs 200."""
    orders.run(seed)


@pytest.mark.parametrize("task", ["plan", "merge"])
def test_a_worker_is_killed_while_planning_or_merging(orders, whole, tmp_path, task):
    """Once, so that another worker does it, and the stream is that of one run."""
    orders.wait_for_two()
    client = cluster_orders.Scripted(orders.client, tmp_path, {task: [("kill", 0)]}, {})
    found = cluster_orders.bounded(
        120, lambda: fvv.distributed.mux(orders.capture, tmp_path / "out.fvv", client, **OPTIONS)
    )
    assert isinstance(found, dict), found
    assert (tmp_path / "out.fvv").read_bytes() == orders.whole.read_bytes()
    assert sorted(path.name for path in tmp_path.glob(f"{task}.*")) == [f"{task}.0", f"{task}.1"]
    assert not [name for name in os.listdir(tmp_path) if name.endswith((".parts", ".partial"))]


# Workers that cannot run tasks.


class Probed:
    """A client of Dask of which only the probe is asked."""

    status = "running"

    def __init__(self, replies):
        self.replies = replies

    def get_executor(self):
        raise AssertionError("not used")

    def ncores(self):
        return dict.fromkeys(self.replies, 1)

    def run(self, function, words, workers=None, on_error="raise"):
        if words != workers_probe():
            return dict.fromkeys(workers, "machine7")
        return {one: reply for one, reply in self.replies.items() if workers is None or one in workers}


def workers_probe():
    return workers._PROBE


GOOD = ("here", 7, tasks.VERSION, "fsspec")


@pytest.mark.parametrize(
    "reply, words",
    [
        (
            ModuleNotFoundError("No module named 'fvv'", name="fvv"),
            "tcp://10.0.0.2:4, host machine7: has no fvv",
        ),
        (ModuleNotFoundError("No module named 'fsspec'", name="fsspec"), "host machine7: has no fsspec"),
        (ImportError("libavcodec.so.59: no such file"), "cannot load fvv: libavcodec.so.59: no such file"),
        (("machine9", 7, "9.9.9", "fsspec"), "worker tcp://10.0.0.2:4, host machine9: has fvv 9.9.9"),
    ],
)
def test_workers_without_this_fvv_are_named_before_the_first_task(capture, tmp_path, reply, words):
    client = Probed({"tcp://10.0.0.1:4": GOOD, "tcp://10.0.0.2:4": reply})
    with pytest.raises(fvv.UsageError) as found:
        fvv.distributed.mux(capture, tmp_path / "out.fvv", client, **OPTIONS)
    text = str(found.value)
    assert words in text and "10.0.0.1" not in text
    assert f"This process has fvv {tasks.VERSION}: install the same version on all workers" in text
    assert os.listdir(tmp_path) == []


class Silent(Probed):
    """Of whose workers one never replies."""

    def run(self, function, words, workers=None, on_error="raise"):
        if workers in (None, ["tcp://10.0.0.2:4"]):
            threading.Event().wait(60)
        return super().run(function, words, workers, on_error)


def test_a_worker_that_does_not_reply_is_named(capture, tmp_path):
    client = Silent({"tcp://10.0.0.1:4": GOOD, "tcp://10.0.0.2:4": GOOD})
    with pytest.raises(fvv.UsageError, match="tcp://10.0.0.2:4: did not reply within 0.3 s") as found:
        fvv.distributed.mux(capture, tmp_path / "out.fvv", client, worker_timeout=0.3, **OPTIONS)
    assert "10.0.0.1" not in str(found.value)


class Busy(concurrent.futures.Executor):
    """Begins no task."""

    def submit(self, function, *arguments):
        return concurrent.futures.Future()


def test_a_pool_that_begins_nothing(capture, tmp_path):
    with pytest.raises(fvv.Error, match="no worker began a first task within 0.3 s"):
        fvv.distributed.mux(capture, tmp_path / "out.fvv", Busy(), worker_timeout=0.3, **OPTIONS)


class Emptied(Probed):
    """Loses its workers after the probe; tasks never end."""

    there = True

    def ncores(self):
        return super().ncores() if self.there else {}

    def submit(self, *arguments, **where):
        self.there = False
        future = concurrent.futures.Future()
        future.key = where["key"]
        return future

    def cancel(self, futures, force=False):
        for future in futures:
            future.cancel()


def test_no_worker_is_left(capture, tmp_path):
    client = Emptied({"tcp://10.0.0.1:4": GOOD})
    with pytest.raises(fvv.Error, match="no worker is left, and none came back within 0.5 s"):
        fvv.distributed.mux(capture, tmp_path / "out.fvv", client, worker_timeout=0.5, **OPTIONS)
    assert os.listdir(tmp_path) == []


class Forgetful(Probed):
    """Of whose tasks the first ones are never run, although its worker is idle."""

    def __init__(self, replies, lost):
        super().__init__(replies)
        self.lost = lost
        self.cancelled = 0
        self.keys = []

    def run(self, function, *words, workers=None, on_error="raise"):
        return (
            {one: [] for one in self.replies}
            if function is tasks.executing
            else super().run(function, *words)
        )

    def submit(self, call, *arguments, key, **where):
        self.keys.append(key)
        future = concurrent.futures.Future()
        future.key = key
        future.release = lambda: None
        if len(self.keys) > self.lost:
            future.set_result(call(*arguments))
        return future

    def cancel(self, futures, force=False):
        self.cancelled += len(futures)


def test_tasks_that_dask_forgets_are_submitted_again(capture, whole, tmp_path):
    client = Forgetful({"tcp://10.0.0.1:4": GOOD}, lost=2)
    fvv.distributed.mux(capture, tmp_path / "out.fvv", client, worker_timeout=0.2, **OPTIONS)
    assert (tmp_path / "out.fvv").read_bytes() == whole
    assert client.cancelled == 2 and len(set(client.keys)) == len(client.keys)


def test_tasks_that_are_always_forgotten_end_the_call(capture, tmp_path):
    client = Forgetful({"tcp://10.0.0.1:4": GOOD}, lost=100)
    with pytest.raises(fvv.Error, match="planning: workers are idle, and none began it, submitted 3 times"):
        fvv.distributed.mux(capture, tmp_path / "out.fvv", client, worker_timeout=0.2, **OPTIONS)
    assert os.listdir(tmp_path) == []


# What errors say.


def test_an_error_names_the_process_and_the_path(capture, tmp_path):
    moved = shutil.copytree(capture, tmp_path / "in")
    broken = sorted(moved.rglob("*0002.png"))[0]
    broken.write_bytes(broken.read_bytes()[:100])
    with (
        concurrent.futures.ProcessPoolExecutor(1) as pool,
        pytest.raises(fvv.DamagedError) as found,
    ):
        fvv.distributed.mux(moved, tmp_path / "out.fvv", pool, **OPTIONS)
    text = str(found.value)
    assert str(broken) in text and re.search(r"\(planning; host \S+, process \d+\)$", text), text
    with (
        concurrent.futures.ProcessPoolExecutor(1) as pool,
        pytest.raises(FileNotFoundError, match=r"planning, tried 3 times; host .*nothing"),
    ):
        fvv.distributed.mux(tmp_path / "nothing", tmp_path / "out.fvv", pool, **OPTIONS)


def test_a_task_of_another_version():
    outcome = tasks.run("0.0.1", tasks.nothing)
    assert outcome.is_foreign and isinstance(outcome.error, fvv.UsageError)
    assert str(outcome.error) == (
        f"has fvv {tasks.VERSION}, and the process that began has 0.0.1: install the same version on both"
    )


def test_an_error_that_cannot_be_sent():
    def fail():
        raise Unsendable("here", 3)

    outcome = tasks.run(tasks.VERSION, fail)
    assert type(outcome.error) is RuntimeError and "Unsendable: here" in str(outcome.error)


class Unsendable(Exception):
    def __init__(self, text, number):
        super().__init__(text)


def test_a_plan_of_another_version(capture, tmp_path, monkeypatch):
    work = tmp_path / "work"
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        fvv.distributed.mux(capture, tmp_path / "a.fvv", pool, work=work, **OPTIONS)
        key = work / "plan.json"
        key.write_text(key.read_text().replace(f'"version": "{tasks.VERSION}"', '"version": "0.0.1"'))
        with pytest.raises(
            fvv.UsageError, match=f"has a plan of fvv 0.0.1, and this is {tasks.VERSION}: give another"
        ):
            fvv.distributed.mux(capture, tmp_path / "b.fvv", pool, work=work, **OPTIONS)


# Storage.


class Buckets(MemoryFileSystem):
    """As an object store: buckets exist or do not, and folders are listed from memory once they were listed."""

    protocol = "buckets"
    store: dict = {}
    pseudo_dirs = [""]
    listed: dict = {}
    made: list = []

    @classmethod
    def _strip_protocol(cls, path):
        return super()._strip_protocol(path.replace("buckets://", "memory://")).lstrip("/")

    def invalidate_cache(self, path=None):
        self.listed.clear()

    def ls(self, path, detail=True, **kwargs):
        path = self._strip_protocol(path)
        if path not in self.listed:
            self.listed[path] = [
                {**one, "name": one["name"].lstrip("/")}
                for one in super().ls("/" + path, detail=True, **kwargs)
            ]
        found = self.listed[path]
        return found if detail else [one["name"] for one in found]

    def makedirs(self, path, exist_ok=False):
        self.made.append(path)

    def put_file(self, lpath, rpath, callback=None, **kwargs):
        if os.path.isfile(lpath):
            with open(lpath, "rb") as file:
                self.pipe_file(rpath, file.read())


def threads(count=1):
    return concurrent.futures.ThreadPoolExecutor(count)


@pytest.fixture
def memory():
    files = fsspec.filesystem("memory")
    yield files
    files.rm("/", recursive=True)


@pytest.mark.parametrize("pool", [concurrent.futures.ProcessPoolExecutor, None])
def test_memory_is_refused_where_workers_do_not_reach_it(orders, capture, tmp_path, pool):
    with pool(1) if pool else contextlib.nullcontext(orders.client) as client:
        for change in {"capture": "memory://in"}, {"out": "memory://out.fvv"}, {"work": "memory://work"}:
            given = {"capture": capture, "out": tmp_path / "out.fvv", "work": None, **change}
            with pytest.raises(
                fvv.UsageError, match="is memory of this process, which workers in other processes"
            ):
                fvv.distributed.mux(given["capture"], given["out"], client, work=given["work"], **OPTIONS)
    assert os.listdir(tmp_path) == []


def test_missing_files_are_named_by_their_url(capture, memory):
    with threads() as pool:
        with pytest.raises(FileNotFoundError, match="memory://absent/capture.json"):
            fvv.distributed.mux("memory://absent/capture.json", "memory://out.fvv", pool, **OPTIONS)
        memory.put(str(capture), "/in", recursive=True)
        memory.rm(next(name for name in memory.find("/in") if name.endswith("0002.png")))
        with pytest.raises(
            fvv.DamagedError, match="^memory://in/capture.json: camera 0: 1 of 4 pictures is"
        ) as found:
            fvv.distributed.mux("memory://in", "memory://out.fvv", pool, **OPTIONS)
        assert "/tmp" not in str(found.value)


@pytest.fixture
def buckets(monkeypatch):
    fsspec.register_implementation("buckets", Buckets, clobber=True)
    monkeypatch.setattr(storage, "BUCKETS", {"buckets"})
    files = fsspec.filesystem("buckets")
    yield files
    for held in (files.store, files.listed, files.made):
        held.clear()


def test_parts_are_removed_from_a_bucket_that_was_listed(buckets, capture, whole):
    buckets.put(str(capture), "films/in", recursive=True)
    buckets.made.clear()
    seen = []

    def look(*_):
        # As a caller that watches the bucket: what it lists is kept until it is invalidated.
        seen.append(list(buckets.ls("films", detail=False)))

    with threads() as pool:
        fvv.distributed.mux("buckets://films/in", "buckets://films/out.fvv", pool, progress=look, **OPTIONS)
    assert any(name.endswith(".parts") for names in seen for name in names)
    assert buckets.cat_file("films/out.fvv") == whole
    assert not [name for name in buckets.store if ".parts" in name or "partial" in name]
    assert buckets.made == []


@pytest.mark.parametrize("change", [{"out": "buckets://absent/out.fvv"}, {"work": "buckets://absent/work"}])
def test_a_missing_bucket_is_not_made(buckets, capture, tmp_path, change):
    with (
        threads() as pool,
        pytest.raises(FileNotFoundError, match="there is no bucket absent; make it first"),
    ):
        given = {"out": tmp_path / "out.fvv", "work": None, **change}
        fvv.distributed.mux(capture, given["out"], pool, work=given["work"], **OPTIONS)
    assert buckets.made == [] and not buckets.store


# Progress.


def test_all_stages_are_reported(capture, memory, monkeypatch):
    monkeypatch.setattr(fvv.distributed.run, "POLL", 0.01)
    monkeypatch.setattr(tasks, "INTERVAL", 0.0)
    memory.put(str(capture), "/in", recursive=True)
    heard, copying, report = [], threading.Event(), tasks.Progress.report

    def hear(*now):
        heard.append(now)
        if now[0] == "copy":
            copying.set()

    def report_and_wait(self, stage, part):
        """Copying within memory would be over before the caller looks."""
        report(self, stage, part)
        if stage == "copy":
            copying.wait(10)
            copying.set()

    monkeypatch.setattr(tasks.Progress, "report", report_and_wait)
    with threads() as pool:
        fvv.distributed.mux("memory://in", "memory://out.fvv", pool, stage=hear, **OPTIONS)
    stages = [one[0] for one in heard]
    assert [s for i, s in enumerate(stages) if s not in stages[:i]][0] == "plan"
    assert {"plan", "copy", "encode", "merge"} == set(stages)
    for name in ("plan", "encode", "merge"):
        own = [one for one in heard if one[0] == name]
        assert own[0][1] == 0 and own[-1][1] == 1 and all(0 <= part <= 1 and s >= 0 for _, part, s in own)
