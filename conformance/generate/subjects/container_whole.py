"""Whole streams: order, configuration, groups, time, text, live streams, unknown chunks. Clauses 2 to 7 and 11."""

import json

from .. import meshes, payloads
from ..case import valid
from ..recipes import block, finished, frame, group, opened
from ..writer import Stream

OTHER = 128  # the first private kind of a track
TIME_MAX = 2**63 - 1


def ended(s):
    s.finish()
    return s


def one(scene=None, track=b"", start=0, times=(0,), end=1, more=None):
    """One group of meshes at given times."""
    s = opened((1, track or payloads.track(payloads.MESH, "mesh")), scene=scene)
    if more:
        more(s)
    s.begin(start, end)
    for time in times:
        frame(s, time)
    s.end()
    return ended(s)


def counts():
    valid("groups_none", "A closed stream without groups.", "3.3 7.1", lambda: ended(opened()))
    valid("groups_none_scene_only", "A closed stream whose only block is SCEN.", "3.3", scene_only)
    valid("group_empty", "A group without chunks between GRUP and GEND.", "6.2", lambda: counted([0]))
    valid("groups_empty_many", "Twenty groups without chunks.", "6.2 7.1", lambda: counted([0] * 20))
    valid("frame_one", "One group of one frame.", "6", lambda: counted([1]))
    valid("frames_many", "One group of 100 frames.", "6 11", lambda: counted([100]))
    valid("groups_many", "100 groups of one frame.", "7.1", lambda: counted([1] * 100))
    valid("groups_uneven", "Groups of 3, 0, 1, 7 and 2 frames.", "6", lambda: counted([3, 0, 1, 7, 2]))
    valid("tracks_16", "16 mesh tracks, the number that every reader supports.", "5.2 13", lambda: tracks(16))
    valid(
        "tracks_200",
        "200 declared tracks, of which two have chunks.",
        "5.2 13",
        lambda: tracks(200, used=(1, 200)),
        uncommon=True,
        limits=True,
    )
    valid("track_65535", "The only track has the greatest identifier.", "5.2", lambda: tracks(1, first=65535))
    valid(
        "tracks_unordered", "Tracks are declared in descending order.", "5.2", lambda: tracks(5, reverse=True)
    )


def counted(frames):
    s, time = opened(), 0
    for count in frames:
        group(s, time, count)
        time += max(count, 1)
    return ended(s)


def scene_only():
    s = Stream()
    s.chunk("SCEN", payloads.scene())
    return ended(s)


def tracks(count, first=1, used=None, reverse=False):
    numbers = list(range(first, first + count))
    declared = numbers[::-1] if reverse else numbers
    s = opened(*[(number, payloads.track(payloads.MESH, f"track {number}")) for number in declared])
    s.begin(0, 2)
    for time in 0, 1:
        for number in used or numbers:
            frame(s, time, meshes.TETRAHEDRON.moved(number % 1000), track=number)
    s.end()
    return ended(s)


def time():
    for name, numerator, denominator in (
        ("29_97", 1001, 30000),
        ("90_khz", 1, 90000),
        ("slow", 4294967295, 1),
        ("fast", 1, 4294967295),
        ("not_reduced", 40, 1000),
    ):
        scene = payloads.scene(time_base_numerator=numerator, time_base_denominator=denominator)
        valid(
            f"time_base_{name}",
            f"The time base is {numerator}/{denominator}.",
            "5.1 11",
            lambda scene=scene: one(scene, times=(0, 1), end=2),
            uncommon=name in ("slow", "fast"),
        )
    valid(
        "time_negative", "All times are negative.", "11", lambda: one(start=-10, times=(-10, -9, -1), end=0)
    )
    valid("time_across_zero", "A group from -2 to 2.", "11", lambda: one(start=-2, times=range(-2, 2), end=2))
    valid(
        "time_least",
        "A group starts at the least time.",
        "11",
        lambda: one(start=-TIME_MAX - 1, times=(-TIME_MAX - 1, -TIME_MAX), end=-TIME_MAX + 1),
        uncommon=True,
    )
    valid(
        "time_greatest",
        "A group ends at the greatest time.",
        "11",
        lambda: one(start=TIME_MAX - 2, times=(TIME_MAX - 2, TIME_MAX - 1), end=TIME_MAX),
        uncommon=True,
    )
    valid(
        "time_whole_range",
        "One group covers all times: differences in its table exceed 63 bits.",
        "6.3 11",
        lambda: one(start=-TIME_MAX - 1, times=(-TIME_MAX - 1, 0, TIME_MAX - 1), end=TIME_MAX),
        uncommon=True,
    )
    valid(
        "time_missing_frames",
        "Frames at 0, 1, 5 and 6 of 8 ticks.",
        "11",
        lambda: one(times=(0, 1, 5, 6), end=8),
    )
    valid(
        "time_first_later",
        "The first mesh comes after the start of the group: the stage is empty before.",
        "11",
        lambda: one(times=(3, 4), end=6),
    )
    valid(
        "time_gap_between_groups",
        "Nothing is between the end of a group and the start of the next.",
        "6.1",
        gaps,
    )
    valid(
        "time_nominal_duration",
        "The nominal duration is 7 ticks; frames have other distances.",
        "5.1 11",
        lambda: one(payloads.scene(frame_duration=7), times=(0, 7, 13, 21), end=28),
    )
    valid(
        "time_duration_greatest",
        "The nominal duration is 2^63 - 1.",
        "5.1",
        lambda: one(payloads.scene(frame_duration=TIME_MAX)),
        uncommon=True,
    )


