"""Masks as segmentation programs write them (spec/capture.md): all mean the same pixels."""

import json
import shutil

import numpy as np
import pytest
from conftest import run, tool_path
from PIL import Image

FRAMES = 2
QUICK = ("--quality", 30, "--visibility", "none", "--match-colours", "off", "--texture-inset", "off")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "made"
    run("fvvsynth", "--rig", "small", "--cameras", 3, "--size", "96x64", "--frames", FRAMES, "-o", folder)
    return folder


@pytest.fixture(scope="module")
def stream(made):
    run("fvvmux", made, "-o", made.parent / "made.fvv", *QUICK)
    return (made.parent / "made.fvv").read_bytes()


def masks_of(folder):
    capture = json.loads((folder / "capture.json").read_text())
    for camera in capture["cameras"]:
        pattern = camera["masks"] if isinstance(camera["masks"], str) else camera["masks"]["pattern"]
        for frame in range(FRAMES):
            yield folder / (pattern % frame)


def rewrite(source, target, write):
    shutil.copytree(source, target)
    for path in masks_of(target):
        write(np.asarray(Image.open(path).convert("L")) > 127, path)
    return target


def grey(value):
    return lambda mask, path: Image.fromarray(np.where(mask, value, 0).astype(np.uint8)).save(path)


def sixteen(value):
    return lambda mask, path: Image.fromarray(np.where(mask, value, 0).astype(np.uint16)).save(path)


def coloured(*rgb):
    return lambda mask, path: Image.fromarray((mask[..., None] * np.array(rgb)).astype(np.uint8)).save(path)


def palette(mask, path):
    image = Image.fromarray(mask.astype(np.uint8), "P")
    image.putpalette([0, 0, 0, 128, 0, 0] + [0] * 762)
    image.save(path)


def two_objects(mask, path):
    """One is bright, the other dark: both are foreground."""
    left = np.arange(mask.shape[1])[None, :] < mask.shape[1] // 2
    rgb = np.where(left[..., None], [255, 255, 0], [0, 0, 64]) * mask[..., None]
    Image.fromarray(rgb.astype(np.uint8)).save(path)


def numbers(*values):
    """Objects beside each other, each with a grey of its own."""

    def write(mask, path):
        value = np.repeat(values, mask.shape[1] // len(values) + 1)[: mask.shape[1]]
        Image.fromarray(np.where(mask, value[None, :], 0).astype(np.uint8)).save(path)

    return write


def cut_out(mask, path):
    """Dark colours under alpha, which alone counts."""
    rgba = np.full((*mask.shape, 4), 20, np.uint8)
    rgba[..., 3] = mask * 255
    Image.fromarray(rgba).save(path)


def grey_cut_out(mask, path):
    Image.fromarray(np.dstack([np.full(mask.shape, 255, np.uint8), mask.astype(np.uint8) * 255]), "LA").save(
        path
    )


def opaque(mask, path):
    """Alpha that says nothing."""
    value = mask.astype(np.uint8) * 255
    Image.fromarray(np.dstack([value, value, value, np.full_like(value, 255)])).save(path)


def transparent_colour(mask, path):
    image = Image.fromarray(np.where(mask, 1, 0).astype(np.uint8), "P")
    image.putpalette([0, 0, 0, 9, 9, 9] + [0] * 762)
    image.save(path, transparency=0)


def one_bit(mask, path):
    Image.fromarray(mask).save(path)


WAYS = {
    "0 and 1": grey(1),
    "0 and 20": grey(20),
    "0 and 127": grey(127),
    "0 and 255 of 16 bits": sixteen(255),
    "0 and 1 of 16 bits": sixteen(1),
    "0 and 65535": sixteen(65535),
    "blue": coloured(0, 0, 255),
    "dark red": coloured(64, 0, 0),
    "palette": palette,
    "two objects": two_objects,
    "numbers": numbers(1, 2, 3, 4, 5),
    "numbers, some bright": numbers(60, 120, 180, 240),
    "numbers, one bright": numbers(1, 200),
    "cut-out": cut_out,
    "grey cut-out": grey_cut_out,
    "opaque alpha": opaque,
    "transparent colour": transparent_colour,
    "one bit": one_bit,
}


@pytest.mark.parametrize("way", WAYS)
def test_masks_of_all_kinds_mean_the_same(way, made, stream, tmp_path):
    folder = rewrite(made, tmp_path / "capture", WAYS[way])
    run("fvvmux", folder, "-o", tmp_path / "o.fvv", *QUICK)
    assert (tmp_path / "o.fvv").read_bytes() == stream


def test_noise_keeps_the_threshold(made, stream, tmp_path):
    """What is a little above black in a noisy mask is background."""
    random = np.random.default_rng(1)

    def noisy(mask, path):
        value = np.where(mask, 255, 0) + random.integers(-40, 41, mask.shape)
        Image.fromarray(np.clip(value, 0, 255).astype(np.uint8)).save(path)

    folder = rewrite(made, tmp_path / "capture", noisy)
    run("fvvmux", folder, "-o", tmp_path / "o.fvv", *QUICK)
    assert (tmp_path / "o.fvv").read_bytes() == stream


def test_the_whole_take_decides(made, tmp_path):
    """A first frame in which a camera sees nothing says nothing about the others."""
    empty = [path for path in masks_of(made) if path.name.endswith("0000.png")]
    names = {path.relative_to(made) for path in empty}
    results = []
    for name, value in {"labels": 1, "usual": 255}.items():
        folder = rewrite(made, tmp_path / name, grey(value))
        for relative in names:
            image = Image.open(folder / relative)
            Image.new("L", image.size).save(folder / relative)
        run("fvvmux", folder, "-o", tmp_path / f"{name}.fvv", *QUICK)
        results.append((tmp_path / f"{name}.fvv").read_bytes())
    assert results[0] == results[1]


def test_sheets_show_the_same(made, tmp_path):
    sheets = []
    for name, value in {"labels": 1, "usual": 255}.items():
        folder = rewrite(made, tmp_path / name, grey(value))
        run("fvvimport", "capture", folder, "--sheet", tmp_path / f"{name}.png")
        sheets.append((tmp_path / f"{name}.png").read_bytes())
    assert tool_path("fvvimport") and sheets[0] == sheets[1]


def everywhere(value):
    return lambda mask, path: Image.fromarray(np.full(mask.shape, value, np.uint8)).save(path)


@pytest.mark.parametrize(("value", "what"), [(0, "empty"), (255, "full")])
def test_masks_that_say_nothing_are_a_warning(value, what, made, tmp_path):
    """All of one camera's, while the mesh is in its picture."""
    folder = tmp_path / "capture"
    shutil.copytree(made, folder)
    paths = list(masks_of(folder))[FRAMES : 2 * FRAMES]
    for path in paths:
        everywhere(value)(np.asarray(Image.open(path).convert("L")), path)
    camera = json.loads((folder / "capture.json").read_text())["cameras"][1]
    for crop in "auto", "none":
        found = run("fvvmux", folder, "-o", tmp_path / f"{crop}.fvv", *QUICK, "--crop", crop, code=3)
        assert found.stderr.count("\n") == 1
        assert f"camera {camera['id']} " in found.stderr
        assert f"its masks are {what} in all frames" in found.stderr
    # One frame that says something is enough.
    image = Image.open(paths[1])
    image.paste(255 - value, (8, 8, 24, 24))
    image.save(paths[1])
    run("fvvmux", folder, "-o", tmp_path / "o.fvv", *QUICK)
