"""fvv_capture.calibrate on pictures and corners that are generated, whose truth is known."""

import dataclasses
import errno
import json
import os
import pathlib
import sys
import unittest.mock

import jsonschema
import numpy
import pytest

cv2 = pytest.importorskip("cv2")
pytest.importorskip("scipy")

sys.path.insert(0, str(pathlib.Path(__file__).parent))
sys.path.insert(0, str(pathlib.Path(__file__).parent.parent))

import room  # noqa: E402
from conftest import ROOT, tool  # noqa: E402
from fvv.errors import Error, UsageError  # noqa: E402
from fvv.outputs import FileOutput  # noqa: E402
from fvv_capture.arguments import calibrate_parser  # noqa: E402
from fvv_capture.calibrate import (  # noqa: E402
    Board,
    Corners,
    Options,
    calibrate,
    calibration,  # noqa: E402
    read_calibration,
    track,
    write_calibration,
)
from fvv_capture.calibrate import command as calibrate_command  # noqa: E402
from fvv_capture.calibrate.adjustment import adjust  # noqa: E402
from fvv_capture.calibrate.calibration import detect  # noqa: E402
from fvv_capture.calibrate.files import description, from_description  # noqa: E402
from fvv_capture.calibrate.lenses import choose  # noqa: E402
from fvv_capture.calibrate.poses import Pose, camera_poses  # noqa: E402
from fvv_capture.calibrate.recordings import Recording, recordings_of  # noqa: E402
from fvv_capture.calibrate.report import picture, report  # noqa: E402
from fvv_capture.calibrate.world import place  # noqa: E402

CHARUCO = Board(9, 6, 0.12, 0.09, "4X4_100")
LENSES = [
    (-0.21, 0.09, 0.0005, -0.0004, -0.01),
    (-0.18, 0.06, -0.0003, 0.0006, 0.0),
    (-0.25, 0.12, 0.0, 0.0, -0.02),
    (-0.15, 0.05, 0.001, -0.0005, 0.0),
]
FRAMES = 48
#: The last frame of the walk: the board lies on the floor.
FLOOR = FRAMES - 1


def validate(document, name):
    schema = json.loads((ROOT / "spec" / f"{name}.schema.json").read_text())
    jsonschema.validate(document, schema, cls=jsonschema.Draft202012Validator)


def ring(count=4, size=(1280, 720)):
    out = []
    for i in range(count):
        angle = 2 * numpy.pi * i / count
        centre = (5 * numpy.sin(angle), 2.4 + 0.3 * i, 5 * numpy.cos(angle))
        focal = (1 + 0.02 * i) * size[0]
        out.append(
            room.look(centre, (0.1 * i, 1.0, 0), focal, size, LENSES[i], "radtan", i, f"cam{i}", 0.02 * i)
        )
    return out


def lying(board):
    """The board on the floor, print up, a little beside the origin."""
    rotation = cv2.Rodrigues(numpy.array([0, 0.4, 0.0]))[0] @ numpy.array(
        [[1, 0, 0], [0, 0, -1], [0, 1.0, 0]]
    )
    return rotation, numpy.array([-0.4, 0.0, -0.3])


def write_pictures(folder, board, cameras, poses, generator, samples=2):
    for camera in cameras:
        (folder / camera.name).mkdir(parents=True)
        for frame, pose in enumerate(poses):
            grey = room.render(camera, [room.board_rectangle(board, pose)], generator, samples=samples)
            cv2.imwrite(str(folder / camera.name / f"{frame:04d}.png"), grey)


def corners_of(board, cameras, poses, generator, noise=0.05):
    """What a perfect detector with noise would find: boards that face the camera, corners within the picture."""
    out = {}
    for camera in cameras:
        out[camera.name] = {}
        for frame, (rotation, translation) in enumerate(poses):
            points = board.points @ rotation.T + translation
            if (points.mean(axis=0) - camera.centre) @ rotation[:, 2] < 0.3:
                continue
            pixels = camera.project(points)
            inside = (pixels > 2).all(axis=1) & (pixels < [camera.width - 2, camera.height - 2]).all(axis=1)
            if inside.sum() > 12:
                found = pixels[inside] + generator.normal(0, noise, (inside.sum(), 2))
                out[camera.name][frame] = Corners(numpy.flatnonzero(inside), found)
    return out


@pytest.fixture(scope="session")
def walk(tmp_path_factory):
    """Cameras, and the folder of a board walk."""
    folder = tmp_path_factory.mktemp("walk")
    generator = numpy.random.default_rng(5)
    cameras = ring()
    poses = [*room.walk(CHARUCO, cameras, FRAMES - 1, generator), lying(CHARUCO)]
    write_pictures(folder, CHARUCO, cameras, poses, generator)
    return cameras, folder


