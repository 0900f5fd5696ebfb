"""Meshes for PyVista (VTK), and meshes from it."""

from __future__ import annotations

from typing import Any

import numpy

from .._core import Mesh
from ..errors import UsageError
from .conventions import upside_down
from .optional_import import optional_import
from .trimesh import MeshArrays


def mesh_to_pyvista(mesh: Mesh) -> Any:
    """A `pyvista.PolyData`: float32 points, triangles, and point data "colours" (uint8, sRGB), "Normals" if they were sent, and
    texture coordinates, all in the order of the vertices."""
    pyvista = optional_import("pyvista", "pyvista")
    # VTK writes to its arrays: it gets copies of arrays that are read-only.
    out = pyvista.PolyData.from_regular_faces(mesh.positions.copy(), mesh.indices.astype(numpy.int64))
    if mesh.colours is not None:
        out.point_data["colours"] = mesh.colours.copy()
    if mesh.has_normals:
        out.point_data.active_normals = mesh.normals.copy()
    if mesh.uvs is not None:
        out.active_texture_coordinates = upside_down(mesh.uvs)
    return out


def mesh_from_pyvista(mesh: Any) -> MeshArrays:
    """The arrays of a `pyvista.PolyData`; faces of more corners are cut into triangles. Normals and texture coordinates come
    along where the mesh has some."""
    pyvista = optional_import("pyvista", "pyvista")
    if not isinstance(mesh, pyvista.PolyData):
        raise UsageError(f"expected a pyvista.PolyData, found {type(mesh).__name__}")
    if not mesh.is_all_triangles:
        mesh = mesh.triangulate()
    normals, uvs = mesh.point_data.active_normals, mesh.active_texture_coordinates
    return MeshArrays(
        numpy.asarray(mesh.points),
        mesh.regular_faces,
        None if normals is None else numpy.asarray(normals),
        None if uvs is None else upside_down(uvs),
    )
