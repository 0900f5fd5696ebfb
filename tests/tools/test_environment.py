"""An environment through all tools and back."""

import json
import shutil
import struct

import numpy as np
import pytest
from conftest import figures, run, validate
from PIL import Image

LIGHTLY = ("--codec", "jpeg", "--quality", "70")


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    """A capture with an environment, its stream in two groups, and fvvmux's summary: (folder, stream, summary)."""
    root = tmp_path_factory.mktemp("stage")
    folder, stream = root / "capture", root / "stage.fvv"
    size = ["--cameras", 3, "--frames", 3, "--size", "96x54"]
    run("fvvsynth", "-o", folder, "--rig", "small", *size, "--environment")
    options = [*LIGHTLY, "--group", 2, "--triangles", 3000, "--verify"]
    return folder, stream, figures("fvvmux", folder, "-o", stream, *options)


def glb(path):
    """The JSON of a GLB, and the bytes of a view by its index."""
    data = path.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20 : 20 + size])

    def view(index):
        entry = document["bufferViews"][index]
        start = 28 + size + entry["byteOffset"]
        return data[start : start + entry["byteLength"]]

    return document, view


def test_an_environment_follows_the_second_frame(stage, fvvinfo):
    _, stream, summary = stage
    found = summary["environment"]
    counts = [found[key] for key in ("chunks", "parts", "triangles", "pictures", "lights")]
    assert counts == [1, 2, 10, 2, 2]
    info = json.loads(fvvinfo("--check", "--chunks", "--json", stream).stdout)["files"][0]
    assert (info["integrity"], info["frames"], info["whole_frames"]) == ("complete", 3, 3)
    names = [(c["type"], c["time"]) for c in info["chunks"]]
    at = names.index(("BACK", "1"))
    assert names[at - 1] == ("VPKT", "1") and names[at + 1][0] == "GEND"
    assert sum(kind == "BACK" for kind, _ in names) == 1


def test_without_and_with_repetitions(stage, tmp_path, fvvinfo):
    folder = stage[0]
    kinds = {}
    for name, option in [("none", "--no-environment"), ("each", "--repeat-configuration")]:
        out = tmp_path / f"{name}.fvv"
        run("fvvmux", folder, "-o", out, *LIGHTLY, "--group", 2, "--triangles", 3000, option)
        info = json.loads(fvvinfo("--check", "--chunks", "--json", out).stdout)["files"][0]
        assert info["integrity"] == "complete"
        kinds[name] = [c["type"] for c in info["chunks"]]
    assert "BACK" not in kinds["none"]
    assert kinds["each"].count("BACK") == 2


def test_an_environment_comes_out_and_goes_in_again(stage, tmp_path):
    folder, stream, summary = stage
    out, again = tmp_path / "out", tmp_path / "again.fvv"
    assert figures("fvvdemux", stream, "-o", out, "--frames", "2")["environment"]
    description = json.loads((out / "capture.json").read_text())
    validate(description, "capture")
    assert description["environment"]["file"] == "environment.glb"
    assert description["environment"]["lattice"]["step"] == summary["environment"]["lattice"]["step"]
    before, old = glb(folder / "environment.glb")
    after, new = glb(out / "environment.glb")
    for a, b in zip(before["images"], after["images"], strict=True):
        assert old(a["bufferView"]) == new(b["bufferView"]), "pictures are passed on as they are"
    second = figures("fvvmux", out, "-o", again, *LIGHTLY, "--keep-geometry")["environment"]
    for key in ("bytes", "parts", "vertices", "triangles", "picture_bytes", "lights"):
        assert second[key] == summary["environment"][key], key
    assert second["max_axis_error"] < 1e-6
    for index in range(2):
        points = []
        for document, view in ((before, old), (after, new)):
            accessor = document["meshes"][index]["primitives"][0]["attributes"]["POSITION"]
            data = view(document["accessors"][accessor]["bufferView"])
            points.append(np.sort(np.frombuffer(data, "<f4").reshape(-1, 3), axis=0))
        assert np.abs(points[0] - points[1]).max() < 1e-3
    run("fvvdemux", stream, "-o", tmp_path / "bare", "--no-environment")
    assert "environment" not in json.loads((tmp_path / "bare/capture.json").read_text())


