"""Materials that show the colours of a clip as they were filmed: they give light and take none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy
from numpy.typing import NDArray

from ...records import Texturing
from ..optional_import import optional_import
from .pictures import StraightPicture

#: The attribute of vertices with their colours, and the one with what a camera sees: -1 nothing to 1 everything.
COLOURS = "colours"
SEEN = "fvv seen {}"
#: Of the next best camera, what is taken from the weights of the best (clause 17.5).
NEXT_BEST = 1023 / 1024
#: Registers of the nodes that look for the best cameras.
MOST_BEST = 4


def vertex_material() -> Any:
    """The colours of vertices."""
    bpy = optional_import("bpy", "blender")
    material = bpy.data.materials.get("fvv colours")
    if material is None:
        material, nodes = emission_material("fvv colours")
        _emit(nodes, nodes.attribute(COLOURS, "Color"))
    return material


def atlas_material(name: str, pixels: NDArray[numpy.uint8]) -> Any:
    """A texture by the UV map of the mesh: the picture of this moment."""
    bpy = optional_import("bpy", "blender")
    image = image_of(name, pixels)
    material = bpy.data.materials.get(name)
    if material is None:
        material, nodes = emission_material(name)
        _emit(nodes, nodes.add("ShaderNodeTexImage", image=image).outputs["Color"])
    return material


def view_material(
    name: str, pictures: Sequence[StraightPicture], texturing: Texturing, has_colours: bool
) -> Any:
    """The pictures of the cameras of this moment, projected: at each point those are mixed that show it best to who looks at it
    (clause 17.5). The nodes are made once for a set of cameras; pictures and calibrations are those of the last call."""
    bpy = optional_import("bpy", "blender")
    material = bpy.data.materials.get(name)
    if material is None:
        material = bpy.data.materials.new(name)
    identifiers = [one.identifier for one in pictures]
    if list(material.get("fvv_cameras", [])) != identifiers:
        _build_view(material, identifiers, texturing, has_colours)
        material["fvv_cameras"] = identifiers
    for one in pictures:
        camera, node = one.camera, material.node_tree.nodes[f"camera {one.identifier}"]
        K, width, height = camera.K, camera.width, camera.height
        values = {
            "Centre": one.centre,
            "Right": camera.R[0],
            "Down": camera.R[1],
            "Forward": camera.R[2],
            "Scale": (K[0, 0] / width, -K[1, 1] / height, 0),
            "Shift": (K[0, 2] / width, 1 - K[1, 2] / height, 0),
        }
        # Blender compiles materials again whose constants were set, also to what they were.
        given = [float(number) for value in values.values() for number in value]
        if list(node.get("fvv_given", [])) != given:
            node["fvv_given"] = given
            for key, value in values.items():
                node.inputs[key].default_value = [float(number) for number in value]
        picture = material.node_tree.nodes[f"picture {one.identifier}"]
        if picture.image != one.image:
            picture.image = one.image
    return material


def image_of(name: str, pixels: NDArray[numpy.uint8]) -> Any:
    """Blender's image of that name with these pixels: (height, width, 3 or 4), sRGB; the fourth is no transparency."""
    bpy = optional_import("bpy", "blender")
    height, width, channels = pixels.shape
    image = bpy.data.images.get(name)
    if image is None:
        image = bpy.data.images.new(name, width, height, alpha=channels == 4)
        image.alpha_mode = "CHANNEL_PACKED"
    elif tuple(image.size) != (width, height):
        image.scale(width, height)
    values = numpy.ones((height, width, 4), numpy.float32)
    # Blender's first row is the lowest.
    numpy.multiply(pixels[::-1], numpy.float32(1 / 255), out=values[..., :channels])
    image.pixels.foreach_set(values.ravel())
    image.update()
    return image


