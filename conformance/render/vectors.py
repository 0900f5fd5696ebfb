#!/usr/bin/env python3
"""Makes the render vectors: streams by fvvsynth and fvvmux, or by the generator of the cases, and the pictures that
fvvrender draws of them.

Needs the Python package fvv, whose `render` has fvvrender's pixels.

--check writes nothing, draws the pictures again from the streams that are there, and exits with 1 where one differs.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import fvv
import numpy
from PIL import Image

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
VECTORS = HERE / "vectors"
sys.path.insert(0, str(ROOT / "conformance"))
from generate.subjects import patched_cases  # noqa: E402

# Two renderers round the corners of a face differently: at a pixel from an outline or a jump of the depth they may show
# different faces.
AWAY = 2
# Change of depth from pixel to pixel, in widths of a pixel, of the steepest surface that is not such a jump.
STEEPEST = 8
SIZE = (240, 160)

# Options of fvvsynth for each capture without a generator of its own, and of fvvmux for each stream.
CAPTURES = {
    "small": ["--rig", "small", "--frames", "4", "--size", "160x120"],
    "studio": ["--frames", "2", "--size", "160x90", "--meshes", "hull", "--hull-cells", "40"],
    "atlas": [
        "--rig",
        "small",
        "--frames",
        "1",
        "--size",
        "96x72",
        "--cameras",
        "3",
        "--atlas",
        "--atlas-size",
        "512",
    ],
    "many": ["--rig", "small", "--cameras", "40", "--frames", "1", "--size", "96x72"],
}
LIGHT = ["--triangles", "3000"]
VECTOR = {
    "bits": {
        "title": "Visibility from the stream, in a delta frame of the second group; H.264.",
        "clauses": ["17.3", "17.5"],
        "capture": "small",
        "mux": [*LIGHT, "--visibility", "weight", "--texture-inset", "30mm", "--group", "2"],
        "frame": 3,
        "angle": 20,
    },
    "depth": {
        "title": "Visibility by depth maps, because the stream has none; JPEG.",
        "clauses": ["10.4", "17.5"],
        "capture": "small",
        "mux": [*LIGHT, "--visibility", "none", "--codec", "jpeg", "--quality", "85", "--frames", "0-0"],
        "frame": 0,
        "angle": 140,
    },
    "texturing": {
        "title": "Texturing parameters in the stream: one camera for a point, a high threshold, a colour for the rest.",
        "clauses": ["17.5"],
        "capture": "small",
        "mux": [
            *LIGHT,
            "--visibility",
            "none",
            "--frames",
            "0-0",
            "--texture-best",
            "1",
            "--texture-threshold",
            "0.5",
        ]
        + ["--texture-unseen", "250,10,60", "--texture-blend", "paper"],
        "frame": 0,
        "angle": 260,
        "psnr": 36,  # seams between cameras are as sharp as outlines
    },
    "lenses": {
        "title": "Cameras of several sizes, with lens distortion, one of which moves; meshes that change; VP9 of 10 bits.",
        "clauses": ["9.1", "9.4", "17.5"],
        "capture": "studio",
        "mux": ["--codec", "vp9", "--bit-depth", "10"],
        "frame": 1,
        "angle": 75,
    },
    "colours": {
        "title": "Colours of vertices where no camera shows the surface: both cameras are on one side.",
        "clauses": ["19.4"],
        "capture": "small",
        "mux": [*LIGHT, "--cameras", "0-1", "--frames", "0-0"],
        "frame": 0,
        "angle": 190,
    },
    "atlas": {
        "title": "A texture atlas beside three cameras.",
        "clauses": ["8.6", "10.1"],
        "capture": "atlas",
        "mux": [*LIGHT],
        "frame": 0,
        "angle": 100,
    },
    "many": {
        "title": "40 cameras, of which each point takes the best three; VP9.",
        "clauses": ["17.5"],
        "capture": "many",
        "mux": [*LIGHT, "--visibility", "weight", "--codec", "vp9"],
        "frame": 0,
        "angle": 320,
    },
    "patches": {
        "title": "A patched frame: a patch with colours of its own in place of some faces; no pictures.",
        "clauses": ["8.14", "19.1"],
        "stream": patched_cases.ball_with_patch,
        "frame": 2,
        "angle": 30,
    },
    "far": {
        "title": "From two and a half times as far: few pixels for many texels.",
        "clauses": ["17.5"],
        "capture": "small",
        "mux": [*LIGHT, "--frames", "0-0"],
        "frame": 0,
        "angle": 50,
        "distance": 2.5,
        "samples": 7,
        "psnr": 26,  # how a renderer averages texels is its own choice
    },
}


def tool(tools, name, *arguments):
    done = subprocess.run([str(tools / name / name), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"vectors.py: {name} exits with {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def view_of(angle, distance):
    """A camera without distortion that looks at the scene from around it: x = R X + t, right, down and forward."""
    turn = numpy.radians(angle)
    eye = numpy.array([4.4 * distance * numpy.sin(turn), 1.5, 4.4 * distance * numpy.cos(turn)])
    forward = numpy.array([0, 0.9, 0]) - eye
    forward /= numpy.linalg.norm(forward)
    right = numpy.cross(forward, [0, 1, 0])
    right /= numpy.linalg.norm(right)
    rotation = numpy.array([right, numpy.cross(forward, right), forward])
    focal = 1.1 * SIZE[0]
    return {
        "width": SIZE[0],
        "height": SIZE[1],
        "fx": focal,
        "fy": focal,
        "cx": SIZE[0] / 2,
        "cy": SIZE[1] / 2,
        "rotation": rotation.flatten().tolist(),
        "translation": (-rotation @ eye).tolist(),
    }


def areas(depth, focal):
    """255: surface away from outlines and jumps of the depth; 128: other surface; 0: none."""
    surface = numpy.isfinite(depth)
    edge = numpy.zeros_like(surface)
    for axis in (0, 1):
        for step in (1, -1):
            other = numpy.roll(depth, step, axis)
            border = [slice(None)] * 2
            border[axis] = 0 if step > 0 else -1
            other[tuple(border)] = depth[tuple(border)]
            with numpy.errstate(invalid="ignore"):
                edge |= ~numpy.isfinite(other) | (abs(other - depth) > STEEPEST * depth / focal)
    edge &= surface
    near = edge.copy()
    for down in range(-AWAY + 1, AWAY):
        for right in range(-AWAY + 1, AWAY):
            near |= numpy.roll(edge, (down, right), (0, 1))
    return numpy.where(surface, numpy.where(near, 128, 255), 0).astype(numpy.uint8)


def draw(name, stream, view):
    """Of a vector: the picture, and the areas in which others are compared with it."""
    focal = [[view["fx"], 0, view["cx"]], [0, view["fy"], view["cy"]], [0, 0, 1]]
    rotation = numpy.reshape(view["rotation"], (3, 3))
    size = (view["width"], view["height"])
    camera = fvv.Camera(0, focal, rotation, view["translation"], size=size)
    samples = VECTOR[name].get("samples", 1)
    with fvv.open(stream) as clip:
        drawn = fvv.render(
            clip, VECTOR[name]["frame"], camera, samples=samples, environment=False, layers=True
        )
    return {"picture.png": drawn.pixels, "area.png": areas(drawn.depth, view["fx"])}


def make(tools, names):
    with tempfile.TemporaryDirectory() as work:
        for name in names:
            vector, folder = VECTOR[name], VECTORS / name
            folder.mkdir(parents=True, exist_ok=True)
            stream = folder / "input.fvv"
            if "stream" in vector:
                stream.write_bytes(bytes(vector["stream"]().out))
            else:
                capture = pathlib.Path(work) / vector["capture"]
                if not capture.exists():
                    tool(tools, "fvvsynth", "-o", capture, *CAPTURES[vector["capture"]])
                tool(tools, "fvvmux", capture, "-o", stream, *vector["mux"], "--force")
            view = view_of(vector["angle"], vector.get("distance", 1))
            for file, pixels in draw(name, stream, view).items():
                Image.fromarray(pixels).save(folder / file, optimize=True)
            facts = {
                "title": vector["title"],
                "clauses": vector["clauses"],
                "format": "0.2",
                "frame": vector["frame"],
                "view": view,
                "psnr": vector.get("psnr", 40),
            }
            (folder / "vector.json").write_text(json.dumps(facts, indent=1) + "\n")
            print(f"{name}: {stream.stat().st_size} bytes")


def check(names):
    """The pictures that are no longer what fvvrender draws."""
    out = []
    for name in names:
        folder = VECTORS / name
        view = json.loads((folder / "vector.json").read_text())["view"]
        for file, pixels in draw(name, folder / "input.fvv", view).items():
            if not numpy.array_equal(pixels, numpy.asarray(Image.open(folder / file))):
                out.append(f"{name}/{file}")
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--tools", type=pathlib.Path, default=ROOT / "build/default/tools", metavar="DIR")
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit 1 where fvvrender draws another picture"
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(VECTOR)}; default: all")
    arguments = parser.parse_args()
    unknown = sorted(set(arguments.names) - set(VECTOR))
    if unknown:
        parser.error(f"there is no vector {', '.join(unknown)}")
    names = arguments.names or list(VECTOR)
    if not arguments.check:
        make(arguments.tools, names)
        return 0
    differing = check(names)
    for name in differing:
        print(f"vectors.py: {name}: fvvrender draws another picture", file=sys.stderr)
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
