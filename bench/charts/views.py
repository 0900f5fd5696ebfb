"""How good a picture is from where a camera stands that is not in the stream.

The truth is filmed by fvvsynth --rig arc: identical cameras, a degree apart, on an arc between two cameras of the rig small. A
stream is drawn from there with fvvrender and compared in two ways, because the same pictures differ by many dB between them:

- inside: over the pixels of the true silhouette. Where the drawn mesh does not reach, the drawn picture is mid-grey.
- box: over the box around the true silhouette, grown by 8 pixels. Both pictures are mid-grey outside of their own silhouettes,
  so a mesh that is too large counts.

PSNR is of the mean squared error of BT.709 luma over all frames and views; SSIM is that of Wang et al. 2004, the mean over windows
whose centre is in the region. Flicker is the rms of what the drawn picture changes by from frame to frame minus what the truth
changes by, over pixels that are in both true silhouettes, in levels of 255.
"""

import copy
import json
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import view_quality
from PIL import Image
from real_capture import luma

from . import experiment

GREY = 128.0
MARGIN = 8
COLOUR = "--background", "128,128,128"


class Arc:
    """Views of a generated scene from the arc; views: degrees along it, 0 to count - 1."""

    def __init__(self, frames, views, seed=1, scene=None):
        self.frames, self.views = frames, tuple(views)
        options = ("--rig", "arc", "--cameras", max(views) + 1, "--frames", frames, "--seed", seed)
        self.folder = experiment.capture("arc", *options, *(("--scene", scene) if scene else ()))
        cameras = json.loads((self.folder / "capture.json").read_text())["cameras"]
        self.cameras = {view: cameras[view] for view in self.views}

    def only(self, view):
        """This arc with one of its views."""
        one = copy.copy(self)
        one.views = (view,)
        return one

    def truth(self, view, frame):
        """Luma and silhouette."""
        camera = self.cameras[view]
        mask = np.asarray(Image.open(self.folder / (camera["masks"] % frame)).convert("L")) > 128
        return luma(self.folder / (camera["pictures"] % frame)), mask

    def options(self, view):
        return view_quality.pose_of(self.cameras[view])

    def place(self, view):
        camera = self.cameras[view]
        return -np.reshape(camera["rotation"], (3, 3)).T @ camera["translation"]


def region_of(mask):
    """The box around a silhouette."""
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    box = np.zeros_like(mask)
    box[
        max(0, rows[0] - MARGIN) : rows[-1] + 1 + MARGIN,
        max(0, columns[0] - MARGIN) : columns[-1] + 1 + MARGIN,
    ] = True
    return box


class Sums:
    """Errors of several pictures, by region."""

    def __init__(self):
        self.squares, self.pixels, self.ssims = {}, {}, {}

    def add(self, region, truth, drawn, mask):
        self.squares[region] = self.squares.get(region, 0) + ((truth - drawn)[mask] ** 2).sum()
        self.pixels[region] = self.pixels.get(region, 0) + mask.sum()
        self.ssims.setdefault(region, []).append(view_quality.ssim(truth, drawn, mask))

    def figures(self):
        out = {}
        for region, squares in self.squares.items():
            mse = squares / self.pixels[region]
            out[f"psnr_{region}_db"] = 10 * math.log10(255**2 / max(mse, 1e-9))
            out[f"ssim_{region}"] = float(np.mean(self.ssims[region]))
        return out


def draw(stream, frame, view_options, out, *options):
    """Luma of a drawn picture, grey where nothing is."""
    experiment.run(
        "fvvrender",
        stream,
        "--frame",
        frame,
        *view_options,
        "--threads",
        1,
        *COLOUR,
        *options,
        "-o",
        out,
        "--force",
    )
    return luma(out)


def measure(stream, arc, *options, frames=None):
    """PSNR, SSIM and flicker of a stream's pictures from the views of an arc. frames: of the stream, default all."""
    numbers = list(range(arc.frames)) if frames is None else list(frames)
    key = (
        experiment.digest_of(experiment.program("fvvrender")),
        stream,
        arc.folder,
        arc.views,
        numbers,
        *options,
    )
    return experiment.kept("views", key, lambda: compared(stream, arc, options, numbers))


def compared(stream, arc, options, numbers):
    folder = experiment.WORK / "drawn" / experiment.short(stream, *options)
    folder.mkdir(parents=True, exist_ok=True)
    cells = [(view, frame) for view in arc.views for frame in numbers]

    def one(cell):
        view, frame = cell
        out = folder / f"{view}-{frame}.png"
        drawn = draw(stream, frame, arc.options(view), out, *options)
        out.unlink()
        return drawn

    with ThreadPoolExecutor(2) as pool:
        pictures = dict(zip(cells, pool.map(one, cells)))
    folder.rmdir()
    sums, changes, changed = Sums(), 0.0, 0
    for view in arc.views:
        before = None
        for frame in numbers:
            truth, mask = arc.truth(view, frame)
            drawn = pictures[view, frame]
            sums.add("inside", truth, drawn, mask)
            sums.add("box", np.where(mask, truth, GREY), drawn, region_of(mask))
            if before is not None and before[0] == frame - 1:
                both = mask & before[3]
                changes += (((drawn - before[2]) - (truth - before[1]))[both] ** 2).sum()
                changed += both.sum()
            before = frame, truth, drawn, mask
    return sums.figures() | ({"flicker": math.sqrt(changes / changed)} if changed else {})
