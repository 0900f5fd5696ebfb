"""The preview sheet of keys: one picture on which a person sees whether the keys are right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy
from fvv.errors import UsageError
from fvv.interop.optional_import import optional_import

from .arrays import Picture
from .keying import Key
from .opencv import named

cv2: Any = optional_import("cv2", "capture")

#: Height of a text line in pixels.
LINE = 18
OUTLINE = (255, 0, 64)
GOOD, POOR = (120, 230, 120), (255, 96, 64)
#: Below this a confidence is drawn in the colour of poor ones.
DOUBTFUL = 0.6


def draw(
    keys: Sequence[Sequence[Key]],
    pictures: Sequence[Sequence[Picture]],
    names: Sequence[str],
    frames: Sequence[int],
    height: int = 240,
) -> Picture:
    """The sheet (h, w, 3) RGB: a row for each camera, and for each frame the picture with the outline, and the matte.

    keys, pictures: [camera][frame], pictures (height, width, 3) RGB; names of cameras; numbers of frames; height of a cell in
    pixels. Outside the mask the picture is darkened, so that what a key lost is seen as dark, and what it took as bright.
    `UsageError`: nothing to draw, or the numbers of cameras, frames, keys and pictures differ.
    """
    if not names or not frames:
        raise UsageError(
            f"a sheet of {len(names)} cameras and {len(frames)} frames; at least one of each is expected"
        )
    rows = []
    if len(keys) != len(names) or len(pictures) != len(names):
        raise UsageError(
            f"keys of {len(keys)} and pictures of {len(pictures)} cameras; {len(names)} are expected"
        )
    for name, own, seen in zip(names, keys, pictures):
        if len(own) != len(frames) or len(seen) != len(frames):
            raise UsageError(
                f"camera {name}: {len(own)} keys and {len(seen)} pictures; {len(frames)} of each are expected"
            )
        cells = []
        for key, picture, frame in zip(own, seen, frames):
            with named(f"camera {name}", frame, is_file=False):
                cells.append(_cell(key, picture, f"{name} frame {frame}", height))
        rows.append(numpy.hstack(cells))
    width = max(row.shape[1] for row in rows)
    return numpy.vstack([numpy.pad(row, ((0, 0), (0, width - row.shape[1]), (0, 0))) for row in rows])


def _cell(key: Key, picture: Picture, title: str, height: int) -> Picture:
    """The outlined picture and the matte side by side, under a title with the confidence."""
    width = max(1, round(picture.shape[1] * height / picture.shape[0]))
    size = (width, height)
    mask = cv2.resize(key.mask, size, interpolation=cv2.INTER_NEAREST)
    small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    view = numpy.where(mask[..., None] > 0, small, small // 3)
    lines, _ = cv2.findContours(mask, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(view, lines, -1, OUTLINE, 1)
    matte = cv2.resize(key.matte, size, interpolation=cv2.INTER_AREA)
    body = numpy.hstack([view, numpy.repeat(matte[..., None], 3, axis=2)])
    head = numpy.full((LINE, body.shape[1], 3), 24, numpy.uint8)
    colour = GOOD if key.confidence >= DOUBTFUL else POOR
    text = f"{title}  {key.confidence:.2f}  {key.mode}"
    cv2.putText(head, text, (4, LINE - 5), cv2.FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv2.LINE_AA)
    cell: Picture = numpy.vstack([head, body]).astype(numpy.uint8)
    return cell
