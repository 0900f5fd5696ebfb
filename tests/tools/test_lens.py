"""k1 = -0.4 alone, whose fold lies within the picture: through fvvimport, fvvmux and fvvrender; and lost calibration."""

import json
import math
import subprocess

import numpy as np
import pytest
from conftest import tool_path
from test_fvvrender import read_exr

FOLD = math.sqrt(1 / 1.2)  # where the derivative of r - 0.4 r^3 is 0


def run(name, *arguments):
    path = tool_path(name)
    assert path, f"{name} was not built"
    done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done.stdout


def test_fvvimport_stores_and_tells_where_the_lens_folds(tmp_path):
    camera = {"fl_x": 600, "fl_y": 600, "cx": 960, "cy": 540, "w": 1920, "h": 1080, "k1": -0.4}
    pose = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    frames = [
        {"file_path": "a/0.png", "transform_matrix": pose},
        {"file_path": "b/0.png", "transform_matrix": pose, "k1": -0.01},
    ]
    (tmp_path / "transforms.json").write_text(json.dumps({**camera, "frames": frames}))
    out = tmp_path / "capture.json"
    arguments = ["nerfstudio", tmp_path / "transforms.json", "-o", out, "--meshes", "%d.ply"]
    told = json.loads(run("fvvimport", *arguments, "--json"))
    folding, mild = told["cameras"]
    assert folding["r_max"] == pytest.approx(FOLD, rel=1e-9)
    # r_max maps to 600 (FOLD - 0.4 FOLD^3) = 365 px from the middle.
    seen = 600 * (FOLD - 0.4 * FOLD**3)
    grid = np.stack(np.meshgrid(np.linspace(-960, 960, 500), np.linspace(-540, 540, 500)))
    assert folding["beyond_r_max"] == pytest.approx((np.hypot(*grid) > seen).mean(), abs=0.02)
    assert mild["beyond_r_max"] == 0
    written = json.loads(out.read_text())["cameras"]
    assert written[0]["lens"]["r_max"] == folding["r_max"]
    text = run("fvvimport", *arguments, "--force")
    assert text.count("beyond r_max") == 1 and "camera 0: 80." in text


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lens") / "capture"
    run("fvvsynth", "-o", folder, "--rig", "studio", "--frames", 3, "--size", "240x136", "--threads", 2)
    return folder


def rewrite(folder, change):
    """The capture with another description, beside the first one."""
    description = json.loads((folder / "capture.json").read_text())
    change({camera["id"]: camera for camera in description["cameras"]})
    out = folder / f"{change.__name__}.json"
    out.write_text(json.dumps(description))
    return out


def world_of(camera, depth):
    """Points of a pinhole camera's depth map, one for each pixel."""
    k = camera["intrinsics"]
    v, u = np.mgrid[: depth.shape[0], : depth.shape[1]] + 0.5
    rays = np.stack([(u - k["cx"]) / k["fx"], (v - k["cy"]) / k["fy"], np.ones_like(u)], axis=-1)
    inside = rays * depth[..., None] - np.array(camera["translation"])
    return inside @ np.array(camera["rotation"])


def near(cameras):
    """The first camera near the scene, which then fills more than a lens can show."""
    camera = cameras[0]
    camera["lens"] = {"model": "none"}
    camera["intrinsics"].update(fx=60, fy=60, cx=20)  # the picture does not fit: only its place counts
    camera["translation"][2] = 2.1


def folding(cameras):
    near(cameras)
    cameras[0]["lens"] = {"model": "radtan", "coefficients": [-0.4, 0, 0, 0]}


