"""Damage, limits, errors, and push reading: by examples and by hypothesis."""

import json
import os
import pickle
import struct
import time

import fvv
import hypothesis
import numpy
import pytest
from conftest import CONFORMANCE, VECTORS, tool
from hypothesis import strategies
from reference import container
from vectors import name_of
from vectors import path_of as vector

FIELD = (vector("delta_field")).read_bytes()
SOUNDS = (vector("audio_two_sounds")).read_bytes()
CONTENTS = {name_of(p): p.read_bytes() for p in VECTORS}
PATCHED = {
    name: (CONFORMANCE / "cases/valid" / name / "input.fvv").read_bytes()
    for name in ("patched_colours", "patched_unseen", "patched_full", "patched_visibility", "patched_groups")
}


def flipped(content, at, bit=0):
    return content[:at] + bytes([content[at] ^ 1 << bit]) + content[at + 1 :]


def positions_of(content):
    with fvv.open(content) as clip:
        return {f.number: f.mesh.lattice.tobytes() if f.mesh else None for f in clip}


def test_64_gib_after_the_footer_cost_nothing(tmp_path):
    path = tmp_path / "sparse.fvv"
    path.write_bytes(FIELD)
    for size in (len(FIELD) + 1, len(FIELD) + 70_000, 64 << 30):
        os.truncate(path, size)
        begin = time.monotonic()
        with fvv.open(path) as clip:
            found = {f.number: f.mesh.lattice.tobytes() for f in clip}
            problems = clip.problems
        checked = fvv.check(path)
        printed = json.loads(tool("fvvinfo", "--json", path, code=1))["files"][0]
        # All of them were read before, which takes minutes.
        assert time.monotonic() - begin < 20
        assert found == positions_of(FIELD)
        assert [(p.issue, p.offset) for p in problems] == [(1303, len(FIELD))]
        assert [(p.issue, p.offset) for p in checked.problems] == [(1303, len(FIELD))]
        assert checked.bytes == printed["bytes"] == size and checked.complete and not checked.ok
        assert [p["issue"] for p in printed["problems"]] == ["FVV-1303"]


# Errors.


def test_exceptions():
    for kind in (fvv.DamagedError, fvv.LimitError, fvv.UnsupportedError, fvv.UsageError):
        assert issubclass(kind, fvv.Error)
    assert issubclass(fvv.UsageError, ValueError) and not issubclass(fvv.DamagedError, ValueError)
    error = fvv.DamagedError("x: 0x10: MESH: wrong [FVV-3]", file="x", chunk="MESH", offset=16, issue=3)
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again), again.file, again.chunk, again.offset, again.issue) == (
        fvv.DamagedError, "x: 0x10: MESH: wrong [FVV-3]", "x", "MESH", 16, 3)  # fmt: skip


def test_no_stream():
    for content in (b"", b"no stream", bytes(1000)):
        with pytest.raises(fvv.DamagedError) as caught:
            fvv.open(content)
        assert caught.value.file == "bytes"


def test_a_later_version():
    content = bytearray(CONTENTS["tiny_tetrahedron"])
    with pytest.raises((fvv.UnsupportedError, fvv.DamagedError)):
        fvv.open(bytes(content[:8]) + struct.pack("<4H", 9, 9, 9, 9) + bytes(content[16:]))


