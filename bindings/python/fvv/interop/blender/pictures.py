"""What cameras filmed, as cameras without lens see it: Blender's have none. Needs no Blender."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy
from numpy.typing import NDArray

from ..._core import Camera, Picture
from ...pictures import on_screen
from ..conventions import straightened

GREY = 128
#: Pixels along which a camera loses its weight towards the border of what was sent (clause 17.5).
BORDER = 8.0


@dataclasses.dataclass
class StraightPicture:
    """The picture of a camera without lens."""

    identifier: int
    camera: Camera  #: Of the picture's size, without lens and skew.
    centre: NDArray[numpy.float64]  #: Metres from the origin of the scene.
    image: Any  #: Blender's.


@dataclasses.dataclass(frozen=True)
class _Map:
    """From a tile to the whole picture without lens."""

    camera: Camera
    empty: NDArray[numpy.uint8]  #: (height, width, 4): grey, and how far inside.
    corner: tuple[int, int] | None  #: Row and column of the tile, where it has neither lens nor skew.
    is_there: NDArray[numpy.bool_]  #: (height, width): otherwise which pixels the tile shows, and
    at: NDArray[numpy.float64]  #: (pixels, 2): where.


class Straightener:
    """Takes lenses out of pictures. Keeps of each camera where pixels come from."""

    def __init__(self) -> None:
        self._maps: dict[int, tuple[tuple[object, ...], _Map]] = {}

    def run(self, whole: Camera, picture: Picture) -> tuple[Camera, NDArray[numpy.uint8]]:
        """The camera, and its whole picture at the scale of what was sent: (height, width, 4), red, green, blue, and how far a pixel is
        inside of what was sent, 0 to 255. Grey where nothing was sent."""
        tile = picture.camera
        assert tile is not None, "the atlas has no camera"
        pixels = on_screen(picture.pixels)
        exact = (tile.K, tile.R, tile.t, tile.distortion)
        key = (whole.width, whole.height, picture.source, *(one.tobytes() for one in exact))
        known = self._maps.get(whole.id)
        if known is None or known[0] != key:
            known = self._maps[whole.id] = (key, _map(whole, picture))
        found = known[1]
        out = found.empty.copy()
        if found.corner is not None:
            row, column = found.corner
            out[row : row + tile.height, column : column + tile.width, :3] = pixels
        else:
            out[found.is_there, :3] = numpy.rint(sampled(pixels, found.at))
        return found.camera, out


def _map(whole: Camera, picture: Picture) -> _Map:
    tile = picture.camera
    assert tile is not None
    x, y, width, height = picture.source
    across, down = tile.width / width, tile.height / height
    left, top = round(x * across), round(y * down)  # the pixels of both are in the same places
    size = (
        max(round(whole.width * across), left + tile.width),
        max(round(whole.height * down), top + tile.height),
    )
    K = numpy.array(tile.K)
    K[0, 1] = 0
    K[:2, 2] += (left, top)
    ideal = Camera(whole.id, K, tile.R, tile.t, size)
    at, _, is_there = straightened(tile, ideal)
    distance = numpy.minimum(at - 0.5, (tile.width - 0.5, tile.height - 0.5) - at).min(axis=-1)
    empty = numpy.full((ideal.height, ideal.width, 4), GREY, numpy.uint8)
    empty[..., 3] = numpy.rint(255 * (numpy.nan_to_num(distance, nan=0.0) / BORDER).clip(0, 1))
    is_straight = tile.lens == "none" and tile.K[0, 1] == 0
    return _Map(ideal, empty, (top, left) if is_straight else None, is_there, at[is_there])


def sampled(pixels: NDArray[numpy.uint8], at: NDArray[numpy.float64]) -> NDArray[numpy.float64]:
    """Bilinear: (n, 2) places in a picture to (n, 3)."""
    height, width = pixels.shape[:2]
    place = numpy.nan_to_num(at, nan=0.0) - 0.5
    column = place[:, 0].clip(0, width - 1)
    row = place[:, 1].clip(0, height - 1)
    left, top = column.astype(numpy.intp), row.astype(numpy.intp)
    right, bottom = numpy.minimum(left + 1, width - 1), numpy.minimum(top + 1, height - 1)
    across, down = (column - left)[:, None], (row - top)[:, None]
    above = pixels[top, left] * (1 - across) + pixels[top, right] * across
    below = pixels[bottom, left] * (1 - across) + pixels[bottom, right] * across
    mixed: NDArray[numpy.float64] = above * (1 - down) + below * down
    return mixed
