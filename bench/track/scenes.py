"""Made-up bodies whose surfaces join and part, as meshes that share nothing from frame to frame.

Each is the zero level of a signed distance on a grid. The grid is moved a little in every frame, so that no vertex stays where it was.
"""

import itertools

import numpy as np

CELL = 0.012  # metres

# The six tetrahedra of a cube, each from corner 0 to corner 7 by one axis after the other.
TETRAHEDRA = [
    [0, 1 << axes[0], (1 << axes[0]) | (1 << axes[1]), 7] for axes in itertools.permutations(range(3))
]


def zero_level(distance, low, high, cell=CELL):
    """Vertices and triangles, outwards, of where distance(points) is 0 between two corners of a box: marching tetrahedra."""
    axes = [np.arange(a, b + cell, cell) for a, b in zip(low, high)]
    shape = [len(axis) for axis in axes]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    values = distance(points)
    number = np.arange(len(points)).reshape(shape)
    corners = np.stack(
        [
            number[tuple(slice(c >> k & 1, n - 1 + (c >> k & 1)) for k, n in enumerate(shape))].ravel()
            for c in range(8)
        ],
        1,
    )
    inside = values < 0
    mixed = corners[(inside[corners].any(1)) & ~(inside[corners].all(1))]
    tetrahedra = mixed[:, np.array(TETRAHEDRA)].reshape(-1, 4)
    # Corners inside come first; how many there are decides what is between.
    tetrahedra = np.take_along_axis(tetrahedra, np.argsort(~inside[tetrahedra], 1, kind="stable"), 1)
    count = inside[tetrahedra].sum(1)
    edges = []  # (triangles, 3, 2): each corner of a triangle is on an edge of the grid
    for inner, triangles in (
        (1, [[(0, 1), (0, 2), (0, 3)]]),
        (2, [[(0, 2), (0, 3), (1, 2)], [(1, 2), (0, 3), (1, 3)]]),
        (3, [[(0, 3), (1, 3), (2, 3)]]),
    ):
        edges += [tetrahedra[count == inner][:, np.array(triangle)] for triangle in triangles]
    edges = np.concatenate(edges)  # the first end of each is inside
    outward = points[edges[..., 1]].mean(1) - points[edges[..., 0]].mean(1)
    ends, corner = np.unique(edges.reshape(-1, 2), axis=0, return_inverse=True)
    faces = corner.reshape(-1, 3)
    a, b = values[ends[:, 0]], values[ends[:, 1]]
    share = np.clip(a / (a - b), 0.02, 0.98)[:, None]
    vertices = points[ends[:, 0]] * (1 - share) + points[ends[:, 1]] * share
    normals = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    turned = (normals * outward).sum(1) < 0
    faces[turned] = faces[turned][:, ::-1]
    return vertices, faces


def capsule(points, a, b, radius):
    a, along = np.array(a), np.subtract(b, a)
    share = np.clip((points - a) @ along / (along @ along), 0, 1)
    return np.linalg.norm(points - a - share[:, None] * along, axis=1) - radius


def touching_hands(share):
    """A body whose two arms come together before it, touch in the middle third of the time, and part. share: 0 to 1."""
    gap = 0.12 * abs(2 * share - 1) - 0.04

    def distance(points):
        parts = [capsule(points, (0, 0.2, 0), (0, 0.7, 0), 0.15)]
        for side in -1, 1:
            hand = side * (0.045 + gap / 2), 0.55, 0.38
            elbow = side * 0.3, 0.45, 0.15
            parts += [
                capsule(points, (side * 0.16, 0.7, 0), elbow, 0.05),
                capsule(points, elbow, hand, 0.045),
            ]
        return np.min(parts, 0)

    return distance, (-0.42, 0, -0.2), (0.42, 0.9, 0.5)


def opened_jacket(share):
    """A body in a jacket whose front opens from a slit to a third of the way around, and stands off more and more. share: 0 to 1.

    As reconstructions have it, there is no space between jacket and body.
    """

    def distance(points):
        body = capsule(points, (0, 0.15, 0), (0, 0.7, 0), 0.14)
        low = np.clip((0.75 - points[:, 1]) / 0.6, 0, 1)  # the hem moves, the shoulders stay
        front = np.abs(np.arctan2(points[:, 0], points[:, 2]))
        radius = np.hypot(points[:, 0], points[:, 2])
        lift = 0.05 * share * low * np.exp(-((front / 1.2) ** 2))
        opening = (0.05 + 0.9 * share) * low
        jacket = np.maximum.reduce(
            [radius - 0.165 - lift, (opening - front) * radius, np.abs(points[:, 1] - 0.42) - 0.3]
        )
        return np.minimum(body, jacket)

    return distance, (-0.3, -0.05, -0.3), (0.3, 0.9, 0.3)


def sequence(scene, frames):
    """Vertices and faces of each frame."""
    meshes = []
    for i in range(frames):
        distance, low, high = scene(i / (frames - 1))
        moved = np.random.default_rng(i).uniform(0, CELL, 3)
        meshes.append(zero_level(distance, np.array(low) - moved, np.array(high)))
    return meshes