def test_damage_is_named(tmp_path):
    path = tmp_path / "field.fvv"
    chunk = [c for c in container.chunks(FIELD) if c.kind == b"MESH"][3]
    path.write_bytes(flipped(FIELD, FIELD.index(chunk.payload) + 5))
    with fvv.open(path) as clip:
        assert len(clip) == 7 and clip.problems == []
        good = [frame.mesh.lattice.tobytes() for frame in clip[:3]]
        assert good == [frame.mesh.lattice.tobytes() for frame in fvv.open(FIELD)[:3]]
        for frame in clip[3:]:
            with pytest.raises(fvv.DamagedError) as caught:
                frame.mesh  # noqa: B018
        assert caught.value.file == str(path) and caught.value.chunk == "MESH" and caught.value.issue
        assert f"FVV-{caught.value.issue:04}" in str(caught.value) or f"FVV-{caught.value.issue}" in str(
            caught.value
        )
        (problem,) = clip.problems
        assert (problem.chunk, problem.offset, problem.issue) == (
            "MESH",
            caught.value.offset,
            caught.value.issue,
        )
        assert str(problem) == str(caught.value)
        # A frame that decodes is still read after one that does not.
        assert clip[0].mesh.lattice.tobytes() == good[0]
    found = fvv.check(path)
    (file,) = json.loads(tool("fvvinfo", "--json", "--check", path, code=1))["files"]
    assert (
        not found.ok
        and found.whole_frames == file["whole_frames"]
        and found.problem_count == file["problem_count"]
    )
    assert found.problems[0].offset == problem.offset


def test_a_stream_that_is_cut():
    cut = SOUNDS[: SOUNDS.rindex(b"GEND") - 4]
    with fvv.open(cut) as clip:
        assert clip.problems
        intact = [frame.number for frame in clip if frame.intact]
        assert intact[:3] == [0, 1, 2]
        for frame in clip:
            if not frame.intact:
                with pytest.raises(fvv.DamagedError):
                    frame.mesh  # noqa: B018
    assert not fvv.check(cut).complete


def test_frames_keep_their_numbers(players, tmp_path):
    content = players.read_bytes()
    groups = [i for i in range(0, len(content), 8) if content[i : i + 4] == b"GRUP"]
    with fvv.open(content) as clip:
        expected = {f.number: f.mesh.lattice.tobytes() for f in clip}
    # Without the second group, its end and the index, by a reader that has to scan.
    damaged = content[: groups[1]] + bytes(groups[2] - groups[1]) + content[groups[2] : -64]
    path = tmp_path / "damaged.fvv"
    path.write_bytes(damaged)
    tool("fvvdemux", path, "-o", tmp_path / "out", "--pictures", "none", code=3)
    written = sorted(int(p.stem) for p in (tmp_path / "out/meshes").iterdir())
    with fvv.open(damaged) as clip:
        found = {f.number: f.mesh.lattice.tobytes() for f in clip if f.intact}
        assert any("lost" in str(problem) for problem in clip.problems)
    assert sorted(found) == written == [0, 1, 2, 3, 4, 10, 11]
    assert all(expected[number] == lattice for number, lattice in found.items())


def test_a_group_whose_configuration_is_lost_has_that_of_a_repetition():
    # Found by test_damage_is_never_taken_for_good: the lattice step was 0.
    good = CONTENTS["environment_stage"]
    scene = good.index(b"SCEN")
    with fvv.open(good) as clip, fvv.open(good[:scene] + good[scene + 1 :]) as damaged_clip:
        assert damaged_clip[0].mesh.step == clip[0].mesh.step > 0
        assert damaged_clip.problems


def test_without_an_index_a_damaged_chunk_of_another_rung_costs_nothing(players):
    """Also before a group's first picture, where the layout of the pictures might be lost."""

    def shown(frame):
        return frame.mesh.lattice.tobytes(), frame.pictures[2].pixels.tobytes()

    content = players.read_bytes()
    content = content[: content.rindex(b"INDX")]
    with fvv.open(content) as clip:
        best, other = (set(rung.tracks) for rung in clip.rungs)
        expected = [shown(frame) for frame in clip]
    at, tried, first = 24, 0, content.index(b"GRUP")
    for chunk in container.chunks(content):
        middle, at = at + 32 + len(chunk.payload) // 2, at + 32 + (len(chunk.payload) + 7) // 8 * 8
        if at < first or chunk.time or chunk.track not in best ^ other:
            continue
        with fvv.open(flipped(content, middle)) as clip:
            if chunk.track in other:
                assert [shown(frame) for frame in clip] == expected and clip.problems
                tried += 1
            elif chunk.kind in (b"MESH", b"VPKT"):
                assert [frame.intact for frame in clip] == [False] * 5 + [True] * 7
    assert tried


