"""The likeness of the player's pictures to those of fvvrender, and of its visibility to rays (./run bench player).

Pictures are those of js/player/conformance/compare.mjs, from 20 places each: the generated capture, wd2_human20 and
pose2sim_4cam where FVV_DATA has them. The last has no mesh, so a solid is put where its person is: it tests lenses
and real video, not the look of a person. Visibility is that of the generated capture at three sizes.
"""

import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

import view_quality

ROOT = pathlib.Path(__file__).resolve().parent.parent
TOOLS = ROOT / "build/default/tools"
WORK = ROOT / "build/bench/player"
DATA = view_quality.DATA
SCENE_METRES = 4  # of the generated action, along its longest side
SCALES = (0.1, 1, 100)


def run(*command, **variables):
    """variables: of the environment."""
    environment = {**os.environ, "FVV_BUILD": str(ROOT / "build/default"), **variables}
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, env=environment)
    # 3: done with a warning, which shows in the next step.
    if done.returncode not in (0, 3):
        sys.exit(f"bench: {command[0]} failed ({done.returncode}): {done.stderr.strip()}")
    return done.stdout


def mux(capture, name, *options):
    stream = WORK / f"{name}.fvv"
    run(TOOLS / "fvvmux/fvvmux", capture, "-o", stream, "--force", *options)
    return stream


def generated():
    """The capture, and copies of it scaled to a length in metres."""
    folder = WORK / "studio"
    if not (folder / "capture.json").exists():
        run(TOOLS / "fvvsynth/fvvsynth", "-o", folder, "--frames", "1", "--force")
    description = json.loads((folder / "capture.json").read_text())
    scaled = []
    for metres in SCALES:
        path = folder / f"capture{metres}.json"
        path.write_text(json.dumps({**description, "units": metres / SCENE_METRES}))
        scaled.append(mux(path, f"studio{metres}", "--visibility", "weight"))
    return mux(folder, "studio", "--visibility", "weight"), scaled


def solid(centre, size, path):
    """A wavy egg, which hides parts of itself; z is up."""
    columns, rows = 48, 24
    corners, faces = [], []
    for j in range(rows + 1):
        polar = math.pi * j / rows
        for i in range(columns):
            turn = 2 * math.pi * i / columns
            out = math.sin(polar) * (
                1 + 0.15 * math.sin(5 * turn) * math.sin(polar) + 0.1 * math.sin(7 * polar)
            )
            place = (out * math.cos(turn), out * math.sin(turn), math.cos(polar))
            corners.append([c + s * p for c, s, p in zip(centre, size, place)])
    for j in range(rows):
        for i in range(columns):
            a, b = j * columns + i, j * columns + (i + 1) % columns
            faces += [(a, a + columns, b)] * (j > 0) + [(b, a + columns, b + columns)] * (j < rows - 1)
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n")


def pose2sim():
    root = DATA / "pose2sim_4cam/Demo_SinglePerson"
    folder = WORK / "pose2sim"
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "capture.json"
    run(TOOLS / "fvvimport/fvvimport", "qualisys", root / "calibration/Calib.qca.txt", "-o", path, "--force",
        "--up", "+z", "--frame-rate", "60", "--frames", "0-0", "--videos", f"{root}/videos/{{name}}.mp4")  # fmt: skip
    description = json.loads(path.read_text())
    for camera in description["cameras"][:2]:
        # Two videos lack the last 8 of the 1088 columns that were calibrated.
        camera["width"] = 1080
    description["meshes"] = {"pattern": "solid_%d.obj"}
    solid((-0.94, -0.02, 0.9), (0.45, 0.45, 0.9), folder / "solid_0.obj")
    path.write_text(json.dumps(description))
    return mux(path, "pose2sim", "--scale", "0.5", "--keep-geometry", "--crop", "none", "--tile-fill", "keep",
               "--visibility", "weight")  # fmt: skip


def real():
    streams = []
    source = view_quality.wd2_capture()
    if source:
        streams.append(mux(source, "wd2", "--visibility", "weight", *view_quality.WINDING))
    if (DATA / "pose2sim_4cam").exists():
        streams.append(pose2sim())
    else:
        print(f"player: without pose2sim_4cam, which is not under FVV_DATA={os.path.relpath(DATA)}")
    return streams


def has_firefox():
    """Whether the browser can be opened as in js/testing/browser.mjs; prints a line when not."""
    for program in os.environ.get("FVV_FIREFOX", "firefox-esr"), "Xvfb":
        if not shutil.which(program):
            print(f"player.firefox_* is left out: no {program} here")
            return False
    return True


def compare(streams, *options, **variables):
    """variables: of the environment."""
    script = ROOT / "js/player/conformance/compare.mjs"
    lines = json.loads(run("node", script, *streams, "--json", *options, **variables))
    for line in lines:
        rays = line["agreementPercent"]
        print(
            f"{line['file']:16} by {line['visibleBy']:6} {line['minPsnr']:6.1f} dB at least, "
            f"{line['minForegroundPsnr']:5.1f} with outlines, {line['largePercent']:.2f} % off by more than 8"
            + (f", {rays:.2f} % as rays" if rays else ""),
            flush=True,
        )
    return lines


def measure():
    """Prints a line for each stream and way and returns the figures for bench.py."""
    if not shutil.which("node") or not shutil.which(os.environ.get("FVV_CHROMIUM", "chromium")):
        print("player.* is left out: no node or no Chromium here")
        return {}
    WORK.mkdir(parents=True, exist_ok=True)
    stream, scaled = generated()
    streams = [stream, *real()]
    pictures = compare(streams)
    seen = compare(scaled, "--poses", "6", "--rays", "--size", "640x360")
    agreement = {
        way: min(line["agreementPercent"] for line in seen if line["visibleBy"] == way)
        for way in ("depth", "bits")
    }
    figures = {}
    if has_firefox():
        print("in Firefox:")
        lines = compare(streams, "--browser", "firefox")
        figures["player.firefox_min_psnr_db"] = min(line["minPsnr"] for line in lines)
    return figures | {
        "player.min_psnr_db": min(line["minPsnr"] for line in pictures),
        "player.min_foreground_psnr_db": min(line["minForegroundPsnr"] for line in pictures),
        "player.off_by_8_percent": max(line["largePercent"] for line in pictures),
        "player.visibility_agreement_percent": agreement["depth"],
        "player.bits_agreement_percent": agreement["bits"],
    }
