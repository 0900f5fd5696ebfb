"""Clean plates: what a camera sees without subjects, from an empty stage or from the clip itself.

A plate has a colour and a noise for each pixel. `plate_of` takes the pictures of an empty stage. `median_plate` takes pictures
with subjects in them, and finds at each pixel the colour that belongs to the background.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable, Sequence
from typing import Any

import numpy
from fvv.errors import UsageError
from fvv.interop.optional_import import optional_import

from .arrays import Flags, Floats, Picture
from .colours import ColourModel

cv2: Any = optional_import("cv2", "capture")

#: Levels of 255. Compression removes the noise of flat parts: less than this is not believed.
NOISE_FLOOR = 1.5
#: A plate is doubtful where fewer of the samples agree with it.
COVERED = 0.08
#: The clip's labelling is found in pictures of at most this many pixels along the longer side.
WORK_SIDE = 480
#: Samples of a clip that the labelling compares with one another.
MOST_SAMPLES = 34
#: Levels by which two samples of one thing differ at most.
SAME = 12
#: Candidate colours at each pixel.
CANDIDATES = 3
#: What it costs to call the background of a pixel unseen.
UNSEEN = 2.3
#: What it costs to call an island of still pixels within what moves background.
ISLAND = 2.6
PASSES = 3


@dataclasses.dataclass(frozen=True)
class Plate:
    """The background of one camera."""

    colour: Floats  #: (height, width, 3) RGB levels, 0 to 255.
    noise: Floats  #: (height, width, 3) standard deviation in levels, at least `NOISE_FLOOR`.
    coverage: Floats  #: (height, width) 0 to 1: samples that show this colour; 0: the background was never seen here.
    samples: int  #: Pictures that it was made of.

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.colour.shape[1], self.colour.shape[0]

    @property
    def unseen(self) -> float:
        """0 to 1: the part of the picture whose background was never seen: a subject stood there for the whole clip."""
        return float((self.coverage < COVERED).mean())


def checked(picture: Picture, size: tuple[int, int] | None = None, what: str = "a picture") -> Picture:
    """The picture. `UsageError` where it is not (height, width, 3) uint8, or not of the size (width, height)."""
    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != numpy.uint8:
        raise UsageError(
            f"{what} is {picture.dtype} of shape {picture.shape}; (height, width, 3) uint8 is expected"
        )
    if size is not None and (picture.shape[1], picture.shape[0]) != size:
        raise UsageError(
            f"{what} has {picture.shape[1]}x{picture.shape[0]} pixels; {size[0]}x{size[1]} are expected"
        )
    return picture


def plate_of(pictures: Iterable[Picture]) -> Plate:
    """The plate of an empty stage: the mean of the pictures (height, width, 3) RGB, and their spread.

    The pictures are taken one by one: a long sequence needs no more memory than a short one. Of a single picture the noise is
    estimated from its differences between neighbours (Immerkaer 1996, Fast Noise Variance Estimation).
    `UsageError`: there is no picture, or sizes differ.
    """
    rest = iter(pictures)
    head = next(rest, None)
    if head is None:
        raise UsageError("a plate needs at least one picture of the empty stage; 0 were given")
    first: Floats = checked(head, what="plate picture 0").astype(numpy.float32)
    total, squares = numpy.zeros_like(first), numpy.zeros_like(first)
    count = 1
    for picture in rest:
        # Squares of the distance to the first picture: those of the levels would lose the noise to rounding.
        distance = checked(picture, (first.shape[1], first.shape[0]), f"plate picture {count}") - first
        total += distance
        squares += distance * distance
        count += 1
    mean = total / count
    if count < 3:
        noise = numpy.full_like(first, _noise_of(first))
    else:
        noise = numpy.sqrt(numpy.maximum(squares / count - mean * mean, 0) * (count / (count - 1)))
        # Few pictures know the spread of a pixel badly; its neighbours know it too.
        noise = numpy.maximum(noise, cv2.blur(noise, (5, 5)))
    return Plate(
        first + mean, numpy.maximum(noise, NOISE_FLOOR), numpy.ones(first.shape[:2], numpy.float32), count
    )


def _noise_of(picture: Floats) -> float:
    """Standard deviation of the noise of a picture, after Immerkaer (1996)."""
    kernel = numpy.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], numpy.float32)
    # The median in place of the mean, for edges are not noise.
    return float(numpy.median(numpy.abs(cv2.filter2D(picture, -1, kernel))) / 0.6745 / 6.0)


def drift(
    picture: Floats, plate: Floats, believed: Flags | None = None, samples: int = 40000
) -> tuple[Floats, Floats]:
    """Gain and offset, (3,) each, that turn the plate's levels into the picture's: exposure and white balance drift.

    picture, plate: (height, width, 3); sizes are equal. believed: (height, width), where the plate is known. samples: pixels that are looked at, about. A line is fitted
    through medians of the picture's levels over bins of the plate's, iterated with the residual's own spread (a robust fit:
    subjects are outliers as long as they cover less than half of each range of levels).
    """
    step = max(1, int((picture.shape[0] * picture.shape[1] / samples) ** 0.5))
    seen, expected = picture[::step, ::step].astype(numpy.float32), plate[::step, ::step]
    use = numpy.ones(seen.shape[:2], bool) if believed is None else believed[::step, ::step]
    gain, offset = numpy.ones(3, numpy.float32), numpy.zeros(3, numpy.float32)
    for channel in range(3):
        a, b = expected[..., channel][use], seen[..., channel][use]
        inside = (a > 4) & (b > 2) & (b < 252) & (a < 252)
        a, b = a[inside], b[inside]
        if a.size < 100:
            continue
        order = numpy.argsort(a, kind="stable")
        bins = numpy.array_split(order, 16)
        x = numpy.array([numpy.median(a[part]) for part in bins])
        y = numpy.array([numpy.median(b[part]) for part in bins])
        weight = numpy.ones(len(bins))
        mx = my = numpy.float64(0)
        slope = 1.0
        for _ in range(8):
            mx, my = numpy.average(x, weights=weight), numpy.average(y, weights=weight)
            spread = numpy.average((x - mx) ** 2, weights=weight)
            # The prior towards a gain of 1 decides where a picture has one level only.
            steep = (numpy.average((x - mx) * (y - my), weights=weight) + 4.0) / (spread + 4.0)
            slope = float(numpy.clip(steep, 0.5, 2.0))
            rest = numpy.abs(y - my - slope * (x - mx))
            weight = 1.0 / numpy.maximum(rest, 0.5)
        gain[channel], offset[channel] = slope, my - slope * mx
    return gain, offset


def small(picture: Floats, scale: float) -> Floats:
    """The picture reduced by a factor of 0 to 1; each pixel is a mean of those that it covers."""
    if scale >= 1:
        return picture
    size = (max(1, round(picture.shape[1] * scale)), max(1, round(picture.shape[0] * scale)))
    reduced: Floats = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return reduced


def samples_of(count: int, most: int = MOST_SAMPLES) -> list[int]:
    """Indices of at most `most` frames, spread evenly over a clip of `count`."""
    taken = min(most, count)
    return [round(i * (count - 1) / max(1, taken - 1)) for i in range(taken)]


def median_plate(pictures: Sequence[Picture]) -> Plate:
    """The plate of a clip with subjects in it, from its pictures (height, width, 3) RGB, in order of time.

    The median over time fails where a subject stands for more than half of the clip. So each pixel has up to three candidate
    colours, those that most samples share, and one labelling of the whole picture chooses among them: background recurs over
    a long span of time, is coloured like what is around it and unlike what moves, and has no edge where neighbours have none
    (after Cohen 2005, Background estimation as a labeling problem; min-sum belief propagation). Where every candidate looks like
    the subject the background was never seen: coverage is 0 and the colour is filled in from around.
    `UsageError`: fewer than three pictures, or sizes differ.
    """
    if len(pictures) < 3:
        raise UsageError(f"a plate of a clip needs at least 3 pictures; {len(pictures)} were given")
    indices = samples_of(len(pictures))
    size = (pictures[0].shape[1], pictures[0].shape[0])
    full = [checked(pictures[i], size, f"picture {i}") for i in indices]
    scale = min(1.0, WORK_SIDE / max(size))
    reduced = numpy.stack([small(picture, scale) for picture in full])
    middle = numpy.median(reduced, axis=0).astype(numpy.float32)
    lines = [drift(picture, middle) for picture in reduced]
    stack = numpy.stack([_undrifted(p, *line) for p, line in zip(reduced, lines)])
    chosen, known = _labelled(stack)
    shows = numpy.abs(stack.astype(numpy.int16) - chosen.astype(numpy.int16)).max(axis=3) <= SAME
    shows &= known
    return _collected(full, lines, shows)


def _undrifted(picture: Floats, gain: Floats, offset: Floats) -> Picture:
    levels = ((picture - offset) / gain).astype(numpy.float32)
    undrifted: Picture = numpy.clip(levels + 0.5, 0, 255).astype(numpy.uint8)
    return undrifted


def _collected(full: Sequence[Picture], lines: Sequence[tuple[Floats, Floats]], shows: Flags) -> Plate:
    """Mean and spread, at full size, of the samples that show the background: shows (samples, h, w) at working size."""
    size = (full[0].shape[1], full[0].shape[0])
    total = numpy.zeros(full[0].shape, numpy.float32)
    squares = numpy.zeros_like(total)
    weights = numpy.zeros(total.shape[:2], numpy.float32)
    anchor: Floats | None = None
    for picture, (gain, offset), shown in zip(full, lines, shows):
        # Reduced pixels on an outline are mixtures: those a step inside count, and others where there is nothing else.
        inner = cv2.erode(shown.astype(numpy.uint8), numpy.ones((3, 3), numpy.uint8))
        weight: Floats = numpy.where(inner > 0, 1, 0.01 * shown).astype(numpy.float32)
        weight = cv2.resize(weight, size, interpolation=cv2.INTER_NEAREST)
        level = ((picture - offset) / gain).astype(numpy.float32)
        if anchor is None:
            anchor = level
        distance = level - anchor
        total += distance * weight[..., None]
        squares += distance * distance * weight[..., None]
        weights += weight
    assert anchor is not None
    sums = numpy.maximum(weights, 1e-6)[..., None]
    mean = total / sums
    noise = numpy.sqrt(numpy.maximum(squares / sums - mean * mean, 0))
    coverage = shows.mean(axis=0, dtype=numpy.float32)
    coverage = cv2.resize(
        numpy.where(shows.sum(axis=0) < 2, 0, coverage), size, interpolation=cv2.INTER_NEAREST
    )
    colour = numpy.clip(_filled(anchor + mean, coverage == 0), 0, 255)
    return Plate(colour, numpy.maximum(noise, NOISE_FLOOR), coverage, len(full))


def _filled(colour: Floats, hole: Flags) -> Floats:
    """The picture with holes filled smoothly from around: levels of a pyramid, coarse to fine (pull-push)."""
    if not hole.any() or hole.all():
        return colour
    weight: Floats = (~hole).astype(numpy.float32)
    return _pulled(colour * weight[..., None], weight)


def _pulled(sums: Floats, weight: Floats) -> Floats:
    mean: Floats = sums / numpy.maximum(weight, 1e-6)[..., None]
    if weight.min() > 0 or min(weight.shape) < 2:
        return mean
    half = ((weight.shape[1] + 1) // 2, (weight.shape[0] + 1) // 2)
    coarse = _pulled(
        cv2.resize(sums, half, interpolation=cv2.INTER_AREA),
        cv2.resize(weight, half, interpolation=cv2.INTER_AREA),
    )
    around = cv2.resize(coarse, (weight.shape[1], weight.shape[0]), interpolation=cv2.INTER_LINEAR)
    filled: Floats = numpy.where(weight[..., None] > 0, mean, around)
    return filled


def _labelled(stack: Picture) -> tuple[Picture, Flags]:
    """The chosen colour (h, w, 3) of samples (n, h, w, 3), and where it is believed to be background."""
    colours, counts, spans = _candidates(stack)
    n = len(stack)
    still = counts[0] >= 0.88 * n
    stable, surroundings = _outer(still)
    sure = (counts[0] >= 0.6 * n) & (counts[0] < 0.97 * n)
    chosen = colours[0]
    cost = ratio = numpy.zeros(counts.shape, numpy.float32)
    pick = numpy.zeros(counts.shape[1:], numpy.intp)
    for _ in range(PASSES):
        # What moves, by what is known so far, gives the colours of the subject; each pass knows more of them.
        moving = numpy.stack([sure & (_apart(p, chosen) > 3 * SAME) for p in stack])
        if moving.any():
            ratio = ColourModel(stack[moving], colours[0], surroundings).ratio(colours)
        cost = 2.0 * (1 - counts / n) + 3.0 * (1 - spans) + 0.8 * numpy.clip(ratio, -5, 3)
        cost[counts < 2] = 12
        cost[0][still] = numpy.maximum(cost[0][still], 0) + ISLAND
        cost[0][stable] = -20
        unknown = numpy.where(stable, 20, UNSEEN).astype(numpy.float32)
        label = _propagated(cost.astype(numpy.float32), unknown, colours.astype(numpy.float32))
        pick = numpy.minimum(label, CANDIDATES - 1)
        chosen = numpy.take_along_axis(colours, pick[None, ..., None], axis=0)[0]
        sure = label < CANDIDATES
    # Subjects are thick. Thin unseen parts are edges of the background, where samples of one thing differ.
    thin = ~sure & (cv2.morphologyEx((~sure).astype(numpy.uint8), cv2.MORPH_OPEN, _disc(7)) == 0)
    thin &= (counts * (spans > 0.7)).max(axis=0) >= 0.3 * n
    best = numpy.take_along_axis(colours, cost.argmin(axis=0)[None, ..., None], axis=0)[0]
    known = sure | thin
    # What is enclosed by unseen parts is more of the same subject, unless its colour is clearly the background's.
    clear = numpy.take_along_axis(ratio, pick[None], axis=0)[0] < -1.5
    _, holes, figures, _ = cv2.connectedComponentsWithStats(known.astype(numpy.uint8), connectivity=4)
    enclosed = figures[:, cv2.CC_STAT_AREA] <= 0.01 * known.size
    enclosed[0] = False
    known &= ~enclosed[holes] | clear
    return numpy.where(thin[..., None], best, chosen), known


def _disc(diameter: int) -> Picture:
    disc: Picture = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter, diameter))
    return disc


def _outer(still: Flags) -> tuple[Flags, Flags]:
    """`still` without islands within what moves, which may be the core of a subject; and of that what is background for sure:
    pieces at the picture's border, or large."""
    box = numpy.ones((3, 3), numpy.uint8)
    opened = cv2.morphologyEx(still.astype(numpy.uint8), cv2.MORPH_OPEN, box)
    _, pieces, figures, _ = cv2.connectedComponentsWithStats(opened, connectivity=4)
    left, top = figures[:, cv2.CC_STAT_LEFT], figures[:, cv2.CC_STAT_TOP]
    right, bottom = left + figures[:, cv2.CC_STAT_WIDTH], top + figures[:, cv2.CC_STAT_HEIGHT]
    area = figures[:, cv2.CC_STAT_AREA]
    island = (left > 0) & (top > 0) & (right < still.shape[1]) & (bottom < still.shape[0])
    island &= area <= 0.05 * still.size
    island[0] = False
    sure = ~island
    sure[0] = False
    # Small ones are gaps between limbs as often as cores, and their colours decide.
    island &= area >= 0.0004 * still.size
    stable = still & (cv2.dilate(island[pieces].astype(numpy.uint8), box) == 0)
    return stable, sure[pieces]


