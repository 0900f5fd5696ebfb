"""Meshes of all profiles, with the rules of clause 8 of spec/fvv.md. Arrays are numpy's."""

import struct

import numpy

from .. import mesh_delta, mesh_fast, mesh_patched, normals
from ..container import demand
from . import draco

RAW, DRACO, DELTA, FAST, PATCHED = 0, 1, 2, 4, 5
INDEPENDENT = RAW, DRACO, FAST
TEXTURE, NORMALS = 1, 2
VERTICES, FACES = 4_194_304, 8_388_608
LATTICE_MAX = 1 << 28


class Header:
    """The header of a MESH payload; the rules that need nothing else."""

    def __init__(self, payload):
        demand(len(payload) >= 16, 3001, "size")
        (
            self.profile,
            self.attributes,
            self.texture_bits,
            self.normal_bits,
            self.vertices,
            self.faces,
            rest,
        ) = struct.unpack_from("<4B3I", payload)
        demand(rest == 0, 3001, "reserved field")
        demand(self.profile in (*INDEPENDENT, DELTA, PATCHED), 3002, f"profile {self.profile}")
        demand(self.attributes < 4, 3002, f"attributes {self.attributes}")
        bits, there = self.texture_bits, self.attributes & TEXTURE
        demand(1 <= bits <= 16 if there else bits == 0, 3014, f"{bits} texture bits")
        bits, there = self.normal_bits, self.attributes & NORMALS
        demand(2 <= bits <= 12 if there else bits == 0, 3030, f"{bits} normal bits")
        demand(self.vertices >= 3 and self.faces >= 1, 3003, f"{self.vertices} vertices, {self.faces} faces")
        demand(self.vertices <= VERTICES and self.faces <= FACES, 7001, "too large a mesh")

    def kind(self):
        return self.attributes, self.texture_bits, self.normal_bits

    def counts(self):
        return self.vertices, self.faces


class Mesh:
    """positions, faces: rows of three; texture, normals: rows of two indices, or None."""

    def __init__(self, header, positions, faces, texture=None, normals=None):
        self.header, self.texture_bits, self.normal_bits = header, header.texture_bits, header.normal_bits
        self.positions, self.faces = positions, faces
        self.texture = texture if header.attributes & TEXTURE else None
        self.normals = normals if header.attributes & NORMALS else None

    def check(self):
        """The rules for every decoded mesh that is independent of others."""
        demand(int(abs(self.positions).max()) <= LATTICE_MAX, 3006, "a position outside the lattice")
        if self.texture is not None:
            inside = (self.texture >= 0).all() and (self.texture <= 1 << self.texture_bits).all()
            demand(bool(inside), 3015, "a texture index")
        if self.normals is not None:
            inside = (self.normals >= 0).all() and (self.normals <= (1 << self.normal_bits) - 2).all()
            demand(bool(inside), 3031, "a normal index")
        faces, count = self.faces, len(self.positions)
        demand(int(faces.max()) < count, 3005, "an index beyond the vertices")
        a, b, c = faces.T
        demand(not ((a == b) | (b == c) | (a == c)).any(), 3005, "a face with the same vertex twice")
        demand(bool(numpy.bincount(faces.ravel(), minlength=count).all()), 3011, "a vertex without a face")

    def metres(self, origin, step):
        """Clause 8.2: binary64, each operation rounded, then binary32."""
        with numpy.errstate(over="ignore"):  # beyond binary32: infinite
            return (numpy.array(origin) + step * self.positions.astype(numpy.float64)).astype("<f4")

    def coordinates(self):
        return (self.texture * 2.0**-self.texture_bits).astype("<f4")

    def directions(self):
        """Clause 8.13: the normals that are sent."""
        known = {}
        for pair in map(tuple, self.normals.tolist()):
            if pair not in known:
                known[pair] = normals.sent(self.normal_bits, pair)
        return numpy.array([known[pair] for pair in map(tuple, self.normals.tolist())]).astype("<f4")


def table(payload, at, count, width, kind):
    return numpy.frombuffer(payload, kind, count * width, at).reshape(count, width).astype(numpy.int64)


def check_size(header, payload):
    """The rules about the size of a payload, which need no decoding."""
    if header.profile == RAW:
        pairs = bin(header.attributes).count("1")
        size = 16 + (12 + 8 * pairs) * header.vertices + 12 * header.faces
        demand(len(payload) == size, 3004, f"{len(payload)} bytes, expected {size}")
    elif header.profile == DRACO:
        draco.check_density(payload[16:], header)
    elif header.profile == FAST:
        mesh_fast.split(payload)
    elif header.profile == PATCHED:
        parts, patch = parts_of(header, payload)
        if patch:
            check_size(patch, parts.patch)


def raw(header, payload):
    at, pairs = 16 + 12 * header.vertices, [None, None]
    for i, attribute in enumerate((TEXTURE, NORMALS)):
        if header.attributes & attribute:
            pairs[i] = table(payload, at, header.vertices, 2, "<u4")
            at += 8 * header.vertices
    positions = table(payload, 16, header.vertices, 3, "<i4")
    return Mesh(header, positions, table(payload, at, header.faces, 3, "<u4"), *pairs)


def fast(header, payload):
    vertices, faces = mesh_fast.streams(payload)
    rows = b"".join(vertices.elements)
    width = len(rows) // 4 // header.vertices
    elements = numpy.frombuffer(rows, "<u4").reshape(header.vertices, width)
    positions = elements[:, :3].astype("<u4").view("<i4").astype(numpy.int64)
    pairs, at = [None, None], 3
    for i, attribute in enumerate((TEXTURE, NORMALS)):
        if header.attributes & attribute:
            pairs[i], at = elements[:, at : at + 2].astype(numpy.int64), at + 2
    return Mesh(header, positions, numpy.array(faces.faces, numpy.int64), *pairs)


