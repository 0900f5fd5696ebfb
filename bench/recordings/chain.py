#!/usr/bin/env python3
"""How good a stream is that fvvcapture makes of films alone, against one made of the truth.

fvvsynth --footage films a session: a board, the empty stage, and the action, by 11 cameras with noise, unlike exposure, lenses and
clocks. fvvcapture gets these films and the size of the board, nothing else. A twelfth camera, oval2, films nothing for it. fvvrender
draws what that camera sees, from the stream of fvvcapture and from one of the true meshes, masks and calibration with the same
films. Both are compared with its true picture: PSNR of BT.709 luma over the pixels of its true silhouette, squared errors pooled
over the frames. What the mesh does not cover counts as it is drawn, grey.

The world that fvvcapture finds has another origin and other axes than the true one. The similarity between them is found from the
centres of the 11 cameras (Umeyama, "Least-squares estimation of transformation parameters between two point patterns", 1991), and
the calibration of oval2 is brought into the world of fvvcapture.

    python bench/recordings/chain.py

prints the figures. Pictures are in build/bench/chain: of each frame the truth, and what was drawn from either stream.
"""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = ROOT / "build/default"
WORK = ROOT / "build/bench/chain"
SHOOT = WORK / "shoot"
FRAMES = 8, 15  #: First and last; the clap and its flash are before.
DRAWN = range(8, 16)
#: Cells that fvvmux need not thin out for long.
HULL = "--cell", "12mm", "--up", "+y", "--floor", "0", "--least-views", "4"
HELD_OUT = 1000  #: A camera's id that no other has.
UNSEEN = 128  #: Grey of what no camera shows, and of what is not covered.


def called(command: list[object], expected: tuple[int, ...] = (0, 3)) -> str:
    """Runs a program and returns its standard output; ends this run with its message when it fails. 3: done with warnings."""
    environment = {**os.environ, "PYTHONPATH": str(BUILD / "bindings/python")}
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, env=environment)
    if done.returncode not in expected:
        sys.exit(f"chain: {command[0]} failed ({done.returncode}): {done.stderr.strip()}")
    return done.stdout


def tool(name: str, *arguments: object) -> str:
    return called([BUILD / "tools" / name / name, *arguments])


def fvvcapture(*arguments: object) -> str:
    return called([sys.executable, "-m", "fvv_capture", *arguments])


def similarity(source: np.ndarray, target: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """scale, rotation (3, 3) and translation (3,), so that scale * rotation @ source + translation is nearest to target, both
    (points, 3): Umeyama 1991, equations 40 to 42."""
    means = source.mean(axis=0), target.mean(axis=0)
    a, b = source - means[0], target - means[1]
    u, values, vt = np.linalg.svd(b.T @ a / len(source))
    signs = np.array([1, 1, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    rotation = u @ np.diag(signs) @ vt
    scale = (values * signs).sum() / (a**2).sum(axis=1).mean()
    return scale, rotation, means[1] - scale * rotation @ means[0]


def centre(camera: dict) -> np.ndarray:
    return -np.array(camera["rotation"]).T @ camera["translation"]


def brought(camera: dict, scale: float, rotation: np.ndarray, translation: np.ndarray) -> dict:
    """A camera of the target's world in that of the source: the same picture of the same things."""
    turned = np.array(camera["rotation"]) @ rotation
    moved = (np.array(camera["rotation"]) @ translation + camera["translation"]) / scale
    u, _, vt = np.linalg.svd(turned)
    return {**camera, "rotation": (u @ vt).tolist(), "translation": moved.tolist()}


def with_held_out(estimated: pathlib.Path, truth: pathlib.Path) -> tuple[pathlib.Path, float]:
    """A capture beside `estimated` that has the camera held out too, and the rms distance of the cameras' centres from the true
    ones, metres."""
    found, true = (json.loads(path.read_text()) for path in (estimated, truth))
    name = json.loads((truth.parent / "truth.json").read_text())["held_out"]
    true_cameras = {camera["name"]: camera for camera in true["cameras"]}
    centres = np.array([centre(camera) for camera in found["cameras"]])
    true_centres = np.array([centre(true_cameras[camera["name"]]) for camera in found["cameras"]])
    scale, rotation, translation = similarity(centres, true_centres)
    errors = scale * centres @ rotation.T + translation - true_centres
    held_out = brought(true_cameras[name], scale, rotation, translation)
    folder = os.path.relpath(truth.parent, estimated.parent)
    for kind in ("pictures", "masks"):
        held_out[kind] = f"{folder}/{held_out[kind]}"
    held_out["id"] = HELD_OUT
    found["cameras"].append(held_out)
    path = estimated.with_name("held_out.json")
    path.write_text(json.dumps(found))
    return path, float(np.sqrt((errors**2).sum(axis=1).mean()))


def luma(path: pathlib.Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB")).astype(float) @ [0.2126, 0.7152, 0.0722]


def held_out_psnr(stream: pathlib.Path, camera: int, first: int) -> float:
    """dB. first: number of the stream's first frame."""
    errors = []
    for frame in DRAWN:
        drawn = stream.with_name(f"{stream.stem}-{frame:04d}.png")
        grey = ",".join([str(UNSEEN)] * 3)
        tool("fvvrender", stream, "-o", drawn, "--frame", frame - first, "--camera", camera, "--leave-one-out",
             "--background", grey, "--unseen", grey, "--no-environment", "--force")  # fmt: skip
        true = SHOOT / f"truth/oval2/{frame:04d}.png"
        shutil.copy(true, stream.with_name(f"picture-{frame:04d}.png"))
        inside = np.asarray(Image.open(true.with_name(f"mask_{frame:04d}.png"))) > 127
        errors.append((luma(drawn) - luma(true))[inside])
    return float(10 * np.log10(255**2 / (np.concatenate(errors) ** 2).mean()))


def chain() -> dict[str, float]:
    """The figures: PSNR of the camera held out in dB, its loss against the truth, and the error of the cameras' places in
    millimetres."""
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir(parents=True)
    tool("fvvsynth", "--footage", "-o", SHOOT, "--frames", FRAMES[1] + 3)
    truth = SHOOT / "truth/capture.json"
    board = json.loads((SHOOT / "truth/truth.json").read_text())["board"]
    captured = WORK / "captured"
    fvvcapture(SHOOT / "performance", "--walk", SHOOT / "board", "--board", f"{board['columns']}x{board['rows']}",
               "--square", board["square"], "--marker", board["marker"], "--dictionary", board["dictionary"], "--on-floor", 0,
               "--plate", SHOOT / "plate", "--synchronise", "sound", "--frames", f"{FRAMES[0]}-{FRAMES[1]}", *HULL,
               "-o", captured)  # fmt: skip
    estimated, error = with_held_out(captured / "capture.json", truth)
    psnr = {}
    for name, capture, camera in [("estimated", estimated, HELD_OUT), ("true", truth, 2)]:
        stream = WORK / f"{name}.fvv"
        tool("fvvmux", capture, "-o", stream, "--frames", f"{FRAMES[0]}-{FRAMES[1]}", "--match-colours", "on")
        psnr[name] = held_out_psnr(stream, camera, FRAMES[0])
    return {
        "chain.held_out_psnr_db": round(psnr["estimated"], 2),
        "chain.held_out_psnr_loss_db": round(psnr["true"] - psnr["estimated"], 2),
        "chain.centre_mm": round(1000 * error, 2),
    }


if __name__ == "__main__":
    for figure, value in chain().items():
        print(f"{figure:32} {value:>12}")
