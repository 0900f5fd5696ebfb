"""What the stability sheets do to captures and streams: cameras turned, masks grown, meshes shaken, chunks dropped."""

import math
import struct

import numpy as np
from PIL import ImageFilter

FILE_HEADER, CHUNK_HEADER = 24, 32
GROUP_TYPES = b"GRUP", b"MESH", b"CALB", b"VISI", b"COLR", b"VPKT", b"AUDI", b"BACK", b"GEND"


def rotation_by(axis, angle):
    """The matrix that turns by an angle about an axis (Rodrigues)."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * across + (1 - math.cos(angle)) * across @ across


def turned(camera, pixels, direction):
    """Rotation and translation of a camera of capture.json that is turned in its place, so that the middle of its picture
    moves by a number of pixels; direction: an angle in the picture."""
    turn = rotation_by(
        (-math.sin(direction), math.cos(direction), 0), math.atan(pixels / camera["intrinsics"]["fx"])
    )
    rotation = turn @ np.reshape(camera["rotation"], (3, 3))
    return rotation.tolist(), (turn @ camera["translation"]).tolist()


def centre_of(camera):
    return -np.reshape(camera["rotation"], (3, 3)).T @ camera["translation"]


def degrees_between(a, b):
    return math.degrees(math.acos(np.clip(np.dot(a, b) / np.linalg.norm(a) / np.linalg.norm(b), -1, 1)))


def grown(mask, pixels):
    """A mask whose outline moves outwards (below 0: inwards) by whole pixels, in squares."""
    if not pixels:
        return mask
    size = 2 * abs(pixels) + 1
    return mask.filter(ImageFilter.MaxFilter(size) if pixels > 0 else ImageFilter.MinFilter(size))


def chunks(stream):
    """Yields (type, begin, end) of each chunk of an intact stream, padding included."""
    at = FILE_HEADER
    while at < len(stream):
        kind, size = stream[at : at + 4], struct.unpack_from("<Q", stream, at + 16)[0]
        end = at + CHUNK_HEADER + -(-size // 8) * 8
        yield kind, at, end
        at = end


def with_losses(stream, share, random):
    """A stream without a random share of the chunks of its groups, and their number. Configuration and index stay."""
    parts, lost = [stream[:FILE_HEADER]], 0
    for kind, begin, end in chunks(stream):
        if kind in GROUP_TYPES and random.random() < share:
            lost += 1
        else:
            parts.append(stream[begin:end])
    return b"".join(parts), lost


def plate(side, thickness, cells):
    """Vertices and faces of a closed plate around the origin: two grids and a rim."""
    at = np.linspace(-side / 2, side / 2, cells + 1)
    x, y = (grid.ravel() for grid in np.meshgrid(at, at, indexing="ij"))
    top = np.column_stack([x, y, np.full(x.size, thickness / 2)])
    vertices = np.vstack([top, top * (1, 1, -1)])
    first = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    a, b, c, d = first, first + cells + 1, first + cells + 2, first + 1
    upper = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    faces = [upper, upper[:, ::-1] + len(top)]
    line = np.arange(cells + 1)
    rim = np.concatenate(
        [
            line * (cells + 1),
            cells * (cells + 1) + line[1:],
            (line * (cells + 1) + cells)[::-1][1:],
            line[::-1][1:],
        ]
    )
    # Around the outline, counter-clockwise seen from above.
    before, after = rim[:-1], rim[1:]
    faces += [
        np.column_stack([before, before + len(top), after + len(top)]),
        np.column_stack([before, after + len(top), after]),
    ]
    return vertices, np.vstack(faces).astype(np.uint32)


def pieces(faces, count):
    """The number of connected pieces of a mesh of count vertices, of those that faces use."""
    label = np.arange(count)
    while True:
        least = label[faces].min(axis=1)
        new = label.copy()
        for corner in range(3):
            np.minimum.at(new, faces[:, corner], least)
        new = new[new]
        if np.array_equal(new, label):
            return len(np.unique(label[np.unique(faces)]))
        label = new