def textured_by_radius(capture, stream, folder):
    """What the first camera textures of what another one sees: how many points within the fold, and beyond."""
    depth, seen = folder / "depth.exr", folder / "seen.exr"
    out = ["-o", folder / "view.png", "--depth", depth, "--visibility", seen, "--force"]
    view = ["--camera", 8, "--size", "720x408", "--sources", "0,3", "--visible-by", "rays"]
    run("fvvrender", stream, *view, *out)
    cameras = {camera["id"]: camera for camera in json.loads(capture.read_text())["cameras"]}
    for key in ("fx", "fy", "cx", "cy"):
        cameras[8]["intrinsics"][key] *= 720 / cameras[8]["width"]
    (depths,) = read_exr(depth).values()
    there = np.isfinite(depths) & (depths > 0)
    world = world_of(cameras[8], np.where(there, depths, 1))
    x, y, z = np.moveaxis(world @ np.array(cameras[0]["rotation"]).T + cameras[0]["translation"], -1, 0)
    radius = np.where(z > 0, np.hypot(x, y) / np.abs(z), np.inf)
    visible = there & (read_exr(seen)["camera.0"] > 0)
    assert (there & (radius > FOLD) & (z > 0)).sum() > 200
    return (visible & (radius < FOLD * 0.99)).sum(), (visible & (radius > FOLD * 1.001)).sum()


def test_nothing_is_textured_beyond_the_fold(studio, tmp_path):
    arguments = [
        "--keep-geometry",
        "--crop",
        "none",
        "--quality",
        20,
        "--json",
        "--threads",
        2,
        "--frames",
        "0-0",
    ]
    figures = {}
    for change, name, options in (
        (near, "near", []),
        (folding, "lens", []),
        (folding, "none", ["--undistort"]),
    ):
        capture, stream = rewrite(studio, change), tmp_path / f"{name}.fvv"
        told = json.loads(run("fvvmux", capture, "-o", stream, *arguments, *options))
        figures[name] = textured_by_radius(capture, stream, tmp_path)
        print(f"{name}: {figures[name][0]} points textured within the fold, {figures[name][1]} beyond")
        if name == "lens":
            (gap,) = told["lens_gaps"]
            assert gap["camera"] == 0 and gap["r_max"] == pytest.approx(FOLD, rel=1e-9) and gap["share"] > 0.2
        else:
            assert "lens_gaps" not in told
        if name == "none":
            assert next(one for one in told["undistorted"] if one["camera"] == 0)["limited"]
    assert figures["near"][1] > 100  # a pinhole sees what is there
    assert figures["lens"][1] == 0 and figures["none"][1] == 0
    assert figures["lens"][0] > 500 and figures["none"][0] > 500


def test_nobody_takes_colours_where_calibration_is_lost(studio, tmp_path, fvvinfo):
    def lost(cameras):
        entries = cameras[2]["per_frame"]
        entries[1] = {"frame": entries[1]["frame"], "calibrated": False}

    stream, back = tmp_path / "lost.fvv", tmp_path / "back"
    run("fvvmux", rewrite(studio, lost), "-o", stream, "--keep-geometry", "--quality", 20, "--verify")
    for frame, missing in ((0, False), (1, True), (2, False)):
        view = ["--frame", frame, "--camera", 3, "-o", tmp_path / "view.png", "--force", "--json"]
        told = json.loads(run("fvvrender", stream, *view))
        sources = told["sources"]
        assert (2 in sources) != missing and {1, 4} <= set(sources)
    (track,) = (
        track
        for track in json.loads(fvvinfo("--json", "--check", stream).stdout)["files"][0]["tracks"]
        if track["kind"] == "calibration"
    )
    assert track["calibration"] == {"entries": 2, "lost": 1}
    assert b"1 of 3 times a camera is not calibrated" in fvvinfo(stream).stdout
    run("fvvdemux", stream, "-o", back)
    (camera,) = (c for c in json.loads((back / "capture.json").read_text())["cameras"] if "per_frame" in c)
    assert camera["id"] == 2
    assert [entry.get("calibrated", True) for entry in camera["per_frame"]] == [True, False, True]
    assert set(camera["per_frame"][1]) == {"frame", "calibrated"}
