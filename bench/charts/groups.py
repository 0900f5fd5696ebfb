"""The length of groups: bytes against how soon a player can begin or switch."""

from . import drawing, experiment, system

FRAMES = 50
LENGTHS = 1, 5, 10, 25, 50
RATE = 25  # frames per second
DEFAULT = RATE
MOST_SAVED = 5  # percent, that twice the default length may save
QUALITY = 16  # of H.264, for all lengths: the number that reaches 42 dB in groups of the default length


def measure(quick):
    if quick:
        return None
    out = {"frames": FRAMES, "meshes": {}}
    for meshes in system.MESHES:
        source = system.clip(meshes, FRAMES)
        out["meshes"][meshes] = [
            {
                "group": n,
                **experiment.parts(experiment.packed(source, "--quality", QUALITY, "--group", n).summary),
            }
            for n in LENGTHS
        ]
    return out


def draw(results, folder):
    figure, panels = drawing.sheet(2, 1, 4.4, 3.3)
    for axis, (meshes, rows) in zip(panels, results["meshes"].items()):
        for number, (part, label) in enumerate(
            (("all", "all"), ("pictures", "pictures"), ("meshes", "meshes"))
        ):
            drawing.line(
                axis, number, [r["group"] for r in rows], [r[f"{part}_bytes"] / 1000 for r in rows], label
            )
        drawing.logarithmic(axis, "x", LENGTHS)
        drawing.mark(axis, DEFAULT, "default,\n1 second", 0.97)
        axis.set_ylim(0)
        axis.set_title(system.TITLES[meshes])
        axis.set_xlabel("frames in a group")
        axis.set_ylabel("kB per frame")
        axis.legend(loc="center right", bbox_to_anchor=(0.98, 0.3))
    drawing.save(figure, folder / "groups.svg")


def over_default(rows, length):
    """Bytes with groups of this length over those with the default, minus 1, in percent."""
    at = {r["group"]: r["all_bytes"] for r in rows}
    return 100 * (at[length] / at[DEFAULT] - 1)


def text(results):
    def each(length):
        return " and ".join(
            f"{over_default(rows, length):+.0f} % ({m})" for m, rows in results["meshes"].items()
        )

    return f"""![kB per frame over the length of groups](groups.svg)

**Twice the default length of a group, one second, changes the bytes by {each(50)}; groups of 10 frames change them by {each(10)}.** A player can begin, seek and change rungs where a group begins. Every group repeats a key mesh and key pictures, so the shorter the groups, the
more bytes; groups of one frame change them by {each(1)}. {results['frames']} frames of the small clip at {RATE} frames per second, H.264 at the number {QUALITY} for all lengths, because the number that reaches 42 dB would differ by a step from length to length."""


def defaults(results):
    said = "; ".join(
        f"{m}: 10 frames {over_default(r, 10):+.0f} %, 50 frames {over_default(r, 50):+.0f} %"
        for m, r in results["meshes"].items()
    )
    longer = min(over_default(r, 50) for r in results["meshes"].values())
    return [("fvvmux --group", "1 s", f"bytes against it: {said}", longer > -MOST_SAVED)]


EXPERIMENTS = (
    experiment.Experiment("groups", "The length of groups", measure, draw, text, defaults=defaults),
)
