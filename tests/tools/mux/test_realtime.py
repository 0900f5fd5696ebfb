"""fvvmux --realtime: frames that arrive in time, late, in halves or not at all, and readers of the stream that stop."""

import contextlib
import fcntl
import json
import os
import shutil
import signal
import subprocess
import time

import pytest
from conftest import PATIENT, SMALL_HULLS, run, small_capture, tool_path, validate

FRAMES = 12
ALL = range(FRAMES)
PERIOD = 1 / 25
END = "capture.end"


@pytest.fixture(scope="module")
def show(tmp_path_factory):
    """A capture of three cameras, whole."""
    folder = tmp_path_factory.mktemp("show") / "show"
    small_capture(folder, *SMALL_HULLS, frames=FRAMES, cameras=3, size="160x96")
    return folder


class Show:
    """A folder that grows: the files of a frame are copied into it, and get their names last."""

    def __init__(self, source, folder, frames=None):
        self.source, self.folder = source, folder
        folder.mkdir()
        description = json.loads((source / "capture.json").read_text())
        if frames:
            description["frames"]["count"] = frames
        (folder / "capture.json").write_text(json.dumps(description))

    def files(self, frame):
        return sorted(p.relative_to(self.source) for p in self.source.glob(f"*/*{frame:04d}.*"))

    def put(self, frame, but=()):
        for name in self.files(frame):
            if name not in but:
                target = self.folder / name
                target.parent.mkdir(exist_ok=True)
                shutil.copy(self.source / name, target.with_suffix(".part"))
                target.with_suffix(".part").rename(target)

    def put_all(self, frames=ALL, but=()):
        for frame in frames:
            self.put(frame, but)

    def play(self, frames=ALL):
        start = time.monotonic()
        for i, frame in enumerate(frames):
            time.sleep(max(0.0, start + i * PERIOD - time.monotonic()))
            self.put(frame)

    def end(self):
        (self.folder / END).touch()


@pytest.fixture
def grow(show, tmp_path):
    return lambda frames=None: Show(show, tmp_path / "growing", frames)


@contextlib.contextmanager
def packing(folder, *options, stdout=subprocess.PIPE, output=None):
    """fvvmux --realtime --json, while it runs; it is killed if a test leaves it running."""
    command = [
        tool_path("fvvmux"),
        "--realtime",
        folder,
        "-o",
        output or folder.parent / "out.fvv",
        "--json",
        *options,
    ]
    child = subprocess.Popen([str(part) for part in command], stdout=stdout, stderr=subprocess.PIPE)
    try:
        yield child
    finally:
        child.kill()
        child.communicate()


def result(child, code=0, kinds=("lost", "dropped", "ended")):
    """Its summary, and its events of some kinds by frame: a busy machine lowers the effort in any test."""
    out, err = child.communicate(timeout=100)
    assert child.returncode == code, err
    lines = [json.loads(line) for line in err.decode().splitlines() if line.startswith("{")]
    summary = json.loads(out)
    validate(summary, "fvvmux")
    return summary, {event["frame"]: event for event in lines if event["event"] in kinds}


def check(folder, frames):
    (found,) = json.loads(run("fvvinfo", "--check", "--json", folder.parent / "out.fvv").stdout)["files"]
    assert int(found["whole_frames"]) == int(found["frames"]) == frames


def test_frames_are_packed_as_they_come(grow):
    show = grow()
    with packing(show.folder, *PATIENT) as child:
        show.play()
        summary, events = result(child)
    assert events == {}
    assert summary["preset"] == "live" and summary["group"] == 12
    found = summary["realtime"]
    assert found["lost_frames"] == found["dropped_frames"] == 0
    assert found["end"] == "all frames of the capture came"
    # The first frame of the only group waited for eleven others.
    assert (
        found["delay_max"] >= 11 * PERIOD
        and found["delay_median"] <= found["delay_p95"] <= found["delay_max"]
    )
    check(show.folder, FRAMES)


