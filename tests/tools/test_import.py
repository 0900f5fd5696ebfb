"""fvvimport: cameras written in other formats by independent formulas project points to the same places."""

import json

import import_formats
import numpy as np
import pytest
from conftest import Tool, read_json, validate


@pytest.fixture(scope="session")
def fvvimport():
    return Tool("fvvimport")


@pytest.fixture
def written(tmp_path):
    """The arguments for reading a COLMAP model, and its cameras."""
    return import_formats.write_colmap(tmp_path, np.random.default_rng(3))


@pytest.mark.parametrize("name", import_formats.WRITERS)
def test_projections_agree(fvvimport, name, tmp_path):
    worst = 0
    for seed in range(5):
        worst = max(worst, *import_formats.measure(fvvimport.path, name, tmp_path, seed))
    print(f"{name}: at most {worst:.3g} px")
    assert worst < 1e-6


def test_capture_is_complete_and_follows_the_schema(fvvimport, written, tmp_path):
    arguments, cameras = written
    out = tmp_path / "out.json"
    options = ["--pictures", "p/{name}_{id}/%04d.png", "--masks", "m/{id}/%04d.png", "--meshes", "m%d.ply"]
    options += ["--frames", "5-9", "--frame-rate", "30000/1001", "--up=-y"]
    done = fvvimport(*arguments, "-o", out, *options)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.decode() == f"{out}: {len(cameras)} cameras from colmap, units unknown\n"
    document = json.loads(out.read_text())
    validate(document, "capture")
    assert document["frames"] == {"first": 5, "count": 5, "step": 1}
    assert (document["frame_rate"], document["up"], document["units"]) == ("30000/1001", "-y", "unknown")
    assert document["cameras"][0]["pictures"] == "p/view0_11/%04d.png"
    assert document["cameras"][0]["masks"] == "m/11/%04d.png"


def test_videos_replace_pictures(fvvimport, written, tmp_path):
    arguments, cameras = written
    out = tmp_path / "out.json"
    done = fvvimport(*arguments, "-o", out, "--videos", "50%/{name}.mp4", "--frames", "0-9")
    assert (done.returncode, done.stderr) == (0, b"")
    document = json.loads(out.read_text())
    validate(document, "capture")
    assert document["cameras"][0]["pictures"]["video"] == "50%/view0.mp4"
    done = fvvimport(*arguments, "-o", out, "--force", "--videos", "a.mp4")
    assert done.returncode == 2
    assert b"--videos: expected {name} or {id} to tell the cameras apart" in done.stderr


@pytest.mark.parametrize(
    ("units", "factor", "written_units"),
    [
        ("feet", 0.3048, "metres"),
        ("0.25", 0.25, "metres"),
        ("unknown", 1, "unknown"),
        ("metres", 1, "metres"),
    ],
)
def test_units_become_metres(fvvimport, written, units, factor, written_units):
    arguments, cameras = written
    done = fvvimport(*arguments, "-o", "-", "--meshes", "%d.ply", "--units", units)
    assert (done.returncode, done.stderr) == (0, b"")
    document = json.loads(done.stdout)
    assert document["units"] == written_units
    for camera, (_, _, truth, _) in zip(document["cameras"], cameras):
        np.testing.assert_allclose(camera["translation"], truth.t * factor, rtol=1e-15)


def test_a_suspected_mistake_is_reported_and_exits_3(fvvimport, written, tmp_path):
    arguments, cameras = written
    random = np.random.default_rng(4)
    lines = []
    for identity, _, camera, _ in cameras:
        points = import_formats.points_before(camera, random, 20)
        for point, pixel in zip(points, camera.project(points) - 0.5):  # OpenCV's pixel convention
            lines.append(f"{import_formats.text(point)} {identity} {import_formats.text(pixel)}\n")
    points = tmp_path / "points.txt"
    points.write_text("".join(lines))
    done = fvvimport(*arguments, "--check", points)
    assert (done.returncode, done.stderr) == (3, b"")
    out = done.stdout.decode().splitlines()
    assert out[0] == "220 points: rms 0.7071 px, max 0.7071 px, 0 not visible"
    assert out[1] == "  camera 11: rms 0.7071 px"
    assert out[-1].startswith(
        "suspected: the principal point, or the points, count pixel centres half a pixel off (undone: rms "
    )
    check = read_json(fvvimport(*arguments, "--check", points, "--json"), "fvvimport")["check"]
    assert check["suspected"] == "half_pixel"
    assert check["rms_px_undone"]["half_pixel"] < 1e-9
    assert check["rms_px_undone"]["axes"] > 100


