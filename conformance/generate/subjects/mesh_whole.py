"""Whole meshes of every profile: clause 8."""

from .. import draco_writer, media, meshes, payloads
from ..case import valid
from ..motion import Motion
from ..packing import pack
from ..recipes import opened

GRID = meshes.grid(7, 6)
MOST = meshes.MOST


def stream(*frames, tracks=1):
    """frames: lists of (payload, key), one list for each group."""
    s = opened(*[(1 + i, payloads.track(payloads.MESH, "mesh")) for i in range(tracks)])
    time = 0
    for group in frames:
        s.begin(time, time + len(group))
        for payload, key in group:
            s.chunk("MESH", payload, 1, time, key)
            time += 1
        s.end()
    s.finish()
    return s


def keys(*payload):
    return lambda: stream([(p, True) for p in payload])


def raw_profile():
    def shape(name, title, *shapes, **more):
        valid(f"mesh_raw_{name}", title, "8.3", keys(*map(meshes.raw, shapes)), **more)

    shape("triangle", "One face, three vertices: the smallest mesh.", meshes.TRIANGLE)
    shape(
        "two_sided",
        "Two faces of the same three vertices.",
        meshes.TRIANGLE._replace(faces=[(0, 1, 2), (0, 2, 1)]),
    )
    shape(
        "changes",
        "Every frame has other counts.",
        meshes.TETRAHEDRON,
        meshes.OCTAHEDRON,
        meshes.TRIANGLE,
        GRID,
    )
    shape("limits", "Positions at both ends of the lattice.", meshes.FAR)
    shape(
        "same_point",
        "All vertices of a mesh on one lattice point.",
        meshes.TETRAHEDRON._replace(positions=[(1, 2, 3)] * 4),
    )
    shape(
        "no_area",
        "Faces without area among others.",
        meshes.Shape([(0, 0, 0), (10, 0, 0), (20, 0, 0), (0, 9, 0)], [(0, 1, 2), (0, 1, 3), (1, 2, 3)]),
    )
    shape(
        "not_manifold",
        "Three faces share an edge, and two surfaces a vertex.",
        meshes.Shape(
            [(0, 0, 0), (10, 0, 0), (0, 9, 0), (0, -9, 0), (0, 0, 9), (-5, 3, 1), (-5, -3, 1)],
            [(0, 1, 2), (1, 0, 3), (0, 1, 4), (0, 5, 6)],
        ),
    )
    shape("repeated_face", "A face is there twice.", meshes.TRIANGLE._replace(faces=[(0, 1, 2), (0, 1, 2)]))
    shape("large", "1,500 vertices and 2,852 faces.", meshes.grid(50, 30))
    shape("pieces", "40 triangles that share no vertex.", meshes.strip(40))
    for bits in (1, 8, 16):
        valid(
            f"mesh_texture_{bits}_bits",
            f"Texture coordinates of {bits} bits, up to 2^{bits}.",
            "8.6",
            keys(
                meshes.raw(
                    meshes.textured(GRID, bits)._replace(
                        texture=[(0, 1 << bits), (1 << bits, 0)] + meshes.textured(GRID, bits).texture[2:]
                    )
                )
            ),
        )
    for bits in (2, 7, 12):
        valid(
            f"mesh_normals_{bits}_bits",
            f"Sent normals of {bits} bits, up to 2^{bits} - 2.",
            "8.13",
            keys(
                meshes.raw(
                    meshes.with_normals(GRID, bits)._replace(
                        normals=[(0, (1 << bits) - 2), ((1 << bits) - 2, 0)]
                        + meshes.with_normals(GRID, bits).normals[2:]
                    )
                )
            ),
        )
    valid(
        "mesh_texture_and_normals",
        "Texture coordinates and normals.",
        "8.3 8.6 8.13",
        keys(meshes.raw(meshes.with_normals(meshes.textured(GRID)))),
    )
    valid(
        "mesh_attributes_by_group",
        "Texture and normal bits change from group to group.",
        "8.6 8.13",
        by_group,
    )
    valid("mesh_attributes_by_track", "Two mesh tracks with different attributes.", "8.6", by_track)
    valid("mesh_track_pauses", "A mesh track has no mesh in the second of three groups.", "11", pauses)


def by_group():
    shapes = [GRID, meshes.textured(GRID, 8), meshes.textured(GRID, 9), meshes.with_normals(GRID, 5), GRID]
    return stream(*[[(meshes.raw(s), True), (meshes.raw(s.moved(1)), True)] for s in shapes])


