"""Visibility: the decoder that was written from the specification reads the vector, and the tools do."""

import math

import pytest
import visibility
from conftest import ROOT

VECTORS = ROOT / "conformance" / "visibility"


@pytest.mark.parametrize("name, count", [("sheet", 10), ("moving", 5), ("shares", 5)])
def test_plain_decoder_gives_the_listed_states(name, count):
    wanted = (VECTORS / f"{name}.crc").read_text().split()
    assert list(visibility.state_crcs((VECTORS / f"{name}.fvv").read_bytes())) == wanted
    assert len(set(wanted)) == count


def test_cameras_that_are_lost_have_no_bits():
    decoded = [states for _, states in visibility.decode((VECTORS / "moving.fvv").read_bytes())]
    assert [sorted(states) for states in decoded] == [[2, 7, 9], [2, 7, 9], [2, 7], [2, 7, 9], [2, 7, 9]]
    # The sheet waves; cameras that move add to what turns.
    turned = [sum(bool(a) != bool(b) for a, b in zip(decoded[0][c], decoded[4][c])) for c in (2, 7, 9)]
    assert min(turned[1:]) > turned[0]


def test_vector_uses_what_clause_17_has():
    decoded = list(visibility.decode((VECTORS / "sheet.fvv").read_bytes()))
    assert {track for track, _ in decoded} == {2, 3}
    for _, states in decoded:
        assert sorted(states) == [2, 7, 300]
        assert {state for row in states.values() for state in row} == {0, 1, 2}
        assert len({tuple(row) for row in states.values()}) == 3
    payloads = [
        p for kind, _, _, p in visibility.chunks((VECTORS / "sheet.fvv").read_bytes()) if kind == b"VISI"
    ]
    assert {(p[0], p[1]) for p in payloads} == {(0, 64), (1, 10)}
    assert [p[8] for p in payloads] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]


def test_plain_facing_is_the_cosine():
    camera = [3000, -1000, 2500]
    for corners in ([0, 0, 0], [900, 40, 10], [30, 800, -20]), ([5, 5, 5], [6, 900, 70], [-700, 3, 400]):
        u, v, w = ([corners[i][a] - corners[0][a] for a in range(3)] for i in (1, 2, 0))
        n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        w = [camera[a] - sum(c[a] for c in corners) / 3 for a in range(3)]
        cosine = sum(map(math.prod, zip(n, w))) / math.hypot(*n) / math.hypot(*w)
        assert 0.1 < cosine < 0.99
        passes = [visibility.face_faces(corners, camera, t) for t in range(256)]
        assert abs(sum(passes) - 256 * cosine) < 2
        assert passes == sorted(passes, reverse=True)


@pytest.mark.parametrize("name", ["sheet", "moving", "shares"])
def test_fvvinfo_finds_every_frame_whole(fvvinfo, name):
    done = fvvinfo("--check", VECTORS / f"{name}.fvv")
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"visibility" in done.stdout.lower()


def test_vector_of_shares_has_every_state():
    decoded = list(visibility.decode((VECTORS / "shares.fvv").read_bytes()))
    assert len(decoded) == 5
    assert {s for _, states in decoded for row in states.values() for s in row} == set(range(7))
    payloads = [p for k, _, _, p in visibility.chunks((VECTORS / "shares.fvv").read_bytes()) if k == b"VISI"]
    assert [(p[0], p[8]) for p in payloads] == [(2, n) for n in range(5)]
