"""What --view-loss 0.1dB does with scenes in which little can be measured: a table of bytes and held-out PSNR beside --view-loss none.

Each scene is the small rig of fvvsynth (12 frames, seven cameras at 480x270) with one thing that is wrong or missing. The truth is filmed
from the arc, as in figures.py. A choice may lose 0.1 dB and grow by 5 %, and says so where it could not measure.

./run bench spend prints the table and the two worst figures.
"""

import pathlib

import numpy as np
from charts import experiment, views

from .figures import GOAL

FRAMES = 12
LOOKED_AT = 1, 6, 10
EMPTY = b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n"


def without_masks(description, _folder):
    for camera in description["cameras"]:
        del camera["masks"]


def far_off(description, _folder):
    """All cameras look past the meshes by about half of a picture."""
    for camera in description["cameras"]:
        camera["translation"][0] += 1.5


def empty_in_the_middle(description, folder):
    """The stage is empty from the fourth frame to the ninth."""
    source = description["meshes"]["pattern"]
    (folder / "meshes").mkdir()
    for frame in range(FRAMES):
        mesh = folder / "meshes" / f"{frame:04d}.ply"
        if 3 <= frame < 9:
            mesh.write_bytes(EMPTY)
        else:
            mesh.symlink_to(source % frame)
    description["meshes"]["pattern"] = "meshes/%04d.ply"


def hulls_at_the_end(hulls):
    """A change: from the seventh frame on meshes are those of another capture of the same scene."""

    def change(description, folder):
        source = description["meshes"]["pattern"]
        (folder / "meshes").mkdir()
        for frame in range(FRAMES):
            mesh = pathlib.Path(source % frame) if frame < 6 else hulls / "meshes" / f"{frame:04d}.ply"
            (folder / "meshes" / f"{frame:04d}.ply").symlink_to(mesh)
        description["meshes"]["pattern"] = "meshes/%04d.ply"

    return change


def scenes():
    """Name to capture, options of fvvmux and how many frames there are to look at."""

    def small(name, *options, frames=FRAMES):
        return experiment.capture(f"scene-{name}", "--rig", "small", "--frames", frames, *options)

    plain, coarse = small("plain"), small("coarse", "--meshes", "hull", "--hull-cells", 32)
    unlike = experiment.capture("scene-unlike", "--size", "480x270", "--frames", FRAMES)
    changed = experiment.changed_capture
    return {
        "as it is": (plain, ()),
        "one camera": (plain, ("--cameras", "0")),
        "two cameras": (plain, ("--cameras", "0,1")),
        "three beside each other": (plain, ("--cameras", "0,1,2")),
        "no masks": (changed(plain, "no-masks", without_masks), ("--winding", "keep")),
        "meshes far off the pictures": (changed(plain, "far-off", far_off), ()),
        "an empty stage in the middle": (changed(plain, "empty", empty_in_the_middle), ()),
        "groups of two frames": (plain, ("--group", "2")),
        "hulls of 32 cells": (coarse, ()),
        "exact meshes, then hulls": (changed(plain, "mixed", hulls_at_the_end(coarse)), ("--group", "6")),
        "thirteen unlike cameras": (unlike, ()),
        "noise of a bad camera": (small("noise", "--noise", 12), ()),
        "exposures two stops apart": (small("exposure", "--exposure", 1), ()),
        "one frame": (small("one", frames=1), ()),
    }


def looked_at(count, name):
    if count == 1:
        return (0,)
    return (1, 10) if "empty" in name else LOOKED_AT


def measure(only=None):
    """only: names of scenes; all without it."""
    arc, still = views.Arc(FRAMES, (13, 26)), views.Arc(1, (13, 26))
    lost, grown = [], []
    print(f"{'scene':31}{'bytes':>9}{'chosen':>9}{'PSNR dB':>9}{'chosen':>8}  what")
    for name, (capture, options) in scenes().items():
        if only and name not in only:
            continue
        count = 1 if name == "one frame" else FRAMES
        before, after = (experiment.packed(capture, *options, *goal) for goal in ((), GOAL))
        seen = [
            views.measure(one.path, still if count == 1 else arc, frames=looked_at(count, name))[
                "psnr_inside_db"
            ]
            for one in (before, after)
        ]
        found = after.summary["view_loss"]
        lost.append(seen[0] - seen[1])
        grown.append(100 * (after.summary["bytes"] / before.summary["bytes"] - 1))
        what = (
            f"{found['picture_psnr']:g} dB, {found['max_error']:g} px, threshold {found['threshold']:g}"
            if found["measured"]
            else f"nothing: {found['reason']}"
        )
        print(
            f"{name:31}{before.summary['bytes']:9}{after.summary['bytes']:9}{seen[0]:9.2f}{seen[1]:8.2f}  {what}",
            flush=True,
        )
    return {
        "spend.scenes_worst_loss_db": float(np.max(lost)),
        "spend.scenes_worst_growth_percent": float(np.max(grown)),
    }
