#!/usr/bin/env python3
"""How good a stream is that fvvcapture makes of films alone, and what each stage costs: with the truth in place of one stage at a time.

fvvsynth --footage films a session: a board, the empty stage, and the action, by 11 cameras with noise, unlike exposure, lenses and
clocks. fvvcapture gets these films and the size of the board, and where a row says so the true calibration or the true silhouettes. A
twelfth camera, oval2, films nothing for it. fvvrender draws what that camera sees, and the picture is compared with its true one: PSNR
of BT.709 luma over the pixels of its true silhouette, squared errors pooled over the frames, and FLIP over the same pixels. What the mesh
does not cover counts as it is drawn, grey. Flicker is by how many levels the error of luma changes from one frame to the next, mean
absolute, over the pixels that are within the silhouettes of both. Clocks that agree are those of a session of its own (--late 0), which is alike in all else.

The world that fvvcapture finds has another origin and other axes than the true one. The similarity between them is found from the
centres of the 11 cameras (Umeyama, "Least-squares estimation of transformation parameters between two point patterns", 1991), and
the calibration of oval2 is brought into the world of fvvcapture.

    python bench/recordings/chain.py [rows]

prints the figures, or all rows as JSON (./run charts chain). Pictures are in build/bench/chain: of each frame the truth, and what was
drawn of each row; closeups.png has faces, hands and feet of all rows.
"""

from __future__ import annotations

import functools
import hashlib
import json
import os
import pathlib
import resource
import shutil
import subprocess
import sys
from typing import NamedTuple

import numpy as np
from PIL import Image

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from recordings.perceptual import flip  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = ROOT / "build/default"
WORK = ROOT / "build/bench/chain"
FRAMES = 8, 15  #: First and last; the clap and its flash are before.
#: Of the table of all rows, which takes as long again for each frame.
TABLE = 10, 11
#: Cells that fvvmux need not thin out for long.
HULL = "--cell", "12mm", "--up", "+y", "--floor", "0", "--least-views", "4"
HELD_OUT = 1000  #: A camera's id that no other has.
TRUE_HELD_OUT = 2  #: The same camera's in the truth.
UNSEEN = 128  #: Grey of what no camera shows, and of what is not covered.
#: Of the picture of the camera held out in one frame: the middles of crops. Faces, hands, feet, an arm before a body.
CLOSEUP_FRAME = 10
CLOSEUPS = (412, 262), (870, 235), (475, 320), (835, 395), (395, 525), (860, 547), (890, 325)
SIDE, MAGNIFIED = 80, 3
OFF = 0.02  #: Metres in depth beyond which a pixel shows another place.


class Row(NamedTuple):
    """What each stage is made of."""

    calibration: str  #: "true" or "found" from the board.
    clocks: str  #: "agree", or "real": up to 40 ms late, found by sound.
    silhouettes: str  #: "true" or "keyed"; "-" where the surface is the true one.
    surface: str  #: "true", "hull" or "refined".

    @property
    def name(self) -> str:
        return "-".join(self).replace("---", "-")


ROWS = (
    Row("true", "agree", "-", "true"),
    Row("true", "real", "-", "true"),
    Row("true", "agree", "true", "hull"),
    Row("true", "agree", "true", "refined"),
    Row("true", "real", "true", "hull"),
    Row("true", "real", "true", "refined"),
    Row("true", "real", "keyed", "hull"),
    Row("true", "real", "keyed", "refined"),
    Row("found", "real", "keyed", "hull"),
    Row("found", "real", "keyed", "refined"),
)


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


def colours(path: pathlib.Path) -> np.ndarray:
    return np.asarray(Image.open(path).convert("RGB"))


def luma(picture: np.ndarray) -> np.ndarray:
    return picture.astype(float) @ [0.2126, 0.7152, 0.0722]


def depths(path: pathlib.Path) -> np.ndarray:
    """Metres along the axis of the camera; infinite where nothing is."""
    sys.path[:0] = [str(ROOT / "tests/tools"), str(ROOT / "conformance")]
    from pictures import read_exr

    return read_exr(path)["Z"]


@functools.lru_cache(None)
def session(clocks: str) -> pathlib.Path:
    """The place of a session, by the program that films it."""
    program = hashlib.sha256((BUILD / "tools/fvvsynth/fvvsynth").read_bytes()).hexdigest()[:12]
    return WORK / f"shoot-{clocks}-{program}"


