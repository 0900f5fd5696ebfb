"""Two sets of triangles: is each of one in the other, with its winding, or at least the same surface? And are the colours alike?"""

import numpy as np
import trimesh
from scipy.spatial import cKDTree

NEIGHBOURS = 12
#: Samples of each triangle that has no equal: a polygon may have been cut along another diagonal.
SAMPLES = 6
MOST_PAIRS = 10_000_000
LEAST_POINTS = 200
AREA_PART = 2e-3
#: Means over 64 parts of a picture level are noise of the encoder; single pixels beside edges are further off.
COLOUR_MEDIAN, COLOUR_NEAR, COLOUR_PART = 8, 40, 0.9


def area_of(corners):
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2


def edges_of(corners):
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)


def visible(corners, tolerance):
    """Whether a triangle is wider than the tolerance: thinner ones may vanish on a lattice."""
    longest = edges_of(corners).max(1)
    return 2 * area_of(corners) > 2 * tolerance * longest


def matches(own, other, tolerance):
    """For each triangle of own the number of one of other with the same corners in the same turn, or -1."""
    found = np.full(len(own), -1)
    if not len(other):
        return found
    count = min(NEIGHBOURS, len(other))
    _, near = cKDTree(other.mean(1)).query(own.mean(1), k=count, distance_upper_bound=2 * tolerance)
    near = near.reshape(len(own), count)
    for k in range(count):
        for turn in range(3):
            asked = np.flatnonzero((found < 0) & (near[:, k] < len(other)))
            there = np.roll(other[near[asked, k]], turn, axis=1)
            equal = np.linalg.norm(own[asked] - there, axis=2).max(1) <= tolerance
            found[asked[equal]] = near[asked[equal], k]
    return found


def largest_distance(own, other):
    """Of samples of own from the surface of other: of as many as time allows."""
    if not len(own):
        return 0.0
    if not len(other):
        return np.nan
    # closest_point() compares squares of lengths with a fixed number: of a model of centimetres it misses the face that a point is on.
    scale = 1000 / np.ptp(other.reshape(-1, 3), axis=0).max()
    own, other = own * scale, other * scale
    random = np.random.default_rng(1)
    weights = random.dirichlet((1, 1, 1), SAMPLES)
    points = np.einsum("sk,nkd->nsd", weights, own).reshape(-1, 3)
    most_points = max(LEAST_POINTS, MOST_PAIRS // len(other))
    if len(points) > most_points:
        points = random.choice(points, most_points, replace=False)
    most = 0.0
    for point in points:
        closest = trimesh.triangles.closest_point(other, np.broadcast_to(point, (len(other), 3)))
        most = max(most, np.linalg.norm(closest - point, axis=1).min())
    return most / scale


def difference(truth, found, tolerance):
    """None where both are the same surface, else what differs, and the match of each visible triangle of truth."""
    (own, _), (other, _) = truth, found
    pairs = matches(own, other, tolerance)
    left = (pairs < 0) & visible(own, tolerance)
    # Of two faces back to back one is sent where neither has texture coordinates: they are the same surface.
    backs = np.flatnonzero(left)
    twins = (matches(own[backs][:, ::-1], other, tolerance) >= 0) & (
        matches(own[backs][:, ::-1], own, tolerance) >= 0
    )
    left[backs[twins]] = False
    own_left = own[left]
    back = matches(other, own, tolerance)
    other_left = other[(back < 0) & visible(other, tolerance)]
    if not len(own_left) and not len(other_left):
        return None, pairs
    # A face that is cut has pieces thinner than the tolerance, too: all that has no equal counts here.
    alone = pairs < 0
    alone[backs[twins]] = False
    own_alone, other_alone = own[alone], other[back < 0]
    areas = area_of(own_alone).sum(), area_of(other_alone).sum()
    # Each corner moved by the tolerance changes a triangle's area by half its edges at most: strips as wide as the lattice's step.
    rounding = tolerance * sum(edges_of(part).sum() for part in (own_alone, other_alone)) / 2
    if abs(areas[0] - areas[1]) <= max(AREA_PART * area_of(own).sum(), rounding):
        # From the whole surface: what is left of a triangle whose thinnest pieces vanished is beside others that have equals.
        far = max(largest_distance(own_left, other), largest_distance(other_left, own))
        if far <= 2 * tolerance:
            return None, pairs
    text = f"{len(own_left)} of {len(own)} triangles are missing, {len(other_left)} are new; areas {areas[0]:.4g} and {areas[1]:.4g}"
    return text, pairs


def colour_difference(truth, found, pairs):
    """None where matched triangles have the same colours, or none were written, else what differs."""
    (_, own), (_, other) = truth, found
    if other is None:
        return None
    known = (pairs >= 0) & np.isfinite(own).all(1)
    if not known.any():
        return None
    there = other[pairs[known]]
    lost = np.isnan(there).any(1).mean()
    if lost > 1 - COLOUR_PART:
        return f"{100 * lost:.0f} % of the triangles have lost their colours"
    off = np.nanmax(np.abs(there - own[known]), axis=1)
    off = off[np.isfinite(off)]
    if np.median(off) > COLOUR_MEDIAN or (off < COLOUR_NEAR).mean() < COLOUR_PART:
        return f"colours differ by {np.median(off):.0f} levels in the median, {100 * (off >= COLOUR_NEAR).mean():.0f} % by more than {COLOUR_NEAR}"
    return None
