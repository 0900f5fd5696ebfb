#!/usr/bin/env python3
"""Do all machines, compilers and levels of optimisation decode the same bits? (./run matrix, docs/evidence/matrix.md)

Every build of libfvv reads every case through the protocol of the conformance suite. A build agrees on a case when its whole
report is that of the first build: frames, hashes of their arrays, sound, environment, issues and their places. The decoders in
other languages are compared in what they claim to decode, and in files that are damaged, in what both call intact.
"""

import argparse
import datetime
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import time
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "conformance"))

from fvv_conformance.compare import content_differences  # noqa: E402
from fvv_conformance.decoder import Decoder, DecoderError  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
SHOWN = 10  # differences of a build
# Parts that a decoder cannot give of a stream. The Python package has weights by mesh and camera, and this stream has two
# visibility tracks for each camera.
LEFT_OUT = {
    ("python", "cases/valid/vector_visibility_sheet/input.fvv"): {"visibility"},
}


class Build(NamedTuple):
    name: str
    about: str
    compilers: tuple = ()  # C, C++; none: nothing is built here
    processor: str = "native"
    flags: str = ""
    runner: str = ""  # that the program needs before it
    command: str = ""  # of what is not built here

    def missing(self):
        """What it needs and is not here; empty: nothing."""
        programs = [*self.compilers, *self.runner.split()[:1], *self.command.split()[:1]]
        return [program for program in programs if not shutil.which(program)]


def libfvv(name, about, prefix, level, processor="native", runner="", more=""):
    clang = prefix == "clang"
    compilers = ("clang", "clang++") if clang else (f"{prefix}gcc", f"{prefix}g++")
    return Build(name, about, compilers, processor, f"-{level} {more}".strip(), runner)


def builds():
    found = []
    for level in "O3", "O0":
        found.append(libfvv(f"gcc-{level}", f"x86-64, GCC, -{level}", "", level))
    for level in "O3", "O0":
        found.append(libfvv(f"clang-{level}", f"x86-64, Clang, -{level}", "clang", level))
    for level in "O3", "O0":
        found.append(
            libfvv(f"i686-{level}", f"x86, 32 bits, GCC, -{level}", "i686-linux-gnu-", level, "i686")
        )
    for level in "O3", "O0":
        about = f"s390x, big-endian, GCC, -{level}, qemu-user"
        found.append(libfvv(f"s390x-{level}", about, "s390x-linux-gnu-", level, "s390x", "qemu-s390x"))
    node, adapter = "node", ROOT / "conformance/adapters/js/node.mjs"
    scalar = HERE / "without_simd.mjs"
    found.append(Build("wasm-simd", "WebAssembly in Node", command=f"{node} {adapter}"))
    found.append(
        Build(
            "wasm-scalar", "WebAssembly in Node, without SIMD", command=f"{node} --import {scalar} {adapter}"
        )
    )
    package = f"env PYTHONPATH={ROOT / 'build/default/bindings/python'} {sys.executable}"
    python = ROOT / "conformance/adapters/python_package.py"
    found.append(Build("python", "the Python package", command=f"{package} {python}"))
    return found


def cases():
    """Name and path of every stream of the suite."""
    folder = ROOT / "conformance"
    paths = sorted(folder.glob("cases/*/*/input.fvv"))
    return {str(path.relative_to(folder)): path for path in paths}


def make(build, folder):
    """Builds an adapter; returns the command that starts it."""
    if build.command:
        return build.command
    log = folder / f"{build.name}.log"
    command = [HERE / "build.sh", folder, build.name, *build.compilers, build.processor, build.flags]
    with log.open("w") as output:
        done = subprocess.run([str(c) for c in command], stdout=output, stderr=subprocess.STDOUT)
    if done.returncode:
        raise DecoderError(
            f"{build.name}: the build failed; all of it is in {log}\n{log.read_text()[-2000:]}"
        )
    return f"{build.runner} {folder / build.name / 'adapter'}".strip()


