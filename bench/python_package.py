"""The Python package: the time to read all meshes of a stream beside libfvv's, copies, and the size of the wheel.

With a stream as its only argument it reads that and prints what it took, as JSON: the package is on PYTHONPATH then.
"""

import json
import os
import pathlib
import subprocess
import sys
import threading
import time
import tracemalloc

ROOT = pathlib.Path(__file__).resolve().parent.parent
RUNS = 5


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


def measure(c_read, build, work, stream):
    """c_read: measures libfvv, ms of processor time. Both are measured in turns, and the least of each counts."""
    environment = os.environ | {"PYTHONPATH": str(build / "bindings/python")}
    own, theirs = [], []
    for _ in range(RUNS):
        theirs.append(c_read())
        done = subprocess.run(
            [sys.executable, __file__, stream], env=environment, capture_output=True, text=True
        )
        if done.returncode:
            sys.exit(f"bench: reading in Python failed: {done.stderr[-2000:]}")
        found = json.loads(done.stdout)
        own.append(found["read_ms"])
    return {
        "python.read_time_over_c": min(own) / min(theirs),
        "python.read_ms": min(own),
        "python.c_read_ms": min(theirs),
        "python.extra_copies": found["extra_copies"],
        "python.two_threads_speed": found["two_threads"],
        "python.wheel_mib": wheel_size(work),
    }


if __name__ == "__main__":
    print(json.dumps(times(sys.argv[1])))
