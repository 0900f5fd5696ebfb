"""Whole and faulty patched frames, and their colours and visibility: clauses 8.14, 17 and 19."""

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
HOLE = range(20, 36)


def stream(shape, frames, key=meshes.raw):
    """A group of a key mesh and frames: functions of Patches and of the positions to be reached."""
    s, state = opened(), Patches(shape)
    s.begin(0, len(frames) + 1)
    s.chunk("MESH", key(shape), 1, 0, True)
    for time, make in enumerate(frames, 1):
        s.chunk("MESH", make(state, moved(shape.positions, time)), 1, time)
    s.end()
    s.finish()
    return s


def out(faces=HOLE, lifted=0, coded=meshes.raw):
    """A frame in which a patch, lifted by some steps, is in the place of faces."""

    def make(state, target):
        patch = cut(state.key, target, faces).moved(z=lifted)
        return state.patched(target, faces, patch, coded)

    return make


def plain(state, target):
    return state.frame(target)


def hole(state, target):
    return state.patched(target, HOLE)


def added(state, target):
    return state.patched(target, (), meshes.TETRAHEDRON)


def coded_by_draco(state, target):
    ball = meshes.Shape(*media.draco_decoded("ball_decoded"))
    return state.patched(target, HOLE, ball, lambda _: draco_payload("ball_decoded"))


def everything(state, target):
    return state.patched(target, range(len(state.key.faces)), meshes.OCTAHEDRON)


def unchanged(state, target):
    return state.patched(target)


