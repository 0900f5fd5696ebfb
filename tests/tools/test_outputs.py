"""No tool ever loses a user's files: what may take the place of what, and what a failed run leaves (docs/tools/outputs.md)."""

import ctypes
import json
import os
import pathlib
import resource
import shutil
import signal
import socket
import stat
import subprocess
import threading
import time

import pytest
from conftest import tool_path
from reference.tiny import TETRAHEDRON

OLD = b"what was there before"
READS = "which this run reads"


def call(command, cwd, **options):
    command = [str(tool_path(command[0])), *map(str, command[1:])]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, timeout=60, **options)


def write_capture(folder):
    """Pictures of fvvsynth, and meshes of four faces, so that every run is quick."""
    synth = ["fvvsynth", "-o", folder, "--rig", "small", "--cameras", 2, "--size", "64x48", "--frames", 2]
    assert call(synth, folder.parent).returncode == 0
    for path in (folder / "meshes").iterdir():
        path.unlink()
    for frame in range(2):
        lines = [f"v {x / 200} {y / 200} {z / 200}" for x, y, z in TETRAHEDRON.positions]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in TETRAHEDRON.faces]
        (folder / f"meshes/{frame:04}.obj").write_text("\n".join(lines) + "\n")
    capture = json.loads((folder / "capture.json").read_text())
    capture["meshes"] = {"pattern": "meshes/%04d.obj"}
    for camera in capture["cameras"]:
        del camera["masks"]
    (folder / "capture.json").write_text(json.dumps(capture))


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """The inputs of all runs; each test has a copy."""
    folder = tmp_path_factory.mktemp("made")
    write_capture(folder / "cap")
    mux = [*MUX, "-o", "s.fvv"]
    done = call(mux, folder)
    assert done.returncode == 0, done.stderr
    for command in [*MUX, "--group", 1, "--plan", "plan"], ["fvvmux", "--part", 1, "plan", "--threads", 1]:
        done = call(command, folder)
        assert done.returncode == 0, done.stderr
    identity = "100 0 32 0 100 24 0 0 1 1 0 0 0 1 0 0 0 1 0 0 2"
    (folder / "par.txt").write_text(f"1\na.png {identity}\n")
    shutil.copy(folder / "s.fvv", folder / "in.png")
    return folder


@pytest.fixture
def work(made, tmp_path):
    folder = tmp_path / "work"
    shutil.copytree(made, folder)
    return folder


MUX = ["fvvmux", "cap", "--codec", "jpeg", "--crop", "none", "--winding", "keep", "--threads", 1]
MIDDLEBURY = ["fvvimport", "middlebury", "par.txt", "--size", "64x48", "--meshes", "m/%04d.ply"]
CAPTURED = ["cap/capture.json", "cap/meshes/0001.obj", "cap/cam1/0001.png"]
# Runs that write a file, whose name has to end in .png or .exr for some, and what they read.
FILES = {
    "fvvmux": ([*MUX, "-o"], ".fvv", CAPTURED),
    "fvvimport": ([*MIDDLEBURY, "-o"], ".json", ["par.txt"]),
    "sheet": (["fvvimport", "capture", "cap", "--sheet-width", 120, "--sheet"], ".png", CAPTURED),
    "fvvrender": (["fvvrender", "in.png", "--camera", 0, "-o"], ".png", ["in.png"]),
    "mask": (["fvvrender", "in.png", "--camera", 0, "-o", "also.png", "--mask"], ".png", ["in.png"]),
    "fvvrecover": (["fvvrecover", "in.png", "-o"], ".fvv", ["in.png"]),
    "merge": (["fvvmux", "--merge", "plan", "-o"], ".fvv", ["plan/plan.cbor", "plan/group-0.fvv"]),
    "csv": (["fvvcompare", "cap", "s.fvv", "--samples", 1, "--csv"], ".csv", ["s.fvv", *CAPTURED[:2]]),
}
# Runs that write a folder; the option comes last.
FOLDERS = {
    "fvvdemux": ["fvvdemux", "s.fvv", "-o"],
    "fvvsynth": ["fvvsynth", "--rig", "small", "--cameras", 1, "--size", "32x32", "--frames", 1, "-o"],
    "segments": ["fvvmux", "s.fvv", "--segments"],
    "both": [*MUX, "-o", "both.fvv", "--segments"],
    "heatmap": ["fvvcompare", "cap", "s.fvv", "--samples", 1, "--heatmap"],
}
files, folders = pytest.mark.parametrize("run", FILES), pytest.mark.parametrize("run", FOLDERS)


