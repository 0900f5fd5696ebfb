"""fvvcapture live: films of a generated scene as cameras that run, come late, stop, and change."""

import contextlib
import json
import signal
import socket
import subprocess
import sys
import threading
import time

import av
import cv2
import fvv
import jsonschema
import pytest
from conftest import ROOT, tool
from fvv_capture.live.fineness import ENOUGH, LOOKED_AT, MOST, Fineness
from fvv_capture.live.moments import Moments
from fvv_capture.live.streams import Source, sources

CAMERAS, RATE, SECONDS = 3, 10, 3
SIZE = (160, 96)
#: Slow enough for any machine; what it loses besides is then what a test is about.
PATIENT = "--fps", "2", "--max-delay", "60", "--jobs", "1"


def film(path, pictures, size=SIZE, codec="libx264", **container):
    with av.open(str(path), "w", **container) as file:
        stream = file.add_stream(codec, rate=RATE)
        stream.width, stream.height = size
        stream.pix_fmt, stream.options = "yuv420p", {"crf": "10", "preset": "ultrafast", "bf": "0"}
        for picture in pictures:
            frame = av.VideoFrame.from_ndarray(cv2.resize(picture, size), format="bgr24")
            file.mux(stream.encode(frame))
        file.mux(stream.encode())


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    """films/, empty/: of each camera; room.json; pictures of each camera."""
    place = tmp_path_factory.mktemp("stage")
    frames = RATE * SECONDS
    small = "--rig", "small", "--cameras", CAMERAS, "--size", "x".join(map(str, SIZE)), "--frames", frames
    tool("fvvsynth", "-o", place / "made", *small)
    (place / "films").mkdir()
    pictures = []
    for camera in range(CAMERAS):
        source = place / "made" / f"cam{camera}"
        pictures.append([cv2.imread(str(source / f"{n:04d}.png")) for n in range(frames)])
        film(place / "films" / f"cam{camera}.mp4", pictures[-1])
        # A screen: keys need not find who is in the picture of the empty stage.
        masks = [cv2.imread(str(source / f"mask_{n:04d}.png"), cv2.IMREAD_GRAYSCALE) for n in range(frames)]
        for picture, mask in zip(pictures[-1], masks):
            picture[cv2.dilate(mask, None) == 0] = (40, 200, 40)
        film(place / "films" / f"cam{camera}.mp4", pictures[-1])
    (place / "room.json").write_text((place / "made/capture.json").read_text())
    return place, pictures


def command(place, cameras, *options):
    given = [cameras, "--calibration", place / "room.json", "--backing", "40,200,40", "--key", "chroma"]
    given += ["--bounds=-2.2,-0.3,-1.2,2.2,2.2,1.2", "--cell", "80mm", "--json", *options]
    return [sys.executable, "-m", "fvv_capture", "live", *map(str, given)]


def live(place, cameras, output, *options, code=0):
    """Summary, and events."""
    done = subprocess.run(
        command(place, cameras, "-o", output, *options), capture_output=True, text=True, timeout=120
    )
    assert done.returncode == code, done.stderr
    return checked(done.stdout, done.stderr)


def checked(out, err):
    summary = json.loads(out)
    for name in ("fvvcapture-live", "fvvmux"):
        schema = json.loads((ROOT / f"spec/{name}.schema.json").read_text())
        jsonschema.validate(summary if name != "fvvmux" else summary["mux"], schema)
    events = [json.loads(line) for line in err.splitlines() if line.startswith("{")]
    # Nothing is lost silently.
    times = summary["mux"]["realtime"]
    lost = [e["frame"] for e in events if e["event"] in ("lost", "dropped")]
    assert len(set(lost)) == len(lost) == times["lost_frames"] + times["dropped_frames"]
    assert summary["mux"]["frames"] + len(lost) == summary["frames"]
    return summary, [e for e in events if e["event"] not in ("lowered", "raised", "coarser", "finer")]


def test_films_are_packed_while_they_play(stage, tmp_path):
    place, _ = stage
    begin = time.monotonic()
    summary, events = live(place, place / "films", tmp_path / "out.fvv", *PATIENT)
    assert time.monotonic() - begin >= SECONDS - 1 / RATE
    assert events == [] and summary["end"] == "all cameras ended"
    assert summary["frames"] == summary["hulls"] == 2 * SECONDS
    assert [camera["pictures"] for camera in summary["cameras"]] == [RATE * SECONDS] * CAMERAS
    assert summary["mux"]["realtime"]["end"] == "its writer ended it"
    with fvv.open(tmp_path / "out.fvv") as clip:
        assert len(clip) == 2 * SECONDS
        # Hulls of the players, of which the cameras see all.
        low, high = clip[0].mesh.positions.min(0), clip[0].mesh.positions.max(0)
        assert 1.5 < high[1] - low[1] < 2.6 and len(clip[0].pictures) == CAMERAS


