"""An estimate of what a basis of trajectories costs: principal components of a sequence of meshes with the same faces.

Positions of all frames of a group are their mean plus a few components, each with a factor for every frame (Alexa and Mueller
2000). What is estimated: the faces and the mean as a Draco mesh on the lattice of the quantiser; the components, quantised and
predicted along a spanning tree of the mesh, by the entropy of what is left; the factors, in 16 bits each. No such codec is
run, and none would reach the entropy with fewer bytes; better predictions could.
"""

import DracoPy
import numpy as np

FACTOR_BITS = 16


def parents(faces, count):
    """For each vertex one that the tree reaches earlier, or itself; and the vertices in the order of the tree."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = np.concatenate([edges, edges[:, ::-1]])
    edges = edges[np.argsort(edges[:, 0], kind="stable")]
    begin = np.searchsorted(edges[:, 0], np.arange(count + 1))
    parent = np.full(count, -1)
    for root in range(count):
        if parent[root] >= 0:
            continue
        parent[root] = root
        front = [root]
        while front:
            following = []
            for vertex in front:
                for neighbour in edges[begin[vertex] : begin[vertex + 1], 1]:
                    if parent[neighbour] < 0:
                        parent[neighbour] = vertex
                        following.append(neighbour)
            front = following
    return parent


def entropy_bytes(values):
    """Of integers, each coded by how often it occurs among all of them."""
    _, counts = np.unique(values, return_counts=True)
    share = counts / counts.sum()
    return float(-(counts * np.log2(share)).sum() / 8)


def fixed_bytes(mean, faces, step):
    """The mean mesh by Draco: as many bits as its box needs for steps of this size."""
    extent = np.ptp(mean, axis=0).max()
    bits = max(1, int(np.ceil(np.log2(extent / step + 1))))
    return len(
        DracoPy.encode(mean.astype(np.float32), faces.astype(np.uint32), quantization_bits=bits, compression_level=10)
    )  # fmt: skip


class Group:
    """Frames x vertices x 3 positions in metres."""

    def __init__(self, positions, faces):
        self.shape, self.faces = positions.shape, faces
        self.mean = positions.mean(0)
        flat = (positions - self.mean).reshape(len(positions), -1)
        # Of the small side: frames.
        values, vectors = np.linalg.eigh(flat @ flat.T)
        order = np.argsort(values)[::-1]
        self.factors = vectors[:, order]
        self.components = self.factors.T @ flat
        self.flat = flat
        self.parent = parents(faces, positions.shape[1])

    def coded(self, count, step):
        """Bytes of the group and the decoded positions, with this number of components and about this error of each."""
        frames = self.shape[0]
        decoded = np.zeros_like(self.flat)
        size = fixed_bytes(self.mean, self.faces, step) + count * frames * FACTOR_BITS / 8
        scale = step * np.sqrt(frames / max(count, 1))
        for component, factor in zip(self.components[:count], self.factors[:, :count].T):
            quantised = np.round(component / scale).astype(np.int64).reshape(-1, 3)
            left = quantised - quantised[self.parent]
            roots = self.parent == np.arange(len(quantised))
            left[roots] = quantised[roots]
            size += sum(entropy_bytes(left[:, axis]) for axis in range(3))
            coarse = np.round(factor * 2 ** (FACTOR_BITS - 1)) / 2 ** (FACTOR_BITS - 1)
            decoded += np.outer(coarse, quantised.ravel() * scale)
        lattice = np.round(self.mean / step) * step
        return size, decoded.reshape(self.shape) + lattice

    def off(self, decoded):
        """The rms of how far vertices are off."""
        return np.sqrt(((decoded - self.flat.reshape(self.shape) - self.mean) ** 2).sum(-1).mean())

    def best(self, rms):
        """The fewest bytes whose vertices are off by at most this rms, in metres: bytes, positions, components."""
        best = None
        for step in rms * np.array([0.5, 1, 1.5, 2, 2.5, 3]):
            low, high = 0, self.shape[0]  # more components err less and take more bytes
            while high - low > 1:
                middle = (low + high) // 2
                low, high = (low, middle) if self.off(self.coded(middle, step)[1]) <= rms else (middle, high)
            size, decoded = self.coded(high, step)
            if self.off(decoded) <= rms and (best is None or size < best[0]):
                best = size, decoded, high
        return best
