#!/usr/bin/env python3
"""How good drawn pictures are: from places where a camera stood, and while the viewer walks.

Leave-one-out draws each camera of a capture from the others and compares the picture with the real one. Captures: wd2_human20 (a person, 20 cameras, the visual hull that comes with it), middlebury_temple (a statue, 47 views, every
fourth is drawn; a hull of voxels, smoothed), and a generated one (the studio of fvvsynth, a hull). Pictures are coded at JPEG's
quality 100 and meshes are kept, so the figures measure geometry, calibration, exposure and the method of texturing. Sources are
all other cameras, or the 8, 4 or 2 whose rays to the middle of the scene are nearest to the target's. PSNR and SSIM (Wang et al.
2004, Gaussian window of 11 x 11 pixels) are of BT.709 luma, FLIP (recordings/perceptual.py) of colours, over the pixels that belong to the silhouette and show the mesh;
everything else is the same grey in both. Surface without colour counts as it is drawn. Every row is drawn with both blends of
clause 17.5.

Flicker is how much a drawn picture changes while the viewer walks, against how much the truth changes, on the generated capture.
The truth is filmed by cameras one degree apart (fvvsynth --rig arc); fvvrender draws the same views from the 13 cameras of
the studio and their hull. Of each step the change is the mean absolute difference of luma over the pixels that belong to both
silhouettes; the ratio is that of the sums over all steps. Smooth motion changes both alike, so jumps are looked for in second
differences, p(i - 1) - 2 p(i) + p(i + 1), in the same way. A still scene, the same frame twice, must give the same picture.

    python bench/view_quality.py [wd2|temple|generated|flicker|closeups...]

prints the tables, and draws close-ups into build/bench/closeups: as WHP 235 blended, with grey where no camera sees the surface;
by the viewer's direction, with colours of vertices; and the picture of the camera, which is no source. ./run bench picture prints the figures.
"""

import functools
import json
import os
import pathlib
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "tests/real"), str(ROOT / "bench")]
import middlebury_temple  # noqa: E402
import wd2_human20  # noqa: E402
from real_capture import DATA, TOOLS, luma, read_ply  # noqa: E402
from recordings.perceptual import flip  # noqa: E402

WORK = ROOT / "build/bench/picture"
FLICKER = ROOT / "build/bench/flicker"
STEPS = 30
SIZE = 480, 270
CLOSEUPS = ROOT / "build/bench/closeups"
MAGNIFIED = 4
# Of each capture, what, of which camera, and the middle of the square in its picture.
PLACES = {
    "generated": [("chin", 4, 514, 125), ("ball and hand", 4, 458, 336), ("hems", 4, 385, 396),
                  ("hair", 6, 501, 195), ("arms", 9, 320, 165)],
    "wd2": [("face", 0, 499, 125), ("hand", 0, 408, 424), ("hand", 0, 645, 315), ("foot", 0, 452, 690),
            ("foot", 0, 594, 600), ("hem", 0, 450, 550), ("hand", 5, 543, 424), ("hair", 5, 478, 118)],
    "temple": [("capital", 12, 393, 170), ("steps", 12, 150, 120), ("columns", 12, 400, 270), ("roof", 12, 540, 270)],
}  # fmt: skip
SIDE = 90  # of the squares, pixels
NEAREST = 0, 8, 4, 2  # 0: all
# The paper looks textures up on the mesh.
BLENDS = {"viewer": ("--blend", "viewer"), "paper": ("--blend", "paper", "--inset", 0)}
GREY = 128.0
WINDING = wd2_human20.WINDING
JPEG = "--codec", "jpeg", "--quality", "100", "--keep-geometry", "--force"


