"""How fine a visual hull is worth carving: fit to the masks, distance to the true surface, and time.

One frame of the generated scene, seven cameras of 960x540. The hull that the masks determine is larger than the scene: no cell
takes the hull's own excess away, which is where all curves of distance end.
"""

from recordings import hull as recordings

from . import drawing, experiment

CELLS = 0.08, 0.06, 0.04, 0.03, 0.02, 0.015, 0.01, 0.0075, 0.005
VERTICES = 17000  # of a hull of the seed paper


def measure(quick):
    if quick:
        return None
    return {"rows": recordings.child("cells", *CELLS), "cameras": 7}


def draw(results, folder):
    figure, (fit, off, time) = drawing.sheet(3, 1, 3.7, 3.3)
    rows = results["rows"]
    cells = [1e3 * row["cell"] for row in rows]
    for number, (name, of) in enumerate(
        (("as carved", lambda r: r), ("5 rounds of smoothing", lambda r: r["smooth"]))
    ):
        drawing.line(fit, number, cells, [100 * of(row)["iou_mean"] for row in rows], name)
        drawing.line(off, number, cells, [1e3 * of(row)["rms"] for row in rows], name)
    drawing.line(time, 0, cells, [row["processor_seconds"] for row in rows])
    fit.set_title("Fit to the masks")
    fit.set_ylabel("IoU, %, mean of the cameras")
    off.set_title("Distance to the true surface")
    off.set_ylabel("mm, rms over the hull")
    off.set_ylim(bottom=0)
    time.set_title("Time of a frame")
    time.set_ylabel("seconds of processor time")
    drawing.logarithmic(time, "y")
    fit.legend(loc="lower left")
    off.legend(loc="lower right")
    for axis in (fit, off, time):
        drawing.logarithmic(axis, "x", (5, 10, 20, 40, 80))
        axis.set_xlabel("side of a cell, mm")
    drawing.save(figure, folder / "hull.svg")


def nearest_to_paper(results):
    return min(results["rows"], key=lambda row: abs(row["vertices"] - VERTICES))


def text(results):
    paper, finest = nearest_to_paper(results), results["rows"][-1]
    header = "| cell | vertices | IoU, mean | IoU, least | rms to the truth | smoothed: IoU, rms | processor seconds |\n|---|---|---|---|---|---|---|"
    lines = [
        f"| {1e3 * r['cell']:g} mm | {r['vertices']:,} | {100 * r['iou_mean']:.2f} % | {100 * r['iou_min']:.2f} % | "
        f"{1e3 * r['rms']:.1f} mm | {100 * r['smooth']['iou_mean']:.2f} %, {1e3 * r['smooth']['rms']:.1f} mm | {r['processor_seconds']:.2f} |"
        for r in results["rows"]
    ]
    return f"""![Fit, distance and time over the side of cells](hull.svg)

**Cells of {1e3 * paper['cell']:g} mm ({paper['vertices']:,} vertices) fit the masks to {100 * paper['iou_mean']:.1f} %, and finer ones come no nearer to the true surface: {1e3 * paper['rms']:.1f} mm from it, against {1e3 * finest['rms']:.1f} mm with cells of {1e3 * finest['cell']:g} mm.**
What is left is the hull's own excess: no silhouette shows what is inside the outlines of all {results['cameras']} cameras. The distance is measured from the hull alone:
coarse hulls are smaller and lose thin parts, which the figure does not count and the fit to the masks does. Time grows with the
surface, not with the volume, because values are computed near the surface alone ([fvvcapture-hull.md](../../tools/fvvcapture-hull.md)).

{chr(10).join([header, *lines])}"""


EXPERIMENTS = (experiment.Experiment("hull", "Resolution of visual hulls", measure, draw, text),)
