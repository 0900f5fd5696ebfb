"""Keying: from a picture to the mask of its subjects, by the colour of a backing, by the difference to a plate, or by both."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy
from fvv import Camera
from fvv.errors import UsageError
from fvv.interop.optional_import import optional_import
from numpy.typing import ArrayLike

from .arrays import Flags, Floats, Mask, Picture
from .backing import Backing, measured_backing, smoothed
from .clean_plate import COVERED, Plate, checked, drift, small
from .colours import ColourModel
from .graph import edge_weights, least_cut

cv2: Any = optional_import("cv2", "capture")

MODES = ("auto", "chroma", "difference", "both")
REFINEMENTS = ("none", "edge", "graph")
#: Standard deviations from the plate at which a pixel is foreground, if it hangs together with stronger ones.
THRESHOLD = 5.0
#: A piece of foreground needs pixels of this many times the threshold.
STRONG = 2.0
#: Brightness of a shadow or mild reflection, relative to the plate.
SHADOW = (0.45, 1.15)
#: Threshold of chromaticity in shadows, in standard deviations of one pixel.
SHADOW_CHROMA = 3.0
#: Part of the score within that the outline has.
SHARP = 0.5
#: Part of the outer frame of a picture that must have one saturated colour to be called a backing.
BACKED = 0.6
#: Where fewer of the plate's samples have its colour it may hold shadows.
ALWAYS = 0.9
#: Holes with the subject's colours are filled up to this part of the picture.
MOST_FILLED = 0.003
#: Scores between these leave it open what a pixel is.
OPEN = (0.6, 1.6)


@dataclasses.dataclass(frozen=True)
class KeyOptions:
    """How pictures are keyed."""

    mode: str = (
        "auto"  #: "auto", "chroma", "difference" or "both"; auto decides from the plate and the pictures.
    )
    backing: tuple[int, int, int] | None = None  #: RGB of the screen; None: measured.
    tolerance: float = 1.0  #: Factor of the thresholds: more takes less for foreground.
    shadows: bool = True  #: Shadows and mild reflections are background.
    min_piece: float = 0.0005  #: Smaller pieces are dropped; part of the picture's pixels.
    max_hole: float = 0.0002  #: Smaller holes are filled; part of the picture's pixels.
    work_side: int = 960  #: Pixels along the longer side that scores are computed at.
    #: Pixels by which drift of exposure is measured, about. A tenth of them takes a third of the time of a key.
    drift_samples: int = 40000
    refine: str = (
        "none"  #: "none"; "edge": the outline follows edges of the picture; "graph": the least cut, slow.
    )

    def __post_init__(self) -> None:
        if self.mode not in MODES:
            raise UsageError(f"key mode {self.mode!r}; one of {', '.join(MODES)} is expected")
        if self.refine not in REFINEMENTS:
            raise UsageError(f"refinement {self.refine!r}; one of {', '.join(REFINEMENTS)} is expected")
        if not self.tolerance > 0:
            raise UsageError(f"tolerance {self.tolerance}; a number above 0 is expected")
        for name, least in (("drift_samples", 400), ("work_side", 32)):
            if getattr(self, name) < least:
                raise UsageError(f"{name} {getattr(self, name)}; {least} or more are expected")
        for name in ("min_piece", "max_hole"):
            if not 0 <= getattr(self, name) < 1:
                raise UsageError(f"{name} {getattr(self, name)}; a part of the picture, 0 to 1, is expected")


@dataclasses.dataclass(frozen=True)
class Key:
    """The key of one picture."""

    mask: Mask  #: (height, width): 255 inside subjects, else 0.
    matte: Mask  #: (height, width): how much a pixel looks like foreground, 128 at the threshold, before pieces are dropped.
    changed: Mask  #: (height, width): the same for how unlike the plate it is, shadows included.
    confidence: float  #: 0 to 1, see `Keyer.key`.
    pieces: int  #: Connected pieces of the mask.
    spill: float  #: 0 to 1: pixels at the outline that have the tint of the backing; 0 where there is no backing.
    mode: str  #: "chroma", "difference" or "both".
    notes: tuple[str, ...] = ()  #: What a person should know of this key.


@dataclasses.dataclass(frozen=True)
class _Keyed:
    """A mask, and at working size what it was made from."""

    mask: Mask  #: Of the picture's size.
    small_mask: Mask
    score: Floats
    plain: Floats  #: The score before a cut.
    changed: Floats
    unsure: Flags | None
    pieces: int


def volume_matte(camera: Camera, low: ArrayLike, high: ArrayLike) -> Mask:
    """The garbage matte of a box: 255 where a camera may see something within it.

    low, high: (3,) metres, opposite corners along the axes of the world. The mask (camera.height, camera.width) is the hull of
    the box's projected surface; all 255 where the box reaches behind the camera. `UsageError`: a box without volume, or outside the picture.
    """
    lower, upper = numpy.asarray(low, numpy.float64), numpy.asarray(high, numpy.float64)
    if lower.shape != (3,) or upper.shape != (3,) or not (lower < upper).all():
        raise UsageError(
            f"box from {lower.tolist()} to {upper.tolist()}; three numbers each, low below high, are expected"
        )
    # Points on the surface, not corners alone: a lens bends the edges.
    line = numpy.linspace(0, 1, 9)
    grid = numpy.stack(numpy.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[((grid == 0) | (grid == 1)).any(axis=1)]
    points = lower + grid * (upper - lower)
    if (camera.depth(points) <= 0).any():
        return numpy.full((camera.height, camera.width), 255, numpy.uint8)
    pixels = camera.project(points)
    pixels = pixels[numpy.isfinite(pixels).all(axis=1)]
    matte = numpy.zeros((camera.height, camera.width), numpy.uint8)
    if len(pixels) >= 3:
        hull = cv2.convexHull(numpy.clip(pixels, -30000, 30000).astype(numpy.float32))
        cv2.fillConvexPoly(matte, numpy.rint(hull - 0.5).astype(numpy.int32), (255,))
    if not matte.any():
        raise UsageError(
            f"camera {camera.name or camera.id}: the box is outside its picture; a box that it sees is expected"
        )
    return matte


class Keyer:
    """Keys the pictures of one camera. It keeps no state between pictures: the same picture has the same key in any order."""

    def __init__(
        self,
        plate: Plate | None,
        options: KeyOptions | None = None,
        backing: Backing | None = None,
        learn: Sequence[Picture] = (),
    ) -> None:
        """plate: the background; None for a backing without one. backing: None: measured, from the plate, else from `learn`.
        learn: some pictures of the clip with subjects in them: they give the colours of the subject, which decide where the plate
        does not know the background and help `refine="graph"`, and without a plate the backing.

        `UsageError`: what the mode needs is missing, or sizes differ.
        """
        self.options = options = options or KeyOptions()
        self.notes: tuple[str, ...] = ()
        if plate is None and not len(learn) and backing is None and options.backing is None:
            raise UsageError(
                "no plate, no backing and no pictures to measure one; pass a plate, KeyOptions.backing or pictures to learn from"
            )
        self._size = plate.size if plate is not None else None
        for i, picture in enumerate(learn):
            checked(picture, self._size, f"picture {i} to learn from")
            self._size = (picture.shape[1], picture.shape[0])
        self._backing = backing or self._measured(plate, learn)
        self.mode = self._decided(plate, backing is not None or options.backing is not None)
        if self.mode == "chroma":
            plate = None
        if self.mode == "difference":
            self._backing = None
        self._plate = plate
        self._scale = 1.0
        if plate is not None:
            self._scale = min(1.0, options.work_side / max(plate.size))
            self._colour: Floats = small(plate.colour, self._scale).astype(numpy.float32)
            noise = small(plate.noise, self._scale).astype(numpy.float32)
            self._inverse: Floats = 1 / self._widened(noise)
            coverage = small(plate.coverage, self._scale)
            self._seen: Flags = coverage >= COVERED
            self._changed: Flags = coverage < ALWAYS
            if plate.unseen > 0.005:
                self._note(
                    f"{plate.unseen:.1%} of the background was never seen: a subject is there in every picture; "
                    "film a plate of the empty stage"
                )
        self._model: ColourModel | None = None
        if plate is not None and len(learn):
            self._model = self._learnt(learn)

    def _note(self, text: str) -> None:
        self.notes += (text,)

    def _measured(self, plate: Plate | None, learn: Sequence[Picture]) -> Backing | None:
        if self.options.mode == "difference":
            return None
        sources = [plate.colour] if plate is not None else list(learn)
        return measured_backing(sources, self.options.backing)

    def _decided(self, plate: Plate | None, given: bool) -> str:
        mode, backing = self.options.mode, self._backing
        if mode in ("difference", "both") and plate is None:
            raise UsageError(
                f"key mode {mode} without a plate; a plate of the empty stage, or of the clip, is expected"
            )
        if mode in ("chroma", "both") and (backing is None or not (given or backing.border >= 0.2)):
            raise UsageError(
                f"key mode {mode}: no saturated colour fills the border; a backing, or its colour, is expected"
            )
        if mode != "auto":
            return mode
        screen = backing is not None and (plate is None or backing.is_screen) and backing.border >= BACKED
        if backing is not None and (given or screen):
            chosen = "chroma" if plate is None else "both"
            self._note(
                f"auto: mode {chosen}: {backing.border:.0%} of the border has the colour {backing.rgb}"
                + (", and there is a plate" if plate is not None else "")
            )
            return chosen
        if plate is None:
            raise UsageError(
                "no plate, and no saturated colour fills the border; a plate or a backing is expected"
            )
        self._note("auto: mode difference: there is a plate, and no green or blue screen fills the border")
        return "difference"

    def _widened(self, noise: Floats) -> Floats:
        """Noise of the plate with what a camera's tremble and compression do at edges: a part of the steepness there."""
        across = cv2.Scharr(self._colour, cv2.CV_32F, 1, 0, scale=1 / 32)
        down = cv2.Scharr(self._colour, cv2.CV_32F, 0, 1, scale=1 / 32)
        wide: Floats = numpy.maximum(noise, 0.15 * numpy.maximum(numpy.abs(across), numpy.abs(down)))
        # Signal-dependent noise has the brightness of the pixel; what is brighter than the plate is noisier.
        return numpy.asarray(numpy.maximum(cv2.blur(wide, (3, 3)), numpy.float32(2)))

    def _learnt(self, learn: Sequence[Picture]) -> ColourModel | None:
        """The subject's colours: pixels well inside the plain keys of some pictures."""
        step = max(1, len(learn) // 12)
        reach = max(3, round(0.03 * max(self._colour.shape))) | 1
        box = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
        taken = []
        for picture in learn[::step]:
            reduced = small(picture, self._scale)
            score, _ = self._difference(reduced)
            mask = self._pieces(score, None)[0]
            # What was never seen without a subject, and is surrounded by one, is one.
            closed = _filled(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, box))
            inner = cv2.erode(closed, numpy.ones((5, 5), numpy.uint8)) > 0
            taken.append(reduced[inner & (~self._seen | (score > 1))])
        colours = numpy.concatenate(taken)
        if len(colours) < 200:
            self._note("the pictures to learn from show no subject; the cut goes by the plate alone")
            return None
        return ColourModel(colours, numpy.clip(self._colour + 0.5, 0, 255).astype(numpy.uint8), self._seen)

    def key(self, picture: Picture, garbage: Mask | None = None) -> Key:
        """The key of a picture (height, width, 3) uint8 RGB. garbage: (height, width), 0 where no subject can be; pieces wholly
        outside are dropped and others are cut.

        The confidence is the part of the outline with a clear score on both sides (above 1.6 times the threshold inside, below
        0.6 outside), less what is open (scores from 0.6 to 1.6) relative to the mask's area, less the mask over background that
        was never seen. It goes by the scores before a cut: a cut is always sure. It is 0 for an empty mask. `UsageError`: sizes differ.
        """
        keyed = self._keyed(picture, garbage)
        confidence = self._confidence(keyed.plain, keyed.small_mask, keyed.unsure)
        size = (picture.shape[1], picture.shape[0])
        matte, change = (
            numpy.clip(s * 127.5 + 0.5, 0, 255).astype(numpy.uint8) for s in (keyed.score, keyed.changed)
        )
        if matte.shape != picture.shape[:2]:
            matte, change = (cv2.resize(m, size, interpolation=cv2.INTER_LINEAR) for m in (matte, change))
        mask = keyed.mask
        notes = []
        if not mask.any():
            notes.append("nothing is keyed: the picture is like its background")
        spill = 0.0 if self._backing is None else self._backing.spill(picture, mask)
        return Key(mask, matte, change, confidence, keyed.pieces, spill, self.mode, tuple(notes))

    def mask(self, picture: Picture, garbage: Mask | None = None) -> Mask:
        """The mask of `key` alone, in less time."""
        return self._keyed(picture, garbage).mask

    def _keyed(self, picture: Picture, garbage: Mask | None) -> _Keyed:
        checked(picture, self._size)
        size = (picture.shape[1], picture.shape[0])
        if garbage is not None and garbage.shape != picture.shape[:2]:
            raise UsageError(
                f"garbage matte has {garbage.shape[1]}x{garbage.shape[0]} pixels; {size[0]}x{size[1]} are expected"
            )
        scale = min(1.0, self.options.work_side / max(size))
        reduced = small(picture, scale).astype(numpy.uint8)
        within = None
        if garbage is not None:
            within = cv2.resize(
                garbage, (reduced.shape[1], reduced.shape[0]), interpolation=cv2.INTER_NEAREST
            )
        score, changed, unsure = self._scores(reduced)
        score = plain = _sharpened(score)
        if self.options.refine == "graph" and self._plate is not None:
            score = self._cut(reduced, score, within)
        ratio = None if self._model is None else self._model.ratio(reduced)
        mask, pieces = self._pieces(score, within, ratio)
        full = self._enlarged(mask, score, size) if scale < 1 else mask
        if self.options.refine == "edge":
            full = _along_edges(picture, full)
        if garbage is not None:
            full = cv2.bitwise_and(full, (garbage > 0).astype(numpy.uint8) * 255)
        return _Keyed(full, mask, score, plain, changed, unsure, pieces)

    def _scores(self, reduced: Picture) -> tuple[Floats, Floats, Flags | None]:
        """(h, w) each: 1 at the threshold, more is foreground; the same before shadows are dropped; and where the background is
        not known."""
        if self._plate is None:
            assert self._backing is not None
            score = self._backing.score(reduced) / numpy.float32(self.options.tolerance)
            return score, score, None
        score, changed = self._difference(reduced)
        if self._model is not None and not self._seen.all():
            # Where the background was never seen only colours are left to go by.
            likely = numpy.clip(1 + 0.5 * cv2.blur(self._model.ratio(reduced), (3, 3)), 0, 3)
            score = numpy.where(self._seen, score, likely)
        if self.mode == "both":
            assert self._backing is not None
            chroma = self._backing.score(reduced) / numpy.float32(self.options.tolerance)
            # On the screen its colour decides: creases and shadows differ from the plate and not in colour.
            screen = self._backing.score(numpy.clip(self._colour, 0, 255).astype(numpy.uint8)) < 1
            score = numpy.where(screen, numpy.maximum(chroma, 0.5 * score), score)
        return score, numpy.maximum(score, changed), ~self._seen

    def _difference(self, reduced: Picture) -> tuple[Floats, Floats]:
        """Scores against the plate (h, w), without and with shadows."""
        gain, offset = drift(reduced, self._colour, self._seen, self.options.drift_samples)
        # OpenCV's loops over three channels take a fraction of numpy's.
        expected = cv2.transform(self._colour, numpy.column_stack([numpy.diag(gain), offset]))
        inverse = self._inverse
        seen = reduced.astype(numpy.float32)
        rest = cv2.multiply(cv2.subtract(seen, expected), inverse)
        limit = numpy.float32(THRESHOLD * self.options.tolerance)
        changed = score = smoothed(numpy.sqrt(_sum3(cv2.multiply(rest, rest))) / limit)
        # Brightness and chromaticity distortion, Horprasert, Harwood and Davis 1999.
        scaled, levels = cv2.multiply(expected, inverse), cv2.multiply(seen, inverse)
        norm = _sum3(cv2.multiply(scaled, scaled))
        alpha = _sum3(cv2.multiply(levels, scaled)) / numpy.maximum(norm, 1e-3)
        if self.options.shadows:
            # Means of the vectors, not of their sizes: noise cancels, and the tint of dark skin on a wooden floor stays.
            chroma = cv2.blur(
                cv2.subtract(levels, cv2.multiply(cv2.merge([alpha, alpha, alpha]), scaled)), (5, 5)
            )
            apart = numpy.sqrt(_sum3(cv2.multiply(chroma, chroma)))
            # A plate of a clip may hold shadows of somebody who stood still: what is brighter then is background too.
            brightest = numpy.where(self._changed, 1 / SHADOW[0], SHADOW[1])
            shade = (alpha > SHADOW[0]) & (alpha < brightest) & (_largest(expected) > 40)
            calm = apart / numpy.float32(SHADOW_CHROMA * self.options.tolerance)
            shaded = (shade & (calm < 1) & (score > 1)).astype(numpy.uint8)
            # A shadow is an area. Thin ones are outlines, where dark clothes mix with the background.
            area = cv2.morphologyEx(shaded, cv2.MORPH_OPEN, numpy.ones((7, 7), numpy.uint8)) > 0
            score = numpy.where(area, numpy.minimum(score, calm), score)
        return score.astype(numpy.float32), changed.astype(numpy.float32)

    def _cut(self, reduced: Picture, score: Floats, within: Mask | None) -> Floats:
        """The score after the least cut: 0 to 2, 1 on the outline."""
        evidence = numpy.clip(1.2 * (score - 1), -1.0, 2.5)
        if self._model is not None:
            ratio = numpy.clip(self._model.ratio(reduced), -4, 4)
            # Where the plate explains a pixel exactly its colour says nothing; where there is no plate it says all.
            weight = numpy.where(self._seen, 0.35, 0.8).astype(numpy.float32)
            evidence = numpy.where(self._seen, evidence, 0.5) + weight * ratio
        if within is not None:
            evidence = numpy.where(within > 0, evidence, -6)
        weights = edge_weights(reduced.astype(numpy.float32), self._colour)
        cut = least_cut(evidence.astype(numpy.float32), weights, 3.0)
        result: Floats = (2 * cut).astype(numpy.float32)
        return result

    def _pieces(self, score: Floats, within: Mask | None, ratio: Floats | None = None) -> tuple[Mask, int]:
        """The mask at working size: pieces with strong seeds and of some size, holes filled; and the number of pieces.

        ratio: how much colours are the subject's. A hole in a silhouette is a tunnel through the hull, so a larger one is filled
        too where its colours are the subject's: the plate is wrong there.
        """
        mask: Mask = (score > 1).astype(numpy.uint8)
        small_box = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
        mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, small_box)
        mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5)))
        seeds = score > (STRONG if self.options.refine != "graph" else 1.5)
        if within is not None:
            seeds &= within > 0
        count, pieces, figures, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
        strong = numpy.bincount(pieces[seeds], minlength=count)
        area = figures[:, cv2.CC_STAT_AREA]
        keep = (area >= self.options.min_piece * mask.size) & (strong >= 0.02 * area) & (strong > 3)
        keep[0] = False
        mask = keep[pieces].astype(numpy.uint8)
        count, holes, figures, _ = cv2.connectedComponentsWithStats(1 - mask, connectivity=4)
        fill = figures[:, cv2.CC_STAT_AREA] <= self.options.max_hole * mask.size
        if ratio is not None:
            likely = (
                numpy.bincount(holes.ravel(), (ratio > 0).ravel(), count) > 0.6 * figures[:, cv2.CC_STAT_AREA]
            )
            fill |= likely & (figures[:, cv2.CC_STAT_AREA] <= MOST_FILLED * mask.size)
        fill[0] = False
        mask |= fill[holes]
        return mask * 255, int(keep.sum())

    def _enlarged(self, mask: Mask, score: Floats, size: tuple[int, int]) -> Mask:
        """The mask at full size: its outline where the interpolated score passes 1, within a pixel of working size."""
        box = numpy.ones((3, 3), numpy.uint8)
        # Signed, so that interpolation finds the place of the threshold; clipped, so that strong scores do not push it.
        signed = numpy.clip(score - 1, -0.9, 0.9)
        signed = numpy.where(
            cv2.erode(mask, box) > 0, 0.9, numpy.where(cv2.dilate(mask, box) > 0, signed, -0.9)
        )
        large = cv2.resize(signed.astype(numpy.float32), size, interpolation=cv2.INTER_LINEAR)
        full: Mask = (large > 0).astype(numpy.uint8) * 255
        return full

    def _confidence(self, score: Floats, mask: Mask, unsure: Flags | None) -> float:
        area = int(numpy.count_nonzero(mask))
        if area == 0:
            return 0.0
        box = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
        inner, outer = cv2.erode(mask, box), cv2.dilate(mask, box)
        wide = cv2.dilate(outer, box)
        inside = (mask > 0) & (inner == 0)
        outside = (wide > 0) & (outer == 0)
        # The best of the inner band next to each place, for the outline itself is a mixture.
        strong = cv2.dilate(numpy.where(mask > 0, score, 0), box) > OPEN[1]
        clear = 0.5 * float(strong[inside].mean()) + 0.5 * float(
            (score[outside] < OPEN[0]).mean() if outside.any() else 1
        )
        near = cv2.dilate(wide, numpy.ones((15, 15), numpy.uint8)) > 0
        undecided = near & (score > OPEN[0]) & (score < OPEN[1])
        outline = max(1, int(inside.sum()))
        doubt = max(0.0, (float(undecided.sum()) - outline) / area)
        blind = 0.0 if unsure is None else float(unsure[mask > 0].mean())
        return float(numpy.clip(clear * math.exp(-2 * doubt) * (1 - 0.5 * blind), 0, 1))


