"""Threads under stress: clips of their own, a shared clip and its meshes, closing meanwhile, and a misused reader."""

import random
import sys
import threading
import time

import fvv
import pytest
from test_read import Ranges


@pytest.fixture(autouse=True)
def often():
    """Threads change as often as the interpreter can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


def together(count, work, seconds=60):
    """Runs work(number, random numbers) in threads that begin at the same time, and raises the first of their exceptions."""
    failures, gate = [], threading.Barrier(count)

    def guarded(number):
        try:
            gate.wait()
            work(number, random.Random(number))
        except BaseException as error:  # also of asserts; raised below
            failures.append(error)

    threads = [threading.Thread(target=guarded, args=(number,), daemon=True) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(seconds)
        assert not thread.is_alive(), "threads wait for each other"
    if failures:
        raise failures[0]


def tastes(frame):
    """All parts of a frame as functions that return bytes."""
    return {
        "positions": lambda: frame.mesh.positions.tobytes(),
        "normals": lambda: frame.mesh.normals.tobytes(),
        "picture": lambda: frame.pictures[1].pixels.tobytes(),
        "whole": lambda: frame.pictures[0].whole().tobytes(),
        "weights": lambda: frame.visibility(2).tobytes(),
        "camera": lambda: frame.cameras[0].project(frame.mesh.positions[:500]).tobytes(),
    }


@pytest.fixture(scope="module")
def expected(players):
    with fvv.open(players) as clip:
        return [{name: taste() for name, taste in tastes(frame).items()} for frame in clip]


def test_clips_of_their_own(players, expected):
    content = players.read_bytes()

    def work(_, numbers):
        source = numbers.choice([str(players), content, Ranges(content)])
        with fvv.open(source) as clip:
            for _ in range(15):
                i = numbers.randrange(12)
                name = numbers.choice(sorted(expected[0]))
                assert tastes(clip[i])[name]() == expected[i][name]

    together(4, work)


def test_a_shared_clip(players, expected):
    content = players.read_bytes()
    for source in (content, Ranges(content)):
        with fvv.open(source) as clip:
            frames = list(clip)
            sounds = len(clip.audio)

            def work(_, numbers, clip=clip, frames=frames, sounds=sounds):
                for _ in range(12):
                    i = numbers.randrange(12)
                    name = numbers.choice(sorted(expected[0]))
                    frame = numbers.choice([frames[i], clip[i]])  # one that others use too, or not
                    assert tastes(frame)[name]() == expected[i][name]
                    if numbers.random() < 0.2:
                        assert len(clip.audio) == sounds and clip.problems == []
                        assert clip.read_at(0, 100) == content[:100] and len(clip.chunks()) > 60

            together(4, work)


def test_one_mesh_for_all(players, expected):
    """Arrays that are computed when they are first used are computed by several threads at once."""
    with fvv.open(players) as clip:
        for i in range(6):
            mesh = clip[i].mesh

            def work(number, _, mesh=mesh, i=i):
                for name in ("positions", "normals") if number % 2 else ("normals", "positions"):
                    assert getattr(mesh, name).tobytes() == expected[i][name]

            together(4, work)


def test_a_clip_that_is_closed_meanwhile(players, expected):
    content = players.read_bytes()
    for turn in range(6):
        clip = fvv.open(content if turn % 2 else Ranges(content))
        frames = list(clip)

        def work(number, numbers, clip=clip, frames=frames, turn=turn):
            if number == 0:
                time.sleep(0.01 * turn)
                clip.close()
                assert clip.closed
                return
            for _ in range(30):
                i = numbers.randrange(12)
                name = numbers.choice(sorted(expected[0]))
                try:
                    assert tastes(frames[i])[name]() == expected[i][name]
                except fvv.UsageError:
                    assert clip.closed

        together(4, work)


def test_readers_of_their_own(players):
    content = players.read_bytes()

    def frames(size):
        reader, out = fvv.Reader(visibility=True, sound=True), []
        for at in range(0, len(content), size):
            out += reader.feed(content[at : at + size])
        events = out + reader.finish()
        return [e.frame.pictures[0].pixels.tobytes() for e in events if isinstance(e, fvv.FrameEvent)]

    alone = frames(10000)
    assert len(alone) == 12

    def work(_, numbers):
        assert frames(numbers.randrange(3000, 50000)) == alone

    together(3, work)


def test_a_reader_of_two_threads_refuses_the_second(players):
    content = players.read_bytes()
    reader, refused, events, ended = fvv.Reader(), [], [], threading.Event()

    def work(number, _):
        if number == 0:
            try:
                events.extend(reader.feed(content))
            finally:
                ended.set()
            return
        while not ended.is_set():
            time.sleep(0.002)  # most of the time the other one decodes
            try:
                reader.feed(b"")
            except fvv.UsageError as error:
                assert "two threads" in str(error)
                refused.append(error)

    # The second one is refused: at times that is the one with the bytes.
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        ended.clear()
        try:
            together(2, work)
        except fvv.UsageError as error:
            refused.append(error)
            events.clear()
            reader = fvv.Reader()
        if events and refused:
            break
        events.clear()
        reader = fvv.Reader()
    assert events and refused
    # It is not harmed.
    events += reader.finish()
    assert [e.frame.number for e in events if isinstance(e, fvv.FrameEvent)] == list(range(12))


def longest_pause(call):
    """How long a call took, and for how long another thread did not run meanwhile, in seconds."""
    pauses, ended = [0.0], threading.Event()

    def watch():
        last = time.perf_counter()
        while not ended.is_set():
            now = time.perf_counter()
            pauses[0] = max(pauses[0], now - last)
            last = now

    thread = threading.Thread(target=watch)
    thread.start()
    begin = time.perf_counter()
    call()
    took = time.perf_counter() - begin
    ended.set()
    thread.join()
    return took, pauses[0]


@pytest.mark.parametrize("name", ["feed", "check"])
def test_long_calls_let_other_threads_run(players, name):
    content = players.read_bytes()
    call = {"feed": lambda: fvv.Reader().feed(content), "check": lambda: fvv.check(content)}[name]
    # With the lock of the interpreter the pause is as long as the call, always; without it only on a busy machine.
    for _ in range(50):
        took, pause = longest_pause(call)
        if pause < took / 2:
            return
    raise AssertionError(f"no other thread ran for {pause:.3f} s of {took:.3f} s")
