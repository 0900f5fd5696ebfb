"""Meshes and frames for trimesh, and meshes from it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy
from numpy.typing import NDArray

from .._core import Camera, Mesh, Picture
from ..errors import UsageError
from ..frames import Frame
from .conventions import along_minus_z, upside_down
from .optional_import import optional_import


class MeshArrays(NamedTuple):
    """A mesh as arrays: what `fvv.compare` and writers take."""

    positions: NDArray[Any]  #: (vertices, 3) metres.
    indices: NDArray[Any]  #: (faces, 3) vertices, counter-clockwise seen from outside.
    normals: NDArray[Any] | None = None  #: (vertices, 3).
    uvs: NDArray[Any] | None = None  #: (vertices, 2), (0, 0) at the top left corner of the atlas.


def mesh_to_trimesh(mesh: Mesh, atlas: Picture | NDArray[Any] | None = None) -> Any:
    """A `trimesh.Trimesh` with the vertices and faces in their order, vertex colours, and normals if they were sent.

    atlas: the picture that the texture coordinates address; with it, or without colours, the mesh has texture coordinates.
    trimesh keeps float64 and int64: positions and faces are converted.
    """
    trimesh = optional_import("trimesh", "trimesh")
    visual = None
    if mesh.uvs is not None and (atlas is not None or mesh.colours is None):
        material = None
        if atlas is not None:
            image = optional_import("PIL.Image", "trimesh").fromarray(_eight_bits(numpy.asarray(atlas)))
            material = trimesh.visual.material.SimpleMaterial(image=image)
        visual = trimesh.visual.TextureVisuals(uv=upside_down(mesh.uvs), material=material)
    elif mesh.colours is not None:
        visual = trimesh.visual.ColorVisuals(vertex_colors=mesh.colours)
    return trimesh.Trimesh(
        mesh.positions,
        mesh.indices,
        vertex_normals=mesh.normals if mesh.has_normals else None,
        visual=visual,
        process=False,
        metadata={"track": mesh.track},
    )


def _eight_bits(pixels: NDArray[Any]) -> NDArray[numpy.uint8]:
    if pixels.dtype == numpy.uint8:
        return pixels
    if pixels.dtype == numpy.uint16:
        return ((pixels.astype(numpy.uint32) * 255 + 32767) // 65535).astype(numpy.uint8)
    raise UsageError(f"atlas: expected uint8 or uint16, found {pixels.dtype}")


def camera_to_trimesh(camera: Camera) -> tuple[Any, NDArray[numpy.float64]]:
    """A `trimesh.scene.Camera` and its (4, 4) transform, camera to world. trimesh has no lens, skew, or principal point away
    from the picture's centre: they are left out."""
    trimesh = optional_import("trimesh", "trimesh")
    found = trimesh.scene.Camera(
        name=camera.name or f"camera {camera.id}",
        resolution=(camera.width, camera.height),
        focal=(camera.K[0, 0], camera.K[1, 1]),
    )
    return found, along_minus_z(camera)


def frame_to_trimesh(frame: Frame) -> Any:
    """A `trimesh.Scene` of the frame's meshes, with the atlas as texture, and a node for each camera. `scene.camera` is the
    first; `scene.metadata["cameras"]` has all, by the name of their node."""
    trimesh = optional_import("trimesh", "trimesh")
    scene = trimesh.Scene(metadata={"time": frame.time, "number": frame.number})
    for track, mesh in frame.meshes.items():
        atlas = frame.atlas if mesh.uvs is not None else None
        scene.add_geometry(mesh_to_trimesh(mesh, atlas), node_name=f"mesh {track}", geom_name=f"mesh {track}")
    cameras: dict[str, Any] = {}
    for camera in frame.cameras.values():
        found, transform = camera_to_trimesh(camera)
        if not cameras:
            scene.camera = found
        cameras[found.name] = found
        scene.graph.update(frame_to=found.name, matrix=transform)
    scene.metadata["cameras"] = cameras
    return scene


def mesh_from_trimesh(mesh: Any, normals: bool = False) -> MeshArrays:
    """The arrays of a `trimesh.Trimesh`, or of all meshes of a `trimesh.Scene` in the scene's axes as one.

    positions and indices are trimesh's own memory: copy them before the mesh changes.
    normals: those of vertices that trimesh has or computes; texture coordinates come along where the mesh has some.
    """
    trimesh = optional_import("trimesh", "trimesh")
    if isinstance(mesh, trimesh.Scene):
        parts = mesh.dump(concatenate=False)
        parts = [part for part in parts if isinstance(part, trimesh.Trimesh)]
        if not parts:
            raise UsageError("expected a scene with a mesh, found none")
        # trimesh packs textures of several meshes into a new one: only one mesh keeps its coordinates.
        mesh = parts[0] if len(parts) == 1 else _joined(parts)
    if not isinstance(mesh, trimesh.Trimesh):
        raise UsageError(f"expected a trimesh.Trimesh or a trimesh.Scene, found {type(mesh).__name__}")
    uvs = getattr(mesh.visual, "uv", None) if mesh.visual.kind == "texture" else None
    return MeshArrays(
        mesh.vertices.view(numpy.ndarray),
        mesh.faces.view(numpy.ndarray),
        numpy.asarray(mesh.vertex_normals) if normals else None,
        None if uvs is None else upside_down(uvs),
    )


def _joined(parts: list[Any]) -> Any:
    trimesh = optional_import("trimesh", "trimesh")
    return trimesh.util.concatenate(
        [trimesh.Trimesh(part.vertices, part.faces, process=False) for part in parts]
    )
