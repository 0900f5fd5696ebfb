"""Recordings on a common time line, as they become pictures of capture.json."""

import json
import pathlib
from fractions import Fraction

import av
import cv2
import numpy
import pytest
from fvv import _core
from fvv.errors import DamagedError, UsageError
from fvv_capture import footage


def shade(i):
    return 20 + 7 * i


def stills(folder, numbers, size=(32, 24), name="{:04d}.png"):
    folder.mkdir(parents=True)
    for n in numbers:
        cv2.imwrite(str(folder / name.format(n)), numpy.full((size[1], size[0], 3), shade(n), numpy.uint8))
    return folder


def film(path, count, rate=25, size=(64, 48), first=0, missing=()):
    """A video whose picture i has the grey level shade(first + i); pictures that are missing have no time of their own."""
    with av.open(str(path), "w") as file:
        stream = file.add_stream("libx264", rate=rate, options={"crf": "4", "bf": "0"})
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        stream.codec_context.time_base = Fraction(1) / Fraction(rate)
        for i in range(count):
            if i in missing:
                continue
            pixels = numpy.full((size[1], size[0], 3), shade(first + i), numpy.uint8)
            frame = av.VideoFrame.from_ndarray(pixels, format="rgb24")
            frame.pts = i
            frame.time_base = Fraction(1) / Fraction(rate)
            file.mux(stream.encode(frame))
        file.mux(stream.encode())
    return path


def reader(recording, line, first, count):
    camera = {
        "id": 0,
        "width": recording.size[0],
        "height": recording.size[1],
        "intrinsics": {"fx": 50, "fy": 50, "cx": 16, "cy": 12},
        "rotation": numpy.eye(3).tolist(),
        "translation": [0, 0, 0],
        "pictures": footage.source(recording, line, first),
    }
    head = {
        "fvv_capture": 1,
        "frame_rate": f"{line.rate.numerator}/{line.rate.denominator}",
        "frames": {"first": first, "count": count},
        "units": "metres",
        "cameras": [camera],
    }
    return _core.Footage(json.dumps(head), "/capture.json")


def test_videos_and_folders_are_found_by_name(tmp_path):
    stills(tmp_path / "left", range(3, 9))
    film(tmp_path / "right.mp4", 7)
    (tmp_path / "notes.txt").write_text("not a recording")
    (tmp_path / "empty").mkdir()
    found = footage.find(tmp_path)
    assert sorted(found) == ["left", "right"]
    assert (found["left"].count, found["left"].first, found["left"].size) == (6, 3, (32, 24))
    assert (found["right"].count, found["right"].size, found["right"].rate()) == (7, (64, 48), 25)
    assert found["left"].rate() is None


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["a.png"], "expected a number"),
        (["a0.png", "b0.png"], "one series"),
        (["a0.png", "a1.png", "a10.png"], "missing"),
        (["a08.png", "a9.png", "a10.png"], "one width"),
    ],
)
def test_folders_that_cannot_be_understood_are_refused(tmp_path, names, said):
    (tmp_path / "cam").mkdir()
    for name in names:
        cv2.imwrite(str(tmp_path / "cam" / name), numpy.zeros((8, 8, 3), numpy.uint8))
    with pytest.raises((UsageError, DamagedError), match=said) as caught:
        footage.find(tmp_path)
    assert "cam" in str(caught.value)


def test_a_folder_without_recordings_is_refused(tmp_path):
    with pytest.raises(UsageError, match="found none"):
        footage.find(tmp_path)
    (tmp_path / "cam.mp4").write_bytes(b"no video at all")
    with pytest.raises(DamagedError, match=r"cam.mp4: .*--exclude cam"):
        footage.find(tmp_path)
    film(tmp_path / "b.mp4", 3)
    assert list(footage.find(tmp_path, exclude=["cam"])) == ["b"]


def test_a_camera_has_one_recording(tmp_path):
    stills(tmp_path / "cam", range(3))
    film(tmp_path / "cam.mp4", 3)
    with pytest.raises(UsageError, match="one recording of each camera"):
        footage.find(tmp_path)


@pytest.mark.parametrize("rate", [Fraction(25), Fraction(30000, 1001), Fraction(60000, 1001), Fraction(50)])
def test_usual_rates_are_exact(tmp_path, rate):
    found = footage.find(film(tmp_path / "cam.mp4", 12, rate).parent)["cam"]
    assert found.rate() == rate


