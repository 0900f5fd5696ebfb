"""What is around the action of a clip in Blender: the environment with its lights, and sound. Neither changes with the frame."""

from __future__ import annotations

import math
import os
import tempfile
import warnings
import wave
from typing import Any

import numpy

from ..._core import Sound
from ...clip import Clip
from ...environment import EnvironmentPart, Light
from ..conventions import upside_down
from ..optional_import import optional_import
from .material import Nodes, emission_material

#: Of objects below the root: a part or a light of the environment.
ENVIRONMENT = "fvv_environment"
#: Lumens of a watt, as Blender's importer of glTF has it.
LUMENS = 683.0
LIGHTS = {"directional": "SUN", "point": "POINT", "spot": "SPOT"}


def add_environment(clip: Clip, root: Any, origin: Any) -> None:
    """Objects below the root for the environment of the first frame. Its surfaces show their pictures and take no light; lights are for
    objects that are added."""
    environment = clip[0].environment
    if environment is None:
        return
    bpy = optional_import("bpy", "blender")
    images = []
    for i, content in enumerate(environment.pictures):
        images.append(_packed_image(f"{root.name} picture {i}", content))
    for i, part in enumerate(environment.parts):
        data = bpy.data.meshes.new(f"{root.name} environment {i}")
        vertices = part.mesh.positions - origin
        data.from_pydata(vertices.tolist(), [], part.mesh.indices.tolist())
        if part.uvs is not None:
            layer = data.uv_layers.new(name="UVMap")
            layer.data.foreach_set(
                "uv", upside_down(part.uvs)[part.mesh.indices].ravel().astype(numpy.float32)
            )
        data.materials.append(_material(data.name, part, images))
        _link(root, bpy.data.objects.new(data.name, data), i)
    for i, light in enumerate(environment.lights):
        _link(root, _light(f"{root.name} light {i}", light, origin), len(environment.parts) + i)


def add_sound(clip: Clip, scene: Any, first: int, name: str) -> None:
    """Strips of the sequencer with the sound of a clip, which are part of the .blend file."""
    sounds = clip.audio
    if not sounds:
        return
    if not optional_import("bpy", "blender").app.build_options.audaspace:
        warnings.warn(f"{clip.name}: this build of Blender has no sound", RuntimeWarning, stacklevel=3)
        return
    editor = scene.sequence_editor or scene.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences  # Blender 4.3 and earlier
    tracks = sorted({sound.track for sound in sounds})
    for sound in sounds:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, f"{name} {sound.title or 'sound'}.wav")
            _write_wave(path, sound)
            begin = first + (sound.start - clip.start) * scene.render.fps / scene.render.fps_base
            channel = 1 + tracks.index(sound.track)
            strip = strips.new_sound(f"{name} sound", path, channel, round(begin))
            strip.sound.pack()


def _write_wave(path: str, sound: Sound) -> None:
    codes = numpy.rint(sound.samples().clip(-1, 1) * 32767).astype("<i2")
    with wave.open(path, "wb") as file:
        file.setnchannels(sound.channels)
        file.setsampwidth(2)
        file.setframerate(sound.rate)
        file.writeframes(codes.tobytes())


def _link(root: Any, item: Any, number: int) -> None:
    item[ENVIRONMENT] = number
    root.users_collection[0].objects.link(item)
    item.parent = root


def _packed_image(name: str, content: bytes) -> Any:
    """An image of a file's bytes. Blender reads only files."""
    bpy = optional_import("bpy", "blender")
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "picture.png" if content.startswith(b"\x89PNG") else "picture.jpg")
        with open(path, "wb") as file:
            file.write(content)
        image = bpy.data.images.load(path)
        image.name = name
        image.pack()
    return image


def _material(name: str, part: EnvironmentPart, images: list[Any]) -> Any:
    material, nodes = emission_material(name)
    colour: Any = (*part.colour, 1.0)
    if part.picture is not None:
        picture = nodes.add(
            "ShaderNodeTexImage",
            image=images[part.picture],
            extension="EXTEND" if part.clamped else "REPEAT",
        )
        colour = nodes.vector("MULTIPLY", picture.outputs["Color"], part.colour)
    _finish(nodes, colour, part.double_sided)
    return material


def _finish(nodes: Nodes, colour: Any, is_double_sided: bool) -> None:
    surface = nodes.add("ShaderNodeEmission", (colour,)).outputs[0]
    if not is_double_sided:
        clear = nodes.add("ShaderNodeBsdfTransparent").outputs[0]
        back = nodes.add("ShaderNodeNewGeometry").outputs["Backfacing"]
        surface = nodes.add("ShaderNodeMixShader", (back, surface, clear)).outputs[0]
    nodes.add("ShaderNodeOutputMaterial", (surface,))


def _light(name: str, light: Light, origin: Any) -> Any:
    bpy = optional_import("bpy", "blender")
    mathutils = optional_import("mathutils", "blender")
    data = bpy.data.lights.new(name, LIGHTS[light.kind])
    data.color = light.colour
    data.use_shadow = light.casts_shadows
    if light.kind == "directional":
        data.energy = light.intensity / LUMENS
    else:
        data.energy = light.intensity * 4 * math.pi / LUMENS
        data.shadow_soft_size = 0
    if light.kind == "spot":
        data.spot_size = 2 * light.outer_cone
        data.spot_blend = 1 - light.inner_cone / light.outer_cone
    item = bpy.data.objects.new(name, data)
    item.location = [float(value) for value in numpy.subtract(light.position, origin)]
    if light.kind != "point":  # a light of Blender shines along -z
        item.rotation_mode = "QUATERNION"
        item.rotation_quaternion = mathutils.Vector(light.direction).to_track_quat("-Z", "Y")
    return item
