"""fvvmux without a capture.json: patterns of files, and folders of COLMAP and nerfstudio as they are."""

import base64
import io
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import zlib

import import_formats
import numpy as np
import pytest
from conftest import ROOT, Tool, figures, run, tool_path, validate
from PIL import Image

FRAMES = 3
# Small and quick: what is compared are bytes, not quality.
QUICK = ("--quality", 30, "--visibility", "none", "--match-colours", "off", "--texture-inset", "off")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A capture of fvvsynth with an atlas, as a template: tests copy what they need."""
    folder = tmp_path_factory.mktemp("made") / "made"
    size = ("--rig", "small", "--cameras", 3, "--size", "160x96", "--frames", FRAMES)
    run("fvvsynth", *size, "--atlas", "--atlas-size", 512, "-o", folder)
    return folder


@pytest.fixture(scope="module")
def stream(made):
    path = made.parent / "made.fvv"
    run("fvvmux", made, "-o", path, *QUICK)
    return path


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The working folder: patterns are relative to it."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def sequence(stream, made, place):
    """f/NNNN.obj and f/NNNN.png, from 7 on."""
    run("fvvdemux", stream, "--meshes", "obj", "--pictures", "png", "-o", "unpacked")
    (place / "f").mkdir()
    for i in range(FRAMES):
        shutil.copy(f"unpacked/meshes/{i:04}.obj", f"f/{i + 7:04}.obj")
        shutil.copy(f"unpacked/atlas/{i:04}.png", f"f/{i + 7:04}.png")
    return place / "f"


def cameras_of(made):
    return json.loads((made / "capture.json").read_text())["cameras"]


def quaternion(rotation):
    """w x y z, w >= 0, from the eigenvector of the largest eigenvalue (Bar-Itzhack 2000)."""
    r = np.array(rotation)
    k = np.zeros((4, 4))
    k[:3, :3] = r + r.T - np.eye(3) * np.trace(r)
    k[3, :3] = k[:3, 3] = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    k[3, 3] = np.trace(r)
    x, y, z, w = np.linalg.eigh(k)[1][:, -1]
    return np.array([w, x, y, z]) * (-1 if w < 0 else 1)


def write_model(made, model, name, binary=True):
    """A COLMAP model of a capture's cameras. name(i): of the picture of camera i."""
    cameras, images, lines = [], [], ([], [])
    for i, camera in enumerate(cameras_of(made)):
        k = camera["intrinsics"]
        size, parameters = (camera["width"], camera["height"]), [k[key] for key in ("fx", "fy", "cx", "cy")]
        q, t = quaternion(camera["rotation"]), camera["translation"]
        cameras.append(import_formats.colmap_camera(i + 1, 1, *size, parameters))
        images.append(import_formats.colmap_image(i + 1, q, t, i + 1, name(i), keypoints=2))
        lines[0].append(f"{i + 1} PINHOLE {size[0]} {size[1]} {import_formats.text(parameters)}\n")
        pose = f"{import_formats.text(q)} {import_formats.text(t)}"
        lines[1].append(f"{i + 1} {pose} {i + 1} {name(i)}\n\n")
    if binary:
        return import_formats.write_colmap_files(model, cameras, images)
    model.mkdir(parents=True)
    for file, text in zip(("cameras.txt", "images.txt"), lines):
        (model / file).write_text("".join(text))


def copy_pictures(made, folder, name, frames=FRAMES):
    for i in range(len(cameras_of(made))):
        for n in range(frames):
            to = folder / name(i, n)
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(made / f"cam{i}/{n:04}.png", to)


def described(*arguments, code=0):
    """The capture.json that arguments stand for; the stream of the arguments and of that file are the same."""
    run("fvvmux", *arguments, *QUICK, "-o", "given.fvv", "--write-capture", "capture.json", code=code)
    run("fvvmux", "capture.json", *QUICK, "-o", "described.fvv", code=code)
    assert pathlib.Path("given.fvv").read_bytes() == pathlib.Path("described.fvv").read_bytes()
    document = json.loads(pathlib.Path("capture.json").read_text())
    validate(document, "capture")
    return document


