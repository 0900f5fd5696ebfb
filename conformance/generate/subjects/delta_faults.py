"""Faults of delta frames: clauses 8.3 and 8.7 to 8.9."""

from reference.container import uleb128

from .. import meshes
from ..case import faulty
from ..motion import Motion
from ..recipes import between
from .mesh_whole import moved

GRID = meshes.grid(8, 6)
LEVELS = meshes.grid(16, 12)


def delta(name, title, clauses, issue, change, shape=GRID, before=1):
    """A key mesh, good delta frames, then the payload of change(motion, target), then a good one that nothing can use."""

    def middle(s):
        motion = Motion(shape)
        s.begin(2, 9)
        s.chunk("MESH", meshes.raw(shape), 1, 2, True)
        for time in range(1, before + 1):
            s.chunk("MESH", motion.frame(moved(shape.positions, time)), 1, 2 + time)
        target = moved(shape.positions, before + 1)
        s.chunk("MESH", change(motion, target), 1, 3 + before, fault=issue)
        s.chunk("MESH", motion.frame(moved(shape.positions, before + 2)), 1, 4 + before)
        s.end()

    faulty(f"delta_{name}", title, clauses, lambda: between(middle))


def fields(**change):
    return lambda motion, target: motion.frame(target, **change)


def header():
    count = len(GRID.positions)
    delta(
        "vertex_count",
        "A delta frame has a vertex more than its key mesh.",
        "8.7",
        3018,
        fields(vertex_count=count + 1),
    )
    delta(
        "face_count",
        "A delta frame has a face less than its key mesh.",
        "8.7",
        3018,
        fields(face_count=len(GRID.faces) - 1),
    )
    delta(
        "attributes",
        "A delta frame has texture coordinates, its key mesh has none.",
        "8.6 8.7",
        3016,
        fields(attributes=1, texture_bits=8),
    )
    textured = meshes.with_normals(meshes.textured(GRID))
    delta(
        "without_attributes",
        "A delta frame lacks the attributes of its key mesh.",
        "8.6 8.7",
        3016,
        fields(attributes=0, texture_bits=0, normal_bits=0),
        textured,
    )
    # These rules of the whole group come before FVV-3018.
    for field, bits, issue in ("texture_bits", 9, 3016), ("normal_bits", 10, 3032):
        delta(
            field,
            f"A delta frame has other {field} than its key mesh.",
            "8.6 8.7 8.13",
            issue,
            fields(**{field: bits}),
            textured,
        )
    delta(
        "attributes_only",
        "A delta frame has the normal bits of its key mesh without the attribute.",
        "8.13",
        3030,
        fields(attributes=0, texture_bits=0),
        meshes.with_normals(GRID),
    )
    delta("number_zero", "The number of a delta frame is 0.", "8.7", 3019, fields(number=0))
    delta(
        "number_repeated",
        "The number of a delta frame is that of the one before.",
        "8.7",
        3019,
        fields(number=1),
    )
    delta("number_skipped", "The number of a delta frame is one too high.", "8.7 12", 3019, fields(number=3))
    delta("number_first", "The first delta frame has the number 2.", "8.7", 3019, fields(number=2), before=0)
    delta("levels_more", "A delta frame has a level more than its key mesh.", "8.7", 3020, more_levels)
    delta(
        "levels_less", "A delta frame has a level less than its key mesh.", "8.7", 3020, fewer_levels, LEVELS
    )
    delta("levels_none", "A delta frame has no level.", "8.7", 3020, fields(count=0))
    delta("step_zero", "The step of a level is 0.", "8.7", 3020, lambda m, t: with_step(m, t, 0))
    delta("step_beyond", "The step of a level is 262144.", "8.7", 3020, lambda m, t: with_step(m, t, 262144))
    delta(
        "step_huge", "The step of a level is 2^64 - 1.", "8.7", 3020, lambda m, t: with_step(m, t, 2**64 - 1)
    )
    delta("size_extra", "A byte follows the data of the last level.", "8.7", 3021, fields(extra=b"\0"))
    delta("size_beyond", "The size of a level is beyond the payload.", "8.7", 3021, fields(sizes=[100000]))
    delta("size_huge", "The size of a level is 2^64 - 1.", "8.7", 3021, fields(sizes=[2**64 - 1]))
    delta(
        "overlong",
        "The number of a delta frame is not in its shortest form.",
        "2.3 8.7",
        3021,
        fields(overlong=True),
    )
    delta("cut", "A delta frame ends inside its numbers.", "8.7", 3021, lambda m, t: m.frame(t)[:18])
    delta("empty", "A delta frame has nothing after its header.", "8.7", 3021, lambda m, t: m.frame(t)[:16])
    faulty(
        "delta_without_key",
        "A delta frame is the first mesh of its track in the group, with the key flag.",
        "8.3",
        lambda: between(first_with_flag),
    )
    faulty(
        "delta_with_flag",
        "A delta frame after a key mesh has the key flag.",
        "8.3",
        lambda: between(with_flag),
    )


