"""Shared by the scripts beside this file: finding data and tools, reading the demultiplexed meshes, comparing them.

Comparisons use NumPy and readers of their own, nothing of libfvv, so that a mistake in the library shows.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TOOLS = pathlib.Path(os.environ.get("FVV_TOOLS_DIR", ROOT / "build/default/tools"))
DATA = pathlib.Path(os.environ.get("FVV_DATA", ROOT.parent / "shared/data"))
WORK = ROOT / "build/real"
SKIPPED = 77

failures = []


def data(name):
    """The path of a capture's file or folder; ends the run as skipped when it is absent."""
    path = DATA / name
    if not path.exists():
        print(f"skipped: no {name} under FVV_DATA={DATA}")
        sys.exit(SKIPPED)
    return path


def tool(name, *arguments, code=0):
    """Shows the command, runs the tool and returns its output; ends the run when it returns another code."""
    print("$", name, *(str(a).replace(str(ROOT) + "/", "") for a in arguments), flush=True)
    done = subprocess.run([TOOLS / name / name, *map(str, arguments)], stdout=subprocess.PIPE, text=True)
    if done.returncode != code:
        print(f"failed: {name} returned {done.returncode}, expected {code}")
        sys.exit(1)
    return done.stdout


def round_trip(capture, *options, code=0):
    """Packs and verifies a capture, checks and unpacks the stream. Returns the reports of fvvmux and fvvinfo, and the folder.

    code: of fvvmux; 3 where it has to warn.
    """
    stream, out = capture.with_name("capture.fvv"), capture.with_name("out")
    command = [capture, "-o", stream, "--verify", "--keep-geometry", "--force", "--json", *options]
    summary = json.loads(tool("fvvmux", *command, code=code))
    print(tool("fvvinfo", "--check", stream))
    shutil.rmtree(out, ignore_errors=True)
    tool("fvvdemux", stream, "-o", out)
    return summary, json.loads(tool("fvvinfo", "--json", stream))["files"][0], out


def contact_sheet(capture, iou=None):
    """Draws the contact sheet beside the capture, for people; with masks, compares its outlines with them."""
    sheet = capture.with_name("sheet.png")
    report = json.loads(tool("fvvimport", "capture", capture, "--sheet", sheet, "--force", "--json"))
    print(f"look at {str(sheet).replace(str(ROOT) + '/', '')}")
    if iou is not None:
        figure("median overlap of mesh and silhouettes", report["median_iou"], iou, at_most=False)


def figure(text, value, limit, at_most=True):
    """Prints a figure and its limit, and notes when the limit is broken."""
    good = value <= limit if at_most else value >= limit
    if not good:
        failures.append(text)
    print(
        f"{text}: {value:.6g} ({'at most' if at_most else 'at least'} {limit:g}) {'ok' if good else 'BROKEN'}"
    )


def finish():
    print("broken: " + ", ".join(failures) if failures else "all limits hold")
    sys.exit(1 if failures else 0)


def write_capture(folder, description):
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "capture.json"
    path.write_text(json.dumps(description, indent=1))
    return path


def ply_arrays(path):
    """Vertices and faces of a binary little-endian PLY of triangles, as structured arrays."""
    bytes_ = pathlib.Path(path).read_bytes()
    end = bytes_.index(b"end_header\n") + len(b"end_header\n")
    header = bytes_[:end].decode("ascii").split("\n")
    assert "format binary_little_endian 1.0" in header, f"{path}: not binary little-endian"
    types = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4", "uint": "<u4"}
    counts, fields, element = {}, [], None
    for line in header:
        word = line.split()
        if word[:1] == ["element"]:
            element = word[1]
            counts[element] = int(word[2])
        if word[:1] == ["property"] and element == "vertex":
            fields.append((word[2], types[word[1]]))
    vertices = np.frombuffer(bytes_, np.dtype(fields), counts["vertex"], end)
    face = np.dtype([("n", "u1"), ("index", "<u4", 3)])
    faces = np.frombuffer(bytes_, face, counts["face"], end + vertices.nbytes)
    assert (faces["n"] == 3).all(), f"{path}: not all faces are triangles"
    return vertices, faces


def read_ply(path):
    """Positions (n x 3, float64) and triangles (m x 3) of such a PLY."""
    vertices, faces = ply_arrays(path)
    return np.stack([vertices[axis].astype(np.float64) for axis in "xyz"], axis=1), faces["index"]


def read_ply_texture(path):
    """Texture coordinates (n x 2, float64) of such a PLY with s and t, v down as pictures have it."""
    vertices, _ = ply_arrays(path)
    return np.stack([vertices["s"], 1 - vertices["t"]], axis=1)


def read_obj(path):
    """Positions and triangles of an OBJ with only v and f lines of triangles."""
    rows = [line.split() for line in pathlib.Path(path).read_text().splitlines()]
    positions = np.array([row[1:4] for row in rows if row[:1] == ["v"]], np.float64)
    faces = np.array(
        [[part.split("/")[0] for part in row[1:4]] for row in rows if row[:1] == ["f"]], np.int64
    )
    return positions, faces - 1


def luma(path):
    """BT.709 luma of a picture, 0 to 255."""
    return np.asarray(Image.open(path).convert("RGB"), np.float64) @ [0.2126, 0.7152, 0.0722]


def triangle_set(positions, faces, step):
    """Triangles as sorted triples of lattice points, independent of the order of vertices and faces."""
    lattice = np.rint(positions / step).astype(np.int64)
    triples = lattice[faces]
    distinct = (
        (triples[:, 0] != triples[:, 1]).any(1)
        & (triples[:, 1] != triples[:, 2]).any(1)
        & (triples[:, 0] != triples[:, 2]).any(1)
    )
    return {tuple(sorted(map(tuple, t))) for t in triples[distinct].tolist()}


def compare_meshes(name, source, decoded, step):
    """Checks that every source vertex has a decoded one within half a step on each axis, and that no triangle is new."""
    (positions, faces), (out_positions, out_faces) = source, decoded
    points = {tuple(p) for p in np.rint(out_positions / step).astype(np.int64).tolist()}
    used = np.unique(faces)
    lattice = np.rint(positions[used] / step)
    error = np.abs(lattice * step - positions[used]).max() / step
    missing = [p for p in lattice.astype(np.int64).tolist() if tuple(p) not in points]
    figure(f"{name}: largest error on an axis, in lattice steps", error, 0.5 + 1e-9)
    figure(f"{name}: source vertices without a decoded one", len(missing), len(used) * 0.001)
    extra = triangle_set(out_positions, out_faces, step) - triangle_set(positions, faces, step)
    figure(f"{name}: triangles that the source does not have", len(extra), 0)