def worst_error(document, made, scale=1):
    """In pixels, of points projected by the cameras of the document and by those of fvvsynth's capture."""
    worst = 0
    random = np.random.default_rng(5)
    for ours, theirs in zip(document["cameras"], cameras_of(made)):
        r, t = np.array(theirs["rotation"]), np.array(theirs["translation"])
        x = np.column_stack([random.uniform(-1, 1, (200, 2)), random.uniform(2, 6, 200)])
        points = (x - t) @ r
        theirs = {"lens": {"model": "none"}, **theirs}
        pixels = import_formats.project_capture(theirs, points)
        worst = max(worst, np.abs(import_formats.project_capture(ours, points * scale) - pixels).max())
    return worst


# ---- the page ----------------------------------------------------------------------------------------------

PAGE = (ROOT / "docs/tools/fvvmux-inputs.md").read_text()
SAMPLES = re.findall(r"<!-- run -->\n```sh\n(.*?)```", PAGE, re.S)


@pytest.mark.parametrize("index", range(4))
def test_a_sample_of_the_page_writes_a_stream(sequence, made, place, index):
    assert len(SAMPLES) == 4
    sequence.rename(place / "scan")
    shutil.copytree(made / "meshes", "meshes")
    shutil.copy("meshes/0000.ply", "mesh.ply")
    write_model(made, place / "project/sparse/0", lambda i: f"cam{i}/0000.png")
    copy_pictures(made, place / "project/images", lambda i, n: f"cam{i}/{n:04}.png")
    write_transforms(made, place / "scene/transforms.json", lambda i: f"images/{i}.png", w=160, h=96)
    copy_pictures(made, place / "scene/images", lambda i, n: f"{i}.png", 1)
    tools = ":".join(str(tool_path(name).parent) for name in ("fvvmux", "fvvimport"))
    environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"}
    done = subprocess.run(["bash", "-ec", SAMPLES[index]], env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    stream = re.findall(r"(\w+\.fvv)", SAMPLES[index])[-1]
    assert json.loads(run("fvvinfo", stream, "--json").stdout)


# ---- patterns --------------------------------------------------------------------------------------------


def test_a_sequence_of_meshes_and_textures(sequence):
    document = described("--meshes", "f/%04d.obj", "--atlas", "f/%04d.png", "--fps", 30, "--up", "+y")
    assert document["frames"] == {"first": 7, "count": FRAMES, "step": 1}
    assert (document["frame_rate"], document["units"], document["up"]) == ("30", "unknown", "+y")
    assert document["meshes"] == {"pattern": "f/%04d.obj"}
    assert document["atlas"] == {"pictures": "f/%04d.png"}


def test_a_still_texture_and_a_still_mesh_serve_all_frames(sequence):
    assert described("--meshes", "f/%04d.obj", "--atlas", "f/0007.png")["frames"]["count"] == FRAMES
    pathlib.Path("capture.json").unlink()
    for name in "given.fvv", "described.fvv":
        pathlib.Path(name).unlink()
    still = described("--meshes", "f/0007.obj", "--atlas", "f/%04d.png", "--units", "0.5")
    assert (still["frames"]["count"], still["units"]) == (FRAMES, 0.5)


def test_the_formats_of_meshes(stream, place):
    run("fvvdemux", stream, "--meshes", "drc", "--pictures", "none", "-o", "drc")
    for i in range(FRAMES):
        pathlib.Path(f"drc/meshes/{i:04}.drc").rename(f"{i}.draco")
    run("fvvdemux", stream, "--meshes", "ply", "--pictures", "none", "-o", "ply")
    sizes = []
    for pattern in "%d.draco", "ply/meshes/%04d.ply":
        sizes.append(figures("fvvmux", "--meshes", pattern, "--keep-geometry", "-o", f"{len(sizes)}.fvv"))
    assert [size["frames"] for size in sizes] == [FRAMES] * 2
    assert sizes[0]["bytes"] == pytest.approx(sizes[1]["bytes"], rel=0.02)


def triangles(shift, animated=False):
    """A glTF file with a texture, and perhaps an animation of a second."""
    positions = [0, 0, 0, 1, 0, 0, 0, 1, shift]
    numbers = struct.pack("<9f6f2f6f", *positions, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 0, 0.5, 0, 0)
    png = base64.b64encode(PNG).decode()
    views = [(0, 36), (36, 24), (60, 8), (68, 24)]
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": f"data:image/png;base64,{png}"}],
        "buffers": [
            {
                "byteLength": len(numbers),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(numbers).decode(),
            }
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": size} for at, size in views],
        "accessors": [
            {"bufferView": i, "componentType": 5126, "count": count, "type": kind}
            for i, (count, kind) in enumerate([(3, "VEC3"), (3, "VEC2"), (2, "SCALAR"), (2, "VEC3")])
        ],
    }
    document["accessors"][0].update(min=[0, 0, min(0, shift)], max=[1, 1, max(0, shift)])
    document["accessors"][2].update(min=[0], max=[1])
    if animated:
        document["animations"] = [
            {
                "samplers": [{"input": 2, "output": 3}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            }
        ]
    return json.dumps(document)


def png(width, height):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + bytes((x * 5 + y * 3) & 255 for x in range(width * 3)) for y in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(rows))
        + chunk(b"IEND", b"")
    )