def shot(clocks: str) -> pathlib.Path:
    """The session that fvvsynth films, unless it is there."""
    folder = session(clocks)
    if not folder.exists():
        late = ("--late", 0) if clocks == "agree" else ()
        tool("fvvsynth", "--footage", "-o", folder, "--frames", FRAMES[1] + 3, *late)
    return folder


def masks(shoot: pathlib.Path) -> pathlib.Path:
    """The true masks of the cameras that film, without those of the camera held out beside its pictures."""
    folder = shoot / "masks"
    folder.mkdir(exist_ok=True)
    for film in (shoot / "performance").iterdir():
        if not (folder / film.stem).exists():
            (folder / film.stem).symlink_to(shoot / "truth" / film.stem)
    return folder


def processor_time() -> float:
    """Seconds of all programs that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def captured(row: Row, frames: tuple[int, int]) -> tuple[pathlib.Path, float, float]:
    """The capture of a row with the camera held out, the error of its cameras' centres in metres, and processor time
    of the whole command in seconds a frame."""
    shoot, folder = shot(row.clocks), WORK / row.name
    truth = shoot / "truth/capture.json"
    options = ["--surface", row.surface]
    before = WORK / row._replace(surface="hull").name / "capture.json"
    if row.calibration == "true":
        options += ["--calibration", truth]
    elif row.surface != "hull" and before.exists():
        options += ["--calibration", before]
    else:
        board = json.loads((shoot / "truth/truth.json").read_text())["board"]
        options += ["--walk", shoot / "board", "--board", f"{board['columns']}x{board['rows']}",
                    "--square", board["square"], "--marker", board["marker"], "--dictionary", board["dictionary"],
                    "--on-floor", 0]  # fmt: skip
    if row.silhouettes == "true":
        options += ["--masks", masks(shoot)]
    else:
        options += ["--plate", shoot / "plate"]
    if row.clocks == "real":
        options += ["--synchronise", "sound"]
    began = processor_time()
    fvvcapture(shoot / "performance", "--frames", f"{frames[0]}-{frames[1]}", *HULL, *options, "-o", folder)
    seconds = (processor_time() - began) / (frames[1] + 1 - frames[0])
    return *with_held_out(folder / "capture.json", truth), seconds


def drawn(row: Row, capture: pathlib.Path, camera: int, frames: tuple[int, int]) -> dict[str, float]:
    """Of what the camera held out sees: PSNR in dB, FLIP, flicker in levels; shares of the pixels that are not covered, and that are off in depth, and of the
    squared error in both."""
    stream, truth = WORK / f"{row.name}.fvv", shot(row.clocks) / "truth/oval2"
    tool("fvvmux", capture, "-o", stream, "--frames", f"{frames[0]}-{frames[1]}", "--match-colours", "on")
    grey = ",".join([str(UNSEEN)] * 3)
    errors, bare, off, unlike, changes = [], [], [], [], []
    last = None
    for frame in range(frames[0], frames[1] + 1):
        head = WORK / f"{row.name}-{frame:04d}"
        picture, depth = head.with_suffix(".png"), head.with_suffix(".exr")
        tool("fvvrender", stream, "-o", picture, "--frame", frame - frames[0], "--camera", camera, "--leave-one-out",
             "--background", grey, "--unseen", grey, "--no-environment", "--depth", depth, "--force")  # fmt: skip
        true = truth / f"{frame:04d}.png"
        shutil.copy(true, WORK / f"picture-{frame:04d}.png")
        inside = np.asarray(Image.open(true.with_name(f"mask_{frame:04d}.png"))) > 127
        pictures = colours(picture), colours(true)
        unlike.append(flip(*pictures, inside))
        error = luma(pictures[0]) - luma(pictures[1])
        if last is not None:
            changes.append(np.abs(error - last[0])[inside & last[1]])
        last = error, inside
        errors.append(error[inside] ** 2)
        there, right = (depths(path)[inside] for path in (depth, depth_of_truth(row.clocks, frame)))
        bare.append(~np.isfinite(there))
        both = np.isfinite(there) & np.isfinite(right)
        off.append(both & (np.abs(np.where(both, there, 0) - np.where(both, right, 0)) > OFF))
    squares, uncovered, wrong = (np.concatenate(parts) for parts in (errors, bare, off))
    return {
        "psnr_db": float(10 * np.log10(255**2 / squares.mean())),
        "flip": float(np.mean(unlike)),
        "flicker": float(np.concatenate(changes).mean()),
        "uncovered": float(uncovered.mean()),
        "uncovered_error": float(squares[uncovered].sum() / squares.sum()),
        "off": float(wrong.mean()),
        "off_error": float(squares[wrong].sum() / squares.sum()),
    }


def depth_of_truth(clocks: str, frame: int) -> pathlib.Path:
    """What was drawn from the true surface."""
    return WORK / f"{Row('true', clocks, '-', 'true').name}-{frame:04d}.exr"


def measured(row: Row, frames: tuple[int, int]) -> dict[str, float]:
    """What `drawn` has; of rows that fvvcapture made also centre_mm and seconds of processor time a frame. Rows of the true surface
    come first."""
    if row.surface == "true":
        return drawn(row, shot(row.clocks) / "truth/capture.json", TRUE_HELD_OUT, frames)
    capture, error, seconds = captured(row, frames)
    return {**drawn(row, capture, HELD_OUT, frames), "centre_mm": 1000 * error, "seconds": seconds}


def closeups(rows: tuple[Row, ...]) -> pathlib.Path:
    """A sheet with a column for each row, and the true picture last."""
    names = [f"{row.name}-{CLOSEUP_FRAME:04d}.png" for row in rows]
    large = SIDE * MAGNIFIED
    columns = [
        Image.open(WORK / name).convert("RGB") for name in (*names, f"picture-{CLOSEUP_FRAME:04d}.png")
    ]
    sheet = Image.new("RGB", (large * len(columns), large * len(CLOSEUPS)))
    for line, (x, y) in enumerate(CLOSEUPS):
        box = (x - SIDE // 2, y - SIDE // 2, x + SIDE // 2, y + SIDE // 2)
        for number, picture in enumerate(columns):
            crop = picture.crop(box).resize((large, large), Image.Resampling.BICUBIC)
            sheet.paste(crop, (number * large, line * large))
    path = WORK / "closeups.png"
    sheet.save(path)
    return path


def ablation(rows: tuple[Row, ...] = ROWS, frames: tuple[int, int] = TABLE) -> list[dict[str, object]]:
    """Rows with what was measured."""
    WORK.mkdir(parents=True, exist_ok=True)
    sessions = [session(clocks) for clocks in ("agree", "real")]
    for path in WORK.iterdir():
        if path.is_dir() and path not in sessions:
            shutil.rmtree(path)
        elif not path.is_dir():
            path.unlink()
    made = [{**row._asdict(), **measured(row, frames)} for row in rows]
    closeups(rows)
    return made


DEFAULT, BEST = (Row("found", "real", "keyed", surface) for surface in ("hull", "refined"))
TRUE = Row("true", "real", "-", "true")
MASKED, KEYED = (Row("true", "real", silhouettes, "refined") for silhouettes in ("true", "keyed"))


def figures(rows: list[dict[str, object]]) -> dict[str, float]:
    """PSNR of the camera held out in dB and its losses, FLIP, the error of the cameras' places in millimetres, and processor time."""
    by = {Row(*(row[field] for field in Row._fields)): row for row in rows}
    psnr = {row: one["psnr_db"] for row, one in by.items()}
    out = {
        "chain.held_out_psnr_db": psnr[DEFAULT],
        "chain.refined_psnr_db": psnr[BEST],
        "chain.held_out_psnr_loss_db": psnr[TRUE] - psnr[DEFAULT],
        "chain.keying_loss_db": psnr[MASKED] - psnr[KEYED],
        "chain.shape_loss_db": psnr[TRUE] - psnr[MASKED],
        "chain.held_out_flip": by[DEFAULT]["flip"],
        "chain.refined_flip": by[BEST]["flip"],
        "chain.centre_mm": by[DEFAULT]["centre_mm"],
        "surface.seconds_per_frame": by[BEST]["seconds"],
    }
    return {name: round(value, 3) for name, value in out.items()}


def chain() -> dict[str, float]:
    """The part "chain" of ./run bench: the rows that its figures are of."""
    return figures(ablation((TRUE, MASKED, KEYED, DEFAULT, BEST), FRAMES))


if __name__ == "__main__":
    if sys.argv[1:] == ["rows"]:
        print(json.dumps(ablation()))
    elif sys.argv[1:]:
        sys.exit(f"chain: expected rows or nothing, found {' '.join(sys.argv[1:])}")
    else:
        for figure, value in chain().items():
            print(f"{figure:32} {value:>12}")