def test_a_group_leaves_before_the_next_one_is_there(grow, tmp_path):
    show = grow()
    with packing(show.folder, *PATIENT, "--group", "4", output="-") as child:
        show.put_all(range(4))
        assert os.read(child.stdout.fileno(), 8)[1:4] == b"FVV"
        show.put_all(range(4, FRAMES))
        out, err = child.communicate(timeout=60)
    assert child.returncode == 0
    summary = json.loads(err)  # with the stream on standard output
    assert summary["groups"] == 3 and summary["frames"] == FRAMES


def test_the_end_marker_ends_a_show_of_unknown_length(grow):
    show = grow(frames=9_999)
    with packing(show.folder, *PATIENT) as child:
        show.put_all(range(5))
        show.end()
        summary, events = result(child)
    assert events == {} and summary["frames"] == 5
    assert summary["realtime"]["end"] == "capture.end is there"
    check(show.folder, 5)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_closes_the_stream(grow, number):
    show = grow(frames=9_999)
    with packing(show.folder, *PATIENT, "--group", "2") as child:
        show.put_all(range(3))
        partial = wait_for(lambda: [p for p in show.folder.parent.glob(".*out*") if p.stat().st_size])
        assert partial
        child.send_signal(number)
        summary, events = result(child)
    assert events == {} and summary["frames"] == 3
    assert summary["realtime"]["end"] == "it was stopped"
    check(show.folder, 3)


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if found := condition():
            return found
        time.sleep(0.01)
    raise AssertionError("it did not happen")


def test_a_show_that_stops_is_closed_with_an_event(grow):
    show = grow()
    with packing(show.folder, *PATIENT, "--idle", "1") as child:
        show.put_all(range(5))
        summary, events = result(child, code=3)
    assert summary["frames"] == 5
    assert events[5]["event"] == "ended" and events[5]["text"] == "no frame came for 1 s"
    check(show.folder, 5)


def test_a_show_that_never_begins_leaves_no_file(grow):
    show = grow()
    with packing(show.folder, "--idle", "0.2") as child:
        out, err = child.communicate(timeout=60)
    assert child.returncode == 1 and not out
    assert err.decode().splitlines()[-1].endswith("no frame was packed: no frame came for 0.2 s")
    assert not list(show.folder.parent.glob("*.fvv"))


def test_a_camera_that_is_late_is_waited_for_and_one_that_fails_costs_its_frame(grow):
    show = grow()
    late, lost = ([p for p in show.files(frame) if str(p).startswith("cam1/0")] for frame in (2, 6))
    with packing(show.folder, *PATIENT) as child:
        show.put_all(range(5), but=late)
        time.sleep(0.1)
        show.put(2)
        show.put_all(range(5, FRAMES), but=lost)
        summary, events = result(child, code=3)
    assert list(events) == [6]
    assert events[6]["event"] == "lost" and events[6]["text"].endswith(f"{lost[0]} is missing")
    assert summary["frames"] == FRAMES - 1 and summary["realtime"]["lost_frames"] == 1
    check(show.folder, FRAMES - 1)


