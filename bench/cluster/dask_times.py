"""A stream from the workers of Dask: whether its bytes are those of one run, groups a second with one and two workers, 200 orders
of failures and deaths, and, as a simulation on these times, an hour of 20 cameras with up to 256 workers.

With a folder as its only argument it measures there and prints what it found, as JSON: the package is on PYTHONPATH then.
"""

import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
ORDERS = 200
CAMERAS, FRAMES, GROUP = 20, 61, 3  # the first group comes with the plan: 20 tasks
SECOND, HOUR = 25, 3600
WORKERS = (16, 32, 64, 128, 256)


def measure(tool, build, work):
    """tool: runs one of the build's. Other processes of the machine disturb the speedup; what is simulated is from processor
    time, but for merging."""
    folder = work / "cluster"
    if not (folder / "capture/capture.json").exists():
        tool("fvvsynth", "-o", folder / "capture", "--rig", "small", "--cameras", CAMERAS, "--frames", FRAMES)
    environment = os.environ | {
        "PYTHONPATH": str(build / "bindings/python"),
        "FVV_TOOLS_DIR": str(build / "tools"),
    }

    def figures(*command):
        done = subprocess.run([sys.executable, *command], env=environment, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"bench: encoding with Dask failed: {done.stderr[-2000:]}")
        return json.loads(done.stdout)

    found = figures(__file__, folder)
    with tempfile.TemporaryDirectory() as orders:
        return found | figures(ROOT / "bindings/python/tests/cluster/cluster_orders.py", str(ORDERS), orders)


def nothing(number):
    return number


class Clock:
    """When progress was reported. kill: a worker dies when some groups are done."""

    def __init__(self, client=None):
        self.times = []
        self.client = client
        self.pids = client.run(os.getpid) if client else {}

    def __call__(self, done, _):
        self.times.append(time.monotonic())
        if self.client and len(self.times) == 5:
            busy = [worker for worker, keys in self.client.processing().items() if keys]
            os.kill(self.pids[busy[0]], signal.SIGKILL)

    def groups_per_second(self):
        """From the end of planning to the last group."""
        return (len(self.times) - 1) / (self.times[-1] - self.times[0])


def overhead(client, count=500):
    """Seconds of an empty task, of which there are many."""
    executor = client.get_executor(pure=False)
    executor.submit(nothing, 0).result()
    begin = time.monotonic()
    for task in [executor.submit(nothing, i) for i in range(count)]:
        task.result()
    return (time.monotonic() - begin) / count


def processor_seconds(work, *arguments):
    begin = time.process_time()
    work(*arguments)
    return time.process_time() - begin


def planning(capture, first):
    """Seconds to plan any stream of this capture by groups of a second on all cores of this machine, and more for each frame."""
    from fvv import _core

    def plan(frames, group):
        options = {"group": str(group), "frames": f"0-{frames - 1}"}
        return processor_seconds(_core.PartPlan.make, str(capture), [], options, first)

    each = max(0.0, (plan(60, 10) - plan(30, 10)) / 30)  # samples have the same size
    return (plan(FRAMES, SECOND) - each * FRAMES) / os.cpu_count(), each / os.cpu_count()


def encoding(capture, first, count=12):
    """Seconds of some groups, each on one core."""
    from fvv import _core

    plan = _core.PartPlan.make(str(capture), [], {"group": str(GROUP)}, first)
    return [processor_seconds(plan.encode, i, 1, first) for i in range(1, 1 + count)]


def main(folder):
    import distributed
    import fvv
    import fvv.distributed
    import simulation

    capture, out = folder / "capture", folder / "out.fvv"
    fvv.mux(capture, out, group=GROUP, force=True)
    whole = out.read_bytes()
    rates, found, identical = {}, {}, True
    for workers in 1, 2:
        with (
            distributed.LocalCluster(
                n_workers=workers, threads_per_worker=1, dashboard_address=None
            ) as local,
            distributed.Client(local) as client,
        ):
            clock = Clock()
            client.run(__import__, "fvv.distributed")
            found[workers] = fvv.distributed.mux(
                capture, out, client, group=GROUP, force=True, progress=clock
            )
            rates[workers] = clock.groups_per_second()
            identical = identical and out.read_bytes() == whole
            if workers == 2:
                cost = overhead(client)
                fvv.distributed.mux(capture, out, client, group=GROUP, force=True, progress=Clock(client))
                identical = identical and out.read_bytes() == whole
    first, each = planning(capture, str(folder / "first.fvv"))
    tasks = encoding(capture, str(folder / "first.fvv"))
    merge_each = found[1]["seconds"]["merge"] / found[1]["bytes"]
    bytes_of_hour = found[1]["bytes"] / FRAMES * SECOND * HOUR
    figures = {
        "dask.identical": int(identical),
        "dask.groups_per_second_1": rates[1],
        "dask.groups_per_second_2": rates[2],
        "dask.speedup_2": rates[2] / rates[1],
        "dask.overhead_ms": 1e3 * cost,
        "dask.frame_seconds": sum(tasks) / len(tasks) / GROUP,
        "dask.plan_seconds": first,
        "dask.plan_frame_ms": 1e3 * each,
        "dask.merge_mib_per_second": 1 / merge_each / 2**20,
    }
    hour = simulation.draw(tasks, HOUR, math.ceil(SECOND / GROUP))
    plan, merge = first + each * SECOND * HOUR, merge_each * bytes_of_hour
    figures |= {"dask.simulated_plan_minutes": plan / 60, "dask.simulated_merge_minutes": merge / 60}
    figures |= simulation.figures(hour, plan, merge, cost, WORKERS)
    print(json.dumps(figures))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
