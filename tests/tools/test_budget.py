"""Decimation by a budget in pixels, judged by fvvcompare."""

import json
import os
import pathlib
import subprocess

import pytest

TOOLS = pathlib.Path(os.environ["FVV_TOOLS_DIR"])


def tool(name, *arguments, expected=(0,)):
    done = subprocess.run([TOOLS / name / name, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode in expected, done.stderr
    return done


def figures(name, *arguments, expected=(0,)):
    return json.loads(tool(name, *arguments, "--json", expected=expected).stdout)


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    root = tmp_path_factory.mktemp("captures")
    for meshes in "hull", "tracked":
        options = ["--rig", "small", "--frames", 3, "--cameras", 4, "--size", "240x135", "--meshes", meshes]
        tool("fvvsynth", "-o", root / meshes, *options)
    return root


def mux(capture, path, *options, expected=(0, 3)):  # 3: a speck vanished
    settings = ["--codec", "jpeg", "--quality", 10, "--force", *options]
    return figures("fvvmux", capture, "-o", path, *settings, expected=expected)


@pytest.mark.parametrize("meshes", [pytest.param("hull", marks=pytest.mark.long), "tracked"])
def test_the_budget_holds_by_another_measure(captures, tmp_path, meshes):
    capture, path = captures / meshes, tmp_path / "out.fvv"
    before = 0
    for pixels in 0.15, 0.05:
        summary = mux(capture, path, "--max-error", pixels, "--verify")
        budget = summary["budget"]
        assert budget["decimated_frames"] == 3 and budget["kept_frames"] == 0
        assert before < budget["triangles"] < budget["triangles_before"] / 2
        before = budget["triangles"]
        assert summary["lattice"]["error_pixels"] <= pixels
        assert budget["rms_pixels"] <= pixels and budget["max_pixels"] <= 6 * pixels
        # The players stand within a few metres, so no pixel covers twice what the sharpest does.
        for frame in range(3):
            found = figures("fvvcompare", capture, path, "--frames", f"{frame}-{frame}")["distance"][
                "symmetric"
            ]
            assert found["rms"] <= 2 * pixels * budget["pixel"]
            if budget["vanished_pieces"] == 0:  # of specks that the lattice swallows nothing is near
                assert found["max"] <= 2 * 6 * pixels * budget["pixel"]
            # Delta frames are reckoned to do what a coarser lattice would, and do less.
            assert (0.85 if meshes == "hull" else 0.6) < found["rms"] / budget["rms"] < 1.15
        # Fitted to the source, or chords of it.
        assert abs(budget["volume_change"]) < (0.01 if meshes == "hull" else 0.05)


def test_a_run_keeps_its_faces(captures, tmp_path):
    path = tmp_path / "out.fvv"
    mux(captures / "tracked", path, "--mesh-profile", "raw")
    tool("fvvdemux", path, "-o", tmp_path / "out")
    temporal = figures("fvvcompare", tmp_path / "out", captures / "tracked")
    counts = {(frame["a"]["faces"], frame["a"]["vertices"]) for frame in temporal["frames"]}
    assert len(counts) == 1 and counts.pop()[0] < 20000


def test_overrides(captures, tmp_path):
    path = tmp_path / "out.fvv"
    hull = captures / "hull"
    kept = mux(hull, path, "--keep-geometry")
    assert kept["budget"]["reason"] == "as --keep-geometry says"
    assert "triangles" not in kept["budget"]
    some = mux(hull, path, "--triangles", 3000, "--step", "2mm")
    assert some["lattice"]["step"] == 0.002
    assert 2000 < some["budget"]["triangles"] <= 3000
    assert some["budget"]["rms"] > 0 and some["mesh"]["bytes"] < kept["mesh"]["bytes"] / 3
    done = tool("fvvmux", hull, "-o", path, "--force", "--keep-geometry", "--triangles", 9, expected=(2,))
    assert "--triangles" in done.stderr or "--keep-geometry" in done.stderr
    done = tool("fvvmux", hull, "-o", path, "--force", "--max-error", "0", expected=(2,))
    assert "--max-error: expected pixels, above 0 and at most 1000, found" in done.stderr


def test_what_was_lost_is_told(captures, tmp_path):
    done = tool("fvvmux", captures / "hull", "-o", tmp_path / "out.fvv", "--triangles", 60, "--codec", "jpeg",
                "--quality", 10, "--max-error", 0.01, expected=(3,))  # fmt: skip
    assert "frame 0: " in done.stderr and "of the surface are further off than 0.06 px" in done.stderr


def test_a_capture_that_was_in_a_stream_is_left_alone(captures, tmp_path):
    mux(captures / "hull", tmp_path / "once.fvv")
    tool("fvvdemux", tmp_path / "once.fvv", "-o", tmp_path / "out")
    again = mux(tmp_path / "out", tmp_path / "twice.fvv")
    assert "brings its lattice" in again["budget"]["reason"]
    assert (
        figures("fvvcompare", tmp_path / "once.fvv", tmp_path / "twice.fvv")["distance"]["symmetric"]["max"]
        < 1e-12
    )


@pytest.mark.long
def test_the_same_bytes_for_any_number_of_threads(captures, tmp_path):
    for meshes in "hull", "tracked":
        streams = set()
        for threads in 1, 3:
            mux(captures / meshes, tmp_path / "out.fvv", "--threads", threads)
            streams.add((tmp_path / "out.fvv").read_bytes())
        assert len(streams) == 1
