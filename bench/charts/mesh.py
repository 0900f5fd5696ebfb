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

from . import drawing, experiment, numbers, system, trajectories

ALONE_FRAMES = 3
TRACKED_FRAMES = 50
GROUP = 25
STEPS = 0.25, 0.5, 1, 2  # mm
BITS = 8, 9, 10, 11, 12
BUDGETS = 0.5, 1, 2, 4, 8  # mm
MOTION = 0.25, 0.5, 1, 2  # mm
DELTA_STEPS = 0.5, 1, 2  # mm, of the quantiser
PROCESSES = 5
QUICK_RUNS = 3
SAMPLES = 10000  # of each surface, besides its vertices
DEFAULT_LEVEL = 9
STEP = 1  # mm, of times
SPACING = 1.32  # of labels, on a logarithmic axis


def codecs(mode, files, numbers_, real=None):
    """Rows of fvvcodecs. real: (height, axis) to which a real sequence is scaled."""
    option = "--bits" if mode == "peers" else "--step"
    scale = ("--height", real[0], "--up", codecs_table.AXES[real[1]]) if real else ()
    return json.loads(
        experiment.run("fvvcodecs", mode, *scale, option, ",".join(map(str, numbers_)), *files).output
    )


def files_of(capture, count):
    return sorted((capture / "meshes").iterdir())[:count]


def compared(source, stream, frames):
    """rms and p99 in mm, the worse of both directions."""
    options = "--frames", f"0-{min(frames, GROUP) - 1}", "--samples", SAMPLES, "--threads", 1
    key = experiment.digest_of(experiment.program("fvvcompare")), source, stream, *options
    found = experiment.kept(
        "compared", key, lambda: experiment.answer("fvvcompare", source, stream, *options)["distance"]
    )
    worst = max((found["a_to_b"], found["b_to_a"]), key=lambda d: d["rms"])
    return {"rms_mm": 1000 * worst["rms"], "p99_mm": 1000 * worst["p99"]}


def packed_meshes(source, frames, *options):
    return experiment.packed(source, "--no-pictures", "--frames", f"0-{frames - 1}", *options)


def decimated(source, frames):
    """Draco at its default level, after decimation to several budgets."""
    rows = []
    for budget in BUDGETS:
        made = packed_meshes(source, frames, "--max-error", f"{budget}mm", "--no-delta")
        timed = json.loads(experiment.run("fvvbench", "draco", made.path).output)
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
        folder = experiment.WORK / "estimates" / experiment.short(source, *(f[0] for f in found))
        capture = mesh_only.write_capture(folder, [(p, faces) for p in decoded])
        made = experiment.packed(capture, "--mesh-profile", "raw", "--keep-geometry", "--step", "0.02mm")
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
    done = subprocess.run(
        ["node", experiment.ROOT / "bench/decoder.mjs", what, path], capture_output=True, text=True
    )
    if done.returncode:
        raise experiment.Failed(["node", what], done.returncode, done.stderr.strip())
    return json.loads(done.stdout)


def times(hulls, moving):
    """First call of a process and later ones, by libfvv and by its build for browsers; medians of new processes."""
    browser = shutil.which("node") and (experiment.ROOT / "js/decoder/dist/core.wasm.js").exists()
    if not browser:
        experiment.left_out("mesh: times of the browser's decoder", "no node, or js/decoder was not built")
    out = {}
    for name in "raw", "draco", "fast", "delta":
        source, options = (hulls, ("--mesh-profile", name, "--no-delta")) if name != "delta" else (moving, ())
        frames = ALONE_FRAMES if name != "delta" else GROUP
        path = packed_meshes(source, frames, "--keep-geometry", "--step", f"{STEP}mm", *options).path
        row = {}
        if name != "delta":
            runs = [json.loads(experiment.run("fvvbench", "first", path).output) for _ in range(PROCESSES)]
            row |= {f"native_{k}": statistics.median(r[k] for r in runs) for k in ("first_ms", "again_ms")}
        else:
            row["native_again_ms"] = json.loads(experiment.run("fvvbench", "delta", path).output)[
                "delta.decode_ms"
            ]
        if browser:
            if name != "delta":
                row["wasm_first_ms"] = statistics.median(
                    node("first", path)["first_ms"] for _ in range(PROCESSES)
                )
            row["wasm_again_ms"] = node("warm", path)["key_ms" if name != "delta" else "delta_ms"]
        out[name] = row
    if browser and (experiment.ROOT / "js/node_modules/draco3d").exists():
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
    moving = experiment.capture(
        "one-camera", "--rig", "small", "--meshes", "tracked", "--cameras", 1, "--frames", TRACKED_FRAMES
    )
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
        found = codecs_table.found(pattern, experiment.WORK / "sequences" / name)
        real = codecs_table.HEIGHT, axis
        if not found:
            experiment.left_out(f"mesh: {name}", f"no {pattern} under FVV_DATA={experiment.DATA}")
        elif same_faces:
            meshes = mesh_only.scaled(found, axis)
            capture = mesh_only.write_capture(experiment.WORK / "captures" / name, meshes)
            out["tracked"][name] = tracked(capture, meshes, found, real)
        else:
            rows = codecs("key", found[:1], STEPS, real) + codecs("peers", found[:1], BITS, real)
            out["alone"][name] = {"rows": rows, "decimated": []}
    return out