PNG = png(64, 64)


def test_gltf_brings_its_texture_units_and_up(place):
    for i in range(2):
        pathlib.Path(f"{i}.gltf").write_text(triangles(0.1 * i))
    document = described("--meshes", "%d.gltf")
    assert document["atlas"] == {"embedded": True}
    assert (document["units"], document["up"]) == ("metres", "+y")


def test_obj_brings_the_picture_that_its_mtl_names(sequence):
    """As fvvdemux writes both, in folders beside each other."""
    document = described("--meshes", "unpacked/meshes/%04d.obj")
    assert document["atlas"] == {"embedded": True}
    run(
        "fvvmux",
        "--meshes",
        "unpacked/meshes/%04d.obj",
        "--atlas",
        "unpacked/atlas/%04d.png",
        *QUICK,
        "-o",
        "named.fvv",
    )
    assert pathlib.Path("named.fvv").read_bytes() == pathlib.Path("given.fvv").read_bytes()
    run("fvvmux", "--meshes", "unpacked/meshes/%04d.obj", "--atlas", "none", "--write-capture", "none.json")
    assert "atlas" not in json.loads(pathlib.Path("none.json").read_text())


def test_outputs_spare_the_picture_of_an_mtl(sequence):
    before = pathlib.Path("unpacked/atlas/0001.png").read_bytes()
    done = run(
        "fvvmux", "--meshes", "unpacked/meshes/%04d.obj", "--force", "-o", "unpacked/atlas/0001.png", code=1
    )
    assert "is unpacked/atlas/0001.png, which this run reads" in done.stderr
    assert pathlib.Path("unpacked/atlas/0001.png").read_bytes() == before


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
FACES = ("f 1/1 2/2 3/3\n", "f 1/1 3/3 4/4\n")


@pytest.mark.parametrize(
    "picture", ["a b.png", "./t/a.png", r"t\a.png", "../beside/a.png", "-s 1 1 1 -clamp on a.png"]
)
def test_places_of_a_picture_of_an_mtl(place, picture):
    for file in "a b.png", "t/a.png", "a.png", "../beside/a.png":
        path = place / "m" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(PNG)
    pathlib.Path("m/my scan.mtl").write_text(f"newmtl my skin\r\nmap_Kd {picture}\r\n")
    pathlib.Path("m/a.obj").write_text("mtllib my scan.mtl\n" + SQUARE + "usemtl my skin\n" + "".join(FACES))
    assert described("--meshes", "m/a.obj")["atlas"] == {"embedded": True}


@pytest.mark.parametrize(
    ("library", "picture", "message"),
    [
        (
            "../a.mtl",
            "a.png",
            'm/a.obj: expected the library of mtllib below the folder of the file, found "../a.mtl"',
        ),
        (
            "out.mtl",
            "a.png",
            'm/a.obj: expected the library of mtllib below the folder of the file, found "out.mtl"',
        ),
        (
            "a.mtl",
            "../a.png",
            'm/a.mtl: expected a picture below the folder of m/a.obj or in one beside it, found "../a.png"',
        ),
        ("a.mtl", "away/../out.png", "m/a.mtl: expected a picture below the folder of m/a.obj"),
        ("a.mtl", "../../a/z.png", "m/a.mtl: expected a picture below the folder of m/a.obj"),
        ("a.mtl", "../a/b/z.png", "m/a.mtl: expected a picture below the folder of m/a.obj"),
        (
            "a.mtl",
            "out.png",
            'm/a.mtl: expected a picture below the folder of m/a.obj or in one beside it, found "out.png"',
        ),
        ("a.mtl", "-s 2 1 1 a.png", 'm/a.mtl:2: expected a picture as it is, found -s with "2"'),
        (
            "a.mtl",
            "-z a.png",
            'm/a.mtl:2: expected the name of a picture after map_Kd, found the unknown option "-z"',
        ),
        ("a.mtl", "none.png", 'm/a.obj: expected the picture "m/none.png" of map_Kd, which is missing'),
    ],
)
def test_an_mtl_that_leads_elsewhere(place, library, picture, message):
    pathlib.Path("m/d/e").mkdir(parents=True)
    pathlib.Path("m/away").symlink_to("d/e")
    pathlib.Path("m/a.mtl").write_text(f"newmtl a\nmap_Kd {picture}\n")
    shutil.copy("m/a.mtl", "a.mtl")
    pathlib.Path("m/out.mtl").symlink_to(place / "a.mtl")
    for name in "a.png", "m/a.png":
        pathlib.Path(name).write_bytes(PNG)
    pathlib.Path("m/out.png").symlink_to(place / "a.png")
    pathlib.Path("m/a.obj").write_text(f"mtllib {library}\n" + SQUARE + "usemtl a\n" + "".join(FACES))
    done = run("fvvmux", "--meshes", "m/a.obj", "-o", "x.fvv", code=1)
    assert message in done.stderr
    run("fvvmux", "--meshes", "m/a.obj", "--atlas", "a.png", "-o", "x.fvv")


