"""The whole stream: bytes against a view that no camera filmed, over the error budget and over the quality of pictures.

`system` varies --max-error and looks for the knee; `size` varies the quality, beside the encoding of WHP 235, which is packed here
with its own methods and drawn by its own rule of texturing.
"""

import io
import json

import whp235
from PIL import Image

from . import drawing, experiment, numbers, views

FRAMES, QUICK_FRAMES = 12, 4
VIEWS = 0, 15, 30
BUDGETS = 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0
DEFAULT = 0.15
MESHES = {"tracked": "tracked: exact", "hull": "visual hull of 7 cameras"}
TITLES = {"hull": "Visual hulls of the 7 cameras", "tracked": "Exact meshes, tracked"}
QUALITIES = 27, 30, 33, 36, 39, 42, 45
DEFAULT_QUALITY = 42
CODECS = "h264", "jpeg"
LOSS = 0.1  # dB that the knee may lose
PAPER_THRESHOLD, PAPER_BEST = 0.25, 3
PAPER = {"bytes": 27.3e6 / 50, "picture_bytes": 14.4e6 / 50}  # WHP 235, section 5: 27.3 Mbyte for 50 frames


def clip(meshes, frames=FRAMES):
    """The generated clip: 7 alike cameras at 480x270."""
    return experiment.capture(f"small-{meshes}", "--rig", "small", "--meshes", meshes, "--frames", frames)


def budget_row(source, arc, *options):
    made = experiment.packed(source, "--quality", "42dB", *options)
    budget = made.summary["budget"]
    row = experiment.parts(made.summary) | views.measure(made.path, arc)
    row |= {"triangles": budget.get("triangles"), "step_mm": 1000 * made.summary["lattice"]["step"]}
    return row | {"rms_mm": 1000 * (budget.get("rms") or 0)}


def budgets(quick):
    if quick:
        return quick_budgets()
    arc = views.Arc(FRAMES, VIEWS)
    out = {"frames": FRAMES, "views_degrees": VIEWS, "meshes": {}}
    for meshes in MESHES:
        source = clip(meshes)
        rows = [{"max_error": e, **budget_row(source, arc, "--max-error", e)} for e in BUDGETS]
        kept = budget_row(source, arc, "--keep-geometry", "--step", "0.1mm")
        found = {"rows": rows, "kept": kept}
        for region in "inside", "box":
            found[f"knee_{region}"] = numbers.knee(rows, "all_bytes", f"psnr_{region}_db", LOSS)["max_error"]
        found["knee_flicker"] = min(
            (r for r in rows if r["flicker"] <= 1.02 * min(s["flicker"] for s in rows)),
            key=lambda r: r["all_bytes"],
        )["max_error"]
        out["meshes"][meshes] = found
    return out


def quick_budgets():
    """The defaults of fvvmux, a view from between two cameras."""
    arc = views.Arc(QUICK_FRAMES, VIEWS[1:2])
    out = {}
    for meshes in MESHES:
        made = experiment.packed(clip(meshes, QUICK_FRAMES))
        out[meshes] = experiment.parts(made.summary) | views.measure(made.path, arc)
    return out


def quick_headlines(results):
    out = {}
    for meshes, row in results.items():
        out[f"{meshes}_bytes_per_frame"] = row["all_bytes"]
        out[f"{meshes}_held_out_mse"] = 255**2 / 10 ** (row["psnr_inside_db"] / 10)
        out[f"{meshes}_flicker"] = row["flicker"]
    return out