def quick_figures(hulls):
    """Of two hulls on a lattice of 1 mm, and of four frames of motion; times are the least of several runs."""
    files = files_of(hulls, 2)
    rows = {}
    for _ in range(QUICK_RUNS):
        for r in codecs("key", files, (STEP,)):
            row = rows.setdefault(f"{r['codec']} {r['setting']}".strip(), r)
            row["decode_ms"] = min(row["decode_ms"], r["decode_ms"])
    moving = system.clip("tracked", system.QUICK_FRAMES)
    delta = codecs("delta", files_of(moving, system.QUICK_FRAMES), (STEP,))
    return {"alone": rows, "delta": next(r for r in delta if r["setting"].endswith("+- 1"))}


def headlines(results):
    rows, delta = results["alone"], results["delta"]
    draco, fast = rows["draco level 9"], rows["fast"]
    return {
        "draco_bits_per_vertex": draco["bits_per_vertex"],
        "draco_bytes_over_libdraco": draco["bytes_per_frame"]
        / rows["libdraco level 10, same lattice"]["bytes_per_frame"],
        "fast_bytes_over_draco": fast["bytes_per_frame"] / draco["bytes_per_frame"],
        "fast_decode_time_over_draco": fast["decode_ms"] / draco["decode_ms"],
        "delta_bits_per_vertex": delta["bits_per_vertex"],
        "delta_rms_mm": delta["rms_mm"],
    }


def nearest(rows, codec, setting, step=STEP):
    """The row of a codec whose step is nearest to step, in mm; setting: how its setting begins."""
    rows = [r for r in rows if r["codec"] == codec and r["setting"].startswith(setting)]
    return min(rows, key=lambda r: abs(np.log(r["step_mm"] / step)))


# Codec and setting as fvvcodecs names them, and the name in charts.
ALONE = (
    ("draco", f"level {DEFAULT_LEVEL}", "fvv, draco (default)"),
    ("fast", "", "fvv, fast"),
    ("raw", "", "fvv, raw"),
    ("libdraco", "level 10, ", "Draco q8 to q12, level 10"),
    ("meshoptimizer", "zstd", "meshoptimizer, then zstd"),
    ("meshoptimizer", "alone", "meshoptimizer"),
)


def series(rows, codec, setting):
    """Rows of one line of the chart, by error."""

    def wanted(r):
        if r["codec"] == "meshoptimizer":
            return ("zstd" in r["setting"]) == (setting == "zstd")
        return r["setting"].startswith(setting) and "lattice" not in r["setting"]

    chosen = [r for r in rows if r["codec"] == codec and wanted(r)]
    if codec == "libdraco":  # those of "peers", which have other bits than those beside the lattice
        chosen = [r for r in chosen if int(r["setting"].split()[-2]) in BITS]
    return sorted({r["rms_mm"]: r for r in chosen}.values(), key=lambda r: r["rms_mm"])