def by_track():
    s = opened((1, payloads.track(1, "plain")), (2, payloads.track(1, "textured")))
    s.begin(0, 2)
    for time in 0, 1:
        s.chunk("MESH", meshes.raw(meshes.TETRAHEDRON), 1, time, True)
        s.chunk("MESH", meshes.raw(meshes.textured(meshes.OCTAHEDRON)), 2, time, True)
    s.end()
    s.finish()
    return s


def pauses():
    s = opened((1, payloads.track(1, "here")), (2, payloads.track(1, "sometimes")))
    for number in range(3):
        s.begin(number, number + 1)
        s.chunk("MESH", meshes.raw(meshes.TETRAHEDRON), 1, number, True)
        if number != 1:
            s.chunk("MESH", meshes.raw(meshes.TRIANGLE), 2, number, True)
        s.end()
    s.finish()
    return s


def draco_payload(name, texture_bits=0, normal_bits=0, data=None, **fields):
    vertices, faces, stored = media.draco(name)
    attributes = (1 if texture_bits else 0) | (2 if normal_bits else 0)
    values = {
        "profile": meshes.DRACO,
        "vertex_count": vertices,
        "face_count": faces,
        "attributes": attributes,
    }
    values |= {"texture_bits": texture_bits, "normal_bits": normal_bits}
    return pack("MESH payload", **values | fields) + (stored if data is None else data)


def by_hand(shape, data=None, **options):
    """A payload of the Draco profile by draco_writer."""
    return shape.header(meshes.DRACO) + (draco_writer.sequential(shape, **options) if data is None else data)


def draco_profile():
    for name, title, bits in (
        ("tetrahedron", "The smallest closed mesh.", ()),
        ("triangle", "One face.", ()),
        ("octahedron_sequential", "Sequential method.", ()),
        ("ball_speed_0", "Constrained multi-parallelogram and valence traversal.", ()),
        ("ball_speed_2", "Speed 2.", ()),
        ("ball_speed_5", "Parallelogram.", ()),
        ("ball_speed_8", "Speed 8.", ()),
        ("ball_speed_10", "Difference.", ()),
        ("grid_valence", "A sheet of 400 vertices, which has a border.", ()),
        ("grid_large", "3,000 vertices.", ()),
        ("grid_sequential", "A sheet by the sequential method.", ()),
        ("grid_textured", "Texture coordinates.", (12,)),
        ("grid_textured_sequential", "Texture coordinates by the sequential method.", (12,)),
        ("grid_normals", "Normals.", (0, 10)),
        ("grid_both", "Texture coordinates and normals.", (12, 10)),
        ("grid_both_sequential", "Texture coordinates and normals by the sequential method.", (12, 10)),
        ("strip", "Triangles that share no vertex.", ()),
        ("corner", "A position at the end of the lattice.", ()),
        ("torus", "A handle, whose splits need events on the right.", ()),
        ("torus_speed_0", "A handle by the valence traversal, in the order of prediction degree.", ()),
        ("torus_speed_4", "A handle by the valence traversal.", ()),
        ("holed", "Many borders, whose splits need events on both sides.", ()),
        ("holed_valence", "Many borders by the valence traversal.", ()),
        ("pieces", "Several parts with borders and handles.", ()),
        ("hubs", "Joining and renumbering vertices takes 12.4 steps per face.", ()),
    ):
        valid(
            f"mesh_draco_{name}",
            f"Draco: {title[0].lower()}{title[1:]}",
            "8.4",
            lambda name=name, bits=bits: stream([(draco_payload(name, *bits), True)]),
        )
    shape = meshes.with_normals(meshes.textured(meshes.grid(9, 7), 12), 10)
    far = meshes.with_normals(meshes.textured(meshes.FAR, 14), 9)
    many = meshes.grid(20, 15)
    for name, title, mesh, options in (
        ("numbers_2", "Numbers of two bytes without entropy coding.", shape, {"size": 2}),
        ("numbers_3", "Numbers of three bytes without entropy coding.", shape, {"size": 3}),
        (
            "numbers_4",
            "Numbers of four bytes without entropy coding, positions at the ends of the lattice.",
            far,
            {"size": 4},
        ),
        ("tags", "Tags, positions at the ends of the lattice.", far, {}),
        ("alphabet_1", "Alphabets that are declared to have one bit.", shape, {"width": 1}),
        ("alphabet_13", "Alphabets of 13 bits.", shape, {"width": 13}),
        ("alphabet_18", "Alphabets of 18 bits.", shape, {"width": 18}),
        (
            "range",
            "The largest range of values.",
            many,
            {"width": 9, "least": -(1 << 30), "most": (1 << 30) - 2},
        ),
        ("tags_33", "An alphabet of 33 tags.", shape, {"least_symbols": 33}),
        (
            "alphabet_long",
            "An alphabet of 2^18 symbols.",
            many,
            {"width": 18, "least_symbols": 1 << 18},
        ),
        ("corners_u16", "Corners of 16 bits.", many, {"width": 9}),
        ("corners_256", "256 vertices: corners of 16 bits.", meshes.grid(16, 16), {"width": 9}),
        ("corners_255", "255 vertices: corners of 8 bits.", meshes.grid(17, 15), {"width": 9}),
    ):
        valid(
            f"mesh_draco_sequential_{name}",
            f"Draco: sequential method. {title}",
            "8.4",
            lambda mesh=mesh, options=options: stream([(by_hand(mesh, **options), True)]),
        )
    valid(
        "mesh_draco_torus_tags",
        "Draco: a handle by the valence traversal, whose symbols have tags.",
        "8.4",
        lambda: stream(
            [
                (
                    draco_payload(
                        "torus_speed_4", data=draco_writer.with_tagged_lists(media.draco("torus_speed_4")[2])
                    ),
                    True,
                )
            ]
        ),
    )
    valid(
        "mesh_profiles_mixed",
        "Raw, Draco and fast meshes in one group.",
        "8.3",
        keys(meshes.raw(meshes.TETRAHEDRON), draco_payload("ball_speed_5"), meshes.fast(GRID)),
    )


