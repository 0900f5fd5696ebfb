"""From points of the world to pixels, and from pixels to rays: clauses 9.1 and 9.3 of spec/fvv.md.

A camera is the 26 numbers of the report, with its lens model.
"""

import math

from .decode.lens import FISHEYE, NONE, value

STEPS = 200  # of a bisection: more than a double has bits
FAR = 1e9  # farther out no pixel is looked for
CLOSE = 1e-6  # pixels by which a ray may miss its pixel, clause 9.3


def radial(lens, k, r):
    """Where the lens takes a point at r, without the tangential terms; r is the angle for fisheye."""
    x = r * r
    if lens == FISHEYE:
        return r * value([1.0, *k[:4]], x)
    return r * value([1.0, k[0], k[1], k[4]], x) / value([1.0, k[5], k[6], k[7]], x)


def distorted(lens, k, x, y):
    """lens(x, y) of clause 9.1."""
    r = math.hypot(x, y)
    if lens == NONE or r == 0:
        return x, y
    if lens == FISHEYE:
        scale = radial(lens, k, math.atan(r)) / r
        return x * scale, y * scale
    d, p1, p2 = radial(lens, k, r) / r, k[2], k[3]
    return (
        x * d + 2 * p1 * x * y + p2 * (r * r + 2 * x * x),
        y * d + p1 * (r * r + 2 * y * y) + 2 * p2 * x * y,
    )


def in_camera(numbers, point):
    """Coordinates of a point of the world in the camera."""
    rotation, translation = numbers[14:23], numbers[23:]
    return [sum(r * w for r, w in zip(rotation[3 * i : 3 * i + 3], point)) + translation[i] for i in range(3)]


def project(lens, numbers, point):
    """The pixel of a point in metres, or None: it is not in front of the camera, or beyond r_max."""
    x, y, z = in_camera(numbers, point)
    if not z > 0:
        return None
    x, y = x / z, y / z
    r = math.hypot(x, y)
    if (math.atan(r) if lens == FISHEYE else r) > numbers[13]:
        return None
    return pixel_of(lens, numbers, x, y)


def pixel_of(lens, numbers, x, y):
    fx, fy, cx, cy, skew = numbers[:5]
    x, y = distorted(lens, numbers[5:13], x, y)
    return [fx * x + skew * y + cx, fy * y + cy]


def undistorted_radius(lens, k, r_max, wanted):
    """The radius up to r_max, an angle for fisheye, that the lens takes nearest to `wanted`."""
    low, high = 0.0, min(r_max, FAR)
    for _ in range(STEPS):
        middle = (low + high) / 2
        if radial(lens, k, middle) < wanted:
            low = middle
        else:
            high = middle
    return high


def unproject(lens, numbers, pixel):
    """The ray through a pixel in coordinates of the camera, with z = 1; None: no point within r_max has this pixel."""
    fx, fy, cx, cy, skew = numbers[:5]
    k, r_max = numbers[5:13], numbers[13]
    v = (pixel[1] - cy) / fy
    u = (pixel[0] - cx - skew * v) / fx
    if lens == NONE:
        return [u, v, 1.0] if math.hypot(u, v) <= r_max else None
    x, y = inverted(lens, k, r_max, u, v)
    found = pixel_of(lens, numbers, x, y)
    return [x, y, 1.0] if max(abs(a - b) for a, b in zip(found, pixel)) < CLOSE else None


def inverted(lens, k, r_max, u, v):
    """The point that the lens takes to u, v. What the tangential terms add is subtracted until nothing changes."""
    p1, p2 = (0.0, 0.0) if lens == FISHEYE else k[2:4]
    x, y = u, v
    for _ in range(STEPS if p1 or p2 else 1):
        r2 = x * x + y * y
        a = u - (2 * p1 * x * y + p2 * (r2 + 2 * x * x))
        b = v - (p1 * (r2 + 2 * y * y) + 2 * p2 * x * y)
        wanted = math.hypot(a, b)
        radius = undistorted_radius(lens, k, r_max, wanted)
        length = math.tan(radius) if lens == FISHEYE else radius
        x, y = (a * length / wanted, b * length / wanted) if wanted else (0.0, 0.0)
    return x, y
