"""Whole and faulty patched frames, and their colours and visibility: clauses 8.14, 17 and 19."""

import copy
import struct

from reference.container import uleb128

from .. import colours, media, meshes, payloads
from ..case import faulty, valid
from ..patches import Patches, cut
from ..recipes import between, opened
from ..weights import Weights
from .colour_cases import TRACK as COLOUR_TRACK
from .colour_cases import TRACKS as COLOUR_TRACKS
from .colour_cases import smooth
from .mesh_whole import draco_payload, moved
from .visibility_cases import TRACK as SEEN_TRACK
from .visibility_cases import begun, centres, level, seen

GRID = meshes.grid(8, 6)
FULL = meshes.with_normals(meshes.textured(GRID))
SHEET = meshes.grid(20, 14)
HOLE = range(20, 36)


def stream(shape, frames, key=meshes.raw):
    """A group of a key mesh and frames: functions of Patches and of the positions to be reached."""
    s, state = opened(), Patches(shape)
    s.begin(0, len(frames) + 1)
    s.chunk("MESH", key(shape), 1, 0, True)
    for time, make in enumerate(frames, 1):
        s.chunk("MESH", make(state, moved(state.positions(), 1)), 1, time)
    s.end()
    s.finish()
    return s


def out(faces=HOLE, lifted=0, coded=meshes.raw, steps=4):
    """A frame in which a patch, lifted by some steps, is in the place of faces. steps: quarters, of the motion."""

    def make(state, target):
        patch = cut(state.key, target, faces).moved(z=lifted)
        return state.patched(target, faces, patch, coded, steps)

    return make


def plain(state, target):
    return state.frame(target)


def finer(state, target):
    return state.frame(target, 3)


def hole(state, target):
    return state.patched(target, HOLE)


def added(state, target):
    return state.patched(target, (), meshes.TETRAHEDRON)


def coded_by_draco(state, target):
    ball = meshes.Shape(*media.draco_decoded("ball_decoded"))
    return state.patched(target, HOLE, ball, lambda _: draco_payload("ball_decoded"))


def everything(state, target):
    return state.patched(target, range(len(state.key.faces)), meshes.OCTAHEDRON)


def all_of_sheet(state, target):
    return state.patched(target, range(len(state.key.faces)), SHEET)


def seamed():
    """The grid in two halves, with vertices of their own on the same points where they meet."""
    halves = [cut(GRID, GRID.positions, faces) for faces in (range(34), range(34, len(GRID.faces)))]
    first = len(halves[0].positions)
    faces = halves[0].faces + [tuple(first + v for v in face) for face in halves[1].faces]
    return GRID._replace(positions=halves[0].positions + halves[1].positions, faces=faces)


def unchanged(state, target):
    return state.patched(target)


def whole():
    def case(name, title, *frames, shape=GRID, key=meshes.raw):
        valid(f"patched_{name}", title, "8.14 8.7", lambda: stream(shape, frames, key))

    case("one", "A patch in the place of 16 faces of a sheet.", out())
    case(
        "moves",
        "Patches one after the other, in other places.",
        out(),
        out(range(18, 30)),
        out([*range(4), *range(40, 44)], 3),
        out(range(40, 44)),
    )
    case(
        "of_patch",
        "Patched frames leave out some and all of the faces of the patch before.",
        out(),
        out(range(60, 70), 2),
        out(range(60, 70)),
        plain,
        out([*range(5), *range(58, 64)]),
        plain,
    )
    case("plain_between", "Delta frames move the mesh with its patches.", out(), plain, out(), plain, plain)
    case(
        "seam",
        "Patches across a seam: twins that remain, and some whose node is dropped.",
        plain,
        out(range(30, 40)),
        plain,
        out(range(28, 36), 1),
        plain,
        shape=seamed(),
    )
    case(
        "fractions",
        "States between the steps of the lattice, which twins in a patch have from their nodes.",
        finer,
        out(steps=3),
        finer,
        out(range(50, 66), steps=3),
        finer,
        finer,
        shape=seamed(),
    )
    case(
        "levels",
        "Patched frames with fewer levels than the mesh before, and with more.",
        plain,
        everything,
        plain,
        all_of_sheet,
        plain,
        out(range(90, 140)),
        plain,
        shape=SHEET,
    )
    case("hole", "Faces are left out, and there is no patch.", hole, hole)
    case("added", "A patch is added, and no face is left out.", added)
    case("everything", "All faces are left out.", everything, plain)
    case("unchanged", "A patched frame without a patch that leaves nothing out.", unchanged, plain)
    case("first_face", "The first run has no face.", out(range(3)), out(range(1)))
    case("last_face", "The last face is left out.", out([len(GRID.faces) - 1]))
    case(
        "full",
        "Texture coordinates and sent normals of key mesh and patches.",
        out(),
        plain,
        out(range(8)),
        plain,
        out(range(50, 66), 4),
        plain,
        shape=FULL,
    )
    case(
        "fast",
        "A patch in the fast profile, after a fast mesh.",
        out(coded=meshes.fast),
        shape=sorted_grid(),
        key=meshes.fast,
    )
    case("draco", "A patch in the Draco profile, after a raw mesh.", coded_by_draco, plain)
    valid("patched_groups", "Two groups, each with patched frames of its own.", "8.14 6.2", groups)


