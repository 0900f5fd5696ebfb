"""The objects of a clip in Blender, which follow the frame of the scene."""

from __future__ import annotations

import atexit
import os
import uuid
from typing import Any, Literal

import numpy

from ..._core import Camera, Mesh
from ...clip import Clip, ClipFrame
from ...errors import Error, UsageError
from ...pictures import on_screen
from ..conventions import along_minus_z, turned, upside_down
from ..optional_import import optional_import
from .colours import baked, seen, sent
from .material import COLOURS, SEEN, atlas_material, image_of, vertex_material, view_material
from .pictures import Straightener, StraightPicture
from .stage import ENVIRONMENT, add_environment, add_sound

#: Where a surface takes its colours from: "view", the pictures of the cameras that show it best from where it is seen; "baked", one
#: colour for each vertex from all cameras; "sent", the colours of vertices that are in the stream; "atlas", its texture.
Colours = Literal["view", "baked", "sent", "atlas"]
#: More cameras are baked, unless asked for: each has some 25 nodes and an attribute, of which Eevee has 16.
MOST_CAMERAS = 12
#: Of the root: who it is, and how it is shown. They are kept by .blend files.
IDENTITY, SOURCE, FIRST, CHOSEN, PICTURES = "fvv", "fvv_source", "fvv_first", "fvv_colours", "fvv_pictures"
ORIGIN = "fvv_origin"
#: Of objects below the root.
TRACK, CAMERA = "fvv_track", "fvv_camera"


def load(
    clip: Clip,
    name: str = "fvv",
    *,
    first: int = 0,
    colours: Colours | None = None,
    pictures: bool = True,
    environment: bool = True,
    sound: bool = True,
) -> Shown:
    """Adds a clip to the current scene of Blender (`bpy`), as a collection of that name: an empty as root, which turns the
    stream's up axis to +z, an object for each mesh track, and the cameras.

    first: the frame of the scene at which the clip begins. Meshes are read when the scene's frame changes, in renders too, so
    their faces may change, and nothing is kept in memory. Sets the scene's frames per second, its range of frames, and that
    Blender's windows are locked while it renders. The clip stays open as long as it is shown. `restore` shows clips of a .blend
    file again; `clip.to_usd` makes a file that Blender imports without this package.

    Meshes have a colour attribute "colours", and a UV map and normals where they were sent. colours: where their material takes
    them from; None: "atlas" where there is one, "view" of up to 12 cameras, "baked" of more, and "sent" of none. With motion
    blur they have velocities, from the frames before and after that have the same faces. Cameras have a focal length and shifts
    for the scene's resolution set to theirs, and no lens or skew. Where K[0, 0] and K[1, 1] differ, the scene's pixel aspect y
    over x has to be their ratio.

    pictures: of the cameras, as their background images, without lens. environment: its surfaces and lights. sound: as strips of
    the sequencer. Streams that are far from 0 are shown relative to the origin of their lattice: Blender's numbers are float32.
    """
    if not len(clip):
        raise UsageError(f"{clip.name}: expected a frame to show, found none", file=clip.name)
    bpy = optional_import("bpy", "blender")
    scene = bpy.context.scene
    collection = bpy.data.collections.new(name)
    scene.collection.children.link(collection)
    root = bpy.data.objects.new(f"{collection.name} root", None)
    collection.objects.link(root)
    rotation = numpy.eye(4)
    rotation[:3, :3] = turned(clip.up or "+y", "+z")
    root.matrix_world = _matrix(rotation)
    root[IDENTITY] = uuid.uuid4().hex
    root[SOURCE] = os.path.abspath(clip.name) if os.path.exists(clip.name) else clip.name
    root[FIRST] = first
    root[CHOSEN] = colours or _best_colours(clip)
    root[PICTURES] = pictures
    root[ORIGIN] = _origin(clip)
    scene.render.fps = max(1, round(float(clip.rate)))
    scene.render.fps_base = scene.render.fps / float(clip.rate)
    scene.frame_start, scene.frame_end = first, first + len(clip) - 1
    scene.render.use_lock_interface = True
    shown = Shown(clip, root)
    if environment:
        add_environment(clip, root, numpy.array(root[ORIGIN]))
    if sound:
        add_sound(clip, scene, first, collection.name)
    bpy.context.view_layer.update()
    return shown


