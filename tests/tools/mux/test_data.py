"""fvvmux --data and fvvdemux: captions and sequences of files of other formats, carried bit for bit."""

import json

import pytest
from conftest import run
from reference.container import chunks

CAPTIONS = """WEBVTT

STYLE
::cue { color: white }

NOTE not for the stream

first
00:00.000 --> 00:00.100
The ball is in.

00:00.040 --> 00:00.250 line:0
Two points.

00:10.000 --> 00:11.000
After the end.
"""


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data") / "capture"
    run("fvvsynth", "-o", folder, "--rig", "small", "--frames", 4, "--size", "64x36", "--cameras", 2)
    return folder


def payloads(stream, kind):
    return [chunk.payload for chunk in chunks(stream.read_bytes()) if chunk.kind == kind]


def mux(capture, out, *options, **more):
    return run("fvvmux", capture, "-o", out, "--group", 2, "--keep-geometry", *options, **more)


def test_captions_of_a_group_are_a_file_of_the_cues_that_overlap_it(capture, tmp_path):
    source = tmp_path / "english.vtt"
    source.write_text(CAPTIONS, newline="\r\n")
    mux(capture, tmp_path / "a.fvv", "--data", source, "--verify")
    # Groups of 80 ms: the first cue ends in the second one, and the second begins in the first.
    first, second = (payload.decode() for payload in payloads(tmp_path / "a.fvv", b"DATA"))
    assert first == second
    assert first.startswith("WEBVTT\n\nSTYLE\n::cue { color: white }\n\nfirst\n00:00.000 --> 00:00.100\n")
    assert first.endswith("\n\n00:00.040 --> 00:00.250 line:0\nTwo points.\n")
    track = next(
        t
        for t in json.loads(run("fvvinfo", "--json", tmp_path / "a.fvv").stdout)["files"][0]["tracks"]
        if t["kind"] == "data"
    )
    assert (track["name"], track["data"]) == ("english", {"media_type": "text/vtt", "codec": ""})


def test_a_sequence_comes_back_bit_for_bit(capture, tmp_path):
    splats, models = tmp_path / "splats", tmp_path / "models"
    for folder, extension in (splats, "spz"), (models, "glb"):
        folder.mkdir()
        for i in range(4):
            (folder / f"{i:03}.{extension}").write_bytes(bytes(range(i, 256)) * (i + 1))
    (splats / "003.spz").write_bytes(b"")
    mux(capture, tmp_path / "b.fvv", "--data", f"{splats},{models}", "--verify")
    done = json.loads(run("fvvdemux", tmp_path / "b.fvv", "-o", tmp_path / "out", "--json").stdout)
    assert done["data"] == 8
    for track, folder, extension in (10201, splats, "spz"), (10202, models, "glb"):
        found = sorted((tmp_path / f"out/data/{track}").iterdir())
        assert [file.name for file in found] == [f"{i:06}.{extension}" for i in range(4)]
        assert [file.read_bytes() for file in found] == [
            file.read_bytes() for file in sorted(folder.iterdir())
        ]
    run("fvvdemux", tmp_path / "b.fvv", "-o", tmp_path / "without", "--no-data")
    assert not (tmp_path / "without/data").exists()


def test_what_does_not_fit_is_refused_before_anything_is_written(capture, tmp_path):
    folder = tmp_path / "few"
    folder.mkdir()
    (folder / "1.spz").write_bytes(b"x")
    wrong = tmp_path / "wrong.vtt"
    wrong.write_text("WEBVTT\n\n00:02.000 --> 00:01.000\nBackwards.\n")
    (tmp_path / "no.vtt").write_text("1\n00:00:01,000 --> 00:00:02,000\nSubRip.\n")
    for path, code, text in (
        (folder, 2, "1 files for 4 frames: expected one for each"),
        (tmp_path / "captions.srt", 2, "expected a WebVTT file (.vtt), or a folder"),
        (tmp_path / "missing.vtt", 1, "missing.vtt"),
        (wrong, 1, "wrong.vtt: line 3: expected times such as"),
        (tmp_path / "no.vtt", 1, "no.vtt: line 1: expected WEBVTT"),
    ):
        done = mux(capture, tmp_path / "c.fvv", "--data", path, code=code)
        assert text in done.stderr
        assert not (tmp_path / "c.fvv").exists()
