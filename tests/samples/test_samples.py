"""The samples of the documentation run: commands in a folder with a small capture and a stream, by the tools of the build.

A shell sample runs line after line; a line fails with any exit code but 0 and 3 (done, with a loss or a warning that was
printed). fvvsynth makes a small scene here unless a sample says how large; fvvserve ends after some seconds, at a free port.
"""

import ast
import importlib
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

import jsonschema
import pytest
from inventory import COMPILED, EACH_LINE, ELSEWHERE, LANGUAGES, NOT, OPTIONS, ROOT, samples

TOOLS = (ROOT / os.environ.get("FVV_TOOLS_DIR", "build/default/tools")).resolve()
EVERYTHING, UNUSED = samples()
SHIMS = {
    "fvvsynth": """case " $* " in *" --rig "*) ;; *) set -- "$@" --rig small --cameras 5;; esac
case " $* " in *" --size "*) ;; *) set -- "$@" --size 160x96;; esac
exec "$TOOL" "$@"
""",
    # The demo site is another test's to build.
    "fvvserve": """case " $* " in *" --open "*) set -- "$@" --root .;; esac
timeout -s INT 2 "$TOOL" --port 0 "$@"
code=$?
# So that what writes to it does not fail.
case " $* " in *"=- "*) cat >/dev/null;; esac
[ $code -eq 124 ] || exit $code
""",
}
RUNNER = """set -E
trap 'code=$?; [ $code -eq 3 ] || { echo "exit code $code: $BASH_COMMAND" >&2; exit 97; }' ERR
set -o pipefail
"""


def of(how):
    return [pytest.param(s, id=str(s)) for s in EVERYTHING if s.how == how]


def test_every_sample_has_a_runner():
    assert len(EVERYTHING) > 60
    assert [f"{s}: nothing runs a sample of {s.language}" for s in EVERYTHING if not s.how] == []
    assert not UNUSED, "rows of inventory.py that no sample needs"
    assert all(
        s.how.startswith((ELSEWHERE, NOT)) or s.how in {EACH_LINE, OPTIONS, COMPILED, *LANGUAGES.values()}
        for s in EVERYTHING
    )


@pytest.fixture(scope="session")
def tools(tmp_path_factory):
    """A folder for PATH: the tools, and what stands for those that take long or do not end."""
    folder = tmp_path_factory.mktemp("bin")
    for path in TOOLS.iterdir():
        program = path / path.name
        if program.is_file():
            shim = folder / path.name
            text = SHIMS.get(path.name, 'exec "$TOOL" "$@"\n')
            shim.write_text(f"#!/bin/bash\nTOOL={shlex.quote(str(program))}\n{text}")
            shim.chmod(0o755)
    return folder


def run(text, folder, tools):
    env = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"}
    return subprocess.run(
        ["bash", "-c", RUNNER + text], cwd=folder, capture_output=True, text=True, timeout=120, env=env
    )


