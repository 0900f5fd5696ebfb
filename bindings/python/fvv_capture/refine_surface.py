"""A hull whose vertices moved inwards to where pictures agree: hollows that no silhouette shows are carved by colour.

Each vertex may move along its normal into the hull. At every step the colours that pairs of cameras see are compared, over the vertex and
its neighbours (the surface's own patch, as Furukawa and Ponce 2010 and Starck and Hilton 2007 do). The steps of all vertices are
chosen together, so that neighbours move alike: a Markov random field over the mesh, by min-sum belief propagation with a truncated
linear cost (Felzenszwalb and Huttenlocher 2006). Moving costs a little, as the balloon of Vogiatzis, Torr and Cipolla 2005 does:
where the pictures say nothing the hull stays. Silhouettes are a bound from within, too: where one is no longer filled, the vertex before it
that loses least goes back. Lengths are in cells of the hull."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy
from fvv import Camera
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

from .arrays import Floats
from .hull import Grid, Hull, coverage

cv2: Any = optional_import("cv2", "capture")
sparse: Any = optional_import("scipy.sparse", "capture")

Doubles = NDArray[numpy.float64]
Flags = NDArray[numpy.bool_]

#: Cells between the places that a vertex is tried at, and how many of them follow the hull's.
STEP = 0.5
STEPS = 20
#: Cells that stay between a place and the other side of the hull.
MARGIN = 1.7
#: Cells by which a vertex may be behind what a camera sees first.
BEHIND = 2.1
#: Cosine between normal and ray above which a camera sees enough of a vertex.
FACING = 0.4
#: Degrees between the rays of two cameras; beyond, they seldom see the same.
APART = 60.0
#: Levels of noise: a difference of so much costs 1 in each channel. Costs are limited.
NOISE = 8.0
MOST = 30.0
#: Of a step inwards, of a step between neighbours, and the most that neighbours cost.
BALLOON = 0.1
STIFFNESS = 2.0
TEAR = 20.0
ROUNDS = 10
#: Times that vertices are put back for silhouettes that they no longer fill, and rounds after each.
TURNS = 3
MORE_ROUNDS = 4
#: Pixels by which an outline may shrink.
TOLERANCE = 1
#: Pixels from one that is lost within which a vertex of the hull may fill it, and cells between those that stay for a stretch of outline.
NEAR = 1
REACH = 1.0
#: Places that are not inside the hull.
FORBIDDEN = 1e3
#: Samples that two cameras need in common for their exposures to be compared, and for them to be a pair.
COMMON = 50
#: OpenCV's remap takes fewer rows and columns than 2^15.
_ROW, _ROWS = 4096, 8192


def refine(
    found: Hull,
    cameras: Sequence[Camera],
    pictures: Sequence[NDArray[numpy.uint8]],
    masks: Sequence[NDArray[Any] | None],
) -> Doubles:
    """The positions (V, 3) of a hull's vertices, moved inwards along their normals by at most STEP * STEPS cells.

    pictures: (height, width, 3) of each camera, at one moment; exposures may differ by a factor for each channel. masks: what the hull was
    carved of, which its surface goes on filling; None for a camera without one. No vertex moves out of the hull; hulls are smooth within 2 cells, finer shapes are not found."""
    positions = numpy.asarray(found.positions, numpy.float64)
    faces = numpy.asarray(found.indices, numpy.int64)
    if not len(faces) or len(cameras) < 2:
        return positions
    cell = found.grid.cell
    links = _links(faces, len(positions))
    patch = links + sparse.identity(len(positions), numpy.float32, format="csr")
    mean = sparse.diags(1 / numpy.asarray(patch.sum(1)).ravel()).astype(numpy.float32) @ patch
    normals = _normals(positions, faces, mean)
    facing = numpy.stack([_facing(c, positions, faces, normals, cell) for c in cameras])
    soft = [cv2.GaussianBlur(p.astype(numpy.float32), (0, 0), 0.7) for p in pictures]
    soft = _alike(soft, cameras, positions, facing > 0)
    depths = numpy.arange(STEPS + 1) * (STEP * cell)
    inside = _inside(found.grid, positions, normals, depths)
    cost = _disagreement(soft, cameras, positions, normals, facing, depths, patch)
    cost += numpy.float32(BALLOON) * numpy.arange(len(depths), dtype=numpy.float32)
    cost[~inside] = FORBIDDEN
    deepest = depths[inside.sum(axis=1) - 1]
    field = _Field(links)
    kept = numpy.zeros(len(positions), bool)
    bound = _Bound(found, cameras, masks)
    moved = positions
    for turn in range(TURNS + 1):
        beliefs = field.beliefs(cost, ROUNDS if turn == 0 else MORE_ROUNDS)
        depth = _least(beliefs) * (STEP * cell)
        depth[kept] = 0
        for _ in range(3):
            depth = mean @ depth
            depth[kept] = 0
        moved = positions - normals * numpy.minimum(depth, deepest)[:, None]
        if turn == TURNS:
            break
        more = bound.opened(moved, beliefs[:, 0] - beliefs.min(axis=1)) & ~kept
        if not more.any():
            break
        kept |= more
        cost[kept, 1:] = FORBIDDEN
    return moved


def _links(faces: NDArray[numpy.int64], count: int) -> Any:
    """Which vertices share an edge, (V, V) sparse, 1 each."""
    ends = numpy.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ends = numpy.concatenate([ends, ends[:, ::-1]])
    links = sparse.coo_matrix((numpy.ones(len(ends), numpy.float32), ends.T), (count, count)).tocsr()
    links.data[:] = 1
    return links


def _normals(positions: Doubles, faces: NDArray[numpy.int64], mean: Any) -> Doubles:
    """(V, 3) unit vectors outwards, smoothed, so that vertices that move do not cross."""
    a, b, c = (positions[faces[:, k]] for k in range(3))
    areas = numpy.cross(b - a, c - a)
    out: Doubles = numpy.stack(
        [
            sum(numpy.bincount(faces[:, k], areas[:, axis], len(positions)) for k in range(3))
            for axis in range(3)
        ],
        axis=1,
    )
    for _ in range(7):
        out /= numpy.maximum(numpy.linalg.norm(out, axis=1, keepdims=True), 1e-12)
        out = mean @ out
    out /= numpy.maximum(numpy.linalg.norm(out, axis=1, keepdims=True), 1e-12)
    return out


def _facing(
    camera: Camera, positions: Doubles, faces: NDArray[numpy.int64], normals: Doubles, cell: float
) -> Floats:
    """(V,) the cosine between each normal and the ray to the camera; 0 where the camera does not see the vertex."""
    a, b, c = (positions[faces[:, k]] for k in range(3))
    # Enough points of each face that none of its pixels is missed: faces are hardly larger than these.
    spread = [(a + b + c) / 3, (a + b) / 2, (b + c) / 2, (a + c) / 2]
    spread += [0.6 * p + 0.2 * q + 0.2 * r for p, q, r in ((a, b, c), (b, c, a), (c, a, b))]
    points = numpy.concatenate([positions, *spread])
    depth = camera.depth(points)
    pixel = camera.project(points) / 1.5
    width, height = int(camera.width / 1.5) + 1, int(camera.height / 1.5) + 1
    seen = numpy.isfinite(pixel).all(axis=1) & (depth > 0)
    place = numpy.zeros(pixel.shape, numpy.int64)
    place[seen] = numpy.floor(pixel[seen])
    seen &= (place >= 0).all(axis=1) & (place[:, 0] < width) & (place[:, 1] < height)
    index = place[:, 1] * width + place[:, 0]
    nearest = numpy.full(width * height, numpy.inf)
    numpy.minimum.at(nearest, index[seen], depth[seen])
    count = len(positions)
    ray = camera.centre - positions
    cosine = (ray * normals).sum(axis=1) / numpy.linalg.norm(ray, axis=1)
    first = seen[:count].copy()
    first[first] = depth[:count][first] < nearest[index[:count][first]] + BEHIND * cell
    return numpy.where(first & (cosine > FACING), cosine, 0).astype(numpy.float32)


def _sampled(picture: Floats, pixels: Doubles) -> Floats:
    """(..., 3) the colours at pixels (..., 2), between pixel centres at .5."""
    flat = numpy.nan_to_num(pixels.reshape(-1, 2).astype(numpy.float32) - numpy.float32(0.5), nan=-1.0)
    rows = -(-len(flat) // _ROW)
    full = numpy.zeros((rows * _ROW, 2), numpy.float32)
    full[: len(flat)] = flat
    full = full.reshape(rows, _ROW, 2)
    parts = [
        cv2.remap(picture, full[i : i + _ROWS], None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        for i in range(0, rows, _ROWS)
    ]
    out: Floats = numpy.concatenate(parts).reshape(-1, 3)[: len(flat)].reshape(*pixels.shape[:-1], 3)
    return out


def _alike(
    pictures: Sequence[Floats], cameras: Sequence[Camera], positions: Doubles, seen: Flags
) -> list[Floats]:
    """The pictures with the exposures that fit best together: the least squares of the pairs' median ratios."""
    colours = [_sampled(p, c.project(positions)) for p, c in zip(pictures, cameras)]
    gains = numpy.zeros((len(cameras), 3))
    for channel in range(3):
        rows, ratios = [numpy.ones(len(cameras))], [0.0]  # the mean gain is 1
        for i in range(len(cameras)):
            for j in range(i):
                a, b = (colours[k][seen[i] & seen[j], channel] for k in (i, j))
                fair = (a > 15) & (b > 15) & (a < 245) & (b < 245)
                if fair.sum() < 2 * COMMON:
                    continue
                row = numpy.zeros(len(cameras))
                row[i], row[j] = 1, -1
                weight = numpy.sqrt(fair.sum())
                rows.append(weight * row)
                ratios.append(float(weight * numpy.median(numpy.log(a[fair] / b[fair]))))
        gains[:, channel] = numpy.linalg.lstsq(numpy.array(rows), numpy.array(ratios), rcond=None)[0]
    return [p * numpy.exp(-g).astype(numpy.float32) for p, g in zip(pictures, gains)]


