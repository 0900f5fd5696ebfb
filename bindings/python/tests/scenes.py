"""Small scenes as arrays, to write."""

import json

import fvv
import numpy
from PIL import Image
from real_capture import read_ply

TETRAHEDRON = numpy.array([[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0], [0, 0, 0.5]])
FACES = numpy.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], numpy.uint32)


def ball(rings=16, radius=0.5, shift=0.0):
    """A sphere: positions and indices, counter-clockwise seen from outside."""
    longitudes = 2 * rings
    polar = numpy.pi * numpy.arange(1, rings) / rings
    around = 2 * numpy.pi * numpy.arange(longitudes) / longitudes
    sides = numpy.stack(
        [
            numpy.outer(numpy.sin(polar), numpy.cos(around)),
            numpy.outer(numpy.sin(polar), numpy.sin(around)),
            numpy.outer(numpy.cos(polar), numpy.ones(longitudes)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    positions = radius * numpy.concatenate([sides, [[0, 0, 1], [0, 0, -1]]]) + [shift, 0, 0]
    top, bottom = len(positions) - 2, len(positions) - 1
    faces = []
    for i in range(longitudes):
        j = (i + 1) % longitudes
        faces += [[top, i, j], [bottom, (rings - 2) * longitudes + j, (rings - 2) * longitudes + i]]
        for r in range(rings - 2):
            a, b = r * longitudes + i, r * longitudes + j
            faces += [[a, a + longitudes, b], [b, a + longitudes, b + longitudes]]
    return positions, numpy.array(faces, numpy.uint32)


def camera(identifier=0, x=0.0, size=(64, 48), name="", **more):
    """Looks along +z from 3 m before the origin."""
    width, height = size
    matrix = [[60, 0, width / 2], [0, 60, height / 2], [0, 0, 1]]
    return fvv.Camera(identifier, matrix, numpy.eye(3), [x, 0, 3], size, name=name, **more)


def picture(of, value, dtype=numpy.uint8):
    """A grey picture of a camera's size with a brighter middle."""
    pixels = numpy.full((of.height, of.width, 3), value, dtype)
    pixels[of.height // 4 : -of.height // 4, of.width // 4 : -of.width // 4] = value + (
        0.25 if dtype == numpy.float32 else numpy.iinfo(dtype).max // 4
    )
    return pixels


def read_capture(folder):
    """Cameras, and a function that gives frame i of a capture of fvvsynth: mesh, pictures, masks."""
    described = json.loads((folder / "capture.json").read_text())
    cameras = [
        fvv.Camera(
            one["id"],
            [
                [one["intrinsics"]["fx"], one["intrinsics"]["skew"], one["intrinsics"]["cx"]],
                [0, one["intrinsics"]["fy"], one["intrinsics"]["cy"]],
                [0, 0, 1],
            ],
            one["rotation"],
            one["translation"],
            (one["width"], one["height"]),
            one["lens"]["coefficients"],
            one["lens"]["model"],
            one["name"],
        )
        for one in described["cameras"]
    ]

    def opened(path):
        with Image.open(path) as image:
            return numpy.array(image)

    def frame(i):
        return (
            read_ply(folder / f"meshes/{i:04}.ply"),
            {c.id: opened(folder / c.name / f"{i:04}.png") for c in cameras},
            {c.name: opened(folder / c.name / f"mask_{i:04}.png") for c in cameras},
        )

    return described, cameras, frame
