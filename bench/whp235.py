#!/usr/bin/env python3
"""The encoding of BBC R&D White Paper 235 (Budd, Grau, Schuebel, 2012), for any capture: the baseline that fvv is
measured against.

As the paper describes it: per frame a mesh as JavaScript arrays in text, with surface normals, nothing compressed
(section 3.1); per camera and frame a picture scaled to a sixteenth of the original area, JPEG at a factor of about 13
below RGB, Base64 (section 5); calibration about 600 bytes per camera. Where the paper is silent: positions in metres to
the millimetre, normals to three digits, and the JPEG quality is the one that comes nearest to the factor over the first
frame. A capture that has the transmitted size already is not scaled again (--scale 1). Cameras without texture and cameras
that move are left out. A capture with other files than PNG, JPEG, PLY and OBJ is converted first by fvvmux and
fvvdemux, with JPEG at quality 100.

    python bench/whp235.py CAPTURE [--scale 4 | --tile 480x270] [--cameras NAME,...] [-o FILE]

prints the bytes of meshes, pictures and calibration as JSON; -o also writes all messages, one per line.
"""

import argparse
import base64
import io
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tests/real"))
from real_capture import TOOLS, read_obj, read_ply  # noqa: E402

FACTOR = 13


READERS = {".ply": read_ply, ".obj": read_obj}


def is_plain(description):
    """Whether this script can read the files."""
    meshes = description.get("meshes")
    if meshes and pathlib.Path(meshes.get("pattern", "")).suffix.lower() not in READERS:
        return False
    sources = [pattern_of(camera)[0] for camera in chosen_cameras(description, ())]
    return all(s and pathlib.Path(s).suffix.lower() in (".png", ".jpg", ".jpeg") for s in sources)


def plain(capture, folder):
    """The capture itself when it is plain, else a copy in folder by fvvmux and fvvdemux."""
    description = json.loads(capture.read_text())
    if is_plain(description):
        return capture
    stream = folder / "plain.fvv"
    first = description["frames"]["first"]
    last = first + (description["frames"]["count"] - 1) * description["frames"].get("step", 1)
    # A range of all frames, so that further pictures in the videos are ignored.
    best = ["--codec", "jpeg", "--quality", "100", "--mesh-profile", "raw", "--frames", f"{first}-{last}"]
    best += ["--keep-geometry", "--crop", "none", "--tile-fill", "keep"]
    if description["units"] != "unknown":
        best += ["--step", "0.1mm"]
    for command in (["fvvmux", capture, "-o", stream, *best], ["fvvdemux", stream, "-o", folder / "plain"]):
        done = subprocess.run([TOOLS / command[0] / command[0], *command[1:]], stdout=subprocess.DEVNULL)
        if done.returncode not in (0, 3):
            sys.exit(f"{command[0]} returned {done.returncode}")
    return folder / "plain/capture.json"


def numbers(array, digits):
    """A JavaScript array in as few characters as possible."""
    text = np.char.mod(f"%.{digits}f", np.asarray(array).ravel())
    if digits:
        text = np.char.rstrip(np.char.rstrip(text, "0"), ".")
        text = np.where(text == "-0", "0", text)
    return "[" + ",".join(text.tolist()) + "]"


def vertex_normals(positions, faces):
    corners = positions[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(positions)
    for corner in range(3):
        np.add.at(total, faces[:, corner], normal)
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)


def mesh_message(path):
    positions, faces = READERS[path.suffix.lower()](path)
    parts = numbers(positions, 3), numbers(vertex_normals(positions, faces), 3), numbers(faces, 0)
    return '{{"vertices":{},"normals":{},"faces":{}}}'.format(*parts)


def load_picture(path, turn, size_of):
    picture = Image.open(path).convert("RGB")
    # Clockwise, as capture.json counts; Pillow counts the other way.
    picture = picture.rotate(-turn, expand=True) if turn else picture
    size = size_of(picture)
    return picture if size == picture.size else picture.resize(size, Image.BOX)


