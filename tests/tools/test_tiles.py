"""Layouts of groups: the reader that was written from the specification reads the vector, and the tools do."""

import json
import subprocess

import numpy as np
import tiles
from conftest import ROOT, tool_path
from PIL import Image

VECTORS = ROOT / "conformance" / "tiles"


def test_plain_reader_gives_the_listed_layouts():
    assert (
        list(tiles.lines((VECTORS / "crops.fvv").read_bytes()))
        == (VECTORS / "crops.txt").read_text().splitlines()
    )


def test_vector_uses_what_clause_10_11_has():
    found = [by_track[2] for _, by_track in tiles.layouts((VECTORS / "crops.fvv").read_bytes())]
    assert found[0] == found[3]
    assert len({str(layout) for layout in found}) == 4
    assert [camera for camera, *_ in found[2]] == [1]
    assert any(source[2:] != destination[2:] for layout in found for _, source, destination in layout)


def test_fvvinfo_finds_every_frame_whole(fvvinfo):
    done = fvvinfo("--check", VECTORS / "crops.fvv")
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"3 layouts of groups" in done.stdout


def run(name, *arguments):
    done = subprocess.run(
        [tool_path(name), *map(str, arguments)], capture_output=True, text=True, timeout=300
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def test_what_is_spread_over_tracks_is_drawn_and_unpacked_as_from_one(tmp_path):
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
        options = ["--crop", "none", "--triangles", 3000, "--quality", 5, "--json"]
        video = json.loads(run("fvvmux", capture, "-o", stream, *options))["video"]
        cameras[rate] = [track["camera_ids"] for track in video] if isinstance(video, list) else None
        run("fvvinfo", "--check", stream)
        out = tmp_path / f"{rate}.png"
        run("fvvrender", stream, "--frame", 1, "--camera", 3, "-o", out, "--json")
        drawn[rate] = np.asarray(Image.open(out).convert("RGB"), float)
        run("fvvdemux", stream, "-o", tmp_path / rate)
        unpacked[rate] = [
            np.asarray(Image.open(tmp_path / rate / f"cam{k}" / "0001.png"), float) for k in range(4)
        ]
    assert cameras == {"25": None, "40000": [[0, 1], [2, 3]]}
    # What is left of each is the codec's.
    pairs = [(drawn["25"], drawn["40000"]), *zip(unpacked["25"], unpacked["40000"])]
    for one, spread in pairs:
        assert one.std() > 10
        assert np.sqrt(((one - spread) ** 2).mean()) < 4
