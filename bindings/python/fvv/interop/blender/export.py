"""Meshes of Blender as a stream: with a baked texture, with pictures that Blender renders of them, or alone."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any, Callable

import numpy
from numpy.typing import NDArray

from ..._core import Camera
from ...errors import UsageError
from ...pictures import on_screen, png
from ...writer import Writer, mux
from ..optional_import import optional_import

Progress = Callable[[int, int], object]
#: Of the cameras of a ring: width in radians, and how far above the horizon they are.
RING_VIEW = math.radians(45)
RING_HEIGHT = math.radians(12)


class _Shape:
    """Faces of all objects at one time, in metres on the axes of the scene."""

    def __init__(self, positions: Any, faces: Any, uvs: Any) -> None:
        self.positions: NDArray[numpy.float32] = positions
        self.faces: NDArray[numpy.int32] = faces
        #: (faces, 3, 2), (0, 0) at the bottom left corner; None: an object has none.
        self.uvs: NDArray[numpy.float32] | None = uvs


def export_rendered(
    path: str,
    objects: Sequence[Any],
    cameras: Sequence[Any],
    *,
    force: bool = False,
    progress: Progress | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Writes objects from the first to the last frame of the scene, with the pictures that its renderer makes of them from each camera,
    at the scene's resolution. Other meshes are not rendered meanwhile. options: of `fvv.Writer`. Returns what it returns."""
    bpy = optional_import("bpy", "blender")
    scene = bpy.context.scene
    if not cameras:
        raise UsageError(f"{path}: expected a camera in the scene, found none")
    frames = _frames(scene)
    with tempfile.TemporaryDirectory() as folder, _Alone(scene, objects):
        scene.frame_set(frames[0])
        first = [_camera_of(scene, one, i) for i, one in enumerate(cameras)]
        writer = Writer(path, rate=_rate(scene), cameras=first, up="+z", force=force, **options)
        with writer:
            for done, number in enumerate(frames):
                scene.frame_set(number)
                shape = _shape_of(objects)
                placed = [_camera_of(scene, one, i) for i, one in enumerate(cameras)]
                views = [_rendered(scene, one, folder) for one in cameras]
                writer.add(
                    (shape.positions, shape.faces),
                    [view[..., :3] for view in views],
                    [view[..., 3] for view in views],
                    calibration=placed if _moves(cameras) else None,
                )
                if progress is not None:
                    progress(done + 1, len(frames))
    return writer.summary or {}


