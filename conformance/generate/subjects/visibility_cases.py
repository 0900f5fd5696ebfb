"""Whole and faulty visibility: clause 17."""

from .. import meshes, payloads
from ..case import faulty, valid
from ..motion import Motion
from ..recipes import frame, opened
from ..weights import Weights, above
from .mesh_whole import moved

TRACK, MOTION = 4, 3
TRACKS = [(1, payloads.track(payloads.MESH, "mesh")), (TRACK, payloads.track(payloads.VISIBILITY, "seen"))]
BALL = meshes.ball(8, 12)
GRID = meshes.grid(9, 8)
PLACES = {0: (0.0, 0.0, 2.0), 1: (1.0, 0.5, 1.5), 7: (-1.0, 0.3, 1.0)}


def centres(*cameras):
    return {camera: above(*PLACES[camera]) for camera in cameras}


def begun(cameras=(0, 1, 7), tracks=TRACKS, scene=None):
    s = opened(*tracks, scene=scene)
    for camera in cameras:
        s.chunk("CAMR", payloads.camera(camera, centre=PLACES[camera]))
    return s


def seen(camera, vertex):
    return (vertex * 7 + camera) % 11 > 2


def patches(camera, vertex):
    return (vertex // 9 + camera) % 3 != 0


def level(camera, vertex):
    return 1 + (vertex + camera) % 3


def one(name, title, shape=BALL, cameras=(0, 1, 7), frames=1, tracks=TRACKS, **chunk):
    def make():
        s = begun(cameras, tracks)
        weights = Weights(shape)
        chunk_fields = {"seen": seen} | chunk
        s.begin(0, frames)
        for time in range(frames):
            s.chunk("MESH", meshes.raw(shape), 1, time, True)
            payload = weights.chunk(centres(*cameras), **chunk_fields)
            s.chunk("VISI", payload, TRACK, time, weights.number == 0)
        s.end()
        s.finish()
        return s

    valid(f"visibility_{name}", title, "17.1 17.3", make)


def whole():
    one("one_camera", "One camera.", cameras=(0,))
    one("three_cameras", "Three cameras, of which some vertices face none.")
    one("tetrahedron", "Four vertices.", meshes.TETRAHEDRON)
    one("all_seen", "Everything that faces a camera is seen.", seen=lambda c, v: 1)
    one("none_seen", "Nothing is seen.", seen=lambda c, v: 0)
    one("blind", "Streams of size 0.", blind=(0, 7))
    one(
        "patches",
        "Patches of a sheet, with levels 1 to 3 at their outlines.",
        GRID,
        seen=patches,
        level=level,
    )
    one("level_3", "All levels are 3.", GRID, level=lambda c, v: 3)
    for threshold in 0, 1, 128, 255:
        one(f"threshold_{threshold}", f"The least cosine is {threshold}/256.", threshold=threshold)
    one("former", "Chunks after a key use the states before.", GRID, frames=4, seen=patches, level=level)
    one("pieces", "A mesh of several pieces.", meshes.strip(20))
    one(
        "backfacing",
        "A camera that no vertex faces.",
        meshes.Shape(GRID.positions, [f[::-1] for f in GRID.faces]),
    )
    valid(
        "visibility_delta",
        "Visibility of delta frames: facing changes with the positions.",
        "17.2 17.3",
        delta,
    )
    valid("visibility_two_tracks", "Two tracks share the cameras of one mesh.", "17.1", two_tracks)
    valid("visibility_two_meshes", "Visibility of two mesh tracks.", "17.1", two_meshes)
    valid("visibility_some_frames", "Some frames have no VISI.", "17.1", some_frames, requirements=(9018,))
    valid(
        "visibility_cameras_change",
        "Cameras appear and disappear between chunks.",
        "17.1 17.3",
        cameras_change,
    )
    valid("visibility_key_later", "A key chunk in the middle of a group.", "17.1", key_later)
    valid("visibility_moving", "A camera that moves, calibrated at two of three times.", "17.1 17.2", moving)
    valid("visibility_far", "Cameras at the end of the lattice.", "17.2", far)


def delta():
    s = begun()
    motion, weights = Motion(GRID), Weights(GRID)
    s.begin(0, 4)
    for time in range(4):
        if time:
            s.chunk("MESH", motion.frame(moved(GRID.positions, 5 * time)), 1, time)
        else:
            s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
        payload = weights.chunk(centres(0, 1, 7), patches, level, positions=motion.positions(), threshold=200)
        s.chunk("VISI", payload, TRACK, time, time == 0)
    s.end()
    s.finish()
    return s


def two_tracks():
    s = begun(tracks=[*TRACKS, (5, payloads.track(payloads.VISIBILITY, "more"))])
    first, second = Weights(BALL), Weights(BALL)
    s.begin(0, 2)
    for time in range(2):
        s.chunk("MESH", meshes.raw(BALL), 1, time, True)
        s.chunk("VISI", first.chunk(centres(0, 7), seen), 4, time, time == 0)
        s.chunk("VISI", second.chunk(centres(1), seen), 5, time, time == 0)
    s.end()
    s.finish()
    return s


def two_meshes():
    s = begun(
        tracks=[
            *TRACKS,
            (2, payloads.track(payloads.MESH, "ball")),
            (5, payloads.track(payloads.VISIBILITY, "2")),
        ]
    )
    s.begin(0, 1)
    s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
    s.chunk("MESH", meshes.raw(BALL), 2, 0, True)
    s.chunk("VISI", Weights(GRID).chunk(centres(0, 1), seen), 4, 0, True)
    s.chunk("VISI", Weights(BALL, 2).chunk(centres(1, 7), seen), 5, 0, True)
    s.end()
    s.finish()
    return s


def some_frames():
    s = begun()
    weights = Weights(BALL)
    s.begin(0, 4)
    for time in range(4):
        s.chunk("MESH", meshes.raw(BALL), 1, time, True)
        if time in (1, 3):
            s.chunk("VISI", weights.chunk(centres(0), seen), TRACK, time, time == 1)
    s.end()
    s.finish()
    return s


def cameras_change():
    s = begun()
    weights = Weights(GRID)
    s.begin(0, 4)
    for time, cameras in enumerate([(0,), (0, 7), (1, 7), (0, 1)]):
        s.chunk("MESH", meshes.raw(GRID), 1, time, True)
        s.chunk("VISI", weights.chunk(centres(*cameras), patches, level), TRACK, time, time == 0)
    s.end()
    s.finish()
    return s


def key_later():
    s = begun()
    weights = Weights(GRID)
    s.begin(0, 4)
    for time in range(4):
        s.chunk("MESH", meshes.raw(GRID), 1, time, True)
        key = time in (0, 2)
        s.chunk("VISI", weights.chunk(centres(0, 1), patches, level, key=key), TRACK, time, key)
    s.end()
    s.finish()
    return s


MOVING = [*TRACKS, (MOTION, payloads.track(payloads.CALIBRATION, "motion"))]


def moving_begun():
    s = opened(*MOVING)
    s.chunk("CAMR", payloads.camera(0, centre=PLACES[0]))
    s.chunk("CAMR", payloads.camera(5, flags=1))
    return s


def moving():
    """Centres of the moving camera are whole sixteenths of a metre above the origin."""
    s = moving_begun()
    weights, before = Weights(BALL), {}
    s.begin(0, 3)
    for time in range(3):
        s.chunk("MESH", meshes.raw(BALL), 1, time, True)
        cameras = centres(0)
        if time != 1:
            entry = [(5, payloads.moving_values(centre=(4 * time, 0, 32)))]
            cameras[5] = above(0.25 * time, 0.0, 2.0)
        else:
            entry = []
        s.chunk("CALB", payloads.calibration(time, entry, before), MOTION, time, time == 0)
        s.chunk("VISI", weights.chunk(cameras, seen), TRACK, time, time == 0)
    s.end()
    s.finish()
    return s


def far():
    s = opened(*TRACKS)
    place = (-(2**28) * 0.001, 2**28 * 0.001, 2**28 * 0.001)
    s.chunk("CAMR", payloads.camera(0, centre=place))
    s.begin(0, 1)
    s.chunk("MESH", meshes.raw(BALL), 1, 0, True)
    s.chunk("VISI", Weights(BALL).chunk({0: above(*place)}, seen), TRACK, 0, True)
    s.end()
    s.finish()
    return s


def fault(name, title, issue, write, clauses="17.1", cameras=(0, 1, 7), key=True, shape=GRID):
    """Good frames at 0 and 1, then at 2 what write(weights) returns, with or without the key flag."""

    def make():
        s = begun(cameras)
        weights = Weights(shape)
        s.begin(0, 5)
        for time in range(3):
            s.chunk("MESH", meshes.raw(shape), 1, time, True)
            if time < 2:
                s.chunk("VISI", weights.chunk(centres(0, 1), patches), TRACK, time, time == 0)
        s.chunk("VISI", write(weights), TRACK, 2, key, fault=issue)
        frame(s, 3)
        s.end()
        s.begin(5, 6)
        s.chunk("MESH", meshes.raw(shape), 1, 5, True)
        s.chunk("VISI", Weights(shape).chunk(centres(0, 7), patches), TRACK, 5, True)
        s.end()
        s.finish()
        return s

    faulty(f"visibility_{name}", title, clauses, make)


def faults():
    def key(**change):
        return lambda w: w.chunk(centres(0, 1), patches, key=True, **change)

    def later(**change):
        return lambda w: w.chunk(centres(0, 1), patches, **change)

    fault("header", "A VISI payload of 15 bytes.", 6001, lambda w: key()(w)[:15])
    fault("header_empty", "A VISI payload of 0 bytes.", 6001, lambda w: b"")
    fault("reserved", "The reserved byte of VISI is 1.", 6001, key(reserved=1))
    fault(
        "camera_unknown",
        "VISI has a camera that does not exist.",
        6003,
        lambda w: w.chunk({0: above(*PLACES[0]), 3: above(*PLACES[1])}, patches, key=True),
    )
    fault("camera_repeated", "VISI has a camera twice.", 6003, key(table=lambda t: [t[0], (0, t[1][1])]))
    fault("camera_beyond", "VISI has the camera 65536.", 6003, key(table=lambda t: [t[0], (65536, t[1][1])]))
    fault(
        "camera_overflow",
        "Identifiers of VISI pass 2^64.",
        6003,
        key(table=lambda t: [(1, t[0][1]), (2**64 - 1, t[1][1])]),
    )
    fault(
        "size_long",
        "The sizes of the streams are more than the payload.",
        6004,
        key(table=lambda t: [t[0], (t[1][0], t[1][1] + 1)]),
    )
    fault("size_huge", "A stream has 2^64 - 1 bytes.", 6004, key(table=lambda t: [(0, 2**64 - 1), t[1]]))
    fault("no_camera", "VISI has no camera.", 6004, lambda w: w.chunk({}, patches, key=True))
    fault(
        "pairs_missing",
        "VISI counts two cameras and has a pair for one.",
        6004,
        lambda w: w.chunk(centres(0), patches, key=True, blind=(0,), camera_count=2),
    )
    fault(
        "overlong",
        "A number of VISI is not in its shortest form.",
        6004,
        key(table=lambda t: [(b"\x80\0", t[0][1]), t[1]]),
    )
    fault("mesh_track", "VISI names a track that is no mesh track.", 6005, key(mesh_track=TRACK))
    fault("mesh_undeclared", "VISI names a track that does not exist.", 6005, key(mesh_track=99))
    fault(
        "vertex_count",
        "VISI has a vertex more than its mesh.",
        6005,
        key(vertex_count=len(GRID.positions) + 1),
    )
    faulty("visibility_no_mesh", "There is no mesh at the time of VISI.", "17.1", no_mesh)
    faulty("visibility_before_mesh", "VISI comes before its mesh.", "17.1", before_mesh)
    fault("number_of_key", "A key chunk has the number 1.", 6006, key(number=1))
    fault("number_zero", "A chunk without the key flag has the number 0.", 6006, later(number=0), key=False)
    fault("number_skipped", "A chunk has the number 3 after 1.", 6006, later(number=3), key=False)
    fault("number_greatest", "A chunk has the number 2^32 - 1.", 6006, later(number=2**32 - 1), key=False)
    fault(
        "stream_longer",
        "A stream has a byte more than its decisions use.",
        6007,
        key(streams=lambda b: b + b"\1"),
        "17.3",
    )
    fault("stream_shorter", "A stream lacks its last byte.", 6007, key(streams=lambda b: b[:-1]), "17.3")
    fault(
        "stream_zeros",
        "Streams end with more zero bytes than are left out.",
        6007,
        key(streams=lambda b: b + bytes(4)),
        "17.3",
    )
    faulty("visibility_beyond_lattice", "The centre of a camera is beyond the lattice.", "17.1 17.2", beyond)
    faulty(
        "visibility_not_calibrated",
        "A camera that moves has a stream and no calibration at that time.",
        "17.1",
        not_calibrated,
    )
    faulty(
        "visibility_calibrated_later",
        "The calibration of a moving camera comes after VISI.",
        "17.1",
        calibrated_later,
    )
    faulty(
        "visibility_track_changes",
        "A chunk without the key flag names another mesh track.",
        "17.1",
        track_changes,
    )


def ending(s, time):
    s.begin(time, time + 1)
    s.chunk("MESH", meshes.raw(GRID), 1, time, True)
    s.chunk("VISI", Weights(GRID).chunk(centres(0), patches), TRACK, time, True)
    s.end()
    s.finish()
    return s


def no_mesh():
    s = begun()
    s.begin(0, 2)
    s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
    s.chunk("VISI", Weights(GRID).chunk(centres(0, 1), patches), TRACK, 1, True, fault=6005)
    s.end()
    return ending(s, 2)


def before_mesh():
    s = begun()
    s.begin(0, 2)
    s.chunk("VISI", Weights(GRID).chunk(centres(0, 1), patches), TRACK, 0, True, fault=6005)
    s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
    s.end()
    return ending(s, 2)


def beyond():
    s = opened(*TRACKS)
    place = ((2**28 + 1) * 0.001, 0.0, 0.0)
    s.chunk("CAMR", payloads.camera(0, centre=PLACES[0]))
    s.chunk("CAMR", payloads.camera(1, centre=place))
    s.begin(0, 1)
    s.chunk("MESH", meshes.raw(GRID), 1, 0, True)
    s.chunk("VISI", Weights(GRID).chunk({1: above(*place)}, patches), TRACK, 0, True, fault=6003)
    s.end()
    return ending(s, 1)


def not_calibrated():
    s = moving_begun()
    weights, before = Weights(BALL), {}
    s.begin(0, 3)
    entry = [(5, payloads.moving_values(centre=(0, 0, 32)))]
    for time in range(2):
        s.chunk("MESH", meshes.raw(BALL), 1, time, True)
        s.chunk(
            "CALB", payloads.calibration(time, entry if time == 0 else [], before), MOTION, time, time == 0
        )
        payload = weights.chunk(centres(0) | {5: above(0.0, 0.0, 2.0)}, seen)
        s.chunk("VISI", payload, TRACK, time, time == 0, fault=6003 if time else None)
    s.end()
    s.finish()
    return s


def calibrated_later():
    s = moving_begun()
    s.begin(0, 2)
    s.chunk("MESH", meshes.raw(BALL), 1, 0, True)
    s.chunk("VISI", Weights(BALL).chunk({5: above(0.0, 0.0, 2.0)}, seen), TRACK, 0, True, fault=6003)
    entry = [(5, payloads.moving_values(centre=(0, 0, 32)))]
    s.chunk("CALB", payloads.calibration(0, entry), MOTION, 0, True)
    s.end()
    s.finish()
    return s


def track_changes():
    s = begun(tracks=[*TRACKS, (2, payloads.track(payloads.MESH, "second"))])
    weights = Weights(GRID)
    s.begin(0, 2)
    for time in range(2):
        for track in 1, 2:
            s.chunk("MESH", meshes.raw(GRID), track, time, True)
        payload = weights.chunk(centres(0), patches, mesh_track=1 + time)
        s.chunk("VISI", payload, TRACK, time, time == 0, fault=6006 if time else None)
    s.end()
    s.finish()
    return s


whole()
faults()
