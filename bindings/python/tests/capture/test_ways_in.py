"""The samples of docs/tools/fvvcapture.md that are marked `<!-- run -->`, in a folder with what they read."""

import json
import os
import re
import shutil
import subprocess
import sys

import numpy
import pytest
from conftest import ROOT, tool
from fvv import open as open_clip
from fvv.errors import Error
from fvv_capture.calibrate.files import read_calibration as read_board_calibration
from fvv_capture.cameras import read_calibration

PAGE = (ROOT / "docs/tools/fvvcapture.md").read_text()
SAMPLES = re.findall(r"<!-- run -->\n```(sh|python)\n(.*?)```", PAGE, re.S)


def colmap(capture, folder):
    """A text model of a capture's cameras, as COLMAP writes it."""
    folder.mkdir(parents=True)
    cameras, images = [], []
    for camera in capture["cameras"]:
        i = camera["intrinsics"]
        number = camera["id"] + 1
        cameras.append(
            f"{number} PINHOLE {camera['width']} {camera['height']} {i['fx']} {i['fy']} {i['cx']} {i['cy']}"
        )
        r = numpy.array(camera["rotation"])
        w = numpy.sqrt(max(0.0, 1 + numpy.trace(r))) / 2
        x, y, z = (r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]) / (4 * w)
        t = " ".join(map(str, camera["translation"]))
        images.append(f"{number} {w} {x} {y} {z} {t} {number} cam{camera['id']}.png\n")
    (folder / "cameras.txt").write_text("\n".join(cameras) + "\n")
    (folder / "images.txt").write_text("\n".join(images) + "\n")
    (folder / "points3D.txt").write_text("")


@pytest.fixture
def place(tmp_path):
    tool(
        "fvvsynth",
        "-o",
        tmp_path / "made",
        "--rig",
        "small",
        "--cameras",
        4,
        "--size",
        "160x96",
        "--frames",
        2,
        "--atlas",
    )
    made = json.loads((tmp_path / "made/capture.json").read_text())
    colmap(made, tmp_path / "sparse/0")
    shutil.copytree(tmp_path / "made/meshes", tmp_path / "meshes")
    for camera in made["cameras"]:
        shutil.copytree(
            tmp_path / f"made/{os.path.dirname(camera['pictures'])}", tmp_path / f"cam{camera['id']}"
        )
    (tmp_path / "scan").mkdir()
    shutil.copy(tmp_path / "made/atlas.png", tmp_path / "scan/texture.png")
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "vt 0 0\nvt 1 0\nvt 0 1\n"
    text += "".join(f"f {a}/1 {b}/2 {c}/3\n" for a, b, c in ((1, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4)))
    for n in range(2):
        (tmp_path / f"scan/{n:04d}.obj").write_text(text)
    return tmp_path


def test_the_page_has_samples():
    assert [kind for kind, _ in SAMPLES] == ["sh", "python", "sh"]


@pytest.mark.parametrize("index", range(len(SAMPLES)))
def test_a_sample_writes_a_stream(place, index):
    kind, text = SAMPLES[index]
    tools = ":".join(str(p) for p in (ROOT / os.environ["FVV_TOOLS_DIR"]).iterdir() if p.is_dir())
    command = [sys.executable, "-c", text] if kind == "python" else ["bash", "-ec", text]
    done = subprocess.run(
        command,
        cwd=place,
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"},
    )
    assert done.returncode == 0, done.stderr
    name = re.search(r"(\w+\.fvv)", text)[1]
    with open_clip(place / name) as clip:
        assert len(clip) == (3 if kind == "python" else 2)
        assert clip[0].mesh.face_count > 0


@pytest.mark.parametrize(
    "text", ["[" * 100000, '{"a":' * 100000, "{", "[]", '{"fvv_capture": 1, "conventions": 3}']
)
@pytest.mark.parametrize("file", ["capture.json", "room.json"])
def test_damaged_and_nested_json_is_an_error_that_names_the_file(file, text, tmp_path):
    (tmp_path / file).write_text(text)
    with pytest.raises(Error, match=file):
        read_calibration(str(tmp_path if file == "capture.json" else tmp_path / file))
    with pytest.raises(Error, match=file):
        read_board_calibration(str(tmp_path / file))
