"""A clip in Blender: its meshes and cameras follow the frame of the scene."""

from __future__ import annotations

from typing import Any

import numpy

from .._core import Camera, Mesh
from ..clip import Clip, ClipFrame
from .conventions import along_minus_z, turned, upside_down
from .optional_import import optional_import


def load(clip: Clip, name: str = "fvv") -> Shown:
    """Adds a clip to the current scene of Blender (`bpy`), as a collection of that name: an empty as root, which turns the
    stream's up axis to +z, an object for each mesh track, and the cameras.

    Frame i of the scene is `clip[i]`: meshes are read when the scene's frame changes, so faces may change too, and nothing is
    kept in memory. Sets the scene's frames per second and its range of frames. The clip stays open as long as it is shown. A
    .blend file keeps the frame that was shown last: `clip.to_usd` makes a file that Blender imports with its motion.

    Meshes have a colour attribute "colours", and a UV map and normals where they were sent. Cameras have a focal length and
    shifts for the scene's resolution set to theirs, and no lens or skew. Where K[0, 0] and K[1, 1] differ, the scene's pixel
    aspect y over x has to be their ratio.
    """
    return Shown(clip, name)


class Shown:
    """A clip in a scene."""

    def __init__(self, clip: Clip, name: str) -> None:
        self._bpy = optional_import("bpy", "blender")
        self._clip = clip
        self._scene = self._bpy.context.scene
        self._collection = self._bpy.data.collections.new(name)
        self._scene.collection.children.link(self._collection)
        #: Of the collection. Blender adds a number to a name that is taken.
        self.name: str = self._collection.name
        #: The empty that all objects are parented to.
        self.root = self._added("root", None)
        rotation = numpy.eye(4)
        rotation[:3, :3] = turned(clip.up or "+y", "+z")
        self.root.matrix_world = _matrix(rotation)
        #: Objects by mesh track.
        self.meshes: dict[int, Any] = {}
        #: Objects by identifier.
        self.cameras: dict[int, Any] = {}
        self._scene.render.fps = max(1, round(float(clip.rate)))
        self._scene.render.fps_base = self._scene.render.fps / float(clip.rate)
        self._scene.frame_start, self._scene.frame_end = 0, len(clip) - 1
        self._bpy.app.handlers.frame_change_pre.append(self._on_frame)
        self.show(min(max(self._scene.frame_current, 0), len(clip) - 1))
        self._bpy.context.view_layer.update()

    def show(self, index: int) -> None:
        """Makes the objects those of a frame of the clip."""
        frame: ClipFrame = self._clip[index]
        for track, mesh in frame.meshes.items():
            if track not in self.meshes:
                data = self._bpy.data.meshes.new(f"{self.name} mesh {track}")
                self.meshes[track] = self._added(f"mesh {track}", data)
            _fill(self.meshes[track].data, mesh)
        for camera in frame.cameras.values():
            if camera.id not in self.cameras:
                data = self._bpy.data.cameras.new(camera.name or f"camera {camera.id}")
                self.cameras[camera.id] = self._added(data.name, data)
            elif not camera.moves:
                continue
            self._place(self.cameras[camera.id], camera)

    def remove(self) -> None:
        """Takes the objects out of Blender. May be called again."""
        handlers = self._bpy.app.handlers.frame_change_pre
        if self._on_frame in handlers:
            handlers.remove(self._on_frame)
            for item in [*self.meshes.values(), *self.cameras.values(), self.root]:
                data = item.data
                self._bpy.data.objects.remove(item)
                if data is not None:
                    kind = (
                        self._bpy.data.meshes
                        if isinstance(data, self._bpy.types.Mesh)
                        else self._bpy.data.cameras
                    )
                    kind.remove(data)
            self._bpy.data.collections.remove(self._collection)

    def _on_frame(self, scene: Any, *_: Any) -> None:
        if scene == self._scene and 0 <= scene.frame_current < len(self._clip):
            self.show(scene.frame_current)

    def _added(self, name: str, data: Any) -> Any:
        item = self._bpy.data.objects.new(f"{self.name} {name}", data)
        self._collection.objects.link(item)
        if data is not None:
            item.parent = self.root
        return item

    @staticmethod
    def _place(item: Any, camera: Camera) -> None:
        K, data = camera.K, item.data
        data.sensor_fit = "HORIZONTAL"
        data.lens = K[0, 0] * data.sensor_width / camera.width
        data.shift_x = 0.5 - K[0, 2] / camera.width
        data.shift_y = (K[1, 2] - camera.height / 2) / camera.width * K[0, 0] / K[1, 1]
        data.clip_start, data.clip_end = 0.01, 10000
        item.matrix_local = _matrix(along_minus_z(camera))


def _matrix(values: Any) -> Any:
    return optional_import("mathutils", "blender").Matrix(values.tolist())


def _fill(data: Any, mesh: Mesh) -> None:
    """Gives Blender's mesh the vertices and faces of a mesh."""
    if len(data.vertices) != mesh.vertex_count or not _same_faces(data, mesh):
        data.clear_geometry()
        data.vertices.add(mesh.vertex_count)
        data.loops.add(3 * mesh.face_count)
        data.polygons.add(mesh.face_count)
        data.loops.foreach_set("vertex_index", mesh.indices.astype(numpy.int32).ravel())
        data.polygons.foreach_set("loop_start", numpy.arange(0, 3 * mesh.face_count, 3, dtype=numpy.int32))
        data.polygons.foreach_set("use_smooth", numpy.ones(mesh.face_count, bool))
    data.vertices.foreach_set("co", mesh.positions.ravel())
    if mesh.colours is not None:
        layer = data.color_attributes.get("colours")
        if layer is None:
            layer = data.color_attributes.new("colours", "BYTE_COLOR", "POINT")
        opaque = numpy.ones((mesh.vertex_count, 4), numpy.float32)
        opaque[:, :3] = mesh.colours / 255
        layer.data.foreach_set("color_srgb", opaque.ravel())
    if mesh.uvs is not None:
        layer = data.uv_layers.active or data.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", upside_down(mesh.uvs)[mesh.indices].ravel())
    data.update()
    if mesh.has_normals:
        data.normals_split_custom_set_from_vertices(mesh.normals)


def _same_faces(data: Any, mesh: Mesh) -> bool:
    if len(data.polygons) != mesh.face_count:
        return False
    known = numpy.zeros(3 * mesh.face_count, numpy.int32)
    data.loops.foreach_get("vertex_index", known)
    return numpy.array_equal(known.reshape(-1, 3), mesh.indices)
