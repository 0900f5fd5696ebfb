#!/usr/bin/env python3
"""scvv_hoxel: fifty frames of a captured person in Draco files, each with a JPEG atlas of its own, at about 30 Hz.

The meshes are read by DracoPy, which is not part of what is tested. Frames were taken 31 to 36 ms apart; a capture
has one frame rate: 30 here, the recording's average_fps.
"""

import json

import DracoPy
import numpy as np
import real_capture as real

SOURCE = "scvv_hoxel"
FIRST, COUNT = 855, 50
STEP = 0.0005  # metres
TEXTURE_BITS = 12
TARGET = 40  # dB
WINDING = "--winding", "flip"  # the source's faces run clockwise, seen from outside


def read_draco(path):
    """Positions, triangles, texture coordinates (n x 2, v down) of each corner."""
    mesh = DracoPy.decode(path.read_bytes())
    faces = mesh.faces.astype(np.int64)
    texture = np.asarray(mesh.tex_coord, np.float64) * [1, -1] + [0, 1]
    return np.asarray(mesh.points, np.float64), faces, texture[faces]


def textured_triangles(positions, faces, texture):
    """Sorted triples of (lattice point, texture indices), independent of the order of vertices and faces."""
    lattice = np.rint(positions / STEP).astype(np.int64)[faces]
    indices = np.rint(np.clip(texture, 0, 1) * 2**TEXTURE_BITS).astype(np.int64)
    corners = np.concatenate([lattice, indices], axis=2)
    return {tuple(sorted(map(tuple, t))) for t in corners.tolist()}


def compare_frame(number, source, out):
    positions, faces, texture = read_draco(source / f"{number:06d}_scandycore_raw_frame.draco")
    decoded, decoded_faces = real.read_ply(out / f"meshes/{number:04d}.ply")
    pairs = real.read_ply_texture(out / f"meshes/{number:04d}.ply")
    name = f"frame {number}"
    real.compare_meshes(name, (positions, faces), (decoded, decoded_faces), STEP)
    extra = textured_triangles(decoded, decoded_faces, pairs[decoded_faces]) - textured_triangles(
        positions, faces, texture
    )
    real.figure(f"{name}: textured triangles that the source does not have", len(extra), 0)
    difference = real.luma(source / f"{number:06d}_scandycore_raw_frame.jpg") - real.luma(
        out / f"atlas/{number:04d}.png"
    )
    psnr = 10 * np.log10(255**2 / np.mean(difference**2))
    real.figure(f"{name}: luma PSNR of the atlas in dB", psnr, TARGET - 2, at_most=False)


def describe(source, folder):
    """Links the meshes under names that fvvmux takes and returns the path of the capture."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in source.glob("*.draco"):
        link = folder / f"{path.stem}.drc"
        link.unlink(missing_ok=True)
        link.symlink_to(path)
    description = {
        "fvv_capture": 1,
        "name": "hoxel",
        "frame_rate": "30",
        "frames": {"first": FIRST, "count": COUNT},
        "units": "metres",
        "up": "-x",
        "meshes": {"pattern": "%06d_scandycore_raw_frame.drc"},
        "atlas": {"pictures": str(source / "%06d_scandycore_raw_frame.jpg")},
    }
    return real.write_capture(folder, description)


def main():
    source = real.data(SOURCE)
    capture = describe(source, real.WORK / "scvv_hoxel")
    frames = ["--frames", f"{FIRST}-{FIRST + COUNT - 1}"]
    wishes = ["--step", f"{STEP}", "--texture-bits", TEXTURE_BITS, "--quality", f"{TARGET}dB"]
    # Two frames have a speck of less than a square millimetre, which vanishes on the lattice.
    _, _, out = real.round_trip(capture, *frames, *wishes, *WINDING, code=3)
    described = json.loads((out / "capture.json").read_text())["atlas"]
    assert described == {"pictures": "atlas/%04d.png", "texture_bits": TEXTURE_BITS}, described
    for number in range(FIRST, FIRST + COUNT, 7):
        compare_frame(number, source, out)
    real.finish()


if __name__ == "__main__":
    main()