def test_an_existing_file_stays_unless_forced(fvvimport, written, tmp_path):
    arguments, _ = written
    out = tmp_path / "mine.json"
    out.write_text("mine")
    command = [*arguments, "-o", out, "--meshes", "%d.ply"]
    done = fvvimport(*command)
    assert done.returncode == 1
    assert done.stderr.decode() == f"fvvimport: {out}: already exists; --force overwrites it\n"
    assert out.read_text() == "mine"
    assert fvvimport(*command, "--force").returncode == 0
    assert json.loads(out.read_text())["fvv_capture"] == 1


def test_errors_of_files_are_one_line(fvvimport, tmp_path):
    path = tmp_path / "room.xml"
    path.write_text('<!DOCTYPE c [<!ENTITY e SYSTEM "file:///etc/hostname">]><c>&e;</c>')
    done = fvvimport("qualisys", path, "-o", tmp_path / "out.json", "--meshes", "%d.ply")
    assert (done.returncode, done.stdout) == (1, b"")
    assert done.stderr.decode() == f"fvvimport: {path}:1: expected no document type (<!DOCTYPE>), found one\n"
    assert not (tmp_path / "out.json").exists()
    done = fvvimport("opencv", tmp_path / "nothing.yml", "-o", "-", "--meshes", "%d.ply")
    assert done.returncode == 1
    assert (
        done.stderr.decode()
        == f"fvvimport: {tmp_path}/nothing.yml: cannot be opened: No such file or directory\n"
    )
    (tmp_path / "empty").mkdir()
    done = fvvimport("opencv", tmp_path / "empty", "-o", "-", "--meshes", "%d.ply")
    assert (
        done.stderr.decode()
        == f"fvvimport: {tmp_path}/empty: expected files .yml, .yaml, .xml or .json, found none\n"
    )


ROS = (
    "image_width: 4\nimage_height: 3\ncamera_matrix: {rows: 3, cols: 3, data: [5, 0, 2, 0, 5, 1, 0, 0, 1]}\n"
    "distortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n"
    "rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n"
)
LENS = "distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [4, 3]\n"
SENSOR = '<sensor id="0" type="{}"><resolution width="4" height="3"/><calibration class="adjusted"><f>5</f>{}'
METASHAPE = (
    "<document><chunk><sensors>" + SENSOR + "</calibration></sensor></sensors>"
    '<cameras><camera sensor_id="0" label="a"><transform>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</transform></camera>'
    '<camera sensor_id="0" label="b"/></cameras></chunk></document>'
)


