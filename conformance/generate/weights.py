"""Visibility: the encoder of clauses 17.1 to 17.3 of spec/fvv.md. States are those of clause 17.3."""

from reference.container import uleb128
from reference.visibility import Contexts, LevelContexts, Surface, centre, class_of, side

from .coder import Encoder
from .packing import pack

LATTICE = (0.0, 0.0, 0.0, 0.001)


def place(rotation, translation, lattice=LATTICE):
    """The centre of a camera in lattice steps."""
    return centre(rotation, translation, lattice)


def above(x=0.0, y=0.0, z=1.0, lattice=LATTICE):
    """The centre of payloads.camera(centre=(x, y, z))."""
    from .payloads import DOWN

    t = tuple(0.0 - sum(DOWN[3 * i + j] * (x, y, z)[j] for j in range(3)) for i in range(3))
    return place(DOWN, t, lattice)


class Weights:
    """Encodes the chunks of one visibility track: seen(camera, vertex) says what is seen, level(camera, vertex) how near
    to a half it is."""

    def __init__(self, shape, mesh_track=1):
        self.shape, self.mesh_track = shape, mesh_track
        self.surface = Surface(len(shape.positions), [tuple(face) for face in shape.faces])
        self.former, self.number = {}, -1

    def stream(self, facing, former, seen, level):
        """Bytes of one camera, and its states."""
        surface, encoder, table = self.surface, Encoder(), Contexts()
        counts = [[0] * len(surface.faces), [0] * len(surface.faces)]
        states = [0] * surface.count
        for vertex in surface.order:
            if not facing[vertex]:
                continue
            faces = surface.around[vertex]
            hidden, shown = (class_of(sum(count[face] for face in faces)) for count in counts)
            rim = not all(facing[corner] for corner in surface.corners(vertex))
            bit = int(bool(seen(vertex)))
            encoder.decision(table[side(former[vertex]), shown, hidden, rim], bit)
            for face in faces:
                counts[bit][face] += 1
            states[vertex] = 1 + bit
        sides, levels = list(states), LevelContexts()
        for vertex in surface.order:
            others = class_of(sum(sides[corner] == 3 - sides[vertex] for corner in surface.corners(vertex)))
            if not sides[vertex] or not others:
                continue
            before = (former[vertex] + 1) // 2 if side(former[vertex]) == sides[vertex] else 0
            for step in 1, 2:
                near = level(vertex) <= step
                encoder.decision(levels[before, others, step], near)
                if near:
                    break
                states[vertex] += 2
        return encoder.data(), states

    def chunk(
        self,
        centres,
        seen,
        level=lambda camera, vertex: 1,
        *,
        key=None,
        positions=None,
        threshold=64,
        blind=(),
        streams=None,
        table=None,
        extra=b"",
        **fields,
    ):
        """A VISI payload. centres: by camera; blind: cameras with a stream of size 0; key: None for the first chunk only;
        streams, table: change the right bytes by camera and the right pairs."""
        self.number = 0 if key or self.number < 0 else self.number + 1
        positions = self.shape.positions if positions is None else positions
        data, states = {}, {}
        for camera in sorted(centres):
            facing = self.surface.facing(positions, centres[camera], threshold)
            former = (
                self.former.get(camera, [0] * self.surface.count) if self.number else [0] * self.surface.count
            )
            if camera in blind:
                data[camera], states[camera] = b"", [int(f) for f in facing]
            else:
                data[camera], states[camera] = self.stream(
                    facing, former, lambda v, c=camera: seen(c, v), lambda v, c=camera: level(c, v)
                )
        self.former = states
        data = {camera: streams(bytes_) if streams else bytes_ for camera, bytes_ in data.items()}
        pairs, last = [], 0
        for camera, bytes_ in data.items():
            pairs.append((camera - last, len(bytes_)))
            last = camera
        pairs = table(pairs) if table else pairs
        values = {"threshold": threshold, "mesh_track": self.mesh_track, "vertex_count": self.surface.count}
        values |= {"number": self.number, "camera_count": len(centres)}
        out = pack("VISI payload", **values | fields)
        out += b"".join(
            number if isinstance(number, bytes) else uleb128(number) for pair in pairs for number in pair
        )
        return out + b"".join(data.values()) + extra