def coded(header, payload):
    values, corners = draco.decode(payload[16:], header)
    values = [numpy.array(rows, numpy.int64) for rows in values]
    faces = numpy.array(corners, numpy.int64).reshape(-1, 3)
    pairs, rest = [None, None], values[1:]
    for i, attribute in enumerate((TEXTURE, NORMALS)):
        if header.attributes & attribute:
            pairs[i] = rest.pop(0)
    return Mesh(header, values[0], faces, *pairs)


def independent(header, payload):
    """The Mesh of a payload of profile 0, 1 or 4."""
    mesh = {RAW: raw, DRACO: coded, FAST: fast}[header.profile](header, payload)
    mesh.check()
    return mesh


def parts_of(header, payload):
    """Clause 8.14: the parts of a payload of profile 5, and the header of its patch or None."""
    parts = mesh_patched.Parts(payload)
    if not parts.patch:
        return parts, None
    demand(len(parts.patch) >= 16, 3001, "size of a patch")
    demand(parts.patch[0] in INDEPENDENT, 3036, f"a patch of profile {parts.patch[0]}")
    demand(tuple(parts.patch[1:4]) == header.kind(), 3036, "attributes or bits of a patch")
    return parts, Header(parts.patch)


def joined(header, base, kept, faces, patch):
    """The mesh of a patched frame: base as it has moved, with the vertices that are kept, by number, and these of its
    faces; and patch or None."""
    number = numpy.zeros(len(base.positions), numpy.int64)
    number[kept] = numpy.arange(len(kept))

    def both(own, other):
        return None if own is None else own[kept] if patch is None else numpy.concatenate([own[kept], other])

    of_patch = patch or base  # not used without a patch
    faces = number[faces] if patch is None else numpy.concatenate([number[faces], patch.faces + len(kept)])
    return Mesh(
        header,
        both(base.positions, of_patch.positions),
        faces,
        both(base.texture, of_patch.texture),
        both(base.normals, of_patch.normals),
    )


class Sequence:
    """A key mesh and the delta and patched frames after it, on one track. patch, kept: of the last frame, its patch and
    the numbers that the vertices it keeps had before, None if it is not patched."""

    def __init__(self, key):
        self.delta, self.mesh = None, key
        self.patch, self.kept = None, None
        self._base(key)

    def _base(self, mesh):
        self.base, self.own_normals = mesh, None
        self.lists = mesh.positions.tolist(), [tuple(f) for f in mesh.faces.tolist()]

    def _start(self):
        class Key:
            positions, faces = self.lists

        self.delta = mesh_delta.Sequence(Key)

    def add(self, header, payload):
        demand(header.kind() == self.base.header.kind(), 3018, "header of a delta frame")
        self.patch, self.kept, at = None, None, 16
        if not self.delta:
            self._start()
        if header.profile == PATCHED:
            self.delta.check_number(payload, parts_of(header, payload)[0].delta)
            faces, at = self._read(header, payload)
        else:
            demand(header.counts() == self.base.header.counts(), 3018, "counts of a delta frame")
        self.delta.add(payload, at)
        positions = numpy.array(self.delta.positions(), numpy.int64)
        turned = self._normals(positions.tolist()) if self.base.normals is not None else None
        self.mesh = Mesh(self.base.header, positions, self.base.faces, self.base.texture, turned)
        if header.profile == PATCHED:
            self._base(joined(header, self.mesh, self.kept, faces, self.patch))
            self.mesh = self.base
            self.delta.replace(
                self.kept.tolist(), self.patch.positions.tolist() if self.patch else [], self.lists[1]
            )

    def _read(self, header, payload):
        """Reads what is kept, and the patch. Returns the faces that remain, and where the motion begins."""
        parts, patch = parts_of(header, payload)
        absent = mesh_patched.left_out(parts.absent, len(self.base.faces))
        remaining = self.base.faces[~numpy.array(absent, bool)]
        self.kept = numpy.unique(remaining)
        vertices, faces = patch.counts() if patch else (0, 0)
        expected = len(self.kept) + vertices, len(remaining) + faces
        demand(header.counts() == expected, 3035, f"counts, expected {expected}")
        self.patch = independent(patch, parts.patch) if patch else None
        return remaining, parts.delta

    def _normals(self, positions):
        faces = self.lists[1]
        if self.own_normals is None:
            self.own_normals = normals.computed(self.lists[0], faces, joined=False)
        after = normals.computed(positions, faces, joined=False)
        rows = zip(map(tuple, self.base.normals.tolist()), self.own_normals, after)
        return numpy.array([normals.turned(self.base.normal_bits, *row) for row in rows], numpy.int64)


class Track:
    """A mesh track in one group."""

    def __init__(self):
        self.first, self.sequence, self.time = None, None, None

    def add(self, chunk, key):
        """Decodes a MESH chunk. Returns False if it follows a lost frame and cannot be decoded."""
        sequence, self.sequence, self.time = self.sequence, None, chunk.time
        header = Header(chunk.payload)
        check_size(header, chunk.payload)
        first = self.first or header
        demand(first.texture_bits == header.texture_bits, 3016, "texture bits differ in the group")
        demand(first.normal_bits == header.normal_bits, 3032, "normal bits differ in the group")
        demand((header.profile in INDEPENDENT) == key, 3017, f"profile {header.profile}, key flag {key}")
        self.first = first
        if not key:
            if sequence is None:
                return False
            sequence.add(header, chunk.payload)
            self.sequence = sequence
            return True
        self.sequence = Sequence(independent(header, chunk.payload))
        return True
