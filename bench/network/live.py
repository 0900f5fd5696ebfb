"""fvvmux --realtime on the seed-shaped clip, whose frames arrive at its rate."""

import json
import shutil
import subprocess
import sys
import time

RATE = 25  # frames per second
FRAMES = 250  # the clip five times, under other numbers


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
