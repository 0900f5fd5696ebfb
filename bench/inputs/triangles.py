"""How evenly triangles are spread over the groups of a stream: of the group that has most, over those of the median group.

With a stream as its only argument it prints that as JSON: the package is on PYTHONPATH then.
"""

import json
import os
import pathlib
import statistics
import subprocess
import sys


def of_groups(path):
    """Triangles a frame of each second, which is a group of the demo."""
    import fvv

    seconds = {}
    with fvv.open(path) as clip:
        for frame in clip:
            seconds.setdefault(int(frame.time), []).append(frame.mesh.face_count)
    return [statistics.mean(counts) for counts in seconds.values()]


def measure(build, path):
    """path: the stream that ./run demo packs; nothing where it is missing."""
    if not pathlib.Path(path).exists():
        print(
            f"bench: triangles of the demo: skipped: {path} is missing: ./run demo --no-serve makes it",
            file=sys.stderr,
        )
        return {}
    environment = os.environ | {"PYTHONPATH": str(build / "bindings/python")}
    done = subprocess.run(
        [sys.executable, __file__, str(path)], env=environment, capture_output=True, text=True
    )
    if done.returncode:
        sys.exit(f"bench: {path} could not be read: {done.stderr[-2000:]}")
    triangles = json.loads(done.stdout)
    return {
        "demo.triangles_median": statistics.median(triangles),
        "demo.triangles_max_over_median": max(triangles) / statistics.median(triangles),
    }


if __name__ == "__main__":
    print(json.dumps(of_groups(sys.argv[1])))