class Nodes:
    """Makes nodes of a tree. Inputs are sockets or constants."""

    def __init__(self, tree: Any) -> None:
        self.tree = tree

    def add(self, kind: str, inputs: Sequence[Any] = (), **settings: Any) -> Any:
        node = self.tree.nodes.new(kind)
        for key, value in settings.items():
            setattr(node, key, value)
        for socket, value in zip(node.inputs, inputs):
            if hasattr(value, "is_output"):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = value
        return node

    def math(self, operation: str, *inputs: Any, clamp: bool = False) -> Any:
        return self.add("ShaderNodeMath", inputs, operation=operation, use_clamp=clamp).outputs[0]

    def vector(self, operation: str, *inputs: Any) -> Any:
        node = self.add("ShaderNodeVectorMath", inputs, operation=operation)
        return node.outputs["Value" if operation in ("DOT_PRODUCT", "LENGTH") else "Vector"]

    def scaled(self, vector: Any, factor: Any) -> Any:
        node = self.add("ShaderNodeVectorMath", (vector,), operation="SCALE")
        if hasattr(factor, "is_output"):
            self.tree.links.new(factor, node.inputs["Scale"])
        else:
            node.inputs["Scale"].default_value = factor
        return node.outputs["Vector"]

    def attribute(self, name: str, output: str) -> Any:
        return self.add("ShaderNodeAttribute", attribute_name=name).outputs[output]

    def in_object(self, vector: Any, kind: str) -> Any:
        """A vector of the world on the axes of the object, of unit length."""
        node = self.add(
            "ShaderNodeVectorTransform", vector_type=kind, convert_from="WORLD", convert_to="OBJECT"
        )
        self.tree.links.new(vector, node.inputs[0])
        return self.vector("NORMALIZE", node.outputs[0])


def emission_material(name: str) -> tuple[Any, Nodes]:
    """A new material without nodes, and what makes them."""
    material = optional_import("bpy", "blender").data.materials.new(name)
    return material, Nodes(_cleared(material))


def _cleared(material: Any) -> Any:
    material.use_nodes = True
    material.node_tree.nodes.clear()
    return material.node_tree


def _emit(nodes: Nodes, colour: Any) -> None:
    emission = nodes.add("ShaderNodeEmission", (colour,)).outputs[0]
    nodes.add("ShaderNodeOutputMaterial", (emission,))


def _build_view(material: Any, cameras: Sequence[int], texturing: Texturing, has_colours: bool) -> None:
    nodes = Nodes(_cleared(material))
    geometry = nodes.add("ShaderNodeNewGeometry")
    position = nodes.add("ShaderNodeTexCoord").outputs["Object"]
    normal = nodes.in_object(geometry.outputs["Normal"], "NORMAL")
    viewer = nodes.in_object(geometry.outputs["Incoming"], "VECTOR")
    inside = position
    if texturing.inset:
        cosine = nodes.math("MAXIMUM", nodes.vector("DOT_PRODUCT", normal, viewer), 0.5)
        inward = nodes.scaled(viewer, nodes.math("DIVIDE", texturing.inset, cosine))
        inside = nodes.vector("SUBTRACT", position, inward)
    shared = _camera_group()
    found = []
    for identifier in cameras:
        given = (position, inside, normal, viewer, texturing.threshold)
        camera = nodes.add("ShaderNodeGroup", node_tree=shared, name=f"camera {identifier}")
        for socket, value in zip(camera.inputs, given):
            if hasattr(value, "is_output"):
                nodes.tree.links.new(value, socket)
            else:
                socket.default_value = value
        picture = nodes.add(
            "ShaderNodeTexImage", (camera.outputs["Place"],), extension="CLIP", name=f"picture {identifier}"
        )
        seen = nodes.math("MAXIMUM", nodes.attribute(SEEN.format(identifier), "Fac"), 0.0)
        # As clause 17.5 has it: s times b, and the border b is the image's fourth channel.
        shown = nodes.math(
            "MULTIPLY", nodes.math("MULTIPLY", seen, picture.outputs["Alpha"]), camera.outputs["Facing"]
        )
        weight = shown
        if texturing.blend == "viewer":
            weight = nodes.math("DIVIDE", shown, nodes.math("POWER", camera.outputs["Away"], 2.0))
        found.append((weight, shown, picture.outputs["Color"]))
    _emit(nodes, _mixed(nodes, found, min(texturing.best, MOST_BEST), texturing, has_colours))