def _inside(grid: Grid, positions: Doubles, normals: Doubles, depths: Doubles) -> Flags:
    """(V, D): places that a vertex reaches without leaving the hull, with a margin; always the first."""
    points = positions[:, None] - normals[:, None] * (depths + MARGIN * grid.cell)[None, :, None]
    place = numpy.rint((points - grid.origin) / grid.cell).astype(numpy.int64)
    place = numpy.clip(place, 0, numpy.array(grid.counts) - 1)
    inside = grid.inside()[place[..., 2], place[..., 1], place[..., 0]]
    inside[:, 0] = True
    out: Flags = numpy.logical_and.accumulate(inside, axis=1)
    return out


def _disagreement(
    pictures: Sequence[Floats],
    cameras: Sequence[Camera],
    positions: Doubles,
    normals: Doubles,
    facing: Floats,
    depths: Doubles,
    patch: Any,
) -> Floats:
    """(V, D): how much the colours of the cameras differ around each vertex at each depth; 0 where no pair sees it."""
    seen = facing > 0
    number = numpy.full((len(cameras), len(positions)), -1)
    colours = []
    for k, camera in enumerate(cameras):
        own = numpy.flatnonzero(seen[k])
        number[k, own] = numpy.arange(len(own))
        points = positions[own, None] - normals[own, None] * depths[None, :, None]
        colours.append(_sampled(pictures[k], camera.project(points)))
    total = numpy.zeros((len(positions), len(depths)), numpy.float32)
    weight = numpy.zeros((len(positions), 1), numpy.float32)
    rays = [c.centre - positions for c in cameras]
    rays = [r / numpy.linalg.norm(r, axis=1, keepdims=True) for r in rays]
    for i in range(len(cameras)):
        for j in range(i):
            both = numpy.flatnonzero(
                seen[i] & seen[j] & ((rays[i] * rays[j]).sum(axis=1) > numpy.cos(numpy.radians(APART)))
            )
            if len(both) < COMMON:
                continue
            differences = colours[i][number[i, both]] - colours[j][number[j, both]]
            near = patch[both][:, both]
            cost = (near @ (differences**2).sum(axis=2)) / numpy.asarray(near.sum(axis=1))
            share = (numpy.minimum(facing[i, both], facing[j, both]) ** 2)[:, None]
            total[both] += share * numpy.minimum(cost / (3 * NOISE**2), MOST)
            weight[both] += share
    out: Floats = total / numpy.maximum(weight, 1e-6)
    return out


