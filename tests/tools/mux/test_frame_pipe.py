"""fvvmux --realtime -: frames from a pipe (spec/frame-pipe.md), whole, cut, of wrong sizes, late, or none."""

import contextlib
import json
import pathlib
import re
import signal
import struct
import subprocess
import tempfile
import time

import pytest
from conftest import PATIENT, SMALL_HULLS, run, small_capture, tool_path, validate
from frame_pipe import END, frame, head, record

FRAMES = 8


@pytest.fixture(scope="module")
def show(tmp_path_factory):
    """The folder of a capture of three cameras, its description, and the records of its frames."""
    folder = tmp_path_factory.mktemp("show") / "show"
    small_capture(folder, *SMALL_HULLS, frames=FRAMES, cameras=3, size="160x96")
    description = json.loads((folder / "capture.json").read_text())
    return folder, description, [frame(folder, description, number) for number in range(FRAMES)]


class Pipe:
    """fvvmux --realtime --json - while it runs."""

    def __init__(self, output, *options):
        self.output = output
        command = [tool_path("fvvmux"), "--realtime", "-", "-o", output, "--json", *options]
        self.errors = tempfile.TemporaryFile()  # which is never full, as a pipe may be  # noqa: SIM115
        self.child = subprocess.Popen(
            [str(part) for part in command],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.errors,
        )

    def ended(self):
        """What it printed on standard output and standard error."""
        out, _ = self.child.communicate(timeout=100)
        self.errors.seek(0)
        return out, self.errors.read()

    def write(self, *parts):
        """A reader that has ended before is what some tests are about."""
        with contextlib.suppress(BrokenPipeError):
            for part in parts:
                self.child.stdin.write(part)
            self.child.stdin.flush()

    def wait_for_a_group(self):
        end = time.monotonic() + 60
        while not [p for p in self.output.parent.glob(".*out*") if p.stat().st_size]:
            assert time.monotonic() < end
            time.sleep(0.01)

    def result(self, code=0):
        """Summary and events; a busy machine lowers the effort in any test."""
        out, err = self.ended()
        assert self.child.returncode == code, err
        lines = [json.loads(line) for line in err.decode().splitlines() if line.startswith("{")]
        summary = json.loads(out)
        validate(summary, "fvvmux")
        events = [e for e in lines if e["event"] not in ("lowered", "raised")]
        return summary, [(e["event"], e["frame"], e["text"]) for e in events]

    def error(self, code=1):
        out, err = self.ended()
        assert self.child.returncode == code and not out, err
        assert not self.output.exists()
        return err.decode().splitlines()[-1]


@pytest.fixture
def pipe(tmp_path):
    """Starts it; what a test leaves running is killed."""
    started = []

    def start(*options, patient=PATIENT):
        started.append(Pipe(tmp_path / "out.fvv", *patient, *options))
        return started[-1]

    yield start
    for one in started:
        one.child.kill()
        one.ended()
        one.errors.close()


def whole_frames(path):
    (found,) = json.loads(run("fvvinfo", "--check", "--json", path).stdout)["files"]
    assert found["whole_frames"] == found["frames"]
    return int(found["frames"])


def test_a_pipe_makes_the_stream_that_the_folder_makes(show, pipe, tmp_path):
    folder, description, frames = show
    one = pipe("--group", "4")
    one.write(head(description), *frames, END)
    summary, events = one.result()
    assert events == [] and summary["frames"] == FRAMES and summary["preset"] == "live"
    assert summary["realtime"]["end"] == "all frames of the capture came"
    # A slow machine lowers the effort; frame_rate 1 leaves it a second for each frame.
    slow = {**description, "frame_rate": 1}
    (folder / "capture.json").write_text(json.dumps(slow))
    run("fvvmux", "--realtime", folder, "-o", tmp_path / "folder.fvv", "--max-delay", 600, "--group", 4)
    one = pipe("--group", "4", "--force")
    one.write(head(slow), *frames, END)
    one.result()
    assert one.output.read_bytes() == (tmp_path / "folder.fvv").read_bytes()


def test_a_show_of_unknown_length_ends_with_its_record(show, pipe):
    _, description, frames = show
    description = {**description, "frames": {"first": 0, "count": 10_000_000}}
    one = pipe("--group", "2")
    one.write(head(description), *frames[:5], END)
    summary, events = one.result()
    assert events == [] and summary["frames"] == 5
    assert summary["realtime"]["end"] == "its writer ended it"
    assert whole_frames(one.output) == 5


