"""Meshes for Open3D."""

from __future__ import annotations

from typing import Any

import numpy

from .._core import Mesh
from .conventions import upside_down
from .optional_import import optional_import


def mesh_to_open3d(mesh: Mesh) -> Any:
    """An `open3d.geometry.TriangleMesh`: float64 positions and int32 faces in their order, vertex colours, normals if they
    were sent, and texture coordinates of corners. Open3D copies all of them."""
    open3d = optional_import("open3d", "open3d")
    vector = open3d.utility
    out = open3d.geometry.TriangleMesh(
        vector.Vector3dVector(mesh.positions.astype(float)),
        vector.Vector3iVector(mesh.indices.astype(numpy.int32)),
    )
    if mesh.has_normals:
        out.vertex_normals = vector.Vector3dVector(mesh.normals.astype(float))
    if mesh.colours is not None:
        out.vertex_colors = vector.Vector3dVector(mesh.colours / 255)
    if mesh.uvs is not None:
        corners = upside_down(mesh.uvs)[mesh.indices].reshape(-1, 2)
        out.triangle_uvs = vector.Vector2dVector(corners.astype(float))
    return out