def tree(folder):
    """All that is in a folder, as (kind, bytes or target) by path. Nothing is followed."""
    out = {}
    for path in sorted(pathlib.Path(folder).rglob("*")):
        mode = path.lstat().st_mode
        kind = stat.S_IFMT(mode)
        value = path.read_bytes() if stat.S_ISREG(mode) else os.readlink(path) if stat.S_ISLNK(mode) else None
        out[str(path.relative_to(folder))] = (kind, value)
    return out


def to_file(run, work, out, *more, **options):
    return call([*FILES[run][0], out, *more], work, **options)


def refuses(work, command, reason, code=1, **options):
    """The run fails for this reason, in one line, and changes nothing."""
    before = tree(work)
    done = call(command, work, **options)
    assert done.returncode == code, done.stderr
    assert reason in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr
    assert ".partial" not in done.stderr, "the name that the user gave"
    assert tree(work) == before
    return done


def make_socket(path):
    """Its name must be short, so it is made from within its folder."""
    here = os.getcwd()
    os.chdir(path.parent)
    try:
        with socket.socket(socket.AF_UNIX) as one:
            one.bind(path.name)
    finally:
        os.chdir(here)


def device(path, minor):
    """A character device of its own: 1:3 is that of null, 1:7 that of full."""
    try:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, minor))
        os.close(os.open(path, os.O_WRONLY))
    except OSError as error:
        pytest.skip(f"no device can be made here: {error}")
    return path


@files
def test_new_and_existing_files(run, work):
    command, end, _ = FILES[run]
    out = work / ("out" + end)
    before = tree(work)
    done = to_file(run, work, out)
    assert done.returncode == 0, done.stderr
    written = out.read_bytes()
    extra = {"also.png"} if run == "mask" else set()
    assert set(tree(work)) - set(before) == {out.name, *extra}, "no temporary file stays"
    for name in extra:
        (work / name).unlink()
    out.write_bytes(OLD)
    out.chmod(0o600)
    refuses(work, [*command, out], "already exists; --force")
    assert to_file(run, work, out, "--force").returncode == 0
    assert out.read_bytes() == written and stat.S_IMODE(out.stat().st_mode) == 0o600
    for name in extra:
        (work / name).unlink()
    target = work / ("target" + end)
    out.rename(target)
    target.write_bytes(OLD)
    out.symlink_to(target.name)
    refuses(work, [*command, out], "already exists; --force")
    assert to_file(run, work, out, "--force").returncode == 0
    assert out.is_symlink() and target.read_bytes() == written, "the link stays, its target is replaced"


@files
def test_devices_and_pipes_are_written_to(run, work):
    command, end, _ = FILES[run]
    pipe = work / ("pipe" + end)
    os.mkfifo(pipe)
    received = []
    reader = threading.Thread(target=lambda: received.append(pipe.read_bytes()))
    reader.start()
    done = to_file(run, work, pipe)
    assert done.returncode == 0, done.stderr
    reader.join()
    assert stat.S_ISFIFO(pipe.lstat().st_mode)
    (work / "also.png").unlink(missing_ok=True)
    assert to_file(run, work, "out" + end).returncode == 0
    assert received == [(work / ("out" + end)).read_bytes()]
    (work / "also.png").unlink(missing_ok=True)
    null, full = device(work / ("null" + end), 3), device(work / ("full" + end), 7)
    for options in [], ["--force"]:
        assert to_file(run, work, null, *options).returncode == 0
        (work / "also.png").unlink(missing_ok=True)
        refuses(work, [*command, full, *options], f"{full}: cannot write: No space left on device")
        assert stat.S_ISCHR(null.lstat().st_mode) and stat.S_ISCHR(full.lstat().st_mode)


@files
def test_what_a_run_reads_is_no_output(run, work):
    command, end, read = FILES[run]
    for name in read:
        hard, soft = work / ("hard" + end), work / ("soft" + end)
        os.link(work / name, hard)
        soft.symlink_to(name)
        for out in [hard, soft, *([work / name] if name.endswith(end) else [])]:
            refuses(work, [*command, out, "--force"], READS)
        hard.unlink()
        soft.unlink()


