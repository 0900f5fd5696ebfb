"""Surfaces that are followed: bytes against error beside key frames and Draco, error over a run, long runs, and what breaks them."""

import csv
import io

import DracoPy
import mesh_only
import numpy as np
from real_capture import read_ply
from track import scenes, surface

from . import drawing, experiment, system

FRAMES = 8
BUDGETS = 1, 2, 4, 8  # mm
HOW = "never", "auto", "always"
CASE_BUDGET = 4
NOISE_MM = 2
SPECKS, SPECK_MM = 30, 8
CAUGHT = 14  # frame from which on the ball arrives at a hand
DRACO_BITS = 7, 8, 9, 10
RUN = 36  # frames of one group, over which the error is watched
LENGTHS = 10, 25, 50, 100  # frames of a group, of a clip with pictures
GROWTH = 10, 25, 50, 100, 250  # frames of one capture
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
        "hands touch and part": (made_up("hands", scenes.touching_hands),),
        "a jacket is opened": (made_up("jacket", scenes.opened_jacket),),
    }  # fmt: skip


def made_up(name, scene):
    folder = experiment.WORK / "captures" / f"track-{name}"
    return mesh_only.write_capture(folder, scenes.sequence(scene, FRAMES))


def draco(capture):
    """Each source mesh by itself, all of its faces: the points of a codec that decimates nothing."""
    rows = []
    sources = [read_ply(path)[:2] for path in sorted((capture / "meshes").glob("*.ply"))]
    for bits in DRACO_BITS:
        coded = [
            DracoPy.encode(
                v.astype(np.float32), f.astype(np.uint32), quantization_bits=bits, compression_level=10
            )
            for v, f in sources
        ]
        squares = []
        for (vertices, faces), data in zip(sources, coded):
            decoded = DracoPy.decode(data)
            squares += [
                (surface.to_plane(np.asarray(decoded.points), surface.dense(vertices, faces, 1)) ** 2).mean()
            ]
        rows.append(
            {
                "bits": bits,
                "bytes": float(np.mean([len(c) for c in coded])),
                "rms_mm": 1000 * np.mean(squares) ** 0.5,
            }
        )
    return rows


def along_a_run():
    """rms from the source of each frame of one run, both directions, and whether its key was sent there."""
    capture = source("--frames", RUN)
    made = experiment.packed(
        capture, "--no-pictures", "--max-error", f"{CASE_BUDGET}mm", "--track", "always", "--group", RUN
    )
    table = experiment.run("fvvcompare", capture, made.path, "--csv", "-").output
    mesh = made.summary["mesh"]
    return {
        "rms_mm": [1000 * float(row["symmetric_rms"]) for row in csv.DictReader(io.StringIO(table))],
        "max_mm": [1000 * float(row["symmetric_max"]) for row in csv.DictReader(io.StringIO(table))],
        "keys": mesh["key"]["frames"],
        "patches": mesh["patched"]["frames"],
    }


def group_rows():
    """The clip of hulls: bytes a frame, and those of half a group, which a viewer who seeks waits for."""
    clip, rows = system.clip("hull", max(LENGTHS)), []
    for how in "never", "auto":
        for length in LENGTHS:
            made = experiment.packed(clip, "--quality", "16", "--track", how, "--group", length)
            rows.append(
                {"track": how, "group": length, "keys": made.summary["mesh"]["key"]["frames"]}
                | experiment.parts(made.summary)
            )
    return rows


def growth_rows():
    rows = []
    for frames in GROWTH:
        capture = source("--frames", frames)
        rows.append({"frames": frames} | {how: row(capture, CASE_BUDGET, how) for how in ("never", "always")})
        made = experiment.packed(
            capture, "--no-pictures", "--max-error", f"{CASE_BUDGET}mm", "--track", "always"
        )
        rows[-1]["mib"] = made.peak_mib
    return rows


def measure(quick):
    if quick:
        return None
    person = source("--frames", FRAMES)
    out = {"budgets": {how: [row(person, b, how) | {"budget_mm": b} for b in BUDGETS] for how in HOW}}
    out["draco"] = draco(person)
    out["cases"] = {
        name: {how: row(capture, CASE_BUDGET, how, *options) for how in ("never", "auto", "always")}
        for name, (capture, *options) in cases().items()
    }
    return out | {"run": along_a_run(), "groups": group_rows(), "growth": growth_rows()}


