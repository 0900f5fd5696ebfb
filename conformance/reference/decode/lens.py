"""Cameras: the rules of clauses 9.1 to 9.3 of spec/fvv.md for one calibration."""

import math
import struct

import numpy

from ..container import demand

NONE, RADTAN, FISHEYE = 0, 1, 2
SIDE = 16384  # limit of the sides of a picture, clause 13
COEFFICIENTS = {NONE: 0, RADTAN: 8, FISHEYE: 4}


def value(polynomial, x):
    out = 0.0
    for coefficient in reversed(polynomial):
        out = out * x + coefficient
    return out


def positive_roots(polynomial):
    """The positive roots at which a polynomial changes its sign, rising. polynomial: coefficients from x^0 on."""
    while polynomial and polynomial[-1] == 0:
        polynomial = polynomial[:-1]
    if len(polynomial) < 2:
        return []
    turns = positive_roots([i * c for i, c in enumerate(polynomial)][1:])
    bound = 1 + max(abs(c / polynomial[-1]) for c in polynomial[:-1])
    places, roots = [0.0, *(t for t in turns if t < bound), bound], []
    for low, high in zip(places, places[1:]):
        sign = value(polynomial, low)
        if sign * value(polynomial, high) > 0:
            continue
        for _ in range(200):
            middle = (low + high) / 2
            if sign * value(polynomial, middle) > 0:
                low = middle
            else:
                high = middle
        if high > 0:
            roots.append(high)
    return roots


def product(a, b):
    return [float(x) for x in numpy.convolve(a, b)]


def radius(lens, k):
    """Clause 9.3: up to where the lens model can be inverted; in the polynomials x is r^2, or a^2 for fisheye."""
    if lens == FISHEYE:
        roots = positive_roots([1.0, 3 * k[0], 5 * k[1], 7 * k[2], 9 * k[3]])
    elif lens == RADTAN:
        n, d = [1.0, k[0], k[1], k[4]], [1.0, k[5], k[6], k[7]]
        n1, d1 = ([2 * i * c for i, c in enumerate(p)] for p in (n, d))  # r times the derivative by r
        slope = [x + y - z for x, y, z in zip(product(n, d), product(n1, d), product(n, d1))]
        roots = positive_roots(slope) + positive_roots(d)
    else:
        roots = []
    return math.sqrt(min(roots)) if roots else math.inf


def check_camera(lens, intrinsics, distortion, r_max, rotation, translation):
    """FVV-5003 to 5005."""
    demand(all(map(math.isfinite, (*intrinsics, *distortion))), 5003, "a number that is not finite")
    demand(intrinsics[0] > 0 and intrinsics[1] > 0, 5003, "a focal length that is not positive")
    demand(all(map(math.isfinite, (*rotation, *translation))), 5004, "a pose that is not finite")
    r = numpy.array(rotation).reshape(3, 3)
    with numpy.errstate(over="ignore", invalid="ignore"):
        demand(bool((abs(r @ r.T - numpy.eye(3)) <= 1e-4).all()), 5004, "R is not orthonormal")
    demand(numpy.linalg.det(r) > 0, 5004, "the determinant of R is not positive")
    demand(r_max > 0, 5005, f"r_max is {r_max}")
    demand(lens == NONE or math.isfinite(r_max), 5005, "r_max is infinite")
    demand(lens != FISHEYE or r_max < math.pi / 2, 5005, f"r_max is {r_max}")
    demand(r_max <= radius(lens, distortion) * (1 + 1e-9), 5005, f"r_max is {r_max}")


class Camera:
    """A CAMR payload. numbers: the 26 f64 of the report."""

    def __init__(self, payload, check_text):
        demand(len(payload) >= 224, 5001, "size")
        self.id, self.lens, flags, name_size, self.width, self.height = struct.unpack_from("<HBBIII", payload)
        numbers = struct.unpack_from("<26d", payload, 16)
        demand(len(payload) == 224 + name_size, 5001, "size")
        demand(max(self.width, self.height) <= SIDE, 7001, f"{self.width} x {self.height} pixels")
        demand(flags < 2, 5001, f"flags {flags}")
        check_text(payload[224:])
        demand(self.lens in COEFFICIENTS, 5002, f"lens model {self.lens}")
        distortion = numbers[5:13]
        demand(not any(distortion[COEFFICIENTS[self.lens] :]), 5001, "a coefficient that the lens has not")
        demand(self.width > 0 and self.height > 0, 5003, "an empty picture")
        self.moves = flags == 1
        check_camera(self.lens, numbers[:5], distortion, numbers[13], numbers[14:23], numbers[23:])
        demand(self.id != 65535, 5006, "identifier 65535")
        self.numbers = numbers
