"""Each call of open, write, fsync, rename, close and mkdir of all tools that write fails once: nothing is lost."""

import collections
import errno
import json
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from test_faults import CALLS, COMMANDS, call, fault, made, needs_faults, whole, work  # noqa: E402, F401

MOST = 400  # calls of a kind in one run; more would be a tool that writes byte by byte
figures = collections.Counter()


def inject(command, work, call_name, number, exchange, run=call):  # noqa: F811
    """Whether the run has that many calls; what it leaves is counted and removed."""
    log = work.parent / "log"
    log.unlink(missing_ok=True)
    before = whole(work)
    code = CALLS.get(call_name, errno.EPERM)
    done = run(command, work, env=fault(call_name, number, code, FAULT_LOG=str(log), **exchange))
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


# Several outputs at once, and a writer.
PYTHON = {
    "mux": "fvv.mux(None, 'out.fvv', meshes='cap/meshes/####.obj', fps=25, write_capture='out.json', force=True, threads=1)",
    "fvvcapture": "sys.exit(main('rec --calibration room.json --masks masks --fps 25 --mux threads=1 --jobs 1 -o out.fvv --sheet sheet.png --chart "
    "chart.png --force'.split()))",
    "writer": "with fvv.Writer('out.fvv', rate=25, force=True, threads=1) as writer:\n"
    "  for i in range(2): writer.add(([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, i + 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))",
}
PACKAGE = pathlib.Path(os.environ.get("FVV_TOOLS_DIR", "/nowhere")).parent / "bindings/python"


def make_recordings(work):  # noqa: F811
    """rec, masks, room.json: what fvvcapture reads."""
    small = ["fvvsynth", "-o", "filmed", "--rig", "small", "--cameras", 3, "--size", "64x48", "--frames", 1]
    assert call(small, work).returncode == 0
    room = json.loads((work / "filmed/capture.json").read_text())
    for camera in room["cameras"]:
        del camera["masks"]
        for folder, name in (("rec", "0000.png"), ("masks", "mask_0000.png")):
            (work / folder / camera["name"]).mkdir(parents=True)
            shutil.copy(work / "filmed" / camera["name"] / name, work / folder / camera["name"] / "0000.png")
    room["meshes"]["pattern"] = f"{work}/filmed/{room['meshes']['pattern']}"
    (work / "room.json").write_text(json.dumps(room))


# Of packages that write files while they are imported, and that report failures in words of their own.
IMPORTS = {
    "fvvcapture": "import fvv_capture.process, matplotlib.figure, scipy.optimize, scipy.ndimage\n"
    "from fvv_capture.command import main",
}


def call_python(text, work, env=None):  # noqa: F811
    """Faults begin after the imports."""
    before = next((IMPORTS[name] for name in IMPORTS if PYTHON[name] == text), "")
    guarded = "\n".join(f"  {line}" for line in text.splitlines())
    script = (
        f"import os, sys, fvv\n{before}\nif 'LATER' in os.environ: os.environ['FAULT'] = os.environ['LATER']\n"
        f"try:\n{guarded}\nexcept (fvv.Error, OSError) as error:\n  sys.exit(str(error))"
    )
    env = (os.environ if env is None else env) | {"PYTHONPATH": str(PACKAGE), "PYTHONDONTWRITEBYTECODE": "1"}
    if "FAULT" in env:
        env["LATER"] = env.pop("FAULT")
    words = [sys.executable, "-W", "ignore", "-c", script]
    return subprocess.run(words, cwd=work, capture_output=True, text=True, timeout=60, env=env)


@needs_faults
@pytest.mark.skipif(
    not list(PACKAGE.glob("fvv/_core*")), reason="skipped: the Python package is not built beside the tools"
)
@pytest.mark.parametrize("name", PYTHON)
def test_every_call_of_python_fails_once(name, work, capsys):  # noqa: F811
    """os.link too, by which a file that comes meanwhile is not replaced; without it files are renamed."""
    text = PYTHON[name]
    if name == "fvvcapture":
        for module in ("cv2", "scipy", "matplotlib"):
            pytest.importorskip(module, reason=f"skipped: fvvcapture --chart needs {module}")
        make_recordings(work)
    done = call_python(text, work)
    # 3: three cameras leave doubts.
    assert done.returncode == 3 if name == "fvvcapture" else done.returncode == 0, done.stderr
    found = collections.Counter()
    for call_name in [*CALLS, "link"]:
        number = 1
        while number < MOST and inject(text, work, call_name, number, {}, call_python):
            number += 1
        found[call_name] = number - 1
    with capsys.disabled():
        print(
            f"\npython {name}: {dict(found)}; faults.injected {figures['injected']}, faults.lost {figures['lost']}"
        )
    assert all(found[call_name] for call_name in ("open", "write", "fsync", "close", "rename", "link"))
    assert not figures["lost"]