def test_materials_of_an_obj(place):
    pathlib.Path("a.mtl").write_text(
        "newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\nnewmtl plain\nKd 1 0 0\n"
    )
    for uses in ("a", "b"), ("a", "plain"):
        parts = "".join(f"usemtl {name}\n{face}" for name, face in zip(uses, FACES))
        pathlib.Path("a.obj").write_text("mtllib a.mtl\n" + SQUARE + parts)
        described = json.loads(run("fvvmux", "--meshes", "a.obj", "--write-capture", "-").stdout)
        assert described["atlas"] == {"embedded": True}
    # A material that no face uses does not matter, and colours alone are no picture.
    pathlib.Path("a.obj").write_text("mtllib a.mtl\nusemtl a\n" + SQUARE + "usemtl plain\n" + "".join(FACES))
    assert "atlas" not in json.loads(run("fvvmux", "--meshes", "a.obj", "--write-capture", "-").stdout)
    done = run("fvvmux", "--meshes", "a.obj", "--atlas", "embedded", "-o", "x.fvv", code=1)
    assert "a.obj: expected faces of a material with map_Kd, found none" in done.stderr


def test_a_missing_file_beside_a_gltf_file_is_called_missing(place):
    """In the working folder too, where paths have no folder."""
    document = json.loads(triangles(0))
    document["buffers"][0]["uri"] = "numbers.bin"
    for name, shown in ("a.gltf", "numbers.bin"), ("m/a.gltf", "m/numbers.bin"):
        pathlib.Path(name).parent.mkdir(exist_ok=True)
        pathlib.Path(name).write_text(json.dumps(document))
        done = run("fvvmux", "--meshes", name, "-o", "x.fvv", code=1)
        assert f"{name}: /buffers/0/uri: {shown}: " in done.stderr and "symbolic link" not in done.stderr


def test_an_animated_gltf_file_has_frames_of_its_own(place):
    pathlib.Path("100%.gltf").write_text(triangles(0, animated=True))
    document = described("--meshes", "100%%.gltf", "--fps", 10)
    assert document["meshes"] == {"file": "100%.gltf", "start": "0/1"}
    assert document["frames"]["count"] == 11