def gaps():
    s = opened()
    for start in (0, 100, 10**12):
        group(s, start)
    return ended(s)


def scenes():
    for axis, name in enumerate(("unknown", "x", "y", "z", "minus_x", "minus_y", "minus_z")):
        valid(
            f"up_{name}",
            f"The up axis is {axis}.",
            "5.1",
            lambda axis=axis: one(payloads.scene(up_axis=axis)),
        )
    valid("scale_unknown", "Lengths are in units of the source.", "5.1", lambda: one(payloads.scene(flags=1)))
    for name, origin, step in (
        ("origin", (1.5, -2.25, 1e3), 0.001),
        ("step_third", (0.1, 0.2, 0.3), 1 / 3),
        ("step_tiny", (0.0, 0.0, 0.0), 5e-324),
        ("step_large", (-1e300, 1e300, 0.0), 1e290),
        ("origin_minus_zero", (-0.0, -0.0, -0.0), 2.0**-10),
    ):
        rare = name in ("step_tiny", "step_large")
        scene = payloads.scene(lattice_origin=origin, lattice_step=step)
        valid(
            f"lattice_{name}",
            f"The lattice begins at {origin} and has steps of {step!r}.",
            "5.1 8.2",
            lambda scene=scene: one(scene),
            uncommon=rare,
            requirements=(9008,),
        )


def names():
    for name, text in (
        ("empty", ""),
        ("ascii", "a mesh of two players"),
        ("utf8", "Spieler № 7 — 選手"),
        ("four_bytes", "\U0001f3c0 \U0010ffff"),
        ("controls", "tab\tnewline\ndelete\x7f"),
        ("combining", "e\u0301 and \u00e9"),
        ("quotes", '<b>"&amp;\\'),
    ):
        valid(
            f"name_{name}",
            f"The name of a track is {json.dumps(text)}.",
            "2.2 5.2",
            lambda text=text: one(track=payloads.track(1, text)),
            uncommon=name == "controls",
        )
    valid(
        "name_long",
        "The name of a track has 20,000 bytes.",
        "5.2 13",
        lambda: one(track=payloads.track(1, "long " * 4000)),
        uncommon=True,
    )
    valid(
        "track_bit_rate",
        "A track states bit rate and nominal size, each 2^32 - 1.",
        "5.2",
        lambda: one(track=payloads.track(1, "m", bit_rate=2**32 - 1, nominal_size=2**32 - 1)),
    )

    def meta(*texts):
        def more(s):
            for text in texts:
                s.chunk("META", text.encode())

        return lambda: one(more=more)

    valid(
        "meta_object",
        "META with a JSON object.",
        "5.3",
        meta('{"title": "Spielzug 3", "takes": [1, 2.5, null]}'),
    )
    valid("meta_two", "Two META chunks of the scene and none is merged.", "5.3", meta('{"a": 1}', '{"a": 2}'))
    valid("meta_empty", "META without a byte.", "5.3", meta(""), uncommon=True)
    valid(
        "meta_no_json", "META that is no JSON: readers ignore it.", "5.3", meta("not { json"), uncommon=True
    )
    valid("meta_array", "META whose top level is an array.", "5.3", meta("[1]"), uncommon=True)
    valid("meta_long", "META of 30,000 bytes.", "5.3 13", meta(json.dumps({"text": "x" * 29988})))


