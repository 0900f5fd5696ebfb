"""What following surfaces saves, how exact and how steady it is; each figure beside that of key frames in the same run."""

import json
import os
import pathlib
import subprocess
import sys
import time

import mesh_only
import numpy as np
from PIL import Image

from track import surface

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "tests/real"))
from real_capture import luma, read_ply  # noqa: E402

DATA = pathlib.Path(os.environ.get("FVV_DATA", ROOT.parent / "shared/data"))
BUDGETS = "0.5mm", "1mm", "2mm"
# Published codecs are compared at a D2 of 70 dB; this reaches it.
COMPARED = "0.9mm"
RATE = 30  # frames a second of the captured player
PLACES = 0, 12, 24, 37, 49  # frames that are drawn


class Tracking:
    def __init__(self, tools, work, clip):
        """clip: fvvmux's arguments for the clip of the paper's shape, by quality in dB."""
        self.tools, self.work, self.clip = tools, work, clip

    def run(self, name, *arguments):
        """3: written, with a warning that names places beyond the budget."""
        done = subprocess.run(
            [self.tools / name / name, *map(str, arguments)], capture_output=True, text=True
        )
        if done.returncode not in (0, 3):
            sys.exit(f"bench: {name} failed ({done.returncode}): {done.stderr.strip()}")
        return done.stdout

    def mux(self, name, *arguments):
        """The summary of fvvmux, and seconds."""
        begin = time.perf_counter()
        done = self.run("fvvmux", *arguments, "-o", self.work / f"{name}.fvv", "--force", "--json")
        return json.loads(done), time.perf_counter() - begin

    def meshes(self, name, frames):
        folder = self.work / f"{name}-meshes"
        numbers = ",".join(map(str, frames))
        self.run(
            "fvvdemux",
            self.work / f"{name}.fvv",
            "-o",
            folder,
            "--frames",
            numbers,
            "--pictures",
            "none",
            "--force",
        )
        return [read_ply(path)[:2] for path in sorted((folder / "meshes").glob("*.ply"))]

    def player(self):
        """Ten frames of a captured basketball player, 21,000 vertices, 1.8 m high."""
        files = sorted(DATA.glob("tvm_basketball_player/*.obj"))
        if not files:
            print(f"track: no tvm_basketball_player under FVV_DATA={DATA}: its figures are left out")
            return {}
        sources = mesh_only.scaled(files, "y")
        capture = mesh_only.write_capture(self.work / "track-player", sources)
        figures = {}
        print(f"{'player':10}{'never':>10}{'auto':>10}{'always':>10}  Mbit/s")
        for budget in BUDGETS:
            rates = {}
            for how in "never", "auto", "always":
                found, _ = self.mux(f"track-player-{how}", capture, "--max-error", budget, "--track", how)
                rates[how] = found["mesh"]["bytes"] * 8e-6 * RATE / len(files)
            print(f"{budget:10}" + "".join(f"{rate:10.2f}" for rate in rates.values()), flush=True)
            figures[f"track.over_keys_{budget}"] = rates["auto"] / rates["never"]
        found, _ = self.mux("track-player", capture, "--max-error", COMPARED, "--track", "auto")
        decoded = self.meshes("track-player", range(len(files)))
        # Groups are tracked side by side: two for two cores.
        twice = mesh_only.write_capture(self.work / "track-player-twice", sources + sources)
        _, seconds = self.mux("track-player-twice", twice, "--max-error", "1mm", "--track", "auto", "--group", len(files), "--threads", 2)  # fmt: skip
        return figures | {
            "track.basketball_mbit_s": found["mesh"]["bytes"] * 8e-6 * RATE / len(files),
            "track.basketball_d2_db": min(map(surface.d2, sources, decoded)),
            "track.frames_per_s": 2 * len(files) / seconds,
        }

    def held_out(self, name, source):
        """Mean PSNR of luma over the silhouettes, of cameras that are drawn from the others."""
        values = []
        for camera in json.loads((source / "capture.json").read_text())["cameras"]:
            for frame in PLACES if camera["name"] in self.clip["cameras"] else ():
                out = self.work / "track-drawn.png"
                self.run("fvvrender", self.work / f"{name}.fvv", "-o", out, "--camera", camera["id"], "--frame", frame,
                         "--leave-one-out", "--size", "480x270", "--force")  # fmt: skip
                picture, mask = (Image.open(source / (camera[key] % frame)) for key in ("pictures", "masks"))
                picture.convert("RGB").resize((480, 270), Image.Resampling.BOX).save(
                    self.work / "track-true.png"
                )
                inside = np.asarray(mask.convert("L").resize((480, 270), Image.Resampling.BOX)) > 128
                error = (luma(out) - luma(self.work / "track-true.png"))[inside]
                values.append(10 * np.log10(255**2 / (error**2).mean()))
        return float(np.mean(values))

    def hulls(self):
        """The clip of the paper's shape with key frames and tracked, by outlines."""
        truth = self.work / "track-truth"
        if not (truth / "capture.json").exists():
            self.run("fvvsynth", "-o", truth, "--rig", "small", "--cameras", 1, "--size", "64x48", "--force")
        figures, flicker, psnr = {}, {}, {}
        print(f"{'clip':14}{'meshes':>10}{'visibility':>12}{'colours':>10}{'all':>12}{'keys':>8}")
        for how in "never", "auto":
            for quality in 42, 36:
                name = f"track-clip{quality}-{how}"
                found, _ = self.mux(name, *self.clip["arguments"](quality), "--track", how)
                parts = found["mesh"]["bytes"], found["visibility"]["bytes"], found["colours"]["bytes"]
                keys = found["mesh"]["key"]["frames"]
                print(
                    f"{f'{quality} dB {how}':14}{parts[0]:10}{parts[1]:12}{parts[2]:10}{found['bytes']:12}{keys:8}",
                    flush=True,
                )
                figures[f"track.clip{quality}_{how}_bytes"] = found["bytes"]
            figures[f"track.clip_{how}_mesh_bytes_per_frame"] = parts[0] / found["frames"]
            figures[f"track.clip_{how}_surface_bytes"] = sum(parts)
            psnr[how] = self.held_out(name.replace("36", "42"), self.clip["capture"])
            steady = surface.Flicker()
            true = [read_ply(path)[0] for path in sorted((truth / "meshes").glob("*.ply"))]
            for places, decoded in zip(true, self.meshes(name, range(found["frames"]))):
                steady.add(places, decoded)
            flicker[how] = steady.rms()
            figures[f"track.clip_{how}_psnr_db"] = psnr[how]
            figures[f"track.clip_{how}_flicker_mm"] = 1000 * flicker[how]
        figures["track.flicker_over_keys"] = flicker["auto"] / flicker["never"]
        return figures

    def measure(self):
        return self.player() | self.hulls()
