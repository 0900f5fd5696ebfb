"""Each call of open, write, fsync, rename, close and mkdir of all tools that write fails once: nothing is lost."""

import collections
import pathlib
import shutil
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from test_faults import CALLS, COMMANDS, call, fault, made, needs_faults, whole, work  # noqa: E402, F401

MOST = 400  # calls of a kind in one run; more would be a tool that writes byte by byte
figures = collections.Counter()


def inject(command, work, call_name, number, exchange):  # noqa: F811
    """Whether the run has that many calls; what it leaves is counted and removed."""
    log = work.parent / "log"
    log.unlink(missing_ok=True)
    before = whole(work)
    done = call(command, work, env=fault(call_name, number, FAULT_LOG=str(log), **exchange))
    if not log.exists():
        assert done.returncode in (0, 3), done.stderr
        return False
    figures["injected"] += 1
    where = f"{call_name} {number}: {done.returncode} {done.stderr}"
    # The tools write the same bytes each time: old and new are one.
    if done.returncode not in (0, 1, 3) or whole(work) != before:
        figures["lost"] += 1
        print(where)
    assert done.returncode != 1 or len(done.stderr.splitlines()) == 1, where
    for path in list(work.rglob("*.partial")):
        assert path.name in done.stderr, where
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    return True


@needs_faults
@pytest.mark.parametrize("exchange", [{}, {"NOEXCHANGE": "1"}], ids=["exchange", "no exchange"])
@pytest.mark.parametrize("name", COMMANDS)
def test_every_call_fails_once(name, exchange, work, capsys):  # noqa: F811
    command, _ = COMMANDS[name]
    assert call(command, work).returncode in (0, 3)
    for call_name in CALLS:
        number = 1
        while number < MOST and inject(command, work, call_name, number, exchange):
            number += 1
        assert number < MOST
    with capsys.disabled():
        print(f"\n{name}: faults.injected {figures['injected']}, faults.lost {figures['lost']}")
    assert figures["injected"] and not figures["lost"]
