"""Mesh codecs on real and generated sequences: a table on the terminal, as CSV and as a chart.

Sequences that were captured lie where FVV_DATA says (default: shared/data beside the project); what is absent is named.
All are scaled so that the first mesh is 1.8 m high, and lengths are those of that scale.
"""

import csv
import json
import os
import pathlib
import subprocess
import sys
import tarfile

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "build/default/bench/fvvcodecs"
DATA = pathlib.Path(os.environ.get("FVV_DATA", ROOT.parent / "shared/data"))
HEIGHT = 1.8
KEY_STEPS = (1, 2)  # mm
DELTA_STEPS = (1, 2, 4)
AXES = {"x": 0, "y": 1, "z": 2}

# Real sequences: name, file or files under FVV_DATA, the vertical axis, and whether all meshes have the same faces.
SEQUENCES = [
    ("crane", "csail_meshes/crane.first50.tar.xz", "y", True),
    ("horse", "csail_meshes/horse-gallop.tar.xz", "y", True),
    ("basketball", "tvm_basketball_player/*.obj", "y", False),
    ("hoxel", "scvv_hoxel/*.draco", "y", False),
    ("human20", "wd2_human20/reference/our_visual_hull_160.ply", "y", False),
]
CHART_MM, CHART_BITS = 1.2, 48
MOST_KEYS = 3  # frames of a sequence that are coded as key frames

# Figure: sequence, codec, setting and step of its line, and its column.
FIGURES = {
    "delta.crane.bits_per_vertex": ("crane", "delta", "0.2222 mm +- 4", 2, "bits_per_vertex"),
    "delta.crane.rms_mm": ("crane", "delta", "0.2222 mm +- 4", 2, "rms_mm"),
    "delta.horse.bits_per_vertex": ("horse", "delta", "0.2222 mm +- 4", 2, "bits_per_vertex"),
    "delta.horse.rms_mm": ("horse", "delta", "0.2222 mm +- 4", 2, "rms_mm"),
    "key.basketball.bits_per_vertex": ("basketball", "draco", "level 7", 1, "bits_per_vertex"),
    "key.human20.bits_per_vertex": ("human20", "draco", "level 7", 1, "bits_per_vertex"),
}
TIME_FIGURE = "delta.decode_time_over_draco"  # a delta frame over a key frame of the first generated sequence


def unpacked(archive, folder):
    """Unpacks an archive of meshes below folder and returns its OBJ files."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    with tarfile.open(archive) as tar:
        for member in tar:
            if member.isfile() and member.name.endswith(".obj"):
                files.append(folder / pathlib.PurePath(member.name).name)
                files[-1].write_bytes(tar.extractfile(member).read())
    return sorted(files)


def found(pattern, folder):
    """The meshes that match a pattern under FVV_DATA, in order; an empty list without the data."""
    files = sorted(DATA.glob(pattern))
    if files and pattern.endswith(".tar.xz"):
        return unpacked(files[0], folder)
    if files and pattern.endswith(".draco"):  # the readers expect the usual extension
        folder.mkdir(parents=True, exist_ok=True)
        for path in files[:MOST_KEYS]:
            (folder / path.name).with_suffix(".drc").write_bytes(path.read_bytes())
        return sorted(folder.glob("*.drc"))
    return files


def measured(mode, files, axis, steps):
    command = [PROGRAM, mode, "--height", str(HEIGHT), "--up", str(AXES[axis]), "--step",
               ",".join(map(str, steps)), *files]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"bench: {done.stderr.strip()}")
    return json.loads(done.stdout)


def rows_of(name, files, axis, tracked):
    """Prints the table's lines of one sequence and returns them."""
    rows = measured("key", files[:MOST_KEYS], axis, KEY_STEPS)
    if tracked:
        rows += measured("delta", files, axis, DELTA_STEPS)
    for row in rows:
        print(
            f"{name:12}{row['codec']:10}{row['setting']:24}{row['step_mm']:8.3f}{row['bytes_per_frame']:10.0f}"
            f"{row['bits_per_vertex']:9.2f}{row['rms_mm']:9.3f}{row['p99_mm']:9.3f}{row['encode_ms']:8.1f}"
            f"{row['decode_ms']:8.2f}"
        )
    return [{"sequence": name, **row} for row in rows]


def chart(rows, path):
    """Bits per vertex over rms error, a panel for each sequence; raw is left out, it has some 290 bits."""
    names = list(dict.fromkeys(row["sequence"] for row in rows))
    columns = min(3, len(names))
    lines = -(-len(names) // columns)
    figure, axes = pyplot.subplots(lines, columns, figsize=(4.5 * columns, 4 * lines), squeeze=False)
    kinds = [
        ("libdraco", "x", "Draco alone"),
        ("draco", "o", "fvv, draco"),
        ("fast", "^", "fvv, fast"),
        ("delta", "s", "fvv, delta frames"),
    ]
    for axis in axes.flat[len(names) :]:
        axis.remove()
    for name, axis in zip(names, axes.flat):
        for codec, marker, label in kinds:
            points = [row for row in rows if row["sequence"] == name and row["codec"] == codec]
            axis.scatter([p["rms_mm"] for p in points], [p["bits_per_vertex"] for p in points],
                         marker=marker, s=28, alpha=0.7, label=label if points else None)  # fmt: skip
        beyond = sum(row["sequence"] == name and row["rms_mm"] > CHART_MM for row in rows)
        axis.set_title(f"{name}, {HEIGHT} m high" + (f" ({beyond} off to the right)" if beyond else ""))
        axis.set_xlabel("rms error, mm")
        axis.set_ylabel("bits per vertex")
        axis.set_xlim(0, CHART_MM)
        axis.set_ylim(0, CHART_BITS)
        axis.grid(alpha=0.3)
        axis.legend(fontsize="small", loc="upper right")
    figure.tight_layout()
    figure.savefig(path, dpi=100)


def measure(work, generated):
    """Prints the table, writes codecs.csv and codecs.png into work, and returns the figures.

    generated: name -> (meshes, whether they share their faces), of captures that are made here.
    """
    print(
        f"meshes scaled to {HEIGHT} m; delta frames: lattice +- error in its steps, without their key frame"
    )
    print(
        f"{'sequence':12}{'codec':10}{'setting':24}{'step mm':>8}{'B/frame':>10}{'bits/vtx':>9}{'rms mm':>9}"
        f"{'p99 mm':>9}{'enc ms':>8}{'dec ms':>8}"
    )
    rows = []
    for name, (files, tracked) in generated.items():
        rows += rows_of(name, files, "y", tracked)
    for name, pattern, axis, tracked in SEQUENCES:
        files = found(pattern, work / "sequences" / name)
        if files:
            rows += rows_of(name, files, axis, tracked)
        else:
            print(f"{name:12}absent: no {pattern} under FVV_DATA ({DATA})")
    with open(work / "codecs.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows(rows)
    chart(rows, work / "codecs.png")
    print(f"written to {work}/codecs.csv and codecs.png")

    def value(sequence, codec, setting, step, column):
        key = (sequence, codec, setting, step)
        for row in rows:
            if (row["sequence"], row["codec"], row["setting"], round(row["step_mm"], 6)) == key:
                return row[column]
        return None

    figures = {figure: value(*line) for figure, line in FIGURES.items()}
    tracked = next(name for name, (_, shared) in generated.items() if shared)
    figures[TIME_FIGURE] = value(tracked, "delta", "0.2222 mm +- 4", 2, "decode_ms") / value(
        tracked, "draco", "level 7", 1, "decode_ms"
    )
    return {figure: number for figure, number in figures.items() if number is not None}
