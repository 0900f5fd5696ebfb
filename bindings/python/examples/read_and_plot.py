"""Reads a clip into numpy arrays and plots where its bytes go and how its surface moves.

usage: python read_and_plot.py CLIP.fvv OUT.png
"""

import sys

import fvv
import matplotlib
import numpy

matplotlib.use("agg")
from matplotlib import pyplot  # noqa: E402


def main(path, out):
    with fvv.open(path) as clip:
        times = numpy.array([frame.time for frame in clip])
        height = numpy.array(
            [frame.mesh.positions.max(axis=0) - frame.mesh.positions.min(axis=0) for frame in clip]
        )

        # How far vertices move from frame to frame: while faces stay the same, vertices are the same points of the surface.
        speed = numpy.full(len(clip), numpy.nan)
        for before, after in zip(clip, clip[1:]):
            if numpy.array_equal(before.mesh.indices, after.mesh.indices):
                way = numpy.linalg.norm(after.mesh.positions - before.mesh.positions, axis=1)
                speed[after.index] = numpy.sqrt((way**2).mean()) / (after.time - before.time)

        # Bytes by kind of track.
        chunks = clip.chunks()
        kinds = {track.id: track.kind for track in clip.tracks}
        bytes_of = {}
        for track, size in zip(chunks["track"].tolist(), chunks["size"].tolist()):
            bytes_of[kinds[track]] = bytes_of.get(kinds[track], 0) + size

        figure, (sides, motion, sizes) = pyplot.subplots(1, 3, figsize=(12, 3.5), layout="constrained")
        for axis, name in enumerate("xyz"):
            sides.plot(times, height[:, axis], label=name)
        sides.set(title="Size of the scene", xlabel="time in s", ylabel="m")
        sides.legend()
        motion.plot(times, speed)
        motion.set(title="Motion of the surface", xlabel="time in s", ylabel="m/s (rms)")
        sizes.bar(list(bytes_of), [size / 1000 for size in bytes_of.values()])
        sizes.set(title=f"Bytes of {clip.duration:.2f} s", ylabel="kB")
        figure.savefig(out, dpi=120)

        print(f"{len(clip)} frames, {max(len(frame.mesh.positions) for frame in clip)} vertices at most")
        print(f"fastest frame: {numpy.nanmax(speed):.2f} m/s at {times[numpy.nanargmax(speed)]:.2f} s")


if __name__ == "__main__":
    main(*sys.argv[1:])
