"""Cameras that are asked where they show points, and which ray a pixel has: clauses 9.1 and 9.3.

Each coefficient of a lens has a camera of its own, so that one that is ignored, or of the wrong sign, moves a pixel.
"""

import math

from .. import payloads
from ..case import valid
from ..recipes import frame, group, opened

NONE, RADTAN, FISHEYE = 0, 1, 2
WIDTH, HEIGHT = 640, 480
# Metres in front of a camera at the origin that looks along z: in the middle, at its sides, near, far, and wide of its axis.
AHEAD = [
    (0.0, 0.0, 2.0),
    (0.3, 0.1, 1.0),
    (-0.25, 0.4, 1.5),
    (0.5, -0.6, 2.5),
    (-3.0, -1.0, 10.0),
    (0.04, 0.03, 0.1),
]
NOT_SEEN = [(0.1, 0.2, -1.0), (0.1, 0.2, 0.0)]  # behind it, and in its plane
INTRINSICS = {
    "width": WIDTH,
    "height": HEIGHT,
    "fx": 500.0,
    "fy": 480.0,
    "cx": 321.5,
    "cy": 238.25,
    "skew": 1.5,
}
UPRIGHT = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
# Away from the middle, where r is about 0.35.
PIXELS = [(321.5, 238.25), (0.5, 0.5), (639.5, 479.5), (200.25, 400.75), (500.0, 31.0), (321.5, 300.0)]


def camera(identifier, lens, coefficients=(), r_max=math.inf, name="", **fields):
    distortion = (*coefficients, *[0.0] * (8 - len(coefficients)))
    values = INTRINSICS | {"lens": lens, "distortion": distortion, "r_max": r_max, "rotation": UPRIGHT}
    return payloads.camera(identifier, name, **{"centre": (0.0, 0.0, 0.0)} | values | fields)


def alone(index, count, value):
    return tuple(value if i == index else 0.0 for i in range(count))


def asked(identifier, points, pixels, frame_number=0):
    which = {"frame": frame_number, "camera": identifier}
    return [
        {"op": "project", **which, "points": [list(point) for point in points]},
        {"op": "unproject", **which, "pixels": [list(pixel) for pixel in pixels]},
    ]


def still(name, title, cameras, points=(*AHEAD, *NOT_SEEN), pixels=PIXELS, clauses="9.1 9.3", **more):
    """cameras: CAMR payloads with the identifiers 0, 1, 2 ..."""

    def make():
        s = opened()
        for payload in cameras:
            s.chunk("CAMR", payload)
        group(s, 0, 1)
        s.finish()
        return s

    rows = [row for identifier in range(len(cameras)) for row in asked(identifier, points, pixels)]
    valid(f"projection_{name}", title, clauses, make, questions=rows, **more)


def turned():
    """A camera that is not where its conventions are easy: it looks down from a corner, with a roll."""
    a, b, c = 0.4, -1.1, 0.25
    x = (1, 0, 0), (0, math.cos(a), -math.sin(a)), (0, math.sin(a), math.cos(a))
    y = (math.cos(b), 0, math.sin(b)), (0, 1, 0), (-math.sin(b), 0, math.cos(b))
    z = (math.cos(c), -math.sin(c), 0), (math.sin(c), math.cos(c), 0), (0, 0, 1)

    def product(p, q):
        return tuple(tuple(sum(p[i][k] * q[k][j] for k in range(3)) for j in range(3)) for i in range(3))

    return tuple(float(v) for row in product(product(x, y), z) for v in row)


RADTAN_NAMES = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
# Large enough to move a pixel far, small enough for an r_max of 0.9.
RADTAN_VALUES = (-0.15, 0.1, 0.02, -0.015, 0.12, 0.2, -0.15, 0.1)
FISHEYE_VALUES = (-0.05, 0.03, -0.02, 0.015)

