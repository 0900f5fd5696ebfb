"""Visual hulls: how well they fit the masks, how far they are from the true surface, and how long they take.

With "figures", or "cells" and sides of cells in metres, as its arguments it measures that and prints it as JSON: the package fvv
is on PYTHONPATH then.
"""

import json
import os
import pathlib
import resource
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BUILD = ROOT / "build/default"
WORK = ROOT / "build/bench"
DATA = pathlib.Path(os.environ.get("FVV_DATA", ROOT.parent / "shared/data"))
RUNS = 5
GROUND = ((0, 1, 0), 0.0)
# In front of single cameras of a rig of seven there are places that three others see at most.
CLIP = {"least_views": 4, "floor": GROUND, "min_share": 0.01}
CLIP_CELL = 0.02  # about 20,000 vertices
FINEST_CELL = 0.004  # a third of a pixel: what the masks determine
HD_CELL = 0.021  # about 17,000 vertices
HD_FRAMES = 8


def wd2_human20():
    """Cameras and masks of the real person."""
    import fvv
    import numpy
    from PIL import Image

    sys.path.append(str(ROOT / "tests/real"))
    import wd2_human20 as source

    folder = DATA / "wd2_human20"
    cameras, masks = [], []
    for camera in source.cameras(folder / source.CALIBRATION):
        matrix = camera["K"].copy()
        matrix[:2, 2] += 0.5
        pose = camera["Rt"]
        cameras.append(
            fvv.Camera(camera["id"], matrix, pose[:, :3], pose[:, 3], (1024, 768), camera["k"], "radtan")
        )
        mask = next((folder / "wd_segmented").glob(f"WD2_{camera['id']}_*"))
        masks.append(numpy.asarray(Image.open(mask).convert("L")) > 128)
    return cameras, masks


def temple_silhouette(picture):
    """The statue is brighter and warmer than the cloth under it; joints in shadow are closed."""
    import numpy
    from PIL import Image, ImageFilter

    red, _, blue = Image.open(picture).convert("RGB").filter(ImageFilter.GaussianBlur(1)).split()
    warm = 2 * numpy.asarray(red, int) - numpy.asarray(blue)
    bright = Image.fromarray((255 * (warm > 80)).astype(numpy.uint8))
    return numpy.asarray(bright.filter(ImageFilter.MaxFilter(7)).filter(ImageFilter.MinFilter(7))) > 0


def middlebury_temple():
    """Cameras and masks of the statue, and a box around it: that of the data's README with a margin."""
    import numpy
    from fvv_capture.cameras import read_calibration

    folder = DATA / "middlebury_temple/templeRing"
    cameras = read_calibration(folder / "templeR_par.txt", units="metres", size=(640, 480)).cameras
    masks = [temple_silhouette(folder / f"{pathlib.Path(camera.name).stem}.png") for camera in cameras]
    box = numpy.array([[-0.023121, -0.038009, -0.091940], [0.078626, 0.121636, -0.017395]])
    return cameras, masks, tuple(box + [[-0.004], [0.004]])


def generated(name, *options):
    """Cameras and masks of a frame of fvvsynth, and the path of its true mesh."""
    import numpy
    from fvv_capture.cameras import read_calibration
    from PIL import Image

    folder = WORK / name
    if not (folder / "capture.json").exists():
        tool = BUILD / "tools/fvvsynth/fvvsynth"
        subprocess.run([tool, "-o", folder, "--force", *options], check=True)
    cameras = read_calibration(folder).cameras
    masks = [numpy.asarray(Image.open(folder / camera.name / "mask_0000.png")) for camera in cameras]
    return cameras, masks, folder / "meshes/0000.ply"


def clip():
    return generated("hull-clip", "--rig", "small", "--frames", "1", "--size", "960x540")


def measured(cameras, masks, box, options, truth=None):
    """Figures of one hull: vertices, IoU over the cameras, and metres from its surface to the true one (rms)."""
    import fvv
    import numpy
    import trimesh
    from fvv_capture import hull

    found = hull.carve(cameras, masks, box, hull.HullOptions(**options))
    ious = hull.silhouette_iou(found.positions, found.indices, cameras, masks)
    out = {"vertices": len(found.positions), "iou_mean": float(numpy.mean(ious)), "iou_min": min(ious)}
    if truth is not None:
        true = trimesh.load(truth, process=False)
        distance = fvv.compare((found.positions, found.indices), (true.vertices, true.faces)).distance
        out["rms"] = distance.a_to_b.rms
    return out


def seconds(work):
    """The least wall and processor time of several runs."""
    best = float("inf"), float("inf")
    for _ in range(RUNS):
        before, begin = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
        work()
        wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_SELF)
        processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        best = min(best[0], wall), min(best[1], processor)
    return best


