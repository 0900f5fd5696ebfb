"""Where views break: far from the nearest camera, near to the surface or far away, and while the viewer walks."""

import json

import numpy as np
import view_quality
from PIL import Image
from real_capture import luma

from .. import degradations, drawing, experiment, views
from . import camera as filmed

DEGREES = range(0, 31, 3)
WALK = range(0, 13)
FRAME = 1
MESHES = {"tracked": "exact mesh", "hull": "visual hull"}
THRESHOLDS = 0, 0.05, 0.1, 0.25, 0.4, 0.6
SIZES = {"120x68": 1 / 4, "240x136": 1 / 2, "480x270": 1, "960x540": 2, "1920x1080": 4}
MIDDLE = 0, 1, 0  # of the scene


def stream_of(meshes):
    source = filmed.clip() if meshes == "tracked" else experiment.capture(
        "small-hull", "--rig", "small", "--meshes", "hull", "--frames", 12)  # fmt: skip
    return experiment.packed(source, "--quality", "42dB").path


def angles():
    """PSNR of each view of the arc, over the angle from the nearest camera as the middle of the scene sees both."""
    cameras = [degradations.centre_of(c) - MIDDLE for c in filmed.clip_cameras()]
    rows = []
    for view in DEGREES:
        arc = filmed.arc((view,))
        eye = arc.place(view) - MIDDLE
        row = {"degrees": min(degradations.degrees_between(eye, c) for c in cameras), "view": view}
        for meshes in MESHES:
            row[f"{meshes}_db"] = views.measure(stream_of(meshes), arc, frames=(FRAME,))["psnr_inside_db"]
        rows.append(row)
    return {"rows": sorted(rows, key=lambda r: r["degrees"])}


def drawn(stream, camera, size, *options):
    """Luma of what a camera of the arc would see."""
    _, pose, _, focal, *_ = view_quality.pose_of(camera)
    out = experiment.WORK / "view.png"
    return views.draw(stream, FRAME, ("--pose", pose, "--focal", focal, "--size", size), out, *options)


def psnr(truth, picture, mask):
    return 10 * np.log10(255**2 / ((truth - picture)[mask] ** 2).mean())


def distances():
    """The same view in other sizes: a viewer four times as near sees four times as many pixels of a surface.

    Beside it the truth at the size of the cameras, enlarged or reduced: what a camera in this place could give."""
    filmed = {}
    for size in SIZES:
        folder = experiment.capture(
            "zoom", "--rig", "arc", "--cameras", 1, "--frames", FRAME + 1, "--size", size
        )
        camera = json.loads((folder / "capture.json").read_text())["cameras"][0]
        mask = np.asarray(Image.open(folder / (camera["masks"] % FRAME)).convert("L")) > 128
        filmed[size] = folder / (camera["pictures"] % FRAME), mask, camera
    rows = []
    for size, factor in SIZES.items():
        path, mask, camera = filmed[size]
        truth = luma(path)
        row = {"factor": factor}
        for meshes in MESHES:
            for samples in (1, 3) if factor < 1 else (1,):
                picture = drawn(stream_of(meshes), camera, size, "--samples", samples)
                row[f"{meshes}_{samples}_db"] = psnr(truth, picture, mask)
        if factor > 1:
            small = Image.open(filmed["480x270"][0]).convert("RGB")
            enlarged = np.asarray(small.resize(truth.shape[::-1], Image.Resampling.BICUBIC), float) @ [
                0.2126,
                0.7152,
                0.0722,
            ]
            row["camera_db"] = psnr(truth, enlarged, mask)
        rows.append(row)
    return {"rows": rows}


def walk():
    """How much a drawn picture changes from step to step of a degree, as a ratio to the truth; second differences show jumps."""
    arc = filmed.arc(WALK)
    found = [arc.truth(view, FRAME) for view in WALK]
    masks = [mask for _, mask in found]
    truth = view_quality.changes([picture for picture, _ in found], masks)
    rows = []
    for threshold in THRESHOLDS:
        row = {"threshold": threshold}
        for meshes in MESHES:
            pictures = [
                views.draw(
                    stream_of(meshes),
                    FRAME,
                    arc.options(view),
                    experiment.WORK / "view.png",
                    "--threshold",
                    threshold,
                )
                for view in WALK
            ]
            row[f"{meshes}_change"], row[f"{meshes}_jumps"] = view_quality.changes(pictures, masks) / truth
        rows.append(row)
    return {"rows": rows}


def measure(quick):
    return None if quick else {"angles": angles(), "distances": distances(), "walk": walk()}


