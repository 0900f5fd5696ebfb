"""Visibility weights: clause 17 of spec/fvv.md, for raw and delta meshes and cameras that move.

A state is 0 where a vertex is backfacing; odd where it is hidden and even where it is seen, up to 6.
"""

import struct
from collections import defaultdict

from . import calibration
from .container import FLAGS, Numbers, chunks, crc32c, demand
from .mesh import read_raw
from .mesh_delta import AXES, Sequence, divide
from .range_coder import RangeDecoder

LEAST = (0, 1, 2, 3, 4, 7, 10)


def centre(rotation, t, lattice):
    """Where a camera is, in steps of the lattice."""
    origin, step = lattice[:3], lattice[3]
    metres = [-((rotation[a] * t[0] + rotation[3 + a] * t[1]) + rotation[6 + a] * t[2]) for a in AXES]
    # Python rounds ties to even.
    return [round((c - o) / step) for c, o in zip(metres, origin)]


def dot(u, v):
    return sum(a * b for a, b in zip(u, v))


def shortened(v):
    s = 0
    while max(map(abs, v)) >= 1 << 11 + s:
        s += 1
    return [divide(x, 1 << s) for x in v]


def face_faces(corners, camera, threshold):
    p, q, r = corners
    u, v = ([x[a] - p[a] for a in AXES] for x in (q, r))
    n = shortened([u[a - 2] * v[a - 1] - u[a - 1] * v[a - 2] for a in AXES])
    w = shortened([3 * camera[a] - p[a] - q[a] - r[a] for a in AXES])
    return dot(n, w) > 0 and 2**16 * dot(n, w) ** 2 > threshold**2 * dot(n, n) * dot(w, w)


class Surface:
    """The vertices of a mesh: the faces that use them, and their coding order."""

    def __init__(self, vertex_count, faces):
        self.faces = faces
        self.around = [[] for _ in range(vertex_count)]
        for number, corners in enumerate(faces):
            for corner in corners:
                self.around[corner].append(number)
        self.count = vertex_count
        self.order, met = [], set()
        for seed in range(self.count):
            row = [seed] if seed not in met else []
            met.add(seed)
            for vertex in row:
                for other in self.corners(vertex):
                    if other not in met:
                        met.add(other)
                        row.append(other)
            self.order += row

    def corners(self, vertex):
        """The corners of the faces that use a vertex, its own among them."""
        return [corner for face in self.around[vertex] for corner in self.faces[face]]

    def facing(self, positions, camera, threshold):
        passed = [face_faces([positions[v] for v in f], camera, threshold) for f in self.faces]
        return [any(passed[f] for f in faces) for faces in self.around]


def class_of(total):
    return max(i for i, least in enumerate(LEAST) if total >= least)


class Contexts(dict):
    def __missing__(self, key):
        former, seen, hidden, _ = key
        a = 8 * LEAST[seen] + 1 + (32 if former == 2 else 0)
        b = 8 * LEAST[hidden] + 1 + (32 if former == 1 else 0)
        self[key] = [2**16 * a // (a + b)] * 2
        return self[key]


class LevelContexts(dict):
    def __missing__(self, key):
        self[key] = [3 * 2**14] * 2
        return self[key]


def side(state):
    """The side of a half on which a state is: 0 backfacing, 1 hidden, 2 seen."""
    return 2 - state % 2 if state else 0


def decode_levels(decoder, surface, sides, former):
    """States of visibility weights: their distance from a half, where a neighbour is on the other side."""
    states, contexts = list(sides), LevelContexts()
    for vertex in surface.order:
        others = class_of(sum(sides[c] == 3 - sides[vertex] for c in surface.corners(vertex)))
        if not sides[vertex] or not others:
            continue
        before = (former[vertex] + 1) // 2 if side(former[vertex]) == sides[vertex] else 0
        for level in 1, 2:
            if decoder.decision(contexts[before, others, level]):
                break
            states[vertex] += 2
    return states


def decode_stream(decoder, surface, facing, former):
    """The state of each vertex for one camera. decoder None: a stream of no bytes."""
    if not decoder:
        return [int(f) for f in facing]
    states, contexts = [0] * surface.count, Contexts()
    counts = [defaultdict(int), defaultdict(int)]
    for vertex in surface.order:
        if not facing[vertex]:
            continue
        faces = surface.around[vertex]
        hidden, seen = (class_of(sum(count[face] for face in faces)) for count in counts)
        rim = not all(facing[c] for c in surface.corners(vertex))
        bit = decoder.decision(contexts[side(former[vertex]), seen, hidden, rim])
        for face in faces:
            counts[bit][face] += 1
        states[vertex] = 1 + bit
    states = decode_levels(decoder, surface, states, former)
    demand(decoder.ends(), 6007, "end of a stream")
    return states


def decode_chunk(payload, positions, faces, cameras, before):
    """States of each camera of a VISI payload. cameras: centres by identifier; before: states by identifier."""
    reserved, threshold, _, count, number, camera_count = struct.unpack_from("<BBHIII", payload)
    assert reserved == 0
    numbers = Numbers(payload, 16, 6004)
    table, camera = [], 0
    for _ in range(camera_count):
        camera += numbers.next()
        table.append((camera, numbers.next()))
    surface = Surface(len(positions), faces)
    assert surface.count == count
    at, states = numbers.at, {}
    for camera, size in table:
        facing = surface.facing(positions, cameras[camera], threshold)
        former = before.get(camera, [0] * count) if number else [0] * count
        decoder = RangeDecoder(payload[at : at + size]) if size else None
        states[camera] = decode_stream(decoder, surface, facing, former)
        at += size
    assert at == len(payload)
    return states


def decode(stream):
    """Yields the track and the states by camera of each VISI chunk of a stream with one configuration block and one group."""
    cameras, moving, before, sequence = {}, {}, {}, None
    for chunk in chunks(stream):
        kind, payload = chunk.kind, chunk.payload
        if kind == b"SCEN":
            lattice = struct.unpack_from("<4d", payload, 16)
        elif kind == b"CAMR":
            identifier, lens, flags = struct.unpack_from("<HBB", payload)
            if flags & calibration.MOVES:
                moving[identifier] = lens
            else:
                rotation, t = struct.unpack_from("<9d", payload, 128), struct.unpack_from("<3d", payload, 200)
                cameras[identifier] = centre(rotation, t, lattice)
        elif kind == b"GRUP":
            followed = calibration.Track(moving)
        elif kind == b"CALB":
            for identifier in moving:
                cameras.pop(identifier, None)
            for identifier, c in followed.add(payload, bool(chunk.flags & FLAGS["key"])).items():
                cameras[identifier] = centre(c["rotation"], c["translation"], lattice)
        elif kind == b"MESH" and payload[0] == 2:
            sequence.add(payload)
        elif kind == b"MESH":
            key = read_raw(payload)
            sequence = Sequence(key)
        elif kind == b"VISI":
            former = before.get(chunk.track, {})
            before[chunk.track] = decode_chunk(payload, sequence.positions(), key.faces, cameras, former)
            yield chunk.track, before[chunk.track]


def listing(stream):
    """For each VISI chunk the CRC-32C of its states, a byte for each camera and vertex."""
    for _, states in decode(stream):
        yield f"{crc32c(bytes(x for camera in sorted(states) for x in states[camera])):08x}"