def test_a_missing_frame_is_named(sequence):
    pathlib.Path("f/0008.obj").unlink()
    done = run("fvvmux", "--meshes", "f/%04d.obj", "--atlas", "f/%04d.png", "-o", "x.fvv", code=1)
    assert "1 of 3 meshes is missing: 8 (first: f/0008.obj)" in done.stderr
    assert not pathlib.Path("x.fvv").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["--meshes", "f/%d.obj"], 1, '--meshes: expected files such as f/0.obj, found "0007.obj"'),
        (["--meshes", "g/%d.obj"], 1, "--meshes: expected files such as g/0.obj, found no folder g"),
        (["--meshes", "f/%04s.obj"], 2, "--meshes: expected %d, %0Nd"),
        (["--meshes", "f/%04d.stl"], 2, "--meshes: expected files .obj, .ply, .drc, .draco, .glb or .gltf"),
        (["f", "--atlas", "f/%04d.png"], 2, "--atlas: expected --meshes too"),
        (["--meshes", "f/%04d.drc", "--atlas", "embedded"], 2, "--atlas: expected embedded for .glb"),
        (["--meshes", "f/%04d.obj", "--pictures", "a.png"], 2, "--pictures: expected {name} or {id}"),
        (["--meshes", "f/%04d.obj", "--masks", "{id}.png"], 2, "--masks: expected a folder with a calibr"),
        (["--meshes", "f/%04d.obj", "--fps", "29.97"], 2, "--fps: expected frames per second like 25 or"),
        (["--meshes", "f/%04d.obj", "--units", "yards"], 2, "--units: expected metres"),
        (["--meshes", "f/%04d.obj", "--up", "z"], 2, "--up: expected +x"),
        ([], 2, "CAPTURE or --meshes is required"),
        (["f", "--meshes", "f/%04d.obj"], 1, "f: expected capture.json, a COLMAP model"),
        (["--meshes", "f/%04d.obj", "--plan", "p"], 2, "--plan: expected a capture.json"),
    ],
)
def test_wrong_inputs(sequence, arguments, code, message):
    output = () if "--plan" in arguments else ("-o", "x.fvv")
    done = run("fvvmux", *arguments, *output, code=code)
    assert message in done.stderr


def test_options_do_not_change_a_capture(made, place):
    done = run("fvvmux", made, "--fps", 30, "-o", "x.fvv", code=2)
    assert f"expected without a capture.json, found {made}/capture.json" in done.stderr


# ---- COLMAP ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("binary", [True, False])
def test_a_project_of_colmap(made, place, binary):
    project = place / "project"
    write_model(made, project / "sparse/0", lambda i: f"cam{i}/0000.png", binary)
    copy_pictures(made, project / "images", lambda i, n: f"cam{i}/{n:04}.png")
    shutil.copytree(made / "meshes", "meshes")
    document = described("project/", "--meshes", "meshes/%04d.ply", "--fps", 25)
    assert [c["pictures"] for c in document["cameras"]] == [
        f"project/images/cam{i}/%04d.png" for i in range(3)
    ]
    assert [(c["id"], c["name"]) for c in document["cameras"]] == [(i + 1, f"cam{i}") for i in range(3)]
    assert document["units"] == "unknown"
    assert worst_error(document, made) < 1e-6


@pytest.mark.parametrize("model", ["sparse", "."])
def test_a_model_elsewhere_and_still_pictures(made, place, model):
    project = place / "project"
    write_model(made, project / model, lambda i: f"50%_{i}.png")
    copy_pictures(made, project / "images", lambda i, n: f"50%_{i}.png", 1)
    shutil.copy(made / "meshes/0000.ply", "mesh.ply")
    document = described("project", "--meshes", "mesh.ply", "--units", "metres", "--up", "+y")
    assert [c["pictures"] for c in document["cameras"]] == [f"project/images/50%%_{i}.png" for i in range(3)]
    assert document["frames"]["count"] == 1
    # The model itself may be named: the pictures are beside it.
    if model == "sparse":
        pathlib.Path("capture.json").unlink()
        run("fvvmux", "project/sparse", "--meshes", "mesh.ply", "--write-capture", "capture.json")
        again = json.loads(pathlib.Path("capture.json").read_text())
        assert [c["pictures"] for c in again["cameras"]] == [c["pictures"] for c in document["cameras"]]


def test_folders_named_after_the_pictures_of_the_model(made, place):
    write_model(made, place / "p/sparse/0", lambda i: f"cam{i}.png")
    copy_pictures(made, place / "p/images", lambda i, n: f"cam{i}/{n + 1}.png")
    document = json.loads(run("fvvmux", "p", "--meshes", "m.ply", "--write-capture", "-").stdout)
    assert document["frames"] == {"first": 1, "count": FRAMES, "step": 1}
    assert document["cameras"][0]["pictures"] == "p/images/cam0/%d.png"


def test_pictures_and_masks_by_name(made, place):
    write_model(made, place / "p", lambda i: f"cam{i}.png")
    done = run("fvvmux", "p", "-o", "x.fvv", code=2)
    assert done.stderr == "fvvmux: p: expected --meshes too, because a COLMAP model has none\n"
    shutil.copytree(made / "meshes", "meshes")
    pictures = ("--pictures", f"{made}/{{name}}/%04d.png", "--masks", f"{made}/{{name}}/mask_%04d.png")
    document = described("p", "--meshes", "meshes/%04d.ply", *pictures, "--units", "metres")
    assert document["cameras"][1]["masks"] == f"{made}/cam1/mask_%04d.png"


