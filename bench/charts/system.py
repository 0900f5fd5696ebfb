"""The whole stream: bytes against a view that no camera filmed, over the error budget and over the quality of pictures.

`system` varies --max-error and looks for the knee; `size` varies the quality, beside the encoding of WHP 235, which is packed here
with its own methods and drawn by its own rule of texturing.
"""

import io
import json
import sys

from PIL import Image

from . import drawing, lab, numbers, views

sys.path.insert(0, str(lab.ROOT / "bench"))
import whp235  # noqa: E402

FRAMES, QUICK_FRAMES = 12, 4
VIEWS = 0, 15, 30
BUDGETS = 0.05, 0.075, 0.1, 0.15, 0.2, 0.3, 0.5, 0.75, 1.0, 1.5, 2.0
DEFAULT = 0.15
MESHES = {"tracked": "tracked: exact", "hull": "visual hull of 7 cameras"}
QUALITIES = 30, 33, 36, 39, 42, 45
CODECS = "h264", "jpeg"
LOSS = 0.1  # dB that the knee may lose
PAPER = {"bytes": 27.3e6 / 50, "picture_bytes": 14.4e6 / 50}  # WHP 235, section 5: 27.3 Mbyte for 50 frames


def clip(meshes, frames=FRAMES):
    """The generated clip: 7 alike cameras at 480x270."""
    return lab.capture(f"small-{meshes}", "--rig", "small", "--meshes", meshes, "--frames", frames)


def budget_row(source, arc, *options):
    made = lab.packed(source, "--quality", "42dB", *options)
    budget = made.summary["budget"]
    row = lab.parts(made.summary) | views.measure(made.path, arc)
    row |= {"triangles": budget.get("triangles"), "step_mm": 1000 * made.summary["lattice"]["step"]}
    return row | {"rms_mm": 1000 * (budget.get("rms") or 0)}


def budgets():
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


def draw_budgets(results, folder):
    figure, panels = drawing.sheet(3, 1, 3.6)
    series = [(m, region) for m in results["meshes"] for region in ("inside", "box")]
    for number, (meshes, region) in enumerate(series):
        rows = results["meshes"][meshes]["rows"]
        best = max(r[f"psnr_{region}_db"] for r in rows)
        drawing.line(panels[0], number, [r["max_error"] for r in rows], [r[f"psnr_{region}_db"] - best for r in rows],
                     f"{meshes}, {region} ({best:.1f} dB)")  # fmt: skip
    panels[0].set_title("Loss in a view that no camera filmed")
    panels[0].set_ylabel("PSNR, dB below the best")
    panels[0].axhline(-LOSS, color=drawing.BLACK, linewidth=0.8, linestyle="--")
    panels[0].legend(loc="lower left")
    for number, meshes in enumerate(results["meshes"]):
        rows = results["meshes"][meshes]["rows"]
        errors = [r["max_error"] for r in rows]
        drawing.line(panels[1], 2 * number, errors, [r["all_bytes"] / 1000 for r in rows], f"{meshes}, all")
        drawing.line(
            panels[1], 2 * number + 1, errors, [r["meshes_bytes"] / 1000 for r in rows], f"{meshes}, meshes"
        )
        drawing.line(panels[2], 2 * number, errors, [r["flicker"] for r in rows], meshes)
    panels[1].set_title("Size")
    panels[1].set_ylabel("kB per frame")
    panels[1].set_ylim(0)
    panels[2].set_title("Flicker")
    panels[2].set_ylabel("rms, levels of 255")
    panels[2].set_ylim(0)
    for axis in panels:
        drawing.logarithmic(axis, "x", (0.05, 0.15, 0.5, 1, 2))
        axis.set_xlabel("--max-error, pixels")
        drawing.mark(axis, DEFAULT, "default", 0.99 if axis is not panels[0] else 0.6)
    for axis in panels[1:]:
        axis.legend(loc="center right")
    drawing.save(figure, folder / "system.svg")


def text_budgets(results):
    lines = ["![Loss of PSNR, bytes and flicker over --max-error](system.svg)", ""]
    found = results["meshes"]
    row = {m: next(r for r in f["rows"] if r["max_error"] == DEFAULT) for m, f in found.items()}

    def knees(what):
        return " and ".join(f"{f[f'knee_{what}']:g} px ({m})" for m, f in found.items())

    lines.append(
        f"**The largest budget that loses at most {LOSS:g} dB is {knees('inside')} inside the silhouette, "
        f"{knees('box')} over the box; flicker stays within 2 % up to {knees('flicker')}.** "
    )
    lines.append(
        f"The default of {DEFAULT:g} px loses {' and '.join(f'{loss_at(f, row[m])} dB ({m})' for m, f in found.items())} inside "
        "against the best budget. " + " ".join(verdict(m, f) for m, f in found.items())
    )
    return "\n".join(lines)


