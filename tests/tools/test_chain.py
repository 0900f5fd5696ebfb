"""The whole chain on a small generated capture: what goes into a stream comes out of it, and goes in again."""

import json
import subprocess
import sys

import jsonschema
import numpy as np
import pytest
from conftest import ROOT, SPEC, tool_path
from PIL import Image

sys.path.insert(0, str(ROOT / "conformance/real"))
from real_capture import read_ply, triangle_set  # noqa: E402


def run(name, *arguments):
    path = tool_path(name)
    assert path, f"{name} was not built"
    done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert done.stderr == "", "success is silent on stderr, and there is no progress in a pipe"
    return done.stdout


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("chain") / "players"
    run("fvvsynth", "-o", folder, "--rig", "small", "--frames", 3, "--cameras", 3, "--size", "160x90")
    return folder


def luma(path):
    return np.asarray(Image.open(path).convert("RGB"), np.float64) @ [0.2126, 0.7152, 0.0722]


@pytest.mark.parametrize("codec, options", [("h264", []), ("jpeg", ["--no-delta"])])
def test_there_and_back(capture, tmp_path, codec, options):
    stream, out = tmp_path / "players.fvv", tmp_path / "out"
    summary = json.loads(
        run(
            "fvvmux",
            capture,
            "-o",
            stream,
            "--codec",
            codec,
            "--quality",
            "40dB",
            "--keep-geometry",
            "--visibility",
            "face",
            "--json",
            *options,
        )  # fmt: skip
    )
    assert summary["frames"] == 3

    document = json.loads(run("fvvinfo", "--check", "--chunks", "--json", stream))
    jsonschema.validate(document, json.loads((SPEC / "fvvinfo.schema.json").read_text()))
    info = document["files"][0]
    assert (info["integrity"], info["frames"], info["whole_frames"]) == ("complete", 3, 3)
    assert [t["kind"] for t in info["tracks"]] == ["mesh", "video", "visibility"]
    profiles = {name: p["chunks"] for name, p in info["tracks"][0]["mesh"]["profiles"].items()}
    assert profiles == ({"draco": 3} if options else {"draco": 1, "delta": 2})
    assert len(info["cameras"]) == len(info["tracks"][1]["video"]["tiles"]) == 3

    run("fvvdemux", stream, "-o", out)
    before = json.loads((capture / "capture.json").read_text())
    after = json.loads((out / "capture.json").read_text())
    for a, b in zip(before["cameras"], after["cameras"]):
        for key in "id", "name", "width", "height", "rotation", "translation":
            assert a[key] == b[key]
        assert {k: v for k, v in a["intrinsics"].items() if v} == {
            k: v for k, v in b["intrinsics"].items() if v
        }

    step = info["scene"]["lattice_step"]
    off = (0.5 + summary["mesh"]["delta"]["max_error_steps"]) * step
    run("fvvcompare", capture, stream, "--max-distance", f"{off * 3**0.5}")
    squares = pixels = 0
    for frame in range(3):
        source = read_ply(capture / f"meshes/{frame:04d}.ply")
        decoded = read_ply(out / f"meshes/{frame:04d}.ply")
        if frame == 0 or options:  # key frames lie on the lattice points nearest to the source
            assert triangle_set(*decoded, step) <= triangle_set(*source, step)
            lattice = {tuple(p) for p in np.rint(source[0] / step).astype(int).tolist()}
            assert {tuple(p) for p in np.rint(decoded[0] / step).astype(int).tolist()} <= lattice
        for camera in range(3):
            mask = np.asarray(Image.open(capture / f"cam{camera}/mask_{frame:04d}.png")) > 127
            error = luma(capture / f"cam{camera}/{frame:04d}.png") - luma(
                out / f"cam{camera}/{frame:04d}.png"
            )
            squares, pixels = squares + (error[mask] ** 2).sum(), pixels + mask.sum()
    assert 10 * np.log10(255**2 * pixels / squares) >= 39.9

    again, once_more = tmp_path / "again.fvv", tmp_path / "once_more"
    run("fvvmux", out, "-o", again, "--codec", codec, "--quality", "40dB", "--no-delta")
    run("fvvdemux", again, "-o", once_more)
    for frame in range(3):
        first = read_ply(out / f"meshes/{frame:04d}.ply")
        second = read_ply(once_more / f"meshes/{frame:04d}.ply")
        assert triangle_set(*first, step) == triangle_set(*second, step)
        assert np.array_equal(np.unique(first[0], axis=0), np.unique(second[0], axis=0))


@pytest.mark.long
def test_the_same_bytes_again(capture, tmp_path):
    streams = []
    for threads in 1, 2, 3:
        path = tmp_path / f"{threads}.fvv"
        run("fvvmux", capture, "-o", path, "--group", 1, "--quality", 30, "--threads", threads)
        streams.append(path.read_bytes())
    assert streams[0] == streams[1] == streams[2]
