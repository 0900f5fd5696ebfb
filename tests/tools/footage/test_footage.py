"""fvvsynth --footage: films of a recording session, and the truth about them."""

import json

import av
import cv2
import numpy as np
import pytest
from conftest import run
from PIL import Image

FILMS = ["head0", "head1", *(f"oval{i}" for i in (0, 1, 3, 4, 5, 6, 7, 8, 9))]
FRAMES, POSES = 8, 12
RATE = 25
OPTIONS = ["--footage", "--size", "640x360", "--frames", FRAMES, "--poses", POSES]


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    folder = tmp_path_factory.mktemp("session") / "shoot"
    run("fvvsynth", "-o", folder, *OPTIONS)
    return folder


@pytest.fixture(scope="module")
def truth(session):
    """(capture.json, truth.json)"""
    return tuple(
        json.loads((session / "truth" / name).read_text()) for name in ("capture.json", "truth.json")
    )


def film(path):
    """Pictures of a film, (frames, height, width, 3)."""
    with av.open(str(path)) as file:
        return np.stack([frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)])


def sound(path):
    """Samples of a film's sound, from the time of its first picture."""
    with av.open(str(path)) as file:
        frames = list(file.decode(file.streams.audio[0]))
    assert frames[0].pts == 0 and frames[0].sample_rate == 48000
    return np.concatenate([frame.to_ndarray().ravel() for frame in frames])


def mask(session, name, frame):
    return np.asarray(Image.open(session / f"truth/{name}/mask_{frame:04d}.png")) > 127


def test_every_camera_has_three_films(session, truth):
    capture, other = truth
    sizes = {camera["name"]: (camera["height"], camera["width"]) for camera in capture["cameras"]}
    assert sorted(sizes) == sorted([*FILMS, "oval2"]) and other["held_out"] == "oval2"
    assert other["board"]["frames_of_pose"] == 2
    for take, count in [("board", 2 * POSES), ("plate", 10), ("performance", FRAMES)]:
        assert sorted(path.name for path in (session / take).iterdir()) == [f"{name}.mp4" for name in FILMS]
        for name in FILMS:
            with av.open(str(session / take / f"{name}.mp4")) as file:
                video = file.streams.video[0]
                assert (video.height, video.width) == sizes[name]
                assert (video.average_rate, video.frames) == (RATE, count)
                assert len(file.streams.audio) == (take == "performance")
                # BT.709, the curve of sRGB, limited range.
                colour = video.codec_context
                assert (colour.color_primaries, colour.color_trc, colour.colorspace, colour.color_range) == (
                    1,
                    13,
                    1,
                    1,
                )


def corners_of(picture, board):
    """Corners that OpenCV detects: identifiers, and pixels whose centres are at 0.5."""
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    corners, ids, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(grey)
    if ids is None:
        return [], np.zeros((0, 2))
    # detectBoard's corners are off by half a pixel from those of cornerSubPix, whose pixels have their centres at 0.
    stop = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 40, 1e-3)
    return ids.ravel(), cv2.cornerSubPix(grey, corners, (2, 2), (-1, -1), stop).reshape(-1, 2) + 0.5


def test_the_board_is_where_the_truth_says(session, truth):
    capture, other = truth
    said = other["board"]
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard(
        (said["columns"], said["rows"]), said["square"], said["marker"], dictionary
    )
    seen, errors = np.zeros((len(FILMS), POSES), int), []
    for number, name in enumerate(FILMS):
        camera = next(c for c in capture["cameras"] if c["name"] == name)
        k = camera["intrinsics"]
        matrix = np.array([[k["fx"], 0, k["cx"]], [0, k["fy"], k["cy"]], [0, 0, 1]])
        lens = np.array(camera["lens"]["coefficients"] or [0, 0, 0, 0], float)
        rotation, _ = cv2.Rodrigues(np.array(camera["rotation"]))
        pictures = film(session / f"board/{name}.mp4")
        for pose, place in enumerate(said["poses"]):
            ids, pixels = corners_of(pictures[2 * pose], board)
            seen[number, pose] = len(ids)
            if not len(ids):
                continue
            axes = np.array([place[axis] for axis in "xyz"])
            world = board.getChessboardCorners()[ids] @ axes + place["origin"]
            expected, _ = cv2.projectPoints(world, rotation, np.array(camera["translation"]), matrix, lens)
            errors += list(np.linalg.norm(expected.reshape(-1, 2) - pixels, axis=1))
    # Cells of the markers are of 2.5 pixels here, of 1.7 in the smallest pictures, which see little; by default of twice as many.
    assert np.median(errors) < 0.2
    assert ((seen >= 6).sum(axis=1) >= 2).sum() >= 9, seen
    assert ((seen >= 6).sum(axis=0) >= 2).sum() >= POSES // 2, seen


def test_a_pose_is_held_for_two_frames(session):
    for name in FILMS[:2]:
        pictures = film(session / f"board/{name}.mp4").astype(float)
        steps = np.abs(np.diff(pictures, axis=0)).max(axis=(1, 2, 3))
        assert steps[::2].max() < 40 < steps[1::2].min()