def test_read_from_a_pipe_a_damaged_chunk_of_another_rung_costs_nothing(players):
    """Nor does one of a kind that is not decoded; one that is decoded costs the frames from it to the end of its group."""
    content = players.read_bytes()
    with fvv.open(content) as clip:
        best, other = (set(rung.tracks) for rung in clip.rungs)

    def shown(stream):
        frames = [
            event.frame
            for event in fed(stream, [5000], visibility=False)
            if isinstance(event, fvv.FrameEvent)
        ]
        return {f.ticks: (f.mesh.lattice.tobytes(), f.pictures[2].pixels.tobytes()) for f in frames}

    expected = shown(content)
    assert len(expected) == 12
    at, first, tried = 24, content.index(b"GRUP"), {}
    for chunk in container.chunks(content):
        middle, at = at + 32 + len(chunk.payload) // 2, at + 32 + (len(chunk.payload) + 7) // 8 * 8
        if at < first or chunk.kind not in (b"MESH", b"VPKT", b"VISI"):
            continue
        is_used = chunk.track in best and chunk.kind != b"VISI"
        key = (chunk.kind, is_used)
        tried[key] = tried.get(key, 0) + 1
        if tried[key] > 4:
            continue
        found = shown(flipped(content, middle))
        assert all(found[ticks] == expected[ticks] for ticks in found)
        if not is_used:
            assert len(found) == 12, chunk
        else:
            group = [t for t in expected if t < chunk.time]
            assert len(found) < 12 and all(t in found for t in group)
    assert {(b"VPKT", False), (b"VISI", False), (b"VPKT", True), (b"MESH", True)} <= tried.keys()


def test_damaged_pictures(players):
    content = players.read_bytes()
    with fvv.open(content) as clip:
        expected = [frame.pictures[2].pixels.tobytes() for frame in clip]
        meshes = [frame.mesh.lattice.tobytes() for frame in clip]
        track = next(track.id for track in clip.tracks if track.kind == "video" and track.selected)
    samples = [c for c in container.chunks(content) if c.kind == b"VPKT" and c.track == track]
    bad = flipped(content, content.index(samples[2].payload) + 9)
    with fvv.open(bad) as clip:
        # Backwards too: frame 2 is lost, and with it what depends on it in its group.
        for order in (range(12), reversed(range(12))):
            for i in order:
                if i in (2, 3, 4):
                    with pytest.raises(fvv.DamagedError) as caught:
                        clip[i].pictures[2]  # noqa: B018
                    assert caught.value.chunk == "VPKT"
                else:
                    assert clip[i].pictures[2].pixels.tobytes() == expected[i]
        assert [frame.mesh.lattice.tobytes() for frame in clip] == meshes
        assert len(clip.problems) == 1
    frames = frames_of(fed(bad, []))
    assert [frame.ticks for frame in frames] == [0, 1, *range(5, 12)]
    assert frames[2].pictures[2].pixels.tobytes() == expected[5]


def test_damaged_sound():
    chunk = [c for c in container.chunks(SOUNDS) if c.kind == b"AUDI" and c.track == 3][1]
    # Both tracks have silence: the first of two equal payloads is track 3's.
    with fvv.open(flipped(SOUNDS, SOUNDS.index(chunk.payload) + 9)) as clip:
        pieces = [sound for sound in clip.audio if sound.track == 3]
        assert [len(piece.packets) for piece in pieces] == [2, 8]
        assert pieces[1].packets_start == 3840 and pieces[1].start == (3840 + 4 * 960) / 48000
        for piece in pieces:
            assert piece.samples().shape == (round(piece.duration * 48000), 1)
        assert any("sound is lost" in str(problem) for problem in clip.problems)