def _apart(a: Picture, b: Picture) -> Picture:
    """The largest difference of the three channels, (h, w)."""
    red, green, blue = cv2.split(cv2.absdiff(a, b))
    return numpy.asarray(cv2.max(cv2.max(red, green), blue))


def _candidates(stack: Picture) -> tuple[Picture, Floats, Floats]:
    """Up to three colours at each pixel that most samples share: (3, h, w, 3), how many share each, and the part of the clip
    between the first and the last of them."""
    n, h, w, _ = stack.shape
    counts = numpy.ones((n, h, w), numpy.uint8)
    for i, j in itertools.combinations(range(n), 2):
        same = _apart(stack[i], stack[j]) <= SAME
        counts[i] += same
        counts[j] += same
    colours = numpy.zeros((CANDIDATES, h, w, 3), numpy.uint8)
    number = numpy.zeros((CANDIDATES, h, w), numpy.float32)
    span = numpy.zeros((CANDIDATES, h, w), numpy.float32)
    free = numpy.ones((n, h, w), bool)
    for k in range(CANDIDATES):
        best = numpy.where(free, counts, 0).argmax(axis=0)
        colours[k] = numpy.take_along_axis(stack, best[None, ..., None], axis=0)[0]
        near = numpy.stack([_apart(picture, colours[k]) <= SAME for picture in stack])
        near &= free
        number[k] = near.sum(axis=0)
        # A single sample that matches by chance would stretch the span: two in a row are needed.
        pair = near[1:] & near[:-1]
        last = (n - 1) - pair[::-1].argmax(axis=0)
        span[k] = numpy.where(pair.any(axis=0), (last - pair.argmax(axis=0) + 1) / n, 0)
        for i, picture in enumerate(stack):
            free[i] &= _apart(picture, colours[k]) > 2 * SAME
    return colours, number, span


