"""The Python package: the time to read all meshes of a stream beside libfvv's, and to write one beside fvvmux; copies, and
the size of the wheel.

With "read" and a stream, "mux" or "write" and a capture, or "rate", a capture and a preset, as its arguments it does that and prints what it took, as JSON: the
package is on PYTHONPATH then.
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import threading
import time
import tracemalloc

ROOT = pathlib.Path(__file__).resolve().parent.parent
RUNS = 5
WRITES = 3
# Half a second of meshes and pictures, in groups of which a writer has one in memory.
WRITTEN = {"frames": "0-11", "group": 6, "codec": "h264", "quality": 23, "no_sound": True}


def read(path):
    """Bytes of the arrays of all meshes."""
    import fvv

    size = 0
    with fvv.open(path) as clip:
        for frame in clip:
            mesh = frame.mesh
            size += mesh.positions.nbytes + mesh.indices.nbytes
            if mesh.colours is not None:
                size += mesh.colours.nbytes
    return size


def times(path):
    """The least processor time of several reads in ms, and what numpy and Python allocated for each byte of an array."""
    found = []
    for _ in range(RUNS):
        begin = time.process_time()
        size = read(path)
        found.append(1e3 * (time.process_time() - begin))
    tracemalloc.start()
    read(path)
    _, peak = tracemalloc.get_traced_memory()
    return {"read_ms": min(found), "extra_copies": peak / size, "two_threads": speed_of_two_threads(path)}


def speed_of_two_threads(path):
    """How much more two threads with a clip each read than one does in the same time: 2 with two free processors."""
    best = {}
    for _ in range(RUNS):
        for count in (1, 2):
            threads = [threading.Thread(target=read, args=(path,)) for _ in range(count)]
            begin = time.perf_counter()
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            best[count] = min(best.get(count, float("inf")), time.perf_counter() - begin)
    return 2 * best[1] / best[2]


def mux(capture):
    """Processor seconds of fvv.mux, without starting Python."""
    import fvv

    begin = time.process_time()
    fvv.mux(capture, os.devnull, **WRITTEN)
    return {"seconds": time.process_time() - begin}


def writing(capture, count, **options):
    """A function that writes the first frames of a capture from arrays, and the frames."""
    sys.path[:0] = [str(ROOT / "bindings/python/tests"), str(ROOT / "tests/real")]
    import fvv
    from scenes import read_capture

    described, cameras, frame = read_capture(pathlib.Path(capture))
    frames = [frame(i) for i in range(count)]

    def once():
        with fvv.Writer(os.devnull, rate=25, cameras=cameras, name=described["name"], **options) as writer:
            writer.extend(frames)

    return once, frames


def rate(capture, preset):
    """Frames a second of a Writer, from arrays that are there."""
    once, frames = writing(capture, 50, preset=preset)
    begin = time.perf_counter()
    once()
    return {"frames_per_s": len(frames) / (time.perf_counter() - begin)}


def write(capture):
    """Processor seconds of a Writer, from arrays that are there, and what numpy and Python allocate for each byte of them."""
    once, frames = writing(
        capture, 12, **{name: value for name, value in WRITTEN.items() if name != "frames"}
    )

    begin = time.process_time()
    once()
    seconds = time.process_time() - begin
    size = sum(
        array.nbytes
        for mesh, *pictures in frames
        for array in [*mesh, *(p for by_camera in pictures for p in by_camera.values())]
    )
    tracemalloc.start()
    once()
    _, peak = tracemalloc.get_traced_memory()
    return {"seconds": seconds, "extra_copies": peak / size}


def wheel_size(work):
    """MiB of the wheel, built with the packages of build/venv."""
    done = subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", work / "wheel", ROOT],
        capture_output=True,
        text=True,
    )
    if done.returncode:
        sys.exit(f"bench: the wheel was not built: {done.stderr[-2000:]}")
    return max((work / "wheel").glob("fvv-*.whl"), key=os.path.getmtime).stat().st_size / 2**20


def examples(build):
    """How many examples of hypothesis the package's tests pass, of the properties that are tried as often as they may."""
    tests = ROOT / "bindings/python/tests"
    environment = os.environ | {
        "PYTHONPATH": str(build / "bindings/python"),
        "FVV_TOOLS_DIR": str(build / "tools"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--hypothesis-show-statistics", "-k", "not types",
         *sorted(path for path in tests.glob("test_*.py") if "hypothesis" in path.read_text())],
        env=environment, cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    if done.returncode:
        sys.exit(f"bench: a property does not hold: {done.stdout[-2000:]}")
    return sum(map(int, re.findall(r"Stopped because settings.max_examples=(\d+)", done.stdout)))


def child(build, *arguments):
    """What this program prints with these arguments, in a process of its own."""
    environment = os.environ | {"PYTHONPATH": str(build / "bindings/python")}
    done = subprocess.run(
        [sys.executable, __file__, *map(str, arguments)], env=environment, capture_output=True, text=True
    )
    if done.returncode:
        sys.exit(f"bench: {arguments[0]} in Python failed: {done.stderr[-2000:]}")
    return json.loads(done.stdout)


def fvvmux_seconds(build, capture):
    """Processor seconds of fvvmux on what WRITTEN describes."""
    command = [build / "tools/fvvmux/fvvmux", capture, "-o", os.devnull]
    for name, value in WRITTEN.items():
        command += ["--" + name.replace("_", "-")] + ([] if value is True else [str(value)])
    running = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(running.pid, 0)
    if os.waitstatus_to_exitcode(status):
        sys.exit("bench: fvvmux failed")
    return usage.ru_utime + usage.ru_stime


def measure(c_read, build, work, stream, capture):
    """c_read: measures libfvv, ms of processor time. Both are measured in turns, and the least of each counts."""
    own, theirs = [], []
    for _ in range(RUNS):
        theirs.append(c_read())
        found = child(build, "read", stream)
        own.append(found["read_ms"])
    packed, muxed, wrote = [], [], []
    for _ in range(WRITES):
        packed.append(fvvmux_seconds(build, capture))
        muxed.append(child(build, "mux", capture)["seconds"])
        written = child(build, "write", capture)
        wrote.append(written["seconds"])
    return {
        "python.read_time_over_c": min(own) / min(theirs),
        "python.read_ms": min(own),
        "python.c_read_ms": min(theirs),
        "python.extra_copies": found["extra_copies"],
        "python.two_threads_speed": found["two_threads"],
        "python.write_time_over_fvvmux": max(min(muxed), min(wrote)) / min(packed),
        "python.mux_seconds": min(muxed),
        "python.write_seconds": min(wrote),
        "python.fvvmux_seconds": min(packed),
        "python.write_extra_copies": written["extra_copies"],
        "python.wheel_mib": wheel_size(work),
    }


if __name__ == "__main__":
    print(json.dumps({"read": times, "mux": mux, "write": write, "rate": rate}[sys.argv[1]](*sys.argv[2:])))
