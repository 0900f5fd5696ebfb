"""Calls in any order: push readers fed in any portions, and clips, each against a model that is simpler than they are."""

import array
import gc
import io

import fvv
import numpy
import pytest
from fvv import pictures, player
from hypothesis import example, given, settings, strategies
from hypothesis.stateful import (
    Bundle,
    RuleBasedStateMachine,
    consumes,
    invariant,
    multiple,
    precondition,
    rule,
)
from PIL import Image
from test_damage import CONTENTS, damaged, fed, flipped, opened, seen, values, whole

# The profile's examples, as a part; a state machine makes many calls in each.
EXAMPLES = settings().max_examples
SMALL = sorted(name for name, content in CONTENTS.items() if len(content) < 12000)
KINDS = [bytes, bytearray, memoryview, lambda part: array.array("B", part)]


def model(content):
    """What a reader gives that is fed all at once; an error as the last event, by its text."""
    reader, out = fvv.Reader(pictures=False), []
    for call in (lambda: reader.feed(content), reader.finish):
        try:
            out += seen(call())
        except fvv.Error as error:
            return [*out, ("error", type(error).__name__, str(error))]
    return out


class Fed:
    """A reader, what it was fed, and what came out."""

    def __init__(self, content):
        self.reader = fvv.Reader(pictures=False)
        self.content, self.at, self.events = content, 0, []
        self.finished = False

    @property
    def failed(self):
        return bool(self.events) and self.events[-1][0] == "error"

    def call(self, work):
        try:
            new = work()
        except fvv.Error as error:
            ended = ("error", type(error).__name__, str(error))
            # An error is final: each further call raises it again.
            assert not self.failed or self.events[-1] == ended
            self.events += [] if self.failed else [ended]
        else:
            assert not self.failed
            self.events += seen(new)


class Readers(RuleBasedStateMachine):
    """Readers of any streams, fed in any portions at the same time."""

    readers, finished = Bundle("readers"), Bundle("finished")

    @rule(target=readers, name=strategies.sampled_from(SMALL))
    def open(self, name):
        return Fed(CONTENTS[name])

    @rule(target=readers, case=damaged().filter(lambda case: len(case[1]) < 12000))
    def open_damaged(self, case):
        return Fed(case[1])

    @rule(one=readers, size=strategies.integers(0, 3000), kind=strategies.sampled_from(KINDS))
    def feed(self, one, size, kind):
        part = kind(one.content[one.at : one.at + size])
        one.at = min(one.at + size, len(one.content))
        one.call(lambda: one.reader.feed(part))

    @rule(one=readers)
    def feed_the_rest(self, one):
        part, one.at = one.content[one.at :], len(one.content)
        one.call(lambda: one.reader.feed(part))

    @rule(one=readers, wrong=strategies.sampled_from(["text", None, 7, memoryview(bytes(8))[::2]]))
    def feed_what_are_no_bytes(self, one, wrong):
        with pytest.raises((TypeError, BufferError, fvv.Error)):
            one.reader.feed(wrong)

    @rule(target=finished, one=consumes(readers))
    def finish(self, one):
        one.call(one.reader.finish)
        one.finished = True
        assert one.events == model(one.content[: one.at])
        return multiple(one)

    @rule(one=finished, size=strategies.integers(0, 100))
    def feed_after_the_end(self, one, size):
        with pytest.raises(fvv.Error) as caught:
            one.reader.feed(bytes(size))
        assert one.failed or isinstance(caught.value, fvv.UsageError)

    @rule(one=finished)
    def finish_again(self, one):
        before = list(one.events)
        one.call(one.reader.finish)
        assert one.events == before

    @rule(one=consumes(finished))
    def forget(self, one):
        del one.reader
        gc.collect(0)


