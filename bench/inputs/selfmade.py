"""Mesh files as writers of each format make them, with what they hold by construction: no reader is asked."""

import base64
import json
import struct

import numpy as np


def ball(rings=6, parts=9):
    """(points, triangles, colours 0 to 255) of a ball that is longer than wide."""
    angles = np.linspace(0.3, np.pi - 0.3, rings)
    turns = np.arange(parts) * 2 * np.pi / parts
    points = [[np.sin(a) * np.cos(t), np.sin(a) * np.sin(t), 1.3 * np.cos(a)] for a in angles for t in turns]
    faces = []
    for i in range(rings - 1):
        for k in range(parts):
            a, b = i * parts + k, i * parts + (k + 1) % parts
            faces += [(a, a + parts, b), (b, a + parts, b + parts)]
    points = np.array(points)
    colours = np.round(127.5 + 100 * points / np.abs(points).max())
    return points, np.array(faces), colours


def numbers(row):
    return " ".join(f"{one:.12g}" for one in row)


def obj(points, faces, form="{0}", extra=None, end="\n", head=""):
    lines = [head] if head else []
    rows = points if extra is None else np.hstack([points, extra])
    lines += [f"v {numbers(row)}" for row in rows]
    lines += ["f " + " ".join(form.format(c + 1, c - len(points)) for c in face) for face in faces]
    return (end.join(lines) + end).encode()


def ply(points, faces, form, colours=None, name="vertex_indices"):
    own = "" if colours is None else "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    head = (
        f"ply\nformat {form} 1.0\ncomment ours\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
        f"property float z\n{own}element face {len(faces)}\nproperty list uchar int {name}\nend_header\n"
    )
    if form == "ascii":
        rows = points if colours is None else np.hstack([points, colours])
        lines = [numbers(row) for row in rows] + [f"{len(f)} {' '.join(map(str, f))}" for f in faces]
        return head.encode() + ("\n".join(lines) + "\n").encode()
    order = "<" if "little" in form else ">"
    body = b""
    for i, point in enumerate(points):
        body += struct.pack(f"{order}3f", *point)
        if colours is not None:
            body += bytes(int(c) for c in colours[i])
    for face in faces:
        body += struct.pack(f"{order}B{len(face)}i", len(face), *face)
    return head.encode() + body


def gltf(points, faces, nodes, mode=4, indexed=True, component=5125, binary=True, colours=None):
    """A file with one mesh, which the nodes show."""
    types = {5121: "<u1", 5123: "<u2", 5125: "<u4"}
    flat = np.asarray(faces).reshape(-1)
    place = points.astype("<f4") if indexed else points[flat].astype("<f4")
    parts = [place.tobytes()]
    bounds = {"min": place.min(0).tolist(), "max": place.max(0).tolist()}
    accessors = [{"bufferView": 0, "componentType": 5126, "count": len(place), "type": "VEC3", **bounds}]
    primitive = {"attributes": {"POSITION": 0}, "mode": mode}
    if colours is not None:
        primitive["attributes"]["COLOR_0"] = len(accessors)
        # glTF's colours are of light, those of pictures are of sRGB.
        linear = np.where(colours <= 10.31, colours / 255 / 12.92, ((colours / 255 + 0.055) / 1.055) ** 2.4)
        accessors.append(
            {"bufferView": len(parts), "componentType": 5126, "count": len(place), "type": "VEC3"}
        )
        parts.append(linear.astype("<f4").tobytes())
    if indexed:
        primitive["indices"] = len(accessors)
        accessors.append(
            {"bufferView": len(parts), "componentType": component, "count": len(flat), "type": "SCALAR"}
        )
        parts.append(flat.astype(types[component]).tobytes())
    views, content = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(content), "byteLength": len(part)})
        content += part + bytes(-len(part) % 4)
    buffer = {"byteLength": len(content)}
    if not binary:
        buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(content).decode()
    whole = {"asset": {"version": "2.0"}, "buffers": [buffer], "bufferViews": views, "accessors": accessors}
    whole |= {"meshes": [{"primitives": [primitive]}], "nodes": nodes, "scene": 0}
    children = {child for node in nodes for child in node.get("children", [])}
    whole["scenes"] = [{"nodes": [i for i in range(len(nodes)) if i not in children]}]
    text = json.dumps(whole).encode()
    if not binary:
        return text
    text += b" " * (-len(text) % 4)
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A)
        + text
        + struct.pack("<II", len(content), 0x004E4942)
        + content
    )
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def strip_of(rings, parts):
    """Corners of a triangle strip around a ring of the ball, and its triangles."""
    corners = [c for k in [*range(parts), 0] for c in (k, parts + k)]
    turned = [
        (corners[i], corners[i + 1], corners[i + 2])
        if i % 2 == 0
        else (corners[i + 1], corners[i], corners[i + 2])
        for i in range(len(corners) - 2)
    ]
    return corners, np.array(turned)


