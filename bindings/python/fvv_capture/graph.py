"""The outline as the least cut of a picture: weighs each pixel's evidence against the edges that an outline follows."""

from __future__ import annotations

from typing import Any

import numpy
from fvv.interop.optional_import import optional_import

from .arrays import Floats

cv2: Any = optional_import("cv2", "capture")

#: Iterations at the coarsest level; a level of twice the size needs half of the number before.
ROUNDS = 160
LEVELS = 3


def edge_weights(picture: Floats, plate: Floats, smooth: float = 5.0) -> Floats:
    """What an outline costs at each pixel (h, w), 0 to 1: little on edges of the picture (h, w, 3) that the plate lacks.

    Edges of the background are weakened after Sun, Zhang, Tang and Shum 2006, Background Cut. `smooth` is the contrast in levels
    at which the cost falls to a third.
    """

    def steepness(levels: Floats) -> Floats:
        soft = cv2.GaussianBlur(levels, (0, 0), 0.8)
        across = cv2.Scharr(soft, cv2.CV_32F, 1, 0, scale=1 / 32)
        down = cv2.Scharr(soft, cv2.CV_32F, 0, 1, scale=1 / 32)
        size: Floats = numpy.sqrt((across * across + down * down).max(axis=2))
        return size

    own = numpy.maximum(steepness(picture) - 0.7 * steepness(plate), 0)
    weights: Floats = 0.04 + 0.96 * numpy.exp(-own / smooth)
    return weights.astype(numpy.float32)


def least_cut(evidence: Floats, weights: Floats, smoothness: float) -> Floats:
    """The cut u (h, w), 0 to 1, that minimises smoothness * sum(weights |grad u|) - sum(evidence u).

    evidence: positive for foreground. The relaxed cut is convex and its level set at 0.5 is a least cut (Chan, Esedoglu and
    Nikolova 2006); found by the primal-dual method of Chambolle and Pock 2011, from coarse to fine.
    """
    pyramid = [(evidence, weights)]
    for _ in range(LEVELS - 1):
        e, g = pyramid[-1]
        if min(e.shape) < 32:
            break
        half = ((e.shape[1] + 1) // 2, (e.shape[0] + 1) // 2)
        # A pixel of twice the size has four times the evidence and twice the outline.
        pyramid.append(
            (
                2 * cv2.resize(e, half, interpolation=cv2.INTER_AREA),
                cv2.resize(g, half, interpolation=cv2.INTER_AREA),
            )
        )
    cut: Floats = (pyramid[-1][0] > 0).astype(numpy.float32)
    rounds = ROUNDS
    for e, g in reversed(pyramid):
        cut = cv2.resize(cut, (e.shape[1], e.shape[0]), interpolation=cv2.INTER_LINEAR)
        cut = _minimised(cut, e, smoothness * g, rounds)
        rounds //= 2
    return cut


def _minimised(cut: Floats, evidence: Floats, weights: Floats, rounds: int) -> Floats:
    step = numpy.float32(0.35)
    across, down = numpy.zeros_like(cut), numpy.zeros_like(cut)
    ahead = cut.copy()
    for _ in range(rounds):
        across[:, :-1] += step * (ahead[:, 1:] - ahead[:, :-1])
        down[:-1] += step * (ahead[1:] - ahead[:-1])
        over = numpy.maximum(1, numpy.sqrt(across * across + down * down) / weights)
        across /= over
        down /= over
        flow: Floats = across + down
        flow[:, 1:] -= across[:, :-1]
        flow[1:] -= down[:-1]
        after = numpy.clip(cut + step * (flow + evidence), 0, 1)
        ahead = 2 * after - cut
        cut = after
    return cut
