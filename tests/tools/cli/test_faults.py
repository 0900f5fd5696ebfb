"""What happens to outputs when the system fails, or another program interferes (docs/tools/outputs.md): nothing is lost."""

import errno
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import pytest
from conftest import tool_path

sys.path.insert(0, str(pathlib.Path(__file__).parents[1]))
from test_outputs import FILES, FOLDERS, MUX, OLD, call, made, tree, work  # noqa: E402, F401

FAULT = os.environ.get("FVV_FAULT_LIBRARY")
needs_faults = pytest.mark.skipif(
    not FAULT, reason="skipped: FVV_FAULT_LIBRARY is not set (sanitizers must be loaded first)"
)
CALLS = {"open": errno.EACCES, "write": errno.ENOSPC, "fsync": errno.EIO, "close": errno.EIO}
CALLS |= {"rename": errno.EIO, "mkdir": errno.EACCES}


def fault(call_name, number, code=None, **more):
    code = CALLS[call_name] if code is None else code
    return os.environ | {"LD_PRELOAD": FAULT, "FAULT": f"{call_name}:{number}:{code}"} | more


def whole(folder):
    """All that is in a folder but temporaries, without times."""
    return {name: value for name, value in tree(folder).items() if ".partial" not in name}


def commands():
    yield from ((name, [*run, f"out{end}", "--force"], f"out{end}") for name, (run, end, _) in FILES.items())
    yield from ((name, [*run, "out", "--force"], "out") for name, run in FOLDERS.items())
    # Its list has files that other runs add, and those are added to a folder that exists.
    yield "plan", [*MUX, "--group", 1, "--plan", "out", "--force"], "out"
    yield "part", ["fvvmux", "--part", 1, "plan", "--threads", 1, "--force"], "plan/group-1.fvv"


COMMANDS = {name: (command, out) for name, command, out in commands()}


@needs_faults
@pytest.mark.parametrize("exchange", [{}, {"NOEXCHANGE": "1"}], ids=["exchange", "no exchange"])
@pytest.mark.parametrize("name", COMMANDS)
def test_each_call_may_fail(name, exchange, work):  # noqa: F811
    """A call of each kind: the run fails and all is as before, or it is done and all is new. test_every_fault.py (nightly) does it for
    every call; without an exchange of names only renaming differs."""
    command, out = COMMANDS[name]
    assert call(command, work).returncode in (0, 3)
    before = whole(work)
    calls = ["rename"] if exchange else CALLS
    failures = 0
    for call_name in calls:
        for number in [1, 9]:
            done = call(command, work, env=fault(call_name, number, **exchange))
            where = f"{call_name} {number}: {done.returncode} {done.stderr}"
            assert done.returncode in (0, 1, 3), where
            # The tools write the same bytes each time: old and new are one.
            assert whole(work) == before, where
            failures += done.returncode == 1
            if done.returncode == 1:
                assert len(done.stderr.splitlines()) == 1, where
            left = [path.name for path in work.rglob("*.partial")]
            assert all(path in done.stderr for path in left), (where, left)
            for path in left:
                shutil.rmtree(work / path) if (work / path).is_dir() else (work / path).unlink()
    assert failures >= max(1, len(calls) - 2), "the faults arrive"


@needs_faults
@pytest.mark.parametrize("exchange", [{}, {"NOEXCHANGE": "1"}], ids=["exchange", "no exchange"])
@pytest.mark.parametrize("number", range(1, 8))
def test_what_cannot_be_put_back_stays_and_is_named(number, exchange, work):  # noqa: F811
    """From some rename on all fail: the file that was there before exists afterwards, under a name that is said."""
    old = work / "o.fvv"
    old.write_bytes(OLD)
    assert call([*MUX, "-o", "x.fvv", "--segments", "seg"], work).returncode == 0
    command = [*MUX, "-o", "o.fvv", "--segments", "seg", "--force"]
    done = call(command, work, env=fault("rename", f"{number}+", **exchange))
    assert number > 2 or done.returncode == 1, "the fault arrives"
    if done.returncode == 0:
        assert old.read_bytes() != OLD and (work / "seg/manifest.json").exists()
        return
    assert done.returncode == 1, done.stderr
    places = [path for path in work.iterdir() if path.is_file() and path.read_bytes() == OLD]
    assert len(places) == 1, done.stderr
    assert places[0] == old or places[0].name in done.stderr, done.stderr
    folders = [path for path in work.iterdir() if (path / "manifest.json").exists()]
    assert folders, done.stderr
    assert work / "seg" in folders or any(path.name in done.stderr for path in folders), done.stderr


