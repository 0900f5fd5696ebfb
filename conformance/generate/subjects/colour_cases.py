"""Whole and faulty colours of vertices, and constants of texturing: clauses 17.5 and 19."""

from .. import colours, meshes, payloads
from ..case import faulty, valid
from ..motion import Motion
from ..packing import patched
from ..recipes import group, opened
from .mesh_whole import moved

TRACK = 8
TRACKS = [(1, payloads.track(payloads.MESH, "mesh")), (TRACK, payloads.track(payloads.COLOURS, "colours"))]
GRID = meshes.grid(9, 8)
BALL = meshes.ball(8, 12)


def smooth(cell):
    x, y, z = cell
    return (20 + x * 2 + y, x - y, z * 3 - x)


def wild(cell):
    x, y, z = cell
    return ((x * 37 + y * 91) % 60, (x * 53 - z * 17) % 40 - 20, (y * 29 + x) % 30 - 15)


def one(name, title, shape=GRID, value_of=smooth, **fields):
    def make():
        s = opened(*TRACKS)
        s.begin(0, 1)
        s.chunk("MESH", meshes.raw(shape), 1, 0, True)
        s.chunk("COLR", colours.payload(shape, value_of, **fields), TRACK, 0, True)
        s.end()
        s.finish()
        return s

    valid(f"colours_{name}", title, "19", make)