def loss_at(found, row):
    return f"{max(r['psnr_inside_db'] for r in found['rows']) - row['psnr_inside_db']:.2f}"


def verdict(meshes, found):
    """Whether the knee inside the silhouette justifies the default, in a sentence."""
    knee = found["knee_inside"]
    if knee == DEFAULT:
        return f"With {meshes} meshes the default is the knee."
    if knee > DEFAULT:
        return f"With {meshes} meshes a larger budget, {knee:g} px, would do."
    return f"With {meshes} meshes this chart does not justify the default: it is coarser than the knee, {knee:g} px."


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

    return lab.changed_capture(source, "whp235", change)


def paper_row(source, arc):
    """Bytes of the messages, and the view with the paper's texturing: by the normal, cosine above 0.25, best three."""
    sizes = whp235.sizes(source / "capture.json", lambda picture: picture.size)
    made = lab.packed(paper_capture(source), "--codec", "jpeg", "--quality", 100, "--keep-geometry", "--step", "1mm",
                      "--crop", "none", "--background", "keep", "--visibility", "none", "--colours", "off",
                      "--match-colours", "off", "--texture-inset", "off")  # fmt: skip
    row = views.measure(made.path, arc, "--blend", "paper", "--inset", 0)
    return {"all_bytes": sizes["all"] / arc.frames, "meshes_bytes": sizes["mesh"] / arc.frames, **row}


def sizes(frames=FRAMES, shown=VIEWS, qualities=QUALITIES, codecs=CODECS):
    arc = views.Arc(frames, shown)
    source = clip("hull", frames)
    out = {
        "frames": frames,
        "views_degrees": shown,
        "codecs": {},
        "paper": paper_row(source, arc),
        "published": PAPER,
    }
    for codec in codecs:
        rows = []
        for quality in qualities:
            made = lab.packed(source, "--codec", codec, "--quality", f"{quality}dB")
            rows.append({"quality_db": quality, **lab.parts(made.summary), **views.measure(made.path, arc)})
        out["codecs"][codec] = rows
    out["bd_rate_percent"] = {
        region: numbers.bd_rate(
            *([(r["all_bytes"], r[f"psnr_{region}_db"]) for r in out["codecs"][c]] for c in ("jpeg", "h264"))
        )
        for region in ("inside", "box")
        if len(codecs) > 1
    }
    return out


def draw_sizes(results, folder):
    figure, panels = drawing.sheet(1, 1, 5.6, 3.2)
    axis = panels[0]
    names = {"h264": "fvv with H.264", "jpeg": "fvv with JPEG"}
    for number, codec in enumerate(results["codecs"]):
        rows = results["codecs"][codec]
        drawing.line(
            axis,
            number,
            [r["all_bytes"] / 1000 for r in rows],
            [r["psnr_inside_db"] for r in rows],
            names[codec],
        )
    paper = results["paper"]
    axis.plot(paper["all_bytes"] / 1000, paper["psnr_inside_db"], color=drawing.BLACK, marker="X", linestyle="", markersize=8,
              label="as in WHP 235, packed and drawn here")  # fmt: skip
    drawing.mark(
        axis,
        results["published"]["bytes"] / 1000,
        "WHP 235 reports\n27.3 MB for 2 s\n(other scene)",
        0.5,
        side="right",
    )
    default = next(r for r in results["codecs"]["h264"] if r["quality_db"] == 42)
    drawing.words(
        axis, default["all_bytes"] / 1000, default["psnr_inside_db"], "default, 42 dB", (4, -12), drawing.BLUE
    )
    drawing.logarithmic(axis, "x", (10, 30, 100, 300, 1000))
    axis.set_xlabel("kB per frame: meshes, 7 pictures of 480x270, everything else")
    axis.set_ylabel("PSNR of a view that no camera\nfilmed, inside its silhouette, dB")
    axis.legend(loc="lower center")
    drawing.save(figure, folder / "size.svg")


def text_sizes(results):
    paper = results["paper"]
    default = next(r for r in results["codecs"]["h264"] if r["quality_db"] == 42)
    better = default["psnr_inside_db"] - paper["psnr_inside_db"]
    box = default["psnr_box_db"] - paper["psnr_box_db"]
    rate = results["bd_rate_percent"]
    return "\n".join(
        [
            "![PSNR of a held-out view over kB per frame](size.svg)",
            "",
            f"**With its defaults fvv takes {paper['all_bytes'] / default['all_bytes']:.0f} times fewer bytes than the encoding of WHP 235 "
            f"of the same clip, and the view from between the cameras is {better:+.1f} dB inside its silhouette ({box:+.1f} dB over "
            "the box).** The paper's own clip is another scene; only its size is comparable (7 cameras of 480x270, "
            f"35,000 triangles, 50 frames). BD-rate of H.264 against JPEG over these views: {rate['inside']:.0f} % inside, "
            f"{rate['box']:.0f} % over the box."
            if all(v is not None for v in rate.values())
            else "",
        ]
    )