@pytest.fixture(scope="session")
def calibrated(walk):
    """The cameras, their calibration, and the progress that was reported."""
    cameras, folder = walk
    steps = []
    found = calibrate(
        recordings_of(str(folder)), CHARUCO, Options(floor=FLOOR), lambda *step: steps.append(step)
    )
    return cameras, found, steps


def test_cameras_are_where_they_are(calibrated):
    cameras, found, _ = calibrated
    assert [one.name for one in found.cameras] == [one.name for one in cameras]
    assert found.rms < 0.1
    true = [one.centre for one in cameras]
    apart = room.aligned_centres([one.pose.centre for one in found.cameras], true)
    assert apart.max() < 0.006, apart
    # Without alignment: the board's squares give the scale, the board on the floor the height.
    for camera, one in zip(cameras, found.cameras):
        assert one.pose.centre[1] == pytest.approx(camera.centre[1], abs=0.02)
    tilt = [one.pose.rotation[:, 1] @ camera.R[:, 1] for camera, one in zip(cameras, found.cameras)]
    assert min(tilt) > numpy.cos(numpy.radians(0.3))


def test_lens_is_right_up_to_r_max(calibrated):
    cameras, found, _ = calibrated
    for camera, one in zip(cameras, found.cameras):
        pixels = numpy.stack(
            numpy.meshgrid(numpy.linspace(20, 1260, 12), numpy.linspace(20, 700, 7)), -1
        ).reshape(-1, 2)
        rays = camera.ray(pixels)[1] @ camera.R.T
        rays = rays / rays[:, 2:]
        seen = numpy.linalg.norm(one.lens.rays(one.pixels), axis=1).max()
        assert 1.09 * seen < one.r_max <= 1.1001 * seen
        inside = numpy.linalg.norm(rays[:, :2], axis=1) < seen
        assert inside.sum() > 30
        # A turn of the camera by what the principal point is off changes no picture: it is taken out.
        apart = one.lens.project(rays)[0] - pixels
        assert numpy.abs(apart - apart[inside].mean(axis=0))[inside].max() < 0.8
        mine = one.lens.camera(0, numpy.eye(3), numpy.zeros(3), "", one.r_max)
        assert mine.project(rays[inside]) == pytest.approx(one.lens.project(rays[inside])[0], abs=1e-6)


def test_progress_and_rejected_corners(calibrated):
    _, found, steps = calibrated
    assert {what for what, _, _ in steps} == {"corners", "lenses", "adjustment"}
    assert all(0 <= done <= of for _, done, of in steps)
    used = sum(len(one.pixels) for one in found.cameras)
    assert 0 <= found.rejected < 0.2 * used


def test_report_and_its_pictures(calibrated, tmp_path):
    _, found, _ = calibrated
    document = report(found, "c.json")
    validate(document, "fvvcapture-calibrate")
    assert document["rms_px"] == pytest.approx(found.rms)
    for camera in found.cameras:
        shown = picture(camera)
        assert shown.shape == (64 + 720 + 56, 1280, 3)
        # Cells with corners have a colour, those without are grey.
        heat = shown[64:784].astype(int)
        coloured = (numpy.ptp(heat, axis=2) > 20).mean()
        grey = (heat == 225).all(axis=2).mean()
        assert 0.1 < coloured < 0.95 and 0.03 < grey < 0.9
        assert coloured + grey > 0.7
        # A residual is drawn at its corner.
        x, y = camera.pixels[0].astype(int)
        assert shown[64 + y - 1 : 64 + y + 2, x - 1 : x + 2].min() < 100


def test_file_holds_the_cameras(calibrated, tmp_path):
    cameras, found, _ = calibrated
    path = tmp_path / "calibration.json"
    write_calibration(str(path), found)
    validate(json.loads(path.read_text()), "fvvcapture-calibration")
    described, up = read_calibration(str(path))
    assert up == "+y"
    for one, camera in zip(described, found.cameras):
        mine = room.camera_at(one)
        points = numpy.random.default_rng(0).uniform(-1, 1, (40, 3)) + [0, 1, 0]
        expected = camera.lens.project(camera.pose(points))[0]
        assert mine.project(points) == pytest.approx(expected, abs=1e-6)
    with pytest.raises(UsageError, match="already exists"):
        write_calibration(str(path), found)
    write_calibration(str(path), found, force=True)
    assert [one.name for one in tmp_path.iterdir()] == ["calibration.json"]


