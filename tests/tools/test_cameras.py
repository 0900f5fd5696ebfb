"""Cameras that move, cameras whose lens folds within the picture, cameras without calibration, and fvvmux --undistort."""

import json
import math

import numpy as np
import pytest
from conftest import figures, run
from pictures import read_exr
from PIL import Image

MOVING_BOUND = 0.05  # pixels
BOUND = 0.1  # pixels
UNSEEN = (255, 0, 255)
LENSES = [1, 2, 4, 5, 10]  # cameras of the studio; 2 pans and zooms
FOLD = math.sqrt(1 / 1.2)  # where the derivative of r - 0.4 r^3 is 0


# Cameras that move.


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


def test_a_camera_that_moves_comes_back(tmp_path):
    studio, stream, back = tmp_path / "studio", tmp_path / "studio.fvv", tmp_path / "back"
    run("fvvsynth", "-o", studio, "--rig", "studio", "--frames", 8, "--size", "160x90", "--threads", 2)
    muxed = figures("fvvmux", studio, "-o", stream, "--group", 4, "--verify", "--threads", 2)
    assert 0 < muxed["verified"]["moving_max_reprojection"] < MOVING_BOUND
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
    assert 0 < worst < MOVING_BOUND
    # It moves by far more than that.
    first, second = ({**after, **after["per_frame"][i]} for i in (0, 7))
    assert np.abs(pixels(first, points) - pixels(second, points)).max() > 20 * MOVING_BOUND


# A lens with k1 = -0.4 alone: its fold is within the picture.


def test_fvvimport_stores_and_reports_where_the_lens_folds(tmp_path):
    camera = {"fl_x": 600, "fl_y": 600, "cx": 960, "cy": 540, "w": 1920, "h": 1080, "k1": -0.4}
    pose = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    frames = [
        {"file_path": "a/0.png", "transform_matrix": pose},
        {"file_path": "b/0.png", "transform_matrix": pose, "k1": -0.01},
    ]
    (tmp_path / "transforms.json").write_text(json.dumps({**camera, "frames": frames}))
    out = tmp_path / "capture.json"
    arguments = ["nerfstudio", tmp_path / "transforms.json", "-o", out, "--meshes", "%d.ply"]
    folding, mild = figures("fvvimport", *arguments)["cameras"]
    assert folding["r_max"] == pytest.approx(FOLD, rel=1e-9)
    # r_max maps to 600 (FOLD - 0.4 FOLD^3) = 365 px from the middle.
    seen = 600 * (FOLD - 0.4 * FOLD**3)
    grid = np.stack(np.meshgrid(np.linspace(-960, 960, 500), np.linspace(-540, 540, 500)))
    assert folding["beyond_r_max"] == pytest.approx((np.hypot(*grid) > seen).mean(), abs=0.02)
    assert mild["beyond_r_max"] == 0
    written = json.loads(out.read_text())["cameras"]
    assert written[0]["lens"]["r_max"] == folding["r_max"]
    text = run("fvvimport", *arguments, "--force").stdout
    assert text.count("beyond r_max") == 1 and "camera 0: 80." in text


