"""Light beyond white from camera pictures in OpenEXR into a stream, out of it, and into rendered pictures."""

import json
import struct

import numpy as np
import openexr
import pytest
from conftest import ROOT, Tool, tool_path
from PIL import Image
from test_fvvrender import read_exr

WIDTH, HEIGHT, FRAMES, CAMERAS = 96, 54, 2, 3
VECTORS = ROOT / "conformance" / "openexr"
WHOLE = ("--crop", "none", "--background", "keep")  # pictures with all of their pixels


def run(name, *arguments, expected=0):
    done = Tool(tool_path(name))(*arguments)
    assert done.returncode == expected, done.stderr
    return done


def write(path, pixels, **changed):
    """Half floats of shape (rows, columns, 3)."""
    path.write_bytes(openexr.write(pixels.shape[1], pixels.shape[0], pixels.tolist(), openexr.ZIP, **changed))


def display(light):
    """Display values of linear light, IEC 61966-2-1, clipped."""
    x = np.clip(np.asarray(light, np.float64), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def light_of(camera, frame):
    """Ramps from below black to 40 times white."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    red = 40.0 ** ((x - y + 3 * frame) % WIDTH / WIDTH) * 0.1
    return np.stack([red, x / WIDTH - 0.25, np.full(x.shape, camera + 0.5)], axis=2).astype(np.float16)


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    """The folder of a generated capture with pictures in OpenEXR."""
    out = tmp_path_factory.mktemp("generated") / "capture"
    size = f"{WIDTH}x{HEIGHT}"
    options = ["--rig", "small", "--frames", FRAMES, "--cameras", CAMERAS, "--size", size]
    run("fvvsynth", "-o", out, *options, "--pictures", "exr", "--exposure", "0.3")
    return out


@pytest.fixture
def capture(generated, tmp_path):
    """The same meshes and cameras with the pictures of light_of: OpenEXR by the decoder written from the prose."""
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


def payloads(path):
    return list(openexr.samples(path.read_bytes()))


def test_plain_decoder_gives_the_listed_samples(fvvinfo):
    assert openexr.crcs((VECTORS / "bars.fvv").read_bytes()) == (VECTORS / "bars.crc").read_text().split()
    assert (VECTORS / "bars.fvv").read_bytes() == openexr.make()
    done = fvvinfo(VECTORS / "bars.fvv", "--check", "--json")
    assert (done.returncode, done.stderr) == (0, b"")
    (track,) = json.loads(done.stdout)["files"][0]["tracks"]
    assert track["chunks"] == 3


def test_generated_light_goes_beyond_white_and_comes_back_bit_for_bit(generated, tmp_path):
    stream, out = tmp_path / "a.fvv", tmp_path / "out"
    done = run("fvvmux", generated, "-o", stream, "--codec", "exr", *WHOLE, "--verify", "--json")
    summary = json.loads(done.stdout)
    assert (summary["video"]["codec"], summary["video"]["quality"], summary["video"]["bit_depth"]) == (
        "exr",
        0,
        16,
    )
    assert (
        summary["verified"]["pictures"] == FRAMES and summary["verified"]["psnr"] is None
    )  # no error at all
    run("fvvdemux", stream, "-o", out)
    for picture in sorted(generated.glob("cam*/0*.exr")):
        # Both were written by the same encoder.
        assert (out / picture.relative_to(generated)).read_bytes() == picture.read_bytes()
    run("fvvdemux", stream, "-o", tmp_path / "png", "--pictures", "png")
    brightest = np.asarray(Image.open(tmp_path / "png/cam0/0000.png"))
    assert (brightest == brightest.max()).sum() > 20  # what was beyond white is clipped there


def test_light_of_other_writers_survives_mux_and_demux(capture, tmp_path):
    first, again, out = tmp_path / "a.fvv", tmp_path / "b.fvv", tmp_path / "out"
    run("fvvmux", capture, "-o", first, "--codec", "exr", "--keep-geometry", *WHOLE, "--verify")
    run("fvvdemux", first, "-o", out)
    assert json.loads((out / "capture.json").read_text())["cameras"][0]["pictures"] == "cam0/%04d.exr"
    run("fvvmux", out, "-o", again, "--codec", "exr", "--keep-geometry", *WHOLE, "--threads", 1)
    assert payloads(first) == payloads(again) and len(payloads(first)) == FRAMES
    run("fvvdemux", first, "-o", tmp_path / "png", "--pictures", "png")
    for index in range(CAMERAS):
        folder = json.loads((out / "capture.json").read_text())["cameras"][index]["pictures"].split("/")[0]
        for frame in range(FRAMES):
            codes = np.asarray(Image.open(tmp_path / f"png/{folder}/{frame:04d}.png")).astype(float)
            # Pillow brings the 16 bits of the file to 8.
            assert np.abs(codes - 255 * display(light_of(index, frame))).max() <= 1
    run("fvvmux", capture, "-o", tmp_path / "small.fvv", "--codec", "exr", "--scale", "0.5", "--verify")
    run("fvvmux", capture, "-o", tmp_path / "jpeg.fvv", "--codec", "jpeg", "--verify")


@pytest.mark.long
def test_quality_is_lossless_a_level_or_decibels(generated, tmp_path):
    found = {}
    for quality in ("lossless", "45", "200", "44dB"):
        path = tmp_path / f"{quality}.fvv"
        done = run(
            "fvvmux", generated, "-o", path, "--codec", "exr", "--quality", quality, "--json", "--verify"
        )
        found[quality] = json.loads(done.stdout)["video"]
    assert found["lossless"]["bytes"] > found["45"]["bytes"] > found["200"]["bytes"]
    assert [found[q]["quality"] for q in ("lossless", "45", "200")] == [0, 45, 200]
    assert 44 <= found["44dB"]["sample_psnr"] < 45
    text = run("fvvmux", generated, "-o", tmp_path / "t.fvv", "--codec", "exr", "--no-meshes").stdout
    assert b"OpenEXR lossless, 16 bits, 3 tiles" in text
    rate = ["--codec", "exr", "--bitrate", "8M", "--json", *WHOLE]
    video = json.loads(run("fvvmux", generated, "-o", tmp_path / "r.fvv", *rate).stdout)["video"]
    assert 0.8 * 8e6 < video["bit_rate"]["reached"] <= 8e6
    for wrong, message in {
        ("--quality", "501"): b"expected a PSNR such as 42dB, or lossless, or a DWA level from 0 to 500",
        ("--bit-depth", "10"): b"the video has 10 bits a sample, expected 16 for OpenEXR",
    }.items():
        done = run("fvvmux", generated, "-o", tmp_path / "w.fvv", "--codec", "exr", *wrong, expected=2)
        assert message in done.stderr
    done = run("fvvmux", generated, "-o", tmp_path / "w.fvv", "--quality", "lossless", expected=2)
    assert b"a CRF from 1 to 51" in done.stderr


def test_values_that_are_no_light_are_refused_by_camera_and_frame(capture, tmp_path):
    path = capture / "cam1/0001.exr"
    floats = np.full((HEIGHT, WIDTH), 0.5, np.float32)
    for value, message in (
        (np.inf, "is infinite"),
        (np.nan, "is not a number"),
        (70000, "is 70000, expected -65504"),
    ):
        floats[7, 11] = value
        lines = [np.concatenate([np.full(WIDTH, 0.5, np.float32), row, row]).tobytes() for row in floats]
        channels = b"".join(openexr.channel(name, 2) for name in "BGR") + b"\0"
        head = (
            openexr.MAGIC
            + struct.pack("<i", 2)
            + openexr.header(WIDTH, HEIGHT, openexr.NONE, channels=channels)
        )
        size, start = 8 + len(lines[0]), len(head) + 8 * HEIGHT
        table = b"".join(struct.pack("<Q", start + y * size) for y in range(HEIGHT))
        blocks = b"".join(struct.pack("<2i", y, len(line)) + line for y, line in enumerate(lines))
        path.write_bytes(head + table + blocks)
        done = run("fvvmux", capture, "-o", tmp_path / "bad.fvv", "--codec", "exr", expected=1)
        assert f"cam1/0001.exr: channel R of pixel (11, 7) {message}" in done.stderr.decode()
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
