"""Golden streams are decoded to the same bits, and are never written again once they are of version 1.0."""

import json
import shutil

import golden
import pytest
from fvv_conformance import FORMAT, cases


def test_every_decoder_finds_what_was_found():
    found, differing = golden.check(golden.GOLDEN)
    assert {case.path.parent.name for case in found} == golden.STREAMS.keys()
    assert differing == {}


def test_they_are_of_this_version_or_of_one_that_does_not_change():
    of = json.loads((golden.GOLDEN / golden.LIST).read_text())["format"]
    assert of == FORMAT or golden.version(of) >= (1, 0), "run conformance/golden.py --write"


@pytest.fixture()
def copy(tmp_path):
    return shutil.copytree(golden.GOLDEN, tmp_path / "golden")


def test_a_stream_of_1_0_is_never_written_again(copy):
    path = copy / golden.LIST
    listed = json.loads(path.read_text())
    for version, frozen in (("0.2", False), ("0.9", False), ("1.0", True), ("1.1", True), ("2.0", True)):
        path.write_text(json.dumps({**listed, "format": version}))
        if not frozen:
            golden.refuse_frozen(copy)
            continue
        before = {file: file.read_bytes() for file in copy.rglob("*.*") if file.is_file()}
        with pytest.raises(golden.Frozen, match="never written again"):
            golden.write(copy)
        assert before == {file: file.read_bytes() for file in copy.rglob("*.*") if file.is_file()}


def test_another_stream_or_another_result_is_found(copy):
    stream = copy / "valid/hulls/input.fvv"
    data = bytearray(stream.read_bytes())
    data[-1] ^= 1
    stream.write_bytes(data)
    expected = copy / "valid/tracked/expected.json"
    report = json.loads(expected.read_text())
    report["frames"][0]["arrays"]["mesh/1/lattice"] = "0" * 64
    expected.write_text(json.dumps(report))
    _, differing = golden.check(copy, ["reference"])
    assert differing.keys() == {"hulls", "tracked"}
    assert golden.changed_files(copy) == ["hulls"]
    assert len(cases.load(copy)) == len(golden.STREAMS)