def blocks():
    valid("block_repeated", "The same block before each of four groups.", "5 7.1", lambda: repeated(4))
    valid(
        "block_repeated_some",
        "The block is repeated before groups 2 and 5 of 6.",
        "5 7.1",
        lambda: repeated(6, (2, 5)),
    )
    valid(
        "block_twice_before_group",
        "Two equal blocks before the first group: only the second is listed.",
        "5 7.1",
        lambda: twice(payloads.scene()),
    )
    valid(
        "block_unused",
        "A block that differs has no group, and no effect.",
        "5 7.1",
        lambda: twice(payloads.scene(up_axis=1)),
        uncommon=True,
    )
    valid("block_last", "A block follows the last group.", "5 7.1", block_last, uncommon=True)
    valid(
        "block_changes_tracks",
        "The second block has other tracks, with the same identifier for another one.",
        "5",
        other_tracks,
    )
    valid("block_changes_up", "Up axis, flags and nominal duration change.", "5.1", other_scene)
    valid("block_returns", "Configurations A, B and A again, each with groups.", "5 7.1", back_to_first)


def repeated(groups, at=None):
    s = opened()
    for number in range(groups):
        if number and (at is None or number in at):
            block(s)
        group(s, 2 * number)
    return ended(s)


def twice(first):
    s = opened(scene=first)
    block(s)
    group(s, 0)
    return ended(s)


def block_last():
    s = opened()
    group(s, 0)
    block(s)
    return ended(s)


def other_tracks():
    s = opened((1, payloads.track(1, "first")), (2, payloads.track(1, "second")))
    s.begin(0, 1)
    frame(s, 0)
    frame(s, 0, meshes.OCTAHEDRON, track=2)
    s.end()
    block(s, (2, payloads.track(1, "now the only one")))
    s.begin(1, 2)
    frame(s, 1, meshes.TRIANGLE, track=2)
    s.end()
    return ended(s)


def other_scene():
    s = opened()
    group(s, 0)
    block(s, scene=payloads.scene(up_axis=2, flags=1, frame_duration=2))
    group(s, 2)
    return ended(s)


def back_to_first():
    s = opened()
    for number in range(3):
        if number:
            block(s, scene=payloads.scene(up_axis=number % 2))
        else:
            block(s, scene=payloads.scene(up_axis=0))
        group(s, 4 * number)
        group(s, 4 * number + 2)
    return ended(s)


def live():
    valid(
        "live_header_only",
        "A file header alone: a live stream that has just begun.",
        "7.3",
        Stream,
        uncommon=True,
    )
    valid(
        "live_configuration_only", "A live stream before its first group.", "7.3 6.4", opened, uncommon=True
    )
    valid("live_without_index", "Three groups without INDX and FOOT.", "7.3", lambda: live_groups(3))
    valid("live_block_last", "A live stream ends after a repeated block.", "7.3", live_block)
    valid("live_index_only", "A stream ends between INDX and FOOT.", "7.3", index_only, uncommon=True)


def live_groups(count):
    s = opened()
    for number in range(count):
        group(s, 2 * number)
    return s


def live_block():
    s = live_groups(2)
    block(s)
    return s


def index_only():
    s = finished()
    s.cut(len(s.out) - 56)
    return s