def sorted_grid():
    return GRID._replace(faces=meshes.index_stream(GRID.faces)[1])


def groups():
    s = opened()
    for start in 0, 3:
        state = Patches(GRID)
        s.begin(start, start + 3)
        s.chunk("MESH", meshes.raw(GRID), 1, start, True)
        for time in 1, 2:
            s.chunk("MESH", out()(state, moved(state.positions(), 1)), 1, start + time)
        s.end()
    s.finish()
    return s


def coloured(texr=None, of_patch=(True, False, True)):
    """Key mesh, patched frames with and without colours of their patch, delta frames between them. The third one leaves
    out faces of the patches before."""
    s = opened(*COLOUR_TRACKS)
    if texr:
        s.chunk("TEXR", texr)
    state = Patches(GRID)
    s.begin(0, 2 * len(of_patch) + 1)
    s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
    s.chunk("COLR", colours.payload(GRID, smooth), COLOUR_TRACK, 0, True)
    for i, own in enumerate(of_patch):
        time, target = 2 * i + 1, moved(state.positions(), 1)
        faces = range(12), range(10, 22), range(50, 64)
        patch = cut(state.key, target, faces[i])
        s.chunk("MESH", state.patched(target, faces[i], patch), 1, time)
        if own:
            s.chunk("COLR", colours.payload(patch, lambda c: smooth(c)[::-1]), COLOUR_TRACK, time, True)
        s.chunk("MESH", state.frame(moved(state.positions(), 1)), 1, time + 1)
    s.end()
    s.finish()
    return s


