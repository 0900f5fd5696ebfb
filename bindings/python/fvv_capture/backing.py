"""Backings: the one colour of a green or blue screen, what is like it, and its spill on subjects."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy
from fvv.interop.optional_import import optional_import

from .arrays import Floats, Mask, Picture

cv2: Any = optional_import("cv2", "capture")

#: Levels of chroma (Cb and Cr, full range) that a backing has at least: less is no saturated colour.
SATURATED = 28.0
#: How many times stronger than the other two the channel of a green or blue screen is at least.
SCREEN = 1.25
#: The screen in shadow is at least this bright, relative to its mode.
DARKEST = 0.35
#: Spreads of the backing's chroma at which a pixel is foreground.
THRESHOLD = 5.0
#: Part of the backing's chroma that a foreground pixel at the outline may have before it counts as tinted.
TINT = 0.15


def _chroma(picture: Floats) -> tuple[Floats, Floats]:
    """Luma (h, w) and Cb, Cr about 0 (h, w, 2) of RGB levels; BT.601, full range."""
    levels = picture.astype(numpy.float32)
    luma = cv2.transform(levels, numpy.array([[0.299, 0.587, 0.114]], numpy.float32))
    matrix = numpy.array([[-0.168736, -0.331264, 0.5], [0.5, -0.418688, -0.081312]], numpy.float32)
    return luma, cv2.transform(levels, matrix)


def smoothed(score: Floats) -> Floats:
    """Scores (h, w) by the majority of 3x3 pixels: lone ones of noise vanish, and strong ones do not spread."""
    majority = numpy.sqrt(cv2.blur(numpy.minimum(score * score, 2), (3, 3)))
    smooth: Floats = numpy.where(majority > 1, cv2.max(score, majority), majority)
    return smooth


@dataclasses.dataclass(frozen=True)
class Backing:
    """A screen of one colour."""

    rgb: tuple[int, int, int]  #: Levels of its mode.
    spread: float  #: Levels of chroma by which the screen varies.
    border: float  #: 0 to 1: the part of the outer frame of the pictures that has this colour.

    @property
    def is_screen(self) -> bool:
        """It is green or blue, as screens are. Floors of wood and walls of brick have one colour, too."""
        red, green, blue = self.rgb
        return green > SCREEN * max(red, blue) or blue > SCREEN * max(red, green)

    def _own(self) -> tuple[float, Floats]:
        luma, chroma = _chroma(numpy.array([[self.rgb]], numpy.uint8))
        return max(float(luma.ravel()[0]), 1.0), chroma.reshape(2)

    def score(self, picture: Floats) -> Floats:
        """How far pixels (h, w, 3) RGB are from the backing: 1 at the threshold, more is foreground.

        The chroma of a screen in shadow shrinks with its luma. What is darker than any shadow on it is foreground.
        """
        luma, chroma = _chroma(picture)
        own, colour = self._own()
        bright = numpy.clip(luma / own, DARKEST, 1.3)[..., None]
        rest: Floats = chroma - bright * colour
        return smoothed(numpy.sqrt((rest * rest).sum(axis=2)) / numpy.float32(THRESHOLD * self.spread))

    def spill(self, picture: Picture, mask: Mask) -> float:
        """0 to 1: of the mask's pixels within three of its outline, the part that has the backing's tint."""
        edge = (mask > 0) & (cv2.erode(mask, numpy.ones((7, 7), numpy.uint8)) == 0)
        if not edge.any():
            return 0.0
        _, chroma = _chroma(picture[edge][None])
        _, colour = self._own()
        along = chroma[0] @ (colour / numpy.linalg.norm(colour))
        return float((along > TINT * numpy.linalg.norm(colour)).mean())

    def despilled(self, picture: Picture) -> Picture:
        """The picture (h, w, 3) RGB without the backing's tint: chroma along the backing's is limited to a quarter of that across.

        For the pictures that become textures. Subjects lose what they have of the backing's own colour.
        """
        luma, chroma = _chroma(picture)
        _, colour = self._own()
        axis = colour / numpy.linalg.norm(colour)
        along = chroma @ axis
        across = numpy.abs(chroma @ numpy.array([-axis[1], axis[0]], numpy.float32))
        chroma = chroma - numpy.maximum(along - 0.25 * across, 0)[..., None] * axis
        cb, cr = chroma[..., 0], chroma[..., 1]
        rgb = numpy.stack(
            [luma + 1.402 * cr, luma - 0.344136 * cb - 0.714136 * cr, luma + 1.772 * cb], axis=-1
        )
        clean: Picture = numpy.clip(rgb + 0.5, 0, 255).astype(numpy.uint8)
        return clean


def measured_backing(pictures: Sequence[Floats], rgb: tuple[int, int, int] | None = None) -> Backing | None:
    """The backing of pictures (h, w, 3) RGB: the robust mode of the chroma of their outer frame (a tenth on each side); None
    where that mode is not saturated. rgb: the backing's colour, when it is known; then only its spread is measured.
    """
    frames = []
    for picture in pictures:
        h, w = picture.shape[:2]
        y, x = max(1, h // 10), max(1, w // 10)
        step = max(1, int((h * w / 60000) ** 0.5))
        parts = (picture[:y], picture[-y:], picture[y:-y, :x], picture[y:-y, -x:])
        frames += [part[::step, ::step].reshape(-1, 3) for part in parts]
    levels = numpy.concatenate(frames) if frames else numpy.zeros((0, 3), numpy.float32)
    if not len(levels):
        return Backing(rgb, 3.0, 0.0) if rgb is not None else None
    luma, chroma = _chroma(levels[None])
    luma, chroma = luma[0], chroma[0]
    if rgb is None:
        table, _, _ = numpy.histogram2d(chroma[:, 0], chroma[:, 1], bins=64, range=[[-128, 128]] * 2)
        smooth = cv2.GaussianBlur(table.astype(numpy.float32), (0, 0), 1.0)
        # Grey is no screen, however much of it there is.
        centres = numpy.arange(64) * 4.0 - 126.0
        smooth[numpy.hypot(centres[:, None], centres[None]) < SATURATED] = 0
        if smooth.max() <= 0:
            return None
        row, column = numpy.unravel_index(int(smooth.argmax()), smooth.shape)
        near = numpy.hypot(chroma[:, 0] - centres[row], chroma[:, 1] - centres[column]) < 12
        if near.sum() < 20:
            return None
        r, g, b = (int(v + 0.5) for v in numpy.median(levels[near], axis=0))
        rgb = (r, g, b)
        if numpy.hypot(*_chroma(numpy.array([[rgb]], numpy.uint8))[1].ravel()) < SATURATED:
            return None
    own = Backing(rgb, 1.0, 0.0)
    distance = own.score(levels[None].astype(numpy.float32))[0] * THRESHOLD
    like = distance < 25
    if not like.any():
        return Backing(rgb, 3.0, 0.0)
    spread = float(numpy.clip(1.4826 * numpy.median(distance[like]), 1.5, 5.0))
    return Backing(rgb, spread, float((distance < THRESHOLD * spread).mean()))