def test_a_file_that_stays_cut_and_a_picture_of_another_size_cost_their_frames(grow):
    show = grow()
    cut = next(p for p in show.files(3) if str(p).startswith("cam0/0"))
    other = next(p for p in show.files(5) if str(p).startswith("cam1/0"))
    with packing(show.folder, *PATIENT) as child:
        show.put_all(range(3))
        show.put(3, but=[cut])
        whole = (show.source / cut).read_bytes()
        (show.folder / cut).write_bytes(whole[: len(whole) // 2])
        show.put(4)
        small_capture(show.folder.parent / "other", frames=6)
        show.put(5, but=[other])
        shutil.copy(show.folder.parent / "other" / other, show.folder / "x")
        (show.folder / "x").rename(show.folder / other)
        show.put_all(range(6, FRAMES))
        summary, events = result(child, code=3)
    assert sorted(events) == [3, 5] and {event["event"] for event in events.values()} == {"lost"}
    assert str(cut) in events[3]["text"]
    assert events[5]["text"].endswith(f"{other}: expected 160 x 96 pixels, found 64 x 48")
    assert summary["frames"] == FRAMES - 2
    check(show.folder, FRAMES - 2)


def test_files_in_place_count_when_their_source_goes_on(grow):
    show = grow()
    # Half of a mesh in text would pass for a whole one.
    stalled = next(p for p in show.files(2) if str(p).startswith("cam0/0"))
    with packing(show.folder, *PATIENT, "--in-place") as child:
        show.put_all(range(2))
        show.put(2, but=[stalled])
        whole = (show.source / stalled).read_bytes()
        with open(show.folder / stalled, "wb") as out:
            out.write(whole[: len(whole) // 2])
            out.flush()
            time.sleep(0.8)  # longer than a file that has its name may be unreadable
            out.write(whole[len(whole) // 2 :])
        show.put_all(range(3, FRAMES))
        show.end()
        summary, events = result(child)
    assert events == {} and summary["frames"] == FRAMES
    check(show.folder, FRAMES)


def test_frames_that_are_too_old_are_dropped_by_name(grow, tmp_path):
    """The reader of a pipe takes nothing for a while: what waits becomes too old."""
    show = grow()
    with packing(show.folder, "--max-delay", "1", "--group", "2", "--quality", "4", output="-") as child:
        fcntl.fcntl(child.stdout, fcntl.F_SETPIPE_SZ, 4096)
        show.play()
        time.sleep(1.5)
        out, err = child.communicate(timeout=60)
    lines = err.decode().splitlines()
    events = [json.loads(line) for line in lines if line.startswith('{"event"')]
    events = [event for event in events if event["event"] not in ("lowered", "raised")]
    assert child.returncode == 3
    assert {event["event"] for event in events} == {"dropped"}
    assert all(event["age"] > 0.6 for event in events)
    summary = json.loads("\n".join(line for line in lines if not line.startswith('{"event"')))
    assert summary["realtime"]["dropped_frames"] == len(events) == FRAMES - summary["frames"]
    (tmp_path / "out.fvv").write_bytes(out)
    check(show.folder, summary["frames"])


def test_a_stream_that_falls_behind_gives_up_effort_step_by_step(grow):
    """Frames that come forty times as fast as usual: no machine keeps up."""
    show = grow()
    description = json.loads((show.folder / "capture.json").read_text())
    (show.folder / "capture.json").write_text(json.dumps(description | {"frame_rate": 1000}))
    show.put_all()
    with packing(show.folder, *PATIENT, "--group", "2") as child:
        summary, events = result(child, kinds=("lowered",))
    assert summary["frames"] == FRAMES and summary["realtime"]["dropped_frames"] == 0
    # The first group plans; each of the next ones is too slow, until there is nothing left to give up.
    steps = summary["realtime"]["effort"]
    assert [(step["frame"], step["step"]) for step in steps] == [(4, 1), (6, 2), (8, 3)]
    assert all(step["text"] in events[step["frame"]]["text"] for step in steps)
    check(show.folder, FRAMES)


def test_a_pipe_that_closes_or_is_not_read_is_an_error(grow):
    show = grow()
    show.put_all()
    with packing(show.folder, *PATIENT, output="-") as child:
        child.stdout.close()
        assert child.wait(60) == 1
        assert b"standard output: cannot write: Broken pipe" in child.stderr.read()
    with packing(show.folder, *PATIENT, "--idle", "0.5", "--quality", "4", output="-") as child:
        assert child.wait(60) == 1  # the pipe is full
        assert b"standard output: its reader took nothing for 0.5 s" in child.stderr.read()


def test_what_frames_that_arrive_cannot_have_is_refused(tmp_path):
    small_capture(tmp_path / "show", "--sound", frames=2)
    done = run("fvvmux", "--realtime", tmp_path / "show", "-o", tmp_path / "out.fvv", code=2)
    assert done.stderr.endswith("frames that arrive have no sound yet (--no-sound leaves it out)\n")
    done = run("fvvmux", "--realtime", tmp_path / "show", "-o", tmp_path / "out.fvv", "--verify", code=2)
    assert "--verify" in done.stderr