def restore() -> list[Shown]:
    """Shows the clips of the .blend file that was opened: opens their files and makes the objects follow them. A clip whose file is
    not there stays as it was saved, and its root has the reason in the property "fvv_problem"."""
    bpy = optional_import("bpy", "blender")
    found = []
    for root in [one for one in bpy.data.objects if IDENTITY in one]:
        try:
            path = root[SOURCE]
            clip = Clip(path if "://" in path else bpy.path.abspath(path))
        except (Error, OSError) as error:
            root["fvv_problem"] = str(error)
            continue
        found.append(Shown(clip, root))
    return found


class Shown:
    """A clip in a scene."""

    def __init__(self, clip: Clip, root: Any) -> None:
        """root: an empty with the properties that `load` gives it."""
        self._bpy = optional_import("bpy", "blender")
        self._clip = clip
        self._identity: str = root[IDENTITY]
        self._straightener = Straightener()
        self._bpy.app.handlers.frame_change_pre.append(self._on_frame)
        # bpy 4.2 crashes where Python ends with a handler left, also one of pure Python.
        atexit.register(self._leave)
        self._update(self._scene)

    # Undo makes new objects of all: they are found by their properties at each use.
    @property
    def root(self) -> Any:
        """The empty that all objects are parented to."""
        for item in self._bpy.data.objects:
            if item.get(IDENTITY) == self._identity:
                return item
        raise UsageError(f"{self._clip.name}: is no longer in this file of Blender", file=self._clip.name)

    @property
    def name(self) -> str:
        """Of the collection. Blender adds a number to a name that is taken."""
        return str(self._collection.name)

    @property
    def meshes(self) -> dict[int, Any]:
        """Objects by mesh track."""
        return {item[TRACK]: item for item in self.root.children if TRACK in item}

    @property
    def cameras(self) -> dict[int, Any]:
        """Objects by identifier."""
        return {item[CAMERA]: item for item in self.root.children if CAMERA in item}

    def show(self, index: int) -> None:
        """Makes the objects those of a frame of the clip."""
        frame = self._clip[index]
        root = self.root
        meshes, cameras = self.meshes, self.cameras
        there = frame.meshes
        for track in sorted(meshes.keys() - there.keys()):
            meshes[track].data.clear_geometry()
        for camera in frame.cameras.values():
            if camera.id not in cameras:
                name = camera.name or f"camera {camera.id}"
                cameras[camera.id] = self._added(name, self._bpy.data.cameras, CAMERA, camera.id)
            elif not camera.moves:
                continue
            _place(cameras[camera.id], camera, root[ORIGIN])
        filmed = self._pictures(frame, cameras, root) if root[PICTURES] or root[CHOSEN] == "view" else []
        for track, mesh in there.items():
            if track not in meshes:
                meshes[track] = self._added(f"mesh {track}", self._bpy.data.meshes, TRACK, track)
            self._fill(meshes[track].data, frame, mesh, filmed, root)

    def remove(self) -> None:
        """Takes the objects out of Blender. May be called again."""
        if not self._leave():
            return
        collection = self._collection
        kinds = (TRACK, CAMERA, ENVIRONMENT)
        added = [one for one in self.root.children if any(kind in one for kind in kinds)]
        for item in [*added, self.root]:
            data = item.data
            self._bpy.data.objects.remove(item)
            if data is not None:
                self._bpy.data.batch_remove([data])
        self._bpy.data.collections.remove(collection)

    @property
    def _collection(self) -> Any:
        return self.root.users_collection[0]

    @property
    def _scene(self) -> Any:
        collection = self._collection
        for scene in self._bpy.data.scenes:
            if collection in scene.collection.children_recursive:
                return scene
        return self._bpy.context.scene

    def _on_frame(self, scene: Any, *_: Any) -> None:
        try:
            if scene == self._scene:
                self._update(scene)
        except UsageError:  # its objects were deleted
            self._leave()

    def _leave(self) -> bool:
        """Follows the scene no more; whether it did."""
        atexit.unregister(self._leave)
        handlers = self._bpy.app.handlers.frame_change_pre
        if self._on_frame not in handlers:
            return False
        handlers.remove(self._on_frame)
        return True

    def _update(self, scene: Any) -> None:
        """Shows what the clip shows at the time of a scene; beyond its ends the first or last frame."""
        root = self.root
        seconds = (scene.frame_current - root[FIRST]) * scene.render.fps_base / scene.render.fps
        # Half a tick is for rates that have no exact number.
        seconds += float(self._clip.time_base) / 2
        last = len(self._clip) - 1
        if seconds < 0:
            index = 0
        elif seconds >= self._clip.duration:
            index = last
        else:
            index = self._clip.at(self._clip.start + seconds).index
        try:
            self.show(index)
            root.pop("fvv_problem", None)
        except Error as error:
            if isinstance(error, UsageError):
                raise
            for item in self.meshes.values():
                item.data.clear_geometry()
            root["fvv_problem"] = str(error)

    def _added(self, name: str, kind: Any, key: str, value: int) -> Any:
        item = self._bpy.data.objects.new(f"{self.name} {name}", kind.new(f"{self.name} {name}"))
        item[key] = value
        if key == TRACK:
            _mark_as_animated(item)
        self._collection.objects.link(item)
        item.parent = self.root
        return item

    def _pictures(self, frame: ClipFrame, cameras: dict[int, Any], root: Any) -> list[StraightPicture]:
        """The pictures of a frame as images, and in the background of the cameras where "pictures" is set."""
        found = []
        for identifier in frame.pictures:
            whole = frame.cameras[identifier]
            ideal, pixels = self._straightener.run(whole, frame.pictures[identifier])
            image = image_of(f"{self.name} {whole.name or whole.id}", pixels)
            found.append(StraightPicture(whole.id, ideal, whole.centre - root[ORIGIN], image))
            data = cameras[whole.id].data
            if root[PICTURES] and not data.background_images:
                data.show_background_images = True
                background = data.background_images.new()
                background.image, background.frame_method, background.alpha = image, "STRETCH", 1.0
        return found

    def _fill(
        self, data: Any, frame: ClipFrame, mesh: Mesh, filmed: list[StraightPicture], root: Any
    ) -> None:
        """Gives Blender's mesh the vertices, faces, colours and material of a mesh."""
        _fill_shape(data, mesh, root[ORIGIN])
        chosen, has_colours = root[CHOSEN], mesh.colours is not None
        atlas = frame.atlas if chosen == "atlas" and mesh.uvs is not None else None
        _fill_colours(data, baked(frame, mesh) if chosen == "baked" else sent(frame, mesh))
        if atlas is not None:
            material = atlas_material(f"{self.name} atlas", on_screen(atlas.pixels))
        elif chosen == "view" and filmed:
            for one in filmed:
                _fill_attribute(
                    data, SEEN.format(one.identifier), "FLOAT", "value", seen(frame, mesh, one.identifier)
                )
            for identifier in set(frame.cameras) - {one.identifier for one in filmed}:
                _fill_attribute(data, SEEN.format(identifier), "FLOAT", "value", None)
            material = view_material(f"{self.name} view", filmed, self._clip.texturing, has_colours)
        else:
            material = vertex_material()
        if len(data.materials) != 1 or data.materials[0] != material:
            data.materials.clear()
            data.materials.append(material)
        # Cycles and Eevee take motion from the attribute of this name.
        _fill_attribute(data, "velocity", "FLOAT_VECTOR", "vector", self._velocities(frame, mesh))

    def _velocities(self, frame: ClipFrame, mesh: Mesh) -> Any:
        """(vertices, 3) metres per second, from the frames beside it with the same faces; None: there is none, or the scene has no
        motion blur."""
        if not self._scene.render.use_motion_blur:
            return None
        ends = [(frame.time, mesh.positions)]
        for index in (frame.index - 1, frame.index + 1):
            if not 0 <= index < len(self._clip) or not self._clip[index].intact:
                continue
            other = self._clip[index]
            near = other.meshes.get(mesh.track)
            if near is not None and numpy.array_equal(near.indices, mesh.indices):
                ends.append((other.time, near.positions))
        ends.sort(key=lambda end: end[0])
        (begin, before), (end, after) = ends[0], ends[-1]
        return None if begin == end else (after - before) / (end - begin)