def draw_errors(results, folder):
    names = [*results["alone"], *results["tracked"]]
    figure, panels = drawing.sheet(2, -(-len(names) // 2), 4.6, 3.5)
    titles = {
        "hulls": "Hulls, each mesh by itself",
        "players": f"Tracked players, groups of {results['group']} frames",
        "basketball": "tvm_basketball_player (real), one mesh",
        "crane": f"crane (real), groups of {results['group']} frames",
    }
    panels = iter(panels)
    for name, found in results["alone"].items():
        axis, points = next(panels), []
        for number, (codec, setting, label) in enumerate(ALONE):
            rows = series(found["rows"], codec, setting)
            points += [(r["rms_mm"], r["bytes_per_frame"] / 1000) for r in rows]
            drawing.line(
                axis, number, [r["rms_mm"] for r in rows], [r["bytes_per_frame"] / 1000 for r in rows], label
            )
        if found["decimated"]:
            rows = found["decimated"]
            points += [(r["rms_mm"], r["bytes_per_frame"] / 1000) for r in rows]
            drawing.line(axis, 6, [r["rms_mm"] for r in rows], [r["bytes_per_frame"] / 1000 for r in rows],
                         f"fvv, budgets of {BUDGETS[0]:g} to {BUDGETS[-1]:g} mm")  # fmt: skip
        pareto = numbers.pareto(points)
        axis.plot(*zip(*pareto), color=drawing.YELLOW, linewidth=7, alpha=0.35, zorder=0, label="Pareto line")
        axis.set_title(titles[name])
    for name, found in results["tracked"].items():
        axis, points = next(panels), []
        for number, (kind, label) in enumerate(
            (
                ("draco", "fvv, each mesh by itself"),
                ("delta", "fvv, motion (default)"),
                ("pca", "principal components, an estimate"),
            )
        ):
            rows = sorted(found[kind], key=lambda r: r["rms_mm"])
            points += [(r["rms_mm"], r["bytes_per_frame"] / 1000) for r in rows]
            drawing.line(
                axis, number, [r["rms_mm"] for r in rows], [r["bytes_per_frame"] / 1000 for r in rows], label
            )
        axis.plot(
            *zip(*numbers.pareto(points)),
            color=drawing.YELLOW,
            linewidth=7,
            alpha=0.35,
            zorder=0,
            label="Pareto line",
        )
        axis.set_title(titles[name])
    for axis in figure.axes[: len(names)]:
        drawing.logarithmic(axis, "x", (0.1, 0.2, 0.5, 1, 2, 5))
        drawing.logarithmic(axis, "y", (1, 2, 5, 10, 20, 50, 100, 200, 500))
        axis.set_xlabel("rms error of the surface, mm")
        axis.set_ylabel("kB per frame")
        axis.legend(fontsize=7)
    for axis in panels:
        axis.remove()
    drawing.save(figure, folder / "mesh-error.svg")


def at_one_step(results):
    """Of hulls on steps of about 1 mm: label, row."""
    rows = results["alone"]["hulls"]["rows"]
    out = []
    for codec, setting, label in (
        ("raw", "", "fvv, raw"),
        ("fast", "", "fvv, fast"),
        ("draco", "level 0", "fvv, draco, level 0"),
        ("draco", "level 5", "fvv, draco, level 5"),
        ("draco", f"level {DEFAULT_LEVEL}", f"fvv, draco, level {DEFAULT_LEVEL} (default)"),
        ("draco", "level 10", "fvv, draco, level 10"),
    ):
        out.append((label, nearest(rows, codec, setting)))
    for level in 1, 7, 10:
        chosen = series(
            [r for r in rows if r["setting"].startswith(f"level {level}, ")], "libdraco", f"level {level}, "
        )
        out.append((f"Draco, level {level}", min(chosen, key=lambda r: abs(np.log(r["step_mm"] / STEP)))))
    for setting, label in ("alone", "meshoptimizer"), ("zstd", "meshoptimizer, zstd 19"):
        chosen = series(rows, "meshoptimizer", setting)
        out.append((label, min(chosen, key=lambda r: abs(np.log(r["step_mm"] / STEP)))))
    moving = min(
        results["tracked"]["players"]["times"],
        key=lambda r: (abs(r["step_mm"] - STEP), not r["setting"].endswith("+- 1")),
    )
    out.append(("fvv, motion", moving))
    return out


def speed(row, what, triangles):
    """Million triangles a second."""
    return triangles / row[f"{what}_ms"] / 1000


def triangles_of(results, label):
    return 2 * (
        results["tracked"]["players"]["vertices"]
        if label == "fvv, motion"
        else vertices_of(results["alone"]["hulls"]["rows"][0])
    )


def vertices_of(row):
    return 8 * row["bytes_per_frame"] / row["bits_per_vertex"]


def draw_speed(results, axis, what):
    """Labels of the many points between 10 and 60 bits are in a column beside them, at least SPACING apart."""
    points = []
    for label, row in at_one_step(results):
        points.append((speed(row, what, triangles_of(results, label)), row["bits_per_vertex"], label))
    below = np.inf
    for y, x, label in sorted(points, reverse=True):
        own = label.startswith("fvv")
        colour = drawing.BLUE if own else drawing.RED
        axis.plot(x, y, marker="o" if own else "s", color=colour, linestyle="")
        if 10 < x < 60:
            below = min(y * SPACING, below / SPACING)
            axis.annotate(label, (x, y), (75, below), fontsize=7.5, color=colour, va="center",
                          arrowprops={"arrowstyle": "-", "linewidth": 0.6, "color": "#999999", "shrinkB": 3})  # fmt: skip
        else:
            drawing.words(
                axis, x, y, label, (-7, -3) if x > 60 else (6, 3), colour, ha="right" if x > 60 else "left"
            )
    drawing.logarithmic(axis, "x", (1, 2, 5, 10, 20, 50, 100, 200))
    drawing.logarithmic(axis, "y")
    axis.set_xlim(1, 400)
    axis.set_ylim(below / SPACING)
    axis.set_xlabel("bits per vertex")
    axis.set_ylabel("million triangles per second, one thread")


def draw_times(results, axis):
    found = {n: row for n, row in results["times"].items() if isinstance(row, dict)}
    bars = (("native_first_ms", "libfvv, first"), ("native_again_ms", "libfvv, later"), ("wasm_first_ms", "browser, first"),
            ("wasm_again_ms", "browser, later"))  # fmt: skip
    for number, (key, label) in enumerate(bars):
        at = [i + 0.2 * (number - 1.5) for i, row in enumerate(found.values()) if key in row]
        heights = [row[key] for row in found.values() if key in row]
        axis.bar(at, heights, 0.18, color=drawing.COLOURS[number], label=label)
        for x, height in zip(at, heights):
            drawing.words(
                axis, x, height, f"{height:.2g}" if height < 10 else f"{height:.0f}", (0, 2), ha="center"
            )
    axis.set_xticks(range(len(found)), found)
    drawing.logarithmic(axis, "y", (0.1, 1, 10))
    axis.set_ylim(top=axis.get_ylim()[1] * 8)
    axis.set_ylabel("ms for a mesh")
    axis.set_title("First of a process and later ones")
    axis.legend(ncols=2, loc="upper right")


def draw(results, folder):
    draw_errors(results, folder)
    figure, panels = drawing.sheet(1, 1, 6.4, 3.8)
    draw_speed(results, panels[0], "decode")
    panels[0].set_title(f"Decoding meshes on a lattice of {STEP} mm")
    drawing.save(figure, folder / "mesh-decode.svg")
    figure, panels = drawing.sheet(2, 1, 4.9, 3.6)
    draw_speed(results, panels[0], "encode")
    panels[0].set_title("Encoding")
    draw_times(results, panels[1])
    drawing.save(figure, folder / "mesh-time.svg")


def table(results):
    lines = [
        "| codec | step, mm | bytes per frame | bits per vertex | rms, mm | p99, mm | encode, ms | decode, ms |"
    ]
    lines.append("|---|---|---|---|---|---|---|---|")
    for label, r in at_one_step(results):
        lines.append(
            f"| {label} | {r['step_mm']:.2f} | {r['bytes_per_frame']:,.0f} | {r['bits_per_vertex']:.1f} | {r['rms_mm']:.2f} "
            f"| {r['p99_mm']:.2f} | {r['encode_ms']:.2f} | {r['decode_ms']:.2f} |"
        )
    return "\n".join(lines)


def against_pca(found):
    """Bytes of motion over those of principal components at the same error."""
    ratio = numbers.bd_rate([(r["bytes_per_frame"], -np.log10(r["rms_mm"])) for r in found["pca"]],
                            [(r["bytes_per_frame"], -np.log10(r["rms_mm"])) for r in found["delta"]])  # fmt: skip
    return None if ratio is None else 1 + ratio / 100


def text(results):
    rows = dict(at_one_step(results))
    default, other = rows[f"fvv, draco, level {DEFAULT_LEVEL} (default)"], rows["Draco, level 10"]
    fast, motion, zstd = rows["fvv, fast"], rows["fvv, motion"], rows["meshoptimizer, zstd 19"]
    pca = {name: ratio for name, f in results["tracked"].items() if (ratio := against_pca(f))}
    said = " and ".join(f"{ratio:.2f} ({name})" for name, ratio in pca.items())
    timed = results["times"]
    browser = ""
    if "draco_over_draco3d" in timed:
        browser = (
            f"In a browser's engine (Node) a draco mesh takes {timed['draco_over_draco3d']:.2f} of the time of npm's draco3d, frame by frame in "
            f"turns. The first call of a process takes {timed['draco']['wasm_first_ms']:.0f} ms against {timed['draco3d']['wasm_first_ms']:.0f}. "
        )
    return f"""![Million triangles decoded per second over bits per vertex](mesh-decode.svg)

**Coded by itself a mesh takes {default['bits_per_vertex']:.0f} bits per vertex and decodes at {speed(default, 'decode', triangles_of(results, '')):.0f} million
triangles per second; motion takes {motion['bits_per_vertex']:.1f} bits at {speed(motion, 'decode', triangles_of(results, 'fvv, motion')):.0f} million; the fast
profile takes {fast['bits_per_vertex']:.0f} bits at {speed(fast, 'decode', triangles_of(results, '')):.0f} million.** Hulls of the generated clip (motion: its
tracked players) on a lattice of {STEP} mm, or for Draco and meshoptimizer with the number of bits that gives about this step over the box of each
mesh, on one thread, in one run; two triangles for each vertex:

{table(results)}

fvv's draco profile uses the library libdraco, so its bytes are near those of Draco ({default['bytes_per_frame'] / other['bytes_per_frame']:.2f} times those of
Draco, level 10, at a step of {default['step_mm']:.2f} instead of {other['step_mm']:.2f} mm); its times include the checks that untrusted data need.
meshoptimizer's positions are 16-bit numbers without a lattice, and its faces are in the order of strips; after zstd it takes {zstd['bits_per_vertex']:.0f} bits.

![kB per frame over rms error](mesh-error.svg)

Where meshes need not be exact, decimation (`--max-error`) saves more than coarser steps do. Of meshes that keep their faces, motion takes
{said} of the bytes of principal components at the same error of the surface. That is an estimate of what a codec with a basis of trajectories would take
([trajectories.py](../../../bench/charts/trajectories.py)): the entropy of quantised components in groups of {results['group']} frames, with the mean mesh by Draco.

![Million triangles encoded per second, and the first call of a process](mesh-time.svg)

{browser}Times of encoding and decoding above are of the processor. Those of first and later calls are by the clock, medians of {PROCESSES} new processes and of
later meshes in one process, on a machine with other load: compare them with each other only.

Left out: Corto, which Debian has no package of; V-DMC and TVMC, whose papers report BD-rates and PSNR on MPEG's sequences (Huang et al.,
arXiv 2510.22646: TVMC takes 10.2 to 16.9 % fewer bytes than V-DMC by BD-rate), not bytes at an error in millimetres, so that they have no point here."""


def defaults(results):
    rows = dict(at_one_step(results))
    default, ten, five = (rows[f"fvv, draco, level {n}"] for n in (f"{DEFAULT_LEVEL} (default)", "10", "5"))
    fast = rows["fvv, fast"]
    return [
        ("fvvmux --mesh-profile", "draco", f"{default['bits_per_vertex']:.1f} bits per vertex; fast takes {fast['bits_per_vertex']:.1f} and "
         f"{fast['decode_ms'] / default['decode_ms']:.2f} of the time to decode"),
        ("fvvmux --mesh-level", DEFAULT_LEVEL, f"level 10 takes {100 * (ten['bytes_per_frame'] / default['bytes_per_frame'] - 1):+.1f} % bytes, level 5 "
         f"{100 * (five['bytes_per_frame'] / default['bytes_per_frame'] - 1):+.1f} %; decoding takes {ten['decode_ms'] / default['decode_ms']:.2f} and "
         f"{five['decode_ms'] / default['decode_ms']:.2f} of the time"),
    ]  # fmt: skip


EXPERIMENTS = (
    experiment.Experiment("mesh", "Meshes: bytes, error and time", measure, draw, text, headlines, defaults),
)
