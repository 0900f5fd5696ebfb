#!/usr/bin/env python3
"""Draws each camera of wd2_human20 from the others and compares the picture with the real one: the quality of a new viewpoint.

The pictures are coded at JPEG's quality 100 and the mesh is the visual hull that comes with the capture, so the
figures measure geometry, calibration, exposure and the method of texturing. Sources are all 19 other cameras, or the 7 whose
rays to the centre of the mesh are nearest to the target's. PSNR and SSIM (Wang et al. 2004, Gaussian window of 11 x 11
pixels) are of BT.709 luma, over the pixels that belong to the silhouette and show the mesh; everything else is the same
grey in both. Surface that no camera shows is drawn grey, and counts. Everything is drawn three times: with visibility by depth maps, by the
bits of the stream (face bits, fvvmux --visibility face), and by rays, which are exact.

    python bench/leave_one_out.py

prints the table; ./run bench wd2 prints its means.
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
from real_capture import DATA, TOOLS, luma, read_ply  # noqa: E402

WORK = pathlib.Path(__file__).resolve().parent.parent / "build/bench/wd2"
NEAREST = 7
WAYS = ("depth", "bits", "rays")
GREY = 128.0


def tool(name, *arguments):
    done = subprocess.run([TOOLS / name / name, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"leave_one_out: {name} returned {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def blurred(picture):
    """Gaussian of 11 x 11 pixels, standard deviation 1.5; pictures shrink by 10."""
    taps = np.exp(-(np.arange(-5, 6) ** 2) / (2 * 1.5**2))
    taps /= taps.sum()
    height, width = picture.shape
    rows = sum(t * picture[i : height - 10 + i] for i, t in enumerate(taps))
    return sum(t * rows[:, i : width - 10 + i] for i, t in enumerate(taps))


def ssim(a, b, mask):
    """The mean over windows with their centre in mask."""
    mean_a, mean_b = blurred(a), blurred(b)
    variance_a, variance_b = blurred(a * a) - mean_a**2, blurred(b * b) - mean_b**2
    covariance = blurred(a * b) - mean_a * mean_b
    c1, c2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    index = (2 * mean_a * mean_b + c1) * (2 * covariance + c2)
    index /= (mean_a**2 + mean_b**2 + c1) * (variance_a + variance_b + c2)
    return index[mask[5:-5, 5:-5]].mean()


def nearest(cameras, target, middle):
    """Identifiers of the cameras whose direction to the centre of the mesh is nearest to the target's."""

    def direction(camera):
        rotation, translation = camera["Rt"][:, :3], camera["Rt"][:, 3]
        ray = -rotation.T @ translation - middle
        return ray / np.linalg.norm(ray)

    others = [c for c in cameras if c is not target]
    others.sort(key=lambda c: -(direction(c) @ direction(target)))
    return sorted(c["id"] for c in others[:NEAREST])


def compare(root, camera, stream, sources, way):
    """One cell: PSNR, SSIM, the part of the silhouette that the mesh covers, the part of the mesh that no camera shows."""
    out, mask_file = WORK / f"{camera['id']}-{len(sources) or 'all'}-{way}.png", WORK / "mask.png"
    chosen = ["--sources", ",".join(map(str, sources))] if sources else []
    drawn = json.loads(
        tool("fvvrender", stream, "-o", out, "--camera", camera["id"], "--leave-one-out", "--mask", mask_file,
             "--json", "--force", "--visible-by", way, *chosen)
    )  # fmt: skip
    silhouette = root / f"wd_segmented/WD2_{camera['id']}_00020_segmented.png"
    silhouette = np.asarray(Image.open(silhouette).convert("L")) > 128
    mask = silhouette & (np.asarray(Image.open(mask_file)) > 128)
    pictures = [
        np.where(mask, luma(path), GREY) for path in (root / f"wd_data/WD2_{camera['id']}_00020.png", out)
    ]
    error = ((pictures[0] - pictures[1])[mask] ** 2).mean()
    psnr = 10 * np.log10(255**2 / error)
    return psnr, ssim(*pictures, mask), mask.sum() / silhouette.sum(), drawn["share_by_cameras"][0]


def cells_of(row):
    return "".join(f"{cell[0]:8.2f}" for cell in row) + "".join(f"{cell[1]:8.4f}" for cell in row)


def figures(means):
    """Figures by bits, as fvvrender draws by default, and the difference to the other ways."""
    out = {}
    for name, rows in means.items():
        by = dict(zip(WAYS, rows))
        out |= {
            f"wd2.{name}_{what}": by["bits"][i]
            for i, what in ((0, "psnr_db"), (1, "ssim"), (3, "unseen_share"))
        }
        for way in "depth", "rays":
            out |= {f"wd2.{name}_by_{way}_{what}": by[way][i] for i, what in ((0, "psnr_db"), (1, "ssim"))}
        gain, similar = by["bits"][0] - by["depth"][0], by["bits"][1] - by["depth"][1]
        # A smaller difference does not show in a figure of two decimals.
        verdict = "no worse" if gain > -0.005 and similar > -0.0005 else "WORSE"
        print(f"{name}: bits are {verdict} than depth maps: {gain:+.3f} dB, SSIM {similar:+.4f}")
    return out


WINDING = wd2_human20.WINDING


def capture():
    """The path of the capture, or None without the data."""
    root = DATA / "wd2_human20"
    if not root.exists():
        print(f"wd2: skipped: no wd2_human20 under FVV_DATA={os.path.relpath(DATA)}")
        return None
    return wd2_human20.describe(root, WORK)


def measure():
    """Prints the table and returns the figures for bench.py; none without the data."""
    source = capture()
    if not source:
        return {}
    root = DATA / "wd2_human20"
    cameras = wd2_human20.cameras(root / wd2_human20.CALIBRATION)
    middle = read_ply(root / wd2_human20.MESH)[0].mean(0)
    stream = WORK / "wd2.fvv"
    tool("fvvmux", source, "-o", stream, "--codec", "jpeg", "--quality", "100", "--keep-geometry",
         "--visibility", "face", *WINDING, "--force")  # fmt: skip
    rows = {name: [] for name in ("leave_one_out", f"nearest_{NEAREST}")}
    titles = "from all others", f"from the nearest {NEAREST}"
    print(f"{'':8}" + "".join(f"{title:>48}" for title in titles))
    ways = "".join(f"{way:>8}" for way in WAYS)
    print(f"{'':8}" + f"{'PSNR dB':>24}{'SSIM':>24}" * 2)
    print(f"{'camera':8}{ways * 4}{'covered %':>12}")
    for camera in cameras:
        cells = ""
        for name, sources in zip(rows, ([], nearest(cameras, camera, middle))):
            row = [compare(root, camera, stream, sources, way) for way in WAYS]
            rows[name].append(row)
            cells += cells_of(row)
        print(f"{camera['id']:<8}{cells}{100 * row[0][2]:12.2f}", flush=True)
    means = {name: np.mean(row, 0) for name, row in rows.items()}
    print(f"{'mean':8}" + "".join(cells_of(mean) for mean in means.values()))
    return figures(means)


if __name__ == "__main__":
    for figure, value in measure().items():
        print(f"{figure:32} {value:12.4f}")
