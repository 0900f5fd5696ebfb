"""The binary interface of libfvv.so against the one that was released (docs/project/abi.md).

abi.py LIBRARY INCLUDE BASELINE [--update]: the types of all that LIBRARY exports, as a C compiler lays them out by the headers below
INCLUDE, are compared by abidiff with BASELINE. Exit 1: they differ. --update writes BASELINE.
"""

import argparse
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path


def exported(library):
    lines = subprocess.run(
        ["nm", "-D", "--defined-only", library], check=True, capture_output=True, text=True
    ).stdout
    return sorted(line.split()[-1] for line in lines.splitlines())


def describe(names, include, output):
    """An abixml file: of a variable for each function, that points to it, so that C alone says what its types are."""
    # Named without a folder, which would be part of the description.
    source = output.with_name("exports.c")
    headers = sorted((include / "fvv").glob("*.h"))
    lines = [f'#include "fvv/{header.name}"' for header in headers]
    lines += [f"__typeof__({name}) *const to_{name} = {name};" for name in names]
    source.write_text("\n".join(lines) + "\n")
    made = output.with_suffix(".so")
    compiler = [os.environ.get("CC", "cc"), "-std=gnu11", "-gdwarf-4", "-fPIC", "-shared"]
    subprocess.run(
        [*compiler, "-I", include.resolve(), source.name, "-o", made], check=True, cwd=source.parent
    )
    options = ["--no-corpus-path", "--no-comp-dir-path", "--no-show-locs"]
    subprocess.run(["abidw", *options, "--out-file", output, made], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("library", type=Path)
    parser.add_argument("include", type=Path)
    parser.add_argument("baseline", type=Path)
    parser.add_argument("--update", action="store_true")
    arguments = parser.parse_args()
    names = exported(arguments.library)
    foreign = [name for name in names if not name.startswith("fvv_")]
    if foreign:
        sys.exit(f"{arguments.library}: exports what is not its own: {', '.join(foreign)}")
    missing = "" if shutil.which("abidiff") else "there is no abidiff (Debian: abigail-tools)"
    if platform.machine() != "x86_64":
        missing = f"{arguments.baseline} is of x86_64, this is {platform.machine()}"
    if missing:
        print(f"skipped: types of {len(names)} functions: {missing}")
        return
    with tempfile.TemporaryDirectory() as folder:
        found = Path(folder) / "found.abi"
        describe(names, arguments.include, found)
        if arguments.update:
            shutil.copyfile(found, arguments.baseline)
            print(f"{arguments.baseline}: {len(names)} functions")
            return
        compared = subprocess.run(["abidiff", arguments.baseline, found], capture_output=True, text=True)
    if compared.returncode:
        print(compared.stdout, compared.stderr, sep="", end="")
        sys.exit(
            f"{arguments.library}: is not what {arguments.baseline} describes; docs/project/abi.md says what follows"
        )
    print(f"{len(names)} functions as in {arguments.baseline}")


if __name__ == "__main__":
    main()