def test_files_that_gltf_refers_to_are_no_output(work):
    buffer = work / "cap/meshes/buffer.bin"
    buffer.write_bytes(bytes(36) + bytes(range(12)))
    gltf = {"asset": {"version": "2.0"}, "buffers": [{"uri": "buffer.bin", "byteLength": 48}]}
    (work / "cap/meshes/0000.gltf").write_text(json.dumps(gltf))
    shutil.copy(work / "cap/meshes/0000.gltf", work / "cap/meshes/0001.gltf")
    capture = json.loads((work / "cap/capture.json").read_text())
    capture["meshes"] = {"pattern": "meshes/%04d.gltf"}
    (work / "cap/capture.json").write_text(json.dumps(capture))
    refuses(work, [*MUX, "-o", buffer, "--force"], READS)


@files
def test_folders_and_sockets_are_no_files(run, work):
    command, end, _ = FILES[run]
    (work / ("folder" + end)).mkdir()
    make_socket(work / ("socket" + end))
    for options in [], ["--force"]:
        refuses(work, [*command, "folder" + end, *options], "is a folder")
        refuses(work, [*command, "socket" + end, *options], "is a socket")


def few_bytes():
    resource.setrlimit(resource.RLIMIT_FSIZE, (16, 16))


def obey_permissions():
    """Root without the right to ignore permissions."""
    if os.getuid() == 0:
        for capability in 1, 2:  # CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH
            assert ctypes.CDLL(None).prctl(24, capability, 0, 0, 0) == 0  # PR_CAPBSET_DROP


@files
def test_full_disks_and_read_only_folders_keep_files(run, work):
    command, end, _ = FILES[run]
    (work / "there").mkdir()
    out = work / "there" / ("out" + end)
    for content in None, OLD:
        if content:
            out.write_bytes(content)
        failure = "also.png: cannot write" if run == "mask" else f"{out}: cannot write: File too large"
        refuses(work, [*command, out, "--force"], failure, preexec_fn=few_bytes)
        (work / "there").chmod(0o555)
        refuses(work, [*command, out, "--force"], f"{out}: cannot create: Perm", preexec_fn=obey_permissions)
        (work / "there").chmod(0o755)


@folders
def test_full_disks_and_read_only_folders_keep_folders(run, work):
    (work / "there").mkdir()
    out = work / "there/out"
    for again in False, True:
        if again:
            assert call([*FOLDERS[run], out], work).returncode == 0
        name = "both.fvv" if run == "both" else str(out)
        failed = refuses(work, [*FOLDERS[run], out, "--force"], "cannot write", preexec_fn=few_bytes)
        assert name in failed.stderr and "File too large" in failed.stderr
        (work / "there").chmod(0o555)
        refuses(work, [*FOLDERS[run], out, "--force"], "cannot create: Perm", preexec_fn=obey_permissions)
        (work / "there").chmod(0o755)


def run_in_tmpfs(work, size, command):
    """Runs a tool in a folder of a file system of some kB, with a copy of s.fvv; returns the process and what it left."""
    script = (
        f"mount -t tmpfs -o size={size}k tmpfs there || exit 77; printf old > there/old.fvv; "
        '"$@"; code=$?; (cd there; find . | sort; cat old.fvv); exit $code'
    )
    (work / "there").mkdir()
    command = [str(tool_path(command[0])), *map(str, command[1:])]
    try:
        done = subprocess.run(
            ["unshare", "-m", "sh", "-c", script, "sh", *command],
            cwd=work, capture_output=True, text=True, timeout=60,
        )  # fmt: skip
    except FileNotFoundError:
        pytest.skip("no unshare")
    if done.returncode not in (0, 1, 2, 3):
        pytest.skip(f"no file system can be mounted here: {done.stderr}")
    return done


def test_failed_segments_leave_no_stream(work):
    """The stream fits, its segments do not."""
    size = (work / "s.fvv").stat().st_size // 1024 + 12
    done = run_in_tmpfs(work, size, [*MUX, "-o", "there/old.fvv", "--force", "--segments", "there/out"])
    assert done.returncode == 1 and "there/out/" in done.stderr and "No space left" in done.stderr
    assert done.stdout == ".\n./old.fvv\nold", "the file of before, and nothing else"