def unknown():
    """Clause 4.5."""

    def in_block(*chunks):
        def more(s):
            for code, payload, fields in chunks:
                s.chunk(code, payload, **fields)

        return lambda: one(more=more)

    valid(
        "unknown_in_block",
        "Unknown chunks in the block: private and reserved types, with and without track.",
        "4.5",
        in_block(("priv", b"private", {}), ("NEWT", b"", {"track": 1}), ("~~~~", bytes(100), {"track": 9})),
        uncommon=True,
        requirements=(9001,),
    )
    valid(
        "unknown_before_track",
        "An unknown chunk between SCEN and TRAK.",
        "4.5",
        unknown_before_track,
        uncommon=True,
        requirements=(9001,),
    )
    valid(
        "unknown_in_group",
        "Unknown chunks between, before and after the frames of a group.",
        "4.5",
        unknown_group,
        uncommon=True,
        requirements=(9001,),
    )
    valid(
        "unknown_key",
        "Unknown chunks with the key flag, and two of one type, track and time.",
        "4.5",
        unknown_key,
        uncommon=True,
        requirements=(9001,),
    )
    valid(
        "unknown_300",
        "300 unknown chunks between two frames: the counter passes 255.",
        "4.4 4.5",
        unknown_300,
        uncommon=True,
        requirements=(9001,),
    )
    valid(
        "unknown_alone",
        "A group of unknown chunks only: no frames.",
        "4.5 11",
        unknown_alone,
        uncommon=True,
        requirements=(9001,),
    )
    valid(
        "unknown_kind",
        "Tracks of an unknown and of a private kind.",
        "5.2",
        unknown_kinds,
        uncommon=True,
        requirements=(9002,),
    )
    valid(
        "unknown_kind_critical",
        "Critical chunks of unknown types on a track of an unknown kind, in the block and in a group.",
        "4.5 5.2",
        foreign_critical,
        uncommon=True,
        requirements=(9002,),
    )
    valid(
        "unknown_kind_frames",
        "Times of a track of an unknown kind are frames; a note on a mesh track is none.",
        "5.2 11",
        foreign_frames,
        uncommon=True,
        requirements=(9002,),
    )
    valid(
        "unknown_kind_base",
        "A track of an unknown kind has a time base of its own.",
        "5.2",
        lambda: ended(
            opened(
                (1, payloads.track(1)),
                (2, payloads.track(OTHER, time_base_numerator=1, time_base_denominator=44100)),
            )
        ),
        uncommon=True,
    )
    valid(
        "written_later",
        "A later minor version wrote the stream; this version can read it.",
        "3.2",
        lambda: header(written_minor=9),
        uncommon=True,
    )
    valid(
        "written_later_major",
        "Version 3.1 wrote the stream; this version can read it.",
        "3.2",
        lambda: header(written_major=3, written_minor=1),
        uncommon=True,
    )


def header(**fields):
    s = opened(**fields)
    group(s, 0)
    return ended(s)


def unknown_before_track():
    s = Stream()
    s.chunk("SCEN", payloads.scene())
    s.chunk("priv", b"early")
    s.chunk("TRAK", payloads.track(payloads.MESH, "mesh"), track=1)
    group(s, 0)
    s.finish()
    return s


def unknown_group():
    s = opened()
    s.begin(0, 3)
    s.chunk("note", b"before", time=0)
    frame(s, 0)
    s.chunk("note", b"between", 1, 0)
    s.chunk("XYZ1", b"\xff" * 33, 777, 1)
    frame(s, 2)
    s.chunk("note", b"", time=2)
    s.end()
    group(s, 3)
    return ended(s)


def unknown_key():
    s = opened()
    s.begin(0, 2)
    for payload in b"one", b"two":
        s.chunk("note", payload, 1, 0, flags=2)
    frame(s, 0)
    frame(s, 1)
    s.end()
    return ended(s)


def unknown_300():
    s = opened()
    s.begin(0, 2)
    frame(s, 0)
    for _ in range(300):
        s.chunk("priv", b"")
    frame(s, 1)
    s.end()
    return ended(s)


def unknown_alone():
    s = opened()
    s.begin(0, 5)
    s.chunk("note", b"x", 1, 4)
    s.end()
    group(s, 5)
    return ended(s)


def foreign_critical():
    s = opened((1, payloads.track(1)), (2, payloads.track(99, "points")))
    s.chunk("PCFG", b"how points are coded", 2, flags=1)
    s.begin(0, 2)
    for time in 0, 1:
        frame(s, time)
        s.chunk("PNTS", b"points", 2, time, flags=1)
    s.end()
    group(s, 2)
    return ended(s)


def foreign_frames():
    s = opened((1, payloads.track(1)), (2, payloads.track(99, "points", flags=1)))
    s.begin(0, 5)
    frame(s, 0)
    s.chunk("note", b"on a mesh track", 1, 1)
    for time in 2, 3:
        s.chunk("PNTS", b"points", 2, time, flags=2)
    frame(s, 4)
    s.chunk("PNTS", b"points", 2, 4)
    s.end()
    group(s, 5)
    return ended(s)


def unknown_kinds():
    s = opened((1, payloads.track(1)), (2, payloads.track(99, "later")), (3, payloads.track(200, "private")))
    s.begin(0, 2)
    for time in 0, 1:
        frame(s, time)
        s.chunk("LATE", b"of a later version", 2, time)
        s.chunk("mine", b"of an application", 3, time, flags=2)
    s.end()
    return ended(s)


counts()
time()
scenes()
names()
blocks()
live()
unknown()