@pytest.mark.parametrize("closed", ["1", "2", "12", "0", "012"])
@pytest.mark.parametrize("name", COMMANDS)
def test_closed_descriptors_are_not_written_to(name, closed, work):  # noqa: F811
    """An output is never opened under the number of a standard stream, so that no message gets into it."""
    command, out = COMMANDS[name]
    if name == "both":
        out = "both.fvv"
    assert call(command, work).returncode in (0, 3)
    before = whole(work)
    shutil.rmtree(work / out) if (work / out).is_dir() else (work / out).unlink()

    def close():
        for number in closed:
            os.close(int(number))

    words = [str(tool_path(command[0])), *map(str, command[1:])]
    code = subprocess.run(words, cwd=work, preexec_fn=close, timeout=60).returncode
    # What is printed is lost, and said to be: but for that the run is done.
    assert code in (0, 1, 3) and whole(work) == before


def test_a_stream_for_a_closed_standard_output_is_an_error(work):  # noqa: F811
    words = [str(tool_path("fvvmux")), *map(str, MUX[1:]), "-o", "-"]
    done = subprocess.run(
        words, cwd=work, preexec_fn=lambda: os.close(1), stderr=subprocess.PIPE, text=True, timeout=60
    )
    assert done.returncode == 1 and "standard output" in done.stderr


class Stopped:
    """A run that is stopped (SIGSTOP) while its temporary output is there."""

    def __init__(self, work, command):  # noqa: F811
        words = [str(tool_path(command[0])), *map(str, command[1:])]
        environment = os.environ | ({"LD_PRELOAD": FAULT} if FAULT else {})
        self.process = subprocess.Popen(
            words, cwd=work, stderr=subprocess.PIPE, text=True, stdout=subprocess.PIPE, env=environment
        )
        end = time.monotonic() + 60
        while not list(work.glob(".*.partial")) and time.monotonic() < end and self.process.poll() is None:
            pass
        self.process.send_signal(signal.SIGSTOP)
        self.caught = self.process.poll() is None and bool(list(work.glob(".*.partial")))

    def finish(self):
        self.process.send_signal(signal.SIGCONT)
        _, err = self.process.communicate(timeout=60)
        return self.process.returncode, err


def stopped(work, command):  # noqa: F811
    """Until a run is caught in its middle; a run that was over first is no failure of the tool."""
    for _ in range(50):
        run = Stopped(work, command)
        if run.caught:
            return run
        run.finish()
    raise AssertionError("no run could be stopped in its middle")


def test_a_folder_that_takes_the_place_of_a_file_stays(work):  # noqa: F811
    (work / "r.fvv").write_bytes(OLD)
    run = stopped(work, [*MUX, "-o", "r.fvv", "--force"])
    (work / "r.fvv").unlink()
    (work / "r.fvv").mkdir()
    (work / "r.fvv/diary.txt").write_text("precious")
    code, err = run.finish()
    assert code == 1 and "r.fvv: has become a folder" in err, err
    assert (work / "r.fvv/diary.txt").read_text() == "precious"
    assert not list(work.glob(".*.partial"))