def cases():
    """(name, bytes, corners of the triangles, their colours or None)."""
    points, faces, colours = ball()
    quads = [(f[0], f[1], g[2], f[2]) for f, g in zip(faces[::2], faces[1::2])]
    plain = points[faces]
    # Of a quad both cuts are right; the fan's is what programs do.
    fans = np.concatenate([points[[(q[0], q[1], q[2]), (q[0], q[2], q[3])]] for q in quads])
    mean = colours[faces].mean(1)
    yield "triangles.obj", obj(points, faces), plain, None
    yield "quads.obj", obj(points, quads), fans, None
    yield "negative.obj", obj(points, faces, "{1}"), plain, None
    yield "crlf.obj", obj(points, faces, end="\r\n", head="# ours"), plain, None
    yield "mark.obj", b"\xef\xbb\xbf" + obj(points, faces), plain, None
    yield "empty_fields.obj", obj(points, faces, "{0}//"), plain, None
    yield "colours.obj", obj(points, faces, extra=colours / 255), plain, mean
    yield "groups.obj", obj(points, faces, head="g a\no b\ns 1"), plain, None
    for form in "ascii", "binary_little_endian", "binary_big_endian":
        yield f"{form}.ply", ply(points, faces, form), plain, None
        yield f"{form}_colours.ply", ply(points, faces, form, colours), plain, mean
        yield f"{form}_quads.ply", ply(points, quads, form, name="vertex_index"), fans, None
    one = [{"mesh": 0}]
    for component in 5121, 5123, 5125:
        yield f"indices_{component}.glb", gltf(points, faces, one, component=component), plain, None
    yield "text.gltf", gltf(points, faces, one, binary=False), plain, None
    yield "no_indices.glb", gltf(points, faces, one, indexed=False), plain, None
    yield "colours.glb", gltf(points, faces, one, colours=colours), plain, mean
    corners, turned = strip_of(6, 9)
    yield "strip.glb", gltf(points, corners, one, mode=5), points[turned], None
    fan = [(0, k, k + 1) for k in range(1, 8)]
    yield "fan.glb", gltf(points, range(9), one, mode=6), points[fan], None
    moved = [{"children": [1, 2]}, {"mesh": 0, "translation": [2, 0, 0], "scale": [0.5, 1, 1]}, {"mesh": 0}]
    yield (
        "nodes.glb",
        gltf(points, faces, moved),
        np.concatenate([plain * [0.5, 1, 1] + [2, 0, 0], plain]),
        None,
    )
    # A mirror turns the faces, so that their fronts stay outside.
    mirror = [{"mesh": 0, "scale": [-1, 1, 1]}]
    yield "mirror.glb", gltf(points, faces, mirror), (plain * [-1, 1, 1])[:, ::-1], None
    # Column by column: a quarter turn about z, then one along x.
    matrix = [{"mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]}]
    yield (
        "matrix.glb",
        gltf(points, faces, matrix),
        plain @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]) + [3, 0, 0],
        None,
    )
    # As surveyors have it: millimetres that float32 does not hold.
    far = np.round(points, 3) + [500_000.0, 5_400_000.0, 120.0]
    yield "surveyed.obj", obj(far, faces), far[faces], None


def write(folder):
    """(path, (corners, colours)) of all."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content, corners, colours in cases():
        path = folder / name
        path.write_bytes(content)
        yield path, (corners, np.full((len(corners), 3), np.nan) if colours is None else colours)