def draw(results, folder):
    figure, panels = drawing.sheet(3, 1, 3.6, 3.0)
    rows = results["angles"]["rows"]
    for number, (meshes, label) in enumerate(MESHES.items()):
        drawing.line(
            panels[0],
            number,
            [r["degrees"] for r in rows],
            [r[f"{meshes}_db"] for r in rows],
            label,
            linestyle="",
        )
    panels[0].set(
        title="Away from the nearest camera",
        xlabel="degrees from the nearest camera",
        ylabel="PSNR inside, dB",
    )
    panels[0].legend(loc="best")
    rows = results["distances"]["rows"]
    for number, (meshes, label) in enumerate(MESHES.items()):
        drawing.line(
            panels[1], number, [r["factor"] for r in rows], [r[f"{meshes}_1_db"] for r in rows], label
        )
    far = [r for r in rows if "tracked_3_db" in r]
    drawing.line(
        panels[1],
        2,
        [r["factor"] for r in far],
        [r["tracked_3_db"] for r in far],
        "exact, --samples 3",
        linestyle=":",
    )
    near = [r for r in rows if "camera_db" in r]
    drawing.line(
        panels[1],
        6,
        [r["factor"] for r in near],
        [r["camera_db"] for r in near],
        "a camera there, enlarged",
        linestyle=":",
    )
    drawing.logarithmic(panels[1], "x", (0.25, 0.5, 1, 2, 4))
    panels[1].set(
        title="Near and far", xlabel="pixels of the viewer for one of a camera", ylabel="PSNR inside, dB"
    )
    panels[1].set_ylim(16.5, None)
    panels[1].legend(loc="lower left")
    rows = results["walk"]["rows"]
    for number, (meshes, label) in enumerate(MESHES.items()):
        x = [r["threshold"] for r in rows]
        drawing.line(panels[2], number, x, [r[f"{meshes}_jumps"] for r in rows], f"{label}, jumps")
        drawing.line(
            panels[2], number + 2, x, [r[f"{meshes}_change"] for r in rows], f"{label}, change", linestyle=":"
        )
    panels[2].axhline(1, color=drawing.BLACK, linewidth=0.8, linestyle="--")
    drawing.mark(panels[2], 0.05, "default", 0.56)
    drawing.mark(panels[2], 0.25, "WHP 235", 0.56)
    panels[2].set_ylim(0.6, 1.25)
    panels[2].set(
        title="While the viewer walks", xlabel="threshold of the cosine", ylabel="ratio to the truth (dashed)"
    )
    panels[2].legend(loc="upper right")
    drawing.save(figure, folder / "stability-view.svg")


def text(results):
    rows, distance, steps = results["angles"]["rows"], results["distances"]["rows"], results["walk"]["rows"]
    near, far = rows[0], rows[-1]
    default = next(r for r in steps if r["threshold"] == 0.05)
    paper = next(r for r in steps if r["threshold"] == 0.25)
    worst = max(steps, key=lambda r: r["tracked_jumps"])
    four = next(r for r in distance if r["factor"] == 4)
    quarter = next(r for r in distance if r["factor"] == 0.25)
    return "\n".join(
        [
            "![Quality of views over angle, distance and threshold](stability-view.svg)",
            "",
            f"**From {near['degrees']:.0f} to {far['degrees']:.0f} degrees from the nearest camera a view goes from {near['tracked_db']:.1f} to "
            f"{far['tracked_db']:.1f} dB with an exact mesh, and from {near['hull_db']:.1f} to {far['hull_db']:.1f} dB with a visual hull.**",
            "",
            f"- Near: at four times the cameras' resolution {four['tracked_1_db']:.1f} dB; a camera in the viewer's place, enlarged, would give "
            f"{four['camera_db']:.1f} dB. Far: at a quarter {quarter['tracked_1_db']:.1f} dB with one sample per pixel, {quarter['tracked_3_db']:.1f} dB "
            "with nine. Sizes stand for distances: the perspective stays that of 4.5 m.",
            f"- Popping: while the viewer walks by steps of one degree, second differences, in which jumps show, are {default['tracked_jumps']:.2f} "
            f"times those of the truth at the default threshold of 0.05 ({default['hull_jumps']:.2f} with a hull), {paper['tracked_jumps']:.2f} "
            f"({paper['hull_jumps']:.2f}) at the 0.25 of WHP 235, and at most {worst['tracked_jumps']:.2f} at {worst['threshold']:g}. "
            "Below 1 a picture is smoother than the truth, which is not popping but blur.",
            "",
            f"7 cameras of 480x270 about 51 degrees apart, H.264 at 42 dB, frame {FRAME}, PSNR inside the true silhouette.",
        ]
    )


def defaults(results):
    rows = {r["threshold"]: r for r in results["walk"]["rows"]}
    said = ", ".join(f"{rows[t]['tracked_jumps']:.2f} at {t:g}" for t in (0, 0.05, 0.25))
    return [
        (
            "fvvmux --texture-threshold",
            "0.05",
            f"second differences while the viewer walks, of the truth's: {said}",
        )
    ]


EXPERIMENTS = (
    experiment.Experiment("stability-view", "Where views break", measure, draw, text, defaults=defaults),
)
