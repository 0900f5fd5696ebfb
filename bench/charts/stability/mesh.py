"""Where meshes break: long chains of delta frames, changes of topology, thin parts, specks, noise and stray vertices."""

import json
import math
import shutil

import mesh_only
import numpy as np
from real_capture import read_ply

from .. import degradations, drawing, experiment, growth, views
from . import camera as filmed

CHAIN = 1500  # frames in one group
RUNS = 1, 2, 3, 4, 6, 12, 24, 48  # frames with the same faces
STEP_MM = 5
THICKNESS = 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1, 1.4, 2, 3, 5  # of a plate, in lattice steps
SPECKS_MM = 0.1, 0.3, 0.6, 1, 1.5, 2, 3, 5, 10, 30  # radius
SPECKS = 50
BUDGET_MM = 1
NOISE_MM = 0, 0.5, 1, 2, 4, 8, 16  # standard deviation of each coordinate
FAR_M = 1, 10, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7
STRAY_PERCENT = 0.04, 0.2, 0.5, 0.8, 1.2, 2, 4, 8  # of the vertices, 100 m away
NOISE_FRAMES, NOISE_VIEWS = 4, (0, 15)


def mesh_capture(name, meshes):
    """A capture without cameras; meshes: vertices and faces of each frame."""
    folder = experiment.WORK / "captures" / f"mesh-{name}"
    shutil.rmtree(folder, ignore_errors=True)
    return mesh_only.write_capture(folder, meshes)


def pack(name, meshes, *options):
    """The summary of fvvmux, its exit code, and the decoded meshes; None where it refuses the capture."""
    capture = mesh_capture(name, meshes)
    stream, out = capture.with_suffix(".fvv"), capture.with_suffix(".out")
    try:
        done = experiment.run("fvvmux", capture, "-o", stream, "--force", "--json", *options)
    except experiment.Failed:
        return None, 1, []
    experiment.run("fvvdemux", stream, "-o", out, "--force")
    decoded = [read_ply(path) for path in sorted((out / "meshes").glob("*.ply"))]
    return json.loads(done.output), done.code, decoded


def period_meshes():
    """Turned, because their vertices lie on a lattice already."""
    _, folder = growth.period()
    turn = degradations.rotation_by((1, 2, 3), 0.7)
    meshes = [read_ply(folder / f"meshes/{i:04d}.ply") for i in range(growth.PERIOD)]
    return [(vertices @ turn.T, faces) for vertices, faces in meshes]


def chain():
    """The distance of decoded meshes from their source over the number of delta frames since the key frame."""
    capture = growth.long_capture(CHAIN)
    made = experiment.packed(
        capture, "--no-pictures", "--keep-geometry", "--max-error", "1mm", "--group", CHAIN
    )
    found = experiment.answer("fvvcompare", capture, made.path, "--samples", 1000, "--threads", 1)["frames"]
    part = CHAIN // 30
    rows = []
    for begin in range(0, CHAIN, part):
        some = [frame["distance"]["symmetric"] for frame in found[begin : begin + part]]
        rows.append({"frame": begin + part // 2, "rms_mm": 1000 * math.sqrt(sum(f["rms"] ** 2 for f in some) / len(some)),
                     "max_mm": 1000 * max(f["max"] for f in some)})  # fmt: skip
    steps = 0.5 + made.summary["mesh"]["delta"]["max_error_steps"]
    bound = 1000 * made.summary["lattice"]["step"] * steps * math.sqrt(3)
    return {"rows": rows, "bound_mm": bound, "keys": made.summary["mesh"]["key"]["frames"]}


def renamed(mesh, random):
    """The same surface with other numbers of vertices and another order of faces: another topology for a coder."""
    vertices, faces = mesh
    order = random.permutation(len(vertices))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return vertices[order], place[faces][random.permutation(len(faces))]