def test_a_camera_that_stops_costs_its_frames_and_is_named(stage, tmp_path):
    place, pictures = stage
    films = tmp_path / "films"
    films.mkdir()
    for camera in range(CAMERAS):
        film(films / f"cam{camera}.mp4", pictures[camera][: RATE if camera == 1 else None])
    summary, events = live(place, films, tmp_path / "out.fvv", *PATIENT, code=3)
    assert [(e["event"], e["frame"], e["text"]) for e in events] == [
        ("lost", n, "no picture of cam1") for n in range(2, 2 * SECONDS)
    ]
    assert summary["mux"]["frames"] == 2


def test_a_camera_that_changes_its_size_is_named(stage, tmp_path):
    place, pictures = stage
    other = tmp_path / "other.h264"
    film(other, pictures[1][RATE:], (320, 192))
    changing = tmp_path / "changing.h264"
    film(changing, pictures[1][:RATE])
    changing.write_bytes(changing.read_bytes() + other.read_bytes())
    listed = tmp_path / "cameras.txt"
    films = place / "films"
    listed.write_text(
        f"cam0 {films}/cam0.mp4\n# a comment\ncam1 changing.h264 framerate={RATE}\ncam2 {films}/cam2.mp4\n"
    )
    summary, events = live(place, listed, tmp_path / "out.fvv", *PATIENT, code=3)
    (size,) = (e for e in events if e["event"] == "size")
    assert size["text"] == "camera cam1: expected pictures of 160 x 96, found 320 x 192"
    assert {e["text"] for e in events if e["event"] == "lost"} == {"no picture of cam1"}
    assert 1 <= summary["mux"]["frames"] <= 3


