#!/usr/bin/env python3
"""Each camera of wd2_human20 drawn from the others and compared with what it took: how good a picture from a new place is.

The pictures are coded at JPEG's quality 100 and the mesh is the visual hull that comes with the capture, so that what is
measured is geometry, calibration, exposure and the method of texturing. Sources are all 19 other cameras, or the 7 whose
rays to the middle of the mesh are nearest to the target's. PSNR and SSIM (Wang et al. 2004, Gaussian window of 11 x 11
pixels) are of BT.709 luma, over the pixels that belong to the silhouette and show the mesh; everything else is the same
grey in both. What no camera shows is drawn grey, and counts.

    python bench/leave_one_out.py

prints the table; ./run bench wd2 its means.
"""

import json
import os
import pathlib
import subprocess
import sys

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "conformance/real"))
import wd2_human20  # noqa: E402
from real_capture import DATA, TOOLS, read_ply, write_capture  # noqa: E402

WORK = pathlib.Path(__file__).resolve().parent.parent / "build/bench/wd2"
NEAREST = 7
GREY = 128.0


def tool(name, *arguments):
    done = subprocess.run([TOOLS / name / name, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"leave_one_out: {name} answered {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def blurred(picture):
    """Gaussian of 11 x 11 pixels, standard deviation 1.5; pictures shrink by 10."""
    taps = np.exp(-(np.arange(-5, 6) ** 2) / (2 * 1.5**2))
    taps /= taps.sum()
    height, width = picture.shape
    rows = sum(t * picture[i : height - 10 + i] for i, t in enumerate(taps))
    return sum(t * rows[:, i : width - 10 + i] for i, t in enumerate(taps))


def ssim(a, b, mask):
    """Mean over the windows whose middle is in mask."""
    mean_a, mean_b = blurred(a), blurred(b)
    variance_a, variance_b = blurred(a * a) - mean_a**2, blurred(b * b) - mean_b**2
    covariance = blurred(a * b) - mean_a * mean_b
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    index = (2 * mean_a * mean_b + c1) * (2 * covariance + c2)
    index /= (mean_a**2 + mean_b**2 + c1) * (variance_a + variance_b + c2)
    return index[mask[5:-5, 5:-5]].mean()


def nearest(cameras, target, middle):
    """Identifiers of the cameras that see the middle of the mesh from the directions nearest to the target's."""

    def direction(camera):
        rotation, translation = camera["Rt"][:, :3], camera["Rt"][:, 3]
        ray = -rotation.T @ translation - middle
        return ray / np.linalg.norm(ray)

    others = [c for c in cameras if c is not target]
    others.sort(key=lambda c: -(direction(c) @ direction(target)))
    return sorted(c["id"] for c in others[:NEAREST])


def compare(root, camera, stream, sources):
    """One row: PSNR, SSIM, the share of the silhouette that the mesh covers, that of the mesh that no camera shows."""
    out, mask_file = WORK / f"{camera['id']}-{len(sources) or 'all'}.png", WORK / "mask.png"
    chosen = ["--sources", ",".join(map(str, sources))] if sources else []
    drawn = json.loads(
        tool("fvvrender", stream, "-o", out, "--camera", camera["id"], "--leave-one-out", "--mask", mask_file,
             "--json", "--force", *chosen)
    )  # fmt: skip
    silhouette = root / f"wd_segmented/WD2_{camera['id']}_00020_segmented.png"
    silhouette = np.asarray(Image.open(silhouette).convert("L")) > 128
    mask = silhouette & (np.asarray(Image.open(mask_file)) > 128)
    pictures = [
        np.where(mask, wd2_human20.luma(path), GREY)
        for path in (root / f"wd_data/WD2_{camera['id']}_00020.png", out)
    ]
    error = ((pictures[0] - pictures[1])[mask] ** 2).mean()
    psnr = 10 * np.log10(255**2 / error)
    return psnr, ssim(*pictures, mask), mask.sum() / silhouette.sum(), drawn["share_by_cameras"][0]


def turned_over(source, path):
    """The capture's mesh has its faces wound clockwise: all turned, as OBJ. Answers the positions."""
    positions, faces = read_ply(source)
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in positions.tolist()]
    lines += [f"f {c + 1} {b + 1} {a + 1}" for a, b, c in faces.tolist()]
    path.write_text("\n".join(lines) + "\n")
    return positions


def measure():
    """Figures for bench.py, none without the data; prints the table."""
    root = DATA / "wd2_human20"
    if not root.exists():
        print(f"wd2: skipped: no wd2_human20 under FVV_DATA={os.path.relpath(DATA)}")
        return {}
    description, cameras = wd2_human20.describe(root)
    WORK.mkdir(parents=True, exist_ok=True)
    description["meshes"] = {"pattern": "mesh_%04d.obj"}
    middle = turned_over(root / wd2_human20.MESH, WORK / "mesh_0020.obj").mean(0)
    capture, stream = write_capture(WORK, description), WORK / "wd2.fvv"
    tool("fvvmux", capture, "-o", stream, "--codec", "jpeg", "--quality", "100", "--keep-geometry", "--force")
    rows = {"all": [], "nearest": []}
    print(f"{'camera':8}{'from all others':>32}{f'from the nearest {NEAREST}':>32}{'covered %':>12}")
    print(f"{'':8}" + f"{'PSNR dB':>12}{'SSIM':>8}{'unseen %':>12}" * 2)
    for camera in cameras:
        pair = [compare(root, camera, stream, s) for s in ([], nearest(cameras, camera, middle))]
        for name, row in zip(rows, pair):
            rows[name].append(row)
        cells = "".join(f"{row[0]:12.2f}{row[1]:8.4f}{100 * row[3]:12.2f}" for row in pair)
        print(f"{camera['id']:<8}{cells}{100 * pair[0][2]:12.2f}", flush=True)
    means = {name: np.mean(row, 0) for name, row in rows.items()}
    return {
        "wd2.leave_one_out_psnr_db": means["all"][0],
        "wd2.leave_one_out_ssim": means["all"][1],
        "wd2.leave_one_out_unseen_share": means["all"][3],
        "wd2.nearest_7_psnr_db": means["nearest"][0],
        "wd2.nearest_7_ssim": means["nearest"][1],
        "wd2.nearest_7_unseen_share": means["nearest"][3],
    }


if __name__ == "__main__":
    for figure, value in measure().items():
        print(f"{figure:32} {value:12.4f}")