def draw(results, folder):
    figure, panels = drawing.sheet(2, 2, 4.4, 3.3)
    bytes_, error, groups, growth = panels
    for number, (how, rows) in enumerate(results["budgets"].items()):
        drawing.line(
            bytes_, number, [r["rms_mm"] for r in rows], [r["bytes"] / 1000 for r in rows], f"--track {how}"
        )
    rows = results["draco"]
    drawing.line(
        bytes_, 3, [r["rms_mm"] for r in rows], [r["bytes"] / 1000 for r in rows], "Draco, source's faces"
    )
    drawing.logarithmic(bytes_, "x")
    drawing.logarithmic(bytes_, "y")
    bytes_.set_xlabel("rms distance from the source, mm")
    bytes_.set_ylabel("kB of meshes per frame")
    bytes_.legend()
    run = results["run"]
    drawing.line(error, 0, range(len(run["rms_mm"])), run["rms_mm"], "rms", marker=None)
    drawing.line(error, 1, range(len(run["max_mm"])), run["max_mm"], "largest", marker=None)
    error.axhline(CASE_BUDGET, color=drawing.BLACK, linewidth=0.8, linestyle="--", label="--max-error")
    error.set_ylim(0)
    error.set_xlabel("frames after the first of the run")
    error.set_ylabel("distance from the source, mm")
    error.legend()
    for number, how in enumerate(("never", "auto")):
        rows = [r for r in results["groups"] if r["track"] == how]
        surface_kb = [(r["meshes_bytes"] + r["visibility_bytes"] + r["colours_bytes"]) / 1000 for r in rows]
        lengths = [r["group"] for r in rows]
        drawing.line(groups, number, lengths, [r["all_bytes"] / 1000 for r in rows], f"all, --track {how}")
        drawing.line(groups, number, lengths, surface_kb, f"surface, --track {how}", linestyle="--")
    drawing.logarithmic(groups, "x", LENGTHS)
    groups.set_ylim(0)
    groups.set_xlabel("frames in a group")
    groups.set_ylabel("kB per frame")
    groups.legend()
    rows = results["growth"]
    frames = [r["frames"] for r in rows]
    for number, how in enumerate(("never", "always")):
        drawing.line(growth, number, frames, [r[how]["seconds"] for r in rows], f"--track {how}")
    drawing.logarithmic(growth, "x", GROWTH)
    growth.set_ylim(0)
    growth.set_xlabel("frames of the capture")
    growth.set_ylabel("seconds of one core per frame")
    growth.legend()
    drawing.save(figure, folder / "track.svg")


def seek(row):
    """kB before the picture of a frame in the middle of a group."""
    return row["all_bytes"] * row["group"] / 2 / 1000


def text(results):
    budgets, cases_ = results["budgets"], results["cases"]
    best = min(zip(BUDGETS, budgets["always"], budgets["never"]), key=lambda r: r[1]["bytes"] / r[2]["bytes"])
    seconds = budgets["always"][-1]["seconds"] - budgets["never"][-1]["seconds"]
    run, groups, growth = results["run"], results["groups"], results["growth"]
    third = len(run["rms_mm"]) // 3
    lines = [
        "![kB per frame over the distance from the source, error over a run, kB over the length of groups, time over frames](track.svg)",
        "",
        f"**At {best[0]} mm a followed surface takes {100 * best[1]['bytes'] / best[2]['bytes']:.0f} % of the bytes of key frames, and "
        f"{seconds:.1f} s more of one core for each frame.** {FRAMES} frames of generated people whose faces change in every frame, one group "
        "without pictures. In short runs the key counts most. Draco has all faces of the source, and fewer bits.",
        "",
        f"Over a run of {RUN} frames at {CASE_BUDGET} mm (keys: {run['keys']}, patches: {run['patches']}) the rms of the first third of the frames is "
        f"{np.mean(run['rms_mm'][:third]):.2f} mm, of the last {np.mean(run['rms_mm'][-third:]):.2f} mm.",
        "",
        "Length of groups: the clip of hulls with 7 cameras at 480x270, H.264 at the number 16. A viewer who seeks waits for half a group:",
        "",
        "| frames in a group | kB a frame, `never` | `auto` | surface, `never` | `auto` | keys, `auto` | kB before a frame in the middle, `auto` |",
        "|---|---|---|---|---|---|---|",
    ]
    for length in LENGTHS:
        never, auto = (
            next(r for r in groups if r["track"] == how and r["group"] == length) for how in ("never", "auto")
        )
        parts = [
            sum(r[f"{p}_bytes"] for p in ("meshes", "visibility", "colours")) / 1000 for r in (never, auto)
        ]
        lines.append(
            f"| {length} | {never['all_bytes'] / 1000:.2f} | {auto['all_bytes'] / 1000:.2f} | {parts[0]:.2f} | {parts[1]:.2f} | {auto['keys']} | {seek(auto):.0f} |"
        )
    lines += [
        "",
        f"Growth: {growth[0]['always']['seconds']:.2f} s a frame of {growth[0]['frames']} frames, {growth[-1]['always']['seconds']:.2f} s of "
        f"{growth[-1]['frames']}, in {growth[0]['mib']:.0f} and {growth[-1]['mib']:.0f} MiB: time is linear in frames, and memory is that of the groups that are worked on.",
        "",
        f"What breaks runs, at {CASE_BUDGET} mm; a frame that cannot be followed is a key frame:",
        "",
        "| case | frames | keys, `auto` | bytes over key frames, `auto` | `always` | rms, `always` |",
        "|---|---|---|---|---|---|",
    ]
    for name, rows in cases_.items():
        auto, always, never = rows["auto"], rows["always"], rows["never"]
        lines.append(
            f"| {name} | {always['frames']} | {auto['keys']} | {100 * auto['bytes'] / never['bytes']:.0f} % | "
            f"{100 * always['bytes'] / never['bytes']:.0f} % | {always['rms_mm']:.2f} mm |"
        )
    said = ", ".join(f"{name} at most {rate}" for name, rate in PUBLISHED.items())
    lines += [
        "",
        "Hands and jacket are made up (`bench/track/scenes.py`): arms of one body that come together, touch and part, and a front that opens to a third of the way around "
        "in eight frames, so that cloth slides over cloth.",
        "",
        f"Published rates of others for a captured basketball player, Mbit/s at 30 frames per second: {said}. Ours, which `./run bench track` "
        "measures where that data is, are in [Tracking](../../encoding/tracking.md#figures).",
    ]
    return "\n".join(lines)


EXPERIMENTS = (experiment.Experiment("track", "Followed surfaces", measure, draw, text),)
