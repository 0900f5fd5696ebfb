"""Meshes: bytes against error and against time, of fvv's profiles and of other codecs on the same meshes in the same run.

`mesh` has two kinds of sequence. Hulls have other faces in every frame, so each mesh is coded by itself. Tracked meshes keep their
faces, so that motion can be coded. Errors are surface to surface, as fvvcompare measures them: rms and p99 of the worse direction.
"""

import json
import shutil
import statistics
import subprocess

import codecs_table
import mesh_only
import numpy as np
from real_capture import read_ply

from . import drawing, lab, numbers, system, trajectories

ALONE_FRAMES = 3
TRACKED_FRAMES = 50
GROUP = 25
STEPS = 0.25, 0.5, 1, 2  # mm
BITS = 8, 9, 10, 11, 12
BUDGETS = 0.5, 1, 2, 4, 8  # mm
MOTION = 0.25, 0.5, 1, 2  # mm
DELTA_STEPS = 0.5, 1, 2  # mm, of the quantiser
PROCESSES = 5
DEFAULT_LEVEL = 9
STEP = 1  # mm, of times


def codecs(mode, files, numbers_, real=None):
    """Rows of fvvcodecs. real: (height, axis) to which a real sequence is scaled."""
    option = "--bits" if mode == "peers" else "--step"
    scale = ("--height", real[0], "--up", codecs_table.AXES[real[1]]) if real else ()
    return json.loads(lab.run("fvvcodecs", mode, *scale, option, ",".join(map(str, numbers_)), *files).output)


def files_of(capture, count):
    return sorted((capture / "meshes").iterdir())[:count]


def compared(source, stream, frames):
    """rms and p99 in mm, the worse of both directions."""
    found = lab.answer("fvvcompare", source, stream, "--frames", f"0-{frames - 1}", "--threads", 1)["distance"]
    worst = max((found["a_to_b"], found["b_to_a"]), key=lambda d: d["rms"])
    return {"rms_mm": 1000 * worst["rms"], "p99_mm": 1000 * worst["p99"]}


def packed_meshes(source, frames, *options):
    return lab.packed(source, "--no-pictures", "--frames", f"0-{frames - 1}", *options)


def decimated(source, frames):
    """Draco at its default level, after decimation to several budgets."""
    rows = []
    for budget in BUDGETS:
        made = packed_meshes(source, frames, "--max-error", f"{budget}mm", "--no-delta")
        timed = json.loads(lab.run("fvvbench", "draco", made.path).output)
        row = {"setting": f"budget {budget} mm", "bytes_per_frame": made.summary["mesh"]["bytes"] / frames}
        row |= {"triangles": timed["draco.triangles"], "decode_ms": timed["draco.decode_ms"]}
        rows.append(row | {"encode_ms": timed["draco.encode_ms"]} | compared(source, made.path, frames))
    return rows


def alone(source, frames=ALONE_FRAMES, steps=STEPS, bits=BITS):
    files = files_of(source, frames)
    rows = codecs("key", files, steps) + codecs("peers", files, bits)
    return {"rows": rows, "decimated": decimated(source, frames) if len(steps) > 1 else []}


def estimated(source, meshes, targets):
    """Principal components of each group; each target is the error of the vertices, what is reported that of the surface."""
    positions = np.array([vertices for vertices, _ in meshes])
    faces = meshes[0][1]
    groups = [trajectories.Group(positions[i : i + GROUP], faces) for i in range(0, len(positions), GROUP)]
    rows = []
    for target in targets:
        found = [group.best(target / 1000) for group in groups]
        if None in found:
            continue
        decoded = np.concatenate([f[1] for f in found])
        folder = lab.WORK / "estimates" / lab.short(source, *(f[0] for f in found))
        capture = mesh_only.write_capture(folder, [(p, faces) for p in decoded])
        made = lab.packed(capture, "--mesh-profile", "raw", "--keep-geometry", "--step", "0.02mm")
        rows.append(
            {
                "vertex_rms_mm": target,
                "components": [f[2] for f in found],
                "bytes_per_frame": sum(f[0] for f in found) / len(positions),
                **compared(source, made.path, len(positions)),
            }
        )
    return rows


def tracked(source, meshes, files, real=None):
    """Whole streams in groups of GROUP frames: motion, and every mesh by itself."""
    frames = len(meshes)
    out = {"delta": [], "draco": []}
    for budget in MOTION:
        options = "--keep-geometry", "--max-error", f"{budget}mm", "--group", GROUP
        for name, more in ("delta", ()), ("draco", ("--no-delta",)):
            made = packed_meshes(source, frames, *options, *more)
            row = {"max_error_mm": budget, "bytes_per_frame": made.summary["mesh"]["bytes"] / frames}
            out[name].append(row | compared(source, made.path, frames))
    out["vertices"] = len(meshes[0][0])
    out["pca"] = estimated(source, meshes, [r["rms_mm"] * 1.3 for r in out["delta"]])
    out["times"] = codecs("delta", files[:GROUP], DELTA_STEPS, real)
    return out


