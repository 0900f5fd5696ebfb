#!/usr/bin/env python3
"""Golden streams: what fvvmux wrote once, which every later version decodes to the same bits (conformance/golden/README.md).

--write packs them again and writes what the reference decoder finds in them. It does so up to version 1.0 of the format: streams of
1.0 or later are never written again. Without --write: decodes them with the decoders that are built and compares; fvvrecover
has to copy them without a change. Exit 1 when something differs.
"""

import argparse
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

from adapters import all as adapters
from fvv_conformance import FORMAT, cases, running

HERE = pathlib.Path(__file__).resolve().parent
GOLDEN = HERE / "golden"
LIST = "golden.json"
DECODERS = ("libfvv", "wasm", "python", "reference")
SMALL = ["--rig", "small", "--frames", "4", "--size", "96x54", "--cameras", "4"]

#: Title, clauses, and the options of fvvsynth and fvvmux.
STREAMS = {
    "hulls": (
        "Hulls with other triangles in every frame: Draco, H.264, two groups.",
        ["8.4", "10.5"],
        [*SMALL, "--meshes", "hull", "--hull-cells", "24"],
        ["--group", "2"],
    ),
    "tracked": (
        "A tracked surface: delta frames, visibility and colours; VP9.",
        ["8.7", "10.8", "17", "19"],
        SMALL,
        ["--triangles", "600", "--visibility", "weight", "--codec", "vp9", "--group", "4"],
    ),
    "ladder": (
        "Two rungs of a ladder; AV1.",
        ["5.2", "10.9"],
        SMALL,
        ["--triangles", "600", "--ladder", "36dB,30dB", "--codec", "av1"],
    ),
    "live": (
        "Without index: the fast profile, JPEG, cameras with lenses of which one moves.",
        ["7.3", "8.11", "9", "10.4"],
        ["--frames", "2", "--size", "64x36"],
        ["--live", "--codec", "jpeg", "--quality", "60", "--mesh-profile", "fast", "--triangles", "600"],
    ),
    "wide": (
        "Raw meshes and OpenEXR.",
        ["8.3", "10.12"],
        ["--rig", "small", "--frames", "2", "--size", "48x32", "--cameras", "2", "--pictures", "exr"],
        ["--codec", "exr", "--mesh-profile", "raw", "--triangles", "300"],
    ),
    "stage": (
        "An environment and sound from two places; HEVC.",
        ["10.7", "18", "20"],
        ["--rig", "small", "--frames", "2", "--size", "64x36", "--cameras", "3", "--environment", "--sound"],
        ["--triangles", "600", "--codec", "hevc"],
    ),
}


class Frozen(Exception):
    pass


def version(text):
    return tuple(int(part) for part in text.split("."))


def refuse_frozen(folder):
    """Streams of 1.0 stay as they are, whatever writes streams later."""
    path = folder / LIST
    if path.exists() and version(json.loads(path.read_text())["format"]) >= (1, 0):
        raise Frozen(
            f"{path}: these are streams of a version that does not change; they are never written again"
        )


def tool(name, *arguments):
    program = adapters.build_folder() / "tools" / name / name
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        raise SystemExit(f"golden.py: {name} ended with {done.returncode}: {done.stderr.strip()}")


def expectation(name, data):
    """expected.json in the form of a conformance case, by the reference decoder."""
    from generate import case
    from reference.decoder import report

    title, clauses, *_ = STREAMS[name]
    found = report(data)
    if found["status"] != "whole":
        raise SystemExit(
            f"golden.py: {name}: the reference decoder calls it {found['status']}: {found['issues'][:1]}"
        )
    if not found["summary"]["ended"]:
        del found["summary"]["indexed"]
    about = {
        "name": name,
        "title": title,
        "clauses": clauses,
        "source": "written by fvvmux",
        "format": FORMAT,
    }
    return case.text(about | found)


def write(folder):
    refuse_frozen(folder)
    hashes = {}
    with tempfile.TemporaryDirectory() as work:
        for name, (_, _, synth, mux) in STREAMS.items():
            capture, stream = pathlib.Path(work) / name, pathlib.Path(work) / f"{name}.fvv"
            tool("fvvsynth", "-o", capture, *synth)
            tool("fvvmux", capture, "-o", stream, *mux)
            home, data = folder / "valid" / name, stream.read_bytes()
            home.mkdir(parents=True, exist_ok=True)
            (home / "input.fvv").write_bytes(data)
            (home / "expected.json").write_bytes(expectation(name, data))
            hashes[name] = hashlib.sha256(data).hexdigest()
    (folder / LIST).write_text(json.dumps({"format": FORMAT, "sha256": hashes}, indent=1) + "\n")


def changed_files(folder):
    """Names of the streams that are not those of the list."""
    listed = json.loads((folder / LIST).read_text())["sha256"]
    there = {case.path.parent.name: hashlib.sha256(case.content).hexdigest() for case in cases.load(folder)}
    return sorted(name for name in listed.keys() | there.keys() if listed.get(name) != there.get(name))


def copy_differs(path):
    """Whether the copy that fvvrecover writes of a stream has other bytes."""
    with tempfile.TemporaryDirectory() as work:
        copy = pathlib.Path(work) / "copy.fvv"
        tool("fvvrecover", path, "-o", copy)
        return copy.read_bytes() != path.read_bytes()


def check(folder, names=DECODERS):
    """Streams, and a line for each that differs somewhere."""
    found = cases.load(folder)
    differing = {name: ["the file is not that of the list"] for name in changed_files(folder)}
    for decoder in names:
        if reason := adapters.missing(decoder):
            print(f"skipped: {decoder}: {reason}")
            continue
        for outcome in running.test_decoder(adapters.commands()[decoder][0], found, 1, 60).outcomes:
            for line in outcome.differences[:3]:
                differing.setdefault(outcome.case.split("/")[1], []).append(f"{decoder}: {line}")
    for case in found:
        if case.expected["summary"]["ended"] and copy_differs(case.path):
            name = case.path.parent.name
            differing.setdefault(name, []).append("fvvrecover: the copy has other bytes")
    return found, differing


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--write", action="store_true", help="pack them again; refused from format 1.0 on")
    arguments = parser.parse_args()
    if arguments.write:
        try:
            write(GOLDEN)
        except Frozen as error:
            print(f"golden.py: {error}", file=sys.stderr)
            return 1
    found, differing = check(GOLDEN)
    for name, lines in sorted(differing.items()):
        for line in lines:
            print(f"{name}: {line}")
    print(f"golden.streams {len(found)}")
    print(f"golden.identical {len(found) - len(differing)}")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
