"""Texturing: the reader that was written from the specification reads the vectors, and fvvinfo does."""

import json

import pytest
import texturing
from conftest import ROOT

VECTORS = ROOT / "conformance" / "texturing"


@pytest.mark.parametrize("name", ["told", "untold"])
def test_plain_reader_gives_the_listed_constants(name):
    found = list(texturing.lines((VECTORS / f"{name}.fvv").read_bytes()))
    assert found == (VECTORS / f"{name}.txt").read_text().splitlines()
    assert len(found) == 2


def test_vectors_have_all_constants_and_none():
    told, untold = (
        set(texturing.groups((VECTORS / f"{name}.fvv").read_bytes())) for name in ("told", "untold")
    )
    assert untold == {texturing.Texturing()}
    (said,) = told
    assert all(a != b for a, b in zip(said, texturing.Texturing()))


def test_weights_are_those_of_clause_17_5():
    cosines = {1: 0.5, 2: 0.2, 3: 1.0, 4: 0.3, 5: 0.7}
    assert texturing.weights(texturing.Texturing(), cosines) == pytest.approx(
        {3: 1 / 2.2, 5: 0.7 / 2.2, 1: 0.5 / 2.2}
    )
    assert texturing.weights(texturing.Texturing(threshold=0.7, best=1), cosines) == {3: 1}
    assert texturing.weights(texturing.Texturing(), {2: 0.2}) is None


def test_rules_have_their_numbers():
    good = next(
        p for kind, _, p in texturing.tiles.chunks((VECTORS / "told.fvv").read_bytes()) if kind == b"TEXR"
    )
    texturing.decode(good)
    for bad, issue in (
        (good + b"\0", "6101"),
        (good[:31] + b"\1", "6101"),
        (good[:24] + b"\0" + good[25:], "6102"),
        (b"\0" * 6 + b"\xf8\x7f" + good[8:], "6102"),
    ):
        with pytest.raises(AssertionError, match=issue):
            texturing.decode(bad)


def test_fvvinfo_tells_the_same(fvvinfo):
    found = {}
    for name in ("told", "untold"):
        done = fvvinfo("--check", VECTORS / f"{name}.fvv", "--json")
        assert (done.returncode, done.stderr) == (0, b"")
        found[name] = json.loads(done.stdout)["files"][0].get("texturing")
    (said,) = set(texturing.groups((VECTORS / "told.fvv").read_bytes()))
    assert found == {"told": {**said._asdict(), "unseen": list(said.unseen)}, "untold": None}
