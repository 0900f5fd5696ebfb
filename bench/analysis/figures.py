"""@fvv/analysis in Node: rays and hierarchies (./run bench pick), and how far its figures are off (./run bench measure)."""

import json
import pathlib
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROCESSES = 5
FIGURES = {"first_build": "pick.first_build_ms", "build": "pick.build_ms", "ray": "pick.ray_ms"}


def can_run(part):
    if shutil.which("node") and (ROOT / "js/decoder/dist/core.wasm.js").exists():
        return True
    print(f"{part}.* is left out: no node, or js/decoder was not built (./run bench js)")
    return False


def node(script, *paths):
    command = ["node", pathlib.Path(__file__).parent / script, *paths]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"bench: {script} failed: {done.stderr[-2000:]}")
    return json.loads(done.stdout)


def tools_bytes():
    """What a page loads for the attribute `tools` of <fvv-player>, with brotli."""
    if not can_run("analysis"):
        return {}
    if not (ROOT / "js/node_modules/esbuild").exists():
        print("analysis.* is left out: no esbuild (npm ci in js)")
        return {}
    return {"analysis.brotli_bytes": node(ROOT / "js/player/sizes.mjs")["brotli"]}


def measured(tool, work):
    """Centres of objects, picked places, heights and speeds of the practice scene, packed with errors of 0.05 to 1 px, beside its unchanged meshes
    (measure.mjs). The figures are those of the default error; coverage is that of the kind with the least."""
    if not can_run("measure"):
        return {}
    capture, exact, packed = work / "measured", work / "measured-exact.fvv", work / "measured.fvv"
    if not (capture / "capture.json").exists():
        tool("fvvsynth", "-o", capture, "--rig", "small", "--frames", 26, "--force")
    every = capture, "--no-pictures", "--objects", "auto", "--force"
    tool("fvvmux", *every, "-o", exact, "--keep-geometry", "--step", "0.1mm")
    print(f"{'measure':10}{'pixels':>8}{'count':>8}{'rms':>10}{'held %':>9}{'width/rms':>11}")
    found = {}
    for pixels in (0.05, 0.5, 1, 0.15):
        tool("fvvmux", *every, "-o", packed, "--max-error", pixels)
        found = node("measure.mjs", exact, packed)
        for kind, one in found.items():
            row = f"{pixels:8}{one['count']:8}{one['rms']:10.5f}{one['coverage']:9.1f}{one['width']:11.2f}"
            print(f"{kind:10}{row}")
    return {
        "measure.distance_error_mm": 1000 * found["centres"]["rms"],
        "measure.speed_error_percent": 100 * found["speeds"]["relative"],
        "measure.coverage_percent": min(one["coverage"] for one in found.values()),
    }


def picks(path):
    """Milliseconds for the hierarchy of a mesh and for a ray (pick.mjs): medians of new processes. pick.first_build_ms is
    that of the first mesh of a process."""
    if not can_run("pick"):
        return {}
    runs = [node("pick.mjs", path) for _ in range(PROCESSES)]
    print(f"pick: {runs[0]['triangles']} triangles")
    return {name: statistics.median(run[of] for run in runs) for of, name in FIGURES.items()}