def scaled_by(factor):
    """The function from a picture to its transmitted size."""
    return lambda picture: (max(1, round(picture.width / factor)), max(1, round(picture.height / factor)))


def chosen_cameras(description, names):
    """The cameras of these names (default: all) that have texture and do not move."""
    cameras = [
        camera
        for camera in description.get("cameras", [])
        if "pictures" in camera and camera.get("texture", True) and "per_frame" not in camera
    ]
    if not names:
        return cameras
    missing = set(names) - {camera.get("name") for camera in cameras}
    if missing:
        sys.exit(f"no such camera that has texture and does not move: {', '.join(sorted(missing))}")
    return [camera for camera in cameras if camera.get("name") in names]


def pattern_of(camera):
    """The pattern of a camera's pictures (None: a video), and the degrees by which they are turned."""
    pictures = camera["pictures"]
    if isinstance(pictures, str):
        return pictures, 0
    return pictures.get("pattern"), pictures.get("rotate", 0)


def jpeg(picture, quality):
    out = io.BytesIO()
    picture.save(out, "JPEG", quality=quality)
    return out.getvalue()


def nearest_quality(pictures):
    """The quality whose JPEG files come nearest to RGB divided by the paper's factor."""
    wanted = sum(p.width * p.height * 3 for p in pictures) / FACTOR
    return min(range(1, 101), key=lambda q: abs(sum(len(jpeg(p, q)) for p in pictures) - wanted))


def calibration_message(camera):
    keys = "id", "width", "height", "intrinsics", "lens", "rotation", "translation"
    return json.dumps({key: camera[key] for key in keys if key in camera}, separators=(",", ":"))


def messages(capture, size_of, names=()):
    """Yields (kind, text) of everything that is transmitted. size_of returns the size to which a picture is scaled."""
    description = json.loads(capture.read_text())
    frames = description["frames"]
    numbers_ = [frames["first"] + i * frames.get("step", 1) for i in range(frames["count"])]
    cameras = chosen_cameras(description, names)
    for camera in cameras:
        yield "calibration", calibration_message(camera)
    place = capture.parent

    def picture(camera, number):
        pattern, turn = pattern_of(camera)
        return load_picture(place / (pattern % number), turn, size_of)

    quality = nearest_quality([picture(c, numbers_[0]) for c in cameras]) if cameras else None
    for number in numbers_:
        if "meshes" in description:
            yield "mesh", mesh_message(place / (description["meshes"]["pattern"] % number))
        for camera in cameras:
            yield "picture", base64.b64encode(jpeg(picture(camera, number), quality)).decode("ascii")


def sizes(capture, size_of, names=(), out=None):
    """Bytes by kind and in total."""
    total = {"mesh": 0, "picture": 0, "calibration": 0}
    with tempfile.TemporaryDirectory() as folder:
        for kind, text in messages(plain(capture, pathlib.Path(folder)), size_of, names):
            total[kind] += len(text.encode("utf-8"))
            if out:
                out.write(text + "\n")
    return {**total, "all": sum(total.values())}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("capture", type=pathlib.Path, help="capture.json")
    parser.add_argument(
        "--scale", type=float, default=4, help="pictures are divided by it in width and height"
    )
    parser.add_argument("--tile", help="size of all transmitted pictures in place of that: 480x270")
    parser.add_argument(
        "--cameras", default="", help="names, with commas; default: all that fvvmux would take"
    )
    parser.add_argument("-o", dest="out", type=argparse.FileType("w"), help="write all messages here")
    arguments = parser.parse_args()
    size_of = scaled_by(arguments.scale)
    if arguments.tile:
        tile = tuple(int(side) for side in arguments.tile.split("x"))
        size_of = lambda picture: tile  # noqa: E731
    names = [name for name in arguments.cameras.split(",") if name]
    print(json.dumps(sizes(arguments.capture, size_of, names, arguments.out)))


if __name__ == "__main__":
    main()
