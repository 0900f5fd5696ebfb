"""fvvmux --realtime on the seed-shaped clip, whose frames arrive at its rate; fvvcapture live on films that play at theirs."""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time

RATE = 25  # frames per second
FRAMES = 250  # the clip five times, under other numbers
CAMERAS = 7
BOX = "-2.5,-0.1,-2,2.5,2.2,2"  # metres: where the game of the footage is


def measure(build, source, work):
    """source: capture.json of stills and meshes that are numbered from 0.

    delay_p95_ms: from the arrival of a frame to the last byte of its group. lost_frames: that were dropped or lost.
    """
    description = json.loads(source.read_text())
    count = description["frames"]["count"]
    patterns = [description["meshes"]["pattern"]]
    patterns += [camera[kind] for camera in description["cameras"] for kind in ("pictures", "masks")]
    folder = work / "live"
    shutil.rmtree(folder, ignore_errors=True)
    for pattern in patterns:
        (folder / pattern).parent.mkdir(parents=True, exist_ok=True)
    description["frames"]["count"] = FRAMES
    (folder / "capture.json").write_text(json.dumps(description))
    command = [
        build / "tools/fvvmux/fvvmux",
        "--realtime",
        folder,
        "-o",
        work / "live.fvv",
        "--force",
        "--json",
    ]
    child = subprocess.Popen(
        [str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    begin = time.perf_counter()
    for frame in range(FRAMES):
        time.sleep(max(0.0, begin + frame / RATE - time.perf_counter()))
        for pattern in patterns:  # as a link it is whole at once, and costs the writer nothing
            (folder / (pattern % frame)).symlink_to((source.parent / (pattern % (frame % count))).resolve())
    out, _ = child.communicate(timeout=600)
    seconds = time.perf_counter() - begin
    if child.returncode not in (0, 3):
        sys.exit("bench: fvvmux --realtime failed")
    summary = json.loads(out)
    found = summary["realtime"]
    return {
        "live.frames_per_s": summary["frames"] / seconds,
        "live.delay_p95_ms": 1000 * found["delay_p95"],
        "live.first_delay_ms": 1000 * found["first_delay"],
        "live.lost_frames": found["lost_frames"] + found["dropped_frames"],
        "live.effort_changes": len(found["effort"]),
    }


def measure_cameras(build, tool, work, seconds=30, rate="12.5"):
    """Seven cameras of 480x270 that film 25 pictures a second, by the films of fvvsynth --footage, again and again.

    capture_frames_per_s: hulls in the stream. capture_delay_p95_ms: from light to the last byte of a group. capture_cells: of the
    hull, relative to 30 mm.
    """
    shoot = work / "live_shoot"
    if not shoot.exists():
        tool("fvvsynth", "--footage", "--size", "480x270", "--frames", "100", "--poses", "4", "-o", shoot)
    described = json.loads((shoot / "truth/capture.json").read_text())["cameras"]
    names = [camera["name"] for camera in described if (camera["width"], camera["height"]) == (480, 270)]
    films = [shoot / f"performance/{name}.mp4" for name in names]
    lines = [f"{film.stem} {film} loop=1" for film in films if film.exists()][:CAMERAS]
    (work / "live_cameras.txt").write_text("\n".join(lines))
    command = [
        sys.executable,
        "-m",
        "fvv_capture",
        "live",
        work / "live_cameras.txt",
        "--json",
        "--fps",
        rate,
    ]
    command += ["--calibration", shoot / "truth/capture.json", "--plate", shoot / "plate", f"--bounds={BOX}"]
    command += ["--cell", "30mm", "-o", "-"]
    child = subprocess.Popen(
        [str(part) for part in command],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": str(build / "bindings/python")},
    )
    timer = threading.Timer(seconds, child.send_signal, [signal.SIGINT])
    timer.start()
    lines = list(child.stderr)
    if child.wait(60) not in (0, 3):
        sys.exit(f"bench: fvvcapture live failed: {lines[-1]}")
    summary = json.loads("".join(line for line in lines if not line.startswith('{"event"')))
    times = summary["mux"]["realtime"]
    return {
        "live.capture_frames_per_s": summary["hulls_per_second"]
        * summary["mux"]["frames"]
        / summary["hulls"],
        "live.capture_delay_p95_ms": 1000 * times["delay_p95"],
        "live.capture_hull_p95_ms": 1000 * summary["hull_delay_p95"],
        "live.capture_lost_frames": times["lost_frames"] + times["dropped_frames"],
        "live.capture_cells": summary["largest_cells"],
    }
