"""How bytes, time and memory grow: with frames, cameras, triangles and the size of pictures.

One parameter varies at a time, and everything else is small, so that a point takes seconds to a minute. fvvmux and fvvdemux
run on one thread; times are processor time. A power law is fitted to all points, and another to the largest three, where
costs that do not grow hide least: that one decides what is called super-linear.
"""

import contextlib
import json
import os
import shutil
import subprocess
import tempfile
import time

import serve

from . import drawing, experiment, numbers

PERIOD = 100  # frames, after which the action of fvvsynth repeats
LONG_TRIANGLES = 500
SIMPLE = "--triangles", 2000, "--step", "1mm"  # as many faces, whatever the pictures
FRAMES = 50, 150, 500, 1500, 5000
CAMERAS = 1, 2, 4, 8, 16, 32, 64
CELLS = 40, 80, 160, 320, 640, 1200  # of a hull's grid; triangles grow with the square
SIZES = "120x68", "240x134", "480x270", "960x540", "1920x1080"
QUICK = {"frames": FRAMES[:2], "cameras": CAMERAS[:4], "cells": CELLS[:3], "sizes": SIZES[:3]}
TICKS = {"cameras": (1, 4, 16, 64)}
DECADES = 100, 1e3, 1e4, 1e5, 1e6
SHORT = 2  # seconds of processor time
SUPER_LINEAR = 1.1  # exponents above it
COSTS = {
    "bytes": "bytes of the stream",
    "mux_s": "time of fvvmux",
    "demux_s": "time of fvvdemux",
    "mux_mib": "memory of fvvmux",
    "demux_mib": "memory of fvvdemux",
}
PARAMETERS = {
    "frames": "frames",
    "cameras": "cameras",
    "kept_triangles": "triangles, all kept",
    "triangles": "triangles of the source, decimated",
    "pixels": "pixels of a picture",
}


def period():
    """100 frames of 500 triangles and two cameras of 64x48, as files: what long captures repeat."""
    source = experiment.capture(
        "period", "--rig", "small", "--cameras", 2, "--size", "64x48", "--frames", PERIOD
    )
    folder = source.parent / f"{source.name}-meshes"
    if not folder.exists():
        made = experiment.packed(source, "--no-pictures", "--triangles", LONG_TRIANGLES, "--step", "1mm",
                          "--group", PERIOD)  # fmt: skip
        experiment.run("fvvdemux", made.path, "-o", folder, "--meshes", "ply")
    return source, folder


def long_capture(frames, name="long", edit=lambda description, folder: None, filmed=None):
    """A clip of any length whose files are those of a period, again and again. edit as change of experiment.changed_capture.

    filmed: a capture of the same scene and length, whose cameras take the place of the period's.
    """
    source, meshes = period()

    def change(description, folder):
        for camera in description["cameras"]:
            name = camera["name"]
            (folder / name).mkdir()
            for what, stem in ("pictures", "p"), ("masks", "m"):
                pattern = camera[what]
                for frame in range(frames):
                    os.link(pattern % (frame % PERIOD), folder / name / f"{stem}{frame:05d}.png")
                camera[what] = f"{name}/{stem}%05d.png"
        (folder / "meshes").mkdir()
        for frame in range(frames):
            os.link(meshes / f"meshes/{frame % PERIOD:04d}.ply", folder / f"meshes/{frame:05d}.ply")
        description["meshes"]["pattern"] = "meshes/%05d.ply"
        description["frames"]["count"] = frames
        edit(description, folder)

    return experiment.changed_capture(filmed or source, f"{name}{frames}", change)


def run(name, *arguments):
    """Processor seconds and peak memory in MiB of a tool on one thread, and what it prints.

    The peak is read while the tool runs: what the system reports after its end includes that of the process that started it.
    """
    command = [str(experiment.program(name)), *map(str, arguments), "--threads", "1"]
    with tempfile.TemporaryFile("w+") as out:
        child, peak = subprocess.Popen(command, stdout=out, stderr=subprocess.DEVNULL), 0.0
        while not os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT):
            with contextlib.suppress(TypeError):  # it ends at this moment
                peak = serve.peak_memory(child.pid)
            time.sleep(0.004)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode not in (0, 3):
            raise experiment.Failed([name, *arguments], child.returncode, "run it for its reason")
        out.seek(0)
        return usage.ru_utime + usage.ru_stime, peak, out.read()


