#!/usr/bin/env python3
"""middlebury_temple: 47 views of a statue, silhouettes by threshold, a hull of voxels; through fvv and back."""

import json

import numpy as np
import real_capture as real
from PIL import Image, ImageFilter

SOURCE = "middlebury_temple/templeRing"
PARAMETERS = "templeR_par.txt"
MESH = "voxels.ply"
SIZE = (640, 480)
# The tight box of the model, from the README of the data, with a margin.
LOW, HIGH, MARGIN = (
    np.array([-0.023121, -0.038009, -0.091940]),
    np.array([0.078626, 0.121636, -0.017395]),
    0.004,
)
CELL = 0.0015  # metres: about 4 pixels
MISSES = 3  # views that may lack a voxel: shadowed parts fall below the threshold
QUALITY = 40.0


def views(path):
    """Name, K and [R|t] of every view, as in the file."""
    out = []
    for line in path.read_text().splitlines()[1:]:
        name, *numbers = line.split()
        n = np.array(numbers, float)
        out.append((name, n[:9].reshape(3, 3), np.column_stack([n[9:18].reshape(3, 3), n[18:]])))
    return out


def project(matrix, transform, points):
    local = points @ transform[:, :3].T + transform[:, 3]
    pixel = local @ matrix.T
    return pixel[:, :2] / pixel[:, 2:]


def silhouette(picture):
    """The statue is brighter than the background; holes of shadow are closed."""
    bright = Image.open(picture).convert("L").point(lambda v: 255 * (v > 40))
    return (
        bright.filter(ImageFilter.MedianFilter(5))
        .filter(ImageFilter.MaxFilter(5))
        .filter(ImageFilter.MinFilter(5))
    )


def carve(cameras, masks):
    """Occupied cells of a grid: (n x m x k bool, origin of the first cell's corner)."""
    low, high = LOW - MARGIN, HIGH + MARGIN
    counts = np.ceil((high - low) / CELL).astype(int)
    axes = [low[a] + CELL * (np.arange(counts[a]) + 0.5) for a in range(3)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    missed = np.zeros(len(points), int)
    for (_, matrix, transform), mask in zip(cameras, masks, strict=True):
        uv = np.rint(project(matrix, transform, points)).astype(int)
        inside = ((uv >= 0) & (uv < SIZE)).all(1)
        seen = np.ones(len(points), bool)  # points outside the picture count as seen
        seen[inside] = mask[uv[inside, 1], uv[inside, 0]]
        missed += ~seen
    return (missed <= MISSES).reshape(counts), low


def voxel_surface(full, low):
    """Triangles of the faces between full and empty cells, seen from outside counter-clockwise."""
    full = np.pad(full, 1)
    low = low - CELL
    quads = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        step = np.diff(full.astype(np.int8), axis=axis)
        for sign in (1, -1):  # 1: full after empty along the axis; the face looks down the axis
            cell = np.argwhere(step == sign)
            cell[:, axis] += 1
            corners = [cell.copy() for _ in range(4)]
            corners[1][:, u] += 1
            corners[2][:, [u, v]] += 1
            corners[3][:, v] += 1
            quads.append(np.stack(corners if sign == -1 else corners[::-1], 1))
    quads = np.concatenate(quads).reshape(-1, 3)
    points, index = np.unique(quads, axis=0, return_inverse=True)
    index = index.reshape(-1, 4)
    faces = np.concatenate([index[:, [0, 1, 2]], index[:, [0, 2, 3]]])
    return low + CELL * points, faces


def write_ply(path, positions, faces):
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(positions)}\nproperty double x\nproperty double y\n"
        f"property double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.empty(len(faces), np.dtype([("n", "u1"), ("index", "<i4", 3)]))
    rows["n"], rows["index"] = 3, faces
    path.write_bytes(header.encode() + positions.astype("<f8").tobytes() + rows.tobytes())


def describe(root, folder):
    """Carves the mesh, has fvvimport write the capture, and returns its path."""
    source = views(root / PARAMETERS)
    folder.mkdir(parents=True, exist_ok=True)
    masks = []
    for name, _, _ in source:
        mask = silhouette(root / name)
        mask.save(folder / f"mask_{name}")  # the name ends in .png
        masks.append(np.asarray(mask) > 127)
    positions, faces = voxel_surface(*carve(source, masks))
    write_ply(folder / MESH, positions, faces)
    capture = folder / "capture.json"
    real.tool(
        *("fvvimport", "middlebury", root / PARAMETERS, "-o", capture, "--force", "--size", "640x480"),
        *("--units", "metres", "--pictures", f"{root}/{{name}}.png", "--masks", "mask_{name}.png"),
        *("--meshes", MESH),
    )
    return capture


def main():
    root = real.data(SOURCE)
    source = views(root / PARAMETERS)
    capture = describe(root, real.WORK / "middlebury_temple")
    positions, faces = real.read_ply(capture.with_name(MESH))
    _, info, out = real.round_trip(capture, "--quality", f"{QUALITY:g}dB")
    real.contact_sheet(capture, iou=0.85)

    decoded = real.read_ply(out / "meshes/0000.ply")
    real.compare_meshes("mesh", (positions, faces), decoded, info["scene"]["lattice_step"])
    written = json.loads((out / "capture.json").read_text())["cameras"]
    real.figure("cameras", len(written), len(source), at_most=False)
    reprojection = 0.0
    for (_, matrix, transform), w in zip(source, written, strict=True):
        i = w["intrinsics"]
        ours = np.array([[i["fx"], i.get("skew", 0), i["cx"]], [0, i["fy"], i["cy"]], [0, 0, 1]])
        there = project(ours, np.column_stack([np.array(w["rotation"]), w["translation"]]), positions)
        reprojection = max(reprojection, np.abs(there - project(matrix, transform, positions) - 0.5).max())
    real.figure("largest reprojection difference, pixels", reprojection, 1e-4)
    real.finish()


if __name__ == "__main__":
    main()