def test_the_empty_stage_is_behind_the_action(session):
    for name in ("head1", "oval4", "oval9"):
        plate = film(session / f"plate/{name}.mp4").astype(float)
        assert plate.mean() > 30 and plate.std() > 20
        # Noise, unlike in every picture.
        assert 0.5 < np.abs(np.diff(plate, axis=0)).mean() < 3
        action = film(session / f"performance/{name}.mp4")[2].astype(float)
        difference = np.abs(action - plate.mean(axis=0)).max(axis=2)
        inside = mask(session, name, 2)
        assert 0.005 < inside.mean() < 0.2
        assert np.median(difference[inside]) > 40
        # Shadows on the floor are outside the masks too.
        assert np.median(difference[~inside]) < 4 and (difference[~inside] > 20).mean() < 0.03


def test_one_clap_is_heard_and_seen(session, truth):
    other = truth[1]
    late = {name: camera["late"] for name, camera in other["cameras"].items()}
    assert late["head0"] == 0 and all(0 <= seconds < 0.04 for seconds in late.values())
    assert max(late.values()) - min(late.values()) > 0.02
    for name in FILMS:
        heard = sound(session / f"performance/{name}.mp4")
        assert abs(len(heard) - 48000 * FRAMES / RATE) < 960
        at = np.abs(heard).argmax() / 48000
        assert abs(at - (other["clap"]["seconds"] - late[name])) < 0.0002
        light = film(session / f"performance/{name}.mp4").mean(axis=(1, 2, 3))
        assert light.argmax() == other["clap"]["seconds"] * RATE
        assert light.max() > 1.2 * np.median(light)


def test_cameras_differ_in_exposure(truth):
    gains = np.array([camera["gains"] for camera in truth[1]["cameras"].values()])
    assert np.abs(np.log2(gains)).max() <= 0.4
    assert gains[:, 1].max() / gains[:, 1].min() > 1.2


def test_the_truth_makes_a_stream(session, truth, tmp_path):
    capture = truth[0]
    assert capture["frames"] == {"first": 1, "count": FRAMES - 1}
    late = {name: camera["late"] for name, camera in truth[1]["cameras"].items()}
    for camera in capture["cameras"]:
        if camera["name"] == "oval2":
            continue
        # The picture nearest in time, and its mask.
        before = int(late[camera["name"]] * RATE > 0.5)
        numerator, denominator = map(int, camera["pictures"]["start"].split("/"))
        assert numerator * RATE == (1 - before) * denominator
        assert camera["masks"]["offset"] == -before
    out = tmp_path / "true.fvv"
    # With warnings, of pictures that are not used.
    run("fvvmux", session / "truth", "-o", out, "--codec", "jpeg", "--quality", 60, code=3)
    run("fvvrender", out, "-o", tmp_path / "drawn.png", "--camera", 2, "--leave-one-out", "--frame", 6)
    drawn = np.asarray(Image.open(tmp_path / "drawn.png")).astype(float)
    true = np.asarray(Image.open(session / "truth/oval2/0007.png")).astype(float)
    inside = mask(session, "oval2", 7)
    assert drawn[inside].mean() > 40
    assert np.abs(drawn - true)[inside].mean() < 30
    assert drawn[~inside].mean() < 5


def test_clocks_that_agree(tmp_path):
    folder = tmp_path / "shoot"
    run("fvvsynth", "-o", folder, "--footage", "--size", "96x54", "--frames", 1, "--poses", 2, "--late", 0)
    capture, other = (
        json.loads((folder / "truth" / name).read_text()) for name in ("capture.json", "truth.json")
    )
    assert {camera["late"] for camera in other["cameras"].values()} == {0}
    assert capture["frames"] == {"first": 0, "count": 1}
    assert other["board"]["frames_of_pose"] == 1
    # Each film shows what the truth has at the same number.
    assert {c["masks"]["offset"] for c in capture["cameras"] if c["name"] != "oval2"} == {0}


@pytest.mark.long
def test_bytes_do_not_depend_on_threads(tmp_path):
    small = ["--footage", "--size", "96x54", "--frames", 3, "--poses", 2]
    for threads in (1, 3):
        run("fvvsynth", "-o", tmp_path / str(threads), *small, "--threads", threads)
    files = sorted(path.relative_to(tmp_path / "1") for path in (tmp_path / "1").rglob("*") if path.is_file())
    assert len(files) > 3 * len(FILMS)
    for path in files:
        assert (tmp_path / "1" / path).read_bytes() == (tmp_path / "3" / path).read_bytes(), path


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["--rig", "small"], "--rig excludes --footage"),
        (["--sound"], "--sound excludes --footage"),
        (["--frames", "1"], "--frames: expected more than 1 with --footage"),
        (["--frames", "2", "--fps", "60"], "--frames: expected more than 3 with --footage"),
    ],
)
def test_options_that_do_not_go_together(tmp_path, arguments, message):
    done = run("fvvsynth", "-o", tmp_path / "out", "--footage", "--size", "96x54", *arguments, code=2)
    assert message in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("option", ["--poses", "--late"])
def test_options_that_need_footage(tmp_path, option):
    done = run("fvvsynth", "-o", tmp_path / "out", option, 1, code=2)
    assert f"{option} requires --footage" in done.stderr