@folders
def test_new_and_existing_folders(run, work):
    command = FOLDERS[run]
    out = work / "out"

    def again(*options):
        (work / "both.fvv").unlink(missing_ok=True)
        return call([*command, out, *options], work)

    out.mkdir()
    assert again().returncode == 0, "an empty folder is replaced"
    written = tree(out)
    marker = written[".fvv-output"][1].decode()
    assert marker.splitlines()[:2] == ["fvv output folder 1", f"tool {command[0]}"]
    listed = {line[5:] for line in marker.splitlines()[2:]}
    assert listed == {name for name, (kind, _) in written.items() if stat.S_ISREG(kind)} - {".fvv-output"}
    (work / "both.fvv").unlink(missing_ok=True)
    refuses(work, [*command, out], "already exists; --force")
    assert again("--force").returncode == 0
    assert tree(out) == written
    # The folder is what a link leads to.
    out.rename(work / "target")
    out.symlink_to("target")
    assert again("--force").returncode == 0
    assert out.is_symlink() and tree(work / "target") == written
    (work / "both.fvv").unlink(missing_ok=True)
    # A user's file, also under the name of a file of the tool.
    mine = out / "mine.txt"
    mine.write_text("mine")
    refuses(work, [*command, out, "--force"], "it did not write")
    mine.unlink()
    mine.mkdir()
    refuses(work, [*command, out, "--force"], "it did not write")
    mine.rmdir()
    one = out / sorted(listed)[0]
    one.unlink()
    one.symlink_to(work / "s.fvv")
    refuses(work, [*command, out, "--force"], "it did not write")
    one.unlink()
    assert again("--force").returncode == 0, "what was deleted is no obstacle"
    (work / "both.fvv").unlink(missing_ok=True)
    (out / ".fvv-output").write_text(marker.replace(f"tool {command[0]}", "tool other"))
    refuses(work, [*command, out, "--force"], "the folder is from other")
    (out / ".fvv-output").unlink()
    refuses(work, [*command, out, "--force"], "has no list of its files")


@folders
def test_what_is_no_folder_stays(run, work):
    command = FOLDERS[run]
    (work / "file").write_bytes(OLD)
    os.mkfifo(work / "pipe")
    (work / "soft").symlink_to("file")
    os.link(work / "s.fvv", work / "hard")
    kinds = {"file": "a file", "pipe": "a pipe", "soft": "a file", "s.fvv": "a file", "hard": "a file"}
    make_socket(work / "socket")
    kinds["socket"] = "a socket"
    for name, kind in kinds.items():
        for options in [], ["--force"]:
            refuses(work, [*command, name, *options], f"{name}: is {kind}, expected the name of a folder")
    if run != "both":  # its stream would be inside
        refuses(work, [*command, work, "--force"], "is the current folder")
        refuses(work, [*command, work.parent, "--force"], "is the current folder")
    null = device(work / "null", 3)
    refuses(work, [*command, null, "--force"], "is a character device")
    (work / "null").unlink()
    (work / "cap/.fvv-output").unlink()
    refuses(work, [*command, "cap", "--force"], "--force replaces only what this tool wrote")


def test_a_folder_with_an_input_in_it_stays(work):
    assert call(["fvvmux", "s.fvv", "--segments", "out"], work).returncode == 0
    os.replace(work / "s.fvv", work / "out/manifest.json")
    (work / "s.fvv").symlink_to("out/manifest.json")
    refuses(work, ["fvvmux", "s.fvv", "--segments", "out", "--force"], READS)


def test_outputs_of_one_run_do_not_meet(work):
    render = ["fvvrender", "in.png", "--camera", 0, "-o", "a.png", "--force"]
    (work / "link.png").symlink_to("a.png")
    for name in "a.png", "./a.png", work / "a.png", "link.png":
        refuses(work, [*render, "--mask", name], "two outputs have this name", code=2)
    (work / "out").mkdir()
    refuses(work, [*MUX, "-o", "out/a.fvv", "--segments", "out"], "inside another output", code=2)
    for options in ["--verify"], ["--segments", "out"]:
        refuses(work, [*MUX, "-o", device(work / "null", 3), *options], "cannot be read back", code=2)
        (work / "null").unlink()


def test_standard_output_is_not_replaced(work):
    (work / "log").write_bytes(OLD)
    with open(work / "log", "ab") as log:
        command = [str(tool_path("fvvmux")), *map(str, MUX[1:]), "-o", "log", "--force"]
        done = subprocess.run(command, cwd=work, stdout=log, stderr=subprocess.PIPE, timeout=60)
    assert done.returncode == 1 and b"is standard output" in done.stderr
    assert (work / "log").read_bytes() == OLD


def test_parents_are_made_and_go_with_a_failed_run(work):
    refuses(work, ["fvvdemux", "s.fvv", "-o", "a/b/c"], "cannot write", preexec_fn=few_bytes)
    assert call(["fvvdemux", "s.fvv", "-o", "a/b/c"], work).returncode == 0
    assert (work / "a/b/c/capture.json").exists()


def partial_outputs(work):
    """Temporary outputs anywhere in work. Unlike Path.rglob, os.walk bears folders that vanish meanwhile."""
    return [
        pathlib.Path(folder, name)
        for folder, folders, names in os.walk(work)
        for name in folders + names
        if name.startswith(".") and name.endswith(".partial")
    ]


