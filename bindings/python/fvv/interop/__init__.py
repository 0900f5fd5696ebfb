"""Other packages: converters from and to them. Each package is imported when it is needed; `pip install fvv[all]` has all of
them but Open3D, Rerun, torch and Blender."""

from __future__ import annotations

from .._core import Mesh
from . import blender, imageio, rerun, usd
from .dlpack import Shared, shared
from .open3d import mesh_to_open3d
from .pyvista import mesh_from_pyvista, mesh_to_pyvista
from .trimesh import MeshArrays, camera_to_trimesh, frame_to_trimesh, mesh_from_trimesh, mesh_to_trimesh
from .xarray import clip_to_dicts, clip_to_xarray

__all__ = [
    "MeshArrays",
    "Shared",
    "blender",
    "camera_to_trimesh",
    "clip_to_dicts",
    "clip_to_xarray",
    "frame_to_trimesh",
    "imageio",
    "mesh_from_pyvista",
    "mesh_from_trimesh",
    "mesh_to_open3d",
    "mesh_to_pyvista",
    "mesh_to_trimesh",
    "rerun",
    "shared",
    "usd",
]

# Methods of a class that is written in C++.
for _name, _method in (
    ("to_trimesh", mesh_to_trimesh),
    ("to_open3d", mesh_to_open3d),
    ("to_pyvista", mesh_to_pyvista),
):
    setattr(Mesh, _name, _method)
