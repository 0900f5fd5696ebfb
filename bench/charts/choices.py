"""What fvvmux chooses by --view-loss 0.1dB, its default, for different scenes: the spread of each setting, and the bytes that it saves.

The scenes are those of `./run bench spend` in which little can be measured, and hulls.
"""

from spend import scenes
from spend.figures import GOAL

from . import drawing, experiment

# By the row of the table of defaults: the key of view_loss in the summary, and its unit.
CHOSEN = {
    "fvvmux --quality": ("picture_psnr", " dB"),
    "fvvmux --max-error": ("max_error", " px"),
    "fvvmux --texture-threshold": ("threshold", ""),
}


def choice(source, options):
    before, after = (experiment.packed(source, *options, *goal) for goal in ((), GOAL))
    found = after.summary["view_loss"]
    row = {"bytes": before.summary["bytes"], "chosen_bytes": after.summary["bytes"]}
    if not found["measured"]:
        return row | {"reason": found["reason"]}
    return row | {key: found[key] for key, _ in CHOSEN.values()} | {"loss": found["loss"]}


def measure(quick):
    if quick:
        return None
    hull = experiment.capture("scene-hull", "--rig", "small", "--meshes", "hull", "--frames", scenes.FRAMES)
    cases = {**scenes.scenes(), "hulls of the cameras": (hull, ())}
    return {"frames": scenes.FRAMES, "scenes": {name: choice(*case) for name, case in cases.items()}}


def saving(row):
    return 100 * (1 - row["chosen_bytes"] / row["bytes"])


def measured(results):
    return [row for row in results["scenes"].values() if "reason" not in row]


def spread(results, option):
    """What was chosen for a row of the table of defaults, in words."""
    key, unit = CHOSEN[option]
    values = [row[key] for row in measured(results)]
    low, high = min(values), max(values)
    said = f"{low:g}{unit}" if low == high else f"{low:g} to {high:g}{unit}"
    return f"{said} in {len(values)} of {len(results['scenes'])} scenes"


def chosen_per_scene(results):
    return {option: spread(results, option) for option in CHOSEN}


def draw(results, folder):
    names = list(results["scenes"])
    rows = [results["scenes"][name] for name in names]
    figure, panels = drawing.sheet(2, 1, 4.6, 4.2)
    places = range(len(names))
    for axis, values, label in (
        (panels[0], [saving(row) for row in rows], "bytes saved, %"),
        (panels[1], [-row.get("loss", 0) for row in rows], "gain of cameras drawn from the others, dB"),
    ):
        axis.barh(places, values, color=drawing.BLUE, height=0.6)
        axis.invert_yaxis()
        axis.set_yticks(list(places))
        axis.set_yticklabels(names if axis is panels[0] else [])
        axis.set_xlabel(label)
    panels[1].axvline(-0.1, color=drawing.BLACK, linewidth=0.8, linestyle=":")
    for place, row in zip(places, rows):
        what = f"{row['max_error']:g} px, {row['threshold']:g}" if "reason" not in row else "nothing chosen"
        drawing.words(panels[1], max(0, -row.get("loss", 0)), place, what, (4, -3))
    panels[1].set_xlim(right=1.6 * max(0.1, *(-row.get("loss", 0) for row in rows)))
    drawing.save(figure, folder / "choices.svg")


def text(results):
    savings = [saving(row) for row in measured(results)]
    lost = max(row["loss"] for row in measured(results))
    lines = [
        f"| {name} | {row['bytes']:,} | {row['chosen_bytes']:,} | "
        + (
            row["reason"] + " | |"
            if "reason" in row
            else f"{row['picture_psnr']:g} dB, {row['max_error']:g} px, threshold {row['threshold']:g} | {-row['loss']:+.2f} dB |"
        )
        for name, row in results["scenes"].items()
    ]
    return f"""![Bytes that a choice by views saves, and what views gain](choices.svg)

**Where views can tell, `--view-loss 0.1dB`, the default, takes {min(savings):.0f} to {max(savings):.0f} % fewer bytes than 42 dB and 0.15 px, and cameras that are drawn from the others lose at most {max(0, lost):.2f} dB.** What it chooses differs from scene to scene, so no fixed value is right for all: errors of meshes from
{spread(results, 'fvvmux --max-error')}; thresholds from {spread(results, 'fvvmux --texture-threshold')}. In the others views cannot tell, and 42 dB and 0.15 px stay.

| scene | bytes | with the choice | chosen | views |
|---|---|---|---|---|
{chr(10).join(lines)}

`fvvsynth --rig small`, {results['frames']} frames (one scene has one); the small figures beside the bars are the error of meshes and the threshold
([docs/encoding/view-loss.md](../../encoding/view-loss.md))."""


EXPERIMENTS = (experiment.Experiment("choices", "What views need, by scene", measure, draw, text),)
