"""One colour for each vertex, from all cameras that see it: the same from every side. Needs no Blender."""

from __future__ import annotations

import numpy
from numpy.typing import NDArray

from ..._core import Camera, Mesh
from ...clip import ClipFrame
from ...pictures import on_screen
from ...view import render
from .pictures import BORDER, sampled

#: Of a vertex behind the surface that a camera sees, in widths of a pixel.
DEPTH_BIAS = 1.5

Weights = NDArray[numpy.float64]


def baked(frame: ClipFrame, mesh: Mesh) -> NDArray[numpy.uint8]:
    """(vertices, 3), sRGB: of each vertex the mean of the cameras that face it best. What no camera sees has the colour that was
    sent, else grey."""
    cameras = list(frame.pictures)
    texturing = frame._description.texturing
    shown_at = mesh.positions - texturing.inset * mesh.normals
    weights = numpy.zeros((len(cameras), mesh.vertex_count))
    samples = numpy.zeros((len(cameras), mesh.vertex_count, 3))
    for i, identifier in enumerate(cameras):
        picture = frame.pictures[identifier]
        if picture.camera is None:
            continue
        at = picture.camera.project(shown_at)
        facing = (_cosines(mesh, picture.camera) - texturing.threshold).clip(0, 1)
        weights[i] = seen(frame, mesh, int(identifier)).clip(0, 1) * facing**2
        weights[i] *= _border(at, picture.camera)
        samples[i] = sampled(on_screen(picture.pixels), at)
    _keep_best(weights, texturing.best)
    total = weights.sum(axis=0)
    found = sent(frame, mesh).astype(numpy.float64)
    shown = total > 0
    mixed = numpy.einsum("cv,cvk->vk", weights, samples)
    found[shown] = mixed[shown] / total[shown, None]
    return numpy.rint(found).astype(numpy.uint8)


def sent(frame: ClipFrame, mesh: Mesh) -> NDArray[numpy.uint8]:
    """(vertices, 3), sRGB: the colours that were sent, else what the stream has for what no camera shows."""
    if mesh.colours is not None:
        return mesh.colours
    return numpy.full((mesh.vertex_count, 3), frame._description.texturing.unseen, numpy.uint8)


def seen(frame: ClipFrame, mesh: Mesh, camera: int) -> Weights:
    """(vertices,): how much of the surface around each vertex a camera sees, -1 nothing to 1 everything, by the weights of the
    stream, else by a depth map."""
    if mesh.track == frame._description.meshes[0]:
        weights = frame.visibility(camera)
        if weights is not None:
            return (weights - 127.5) / 127.5
    return _by_depth(frame, mesh, camera)


def _by_depth(frame: ClipFrame, mesh: Mesh, camera: int) -> Weights:
    view = frame.cameras[camera]
    drawn = render(frame._clip, frame, camera, pictures=False, environment=False, layers=True)
    height, width = drawn.depth.shape
    column, row = _pixels(view.project(mesh.positions))
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    nearest = drawn.depth[row.clip(0, height - 1), column.clip(0, width - 1)]
    depth = view.depth(mesh.positions)
    # The depth changes within a pixel, and more so where the surface is seen at a grazing angle.
    width_of_pixel = depth / view.K[0, 0]
    slack = DEPTH_BIAS * width_of_pixel / _cosines(mesh, view).clip(0.1, 1)
    return numpy.where(inside & (depth <= nearest + slack), 1.0, -1.0)


def _cosines(mesh: Mesh, camera: Camera) -> Weights:
    towards = camera.centre - mesh.positions
    towards /= numpy.linalg.norm(towards, axis=1, keepdims=True)
    cosines: Weights = numpy.einsum("vk,vk->v", mesh.normals, towards)
    return cosines


def _border(at: Weights, camera: Camera) -> Weights:
    distance = numpy.minimum(at - 0.5, (camera.width - 0.5, camera.height - 0.5) - at).min(axis=1)
    ramp: Weights = numpy.nan_to_num(distance / BORDER, nan=0.0).clip(0, 1)
    return ramp


def _pixels(at: Weights) -> tuple[NDArray[numpy.intp], NDArray[numpy.intp]]:
    column, row = numpy.floor(numpy.nan_to_num(at, nan=-1.0).clip(-1, 1 << 20)).astype(numpy.intp).T
    return column, row


def _keep_best(weights: Weights, best: int) -> None:
    """Leaves the largest weights of each vertex, less the largest that is not kept, so that cameras come and go smoothly."""
    if len(weights) <= best:
        return
    next_best = numpy.sort(weights, axis=0)[-best - 1]
    weights -= next_best
    numpy.clip(weights, 0, None, out=weights)
