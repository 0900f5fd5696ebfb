"""fvvdemux --mp4: the video tracks as they are in the stream."""

import json
from fractions import Fraction

import av
import numpy as np
import pytest
from conftest import ROOT, figures, read_json, run, small_capture
from PIL import Image
from test_damage import chunks_of

FRAMES = 6
GROUP = 3


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    root = tmp_path_factory.mktemp("films")
    run("fvvsynth", "-o", root / "capture", "--atlas", "--rig", "small", "--frames", FRAMES, "--cameras", 2,
        "--size", "160x96")  # fmt: skip
    return root / "capture"


def stream_of(capture, path, codec="h264"):
    run(
        "fvvmux",
        capture,
        "-o",
        path,
        "--codec",
        codec,
        "--keep-geometry",
        "--group",
        GROUP,
        "--visibility",
        "none",
    )
    return path


def decoded(path):
    """Times in seconds, and luma, 0 to 1."""
    with av.open(str(path)) as film:
        frames = list(film.decode(video=0))
    return [f.time for f in frames], [(f.to_ndarray()[: f.height] - 16.0) / 219 for f in frames]


@pytest.mark.parametrize("codec", ["h264", "hevc"])
def test_the_film_of_the_atlas_has_its_pictures_at_their_times(capture, tmp_path, codec):
    stream = stream_of(capture, tmp_path / "s.fvv", codec)
    told = figures("fvvdemux", stream, "-o", tmp_path / "out", "--mp4")
    films = sorted((tmp_path / "out/video").iterdir())
    assert told["films"] == len(films) == 2
    same = 0
    for film in films:
        times, pictures = decoded(film)
        rate = Fraction(json.loads((tmp_path / "out/capture.json").read_text())["frame_rate"])
        assert times == pytest.approx([float(i / rate) for i in range(FRAMES)])
        for i, picture in enumerate(pictures):
            own = np.array(Image.open(tmp_path / f"out/atlas/{i:04d}.png")) @ [0.2126, 0.7152, 0.0722] / 255
            same += own.shape == picture.shape and np.abs(own - picture).mean() < 0.005
    assert same == FRAMES


def test_frames_are_whole_groups(capture, tmp_path):
    stream = stream_of(capture, tmp_path / "s.fvv")
    bare = ["--meshes", "none", "--pictures", "none", "--mp4"]
    done = run("fvvdemux", stream, "-o", tmp_path / "no", *bare, "--frames", "1-5", code=2)
    assert "--frames: with --mp4 expected whole groups; frames 0-2 are one" in done.stderr
    assert not (tmp_path / "no").exists()
    run("fvvdemux", stream, "-o", tmp_path / "out", *bare, "--frames", "3-5")
    for film in (tmp_path / "out/video").iterdir():
        times, _ = decoded(film)
        assert len(times) == GROUP and times[0] == 0


def test_other_codecs_are_no_films(capture, tmp_path):
    stream = stream_of(capture, tmp_path / "s.fvv", "jpeg")
    done = run("fvvdemux", stream, "-o", tmp_path / "out", "--mp4", "--json", warns=True)
    told = read_json(done, "fvvdemux")
    assert told["films"] == 0 and not (tmp_path / "out/video").exists()
    assert any("is in JPEG, not in H.264 or HEVC" in line for line in told["warnings"])
    run("fvvdemux", stream, "-o", tmp_path / "no", "--meshes", "none", "--pictures", "none", "--mp4", code=1)


def test_films_without_a_whole_frame_have_no_capture(tmp_path):
    """Found by fuzzing: a capture that was not there was described."""
    stream = ROOT / "tests/fuzz/crashes/demux_tool/films_without_a_whole_frame"
    done = run("fvvdemux", stream, "-o", tmp_path / "out", "--mp4", code=3)
    assert "no capture.json: no frame is whole\n" in done.stderr
    assert [path.name for path in (tmp_path / "out").iterdir() if path.suffix] == []
    assert list((tmp_path / "out/video").iterdir())


def test_a_group_that_lost_its_last_frames_has_none_of_the_next(tmp_path):
    """Without index and GEND a group goes up to the next one, whose frames are those of the next one alone."""
    count, group, left = 12, 6, 4
    small_capture(tmp_path / "in", frames=count)
    run("fvvmux", tmp_path / "in", "-o", tmp_path / "whole.fvv", "--group", group)
    stream, groups = (tmp_path / "whole.fvv").read_bytes(), 0
    kept = bytearray(stream[:24])
    for at, kind, _, size in chunks_of(stream):
        if kind == "INDX":
            break
        groups += kind == "GRUP"
        time = int.from_bytes(stream[at + 8 : at + 16], "little")
        if groups != 1 or (kind != "GEND" and time < left):
            kept += stream[at : at + 32 + (size + 7) // 8 * 8]
    (tmp_path / "cut.fvv").write_bytes(kept)
    done = run(
        "fvvdemux", tmp_path / "cut.fvv", "-o", tmp_path / "out", "--mp4", "--json", code=3, warns=True
    )
    told = read_json(done, "fvvdemux")
    # The last frame before the loss may have had more chunks.
    assert told["frames"]["written"] == count - (group - left) - 1
    for film in (tmp_path / "out/video").iterdir():
        times, _ = decoded(film)
        assert [round(25 * t) for t in times] == [*range(left), *range(group, count)]
    # The film of a viewer has the frames that are there.
    run(
        "fvvrender",
        tmp_path / "cut.fvv",
        "-o",
        tmp_path / "r.mp4",
        "--orbit",
        1,
        "--size",
        "64x48",
        code=(0, 3),
        warns=True,
    )
    assert len(decoded(tmp_path / "r.mp4")[0]) == count