class Clips(RuleBasedStateMachine):
    """One clip: what is read does not depend on what was read before, and stays after the clip is closed."""

    frames = Bundle("frames")

    def __init__(self):
        super().__init__()
        self.clip = None
        self.closed = True
        self.kept = []

    @rule(name=strategies.sampled_from([n for n in SMALL if n != "tiny_empty"]))
    def open(self, name):
        self.name, self.content = name, CONTENTS[name]
        self.clip, self.closed = fvv.open(self.content), False

    def guarded(self, work):
        """What work returns; after close only the error for that is right."""
        if not self.closed:
            return work()
        with pytest.raises(fvv.UsageError, match="closed"):
            work()
        return None

    @precondition(lambda self: self.clip is not None)
    @rule(target=frames, at=strategies.integers(0, 20))
    def take(self, at):
        frame = self.guarded(lambda: self.clip[at % len(self.clip)])
        return multiple() if frame is None else (self.name, self.clip, frame)

    @rule(taken=frames)
    def read(self, taken):
        name, clip, frame = taken
        if clip.closed:
            return
        assert values(frame) == whole(name)[frame.ticks]

    @rule(taken=frames)
    def keep(self, taken):
        _, clip, frame = taken
        if not clip.closed and (mesh := frame.mesh) is not None:
            self.kept.append((mesh.positions, mesh.positions.copy()))

    @rule(taken=frames)
    def read_what_is_new_after_close(self, taken):
        _, clip, frame = taken
        if clip.closed:
            with pytest.raises(fvv.UsageError):
                clip[frame.index]
            fresh = fvv.ClipFrame(clip, frame.index)
            for name in ("mesh", "cameras", "pictures", "ticks"):
                with pytest.raises(fvv.UsageError):
                    getattr(fresh, name)

    @precondition(lambda self: self.clip is not None)
    @rule(part=strategies.floats(0, 0.999))
    def at_a_time(self, part):
        def work():
            clip = self.clip
            seconds = clip.start + part * clip.duration
            found = clip.at(seconds)
            assert found.time <= seconds + 1e-6
            assert found.index + 1 == len(clip) or clip[found.index + 1].time > seconds - 1e-6

        self.guarded(work)

    @precondition(lambda self: self.clip is not None)
    @rule(
        what=strategies.sampled_from(
            ["tracks", "audio", "problems", "duration", "metadata", "size", "up", "rungs"]
        )
    )
    def ask(self, what):
        found = self.guarded(lambda: getattr(self.clip, what))
        if what == "problems" and found:
            # Some vectors have samples with headers alone, which do not decode.
            assert all("track" in str(problem) and "sample" in str(problem) for problem in found)
        if what == "size" and found is not None:
            assert found == len(self.content)

    @precondition(lambda self: self.clip is not None)
    @rule(offset=strategies.integers(0, 12000), size=strategies.integers(0, 500))
    def bytes_of_it(self, offset, size):
        if self.closed or offset + size <= len(self.content):
            found = self.guarded(lambda: self.clip.read_at(offset, size))
            assert found is None or found == self.content[offset : offset + size]
        else:
            with pytest.raises(fvv.UsageError, match="bytes at"):
                self.clip.read_at(offset, size)

    @precondition(lambda self: self.clip is not None)
    @rule()
    def chunks_of_it(self):
        found = self.guarded(lambda: self.clip.chunks())
        assert found is None or (found["offset"] + found["size"] < len(self.content)).all()

    @precondition(lambda self: self.clip is not None)
    @rule()
    def close(self):
        self.clip.close()
        self.closed = True
        assert self.clip.closed

    @invariant()
    def what_was_read_stays(self):
        for positions, copy in self.kept:
            assert (positions == copy).all()


TestReaders = Readers.TestCase
TestReaders.settings = settings(max_examples=EXAMPLES * 4 // 10, stateful_step_count=15)
TestClips = Clips.TestCase
TestClips.settings = settings(max_examples=EXAMPLES * 3 // 10, stateful_step_count=15)


@settings(max_examples=2 * EXAMPLES)
@given(
    strategies.sampled_from(SMALL),
    strategies.floats(0, 1),
    strategies.floats(0, 1),
    strategies.sampled_from(KINDS),
)
@example("tiny_tetrahedron", 0.0, 0.0, bytes)
@example("tiny_empty", 1.0, 1.0, memoryview)
def test_two_cuts_anywhere(name, one, two, kind):
    content = CONTENTS[name]
    first, second = sorted((round(one * len(content)), round(two * len(content))))
    reader, found = fvv.Reader(pictures=False), []
    for part in (content[:first], content[first:second], content[second:]):
        found += seen(reader.feed(kind(part)))
    assert found + seen(reader.finish()) == MODELS.setdefault(name, model(content))


MODELS = {}


@given(strategies.sampled_from(SMALL), strategies.floats(0, 1), strategies.integers(0, 2000))
@example("delta_stencils", 1.0, 1)
def test_a_stream_that_is_joined_late(name, part, size):
    """From the configuration on, then from anywhere: frames are those of the stream."""
    content = CONTENTS[name]
    begin = content.index(b"GRUP") if b"GRUP" in content else len(content)
    cut = begin + round(part * (len(content) - begin))
    try:
        events = fed(content[:begin] + content[cut:], [size] * 8, pictures=False, join=True)
    except fvv.Error as error:
        assert not isinstance(error, fvv.UsageError)
        return
    for event in events:
        if isinstance(event, fvv.FrameEvent):
            frame = event.frame
            found = [(t, m.lattice.tobytes(), m.indices.tobytes()) for t, m in frame.meshes.items()]
            assert found == whole(name)[frame.ticks]["mesh"]


@given(damaged())
@example(("delta_field", flipped(CONTENTS["delta_field"], CONTENTS["delta_field"].rindex(b"GEND") + 20)))
def test_chunks_of_damaged_streams_lie_in_them(case):
    _, content = case
    clip = opened(content)
    if clip is None:
        return
    with clip:
        chunks = clip.chunks()
        assert (chunks["offset"] + chunks["size"] < len(content)).all()
        for group in sorted(set(chunks["group"].tolist())):
            assert (clip.chunks(group) == chunks[chunks["group"] == group]).all()


@given(
    strategies.integers(1, 10**6),
    strategies.none() | strategies.integers(0, 2 * 10**6),
    strategies.none() | strategies.integers(0, 2 * 10**6),
)
@example(1, None, 0)
@example(10, 9, 9)
@example(10, 10, None)
def test_ranges_are_those_of_a_slice(size, first, last):
    text = f"bytes={'' if first is None else first}-{'' if last is None else last}"
    places = range(size)
    if first is None:
        places = places[max(0, size - last) :] if last else places[:0]
    else:
        places = places[first : None if last is None else last + 1]
    expected = (places[0], places[-1]) if places else None
    assert player.range_of(text, size) == expected


@given(strategies.integers(1, 9), strategies.integers(1, 9), strategies.binary(min_size=300, max_size=300))
def test_pictures_come_back(height, width, content):
    pixels = numpy.frombuffer(content, numpy.uint8)[: 3 * height * width].reshape(height, width, 3)
    back = numpy.asarray(Image.open(io.BytesIO(pictures.png(pixels))))
    assert (back == pixels).all()