def fast_profile():
    def shape(name, title, mesh, **change):
        valid(f"mesh_fast_{name}", f"Fast: {title}", "8.11", keys(meshes.fast(mesh, **change)))

    def vertices(mesh, mode):
        elements = meshes.elements_of(mesh)
        return lambda _: meshes.vertex_stream(elements, len(elements[0]), mode)

    shape("triangle", "one face.", meshes.TRIANGLE)
    shape("octahedron", "an octahedron.", meshes.OCTAHEDRON)
    shape("grid", "a sheet of 42 vertices.", GRID)
    shape("two_blocks", "300 vertices: two blocks.", meshes.grid(20, 15))
    shape("block_of_256", "256 vertices fill one block.", meshes.grid(16, 16))
    shape("pieces", "vertices that no other face uses.", meshes.strip(30))
    shape("ball", "a closed surface.", meshes.ball(8, 12))
    shape("far", "positions at both ends of the lattice.", meshes.FAR)
    shape("textured", "texture coordinates.", meshes.textured(GRID, 12))
    shape("normals", "normals.", meshes.with_normals(GRID, 9))
    shape("both", "texture coordinates and normals.", meshes.with_normals(meshes.textured(GRID, 12), 9))
    ball = meshes.ball(6, 9)
    shape("bytes", "all groups of deltas as bytes.", ball, vertices=vertices(ball, lambda group: 3))
    shape("two_bits", "all groups of deltas with 2 bits.", ball, vertices=vertices(ball, lambda group: 1))
    shape("four_bits", "all groups of deltas with 4 bits.", ball, vertices=vertices(ball, lambda group: 2))
    jump = [(0, 1, 2), (2, 1, 3), (60, 61, 62), (3, 1, 61), (59, 62, 4)]
    rest = [(i, i + 1, i + 2) for i in range(4, 58, 3)] + [(58, 59, 57)]
    shape(
        "far_indices", "faces that use vertices out of order.", meshes.grid(9, 7)._replace(faces=jump + rest)
    )


