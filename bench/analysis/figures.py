"""Rays and hierarchies of @fvv/analysis in Node (./run bench pick)."""

import json
import pathlib
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROCESSES = 5
FIGURES = {"first_build": "pick.first_build_ms", "build": "pick.build_ms", "ray": "pick.ray_ms"}


def picks(path):
    """Milliseconds for the hierarchy of a mesh and for a ray (pick.mjs): medians of new processes. pick.first_build_ms is
    that of the first mesh of a process."""
    if not shutil.which("node") or not (ROOT / "js/decoder/dist/core.wasm.js").exists():
        print("pick.* is left out: no node, or js/decoder was not built (./run bench js)")
        return {}
    runs = []
    for _ in range(PROCESSES):
        command = ["node", pathlib.Path(__file__).parent / "pick.mjs", path]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"bench: picks could not be measured: {done.stderr[-2000:]}")
        runs.append(json.loads(done.stdout))
    print(f"pick: {runs[0]['triangles']} triangles")
    return {name: statistics.median(run[of] for run in runs) for of, name in FIGURES.items()}