def test_calibration_and_pictures_are_written_or_none(calibrated, tmp_path, monkeypatch):
    monkeypatch.setattr(calibrate_command, "_calibrated", lambda *_: calibrated[1])
    arguments = ["walk", "--board", "9x6", "--square", "0.12", "--report", tmp_path / "report"]
    arguments += ["-o", tmp_path / "calibration.json"]
    with monkeypatch.context() as patched, pytest.raises(OSError, match="No space"):
        full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "calibration.json")
        patched.setattr(FileOutput, "place", unittest.mock.Mock(side_effect=full))
        run(*arguments)
    assert os.listdir(tmp_path) == []
    run(*arguments)
    assert sorted(os.listdir(tmp_path)) == ["calibration.json", "report"]


def test_fvvimport_reads_the_opencv_form(calibrated, tmp_path):
    _, found, _ = calibrated
    write_calibration(str(tmp_path / "opencv"), found, "opencv")
    files = [str(tmp_path / "opencv" / f"{one.name}.yml") for one in found.cameras]
    output = tmp_path / "capture.json"
    tool(
        "fvvimport", "opencv", *files, "-o", output, "--units", "metres", "--meshes", "mesh.ply", "--frames", "0-0",
        "--frame-rate", "30",
    )  # fmt: skip
    capture = json.loads(output.read_text())
    assert capture.get("conventions", {"pixel_centre": 0.5}) == {"pixel_centre": 0.5}
    points = numpy.random.default_rng(0).uniform(-1, 1, (20, 3)) + [0, 1, 0]
    for one, camera in zip(capture["cameras"], found.cameras):
        expected = camera.lens.project(camera.pose(points))[0]
        assert room.camera_at(one).project(points) == pytest.approx(expected, abs=1e-5)


def test_offset_and_size(walk, tmp_path):
    cameras, folder = walk
    for camera, late in ((cameras[0], 0), (cameras[1], 3)):
        (tmp_path / camera.name).mkdir()
        for frame in range(5):
            (tmp_path / camera.name / f"{frame + late:02d}.png").symlink_to(
                folder / camera.name / f"{frame:04d}.png"
            )
        for frame in range(late):
            (tmp_path / camera.name / f"{frame:02d}.png").symlink_to(folder / camera.name / "0030.png")
    options = Options(last=4)
    _, true = detect(recordings_of(str(folder)), CHARUCO, options)
    _, found = detect(recordings_of(str(tmp_path), {"cam1": 3}), CHARUCO, options)
    assert found["cam1"]
    for name in found:
        assert list(found[name]) == list(true[name])
        for frame, view in found[name].items():
            assert (view.pixels == true[name][frame].pixels).all()
    with pytest.raises(UsageError, match="offset cam9: expected one of cam0, cam1"):
        recordings_of(str(tmp_path), {"cam9": 1})
    cv2.imwrite(str(tmp_path / "cam0" / "90.png"), numpy.zeros((100, 200), numpy.uint8))
    with pytest.raises(Error, match="camera cam0: frame 5: expected a picture of 1280x720, found 200x100"):
        detect(recordings_of(str(tmp_path)), CHARUCO, Options())


def test_too_few_views_are_counted(walk):
    _, folder = walk
    with pytest.raises(Error, match=r"camera cam\d: expected the board in 6 frames or more, found it in \d"):
        calibrate(recordings_of(str(folder)), CHARUCO, Options(last=5))


def test_cameras_that_share_no_view_are_named():
    generator = numpy.random.default_rng(1)
    cameras = ring()
    views = corners_of(CHARUCO, cameras, room.walk(CHARUCO, cameras, 60, generator), generator)
    for name in ("cam1", "cam3"):
        views[name] = {
            f: v for f, v in views[name].items() if f not in views["cam0"] and f not in views["cam2"]
        }
    lens = choose("radtan5", CHARUCO, list(views["cam0"].values()), (1280, 720))[0]
    lenses = {one.name: lens for one in cameras}
    with pytest.raises(Error, match=r"not connected.*cam0"):
        camera_poses(lenses, CHARUCO, views)


def given(monkeypatch, views):
    """Recordings in which these corners are found."""
    sizes = dict.fromkeys(views, (1280, 720))
    monkeypatch.setattr(calibration, "detect", lambda *_: (sizes, views))
    return [Recording(name, "") for name in views]


