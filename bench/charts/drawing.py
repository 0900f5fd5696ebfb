"""How charts look: small SVG files with the same bytes for the same figures.

Colours are those of Okabe and Ito (2008), which people with colour-blindness can tell apart; a series has a marker of its own
besides. The background is opaque and light, so that charts can be read on dark pages too.
"""

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402
from matplotlib.ticker import FuncFormatter, NullFormatter  # noqa: E402

BLACK, ORANGE, SKY, GREEN = "#222222", "#d98200", "#4aa3d8", "#00795c"
YELLOW, BLUE, RED, PURPLE = "#b8a800", "#0060a0", "#c44e00", "#b0588c"
COLOURS = BLUE, RED, GREEN, PURPLE, ORANGE, SKY, BLACK, YELLOW
MARKERS = "o", "s", "^", "D", "v", "P", "X", "*"
PAPER, LINES = "#fbfbf8", "#d8d8d2"

STYLE = {
    "figure.facecolor": PAPER,
    "savefig.facecolor": PAPER,
    "axes.facecolor": PAPER,
    "axes.edgecolor": "#777777",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": LINES,
    "grid.linewidth": 0.6,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": True,
    "legend.framealpha": 0.85,
    "legend.facecolor": PAPER,
    "legend.edgecolor": "none",
    "font.family": ["DejaVu Sans", "sans-serif"],
    "font.size": 8,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.5,
    "svg.fonttype": "none",
    "svg.hashsalt": "fvv",
    "path.simplify": True,
}


def styled():
    """A context in which charts look as STYLE says; the caller of an experiment's draw() opens it."""
    return matplotlib.rc_context(STYLE)


def sheet(columns, rows=1, width=4.4, height=3.3):
    """A figure and its panels in one list."""
    figure, axes = pyplot.subplots(rows, columns, figsize=(width * columns, height * rows), squeeze=False)
    return figure, list(axes.flat)


def plain(value, _=None):
    """A number as people write it: 0.05, 3, 1,200."""
    return f"{value:,.0f}" if value >= 10 else f"{value:.3g}"


def logarithmic(axis, which="x", ticks=None):
    """A logarithmic axis with plain numbers."""
    side = axis.xaxis if which == "x" else axis.yaxis
    (axis.set_xscale if which == "x" else axis.set_yscale)("log")
    side.set_major_formatter(FuncFormatter(plain))
    side.set_minor_formatter(NullFormatter())
    if ticks is not None:
        (axis.set_xticks if which == "x" else axis.set_yticks)(list(ticks))


def line(axis, number, x, y, label=None, **more):
    """A series in the colours and with the marker of this number."""
    look = {"color": COLOURS[number % 8], "marker": MARKERS[number % 8], "label": label, **more}
    return axis.plot(x, y, **look)


def mark(axis, x, text, top=0.97, colour=BLACK, side="left"):
    """A vertical line with words beside it, at a share of the height."""
    axis.axvline(x, color=colour, linestyle=":", linewidth=1.1)
    offset = 4 if side == "left" else -4
    axis.annotate(text, (x, top), xycoords=("data", "axes fraction"), xytext=(offset, 0), textcoords="offset points",
                  ha=side, va="top", fontsize=7.5, color=colour)  # fmt: skip


def words(axis, x, y, text, to=(5, 4), colour=BLACK, **more):
    """Words beside a point."""
    axis.annotate(text, (x, y), xytext=to, textcoords="offset points", fontsize=7.5, color=colour, **more)


def save(figure, path):
    figure.tight_layout()
    figure.savefig(path, format="svg", metadata={"Date": None, "Creator": None})
    pyplot.close(figure)
    # Trailing spaces and the XML declaration's doctype say nothing.
    lines = [line.rstrip() for line in path.read_text().splitlines()]
    path.write_text("\n".join(lines) + "\n")
