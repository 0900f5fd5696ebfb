"""fvvmux --undistort: what is rendered from a stream with lenses and from one without lies in the same place."""

import json
import subprocess

import numpy as np
import pytest
from conftest import tool_path
from PIL import Image

BOUND = 0.1  # pixels
UNSEEN = (255, 0, 255)
LENSES = [1, 2, 4, 5, 10]  # cameras of the studio; 2 pans and zooms


def run(name, *arguments, code=0):
    path = tool_path(name)
    assert path, f"{name} was not built"
    done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert done.returncode == code, done.stderr
    return done


@pytest.fixture(scope="module")
def studio(tmp_path_factory):
    folder = tmp_path_factory.mktemp("studio") / "capture"
    run("fvvsynth", "-o", folder, "--rig", "studio", "--frames", 2, "--size", "480x270", "--threads", 2)
    return folder


def mux(capture, stream, *arguments):
    fine = ["--quality", 3, "--keep-geometry", "--threads", 2, "--json"]
    return json.loads(run("fvvmux", capture, "-o", stream, *fine, *arguments).stdout)


@pytest.fixture(scope="module")
def streams(studio):
    """As shot, without lenses, and as shot under another convention: pixel centres at whole numbers."""
    plain, straight, shifted = (studio.parent / name for name in ("plain.fvv", "straight.fvv", "shifted.fvv"))
    mux(studio, plain)
    told = mux(studio, straight, "--undistort", "--verify")
    assert {one["camera"] for one in told["undistorted"]} == {1, 2, 4, 5, 7, 9, 10}
    assert all(one["blank"] < 0.001 and one["kept"] > 0.9 for one in told["undistorted"])
    description = json.loads((studio / "capture.json").read_text())
    description["conventions"]["pixel_centre"] = 0
    (studio / "other.json").write_text(json.dumps(description))
    mux(studio / "other.json", shifted, "--undistort")
    return plain, straight, shifted


def view(stream, eye, source, frame, out):
    """What a camera without lens sees from there."""
    place = ",".join(f"{number:.6f}" for number in eye)
    pose = [f"--pose={place},0,1,0", "--focal", 480, "--size", "640x360", "--unseen", "255,0,255"]
    run("fvvrender", stream, "-o", out, "--frame", frame, "--sources", source, *pose)
    return np.asarray(Image.open(out)).astype(float)


def shift(a, b):
    """Pixels by which b is displaced against a, by least squares over what both show; how many pixels that are."""
    known = np.ones(a.shape[:2], bool)
    for picture in (a, b):
        known &= (picture != UNSEEN).any(axis=2) & (picture.sum(axis=2) > 0)
    for _ in range(2):  # not beside the border of what is seen
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
def test_pictures_lie_where_they_did(studio, streams, tmp_path, source):
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
    # The measure sees half a pixel of the source.
    (dx, dy), _ = shift(before, view(shifted, eye, source, frame, tmp_path / "shifted.png"))
    print(f"    and half a pixel of the source: {dx:+.3f} {dy:+.3f} px")
    assert np.hypot(dx, dy) > 2.5 * BOUND


@pytest.mark.parametrize("target,sources", [(0, "1,9"), (8, "7,9")])
def test_both_lie_where_the_camera_saw_it(studio, streams, tmp_path, target, sources):
    """Against the picture that a camera without lens took."""
    truth = np.asarray(Image.open(studio / f"oval{target}" / "0001.png").convert("RGB")).astype(float)
    for stream in streams[:2]:
        out = tmp_path / f"{stream.stem}.png"
        arguments = ["--frame", 1, "--camera", target, "--sources", sources, "--unseen", "255,0,255"]
        run("fvvrender", stream, "-o", out, *arguments)
        (dx, dy), pixels = shift(np.asarray(Image.open(out)).astype(float), truth)
        print(f"camera {target} {stream.stem}: {dx:+.3f} {dy:+.3f} px over {pixels} pixels")
        assert pixels > 1000
        assert abs(dx) < BOUND and abs(dy) < BOUND