def whole():
    one("sheet", "A sheet in smooth colours.")
    one("ball", "A ball.", BALL, size=100)
    one("wild", "Neighbouring cells differ much.", value_of=wild)
    one("one_cell", "All vertices in one cell.", meshes.TRIANGLE, size=2**24)
    one("cell_1", "Cells of one lattice step: one for each vertex.", size=1)
    one("cell_odd", "Cells of 7 steps, around 0.", BALL, size=7 * 19)
    one(
        "steps_1",
        "Steps of 1.",
        value_of=lambda c: tuple(4 * v for v in smooth(c)),
        luma_step=1,
        chroma_step=1,
    )
    one(
        "steps_64",
        "Steps of 64.",
        value_of=lambda c: (c[0] % 4, 1 - c[1] % 3, c[0] % 2),
        luma_step=64,
        chroma_step=64,
    )
    one(
        "limits",
        "Values of -511 and 511: colours are kept within range.",
        value_of=lambda c: (511 if c[0] % 2 else -511, -511 if c[1] % 2 else 511, 511),
        luma_step=1,
        chroma_step=1,
    )
    one("constant", "All cells have the expected value.", value_of=lambda c: (32, 0, 0))
    one(
        "pieces",
        "Cells without neighbours.",
        meshes.strip(12)._replace(
            positions=[
                (500 * (i // 3) + x % 10, y, z) for i, (x, y, z) in enumerate(meshes.strip(12).positions)
            ]
        ),
        wild,
    )
    one(
        "extent_1022",
        "Cells 1,021 apart on each axis.",
        meshes.Shape([(0, 0, 0), (1021, 1021, 1021), (5, 0, 0)], [(0, 1, 2)]),
        wild,
        size=1,
    )
    valid(
        "colours_delta", "Delta frames keep the colours of their key mesh, vertex by vertex.", "19.1", delta
    )
    valid("colours_some_keys", "A key mesh with colours and one without.", "19.1", some_keys)
    valid("colours_two_meshes", "Colours of two mesh tracks.", "19.1", two_meshes)
    for name, fields in (
        ("default", None),
        (
            "explicit",
            {"threshold": 0.25, "depth_bias": 1.5, "depth_slope": 0.0, "best": 5, "unseen": (1, 2, 3)},
        ),
        (
            "extremes",
            {"threshold": 1.0, "depth_bias": 0.0, "depth_slope": 1e300, "best": 255, "unseen": (255, 0, 255)},
        ),
        ("least", {"threshold": 0.0, "depth_bias": 5e-324, "best": 1, "unseen": (0, 0, 0)}),
        ("blend_1", {"blend": 1, "inset": 0.004}),
    ):
        valid(
            f"texturing_{name}",
            f"Constants of texturing: {fields or 'the defaults, without TEXR'}.",
            "17.5",
            lambda fields=fields: texturing(fields),
        )


def texturing(fields):
    s = opened()
    if fields is not None:
        s.chunk("TEXR", payloads.texturing(**fields))
    group(s, 0)
    s.finish()
    return s


def delta():
    s = opened(*TRACKS)
    for start in 0, 4:
        motion = Motion(GRID)
        s.begin(start, start + 3)
        s.chunk("MESH", meshes.raw(GRID), 1, start, True)
        s.chunk("COLR", colours.payload(GRID, smooth if start else wild), TRACK, start, True)
        for time in 1, 2:
            s.chunk("MESH", motion.frame(moved(GRID.positions, 3 * time)), 1, start + time)
        s.end()
    s.finish()
    return s


def some_keys():
    s = opened(*TRACKS)
    s.begin(0, 4)
    for time in range(4):
        s.chunk("MESH", meshes.raw(GRID.moved(time)), 1, time, True)
        if time in (0, 2):
            s.chunk("COLR", colours.payload(GRID.moved(time), smooth), TRACK, time, True)
    s.end()
    s.finish()
    return s


def two_meshes():
    s = opened(
        *TRACKS, (2, payloads.track(payloads.MESH, "ball")), (9, payloads.track(payloads.COLOURS, "ball"))
    )
    s.begin(0, 1)
    s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
    s.chunk("MESH", meshes.raw(BALL), 2, 0, True)
    s.chunk("COLR", colours.payload(GRID, smooth), TRACK, 0, True)
    s.chunk("COLR", colours.payload(BALL, smooth, size=100, mesh_track=2), 9, 0, True)
    s.end()
    s.finish()
    return s


def fault(name, title, issue, payload, clauses="19.1", shape=GRID, key=True, with_mesh=True):
    """After a good frame; a good group follows."""

    def make():
        s = opened(*TRACKS)
        s.begin(0, 4)
        s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
        s.chunk("COLR", colours.payload(GRID, smooth), TRACK, 0, True)
        if with_mesh:
            s.chunk("MESH", meshes.raw(shape), 1, 2, True)
        s.chunk("COLR", payload, TRACK, 2, key, fault=issue)
        s.end()
        s.begin(4, 5)
        s.chunk("MESH", meshes.raw(GRID), 1, 4, True)
        s.chunk("COLR", colours.payload(GRID, smooth), TRACK, 4, True)
        s.end()
        s.finish()
        return s

    faulty(f"colours_{name}", title, clauses, make)


def faults():
    good = colours.payload(GRID, smooth)

    def header(field, value):
        return patched(good, "COLR payload", field, value)

    fault("header", "A COLR payload of 15 bytes.", 6201, good[:15])
    for field, value in (
        ("luma_step", 0),
        ("luma_step", 65),
        ("chroma_step", 0),
        ("chroma_step", 255),
        ("cell_size", 0),
        ("cell_size", 2**24 + 1),
    ):
        fault(f"{field}_{value}", f"{field} is {value}.", 6201, header(field, value))
    fault("no_key", "A COLR chunk does not have the key flag.", 6201, good, key=False)
    fault(
        "vertex_count",
        "COLR has a vertex less than its mesh.",
        6202,
        header("vertex_count", len(GRID.positions) - 1),
    )
    fault("mesh_track", "COLR names a track that is no mesh track.", 6202, header("mesh_track", TRACK))
    fault("mesh_undeclared", "COLR names a track that does not exist.", 6202, header("mesh_track", 77))
    fault("no_mesh", "There is no mesh at the time of COLR.", 6202, good, with_mesh=False)
    faulty("colours_of_delta", "COLR is at the time of a delta frame.", "19.1", of_delta)
    cells = len(colours.occupied(GRID.positions, 20))
    fault(
        "cells_more",
        "COLR counts a cell more than its mesh occupies.",
        6203,
        header("cell_count", cells + 1),
        "19.2",
    )
    fault(
        "cells_less",
        "COLR counts a cell less than its mesh occupies.",
        6203,
        header("cell_count", cells - 1),
        "19.2",
    )
    fault("cells_zero", "COLR has no cell.", 6203, header("cell_count", 0), "19.2")
    fault("cells_many", "COLR has 65,537 cells.", 6203, header("cell_count", 65537), "19.2")
    far = meshes.Shape([(0, 0, 0), (0, 1022, 0), (5, 0, 0)], [(0, 1, 2)])
    fault("extent", "Cells are 1,022 apart.", 6203, colours.payload(far, smooth, size=1), "19.2", far)
    fault("stream_longer", "The data has a byte more than the cells use.", 6204, good + b"\1", "19.3")
    fault("stream_shorter", "The data lacks its last byte.", 6204, good[:-1], "19.3")
    fault("stream_empty", "There is no data.", 6204, good[:16], "19.3")
    for name, value in ("above", (512, 0, 0)), ("below", (0, 0, -512)):
        fault(
            f"value_{name}",
            f"A cell has the values {value}.",
            6204,
            colours.payload(
                GRID, lambda cell, value=value: value if cell == (1, 1, 0) else (0, 0, 0), luma_step=1
            ),
            "19.3",
        )


def of_delta():
    s = opened(*TRACKS)
    s.begin(0, 3)
    motion = Motion(GRID)
    s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
    s.chunk("MESH", motion.frame(moved(GRID.positions, 1)), 1, 1)
    s.chunk("COLR", colours.payload(GRID, smooth), TRACK, 1, True, fault=6202)
    s.end()
    group(s, 3)
    s.finish()
    return s


whole()
faults()
