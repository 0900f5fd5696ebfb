"""Compares what the description for Kaitai finds in streams with what the reference decoder finds: chunks, offsets and fields."""

import json
import pathlib
import shutil
import struct
import subprocess

from reference.container import PACKED, STRUCTURES
from reference.decode.scan import Chunk, scan

HERE = pathlib.Path(__file__).resolve().parent
COMPILER = HERE.parent.parent / "js/node_modules/kaitai-struct-compiler"


def missing():
    """Why it cannot run here; None: it can."""
    if not shutil.which("node"):
        return "no Node"
    return None if COMPILER.is_dir() else "no js/node_modules: run npm ci in js"


def read(paths):
    """What read.mjs finds in each stream, in the order of the paths: header and chunks, or an error."""
    done = subprocess.run(
        [shutil.which("node"), HERE / "read.mjs"],
        input="".join(f"{path}\n" for path in paths),
        capture_output=True,
        text=True,
    )
    if done.returncode or done.stderr:
        raise RuntimeError(f"read.mjs: exit {done.returncode}: {done.stderr.strip()}")
    readings = [json.loads(line) for line in done.stdout.splitlines()]
    if [reading["path"] for reading in readings] != [str(path) for path in paths]:
        raise RuntimeError("read.mjs: not one line for each stream")
    return readings


def flat(value):
    """The numbers of a field: of a list, of a structure, or of flags, whose bits are named."""
    if isinstance(value, dict):
        values = list(value.values())
        if all(isinstance(v, bool) for v in values[:-1]) and len(values) > 1:
            return [float(sum(int(v) << bit for bit, v in enumerate(values)))]
        return [x for v in values for x in flat(v)]
    if isinstance(value, list):
        return [x for v in value for x in flat(v)]
    return [float(value) if not isinstance(value, str) else value]


def camel(name):
    first, *rest = name.split("_")
    return first + "".join(word.capitalize() for word in rest)


def fields(name, data):
    """The fields of a structure of spec/chunks.json as lists of numbers, by name; text as it is."""
    out = {}
    for field in STRUCTURES[name]["fields"]:
        kind, _, count = field["type"].rstrip("]").partition("[")
        values = struct.unpack_from(f"<{count or 1}{PACKED[kind]}", data, field["offset"])
        out[camel(field["name"])] = [float(value) for value in values]
    return out


def unequal(kaitai, own):
    """The first field that differs, with both values; None if all are equal. Codes of four bytes are text in Kaitai's reading."""
    for name, values in own.items():
        found = flat(kaitai[name])
        if len(found) == 1 and isinstance(found[0], str) and len(values) == 4:
            found = [float(byte) for byte in found[0].encode()]
        found = [float(x) for x in found]
        if found != values and not any(x != x for x in found + values):
            return f"{name} is {found} and {values}"
    return None


def differences(data, reading):
    """Sentences about what the two readings of a stream do not share; [] if they agree."""
    if "error" in reading:
        return [f"refused: {reading['error']}"]
    chunks = list(scan(data))
    if [chunk["offset"] for chunk in reading["chunks"]] != [chunk.offset for chunk in chunks]:
        return ["the chunks have other offsets"]
    pairs = [("header", {**reading["header"], "signature": list(data[:8])}, fields("file header", data))]
    for chunk, found in zip(chunks, reading["chunks"]):
        place = f"{chunk.kind.decode()} at {chunk.offset:#x}"
        pairs.append((place, found, fields("chunk header", data[chunk.offset :])))
        name = f"{chunk.kind.decode()} payload"
        if name in STRUCTURES:
            pairs.append((f"payload of {place}", found["payload"], fields(name, chunk.payload)))
    return [f"{place}: {wrong}" for place, kaitai, own in pairs if (wrong := unequal(kaitai, own))]


def comparable(data):
    """Whether all chunks of a stream are whole: a description has no CRCs, and cannot go on after damage."""
    return all(isinstance(found, Chunk) for found in scan(data))
