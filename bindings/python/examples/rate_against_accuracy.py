"""Packs a capture with several budgets of error and plots what accuracy costs: bit rate of the meshes against their distance.

usage: python rate_against_accuracy.py CAPTURE OUT.png [FRAMES]
"""

import os
import sys
import tempfile

import fvv
import matplotlib

matplotlib.use("agg")
from matplotlib import pyplot  # noqa: E402

BUDGETS = ("20mm", "10mm", "5mm", "2mm")


def main(capture, out, frames="5"):
    rates, errors, worst = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for budget in BUDGETS:
            path = os.path.join(folder, f"{budget}.fvv")
            fvv.mux(capture, path, max_error=budget, frames=f"0-{int(frames) - 1}")
            with fvv.open(path) as clip:
                chunks = clip.chunks()
                rates.append(8 * chunks["size"][chunks["type"] == b"MESH"].sum() / clip.duration / 1e6)
            # One frame is enough here; None compares all.
            found = fvv.compare(capture, path, 0, samples=5000)
            errors.append(1000 * found.distance.symmetric.rms)
            worst.append(1000 * found.distance.symmetric.max)
            print(
                f"{budget:>5}: {rates[-1]:6.3f} Mbit/s, {errors[-1]:5.2f} mm rms, {worst[-1]:5.2f} mm at most"
            )

    figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    axes.loglog(rates, errors, "o-", label="rms")
    axes.loglog(rates, worst, "s--", label="largest")
    for rate, error, budget in zip(rates, errors, BUDGETS):
        axes.annotate(budget, (rate, error), xytext=(6, 4), textcoords="offset points")
    axes.set(
        xlabel="meshes in Mbit/s",
        ylabel="distance to the capture's surface in mm",
        title=f"Budgets of {', '.join(BUDGETS)}",
    )
    axes.grid(True, which="both", alpha=0.4)
    axes.legend()
    figure.savefig(out, dpi=120)


if __name__ == "__main__":
    main(*sys.argv[1:])