def _propagated(cost: Floats, unknown: Floats, colours: Floats, rounds: int = 30) -> Floats:
    """The label of least cost at each pixel, 3 colours or unknown: min-sum belief propagation over 4 neighbours.

    cost (3, h, w); unknown (h, w); colours (3, h, w, 3). Neighbours cost what their colours differ by, up to a limit.
    """
    limit, scale, border = 3.0, 1 / 15.0, 0.8
    unary = numpy.concatenate([cost, unknown[None]])
    labels, h, w = unary.shape
    pairs = {}
    for axis in (0, 1):
        a = colours.take(range(0, colours.shape[axis + 1] - 1), axis + 1)
        b = colours.take(range(1, colours.shape[axis + 1]), axis + 1)
        table = numpy.full((labels, labels, *a.shape[1:3]), border, numpy.float32)
        table[-1, -1] = 0
        for i in range(labels - 1):
            for j in range(labels - 1):
                table[i, j] = numpy.minimum(numpy.abs(a[i] - b[j]).max(axis=2) * scale, limit)
        pairs[axis] = table
    # messages[d]: what a pixel hears from its neighbour above, below, left, right.
    messages = numpy.zeros((4, labels, h, w), numpy.float32)
    for _ in range(rounds):
        belief = unary + messages.sum(axis=0)
        fresh = numpy.zeros_like(messages)
        for axis in (0, 1):
            low = tuple([slice(None)] + [slice(0, -1) if a == axis else slice(None) for a in (0, 1)])
            high = tuple([slice(None)] + [slice(1, None) if a == axis else slice(None) for a in (0, 1)])
            before, after = 2 * axis, 2 * axis + 1
            down = (belief - messages[after])[low]
            up = (belief - messages[before])[high]
            fresh[before][high] = (down[:, None] + pairs[axis]).min(axis=0)
            fresh[after][low] = (up[None] + pairs[axis]).min(axis=1)
        fresh -= fresh.min(axis=1, keepdims=True)
        messages = 0.5 * messages + 0.5 * fresh
    labels_of: Floats = (unary + messages.sum(axis=0)).argmin(axis=0)
    return labels_of
