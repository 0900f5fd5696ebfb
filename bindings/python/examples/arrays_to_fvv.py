"""Writes a stream from numpy arrays: a ball that rolls before four cameras, with pictures, masks and a mesh for each frame.

usage: python arrays_to_fvv.py OUT.fvv [FRAMES]
"""

import sys

import fvv
import numpy

SIZE = 192, 144  # pixels
RADIUS = 0.5  # metres


def camera(identifier, angle, distance=4.0):
    """Looks at (0, 0.5, 0) from a circle; x right, y down, z forward."""
    centre = numpy.array([distance * numpy.sin(angle), 1.2, distance * numpy.cos(angle)])
    forward = numpy.array([0, 0.5, 0]) - centre
    forward /= numpy.linalg.norm(forward)
    right = numpy.cross(forward, [0, 1, 0])
    right /= numpy.linalg.norm(right)
    rotation = numpy.stack([right, numpy.cross(forward, right), forward])
    width, height = SIZE
    matrix = [[220, 0, width / 2], [0, 220, height / 2], [0, 0, 1]]
    return fvv.Camera(identifier, matrix, rotation, -rotation @ centre, SIZE, name=f"camera {identifier}")


def sphere(rings=24):
    """(positions, faces) of a ball around the origin, faces counter-clockwise seen from outside."""
    columns = 2 * rings
    polar, around = numpy.meshgrid(
        numpy.linspace(0, numpy.pi, rings + 1)[1:-1],
        2 * numpy.pi * numpy.arange(columns) / columns,
        indexing="ij",
    )
    ring = numpy.stack(
        [numpy.sin(polar) * numpy.sin(around), numpy.cos(polar), numpy.sin(polar) * numpy.cos(around)],
        axis=-1,
    )
    positions = RADIUS * numpy.concatenate([ring.reshape(-1, 3), [[0, 1, 0], [0, -1, 0]]])
    index = numpy.arange((rings - 1) * columns).reshape(rings - 1, columns)
    beside = numpy.roll(index, -1, axis=1)
    top, bottom = len(positions) - 2, len(positions) - 1
    corners = (index[:-1], index[1:], beside[1:], beside[:-1])
    a, b, c, d = (one.ravel() for one in corners)
    caps = [
        [numpy.full(columns, top), index[0], beside[0]],
        [numpy.full(columns, bottom), beside[-1], index[-1]],
    ]
    faces = numpy.concatenate([numpy.stack(three, axis=1) for three in ([a, b, c], [a, c, d], *caps)])
    return positions, faces.astype(numpy.uint32)


def photograph(of, centre, turn):
    """The picture of the ball by rays, uint8 (height, width, 3), and its mask, bool (height, width)."""
    width, height = SIZE
    columns, rows = numpy.meshgrid(numpy.arange(width) + 0.5, numpy.arange(height) + 0.5)
    origin, ways = of.ray(numpy.stack([columns, rows], axis=-1))
    along = ways @ (centre - origin)
    under = along**2 - ((centre - origin) ** 2).sum() + RADIUS**2
    mask = under > 0
    normals = (origin + (along - numpy.sqrt(under.clip(0)))[..., None] * ways - centre) / RADIUS
    # A beach ball: stripes that turn with it, lit from above.
    longitude = numpy.arctan2(normals[..., 1], normals[..., 0]) + turn
    stripes = (numpy.floor(longitude / (numpy.pi / 4)) % 2)[..., None]
    colour = stripes * [220, 60, 40] + (1 - stripes) * [240, 240, 230]
    shade = 0.6 + 0.4 * normals[..., 1:2].clip(0)
    picture = numpy.where(mask[..., None], colour * shade, [90, 110, 130])
    return picture.round().astype(numpy.uint8), mask


def main(out, frames="20"):
    cameras = [camera(i, numpy.radians(90 * i + 20)) for i in range(4)]
    positions, faces = sphere()
    with fvv.Writer(out, rate=25, cameras=cameras, up="+y", name="a ball", force=True, group=10) as writer:
        for i in range(int(frames)):
            centre = numpy.array([0.02 * i - 0.2, RADIUS, 0])
            turn = 0.02 * i / RADIUS
            c, s = numpy.cos(turn), numpy.sin(turn)
            rolled = positions @ numpy.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) + centre
            seen = [photograph(one, centre, turn) for one in cameras]
            writer.add((rolled, faces), [picture for picture, _ in seen], [mask for _, mask in seen])
    with fvv.open(out) as clip:
        error = numpy.linalg.norm(
            numpy.linalg.norm(clip[0].mesh.positions - [-0.2, RADIUS, 0], axis=1) - RADIUS, numpy.inf
        )
        print(f"{len(clip)} frames, {clip.size} bytes; the ball is off by {1000 * error:.2f} mm at most")


if __name__ == "__main__":
    main(*sys.argv[1:])
