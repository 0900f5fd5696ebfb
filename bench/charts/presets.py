"""The presets of fvvmux: how long they take, and what is lost for it."""

import os

from muxing import DEMO_OPTIONS, Muxing

from . import drawing, experiment, system, views

PRESETS = "live", "fast", "medium", "slow"
FRAMES = 50
PLACES = 13, 26  # degrees along the arc
LOOKED_AT = 4, 24, 44
COMPARED = "0-9"


def distances(source, stream):
    """Symmetric rms and Hausdorff distance from the source's meshes, mm."""
    found = experiment.answer("fvvcompare", source, stream, "--frames", COMPARED)["distance"]["symmetric"]
    return {"rms_mm": 1000 * found["rms"], "largest_mm": 1000 * found["max"]}


def row_of(made):
    """Processor time and wall time are of one run, on as many threads as there are cores."""
    return {
        "preset": made.summary["preset"],
        "bytes": made.summary["bytes"],
        "cpu_per_frame": made.seconds / FRAMES,
        "frames_per_s": made.summary["frames_per_second"],
        **{k: v for k, v in experiment.parts(made.summary).items() if k != "all_bytes"},
    }


def measure(quick):
    if quick:
        return None
    arc = views.Arc(FRAMES, PLACES)
    clips = {}
    for meshes in system.MESHES:
        source = system.clip(meshes, FRAMES)
        clips[meshes] = []
        for preset in PRESETS:
            made = experiment.packed(source, "--preset", preset)
            seen = views.measure(made.path, arc, frames=LOOKED_AT)
            clips[meshes].append(
                row_of(made)
                | {"psnr_db": seen["psnr_inside_db"], "ssim": seen["ssim_inside"]}
                | distances(source, made.path)
            )
    return {"cores": os.cpu_count(), "frames": FRAMES, "clips": clips, "practice": practice()}


def practice():
    """The default capture of fvvsynth, 13 cameras at 960x540, from PNG files and from H.264 files."""
    png = experiment.capture("practice", "--frames", FRAMES)
    maker = Muxing(experiment.program("fvvmux"), experiment.run, experiment.WORK / "captures")
    sources = {"png": png, "video": maker.with_videos(png)}
    return {
        name: [row_of(experiment.packed(source, "--preset", p, *DEMO_OPTIONS)) for p in PRESETS[:3]]
        for name, source in sources.items()
    }


def draw(results, folder):
    figure, panels = drawing.sheet(2, 2, 4.4, 3.1)
    for column, (meshes, rows) in zip((panels[::2], panels[1::2]), results["clips"].items()):
        seconds = [r["cpu_per_frame"] for r in rows]
        for axis, key, scale, label in (
            (column[0], "bytes", 1e-6, "MB for 50 frames"),
            (column[1], "psnr_db", 1, "held-out PSNR, dB"),
        ):
            drawing.line(axis, 0, seconds, [scale * r[key] for r in rows], None)
            for r, x in zip(rows, seconds):
                axis.annotate(
                    r["preset"],
                    (x, scale * r[key]),
                    textcoords="offset points",
                    xytext=(5, -12 if r["preset"] == "slow" else 5),
                    fontsize=8,
                )
            drawing.logarithmic(axis, "x", (0.05, 0.1, 0.2, 0.5, 1, 2))
            axis.margins(0.15)
            axis.set_ylabel(label)
        column[0].set_title(system.TITLES[meshes])
        column[1].set_xlabel("seconds of processor time a frame")
    drawing.save(figure, folder / "presets.svg")


def beside_medium(results, preset, key, pattern, compare):
    """compare(figure of a preset, of medium) for each clip, as text."""
    found = []
    for meshes, rows in results["clips"].items():
        at = {r["preset"]: r[key] for r in rows}
        found.append(pattern.format(compare(at[preset], at["medium"])) + f" ({meshes})")
    return " and ".join(found)


def text(results):
    def more(preset):
        return beside_medium(results, preset, "bytes", "{:+.0f} %", lambda a, b: 100 * (a / b - 1))

    def loss(preset):
        return beside_medium(results, preset, "psnr_db", "{:+.2f} dB", lambda a, b: a - b)

    lines = [
        "| capture | preset | frames/s | s of processor time a frame | bytes | held out, dB | SSIM | rms, mm | largest, mm |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for meshes, rows in results["clips"].items():
        for r in rows:
            lines.append(
                f"| {meshes}, 7 cameras at 480x270, PNG | {r['preset']} | {r['frames_per_s']:.1f} | {r['cpu_per_frame']:.3f} | {r['bytes']:,} "
                f"| {r['psnr_db']:.2f} | {r['ssim']:.4f} | {r['rms_mm']:.2f} | {r['largest_mm']:.1f} |"
            )
    for name, rows in results["practice"].items():
        for r in rows:
            lines.append(
                f"| practice, 13 cameras at 960x540, {name} | {r['preset']} | {r['frames_per_s']:.1f} | {r['cpu_per_frame']:.3f} | {r['bytes']:,} | | | | |"
            )
    return f"""![Bytes and held-out PSNR over processor time, by preset](presets.svg)

**Against medium, live takes {more('live')} bytes and changes the picture from between the cameras by {loss('live')}; fast takes {more('fast')} and changes it by {loss('fast')}.** {results['frames']} frames at 25 frames per second; the error of meshes is that of frames {COMPARED} against the
source, by fvvcompare. Frames per second are of one run on {results['cores']} cores, with whatever else ran there; processor time depends less on that.

{chr(10).join(lines)}"""


def defaults(results):
    times = beside_medium(results, "fast", "cpu_per_frame", "{:.1f} times", lambda a, b: b / a)
    return [("fvvmux --preset", "medium", f"takes {times} as long as fast")]


EXPERIMENTS = (experiment.Experiment("presets", "The presets", measure, draw, text, defaults=defaults),)
