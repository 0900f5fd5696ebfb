"""Surfaces that are followed: bytes against error beside key frames, and what breaks runs."""

import mesh_only
import numpy as np
from real_capture import read_ply

from . import drawing, experiment

FRAMES = 8
BUDGETS = 1, 2, 4, 8  # mm
HOW = "never", "auto", "always"
CASE_BUDGET = 4
NOISE_MM = 2
SPECKS, SPECK_MM = 30, 8
CAUGHT = 14  # frame from which on the ball arrives at a hand
# Of a captured basketball player at 30 frames per second: Mbit/s at D2 of about 70 dB, as read from what its authors published.
PUBLISHED = {"V-DMC": 3.3, "TVMC": 2.8}


def source(*options):
    """A person and another with a ball, in other faces in every frame."""
    return experiment.capture(
        "remeshed", "--rig", "small", "--cameras", 1, "--size", "64x48", "--meshes", "remeshed", *options
    )


def row(capture, budget, how, *options):
    made = experiment.packed(capture, "--no-pictures", "--max-error", f"{budget}mm", "--track", how, *options)
    mesh, frames = made.summary["mesh"], made.summary["frames"]
    return {
        "bytes": mesh["bytes"] / frames,
        "keys": mesh["key"]["frames"],
        "frames": frames,
        "rms_mm": 1000 * made.summary["budget"]["rms"],
        "seconds": made.seconds / frames,
    }


def unchanged(vertices, faces, _):
    return vertices, faces


def changed(capture, name, change, missing=()):
    """A copy of a capture whose meshes go through change(vertices, faces, random); without the files of some frames."""

    def write(description, folder):
        for number in sorted(set(range(FRAMES)) - set(missing)):
            vertices, faces = read_ply(capture / f"meshes/{number:04d}.ply")
            mesh_only.write_ply(
                folder / f"{number:04d}.ply", *change(vertices, faces, np.random.default_rng(number))
            )
        description["meshes"]["pattern"] = "%04d.ply"

    return experiment.changed_capture(capture, name, write)


def noisy(vertices, faces, random):
    return vertices + random.normal(0, NOISE_MM / 1000, vertices.shape), faces


def specked(vertices, faces, random):
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * SPECK_MM / 1000
    sides = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    low, high = vertices.min(0), vertices.max(0)
    all_vertices, all_faces = [vertices], [faces]
    for i in range(SPECKS):
        all_vertices.append(random.uniform(low, high) + corners)
        all_faces.append(sides + len(vertices) + 4 * i)
    return np.concatenate(all_vertices), np.concatenate(all_faces)


def cases():
    person = source("--frames", FRAMES)
    everything = source("--frames", CAUGHT + FRAMES)
    range_of = f"{CAUGHT}-{CAUGHT + FRAMES - 1}"
    return {
        "25 frames per second": (person,),
        "12.5 frames per second": (source("--frames", FRAMES, "--fps", "25/2"),),
        "50 frames per second": (source("--frames", FRAMES, "--fps", 50),),
        f"a frame is missing ({FRAMES // 2})": (
            changed(person, "missing", unchanged, [FRAMES // 2]), "--skip-bad-frames"),
        f"noise of {NOISE_MM} mm": (changed(person, "noise", noisy),),
        f"{SPECKS} specks of {SPECK_MM} mm": (changed(person, "specks", specked),),
        "a ball is caught": (everything, "--frames", range_of),
    }  # fmt: skip


def measure(quick):
    if quick:
        return None
    person = source("--frames", FRAMES)
    out = {"budgets": {how: [row(person, b, how) | {"budget_mm": b} for b in BUDGETS] for how in HOW}}
    out["cases"] = {
        name: {how: row(capture, CASE_BUDGET, how, *options) for how in ("never", "always")}
        for name, (capture, *options) in cases().items()
    }
    return out


def draw(results, folder):
    figure, (panel,) = drawing.sheet(1, 1, 5.2, 3.6)
    for number, (how, rows) in enumerate(results["budgets"].items()):
        drawing.line(
            panel, number, [r["rms_mm"] for r in rows], [r["bytes"] / 1000 for r in rows], f"--track {how}"
        )
    drawing.logarithmic(panel, "x")
    drawing.logarithmic(panel, "y")
    panel.set_xlabel("rms distance from the source, mm")
    panel.set_ylabel("kB of meshes per frame")
    panel.legend()
    drawing.save(figure, folder / "track.svg")


def text(results):
    budgets, cases_ = results["budgets"], results["cases"]
    best = min(zip(BUDGETS, budgets["always"], budgets["never"]), key=lambda r: r[1]["bytes"] / r[2]["bytes"])
    seconds = budgets["always"][-1]["seconds"] - budgets["never"][-1]["seconds"]
    lines = [
        "![kB per frame over the distance from the source](track.svg)",
        "",
        f"**At {best[0]} mm a followed surface takes {100 * best[1]['bytes'] / best[2]['bytes']:.0f} % of the bytes of key frames, and "
        f"{seconds:.1f} s more of one core for each frame.** {FRAMES} frames of generated people whose faces change in every frame, one group "
        "without pictures. In short runs the key counts most.",
        "",
        f"What breaks runs, at {CASE_BUDGET} mm; a frame that cannot be followed is a key frame:",
        "",
        "| case | frames | keys | bytes over key frames | rms |",
        "|---|---|---|---|---|",
    ]
    for name, rows in cases_.items():
        always, never = rows["always"], rows["never"]
        lines.append(
            f"| {name} | {always['frames']} | {always['keys']} | {100 * always['bytes'] / never['bytes']:.0f} % | {always['rms_mm']:.2f} mm |"
        )
    said = ", ".join(f"{name} at most {rate}" for name, rate in PUBLISHED.items())
    lines += [
        "",
        f"Published rates of others for a captured basketball player, Mbit/s at 30 frames per second: {said}. Ours, which `./run bench track` "
        "measures where that data is, are in [Tracking](../../encoding/tracking.md#figures).",
    ]
    return "\n".join(lines)


EXPERIMENTS = (experiment.Experiment("track", "Followed surfaces", measure, draw, text),)