def more_levels(motion, target):
    payload = motion.frame(target, [4])
    return payload.replace(b"\x02\x01\x04", b"\x02\x02\x04", 1)[:19] + payload[19:]


def fewer_levels(motion, target):
    count = len(motion.levels)
    return motion.frame(target, count=count - 1)


def with_step(motion, target, step):
    """The data is that of a step of 4."""
    good = motion.frame(target)
    numbers = uleb128(motion.number) + uleb128(1) + uleb128(4)
    if good[16 : 16 + len(numbers)] != numbers:
        raise ValueError("one level is expected")
    return good[:18] + uleb128(step) + good[16 + len(numbers) :]


def first_with_flag(s):
    s.begin(2, 4)
    s.chunk("MESH", Motion(GRID).frame(GRID.positions), 1, 2, True, fault=3017)
    s.end()


def with_flag(s):
    s.begin(2, 5)
    motion = Motion(GRID)
    s.chunk("MESH", meshes.raw(GRID), 1, 2, True)
    s.chunk("MESH", motion.frame(GRID.positions), 1, 3, True, fault=3017)
    s.chunk("MESH", motion.frame(GRID.positions), 1, 4)
    s.end()


def streams():
    delta("stream_longer", "A level has a byte more than its decisions use.", "2.4 8.9", 3022, longer)
    delta("stream_shorter", "A level lacks its last byte.", "2.4 8.9", 3022, shorter)
    delta("stream_digits", "A magnitude has 30 digits.", "8.9", 3022, lambda m, t: coded(m, many_digits()))
    far = meshes.TETRAHEDRON._replace(positions=[(meshes.MOST, 0, 0), *meshes.TETRAHEDRON.positions[1:]])
    delta(
        "beyond_lattice",
        "A delta frame moves a vertex beyond the lattice.",
        "8.1 8.9",
        3006,
        lambda m, t: coded(m, first_residual(1)),
        far,
        before=0,
    )
    low = meshes.TETRAHEDRON._replace(positions=[(0, -meshes.MOST, 0), *meshes.TETRAHEDRON.positions[1:]])
    delta(
        "below_lattice",
        "A delta frame moves a vertex below the lattice.",
        "8.1 8.9",
        3006,
        lambda m, t: coded(m, second_residual(-1)),
        low,
        before=0,
    )


def resized(payload, data):
    """A payload of one level of less than 128 steps with other data."""
    at = 18 + 1
    while payload[at] & 128:
        at += 1
    return payload[:19] + uleb128(len(data)) + data, payload[at + 1 :]


def longer(motion, target):
    payload = motion.frame(target)
    data = resized(payload, b"")[1]
    return resized(payload, data + b"\1")[0]


def shorter(motion, target):
    payload = motion.frame(target)
    data = resized(payload, b"")[1]
    return resized(payload, data[:-1])[0]


def coded(motion, data):
    """A frame of one level with a step of one lattice step and this data."""
    motion.number += 1
    return motion.payload([4], [data], motion.number)


def many_digits():
    """some = 1, then 31 times more = 1."""
    from ..coder import Encoder, contexts

    encoder, table = Encoder(), contexts()
    encoder.decision(table["some"], 1)
    for i in range(31):
        encoder.decision(table[i], 1)
    for _ in range(32):
        encoder.even(1)
    return encoder.data()


def first_residual(value):
    return residuals([value])


def second_residual(value):
    return residuals([0, value])


def residuals(values):
    """Decisions of the first axes of the first vertex of a tetrahedron, 0 for the others."""
    from ..coder import Encoder, contexts
    from ..motion import sign, write_magnitude

    encoder, table, done = Encoder(), contexts(), 0
    for vertex in range(4):
        for a in range(3):
            residual = values[a] if vertex == 0 and a < len(values) else 0
            near = 1 if vertex == 1 and a < len(values) and values[a] else 0
            done = min(sum(abs(x) for x in values[:a]), 2) if vertex == 0 else 0
            encoder.decision(table["some", (a, near, 0, done)], residual != 0)
            if residual:
                write_magnitude(encoder, table, near, abs(residual))
                encoder.decision(table["negative", (a, 0, sign(0))], residual < 0)
    return encoder.data()


header()
streams()