def draw_budgets(results, folder):
    figure, panels = drawing.sheet(3, 1, 3.7, 3.4)
    for number, (meshes, found) in enumerate(results["meshes"].items()):
        rows = found["rows"]
        errors = [r["max_error"] for r in rows]
        for region, look in ("inside", "-"), ("box", "--"):
            best = max(r[f"psnr_{region}_db"] for r in rows)
            drawing.line(panels[0], number, errors, [r[f"psnr_{region}_db"] - best for r in rows],
                         f"{meshes}, {region} (best {best:.1f} dB)", linestyle=look)  # fmt: skip
        for part, look in ("all", "-"), ("meshes", "--"):
            kilobytes = [r[f"{part}_bytes"] / 1000 for r in rows]
            drawing.line(panels[1], number, errors, kilobytes, f"{meshes}, {part}", linestyle=look)
        drawing.line(panels[2], number, errors, [r["flicker"] for r in rows], meshes)
    panels[0].set_title("Loss in a view that no camera filmed")
    panels[0].set_ylabel("PSNR, dB below the best")
    panels[0].set_ylim(-4.2, 0.15)
    panels[0].axhline(-LOSS, color=drawing.BLACK, linewidth=0.8, linestyle=":")
    panels[0].legend(loc="lower left")
    panels[1].set_title("Size")
    panels[1].set_ylabel("kB per frame")
    panels[1].set_ylim(0)
    panels[1].legend(loc="center right", bbox_to_anchor=(1, 0.4))
    panels[2].set_title("Flicker in the same view")
    panels[2].set_ylabel("rms, levels of 255")
    panels[2].set_ylim(0)
    panels[2].legend(loc="lower right")
    for axis in panels:
        drawing.logarithmic(axis, "x", (0.05, 0.15, 0.5, 1, 2))
        axis.set_xlabel("--max-error, pixels")
        drawing.mark(axis, DEFAULT, "default", 0.5 if axis is panels[0] else 0.99)
    drawing.save(figure, folder / "system.svg")


def text_budgets(results):
    found = results["meshes"]
    row = {m: at_default(f) for m, f in found.items()}

    def knees(what):
        return " and ".join(f"{f[f'knee_{what}']:g} px ({m})" for m, f in found.items())

    def each(value):
        return " and ".join(f"{value(m)} ({m})" for m in found)

    return f"""![Loss of PSNR, bytes and flicker over --max-error](system.svg)

**The largest error budget that costs at most {LOSS:g} dB in a view that no camera filmed is {knees('inside')}; the default is
{DEFAULT:g} px.** That is inside the true silhouette; over the box around it, where a mesh that is too large counts, it is
{knees('box')}. Flicker stays within 2 % of the least up to {knees('flicker')}. {' '.join(verdict(m, f) for m, f in found.items())}

At the default, compared with the finest budget tried ({BUDGETS[0]:g} px), PSNR inside is lower by
{each(lambda m: f"{loss_at(found[m], row[m]):.2f} dB")}, and the stream smaller by
{each(lambda m: f"{100 * (1 - row[m]['all_bytes'] / found[m]['rows'][0]['all_bytes']):.0f} %")}; meshes take
{each(lambda m: f"{100 * row[m]['meshes_bytes'] / row[m]['all_bytes']:.0f} %")} of it.

Input: `fvvsynth --rig small`, 7 cameras of 480x270, {results['frames']} frames; meshes are the exact ones (tracked) or visual hulls of
the 7 cameras (hull), which are wrong by more than any budget here, so that finer budgets cannot help. Pictures are H.264 at 42 dB.
The view is drawn with `fvvrender` from {len(results['views_degrees'])} places between two cameras and compared with the generator's own
picture from there: PSNR of luma of all pixels together. Flicker is how much more or less the view changes from frame to frame than
the truth does. Nothing here is of a real scene."""


def at_default(found):
    return next(r for r in found["rows"] if r["max_error"] == DEFAULT)


def loss_at(found, row):
    return max(r["psnr_inside_db"] for r in found["rows"]) - row["psnr_inside_db"]


def verdict(meshes, found):
    """Whether the knee inside the silhouette justifies the default, in a sentence."""
    knee = found["knee_inside"]
    if knee == DEFAULT:
        return f"With {meshes} meshes the default is the knee."
    if knee > DEFAULT:
        return f"With {meshes} meshes a larger budget, {knee:g} px, would do."
    return f"With {meshes} meshes this chart does not justify the default: it is coarser than the knee, {knee:g} px."


def defaults_of_budgets(results):
    found = results["meshes"]
    said = "; ".join(
        f"{m}: knee {f['knee_inside']:g} px, {loss_at(f, at_default(f)):.2f} dB lost"
        for m, f in found.items()
    )
    steps = ", ".join(f"{at_default(f)['step_mm']:g} mm ({m})" for m, f in found.items())
    return [
        (
            "fvvmux --max-error",
            f"{DEFAULT:g} px",
            said,
            all(f["knee_inside"] == DEFAULT for f in found.values()),
        ),
        ("fvvmux --step", "by the budget", f"{steps} at the default budget"),
    ]


