#!/usr/bin/env python3
"""Writes conformance/tiny and reference/listings by the writers and readers in reference/.

A listing (.crc or .txt) is what a reader finds in the stream of a case that is named vector_ and its name. --check writes nothing and
exits with 1 when a file differs. --list KIND STREAM prints the listing of any stream. --rewrite STREAM writes it again after a change of the
container, with the same payloads.
"""

import argparse
import pathlib
import sys

from reference import (
    audio,
    calibration,
    colours,
    container,
    environment,
    mesh_delta,
    mesh_fast,
    normals,
    openexr,
    texturing,
    tiles,
    tiny,
    visibility,
)

ROOT = pathlib.Path(__file__).resolve().parent
LISTINGS = ROOT / "reference/listings"
READERS = {
    "audio": audio,
    "calibration": calibration,
    "colours": colours,
    "delta": mesh_delta,
    "environment": environment,
    "fast": mesh_fast,
    "normals": normals,
    "openexr": openexr,
    "texturing": texturing,
    "tiles": tiles,
    "visibility": visibility,
}
TEXT = {"audio", "environment", "texturing", "tiles"}  # others list CRCs


def streams():
    """The bytes of the streams that are written here, by path."""
    return {ROOT / "tiny" / name: stream for name, stream in tiny.files().items()}


def path_of(name):
    """The stream of a vector, such as delta_field: of the case vector_delta_field."""
    return ROOT / f"cases/valid/vector_{name}/input.fvv"


def names():
    """The names of all vectors. A name begins with its subject: one of READERS, or tiny, which has no listing."""
    return sorted(path.name[len("vector_") :] for path in (ROOT / "cases/valid").glob("vector_*"))


def name_of(path):
    """The name of a vector by the path of its stream."""
    return path.parent.name[len("vector_") :]


def listings():
    """The bytes of the listing of each vector, by path."""
    out = {}
    for name in names():
        kind = name.split("_")[0]
        if kind in READERS:
            text = "".join(line + "\n" for line in READERS[kind].listing(path_of(name).read_bytes()))
            out[LISTINGS / f"{name}.{'txt' if kind in TEXT else 'crc'}"] = text.encode()
    return out


def write(files, check):
    """Writes the files that differ and returns their paths; with check it only returns them."""
    differing = [path for path, content in files.items() if not path.exists() or path.read_bytes() != content]
    if not check:
        for path in differing:
            path.write_bytes(files[path])
    return differing


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when a file differs")
    parser.add_argument("--list", nargs=2, metavar=("KIND", "STREAM"), help=f"KIND: {', '.join(READERS)}")
    parser.add_argument("--rewrite", metavar="STREAM", type=pathlib.Path, help="write its container again")
    arguments = parser.parse_args()
    if arguments.rewrite:
        arguments.rewrite.write_bytes(container.rewritten(arguments.rewrite.read_bytes()))
        return 0
    if arguments.list:
        kind, path = arguments.list
        if kind not in READERS:
            parser.error(f"--list: expected one of {', '.join(READERS)}, found {kind}")
        print("\n".join(READERS[kind].listing(pathlib.Path(path).read_bytes())))
        return 0
    differing = write(streams(), arguments.check)
    differing += write(listings(), arguments.check)
    for path in differing:
        state = "differs: run conformance/vectors.py" if arguments.check else "written"
        print(f"{path.relative_to(ROOT.parent)}: {state}", file=sys.stderr)
    return 1 if arguments.check and differing else 0


if __name__ == "__main__":
    sys.exit(main())
