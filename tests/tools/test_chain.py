"""The whole chain on a small generated capture: into a stream, out of it, and in again."""

import json

import numpy as np
import pytest
from conftest import figures, run
from PIL import Image
from real_capture import luma, read_ply, triangle_set


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("chain") / "players"
    run("fvvsynth", "-o", folder, "--rig", "small", "--frames", 3, "--cameras", 3, "--size", "160x90")
    return folder


@pytest.mark.parametrize("codec, options", [("h264", []), ("jpeg", ["--no-delta"])])
def test_there_and_back(capture, tmp_path, codec, options):
    stream, out = tmp_path / "players.fvv", tmp_path / "out"
    wishes = ["--codec", codec, "--quality", "40dB", "--keep-geometry", "--visibility", "weight", *options]
    summary = figures("fvvmux", capture, "-o", stream, *wishes)
    assert summary["frames"] == 3

    info = figures("fvvinfo", "--check", "--chunks", stream)["files"][0]
    assert (info["integrity"], info["frames"], info["whole_frames"]) == ("complete", 3, 3)
    assert [t["kind"] for t in info["tracks"]] == ["mesh", "video", "visibility", "colours"]
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


def test_cameras_on_several_tracks_are_drawn_and_unpacked_as_from_one(tmp_path):
    capture = tmp_path / "capture"
    run("fvvsynth", "-o", capture, "--rig", "small", "--cameras", 4, "--frames", 2, "--size", "96x54")
    description = capture / "capture.json"
    drawn, unpacked, cameras = {}, {}, {}
    # Level 5.2 of H.264 has 2,073,600 macroblocks a second: room for two whole pictures at the higher rate.
    for rate in ("25", "40000"):
        text = json.loads(description.read_text())
        text["frame_rate"] = rate
        description.write_text(json.dumps(text))
        stream = tmp_path / f"{rate}.fvv"
        options = ["--crop", "none", "--triangles", 3000, "--quality", 5]
        video = figures("fvvmux", capture, "-o", stream, *options)["video"]
        cameras[rate] = [track["camera_ids"] for track in video] if isinstance(video, list) else None
        run("fvvinfo", "--check", stream)
        out = tmp_path / f"{rate}.png"
        run("fvvrender", stream, "--frame", 1, "--camera", 3, "-o", out)
        drawn[rate] = np.asarray(Image.open(out).convert("RGB"), float)
        run("fvvdemux", stream, "-o", tmp_path / rate)
        unpacked[rate] = [
            np.asarray(Image.open(tmp_path / rate / f"cam{k}" / "0001.png"), float) for k in range(4)
        ]
    assert cameras == {"25": None, "40000": [[0, 1], [2, 3]]}
    # The difference that remains is the codec's.
    pairs = [(drawn["25"], drawn["40000"]), *zip(unpacked["25"], unpacked["40000"])]
    for one, spread in pairs:
        assert one.std() > 10
        assert np.sqrt(((one - spread) ** 2).mean()) < 4