def paper_capture(source):
    """The clip as a client of WHP 235 has it: vertices to the millimetre, and pictures after their JPEG; no masks."""
    read = json.loads((source / "capture.json").read_text())
    pictures = [Image.open(source / (c["pictures"] % 0)).convert("RGB") for c in read["cameras"]]
    quality = whp235.nearest_quality(pictures)

    def change(description, folder):
        for camera, from_source in zip(description["cameras"], read["cameras"]):
            (folder / camera["name"]).mkdir()
            for frame in range(description["frames"]["count"]):
                picture = Image.open(source / (from_source["pictures"] % frame)).convert("RGB")
                decoded = Image.open(io.BytesIO(whp235.jpeg(picture, quality)))
                decoded.save(folder / camera["name"] / f"{frame:04d}.png", compress_level=1)
            camera["pictures"] = f"{camera['name']}/%04d.png"
            del camera["masks"]

    return experiment.changed_capture(source, "whp235", change)


def paper_row(source, arc):
    """Bytes of the messages, and the view with the paper's texturing: by the normal, cosine above 0.25, best three."""
    sizes = whp235.sizes(source / "capture.json", lambda picture: picture.size)
    made = experiment.packed(paper_capture(source), "--codec", "jpeg", "--quality", 100, "--keep-geometry", "--step", "1mm",
                      "--crop", "none", "--tile-fill", "keep", "--visibility", "none", "--colours", "off",
                      "--match-colours", "off", "--texture-inset", "off")  # fmt: skip
    row = views.measure(made.path, arc, "--blend", "paper", "--inset", 0)
    return {"all_bytes": sizes["all"] / arc.frames, "meshes_bytes": sizes["mesh"] / arc.frames, **row}


def size_rows(source, arc, codec):
    rows = []
    for quality in QUALITIES:
        made = experiment.packed(source, "--codec", codec, "--quality", f"{quality}dB")
        rows.append(
            {"quality_db": quality, **experiment.parts(made.summary), **views.measure(made.path, arc)}
        )
    return rows


def sizes(quick):
    if quick:
        return quick_sizes()
    arc = views.Arc(FRAMES, VIEWS)
    out = {"frames": FRAMES, "views_degrees": VIEWS, "published": PAPER, "series": {}}
    for meshes in MESHES:
        source = clip(meshes)
        rows = {codec: size_rows(source, arc, codec) for codec in CODECS}
        curves = {
            region: [[(r["all_bytes"], r[f"psnr_{region}_db"]) for r in rows[c]] for c in CODECS]
            for region in ("inside", "box")
        }
        out["series"][meshes] = {
            "codecs": rows,
            "paper": paper_row(source, arc),
            # Of H.264 against JPEG.
            "bd_rate_percent": {
                region: numbers.bd_rate(jpeg, h264) for region, (h264, jpeg) in curves.items()
            },
            "knee_db": numbers.knee(rows["h264"], "all_bytes", "psnr_inside_db", LOSS)["quality_db"],
        }
    return out


def quick_sizes():
    source = clip("hull", QUICK_FRAMES)
    paper = whp235.sizes(source / "capture.json", lambda picture: picture.size)
    return {"bytes_over_whp235": experiment.packed(source).summary["bytes"] / paper["all"]}


def draw_sizes(results, folder):
    figure, panels = drawing.sheet(2, 1, 4.6, 3.6)
    names = {"h264": "fvv, H.264", "jpeg": "fvv, JPEG"}
    for axis, (meshes, found) in zip(panels, results["series"].items()):
        for number, (codec, rows) in enumerate(found["codecs"].items()):
            kilobytes = [r["all_bytes"] / 1000 for r in rows]
            drawing.line(axis, number, kilobytes, [r["psnr_inside_db"] for r in rows], names[codec])
        default = row_at_default(found)
        at = default["all_bytes"] / 1000, default["psnr_inside_db"]
        axis.plot(*at, marker="o", markersize=11, markerfacecolor="none", color=drawing.BLUE, linestyle="")
        drawing.words(axis, *at, "default of fvvmux", (0, 10), drawing.BLUE, ha="center")
        paper = found["paper"]
        at = paper["all_bytes"] / 1000, paper["psnr_inside_db"]
        axis.plot(*at, color=drawing.BLACK, marker="X", linestyle="", markersize=8)
        drawing.words(axis, *at, "WHP 235's\nencoding", (0, -26), ha="center")
        drawing.mark(
            axis,
            results["published"]["bytes"] / 1000,
            "size that WHP 235\nreports for its\nown clip",
            0.66,
            side="right",
        )
        drawing.logarithmic(axis, "x", (5, 10, 30, 100, 300, 1000))
        axis.set_xlim(3.5, 4000)
        low, high = axis.get_ylim()
        axis.set_ylim(low - 0.2 * (high - low), high + 0.12 * (high - low))
        axis.set_title(TITLES[meshes])
        axis.set_xlabel("kB per frame, all of the stream")
        axis.set_ylabel("PSNR of a held-out view, inside, dB")
        axis.legend(loc="lower center", bbox_to_anchor=(0.5, 0.02))
    drawing.save(figure, folder / "size.svg")