@pytest.fixture(scope="module")
def small_studio(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lens") / "capture"
    run("fvvsynth", "-o", folder, "--rig", "studio", "--frames", 3, "--size", "240x136", "--threads", 2)
    return folder


def rewrite(folder, change):
    """Writes a changed description beside the capture's own and returns its path."""
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
    camera["intrinsics"].update(fx=60, fy=60, cx=20)  # the picture does not match; only its position matters
    camera["translation"][2] = 2.1
    camera.pop("masks", None)  # nor do its masks


def folding(cameras):
    near(cameras)
    cameras[0]["lens"] = {"model": "radtan", "coefficients": [-0.4, 0, 0, 0]}


def textured_by_radius(capture, stream, folder):
    """Counts the points that the first camera textures of what another one sees: within the fold, and beyond."""
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


def test_nothing_is_textured_beyond_the_fold(small_studio, tmp_path):
    arguments = ["--keep-geometry", "--crop", "none", "--quality", 20, "--threads", 2, "--frames", "0-0"]
    counts = {}
    for change, name, options in (
        (near, "near", []),
        (folding, "lens", []),
        (folding, "none", ["--undistort"]),
    ):
        capture, stream = rewrite(small_studio, change), tmp_path / f"{name}.fvv"
        summary = figures("fvvmux", capture, "-o", stream, *arguments, *options)
        counts[name] = textured_by_radius(capture, stream, tmp_path)
        print(f"{name}: {counts[name][0]} points textured within the fold, {counts[name][1]} beyond")
        if name == "lens":
            (gap,) = summary["lens_gaps"]
            assert gap["camera"] == 0 and gap["r_max"] == pytest.approx(FOLD, rel=1e-9) and gap["share"] > 0.2
        else:
            assert "lens_gaps" not in summary
        if name == "none":
            assert next(one for one in summary["undistorted"] if one["camera"] == 0)["limited"]
    assert counts["near"][1] > 100  # a pinhole sees what is there
    assert counts["lens"][1] == 0 and counts["none"][1] == 0
    assert counts["lens"][0] > 500 and counts["none"][0] > 500


def test_a_camera_gives_no_colours_where_its_calibration_is_lost(small_studio, tmp_path, fvvinfo):
    def lost(cameras):
        entries = cameras[2]["per_frame"]
        entries[1] = {"frame": entries[1]["frame"], "calibrated": False}

    stream, back = tmp_path / "lost.fvv", tmp_path / "back"
    run("fvvmux", rewrite(small_studio, lost), "-o", stream, "--keep-geometry", "--quality", 20, "--verify")
    for frame, missing in ((0, False), (1, True), (2, False)):
        view = ["--frame", frame, "--camera", 3, "-o", tmp_path / "view.png", "--force"]
        sources = figures("fvvrender", stream, *view)["sources"]
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


# Pictures rendered from a stream with lenses and from one without agree in position.


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studio") / "capture"
    run("fvvsynth", "-o", folder, "--rig", "studio", "--frames", 2, "--size", "480x270", "--threads", 2)
    return folder


def mux(capture, stream, *arguments):
    fine = ["--quality", 3, "--keep-geometry", "--threads", 2]
    return figures("fvvmux", capture, "-o", stream, *fine, *arguments)


@pytest.fixture(scope="module")
def streams(studio):
    """As shot, without lenses, and as shot but with pixel centres at whole numbers."""
    plain, straight, shifted = (studio.parent / name for name in ("plain.fvv", "straight.fvv", "shifted.fvv"))
    mux(studio, plain)
    changed = mux(studio, straight, "--undistort", "--verify")["undistorted"]
    assert {one["camera"] for one in changed} == {1, 2, 4, 5, 7, 9, 10}
    assert all(one["blank"] < 0.001 and one["kept"] > 0.9 for one in changed)
    description = json.loads((studio / "capture.json").read_text())
    description["conventions"]["pixel_centre"] = 0
    (studio / "other.json").write_text(json.dumps(description))
    mux(studio / "other.json", shifted, "--undistort")
    return plain, straight, shifted


def view(stream, eye, source, frame, out):
    """The picture of a camera without lens at this place."""
    place = ",".join(f"{number:.6f}" for number in eye)
    pose = [f"--pose={place},0,1,0", "--focal", 480, "--size", "640x360", "--unseen", "255,0,255"]
    run("fvvrender", stream, "-o", out, "--frame", frame, "--sources", source, *pose)
    return np.asarray(Image.open(out)).astype(float)


def shift(a, b):
    """Displacement of b against a in pixels, by least squares over the pixels that both show, and their number."""
    known = np.ones(a.shape[:2], bool)
    for picture in (a, b):
        known &= (picture != UNSEEN).any(axis=2) & (picture.sum(axis=2) > 0)
    for _ in range(2):  # away from the border of the visible surface
        inner = known.copy()
        for axis in (0, 1):
            for step in (1, -1):
                inner &= np.roll(known, step, axis)
        known = inner
    grey_a, grey_b = a.mean(axis=2), b.mean(axis=2)
    middle = (grey_a + grey_b) / 2
    dy, dx = np.gradient(middle)
    slopes = np.stack([dx[known], dy[known]], axis=1)
    found, *_ = np.linalg.lstsq(slopes, -(grey_b - grey_a)[known], rcond=None)
    return found, int(known.sum())


@pytest.mark.long
@pytest.mark.parametrize("source", LENSES)
def test_undistorted_pictures_are_not_displaced(studio, streams, tmp_path, source):
    plain, straight, shifted = streams
    frame = 1
    (camera,) = (c for c in json.loads((studio / "capture.json").read_text())["cameras"] if c["id"] == source)
    camera.update(camera.get("per_frame", [{}] * 2)[frame])
    eye = -np.array(camera["rotation"]).T @ camera["translation"] + [0.3, 0.2, 0.3]
    before, after = (view(s, eye, source, frame, tmp_path / f"{s.stem}.png") for s in (plain, straight))
    (dx, dy), pixels = shift(before, after)
    print(f"camera {source}: {dx:+.3f} {dy:+.3f} px over {pixels} pixels")
    assert pixels > 1500
    assert abs(dx) < BOUND and abs(dy) < BOUND
    # The measure notices half a pixel of the source.
    (dx, dy), _ = shift(before, view(shifted, eye, source, frame, tmp_path / "shifted.png"))
    print(f"    and half a pixel of the source: {dx:+.3f} {dy:+.3f} px")
    assert np.hypot(dx, dy) > 2.5 * BOUND


@pytest.mark.parametrize("target,sources", [(0, "1,9"), (8, "7,9")])
def test_both_agree_with_the_picture_of_a_camera(studio, streams, tmp_path, target, sources):
    """Compares with the picture of a camera without lens."""
    truth = np.asarray(Image.open(studio / f"oval{target}" / "0001.png").convert("RGB")).astype(float)
    for stream in streams[:2]:
        out = tmp_path / f"{stream.stem}.png"
        arguments = ["--frame", 1, "--camera", target, "--sources", sources, "--unseen", "255,0,255"]
        run("fvvrender", stream, "-o", out, *arguments)
        (dx, dy), pixels = shift(np.asarray(Image.open(out)).astype(float), truth)
        print(f"camera {target} {stream.stem}: {dx:+.3f} {dy:+.3f} px over {pixels} pixels")
        assert pixels > 1000
        assert abs(dx) < BOUND and abs(dy) < BOUND