def whole():
    def case(name, title, *frames, shape=GRID, key=meshes.raw):
        valid(f"patched_{name}", title, "8.14 8.7", lambda: stream(shape, frames, key))

    case("one", "A patch in the place of 16 faces of a sheet.", out())
    case(
        "moves",
        "The faces that are left out change from frame to frame.",
        out(),
        out(range(18, 30)),
        out([*range(4), *range(40, 44)], 3),
        out(range(40, 44)),
    )
    case(
        "plain_between", "A delta frame between patched ones leaves nothing out.", out(), plain, out(), plain
    )
    case("hole", "Faces are left out, and there is no patch.", hole, hole)
    case("added", "A patch is added, and no face is left out.", added)
    case("everything", "All faces of the key mesh are left out.", everything, plain)
    case("unchanged", "A patched frame without a patch that leaves nothing out.", unchanged, plain)
    case("first_face", "The first run has no face.", out(range(3)), out(range(1)))
    case("last_face", "The last face is left out.", out([len(GRID.faces) - 1]))
    case(
        "full",
        "Texture coordinates and sent normals of key mesh and patch.",
        out(),
        plain,
        out(range(8)),
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
            s.chunk("MESH", out()(state, moved(GRID.positions, time)), 1, start + time)
        s.end()
    s.finish()
    return s


def coloured(texr=None, of_patch=(True, False, True)):
    """Key mesh, patched frames with and without colours of their patch, delta frames between them."""
    s = opened(*COLOUR_TRACKS)
    if texr:
        s.chunk("TEXR", texr)
    state = Patches(GRID)
    s.begin(0, 2 * len(of_patch) + 1)
    s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
    s.chunk("COLR", colours.payload(GRID, smooth), COLOUR_TRACK, 0, True)
    for i, own in enumerate(of_patch):
        time, target = 2 * i + 1, moved(GRID.positions, i + 1)
        patch = cut(GRID, target, range(10 * i, 10 * i + 12))
        s.chunk("MESH", state.patched(target, range(10 * i, 10 * i + 12), patch), 1, time)
        if own:
            s.chunk("COLR", colours.payload(patch, lambda c: smooth(c)[::-1]), COLOUR_TRACK, time, True)
        s.chunk("MESH", state.frame(target), 1, time + 1)
    s.end()
    s.finish()
    return s


def ball_with_patch():
    """A ball 1 m above the ground that moves, and whose side is replaced in frames 1 and 2 by a patch that stands out. For
    players: render/vectors.py draws frame 2."""
    ball = meshes.ball(24, 36, 700).moved(y=900)
    s, state = opened(*COLOUR_TRACKS), Patches(ball)
    s.begin(0, 3)
    s.chunk("MESH", meshes.raw(ball), 1, 0, True)
    s.chunk(
        "COLR", colours.payload(ball, lambda c: (24 + c[1] % 20, c[0], c[2]), size=100), COLOUR_TRACK, 0, True
    )
    for time in 1, 2:
        moving = ball.moved(x=40 * time)
        faces = [
            i
            for i, face in enumerate(ball.faces)
            if all(ball.positions[v][2] > 350 and ball.positions[v][1] > 700 + 200 * time for v in face)
        ]
        patch = cut(ball, moving.positions, faces)
        out = [(x, y, z + (y - 900) // 4) for x, y, z in patch.positions]
        patch = patch._replace(positions=out)
        s.chunk("MESH", state.patched(moving.positions, faces, patch), 1, time)
        own = colours.payload(patch, lambda c: (44, -8 + c[0] % 4, 6), size=100)
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


def whole_shape(state, target, patch):
    """The mesh of a patched frame, for which HOLE is left out."""
    first = len(state.key.positions)
    kept = [face for i, face in enumerate(state.key.faces) if i not in HOLE]
    faces = kept + [tuple(first + v for v in face) for face in patch.faces]
    return state.key._replace(positions=[*state.positions(), *patch.positions], faces=faces)


def visible(wrong=False):
    """VISI of a key mesh, a patched frame and a delta frame. wrong: the patched one has the vertices of the key mesh."""
    s, state = begun(), Patches(GRID)
    s.begin(0, 3)
    for time in range(3):
        target = moved(GRID.positions, 3 * time)
        patch = cut(GRID, target, HOLE)
        if time == 0:
            payload, shape = meshes.raw(GRID), GRID
        elif time == 1:
            payload = state.patched(target, HOLE, patch)
            shape = GRID if wrong else whole_shape(state, target, patch)
        else:
            payload, shape = state.frame(target), GRID._replace(positions=state.positions())
        s.chunk("MESH", payload, 1, time, time == 0)
        seen_at = Weights(shape).chunk(centres(0, 1, 7), seen, level)
        s.chunk("VISI", seen_at, SEEN_TRACK, time, True, **({"fault": 6005} if wrong and time == 1 else {}))
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
        target = moved(shape.positions, 2)
        s.chunk("MESH", change(state, target, cut(shape, target, HOLE)), 1, 4, fault=issue)
        s.chunk("MESH", state.frame(moved(shape.positions, 3)), 1, 5)
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
        counts = len(GRID.positions) + len(patch.positions), len(GRID.faces) - len(HOLE) + len(patch.faces)
        return state.patched(
            target, HOLE, patch, vertex_count=counts[0] + vertices, face_count=counts[1] + faces
        )

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
    fault("runs_short", "The runs have a face less than the key mesh.", 3034, with_(lengths=[count - 1]))
    fault("runs_long", "The runs have a face more than the key mesh.", 3034, with_(lengths=[count + 1]))
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
    fault("vertices_more", "A vertex more than key mesh and patch have.", 3035, with_counts(vertices=1))
    fault(
        "vertices_of_key",
        "The vertices of the key mesh alone.",
        3035,
        with_(vertex_count=len(GRID.positions)),
    )
    fault("faces_less", "A face less than key mesh and patch have.", 3035, with_counts(faces=-1))
    fault(
        "faces_of_key",
        "Another count of faces, although the runs leave none out.",
        3035,
        with_(lengths=[20, 16, count - 36]),
    )
    for profile, what in (2, "delta"), (3, "field"), (5, "patched"), (77, "unknown"):
        fault(f"patch_{what}", f"The profile of a patch is {profile}, {what}.", 3036, spoilt(0, profile))
    fault(
        "patch_attributes",
        "A patch has texture coordinates, its key mesh has none.",
        3036,
        lambda s, t, p: s.patched(t, HOLE, p, data=meshes.raw(meshes.textured(p))),
    )
    fault("patch_bits", "A patch has other texture bits than its key mesh.", 3036, spoilt(2, 9), FULL)
    fault("patch_normal_bits", "A patch has other normal bits than its key mesh.", 3036, spoilt(3, 3), FULL)
    fault("patch_header", "The header of a patch is cut.", 3001, with_data(lambda data: data[:15]))
    fault("patch_reserved", "A reserved field of the header of a patch is not 0.", 3001, spoilt(12, 1))
    fault("patch_size", "A raw patch lacks its last byte.", 3004, with_data(lambda data: data[:-1]))
    fault(
        "patch_index",
        "A face of a patch uses a vertex of the key mesh.",
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


def renumbered(state, target, patch):
    state.number -= 1
    return state.patched(target, HOLE, patch)


whole()
coloured_cases()
valid("patched_visibility", "Visibility of a patched frame, its patch included.", "8.14 17.1", visible)
faulty(
    "patched_visibility_of_key",
    "Visibility of a patched frame has the vertices of its key mesh.",
    "8.14 17.1",
    lambda: visible(True),
)
faults()