def row_at_default(found):
    return next(r for r in found["codecs"]["h264"] if r["quality_db"] == DEFAULT_QUALITY)


def percent(value):
    return "-" if value is None else f"{value:.0f} %"


def text_sizes(results):
    lines = []
    for meshes, found in results["series"].items():
        paper, default, rate = found["paper"], row_at_default(found), found["bd_rate_percent"]
        knee = next(r for r in found["codecs"]["h264"] if r["quality_db"] == found["knee_db"])
        lines.append(
            f"| {meshes} | {default['all_bytes'] / 1000:.1f} kB, {default['psnr_inside_db']:.2f} dB ({default['psnr_box_db']:.2f}) "
            f"| {paper['all_bytes'] / 1000:.0f} kB, {paper['psnr_inside_db']:.2f} dB ({paper['psnr_box_db']:.2f}) "
            f"| {paper['all_bytes'] / default['all_bytes']:.0f} | {percent(rate['inside'])} ({percent(rate['box'])}) "
            f"| {found['knee_db']} dB, {knee['all_bytes'] / 1000:.1f} kB |"
        )
    hull = results["series"]["hull"]
    better = row_at_default(hull)["psnr_inside_db"] - hull["paper"]["psnr_inside_db"]
    ratio = hull["paper"]["all_bytes"] / row_at_default(hull)["all_bytes"]
    table = "\n".join(lines)
    return f"""![PSNR of a held-out view over kB per frame](size.svg)

**With its defaults fvv takes {ratio:.0f} times fewer bytes than the encoding of WHP 235 for the same clip of hulls, and the view from
between its cameras is {better:.1f} dB better.** Figures are PSNR inside the silhouette, and over the box in brackets:

| meshes | fvv, defaults | WHP 235's encoding | bytes, ratio | BD-rate of H.264 against JPEG | least quality that costs at most {LOSS:g} dB here |
|---|---|---|---|---|---|
{table}

The encoding of WHP 235 is that of [bench/whp235.py](../../../bench/whp235.py): text meshes to the millimetre, JPEG in Base64. Its view is drawn by
the paper's rule (cameras weighted by the normal, cosine above {PAPER_THRESHOLD:g}, the best {PAPER_BEST}), with meshes and pictures as its client has
them; fvv's by its own. So the difference in PSNR is of texturing and of seeing less of the background at outlines, not of the coding alone.
The dotted line is the size that the paper reports for its own clip, {results['published']['bytes'] / 1000:.0f} kB a frame (27.3 Mbyte
for 50 frames, section 5): another scene, so its quality cannot be compared.

Held-out views say little on the quality of pictures: they are limited by where the mesh is wrong and by blending, so
they stop getting better long before {DEFAULT_QUALITY} dB. The default is what a viewer at a camera's own place sees; a page whose
viewers stay between cameras can take less."""


def defaults_of_sizes(results):
    knees = ", ".join(f"{f['knee_db']} dB ({m})" for m, f in results["series"].items())
    rates = ", ".join(
        f"{percent(f['bd_rate_percent']['inside'])} ({m})" for m, f in results["series"].items()
    )
    return [
        (
            "fvvmux --quality",
            f"{DEFAULT_QUALITY}dB",
            f"held-out views lose {LOSS:g} dB only below {knees}; it is for views from cameras' own places",
            all(f["knee_db"] == DEFAULT_QUALITY for f in results["series"].values()),
        ),
        (
            "fvvmux --codec",
            "h264",
            f"bytes against JPEG at the same held-out PSNR: {rates}; against other codecs see texture",
        ),
    ]


EXPERIMENTS = (
    experiment.Experiment(
        "system",
        "The error budget",
        budgets,
        draw_budgets,
        text_budgets,
        quick_headlines,
        defaults_of_budgets,
    ),
    experiment.Experiment(
        "size",
        "Size and a view that no camera filmed",
        sizes,
        draw_sizes,
        text_sizes,
        dict,
        defaults_of_sizes,
    ),
)
