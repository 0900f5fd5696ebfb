"""A clip as an xarray dataset, or as plain dicts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy

from .._core import Camera, Mesh
from ..clip import EVERY, Clip, ClipFrame
from .optional_import import optional_import


def clip_to_dicts(clip: Clip, frames: slice = EVERY) -> Iterator[dict[str, Any]]:
    """Each frame as a dict of plain values and arrays: "time" (seconds), "number", "mesh" (None, or a dict of "positions",
    "indices", and where they were sent "normals", "uvs", "colours"), and "cameras" (a dict by identifier of dicts). Meshes may
    differ in their numbers of vertices and faces. Arrays are those of the frame, without copies."""
    for frame in clip[frames]:
        yield {
            "time": frame.time,
            "number": frame.number,
            "mesh": None if frame.mesh is None else _mesh(frame.mesh),
            "cameras": {camera.id: _camera(camera) for camera in frame.cameras.values()},
        }


def _mesh(mesh: Mesh) -> dict[str, Any]:
    out: dict[str, Any] = {"positions": mesh.positions, "indices": mesh.indices}
    if mesh.has_normals:
        out["normals"] = mesh.normals
    if mesh.uvs is not None:
        out["uvs"] = mesh.uvs
    if mesh.colours is not None:
        out["colours"] = mesh.colours
    return out


def _camera(camera: Camera) -> dict[str, Any]:
    names = ("name", "width", "height", "K", "R", "t", "centre", "lens", "distortion", "r_max", "moves")
    return {name: getattr(camera, name) for name in names}


def clip_to_xarray(clip: Clip, frames: slice = EVERY) -> Any:
    """An `xarray.Dataset` with the dimensions time (seconds) and camera (identifiers): calibrations, and NaN where a camera is not
    calibrated; vertex_count and face_count, 0 where there is no mesh.

    Where all meshes have the same faces it has indices (face, corner) and positions (time, vertex, axis) too, NaN where there
    is no mesh; with colours and normals where all meshes sent them. Where faces change, the attribute "topology" is
    "changes" and the meshes are left out: `clip.to_dicts()` has them. Units are in the attributes of the variables.
    """
    xarray = optional_import("xarray", "xarray")
    chosen = clip[frames]
    meshes = [frame.mesh for frame in chosen]
    counts = {"description": "0: no mesh"}
    variables: dict[str, Any] = {
        "number": ("time", [frame.number for frame in chosen]),
        "vertex_count": ("time", [0 if m is None else m.vertex_count for m in meshes], counts),
        "face_count": ("time", [0 if m is None else m.face_count for m in meshes], counts),
    }
    cameras, names = _calibrations(chosen)
    variables.update(cameras)
    some = [mesh for mesh in meshes if mesh is not None]
    constant = bool(some) and all(numpy.array_equal(m.indices, some[0].indices) for m in some)
    constant = constant and all(m.vertex_count == some[0].vertex_count for m in some)
    if constant:
        variables.update(_tracked(meshes, some))
    return xarray.Dataset(
        variables,
        coords={
            "time": ("time", [frame.time for frame in chosen], {"units": "s"}),
            "camera": ("camera", [identifier for identifier, _ in names]),
            "camera_name": ("camera", [name for _, name in names]),
            "axis": ["x", "y", "z"],
        },
        attrs={
            "topology": "constant" if constant else "changes" if some else "none",
            "up": clip.up or "",
            "rate": float(clip.rate),
            "axes_of_cameras": "x_camera = R x_world + t; x right, y down, z forward; pixel centres at .5",
        },
    )


def _tracked(meshes: list[Mesh | None], some: list[Mesh]) -> dict[str, Any]:
    """Meshes that share their faces, over time."""

    def over_time(name: str, dtype: Any, missing: Any) -> Any:
        out = numpy.full((len(meshes), some[0].vertex_count, 3), missing, dtype)
        for row, mesh in zip(out, meshes):
            if mesh is not None:
                row[:] = getattr(mesh, name)
        return out

    out: dict[str, Any] = {
        "indices": (
            ("face", "corner"),
            some[0].indices,
            {"description": "vertices, counter-clockwise from outside"},
        ),
        "positions": (
            ("time", "vertex", "axis"),
            over_time("positions", some[0].positions.dtype, numpy.nan),
            {"units": "m"},
        ),
    }
    if all(mesh.has_normals for mesh in some):
        out["normals"] = (
            ("time", "vertex", "axis"),
            over_time("normals", numpy.float32, numpy.nan),
            {"units": "1"},
        )
    if all(mesh.colours is not None for mesh in some):
        out["colours"] = (("time", "vertex", "rgb"), over_time("colours", numpy.uint8, 0), {"units": "sRGB"})
    return out


def _calibrations(frames: list[ClipFrame]) -> tuple[dict[str, Any], list[tuple[int, str]]]:
    known: dict[int, Camera] = {}
    for frame in frames:
        for camera in frame.cameras.values():
            known.setdefault(camera.id, camera)
    shapes = {
        "K": (("row", "column"), (3, 3), "pixels"),
        "R": (("row", "column"), (3, 3), "1"),
        "t": (("axis",), (3,), "m"),
        "centre": (("axis",), (3,), "m"),
        "distortion": (("coefficient",), (8,), "1"),
    }
    out: dict[str, Any] = {}
    for name, (dimensions, shape, unit) in shapes.items():
        values = numpy.full((len(frames), len(known), *shape), numpy.nan)
        for row, frame in zip(values, frames):
            for place, identifier in enumerate(known):
                if (found := frame.cameras.get(identifier)) is not None:
                    row[place] = getattr(found, name)
        out[name] = (("time", "camera", *dimensions), values, {"units": unit})
    for name in ("width", "height"):
        out[name] = ("camera", [getattr(camera, name) for camera in known.values()], {"units": "pixels"})
    out["lens"] = ("camera", [camera.lens for camera in known.values()])
    return out, [(identifier, camera.name) for identifier, camera in known.items()]
