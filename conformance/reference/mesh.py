"""Meshes in the raw profile: clauses 8.2, 8.3, 8.6 and 8.13 of spec/fvv.md."""

import struct
from typing import NamedTuple

from .container import Part, demand, joined, structure

TEXTURE, NORMALS = 1, 2  # bits of `attributes`


class Mesh(NamedTuple):
    """positions: lattice points; faces: triples of vertices; texture, normals: two indices of each vertex, or nothing."""

    positions: list
    faces: list
    texture: list = ()
    texture_bits: int = 0
    normals: list = ()
    normal_bits: int = 0


def rows(payload, at, count, form):
    size = struct.calcsize(form)
    return [struct.unpack_from(form, payload, at + size * i) for i in range(count)]


def read_raw(payload):
    """Reads a whole MESH payload of profile 0."""
    profile, attributes, texture_bits, normal_bits, vertices, faces, reserved = struct.unpack_from(
        "<4B3I", payload
    )
    assert profile == 0
    demand(reserved == 0, 3001, "reserved field")
    at, pairs = 16 + 12 * vertices, []
    for attribute in (TEXTURE, NORMALS):
        pairs.append(rows(payload, at, vertices, "<2I") if attributes & attribute else [])
        at += 8 * len(pairs[-1])
    demand(len(payload) == at + 12 * faces, 3004, "size")
    positions = rows(payload, 16, vertices, "<3i")
    return Mesh(positions, rows(payload, at, faces, "<3I"), pairs[0], texture_bits, pairs[1], normal_bits)


def raw_parts(mesh):
    """The parts of the payload of a mesh in the raw profile."""
    values = {"profile": 0, "vertex_count": len(mesh.positions), "face_count": len(mesh.faces)}
    if mesh.texture:
        values |= {"attributes": TEXTURE, "texture_bits": mesh.texture_bits}
    if mesh.normals:
        values |= {"attributes": values.get("attributes", 0) | NORMALS, "normal_bits": mesh.normal_bits}
    parts = structure("MESH payload", values, {"profile": "0: raw"})
    for name, form, table in (
        ("vertex", "<3i", mesh.positions),
        ("texture", "<2I", mesh.texture),
        ("normal", "<2I", mesh.normals),
        ("face", "<3I", mesh.faces),
    ):
        parts += [Part(struct.pack(form, *row), f"{name} {i}", str(row)) for i, row in enumerate(table)]
    return parts


def raw_data(mesh):
    """The bytes after the header of a mesh in the raw profile."""
    return joined(raw_parts(mesh))[16:]
