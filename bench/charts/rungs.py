"""The ladder of quality: what each rung costs, and how its view from between two cameras compares with one stream of that size."""

from . import drawing, experiment, numbers, system, views

LADDER = 1, 0.75, 0.5, 0.25
BY_QUALITY = 42, 36, 30, 27  # dB, of a ladder of the full size
QUALITIES = 27, 30, 33, 36, 39, 42
FRAMES = system.FRAMES


def measure(quick):
    if quick:
        return None
    arc = views.Arc(FRAMES, system.VIEWS)
    out = {"frames": FRAMES, "meshes": {}}
    for meshes in system.MESHES:
        source = system.clip(meshes)
        made = experiment.packed(source, "--ladder", ",".join(map(str, LADDER)))
        coarser = experiment.packed(source, "--ladder", ",".join(f"{quality}dB" for quality in BY_QUALITY))
        single = []
        for quality in QUALITIES:
            one = experiment.packed(source, "--codec", "h264", "--quality", f"{quality}dB")
            found = experiment.parts(one.summary)
            size = sum(found[f"{k}_bytes"] for k in ("pictures", "meshes", "visibility", "colours"))
            single.append({"quality_db": quality, "bytes_per_frame": size, **views.measure(one.path, arc)})
        out["meshes"][meshes] = {
            "rungs": rung_rows(made, arc),
            "by_quality": [
                row | {"quality_db": quality} for row, quality in zip(rung_rows(coarser, arc), BY_QUALITY)
            ],
            "single": single,
            "bytes_per_frame": made.summary["bytes"] / FRAMES,
        }
    return out


def rung_rows(made, arc):
    rows = []
    for rung in made.summary["ladder"]:
        size = rung["picture_bytes"] + sum(
            rung["meshes"][k] for k in ("bytes", "visibility_bytes", "colours_bytes")
        )
        row = {
            "scale": rung["scale"],
            "bytes_per_frame": size / FRAMES,
            "own_meshes": rung["meshes"]["rung"] == rung["rung"],
        }
        rows.append(row | views.measure(made.path, arc, "--rung", rung["rung"]))
    return rows


def draw(results, folder):
    figure, panels = drawing.sheet(2, 1, 4.6, 3.5)
    for axis, (meshes, found) in zip(panels, results["meshes"].items()):
        for number, (what, label) in enumerate(
            (
                ("rungs", "rungs of one ladder, by their size"),
                ("by_quality", "rungs of one ladder, by their quality"),
                ("single", "streams at full size, by their quality"),
            )
        ):
            rows = found[what]
            drawing.line(
                axis,
                number,
                [r["bytes_per_frame"] / 1000 for r in rows],
                [r["psnr_inside_db"] for r in rows],
                label,
            )
            for r in rows:
                at = r["bytes_per_frame"] / 1000, r["psnr_inside_db"]
                if what == "rungs":
                    drawing.words(
                        axis, *at, f"{r['scale']:g}", (0, -12), drawing.COLOURS[number], ha="center"
                    )
                elif r in (rows[0], rows[-1]):
                    drawing.words(
                        axis, *at, f"{r['quality_db']} dB", (0, 6), drawing.COLOURS[number], ha="center"
                    )
        low, high = axis.get_ylim()
        axis.set_ylim(low - 0.25 * (high - low), high + 0.1 * (high - low))
        drawing.logarithmic(axis, "x", (1, 2, 5, 10, 20, 50))
        axis.set_title(system.TITLES[meshes])
        axis.set_xlabel("kB per frame that a player takes")
        axis.set_ylabel("PSNR of a held-out view, inside, dB")
        axis.legend(loc="lower right")
    drawing.save(figure, folder / "rungs.svg")


def rates(found, of="rungs", against="single"):
    """Bytes of rungs over those of single streams of the same held-out PSNR, minus 1, in percent."""
    return numbers.bd_rate(
        *([(r["bytes_per_frame"], r["psnr_inside_db"]) for r in found[w]] for w in (against, of))
    )


def text(results):
    lines = [
        "| meshes | rung | kB per frame | PSNR inside | over the box | flicker |",
        "|---|---|---|---|---|---|",
    ]
    for meshes, found in results["meshes"].items():
        for r in found["rungs"] + found["by_quality"]:
            name = f"{r['quality_db']} dB" if "quality_db" in r else f"{r['scale']:g}"
            lines.append(
                f"| {meshes} | {name} | {r['bytes_per_frame'] / 1000:.1f} | {r['psnr_inside_db']:.2f} dB | {r['psnr_box_db']:.2f} dB | {r['flicker']:.1f} |"
            )
    table = "\n".join(lines)

    def each(value):
        return " and ".join(f"{value(f)} ({m})" for m, f in results["meshes"].items())

    def half(f):
        first, rung = f["rungs"][0], next(r for r in f["rungs"] if r["scale"] == 0.5)
        return f"{100 * rung['bytes_per_frame'] / first['bytes_per_frame']:.0f} % of the bytes and {first['psnr_inside_db'] - rung['psnr_inside_db']:.2f} dB less"

    def against(f, other="single"):
        rate = rates(f, against=other)
        return "no common range of quality" if rate is None else f"{rate:+.0f} % bytes"

    return f"""![PSNR of a held-out view over the bytes of each rung](rungs.svg)

**A rung of half the size takes {each(half)} in a view that no camera filmed.** Against streams of the full size and a lower quality, at the same PSNR of
that view, rungs by size take {each(against)}: for the same link a coarser quality of the full size shows more here than a smaller size does. Against rungs by quality
(`--ladder {",".join(f"{q}dB" for q in BY_QUALITY)}`), which one stream has as well, they take {each(lambda f: against(f, "by_quality"))}. The generated
pictures are sharper than those of real cameras ([docs/encoding/ladder.md](../../encoding/ladder.md#size-and-quality) has both), and a rung also spares a player
pixels to decode and to upload, which this chart does not show. Bytes are what a player takes: pictures, meshes, visibility and colours.

{table}

Input and views are those of [the error budget](#the-error-budget). Qualities of smaller rungs follow the rule of `--ladder`, 9 dB less for half the size."""


def defaults(results):
    said = ", ".join(
        f"{m} {'-' if (r := rates(f)) is None else f'{r:+.0f} %'}" for m, f in results["meshes"].items()
    )
    return [
        (
            "fvvmux --ladder",
            "none",
            f"bytes of rungs against full-size streams of the same held-out PSNR: {said}",
            all((r := rates(f)) is None or r > 0 for f in results["meshes"].values()),
        )
    ]


EXPERIMENTS = (experiment.Experiment("rungs", "Rungs of the ladder", measure, draw, text, defaults=defaults),)
