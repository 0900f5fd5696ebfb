"""OpenEXR through the tools: pictures that fvvmux takes, depth and visibility that fvvsynth writes."""

import json
import struct
import subprocess

import numpy as np
import pytest
from conftest import tool_path
from PIL import Image


def run(name, *arguments):
    path = tool_path(name)
    assert path, f"{name} was not built"
    return subprocess.run([path, *map(str, arguments)], capture_output=True, text=True, timeout=300)


def write_exr(path, channels):
    """An uncompressed file of {name: array of float16 or float32}, by the layout that OpenEXR documents."""
    height, width = next(iter(channels.values())).shape
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    names = sorted(channels)
    entries = b"".join(
        n.encode() + struct.pack("<x2I2i", 1 if channels[n].dtype == np.float16 else 2, 0, 1, 1)
        for n in names
    )
    attributes = [
        ("channels", "chlist", entries + b"\0"),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", box),
        ("displayWindow", "box2i", box),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    ]
    header = struct.pack("<2I", 20000630, 2)
    for name, kind, value in attributes:
        header += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<I", len(value)) + value
    header += b"\0"
    lines = [b"".join(channels[n][y].tobytes() for n in names) for y in range(height)]
    size = 8 + len(lines[0])
    start = len(header) + 8 * height
    table = b"".join(struct.pack("<Q", start + y * size) for y in range(height))
    blocks = b"".join(struct.pack("<2i", y, len(line)) + line for y, line in enumerate(lines))
    path.write_bytes(header + table + blocks)


def linear(codes):
    """Linear light of 8-bit sRGB values, IEC 61966-2-1."""
    v = np.asarray(codes, np.float64) / 255
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4).astype(np.float32)


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    """PNG pictures, and the same in OpenEXR: {"png": folder, "exr": folder}."""
    root = tmp_path_factory.mktemp("exr")
    done = run(
        "fvvsynth", "-o", root / "png", "--rig", "small", "--frames", 2, "--cameras", 3, "--size", "96x54"
    )
    assert done.returncode == 0, done.stderr
    description = json.loads((root / "png/capture.json").read_text())
    for camera in description["cameras"]:
        folder = root / "exr" / camera["name"]
        folder.mkdir(parents=True)
        for frame in range(2):
            picture = np.asarray(Image.open(root / "png" / camera["name"] / f"{frame:04d}.png"))
            write_exr(folder / f"{frame:04d}.exr", {c: linear(picture[..., i]) for i, c in enumerate("RGB")})
            mask = np.asarray(Image.open(root / "png" / camera["name"] / f"mask_{frame:04d}.png"))
            write_exr(folder / f"mask_{frame:04d}.exr", {"Y": (mask / 255).astype(np.float16)})
        camera["pictures"] = camera["pictures"].replace(".png", ".exr")
        camera["masks"] = camera["masks"].replace(".png", ".exr")
    description["meshes"]["pattern"] = str(root / "png/meshes/%04d.ply")
    (root / "exr/capture.json").write_text(json.dumps(description))
    return {"png": root / "png", "exr": root / "exr"}


def test_a_sequence_in_linear_light_gives_the_stream_that_its_display_values_give(capture, tmp_path):
    streams = {}
    for kind, folder in capture.items():
        out = tmp_path / f"{kind}.fvv"
        done = run(
            "fvvmux", folder, "-o", out, "--codec", "jpeg", "--quality", "40dB", "--background", "flat"
        )
        assert (done.returncode, done.stderr) == (0, "")
        streams[kind] = out.read_bytes()
    assert len(streams["png"]) > 10000
    assert streams["exr"] == streams["png"]
    assert run("fvvdemux", tmp_path / "exr.fvv", "-o", tmp_path / "out").returncode == 0
    assert Image.open(tmp_path / "out/cam0/0000.png").size == (96, 54)


def test_pictures_that_are_no_light_are_refused_by_name_and_pixel(capture, tmp_path):
    path = capture["exr"] / "cam1/0001.exr"
    good = path.read_bytes()
    try:
        samples = np.full((54, 96), 0.5, np.float32)
        bad = samples.copy()
        bad[7, 11] = np.nan
        write_exr(path, {"R": samples, "G": bad, "B": samples})
        done = run("fvvmux", capture["exr"], "-o", tmp_path / "nan.fvv")
        assert done.returncode == 1
        assert "cam1/0001.exr: channel G of pixel (11, 7) is not a number" in done.stderr
        write_exr(path, {"Z": samples})
        done = run("fvvmux", capture["exr"], "-o", tmp_path / "depth.fvv")
        assert done.returncode == 1
        assert "cam1/0001.exr: has the depth channel Z alone" in done.stderr
        path.write_bytes(good[:-100])
        done = run("fvvmux", capture["exr"], "-o", tmp_path / "cut.fvv")
        assert done.returncode == 1
        assert "cam1/0001.exr: " in done.stderr
        assert not list(tmp_path.glob("*.fvv"))
    finally:
        path.write_bytes(good)


def test_numpy_reads_visibility_and_the_capture_can_be_packed(tmp_path):
    out = tmp_path / "truth"
    options = ["--rig", "small", "--frames", 2, "--cameras", 3, "--size", "96x54", "--meshes", "remeshed"]
    done = run("fvvsynth", "-o", out, *options, "--depth", "--visibility")
    assert (done.returncode, done.stderr) == (0, "")
    for frame in range(2):
        head = (out / f"meshes/{frame:04d}.ply").read_bytes()[:400].decode("latin-1").split("\n")
        counts = {line.split()[1]: int(line.split()[2]) for line in head if line.startswith("element")}
        for kind, count in ("faces", counts["face"]), ("vertices", counts["vertex"]):
            seen = np.load(out / f"visibility/{kind}_{frame:04d}.npy", allow_pickle=False)
            assert (seen.dtype, seen.shape) == (np.dtype(bool), (3, count))
            assert (seen.mean(axis=1) > 0.2).all()
            assert (seen.mean(axis=1) < 0.55).all()
    assert len(list(out.glob("cam*/depth_*.exr"))) == 6
    done = run("fvvmux", out, "-o", tmp_path / "truth.fvv")
    assert (done.returncode, done.stderr) == (0, "")
