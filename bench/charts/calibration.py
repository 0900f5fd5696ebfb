"""How precisely a calibration has to be written down: rounded parameters against pixels.

Cameras of the generated studio, with their lenses, at three widths of picture; points are spread over the scene. Each group of parameters
is rounded to 2^-bits of its unit while all others are exact: rotations (a quaternion), centres (metres), intrinsics and centres of pictures
(pixels). Static cameras are binary64 in the format and moving ones have the bits that the writer chooses, so no error here is a stream's
own; the chart says what fewer bits would cost.
"""

import json

import numpy as np

from . import drawing, experiment

WIDTHS = 480, 1920, 3840
GROUPS = {
    "rotation": "rotation, of a quaternion",
    "position": "position, of a metre",
    "pixels": "focal length and centre, of a pixel",
}
BITS = tuple(range(4, 31, 2))
DIGITS = 2, 3, 4, 5, 6
POINTS = 2000
TARGET = 0.01  # pixels; what fvvmux allows for cameras that move


def quaternion(rotation):
    """Of a rotation matrix, with the largest element positive."""
    r = rotation
    k = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], 0, 0, 0],
            [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], 0, 0],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], 0],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], np.trace(r)],
        ]
    )
    _, vectors = np.linalg.eigh(k)
    x, y, z, w = vectors[:, -1]
    return np.array([w, x, y, z])


def matrix(q):
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def project(camera, rotation, centre, intrinsics, points):
    """Pixels, by the radial-tangential model (spec/fvv.md, clause 9.1); coefficients k1 k2 p1 p2 k3..."""
    at = (points - centre) @ rotation.T
    x, y = at[:, 0] / at[:, 2], at[:, 1] / at[:, 2]
    k1, k2, p1, p2 = (list(camera["lens"].get("coefficients", ())) + [0] * 4)[:4]
    r2 = x * x + y * y
    d = 1 + k1 * r2 + k2 * r2 * r2
    x, y = x * d + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * d + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    fx, fy, cx, cy = intrinsics
    return np.stack([fx * x + cx, fy * y + cy], 1), at[:, 2] > 0.1


def rounded(value, step):
    return np.round(np.asarray(value) / step) * step


def errors(camera, width, points, change):
    """Distances in pixels of a picture of this width. change(group, values) returns what is written down."""
    rotation = np.reshape(camera["rotation"], (3, 3))
    centre = -rotation.T @ np.array(camera["translation"])
    intrinsics = (
        np.array([camera["intrinsics"][k] for k in ("fx", "fy", "cx", "cy")]) * width / camera["width"]
    )
    exact, front = project(camera, rotation, centre, intrinsics, points)
    coded = (
        matrix(change("rotation", quaternion(rotation))),
        change("position", centre),
        change("pixels", intrinsics),
    )
    found, _ = project(camera, *coded, points)
    inside = front & (exact >= 0).all(1) & (exact[:, 0] < width)
    return np.linalg.norm(found - exact, axis=1)[inside]


def largest(cameras, width, points, change):
    return float(max(e.max() for c in cameras if len(e := errors(c, width, points, change))))


def measure(quick):
    if quick:
        return None
    folder = experiment.capture("studio-one", "--frames", 1, "--size", "480x270")
    cameras = [
        c
        for c in json.loads((folder / "capture.json").read_text())["cameras"]
        if c["lens"]["model"] in ("none", "radtan")
    ]
    random = np.random.default_rng(1)
    points = random.uniform((-1.5, 0, -1.5), (1.5, 2, 1.5), (POINTS, 3))
    rows = {}
    for width in WIDTHS:
        rows[width] = {
            group: [
                largest(
                    cameras,
                    width,
                    points,
                    lambda g, v, group=group, b=b: rounded(v, 2.0**-b) if g == group else v,
                )
                for b in BITS
            ]
            for group in GROUPS
        }
    whole = {
        f"{digits} decimals": [
            largest(cameras, w, points, lambda g, v, d=digits: np.round(v, d)) for w in WIDTHS
        ]
        for digits in DIGITS
    }
    whole["binary32"] = [
        largest(cameras, w, points, lambda g, v: np.asarray(v, np.float32).astype(float)) for w in WIDTHS
    ]
    return {
        "bits": BITS,
        "widths": WIDTHS,
        "rows": {str(w): r for w, r in rows.items()},
        "whole": whole,
        "cameras": len(cameras),
    }


def draw(results, folder):
    figure, panels = drawing.sheet(3, 1, 3.7, 3.3)
    for axis, (group, title) in zip(panels, GROUPS.items()):
        for number, width in enumerate(results["widths"]):
            drawing.line(
                axis, number, results["bits"], results["rows"][str(width)][group], f"{width} pixels wide"
            )
        axis.axhline(TARGET, color=drawing.BLACK, linewidth=0.8, linestyle=":")
        axis.set_yscale("log")
        axis.set_ylim(1e-7, 1e3)
        axis.set_title(title[0].upper() + title[1:])
        axis.set_xlabel("bits after the binary point")
        axis.set_ylabel("largest error, pixels")
        axis.legend(loc="upper right")
    drawing.save(figure, folder / "calibration.svg")


def needed(results, width, group):
    """The fewest bits whose error is at most TARGET."""
    found = zip(results["bits"], results["rows"][str(width)][group])
    return next((bits for bits, error in found if error <= TARGET), None)


def text(results):
    widest = results["widths"][-1]
    need = {group: needed(results, widest, group) for group in GROUPS}
    header = "| written as | " + " | ".join(f"{w} pixels wide" for w in results["widths"]) + " |"
    lines = [header, "|" + "---|" * (1 + len(results["widths"]))]
    for name, row in results["whole"].items():
        lines.append(f"| {name} | " + " | ".join(f"{e:.2g} px" for e in row) + " |")
    table = "\n".join(lines)
    return f"""![Largest error in pixels over bits of each group of parameters](calibration.svg)

**A calibration for pictures of {widest} pixels needs {need['rotation']} bits of rotation, {need['position']} of position and {need['pixels']} of pixels for an error below {TARGET:g} pixels.**
CAMR, the camera that stands still, has binary64 for everything: 224 bytes once per stream, so nothing would be gained by less. CALB, for cameras
that move, has up to 25 bits of rotation and up to 40 of each of the others; fvvmux takes the fewest that move no point of the pictures by more than
{TARGET:g} pixels. Largest error over {results['cameras']} cameras of the studio and points all over the scene,
with all parameters rounded alike:

{table}

The paper does not say with how many digits its calibration text was written (about 600 bytes per camera). Rounding is not calibration error:
the [stability sheets](#what-they-say) have that."""


def defaults(results):
    widest = results["widths"][-1]
    need = ", ".join(f"{needed(results, widest, g)} of {g}" for g in GROUPS)
    return [
        (
            "bits of moving cameras",
            f"those for {TARGET:g} px",
            f"{need} keep {TARGET:g} px at {widest} pixels",
        )
    ]


EXPERIMENTS = (
    experiment.Experiment("calibration", "Precision of calibrations", measure, draw, text, defaults=defaults),
)
