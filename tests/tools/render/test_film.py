"""Films of fvvrender: their pictures are those that it draws alone, at the times and from the places promised."""

import json
import math
import re
from fractions import Fraction

import av
import numpy as np
import pytest
from conftest import figures, run
from PIL import Image

SIZE = ["--size", "160x90"]


@pytest.fixture(scope="module")
def stream(tmp_path_factory):
    root = tmp_path_factory.mktemp("film")
    run(
        "fvvsynth",
        "-o",
        root / "capture",
        "--rig",
        "small",
        "--frames",
        5,
        "--cameras",
        4,
        "--size",
        "160x96",
    )
    run("fvvmux", root / "capture", "-o", root / "scene.fvv", "--codec", "jpeg", "--keep-geometry")
    return root / "scene.fvv"


def pixels(path):
    return np.asarray(Image.open(path).convert("RGB"), dtype=int)


def decoded(path):
    with av.open(str(path)) as film:
        return [frame.to_ndarray(format="rgb24").astype(int) for frame in film.decode(video=0)]


def test_a_film_has_the_frames_of_the_stream_and_its_rate(stream, tmp_path):
    out = tmp_path / "turn.mp4"
    told = figures("fvvrender", stream, "--orbit", 360, "-o", out, *SIZE)
    assert told["target"] == {"orbit": 360}
    assert (told["frame"], told["film"]["last_frame"], told["film"]["pictures"]) == (0, 4, 5)
    rate = told["film"]["rate"]
    with av.open(str(out)) as film:
        video = film.streams.video[0]
        assert (video.codec_context.name, video.pix_fmt, video.frames) == ("h264", "yuv420p", 5)
        assert video.average_rate == Fraction(*rate)
        assert [f.time * rate[0] / rate[1] for f in film.decode(video)] == pytest.approx(range(5))
    run("fvvrender", stream, "--orbit", 360, "-o", tmp_path / "turn/%04d.png", *SIZE)
    film = decoded(out)
    for i in range(5):
        alone = pixels(tmp_path / f"turn/{i:04d}.png")
        assert np.abs(film[i] - alone).mean() < 2.5
        # The action is in the picture, and not cut off.
        assert (alone != 0).any(2).mean() > 0.02
        assert not (alone[[0, -1]] != 0).any() and not (alone[:, [0, -1]] != 0).any()
    assert len(film) == 5


def test_an_orbit_is_a_circle_around_the_target_and_time_is_still(stream, tmp_path):
    run("fvvrender", stream, "--orbit", 180, "--frame", 2, "--count", 4, "--target", "0,1,0", "--radius", 4,
        "--height", 1, "-o", tmp_path / "turn/%04d.png", *SIZE)  # fmt: skip
    assert len(list((tmp_path / "turn").glob("*.png"))) == 4
    # It begins on the side of the first camera; +y is up.
    (line,) = re.findall(r" cam0 .* at \(([^)]*)\)", run("fvvinfo", stream).stdout)
    eye = [float(number) for number in line.split(",")]
    first = math.atan2(eye[0], eye[2])  # from +z to +x is counterclockwise from above
    for i in range(4):
        angle = first + math.radians(180 * i / 4)
        place = f"{4 * math.sin(angle)!r},2,{4 * math.cos(angle)!r},0,1,0"
        alone = tmp_path / f"{i}.png"
        run("fvvrender", stream, "--frame", 2, f"--pose={place}", "-o", alone, *SIZE)
        differ = np.abs(pixels(alone) - pixels(tmp_path / f"turn/{i:04d}.png"))
        assert differ.mean() < 0.05, i


def test_a_path_passes_its_keyframes_and_goes_on_smoothly(stream, tmp_path):
    rate = 10
    keys = [
        {"time": 0, "position": [3, 1.5, 3], "target": [0, 1, 0], "fov": 40},
        {"time": 0.2, "position": [0, 1.8, 4], "target": [0, 1, 0.2], "fov": 33},
        {"time": 0.6, "position": [-3, 1.5, 3], "target": [0, 1, 0], "fov": 40},
    ]
    (tmp_path / "walk.json").write_text(json.dumps(keys))
    run("fvvrender", stream, "--path", tmp_path / "walk.json", "--frame", 1, "--count", 8, "--fps", rate,
        "-o", tmp_path / "walk/%04d.png", *SIZE)  # fmt: skip
    for i, key in [(0, 0), (2, 1), (6, 2), (7, 2)]:
        place = ",".join(map(str, keys[key]["position"] + keys[key]["target"]))
        focal = 45 / math.tan(math.radians(keys[key]["fov"] / 2))
        alone = tmp_path / f"{i}.png"
        run("fvvrender", stream, "--frame", 1, "--pose", place, "--focal", repr(focal), "-o", alone, *SIZE)
        assert np.abs(pixels(alone) - pixels(tmp_path / f"walk/{i:04d}.png")).mean() < 0.05, i
    assert (pixels(tmp_path / "walk/0001.png") != pixels(tmp_path / "walk/0002.png")).any()


