"""Distances between surfaces whose faces differ, by points that are dense on both."""

import numpy as np
from scipy.spatial import cKDTree

FAR = 0.03  # metres; a place that is further off has no counterpart


def dense(vertices, faces, rounds=2):
    """Points of a surface and their normals: its vertices after midpoint subdivisions."""
    for _ in range(rounds):
        edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), 1)
        edges, number = np.unique(edges, axis=0, return_inverse=True)
        middle = number.reshape(3, -1).T + len(vertices)
        vertices = np.concatenate([vertices, vertices[edges].mean(1)])
        a, b, c = faces.T
        ab, bc, ca = middle.T
        corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = np.concatenate([np.stack(three, 1) for three in corners])
    across = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, faces[:, k], across)
    return vertices, normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)


def to_plane(points, onto):
    """The signed distance of points from the planes of the nearest points of a dense surface."""
    where, normals = onto
    nearest = cKDTree(where).query(points)[1]
    return ((points - where[nearest]) * normals[nearest]).sum(1)


def d2(source, decoded):
    """Point to plane as MPEG's pc_error has it: 10 log10(3 p^2 / mean square), p the largest side, of the worse direction."""
    a, b = dense(*source), dense(*decoded)
    worst = max((to_plane(x[0], y) ** 2).mean() for x, y in ((a, b), (b, a)))
    return 10 * np.log10(3 * np.ptp(source[0], axis=0).max() ** 2 / worst)


class Flicker:
    """How much a surface moves against the true one: rms of the change, from frame to frame, of the distance of the same true places."""

    def __init__(self):
        self.before, self.changes = None, []

    def add(self, truth, decoded):
        """truth: the same places in each frame."""
        distance = to_plane(truth, dense(*decoded))
        if self.before is not None:
            near = (np.abs(distance) < FAR) & (np.abs(self.before) < FAR)
            self.changes.append((distance - self.before)[near])
        self.before = distance

    def rms(self):
        return float(np.sqrt((np.concatenate(self.changes) ** 2).mean()))
