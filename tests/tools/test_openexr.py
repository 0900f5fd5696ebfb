"""OpenEXR through the tools: pictures as input, depth and visibility of fvvsynth, and light beyond white in streams."""

import json

import numpy as np
import pytest
from conftest import figures, run
from pictures import read_exr, write_exr
from PIL import Image
from reference import container, openexr

WIDTH, HEIGHT, FRAMES, CAMERAS = 96, 54, 2, 3
SMALL = ("--rig", "small", "--frames", FRAMES, "--cameras", CAMERAS, "--size", f"{WIDTH}x{HEIGHT}")
WHOLE = ("--crop", "none", "--tile-fill", "keep")  # pictures with all of their pixels


def linear(codes):
    """Linear light of 8-bit sRGB values, IEC 61966-2-1."""
    v = np.asarray(codes, np.float64) / 255
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4).astype(np.float32)


def display(light):
    """Display values of linear light, IEC 61966-2-1, clipped."""
    x = np.clip(np.asarray(light, np.float64), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


# Pictures in OpenEXR become display values.


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """PNG pictures, and the same in OpenEXR: {"png": folder, "exr": folder}."""
    root = tmp_path_factory.mktemp("exr")
    run("fvvsynth", "-o", root / "png", *SMALL)
    description = json.loads((root / "png/capture.json").read_text())
    for camera in description["cameras"]:
        folder = root / "exr" / camera["name"]
        folder.mkdir(parents=True)
        for frame in range(FRAMES):
            picture = np.asarray(Image.open(root / "png" / camera["name"] / f"{frame:04d}.png"))
            write_exr(folder / f"{frame:04d}.exr", {c: linear(picture[..., i]) for i, c in enumerate("RGB")})
            mask = np.asarray(Image.open(root / "png" / camera["name"] / f"mask_{frame:04d}.png"))
            write_exr(folder / f"mask_{frame:04d}.exr", {"Y": (mask / 255).astype(np.float16)})
        camera["pictures"] = camera["pictures"].replace(".png", ".exr")
        camera["masks"] = camera["masks"].replace(".png", ".exr")
    description["meshes"]["pattern"] = str(root / "png/meshes/%04d.ply")
    (root / "exr/capture.json").write_text(json.dumps(description))
    return {"png": root / "png", "exr": root / "exr"}


def test_a_sequence_in_linear_light_gives_the_stream_that_its_display_values_give(pair, tmp_path):
    streams = {}
    for kind, folder in pair.items():
        out = tmp_path / f"{kind}.fvv"
        run("fvvmux", folder, "-o", out, "--codec", "jpeg", "--quality", "40dB", "--tile-fill", "flat")
        streams[kind] = out.read_bytes()
    assert len(streams["png"]) > 10000
    assert streams["exr"] == streams["png"]
    run("fvvdemux", tmp_path / "exr.fvv", "-o", tmp_path / "out")
    assert Image.open(tmp_path / "out/cam0/0000.png").size == (96, 54)


def test_a_picture_that_is_not_light_is_refused_by_name_and_pixel(pair, tmp_path):
    path = pair["exr"] / "cam1/0001.exr"
    good = path.read_bytes()
    try:
        grey = np.full((HEIGHT, WIDTH), 0.5, np.float32)
        bad = grey.copy()
        bad[7, 11] = np.nan
        write_exr(path, {"R": grey, "G": bad, "B": grey})
        done = run("fvvmux", pair["exr"], "-o", tmp_path / "nan.fvv", code=1)
        assert "cam1/0001.exr: channel G of pixel (11, 7) is not a number" in done.stderr
        write_exr(path, {"Z": grey})
        done = run("fvvmux", pair["exr"], "-o", tmp_path / "depth.fvv", code=1)
        assert "cam1/0001.exr: has the depth channel Z alone" in done.stderr
        path.write_bytes(good[:-100])
        done = run("fvvmux", pair["exr"], "-o", tmp_path / "cut.fvv", code=1)
        assert "cam1/0001.exr: " in done.stderr
        assert not list(tmp_path.glob("*.fvv"))
    finally:
        path.write_bytes(good)


def test_numpy_reads_visibility_and_the_capture_can_be_packed(tmp_path):
    out = tmp_path / "truth"
    run("fvvsynth", "-o", out, *SMALL, "--meshes", "remeshed", "--depth", "--visibility")
    for frame in range(FRAMES):
        head = (out / f"meshes/{frame:04d}.ply").read_bytes()[:400].decode("latin-1").split("\n")
        counts = {line.split()[1]: int(line.split()[2]) for line in head if line.startswith("element")}
        for kind, count in ("faces", counts["face"]), ("vertices", counts["vertex"]):
            seen = np.load(out / f"visibility/{kind}_{frame:04d}.npy", allow_pickle=False)
            assert (seen.dtype, seen.shape) == (np.dtype(bool), (CAMERAS, count))
            assert (seen.mean(axis=1) > 0.2).all()
            assert (seen.mean(axis=1) < 0.55).all()
    assert len(list(out.glob("cam*/depth_*.exr"))) == FRAMES * CAMERAS
    run("fvvmux", out, "-o", tmp_path / "truth.fvv")


# Streams with samples in OpenEXR.


def write(path, pixels, **changed):
    """Half floats of shape (rows, columns, 3)."""
    path.write_bytes(openexr.write(pixels.shape[1], pixels.shape[0], pixels.tolist(), openexr.ZIP, **changed))


def light_of(camera, frame):
    """Ramps from below black to 40 times white."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    red = 40.0 ** ((x - y + 3 * frame) % WIDTH / WIDTH) * 0.1
    return np.stack([red, x / WIDTH - 0.25, np.full(x.shape, camera + 0.5)], axis=2).astype(np.float16)


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    """The folder of a generated capture with pictures in OpenEXR."""
    out = tmp_path_factory.mktemp("generated") / "capture"
    run("fvvsynth", "-o", out, *SMALL, "--pictures", "exr", "--exposure", "0.3")
    return out


@pytest.fixture
def capture(generated, tmp_path):
    """The same meshes and cameras with the pictures of light_of, as the reference writes OpenEXR."""
    folder = tmp_path / "capture"
    description = json.loads((generated / "capture.json").read_text())
    description["meshes"]["pattern"] = str(generated / "meshes/%04d.ply")
    for index, camera in enumerate(description["cameras"]):
        del camera["masks"]
        (folder / camera["name"]).mkdir(parents=True)
        for frame in range(FRAMES):
            write(folder / camera["name"] / f"{frame:04d}.exr", light_of(index, frame))
    (folder / "capture.json").write_text(json.dumps(description))
    return folder


def samples(path):
    return container.payloads(path.read_bytes(), b"VPKT")


def test_generated_light_goes_beyond_white_and_comes_back_bit_for_bit(generated, tmp_path):
    stream, out = tmp_path / "a.fvv", tmp_path / "out"
    summary = figures("fvvmux", generated, "-o", stream, "--codec", "exr", *WHOLE, "--verify")
    video = summary["video"]
    assert (video["codec"], video["quality"], video["bit_depth"]) == ("exr", 0, 16)
    # No error at all.
    assert summary["verified"]["pictures"] == FRAMES and summary["verified"]["psnr"] is None
    run("fvvdemux", stream, "-o", out)
    for picture in sorted(generated.glob("cam*/0*.exr")):
        # Both were written by the same encoder.
        assert (out / picture.relative_to(generated)).read_bytes() == picture.read_bytes()
    run("fvvdemux", stream, "-o", tmp_path / "png", "--pictures", "png")
    brightest = np.asarray(Image.open(tmp_path / "png/cam0/0000.png"))
    assert (brightest == brightest.max()).sum() > 20  # light beyond white is clipped there


def test_light_of_other_writers_survives_mux_and_demux(capture, tmp_path):
    first, again, out = tmp_path / "a.fvv", tmp_path / "b.fvv", tmp_path / "out"
    run("fvvmux", capture, "-o", first, "--codec", "exr", "--keep-geometry", *WHOLE, "--verify")
    run("fvvdemux", first, "-o", out)
    assert json.loads((out / "capture.json").read_text())["cameras"][0]["pictures"] == "cam0/%04d.exr"
    run("fvvmux", out, "-o", again, "--codec", "exr", "--keep-geometry", *WHOLE, "--threads", 1)
    assert samples(first) == samples(again) and len(samples(first)) == FRAMES
    run("fvvdemux", first, "-o", tmp_path / "png", "--pictures", "png")
    for index in range(CAMERAS):
        folder = json.loads((out / "capture.json").read_text())["cameras"][index]["pictures"].split("/")[0]
        for frame in range(FRAMES):
            codes = np.asarray(Image.open(tmp_path / f"png/{folder}/{frame:04d}.png")).astype(float)
            # Pillow reduces the 16 bits of the file to 8.
            assert np.abs(codes - 255 * display(light_of(index, frame))).max() <= 1
    run("fvvmux", capture, "-o", tmp_path / "small.fvv", "--codec", "exr", "--scale", "0.5", "--verify")
    run("fvvmux", capture, "-o", tmp_path / "jpeg.fvv", "--codec", "jpeg", "--verify")


def test_quality_is_lossless_alone(generated, tmp_path):
    text = run("fvvmux", generated, "-o", tmp_path / "t.fvv", "--codec", "exr", "--no-meshes").stdout
    assert "OpenEXR lossless, 16 bits, 3 tiles" in text
    options = ["-o", tmp_path / "q.fvv", "--codec", "exr", "--quality", "lossless", *WHOLE, "--verify"]
    assert figures("fvvmux", generated, *options)["video"]["quality"] == 0
    for wrong, message in {
        ("--quality", "45"): '--quality: expected lossless, the only quality of OpenEXR, found "45"',
        ("--quality", "44dB"): '--quality: expected lossless, the only quality of OpenEXR, found "44dB"',
        ("--bitrate", "8M"): "--bitrate: video in OpenEXR is lossless and keeps no bit rate",
        ("--bit-depth", "10"): "the video has 10 bits a sample, expected 16 for OpenEXR",
    }.items():
        done = run("fvvmux", generated, "-o", tmp_path / "w.fvv", "--codec", "exr", *wrong, code=2)
        assert message in done.stderr
    done = run("fvvmux", generated, "-o", tmp_path / "w.fvv", "--quality", "lossless", code=2)
    assert "a CRF from 1 to 51" in done.stderr


def test_values_that_are_not_light_are_refused_by_camera_and_frame(capture, tmp_path):
    path = capture / "cam1/0001.exr"
    floats = np.full((HEIGHT, WIDTH), 0.5, np.float32)
    for value, message in (
        (np.inf, "is infinite"),
        (np.nan, "is not a number"),
        (70000, "is 70000, expected -65504"),
    ):
        floats[7, 11] = value
        grey = np.full((HEIGHT, WIDTH), 0.5, np.float32)
        write_exr(path, {"R": floats, "G": grey, "B": grey})
        done = run("fvvmux", capture, "-o", tmp_path / "bad.fvv", "--codec", "exr", code=1)
        assert f"cam1/0001.exr: channel R of pixel (11, 7) {message}" in done.stderr
    assert not list(tmp_path.glob("*.fvv"))


def test_rendered_pictures_have_the_light_of_the_cameras(capture, tmp_path):
    colour = np.array([5.0, 0.5, -0.25])
    for path in capture.glob("cam*/*.exr"):
        write(path, np.broadcast_to(colour, (HEIGHT, WIDTH, 3)))
    run("fvvmux", capture, "-o", tmp_path / "lit.fvv", "--codec", "exr")
    for name in ("view.exr", "view.png"):
        where = ["--camera", 1, "--unseen", "0,0,0", "--mask", tmp_path / "mask.png"]
        run("fvvrender", tmp_path / "lit.fvv", "--frame", 1, *where, "-o", tmp_path / name, "--force")
    channels = read_exr(tmp_path / "view.exr")
    picture = np.stack([channels[c] for c in "RGB"], axis=2)
    lit = picture[..., 1] > 0.1
    assert lit.sum() > 100
    assert np.abs(picture[lit] - colour).max() < 1e-5
    png = np.asarray(Image.open(tmp_path / "view.png"))
    assert (png[lit] == [255, 188, 0]).all()