def answers(command, paths):
    with Decoder(command, timeout=300, start_timeout=300) as decoder:
        found = list(decoder.decode_all({"path": str(path)} for path in paths.values()))
        return decoder.parts, dict(zip(paths, found))


def without_id(answer):
    return (
        {key: value for key, value in answer.items() if key != "id"} if isinstance(answer, dict) else answer
    )


def differences(build, parts, first, found):
    """Lines about one case."""
    for answer in first, found:
        if isinstance(answer, str):
            return [answer]
    if not build.command:
        if without_id(first) == without_id(found):
            return []
        lines = list(content_differences(first, found, parts, True))
        keys = [key for key in first if key != "id" and first[key] != found.get(key)]
        return lines or [f"{key}: {json.dumps(found.get(key))[:200]}" for key in keys]
    if first["status"] == "whole":
        return list(content_differences(first, found, parts, True))
    # A reader that follows a stream, and one with random access, know different things of what is damaged.
    times = {int(frame["time"]) for frame in first["frames"]}
    both = [frame for frame in found["frames"] if int(frame["time"]) in times]
    return list(content_differences({"frames": first["frames"]}, {"frames": both}, parts, False))


def markdown(rows, count, seconds):
    lines = [
        f"{datetime.date.today()}, {platform.machine()}, {count} streams, {seconds:.0f} s with the builds:",
        "",
        "| build | what | streams | equal | seconds |",
        "|---|---|---|---|---|",
    ]
    return "\n".join([*lines, *(f"| `{a}` | {b} | {c} | {d} | {e} |" for a, b, c, d, e in rows)]) + "\n"


BEGIN, END = "<!-- result -->\n", "<!-- end result -->"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("builds", nargs="*", help="names; default: all")
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "build/matrix")
    parser.add_argument("--docs", action="store_true", help="write the table into docs/evidence/matrix.md")
    options = parser.parse_args()
    known = {build.name: build for build in builds()}
    unknown = set(options.builds) - set(known)
    if unknown:
        parser.error(f"unknown builds: {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    reference = next(iter(known))
    chosen = [
        known[name] for name in known if not options.builds or name in options.builds or name == reference
    ]
    options.folder.mkdir(parents=True, exist_ok=True)
    paths, first, rows, failed = cases(), None, [], []
    begin = time.monotonic()
    for build in chosen:
        missing = build.missing()
        if missing:
            print(f"{build.name}: skipped, there is no {', '.join(missing)}", file=sys.stderr)
            failed.append(build.name)
            continue
        try:
            command = make(build, options.folder)
            started = time.monotonic()
            parts, found = answers(command, paths)
        except DecoderError as error:
            print(f"{build.name}: {error}", file=sys.stderr)
            failed.append(build.name)
            continue
        taken = time.monotonic() - started
        first = first or found
        wrong = {}
        for name in paths:
            compared = parts - LEFT_OUT.get((build.name, name), set())
            wrong[name] = differences(build, compared, first[name], found[name])
        wrong = {name: lines for name, lines in wrong.items() if lines}
        for name in list(wrong)[:SHOWN]:
            print(f"{build.name}: {name}: {wrong[name][0]}", file=sys.stderr)
        if wrong:
            failed.append(build.name)
        rows.append((build.name, build.about, len(paths), len(paths) - len(wrong), f"{taken:.1f}"))
        print(
            f"{build.name:12} {len(paths):5} streams {len(paths) - len(wrong):5} equal {taken:7.1f} s",
            flush=True,
        )
    print(f"matrix.builds {len(rows)}")
    if options.docs:
        page = ROOT / "docs/evidence/matrix.md"
        before, rest = page.read_text().split(BEGIN)
        after = rest.split(END)[1]
        table = markdown(rows, len(paths), time.monotonic() - begin)
        page.write_text(before + BEGIN + "\n" + table + "\n" + END + after)
    if failed:
        print(f"not equal or not there: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    os.environ.setdefault("PYTHONDONTWRITEBYTECODE", "1")
    sys.exit(main())