class Sender(threading.Thread):
    """A camera in the network: sends a film at its speed to who connects, once after each of some waits."""

    def __init__(self, path, waits):
        super().__init__(daemon=True)
        self.server = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp://127.0.0.1:{self.server.getsockname()[1]}"
        self.content, self.waits = path.read_bytes(), waits
        self.start()

    def run(self):
        for wait in self.waits:
            with contextlib.suppress(OSError), self.server.accept()[0] as channel:
                time.sleep(wait)
                parts, start = 10 * SECONDS, time.monotonic()
                for i in range(parts):
                    channel.sendall(
                        self.content[len(self.content) * i // parts : len(self.content) * (i + 1) // parts]
                    )
                    time.sleep(max(0.0, start + (i + 1) * SECONDS / parts - time.monotonic()))


def test_a_camera_in_the_network_may_come_late_and_again(stage, tmp_path):
    place, pictures = stage
    sent = tmp_path / "cam1.ts"
    film(sent, pictures[1], format="mpegts")
    sender = Sender(sent, (1.0, 0.0))
    films = place / "films"
    listed = tmp_path / "cameras.txt"
    listed.write_text(
        f"cam0 {films}/cam0.mp4 loop=1\ncam1 {sender.address} format=mpegts probesize=32000\ncam2 {films}/cam2.mp4 loop=1\n"
    )
    child = subprocess.Popen(
        command(place, listed, "-o", tmp_path / "out.fvv", *PATIENT, "--idle", "30"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    seen = []
    try:
        # Until frames are whole again after the camera came back.
        for line in child.stderr:
            seen.append(line)
            if '"back"' in line:
                break
        time.sleep(2)
        child.send_signal(signal.SIGINT)
        out, err = child.communicate(timeout=60)
    finally:
        child.kill()
        child.communicate()
    assert child.returncode == 3
    summary, events = checked(out, "".join(seen) + err)
    of_camera = [(e["event"], e["text"]) for e in events if e["event"] in ("stopped", "back")]
    assert of_camera[0][0] == "stopped" and of_camera[0][1].startswith("camera cam1: ")
    assert of_camera[1] == ("back", "camera cam1: sends pictures again")
    assert summary["end"] == "it was stopped" and summary["mux"]["frames"] >= 3
    # The show began with the camera that came last: what was before is no part of it.
    assert not [e for e in events if e["event"] == "lost" and e["frame"] == 0]


def test_a_camera_that_never_comes_ends_the_show(stage, tmp_path):
    place, _ = stage
    films = place / "films"
    listed = tmp_path / "cameras.txt"
    listed.write_text(f"cam0 {films}/cam0.mp4 loop=1\ncam1 tcp://127.0.0.1:9\ncam2 {films}/cam2.mp4 loop=1\n")
    done = subprocess.run(
        command(place, listed, "-o", tmp_path / "out.fvv", *PATIENT, "--idle", "1"),
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 1 and not (tmp_path / "out.fvv").exists()
    assert "no whole frame came for 1 s, and no picture of cam1" in done.stderr


def test_a_stream_to_a_pipe_has_no_index(stage):
    place, _ = stage
    done = subprocess.run(
        command(place, place / "films", "-o", "-", *PATIENT), capture_output=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout[1:4] == b"FVV" and b"INDX" not in done.stdout
    assert json.loads(done.stderr)["frames"] == 2 * SECONDS


@pytest.mark.parametrize(
    "text, message",
    [
        ("cam0", ":1: expected NAME ADDRESS"),
        ("cam0 a.mp4 loop", ":1: expected NAME ADDRESS"),
        ("cam0 a\n\ncam0 b", ":3: camera cam0 has a line before"),
        ('cam0 "a', ":1: No closing quotation"),
        ("# nothing\n", ": expected a camera or more, found none"),
        ("cam9 a", ": there is no camera cam9 in the calibration: cam0, cam1"),
    ],
)
def test_lists_of_cameras_that_are_wrong_are_refused(tmp_path, text, message):
    path = tmp_path / "cameras.txt"
    path.write_text(text)
    with pytest.raises(fvv.UsageError) as caught:
        sources(str(path), ["cam0", "cam1"], [])
    assert message in str(caught.value)


def test_a_list_of_cameras(tmp_path):
    path = tmp_path / "cameras.txt"
    (tmp_path / "a b.mp4").touch()
    path.write_text("right rtsp://10.0.0.2/x rtsp_transport=tcp\nleft 'a b.mp4' loop=1 # a rehearsal\n")
    left, right = sources(str(path), ["left", "middle", "right"], [])
    assert left == Source("left", str(tmp_path / "a b.mp4"), None, True, {})
    assert right == Source("right", "rtsp://10.0.0.2/x", None, False, {"rtsp_transport": "tcp"})


def test_frames_have_the_pictures_of_one_moment():
    moments = Moments(2, rate=10, patience=0.5)
    # Of 25 pictures a second those nearest to frames, of equal rates all.
    assert [moments.place(i / 25, 1 / 25) for i in range(6)] == [0, None, 1, None, None, 2]
    assert [moments.place(i / 10 + 0.02, 1 / 10) for i in range(3)] == [0, 1, 2]

    def come(camera, number):
        if moments.wants(camera, number):
            moments.put(camera, number, (camera, number))

    come(0, 3)
    assert moments.take(0.3) == [] and moments.waited_for == [1] and not moments.has_begun
    come(1, 5)  # the show begins here
    come(0, 5)
    come(1, 6)
    (first,) = moments.take(0.6)
    assert (first.number, first.due, first.pictures) == (0, 0.5, [(0, 5), (1, 5)])
    come(1, 7)
    come(0, 7)
    assert moments.take(1.09) == []  # frame 6 is waited for
    second, third = moments.take(1.11)
    assert (second.number, second.missing, third.number, third.missing) == (1, [0], 2, [])
    come(0, 6)
    assert moments.late == [1, 0]
    moments.end(0)
    come(1, 8)
    assert moments.take(1.2) == []
    moments.end(1)
    (last,) = moments.take(1.2)
    assert (last.number, last.missing) == (3, [0]) and moments.is_over and moments.take(99) == []


def test_before_a_show_begins_little_is_kept():
    moments = Moments(2, rate=10, patience=0.5)
    for number in range(1000):
        moments.wants(0, number)
        moments.put(0, number, number)
    assert len(moments._found) <= 21


def test_cells_grow_with_the_load_and_shrink_later():
    fineness = Fineness(rate=10, processes=2)  # 0.2 s for a frame
    changes = [fineness.add(0.19) for _ in range(3 * LOOKED_AT)]
    assert [i for i, change in enumerate(changes) if change] == [LOOKED_AT * i - 1 for i in (1, 2, 3)]
    assert fineness.step == 3 and fineness.scale == pytest.approx(2)
    easy = [fineness.add(0.05) for _ in range(ENOUGH + LOOKED_AT)]
    assert easy.count(-1) == 1 and fineness.step == 2
    # Too early: it takes twice as many frames from then on.
    while not (change := fineness.add(0.3)):
        pass
    assert change == 1
    assert -1 not in [fineness.add(0.05) for _ in range(2 * ENOUGH)]
    # One burst of lost frames is one step.
    fresh = Fineness(rate=10, processes=2)
    assert [fresh.drop() for _ in range(LOOKED_AT)] == [1] + [0] * (LOOKED_AT - 1)
    for _ in range(20 * LOOKED_AT):
        fresh.drop()
    assert fresh.step == MOST
