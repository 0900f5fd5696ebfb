"""Materials that show the colours of a clip as they were filmed: they give light and take none."""

from __future__ import annotations

from typing import Any

import numpy
from numpy.typing import NDArray

from ..optional_import import optional_import


def vertex_material(name: str, attribute: str) -> Any:
    """The colours of an attribute of the mesh."""
    bpy = optional_import("bpy", "blender")
    material = bpy.data.materials.get(name)
    if material is not None:
        return material
    material, tree, emission = _emission(name)
    colour = tree.nodes.new("ShaderNodeAttribute")
    colour.attribute_name = attribute
    tree.links.new(colour.outputs["Color"], emission.inputs["Color"])
    return material


def atlas_material(name: str, pixels: NDArray[numpy.uint8]) -> Any:
    """A texture by the UV map of the mesh: the picture of this moment."""
    bpy = optional_import("bpy", "blender")
    image = image_of(name, pixels)
    material = bpy.data.materials.get(name)
    if material is None:
        material, tree, emission = _emission(name)
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = image
        tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    return material


def image_of(name: str, pixels: NDArray[numpy.uint8]) -> Any:
    """Blender's image of that name with these pixels, (height, width, 3), sRGB."""
    bpy = optional_import("bpy", "blender")
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(name)
    if image is not None and tuple(image.size) != (width, height):
        image.scale(width, height)
    if image is None:
        image = bpy.data.images.new(name, width, height)
    opaque = numpy.ones((height, width, 4), numpy.float32)
    opaque[..., :3] = pixels[::-1] / numpy.float32(255)  # Blender's first row is the lowest
    image.pixels.foreach_set(opaque.ravel())
    image.update()
    return image


def _emission(name: str) -> tuple[Any, Any, Any]:
    bpy = optional_import("bpy", "blender")
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])
    return material, tree, emission