def node(what, path):
    done = subprocess.run(["node", lab.ROOT / "bench/decoder.mjs", what, path], capture_output=True, text=True)
    if done.returncode:
        raise lab.Failed(["node", what], done.returncode, done.stderr.strip())
    return json.loads(done.stdout)


def times(hulls, moving):
    """First call of a process and later ones, by libfvv and by its build for browsers; medians of new processes."""
    browser = shutil.which("node") and (lab.ROOT / "js/decoder/dist/core.wasm.js").exists()
    if not browser:
        lab.left_out("mesh: times of the browser's decoder", "no node, or js/decoder was not built")
    out = {}
    for name in "raw", "draco", "fast", "delta":
        source, options = (hulls, ("--mesh-profile", name, "--no-delta")) if name != "delta" else (moving, ())
        frames = ALONE_FRAMES if name != "delta" else GROUP
        path = packed_meshes(source, frames, "--keep-geometry", "--step", f"{STEP}mm", *options).path
        row = {}
        if name != "delta":
            runs = [json.loads(lab.run("fvvbench", "first", path).output) for _ in range(PROCESSES)]
            row |= {f"native_{k}": statistics.median(r[k] for r in runs) for k in ("first_ms", "again_ms")}
        else:
            row["native_again_ms"] = json.loads(lab.run("fvvbench", "delta", path).output)["delta.decode_ms"]
        if browser:
            if name != "delta":
                row["wasm_first_ms"] = statistics.median(node("first", path)["first_ms"] for _ in range(PROCESSES))
            row["wasm_again_ms"] = node("warm", path)["key_ms" if name != "delta" else "delta_ms"]
        out[name] = row
    if browser and (lab.ROOT / "js/node_modules/draco3d").exists():
        path = packed_meshes(hulls, ALONE_FRAMES, "--keep-geometry", "--step", f"{STEP}mm", "--no-delta").path
        both = node("beside", path)
        first = statistics.median(node("draco3d", path)["first_ms"] for _ in range(PROCESSES))
        out["draco3d"] = {"wasm_first_ms": first, "wasm_again_ms": both["draco3d_ms"]}
        out["draco_over_draco3d"] = both["ratio"]
    return out


def measure(quick):
    hulls = system.clip("hull", system.QUICK_FRAMES if quick else system.FRAMES)
    if quick:
        return quick_figures(hulls)
    moving = lab.capture("one-camera", "--rig", "small", "--meshes", "tracked", "--cameras", 1, "--frames", TRACKED_FRAMES)
    files = files_of(moving, TRACKED_FRAMES)
    out = {
        "alone": {"hulls": alone(hulls)},
        "tracked": {"players": tracked(moving, [read_ply(f) for f in files], files)},
        "times": times(hulls, moving),
        "group": GROUP,
    }
    for name, pattern, axis, same_faces in codecs_table.SEQUENCES:
        if name not in ("basketball", "crane"):
            continue
        found = codecs_table.found(pattern, lab.WORK / "sequences" / name)
        real = codecs_table.HEIGHT, axis
        if not found:
            lab.left_out(f"mesh: {name}", f"no {pattern} under FVV_DATA={lab.DATA}")
        elif same_faces:
            meshes = mesh_only.scaled(found, axis)
            capture = mesh_only.write_capture(lab.WORK / "captures" / name, meshes)
            out["tracked"][name] = tracked(capture, meshes, found, real)
        else:
            rows = codecs("key", found[:1], STEPS, real) + codecs("peers", found[:1], BITS, real)
            out["alone"][name] = {"rows": rows, "decimated": []}
    return out


def quick_figures(hulls):
    """Of two hulls on a lattice of 1 mm, and of four frames of motion."""
    rows = {f"{r['codec']} {r['setting']}".strip(): r for r in codecs("key", files_of(hulls, 2), (STEP,))}
    moving = system.clip("tracked", system.QUICK_FRAMES)
    delta = codecs("delta", files_of(moving, system.QUICK_FRAMES), (STEP,))
    return {"alone": rows, "delta": next(r for r in delta if r["setting"].endswith("+- 1"))}


def headlines(results):
    rows, delta = results["alone"], results["delta"]
    draco, fast = rows["draco level 9"], rows["fast"]
    return {
        "draco_bits_per_vertex": draco["bits_per_vertex"],
        "draco_bytes_over_libdraco": draco["bytes_per_frame"] / rows["libdraco level 10, same lattice"]["bytes_per_frame"],
        "fast_bytes_over_draco": fast["bytes_per_frame"] / draco["bytes_per_frame"],
        "fast_decode_time_over_draco": fast["decode_ms"] / draco["decode_ms"],
        "delta_bits_per_vertex": delta["bits_per_vertex"],
        "delta_rms_mm": delta["rms_mm"],
    }
