"""The polygons of OBJ files as triangles inside their outlines, cut one by one at corners that are ears."""

import numpy as np

#: Of the largest side.
FLAT = 1e-3


class NotPlane(Exception):
    """A polygon that is not flat, and whose fan lies partly outside it: no format defines its surface."""


def concave_triangles(path):
    """Corners (n, 3, 3) of all faces of a file with polygons that their fans leave; None where fans are right. Raises
    NotPlane."""
    points, faces = [], []
    for line in path.read_text(errors="replace").replace("\\\n", " ").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"] and len(words) > 3:
            numbers = [int(word.split("/")[0]) for word in words[1:]]
            faces.append([n - 1 if n > 0 else len(points) + n for n in numbers])
    points = np.array(points)
    leaving = {i for i, face in enumerate(faces) if len(face) > 3 and leaves_outline(points[face])}
    if not leaving:
        return None
    fans = [
        (f[0], f[k], f[k + 1]) for i, f in enumerate(faces) if i not in leaving for k in range(1, len(f) - 1)
    ]
    return points[np.array(fans + [one for i in sorted(leaving) for one in cut(points, faces[i])])]


def normal_of(outline):
    """Its length is twice the area."""
    return np.cross(outline - outline[0], np.roll(outline, -1, axis=0) - outline[0]).sum(0)


def leaves_outline(outline):
    """Whether a triangle of the fan around the first corner is turned round, by more than rounding."""
    normal = normal_of(outline)
    parts = np.cross(outline[1:-1] - outline[0], outline[2:] - outline[0]) @ normal
    return parts.min() < -1e-9 * (normal @ normal)


def turns(outline):
    """Of each corner the area that it spans with its neighbours, on the side of the whole: below zero where it is concave."""
    before, after = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
    whole = normal_of(outline)
    length = np.linalg.norm(whole)
    if length == 0:
        return np.zeros(len(outline))
    spanned = np.cross(outline - before, after - outline) @ (whole / length)
    return np.where(np.abs(spanned) < 1e-9 * length, 0, spanned)


def cut(points, face):
    face, outline = list(face), points[face]
    normal = normal_of(outline)
    height = (outline - outline.mean(0)) @ (normal / np.linalg.norm(normal))
    if np.ptp(height) > FLAT * np.ptp(outline, axis=0).max():
        raise NotPlane
    while len(face) > 3:
        outline = points[face]
        spans = turns(outline)
        ear = next(
            (i for i in range(len(face)) if spans[i] > 0 and is_empty(outline, i)), int(spans.argmax())
        )
        yield [face[ear - 1], face[ear], face[(ear + 1) % len(face)]]
        del face[ear]
    yield face


def is_empty(outline, i):
    """Whether no other corner is inside the triangle of a corner and its neighbours."""
    count = len(outline)
    three = [(i - 1) % count, i, (i + 1) % count]
    triangle = outline[three]
    others = np.delete(outline, three, axis=0)
    normal = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    sides = [np.cross(triangle[(j + 1) % 3] - triangle[j], others - triangle[j]) @ normal for j in range(3)]
    is_corner = (others[:, None] == triangle).all(2).any(1)
    return not ((np.min(sides, axis=0) >= 0) & ~is_corner).any()