def moved(positions, time):
    """A smooth motion, and one vertex that jumps."""
    out = [(x + (y * time) // 20, y + 2 * time, z + (x * time) // 30) for x, y, z in positions]
    out[len(out) // 2] = (out[len(out) // 2][0] + 40 * time, *out[len(out) // 2][1:])
    return out


def sequence(shape, frames, steps=4, key=meshes.raw, still=None):
    motion, out = Motion(shape), [(key(shape), True)]
    for time in range(1, frames):
        levels = still(time, len(motion.levels)) if still else ()
        out.append((motion.frame(moved(shape.positions, time), steps, levels), False))
    return out


def delta_profile():
    def case(name, title, *groups, clauses="8.7 8.9", **more):
        valid(
            f"mesh_delta_{name}",
            title,
            clauses,
            lambda: stream(*[g() if callable(g) else g for g in groups]),
            **more,
        )

    case(
        "tetrahedron",
        "Delta frames of four vertices: one level of survivors.",
        lambda: sequence(meshes.TETRAHEDRON, 4),
    )
    case("grid", "Ten delta frames of a sheet.", lambda: sequence(meshes.grid(8, 8), 11))
    case("levels", "A mesh of several levels.", lambda: sequence(meshes.grid(26, 24), 4), clauses="8.8 8.9")
    case("ball", "A closed surface.", lambda: sequence(meshes.ball(12, 16), 4), clauses="8.8")
    twins = meshes.Shape(
        [*meshes.grid(8, 6).positions, *meshes.grid(8, 6).positions[:8]],
        [*meshes.grid(8, 6).faces, (48, 49, 50), (51, 52, 53), (53, 54, 55)],
    )
    case(
        "twins", "Vertices on one lattice point: a level of twins.", lambda: sequence(twins, 4), clauses="8.8"
    )
    case(
        "pieces",
        "60 triangles that share no vertex: all are survivors but those of the passes.",
        lambda: sequence(meshes.strip(60), 3),
        clauses="8.8",
    )
    for step in (1, 2, 3, 6, 8, 1000, 262143):
        case(
            f"step_{step}",
            f"Steps of {step} quarters.",
            lambda step=step: sequence(meshes.grid(8, 8), 4, step),
        )
    case(
        "still",
        "All levels have size 0: only the prediction moves.",
        lambda: sequence(
            meshes.grid(26, 24), 5, still=lambda time, levels: range(levels) if time > 2 else ()
        ),
    )
    case(
        "still_levels",
        "Every other level has size 0.",
        lambda: sequence(meshes.grid(26, 24), 5, still=lambda time, levels: range(time % 2, levels, 2)),
    )
    case(
        "textured",
        "Delta frames of a mesh with texture coordinates.",
        lambda: sequence(meshes.textured(meshes.grid(7, 5)), 3),
        clauses="8.6 8.7",
    )
    case(
        "normals",
        "Delta frames of a mesh with normals, which rotate with the faces.",
        lambda: sequence(meshes.with_normals(meshes.grid(7, 5), 10), 4),
        clauses="8.13",
    )
    case("after_draco", "Delta frames after a Draco mesh.", after_draco, clauses="8.4 8.7")
    case("after_fast", "Delta frames after a fast mesh.", after_fast, clauses="8.7 8.11")
    case(
        "keys_between",
        "Keys and delta frames alternate within a group.",
        lambda: sequence(GRID, 3) + sequence(GRID.moved(5), 2) + sequence(meshes.TETRAHEDRON, 3),
        clauses="8.7",
    )
    case(
        "groups",
        "Each group begins with a key mesh.",
        lambda: sequence(GRID, 3),
        lambda: sequence(meshes.OCTAHEDRON, 3),
        clauses="8.7 6.2",
    )
    case("large_motion", "Positions cross the whole lattice.", across)
    case(
        "many",
        "140 delta frames: the number takes two bytes.",
        lambda: sequence(meshes.TETRAHEDRON, 141),
        clauses="8.7",
    )


def after_draco():
    shape = meshes.Shape(*media.draco_decoded("ball_decoded"))
    return sequence(shape, 3, key=lambda _: draco_payload("ball_decoded"))


def after_fast():
    faces = meshes.index_stream(GRID.faces)[1]
    return sequence(GRID._replace(faces=faces), 3, key=meshes.fast)


def across():
    shape = meshes.TETRAHEDRON._replace(
        positions=[(-MOST, -MOST, -MOST), (-MOST, 5, 0), (0, -MOST, 1), (3, 3, 3)]
    )
    motion = Motion(shape)
    ends = [(MOST, MOST, MOST), (MOST, 5, 0), (0, MOST, 1), (3, 3, 3)]
    out = [(meshes.raw(shape), True)]
    for target in (ends, shape.positions, ends):
        out.append((motion.frame(target), False))
    return out


raw_profile()
draco_profile()
fast_profile()
delta_profile()
