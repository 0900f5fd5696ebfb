"""fvv.distributed: the bytes of one run, from processes, a cluster, and storage that is not local; workers die and
tasks fail on the way."""

import concurrent.futures
import contextlib
import errno
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings

import distributed
import fsspec
import fvv
import fvv.distributed
import pytest
from conftest import tool
from fvv.distributed import storage, tasks, workers

OPTIONS = {"group": 2, "quality": "38dB", "repeat_configuration": True}


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("capture") / "in"
    tool("fvvsynth", "-o", folder, "--rig", "small", "--cameras", 3, "--size", "160x96", "--frames", 9,
         "--sound")  # fmt: skip
    return folder


@pytest.fixture(scope="module")
def whole(capture):
    """The bytes that one run writes."""
    out = capture.parent / "whole.fvv"
    fvv.mux(capture, out, **OPTIONS)
    return out.read_bytes()


@contextlib.contextmanager
def cluster(workers):
    with (
        distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
        ) as local,
        distributed.Client(local) as client,
    ):
        yield client


def test_one_worker_of_a_cluster(capture, whole, tmp_path):
    done = []
    with cluster(1) as client:
        found = fvv.distributed.mux(
            capture, tmp_path / "out.fvv", client, progress=lambda *now: done.append(now), **OPTIONS
        )
    assert (tmp_path / "out.fvv").read_bytes() == whole
    assert os.listdir(tmp_path) == ["out.fvv"]
    assert (found["frames"], found["groups"], found["bytes"]) == (9, 5, len(whole))
    assert found["warnings"] == [] and len(found["seconds"]["encode"]) == 5
    assert done[0] == (2, 9) and done[-1] == (9, 9) and done == sorted(done)


def test_a_worker_of_two_is_killed_in_the_middle(capture, whole, tmp_path):
    """Kills the one that encodes when two groups are done; its group is encoded again."""
    with cluster(2) as client:
        before = client.run(os.getpid)

        def kill(done, _):
            if done >= 4 and len(killed) == 0:
                busy = [name for name, keys in client.processing().items() if keys]
                killed.append(before[busy[0]])
                os.kill(killed[0], signal.SIGKILL)

        killed = []
        fvv.distributed.mux(
            capture, tmp_path / "out.fvv", client, work=tmp_path / "parts", progress=kill, **OPTIONS
        )
        client.wait_for_workers(2, timeout=60)
        after = set(client.run(os.getpid).values())
    assert len(killed) == 1 and killed[0] not in after and len(after & set(before.values())) == 1
    assert (tmp_path / "out.fvv").read_bytes() == whole


def test_processes_without_a_cluster(capture, whole, tmp_path):
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        fvv.distributed.mux(capture, tmp_path / "out.fvv", pool, **OPTIONS)
    assert (tmp_path / "out.fvv").read_bytes() == whole


@pytest.fixture
def memory():
    """fsspec's storage in memory, emptied afterwards. One thread may use it: readers of a file share their position."""
    files = fsspec.filesystem("memory")
    yield files
    files.rm("/", recursive=True)


def threads(count=2):
    return concurrent.futures.ThreadPoolExecutor(count)


