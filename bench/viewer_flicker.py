#!/usr/bin/env python3
"""How much a drawn picture changes while the viewer walks, against how much the truth changes, on a generated capture.

The truth is filmed by cameras one degree apart (fvvsynth --rig arc); fvvrender draws the same views from the 13 cameras of
the studio and their hull. Of each step the change is the mean absolute difference of BT.709 luma over the pixels that belong
to both silhouettes; the ratio is that of the sums over all steps. Smooth motion changes both alike, so jumps are looked for in
second differences, p(i - 1) - 2 p(i) + p(i + 1), in the same way. A still scene, the same frame twice, must give the same picture.

    python bench/viewer_flicker.py
"""

import json
import os
import shutil

import numpy as np
from leave_one_out import BLENDS, JPEG, ROOT, luma, tool
from PIL import Image

WORK = ROOT / "build/bench/flicker"
STEPS = 30
SIZE = 480, 270


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
    folder = WORK / "still"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(source, folder)
    capture = json.loads((folder / "capture.json").read_text())
    capture["frames"]["count"] = 2
    for camera in capture["cameras"]:
        camera.pop("per_frame", None)
    (folder / "capture.json").write_text(json.dumps(capture))
    for path in list(folder.rglob("*0000.*")):
        os.link(path, path.with_name(path.name.replace("0000", "0001")))
    tool("fvvmux", folder, "-o", WORK / "still.fvv", *JPEG)
    views = []
    for frame in 0, 1:
        out = WORK / f"still{frame}.png"
        tool(
            "fvvrender",
            WORK / "still.fvv",
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


def measure():
    """Prints the table and returns the figures for bench.py."""
    WORK.mkdir(parents=True, exist_ok=True)
    studio, walk = WORK / "studio", WORK / "walk"
    tool("fvvsynth", "-o", studio, "--frames", 1, "--meshes", "hull", "--force")
    tool("fvvsynth", "-o", walk, "--frames", 1, "--rig", "arc", "--cameras", STEPS + 1,
         "--size", "{}x{}".format(*SIZE), "--force")  # fmt: skip
    tool("fvvmux", studio, "-o", WORK / "studio.fvv", *JPEG)
    cameras = json.loads((walk / "capture.json").read_text())["cameras"]
    masks = [np.asarray(Image.open(walk / (c["masks"] % 0)).convert("L")) > 128 for c in cameras]
    truth = changes([luma(walk / (c["pictures"] % 0)) for c in cameras], masks)
    print(f"{STEPS} steps of one degree; the truth changes by {truth[0] / STEPS:.2f} of 255 a step")
    ratios = {}
    for blend in BLENDS:
        drawn = []
        for camera in cameras:
            out = WORK / f"view{camera['id']}.png"
            tool("fvvrender", WORK / "studio.fvv", *pose_of(camera), "-o", out, "--blend", blend, "--force")
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


if __name__ == "__main__":
    for figure, value in measure().items():
        print(f"{figure:32} {value:12.4f}")
