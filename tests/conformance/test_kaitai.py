"""The description for Kaitai and the reference decoder find the same chunks, with the same fields."""

import pytest
from kaitai import compare
from streams import cases


@pytest.fixture(scope="module")
def readings():
    """What conformance/kaitai/read.mjs finds in each stream, by path."""
    if reason := compare.missing():
        pytest.skip(reason)
    paths = [case.path for tier in ("valid", "uncommon", "faulty") for case in cases(tier)]
    return {reading["path"]: reading for reading in compare.read(paths)}


def test_whole_streams_have_the_same_chunks(readings):
    whole = [case.path for tier in ("valid", "uncommon") for case in cases(tier)]
    found = {path: compare.differences(path.read_bytes(), readings[str(path)]) for path in whole}
    assert {path: wrong for path, wrong in found.items() if wrong} == {}
    assert sum(len(readings[str(path)]["chunks"]) for path in whole) > 500


def test_faulty_streams_whose_chunks_are_whole_have_the_same_chunks(readings):
    whole = [case for case in cases("faulty") if compare.comparable(case.data)]
    found = {case.name: (case.data, readings[str(case.path)]) for case in whole}
    found = {name: compare.differences(*pair) for name, pair in found.items() if "error" not in pair[1]}
    assert {name: wrong for name, wrong in found.items() if wrong} == {}
    assert len(found) > 50


def test_a_wrong_field_a_lost_chunk_and_a_refusal_are_differences(readings):
    case = cases("valid")[0]
    reading = readings[str(case.path)]
    header = {**reading["header"], "readerMinor": 77}
    assert "readerMinor" in compare.differences(case.data, {**reading, "header": header})[0]
    assert "offsets" in compare.differences(case.data, {**reading, "chunks": reading["chunks"][:-1]})[0]
    assert "refused" in compare.differences(case.data, {"path": "", "error": "short"})[0]


def test_the_description_refuses_what_breaks_its_fields(readings):
    refused = {case.name for case in cases("faulty") if "error" in readings[str(case.path)]}
    wanted = {case.name for case in cases("faulty") if case.expected["issues"][0]["issue"] == "FVV-1001"}
    assert wanted and wanted <= refused
