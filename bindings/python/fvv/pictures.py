"""Pixels for screens: as eight bits of sRGB, and as PNG."""

from __future__ import annotations

import struct
import zlib

import numpy
from numpy.typing import NDArray

from .errors import UsageError

Bytes = NDArray[numpy.uint8]
#: Pixels in a row of what notebooks show.
WIDEST = 960


def on_screen(pixels: NDArray[numpy.generic]) -> Bytes:
    """Pixels as screens take them. pixels: (height, width, 3), uint8 or uint16 in sRGB, or floating point in linear light, 1 for
    white, as `Picture.pixels` are. Returns (height, width, 3), uint8 sRGB; light beyond 0 and 1 is clipped. The curve is that of
    IEC 61966-2-1."""
    if pixels.ndim != 3 or pixels.shape[2] != 3:
        raise UsageError(f"pixels: expected an array of shape (height, width, 3), found {pixels.shape}")
    if pixels.dtype == numpy.uint8:
        return numpy.asarray(pixels, numpy.uint8)
    if pixels.dtype == numpy.uint16:
        high: Bytes = (numpy.asarray(pixels, numpy.uint16) >> 8).astype(numpy.uint8)
        return high
    if not numpy.issubdtype(pixels.dtype, numpy.floating):
        raise UsageError(f"pixels: expected uint8, uint16 or floating point, found {pixels.dtype}")
    light = numpy.nan_to_num(pixels.astype(numpy.float64)).clip(0, 1)
    curve = numpy.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    levels: Bytes = numpy.rint(255 * curve).astype(numpy.uint8)
    return levels


def shrunk(pixels: Bytes, widest: int = WIDEST) -> Bytes:
    """The mean of squares of pixels, the least that make a row no wider than `widest`; what is left over at the right and at the
    bottom is cut off. (height, width, 3), uint8."""
    side = -(-pixels.shape[1] // widest)
    if side <= 1 or pixels.shape[0] < side:
        return pixels
    height, width = pixels.shape[0] // side, pixels.shape[1] // side
    squares = pixels[: height * side, : width * side].reshape(height, side, width, side, 3)
    means: Bytes = squares.mean(axis=(1, 3)).round().astype(numpy.uint8)
    return means


def png(pixels: Bytes) -> bytes:
    """A PNG file (ISO/IEC 15948) of sRGB. pixels: (height, width, 3), uint8. `UsageError`: another shape or type, or none."""
    if pixels.dtype != numpy.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or not pixels.size:
        raise UsageError(
            f"pixels: expected uint8 of (height, width, 3), found {pixels.dtype} of {pixels.shape}"
        )
    height, width, _ = pixels.shape
    # Each row but the first as its difference from the one above (filter 2), which compresses better.
    rows = pixels.reshape(height, 3 * width).copy()
    rows[1:] -= pixels.reshape(height, 3 * width)[:-1]
    filtered = numpy.concatenate([numpy.full((height, 1), 2, numpy.uint8), rows], axis=1)

    def chunk(kind: bytes, content: bytes) -> bytes:
        return (
            struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        )

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = [
        (b"IHDR", header),
        (b"sRGB", b"\0"),
        (b"IDAT", zlib.compress(filtered.tobytes())),
        (b"IEND", b""),
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(kind, content) for kind, content in parts)
