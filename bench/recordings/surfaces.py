#!/usr/bin/env python3
"""Refined surfaces of real sets beside their hulls: each camera drawn from all others, as bench/view_quality.py does.

That benchmark counts the pixels that the mesh covers, and a mesh that gives up its outlines gains by it. So there are three more
figures: the share of the silhouettes that is covered, PSNR of the pixels that all surfaces cover, and PSNR inside: 3 pixels and more from the
outline of the silhouette, where what is not covered counts as grey. Surfaces are refined by all pictures, that of the camera to be drawn too.

    python bench/recordings/surfaces.py

prints the table. "meshes" and a folder as arguments: writes the meshes there; the package fvv is on PYTHONPATH then.
"""

import functools
import json
import pathlib
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from PIL import Image, ImageFilter

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import view_quality  # noqa: E402

from recordings import hull as hulls  # noqa: E402

WORK = hulls.WORK / "surfaces"
KINDS = "hull", "refined"
INSIDE = 7  # pixels along the side of the square that is within a silhouette


def write_meshes(folder):
    """NAME-hull.ply and NAME-refined.ply of each set that is there."""
    from fvv_capture import hull, pipeline, refine_surface

    for name, data in (("wd2", "wd2_human20"), ("temple", "middlebury_temple")):
        if not (hulls.DATA / data).exists():
            continue
        box, options = None, {"cell": 0.125}
        if name == "wd2":
            cameras, masks = hulls.wd2_human20()
            paths = [hulls.DATA / f"wd2_human20/wd_data/WD2_{camera.id}_00020.png" for camera in cameras]
        else:
            cameras, masks, box = hulls.middlebury_temple()
            options = {"cell": 0.0008, "missed": 1, "min_share": 1}
            ring = hulls.DATA / "middlebury_temple/templeRing"
            paths = [ring / f"{pathlib.Path(camera.name).stem}.png" for camera in cameras]
        pictures = [np.asarray(Image.open(path).convert("RGB")) for path in paths]
        found = hull.carve(cameras, masks, box, hull.HullOptions(**options))
        refined = refine_surface.refine(found, cameras, pictures, masks)
        for kind, positions in zip(KINDS, (found.positions, refined)):
            pipeline.write_ply(str(folder / f"{name}-{kind}.ply"), positions, found.indices)


def drawn(stream, target):
    """Luma, and where the mesh is, of what a camera sees from all others."""
    out, mask = (WORK / f"{stream.stem}-{target}{end}.png" for end in ("", "-mask"))
    view_quality.tool(
        "fvvrender", stream, "-o", out, "--camera", target, "--leave-one-out", "--mask", mask, "--force"
    )
    return view_quality.luma(out), np.asarray(Image.open(mask)) > 128


def psnr(error, mask):
    return 10 * np.log10(255**2 / (error[mask] ** 2).mean())


def compared(streams, view, target):
    """(streams, 4): PSNR as in the benchmark, share of the silhouette, PSNR of what all cover, PSNR inside."""
    picture = view_quality.luma(view.picture)
    silhouette = Image.open(view.silhouette).convert("L")
    inner = np.asarray(silhouette.filter(ImageFilter.MinFilter(INSIDE))) > 128
    silhouette = np.asarray(silhouette) > 128
    pictures = [drawn(stream, target) for stream in streams]
    common = np.logical_and.reduce([silhouette, *(there for _, there in pictures)])
    rows = []
    for luma, there in pictures:
        error = np.where(there, luma, view_quality.GREY) - picture
        covered = silhouette & there
        rows.append(
            (psnr(error, covered), covered.sum() / silhouette.sum(), psnr(error, common), psnr(error, inner))
        )
    return rows


def surfaces():
    """Prints the table and returns the figures, of sets that are there."""
    WORK.mkdir(parents=True, exist_ok=True)
    view_quality.WORK = WORK
    hulls.child("meshes", WORK, program=__file__)
    figures = {}
    print(f"{'':16}{'PSNR dB':>9}{'covered':>9}{'common':>9}{'inside':>9}")
    for name in ("wd2", "temple"):
        made = view_quality.CAPTURES[name]()
        if not made:
            continue
        views, targets = made
        streams = [WORK / f"{name}.fvv"]
        for kind in KINDS:
            capture = WORK / name / "capture.json"
            description = json.loads(capture.read_text())
            description["meshes"]["pattern"] = str(WORK / f"{name}-{kind}.ply")
            other = capture.with_name(f"{kind}.json")
            other.write_text(json.dumps(description))
            streams.append(WORK / f"{name}-{kind}.fvv")
            view_quality.tool("fvvmux", other, "-o", streams[-1], *view_quality.JPEG)
        with ThreadPoolExecutor(2) as pool:
            seen = [views[target] for target in targets]
            cells = list(pool.map(functools.partial(compared, streams), seen, targets))
        for stream, row in zip(streams, np.mean(cells, 0)):
            print(f"{stream.stem:16}{row[0]:9.2f}{100 * row[1]:8.1f}%{row[2]:9.2f}{row[3]:9.2f}", flush=True)
        for kind, row in zip(KINDS, np.mean(cells, 0)[1:]):
            figures[f"{name}.{kind}_psnr_db"], figures[f"{name}.{kind}_inside_psnr_db"] = row[0], row[3]
    return figures


if __name__ == "__main__":
    if sys.argv[1:2] == ["meshes"]:
        write_meshes(pathlib.Path(sys.argv[2]))
        print("{}")
    else:
        surfaces()