def once_or_twice(*command):
    first = run(*command)
    return [first, run(*command)] if first[0] < SHORT else [first]


def costs(source, *options):
    """Of packing a capture and unpacking the stream; of what takes little time, the faster of two runs."""
    stream, folder = experiment.WORK / "scratch.fvv", experiment.WORK / "scratch"

    def pack_and_unpack():
        packing = once_or_twice("fvvmux", source, "-o", stream, "--force", "--json", *options)
        unpacking = once_or_twice("fvvdemux", stream, "-o", folder, "--force")
        shutil.rmtree(folder)
        return {
            "bytes": json.loads(packing[0][2])["bytes"],
            "mux_s": min(seconds for seconds, _, _ in packing),
            "demux_s": min(seconds for seconds, _, _ in unpacking),
            "mux_mib": max(peak for _, peak, _ in packing),
            "demux_mib": max(peak for _, peak, _ in unpacking),
        }

    programs = [experiment.digest_of(experiment.program(name)) for name in ("fvvmux", "fvvdemux")]
    return experiment.kept(
        "costs", (*programs, source, experiment.digest_of(source / "capture.json"), *options), pack_and_unpack
    )


def small(*options):
    return experiment.capture("grown", "--rig", "small", *options)


def triangles_of(source):
    """Of the first mesh."""
    with open(
        source / (json.loads((source / "capture.json").read_text())["meshes"]["pattern"] % 0), "rb"
    ) as file:
        for line in file:
            if line.startswith(b"element face"):
                return int(line.split()[-1])
    raise ValueError(f"{source}: the first mesh has no header of PLY")


def measure(quick):
    wanted = QUICK if quick else {"frames": FRAMES, "cameras": CAMERAS, "cells": CELLS, "sizes": SIZES}
    rows = {name: [] for name in PARAMETERS}
    for frames in wanted["frames"]:
        rows["frames"].append(
            {"x": frames, **costs(long_capture(frames), "--keep-geometry", "--step", "1mm")}
        )
    for cameras in wanted["cameras"]:
        source = small("--cameras", cameras, "--size", "160x90", "--frames", 4)
        rows["cameras"].append({"x": cameras, **costs(source, *SIMPLE)})
    for cells in wanted["cells"]:
        source = small("--meshes", "hull", "--hull-cells", cells, "--frames", 1)
        triangles = triangles_of(source)
        rows["kept_triangles"].append({"x": triangles, **costs(source, "--keep-geometry", "--step", "1mm")})
        rows["triangles"].append({"x": triangles, **costs(source)})
    for size in wanted["sizes"]:
        width, height = map(int, size.split("x"))
        source = small("--cameras", 2, "--size", size, "--frames", 4)
        rows["pixels"].append({"x": width * height, **costs(source, *SIMPLE)})
    out = {"rows": rows}
    if not quick:
        out["exponents"] = {name: exponents(found) for name, found in rows.items()}
        out["matching"] = matching(rows["cameras"][-3:])
    return out


def matching(rows):
    """Seconds in which fvvmux compares the colours of cameras: what a run without it takes less."""
    out = []
    for row in rows:
        source = small("--cameras", row["x"], "--size", "160x90", "--frames", 4)
        without = costs(source, *SIMPLE, "--match-colours", "off")
        out.append({"cameras": row["x"], "seconds": row["mux_s"] - without["mux_s"]})
    return out


def exponents(rows):
    """Of each cost, over all points, and over the largest three with the R^2 there."""
    x = [row["x"] for row in rows]
    out = {}
    for cost in COSTS:
        y = [row[cost] for row in rows]
        end, fit = numbers.exponent(x[-3:], y[-3:])
        out[cost] = {"all": numbers.exponent(x, y)[0], "end": end, "end_r2": fit}
    return out