@pytest.mark.parametrize(
    ("format", "text", "message"),
    [
        (
            "opencv",
            ROS,
            ": is a camera_info of ROS, which has no pose: expected rvec or R, and tvec or T, world",
        ),
        (
            "opencv",
            ROS.replace("plumb_bob", "omni"),
            ":4: expected plumb_bob, rational_polynomial or equidistant",
        ),
        (
            "opencv",
            '{"image_size": [4, 3], "K": [[5, 0], [0, 5]]}',
            ":1: expected 3 x 3 numbers for K, found 2 x 2",
        ),
        ("opencv", '{"image_size": [4, 3], "K": [[5, 0], [0]]}', ":1: expected rows of one length in K"),
        ("kalibr", "cam0:\n  camera_model: omni\n", ":2: expected pinhole for camera_model, found"),
        ("kalibr", "cam1:\n  camera_model: pinhole\n", ":2: expected cam0, found"),
        (
            "kalibr",
            f"cam0:\n  camera_model: pinhole\n  intrinsics: [5, 5, 2, 1]\n  {LENS}"
            f"cam1:\n  camera_model: pinhole\n  intrinsics: [5, 5, 2, 1]\n  {LENS}",
            ":8: expected the key T_cn_cnm1 in cam1, found none",
        ),
        ("toml", "[cam_0]\nsize = [4, 3]\n", ":1: expected the key matrix in cam_0, found none"),
        ("toml", "[cam_0\n", ":1: expected TOML, found: "),
        ("toml", "[metadata]\nerror = 1\n", ": expected at least one camera, found none"),
        ("metashape", METASHAPE.format("fisheye", ""), ":1: expected a sensor of the type frame, found"),
        (
            "metashape",
            METASHAPE.format("frame", "<k4>0.1</k4>"),
            ":1: expected 0 for k4, which fvv does not have",
        ),
        ("panoptic", "[]", ": expected at least one camera, found none"),
        ("panoptic", '{"a": {"K": 1}}', ': /a: expected key "resolution", found none'),
    ],
)
def test_what_other_programs_write_and_fvv_cannot_hold(fvvimport, tmp_path, format, text, message):
    path = tmp_path / "file"
    path.write_text(text)
    done = fvvimport(format, path, "-o", tmp_path / "out.json", "--meshes", "%d.ply")
    assert (done.returncode, done.stdout) == (1, b"")
    assert done.stderr.decode().startswith(f"fvvimport: {path}{message}"), done.stderr.decode()
    assert not (tmp_path / "out.json").exists()


@pytest.mark.parametrize("gone", ["rigs.txt", "frames.txt"])
def test_half_of_the_rigs_of_colmap_is_refused(fvvimport, tmp_path, gone):
    """Poses are in both; those of the list of images may be older."""
    import_formats.write_colmap_rigs(tmp_path, np.random.default_rng(0))
    (tmp_path / gone).unlink()
    done = fvvimport("colmap", tmp_path, "-o", "-", "--pictures", "{name}.png")
    assert done.returncode == 1
    assert f": expected {tmp_path}/{gone} too, as both hold the poses" in done.stderr.decode()


def test_an_image_of_no_frame_of_colmap_is_refused(fvvimport, tmp_path):
    _, cameras = import_formats.write_colmap_rigs(tmp_path, np.random.default_rng(0))
    frames = (tmp_path / "frames.txt").read_text()
    (tmp_path / "frames.txt").write_text(
        frames.replace(f" {len(cameras)} CAMERA 1 ", f" {len(cameras) - 1} CAMERA 1 ")
    )
    done = fvvimport("colmap", tmp_path, "-o", "-", "--pictures", "{name}.png")
    assert done.returncode == 1
    assert f"expected an image of one of the frames, found image {cameras[-1][0]}" in done.stderr.decode()


@pytest.mark.parametrize(("head", "units"), [({"calibDataSource": "a"}, "metres"), ({}, "unknown")])
def test_only_the_files_of_the_studio_are_in_centimetres(fvvimport, tmp_path, head, units):
    camera = {
        "resolution": [4, 3],
        "K": [[5, 0, 2], [0, 5, 1], [0, 0, 1]],
        "R": np.eye(3).tolist(),
        "t": [0, 0, 3],
    }
    (tmp_path / "c.json").write_text(json.dumps({**head, "cameras": [camera]}))
    done = fvvimport("panoptic", tmp_path / "c.json", "-o", "-", "--pictures", "{name}.png")
    document = json.loads(done.stdout)
    assert document["units"] == units
    assert document["cameras"][0]["translation"][2] == pytest.approx(0.03 if head else 3)


def test_cameras_that_are_not_aligned_are_counted(fvvimport, tmp_path):
    path = tmp_path / "cameras.xml"
    path.write_text(METASHAPE.format("frame", ""))
    done = fvvimport("metashape", path, "-o", tmp_path / "out.json", "--pictures", "{name}.png")
    warning = f"fvvimport: warning: {path}: 1 of 2 cameras are not aligned and left out\n"
    assert (done.returncode, done.stderr.decode()) == (3, warning)
    assert [one["name"] for one in json.loads((tmp_path / "out.json").read_text())["cameras"]] == ["a"]


