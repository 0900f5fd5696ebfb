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
    """The state of a key mesh with its delta and patched frames. key: the base mesh."""

    def patched(
        self,
        target,
        absent=(),
        patch=None,
        coded=meshes.raw,
        steps=4,
        lengths=None,
        sizes=None,
        data=None,
        **header,
    ):
        """A MESH payload of profile 5. absent: numbers of faces; patch: a shape. lengths, sizes, data: other runs, sizes
        and bytes of the patch than the right ones; header: other values of its fields."""
        flags = [face in set(absent) for face in range(len(self.key.faces))]
        delta = self.frame(target, steps, attributes=0)[16:]
        numbers = runs(flags) if lengths is None else lengths
        coded_runs = numbers if isinstance(numbers, bytes) else b"".join(map(uleb128, numbers))
        if data is None:
            data = coded(patch) if patch else b""
        base, merged = self.key, self._merge(flags, patch)
        values = {"vertex_count": len(merged.positions), "face_count": len(merged.faces)}
        parts = sizes if sizes is not None else uleb128(len(coded_runs)) + uleb128(len(data))
        return base.header(PATCHED, **values | header) + parts + coded_runs + data + delta

    def _merge(self, flags, patch):
        """Goes on with the base mesh without some faces, and with the patch."""
        faces = [face for face, flag in zip(self.key.faces, flags) if not flag]
        kept = sorted({vertex for face in faces for vertex in face})
        number = {vertex: i for i, vertex in enumerate(kept)}
        now = self.shape()
        own = patch or now._replace(positions=[], faces=[], texture=[], normals=[])

        def rows(table, other):
            return [table[vertex] for vertex in kept] + list(other) if table else ()

        self.replace(
            now._replace(
                positions=rows(now.positions, own.positions),
                faces=[tuple(number[v] for v in face) for face in faces]
                + [tuple(len(kept) + v for v in face) for face in own.faces],
                texture=rows(now.texture, own.texture),
                normals=rows(now.normals, own.normals),
            ),
            kept,
        )
        return self.key