def export_textured(
    path: str,
    objects: Sequence[Any],
    *,
    force: bool = False,
    progress: Progress | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Writes objects from the first to the last frame of the scene, with the image of their material as an atlas; they share one image, and
    their active UV maps place them in it. Without an image the meshes are alone. options: of `fvv.mux`. Returns what it returns."""
    scene = optional_import("bpy", "blender").context.scene
    frames = _frames(scene)
    image = _image_of(objects, path)
    encoded = None if image is None else png(_pixels_of(image)[..., :3])
    with tempfile.TemporaryDirectory() as folder:
        for done, number in enumerate(frames):
            scene.frame_set(number)
            shape = _shape_of(objects)
            if image is not None and shape.uvs is None:
                raise UsageError(
                    f"{path}: expected a UV map of each mesh with the image {image.name}, found one without"
                )
            _write_obj(os.path.join(folder, f"{done:05d}.obj"), shape)
            if encoded is not None:
                with open(os.path.join(folder, f"{done:05d}.png"), "wb") as file:
                    file.write(encoded)
            if progress is not None:
                progress(done + 1, len(frames))
        if image is not None:
            options["atlas"] = os.path.join(folder, "%05d.png")
        meshes = os.path.join(folder, "%05d.obj")
        options |= {"meshes": meshes, "fps": str(_rate(scene)), "up": "+z", "units": "metres"}
        return mux(None, path, force=force, **options)


def add_ring(objects: Sequence[Any], count: int) -> list[Any]:
    """Cameras around objects, which have all of them in their pictures from the first to the last frame of the scene: new objects of
    the scene, one in three higher than the others."""
    bpy = optional_import("bpy", "blender")
    mathutils = optional_import("mathutils", "blender")
    scene = bpy.context.scene
    low, high = numpy.full(3, numpy.inf), numpy.full(3, -numpy.inf)
    for number in _frames(scene):
        scene.frame_set(number)
        positions = _shape_of(objects).positions
        low, high = numpy.minimum(low, positions.min(axis=0)), numpy.maximum(high, positions.max(axis=0))
    middle, radius = (low + high) / 2, float(numpy.linalg.norm(high - low)) / 2
    width, height = _size(scene)
    narrower = math.atan(math.tan(RING_VIEW / 2) * min(1, height / width))
    distance = radius / math.sin(narrower)
    found = []
    for i in range(count):
        around, above = 2 * math.pi * i / count, RING_HEIGHT * (3 if i % 3 == 2 else 1)
        towards = numpy.array(
            (math.cos(around) * math.cos(above), math.sin(around) * math.cos(above), math.sin(above))
        )
        data = bpy.data.cameras.new(f"ring {i}")
        data.sensor_fit, data.angle = "HORIZONTAL", RING_VIEW
        data.clip_start, data.clip_end = distance / 1000, distance * 10
        item = bpy.data.objects.new(data.name, data)
        item.location = (middle + distance * towards).tolist()
        item.rotation_mode = "QUATERNION"
        item.rotation_quaternion = mathutils.Vector((-towards).tolist()).to_track_quat("-Z", "Y")
        scene.collection.objects.link(item)
        found.append(item)
    bpy.context.view_layer.update()
    return found


class _Alone:
    """The scene as it is rendered for an export: without other meshes, on nothing, as PNG; afterwards as it was."""

    def __init__(self, scene: Any, objects: Sequence[Any]) -> None:
        others = [one for one in scene.objects if one.type == "MESH" and one not in objects]
        render, view = scene.render, scene.view_settings
        self._values = [
            *((one, "hide_render", True) for one in others),
            (render, "film_transparent", True),
            (render, "filepath", ""),
            (render.image_settings, "file_format", "PNG"),
            (render.image_settings, "color_mode", "RGBA"),
            (render.image_settings, "color_depth", "8"),
            (scene, "camera", scene.camera),
            (scene, "frame_current", scene.frame_current),
            (view, "view_transform", view.view_transform),
        ]
        self._before: list[tuple[Any, str, Any]] = []

    def __enter__(self) -> None:
        for owner, name, value in self._values:
            self._before.append((owner, name, getattr(owner, name)))
            setattr(owner, name, value)

    def __exit__(self, *_: object) -> None:
        for owner, name, value in reversed(self._before):
            setattr(owner, name, value)


def _frames(scene: Any) -> list[int]:
    return list(range(scene.frame_start, scene.frame_end + 1))


def _rate(scene: Any) -> Fraction:
    return Fraction(scene.render.fps) / Fraction(scene.render.fps_base).limit_denominator(1001)


def _size(scene: Any) -> tuple[int, int]:
    part = scene.render.resolution_percentage / 100
    return int(scene.render.resolution_x * part), int(scene.render.resolution_y * part)


def _shapes(objects: Sequence[Any]) -> Iterator[tuple[Any, Any, Any]]:
    graph = optional_import("bpy", "blender").context.evaluated_depsgraph_get()
    for item in objects:
        evaluated = item.evaluated_get(graph)
        mesh = evaluated.to_mesh()
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        positions = numpy.zeros((len(mesh.vertices), 3), numpy.float32)
        faces, corners = (numpy.zeros((count, 3), numpy.int32) for _ in range(2))
        mesh.vertices.foreach_get("co", positions.ravel())
        mesh.loop_triangles.foreach_get("vertices", faces.ravel())
        mesh.loop_triangles.foreach_get("loops", corners.ravel())
        uvs = None
        if mesh.uv_layers.active is not None:
            flat = numpy.zeros((len(mesh.loops), 2), numpy.float32)
            mesh.uv_layers.active.data.foreach_get("uv", flat.ravel())
            uvs = flat[corners]
        to_world = numpy.array(evaluated.matrix_world)
        positions = positions @ to_world[:3, :3].T + to_world[:3, 3]
        if numpy.linalg.det(to_world[:3, :3]) < 0:  # mirrored
            faces, uvs = faces[:, ::-1], None if uvs is None else uvs[:, ::-1]
        evaluated.to_mesh_clear()
        yield positions, faces, uvs


def _shape_of(objects: Sequence[Any]) -> _Shape:
    positions, faces, uvs, base = [], [], [], 0
    for its_positions, its_faces, its_uvs in _shapes(objects):
        positions.append(its_positions)
        faces.append(its_faces + base)
        uvs.append(its_uvs)
        base += len(its_positions)
    if not sum(map(len, faces)):
        raise UsageError("objects: expected meshes with faces, found none")
    return _Shape(
        numpy.concatenate(positions).astype(numpy.float32),
        numpy.concatenate(faces).astype(numpy.int32),
        None if any(one is None for one in uvs) else numpy.concatenate(uvs),
    )


def _write_obj(path: str, shape: _Shape) -> None:
    with open(path, "w") as file:
        numpy.savetxt(file, shape.positions, "v %.7g %.7g %.7g")
        if shape.uvs is None:
            numpy.savetxt(file, shape.faces + 1, "f %d %d %d")
            return
        places, corners = numpy.unique(shape.uvs.reshape(-1, 2), axis=0, return_inverse=True)
        numpy.savetxt(file, places, "vt %.7g %.7g")
        both = numpy.stack([shape.faces, corners.reshape(-1, 3)], axis=-1) + 1
        numpy.savetxt(file, both.reshape(-1, 6), "f %d/%d %d/%d %d/%d")


def _image_of(objects: Sequence[Any], path: str) -> Any:
    """The image that all objects are textured with; None: there is none."""
    found = {
        node.image
        for item in objects
        for slot in item.material_slots
        if slot.material is not None and slot.material.use_nodes
        for node in slot.material.node_tree.nodes
        if node.type == "TEX_IMAGE" and node.image is not None
    }
    if len(found) > 1:
        names = ", ".join(sorted(one.name for one in found))
        raise UsageError(f"{path}: expected one image for all materials, found {names}: bake them into one")
    image = found.pop() if found else None
    if image is not None and image.source in ("MOVIE", "SEQUENCE"):
        raise UsageError(f"{path}: expected an image that is no film, found {image.name}")
    return image


def _pixels_of(image: Any) -> NDArray[numpy.uint8]:
    """(height, width, 4), sRGB."""
    width, height = image.size
    flat = numpy.empty(4 * width * height, numpy.float32)
    image.pixels.foreach_get(flat)
    values = flat.reshape(height, width, 4)[::-1]
    rounded: NDArray[numpy.uint8] = numpy.rint(255 * values.clip(0, 1)).astype(numpy.uint8)
    if image.is_float:
        rounded[..., :3] = on_screen(values[..., :3])
    return rounded


def _rendered(scene: Any, camera: Any, folder: str) -> NDArray[numpy.uint8]:
    """(height, width, 4): colours and how much of the pixel shows the objects."""
    bpy = optional_import("bpy", "blender")
    scene.camera = camera
    scene.render.filepath = os.path.join(folder, "view.png")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    image.alpha_mode = "CHANNEL_PACKED"  # colours as the file has them: those of the objects alone
    pixels = _pixels_of(image)
    bpy.data.images.remove(image)
    return pixels


def _moves(cameras: Sequence[Any]) -> bool:
    return any(
        owner.animation_data is not None or getattr(owner, "constraints", None)
        for camera in cameras
        for one in (camera, camera.parent)
        if one is not None
        for owner in (one, one.data)
        if owner is not None
    )


def _camera_of(scene: Any, item: Any, identifier: int) -> Camera:
    if item.data.type != "PERSP":
        raise UsageError(f"{item.name}: expected a perspective camera, found {item.data.type}")
    width, height = _size(scene)
    graph = optional_import("bpy", "blender").context.evaluated_depsgraph_get()
    render = scene.render
    # Of clip space, whose y is up.
    P = numpy.array(
        item.evaluated_get(graph).calc_matrix_camera(
            graph, x=width, y=height, scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y
        )
    )
    K = numpy.array(
        [
            [P[0, 0] * width / 2, 0, (1 - P[0, 2]) * width / 2],
            [0, P[1, 1] * height / 2, (1 + P[1, 2]) * height / 2],
            [0, 0, 1],
        ]
    )
    to_world = numpy.array(item.evaluated_get(graph).matrix_world)
    axes = to_world[:3, :3] * (1.0, -1.0, -1.0)
    left, _, right = numpy.linalg.svd(axes / numpy.linalg.norm(axes, axis=0))  # Blender's numbers are float32
    R = left @ right
    return Camera(identifier, K, R.T, -R.T @ to_world[:3, 3], (width, height), name=item.name)
