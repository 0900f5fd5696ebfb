"""The reference decoder: whole vectors, damaged streams beside libfvv, and the parts that no stream shows alone."""

import base64
import json
import os
import pathlib
import random
import struct
import subprocess
import sys

import numpy
import pytest
from reference.container import rewritten
from reference.decode import lens, records
from reference.decoder import report
from streams import CONFORMANCE, cases, vectors

SEED = 20
STREAMS = sorted(case.path for case in cases("valid") if len(case.data) <= 8192)


class Decoder:
    """A decoder of the protocol, as a program."""

    def __init__(self, *command, **options):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self.process = subprocess.Popen([str(part) for part in command], **pipes, **options)

    def ask(self, **request):
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def decode(self, data):
        return self.ask(op="decode", id=1, data=base64.b64encode(data).decode())

    def close(self):
        self.process.stdin.close()
        return self.process.wait(timeout=20)


@pytest.fixture(scope="module")
def libfvv():
    tools = os.environ.get("FVV_TOOLS_DIR")
    adapter = pathlib.Path(tools or ".").resolve().parent / "conformance/fvv_conformance_libfvv"
    if not tools or not adapter.is_file():
        pytest.skip(f"the adapter of libfvv was not built: {adapter}")
    decoder = Decoder(adapter)
    yield decoder
    assert decoder.close() == 0


@pytest.mark.parametrize("path", vectors(), ids=lambda path: path.parent.name)
def test_vectors_are_whole_and_decode_to_the_arrays_of_libfvv(path, libfvv):
    data = path.read_bytes()
    own, other = report(data), libfvv.decode(data)
    assert (own["status"], own["issues"]) == ("whole", [])
    for part in "frames", "sounds", "environment":
        assert own[part] == other[part], part


def lies(data):
    """(offset, end, payload size) of each chunk of a whole stream."""
    at, out = 24, []
    while at < len(data):
        (size,) = struct.unpack_from("<Q", data, at + 16)
        end = at + 32 + (size + 7) // 8 * 8
        out.append((at, end, size))
        at = end
    return out


def damaged(data, chance):
    """A stream with one kind of damage to its bytes or its chunks."""
    out, spots = bytearray(data), lies(data)
    place, size = chance.randrange(len(data)), chance.choice([1, 4, 32, 200])
    what = chance.choice(
        ["flip", "cut", "delete", "repeat", "burst", "drop chunk", "repeat chunk", "swap chunks"]
    )
    if what == "flip":
        out[place] ^= 1 << chance.randrange(8)
    elif what == "cut":
        del out[place:]
    elif what == "delete":
        del out[place : place + size]
    elif what == "repeat":
        out[place:place] = out[place : place + size]
    elif what == "burst":
        out[place : place + size] = chance.randbytes(len(out[place : place + size]))
    elif what == "drop chunk":
        begin, end, _ = chance.choice(spots)
        del out[begin:end]
    elif what == "repeat chunk":
        begin, end, _ = chance.choice(spots)
        out[end:end] = out[begin:end]
    else:
        (a, b, _), (c, d, _) = sorted(chance.sample(spots, 2))
        out = data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:]
    return what, bytes(out)


def test_damaged_streams_show_nothing_that_was_not_sent_and_agree_with_libfvv(libfvv):
    chance, intact = random.Random(SEED), 0
    for _ in range(500):
        path = chance.choice(STREAMS)
        data = path.read_bytes()
        what, bad = damaged(data, chance)
        own, other, sent = report(bad), libfvv.decode(bad), report(data)
        label = f"{path.parent.name}: {what}"
        frames = {frame["time"]: frame["arrays"] for frame in own["frames"]}
        before = {frame["time"]: frame["arrays"] for frame in sent["frames"]}
        assert all(before.get(time) == arrays for time, arrays in frames.items()), label
        if own["status"] == "whole":  # a stream that was cut between groups, or has SCEN twice
            assert own["frames"] == sent["frames"][: len(own["frames"])], label
        assert all(frames.get(frame["time"]) == frame["arrays"] for frame in other["frames"]), label
        assert own["status"] == other["status"], label
        assert own["issues"][:1] == other["issues"][:1], label
        intact += len(frames)
    assert intact > 200


