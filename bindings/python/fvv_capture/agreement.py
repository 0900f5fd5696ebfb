"""What the other cameras say: which cameras do not agree with them, and what a camera's key dropped that they see.

A hull is an intersection: one camera that was pushed, turned round or taken for another cuts it wherever its silhouette is not that
of the others, and all silhouettes suffer alike. Which one it is shows when each is left out in turn: without it the others fill
their silhouettes again, while without any other camera little changes.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy
from fvv import Camera
from fvv.errors import Error
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

from . import hull

cv2: Any = optional_import("cv2", "capture")

Mask = NDArray[numpy.uint8]
Bounds = tuple[tuple[float, float, float], tuple[float, float, float]]

#: Cells along the longest side of the bounds: outlines to a pixel or two of a small picture.
CELLS = 96
#: What the mean IoU of the others gains without a camera, beyond what it gains without any other one: that camera disagrees.
GAIN = 0.025
#: The same where nothing explains it: keys that are not exact gain less.
UNEXPLAINED = 0.06
#: What a change of its mask must gain in IoU with the others' hull to be named as the cause.
CAUSE = 0.04
#: Below this mean IoU two cameras that spoil each other's test, as swapped ones do, are looked for together.
BROKEN = 0.7
#: `Key.changed` of a pixel that differs from the empty stage: the key's own threshold.
UNLIKE = 128
#: Up to this number of cameras each pair is tried; of more cameras, those that fit least.
SUSPECTS = 12
#: Cameras that are looked at together, at least.
FEWEST = 4
#: Pictures that a recording may be early or late by, to be found here.
MOMENTS = 6


@dataclasses.dataclass(frozen=True)
class Doubt:
    """A camera that disagrees with the others in a frame."""

    camera: int  #: Its place among all.
    iou: float  #: Of its mask and the others' hull.
    gain: float  #: Of the others' mean IoU without it.
    cause: str  #: What would explain it; empty: nothing that is looked for.
    better: float  #: IoU of its mask and the others' hull if it is so.


def find(
    cameras: Sequence[Camera | None],
    masks: Sequence[Mask | None],
    bounds: Bounds,
    options: hull.HullOptions,
    names: Sequence[str],
    moment: Callable[[int, int], Mask | None] = lambda camera, by: None,
) -> list[Doubt]:
    """Cameras that disagree in one frame, those that disagree most first; at most a third of all. names: of cameras, for causes.
    moment: the mask of a camera some pictures later; None: it has no such picture."""
    pairs = {i: pair for i, pair in _calibrated(cameras, masks).items() if pair[1].any()}
    there = list(pairs)
    side = max(high - low for low, high in zip(*bounds))
    coarse = dataclasses.replace(options, cell=side / CELLS, max_error=None, smoothing=0)

    def made(of: Sequence[int], missed: int = coarse.missed) -> hull.Hull | None:
        few = dataclasses.replace(
            coarse, least_views=min(coarse.least_views, max(1, len(of) - 1)), missed=missed
        )
        try:
            return hull.carve([pairs[i][0] for i in of], [pairs[i][1] for i in of], bounds, few)
        except Error:
            return None

    def mean_iou(of: Sequence[int], body: hull.Hull | None) -> float:
        if body is None or not len(body.indices):
            return 0.0
        seeing, own = [pairs[i][0] for i in of], [pairs[i][1] for i in of]
        values = hull.silhouette_iou(body.positions, body.indices, seeing, own)
        return float(numpy.mean([v for v in values if v is not None] or [0.0]))

    def gain(of: Sequence[int]) -> tuple[list[int], float]:
        """What to leave out, and what that gains beyond the usual; nothing: 0."""
        whole = made(of)
        sets = [[i] for i in of]
        found = _outstanding(sets, [without(of, whole, one) for one in sets])
        if found[1] < GAIN and mean_iou(of, whole) < BROKEN and len(of) > FEWEST + 1:
            sets = [list(pair) for pair in itertools.combinations(suspects(of), 2)]
            found = _outstanding(sets, [without(of, whole, one) for one in sets])
        return found

    def suspects(of: Sequence[int]) -> Sequence[int]:
        """Where pairs are too many, cameras whose masks have least in common with a hull that two may miss."""
        if len(of) <= SUSPECTS:
            return of
        body = made(of, missed=coarse.missed + 2)
        if body is None or not len(body.indices):
            return of[:SUSPECTS]
        return sorted(sorted(of, key=lambda i: mean_iou([i], body))[:SUSPECTS])

    def without(of: Sequence[int], whole: hull.Hull | None, left_out: Sequence[int]) -> float:
        rest = [k for k in of if k not in left_out]
        return mean_iou(rest, made(rest)) - mean_iou(rest, whole)

    out: list[tuple[int, float]] = []
    while len(there) >= FEWEST and len(out) < max(1, len(cameras) // 3):
        left_out, gained = gain(there)
        if gained < GAIN:
            break
        out += [(i, gained) for i in left_out]
        there = [i for i in there if i not in left_out]
    body = made(there) if out else None
    if body is None or not len(body.indices):
        return []
    doubted = {i: pairs[i] for i, _ in out}
    explained = [_explained(i, gain, doubted, body, names, moment) for i, gain in out]
    return [doubt for doubt in explained if doubt.cause or doubt.gain >= UNEXPLAINED]


def dropped(
    cameras: Sequence[Camera | None],
    outlines: Sequence[Mask | None],
    changed: Sequence[Mask | None],
    bounds: Bounds,
    options: hull.HullOptions,
) -> list[NDArray[numpy.bool_] | None]:
    """For each camera the pixels that its key dropped although its picture is unlike the empty stage there and all other cameras see
    something: a dark arm before a red wall is like a shadow of it to one camera, and no shadow hangs in the air.

    outlines: masks, which are not changed. changed: `Key.changed`; None: the mask was given, and nothing is missing. What the others see is
    a hull that one silhouette more may miss."""
    pairs = _calibrated(cameras, outlines)
    out: list[NDArray[numpy.bool_] | None] = [None] * len(cameras)
    if len(pairs) <= options.least_views + options.missed or all(change is None for change in changed):
        return out
    tolerant = dataclasses.replace(options, missed=options.missed + 1, smoothing=0)
    body = hull.carve([c for c, _ in pairs.values()], [m for _, m in pairs.values()], bounds, tolerant)
    if len(body.indices):
        for i, (camera, _) in pairs.items():
            change = changed[i]
            if change is not None:
                out[i] = (hull.coverage(body.positions, body.indices, camera) > 0) & (change > UNLIKE)
    return out


def added(masks: Sequence[Mask | None], more: Sequence[NDArray[numpy.bool_] | None]) -> list[Mask | None]:
    """Masks with more pixels."""
    return [
        mask if mask is None or pixels is None else numpy.where(pixels, 255, mask).astype(numpy.uint8)
        for mask, pixels in zip(masks, more)
    ]


def _calibrated(
    cameras: Sequence[Camera | None], masks: Sequence[Mask | None]
) -> dict[int, tuple[Camera, Mask]]:
    """Those that have both, by their place."""
    both = enumerate(zip(cameras, masks))
    return {i: (camera, mask) for i, (camera, mask) in both if camera is not None and mask is not None}


def _outstanding(sets: Sequence[list[int]], gains: Sequence[float]) -> tuple[list[int], float]:
    """The set that gains most, and by how much it gains more than is usual."""
    most = int(numpy.argmax(gains))
    others = [g for k, g in enumerate(gains) if k != most and not set(sets[k]) & set(sets[most])]
    return sets[most], gains[most] - float(numpy.median(others or [0.0]))


def _explained(
    index: int,
    gain: float,
    doubted: Mapping[int, tuple[Camera, Mask]],
    body: hull.Hull,
    names: Sequence[str],
    moment: Callable[[int, int], Mask | None],
) -> Doubt:
    """The change of a camera's mask that fits the others' hull best."""
    camera, mask = doubted[index]
    wanted = hull.coverage(body.positions, body.indices, camera) > 0
    own = _iou(mask > 0, wanted)
    causes: dict[str, float] = {}
    for other, (_, taken) in doubted.items():
        if other != index and taken.shape == mask.shape:
            causes[f"its recording is that of {names[other]}"] = _iou(taken > 0, wanted)
    causes["its pictures are upside down"] = _iou(mask[::-1, ::-1] > 0, wanted)
    causes["its pictures are mirrored"] = _iou(mask[:, ::-1] > 0, wanted)
    if mask.shape[0] == mask.shape[1]:
        for turns, text in ((1, "left"), (3, "right")):
            causes[f"its pictures are turned to the {text}"] = _iou(numpy.rot90(mask, turns) > 0, wanted)
    dx, dy = _shift(mask > 0, wanted)
    if (dx, dy) != (0, 0):
        moved = _iou(_moved(mask > 0, -dx, -dy), wanted)
        causes[f"it was moved after its calibration, by about {dx:+d}, {dy:+d} pixels"] = moved
    for by in range(-MOMENTS, MOMENTS + 1):
        later = moment(index, by) if by else None
        if later is not None:
            causes[f"its offset is wrong by {by:+d} pictures"] = _iou(later > 0, wanted)
    best = max(causes, key=lambda text: causes[text])
    if causes[best] - own < CAUSE:
        return Doubt(index, own, gain, "", own)
    return Doubt(index, own, gain, best, causes[best])


def _iou(a: NDArray[numpy.bool_], b: NDArray[numpy.bool_]) -> float:
    union = int((a | b).sum())
    return int((a & b).sum()) / union if union else 0.0


def _moved(mask: NDArray[numpy.bool_], dx: int, dy: int) -> NDArray[numpy.bool_]:
    out = numpy.zeros_like(mask)
    height, width = mask.shape
    if abs(dx) < width and abs(dy) < height:
        out[max(dy, 0) : height + min(dy, 0), max(dx, 0) : width + min(dx, 0)] = mask[
            max(-dy, 0) : height + min(-dy, 0), max(-dx, 0) : width + min(-dx, 0)
        ]
    return out


def _shift(mask: NDArray[numpy.bool_], wanted: NDArray[numpy.bool_]) -> tuple[int, int]:
    """By how much the mask lies right of and below what is wanted: the peak of their correlation, at most an eighth of a picture."""
    height, width = mask.shape
    far = max(height, width) // 8
    around = cv2.copyMakeBorder(mask.astype(numpy.float32), far, far, far, far, cv2.BORDER_CONSTANT, value=0)
    score = cv2.matchTemplate(around, wanted.astype(numpy.float32), cv2.TM_CCORR)
    y, x = numpy.unravel_index(int(score.argmax()), score.shape)
    return int(x) - far, int(y) - far


def sentences(doubts: Mapping[int, Sequence[Doubt]], names: Sequence[str]) -> list[str]:
    """Warnings of what was found in frames, by their numbers: one for each camera, with the cause that explains most."""
    out = []
    for index, name in enumerate(names):
        own = [(frame, d) for frame, found in doubts.items() for d in found if d.camera == index]
        if not own:
            continue
        frame, worst = max(own, key=lambda one: one[1].better - one[1].iou)
        text = (
            f"{name} does not agree with the other cameras in frame {frame} (IoU {worst.iou:.2f} with their hull; without it "
            f"their silhouettes gain {worst.gain:.2f})"
        )
        if worst.cause:
            text += f": perhaps {worst.cause} (IoU {worst.better:.2f} then)"
        else:
            text += f": look at its key and its calibration, or pass --exclude {name}"
        out.append(text)
    return out
