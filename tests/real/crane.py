#!/usr/bin/env python3
"""crane: fifty frames of a captured person with one topology, in metres, no pictures."""

import tarfile

import real_capture as real

SOURCE = "csail_meshes/crane.first50.tar.xz"


def describe(archive, folder):
    """Unpacks the meshes and returns the path of the capture."""
    folder.mkdir(parents=True, exist_ok=True)
    with tarfile.open(archive) as tar:
        for member in tar:
            name = member.name.split("/")[-1]
            if member.isfile() and name.startswith("mesh_") and name.endswith(".obj"):
                (folder / name).write_bytes(tar.extractfile(member).read())
    count = len(list(folder.glob("mesh_*.obj")))
    description = {
        "fvv_capture": 1,
        "name": "crane",
        "frame_rate": "25",
        "frames": {"first": 0, "count": count},
        "units": "metres",
        "up": "+y",
        "meshes": {"pattern": "mesh_%04d.obj"},
    }
    return real.write_capture(folder, description)


def main():
    folder = real.WORK / "crane"
    capture = describe(real.data(SOURCE), folder)
    count = len(list(folder.glob("mesh_*.obj")))
    _, info, out = real.round_trip(capture, "--step", "1mm")
    step = info["scene"]["lattice_step"]
    for number in range(0, count, 7):
        source = real.read_obj(folder / f"mesh_{number:04d}.obj")
        real.compare_meshes(f"frame {number}", source, real.read_ply(out / f"meshes/{number:04d}.ply"), step)
    real.finish()


if __name__ == "__main__":
    main()
