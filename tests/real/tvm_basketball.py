#!/usr/bin/env python3
"""tvm_basketball_player: ten captured meshes with different connectivity in every frame, no pictures."""

import real_capture as real

SOURCE = "tvm_basketball_player"


def describe(root, folder):
    """Returns the path of the capture."""
    description = {
        "fvv_capture": 1,
        "name": "basketball player",
        "frame_rate": "30",
        "frames": {"first": 11, "count": 10},
        "units": "unknown",
        "up": "+y",
        "meshes": {"pattern": str(root / "basketball_player_fr%04d.obj")},
    }
    return real.write_capture(folder, description)


def main():
    root = real.data(SOURCE)
    _, info, out = real.round_trip(describe(root, real.WORK / "tvm_basketball"))
    step = info["scene"]["lattice_step"]
    for number in range(11, 21):
        source = real.read_obj(root / f"basketball_player_fr{number:04d}.obj")
        real.compare_meshes(f"frame {number}", source, real.read_ply(out / f"meshes/{number:04d}.ply"), step)
    real.finish()


if __name__ == "__main__":
    main()
