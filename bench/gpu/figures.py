"""The player on a graphics card: pictures per second and likeness to fvvrender (./run bench gpu).

FVV_ANGLE names what Chromium draws with (js/testing/browser.mjs); without it vulkan, then gl-egl are tried. Where all draw
with the processor, nothing is measured and a line says so.
"""

import json
import os
import pathlib
import re

from player_renderer import TOOLS, compare, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "build/bench/gpu"
CAMERAS = (7, 12, 40)
SOFTWARE = re.compile("swiftshader|llvmpipe|softpipe", re.IGNORECASE)


def clips():
    """One for each number of cameras: a second of the generated players, in pictures of 960x540."""
    WORK.mkdir(parents=True, exist_ok=True)
    paths = []
    for count in CAMERAS:
        stream = WORK / f"cameras{count}.fvv"
        if not stream.exists():
            capture = WORK / f"cameras{count}"
            run(TOOLS / "fvvsynth/fvvsynth", "-o", capture, "--force", "--rig", "small", "--cameras", count,
                "--frames", 25, "--size", "960x540", "--environment")  # fmt: skip
            run(TOOLS / "fvvmux/fvvmux", capture, "-o", stream, "--visibility", "weight")
        paths.append(stream)
    return paths


def rates(streams):
    """What was measured and with which ANGLE, or None."""
    for angle in [os.environ["FVV_ANGLE"]] if "FVV_ANGLE" in os.environ else ["vulkan", "gl-egl"]:
        try:
            found = json.loads(run("node", ROOT / "bench/gpu/rates.mjs", *streams, FVV_ANGLE=angle))
        except SystemExit as error:
            print(f"{angle}: {error}")
            continue
        print(f"{angle}: {found['renderer']}")
        if found["renderer"] and not SOFTWARE.search(found["renderer"]):
            return angle, found
    return None


def measure():
    streams = clips()
    measured = rates(streams)
    if not measured:
        print("player.gpu_* is left out: no graphics card draws here")
        return {}
    angle, found = measured
    for name, sizes in found["clips"].items():
        for size, ways in sizes.items():
            for way, rate in ways.items():
                print(
                    f"{name:10} {size:9} by {way:5} {rate['playing']:7.1f} frames/s while playing, "
                    f"{rate['still']:7.1f} of one frame"
                )
    lines = compare(streams[1:2], "--poses", "8", FVV_ANGLE=angle)
    by = found["clips"]
    return {
        "player.gpu_fps": by["cameras12"]["1080p"]["bits"]["playing"],
        "player.gpu_fps_standing": by["cameras12"]["1080p"]["bits"]["still"],
        "player.gpu_fps_4k": by["cameras12"]["4k"]["bits"]["playing"],
        "player.gpu_fps_4k_standing": by["cameras12"]["4k"]["bits"]["still"],
        "player.gpu_fps_7_cameras": by["cameras7"]["1080p"]["bits"]["playing"],
        "player.gpu_fps_40_cameras": by["cameras40"]["1080p"]["bits"]["playing"],
        "player.gpu_fps_throttled": by["cameras12"]["throttled"]["bits"]["playing"],
        "player.gpu_fps_depth_maps": by["cameras12"]["1080p"]["depth"]["playing"],
        "player.gpu_min_psnr_db": min(line["minPsnr"] for line in lines),
    }