def tool(name, *arguments):
    """Runs a tool and returns its standard output; ends this run with its message when it fails."""
    done = subprocess.run([TOOLS / name / name, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"picture: {name} failed ({done.returncode}): {done.stderr.strip()}")
    return done.stdout


class View(NamedTuple):
    picture: pathlib.Path
    silhouette: pathlib.Path
    transform: np.ndarray  # [R|t], world to camera


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


def smoothed(positions, faces, rounds=6):
    """The mesh without the steps of its voxels: each vertex moves to the mean of its neighbours, then a little back (Taubin)."""
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    count = np.bincount(pairs[:, 0], minlength=len(positions))[:, None]
    for weight in (0.5, -0.53) * rounds:
        total = np.zeros_like(positions)
        np.add.at(total, pairs[:, 0], positions[pairs[:, 1]])
        positions = positions + weight * (total / count - positions)
    return positions


def wd2_capture():
    """The capture's path, or None without the data."""
    root = DATA / "wd2_human20"
    if not root.exists():
        print(f"picture: skipped: no wd2_human20 under FVV_DATA={os.path.relpath(DATA)}")
        return None
    return wd2_human20.describe(root, WORK / "wd2")


def wd2():
    capture = wd2_capture()
    if not capture:
        return None
    root = DATA / "wd2_human20"
    views = {
        c["id"]: View(
            root / f"wd_data/WD2_{c['id']}_00020.png",
            root / f"wd_segmented/WD2_{c['id']}_00020_segmented.png",
            c["Rt"],
        )
        for c in wd2_human20.cameras(root / wd2_human20.CALIBRATION)
    }
    tool("fvvmux", capture, "-o", WORK / "wd2.fvv", *JPEG, *WINDING)
    return views, list(views)


def temple():
    root = DATA / middlebury_temple.SOURCE
    if not root.exists():
        print(f"picture: skipped: no middlebury_temple under FVV_DATA={os.path.relpath(DATA)}")
        return None
    folder = WORK / "temple"
    capture = middlebury_temple.describe(root, folder)
    mesh = folder / middlebury_temple.MESH
    positions, faces = read_ply(mesh)
    middlebury_temple.write_ply(mesh, smoothed(positions, faces), faces)
    views = {
        i: View(root / name, folder / f"mask_{name}", transform)
        for i, (name, _, transform) in enumerate(middlebury_temple.views(root / middlebury_temple.PARAMETERS))
    }
    tool("fvvmux", capture, "-o", WORK / "temple.fvv", *JPEG)
    return views, list(views)[::4]


def generated():
    folder = WORK / "generated"
    tool("fvvsynth", "-o", folder, "--frames", 1, "--meshes", "hull", "--force")
    views = {}
    for camera in json.loads((folder / "capture.json").read_text())["cameras"]:
        if camera.get("texture", True):
            transform = np.column_stack([np.reshape(camera["rotation"], (3, 3)), camera["translation"]])
            views[camera["id"]] = View(
                folder / (camera["pictures"] % 0), folder / (camera["masks"] % 0), transform
            )
    tool("fvvmux", folder, "-o", WORK / "generated.fvv", *JPEG)
    return views, list(views)


CAPTURES = {"wd2": wd2, "temple": temple, "generated": generated}


def nearest(views, target, count):
    """Identifiers of the cameras whose direction from the middle of the scene, to which all axes are near, is nearest."""
    axes = [(-v.transform[:, :3].T @ v.transform[:, 3], v.transform[2, :3]) for v in views.values()]
    across = [np.eye(3) - np.outer(axis, axis) for _, axis in axes]
    middle = np.linalg.solve(sum(across), sum(p @ centre for p, (centre, _) in zip(across, axes)))

    def direction(view):
        ray = -view.transform[:, :3].T @ view.transform[:, 3] - middle
        return ray / np.linalg.norm(ray)

    others = [i for i in views if i != target]
    others.sort(key=lambda i: -(direction(views[i]) @ direction(views[target])))
    return sorted(others[:count])


def compare(name, views, count, blend, target):
    """One cell: PSNR, SSIM, FLIP, and the percentage of the mesh's pixels that no camera shows."""
    out, mask_file = (WORK / f"{name}-{target}{end}.png" for end in ("", "-mask"))
    chosen = ["--sources", ",".join(map(str, nearest(views, target, count)))] if count else []
    drawn = json.loads(
        tool("fvvrender", WORK / f"{name}.fvv", "-o", out, "--camera", target, "--leave-one-out", "--mask", mask_file,
             "--json", "--force", *BLENDS[blend], *chosen)
    )  # fmt: skip
    silhouette = np.asarray(Image.open(views[target].silhouette).convert("L")) > 128
    mask = silhouette & (np.asarray(Image.open(mask_file)) > 128)
    pictures = [np.where(mask, luma(path), GREY) for path in (views[target].picture, out)]
    error = ((pictures[0] - pictures[1])[mask] ** 2).mean()
    colours = [np.asarray(Image.open(path).convert("RGB")) for path in (views[target].picture, out)]
    unlike = flip(*colours, mask)
    return 10 * np.log10(255**2 / error), ssim(*pictures, mask), unlike, 100 * drawn["share_by_cameras"][0]


def table(name, views, targets):
    """Prints the rows of a capture; returns {(sources, blend): means}."""
    means = {}
    with ThreadPoolExecutor(2) as pool:
        for count in NEAREST:
            for blend in BLENDS:
                draw = functools.partial(compare, name, views, count, blend)
                cells = list(pool.map(draw, targets))
                means[count, blend] = np.mean(cells, 0)
            cells = "".join("{:9.2f}{:8.4f}{:8.4f}{:8.2f}".format(*means[count, blend]) for blend in BLENDS)
            print(
                f"{name:10}{f'nearest {count}' if count else f'all {len(views) - 1}':>12}{cells}", flush=True
            )
    return means


def leave_one_out(names):
    """Prints the table and returns the figures, of captures whose data are there."""
    print(f"{'':22}" + "".join(f"{blend + ':':>9}{'SSIM':>8}{'FLIP':>8}{'unseen':>8}" for blend in BLENDS))
    print(f"{'capture':10}{'sources':>12}" + f"{'PSNR dB':>9}{'':16}{'%':>8}" * 2)
    figures = {}
    for name in names:
        made = CAPTURES[name]()
        if not made:
            continue
        means = table(name, *made)
        psnr, likeness, unlike, unseen = means[0, "viewer"]
        figures[f"{name}.leave_one_out_psnr_db"], figures[f"{name}.leave_one_out_ssim"] = psnr, likeness
        figures[f"{name}.leave_one_out_flip"] = unlike
        figures[f"{name}.nearest2_psnr_db"] = means[2, "viewer"][0]
        figures["picture.unseen_percent"] = max(unseen, figures.get("picture.unseen_percent", 0))
        loss = means[2, "viewer"][0] - means[0, "viewer"][0]
        print(
            f"{name}: all others are {'WORSE' if loss > 0.1 else 'no worse'} than the nearest two: {-loss:+.2f} dB"
        )
    return figures


def pose_of(camera):
    """The options of fvvrender that draw what the camera sees."""
    rotation = np.reshape(camera["rotation"], (3, 3))
    eye = -rotation.T @ camera["translation"]
    pose = ",".join(f"{x:.9g}" for x in (*eye, *(eye + rotation[2])))
    return "--pose", pose, "--focal", camera["intrinsics"]["fx"], "--size", "{}x{}".format(*SIZE)


def changes(pictures, masks):
    """Mean absolute first and second differences, summed over the walk."""
    first = second = 0.0
    for i in range(1, len(pictures)):
        both = masks[i - 1] & masks[i]
        first += np.abs(pictures[i] - pictures[i - 1])[both].mean()
        if i + 1 < len(pictures):
            both &= masks[i + 1]
            second += np.abs(pictures[i - 1] - 2 * pictures[i] + pictures[i + 1])[both].mean()
    return np.array([first, second])


def still_scene(source):
    """Whether two frames of the same pictures and mesh are drawn alike."""
    folder = FLICKER / "still"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(source, folder)
    capture = json.loads((folder / "capture.json").read_text())
    capture["frames"]["count"] = 2
    for camera in capture["cameras"]:
        camera.pop("per_frame", None)
    (folder / "capture.json").write_text(json.dumps(capture))
    for path in list(folder.rglob("*0000.*")):
        os.link(path, path.with_name(path.name.replace("0000", "0001")))
    tool("fvvmux", folder, "-o", FLICKER / "still.fvv", *JPEG)
    views = []
    for frame in 0, 1:
        out = FLICKER / f"still{frame}.png"
        tool(
            "fvvrender",
            FLICKER / "still.fvv",
            "--frame",
            frame,
            "--pose",
            "1.5,1.6,3.2,0,1,0",
            "-o",
            out,
            "--force",
        )
        views.append(luma(out))
    return np.abs(views[0] - views[1]).max()


def flicker():
    """Prints the table and returns the figures."""
    studio, walk = FLICKER / "studio", FLICKER / "walk"
    tool("fvvsynth", "-o", studio, "--frames", 1, "--meshes", "hull", "--force")
    tool("fvvsynth", "-o", walk, "--frames", 1, "--rig", "arc", "--cameras", STEPS + 1,
         "--size", "{}x{}".format(*SIZE), "--force")  # fmt: skip
    tool("fvvmux", studio, "-o", FLICKER / "studio.fvv", *JPEG)
    cameras = json.loads((walk / "capture.json").read_text())["cameras"]
    masks = [np.asarray(Image.open(walk / (c["masks"] % 0)).convert("L")) > 128 for c in cameras]
    truth = changes([luma(walk / (c["pictures"] % 0)) for c in cameras], masks)
    print(f"{STEPS} steps of one degree; the truth changes by {truth[0] / STEPS:.2f} of 255 a step")
    ratios = {}
    for blend in BLENDS:
        drawn = []
        for camera in cameras:
            out = FLICKER / f"view{camera['id']}.png"
            tool("fvvrender", FLICKER / "studio.fvv", *pose_of(camera), "-o", out, *BLENDS[blend], "--force")
            drawn.append(luma(out))
        ratios[blend] = changes(drawn, masks) / truth
        print(
            "{:8} first differences {:.3f} of the truth's, second {:.3f}".format(blend, *ratios[blend]),
            flush=True,
        )
    return {
        "picture.viewer_flicker_ratio": ratios["viewer"][0],
        "picture.viewer_jump_ratio": ratios["viewer"][1],
        "picture.still_difference": still_scene(studio),
    }


def closeups():
    """Draws a sheet for each capture: a row for each place."""
    former = *BLENDS["paper"], "--unseen", "128,128,128"
    for name, places in PLACES.items():
        made = CAPTURES[name]()
        if not made:
            continue
        sheet = Image.new("RGB", (3 * MAGNIFIED * SIDE, len(places) * MAGNIFIED * SIDE))
        for row, (_, camera, x, y) in enumerate(places):
            photo = Image.open(made[0][camera].picture).convert("RGB")
            size = "{}x{}".format(*(MAGNIFIED * side for side in photo.size))
            columns = []
            for options in former, ():
                out = CLOSEUPS / "view.png"
                tool("fvvrender", WORK / f"{name}.fvv", "-o", out, "--camera", camera, "--leave-one-out", "--size", size,
                     "--force", *options)  # fmt: skip
                columns.append(Image.open(out).convert("RGB"))
            columns.append(photo.resize(columns[0].size, Image.Resampling.BICUBIC))
            corner = [MAGNIFIED * (at - SIDE // 2) for at in (x, y)]
            box = (*corner, *(at + MAGNIFIED * SIDE for at in corner))
            for column, picture in enumerate(columns):
                sheet.paste(picture.crop(box), (column * MAGNIFIED * SIDE, row * MAGNIFIED * SIDE))
        sheet.save(CLOSEUPS / f"{name}.png")
        print(f"{CLOSEUPS / name}.png: {', '.join(place[0] for place in places)}")


def measure(names=(*CAPTURES, "flicker")):
    """The figures for bench.py."""
    for folder in WORK, FLICKER, CLOSEUPS:
        folder.mkdir(parents=True, exist_ok=True)
    captures = [name for name in names if name in CAPTURES]
    if "closeups" in names:
        closeups()
    return {**(leave_one_out(captures) if captures else {}), **(flicker() if "flicker" in names else {})}


if __name__ == "__main__":
    known = (*CAPTURES, "flicker", "closeups")
    if wrong := set(sys.argv[1:]) - set(known):
        sys.exit(f"picture: expected {', '.join(known)}; found {', '.join(wrong)}")
    for figure, value in measure(sys.argv[1:] or known).items():
        print(f"{figure:32} {value:12.4f}")
