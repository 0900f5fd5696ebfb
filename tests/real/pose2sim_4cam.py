#!/usr/bin/env python3
"""pose2sim_4cam: four synchronised videos, Qualisys calibration with distortion, no mesh; through fvv and back."""

import json
import xml.etree.ElementTree as xml

import numpy as np
import real_capture as real

SOURCE = "pose2sim_4cam/Demo_SinglePerson"
FRAMES = 30  # of 100, at 60 a second
QUALITY = 40.0
SCALE = 0.25  # all sizes are multiples of 4
CALIBRATION = "calibration/Calib.qca.txt"


def cameras(path):
    """The source's own numbers: name, K and k1 k2 p1 p2 with pixel centres at integers, R and t of OpenCV."""
    out = []
    for camera in xml.parse(path).getroot().iter("camera"):
        i = {key: float(value) for key, value in camera.find("intrinsic").attrib.items()}
        t = {key: float(value) for key, value in camera.find("transform").attrib.items()}
        flip = np.diag([1.0, -1.0, -1.0])  # its cameras look down their z axis, y up
        rotation = np.array([[t[f"r{r}{c}"] for c in (1, 2, 3)] for r in (1, 2, 3)]).T
        centre = np.array([t["x"], t["y"], t["z"]]) / 1000
        matrix = np.array(
            [
                [i["focalLengthU"] / 64, 0, i["centerPointU"] / 64],
                [0, i["focalLengthV"] / 64, i["centerPointV"] / 64],
                [0, 0, 1],
            ]
        )
        lens = [i[f"{kind}Distortion{n}"] for kind in ("radial", "tangental") for n in (1, 2)]
        out.append((camera.get("serial"), matrix, lens, flip @ rotation.T, -flip @ rotation.T @ centre))
    return out


def project(matrix, lens, rotation, translation, points):
    """Brown-Conrady with k1 k2 p1 p2."""
    local = points @ rotation.T + translation
    x, y = local[:, 0] / local[:, 2], local[:, 1] / local[:, 2]
    r2 = x**2 + y**2
    radial = 1 + lens[0] * r2 + lens[1] * r2**2
    u = x * radial + 2 * lens[2] * x * y + lens[3] * (r2 + 2 * x**2)
    v = y * radial + lens[2] * (r2 + 2 * y**2) + 2 * lens[3] * x * y
    return np.column_stack([u, v]) @ matrix[:2, :2].T + matrix[:2, 2]


def describe(root, folder):
    """Has fvvimport write the capture and returns its path."""
    calibration = root / CALIBRATION
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "capture.json"
    real.tool(
        *("fvvimport", "qualisys", calibration, "-o", path, "--force", "--up", "+z", "--frame-rate", 60),
        *("--frames", f"0-{FRAMES - 1}", "--videos", f"{root}/videos/{{name}}.mp4"),
    )
    description = json.loads(path.read_text())
    for camera in description["cameras"][:2]:
        # Two videos lack the last 8 of the 1088 columns that were calibrated.
        camera["width"] = 1080
    path.write_text(json.dumps(description, indent=1))
    return path


def main():
    root = real.data(SOURCE)
    path = describe(root, real.WORK / "pose2sim_4cam")
    frames = ["--frames", f"0-{FRAMES - 1}"]  # or else fvvmux warns of the pictures after them
    summary, _, out = real.round_trip(path, "--quality", f"{QUALITY:g}dB", "--scale", SCALE, *frames)
    real.contact_sheet(path)

    for source in summary["sources"]:
        name = source["file"].rsplit("/", 1)[-1]
        real.figure(f"{name}: frames with a picture of their time", source["met"], FRAMES, at_most=False)
        real.figure(f"{name}: largest offset, seconds", source["largest_offset"], 0.25 / 60)
    real.figure("PSNR that was verified, dB", summary["verified"]["psnr"], QUALITY - 0.3, at_most=False)

    source = cameras(root / CALIBRATION)
    written = json.loads((out / "capture.json").read_text())["cameras"]
    real.figure("cameras", len(written), len(source), at_most=False)
    # Points in front of all cameras: where their axes meet.
    points = np.array([-0.94, -0.02, 0.59]) + np.random.default_rng(1).uniform(-0.8, 0.8, (500, 3))
    reprojection = 0.0
    for (_, matrix, lens, rotation, translation), w in zip(source, written, strict=True):
        i = w["intrinsics"]
        ours = np.array([[i["fx"], i.get("skew", 0), i["cx"]], [0, i["fy"], i["cy"]], [0, 0, 1]])
        there = project(
            ours, w["lens"]["coefficients"][:4], np.array(w["rotation"]), np.array(w["translation"]), points
        )
        here = project(matrix, lens, rotation, translation, points) + 0.5
        reprojection = max(reprojection, np.abs(there / SCALE - here).max())
    real.figure("largest reprojection difference, pixels", reprojection, 1e-4)
    real.finish()


if __name__ == "__main__":
    main()