@pytest.mark.parametrize("kind", ["file", "empty file", "link"])
def test_a_file_that_takes_the_place_of_a_folder_stays(kind, work):  # noqa: F811
    command = ["fvvdemux", "s.fvv", "-o", "d"]
    assert call(command, work).returncode == 0
    run = stopped(work, [*command, "--force"])
    shutil.rmtree(work / "d")
    if kind == "link":
        (work / "elsewhere").mkdir()
        (work / "elsewhere/diary.txt").write_text("precious")
        (work / "d").symlink_to("elsewhere")
    else:
        (work / "d").write_bytes(OLD if kind == "file" else b"")
    code, err = run.finish()
    assert code == 1 and "has become" in err, err
    if kind == "link":
        assert (work / "elsewhere/diary.txt").read_text() == "precious" and (work / "d").is_symlink()
    else:
        assert (work / "d").read_bytes() == (OLD if kind == "file" else b"")


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGINT, signal.SIGTERM])
def test_ignored_signals_stay_ignored(number, work):  # noqa: F811
    """nohup, and jobs in the background of a script."""
    words = [str(tool_path("fvvmux")), *map(str, MUX[1:]), "-o", "n.fvv"]
    run = subprocess.Popen(words, cwd=work, preexec_fn=lambda: signal.signal(number, signal.SIG_IGN))
    while run.poll() is None:
        run.send_signal(number)
        time.sleep(0.005)
    assert run.returncode == 0
    assert (work / "n.fvv").read_bytes() == (work / "s.fvv").read_bytes()


def test_names_of_the_greatest_length(work):  # noqa: F811
    longest = os.pathconf(work, "PC_NAME_MAX")
    for name in ["n" * (longest - 4) + ".fvv", "é" * ((longest - 4) // 2) + ".fvv"]:
        done = call([*MUX, "-o", name], work)
        assert done.returncode == 0, done.stderr
        assert (work / name).read_bytes() == (work / "s.fvv").read_bytes()
        assert call([*MUX, "-o", name, "--force"], work).returncode == 0
    assert call(["fvvdemux", "s.fvv", "-o", "d" * longest], work).returncode == 0
    assert not list(work.glob(".*.partial"))


@pytest.mark.skipif(os.geteuid() != 0, reason="skipped: only root gives files away")
def test_the_owner_of_a_replaced_file_is_kept(work):  # noqa: F811
    (work / "o.fvv").write_bytes(OLD)
    os.chown(work / "o.fvv", 1234, 2345)
    os.chmod(work / "o.fvv", 0o640)
    assert call([*MUX, "-o", "o.fvv", "--force"], work).returncode == 0
    status = (work / "o.fvv").stat()
    assert (status.st_uid, status.st_gid, status.st_mode & 0o777) == (1234, 2345, 0o640)


def test_json_of_names_that_are_not_utf8(work):  # noqa: F811
    """All tools that print JSON print it with replacement characters."""
    name = os.fsdecode(b"n\xff")
    shutil.copy(work / "s.fvv", work / f"{name}.fvv")
    for command in [
        [*MUX, "-o", f"{name}o.fvv", "--json"],
        [*MUX, "--plan", f"{name}plan", "--json"],
        ["fvvmux", f"{name}.fvv", "--segments", f"{name}seg", "--json"],
        ["fvvimport", "capture", "cap", "--sheet", f"{name}.png", "--json"],
        ["fvvinfo", f"{name}.fvv", "--json"],
        ["fvvdemux", f"{name}.fvv", "-o", f"{name}d", "--json"],
        ["fvvcompare", f"{name}.fvv", f"{name}.fvv", "--samples", 1, "--json"],
        ["fvvrender", f"{name}.fvv", "--camera", 0, "-o", f"{name}v.png", "--json"],
        ["fvvrecover", f"{name}.fvv", "-o", f"{name}r.fvv", "--json"],
    ]:
        words = [str(tool_path(command[0])), *map(str, command[1:])]
        done = subprocess.run(words, cwd=work, capture_output=True, timeout=60)
        assert done.returncode == 0, (command, done.stderr)
        assert "n�" in done.stdout.decode(), command
