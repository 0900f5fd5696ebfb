"""Layouts of groups: the reader that was written from the specification reads the vector, and the tools do."""

import tiles
from conftest import ROOT

VECTORS = ROOT / "conformance" / "tiles"


def test_plain_reader_gives_the_listed_layouts():
    assert (
        list(tiles.lines((VECTORS / "crops.fvv").read_bytes()))
        == (VECTORS / "crops.txt").read_text().splitlines()
    )


def test_vector_uses_what_clause_10_11_has():
    found = [by_track[2] for _, by_track in tiles.layouts((VECTORS / "crops.fvv").read_bytes())]
    assert found[0] == found[3]
    assert len({str(layout) for layout in found}) == 4
    assert [camera for camera, *_ in found[2]] == [1]
    assert any(source[2:] != destination[2:] for layout in found for _, source, destination in layout)


def test_fvvinfo_finds_every_frame_whole(fvvinfo):
    done = fvvinfo("--check", VECTORS / "crops.fvv")
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"3 layouts of groups" in done.stdout
