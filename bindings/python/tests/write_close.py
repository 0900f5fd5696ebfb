"""Writes 240 streams and prints by how many bytes the process grew in the last 200: it has nothing else to free."""

import gc
import io
import os
import pathlib
import sys

import fvv
from open_close import resident

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "tests/real"))  # for scenes
from scenes import ball, camera, picture


def once(folder, i, mesh, of):
    target = io.BytesIO() if i % 2 else folder / f"{i}.fvv"
    cheap = {"codec": "jpeg", "quality": 80, "group": 1, "threads": 1, "colours": False, "visibility": "none"}
    writer = fvv.Writer(target, rate=25, cameras=[of], **cheap)
    for _ in range(2):
        writer.add(mesh, [picture(of, 90)])
    if i % 3 == 0:
        writer.finish()
    elif i % 3 == 1:
        writer.close()
    if i % 6 == 0:
        os.unlink(target)


def main():
    folder = pathlib.Path(sys.argv[1])
    mesh, of = ball(4), camera()
    descriptors = len(os.listdir("/proc/self/fd"))
    sizes = []
    for i in range(241):
        once(folder, i, mesh, of)
        if i % 20 == 0:
            gc.collect()
            sizes.append(resident())
    assert len(os.listdir("/proc/self/fd")) == descriptors and not os.listdir(folder)
    print(sizes[-1] - sizes[2])


if __name__ == "__main__":
    main()
