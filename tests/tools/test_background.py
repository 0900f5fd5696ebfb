"""Backgrounds: the decoder that was written from the specification, and an environment through all tools and back."""

import json
import struct
import subprocess

import background
import jsonschema
import numpy as np
import pytest
from conftest import ROOT, SPEC, tool_path
from PIL import Image

VECTORS = ROOT / "conformance" / "background"


def run(name, *arguments, code=0):
    done = subprocess.run(
        [tool_path(name), *map(str, arguments)], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == code, done.stderr
    return done


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    """A capture with an environment, its stream in two groups, and what fvvmux said: (folder, stream, summary)."""
    root = tmp_path_factory.mktemp("stage")
    folder, stream = root / "capture", root / "stage.fvv"
    run(
        "fvvsynth",
        "-o",
        folder,
        "--rig",
        "small",
        "--cameras",
        3,
        "--frames",
        3,
        "--size",
        "96x54",
        "--environment",
    )
    options = ["--codec", "jpeg", "--quality", "70", "--group", 2, "--triangles", 3000, "--verify", "--json"]
    return folder, stream, json.loads(run("fvvmux", folder, "-o", stream, *options).stdout)


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


def test_plain_decoder_says_what_is_listed():
    wanted = (VECTORS / "stage.txt").read_text().splitlines()
    assert list(background.decode((VECTORS / "stage.fvv").read_bytes())) == wanted
    assert sum(line.startswith("light") for line in wanted) == 3


def test_plain_decoder_finds_broken_rules():
    payload = next(
        p for kind, *_, p in background.chunks((VECTORS / "stage.fvv").read_bytes()) if kind == b"BACK"
    )
    for at, byte, issue in [
        (44, 1, 8001),
        (31, 0x80, 8002),
        (52, 9, 8005),
        (144, 2, 8007),
        (149, 9, 8006),
        (176, 3, 8008),
    ]:
        broken = bytearray(payload)
        broken[at] = byte
        with pytest.raises(background.Broken, match=f"FVV-{issue}"):
            list(background.lines(bytes(broken)))


def test_fvvinfo_tells_what_the_vector_holds(fvvinfo):
    done = fvvinfo("--check", "--json", VECTORS / "stage.fvv")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    jsonschema.validate(document, json.loads((SPEC / "fvvinfo.schema.json").read_text()))
    track = next(t for t in document["files"][0]["tracks"] if t["kind"] == "background")
    assert track["background"] == {"parts": 2, "vertices": 8, "triangles": 4, "pictures": 2, "lights": 3}


def test_an_environment_stands_behind_the_second_frame(stage, fvvinfo):
    _, stream, summary = stage
    told = summary["background"]
    assert (told["chunks"], told["parts"], told["triangles"], told["pictures"], told["lights"]) == (
        1,
        2,
        10,
        2,
        2,
    )
    info = json.loads(fvvinfo("--check", "--chunks", "--json", stream).stdout)["files"][0]
    assert (info["integrity"], info["frames"], info["whole_frames"]) == ("complete", 3, 3)
    names = [(c["type"], c["time"]) for c in info["chunks"]]
    at = names.index(("BACK", "1"))
    assert names[at - 1] == ("VPKT", "1") and names[at + 1][0] == "GEND"
    assert sum(kind == "BACK" for kind, _ in names) == 1


def test_without_and_with_repetitions(stage, tmp_path, fvvinfo):
    folder = stage[0]
    kinds = {}
    for name, option in [("none", "--no-background"), ("each", "--repeat-configuration")]:
        out = tmp_path / f"{name}.fvv"
        run(
            "fvvmux",
            folder,
            "-o",
            out,
            "--codec",
            "jpeg",
            "--quality",
            "70",
            "--group",
            2,
            "--triangles",
            3000,
            option,
        )
        info = json.loads(fvvinfo("--check", "--chunks", "--json", out).stdout)["files"][0]
        assert info["integrity"] == "complete"
        kinds[name] = [c["type"] for c in info["chunks"]]
    assert "BACK" not in kinds["none"]
    assert kinds["each"].count("BACK") == 2


def test_an_environment_comes_out_and_goes_in_again(stage, tmp_path):
    folder, stream, summary = stage
    out, again = tmp_path / "out", tmp_path / "again.fvv"
    told = json.loads(run("fvvdemux", stream, "-o", out, "--frames", "2", "--json").stdout)
    assert told["background"]
    description = json.loads((out / "capture.json").read_text())
    jsonschema.validate(description, json.loads((SPEC / "capture.schema.json").read_text()))
    assert description["background"]["file"] == "background.glb"
    assert description["background"]["lattice"]["step"] == summary["background"]["lattice"]["step"]
    before, old = glb(folder / "background.glb")
    after, new = glb(out / "background.glb")
    for a, b in zip(before["images"], after["images"], strict=True):
        assert old(a["bufferView"]) == new(b["bufferView"]), "pictures are passed on as they are"
    second = json.loads(
        run(
            "fvvmux", out, "-o", again, "--codec", "jpeg", "--quality", "70", "--keep-geometry", "--json"
        ).stdout
    )["background"]
    for key in ("bytes", "parts", "vertices", "triangles", "picture_bytes", "lights"):
        assert second[key] == summary["background"][key], key
    assert second["max_axis_error"] < 1e-6
    for index in range(2):
        a, b = (
            np.frombuffer(
                view(
                    document["accessors"][
                        document["meshes"][index]["primitives"][0]["attributes"]["POSITION"]
                    ]["bufferView"]
                ),
                "<f4",
            ).reshape(-1, 3)
            for document, view in ((before, old), (after, new))
        )
        assert np.abs(np.sort(a, axis=0) - np.sort(b, axis=0)).max() < 1e-3
    assert "background" not in json.loads(
        (lambda d: (run("fvvdemux", stream, "-o", d, "--no-background"), d)[1] / "capture.json")(
            tmp_path / "b"
        ).read_text()
    )


def test_metadata_of_pictures_stays_at_home(stage, tmp_path):
    folder = tmp_path / "capture"
    subprocess.run(["cp", "-r", stage[0], folder], check=True)
    path = folder / "background.glb"
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
    path.write_bytes(
        b"glTF"
        + struct.pack("<II", 2, len(data) - size + len(text))
        + struct.pack("<I", len(text))
        + b"JSON"
        + text
        + data[20 + size :]
    )
    out = tmp_path / "clean.fvv"
    run("fvvmux", folder, "-o", out, "--codec", "jpeg", "--quality", "70", "--triangles", 3000)
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
    # Things that stand about and shadows are not part of it.
    assert np.median(np.abs(filmed - drawn)[away]) < 8
    assert np.abs(filmed - bare)[away].mean() > 60
    assert (drawn.sum(axis=2) > 0).mean() > 0.97


def test_what_is_wrong_with_a_background_is_told(stage, tmp_path):
    folder = tmp_path / "capture"
    subprocess.run(["cp", "-r", stage[0], folder], check=True)
    (folder / "background.glb").unlink()
    done = run("fvvmux", folder, "-o", tmp_path / "x.fvv", code=1)
    assert "background: background.glb is missing" in done.stderr
    (folder / "background.glb").write_bytes((stage[0] / "background.glb").read_bytes()[:5000])
    done = run("fvvmux", folder, "-o", tmp_path / "x.fvv", code=1)
    assert "background.glb" in done.stderr and not (tmp_path / "x.fvv").exists()


def test_a_damaged_background_costs_nothing_else(stage, tmp_path):
    data = bytearray(stage[1].read_bytes())
    at = data.index(b"BACK", 24)
    data[at + 32 + 500] ^= 4
    broken = tmp_path / "broken.fvv"
    broken.write_bytes(data)
    done = run("fvvrender", broken, "--frame", 2, "--camera", 0, "-o", tmp_path / "v.png", code=3)
    assert "no environment" in done.stderr and "FVV-1103" in done.stderr
    assert np.asarray(Image.open(tmp_path / "v.png")).any()
    done = run("fvvdemux", broken, "-o", tmp_path / "out", "--frames", "2", code=3)
    assert "the background is lost" in done.stderr
    assert (tmp_path / "out" / "capture.json").exists() and not (tmp_path / "out" / "background.glb").exists()