@pytest.fixture(scope="session")
def made(tmp_path_factory, tools):
    """What samples read: the capture `players` of 12 frames, and streams of it. (folder, writers of calibrations, random)"""
    folder = tmp_path_factory.mktemp("made")
    sys.path.insert(0, str(ROOT / "tests/tools"))
    formats = importlib.import_module("import_formats")
    random = formats.np.random.default_rng(1)
    done = run("fvvsynth -o players --frames 12 --atlas", folder, tools)
    assert done.returncode == 0, done.stderr
    # Three groups of a second, of few frames.
    description = folder / "players/capture.json"
    capture = {**json.loads(description.read_text()), "frame_rate": 5}
    description.write_text(json.dumps(capture))
    done = run("fvvmux players -o players.fvv", folder, tools)
    assert done.returncode == 0, done.stderr
    stream = (folder / "players.fvv").read_bytes()
    (folder / "cut.fvv").write_bytes(stream[: len(stream) * 2 // 3])
    (folder / "site").mkdir()
    shutil.copy(folder / "players.fvv", folder / "site")
    shutil.copy(folder / "players.fvv", folder / "clip.fvv")
    return folder, formats, random


@pytest.fixture
def place(made, tmp_path):
    """A folder with all of that, in which nothing is written to the originals."""
    shutil.copytree(made[0], tmp_path / "here", symlinks=True, copy_function=os.link)
    return tmp_path / "here"


def remove_outputs(text, folder):
    """Samples make players.fvv, although others read it."""
    for name in re.findall(r"(?:-o|--sheet|--segments|--plan) (\S+)", text):
        path = folder / name
        if path.is_dir():
            shutil.rmtree(path)
        elif path.exists():
            path.unlink()


@pytest.mark.parametrize("sample", of(LANGUAGES["sh"]))
def test_commands(sample, place, tools):
    text = sample.text
    for name, value in {"CAPTURE": "players", "PARTS": "parts", "SITE": "pieces"}.items():
        text = re.sub(rf"\b{name}\b", value, text)
    if sample.mark.startswith("run: "):
        for kind in sample.mark[len("run: ") :].split():
            prepare(kind, place, tools)
    remove_outputs(text, place)
    done = run(text, place, tools)
    assert done.returncode in {0, 3}, done.stdout + done.stderr
    if "fvvserve" in text:
        assert "http://127.0.0.1:" in done.stdout


def prepare(kind, place, tools):
    """The folders of docs/guide, of what other programs write."""
    capture = json.loads((place / "players/capture.json").read_text())
    if kind == "meshes":
        (place / "scan").mkdir()
        corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        text = "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "vt 0 0\nvt 1 0\nvt 0 1\n"
        text += "".join(f"f {a}/1 {b}/2 {c}/3\n" for a, b, c in ((1, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4)))
        for n in range(3):
            (place / f"scan/{n:04d}.obj").write_text(text)
            shutil.copy(place / "players/atlas.png", place / f"scan/{n:04d}.png")
        return
    root = place / f"{kind}_folder"
    (root / "images").mkdir(parents=True)
    for camera in capture["cameras"]:
        shutil.copy(place / "players" / (camera["pictures"] % 0), root / f"images/cam{camera['id']}.png")
    mesh = place / "players" / (capture["meshes"]["pattern"] % 0)
    if kind == "colmap":
        (root / "meshes").mkdir()
        shutil.copy(mesh, root / "meshes/0000.ply")
        write_colmap(capture, root / "sparse/0")
    else:
        shutil.copy(mesh, root / "mesh.ply")
        write_nerfstudio(capture, root)


def poses(capture):
    """(camera, rotation, translation) of the cameras of a capture, as numpy arrays."""
    import numpy

    for camera in capture["cameras"]:
        yield camera, numpy.array(camera["rotation"], float), numpy.array(camera["translation"], float)


def write_colmap(capture, folder):
    folder.mkdir(parents=True)
    cameras, images = [], []
    for camera, r, t in poses(capture):
        i, number = camera["intrinsics"], camera["id"] + 1
        cameras.append(
            f"{number} PINHOLE {camera['width']} {camera['height']} {i['fx']} {i['fy']} {i['cx']} {i['cy']}"
        )
        w = (max(0.0, 1 + r[0, 0] + r[1, 1] + r[2, 2])) ** 0.5 / 2
        x, y, z = (r[2, 1] - r[1, 2]) / (4 * w), (r[0, 2] - r[2, 0]) / (4 * w), (r[1, 0] - r[0, 1]) / (4 * w)
        place = " ".join(map(str, t))
        images.append(f"{number} {w} {x} {y} {z} {place} {number} cam{camera['id']}.png\n")
    (folder / "cameras.txt").write_text("\n".join(cameras) + "\n")
    (folder / "images.txt").write_text("\n".join(images) + "\n")
    (folder / "points3D.txt").write_text("")


def write_nerfstudio(capture, folder):
    frames = []
    for camera, r, t in poses(capture):
        i = camera["intrinsics"]
        # Camera to world, and OpenGL's axes: y up, z backwards.
        rotation, centre = r.T * [1, -1, -1], -r.T @ t
        matrix = [[*map(float, rotation[k]), float(centre[k])] for k in range(3)] + [[0.0, 0.0, 0.0, 1.0]]
        frames.append(
            {
                "file_path": f"images/cam{camera['id']}.png",
                "transform_matrix": matrix,
                "w": camera["width"],
                "h": camera["height"],
                "fl_x": i["fx"],
                "fl_y": i["fy"],
                "cx": i["cx"],
                "cy": i["cy"],
            }
        )
    (folder / "transforms.json").write_text(json.dumps({"camera_model": "OPENCV", "frames": frames}))


@pytest.mark.parametrize("sample", of(EACH_LINE))
def test_each_command(sample, made, tmp_path, tools):
    for number, line in enumerate(sample.text.splitlines()):
        place = tmp_path / str(number)
        shutil.copytree(made[0], place, symlinks=True, copy_function=os.link)
        if sample.file == "docs/tools/calibration.md":
            write_calibrations(made, place)
        remove_outputs(line, place)
        done = run(line, place, tools)
        assert done.returncode in {0, 3}, line + "\n" + done.stderr


def write_calibrations(made, place):
    """The files that the samples of docs/tools/calibration.md name, and captures beside them."""
    _, formats, random = made
    shutil.copytree(place / "players", place, dirs_exist_ok=True, copy_function=os.link)
    for name, target in [
        ("colmap", "sparse/0"),
        ("qualisys", "room.qca.txt"),
        ("opencv", "."),
        ("nerfstudio", "transforms.json"),
        ("krt_files", "cameras"),
        ("panoptic", "calibration_171204_pose1.json"),
        ("easymocap", "zju/377"),
        ("toml", "calibration.toml"),
        ("kalibr", "camchain.yaml"),
        ("metashape", "cameras.xml"),
        ("realitycapture_table", "cameras.csv"),
    ]:
        folder = place / f"of_{name}"
        folder.mkdir()
        arguments, _ = getattr(formats, f"write_{name}")(folder, random)
        inputs = [pathlib.Path(a) for a in arguments if pathlib.Path(a).exists()]
        if name == "opencv":
            for n in range(2):
                shutil.copy(
                    next(p for p in [*inputs, *folder.rglob("*.yml")] if p.suffix == ".yml"),
                    place / f"cam{n}.yml",
                )
        elif inputs[0].is_dir():
            shutil.copytree(inputs[0], place / target)
        else:
            shutil.copy(inputs[0], place / target)
    (place / "points.txt").write_text("".join(f"0.{n} 0.2 1 0 6{n} 48\n" for n in range(9)))


def commands(text):
    """The commands of a shell sample, as lists of words; comments are left out, and so are placeholders."""
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words:
            yield [word for word in words if word != "..."]


@pytest.mark.parametrize("sample", of(OPTIONS))
def test_options(sample):
    from fvv_capture.arguments import calibrate_parser, capture_parser, live_parser

    parsed = 0
    for name, *arguments in commands(sample.text):
        if name == "fvvcapture":
            if arguments[0] == "calibrate":
                calibrate_parser("").parse(arguments[1:])
            elif arguments[0] == "live":
                live_parser("").parse(arguments[1:])
            else:
                capture_parser("").parse(arguments)
            parsed += 1
        elif name == "pip":
            extra = re.fullmatch(r"\.\[(\w+)\]", arguments[1])[1]
            assert re.search(rf"^{extra} = \[", (ROOT / "pyproject.toml").read_text(), re.M)
        else:
            assert name in {"fvvsynth", "fvvinfo"}, name
    assert parsed


@pytest.mark.parametrize("sample", of(COMPILED))
def test_names(sample):
    modules, seen = {}, 0
    for node in ast.walk(compile(sample.text, str(sample), "exec", ast.PyCF_ONLY_AST)):
        if isinstance(node, ast.ImportFrom):
            for name in node.names:
                modules[name.asname or name.name] = importlib.import_module(f"{node.module}.{name.name}")
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in modules:
            assert hasattr(modules[node.value.id], node.attr), f"{node.value.id}.{node.attr}"
            seen += 1
    assert seen


@pytest.mark.parametrize("sample", of(LANGUAGES["json"]))
def test_json(sample):
    value = json.loads(sample.text)
    if "fvv_capture" in value:
        jsonschema.validate(value, json.loads((ROOT / "spec/capture.schema.json").read_text()))
