"""From films alone to a stream in one command: a board walk, the empty stage, and the action with a clap."""

import json
import subprocess
import sys

import fvv
import numpy
from conftest import tool
from fvv_capture.cameras import read_calibration

FRAMES = 16
CAMERAS = ("head0", "head1", "oval0", "oval1", "oval3", "oval5", "oval7")


def test_films_become_a_stream_in_one_command(tmp_path):
    shoot = tmp_path / "shoot"
    tool("fvvsynth", "--footage", "-o", shoot, "--size", "640x360", "--frames", FRAMES, "--poses", 40)
    for take in ("board", "plate", "performance"):
        for film in (shoot / take).iterdir():
            if film.stem not in CAMERAS:
                film.unlink()
    truth = json.loads((shoot / "truth/truth.json").read_text())
    board = truth["board"]
    command = [shoot / "performance", "--walk", shoot / "board", "--board", f"{board['columns']}x{board['rows']}", "--square",
               board["square"], "--marker", board["marker"], "--dictionary", board["dictionary"], "--plate",
               shoot / "plate", "--synchronise", "sound", "--frames", "8-", "--cell", "25mm", "--least-views", 4, "--json", "--mux", "scale=0.5", "-o", tmp_path / "players.fvv"]  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-m", "fvv_capture", *map(str, command)], capture_output=True, text=True, timeout=500
    )
    # 3: cameras whose board was near the middle alone are named.
    assert done.returncode in (0, 3), done.stderr
    report = json.loads(done.stdout)
    assert report["iou_mean"] > 0.8
    for name, offset in report["offsets"].items():
        # A clock that is late by less than a picture: to a millisecond, by the clap.
        assert abs(offset["seconds"] + truth["cameras"][name]["late"]) < 0.001
        assert offset["confidence"] > 0.3
    found = read_calibration(shoot / "truth/capture.json").cameras
    centres = {camera.name: camera.centre for camera in found}
    with fvv.open(tmp_path / "players.fvv") as clip:
        assert len(clip) >= FRAMES - 10
        cameras = [clip[0].cameras[i] for i in range(len(report["cameras"]))]
        assert len(cameras) == len(CAMERAS)
        # Distances between cameras are those of the truth.
        for a, b in zip(cameras, cameras[1:]):
            apart = numpy.linalg.norm(centres[a.name] - centres[b.name])
            assert abs(numpy.linalg.norm(a.centre - b.centre) / apart - 1) < 0.01
        low, high = clip[0].mesh.positions.min(axis=0), clip[0].mesh.positions.max(axis=0)
        assert 1.5 < (high - low).max() < 6