def test_limits(players):
    with fvv.open(players, limits=fvv.Limits(max_vertices=100)) as clip, pytest.raises(fvv.LimitError):
        clip[0].mesh  # noqa: B018
    with fvv.open(players, limits=fvv.Limits(max_picture_memory=1000)) as clip:
        assert clip[0].mesh.vertex_count
        with pytest.raises(fvv.LimitError, match="max_picture_memory"):
            clip[0].pictures[0]  # noqa: B018
    with fvv.open(players, limits=fvv.Limits(max_tracks=1)) as clip, pytest.raises(fvv.LimitError):
        clip.tracks  # noqa: B018
    assert fvv.check(players, limits=fvv.Limits(max_payload=10_000)).problem_count
    with pytest.raises(fvv.UsageError):
        fvv.open(players, limits=fvv.Limits(max_faces=0))
    with pytest.raises(fvv.UsageError):
        fvv.open(players, limits=fvv.Limits(max_faces=1 << 40))


# Push reading.


def fed(content, sizes, **options):
    reader = fvv.Reader(**options)
    events, at = [], 0
    for size in sizes:
        events += reader.feed(content[at : at + size])
        at += size
    return events + reader.feed(memoryview(content)[at:]) + reader.finish()


def seen(events):
    """What events hold, to compare."""
    out = []
    for event in events:
        if isinstance(event, fvv.FrameEvent):
            frame = event.frame
            out.append((frame.number, frame.ticks, [(t, m.lattice.tobytes(), m.indices.tobytes(), m.normals.tobytes(),
                        None if m.colours is None else m.colours.tobytes()) for t, m in frame.meshes.items()],
                        [(i, p.pixels.tobytes(), p.source) for i, p in frame.pictures.items()],
                        [(c.id, c.K.tobytes(), c.R.tobytes(), c.t.tobytes()) for c in frame.cameras.values()],
                        weights_of(frame)))  # fmt: skip
        elif isinstance(event, fvv.SoundEvent):
            out.append((event.track, event.start, event.samples.tobytes(), event.position))
        elif isinstance(event, fvv.Damage):
            out.append((str(event.problem), event.skipped))
        else:
            out.append(type(event).__name__)
    return out


def weights_of(frame):
    """The visibility of all cameras, where the reader decodes it."""
    try:
        found = [(camera, frame.visibility(camera)) for camera in frame.cameras]
    except fvv.UsageError:
        return None
    return [(camera, None if weights is None else weights.tobytes()) for camera, weights in found]


def frames_of(events):
    return [event.frame for event in events if isinstance(event, fvv.FrameEvent)]


def equal(a, b, pictures=True):
    assert (a.ticks, list(a.meshes), list(a.cameras)) == (b.ticks, list(b.meshes), list(b.cameras))
    for track, mesh in a.meshes.items():
        other = b.meshes[track]
        for name in ("positions", "lattice", "indices", "normals", "uvs", "colours"):
            one, two = getattr(mesh, name), getattr(other, name)
            assert (one is None and two is None) or one.tobytes() == two.tobytes(), name
    for identifier, camera in a.cameras.items():
        assert camera.R.tobytes() == b.cameras[identifier].R.tobytes()
        assert camera.K.tobytes() == b.cameras[identifier].K.tobytes()
    if pictures:
        assert list(a.pictures) == list(b.pictures)
        for identifier, picture in a.pictures.items():
            other = b.pictures[identifier]
            assert picture.pixels.tobytes() == other.pixels.tobytes() and picture.source == other.source
            assert picture.camera.K.tobytes() == other.camera.K.tobytes()


@pytest.mark.parametrize("name", sorted({**CONTENTS, **PATCHED}))
def test_a_reader_gives_what_a_clip_gives(name):
    # Some vectors have samples with headers alone.
    content = {**CONTENTS, **PATCHED}[name]
    pictures = name == "openexr_bars"
    events = fed(content, [100] * 20, pictures=pictures)
    assert isinstance(events[-1], fvv.End)
    frames = frames_of(events)
    if name == "tiny_empty":
        return
    with fvv.open(content) as clip:
        assert len(frames) == len(clip)
        for one, other in zip(frames, clip):
            equal(one, other, pictures)


