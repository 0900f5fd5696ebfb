"""How many cameras, which of them, and how they are mixed: held-out views of a rig of ten cameras."""

import json

import numpy as np

from . import drawing, experiment, views

FRAMES = 2
RIG = 10
VIEWS = 0, 15, 30
BEST = 1, 2, 3, 4, 5, 6, 8
NEAREST = 1, 2, 3, 4, 6, 8, 10
THRESHOLDS = 0.0, 0.05, 0.1, 0.15, 0.25, 0.35, 0.45, 0.6
RANKINGS = {"viewer": "by the viewer's direction", "paper": "by the normal, as WHP 235"}
LOSS = 0.1  # dB, that a default may lose against the best
DEFAULT_BEST = 3
DEFAULT_THRESHOLD = {"viewer": 0.05, "paper": 0.25}
MESHES = "tracked", "hull"


def nearest(source, arc, view, count):
    """Identifiers of the cameras whose direction from the middle of the scene is nearest to the view's."""
    cameras = json.loads((source / "capture.json").read_text())["cameras"]
    middle = np.array([0, 0.95, 0])

    def direction(place):
        ray = place - middle
        return ray / np.linalg.norm(ray)

    def place(camera):
        return -np.reshape(camera["rotation"], (3, 3)).T @ camera["translation"]

    wanted = direction(arc.place(view))
    order = sorted(cameras, key=lambda c: -(direction(place(c)) @ wanted))
    return sorted(c["id"] for c in order[:count])


def with_sources(stream, source, arc, count):
    """Each view from its own nearest cameras; figures are means over the views."""
    found = []
    for view in arc.views:
        ids = ",".join(map(str, nearest(source, arc, view, count)))
        found.append(views.measure(stream, arc.only(view), "--sources", ids, "--visible-by", "depth"))
    return {name: float(np.mean([f[name] for f in found])) for name in found[0]}


def measure(quick):
    if quick:
        return None
    arc = views.Arc(FRAMES, VIEWS)
    out = {"frames": FRAMES, "views_degrees": VIEWS, "cameras": RIG, "meshes": {}}
    for meshes in MESHES:
        source = experiment.capture(
            f"ten-{meshes}", "--rig", "small", "--cameras", RIG, "--meshes", meshes, "--frames", FRAMES
        )
        stream = experiment.packed(source).path
        found = {"best": {}, "threshold": {}}
        for ranking in RANKINGS:
            common = "--blend", ranking, "--visible-by", "depth"
            limit = "--threshold", DEFAULT_THRESHOLD[ranking]
            found["best"][ranking] = [
                {"best": n, **views.measure(stream, arc, *common, *limit, "--best", n)} for n in BEST
            ]
            found["threshold"][ranking] = [
                {
                    "threshold": t,
                    **views.measure(stream, arc, *common, "--best", DEFAULT_BEST, "--threshold", t),
                }
                for t in THRESHOLDS
            ]
        found["sources"] = [{"sources": n, **with_sources(stream, source, arc, n)} for n in NEAREST]
        out["meshes"][meshes] = found
    return out


def draw(results, folder):
    figure, panels = drawing.sheet(3, 1, 3.7, 3.4)
    looks = {"tracked": "-", "hull": "--"}
    for meshes, found in results["meshes"].items():
        for number, ranking in enumerate(RANKINGS):
            for axis, what in (panels[0], "best"), (panels[1], "threshold"):
                rows = found[what][ranking]
                drawing.line(axis, number, [r[what] for r in rows], [r["psnr_inside_db"] for r in rows],
                             f"{meshes}, {'viewer' if ranking == 'viewer' else 'normal'}", linestyle=looks[meshes])  # fmt: skip
        rows = found["sources"]
        drawing.line(
            panels[2],
            2,
            [r["sources"] for r in rows],
            [r["psnr_inside_db"] for r in rows],
            meshes,
            linestyle=looks[meshes],
        )
    panels[0].set_title("Cameras mixed at a place")
    panels[0].set_xlabel("--best")
    drawing.mark(panels[0], DEFAULT_BEST, "default\nand WHP 235", 0.3)
    panels[1].set_title("Least cosine to a camera")
    panels[1].set_xlabel("--threshold")
    drawing.mark(panels[1], DEFAULT_THRESHOLD["viewer"], "default", 0.2)
    drawing.mark(panels[1], DEFAULT_THRESHOLD["paper"], "WHP 235", 0.2)
    panels[2].set_title(f"Cameras that a view uses, of {results['cameras']}")
    panels[2].set_xlabel("nearest cameras")
    for axis in panels:
        axis.set_ylabel("PSNR of a held-out view, inside, dB")
        low, high = axis.get_ylim()
        axis.set_ylim(low - 0.35 * (high - low), high)
        axis.legend(loc="lower right", fontsize=7, ncols=2)
    drawing.save(figure, folder / "cameras.svg")


