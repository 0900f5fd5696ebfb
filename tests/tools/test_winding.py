"""Meshes whose faces are wound inside out: fvvmux finds out, warns, and turns them round when asked."""

import json
import os
import pathlib
import subprocess

import numpy as np
import pytest
from PIL import Image

TOOLS = pathlib.Path(os.environ["FVV_TOOLS_DIR"])
SIZE = 64
COLOURS = [(200, 40, 40), (40, 200, 40), (40, 40, 200)]


def tool(name, *arguments, expected=0):
    done = subprocess.run([TOOLS / name / name, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == expected, done.stderr
    return done


def ball(whole):
    """A ball around the origin with its faces outwards, or the half of it at negative z, which is open."""
    rings, sides = 8, 16
    upper = np.pi if whole else np.pi / 2
    points, faces = [], []
    for polar in np.linspace(0.01, upper - 0.01, rings):  # from -z
        for around in np.arange(sides) * 2 * np.pi / sides:
            points.append((np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), -np.cos(polar)))
    for ring in range(rings - 1):
        for side in range(sides):
            a, b = ring * sides + side, ring * sides + (side + 1) % sides
            faces += [(a, b, b + sides), (a, b + sides, a + sides)]
    return np.array(points), np.array(faces)


def scene(folder, inside_out, whole=True, cameras=3, normals=None):
    """A capture of one frame. normals: 1 for those of the ball, -1 for their opposites."""
    folder.mkdir()
    points, faces = ball(whole)
    lines = ["v {} {} {}".format(*p) for p in points]
    if normals:
        lines += ["vn {} {} {}".format(*(normals * p)) for p in points]
    for face in faces + 1:
        corners = [f"{i}//{i}" if normals else str(i) for i in (face[::-1] if inside_out else face)]
        lines.append("f " + " ".join(corners))
    (folder / "mesh_0000.obj").write_text("\n".join(lines) + "\n")
    described = []
    for number in range(cameras):
        # Three sides of the half that is always there; 4 away from the origin, looking at it.
        angle = (number - 1) * 0.6
        Image.new("RGB", (SIZE, SIZE), COLOURS[number]).save(folder / f"{number}_0000.png")
        cos, sin = np.cos(angle), np.sin(angle)
        described.append(
            {
                "id": number,
                "width": SIZE,
                "height": SIZE,
                "intrinsics": {"fx": 80, "fy": 80, "cx": SIZE / 2, "cy": SIZE / 2},
                "rotation": [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]],
                "translation": [0, 0, 4],
                "pictures": f"{number}_%04d.png",
            }
        )
    description = {
        "fvv_capture": 1,
        "name": "ball",
        "frame_rate": "25",
        "frames": {"first": 0, "count": 1},
        "units": "metres",
        "up": "-y",
        "meshes": {"pattern": "mesh_%04d.obj"},
        "cameras": described,
    }
    (folder / "capture.json").write_text(json.dumps(description))
    return folder


def pack(capture, out, *options, expected=0):
    return tool("fvvmux", capture, "-o", out, "--codec", "jpeg", "--quality", 90, "--step", "1mm",
                "--crop", "none", *options, expected=expected)  # fmt: skip


def middle_colour(stream, picture):
    tool("fvvrender", stream, "--camera", 1, "-o", picture, "--visible-by", "depth", "--best", 1)
    return np.asarray(Image.open(picture))[SIZE // 2, SIZE // 2].astype(int)


@pytest.mark.parametrize("whole", [True, False])
def test_faces_with_their_backs_to_the_cameras_are_found_and_turned(tmp_path, whole):
    capture = scene(tmp_path / "turned", inside_out=True, whole=whole)
    done = pack(capture, tmp_path / "as_it_is.fvv", expected=3)
    assert done.stderr == (
        f"fvvmux: warning: {capture / 'capture.json'}: 100 % of the surface nearest to the cameras has its back to "
        "them: the faces are inside out, and players find no colours for them (--winding flip turns them round, "
        "keep says that they are meant so)\n"
    )
    assert "winding   as in the files: 100 %" in done.stdout
    assert pack(capture, tmp_path / "meant.fvv", "--winding", "keep").stderr == ""
    done = pack(capture, tmp_path / "flipped.fvv", "--winding", "flip", "--verify")
    assert done.stderr == "" and "winding   flipped: 0 %" in done.stdout
    done = pack(capture, tmp_path / "auto.fvv", "--winding", "auto", "--json")
    winding = json.loads(done.stdout)["mesh"]["winding"]
    assert winding == {"flipped": True, "turned_away": 0, "by_cameras": True}
    read = {
        name: (tmp_path / f"{name}.fvv").read_bytes() for name in ("as_it_is", "meant", "flipped", "auto")
    }
    assert read["as_it_is"] == read["meant"] != read["flipped"] == read["auto"]
    assert np.abs(middle_colour(tmp_path / "flipped.fvv", tmp_path / "v.png") - COLOURS[1]).max() < 60
    tool("fvvrender", tmp_path / "meant.fvv", "--camera", 1, "-o", tmp_path / "grey.png",
         "--visible-by", "depth")  # fmt: skip
    assert (np.asarray(Image.open(tmp_path / "grey.png"))[SIZE // 2, SIZE // 2] == 128).all()


def test_faces_that_are_right_stay(tmp_path):
    capture = scene(tmp_path / "right", inside_out=False)
    outputs = [tmp_path / "default.fvv", tmp_path / "auto.fvv"]
    for out, options in zip(outputs, [(), ("--winding", "auto")]):
        assert pack(capture, out, *options).stderr == ""
    assert outputs[0].read_bytes() == outputs[1].read_bytes()
    done = pack(capture, tmp_path / "flipped.fvv", "--winding", "flip", expected=3)
    assert (
        "with --winding flip 100 % of the surface nearest to the cameras has its back to them" in done.stderr
    )
    assert "--winding: expected auto, keep or flip, found" in pack(
        capture, tmp_path / "x.fvv", "--winding", "turn", expected=2).stderr  # fmt: skip


def test_without_cameras_the_volume_tells(tmp_path):
    capture = scene(tmp_path / "turned", inside_out=True, cameras=0)
    done = pack(capture, tmp_path / "x.fvv", expected=3)
    assert "100 % of the sampled meshes enclose a negative volume: the faces are inside out (" in done.stderr
    assert pack(capture, tmp_path / "y.fvv", "--winding", "auto").stderr == ""


@pytest.mark.parametrize("normals", [1, -1])
def test_normals_point_out_when_faces_are_turned(tmp_path, normals):
    """Whether they were those of the faces in the file, or those of the ball beside faces that were wrong."""
    capture = scene(tmp_path / "turned", inside_out=True, normals=normals)
    pack(capture, tmp_path / "x.fvv", "--winding", "flip", "--normals", "always", "--verify")
    tool("fvvdemux", tmp_path / "x.fvv", "-o", tmp_path / "out", "--meshes", "obj")
    rows = [line.split() for line in next((tmp_path / "out/meshes").glob("*.obj")).read_text().splitlines()]
    points, sent = (np.array([row[1:4] for row in rows if row[0] == key], float) for key in ("v", "vn"))
    faces = np.array([[c.split("/")[0] for c in row[1:4]] for row in rows if row[0] == "f"], int) - 1
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    assert ((np.cross(b - a, c - a) * (a + b + c)).sum(1) > 0).all()
    assert ((sent * points).sum(1) > 0.98).all()