def test_frames_that_are_missing_lost_or_unusable_are_named_and_the_others_packed(show, pipe):
    _, description, frames = show
    vertices, faces = struct.unpack_from("<2I", frames[4], 4)
    broken = bytearray(frames[4])
    struct.pack_into("<I", broken, 40 + 12 * vertices, vertices)  # an index out of range
    one = pipe()
    one.write(head(description), frames[0], frames[2], record(b"LOST", 3, b"camera left stopped"))
    one.write(broken, *frames[5:], END)
    summary, events = one.result(code=3)
    assert [e[:2] for e in events] == [("lost", 1), ("lost", 3), ("lost", 4)]
    assert [e[2] for e in events][:2] == ["it did not come", "camera left stopped"]
    assert f"{vertices}" in events[2][2]
    assert summary["realtime"]["lost_frames"] == 3 and whole_frames(one.output) == FRAMES - 3


def test_a_group_whose_last_frames_are_lost_does_not_wait_for_others(show, pipe):
    _, description, frames = show
    one = pipe("--group", "4")
    one.write(head(description), *frames[:3])
    one.write(record(b"LOST", 3))
    one.wait_for_a_group()  # while the pipe is open
    one.write(*frames[4:6], END)
    summary, events = one.result(code=3)
    assert [e[:2] for e in events] == [("lost", 3)] and events[0][2] == "its writer lost it"
    assert summary["groups"] == 2 and whole_frames(one.output) == 5