def keyed_and_carved():
    """Seconds of two processes for a frame of 14 HD cameras: keys against plates, and the hull of its masks. Reading and writing
    are not counted."""
    import tempfile

    import cv2

    name = "hull-hd-frames"
    generated(name, "--rig", "small", "--cameras", "14", "--size", "1920x1080", "--frames", str(HD_FRAMES))
    recordings, plates = WORK / f"{name}-recordings", WORK / f"{name}-plates"
    for camera in range(14):
        for folder in (recordings, plates):
            (folder / f"cam{camera}").mkdir(parents=True, exist_ok=True)
        for n in range(HD_FRAMES):
            link = recordings / f"cam{camera}/{n:04d}.png"
            if not link.exists():
                link.symlink_to(WORK / name / f"cam{camera}/{n:04d}.png")
        plate = plates / f"cam{camera}/0000.png"
        if not plate.exists():  # what the players cover is filled in
            picture, mask = (
                cv2.imread(str(WORK / name / f"cam{camera}" / f)) for f in ("0000.png", "mask_0000.png")
            )
            covered = cv2.dilate(mask[:, :, 0], None, iterations=3)
            cv2.imwrite(str(plate), cv2.inpaint(picture, covered, 3, cv2.INPAINT_TELEA))
    with tempfile.TemporaryDirectory() as out:
        command = [
            sys.executable,
            "-m",
            "fvv_capture",
            recordings,
            "--plate",
            plates,
            "--fps",
            "25",
            "--key",
            "difference",
        ]
        command += [
            "--calibration",
            WORK / name / "capture.json",
            "--cell",
            f"{HD_CELL}m",
            "--up",
            "+y",
            "--floor",
            "0",
        ]
        command += ["--jobs", "2", "--json", "-o", f"{out}/capture"]
        done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, text=True)
        if done.returncode not in (0, 3):
            sys.exit("bench: hull: fvvcapture failed")
    spent = json.loads(done.stdout)["seconds"]["of_frames"]
    return (spent["key"] + spent["carve"]) / 2 / HD_FRAMES


def figures():
    """What the part "hull" of ./run bench prints; without the figures of real sets that are not there."""
    from fvv_capture import hull

    out = {}
    if (DATA / "wd2_human20").exists():
        found = measured(*wd2_human20(), None, {"cell": 0.125})
        out |= {"hull.wd2_iou_mean": found["iou_mean"], "hull.wd2_iou_min": found["iou_min"]}
    else:
        print("bench: hull: wd2_human20 is not in FVV_DATA: left out", file=sys.stderr)
    if (DATA / "middlebury_temple").exists():
        found = measured(*middlebury_temple(), {"cell": 0.0008, "missed": 1, "min_share": 1})
        out["hull.temple_iou_mean"] = found["iou_mean"]
    else:
        print("bench: hull: middlebury_temple is not in FVV_DATA: left out", file=sys.stderr)
    cameras, masks, truth = clip()
    box = hull.bounds(cameras, masks, least_views=CLIP["least_views"], floor=GROUND)
    found = measured(cameras, masks, box, CLIP | {"cell": CLIP_CELL}, truth)
    out |= {"hull.clip_iou_mean": found["iou_mean"], "hull.clip_rms_mm": 1e3 * found["rms"]}
    finest = measured(cameras, masks, box, CLIP | {"cell": FINEST_CELL}, truth)
    out["hull.theoretical_rms_mm"] = 1e3 * finest["rms"]
    cameras, masks, _ = generated(
        "hull-hd", "--rig", "small", "--frames", "1", "--cameras", "14", "--size", "1920x1080"
    )
    box = hull.bounds(cameras, masks, floor=GROUND)
    options = hull.HullOptions(cell=HD_CELL, floor=GROUND)
    wall, processor = seconds(lambda: hull.carve(cameras, masks, box, options))
    out |= {"hull.carve_seconds_per_frame": wall, "hull.carve_processor_seconds": processor}
    out["hull.seconds_per_frame"] = keyed_and_carved()
    return out


def sweep(cells):
    """For each cell the figures of the generated clip and the time of its hull."""
    from fvv_capture import hull

    cameras, masks, truth = clip()
    box = hull.bounds(cameras, masks, least_views=CLIP["least_views"], floor=GROUND)

    def row(cell):
        options = CLIP | {"cell": cell}
        _, processor = seconds(lambda: hull.carve(cameras, masks, box, hull.HullOptions(**options)))
        smooth = measured(cameras, masks, box, options | {"smoothing": 5}, truth)
        return {"cell": cell, "processor_seconds": processor, "smooth": smooth} | measured(
            cameras, masks, box, options, truth
        )

    return [row(cell) for cell in cells]


def child(*arguments, program=__file__):
    """What this or another program prints with these arguments, in a process that has the package."""
    environment = os.environ | {"PYTHONPATH": str(BUILD / "bindings/python")}
    command = [sys.executable, program, *map(str, arguments)]
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"bench: hull: {arguments[0]} failed")
    return json.loads(done.stdout)


def hull():
    """Hulls of real and generated masks: fit, error and time."""
    return child("figures")


if __name__ == "__main__":
    what, *rest = sys.argv[1:]
    print(json.dumps(figures() if what == "figures" else sweep([float(cell) for cell in rest])))