def kill_in_the_middle(command, work, end, delay):
    command = [str(tool_path(command[0])), *map(str, command[1:])]
    process = subprocess.Popen(command, cwd=work, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    limit = time.monotonic() + 20
    while process.poll() is None and not partial_outputs(work) and time.monotonic() < limit:
        time.sleep(0.001)
    time.sleep(delay)
    process.send_signal(end)
    try:
        process.wait(timeout=20)
    finally:
        process.kill()
    partial = partial_outputs(work)
    if end != signal.SIGKILL:
        assert not partial
    for (
        path
    ) in partial:  # a later run copes with these; here they are removed so that the next kill can be timed
        shutil.rmtree(path) if path.is_dir() else path.unlink()


@pytest.mark.parametrize("run", [*FILES, *FOLDERS])
def test_killed_runs_leave_the_old_or_the_new(run, work):
    command, end = (FOLDERS[run], "") if run in FOLDERS else FILES[run][:2]
    out = work / ("out" + end)
    both = work / "both.fvv"
    command = [*command, out, "--force"]
    if run in FOLDERS:
        assert call(command, work).returncode == 0
    else:
        out.write_bytes(OLD)

    def state():
        shown = tree(out) if out.is_dir() else out.read_bytes()
        return shown, both.read_bytes() if both.exists() else None

    old = state()
    assert call(command, work).returncode == 0
    new = state()
    for name in "also.png", "both.fvv":
        (work / name).unlink(missing_ok=True)
    for end in signal.SIGTERM, signal.SIGINT, signal.SIGKILL:
        for delay in 0, 0.004:
            kill_in_the_middle(command, work, end, delay)
            shown, stream = state()
            assert shown in (old[0], new[0]) and stream in (None, new[1])
            both.unlink(missing_ok=True)
            (work / "also.png").unlink(missing_ok=True)


def test_what_a_killed_run_left_is_passed_over(work):
    """Whatever the number of its process was: that of this run, too."""
    script = 'mkdir .out.$$.0.partial; touch .out.$$.0.partial/left .o.fvv.$$.0.partial; exec "$@"'
    command = [str(tool_path("fvvmux")), *map(str, MUX[1:]), "-o", "o.fvv", "--segments", "out"]
    done = subprocess.run(["sh", "-c", script, "sh", *command], cwd=work, capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert not (work / "out/left").exists() and (work / "out/manifest.json").exists()
    assert len(list(work.glob(".*.partial"))) == 2


READERS = {
    "fvvmux": (["fvvmux", "IN", "-o", "x.fvv"], "cap/capture.json"),
    "mesh": ([*MUX, "-o", "x.fvv"], "cap/meshes/0001.obj"),
    "picture": ([*MUX, "-o", "x.fvv"], "cap/cam0/0000.png"),
    "segments": (["fvvmux", "s.fvv", "--segments", "x"], "s.fvv"),
    "fvvdemux": (["fvvdemux", "s.fvv", "-o", "x"], "s.fvv"),
    "fvvrender": (["fvvrender", "s.fvv", "-o", "x.png", "--camera", 0], "s.fvv"),
    "fvvcompare": (["fvvcompare", "cap", "s.fvv", "--samples", 1], "s.fvv"),
    "fvvimport": (MIDDLEBURY + ["-o", "x.json"], "par.txt"),
    "fvvinfo": (["fvvinfo", "s.fvv"], "s.fvv"),
}


@pytest.mark.parametrize("run", READERS)
def test_what_cannot_be_read_is_named(run, work):
    command, name = READERS[run]
    command = [name if word == "IN" else word for word in command]
    path = work / name
    content = path.read_bytes()

    def fails(reason, **options):
        done = call(command, work, **options)
        assert done.returncode == 1 and reason in done.stderr and path.suffix in done.stderr, done.stderr
        assert "missing" not in done.stderr

    path.chmod(0)
    fails("ermission denied", preexec_fn=obey_permissions)
    path.unlink()
    path.mkdir()
    if run not in ("fvvmux", "fvvcompare"):  # the folder of a capture.json
        fails("is a folder")
    path.rmdir()
    if run != "fvvinfo":  # reads pipes
        os.mkfifo(path)
        fails("is a pipe")
        path.unlink()
    path.write_bytes(content)
    if path.parent != work:
        path.parent.chmod(0)
        fails("ermission denied", preexec_fn=obey_permissions)
        path.parent.chmod(0o755)
