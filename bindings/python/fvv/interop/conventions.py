"""Conventions of other programs: axes of cameras and worlds, linear light, texture coordinates from the bottom."""

from __future__ import annotations

from typing import Any

import numpy
from numpy.typing import NDArray

from .._core import Camera


def along_minus_z(camera: Camera) -> NDArray[numpy.float64]:
    """(4, 4), camera to world in metres, of a camera that looks along -z with x to the right and y up, as trimesh, USD and
    Blender have it. A camera of this package looks along +z with y down."""
    out = numpy.eye(4)
    out[:3, :3] = camera.R.T * (1, -1, -1)
    out[:3, 3] = camera.centre
    return out


def straightened(
    camera: Camera, ideal: Camera
) -> tuple[NDArray[numpy.float64], NDArray[numpy.intp], NDArray[numpy.bool_]]:
    """For each pixel of a camera at the same place without lens: where the camera's picture shows the same, in pixels and NaN
    where it does not, (height, width, 2); the number of that pixel, counted row by row; and whether there is one, (height,
    width)."""
    rows, columns = numpy.mgrid[: ideal.height, : ideal.width] + 0.5
    at = camera.project(ideal.unproject(numpy.stack([columns, rows], axis=-1), 1.0))
    seen = numpy.isfinite(at).all(axis=-1)
    x, y = numpy.floor(numpy.where(seen[..., None], at, -1)).astype(numpy.intp).transpose(2, 0, 1)
    inside = (x >= 0) & (x < camera.width) & (y >= 0) & (y < camera.height)
    return at, numpy.where(inside, y * camera.width + x, 0), inside


def turned(up: str, to: str) -> NDArray[numpy.float64]:
    """(3, 3): the rotation that turns the axis up ("+x" ... "-z") into the axis to, by the shortest way."""
    axes = []
    for name in (up, to):
        axis = numpy.zeros(3)
        axis["xyz".index(name[1])] = 1 if name[0] == "+" else -1
        axes.append(axis)
    if (axes[0] == -axes[1]).all():
        about = numpy.roll(axes[0], 1)
        return 2 * numpy.outer(about, about) - numpy.eye(3)
    x, y, z = numpy.cross(axes[0], axes[1])
    across = numpy.array([(0, -z, y), (z, 0, -x), (-y, x, 0)])
    out: NDArray[numpy.float64] = numpy.eye(3) + across + across @ across / (1 + axes[0] @ axes[1])
    return out


def linear_of_srgb(codes: NDArray[numpy.uint8]) -> NDArray[numpy.float32]:
    """Light of sRGB codes, 0 to 1 (IEC 61966-2-1)."""
    value = numpy.arange(256) / 255
    table = numpy.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return table.astype(numpy.float32)[codes]


def upside_down(uvs: NDArray[Any]) -> NDArray[Any]:
    """Texture coordinates whose (0, 0) is the bottom left corner as those whose (0, 0) is the top left one, and back: a copy."""
    out = numpy.array(uvs)
    out[:, 1] = 1 - out[:, 1]
    return out