still(
    "pinhole",
    "A camera without a lens model, one with a finite r_max, and one that is turned and moved.",
    [
        camera(0, NONE),
        camera(1, NONE, r_max=0.3),
        camera(2, NONE, rotation=turned(), centre=(0.75, -0.5, -3.0)),
    ],
    points=(*AHEAD, *NOT_SEEN, (-2.0, 1.0, 0.5)),
    requirements=(9011, 9012),
)
still(
    "radtan_each",
    "One camera for each coefficient of radtan, of which no other is there.",
    [
        camera(i, RADTAN, alone(i, 8, value), 0.9, name)
        for i, (name, value) in enumerate(zip(RADTAN_NAMES, RADTAN_VALUES))
    ],
)
still(
    "radtan_all",
    "All coefficients of radtan at once; the second camera ends at a radius of 0.45.",
    [
        camera(0, RADTAN, (-0.1, 0.05, 0.003, -0.002, 0.04, 0.1, 0.05, 0.02), 0.9),
        camera(1, RADTAN, (-0.1, 0.05, 0.003, -0.002, 0.04, 0.1, 0.05, 0.02), 0.45),
    ],
    points=(*AHEAD, *NOT_SEEN, (0.449, 0.0, 1.0), (0.0, 0.451, 1.0), (0.8, 0.0, 1.0), (0.0, 0.95, 1.0)),
    requirements=(9011, 9012),
)
still(
    "radtan_fold",
    "A lens that folds at 1 / sqrt(3): two radii have the same pixel, and the lesser is right.",
    [camera(0, RADTAN, (-1.0,), 0.57)],
    points=((0.5, 0.0, 1.0), (0.3, 0.45, 1.0), (0.58, 0.0, 1.0), (0.0, 0.65, 1.0), (0.9, 0.0, 1.0)),
    pixels=((500.0, 238.25), (321.5, 60.0), (321.5, 238.25), (513.0, 238.25), (630.0, 238.25)),
    requirements=(9011, 9012),
)
still(
    "fisheye_each",
    "One camera for each coefficient of fisheye, of which no other is there, and one without.",
    [
        *[camera(i, FISHEYE, alone(i, 4, value), 1.3, f"k{i + 1}") for i, value in enumerate(FISHEYE_VALUES)],
        camera(4, FISHEYE, (), 1.3, "none"),
    ],
    points=(*AHEAD, *NOT_SEEN, (2.0, 1.0, 0.8), (-1.0, 3.0, 1.0)),
)
still(
    "fisheye_all",
    "All coefficients of fisheye at once, almost to 90 degrees; the second camera ends at an angle of 0.4.",
    [camera(0, FISHEYE, FISHEYE_VALUES, 1.5), camera(1, FISHEYE, FISHEYE_VALUES, 0.4)],
    points=(*AHEAD, *NOT_SEEN, (0.42, 0.0, 1.0), (0.0, 0.43, 1.0), (14.0, 0.0, 1.0), (15.0, 0.0, 1.0)),
    pixels=(*PIXELS, (1005.0, 238.25), (-350.0, 238.25), (1400.0, 238.25)),
    requirements=(9011, 9012),
)


def moving():
    s = opened(
        (1, payloads.track(payloads.MESH, "mesh")), (3, payloads.track(payloads.CALIBRATION, "motion"))
    )
    s.chunk("CAMR", camera(0, RADTAN, (), 0.9, flags=1))
    s.chunk("CAMR", camera(1, FISHEYE, (), 1.2, flags=1))
    s.begin(0, 2)
    before = {}
    for time in range(2):
        frame(s, time)
        entries = []
        for identifier, lens in (0, [-6000, 900, 150, -80, 700, 500, 300, 90]), (1, [-900, 500, -300, 200]):
            q = (240 - 20 * time, 60, 30 + 50 * time, -25)
            centre = (3 + time, -2, -40 - 5 * time)
            pixels = (8000 + 320 * time, 7680, 5144, 3812 - 100 * time, 24)
            entries.append((identifier, payloads.moving_values(q, centre, pixels, lens, 50000)))
        s.chunk("CALB", payloads.calibration(time, entries, before), 3, time, time == 0)
    s.end()
    s.finish()
    return s


valid(
    "projection_moving",
    "Two cameras that turn, travel and zoom, with a lens each.",
    "9.4 9.5 9.1",
    moving,
    requirements=(9013,),
    questions=[
        row
        for number in range(2)
        for identifier in range(2)
        for row in asked(identifier, [(x - 1.2, y, z) for x, y, z in (*AHEAD, *NOT_SEEN)], PIXELS, number)
    ],
)
