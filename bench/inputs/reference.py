"""What a mesh file holds, read by trimesh: triangles with their places in the scene, and the colour in the middle of each."""

import pathlib
import re
import warnings

import numpy as np
import trimesh

from . import polygons


class NotUsable(Exception):
    """The file holds no triangle mesh, is not whole, or lacks companions: the reason."""


def read(path):
    """(corners (n, 3, 3), colours (n, 3) with NaN where there are none)."""
    require_companions(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = trimesh.load(path, process=False, force="scene")
    except Exception as error:  # of many kinds: whatever a reader in Python meets
        raise NotUsable(f"trimesh cannot read it: {error or type(error).__name__}") from error
    corners, colours = [], []
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        mesh = scene.geometry[name]
        if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces):
            continue
        points = mesh.vertices @ transform[:3, :3].T + transform[:3, 3]
        placed = points[mesh.faces]
        if np.linalg.det(transform[:3, :3]) < 0:
            placed = placed[:, ::-1]
        corners.append(placed)
        colours.append(colours_of(mesh))
    if not corners:
        raise NotUsable("it holds no triangle mesh")
    corners, colours = np.concatenate(corners), np.concatenate(colours)
    if pathlib.Path(path).suffix.lower() == ".obj":
        try:
            own = polygons.concave_triangles(path)
        except polygons.NotPlane:
            raise NotUsable("it has concave polygons that are not plane, which no one surface fits") from None
        if own is not None:
            # trimesh cuts all of them as fans.
            corners, colours = own, np.full((len(own), 3), np.nan)
    if not np.isfinite(corners).all():
        raise NotUsable("it has vertices that are not finite")
    return corners, colours


def require_companions(path):
    """Raises NotUsable where a file that this one names is absent."""
    path = pathlib.Path(path)
    if path.suffix.lower() == ".obj":
        for library in named_in(path, "mtllib"):
            beside = path.parent / library
            if not beside.exists():
                raise NotUsable(f"{library} is not in the package")
            for picture in named_in(beside, "map_Kd"):
                if not (path.parent / picture.replace("\\", "/")).exists():
                    raise NotUsable(f"{picture} is not in the package")
    if path.suffix.lower() == ".gltf":
        for name in re.findall(r'"uri"\s*:\s*"([^"]+)"', path.read_text()):
            if not name.startswith("data:") and not (path.parent / name).exists():
                raise NotUsable(f"{name} is not in the package")


def named_in(path, keyword):
    text = path.read_text(errors="replace")
    return [one.strip() for one in re.findall(rf"^\s*{keyword}[ \t]+(.+)$", text, re.M)]


def colours_of(mesh):
    """Of each face, 0 to 255: the texture in its middle, else the mean of its corners' colours, else NaN."""
    none = np.full((len(mesh.faces), 3), np.nan)
    visual = mesh.visual
    if visual.kind == "vertex":
        return np.asarray(visual.vertex_colors, float)[mesh.faces].mean(1)[:, :3]
    if visual.kind != "texture" or visual.uv is None:
        return none
    material = visual.material
    picture = getattr(material, "baseColorTexture", None) or getattr(material, "image", None)
    if picture is None:
        return none
    factor = getattr(material, "baseColorFactor", None)
    found = sampled(picture, visual.uv[mesh.faces].mean(1))
    return found if factor is None else of_light(light(found) * np.asarray(factor, float)[:3] / 255)


def light(levels):
    """Of sRGB levels, 0 to 1: glTF's factors are of light."""
    part = levels / 255
    return np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)


def of_light(part):
    return 255 * np.where(part <= 0.0031308, 12.92 * part, 1.055 * part ** (1 / 2.4) - 0.055)


def sampled(picture, places):
    """The nearest pixels of texture coordinates, whose v counts from below, as in OBJ and in what trimesh returns."""
    pixels = np.asarray(picture.convert("RGB"), float)
    size = np.array([pixels.shape[1], pixels.shape[0]])
    at = np.floor((places % 1.0) * [1, 1] * size).astype(int)
    column, row = at[:, 0].clip(0, size[0] - 1), (size[1] - 1 - at[:, 1]).clip(0, size[1] - 1)
    return pixels[row, column]
