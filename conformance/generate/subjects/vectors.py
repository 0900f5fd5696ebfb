"""The vectors of the other folders of conformance/ as cases: most were written by libfvv, for one subject each."""

import pathlib

from ..case import valid

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# Folder: clauses, and the program that writes its files.
REFERENCE, LIBRARY = "conformance/reference", "libfvv"
FOLDERS = {
    "tiny": ("3 4 5 6 7 8.3", REFERENCE),
    "audio": ("5.2 20", REFERENCE),
    "openexr": ("10.12", REFERENCE),
    "background": ("18", LIBRARY),
    "calibration": ("9.4 9.5", LIBRARY),
    "colours": ("19", LIBRARY),
    "delta": ("8.7 8.8 8.9", LIBRARY),
    "fast": ("8.11", LIBRARY),
    "normals": ("8.12 8.13", LIBRARY),
    "texturing": ("17.5", LIBRARY),
    "tiles": ("10.11", LIBRARY),
    "visibility": ("17.1 17.2 17.3", LIBRARY),
}


def add(path, clauses, writer):
    folder = path.parent.name
    valid(
        f"vector_{folder}_{path.stem}",
        f"The vector {folder}/{path.name}, described in conformance/{folder}/README.md.",
        clauses,
        path.read_bytes,
        source=f"conformance/{folder}/{path.name}, written by {writer}",
    )


for name, (numbers, program) in FOLDERS.items():
    for file in sorted((ROOT / name).glob("*.fvv")):
        add(file, numbers, program)
