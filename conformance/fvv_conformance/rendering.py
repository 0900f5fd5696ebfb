"""Compares pictures that renderers draw with those of the render vectors.

A vector is a folder: vector.json (frame, view, least PSNR), input.fvv, picture.png, which is what fvvrender draws, and area.png,
which says where pictures are compared: 255 is surface away from outlines and from jumps of the depth, 128 other surface, 0
none. Two renderers that are right may show different faces at an outline, but not away from it.
"""

from __future__ import annotations

import base64
import binascii
import fnmatch
import json
import pathlib
from typing import NamedTuple

from .cases import BadCase
from .decoder import Decoder
from .outputs import table

#: Pixels outside of the surface that may be drawn, as a share of its pixels.
OUTSIDE = 0.01
INNER = 255


class Vector(NamedTuple):
    """wanted: (height, width, 3) uint8. area: (height, width) uint8."""

    name: str
    path: pathlib.Path
    about: dict
    wanted: object
    area: object


class Drawn(NamedTuple):
    """A renderer on one vector. psnr: dB over the inner area, None where nothing was drawn. problem: why it fails, or None.
    unsupported: what the renderer lacks, or None."""

    vector: str
    psnr: float | None
    outside: float | None
    problem: str | None
    unsupported: str | None


class Result(NamedTuple):
    name: str
    version: str
    drawn: list


def add_parser(commands):
    one = commands.add_parser("render", help="compare pictures that renderers draw with those of fvvrender")
    one.add_argument(
        "--renderer",
        metavar="CMD",
        action="append",
        required=True,
        help="a program that speaks the protocol; may be repeated",
    )
    one.add_argument(
        "--vectors", metavar="DIR", type=pathlib.Path, help="default: those that came with the package"
    )
    one.add_argument("--only", metavar="GLOB", action="append", help="names of vectors; may be repeated")
    one.add_argument(
        "--timeout", metavar="S", type=float, default=120, help="seconds for one answer (default 120)"
    )
    one.add_argument("--json", metavar="FILE", help="write the result; - is standard output")
    one.add_argument("--force", action="store_true", help="replace files that exist")


def default_folder():
    """The vectors of a wheel, or those of the checkout."""
    here = pathlib.Path(__file__).resolve().parent
    installed = here / "vectors"
    return installed if installed.is_dir() else here.parent / "render/vectors"


def load_vectors(folder, only=None):
    """The vectors in a folder, by name. only: patterns of names; None: all. Needs numpy and Pillow."""
    try:
        import numpy
        from PIL import Image
    except ImportError as error:
        raise BadCase(
            f"render vectors need numpy and Pillow: {error}; pip install fvv-conformance[render]"
        ) from error
    out = []
    for path in sorted(pathlib.Path(folder).glob("*/vector.json")):
        home = path.parent
        if only and not any(fnmatch.fnmatch(home.name, pattern) for pattern in only):
            continue
        about = json.loads(path.read_text(encoding="utf-8"))
        wanted = numpy.asarray(Image.open(home / "picture.png").convert("RGB"))
        area = numpy.asarray(Image.open(home / "area.png"))
        if wanted.shape[:2] != area.shape or not (area == INNER).any():
            raise BadCase(f"{home}: picture.png and area.png do not fit")
        out.append(Vector(home.name, home / "input.fvv", about, wanted, area))
    if not out:
        raise BadCase(f"{folder}: no render vectors found")
    return out


def pixels_of(answer, shape):
    """(height, width, 3) of an answer, or a text that says what is wrong with it."""
    import numpy

    height, width = shape
    if (answer.get("width"), answer.get("height")) != (width, height):
        return f"expected {width} x {height} pixels, found {answer.get('width')} x {answer.get('height')}"
    try:
        data = base64.b64decode(answer.get("rgba") or "", validate=True)
    except (binascii.Error, TypeError, ValueError):
        return "rgba: expected base64"
    if len(data) != 4 * width * height:
        return f"rgba: expected {4 * width * height} bytes, found {len(data)}"
    return numpy.frombuffer(data, numpy.uint8).reshape(height, width, 4)[..., :3]


def judge(vector, answer):
    """What an answer of a renderer, or the reason why there is none, says of a vector."""
    import numpy

    if not isinstance(answer, dict):
        return Drawn(vector.name, None, None, str(answer), None)
    if "unsupported" in answer:
        return Drawn(vector.name, None, None, None, str(answer["unsupported"]))
    found = pixels_of(answer, vector.area.shape)
    if isinstance(found, str):
        return Drawn(vector.name, None, None, found, None)
    inner = vector.area == INNER
    error = numpy.square(found[inner].astype(float) - vector.wanted[inner]).mean()
    psnr = float(10 * numpy.log10(255**2 / max(error, 1e-4)))
    surface = vector.area > 0
    outside = float((found[~surface] > 0).any(axis=-1).sum() / surface.sum())
    problem = None
    if psnr < vector.about["psnr"]:
        problem = f"{psnr:.1f} dB, expected at least {vector.about['psnr']}"
    elif outside > OUTSIDE:
        problem = (
            f"{100 * outside:.1f} % of the surface is drawn beside it, expected {100 * OUTSIDE:g} % at most"
        )
    return Drawn(vector.name, psnr, outside, problem, None)


def test_renderer(command, vectors, timeout, on_step=lambda: None):
    requests = [
        {
            "op": "render",
            "path": str(vector.path),
            "frame": vector.about["frame"],
            "view": vector.about["view"],
        }
        for vector in vectors
    ]
    drawn = []
    with Decoder(command, timeout) as renderer:
        for vector, answer in zip(vectors, renderer.decode_all(requests), strict=True):
            drawn.append(judge(vector, answer))
            on_step()
    return Result(renderer.name, renderer.version, drawn)


def lines_of(results):
    """A table of decibels, and a line for each vector that fails or is not supported."""
    names = [drawn.vector for drawn in results[0].drawn]
    rows = []
    for one in results:
        rows.append(
            [
                f"{one.name} {one.version}".strip(),
                *("-" if d.psnr is None else f"{d.psnr:.1f}" for d in one.drawn),
            ]
        )
    yield from table(["renderer, dB", *names], rows)
    for one in results:
        for drawn in one.drawn:
            if drawn.problem:
                yield f"{one.name}: {drawn.vector}: {drawn.problem}"
            if drawn.unsupported:
                yield f"{one.name}: {drawn.vector}: not supported: {drawn.unsupported}"


def as_json(results):
    return {
        "fvv_conformance_render": 1,
        "renderers": [
            {"name": one.name, "version": one.version, "vectors": [line._asdict() for line in one.drawn]}
            for one in results
        ],
    }