def test_lens_and_pose_of_a_camera_that_moves_in_the_walk(monkeypatch):
    generator = numpy.random.default_rng(11)
    cameras = ring()
    poses = room.walk(CHARUCO, cameras, 50, generator)
    views = corners_of(CHARUCO, cameras, poses, generator)
    hand = {}
    truth = {}
    for frame, pose in enumerate(poses):
        centre = [0.4 * numpy.sin(frame), 1.6, 4.5 + 0.01 * frame]
        truth[frame] = room.look(centre, (0, 1.1, 0), 1200, (1280, 720), LENSES[0], "radtan", 4, "hand")
        seen = corners_of(CHARUCO, [truth[frame]], [pose], generator)["hand"]
        if seen:
            hand[frame] = seen[0]
    recordings = given(monkeypatch, views | {"hand": hand})
    found = calibrate(recordings, CHARUCO, Options(moving=("hand",)))
    lens = found.camera("hand").lens
    assert lens.parameters[0] == pytest.approx(1200, rel=0.005)
    # Its place among the others is that of the first frame in which they see the board as well.
    first = min(set(hand) & set(found.boards))
    still = [one.centre for one in cameras]
    apart = room.aligned_centres([one.pose.centre for one in found.cameras], [*still, truth[first].centre])
    assert apart[:4].max() < 0.03 and apart[4] < 0.05, apart


def test_camera_out_of_step_is_named(monkeypatch):
    generator = numpy.random.default_rng(12)
    cameras = ring()
    views = corners_of(CHARUCO, cameras, room.walk(CHARUCO, cameras, 40, generator), generator)
    views["cam2"] = {frame + 1: view for frame, view in views["cam2"].items()}
    with pytest.raises(
        Error, match=r"camera cam2: expected 3 frames or more in which .*cam0, cam1, cam3.*--offset"
    ):
        calibrate(given(monkeypatch, views), CHARUCO)


@pytest.mark.parametrize("outliers", [0.0, 0.03])
def test_adjustment_of_corners(outliers):
    """Corners with 0.1 px of noise, of which some are anywhere near."""
    generator = numpy.random.default_rng(2)
    cameras = ring()
    views = corners_of(CHARUCO, cameras, room.walk(CHARUCO, cameras, 50, generator), generator, noise=0.1)
    count = 0
    for seen in views.values():
        for view in seen.values():
            wrong = generator.random(len(view.ids)) < outliers
            view.pixels[wrong] += generator.uniform(2, 12, (wrong.sum(), 2))
            count += wrong.sum()
    lenses = {
        name: choose("auto", CHARUCO, list(seen.values()), (1280, 720))[0] for name, seen in views.items()
    }
    poses, boards = camera_poses(lenses, CHARUCO, views)
    bundle = adjust(CHARUCO, lenses, poses, boards, views)
    apart = room.aligned_centres(
        [bundle.cameras[one.name].centre for one in cameras], [one.centre for one in cameras]
    )
    assert apart.max() < 0.004, apart
    # Two dimensions: sqrt(2) times the noise, less what the unknowns take up.
    assert 0.12 < bundle.rms() < 0.145
    assert count <= bundle.rejected < count + 60


def test_model_is_chosen_by_held_out_views():
    generator = numpy.random.default_rng(3)
    size = (1280, 720)
    plain = room.look(
        (0, 1, 5), (0, 1, 0), 800, size, (-0.2, 0.06, 0.0003, -0.0002, -0.01), "radtan", name="a"
    )
    # A wide lens whose curve no polynomial of degree 6 follows.
    wide = room.look(
        (0, 1, 5),
        (0, 1, 0),
        500,
        size,
        (0.9, 0.2, 0.0002, 0.0001, 0.01, 1.25, 0.42, 0.03),
        "radtan",
        name="b",
    )
    bent = room.look((0, 1, 5), (0, 1, 0), 500, size, (-0.02, 0.01, -0.004, 0.0005), "fisheye", name="c")
    for camera, model, expected in (
        (plain, "auto", "radtan5"),
        (wide, "auto", "radtan8"),
        (bent, "fisheye", "fisheye"),
    ):
        poses = []
        for _ in range(40):
            pixel = generator.uniform(0.02, 0.98, 2) * size
            place = camera.centre + camera.ray(pixel)[1] * generator.uniform(1.0, 2.0)
            forward = place - camera.centre
            pose = room.look(camera.centre, place, 1, size)
            rotation = pose.R.T @ cv2.Rodrigues(generator.uniform(-0.6, 0.6, 3))[0]
            assert forward @ rotation[:, 2] > 0
            poses.append((rotation, place - rotation @ [0.54, 0.36, 0]))
        views = list(corners_of(CHARUCO, [camera], poses, generator)[camera.name].values())
        lens, compared = choose(model, CHARUCO, views, size)
        assert lens.model == expected, compared
        assert lens.parameters[:4] == pytest.approx([*numpy.diag(camera.K)[:2], *camera.K[:2, 2]], abs=1.5)
        if model == "auto":
            assert set(compared) == {"radtan5", "radtan8"}
            assert 0.04 < compared[expected] < 0.12