def _mixed(
    nodes: Nodes, found: Sequence[tuple[Any, Any, Any]], best: int, texturing: Texturing, has_colours: bool
) -> Any:
    """The colour of the best cameras. found: weight, weight without the viewer, and colour of each."""
    largest: list[Any] = [0.0] * (best + 1)
    for weight, _, _ in found:
        rest = weight
        for i, one in enumerate(largest):
            largest[i], rest = nodes.math("MAXIMUM", one, rest), nodes.math("MINIMUM", one, rest)
    next_best = nodes.math("MULTIPLY", largest[best], NEXT_BEST)
    total: Any = 0.0
    clear: Any = 0.0
    colour: Any = (0.0, 0.0, 0.0)
    for weight, shown, picture in found:
        kept = nodes.math("MAXIMUM", nodes.math("SUBTRACT", weight, next_best), 0.0)
        total = nodes.math("ADD", total, kept)
        clear = nodes.math("MULTIPLY_ADD", kept, shown, clear)
        colour = nodes.vector("ADD", colour, nodes.scaled(picture, kept))
    least = nodes.math("MAXIMUM", total, 1e-12)
    mean = nodes.scaled(colour, nodes.math("DIVIDE", 1.0, least))
    part = nodes.math("GREATER_THAN", total, 1e-9)
    if has_colours and texturing.blend == "viewer":
        part = nodes.math("MULTIPLY", nodes.math("DIVIDE", clear, least), 10.0, clamp=True)
    sent = nodes.scaled(nodes.attribute(COLOURS, "Color"), nodes.math("SUBTRACT", 1.0, part))
    return nodes.vector("ADD", nodes.scaled(mean, part), sent)


def _camera_group() -> Any:
    """What a camera has to do with a point: its place in the picture, how much the surface faces it, and how far its direction is from
    the viewer's."""
    bpy = optional_import("bpy", "blender")
    tree = bpy.data.node_groups.get("fvv camera")
    if tree is not None:
        return tree
    tree = bpy.data.node_groups.new("fvv camera", "ShaderNodeTree")
    vectors = ("Position", "Inside", "Normal", "Viewer")
    for name in vectors:
        tree.interface.new_socket(name, in_out="INPUT", socket_type="NodeSocketVector")
    tree.interface.new_socket("Threshold", in_out="INPUT", socket_type="NodeSocketFloat")
    for name in ("Centre", "Right", "Down", "Forward", "Scale", "Shift"):
        tree.interface.new_socket(name, in_out="INPUT", socket_type="NodeSocketVector")
    tree.interface.new_socket("Place", in_out="OUTPUT", socket_type="NodeSocketVector")
    for name in ("Facing", "Away"):
        tree.interface.new_socket(name, in_out="OUTPUT", socket_type="NodeSocketFloat")
    nodes = Nodes(tree)
    given = nodes.add("NodeGroupInput").outputs
    towards = nodes.vector("NORMALIZE", nodes.vector("SUBTRACT", given["Centre"], given["Position"]))
    seen_from = nodes.vector("SUBTRACT", given["Inside"], given["Centre"])
    right, down, forward = (
        nodes.vector("DOT_PRODUCT", seen_from, given[key]) for key in ("Right", "Down", "Forward")
    )
    is_before = nodes.math("GREATER_THAN", forward, 1e-6)
    depth = nodes.math("MAXIMUM", forward, 1e-6)
    ratios = nodes.add(
        "ShaderNodeCombineXYZ", (nodes.math("DIVIDE", right, depth), nodes.math("DIVIDE", down, depth))
    )
    place = nodes.vector("MULTIPLY_ADD", ratios.outputs[0], given["Scale"], given["Shift"])
    cosine = nodes.vector("DOT_PRODUCT", given["Normal"], towards)
    over = nodes.math("SUBTRACT", cosine, given["Threshold"])
    facing = nodes.math("DIVIDE", over, nodes.math("SUBTRACT", 1.0001, given["Threshold"]))
    facing = nodes.math("MULTIPLY", nodes.math("MAXIMUM", facing, 0.0), is_before)
    away = nodes.math("SUBTRACT", 1.01, nodes.vector("DOT_PRODUCT", towards, given["Viewer"]))
    nodes.add("NodeGroupOutput", (place, facing, away))
    return tree
