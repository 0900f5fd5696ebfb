#!/usr/bin/env python3
"""Clips of real captures for the demo's page: demo_clips.py FOLDER. Absent captures are skipped.

A clip is made again only when it is older than the muxer or a script.
"""

import pathlib
import sys

import pose2sim_4cam
import real_capture as real
import wd2_human20

MUXER = real.TOOLS / "fvvmux/fvvmux"


def wd2(root, folder):
    return [wd2_human20.describe(root, folder), *wd2_human20.WINDING, "--scale", "0.5"]


def pose2sim(root, folder):
    capture = pose2sim_4cam.describe(root, folder)
    return [capture, "--frames", f"0-{pose2sim_4cam.FRAMES - 1}", "--scale", pose2sim_4cam.SCALE]


CLIPS = {
    "wd2_human20": (wd2, wd2_human20),
    "pose2sim_4cam": (pose2sim, pose2sim_4cam),
}


def is_current(clip, makers):
    return clip.exists() and all(
        clip.stat().st_mtime > pathlib.Path(maker).stat().st_mtime for maker in makers
    )


def main():
    out = pathlib.Path(sys.argv[1]).resolve()
    out.mkdir(parents=True, exist_ok=True)
    for name, (prepare, module) in CLIPS.items():
        root, clip = real.DATA / module.SOURCE, out / f"{name}.fvv"
        if not root.exists() or is_current(clip, [MUXER, __file__, module.__file__]):
            continue
        command = prepare(root, real.WORK / "demo" / name)
        real.tool("fvvmux", *command, "-o", clip, "--force")


if __name__ == "__main__":
    main()
