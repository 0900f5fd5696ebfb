"""Computed and transmitted normals: clauses 8.12 and 8.13 of spec/fvv.md.

Python's floats are binary64, and it never fuses multiply and add.
"""

import math
import struct

from . import mesh_delta
from .container import crc32c, payloads
from .mesh import read_raw


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def computed(positions, faces, joined=True):
    """Clause 8.12. joined: vertices on one point share their faces."""
    keys = [tuple(p) if joined else v for v, p in enumerate(positions)]
    sums = {key: [0.0, 0.0, 0.0] for key in keys}
    for face in faces:
        a, b, c = (positions[v] for v in face)
        area = cross([q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)])
        for v in face:
            for k in range(3):
                sums[keys[v]][k] += float(area[k])
    normals = []
    for key in keys:
        length = math.sqrt(dot(sums[key], sums[key]))
        normals.append([x / length if length else 0.0 for x in sums[key]])
    return normals


def sign(x):
    return -1 if x < 0 else 1


def unfold(half, a, b):
    """A point of the square -> its integers x, y, z (clause 8.13)."""
    z = half - abs(a) - abs(b)
    return [a, b, z] if z >= 0 else [(half - abs(b)) * sign(a), (half - abs(a)) * sign(b), z]


def sent(bits, pair):
    """The normal of a pair of indices."""
    half = 2 ** (bits - 1) - 1
    vector = unfold(half, pair[0] - half, pair[1] - half)
    length = math.sqrt(dot(vector, vector))
    return [x / length for x in vector]


def nearest(bits, vector):
    """The nearest indices of a vector."""
    half = 2 ** (bits - 1) - 1
    total = abs(vector[0]) + abs(vector[1]) + abs(vector[2])
    x, y = vector[0] / total * half, vector[1] / total * half
    if vector[2] < 0:
        x, y = (half - abs(y)) * sign(x), (half - abs(x)) * sign(y)
    best = None
    for j in (0, 1):
        for i in (0, 1):
            a, b = math.floor(x) + i, math.floor(y) + j
            if abs(a) > half or abs(b) > half:
                continue
            integers = unfold(half, a, b)
            cosine = dot(integers, vector) / math.sqrt(dot(integers, integers))
            if best is None or cosine > best[0]:
                best = cosine, a, b
    _, a, b = best
    a, b = (abs(a) if abs(b) == half else a), (abs(b) if abs(a) == half else b)
    return a + half, b + half


def turned(bits, pair, p, q):
    """The indices of a key mesh's vertex in a delta frame. p, q: normals of its own faces in the key mesh and there."""
    if p == [0, 0, 0] or q == [0, 0, 0]:
        return pair
    n, c, v = sent(bits, pair), dot(p, q), cross(p, q)
    if 1 + c < 2**-20:
        return nearest(bits, [-x for x in n])
    t, w = dot(v, n) / (1 + c), cross(v, n)
    return nearest(bits, [c * n[k] + w[k] + t * v[k] for k in range(3)])


def frames(stream):
    """Yields the normals of each mesh frame of a stream of one mesh track."""
    for payload, positions in zip(payloads(stream, b"MESH"), mesh_delta.decode(stream)):
        if payload[0] == 0:
            key = read_raw(payload)
            before = computed(positions, key.faces, joined=False)
        if not key.normals:
            yield computed(positions, key.faces)
        elif payload[0] == 0:
            yield [sent(key.normal_bits, pair) for pair in key.normals]
        else:
            after = computed(positions, key.faces, joined=False)
            now = [turned(key.normal_bits, *three) for three in zip(key.normals, before, after)]
            yield [sent(key.normal_bits, pair) for pair in now]


def listing(stream):
    """CRC-32C of the normals of each frame as f32, x y z for each vertex."""
    for normals in frames(stream):
        yield f"{crc32c(b''.join(struct.pack('<3f', *n) for n in normals)):08x}"