def test_one_picture_is_not_a_sequence(made, place):
    write_model(made, place / "p/sparse/0", lambda i: f"cam{i}.png")
    copy_pictures(made, place / "p/images", lambda i, n: f"cam{i}.png", 1)
    done = run("fvvmux", "p", "--meshes", f"{made}/meshes/%04d.ply", "-o", "x.fvv", code=1)
    assert (
        "camera 1 (cam0): expected a picture for each of 3 frames, found one, p/images/cam0.png"
        in done.stderr
    )
    assert "--pictures 'images/{name}/%04d.png'" in done.stderr


def test_faulty_binary_models(made, place):
    fvvimport = Tool("fvvimport")

    def message():
        done = fvvimport("colmap", "p", "-o", "-", "--meshes", "m.ply")
        assert (done.returncode, done.stdout) == (1, b"")
        return done.stderr.decode()

    camera = import_formats.colmap_camera(1, 1, 640, 480, [500, 500, 320, 240])
    image = import_formats.colmap_image(1, [1, 0, 0, 0], [0, 0, 3], 1, "a.png", keypoints=1)
    write = import_formats.write_colmap_files
    write(place / "p", [camera], [image])
    good = (place / "p/images.bin").read_bytes()
    for length in range(len(good)):
        (place / "p/images.bin").write_bytes(good[:length])
        if length % 7 == 0:
            assert "p/images.bin: byte " in message()
    write(place / "p", [camera], [image + b"\0"])
    assert "p/images.bin: byte 110: expected the end of the file, found 1 bytes" in message()
    write(place / "p", [camera, camera], [image])
    assert "p/cameras.bin: byte 64: expected every CAMERA_ID once, found 1 again" in message()
    for number, name in (7, '"FOV"'), (10, '"THIN_PRISM_FISHEYE"'), (99, "the number 99"):
        write(place / "p", [import_formats.colmap_camera(1, number, 640, 480, [1.0] * 5)], [image])
        assert f", found {name}\n" in message()
    write(place / "p", [camera], [image[:72] + b"\xff" * 8])  # the count of keypoints
    assert "keypoints, found the end of the file" in message()
    write(place / "p/sparse/0", [camera], [image])
    write(place / "p/sparse/1", [camera], [image])
    for name in "cameras", "images":
        (place / f"p/{name}.bin").unlink()
    assert "p: expected one COLMAP model, found p/sparse/0 and p/sparse/1" in message()


# ---- nerfstudio ------------------------------------------------------------------------------------------


def write_transforms(made, path, name, **top):
    """transforms.json of a capture's cameras, in OpenGL's axes."""
    frames = []
    for i, camera in enumerate(cameras_of(made)):
        r, t, k = np.array(camera["rotation"]), np.array(camera["translation"]), camera["intrinsics"]
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = r.T @ np.diag([1, -1, -1]), -r.T @ t
        frame = {"file_path": name(i), "transform_matrix": pose.tolist(), "fl_x": k["fx"], "fl_y": k["fy"]}
        frames.append({**frame, "cx": k["cx"], "cy": k["cy"]})
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({**top, "frames": frames}))


def test_a_folder_of_nerfstudio(made, place):
    write_transforms(made, place / "n/transforms.json", lambda i: f"images/cam{i}/0000.png", w=160, h=96)
    copy_pictures(made, place / "n/images", lambda i, n: f"cam{i}/{n:04}.png")
    shutil.copytree(made / "meshes", "meshes")
    document = described("n", "--meshes", "meshes/%04d.ply", "--units", "metres")
    assert document["cameras"][2]["pictures"] == "n/images/cam2/%04d.png"
    assert worst_error(document, made) < 1e-6


def test_a_blender_set(made, place):
    """No size, no extension, and a file for each part of the set."""
    write_transforms(made, place / "b/transforms_train.json", lambda i: f"./train/r_{i}")
    write_transforms(made, place / "b/transforms_test.json", lambda i: f"./test/r_{i}")
    copy_pictures(made, place / "b/train", lambda i, n: f"r_{i}.png", 1)
    shutil.copy(made / "meshes/0000.ply", "mesh.ply")
    document = described("b", "--meshes", "mesh.ply", "--units", "metres")
    assert [c["pictures"] for c in document["cameras"]] == [f"b/train/r_{i}.png" for i in range(3)]
    assert (document["cameras"][0]["width"], document["cameras"][0]["height"]) == (160, 96)
    assert worst_error(document, made) < 1e-6
    done = run("fvvmux", "b/transforms_test.json", "--meshes", "mesh.ply", "-o", "x.fvv", code=1)
    assert 'expected "w" here or at the top, found neither' in done.stderr