def topology():
    meshes = period_meshes()[: max(RUNS)]
    rows = []
    for length in RUNS:
        changed = []
        for i, mesh in enumerate(meshes):
            changed.append(renamed(mesh, np.random.default_rng(i // length)))
        options = "--max-error", "1mm", "--keep-geometry", "--group", len(meshes)
        summary, _, _ = pack("run", changed, *options)
        row = {"run": length, "bytes": summary["mesh"]["bytes"] / len(meshes)}
        row["keys"] = summary["mesh"]["key"]["frames"]
        rows.append(row | {"rms_mm": 1000 * compared("run", 2000)["distance"]["symmetric"]["rms"]})
    return {"rows": rows, "frames": len(meshes)}


def compared(name, samples):
    """What fvvcompare says of the capture and the stream that pack() wrote last."""
    capture = experiment.WORK / f"captures/mesh-{name}"
    return experiment.answer(
        "fvvcompare", capture, capture.with_suffix(".fvv"), "--samples", samples, "--threads", 1
    )


def thin():
    """A plate, turned in space, as a lattice of STEP_MM alone and as the same budget with decimation leave it."""
    turn = degradations.rotation_by((1, 2, 3), 0.7)
    ways = {
        "lattice": ("--keep-geometry", "--step", f"{STEP_MM}mm"),
        "decimated": ("--max-error", f"{STEP_MM / 2}mm"),
    }
    rows = []
    for thickness in THICKNESS:
        vertices, faces = degradations.plate(0.6, thickness * STEP_MM / 1000, 60)
        row = {"steps": thickness}
        for way, options in ways.items():
            summary, code, _ = pack("plate", [(vertices @ turn.T, faces)], *options)
            row[f"{way}_code"] = code
            if summary:
                found = compared("plate", 20000)
                row[f"{way}_turned_percent"] = 100 * found["turned"]["symmetric"]
                row[f"{way}_max_mm"] = 1000 * found["distance"]["symmetric"]["max"]
        rows.append(row)
    return {"rows": rows}


def specks():
    """Small balls beside a large one, with a budget of BUDGET_MM."""
    ball, small = mesh_only.icosphere(4), mesh_only.icosphere(1)
    random = np.random.default_rng(1)
    away = random.normal(size=(SPECKS, 3))
    away *= (0.8 + 0.4 * random.random(SPECKS)[:, None]) / np.linalg.norm(away, axis=1, keepdims=True)
    rows = []
    for radius in SPECKS_MM:
        parts = [ball] + [(small[0] * radius / 500 + place, small[1]) for place in away]
        starts = np.cumsum([0] + [len(v) for v, _ in parts[:-1]])
        mesh = (
            np.vstack([v for v, _ in parts]),
            np.vstack([f + start for (_, f), start in zip(parts, starts)]),
        )
        row = {"radius_mm": radius}
        for way, options in {"decimated": (), "kept": ("--keep-geometry",)}.items():
            _, code, decoded = pack("specks", [mesh], "--max-error", f"{BUDGET_MM}mm", *options)
            left = degradations.pieces(decoded[0][1], len(decoded[0][0])) - 1
            # A piece may fall apart on the lattice.
            row |= {f"{way}_percent": min(100, 100 * left / SPECKS), f"{way}_code": code}
        rows.append(row)
    return {"rows": rows}


def noise():
    """Vertices off at random, in each frame otherwise, of the generated clip with 7 cameras."""
    source = filmed.clip()
    arc = filmed.arc(NOISE_VIEWS)
    meshes = [read_ply(source / f"meshes/{i:04d}.ply") for i in range(NOISE_FRAMES)]
    rows = []
    for deviation in NOISE_MM:

        def change(description, folder, deviation=deviation):
            random = np.random.default_rng(1)
            for i, (vertices, faces) in enumerate(meshes):
                off = random.normal(scale=max(deviation, 1e-9) / 1000, size=vertices.shape)
                mesh_only.write_ply(folder / f"{i:04d}.ply", vertices + off, faces)
            description["meshes"]["pattern"] = "%04d.ply"
            description["frames"]["count"] = NOISE_FRAMES

        made = experiment.packed(experiment.changed_capture(source, f"noise{deviation:g}", change))
        view = views.measure(made.path, arc, frames=filmed.SHOWN)
        row = {"mm": deviation, "bytes": made.summary["mesh"]["bytes"] / NOISE_FRAMES}
        decimated = made.summary["budget"]["decimated_frames"]
        rows.append(row | {"psnr_db": view["psnr_inside_db"], "decimated_frames": decimated})
    return {"rows": rows}


def stray(name, distance, share):
    """What is left of a ball when some of its vertices are far away: the rms error of the others, or None when refused."""
    vertices, faces = mesh_only.icosphere(4)
    vertices = vertices.copy()
    random = np.random.default_rng(1)
    count = max(1, round(share * len(vertices)))
    some = random.choice(len(vertices), count, replace=False)
    away = random.normal(size=(count, 3))
    vertices[some] = distance * away / np.linalg.norm(away, axis=1, keepdims=True)
    summary, code, decoded = pack(name, [(vertices, faces)])
    row = {"distance_m": distance, "percent": 100 * share, "code": code}
    if summary:
        radius = np.linalg.norm(decoded[0][0], axis=1)
        near = radius < 0.75
        row |= {"rms_mm": 1000 * math.sqrt(((radius[near] - 0.5) ** 2).mean()), "step_mm": 1000 * summary["lattice"]["step"],
                "near": int(near.sum()), "expected": len(vertices) - count}  # fmt: skip
    return row


def outliers():
    return {"far": [stray("far", distance, 0) for distance in FAR_M],
            "many": [stray("many", 100, share / 100) for share in STRAY_PERCENT]}  # fmt: skip


def measure(quick):
    if quick:
        return {"topology": topology()}
    return {
        "chain": chain(),
        "topology": topology(),
        "thin": thin(),
        "specks": specks(),
        "noise": noise(),
        "outliers": outliers(),
    }


def draw(results, folder):
    figure, panels = drawing.sheet(4, 2, 3.1, 2.7)
    draw_chain(panels[0], results["chain"])
    draw_topology(panels[1], results["topology"])
    draw_thin(panels[2], results["thin"])
    draw_specks(panels[3], results["specks"])
    draw_noise(panels[4], panels[5], results["noise"])
    draw_outliers(panels[6], panels[7], results["outliers"])
    drawing.save(figure, folder / "stability-mesh.svg")


def draw_chain(axis, found):
    rows = found["rows"]
    drawing.line(axis, 0, [r["frame"] for r in rows], [r["rms_mm"] for r in rows], "rms", markersize=3)
    drawing.line(axis, 1, [r["frame"] for r in rows], [r["max_mm"] for r in rows], "largest", markersize=3)
    axis.axhline(
        found["bound_mm"], color=drawing.BLACK, linewidth=0.8, linestyle="--", label="bound of the encoder"
    )
    axis.set(
        title="Long chains of delta frames",
        xlabel="frames since the key frame",
        ylabel="error, mm (budget 1 mm)",
    )
    axis.set_ylim(0, 1.5 * found["bound_mm"])
    axis.legend(loc="upper right")


def draw_topology(axis, found):
    rows = found["rows"]
    drawing.line(axis, 0, [r["run"] for r in rows], [r["bytes"] / 1000 for r in rows], "kB per frame")
    drawing.line(axis, 1, [r["run"] for r in rows], [r["rms_mm"] for r in rows], "error, mm rms")
    drawing.logarithmic(axis, "x", RUNS[::2])
    axis.set(title="Change of topology", xlabel="frames between changes", ylabel="kB or mm")
    drawing.words(axis, 1, rows[0]["bytes"] / 1000, "all key frames", (8, -2))
    axis.set_ylim(0, 1.45 * max(r["bytes"] / 1000 for r in rows))
    axis.legend(loc="upper right")


def draw_thin(axis, found):
    rows = found["rows"]
    for number, (way, label) in enumerate((("lattice", "lattice"), ("decimated", "decimated"))):
        some = [r for r in rows if f"{way}_turned_percent" in r]
        drawing.line(
            axis, number, [r["steps"] for r in some], [r[f"{way}_turned_percent"] for r in some], label
        )
    warned = [r["steps"] for r in rows if r["lattice_code"] == 3]
    if warned:
        drawing.mark(axis, max(warned), "fvvmux\nwarns\nup to here", 0.75, side="right")
    drawing.logarithmic(axis, "x", (0.02, 0.1, 0.5, 2))
    axis.set(title="Thin parts", xlabel="thickness of a plate, lattice steps", ylabel="surface inside out, %")
    axis.legend(loc="lower left")


def draw_specks(axis, found):
    rows = found["rows"]
    radius = [r["radius_mm"] for r in rows]
    drawing.line(axis, 0, radius, [r["kept_percent"] for r in rows], "--keep-geometry")
    drawing.line(axis, 1, radius, [r["decimated_percent"] for r in rows], "decimated", linestyle=":")
    drawing.logarithmic(axis, "x", (0.1, 1, 10))
    drawing.mark(axis, BUDGET_MM, "budget", 0.2)
    axis.set(title="Specks", xlabel="radius, mm", ylabel="of 50 small pieces left, %")
    axis.set_ylim(-5, 108)
    axis.legend(loc="center right")


def draw_noise(left, right, found):
    rows = found["rows"]
    x = [max(r["mm"], 0.25) for r in rows]
    drawing.line(left, 0, x, [r["bytes"] / 1000 for r in rows])
    left.set(title="Noise of meshes: size", ylabel="kB per frame of meshes")
    left.set_ylim(0, None)
    drawing.line(right, 0, x, [r["psnr_db"] for r in rows])
    right.set(title="Noise of meshes: view", ylabel="PSNR inside, dB")
    for axis in (left, right):
        drawing.logarithmic(axis, "x")
        axis.set_xticks([0.25, 0.5, 1, 2, 4, 8, 16], ["0", "0.5", "1", "2", "4", "8", "16"])
        axis.set_xlabel("deviation of a coordinate, mm")


def draw_outliers(left, right, found):
    for axis, rows, key in (left, found["far"], "distance_m"), (right, found["many"], "percent"):
        some = [r for r in rows if "rms_mm" in r]
        drawing.line(axis, 0, [r[key] for r in some], [r["rms_mm"] for r in some], "error of the others, rms")
        drawing.line(axis, 1, [r[key] for r in some], [r["step_mm"] for r in some], "lattice step")
        drawing.logarithmic(axis, "x")
        drawing.logarithmic(axis, "y")
        axis.set_ylabel("mm")
        if refused := [r[key] for r in rows if "rms_mm" not in r]:
            drawing.mark(axis, min(refused), "refused", 0.62, side="right")
    left.set_xticks([1, 100, 1e4])
    left.set_ylim(0.01, 10)
    left.set(title="One stray vertex", xlabel="its distance, m (ball of 0.5 m)")
    right.set(title="Many stray vertices", xlabel="share of vertices 100 m away, %")
    left.legend(loc="upper left")


def whole(rows, way):
    """The smallest radius from which on no speck is lost."""
    lost = [r["radius_mm"] for r in rows if r[f"{way}_percent"] < 100]
    return f"{min(r['radius_mm'] for r in rows if r['radius_mm'] > max(lost, default=0)):g}"


def silently(rows, way):
    """How many cases with losses have no warning, in words."""
    lost = [r for r in rows if r[f"{way}_percent"] < 100]
    silent = sum(r[f"{way}_code"] == 0 for r in lost)
    return (
        f"without a warning in {silent} of {len(lost)} cases"
        if silent
        else f"with a warning in all {len(lost)} cases"
    )


def text(results):
    rows = results["chain"]["rows"]
    plates, specks_, noisy = results["thin"]["rows"], results["specks"]["rows"], results["noise"]["rows"]
    thinner = [r for r in plates if r["steps"] < 1]
    warned = [r for r in thinner if 3 in (r["lattice_code"], r["decimated_code"])]
    few = next(r for r in plates if r["steps"] == 0.5)
    far, many = results["outliers"]["far"], results["outliers"]["many"]
    refused = [r["distance_m"] for r in far if "rms_mm" not in r]
    fine = [r["percent"] for r in many if "rms_mm" in r and r["rms_mm"] < 1]
    topology_ = results["topology"]["rows"]
    lines = [
        "![Errors of meshes over what breaks them](stability-mesh.svg)",
        "",
        f"**Over {CHAIN:,} delta frames the error goes from {rows[0]['rms_mm']:.2f} to {rows[-1]['rms_mm']:.2f} mm rms and never exceeds the bound of the "
        "encoder; a change of topology costs bytes, not accuracy.**",
        "",
        f"- Chains: a group of {CHAIN:,} frames with {results['chain']['keys']} key frame; the encoder predicts from what decoders have, so errors do not add up. The largest is "
        f"{max(r['max_mm'] for r in rows):.2f} mm, the bound {results['chain']['bound_mm']:.2f} mm.",
        f"- Topology: with other faces in every frame all {results['topology']['frames']} frames are key frames of "
        f"{topology_[0]['bytes'] / 1000:.1f} kB; with the same faces {topology_[-1]['bytes'] / 1000:.1f} kB. The error is "
        f"{min(r['rms_mm'] for r in topology_):.2f} to {max(r['rms_mm'] for r in topology_):.2f} mm rms (budget: 1 mm).",
        f"- Thin parts: below a lattice step the two sides of a plate meet or cross. At {few['steps']:g} steps {few['lattice_turned_percent']:.0f} % of the "
        f"surface is inside out ({few['decimated_turned_percent']:.0f} % decimated with the same budget; 50 % means that both sides coincide), from 1 step "
        f"on at most {max(r['lattice_turned_percent'] for r in plates if r['steps'] >= 1):.1f} %. `fvvmux` warns of {len(warned)} of the {len(thinner)} plates below a step.",
        f"- Specks: with a budget of {BUDGET_MM} mm, pieces of {whole(specks_, 'decimated')} mm and more all stay, with `--keep-geometry` those of "
        f"{whole(specks_, 'kept')} mm. Smaller ones vanish on the lattice: {silently(specks_, 'decimated')} when decimated, "
        f"{silently(specks_, 'kept')} with `--keep-geometry`.",
        f"- Noise of {noisy[-1]['mm']} mm takes {noisy[-1]['bytes'] / noisy[0]['bytes']:.1f} times the bytes of an exact mesh, and the view loses "
        f"{noisy[0]['psnr_db'] - noisy[-1]['psnr_db']:.1f} dB ({noisy[0]['psnr_db']:.1f} dB without).",
        "- Stray vertices: one far away costs the others nothing"
        + (
            f" up to {max(r['distance_m'] for r in far if 'rms_mm' in r):,.0f} m, and is refused from {min(refused):,.0f} m on"
            if refused
            else ""
        )
        + (
            f"; up to {max(fine):g} % of all vertices can be far away before the lattice becomes coarse."
            if fine
            else "."
        ),
    ]
    return "\n".join(lines)


def headlines(results):
    rows = results["topology"]["rows"]
    return {"other_faces_bytes": rows[0]["bytes"], "same_faces_bytes": rows[-1]["bytes"]}


EXPERIMENTS = (experiment.Experiment("stability-mesh", "Where meshes break", measure, draw, text, headlines),)