def at(rows, what, value):
    return next(r for r in rows if r[what] == value)["psnr_inside_db"]


def gains(results):
    """What the defaults lose against the best of each row, in dB."""
    out = {}
    for meshes, found in results["meshes"].items():
        best, threshold = found["best"]["viewer"], found["threshold"]["viewer"]
        out[meshes] = {
            "best": max(r["psnr_inside_db"] for r in best) - at(best, "best", DEFAULT_BEST),
            "best_at": max(best, key=lambda r: r["psnr_inside_db"])["best"],
            "one": at(best, "best", DEFAULT_BEST) - at(best, "best", 1),
            "threshold": max(r["psnr_inside_db"] for r in threshold)
            - at(threshold, "threshold", DEFAULT_THRESHOLD["viewer"]),
            "threshold_at": max(threshold, key=lambda r: r["psnr_inside_db"])["threshold"],
            "ranking": at(best, "best", DEFAULT_BEST) - at(found["best"]["paper"], "best", DEFAULT_BEST),
            "sources_at": max(found["sources"], key=lambda r: r["psnr_inside_db"])["sources"],
            "sources": at(found["sources"], "sources", RIG) - at(found["sources"], "sources", 3),
        }
    return out


def text(results):
    found = gains(results)

    def each(form):
        return " and ".join(f"{form.format(**g)} ({m})" for m, g in found.items())

    return f"""![PSNR of held-out views over the number of cameras and the threshold](cameras.svg)

**Three cameras at a place are enough: more would give at most {max(g['best'] for g in found.values()):.2f} dB, a single one loses {each('{one:.2f} dB')}.** WHP 235
says three as well. Ranking cameras by the viewer's direction instead of by the surface's normal changes PSNR by {each('{ranking:+.2f} dB')}, with three cameras
and the threshold of each rule (WHP 235: a cosine of 0.25, by the normal). The viewer's direction is for meshes that are wrong, as hulls are: there cameras
near the viewer err least.

The default threshold of {DEFAULT_THRESHOLD['viewer']:g} loses {each('{threshold:.2f} dB against {threshold_at:g}')}. Of the {results['cameras']} cameras of the
rig a view needs its nearest ones: most PSNR has the view from {each('{sources_at} cameras')}; all {results['cameras']} instead of the nearest three change it by
{each('{sources:+.2f} dB')}.

Input: `fvvsynth --rig small --cameras {results['cameras']}`, {results['frames']} frames, default stream; {len(results['views_degrees'])} views from between two cameras,
drawn with depth maps, so that the visibility weights of the stream, which are found for its own threshold, do not count. PSNR inside the true
silhouette; a place that no camera shows has the stream's colours of vertices."""


def defaults(results):
    found = gains(results)
    ranking = [g["ranking"] for g in found.values()]
    return [
        (
            "fvvmux --texture-best",
            DEFAULT_BEST,
            "; ".join(
                f"{m}: the best ({g['best_at']}) is {g['best']:.2f} dB better" for m, g in found.items()
            ),
            all(g["best"] <= LOSS for g in found.values()),
        ),
        (
            "fvvmux --texture-threshold",
            DEFAULT_THRESHOLD["viewer"],
            "; ".join(
                f"{m}: the best ({g['threshold_at']:g}) is {g['threshold']:.2f} dB better"
                for m, g in found.items()
            ),
            all(g["threshold"] <= LOSS for g in found.values()),
        ),
        (
            "fvvmux --texture-blend",
            "viewer",
            "; ".join(f"{m}: {g['ranking']:+.2f} dB against the normal" for m, g in found.items())
            + f": it loses at most {-min(ranking):.2f} dB, the normal {max(ranking):.2f} dB",
            -min(ranking) < max(ranking),  # a stream is of either kind
        ),
    ]


EXPERIMENTS = (
    experiment.Experiment(
        "cameras", "Cameras: how many, which, and how mixed", measure, draw, text, defaults=defaults
    ),
)
