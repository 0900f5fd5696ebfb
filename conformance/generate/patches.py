"""Patched frames: the encoder of clause 8.14 of spec/fvv.md."""

from reference.container import uleb128
from reference.mesh_patched import runs

from . import meshes
from .motion import Motion

PATCHED = 5


def cut(shape, positions, faces):
    """Some faces of a shape, by number, as a shape of its own at other positions."""
    corners = [shape.faces[face] for face in faces]
    vertices = list(dict.fromkeys(vertex for face in corners for vertex in face))
    number = {vertex: i for i, vertex in enumerate(vertices)}

    def rows(table):
        return [table[vertex] for vertex in vertices] if table else ()

    return shape._replace(
        positions=rows(positions),
        faces=[tuple(number[vertex] for vertex in face) for face in corners],
        texture=rows(shape.texture),
        normals=rows(shape.normals),
    )


class Patches(Motion):
    """The state of a key mesh with its delta and patched frames."""

    def __init__(self, key):
        super().__init__(key)
        self.absent = [False] * len(key.faces)

    def frame(self, *arguments, **change):
        self.absent = [False] * len(self.key.faces)
        return super().frame(*arguments, **change)

    def patched(
        self, target, absent=(), patch=None, coded=meshes.raw, lengths=None, sizes=None, data=None, **header
    ):
        """A MESH payload of profile 5. absent: numbers of faces; patch: a shape. lengths, sizes, data: other runs, sizes
        and bytes of the patch than the right ones; header: other values of its fields."""
        before, self.absent = self.absent, [face in set(absent) for face in range(len(self.key.faces))]
        delta = super().frame(target, attributes=0)[16:]
        numbers = runs(before, self.absent) if lengths is None else lengths
        coded_runs = numbers if isinstance(numbers, bytes) else b"".join(map(uleb128, numbers))
        if data is None:
            data = coded(patch) if patch else b""
        vertices, faces = (len(patch.positions), len(patch.faces)) if patch else (0, 0)
        values = {
            "vertex_count": len(self.key.positions) + vertices,
            "face_count": self.absent.count(False) + faces,
        }
        parts = sizes if sizes is not None else uleb128(len(coded_runs)) + uleb128(len(data))
        return self.key.header(PATCHED, **values | header) + parts + coded_runs + data + delta
