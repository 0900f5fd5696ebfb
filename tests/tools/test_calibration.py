"""Cameras that move: the decoder that was written from the specification, and the studio's camera there and back."""

import json
import subprocess

import calibration
import jsonschema
import numpy as np
from conftest import ROOT, SPEC, tool_path

VECTORS = ROOT / "conformance" / "calibration"
BOUND = 0.05  # pixels


def run(name, *arguments):
    path = tool_path(name)
    assert path, f"{name} was not built"
    done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done.stdout


def test_plain_decoder_gives_the_listed_cameras():
    wanted = (VECTORS / "moving.crc").read_text().splitlines()
    assert list(calibration.lines((VECTORS / "moving.fvv").read_bytes())) == wanted
    assert len(set(wanted)) == 38


def test_vector_uses_what_the_track_has():
    frames = list(calibration.decode((VECTORS / "moving.fvv").read_bytes()))
    assert {tuple(cameras) for _, cameras in frames} == {(2, 9, 300), (2, 300)}
    pans = [cameras[2]["rotation"] for _, cameras in frames]
    assert min(rotation[0] for rotation in pans) < -0.97  # about 180 degrees
    zooms = [cameras[300]["intrinsics"][0] for _, cameras in frames]
    assert max(zooms) > 7 * min(zooms)
    assert {cameras[2]["r_max"] for _, cameras in frames} == {1.5, float("inf")}


def test_fvvinfo_finds_every_frame_whole(fvvinfo):
    done = fvvinfo("--json", VECTORS / "moving.fvv")
    assert (done.returncode, done.stderr) == (0, b"")
    told = json.loads(done.stdout)
    jsonschema.validate(told, json.loads((SPEC / "fvvinfo.schema.json").read_text()))
    (stream,) = told["files"]
    assert [camera["moves"] for camera in stream["cameras"]] == [True] * 3
    (track,) = stream["tracks"]
    assert (track["kind"], track["chunks"], track["key_chunks"]) == ("calibration", 14, 2)


def pixels(camera, points):
    """Clause 9.1 for a pinhole or radtan, in numpy."""
    x, y, z = np.array(camera["rotation"]) @ points.T + np.array(camera["translation"])[:, None]
    assert (z > 0.5).all()
    x, y = x / z, y / z
    k1, k2, p1, p2, k3, k4, k5, k6 = (camera["lens"].get("coefficients", []) + [0] * 8)[:8]
    r2 = x * x + y * y
    d = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    u = x * d + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * d + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    k = camera["intrinsics"]
    return np.stack([k["fx"] * u + k["skew"] * v + k["cx"], k["fy"] * v + k["cy"]])


def moving_camera(folder):
    cameras = json.loads((folder / "capture.json").read_text())["cameras"]
    (found,) = (camera for camera in cameras if "per_frame" in camera)
    return found


def test_studio_camera_comes_back(tmp_path):
    studio, stream, back = tmp_path / "studio", tmp_path / "studio.fvv", tmp_path / "back"
    run("fvvsynth", "-o", studio, "--rig", "studio", "--frames", 8, "--size", "160x90", "--threads", 2)
    muxed = json.loads(
        run("fvvmux", studio, "-o", stream, "--group", 4, "--json", "--verify", "--threads", 2)
    )
    assert 0 < muxed["verified"]["moving_max_reprojection"] < BOUND
    assert muxed["verified"]["cameras"] == 13
    assert muxed["calibration"]["bytes"] < 8 * 100
    run("fvvdemux", stream, "-o", back, "--meshes", "ply")
    before, after = moving_camera(studio), moving_camera(back)
    assert before["id"] == after["id"] and len(after["per_frame"]) == 8
    points = np.random.default_rng(3).uniform([-1, 0, -1], [1, 2, 1], (500, 3))  # where the players are
    worst = 0
    for ours, theirs in zip(before["per_frame"], after["per_frame"]):
        assert ours["frame"] == theirs["frame"]
        worst = max(
            worst, np.abs(pixels({**before, **ours}, points) - pixels({**after, **theirs}, points)).max()
        )
    assert 0 < worst < BOUND
    # It moves by far more than that.
    first, second = ({**after, **after["per_frame"][i]} for i in (0, 7))
    assert np.abs(pixels(first, points) - pixels(second, points)).max() > 20 * BOUND