def test_metadata_of_pictures_is_dropped(stage, tmp_path):
    folder = tmp_path / "capture"
    shutil.copytree(stage[0], folder)
    path = folder / "environment.glb"
    data = path.read_bytes()
    jpeg = data.index(b"\xff\xd8\xff\xe0")
    secret = b"\xff\xe1\x00\x0asecret!!" + b"\xff\xfe\x00\x06note"
    document, view = glb(path)
    picture = view(document["images"][0]["bufferView"])
    assert data[jpeg : jpeg + 100] == picture[:100]
    segment = 4 + struct.unpack_from(">H", picture, 4)[0]
    (folder / "floor.jpg").write_bytes(picture[:segment] + secret + picture[segment:])
    document["images"][0] = {"uri": "floor.jpg"}
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    size = struct.unpack_from("<I", data, 12)[0]
    head = b"glTF" + struct.pack("<III", 2, len(data) - size + len(text), len(text)) + b"JSON"
    path.write_bytes(head + text + data[20 + size :])
    out = tmp_path / "clean.fvv"
    run("fvvmux", folder, "-o", out, *LIGHTLY, "--triangles", 3000)
    stream = out.read_bytes()
    assert b"secret!!" not in stream and b"note" not in stream
    assert picture in stream


def test_the_environment_is_drawn_as_the_cameras_saw_it(stage, tmp_path):
    folder, stream, _ = stage
    around, alone = tmp_path / "around.png", tmp_path / "alone.png"
    run("fvvrender", stream, "--frame", 2, "--camera", 1, "--samples", 5, "-o", around)
    run("fvvrender", stream, "--frame", 2, "--camera", 1, "--samples", 5, "--no-environment", "-o", alone)
    camera = json.loads((folder / "capture.json").read_text())["cameras"][1]

    def pixels(path):
        return np.asarray(Image.open(path).convert("RGB"), np.float64)

    filmed, drawn, bare = (pixels(p) for p in (folder / (camera["pictures"] % 2), around, alone))
    mask = np.asarray(Image.open(folder / (camera["masks"] % 2))) > 0
    away = ~mask & (bare.sum(axis=2) == 0)
    assert away.mean() > 0.7
    # Loose objects and shadows are not part of it.
    assert np.median(np.abs(filmed - drawn)[away]) < 8
    assert np.abs(filmed - bare)[away].mean() > 60
    assert (drawn.sum(axis=2) > 0).mean() > 0.97


def test_a_environment_that_is_missing_or_cut_is_refused(stage, tmp_path):
    folder = tmp_path / "capture"
    shutil.copytree(stage[0], folder)
    (folder / "environment.glb").unlink()
    done = run("fvvmux", folder, "-o", tmp_path / "x.fvv", code=1)
    assert "environment: environment.glb: is missing" in done.stderr
    (folder / "environment.glb").write_bytes((stage[0] / "environment.glb").read_bytes()[:5000])
    done = run("fvvmux", folder, "-o", tmp_path / "x.fvv", code=1)
    assert "environment.glb" in done.stderr and not (tmp_path / "x.fvv").exists()


def test_a_damaged_environment_costs_nothing_else(stage, tmp_path):
    data = bytearray(stage[1].read_bytes())
    at = data.index(b"BACK", 24)
    data[at + 32 + 500] ^= 4
    broken = tmp_path / "broken.fvv"
    broken.write_bytes(data)
    done = run("fvvrender", broken, "--frame", 2, "--camera", 0, "-o", tmp_path / "v.png", code=3)
    assert "no environment" in done.stderr and "FVV-1103" in done.stderr
    assert np.asarray(Image.open(tmp_path / "v.png")).any()
    done = run("fvvdemux", broken, "-o", tmp_path / "out", "--frames", "2", code=3)
    assert "the environment is lost" in done.stderr
    assert (tmp_path / "out" / "capture.json").exists() and not (
        tmp_path / "out" / "environment.glb"
    ).exists()