def moments(place, cameras, moving=False, key="time", number=lambda moment: moment):
    """transforms.json with times, as D-NeRF and 4DGS have it, and pictures of one colour a moment."""
    frames = []
    (place / "images").mkdir()
    for moment in range(3):
        for camera in range(cameras):
            name = f"images/cam{camera:02}_{number(moment):04}.png"
            pixels = np.zeros((36, 64, 3), np.uint8)
            pixels[..., moment] = 200
            (place / name).write_bytes(png_of(pixels))
            angle = camera + (0.1 * moment if moving else 0)
            c, s = np.cos(angle), np.sin(angle)
            pose = [[c, 0, s, 3 * s], [0, 1, 0, 0.5], [-s, 0, c, 3 * c], [0, 0, 0, 1]]
            frames.append({"file_path": name, key: moment / 2, "transform_matrix": pose})
    document = {"w": 64, "h": 36, "fl_x": 45, "fl_y": 45, "frames": frames}
    (place / "transforms.json").write_text(json.dumps(document))
    (place / "m.obj").write_text(
        "v -0.5 0 -0.5\nv 0.5 0 -0.5\nv 0 1 0\nv 0 0 0.5\nf 1 2 3\nf 2 4 3\nf 4 1 3\nf 1 4 2\n"
    )


def png_of(pixels):
    image = io.BytesIO()
    Image.fromarray(pixels).save(image, "PNG")
    return image.getvalue()


def test_times_of_nerfstudio_are_frames(place):
    moments(place, 2)
    run("fvvmux", ".", "--meshes", "m.obj", "-o", "o.fvv", *QUICK, warns=True, code=(0, 3))
    (info,) = json.loads(run("fvvinfo", "--json", "o.fvv").stdout)["files"]
    assert info["frames"] == 3 and len(info["cameras"]) == 2


@pytest.mark.parametrize("key", ["time_id", "timestamp", "frame_id"])
def test_several_pictures_of_one_camera_are_moments(key, place):
    """Also if the entries are in another order."""
    moments(place, 2, key=key)
    document = json.loads((place / "transforms.json").read_text())
    (place / "transforms.json").write_text(json.dumps({**document, "frames": document["frames"][::-1]}))
    described = json.loads(run("fvvmux", ".", "--meshes", "m.obj", "--write-capture", "-").stdout)
    assert described["frames"]["count"] == 3
    assert [c["pictures"] for c in described["cameras"]] == [f"images/cam0{i}_%04d.png" for i in (1, 0)]


@pytest.mark.parametrize("number", [lambda moment: 9 - moment, lambda moment: [1, 0, 2][moment]])
def test_pictures_whose_numbers_do_not_go_with_their_times_are_refused(number, place):
    moments(place, 2, number=number)
    done = run("fvvmux", ".", "--meshes", "m.obj", "-o", "o.fvv", code=1)
    assert "whose numbers are in the order of their times" in done.stderr


def test_several_pictures_of_one_camera_without_times_are_refused(place):
    moments(place, 2, key="other")
    done = run("fvvmux", ".", "--meshes", "m.obj", "-o", "o.fvv", code=1)
    assert 'pictures of several moments need a "time"' in done.stderr


def test_masks_of_nerfstudio_are_a_warning(place):
    moments(place, 1, key="other")
    document = json.loads((place / "transforms.json").read_text())
    document["frames"] = [{**document["frames"][0], "mask_path": "masks/0.png"}]
    (place / "transforms.json").write_text(json.dumps(document))
    done = run("fvvmux", ".", "--meshes", "m.obj", "-o", "o.fvv", *QUICK, warns=True, code=3)
    assert 'names masks ("mask_path"), which are not used' in done.stderr


def test_a_moving_camera_of_nerfstudio_is_refused(place):
    """Pictures of several moments never colour one mesh."""
    moments(place, 1, moving=True)
    done = run("fvvmux", ".", "--meshes", "m.obj", "-o", "o.fvv", code=1)
    assert 'has 3 moments ("time")' in done.stderr and "capture.json" in done.stderr