def _mark_as_animated(item: Any) -> None:
    """Blender's exporters write a mesh for each frame only where something of it is animated, or where it has a modifier: one
    without nodes does nothing. Drivers of a mesh are lost where its faces change."""
    modifier = item.modifiers.new("Frames of the clip", "NODES")
    modifier.show_viewport = modifier.show_render = False


def _best_colours(clip: Clip) -> Colours:
    frame = clip[0]
    if frame.atlas is not None:
        return "atlas"
    filmed = len(frame.pictures)
    if not filmed:
        return "sent"
    return "view" if filmed <= MOST_CAMERAS else "baked"


def _origin(clip: Clip) -> list[float]:
    """Where Blender's 0 is, in the world of the stream."""
    for mesh in clip[0].meshes.values():
        if mesh.positions.dtype == numpy.float64:
            return [float(value) for value in mesh.origin]
    return [0.0, 0.0, 0.0]


def _place(item: Any, camera: Camera, origin: Any) -> None:
    K, data = camera.K, item.data
    data.sensor_fit = "HORIZONTAL"
    data.lens = K[0, 0] * data.sensor_width / camera.width
    data.shift_x = 0.5 - K[0, 2] / camera.width
    data.shift_y = (K[1, 2] - camera.height / 2) / camera.width * K[0, 0] / K[1, 1]
    data.clip_start, data.clip_end = 0.01, 10000
    place = along_minus_z(camera)
    place[:3, 3] -= origin
    item.matrix_local = _matrix(place)


