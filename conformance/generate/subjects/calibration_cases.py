"""Whole and faulty cameras: lens models, and cameras that move. Clause 9."""

import math

from reference.container import uleb128

from .. import payloads
from ..case import faulty, valid
from ..recipes import frame, group, opened

TRACK = 3
MOVES = 1
UNIT = 2**8  # of a quaternion in payloads.BITS
TRACKS = [(1, payloads.track(payloads.MESH, "mesh")), (TRACK, payloads.track(payloads.CALIBRATION, "motion"))]


def still(name, title, *cameras, **more):
    def make():
        s = opened()
        for payload in cameras:
            s.chunk("CAMR", payload)
        group(s, 0)
        s.finish()
        return s

    valid(f"camera_{name}", title, "9.1 9.2", make, **more)


def lenses():
    camera = payloads.camera
    still("pinhole", "A pinhole camera.", camera(0, "pinhole"))
    still(
        "skew",
        "Skew, and different focal lengths.",
        camera(0, fx=20.0, fy=10.0, skew=0.25, cx=-3.5, cy=100.0),
    )
    still("finite_r_max", "A pinhole camera with a finite radius.", camera(0, r_max=2.5))
    still(
        "radtan",
        "All eight coefficients of radtan.",
        camera(0, lens=1, r_max=0.6, distortion=(-0.2, 0.05, 0.001, -0.0005, 0.01, 0.02, 0.003, 0.0001)),
    )
    still("radtan_zero", "Radtan without distortion.", camera(0, lens=1, r_max=1e6))
    still(
        "radtan_rational",
        "A rational lens of which only the denominator bends.",
        camera(0, lens=1, r_max=0.9, distortion=(0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0)),
    )
    still(
        "radtan_fold",
        "r_max just below the fold, at 1 / sqrt(3).",
        camera(0, lens=1, r_max=0.5773502, distortion=(-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
    )
    still(
        "fisheye",
        "All four coefficients of fisheye.",
        camera(0, lens=2, r_max=1.2, distortion=(-0.02, 0.003, -0.0004, 0.00005, 0.0, 0.0, 0.0, 0.0)),
    )
    still("fisheye_wide", "Fisheye up to almost pi / 2.", camera(0, lens=2, r_max=1.5707963267948963))
    still(
        "identifiers", "Identifiers 65534, 0 and 300, in this order.", camera(65534), camera(0), camera(300)
    )
    still(
        "names",
        "Names: empty, equal, and of UTF-8.",
        camera(0, ""),
        camera(1, "north"),
        camera(2, "north"),
        camera(3, "北"),
    )
    still(
        "rotation_not_exact",
        "R deviates from orthonormal by 9e-5: readers use it as it is.",
        camera(
            0,
            rotation=(1.00004, 0.0, 0.0, 0.0, -1.0, 0.00003, 0.0, 0.0, -0.99997),
            translation=(0.0, 0.0, 1.0),
        ),
        requirements=(9010,),
    )
    angle = 0.7
    c, n = math.cos(angle), math.sin(angle)
    still(
        "rotation",
        "A camera that looks sideways.",
        camera(0, centre=(3.0, -2.0, 1.5), rotation=(c, n, 0.0, 0.0, 0.0, -1.0, -n, c, 0.0)),
    )
    still(
        "far_away",
        "A camera 10^12 m away, and one in the origin.",
        camera(0, centre=(1e12, 0.0, 1.0)),
        camera(1, centre=(0.0, 0.0, 0.0)),
    )
    still(
        "picture_largest",
        "A picture of 4,096 x 4,096 pixels, and one of 1 x 1.",
        camera(0, width=4096, height=4096),
        camera(1, width=1, height=1),
    )
    for count in 1, 64:
        still(
            f"count_{count}",
            f"{count} cameras.",
            *[camera(i, f"camera {i}", centre=(0.1 * i, 0.0, 2.0)) for i in range(count)],
        )


def begun(*lenses, config=None):
    """Moving cameras 0, 2, 4 … with these lens models, and the still camera 1."""
    s = opened(*TRACKS)
    for i, lens in enumerate(lenses or (0,)):
        fields = {0: {}, 1: {"r_max": 1.0}, 2: {"r_max": 1.2}}[lens]
        s.chunk("CAMR", payloads.camera(2 * i, f"moving {i}", flags=MOVES, lens=lens, **fields))
    s.chunk("CAMR", payloads.camera(1, "still"))
    return s


def moves(name, title, *frames, lenses=(0,), bits=None, **more):
    """frames: for each time the entries (camera, values), or None for a time without CALB."""

    def make():
        s = begun(*lenses)
        bits_ = bits or {}
        s.begin(0, len(frames))
        before, number = {}, 0
        for time, entries in enumerate(frames):
            frame(s, time)
            if entries is None:
                continue
            if entries and entries[0] == "key":
                entries, before, number = entries[1:], {}, 0
            s.chunk("CALB", payloads.calibration(number, entries, before, **bits_), TRACK, time, number == 0)
            number += 1
        s.end()
        s.finish()
        return s

    valid(f"moving_{name}", title, "9.4 9.5", make, **more)


def values(step, lens=(), r_max=0, q=None):
    q = q or (step, UNIT, -step, 2 * step)
    return payloads.moving_values(
        q, (16 + step, -step, 16), (256 + step, 256, 128, 128 - step, step % 3), lens, r_max
    )


def moving():
    moves(
        "one", "A camera that travels, turns and zooms for six frames.", *[[(0, values(i))] for i in range(6)]
    )
    moves("still", "A camera that could move and does not: differences of 0.", *[[(0, values(3))]] * 4)
    moves(
        "lost",
        "A camera is not calibrated in some frames, and another one has no entry at first.",
        [(0, values(0))],
        [(0, values(1)), (2, values(9))],
        [(2, values(10))],
        [],
        [(0, values(5)), (2, values(12))],
        lenses=(0, 0),
        requirements=(9014,),
    )
    moves(
        "pauses",
        "Frames without CALB between frames with one.",
        [(0, values(0))],
        None,
        [(0, values(2))],
        None,
    )
    moves(
        "keys",
        "Key chunks between others.",
        [(0, values(0))],
        [(0, values(1))],
        ["key", (0, values(7))],
        [(0, values(8))],
    )
    radtan = [[0] * 8, [-3000, 10, 1, -1, 0, 20, 30, 5], [-3001, 12, 0, 0, 0, 22, 29, 6]]
    moves(
        "radtan",
        "The coefficients of radtan change.",
        *[[(0, values(i, lens, 30000 + i))] for i, lens in enumerate(radtan)],
        lenses=(1,),
    )
    moves(
        "fisheye",
        "The coefficients of fisheye change.",
        *[[(0, values(i, [100 * i, -50, 3, i], 70000 - i))] for i in range(3)],
        lenses=(2,),
    )
    moves(
        "three_models",
        "Three cameras with the three lens models.",
        *[
            [(0, values(i)), (2, values(i, [10] * 8, 40000)), (4, values(i, [1, 2, 3, 4], 60000))]
            for i in range(3)
        ],
        lenses=(0, 1, 2),
    )
    moves(
        "finite_r_max",
        "A pinhole camera with a finite radius, which becomes infinite.",
        [(0, values(0, r_max=65536))],
        [(0, values(1, r_max=0))],
    )
    big = 1 << 25
    wide = payloads.moving_values(
        (big // 2, big // 3, -big // 5, big),
        (1 << 50, -(1 << 49), 1 << 52),
        (1 << 44, 1 << 45, 1 << 43, 1 << 43, 0),
        (),
        0,
    )
    moves(
        "finest",
        "The finest units: 25, 40, 40 and 40 bits.",
        [(0, wide)],
        [(0, [v + 1 for v in wide[:-1]] + [0])],
        bits={"rotation_bits": 25, "position_bits": 40, "pixel_bits": 40, "lens_bits": 40},
    )
    coarse = payloads.moving_values((0, 256, 0, 0), (1, 2, 3), (16, 16, 8, 8, 0))
    moves(
        "coarsest",
        "The coarsest units: 8, 0, 0 and 0 bits.",
        [(0, coarse)],
        [(0, [*coarse[:4], 2, *coarse[5:]])],
        bits={"rotation_bits": 8, "position_bits": 0, "pixel_bits": 0, "lens_bits": 0},
    )
    moves(
        "short_quaternion",
        "A quaternion of length 1/2, and one of length 2.",
        [(0, values(0, q=(128, 0, 0, 0)))],
        [(0, values(0, q=(0, 0, 512, 0)))],
    )
    moves("greatest", "Values of 2^53.", [(0, payloads.moving_values(centre=(2**53, -(2**53), 0)))])
    valid("moving_groups", "Each group begins with a key chunk.", "9.4", groups_of_motion)
    valid("moving_many", "300 chunks after a key chunk.", "9.4", many)


def groups_of_motion():
    s = begun(0)
    for number in range(3):
        s.begin(2 * number, 2 * number + 2)
        before = {}
        for i in range(2):
            frame(s, 2 * number + i)
            s.chunk(
                "CALB",
                payloads.calibration(i, [(0, values(number + i))], before),
                TRACK,
                2 * number + i,
                i == 0,
            )
        s.end()
    s.finish()
    return s


def many():
    s = begun(0)
    s.begin(0, 301)
    before = {}
    frame(s, 0)
    for i in range(301):
        s.chunk("CALB", payloads.calibration(i, [(0, values(i % 7))], before), TRACK, i, i == 0)
    s.end()
    s.finish()
    return s


def motion(name, title, issue, make_payload, *, key=False, first=False, lenses=(0, 0), clauses="9.4"):
    """Frames at 2, 3 and 4 with good chunks at 2 and 4; that at 3, or with first the one at 2, comes from
    make_payload(number, before)."""

    def make():
        s = begun(*lenses)
        group(s, 0)
        s.begin(2, 6)
        before = {}
        entries = [(0, values(0, [0] * 8, 30000) if lenses[0] else values(0)), (2, values(1))]
        if not first:
            frame(s, 2)
            s.chunk("CALB", payloads.calibration(0, entries, before), TRACK, 2, True)
        frame(s, 3)
        bad = make_payload(0 if first or key else 1, {} if key or first else before)
        s.chunk("CALB", bad, TRACK, 3, key or first, fault=issue)
        frame(s, 4)
        s.end()
        s.begin(6, 7)
        frame(s, 6)
        s.chunk("CALB", payloads.calibration(0, entries), TRACK, 6, True)
        s.end()
        s.finish()
        return s

    faulty(f"calibration_{name}", title, clauses, make)


def motion_faults():
    entries = [(0, values(2)), (2, values(3))]

    def with_fields(**fields):
        return lambda number, before: payloads.calibration(number, entries, before, **fields)

    for size in 0, 7:
        motion(
            f"header_{size}_bytes",
            f"A CALB payload of {size} bytes.",
            5101,
            lambda n, b, size=size: payloads.calibration(n, entries, b)[:size],
        )
    for name, fields in (
        ("rotation_bits_7", {"rotation_bits": 7}),
        ("rotation_bits_26", {"rotation_bits": 26}),
        ("position_bits_41", {"position_bits": 41}),
        ("pixel_bits_41", {"pixel_bits": 41}),
        ("lens_bits_255", {"lens_bits": 255}),
    ):
        motion(name, f"A CALB payload has {fields}.", 5101, with_fields(**fields), first=True)
    motion(
        "count_more",
        "CALB counts an entry more than it has.",
        5101,
        lambda n, b: payloads.calibration(n, entries[:1], b, count=2),
    )
    motion("count_less", "CALB counts an entry less than it has.", 5101, with_fields(count=1))
    motion("cut", "The last entry lacks a byte.", 5101, lambda n, b: payloads.calibration(n, entries, b)[:-1])
    motion(
        "extra",
        "A byte follows the last entry.",
        5101,
        lambda n, b: payloads.calibration(n, entries, b) + b"\0",
    )
    motion(
        "overlong",
        "The last number is not in its shortest form.",
        5101,
        lambda n, b: payloads.calibration(n, entries, b)[:-1] + b"\x80\0",
    )
    motion(
        "number_65_bits",
        "A number has more than 64 bits.",
        5101,
        lambda n, b: payloads.calibration(n, entries, b)[:-1] + b"\xff" * 9 + b"\x7f",
    )
    motion(
        "camera_order",
        "The entries are in descending order.",
        5102,
        lambda n, b: payloads.calibration(n, entries[::-1], b),
    )
    motion(
        "camera_twice",
        "A camera has two entries.",
        5102,
        lambda n, b: payloads.calibration(n, [entries[0]] * 2, b),
    )
    motion(
        "camera_still",
        "An entry is of a camera that does not move.",
        5102,
        lambda n, b: payloads.calibration(n, [(1, values(0))], b),
    )
    motion(
        "camera_unknown",
        "An entry is of a camera that does not exist.",
        5102,
        lambda n, b: payloads.calibration(n, [(9, values(0))], b),
    )
    motion(
        "camera_beyond",
        "An entry is of camera 65536.",
        5102,
        lambda n, b: payloads.calibration(n, [], b, count=1) + uleb128(65536) + bytes(13),
    )
    motion(
        "number_repeated",
        "A chunk without the key flag has the number 0.",
        5103,
        lambda n, b: payloads.calibration(0, entries, b),
    )
    motion(
        "number_skipped",
        "A chunk has the number 2 after 0.",
        5103,
        lambda n, b: payloads.calibration(2, entries, b),
    )
    motion(
        "number_of_key",
        "A key chunk has the number 1.",
        5103,
        lambda n, b: payloads.calibration(1, entries, b),
        key=True,
    )
    for field in ("rotation_bits", "position_bits", "pixel_bits", "lens_bits"):
        motion(
            f"changes_{field}",
            f"A chunk has other {field} than its key chunk.",
            5103,
            with_fields(**{field: payloads.BITS[field] + 1}),
        )

    def key(name, title, issue, *entry, lenses=(0, 0), clauses="9.4"):
        motion(
            name,
            title,
            issue,
            lambda n, b: payloads.calibration(0, [(0, payloads.moving_values(*entry))]),
            key=True,
            lenses=lenses,
            clauses=clauses,
        )

    key("value_beyond", "A value is 2^53 + 1.", 5104, payloads.LOOKING_DOWN, (2**53 + 1, 0, 0))
    key("value_below", "A value is -2^63.", 5104, payloads.LOOKING_DOWN, (-(2**63), 0, 0))
    key("quaternion_zero", "The quaternion is 0.", 5104, (0, 0, 0, 0))
    key("quaternion_short", "The quaternion is just shorter than 1/2.", 5104, (127, 0, 0, 0))
    key("quaternion_long", "The quaternion is just longer than 2.", 5104, (512, 1, 0, 0))
    motion(
        "value_sum",
        "A sum of differences passes 2^53.",
        5104,
        lambda n, b: payloads.calibration(1, [(0, [*values(0)[:4], 2**53 + 20, *values(0)[5:]])], b),
    )
    key(
        "focal_zero",
        "fx becomes 0.",
        5105,
        payloads.LOOKING_DOWN,
        (0, 0, 16),
        (0, 256, 128, 128, 0),
        clauses="9.5",
    )
    key(
        "focal_negative",
        "fy becomes negative.",
        5105,
        payloads.LOOKING_DOWN,
        (0, 0, 16),
        (256, -1, 128, 128, 0),
        clauses="9.5",
    )
    key(
        "r_max_negative",
        "r_max becomes negative.",
        5105,
        payloads.LOOKING_DOWN,
        (0, 0, 16),
        (256, 256, 128, 128, 0),
        (),
        -1,
        clauses="9.5",
    )
    key(
        "r_max_zero_radtan",
        "r_max becomes 0 with a lens model.",
        5105,
        payloads.LOOKING_DOWN,
        (0, 0, 16),
        (256, 256, 128, 128, 0),
        [0] * 8,
        0,
        lenses=(1, 0),
        clauses="9.5",
    )
    key(
        "r_max_fold",
        "r_max is beyond the fold of k1 = -1.",
        5105,
        payloads.LOOKING_DOWN,
        (0, 0, 16),
        (256, 256, 128, 128, 0),
        [-65536, *[0] * 7],
        40000,
        lenses=(1, 0),
        clauses="9.5",
    )


lenses()
moving()
motion_faults()
