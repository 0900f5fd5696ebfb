#!/usr/bin/env python3
"""wd2_human20: 20 calibrated cameras around a person, one frame, visual hull; through fvv and back."""

import json

import numpy as np
import real_capture as real
from PIL import Image

SOURCE = "wd2_human20"
QUALITY = 42.0  # dB over the silhouettes
WINDING = "--winding", "flip"  # the source's faces run clockwise, seen from outside
CALIBRATION = "calibParamsI.txt"
MESH = "reference/our_visual_hull_160.ply"


def cameras(path):
    """The source's own numbers: id, K (3x3, with skew), k1 k2, [R|t] (3x4); pixel centres at integers."""
    words = [line.split() for line in path.read_text().splitlines() if line.strip()]
    out = []
    for at in range(0, len(words), 8):
        rows = [np.array(row, float) for row in words[at + 1 : at + 8]]
        out.append(
            {"id": int(words[at][0]), "K": np.array(rows[:3]), "k": rows[3], "Rt": np.array(rows[4:7])}
        )
    return out


def project(matrix, k, transform, points):
    """Pinhole with k1 k2 of the usual radial model."""
    local = points @ transform[:, :3].T + transform[:, 3]
    xy = local[:, :2] / local[:, 2:]
    r2 = (xy**2).sum(1, keepdims=True)
    xy = xy * (1 + k[0] * r2 + k[1] * r2**2)
    return xy @ matrix[:2, :2].T + matrix[:2, 2]


def describe(root, folder):
    """Returns the path of the capture."""
    description = {
        "fvv_capture": 1,
        "name": "wd2_human20",
        "frame_rate": "25",
        "frames": {"first": 20, "count": 1},
        "units": "unknown",
        "up": "-y",
        "conventions": {"pixel_centre": 0},
        "meshes": {"pattern": str(root / MESH)},
        "cameras": [
            {
                "id": c["id"],
                "name": f"WD2_{c['id']}",
                "width": 1024,
                "height": 768,
                "intrinsics": {
                    "fx": c["K"][0, 0],
                    "fy": c["K"][1, 1],
                    "cx": c["K"][0, 2],
                    "cy": c["K"][1, 2],
                    "skew": c["K"][0, 1],
                },
                "lens": {"model": "radtan", "coefficients": [c["k"][0], c["k"][1], 0, 0]},
                "rotation": c["Rt"][:, :3].tolist(),
                "translation": c["Rt"][:, 3].tolist(),
                "pictures": str(root / f"wd_data/WD2_{c['id']}_%05d.png"),
                "masks": str(root / f"wd_segmented/WD2_{c['id']}_%05d_segmented.png"),
            }
            for c in cameras(root / CALIBRATION)
        ],
    }
    return real.write_capture(folder, description)


def main():
    root = real.data(SOURCE)
    source = cameras(root / CALIBRATION)
    capture = describe(root, real.WORK / "wd2_human20")
    # The pictures are compared with the source's, so they are coded as they are.
    options = "--quality", f"{QUALITY:g}dB", "--match-colours", "off"
    _, info, out = real.round_trip(capture, *options, *WINDING)
    real.contact_sheet(capture, iou=0.95)

    positions, faces = real.read_ply(root / MESH)
    decoded = real.read_ply(out / "meshes/0020.ply")
    real.figure("vertices decoded", len(decoded[0]), 17264, at_most=False)
    real.compare_meshes("mesh", (positions, faces), decoded, info["scene"]["lattice_step"])

    written = {c["id"]: c for c in json.loads((out / "capture.json").read_text())["cameras"]}
    reprojection = 0.0
    for c in source:
        w = written[c["id"]]
        i = w["intrinsics"]
        matrix = np.array([[i["fx"], i.get("skew", 0), i["cx"]], [0, i["fy"], i["cy"]], [0, 0, 1]])
        transform = np.column_stack([np.array(w["rotation"]), np.array(w["translation"])])
        there = project(matrix, w["lens"]["coefficients"], transform, positions)
        here = project(c["K"], c["k"], c["Rt"], positions) + 0.5
        reprojection = max(reprojection, np.abs(there - here).max())
    real.figure("cameras", len(written), 20, at_most=False)
    real.figure("largest reprojection difference, pixels", reprojection, 1e-4)

    squares, pixels, worst = 0.0, 0, np.inf
    for c in source:
        picture = real.luma(root / f"wd_data/WD2_{c['id']}_00020.png")
        mask = (
            np.asarray(Image.open(root / f"wd_segmented/WD2_{c['id']}_00020_segmented.png").convert("L"))
            > 128
        )
        error = ((picture - real.luma(out / f"cam{c['id']}/0020.png")) ** 2)[mask]
        worst = min(worst, 10 * np.log10(255**2 / error.mean()))
        squares, pixels = squares + error.sum(), pixels + error.size
    real.figure(
        "PSNR over the silhouettes of all cameras, dB",
        10 * np.log10(255**2 * pixels / squares),
        QUALITY - 0.05,
        False,
    )
    print(f"PSNR of the worst camera: {worst:.2f} dB")
    real.finish()


if __name__ == "__main__":
    main()