def _sum3(levels: Floats) -> Floats:
    """The sum over the channels of (h, w, 3)."""
    total: Floats = cv2.transform(levels, numpy.ones((1, 3), numpy.float32))
    return total


def _largest(levels: Floats) -> Floats:
    """The largest of the channels of (h, w, 3)."""
    red, green, blue = cv2.split(levels)
    largest: Floats = cv2.max(cv2.max(red, green), blue)
    return largest


def _sharpened(score: Floats) -> Floats:
    """The score with the outline where it is half of that within: mixtures of subject and background pass a low threshold.

    Only pixels within two of the outline change. The limit keeps mixtures of a light and a dark part from being cut off.
    """
    mask = (score > 1).astype(numpy.uint8)
    inner = cv2.erode(mask, numpy.ones((5, 5), numpy.uint8)).astype(numpy.float32)
    number = cv2.blur(inner, (5, 5))
    within = cv2.blur(numpy.minimum(score, 16) * inner, (5, 5)) / numpy.maximum(number, 1e-6)
    band = (mask > 0) & (inner == 0) & (number > 0)
    sharp: Floats = numpy.where(band, score / numpy.maximum(1, SHARP * within), score)
    return sharp


def _filled(mask: Mask) -> Mask:
    """The mask without holes."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled: Mask = cv2.drawContours(numpy.zeros_like(mask), outlines, -1, (255,), cv2.FILLED)
    return filled


def _along_edges(picture: Picture, mask: Mask) -> Mask:
    """The mask with its outline moved to edges of the picture nearby, by the guided filter (He, Sun and Tang 2010)."""
    guide = picture.astype(numpy.float32) / 255
    soft = cv2.ximgproc.guidedFilter(guide, (mask > 0).astype(numpy.float32), 4, 1e-2)
    refined: Mask = (soft > 0.5).astype(numpy.uint8) * 255
    return refined
