"""fvvmux --track: meshes whose faces change in every frame as motion."""

import json

import pytest
from conftest import run
from PIL import Image

OPTIONS = ("--no-pictures", "--max-error", "8mm")


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("remeshed") / "capture"
    run(
        "fvvsynth",
        "--rig",
        "small",
        "--cameras",
        2,
        "--size",
        "64x48",
        "--frames",
        4,
        "--meshes",
        "remeshed",
        "-o",
        folder,
    )
    return folder


def mux(capture, output, *options, **expected):
    return json.loads(run("fvvmux", capture, *OPTIONS, *options, "--json", "-o", output, **expected).stdout)


def test_tracked_frames_take_fewer_bytes_within_the_error(capture, tmp_path):
    three = ("--frames", "0-2")
    keys = mux(capture, tmp_path / "keys.fvv", *three)
    assert "tracking" not in keys["mesh"] and keys["mesh"]["delta"]["frames"] == 0
    for how, most in ("auto", 1), ("always", 0.8):
        found = mux(
            capture, tmp_path / f"{how}.fvv", "--track", how, "--verify", *three, code=(0, 3), warns=True
        )
        assert found["mesh"]["tracking"]["on"]
        assert found["bytes"] <= most * keys["bytes"]
        run("fvvcompare", capture, tmp_path / f"{how}.fvv", *three, "--max-rms", 0.0085)
    assert found["mesh"]["delta"]["frames"] >= 1


def test_threads_and_parts_give_the_same_bytes(capture, tmp_path):
    groups = ("--track", "always", "--group", 2)
    for threads in 1, 2:
        mux(
            capture,
            tmp_path / f"{threads}.fvv",
            *groups,
            "--threads",
            threads,
            code=(0, 3),
            warns=True,
        )
    whole = (tmp_path / "1.fvv").read_bytes()
    assert whole == (tmp_path / "2.fvv").read_bytes()
    parts = tmp_path / "parts"
    run("fvvmux", capture, *OPTIONS, *groups, "--plan", parts, code=(0, 3), warns=True)
    run("fvvmux", "--part", 1, parts, code=(0, 3), warns=True)
    run("fvvmux", "--merge", parts, "-o", tmp_path / "merged.fvv", code=(0, 3), warns=True)
    assert whole == (tmp_path / "merged.fvv").read_bytes()


def test_meshes_with_texture_coordinates_stay_key_frames(tmp_path):
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
    (tmp_path / "0.obj").write_text(corners + "f 1/1 2/2 3/3\nf 2/2 4/4 3/3\n")
    (tmp_path / "1.obj").write_text(corners + "f 1/1 2/2 4/4\nf 1/1 4/4 3/3\n")
    options = (
        "--meshes",
        tmp_path / "%d.obj",
        "--atlas",
        tmp_path / "%d.png",
        "--max-error",
        "1mm",
        "--units",
        "metres",
    )
    for i in 0, 1:
        Image.new("RGB", (16, 16), (200, 40, 40)).save(tmp_path / f"{i}.png")
    for how, code in ("auto", 0), ("always", 3):
        done = run("fvvmux", *options, "--track", how, "--json", "-o", tmp_path / f"{how}.fvv", code=code)
        tracking = json.loads(done.stdout)["mesh"]["tracking"]
        assert not tracking["on"] and "texture coordinates" in tracking["reason"]
        assert ("--track always" in done.stderr) == (how == "always")


def test_options_that_leave_nothing_to_track_are_refused(capture, tmp_path):
    for other in ("--keep-geometry",), ("--triangles", 500), ("--no-delta",):
        result = run(
            "fvvmux", capture, "--track", "auto", *other, "-o", tmp_path / "x.fvv", code=2, warns=True
        )
        assert "--track" in result.stderr


def test_outlines_judge_hulls(tmp_path):
    """Hulls flicker by more than the budget; by their outlines they are tracked all the same."""
    folder = tmp_path / "hulls"
    size = ("--rig", "small", "--cameras", 7, "--size", "240x135", "--hull-cells", 64)
    run("fvvsynth", *size, "--frames", 5, "--meshes", "hull", "-o", folder)
    small = ("--codec", "jpeg", "--quality", 5)
    found = {}
    for how in "never", "auto":
        output = tmp_path / f"{how}.fvv"
        done = run("fvvmux", folder, *small, "--track", how, "--verify", "--json", "-o", output)
        found[how] = json.loads(done.stdout)["mesh"]
    tracking = found["auto"]["tracking"]
    assert "touch outlines" in tracking["reason"] and tracking["by_outlines"] >= 2
    assert found["auto"]["delta"]["frames"] >= 3
    assert found["auto"]["bytes"] < 0.8 * found["never"]["bytes"]
    # A budget that is a length is one of distances.
    done = run(
        "fvvmux", folder, *small, "--track", "auto", "--max-error", "3mm", "--json", "-o", tmp_path / "mm.fvv"
    )
    tracking = json.loads(done.stdout)["mesh"]["tracking"]
    assert "outlines" not in tracking["reason"] and tracking["by_outlines"] == 0