def changed(data, chance):
    """A stream whose container is in order around a changed byte of one payload."""
    spots = [
        spot
        for spot in lies(data)
        if spot[2] and data[spot[0] : spot[0] + 4] not in (b"GRUP", b"GEND", b"INDX", b"FOOT")
    ]
    out, kinds = bytearray(data), sorted({data[begin : begin + 4] for begin, _, _ in spots})
    kind = chance.choice(kinds)
    begin, _, size = chance.choice([spot for spot in spots if data[spot[0] : spot[0] + 4] == kind])
    at = begin + 32 + chance.randrange(size if chance.random() < 0.5 else min(size, 40))
    out[at] = chance.choice([0, 255, out[at] ^ 1 << chance.randrange(8), chance.randrange(256)])
    return rewritten(bytes(out))


def test_a_changed_payload_is_reported_at_its_chunk_or_decodes():
    chance, found = random.Random(SEED), set()
    for _ in range(500):
        data = chance.choice(STREAMS).read_bytes()
        try:
            bad = changed(data, chance)
        except (KeyError, struct.error, UnicodeDecodeError):
            continue  # unknown chunks, which the writer cannot write
        own = report(bad)
        offsets = {begin for begin, _, _ in lies(bad)}
        assert own["status"] in ("whole", "damaged")
        assert all(issue["offset"] in offsets for issue in own["issues"])
        found |= {issue["issue"][:5] for issue in own["issues"]}
    assert found >= {"FVV-2", "FVV-3", "FVV-4"}


def test_the_program_speaks_the_protocol():
    decoder = Decoder(sys.executable, "-m", "reference", cwd=CONFORMANCE)
    hello = decoder.ask(op="hello", protocol=1)
    assert (hello["protocol"], hello["name"]) == (1, "reference") and "check" in hello["parts"]
    path = CONFORMANCE / "tiny/cameras.fvv"
    by_path = decoder.ask(op="decode", id=7, path=str(path))
    assert by_path == {"id": 7, **json.loads(json.dumps(report(path.read_bytes())))}
    cut = decoder.ask(op="decode", id=8, data=base64.b64encode(path.read_bytes()[:-56]).decode(), live=True)
    assert (cut["status"], cut["summary"]["ended"]) == ("whole", False)
    decoder.process.stdin.write('{"op":"quit"}\n')
    assert decoder.close() == 0


@pytest.mark.parametrize("model, k", [
    (lens.RADTAN, (-0.3, 0.1, 0, 0, 0, 0, 0, 0)),
    (lens.RADTAN, (-0.3, 0, 0, 0, 0, 0, 0, 0)),
    (lens.RADTAN, (0.2, -0.4, 0, 0, 0.05, 0.1, -0.2, 0)),
    (lens.RADTAN, (0, 0, 0, 0, 0, -0.5, 0, 0)),
    (lens.FISHEYE, (-0.05, 0.01, -0.2, 0.0, 0, 0, 0, 0)),
])  # fmt: skip
def test_the_radius_of_a_lens_is_where_its_radial_function_stops_to_rise(model, k):
    radius = lens.radius(model, k)
    r = numpy.linspace(0, min(radius, 10), 20001)[1:]
    s = r * r
    if model == lens.RADTAN:
        value = r * (1 + k[0] * s + k[1] * s**2 + k[4] * s**3) / (1 + k[5] * s + k[6] * s**2 + k[7] * s**3)
    else:
        value = r * (1 + k[0] * s + k[1] * s**2 + k[2] * s**3 + k[3] * s**4)
    assert (numpy.diff(value[:-1]) > 0).all()


def test_the_radius_without_a_root_is_infinite():
    assert lens.radius(lens.RADTAN, (0.1, 0.1, 0, 0, 0.1, 0, 0, 0)) == float("inf")
    assert lens.radius(lens.RADTAN, (-1 / 3, 0, 0, 0, 0, 0, 0, 0)) == pytest.approx(1, rel=1e-12)


def test_codec_strings_of_hevc():
    assert records.hevc_string(1, 0x60000000, b"\xb0\0\0\0\0\0", 93) == b"hvc1.1.6.L93.b0"
    assert (
        records.hevc_string(0x22, 0x20000000, b"\x90\0\0\0\0\x01", 120) == b"hvc1.2.4.H120.90.00.00.00.00.01"
    )