def test_axes_of_the_world():
    cameras = {one.name: Pose(one.R, one.t) for one in ring()}
    board = lying(CHARUCO)
    for up in ("+x", "-x", "+y", "-y", "+z", "-z"):
        placement = place(cameras, {7: Pose(*board)}, CHARUCO, up, floor=7)
        sign, axis = (1 if up[0] == "+" else -1), "xyz".index(up[1])
        assert numpy.linalg.det(placement.rotation) == pytest.approx(1)
        for pose in cameras.values():
            assert sign * placement.camera(pose).centre[axis] == pytest.approx(pose.centre[1])
            assert placement.camera(pose).rotation @ placement.rotation == pytest.approx(pose.rotation)
        flat = placement.board(Pose(*board))(CHARUCO.points)
        assert flat[:, axis] == pytest.approx(0, abs=1e-9)
    free = place(cameras, {}, CHARUCO)
    upwards = free.rotation.T @ [0, 1, 0]
    assert upwards @ [0, 1, 0] > numpy.cos(numpy.radians(3))
    with pytest.raises(UsageError, match="floor: expected a frame"):
        place(cameras, {}, CHARUCO, floor=3)
    rolled = {
        n: Pose(numpy.diag([(-1.0) ** i, (-1.0) ** i, 1]) @ p.rotation, p.translation)
        for i, (n, p) in enumerate(cameras.items())
    }
    with pytest.raises(Error, match="do not agree which way is up"):
        place(rolled, {}, CHARUCO)


def test_distance_gives_the_scale():
    cameras = {one.name: Pose(one.R, one.t) for one in ring()}
    placement = place(cameras, {}, CHARUCO, distance=("cam0", "cam2", 20.0))
    moved = {name: placement.camera(pose) for name, pose in cameras.items()}
    assert numpy.linalg.norm(moved["cam0"].centre - moved["cam2"].centre) == pytest.approx(20.0)
    # The picture is the same.
    points = numpy.array([[0.3, 1.1, -0.2]])
    new = placement.scale * points @ placement.rotation.T + placement.translation
    for name, pose in cameras.items():
        before, after = pose(points)[0], moved[name](new)[0]
        assert after[:2] / after[2] == pytest.approx(before[:2] / before[2])
    with pytest.raises(UsageError, match="distance: expected cameras among"):
        place(cameras, {}, CHARUCO, distance=("cam0", "x", 1.0))


def test_options_that_cannot_be_fulfilled(walk):
    _, folder = walk
    recordings = recordings_of(str(folder))
    for options, message in [
        (Options(moving=("cam7",)), "moving: expected cameras among cam0, cam1"),
        (Options(moving=("cam0", "cam1")), "moving: expected 3 cameras or more that stand still, found 2"),
        (Options(lens="thin"), "lens: expected one of auto"),
        (Options(up="y"), "up: expected one of"),
        (Options(step=0), "step of 1 or more"),
    ]:
        with pytest.raises(UsageError, match=message):
            calibrate(recordings, CHARUCO, options)
    with pytest.raises(UsageError, match="looks the same after half a turn"):
        calibrate(recordings, Board(8, 6, 0.1), Options())


def test_recordings_that_cannot_be_read(tmp_path):
    with pytest.raises(UsageError, match="found none"):
        recordings_of(str(tmp_path))
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "0.png").write_bytes(b"no picture")
    (a,) = recordings_of(str(tmp_path))
    with pytest.raises(Error, match=r"a/0.png: frame 0: is no picture"):
        list(a.frames())
    (tmp_path / "b.mp4").write_bytes(b"no video")
    with pytest.raises(Error, match=r"b.mp4: is no video"):
        recordings_of(str(tmp_path))
    assert [one.name for one in recordings_of(str(tmp_path), exclude=["b"])] == ["a"]
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "0.png").write_bytes(b"")
    with pytest.raises(UsageError, match=r"b.mp4: expected one recording of each camera, found \S+/b too"):
        recordings_of(str(tmp_path))


def test_failures_of_opencv_name_file_and_frame(tmp_path, monkeypatch):
    def outside(board, grey):
        return cv2.findHomography(numpy.zeros((2, 2)), numpy.zeros((3, 2)))

    monkeypatch.setattr(Board, "detect", outside)
    (tmp_path / "a").mkdir()
    cv2.imwrite(str(tmp_path / "a" / "7.png"), numpy.zeros((90, 160), numpy.uint8))
    with pytest.raises(Error, match=r"/a: frame 0: OpenCV [45]\.") as caught:
        detect(recordings_of(str(tmp_path)), CHARUCO, Options())
    assert caught.value.file == str(tmp_path / "a") and "\n" not in str(caught.value)


