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
        == f"fvvimport: {tmp_path}/empty: expected files .yml, .yaml or .xml, found none\n"
    )


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
            "--size: expected for middlebury and krt only, the other formats say how large pictures are",
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