def test_easymocap_without_sizes_needs_them(fvvimport, tmp_path):
    import_formats.write_easymocap(tmp_path, np.random.default_rng(0))
    done = fvvimport("easymocap", tmp_path, "-o", "-", "--pictures", "{name}.png")
    assert done.returncode == 1
    wanted = f"fvvimport: {tmp_path}/intri.yml: has no W_00 and H_00: pass the size of the pictures\n"
    assert done.stderr.decode() == wanted


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "expected -o FILE, --check POINTS or both"),
        (
            ["-o", "-"],
            "-o: expected --pictures, --videos or --meshes too, because a capture has one of them at least",
        ),
        (
            ["-o", "-", "--meshes", "m.ply", "--masks", "{id}.png"],
            "--masks: expected --pictures or --videos too",
        ),
        (
            ["-o", "-", "--meshes", "m.ply", "--json"],
            "--json: standard output is taken by the capture (-o -)",
        ),
        (
            ["-o", "-", "--meshes", "m.ply", "--check", "x"],
            "--check: standard output is taken by the capture (-o -)",
        ),
        (
            ["-o", "-", "--pictures", "a.png"],
            '--pictures: expected {name} or {id} to tell the cameras apart, found "a.png" for two of them',
        ),
        (
            ["-o", "-", "--pictures", "{frame}.png"],
            '--pictures: expected {name} or {id} where there are braces, found "{frame}.png"',
        ),
        (
            ["-o", "-", "--meshes", "m.ply", "--frames", "0-3"],
            '--meshes: expected %d or %0Nd for the number of each of 4 frames, found "m.ply"',
        ),
        (
            ["-o", "-", "--meshes", "m.ply", "--frames", "3-2"],
            "--frames: expected a number or two such as 10-19 or 10..19, the second not below the first, found '3-2'",
        ),
        (
            ["-o", "-", "--meshes", "m.ply", "--frame-rate", "29.97"],
            '--frame-rate: expected frames per second like 25 or 30000/1001, found "29.97"',
        ),
        (
            ["-o", "-", "--meshes", "m.ply", "--units", "yards"],
            "--units: expected metres, centimetres, millimetres, inches, feet, unknown or metres per unit > 0, "
            'found "yards"',
        ),
        (
            ["-o", "-", "--meshes", "m.ply", "--up", "z"],
            '--up: expected +x, -x, +y, -y, +z, -z or unknown, found "z"',
        ),
        (
            ["-o", "-", "--meshes", "m.ply", "--size", "1x1"],
            "--size: expected for middlebury, krt, easymocap, realitycapture only, the other formats say how large pictures are",
        ),
    ],
)
def test_wrong_options(fvvimport, written, options, message):
    done = fvvimport(*written[0], *options)
    assert (done.returncode, done.stdout, done.stderr.decode()) == (2, b"", f"fvvimport: {message}\n")


def test_wrong_formats_and_inputs(fvvimport, tmp_path):
    assert fvvimport("vicon", tmp_path, "-o", "-").returncode == 2
    assert fvvimport("--version").stdout.startswith(b"fvvimport ")
    assert fvvimport("--help").returncode == 0
    done = fvvimport("colmap", "a", "b", "-o", "-", "--meshes", "m.ply")
    assert (done.returncode, done.stderr) == (2, b"fvvimport: INPUT: expected one for colmap, found 2\n")
    done = fvvimport("middlebury", "a", "-o", "-", "--meshes", "m.ply")
    assert done.returncode == 2
    assert done.stderr.startswith(b"fvvimport: --size: expected WIDTHxHEIGHT of the pictures")
    done = fvvimport("middlebury", "a", "-o", "-", "--meshes", "m.ply", "--size", "640")
    assert done.stderr == b'fvvimport: --size: expected WIDTHxHEIGHT like 640x480, found "640"\n'