def test_a_missing_picture_does_not_change_the_rate(tmp_path):
    film(tmp_path / "cam.mp4", 30, missing=(11, 12))
    found = footage.find(tmp_path)["cam"]
    assert (found.rate(), found.count) == (25, 28)
    line = footage.timeline([found], Fraction(25), {})
    assert line.count == 30


def test_rates_that_differ_are_refused_with_their_names(tmp_path):
    film(tmp_path / "a.mp4", 12)
    film(tmp_path / "b.mp4", 12, 30)
    found = footage.find(tmp_path)
    with pytest.raises(UsageError, match="a 25, b 30"):
        footage.common_rate(list(found.values()))
    film(tmp_path / "b.mp4", 24, 50)
    film(tmp_path / "c.mp4", 12, Fraction(25000, 1001))
    found = footage.find(tmp_path)
    assert footage.common_rate([found["b"], found["a"]]) == 25
    assert footage.common_rate([found["a"], found["c"]]) == 25
    stills(tmp_path / "more/c", range(3))
    pictures = footage.find(tmp_path / "more")
    with pytest.raises(UsageError, match="--fps"):
        footage.common_rate(list(pictures.values()))
    assert footage.common_rate(list(pictures.values()), Fraction(24)) == 24


def test_offsets_give_the_frames_that_all_have(tmp_path):
    stills(tmp_path / "a", range(0, 10))
    stills(tmp_path / "b", range(5, 15))
    found = footage.find(tmp_path)
    both = [found["a"], found["b"]]
    line = footage.timeline(both, Fraction(25), {"b": 2.4})
    assert (line.offsets, line.first, line.count) == ({"a": 0, "b": 2}, 0, 8)
    line = footage.timeline(both, Fraction(25), {"b": -3})
    assert (line.first, line.count) == (3, 7)
    for name, picture in (("a", 3), ("b", 5)):
        shown = reader(found[name], line, line.first, line.count).picture(0, line.first)
        assert shown[0, 0, 0] == shade(picture)
    with pytest.raises(UsageError, match="no frame in common"):
        footage.timeline(both, Fraction(25), {"b": 10})
    with pytest.raises(UsageError, match="offset of c"):
        footage.timeline(both, Fraction(25), {"c": 1})


def test_videos_give_the_pictures_of_their_offsets(tmp_path):
    film(tmp_path / "a.mp4", 12, first=0)
    film(tmp_path / "b.mp4", 12, first=0)
    found = footage.find(tmp_path)
    line = footage.timeline(list(found.values()), Fraction(25), {"b": 4})
    assert (line.first, line.count) == (0, 8)
    for first in (0, 3):
        for name, offset in (("a", 0), ("b", 4)):
            shown = reader(found[name], line, first, 4).picture(0, first + 1)
            assert abs(int(shown[10, 10, 1]) - shade(first + 1 + offset)) <= 2


def test_names_of_sources_are_relative_to_the_folder_of_the_capture(tmp_path):
    folder = stills(tmp_path / "100 % cam", range(3))
    found = footage.find(tmp_path)["100 % cam"]
    line = footage.timeline([found], Fraction(25), {})
    pattern = footage.source(found, line, 0, str(tmp_path / "out"))
    assert pattern == "../100 %% cam/%04d.png"
    assert pathlib.Path(str(pattern).replace("%%", "%").replace("%04d", "0001")).name == "0001.png"
    assert reader(found, line, 0, 3).check() == ([], [])
    assert folder.exists()


def test_cameras_match_recordings_without_case_and_extension(tmp_path):
    stills(tmp_path / "Cam01", range(2))
    stills(tmp_path / "cam02", range(2))
    stills(tmp_path / "other", range(2))
    found = footage.find(tmp_path)
    matched, unused = footage.match_cameras(["cam01.mp4", "cam02", "cam03"], found)
    assert {i: r.name for i, r in matched.items()} == {0: "Cam01", 1: "cam02"}
    assert unused == ["other"]
    with pytest.raises(UsageError, match="names of the calibration"):
        footage.match_cameras(["x"], found)