def test_time_goes_with_the_stream_at_any_rate(stream, tmp_path):
    told = figures(
        "fvvrender", stream, "--camera", 0, "--frames", "1-2", "-o", tmp_path / "a/%04d.png", *SIZE
    )
    rate = told["film"]["rate"]
    double = f"{2 * rate[0]}/{rate[1]}"
    run("fvvrender", stream, "--camera", 0, "--frames", "1-2", "--fps", double, "-o", tmp_path / "b/%04d.png",
        *SIZE)  # fmt: skip
    for i in range(4):
        assert (tmp_path / f"b/{i:04d}.png").read_bytes() == (tmp_path / f"a/{i // 2:04d}.png").read_bytes()
    assert len(list((tmp_path / "b").glob("*.png"))) == 4


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--orbit", 90, "-o", "a.png"], "--orbit: expected with a film"),
        (["-o", "a.mp4"], "expected one of --orbit, --path, --camera and --pose, found none"),
        (["--orbit", 90, "--camera", 0, "-o", "a.mp4"], "found several"),
        (["--orbit", 90, "--frames", "3-9", "-o", "a.mp4"], "frame 9 is not in the stream, which has 5"),
        (["--orbit", 90, "--frames", "0,4", "-o", "a.mp4"], "--frames: expected one range"),
        (["--orbit", 90, "--frame", 2, "-o", "a.mp4"], "expected --frame and --count together"),
        (["--orbit", 90, "--fps", "0", "-o", "a.mp4"], "--fps: expected a number like 25"),
        (
            ["--orbit", 90, "--size", "161x90", "-o", "a.mp4"],
            "--size: expected even sides for MP4, found 161x90",
        ),
        (["--orbit", 90, "--depth", "d.exr", "-o", "a.mp4"], "expected with a single picture"),
        (["--pose", "0,1,4,0,1,0", "--radius", 2, "-o", "a.mp4"], "--radius: expected with --orbit"),
        (["--orbit", 90, "-o", "%04d.png"], "expected a folder before %04d.png"),
    ],
)
def test_what_does_not_fit_is_usage(stream, tmp_path, arguments, message):
    named = [tmp_path / a if str(a).endswith((".mp4", "a.png")) else a for a in arguments]
    done = run("fvvrender", stream, *named, code=2)
    assert message in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "text, message",
    [
        ("[", ":1:2: not JSON"),
        ("[]", "expected 1 to 10000 keyframes, found 0"),
        ('[{"time": 0, "position": [0, 1, 2], "target": [0, 1, 2]}]', "/0/target: expected another point"),
        ('[{"time": -1, "position": [0, 1, 2], "target": [0, 1, 0]}]', "/0/time: expected a number from 0"),
        ('[{"time": 0, "position": [0, 1], "target": [0, 1, 0]}]', "/0/position: expected 3 items"),
        ('[{"time": 0, "position": [0, 1, 2], "target": [0, 1, 0], "fog": 3}]', "/0"),
        ('[{"time": 0, "position": [0, 1, 2], "target": [0, 1, 0], "fov": 180}]', "/0/fov: expected a number from 1"),
        ('[{"time": 0, "position": [0, 1, 2], "target": [0, 1, 0]},'
         ' {"time": 0, "position": [0, 1, 3], "target": [0, 1, 0]}]', "/1/time: expected more than"),
        ('[{"time": 0, "position": [0, 1, 2], "target": [0, 1, 0]},'
         ' {"time": 1, "position": [0, 1, 3], "target": [0, 1, 0], "fov": 50}]', "/1: expected fov in all"),
    ],
)  # fmt: skip
def test_a_path_that_is_none_says_where(stream, tmp_path, text, message):
    path = tmp_path / "path.json"
    path.write_text(text)
    done = run("fvvrender", stream, "--path", path, "-o", tmp_path / "a.mp4", code=1)
    assert str(path) in done.stderr and message in done.stderr
    assert not (tmp_path / "a.mp4").exists()


def test_a_film_is_replaced_with_force_alone(stream, tmp_path):
    out = tmp_path / "a.mp4"
    out.write_bytes(b"mine")
    done = run("fvvrender", stream, "--camera", 0, "--frames", "0-1", "-o", out, code=1)
    assert "--force" in done.stderr and out.read_bytes() == b"mine"
    run("fvvrender", stream, "--camera", 0, "--frames", "0-1", "-o", out, "--force", "--size", "160x96")
    assert len(decoded(out)) == 2