def ball_with_patch():
    """A ball 1 m above the ground that moves. Its side is replaced in frame 1 by a patch that stands out, and the top of
    that in frame 2 by another. For players: render/vectors.py draws frame 2."""
    ball = meshes.ball(24, 36, 700).moved(y=900)
    s, state = opened(*COLOUR_TRACKS), Patches(ball)
    s.begin(0, 3)
    s.chunk("MESH", meshes.raw(ball), 1, 0, True)
    s.chunk(
        "COLR", colours.payload(ball, lambda c: (24 + c[1] % 20, c[0], c[2]), size=100), COLOUR_TRACK, 0, True
    )
    for time in 1, 2:
        moving = state.shape().moved(x=40)
        faces = [
            i
            for i, face in enumerate(moving.faces)
            if all(moving.positions[v][2] > 350 and moving.positions[v][1] > 700 + 200 * time for v in face)
        ]
        patch = cut(moving, moving.positions, faces)
        out = [(x, y, z + (y - 900) // 4) for x, y, z in patch.positions]
        patch = patch._replace(positions=out)
        s.chunk("MESH", state.patched(moving.positions, faces, patch), 1, time)
        own = colours.payload(patch, lambda c, t=time: (44, -8 + c[0] % 4, 18 - 12 * t), size=100)
        s.chunk("COLR", own, COLOUR_TRACK, time, True)
    s.end()
    s.finish()
    return s


def only_patch_coloured():
    s = opened(*COLOUR_TRACKS)
    state, target = Patches(GRID), moved(GRID.positions, 1)
    patch = cut(GRID, target, HOLE)
    s.begin(0, 2)
    s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
    s.chunk("MESH", state.patched(target, HOLE, patch), 1, 1)
    s.chunk("COLR", colours.payload(patch, smooth), COLOUR_TRACK, 1, True)
    s.end()
    s.finish()
    return s


def coloured_cases():
    valid("patched_colours", "Patches with colours, and one without.", "8.14 19.1", coloured)
    texr = payloads.texturing(unseen=(200, 100, 50))
    valid(
        "patched_unseen",
        "A patch without colours, and a colour of what is not seen.",
        "8.14 17.5 19.1",
        lambda: coloured(texr),
    )
    valid("patched_only_colours", "A patch with colours; its key mesh has none.", "19.1", only_patch_coloured)

    def wrong(name, title, make):
        def middle(s):
            state, target = Patches(GRID), moved(GRID.positions, 1)
            patch = cut(GRID, target, HOLE)
            s.begin(2, 6)
            s.chunk("MESH", meshes.raw(GRID), 1, 2, True)
            s.chunk("COLR", colours.payload(GRID, smooth), COLOUR_TRACK, 2, True)
            make(s, state, target, patch)
            s.end()

        faulty(name, title, "8.14 19.1", lambda: between(middle, *COLOUR_TRACKS))

    def of_key(s, state, target, patch):
        s.chunk("MESH", state.patched(target, HOLE, patch), 1, 3)
        s.chunk("COLR", colours.payload(GRID, smooth), COLOUR_TRACK, 3, True, fault=6202)

    def of_none(s, state, target, patch):
        s.chunk("MESH", state.patched(target, HOLE), 1, 3)
        s.chunk("COLR", colours.payload(patch, smooth), COLOUR_TRACK, 3, True, fault=6202)

    wrong("patched_colours_of_key", "Colours of a patched frame have the vertices of its key mesh.", of_key)
    wrong("patched_colours_of_none", "Colours of a patched frame without a patch.", of_none)


def visible(wrong=False):
    """VISI of a key mesh, of patched frames and of the delta frames after them, whose chunks go on. wrong: that of the
    first patched one has the vertices of the key mesh."""
    s, state = begun(), Patches(GRID)
    s.begin(0, 5)
    weights = None
    for time in range(5):
        target = moved(state.positions(), 3)
        if time == 0:
            payload = meshes.raw(GRID)
        elif time % 2:
            payload = state.patched(target, HOLE, cut(state.key, target, HOLE))
        else:
            payload = state.frame(target)
        s.chunk("MESH", payload, 1, time, time == 0)
        shape, key = state.shape(), time == 0 or time % 2 == 1
        fault = {"fault": 6005} if wrong and time == 1 else {}
        if key:
            weights = Weights(GRID if fault else shape)
        seen_at = weights.chunk(centres(0, 1, 7), seen, level, positions=None if key else shape.positions)
        s.chunk("VISI", seen_at, SEEN_TRACK, time, key, **fault)
    s.end()
    s.finish()
    return s


def fault(name, title, issue, change, shape=GRID, clauses="8.14"):
    """A key mesh, a good patched frame, then the payload of change(state, target, patch), then a delta frame."""

    def middle(s):
        state = Patches(shape)
        s.begin(2, 9)
        s.chunk("MESH", meshes.raw(shape), 1, 2, True)
        s.chunk("MESH", out()(state, moved(shape.positions, 1)), 1, 3)
        target = moved(state.positions(), 1)
        s.chunk("MESH", change(state, target, cut(state.key, target, HOLE)), 1, 4, fault=issue)
        s.chunk("MESH", state.frame(moved(state.positions(), 1)), 1, 5)
        s.end()

    faulty(f"patched_{name}", title, clauses, lambda: between(middle))


def with_(**change):
    return lambda state, target, patch: state.patched(target, HOLE, patch, **change)


def with_data(change):
    """Other bytes of the patch."""
    return lambda state, target, patch: state.patched(target, HOLE, patch, data=change(meshes.raw(patch)))


def spoilt(at, value):
    return with_data(lambda data: data[:at] + bytes([value]) + data[at + 1 :])


def with_counts(vertices=0, faces=0):
    def make(state, target, patch):
        payload = state.patched(target, HOLE, patch)
        counts = struct.pack("<2I", len(state.key.positions) + vertices, len(state.key.faces) + faces)
        return payload[:4] + counts + payload[12:]

    return make


def faults():
    count = len(GRID.faces)
    fault(
        "sizes_beyond",
        "The runs are said to be longer than the payload.",
        3033,
        with_(sizes=uleb128(10000) + uleb128(0)),
    )
    fault(
        "patch_beyond",
        "The patch is said to be longer than the payload.",
        3033,
        with_(sizes=uleb128(1) + uleb128(10000)),
    )
    fault("sizes_huge", "Sizes of 2^64 - 1.", 3033, with_(sizes=2 * uleb128(2**64 - 1)))
    fault(
        "sizes_overlong",
        "A size is not in its shortest form.",
        3033,
        with_(sizes=b"\x81\0\0"),
        clauses="2.3 8.14",
    )
    fault(
        "cut",
        "A patched frame has nothing after its header.",
        3033,
        lambda s, t, p: s.patched(t, HOLE, p)[:16],
    )
    fault("runs_short", "The runs have a face less than the base mesh.", 3034, with_(lengths=[count - 1]))
    fault("runs_long", "The runs have a face more than the base mesh.", 3034, with_(lengths=[count + 1]))
    fault("runs_huge", "A run of 2^64 - 1 faces.", 3034, with_(lengths=[1, 2**64 - 1]))
    fault("runs_none", "There are no runs.", 3034, with_(lengths=[]))
    fault("run_empty", "The second run has no face.", 3034, with_(lengths=[5, 0, count - 5]))
    fault("run_empty_last", "The last run has no face.", 3034, with_(lengths=[count, 0]))
    fault(
        "run_overlong",
        "A run is not in its shortest form.",
        3034,
        with_(lengths=bytes([count | 128, 0])),
        clauses="2.3 8.14",
    )
    fault("run_cut", "The last run is cut.", 3034, with_(lengths=bytes([count | 128])))
    fault("vertices_more", "A vertex more than remains with the patch.", 3035, with_counts(vertices=1))
    fault("vertices_less", "A vertex less than remains with the patch.", 3035, with_counts(vertices=-1))
    fault(
        "vertices_dropped",
        "Vertices that no face uses any more are counted.",
        3035,
        lambda s, t, p: s.patched(t, HOLE, p, vertex_count=len(s.key.positions) + len(p.positions)),
    )
    fault("no_face", "All faces are left out, and there is no patch.", 3003, nothing_left)
    fault("faces_less", "A face less than remains with the patch.", 3035, with_counts(faces=-1))
    fault(
        "faces_of_key",
        "Another count of faces, although the runs leave none out.",
        3035,
        with_(lengths=[count]),
    )
    for profile, what in (2, "delta"), (3, "field"), (5, "patched"), (77, "unknown"):
        fault(f"patch_{what}", f"The profile of a patch is {profile}, {what}.", 3036, spoilt(0, profile))
    fault(
        "patch_attributes",
        "A patch has texture coordinates, its base mesh has none.",
        3036,
        lambda s, t, p: s.patched(t, HOLE, p, data=meshes.raw(meshes.textured(p))),
    )
    fault("patch_bits", "A patch has other texture bits than its base mesh.", 3036, spoilt(2, 9), FULL)
    fault("patch_normal_bits", "A patch has other normal bits than its base mesh.", 3036, spoilt(3, 3), FULL)
    fault("patch_header", "The header of a patch is cut.", 3001, with_data(lambda data: data[:15]))
    fault("patch_reserved", "A reserved field of the header of a patch is not 0.", 3001, spoilt(12, 1))
    fault("patch_size", "A raw patch lacks its last byte.", 3004, with_data(lambda data: data[:-1]))
    fault(
        "patch_index",
        "A face of a patch uses a vertex of the base mesh.",
        3005,
        with_data(lambda data: data[:-12] + bytes([len(GRID.positions)]) + data[-11:]),
    )
    fault("patch_lattice", "A vertex of a patch is outside the lattice.", 3006, spoilt(19, 0x11))
    fault(
        "number",
        "The number of a patched frame is that of the frame before.",
        3019,
        lambda s, t, p: renumbered(s, t, p),
    )


def nothing_left(state, target, patch):
    return copy.deepcopy(state).patched(target, range(len(state.key.faces)))


def renumbered(state, target, patch):
    state.number -= 1
    return state.patched(target, HOLE, patch)


whole()
coloured_cases()
valid(
    "patched_visibility",
    "Visibility of patched frames, their patches included, and of the frames after them.",
    "8.14 17.1",
    visible,
)
faulty(
    "patched_visibility_of_key",
    "Visibility of a patched frame has the vertices of its key mesh.",
    "8.14 17.1",
    lambda: visible(True),
)
faults()
