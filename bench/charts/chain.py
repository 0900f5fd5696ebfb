"""From films to a surface: what each stage of fvvcapture costs at a camera that filmed nothing, with the truth in place of the others."""

from recordings import chain

from . import drawing, experiment


def measure(quick):
    return None if quick else {"rows": chain.ablation()}


def label(row):
    said = {
        "calibration": f"{row['calibration']} cameras",
        "clocks": "clocks agree" if row["clocks"] == "agree" else "real clocks",
        "silhouettes": None if row["silhouettes"] == "-" else f"{row['silhouettes']} silhouettes",
        "surface": f"{row['surface']} surface" if row["surface"] != "hull" else "hull",
    }
    return ", ".join(part for part in said.values() if part)


def draw(results, folder):
    figure, (panel,) = drawing.sheet(1, 1, 7.4, 3.9)
    rows = results["rows"]
    colours = {"true": drawing.GREEN, "hull": drawing.BLUE, "refined": drawing.ORANGE}
    for number, row in enumerate(rows):
        panel.barh(number, row["psnr_db"], color=colours[row["surface"]], height=0.7)
        drawing.words(panel, row["psnr_db"], number, f"{row['psnr_db']:.2f}", to=(3, -3))
    panel.set_yticks(range(len(rows)), [label(row) for row in rows])
    panel.invert_yaxis()
    panel.set_xlim(18, 29)
    panel.set_xlabel("PSNR of a camera held out, within its true silhouette, dB")
    drawing.save(figure, folder / "chain.svg")


def text(results):
    rows, found = results["rows"], chain.figures(results["rows"])
    header = (
        "| calibration | clocks | silhouettes | surface | PSNR | FLIP | flicker | not covered (share of the error) | more than 2 cm off in depth (share) | seconds a frame |\n"
        "|---|---|---|---|---|---|---|---|---|---|"
    )
    lines = [
        f"| {row['calibration']} | {row['clocks']} | {row['silhouettes']} | {row['surface']} | {row['psnr_db']:.2f} dB | {row['flip']:.3f} | {row['flicker']:.2f} | "
        f"{100 * row['uncovered']:.1f} % ({100 * row['uncovered_error']:.0f} %) | "
        f"{100 * row['off']:.1f} % ({100 * row['off_error']:.0f} %) | {row.get('seconds', 0):.1f} |"
        for row in rows
    ]
    return f"""![PSNR of a camera held out, with the truth in place of stages](chain.svg)

**A stream that fvvcapture makes of films alone gives {found['chain.refined_psnr_db']:.1f} dB with refined surfaces and {found['chain.held_out_psnr_db']:.1f} dB with hulls at a camera that filmed nothing; true surfaces give {rows[1]['psnr_db']:.1f}.**
With refined surfaces keys cost {found['chain.keying_loss_db']:.2f} dB against true silhouettes, and the surface {found['chain.shape_loss_db']:.2f} dB against the true one. Frames {chain.TABLE[0]} and {chain.TABLE[1]} of generated footage
([fvvsynth.md](../../tools/fvvsynth.md#footage)), 11 cameras. FLIP is 0 for pictures that look alike; flicker is by how many levels the
error of luma changes from frame to frame. Seconds are the processor time of the whole command
over its two frames: backgrounds, sound and bounds too, and in the row of hulls with found calibration the board. A refined row less its hull is what refinement takes.

{chr(10).join([header, *lines])}"""


EXPERIMENTS = (experiment.Experiment("chain", "From films to a surface", measure, draw, text),)