def run(*arguments):
    return calibrate_command.run(calibrate_parser("").parse([str(one) for one in arguments]))


def test_command_on_videos_of_a_chessboard(tmp_path, capsys):
    board = Board(7, 4, 0.15)
    generator = numpy.random.default_rng(6)
    cameras = [
        room.look((x, 1.2, 4), (0, 1.0, 0), 700, (640, 480), (-0.1, 0.02, 0, 0, 0), "radtan", i, name)
        for i, (x, name) in enumerate(((-1.0, "left"), (1.0, "right")))
    ]
    poses = room.walk(board, cameras, 26, generator, reach=(0.8, 0.5, 0.8), height=1.1)
    (tmp_path / "videos").mkdir()
    for camera in cameras:
        pictures = [
            room.render(camera, [room.board_rectangle(board, pose, margin=1)], generator, samples=2)
            for pose in poses
        ]
        writer = cv2.VideoWriter(
            str(tmp_path / "videos" / f"{camera.name}.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 25, (640, 480)
        )
        writer.set(cv2.VIDEOWRITER_PROP_QUALITY, 100)
        for one in pictures:
            writer.write(cv2.cvtColor(one, cv2.COLOR_GRAY2BGR))
        writer.release()
    board_arguments = ("--board", "7x4", "--square", "0.15")
    output = tmp_path / "calibration.json"
    code = run(tmp_path / "videos", *board_arguments, "-o", output, "--report", tmp_path / "report", "--json")
    out, err = capsys.readouterr()
    document = json.loads(out)
    validate(document, "fvvcapture-calibrate")
    assert code == (3 if document["warnings"] else 0)
    assert [line for line in err.splitlines() if not line.startswith("fvvcapture: camera")] == []
    assert document["output"] == str(output) and document["rms_px"] < 0.15
    left, right = (numpy.array(one["centre"]) for one in document["cameras"])
    assert numpy.linalg.norm(left - right) == pytest.approx(2.0, abs=0.02)
    assert sorted(one.name for one in (tmp_path / "report").iterdir()) == ["left.png", "right.png"]
    assert cv2.imread(str(tmp_path / "report" / "left.png")).std() > 10
    for arguments, message in [
        ((tmp_path / "videos", *board_arguments, "-o", output), "already exists"),
        ((tmp_path / "videos", *board_arguments), "nothing to write"),
        ((tmp_path / "videos", "--json"), "expected --board and --square"),
        ((tmp_path / "videos", "--json", *board_arguments, "--offset", "left"), "expected CAMERA=FRAMES"),
        ((tmp_path / "videos", "--json", *board_arguments, "--frames", "5-2"), "--frames: expected A-B"),
        (
            (tmp_path / "videos", "--json", *board_arguments, "--moving", "left"),
            "--moving, --tripod: expected --take",
        ),
        (
            (tmp_path / "videos", "--json", *board_arguments, "--distance", "left", "right", "far"),
            "--distance: expected a number",
        ),
        (("--json", *board_arguments), "expected FOLDER"),
    ]:
        with pytest.raises(UsageError, match=message):
            run(*arguments)


def wall(generator, rows, columns):
    """Patches of many sizes, as a bookshelf or a brick wall has."""
    out = numpy.zeros((rows, columns))
    for size in (4, 9, 20, 45):
        noise = generator.normal(0, 1, (rows // size + 2, columns // size + 2))
        out += cv2.resize(noise, (columns, rows), interpolation=cv2.INTER_NEAREST)
    return numpy.clip(120 + 45 * out, 0, 255).astype(numpy.float32)


def studio(generator):
    """A floor, two walls and boxes, with texture."""
    boxes = [
        ([-2.5, 2.5, -2.5], [5, 0, 0], [0, -2.5, 0]),
        ([-2.5, 2.5, 1.5], [0, 0, -4], [0, -2.5, 0]),
        ([-2.5, 0, -2.5], [5, 0, 0], [0, 0, 4.5]),
        ([-1.4, 1.2, -1.2], [0.9, 0, 0.3], [0, -1.2, 0]),
        ([0.6, 0.9, -0.8], [0.8, 0, -0.4], [0, -0.9, 0]),
    ]
    return [
        room.Rectangle(
            o, a, d, wall(generator, int(160 * numpy.linalg.norm(d)), int(160 * numpy.linalg.norm(a)))
        )
        for o, a, d in boxes
    ]


@pytest.mark.parametrize("zoom", [False, True])
def test_cameras_that_move(tmp_path, capsys, zoom):
    generator = numpy.random.default_rng(8)
    size, lens = (640, 400), (-0.12, 0.03, 0.0002, -0.0003, 0.0)
    still = [
        room.look((x, y, 4), (0, 0.9, -1), 620, size, lens, "radtan", i, f"still{i}")
        for i, (x, y) in enumerate(((-0.9, 1.3), (0.1, 1.8), (1.1, 1.2)))
    ]
    frames = 4
    path = [
        room.look(
            (-0.6 + 0.2 * i, 1.5 + 0.05 * i, 3.6 - 0.1 * i),
            (-0.5 + 0.2 * i, 0.9, -1),
            560 * (1 + 0.04 * i * zoom),
            size,
            lens,
            "radtan",
            3,
            "hand",
            roll=0.03 * i,
        )
        for i in range(frames)
    ]
    scene = studio(generator)
    actor = wall(generator, 200, 100)
    for name in (*(one.name for one in still), "hand"):
        (tmp_path / "take" / name).mkdir(parents=True)
    for frame in range(frames):
        walks = room.Rectangle([-1.2 + 0.35 * frame, 1.6, 0.2], [0.5, 0, 0], [0, -1.6, 0], actor)
        for camera in (*still, path[frame]):
            grey = room.render(camera, [*scene, walks], generator, samples=2)
            cv2.imwrite(str(tmp_path / "take" / camera.name / f"{frame:03d}.png"), grey)
    start = room.look((0, 1, 4), (0, 1, 0), 560, size, lens, "radtan", 3, "hand")
    document = {
        "fvv_calibration": 1, "units": "metres", "up": "+y", "conventions": {"pixel_centre": 0.5},
        "cameras": described([*still, start], lens),
    }  # fmt: skip
    (tmp_path / "still.json").write_text(json.dumps(document))
    output = tmp_path / "moving.json"
    code = run(
        "--calibration", tmp_path / "still.json", "--take", tmp_path / "take", "--moving", "hand", "-o", output, "--json",
        *(["--zoom"] if zoom else []),
    )  # fmt: skip
    summary = json.loads(capsys.readouterr().out)
    validate(summary, "fvvcapture-calibrate")
    assert code == 0
    assert summary["cameras"][3]["moves"]["found"] == frames
    assert summary["cameras"][3]["moves"]["worst_rms_px"] < 1.5
    written = json.loads(output.read_text())
    validate(written, "fvvcapture-calibration")
    hand = written["cameras"][3]
    validate(
        {
            "fvv_capture": 1, "frame_rate": 25, "frames": {"first": 0, "count": frames}, "units": "metres",
            "meshes": {"pattern": "%d.ply"}, "cameras": written["cameras"],
        },
        "capture",
    )  # fmt: skip
    assert [one["frame"] for one in hand["per_frame"]] == list(range(frames))
    points = numpy.stack(numpy.meshgrid([-1.5, 0, 1.5], [0.2, 1.5], [-2, 0]), -1).reshape(-1, 3)
    worst = []
    for frame, true in enumerate(path):
        found = room.camera_at(hand, frame)
        assert numpy.linalg.norm(found.centre - true.centre) < (0.02 if zoom else 0.005)
        assert found.K[0, 0] == pytest.approx(true.K[0, 0], rel=0.01 if zoom else 1e-9)
        worst.append(numpy.nanmax(numpy.linalg.norm(found.project(points) - true.project(points), axis=1)))
    print("largest distance of projected points from the truth, px, by frame:", numpy.round(worst, 2))
    assert max(worst) < 0.6, worst


def described(cameras, lens):
    """Cameras as a calibration file has them."""
    return [
        {
            "id": one.id, "name": one.name, "width": one.width, "height": one.height,
            "intrinsics": {"fx": one.K[0, 0], "fy": one.K[1, 1], "cx": one.K[0, 2], "cy": one.K[1, 2]},
            "lens": {"model": "radtan", "coefficients": list(lens), "r_max": 0.8},
            "rotation": one.R.tolist(), "translation": one.t.tolist(),
        }
        for one in cameras
    ]  # fmt: skip


def test_camera_on_a_tripod(tmp_path):
    """It turns by 40 degrees, so that little of the first picture is left, and zooms; no other camera is there."""
    generator = numpy.random.default_rng(10)
    lens = (-0.12, 0.03, 0.0002, -0.0003, 0.0)
    path = [
        room.look(
            (0.3, 1.3, 3),
            (0.3 + 5 * numpy.tan(angle), 1.0, -2),
            500 * (1 + 0.03 * i),
            (640, 400),
            lens,
            "radtan",
            0,
            "pan",
        )
        for i, angle in enumerate(numpy.linspace(-0.35, 0.35, 6))
    ]
    scene = studio(generator)
    (tmp_path / "pan").mkdir()
    for frame, camera in enumerate(path):
        cv2.imwrite(str(tmp_path / "pan" / f"{frame}.png"), room.render(camera, scene, generator, samples=2))
    start = from_description(described(path[:1], lens), "+y")
    found = track(start, recordings_of(str(tmp_path)), [], tripod=["pan"], zoom=True)
    points = numpy.stack(numpy.meshgrid([-1.5, 0, 1.5], [0.2, 1.5], [-2, 0]), -1).reshape(-1, 3)
    worst = []
    for frame, true in enumerate(path):
        mine = room.camera_at(description(found)["cameras"][0], frame)
        assert mine.centre == pytest.approx(true.centre, abs=1e-9)
        shown = true.project(points)
        inside = (shown > 0).all(axis=1) & (shown < [640, 400]).all(axis=1)
        assert inside.any()
        worst.append(numpy.linalg.norm(mine.project(points) - shown, axis=1)[inside].max())
    print("largest distance of projected points from the truth, px, by frame:", numpy.round(worst, 2))
    assert worst[0] == pytest.approx(0, abs=1e-6) and max(worst) < 0.3


def test_real_camera_that_stands_still_is_found_to(tmp_path):
    """A person walks through the picture; the tracker may not be carried along."""
    folder = (
        pathlib.Path(os.environ.get("FVV_DATA", ROOT.parent / "shared" / "data"))
        / "pose2sim_4cam"
        / "Demo_SinglePerson"
    )
    if not folder.is_dir():
        pytest.skip(f"no {folder}: set FVV_DATA")
    output = tmp_path / "capture.json"
    tool(
        "fvvimport", "qualisys", folder / "calibration" / "Calib.qca.txt", "-o", output, "--meshes", "%d.ply", "--frames", "0-1",
        "--frame-rate", "60",
    )  # fmt: skip
    camera = json.loads(output.read_text())["cameras"][0]
    camera.update(name="cam01", width=1080)  # the video lacks 8 columns
    recordings = [one for one in recordings_of(str(folder / "videos")) if one.name == "cam01"]
    found = track(
        from_description([camera], "+z"), recordings, [], first=0, step=40, last=80, tripod=["cam01"]
    )
    moments = found.cameras[0].per_frame
    assert list(moments) == [0, 40, 80]
    for moment in moments.values():
        turn = cv2.Rodrigues(moment.pose.rotation @ found.cameras[0].pose.rotation.T)[0]
        assert numpy.degrees(numpy.linalg.norm(turn)) < 0.02
        assert moment.matches > 500


def test_frames_without_a_pose_are_listed(tmp_path):
    """A frame that shows nothing is not calibrated, and is in the file."""
    generator = numpy.random.default_rng(9)
    cameras = [
        room.look((x, 1.3, 4), (0, 0.9, -1), 400, (400, 260), (), "none", i, name)
        for i, (x, name) in enumerate(((-0.6, "a"), (0.0, "b"), (0.6, "c"), (0.3, "hand")))
    ]
    scene = studio(generator)
    for camera in cameras:
        (tmp_path / camera.name).mkdir()
        for frame in range(3):
            grey = room.render(camera, scene, generator, samples=2)
            if camera.name == "hand" and frame == 1:
                grey[:] = 128
            cv2.imwrite(str(tmp_path / camera.name / f"{frame}.png"), grey)
    plain = from_description(described(cameras, [0.0] * 5), "+y")
    found = track(plain, recordings_of(str(tmp_path)), ["hand"])
    hand = description(found)["cameras"][3]
    assert hand["per_frame"][1] == {"frame": 1, "calibrated": False}
    assert room.camera_at(hand, 1) is None
    assert room.camera_at(hand, 0) is not None
    with pytest.raises(UsageError, match="frame 5: is not among"):
        room.camera_at(hand, 5)
    with pytest.raises(UsageError, match="OpenCV's files cannot hold"):
        write_calibration(str(tmp_path / "out"), dataclasses.replace(found), "opencv")
    with pytest.raises(UsageError, match="expected 3 cameras or more that stand still, found 2"):
        track(plain, recordings_of(str(tmp_path)), ["hand", "a"])
    with pytest.raises(UsageError, match="camera no: expected one of a, b, c, hand"):
        track(plain, recordings_of(str(tmp_path)), ["no"])