def draw(results, folder):
    figure, panels = drawing.sheet(3, 2, 3.1, 2.5)
    for axis, (name, title) in zip(panels, PARAMETERS.items()):
        rows = results["rows"][name]
        x = [row["x"] for row in rows]
        for number, (cost, label) in enumerate(COSTS.items()):
            drawing.line(axis, number, x, [row[cost] / rows[0][cost] for row in rows], label)
        axis.plot(
            x,
            [value / x[0] for value in x],
            color=drawing.BLACK,
            linewidth=0.8,
            linestyle="--",
            label="linear",
        )
        drawing.logarithmic(axis, "x", TICKS.get(name, [v for v in DECADES if x[0] / 2 <= v <= x[-1]]))
        axis.xaxis.set_major_formatter(drawing.FuncFormatter(short))
        drawing.logarithmic(axis, "y")
        axis.set_xlabel(title)
        axis.set_ylabel("times the smallest")
    panels[-1].axis("off")
    panels[-1].legend(*panels[0].get_legend_handles_labels(), loc="center left", fontsize=9)
    drawing.save(figure, folder / "growth.svg")


def short(value, _=None):
    """1k, 1M."""
    for size, letter in (1e6, "M"), (1e3, "k"):
        if value >= size:
            return f"{value / size:g}{letter}"
    return f"{value:g}"


def super_linear(results):
    """[(cost, parameter, exponent)] of what grows faster than its parameter at the end."""
    return [
        (cost, name, found[cost]["end"])
        for name, found in results["exponents"].items()
        for cost in COSTS
        if found[cost]["end"] > SUPER_LINEAR
    ]


def text(results):
    found = super_linear(results)
    if found:
        verdict = "Faster than their parameter grow: " + "; ".join(
            f"{COSTS[cost]} with {PARAMETERS[name]} (exponent {value:.2f})" for cost, name, value in found
        )
    else:
        verdict = "Nothing grows faster than its parameter"
    rows, last = results["rows"], {name: found[-1] for name, found in results["rows"].items()}
    first, end = rows["frames"][0], rows["frames"][-1]
    each = 1024 * (end["mux_mib"] - first["mux_mib"]) / (end["x"] - first["x"])
    lines = [
        "![Costs over frames, cameras, triangles and pixels](growth.svg)",
        "",
        f"**{verdict}; every frame adds {each:.1f} KiB to the memory of `fvvmux`, which takes {first['mux_mib']:.0f} MiB for "
        f"{first['x']} frames and {end['mux_mib']:.0f} MiB for {end['x']:,}.** Exponents are fitted to the largest three points of each line; 1 is "
        f"linear, 0 constant, and above {SUPER_LINEAR:g} counts as super-linear.",
        "",
        "| with | largest | " + " | ".join(COSTS.values()) + " |",
        "|---|---|" + "---|" * len(COSTS),
    ]
    for name, title in PARAMETERS.items():
        cells = " | ".join(f"{results['exponents'][name][cost]['end']:.2f}" for cost in COSTS)
        lines.append(f"| {title} | {last[name]['x']:,} | {cells} |")
    each = ", ".join(f"{r['seconds']:.1f} s of {r['cameras']}" for r in results["matching"])
    lines += ["", f"With more cameras `--match-colours` takes most of what is more: {each} cameras."]
    lines += [
        "",
        f"Frames: meshes of {LONG_TRIANGLES} triangles and two pictures of 64x48, {PERIOD} frames again and again (a group never refers to "
        f"another, so repetition saves no bytes). Cameras: 160x90, 4 frames, {SIMPLE[1]:,} triangles. Triangles: one frame, a visual hull on a "
        "finer and finer grid, with 7 pictures of 480x270; first as it is on a lattice of 1 mm, then with the default budget, by which the stream "
        f"stops growing. Pixels: two cameras, 4 frames, {SIMPLE[1]:,} triangles, H.264 at 42 dB. `fvvmux` and `fvvdemux` on one thread, processor "
        "time; a finer hull is also smoother, so bytes per triangle fall.",
    ]
    return "\n".join(lines)


def headlines(results):
    """Bytes of the smallest points; times are not compared."""
    points = {"frames": 1, "cameras": 3, "kept_triangles": 2, "triangles": 2, "pixels": 2}
    return {f"{name}_bytes": results["rows"][name][i]["bytes"] for name, i in points.items()}


EXPERIMENTS = (experiment.Experiment("growth", "Growth", measure, draw, text, headlines),)
