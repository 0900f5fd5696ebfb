"""Delta frames: the decoder that was written from the specification reads the vector, and the tools do."""

import delta
from conftest import ROOT

VECTORS = ROOT / "conformance" / "delta"


def test_plain_decoder_gives_the_listed_positions():
    wanted = (VECTORS / "field.crc").read_text().split()
    assert list(delta.position_crcs((VECTORS / "field.fvv").read_bytes())) == wanted
    assert len(set(wanted)) == 6  # the fourth frame stands still


def test_vector_uses_what_the_profile_has():
    stream = (VECTORS / "field.fvv").read_bytes()
    payloads = list(delta.mesh_payloads(stream))
    hierarchy = delta.Levels(*delta.raw_mesh(payloads[0]))
    assert len(hierarchy.levels) >= 4 and hierarchy.twins
    steps, sizes = set(), set()
    for payload in payloads[1:]:
        numbers = delta.Numbers(payload, 18)
        for _ in hierarchy.levels:
            steps.add(numbers.next())
            sizes.add(numbers.next())
    assert steps == {4, 6, 9, 15} and 0 in sizes


def test_fvvinfo_finds_every_frame_whole(fvvinfo):
    done = fvvinfo(VECTORS / "field.fvv")
    assert (done.returncode, done.stderr) == (0, b"")