def test_names_of_recordings_may_say_more_than_the_camera(tmp_path):
    film(tmp_path / "left_take.mp4", 3)
    film(tmp_path / "right_TAKE.mp4", 3)
    stills(tmp_path / "top", range(2))
    assert list(footage.find(tmp_path, ["{camera}_take", "{camera}_board"])) == ["left", "right", "top"]
    for pattern in ("take", "{camera}{camera}"):
        with pytest.raises(UsageError, match="expected {camera} once"):
            footage.find(tmp_path, [pattern])
    film(tmp_path / "left.mp4", 3)
    with pytest.raises(UsageError, match="one recording of each camera"):
        footage.find(tmp_path, ["{camera}_take"])


def test_twice_the_rate_gives_every_second_picture(tmp_path):
    film(tmp_path / "a.mp4", 12, 25)
    film(tmp_path / "b.mp4", 24, 50)
    found = footage.find(tmp_path)
    line = footage.timeline(list(found.values()), Fraction(25), {"b": 1})
    # The last picture is half a frame before frame 12 of its own.
    assert (line.first, line.count) == (0, 12)
    shown = reader(found["b"], line, 0, 12)
    assert [round((int(shown.picture(0, n)[9, 9, 1]) - 20) / 7) for n in range(4)] == [2, 4, 6, 8]


def test_pictures_that_were_dropped_are_left_out_of_a_board_walk(tmp_path):
    """Those after them keep their frames."""
    film(tmp_path / "cam.mp4", 12, missing=(4, 5))
    recording = footage.find(tmp_path)["cam"]
    found = {n: round((int(p[9, 9, 1]) - 20) / 7) for n, p in footage.pictures(recording, Fraction(25), 2)}
    assert found == {0: 2, 1: 3, 4: 6, 5: 7, 6: 8, 7: 9, 8: 10, 9: 11}
    late = [n for n, _ in footage.pictures(recording, Fraction(25), -3, step=2, last=9)]
    assert late == [4, 6]
    again = [n for n, _ in footage.pictures(recording, Fraction(25), repeat=True)]
    assert again == list(range(12))


def test_a_film_that_ends_early_does_not_end_the_take(tmp_path):
    for name, count in (("a", 20), ("b", 20), ("c", 19), ("d", 8)):
        film(tmp_path / f"{name}.mp4", count)
    found = list(footage.find(tmp_path).values())
    line = footage.timeline(found, Fraction(25), {})
    assert (line.count, line.ends) == (19, {"d": 8})
    # Of three, two would be left.
    assert footage.timeline(found[1:], Fraction(25), {}).count == 8


def test_a_clock_that_drifts_is_followed_by_the_reader(tmp_path):
    """A hundredth, which no quartz does, so that it shows in 33 pictures."""
    film(tmp_path / "a.mp4", 34)
    film(tmp_path / "b.mp4", 34)
    found = footage.find(tmp_path)
    line = footage.timeline(list(found.values()), Fraction(25), {"b": 1.3}, {"b": 0.01})
    assert line.offsets == {"a": 0, "b": 1}
    # 20 (1.01) + 1.3 = 21.5
    assert [line.picture("b", n) - n for n in (0, 19, 20, 30)] == [1, 1, 2, 2]
    made = footage.source(found["b"], line, 0)
    assert made["clock"] == "101/100"
    shown = reader(found["b"], line, 0, line.count)
    for n in range(0, line.count, 3):
        assert round((int(shown.picture(0, n)[9, 9, 1]) - 20) / 7) == line.picture("b", n)
    assert shown.check()[1] == []


@pytest.mark.parametrize("clock", ["98/100", "102/100", "1/0", "x", 2, 1.0])
def test_clocks_that_no_camera_has_are_refused(tmp_path, clock):
    film(tmp_path / "a.mp4", 3)
    found = footage.find(tmp_path)["a"]
    camera = {**footage.camera_of(found), "pictures": {"video": str(tmp_path / "a.mp4"), "clock": clock}}
    head = {"fvv_capture": 1, "frame_rate": 25, "frames": {"first": 0, "count": 3}, "units": "metres"}
    with pytest.raises(
        DamagedError, match="/cameras/0/pictures/clock: expected 1 or a fraction from 99/100 to 101/100"
    ):
        _core.Footage(json.dumps({**head, "cameras": [camera]}), "/capture.json")
