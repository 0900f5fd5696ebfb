"""Valid streams with extreme numbers, damaged ones and working files that somebody changed: an error, never a crash."""

import json
import pathlib
import resource
import subprocess
import wave

import pytest
from conftest import run, tool_path

STREAMS = sorted((pathlib.Path(__file__).parent / "hostile").glob("*.fvv"))
# Whatever a stream says, all of these end with an exit code.
RUNS = {
    "compare": ["fvvcompare", "{}", "{}", "--samples", 100],
    "demux": ["fvvdemux", "{}", "-o", "d", "--force"],
    "films": ["fvvdemux", "{}", "-o", "d", "--mp4", "--force"],
    "gltf": ["fvvdemux", "{}", "-o", "d", "--meshes", "glb", "--force"],
    "camera": ["fvvrender", "{}", "--camera", 0, "--size", "32x32", "-o", "v.png", "--force"],
    "film": [
        "fvvrender",
        "{}",
        "--camera",
        0,
        "--frames",
        "0-2",
        "--size",
        "32x32",
        "-o",
        "f%04d.png",
        "--force",
    ],
    "recover": ["fvvrecover", "{}", "-o", "r.fvv", "--force"],
    "segments": ["fvvmux", "{}", "--segments", "s", "--force"],
    "info": ["fvvinfo", "--check", "{}"],
}


def code_of(command, stream, cwd):
    words = [
        str(tool_path(command[0])),
        *(str(stream) if word == "{}" else str(word) for word in command[1:]),
    ]
    done = subprocess.run(words, cwd=cwd, capture_output=True, text=True, timeout=60)
    assert 0 <= done.returncode <= 3, (words, done.returncode, done.stderr)
    assert "Sanitizer" not in done.stderr and "runtime error" not in done.stderr, done.stderr
    return done


@pytest.mark.parametrize("stream", STREAMS, ids=lambda path: path.stem)
@pytest.mark.parametrize("name", RUNS)
def test_extreme_numbers(name, stream, tmp_path):
    code_of(RUNS[name], stream, tmp_path)


@pytest.mark.parametrize("name", ["origin1e160", "origin1e200", "step1e150", "step1e160", "step1e290"])
def test_what_cannot_be_compared_is_said(name, tmp_path):
    done = code_of(RUNS["compare"], STREAMS[0].parent / f"compare_{name}.fvv", tmp_path)
    assert done.returncode == 1 and "no frame could be compared" in done.stderr


def test_films_of_a_stream_whose_meshes_are_all_damaged(eight_frames, tmp_path):
    """The films are whole: they are written, and the loss is said."""
    run("fvvmux", eight_frames, "-o", tmp_path / "s.fvv")
    stream = bytearray((tmp_path / "s.fvv").read_bytes())
    at = 24
    while at + 32 <= len(stream):
        size = int.from_bytes(stream[at + 16 : at + 24], "little")
        if stream[at : at + 4] == b"MESH":
            stream[at + 32 + size // 2] ^= 1
        at += 32 + (size + 7) // 8 * 8
    (tmp_path / "d.fvv").write_bytes(stream)
    done = code_of(["fvvdemux", "{}", "-o", "d", "--mp4"], tmp_path / "d.fvv", tmp_path)
    assert done.returncode == 3, done.stderr
    assert list((tmp_path / "d").rglob("*.mp4")) and not list(tmp_path.glob(".*.partial"))


@pytest.mark.parametrize(
    "byte", [b"\x81", b"\xa1\x60", b"\x9f", b"\xd9\xd9\xf7"], ids=["array", "map", "endless", "tag"]
)
def test_nested_plans(byte, tmp_path):
    (tmp_path / "P").mkdir()
    (tmp_path / "P/plan.cbor").write_bytes(byte * 400000)
    done = code_of(["fvvmux", "--part", 1, "P"], "", tmp_path)
    assert done.returncode == 1 and "is no plan, or a damaged one" in done.stderr


def test_nested_reports_of_parts(eight_frames, tmp_path):
    run("fvvmux", eight_frames, "--frames", "0-2", "--group", 1, "--plan", tmp_path / "P")
    for group in (1, 2):  # the plan has the first one
        run("fvvmux", "--part", group, tmp_path / "P")
    report = tmp_path / "P/group-0.json"
    assert json.loads(report.read_text())["fvv_part"] == 2
    n = 400000
    report.write_text('{"warnings":' + "[" * n + "]" * n + ',"videos":[],"lower_meshes":[]}')
    done = code_of(["fvvmux", "--merge", "P", "-o", "m.fvv"], "", tmp_path)
    assert done.returncode == 1 and "the report of the part is damaged" in done.stderr


@pytest.mark.parametrize("channels", [1, 8])
def test_sound_of_one_sample_a_second(channels, eight_frames, tmp_path):
    """4 kB that would be resampled to 4 GB: within 2 GiB, which sanitizers need part of."""
    with wave.open(str(tmp_path / "bomb.wav"), "wb") as file:
        file.setparams((channels, 1, 1, 4000, "NONE", None))
        file.writeframes(bytes(range(200)) * 20 * channels)
    capture = json.loads((eight_frames / "capture.json").read_text())
    capture["audio"] = "bomb.wav"
    for path in eight_frames.iterdir():
        if path.name != "capture.json":
            (tmp_path / path.name).symlink_to(path)
    (tmp_path / "capture.json").write_text(json.dumps(capture))
    words = [str(tool_path("fvvmux")), str(tmp_path), "-o", str(tmp_path / "s.fvv"), "--threads", "1"]
    begin = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode in (0, 1, 3), done.stderr
    most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    assert most < max(begin, 2 << 20), "kilobytes of the largest process so far"
