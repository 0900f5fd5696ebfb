"""The description for Kaitai and the reference decoder find the same chunks, with the same fields."""

import json
import shutil
import struct
import subprocess

import pytest
from conftest import CONFORMANCE, ROOT, cases, vectors
from reference.container import PACKED, STRUCTURES
from reference.decode.scan import Chunk, scan


@pytest.fixture(scope="module")
def readings():
    """What conformance/kaitai/read.mjs finds in each stream, by path."""
    node = shutil.which("node")
    if not node or not (ROOT / "js/node_modules/kaitai-struct-compiler").is_dir():
        pytest.skip("no Node, or no js/node_modules: run npm install --no-package-lock in js")
    paths = [*vectors(), *(case.path for tier in ("valid", "uncommon", "faulty") for case in cases(tier))]
    done = subprocess.run(
        [node, CONFORMANCE / "kaitai/read.mjs"],
        input="".join(f"{path}\n" for path in paths),
        capture_output=True,
        text=True,
    )
    assert (done.stderr, done.returncode) == ("", 0)
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert [reading["path"] for reading in found] == [str(path) for path in paths]
    return {reading["path"]: reading for reading in found}


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


def same(kaitai, own):
    """Whether all fields are equal. Codes of four bytes are text in Kaitai's reading."""
    for name, values in own.items():
        found = flat(kaitai[name])
        if len(found) == 1 and isinstance(found[0], str) and len(values) == 4:
            found = [float(byte) for byte in found[0].encode()]
        found = [float(x) for x in found]
        if found != values and not any(x != x for x in found + values):
            return False
    return True


def compare(path, reading):
    """Asserts that both readings of a stream are the same, and returns the number of its chunks."""
    data = path.read_bytes()
    assert same({**reading["header"], "signature": list(data[:8])}, fields("file header", data))
    chunks = list(scan(data))
    assert [chunk["offset"] for chunk in reading["chunks"]] == [chunk.offset for chunk in chunks]
    for chunk, found in zip(chunks, reading["chunks"]):
        assert same(found, fields("chunk header", data[chunk.offset :])), (path, chunk.offset)
        name = f"{chunk.kind.decode()} payload"
        if name in STRUCTURES:
            assert same(found["payload"], fields(name, chunk.payload)), (path, chunk.offset)
    return len(chunks)


def test_whole_streams_have_the_same_chunks(readings):
    whole = [*vectors(), *(case.path for tier in ("valid", "uncommon") for case in cases(tier))]
    errors = {str(path): readings[str(path)]["error"] for path in whole if "error" in readings[str(path)]}
    assert errors == {}
    assert sum(compare(path, readings[str(path)]) for path in whole) > 500


def test_faulty_streams_whose_chunks_are_whole_have_the_same_chunks(readings):
    compared = 0
    for case in cases("faulty"):
        reading = readings[str(case.path)]
        if "error" not in reading and all(isinstance(found, Chunk) for found in scan(case.data)):
            compare(case.path, reading)
            compared += 1
    assert compared > 50


def test_the_description_refuses_what_breaks_its_fields(readings):
    refused = {case.name for case in cases("faulty") if "error" in readings[str(case.path)]}
    wanted = {case.name for case in cases("faulty") if case.expected["issues"][0]["issue"] == "FVV-1001"}
    assert wanted and wanted <= refused