def test_memory_does_not_grow_with_the_stream(show, pipe):
    """Without an index, whose entries do. Each frame of a stream that was kept would be 0.1 MB."""
    _, description, frames = show
    count = 1500
    one = pipe("--group", "4", "--live", "--quality", "30")
    one.write(head({**description, "frames": {"first": 0, "count": count}}))
    resident = []
    for number in range(count):
        known = frames[number % FRAMES]
        one.write(known[:16] + struct.pack("<q", number) + known[24:])
        if number in (count // 3, count - 1):
            status = pathlib.Path(f"/proc/{one.child.pid}/status").read_text()
            resident.append(int(re.search(r"VmRSS:\s+(\d+) kB", status)[1]) / 1024)
    summary, events = one.result()
    assert events == [] and summary["frames"] == count
    assert resident[1] < resident[0] + 30, resident  # MiB


def test_cameras_and_frames_can_be_left_out(show, pipe):
    _, description, frames = show
    one = pipe("--cameras", "1", "--frames", "2-4")
    one.write(head(description), *frames[:5])
    summary, events = one.result()
    assert events == [] and summary["frames"] == 3
    (found,) = json.loads(run("fvvinfo", "--json", one.output).stdout)["files"]
    assert [camera["id"] for camera in found["cameras"]] == [1]


@pytest.mark.parametrize("at", ["the border of a frame", "a record's head", "a mesh", "a picture"])
def test_a_pipe_that_is_cut_is_closed_with_an_event(show, pipe, at):
    _, description, frames = show
    top, before = head(description), frames[:3]
    size = {
        "the border of a frame": 0,
        "a record's head": 17,
        "a mesh": 100,
        "a picture": len(frames[3]) - 5,
    }[at]
    one = pipe()
    one.write(top, *before, frames[3][:size])
    summary, events = one.result(code=3)
    assert summary["frames"] == 3 and whole_frames(one.output) == 3
    offset = len(top) + sum(map(len, before)) + size
    assert events[-1][0] == "ended" and f"standard input: {offset:#x}: the pipe was closed w" in events[-1][2]
    assert summary["realtime"]["end"] == events[-1][2]
    # Of a frame whose head came it is known that it is lost.
    assert summary["realtime"]["lost_frames"] == (at in ("a mesh", "a picture"))


@pytest.mark.parametrize(
    "change, place, message",
    [
        ((0, b"FRAN"), 0, "expected a record FRAM, LOST or ENDS, found 46 52 41 4e"),
        (
            (4, struct.pack("<I", 5 << 20)),
            4,
            "expected at most 4194304 vertices and 8388608 faces, found 5242880",
        ),
        ((12, b"\1"), 12, "expected 0"),
        ((32, struct.pack("<Q", 1 << 60)), 32, "bytes after the record's head, found 1152921504606846976"),
    ],
)
def test_a_record_that_breaks_a_rule_ends_the_stream_properly(show, pipe, change, place, message):
    _, description, frames = show
    wrong = bytearray(frames[2])
    wrong[change[0] : change[0] + len(change[1])] = change[1]
    top = head(description)
    one = pipe()
    one.write(top, *frames[:2], wrong[:40])
    summary, events = one.result(code=3)
    offset = len(top) + len(frames[0]) + len(frames[1]) + place
    ((kind, number, text),) = events
    assert (kind, number) == ("ended", 2) and f"standard input: {offset:#x}: " in text and message in text
    assert whole_frames(one.output) == 2


def test_numbers_have_to_rise(show, pipe):
    _, description, frames = show
    one = pipe()
    one.write(head(description), frames[0], frames[1], frames[1])
    summary, events = one.result(code=3)
    assert "expected frame 2 or a later one, found 1" in events[0][2] and summary["frames"] == 2


def test_heads_that_break_a_rule_leave_no_file(show, pipe):
    _, description, _ = show
    huge = json.loads(json.dumps(description))
    for camera in huge["cameras"]:
        camera.update(width=16384, height=16384)
    for content, message in [
        (
            b"\x89FVV\r\n\x1a\n" + bytes(8),
            "standard input: 0x0: expected a pipe of frames (spec/frame-pipe.md)",
        ),
        (
            head(description, 2),
            "standard input: 0x8: expected version 1 of the pipe, found 2",
        ),
        (
            head(b"")[:12] + b"\xff\xff\xff\xff",
            "standard input: 0xc: expected a description of 1 to 16777216 bytes",
        ),
        (head(b"{}"), "standard input: expected key"),
        (head(description)[:-9], "expected 9 more bytes of the description"),
        (b"", "expected 16 more bytes of the head"),
        (head(huge), "--max-memory"),
    ]:
        one = pipe("--max-memory", "1G")
        one.write(content)
        assert message in one.error(), message


def test_a_writer_that_stalls_ends_the_stream(show, pipe):
    _, description, frames = show
    for cut, kinds in [(len(frames[3]), ["ended"]), (100, ["lost", "ended"])]:
        one = pipe("--idle", "0.5", "--force")
        one.write(head(description), *frames[:3], frames[3][:cut] if cut < len(frames[3]) else b"")
        one.child.stdin.flush()
        assert one.child.wait(60) == 3
        summary, events = one.result(code=3)
        assert [e[0] for e in events] == kinds and events[-1][2] == "no frame came for 0.5 s"
        assert summary["frames"] == 3
    one = pipe("--idle", "0.2", "--force")
    assert one.child.wait(60) == 1
    assert one.ended()[1].decode().endswith("expected the description of a show: no frame came for 0.2 s\n")


def test_frames_that_were_filmed_too_long_ago_are_dropped(show, pipe):
    folder, description, frames = show
    old = int((time.time() - 30) * 1e6)
    one = pipe("--group", "2", patient=("--max-delay", "20"))
    one.write(head(description), *frames[:2])
    one.wait_for_a_group()
    one.write(*(frame(folder, description, n, time=old) for n in (2, 3)), *frames[4:], END)
    summary, events = one.result(code=3)
    assert [e[:2] for e in events] == [("dropped", 2), ("dropped", 3)]
    assert summary["realtime"]["dropped_frames"] == 2 and summary["frames"] == FRAMES - 2


def test_a_signal_closes_the_stream(show, pipe):
    _, description, frames = show
    one = pipe("--group", "2")
    one.write(head(description), *frames[:3])
    one.wait_for_a_group()
    one.child.send_signal(signal.SIGINT)
    assert one.child.wait(60) == 0
    summary, events = one.result()
    assert events == [] and summary["realtime"]["end"] == "it was stopped"
    assert whole_frames(one.output) == summary["frames"] == 3


def test_what_does_not_fit_a_pipe_is_refused(show, pipe):
    _, description, _ = show
    one = pipe("--in-place")
    assert one.error(code=2).endswith("--in-place: expected a folder, found a pipe")
    one = pipe("--codec", "exr")
    one.write(head(description))
    assert "8 bits a sample" in one.error(code=2)