class _Bound:
    """What the silhouettes say of a surface within the hull: each of their pixels that the hull covers stays covered."""

    def __init__(self, found: Hull, cameras: Sequence[Camera], masks: Sequence[NDArray[Any] | None]) -> None:
        pairs = [(camera, mask) for camera, mask in zip(cameras, masks) if mask is not None]
        cameras = [camera for camera, _ in pairs]
        self._cameras, self._faces = cameras, found.indices
        positions = numpy.asarray(found.positions, numpy.float64)
        self._wanted = [
            cv2.erode(
                numpy.where(numpy.asarray(mask) > 0, coverage(positions, found.indices, camera), 0),
                _box(TOLERANCE),
            )
            > 0
            for camera, mask in pairs
        ]
        self._pixels = [camera.project(positions) for camera in cameras]
        away = [max(1e-9, float(numpy.median(camera.depth(positions)))) for camera in cameras]
        reach = REACH * found.grid.cell
        self._side = [max(1, round(reach * float(c.K[0, 0]) / z)) for c, z in zip(cameras, away)]

    def opened(self, moved: Doubles, regret: Floats) -> Flags:
        """(V,) vertices that must stay on the hull for pixels that a surface no longer covers: of those before each the one that
        loses least."""
        out = numpy.zeros(len(moved), bool)
        for camera, wanted, pixels, side in zip(self._cameras, self._wanted, self._pixels, self._side):
            lost = wanted & (coverage(moved, self._faces, camera) == 0)
            if not lost.any():
                continue
            height, width = lost.shape
            there = numpy.isfinite(pixels).all(axis=1)
            place = numpy.zeros(pixels.shape, numpy.int64)
            place[there] = numpy.floor(pixels[there])
            there &= (place >= 0).all(axis=1) & (place[:, 0] < width) & (place[:, 1] < height)
            near = cv2.dilate(lost.astype(numpy.uint8), _box(NEAR)) > 0
            there[there] = near[place[there, 1], place[there, 0]]
            own = numpy.flatnonzero(there)
            bins = (place[own, 1] // side) * (width // side + 1) + place[own, 0] // side
            order = numpy.lexsort((regret[own], bins))
            first = numpy.unique(bins[order], return_index=True)[1]
            out[own[order[first]]] = True
        return out


def _box(reach: int) -> NDArray[numpy.uint8]:
    return numpy.ones((2 * reach + 1, 2 * reach + 1), numpy.uint8)


class _Field:
    """Min-sum belief propagation between neighbours, which goes on from the messages of before."""

    def __init__(self, links: Any) -> None:
        links = links.tocoo()
        order = numpy.lexsort((links.row, links.col))
        self._source, target = links.row[order], links.col[order]
        count, edges = links.shape[0], len(order)
        # Links come in pairs: sorted by source, then target, the place of each is that of its opposite.
        self._back = numpy.lexsort((target, self._source))
        first = numpy.concatenate([[0], numpy.cumsum(numpy.bincount(target, minlength=count))])
        ones = numpy.ones(edges, numpy.float32)
        self._gather = sparse.csr_matrix((ones, numpy.arange(edges), first), (count, edges))
        self._messages: Floats | None = None

    def beliefs(self, cost: Floats, rounds: int) -> Floats:
        """(V, D) of the costs, after rounds of messages, halved with the former ones."""
        messages = self._messages
        if messages is None:
            messages = numpy.zeros((len(self._source), cost.shape[1]), numpy.float32)
        for _ in range(rounds):
            told = (cost + self._gather @ messages)[self._source] - messages[self._back]
            told -= told.min(axis=1, keepdims=True)
            for k in range(1, told.shape[1]):
                numpy.minimum(told[:, k], told[:, k - 1] + STIFFNESS, out=told[:, k])
            for k in range(told.shape[1] - 2, -1, -1):
                numpy.minimum(told[:, k], told[:, k + 1] + STIFFNESS, out=told[:, k])
            numpy.minimum(told, TEAR, out=told)
            told -= told.mean(axis=1, keepdims=True)
            messages = 0.5 * (messages + told)
        self._messages = messages
        out: Floats = cost + self._gather @ messages
        return out


def _least(beliefs: Floats) -> Doubles:
    """(V,) steps at which beliefs are least, by the parabola through each least one and its neighbours."""
    best = beliefs.argmin(axis=1)
    middle = numpy.clip(best, 1, beliefs.shape[1] - 2)
    row = numpy.arange(len(best))
    before, here, after = (beliefs[row, middle + k].astype(numpy.float64) for k in (-1, 0, 1))
    bend = before - 2 * here + after
    shift = numpy.clip(0.5 * (before - after) / numpy.maximum(bend, 1e-6), -0.5, 0.5)
    out: Doubles = best + numpy.where((best == middle) & (bend > 1e-6), shift, 0.0)
    return out