def test_storage_that_is_not_local(capture, whole, memory, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    memory.put(str(capture), "/in", recursive=True)
    with threads(1) as pool:
        fvv.distributed.mux("memory://in", "memory://out/clip.fvv", pool, work="memory://work", **OPTIONS)
    assert memory.cat_file("/out/clip.fvv") == whole
    assert memory.ls("/out", detail=False) == ["/out/clip.fvv"]
    assert not [name for name in memory.ls("/work", detail=False) if "partial" in name]
    assert os.listdir(tmp_path) == []


def test_a_group_reads_its_own_files(capture, memory):
    """From remote storage a task takes what its frames need."""
    memory.put(str(capture), "/in", recursive=True)
    with threads(1) as pool:
        fvv.distributed.mux("memory://in", "memory://a.fvv", pool, work="memory://work", **OPTIONS)
        first = memory.cat_file("/work/group-1.fvv")
        for name in memory.find("/in"):
            number = os.path.splitext(name)[0][-4:]
            if number.isdigit() and int(number) not in (2, 3):
                memory.rm(name)
        memory.rm("/work/group-1.fvv")
        memory.rm("/a.fvv")
        fvv.distributed.mux("memory://in", "memory://a.fvv", pool, work="memory://work", **OPTIONS)
    assert memory.cat_file("/work/group-1.fvv") == first


def test_work_is_continued(capture, tmp_path):
    """By another call, after the first one failed in the middle."""
    # Where a quality is found, pictures of groups over the whole take are read first.
    options = {name: value for name, value in OPTIONS.items() if name != "quality"} | {"bitrate": "400k"}
    fvv.mux(capture, tmp_path / "whole.fvv", **options)
    whole = (tmp_path / "whole.fvv").read_bytes()
    moved = shutil.copytree(capture, tmp_path / "in")
    broken = sorted(moved.rglob("*0007.png"))[0]
    good = broken.read_bytes()
    out, work = tmp_path / "out.fvv", tmp_path / "parts"
    broken.write_bytes(good[:100])
    with threads() as pool, pytest.raises(fvv.DamagedError, match=broken.name):
        fvv.distributed.mux(moved, out, pool, work=work, **options)
    assert not out.exists() and not (work / "group-3.fvv").exists()
    times = {path.name: path.stat().st_mtime_ns for path in work.iterdir()}
    assert {"group-0.fvv", "group-1.fvv", "group-2.fvv"} <= times.keys()
    broken.write_bytes(good)
    with threads() as pool:
        found = fvv.distributed.mux(moved, out, pool, work=work, **options)
        assert out.read_bytes() == whole
        assert found["seconds"]["plan"] == 0 and found["seconds"]["encode"][1] == 0
        assert {name: (work / name).stat().st_mtime_ns for name in times} == times
        with pytest.raises(fvv.UsageError, match="already exists"):
            fvv.distributed.mux(moved, out, pool, work=work, **options)
        fvv.distributed.mux(moved, out, pool, work=work, force=True, **options)
        with pytest.raises(fvv.UsageError, match="plan of another capture or with other options"):
            fvv.distributed.mux(moved, tmp_path / "b.fvv", pool, work=work, **{**options, "group": 3})


class Flaky(concurrent.futures.ThreadPoolExecutor):
    """The first tasks that encode a group fail as storage does."""

    def __init__(self, failures):
        super().__init__(2)
        self.failures = failures

    def submit(self, function, *arguments):
        if arguments[1] is tasks.encode and self.failures:
            self.failures -= 1
            return super().submit(self._fail)
        return super().submit(function, *arguments)

    @staticmethod
    def _fail():
        raise TimeoutError("the storage does not answer")


def test_failing_storage_is_tried_again(capture, whole, tmp_path):
    with Flaky(6) as pool:
        fvv.distributed.mux(capture, tmp_path / "out.fvv", pool, **OPTIONS)
    assert (tmp_path / "out.fvv").read_bytes() == whole
    with Flaky(100) as pool, pytest.raises(TimeoutError):
        fvv.distributed.mux(capture, tmp_path / "b.fvv", pool, **OPTIONS)
    assert os.listdir(tmp_path) == ["out.fvv"]


class Unnoticed(concurrent.futures.Executor):
    """As Dask's: a future that is cancelled stays so, and a wait for it never ends. Groups fail, or never end."""

    def __init__(self, failing, running=()):
        self.failing, self.running = failing, running

    def submit(self, function, *arguments):
        future = concurrent.futures.Future()
        if arguments[1] is not tasks.encode:
            future.set_running_or_notify_cancel()
            future.set_result(function(*arguments))
        elif (group := arguments[5]) in self.failing:
            future.set_exception(fvv.DamagedError(f"group {group}"))
        elif group in self.running:
            future.set_running_or_notify_cancel()
        return future


def ends(seconds, call):
    """What call raises; the test fails when it does not return."""
    raised = []

    def run():
        try:
            call()
        except Exception as error:
            raised.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(seconds)
    assert not thread.is_alive(), "the call does not return"
    return raised[0]


@pytest.mark.parametrize("failing, running", [((1,), ()), ((3, 2), ()), ((4, 2, 3), (1,))])
def test_a_failure_ends_the_call_whatever_the_other_groups_do(
    capture, tmp_path, monkeypatch, failing, running
):
    """It never waits for a cancelled group, and waits for a bounded time for one that runs; the error is that of the first group that failed."""
    monkeypatch.setattr(workers, "LAST_WAIT", 0.5)
    pool = Unnoticed(failing, running)
    error = ends(60, lambda: fvv.distributed.mux(capture, tmp_path / "out.fvv", pool, **OPTIONS))
    assert (
        isinstance(error, fvv.DamagedError) and str(error) == f"group {min(failing)} (group {min(failing)})"
    )
    assert os.listdir(tmp_path) == []


def test_groups_that_fail_together_on_a_cluster(capture, tmp_path):
    moved = shutil.copytree(capture, tmp_path / "in")
    for frame in range(2, 9):
        broken = sorted(moved.rglob(f"*{frame:04}.png"))[0]
        broken.write_bytes(broken.read_bytes()[:100])
    with cluster(2) as client:
        error = ends(120, lambda: fvv.distributed.mux(moved, tmp_path / "out.fvv", client, **OPTIONS))
    assert isinstance(error, fvv.DamagedError), error
    assert os.listdir(tmp_path) == ["in"]


def test_warnings_are_those_of_one_run(capture, tmp_path):
    starved = {"group": 3, "bitrate": "8k", "max_error": "1mm"}
    with warnings.catch_warnings(record=True) as one:
        warnings.simplefilter("always")
        fvv.mux(capture, tmp_path / "one.fvv", **starved)
    with threads() as pool, warnings.catch_warnings(record=True) as many:
        warnings.simplefilter("always")
        found = fvv.distributed.mux(capture, tmp_path / "many.fvv", pool, **starved)
    assert [str(w.message) for w in many] == [str(w.message) for w in one] == found["warnings"] != []
    assert all(issubclass(w.category, fvv.LossWarning) for w in many)
    assert (tmp_path / "one.fvv").read_bytes() == (tmp_path / "many.fvv").read_bytes()


@pytest.mark.parametrize(
    "change",
    [{"verify": True}, {"segments": "x"}, {"codec": "gif"}, {"no_such_option": 1}, {"cameras": "99"}],
)
def test_wrong_arguments_leave_nothing(capture, tmp_path, change):
    with threads() as pool, pytest.raises(fvv.UsageError):
        fvv.distributed.mux(capture, tmp_path / "out.fvv", pool, **{**OPTIONS, **change})
    assert os.listdir(tmp_path) == []


def test_a_file_of_the_capture_is_not_replaced(capture, tmp_path):
    mesh = next(capture.glob("meshes/*0001*"))
    before = mesh.read_bytes()
    os.link(mesh, tmp_path / "alias.fvv")
    with threads() as pool, pytest.raises(fvv.UsageError, match="is read by this call"):
        fvv.distributed.mux(capture, tmp_path / "alias.fvv", pool, force=True, **OPTIONS)
    assert mesh.read_bytes() == before and os.listdir(tmp_path) == ["alias.fvv"]


def test_other_threads_run_while_a_group_is_encoded(capture, tmp_path):
    """The GIL is released: this thread counts on meanwhile."""
    with threads() as pool:
        started = threading.Event()

        def mux():
            started.set()
            fvv.distributed.mux(capture, tmp_path / "out.fvv", pool, **OPTIONS)

        task = pool.submit(mux)
        started.wait()
        steps = 0
        while not task.done():
            time.sleep(0.001)
            steps += 1
        task.result()
    assert steps > 50


def test_without_fsspec(capture, tmp_path):
    code = (
        "import sys; sys.modules['fsspec'] = None; import fvv.distributed, concurrent.futures as f\n"
        "try: fvv.distributed.mux('a', 'b', f.ThreadPoolExecutor())\n"
        "except ImportError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == "fvv.distributed needs fsspec: pip install fvv[dask]\n", done.stderr


def test_a_folder_that_a_worker_still_writes_into_is_removed(tmp_path, monkeypatch):
    folder = tmp_path / "parts"
    folder.mkdir()
    remove, tries = storage.remove, []

    def late(path):
        tries.append(path)
        if len(tries) < 3:
            raise OSError(errno.ENOTEMPTY, "Directory not empty", path)
        remove(path)

    monkeypatch.setattr(storage, "remove", late)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fvv.distributed._remove(str(folder))
    assert len(tries) == 3 and not folder.exists()
    # Waiting ends, and is for this failure alone.
    monkeypatch.setattr(fvv.distributed, "_LAST_FILE", 0.5)
    for code, waits in (errno.ENOTEMPTY, True), (errno.EACCES, False):
        tries.clear()

        def fail(path, code=code):
            tries.append(path)
            raise OSError(code, os.strerror(code), path)

        monkeypatch.setattr(storage, "remove", fail)
        with pytest.warns(RuntimeWarning, match="parts: cannot be removed"):
            fvv.distributed._remove(str(folder))
        assert (len(tries) > 1) == waits