def test_a_reader_decodes_pictures(players):
    content = players.read_bytes()
    for rung in (0, 1):
        with fvv.open(content, rung=rung) as clip:
            frames = frames_of(fed(content, [5000] * 9, rung=rung))
            assert len(frames) == len(clip)
            for one, other in zip(frames, clip):
                equal(one, other)


@pytest.mark.parametrize("name", sorted(n for n in CONTENTS if n != "tiny_empty"))
def test_a_reader_gives_the_visibility_of_a_clip(name):
    same_visibility(CONTENTS[name])


def test_a_reader_gives_the_visibility_of_players(players):
    assert same_visibility(players.read_bytes()) == 36


def same_visibility(content):
    frames, count = frames_of(fed(content, [777] * 20, pictures=False, visibility=True)), 0
    with fvv.open(content) as clip:
        for one, other in zip(frames, clip):
            for camera in other.cameras:
                weights, expected = one.visibility(camera), other.visibility(camera)
                assert (weights is None) == (expected is None)
                if weights is not None:
                    assert (weights == expected).all() and weights.dtype == numpy.uint8
                    assert not weights.flags.writeable
                    count += 1
            with pytest.raises(KeyError):
                one.visibility("no camera")
    return count


def test_visibility_is_decoded_on_demand():
    (frame, *_) = frames_of(fed(CONTENTS["visibility_sheet"], []))
    with pytest.raises(fvv.UsageError, match="visibility=True"):
        frame.visibility(next(iter(frame.cameras)))


def sounds_of(events):
    """By track: (start, rate, samples of all events), where they follow each other."""
    out = {}
    for event in events:
        if isinstance(event, fvv.SoundEvent):
            pieces = out.setdefault(event.track, [])
            if pieces:
                last = pieces[-1]
                assert event.start == pytest.approx(last.start + len(last.samples) / last.rate)
            pieces.append(event)
    return {
        track: (p[0].start, p[0].rate, numpy.concatenate([e.samples for e in p])) for track, p in out.items()
    }


@pytest.mark.parametrize("sizes", [[], [500] * 300])
def test_a_reader_gives_the_sound_of_a_clip(players, sizes):
    for content in (SOUNDS, players.read_bytes()):
        events = fed(content, sizes, pictures=False, sound=True)
        found = sounds_of(events)
        with fvv.open(content) as clip:
            assert found.keys() == {sound.track for sound in clip.audio} != set()
            for sound in clip.audio:
                start, rate, samples = found[sound.track]
                assert (start, rate) == (sound.start, sound.rate) and samples.dtype == numpy.float32
                assert samples.tobytes() == sound.samples().tobytes()
                places = [
                    e.position for e in events if isinstance(e, fvv.SoundEvent) and e.track == sound.track
                ]
                assert all((place is None) == (sound.position_at(0) is None) for place in places)
        assert not any(isinstance(e, fvv.SoundEvent) for e in fed(content, sizes, pictures=False))


def test_sound_that_moves(players):
    with fvv.open(players) as clip:
        claps, ball = clip.audio
        assert claps.position is None is claps.position_at(0.1) and not claps.moves
        assert ball.moves and ball.position is None
        events = [
            e
            for e in fed(players.read_bytes(), [], pictures=False, sound=True)
            if isinstance(e, fvv.SoundEvent)
        ]
        places = [e.position for e in events if e.track == ball.track]
        assert len(places) == len(clip) and len(set(places)) > 5
        for frame, place in zip(clip, places):
            assert ball.position_at(frame.time) == pytest.approx(place)
        assert ball.position_at(0.06) == pytest.approx((numpy.array(places[1]) + places[2]) / 2)
        assert ball.position_at(-5) == pytest.approx(places[0]) and ball.position_at(1e300) == pytest.approx(
            places[-1]
        )
        with pytest.raises(fvv.UsageError):
            ball.position_at(float("nan"))
    with fvv.open(SOUNDS) as clip:
        still = [sound for sound in clip.audio if sound.position is not None]
        assert all((sound.position_at(3) == sound.position).all() for sound in still)


