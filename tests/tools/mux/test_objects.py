"""fvvmux --objects: the pieces of the meshes, followed over time, in META (spec/registry.md, keys of META)."""

import json
import math
import re

import numpy as np
import pytest
from conftest import run

FRAMES = 30


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "made"
    run("fvvsynth", "--rig", "small", "--cameras", 2, "--size", "96x64", "--frames", FRAMES, "-o", folder)
    return folder


def objects_of(stream):
    """What META says, or None."""
    found = re.findall(rb'\{"objects":\{[^\0]*?\]\}\}', stream.read_bytes())
    return json.loads(found[0])["objects"] if found else None


def packed(capture, tmp_path, *options):
    out = tmp_path / "out.fvv"
    run("fvvmux", capture, "-o", out, "--no-pictures", "--force", *options)
    return objects_of(out)


def places(found, one):
    """Of an object at each frame, as the registry says; NaN where it is not."""
    out = np.full((FRAMES, 3), math.nan)
    for first, *numbers in one["path"]:
        steps = np.cumsum(np.reshape(numbers, (-1, 3)), axis=0)
        out[first : first + len(steps)] = np.array(found["origin"]) + found["unit"] * steps
    return out


def test_three_objects_are_followed(made, tmp_path):
    found = packed(made, tmp_path, "--objects", "auto")
    assert [one["id"] for one in found["list"]] == [1, 2, 3]
    assert found["step"] == 1 and found["touching"] == [] and found["splits"] == []
    assert all("name" not in one for one in found["list"])
    ball = found["list"][2]
    assert 0.11 < ball["radius"] < 0.13
    way = places(found, ball)
    assert np.isfinite(way).all()
    # It flies: no object moves as far.
    lengths = [np.linalg.norm(np.diff(places(found, one), axis=0), axis=1).sum() for one in found["list"]]
    assert lengths[2] > 3 * max(lengths[:2])


def test_without_the_option_nothing_is_said(made, tmp_path):
    assert packed(made, tmp_path) is None


def test_names_by_number_place_and_parts(made, tmp_path):
    first = packed(made, tmp_path, "--objects", "auto")
    at = [round(x, 3) for x in places(first, first["list"][2])[7]]
    names = tmp_path / "names.json"
    names.write_text(json.dumps({"ball": {"frame": 7, "at": at}, "both": [{"object": 2}, {"object": 1}]}))
    found = packed(made, tmp_path, "--objects", names)
    assert [(one.get("name"), one.get("of")) for one in found["list"]] == [
        (None, 2),
        ("both", None),
        ("ball", None),
    ]
    assert [one["path"] for one in found["list"]] == [one["path"] for one in first["list"]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "byte 2: is no JSON"),
        ("[]", "expected an object"),
        ('{"ball": 3}', '/ball: expected {"object": 2}'),
        ('{"ball": {"object": 9}}', "/ball: expected one of these objects: 1 at "),
        ('{"ball": {"frame": 2, "at": [0, 50, 0]}}', "/ball: no object is there in that frame"),
        ('{"ball": {"frame": 99, "at": [0, 50, 0]}}', "/ball: the stream has no frame 99"),
        ('{"a": {"object": 1}, "b": {"object": 1}}', "/b: is the same object as a"),
        ('{"a": []}', "/a: expected a name, and what has it"),
    ],
)
def test_names_that_fit_nothing_are_refused(made, tmp_path, text, message):
    names = tmp_path / "names.json"
    names.write_text(text)
    done = run("fvvmux", made, "-o", tmp_path / "x.fvv", "--no-pictures", "--objects", names, code=2)
    assert "names.json: " + message in done.stderr
    assert not (tmp_path / "x.fvv").exists()


def test_no_meshes_no_objects(made, tmp_path):
    done = run("fvvmux", made, "-o", tmp_path / "x.fvv", "--no-meshes", "--objects", "auto", code=2)
    assert "--objects auto: there are no meshes" in done.stderr
    done = run("fvvmux", made, "-o", tmp_path / "x.fvv", "--objects", tmp_path / "none.json", code=1)
    assert "none.json" in done.stderr


def test_a_stream_packed_in_parts_has_them_too(made, tmp_path):
    whole = packed(made, tmp_path, "--objects", "auto")
    parts = tmp_path / "parts"
    run("fvvmux", made, "--no-pictures", "--objects", "auto", "--group", 15, "--plan", parts)
    run("fvvmux", "--part", 1, parts)
    run("fvvmux", "--merge", parts, "-o", tmp_path / "joined.fvv")
    assert objects_of(tmp_path / "joined.fvv") == whole
