"""Normals: the decoder that was written from the specification reads the vector, and the tools do."""

import itertools
import json
import math

import normals
import pytest
from conftest import ROOT

VECTORS = ROOT / "conformance" / "normals"


def test_plain_decoder_gives_the_listed_normals():
    wanted = (VECTORS / "cube.crc").read_text().split()
    stream = (VECTORS / "cube.fvv").read_bytes()
    assert list(normals.crcs(stream)) == wanted
    assert len(set(wanted)) == 10
    lengths = {round(math.hypot(*n), 6) for n in itertools.chain(*normals.frames(stream))}
    assert lengths == {0, 1}


@pytest.mark.parametrize("bits", [2, 3, 6])
def test_indices_come_back_but_for_the_rim(bits):
    last = 2**bits - 2
    for pair in itertools.product(range(last + 1), repeat=2):
        again = normals.nearest(bits, normals.sent(bits, pair))
        assert again == pair or {0, last} & set(pair)
        assert normals.sent(bits, again) == pytest.approx(normals.sent(bits, pair), abs=1e-12)


def test_fvvinfo_tells_of_normals(fvvinfo):
    done = fvvinfo(VECTORS / "cube.fvv", "--check", "--json")
    assert (done.returncode, done.stderr) == (0, b"")
    (track,) = json.loads(done.stdout)["files"][0]["tracks"]
    assert track["mesh"]["normals"] == {"chunks": 5, "bits": [9, 9]}
    assert b"normals of 9 bits in 5 chunks" in fvvinfo(VECTORS / "cube.fvv").stdout