def test_sound_of_a_stream_that_is_joined_late(players):
    content = players.read_bytes()
    groups = [i for i in range(0, len(content), 8) if content[i : i + 4] == b"GRUP"]
    joined = content[: groups[0]] + content[groups[1] :]
    found = sounds_of(fed(joined, [], pictures=False, sound=True, join=True))
    whole_ones = sounds_of(fed(content, [], pictures=False, sound=True))
    for track, (start, rate, samples) in found.items():
        assert start == 0.2
        # The decoder forgets what came before the pre-roll.
        assert (
            numpy.abs(samples[rate // 50 :] - whole_ones[track][2][-len(samples) :][rate // 50 :]).max()
            < 1e-3
        )


def test_frames_come_as_soon_as_they_are_whole():
    reader, counts = fvv.Reader(pictures=False), []
    for at in range(0, len(FIELD), 1000):
        counts.append(len(frames_of(reader.feed(FIELD[at : at + 1000]))))
    assert sum(counts) == 7 and max(counts) < 4


def test_damage_is_an_event():
    chunk = [c for c in container.chunks(SOUNDS) if c.kind == b"MESH"][2]
    damaged = flipped(SOUNDS, SOUNDS.index(chunk.payload, SOUNDS.index(b"GRUP")) + 8)
    events = fed(damaged, [])
    damage = [event for event in events if isinstance(event, fvv.Damage)]
    assert damage[0].problem.chunk == "MESH" and damage[0].problem.issue and damage[0].skipped
    assert [frame.ticks for frame in frames_of(events)][-3:] == [3, 4, 5]
    assert isinstance(events[-1], fvv.End)


def test_a_reader_is_used_in_order():
    reader = fvv.Reader()
    reader.feed(FIELD)
    reader.finish()
    assert reader.finish() == []
    with pytest.raises(fvv.UsageError):
        reader.feed(b"more")
    with pytest.raises(fvv.DamagedError, match="empty"):
        fvv.Reader().finish()
    with pytest.raises(TypeError):
        fvv.Reader().feed("text")
    with pytest.raises(fvv.UsageError):
        fvv.Reader(rung=-1)


def test_a_stream_joined_late(players):
    content = players.read_bytes()
    groups = [i for i in range(0, len(content), 8) if content[i : i + 4] == b"GRUP"]
    late = content[: groups[0]] + content[groups[1] :]
    frames = frames_of(fed(late, [], join=True, pictures=False))
    with fvv.open(content) as clip:
        assert [frame.ticks for frame in frames] == [frame.ticks for frame in clip[5:]]
        equal(frames[0], clip[5], pictures=False)


# By hypothesis.


@hypothesis.given(strategies.slices(12))
def test_slices(players, chosen):
    with fvv.open(players) as clip:
        assert [frame.index for frame in clip[chosen]] == list(range(12))[chosen]


@hypothesis.given(strategies.lists(strategies.integers(0, 6), max_size=8))
def test_any_order_of_frames_gives_the_same(order):
    expected = positions_of(FIELD)
    with fvv.open(FIELD) as clip:
        for number in order:
            assert clip[number].mesh.lattice.tobytes() == expected[number]


@hypothesis.given(strategies.integers(0, 11), strategies.floats(0, 0.0399))
def test_at(players, index, after):
    with fvv.open(players) as clip:
        frame = clip[index]
        assert clip.at(frame.time).index == index
        assert clip.at(min(frame.time + after, 0.4799)).index == index


@hypothesis.given(
    strategies.sampled_from(sorted(CONTENTS)), strategies.lists(strategies.integers(0, 4000), max_size=8)
)
def test_any_split_gives_the_same_events(name, sizes):
    wanted = {"pictures": False, "visibility": True, "sound": True}
    assert seen(fed(CONTENTS[name], sizes, **wanted)) == seen(fed(CONTENTS[name], [], **wanted))


@strategies.composite
def damaged(draw):
    """A vector with bits flipped, bytes cut out, repeated or cut off."""
    name = draw(strategies.sampled_from(sorted(CONTENTS)))
    content = CONTENTS[name]
    for _ in range(draw(strategies.integers(1, 3))):
        at = draw(strategies.integers(0, len(content) - 1))
        what = draw(strategies.sampled_from(["flip", "cut", "drop", "repeat"]))
        size = draw(strategies.integers(1, 400))
        if what == "flip":
            content = flipped(content, at, draw(strategies.integers(0, 7)))
        elif what == "cut":
            content = content[: at + 1]
        elif what == "drop":
            content = content[:at] + content[at + size :] or b"\0"
        else:
            content = content[:at] + content[at : at + size] + content[at:]
    return name, content


def values(frame):
    """What a frame holds, by name; an Error in place of what is damaged."""
    out = {}
    for name, read in {
        "mesh": lambda: [(t, m.lattice.tobytes(), m.indices.tobytes()) for t, m in frame.meshes.items()],
        "cameras": lambda: [(c.id, c.R.tobytes(), c.t.tobytes()) for c in frame.cameras.values()],
        "pictures": lambda: [(i, p.pixels.tobytes()) for i, p in frame.pictures.items()],
        "visibility": lambda: [
            (i, None if (w := frame.visibility(i)) is None else w.tobytes()) for i in frame.cameras
        ],
    }.items():
        try:
            out[name] = read()
        except fvv.Error as error:
            assert not isinstance(error, fvv.UsageError)
            out[name] = None
    return out


WHOLE = {}


def whole(name):
    """The values of the frames of an undamaged vector, by time."""
    if name not in WHOLE:
        try:
            with fvv.open(CONTENTS[name]) as clip:
                WHOLE[name] = {frame.ticks: values(frame) for frame in clip}
        except fvv.DamagedError:
            WHOLE[name] = {}
    return WHOLE[name]


def opened(content):
    """The clip in the bytes, or None if they are too damaged for one."""
    try:
        return fvv.open(content)
    except fvv.Error as error:
        assert not isinstance(error, fvv.UsageError)
        return None


@hypothesis.given(damaged())
def test_damage_is_never_taken_for_good(case):
    """Frames of a damaged stream are those of the undamaged one, or raise."""
    name, content = case
    expected = whole(name)
    clip = opened(content)
    if clip is None:
        return
    with clip:
        for frame in clip:
            try:
                ticks = frame.ticks
            except fvv.Error as error:
                assert not isinstance(error, fvv.UsageError) and not frame.intact
                continue
            for what, value in values(frame).items():
                assert value is None or value == expected[ticks][what]
        try:
            assert all(isinstance(sound.samples(), numpy.ndarray) for sound in clip.audio)
        except fvv.Error as error:
            assert not isinstance(error, fvv.UsageError)
        assert all(str(problem) for problem in clip.problems)
    assert content == CONTENTS[name] or not fvv.check(content).ok


@hypothesis.given(damaged(), strategies.lists(strategies.integers(0, 3000), max_size=4))
def test_a_reader_never_takes_damage_for_good(case, sizes):
    name, content = case
    expected = whole(name)
    try:
        frames = frames_of(fed(content, sizes, pictures=False, visibility=True, sound=True))
    except fvv.Error as error:
        assert not isinstance(error, fvv.UsageError)
        return
    for frame in frames:
        found = [(t, m.lattice.tobytes(), m.indices.tobytes()) for t, m in frame.meshes.items()]
        assert found == expected[frame.ticks]["mesh"]
        weights = expected[frame.ticks]["visibility"]
        assert weights is None or weights_of(frame) == weights


@hypothesis.given(strategies.binary(max_size=300))
def test_any_bytes(content):
    with pytest.raises(fvv.Error):
        fvv.open(content)
    assert not fvv.check(content).ok
