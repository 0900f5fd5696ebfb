"""The camera from whose side players begin (spec/registry.md, keys of META): its picture shows the action whole and large."""

import json
import re
import shutil

import numpy as np
import pytest
from conftest import run
from PIL import Image

FRAMES = 2
QUICK = (
    "--quality",
    30,
    "--visibility",
    "none",
    "--match-colours",
    "off",
    "--texture-inset",
    "off",
    "--colours",
    "off",
)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "made"
    run("fvvsynth", "--rig", "small", "--cameras", 4, "--size", "96x64", "--frames", FRAMES, "-o", folder)
    return folder


def view_of(capture, *options):
    """What META says, or None."""
    out = capture.with_suffix(".fvv")
    run("fvvmux", capture, "-o", out, "--force", *QUICK, *options)
    (text,) = re.findall(rb'\{"generator":"fvvmux[^\0]*\}', out.read_bytes())
    return json.loads(text).get("view")


def changed(made, target, edit):
    shutil.copytree(made, target)
    description = json.loads((target / "capture.json").read_text())
    edit(description)
    (target / "capture.json").write_text(json.dumps(description))
    return target


def test_a_camera_behind_something_is_not_chosen(made, tmp_path):
    first = view_of(made)["camera"]

    def cover(description):
        (camera,) = (c for c in description["cameras"] if c["id"] == first)
        for frame in range(FRAMES):
            path = tmp_path / "covered" / (camera["masks"] % frame)
            mask = np.asarray(Image.open(path)).copy()
            mask[32:] = 0  # a wall before the lower half
            Image.fromarray(mask).save(path)

    second = view_of(changed(made, tmp_path / "covered", cover))["camera"]
    assert second in range(4) and second != first


def test_the_camera_whose_picture_shows_most_is_chosen_without_masks_too(made, tmp_path):
    def nearer(description):
        """A copy of the last camera with twice its focal lengths: what it shows is larger."""
        for camera in description["cameras"]:
            del camera["masks"]
        lens = description["cameras"][2]["intrinsics"]
        lens["fx"] *= 1.2
        lens["fy"] *= 1.2

    assert view_of(changed(made, tmp_path / "nearer", nearer)) == {"camera": 2}


def test_where_there_is_no_choice_nothing_is_said(made, tmp_path):
    def alone(description):
        del description["cameras"][1:]

    assert view_of(changed(made, tmp_path / "alone", alone)) is None
    assert view_of(made, "--no-pictures") is None


def test_the_game_does_not_begin_behind_the_pole_or_above(tmp_path):
    game = tmp_path / "game"
    run("fvvsynth", "--scene", "game", "--size", "192x108", "--frames", 1, "-o", game)
    names = {c["id"]: c["name"] for c in json.loads((game / "capture.json").read_text())["cameras"]}
    # Of 13: oval0 and oval9 are behind the basket, oval3 to oval6 behind the other player.
    assert names[view_of(game)["camera"]] in ("oval2", "oval7")