def _matrix(values: Any) -> Any:
    return optional_import("mathutils", "blender").Matrix(values.tolist())


def _fill_shape(data: Any, mesh: Mesh, origin: Any) -> None:
    if len(data.vertices) != mesh.vertex_count or not _same_faces(data, mesh):
        data.clear_geometry()
        data.vertices.add(mesh.vertex_count)
        data.loops.add(3 * mesh.face_count)
        data.polygons.add(mesh.face_count)
        data.loops.foreach_set("vertex_index", mesh.indices.astype(numpy.int32).ravel())
        data.polygons.foreach_set("loop_start", numpy.arange(0, 3 * mesh.face_count, 3, dtype=numpy.int32))
        data.polygons.foreach_set("use_smooth", numpy.ones(mesh.face_count, bool))
    data.vertices.foreach_set("co", (mesh.positions - origin).astype(numpy.float32).ravel())
    if mesh.uvs is not None:
        layer = data.uv_layers.active or data.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", upside_down(mesh.uvs)[mesh.indices].ravel())
    data.update()
    if mesh.has_normals:
        data.normals_split_custom_set_from_vertices(mesh.normals)


def _fill_colours(data: Any, colours: Any) -> None:
    layer = data.color_attributes.get(COLOURS)
    if layer is None:
        layer = data.color_attributes.new(COLOURS, "BYTE_COLOR", "POINT")
    opaque = numpy.ones((len(colours), 4), numpy.float32)
    opaque[:, :3] = colours / 255
    layer.data.foreach_set("color_srgb", opaque.ravel())


def _fill_attribute(data: Any, name: str, kind: str, field: str, values: Any) -> None:
    """An attribute of the vertices; None: there is none."""
    layer = data.attributes.get(name)
    if values is None:
        if layer is not None:
            data.attributes.remove(layer)
        return
    if layer is None:
        layer = data.attributes.new(name, kind, "POINT")
    layer.data.foreach_set(field, values.astype(numpy.float32).ravel())


def _same_faces(data: Any, mesh: Mesh) -> bool:
    if len(data.polygons) != mesh.face_count:
        return False
    known = numpy.zeros(3 * mesh.face_count, numpy.int32)
    data.loops.foreach_get("vertex_index", known)
    return numpy.array_equal(known.reshape(-1, 3), mesh.indices)
