"""Faults of order, of cut streams and of groups: clauses 3.3, 6 and 7.3."""

from reference.container import uleb128

from .. import meshes, payloads
from ..case import faulty
from ..packing import pack
from ..recipes import between, block, finished, frame, group, in_group, opened
from ..writer import Group, Stream

TETRAHEDRON = meshes.raw(meshes.TETRAHEDRON)


def order():
    """Clause 3.3 and where chunks may be."""
    faulty(
        "place_track_after_camera",
        "A TRAK follows a CAMR.",
        "3.3 5",
        lambda: between(
            lambda s: None,
            more=lambda s: (
                s.chunk("CAMR", payloads.camera()),
                s.chunk("TRAK", payloads.track(1), track=2, fault=1201),
            ),
        ),
    )
    faulty(
        "place_mesh_in_block",
        "A MESH chunk is in the configuration block.",
        "3.3",
        lambda: between(lambda s: None, more=lambda s: frame(s, 0, fault=1201)),
    )
    faulty(
        "place_camera_between_groups",
        "A CAMR follows GEND, without SCEN before it.",
        "3.3",
        lambda: between(
            lambda s: s.chunk("CAMR", payloads.camera(), counter=s.counter + 1, silent=True, fault=1201)
        ),
    )
    faulty(
        "place_end_without_group",
        "A GEND follows a GEND.",
        "3.3",
        lambda: between(lambda s: s.raw(end_again(s), fault=1201)),
    )
    faulty("place_first_is_mesh", "A MESH chunk is the first chunk of the stream.", "3.3", first_is_mesh)
    faulty("place_track_first", "A TRAK is the first chunk of the stream.", "3.3", first_is_track)
    faulty("place_footer_without_index", "FOOT follows a group, without INDX.", "3.3", footer_alone)
    faulty(
        "place_index_in_block",
        "INDX follows SCEN and TRAK of a block, and a group follows INDX.",
        "3.3",
        index_early,
    )
    faulty("configuration_missing", "A stream begins with GRUP.", "3.3 12", group_first)
    faulty("configuration_missing_index", "A stream of INDX and FOOT alone.", "3.3 12", index_first)
    faulty(
        "group_without_end",
        "A group is followed by the next one, without GEND.",
        "6.3 12",
        lambda: between(unended),
    )
    faulty(
        "group_without_end_block",
        "A configuration block begins inside a group.",
        "6.3 12",
        lambda: between(unended_block),
    )
    faulty(
        "group_with_camera",
        "A CAMR is inside a group.",
        "6.2 12",
        lambda: in_group(lambda s: s.chunk("CAMR", payloads.camera(), fault=1203)),
    )
    faulty("group_without_end_index", "INDX follows an unfinished group.", "6.3", index_in_group)
    faulty(
        "group_cut_between_chunks",
        "A stream ends between two chunks of a group.",
        "6.3 7.3",
        lambda: cut_group(0),
    )


def end_again(s):
    """The bytes of the last GEND, whose counter is that after the last chunk."""
    again = Stream()
    again.counter = s.counter
    again.group = Group(0, 9, 2, 3)
    before = len(again.out)
    again.end(listed=False)
    return bytes(again.out[before:])


def first_is_mesh():
    s = Stream()
    s.chunk("MESH", TETRAHEDRON, 1, 0, True, counter=0, fault=1201)
    s.counter = 255
    block(s)
    group(s, 0)
    s.finish()
    return s


def first_is_track():
    s = Stream()
    s.chunk("TRAK", payloads.track(1), 1, counter=0, fault=1201)
    block(s)
    group(s, 0)
    s.finish()
    return s


def footer_alone():
    s = opened()
    group(s, 0)
    body = pack("FOOT payload", index_offset=len(s.out), file_size=len(s.out) + 56)
    s.chunk("FOOT", body, fault=1201)
    return s


def index_early():
    s = opened()
    s.chunk("INDX", s.index_payload())
    s.begin(0, 1, fault=1201)
    frame(s, 0)
    s.end()
    return s


def group_first():
    s = Stream()
    s.begin(0, 2, fault=1202)
    frame(s, 0)
    s.end()
    block(s)
    group(s, 2)
    s.finish()
    return s


def index_first():
    s = Stream()
    s.finish(fault_index=1202)
    return s


def unended(s):
    s.begin(2, 4)
    frame(s, 2)
    s.sequence = s.group.sequence + 1
    s.group = None
    s.begin(4, 6, fault=1203)
    frame(s, 4)
    s.end()


def unended_block(s):
    s.begin(2, 4)
    frame(s, 2)
    s.group = None
    s.chunk("SCEN", payloads.scene(), fault=1203)
    s.chunk("TRAK", payloads.track(payloads.MESH, "mesh"), track=1)


def index_in_group():
    s = opened()
    s.begin(0, 2)
    frame(s, 0)
    s.group = None
    s.finish(fault_index=1203)
    return s


def cut_group(extra):
    s = opened()
    group(s, 0)
    s.begin(2, 4)
    frame(s, 2)
    at = len(s.out)
    frame(s, 3)
    s.cut(at + extra, 1107 if extra else 1203, at)
    return s


def cuts():
    """Clause 7.3."""
    for extra in (1, 16, 31, 32, 40, 100):
        inside = "header" if extra < 32 else "chunk"
        faulty(
            f"cut_{extra}_bytes_into_chunk",
            f"A stream ends {extra} bytes after the beginning of a {inside}.",
            "7.3",
            lambda extra=extra: cut_group(extra),
        )
    faulty("cut_in_padding", "A stream ends one byte before the end of the last padding.", "7.3", cut_padding)
    faulty("cut_in_configuration", "A stream ends inside SCEN.", "7.3", cut_scene)
    faulty("cut_in_footer", "A stream ends in the middle of FOOT.", "7.3", cut_footer)


def cut_padding():
    s = opened()
    group(s, 0)
    s.begin(2, 3)
    at = s.chunk("note", b"five!", time=2)
    s.cut(len(s.out) - 1, 1107, at)
    return s


def cut_scene():
    s = Stream()
    s.chunk("SCEN", payloads.scene())
    s.cut(24 + 50, 1107, 24)
    return s


def cut_footer():
    s = finished()
    s.cut(len(s.out) - 20, 1107, len(s.out) - 56)
    return s


def groups():
    """Clauses 6.1 and 6.2."""

    def begun(start=2, end=4, **fields):
        def middle(s):
            s.begin(start, end, **fields)
            frame(s, 2)
            s.end()

        return lambda: between(middle)

    right = pack("GRUP payload", sequence=1, configuration_crc=0, start=2, end=4)
    faulty(
        "group_payload_short", "The GRUP payload has 16 bytes.", "6.1", begun(payload=right[:16], fault=1204)
    )
    faulty(
        "group_payload_long",
        "The GRUP payload has 32 bytes.",
        "6.1",
        begun(payload=right + bytes(8), fault=1204),
    )
    faulty(
        "sequence_first",
        "The first group of a stream with a footer has the number 5.",
        "6.1",
        sequence_first,
        needs_check=True,
    )
    faulty(
        "sequence_repeated",
        "The second group repeats the number of the first.",
        "6.1",
        begun(sequence=0, fault=1205),
    )
    faulty(
        "sequence_gap",
        "The second group has the number 2: a group is missing.",
        "6.1 7.4",
        begun(sequence=2, fault=1205),
    )
    faulty("group_duplicated", "A whole group is there twice.", "6.1 7.4", duplicated)
    faulty("group_empty_time", "A group starts and ends at the same tick.", "6.1", begun(end=2, fault=1206))
    faulty("group_negative_time", "A group ends before it starts.", "6.1", begun(end=-5, fault=1206))
    faulty(
        "group_start_is_not_time",
        "The start in GRUP is one more than the time in its header.",
        "6.1",
        begun(start=3, time=2, fault=1206),
    )
    faulty(
        "group_overlaps",
        "A group starts one tick before the end of the group before.",
        "6.1",
        begun(start=1, fault=1206),
    )
    faulty(
        "digest_wrong",
        "The digest in GRUP is that of no block.",
        "6.1 7.4",
        begun(configuration_crc=0x12345678, fault=1207),
    )
    faulty(
        "digest_of_earlier_block",
        "A group names the digest of the block before the last one.",
        "6.1 7.4",
        lambda: between(earlier_digest),
    )

    def chunk(**fields):
        return lambda: in_group(lambda s: frame(s, **fields))

    faulty(
        "time_before_group",
        "A mesh has the time before the start of its group.",
        "6.2",
        lambda: in_group(lambda s: frame(s, 1, fault=1208), frames=0),
    )
    faulty("time_at_end", "A mesh has the time of the end of its group.", "6.2", chunk(time=6, fault=1208))
    faulty(
        "time_of_unknown_chunk",
        "An unknown chunk in a group has the time 0, before its group.",
        "4.5 6.2",
        lambda: in_group(lambda s: s.chunk("note", b"", time=0, fault=1208)),
    )
    faulty(
        "time_decreases",
        "A chunk has an earlier time than the one before it.",
        "6.2",
        lambda: in_group(lambda s: (frame(s, 4), frame(s, 3, fault=1209))),
    )
    faulty("time_twice", "A track has two meshes at one time.", "6.2 12", chunk(time=2, fault=1209))
    faulty(
        "time_decreases_unknown",
        "An unknown chunk has an earlier time than the mesh before it.",
        "4.5 6.2",
        lambda: in_group(lambda s: (frame(s, 4), s.chunk("note", b"", time=2, fault=1209))),
    )
    faulty(
        "track_undeclared",
        "A mesh belongs to track 2, which no TRAK declares.",
        "6.2",
        chunk(time=2, track=2, fault=1210),
    )
    faulty(
        "track_of_earlier_block",
        "A mesh belongs to a track of the configuration before this one.",
        "5 6.2",
        earlier_track,
    )
    kinds = [(1, payloads.track(payloads.MESH)), (2, payloads.track(payloads.COLOURS))]
    faulty(
        "kind_mesh_on_colours",
        "A MESH chunk belongs to a colour track.",
        "6.2",
        lambda: in_group(lambda s: frame(s, 2, track=2, fault=1211), *kinds),
    )
    faulty(
        "kind_video_on_mesh",
        "A VPKT chunk belongs to a mesh track.",
        "6.2",
        lambda: in_group(lambda s: s.chunk("VPKT", b"x", 1, 2, True, fault=1211)),
    )
    faulty(
        "kind_unknown_track",
        "A MESH chunk belongs to a track of an unknown kind.",
        "5.2 6.2",
        lambda: in_group(lambda s: frame(s, 2, track=2, fault=1211), kinds[0], (2, payloads.track(200))),
    )
    faulty(
        "first_is_not_key",
        "The first mesh of a track in a group does not have the key flag.",
        "6.2 12",
        lambda: in_group(lambda s: s.chunk("MESH", TETRAHEDRON, 1, 2, fault=1212), frames=0),
    )
    seen = [(1, payloads.track(payloads.MESH)), (2, payloads.track(payloads.VISIBILITY))]
    faulty(
        "first_is_not_key_visibility",
        "The first VISI of a track in a group does not have the key flag.",
        "6.2",
        lambda: in_group(lambda s: s.chunk("VISI", pack("VISI payload"), 2, 2, fault=1212), *seen),
    )


def sequence_first():
    s = opened()
    s.sequence = 5
    s.begin(0, 2, fault=1205)
    frame(s, 0)
    s.end()
    s.finish()
    return s


def duplicated():
    s = opened()
    group(s, 0)
    at = len(s.out)
    group(s, 2)
    s.raw(bytes(s.out[at:]), fault=1206)
    group(s, 4)
    s.finish()
    return s


def earlier_digest(s):
    before = s.digest()
    s.chunk("SCEN", payloads.scene(up_axis=1))
    s.chunk("TRAK", payloads.track(payloads.MESH, "mesh"), track=1)
    s.begin(2, 3, configuration_crc=before, fault=1207)
    frame(s, 2)
    s.end()


def earlier_track():
    s = opened((1, payloads.track(1)), (2, payloads.track(1)))
    group(s, 0)
    s.chunk("SCEN", payloads.scene())
    s.chunk("TRAK", payloads.track(1), track=1)
    s.begin(2, 3)
    frame(s, 2)
    frame(s, 2, track=2, fault=1210)
    s.end()
    s.finish()
    return s


def ends():
    """Clauses 6.3, 7.1 and 7.2."""

    def ended(**fields):
        def middle(s):
            s.begin(2, 5)
            frame(s, 2)
            s.chunk("note", b"12345", time=2)
            frame(s, 3)
            s.end(**fields)

        return lambda: between(middle)

    for name, title, fields in (
        ("sequence", "GEND names another sequence number than GRUP.", {"sequence": 2}),
        ("count", "GEND counts one chunk more than the group has.", {"chunk_count": 5}),
        ("count_zero", "GEND counts no chunk.", {"chunk_count": 0}),
        ("chain", "The chain CRC in GEND is wrong.", {"chain_crc": 0}),
        ("frames", "GEND counts a frame less than the group has.", {"frame_count": 1}),
        (
            "frames_more",
            "GEND counts three frames; the group has two and a chunk without a track.",
            {"frame_count": 3},
        ),
        ("time", "The time of GEND is not the end of the group.", {"time": 4}),
    ):
        faulty(f"group_end_{name}", title, "6.3", ended(fault=1213, **fields))
    faulty(
        "group_end_lost_256",
        "256 chunks of a group are missing: the counter does not show it.",
        "4.4 6.3",
        lambda: between(lost_256),
    )
    faulty(
        "group_end_foreign_chunk",
        "A mesh of an earlier stream took the place of the right one, with a good CRC.",
        "6.3",
        lambda: between(foreign),
    )

    rows = {
        "order": lambda r: r[8:16] + r[:8],
        "twice": lambda r: r + r[:8],
        "reserved": lambda r: r[:7] + b"\1" + r[8:],
        "flags": lambda r: r[:6] + b"\1" + r[7:],
        "missing": lambda r: r[:8],
    }
    titles = {
        "order": "The rows of GEND are not in order of first appearance.",
        "twice": "A row of GEND is there twice.",
        "reserved": "The reserved byte of a row of GEND is 1.",
        "flags": "A row of GEND has other flags than the chunks.",
        "missing": "A row of GEND is missing.",
    }
    for name, change in rows.items():
        faulty(f"group_table_rows_{name}", titles[name], "6.3", ended(fault=1214, rows=change))
    tables = {
        "overlong": (
            "A number in the table of GEND is not in its shortest form.",
            lambda t: b"\x80\0" + t[1:],
        ),
        "size": (
            "A payload size in the table of GEND is one too large.",
            lambda t: t[:1] + uleb128(113) + t[2:],
        ),
        "time": ("A time in the table of GEND is wrong.", lambda t: t[:2] + b"\2" + t[3:]),
        "row": ("A number of a row in the table of GEND is wrong.", lambda t: b"\1" + t[1:]),
        "short": ("The table of GEND lacks its last entry.", lambda t: t[:-3]),
        "long": ("The table of GEND has an entry too many.", lambda t: t + t[-3:]),
    }
    for name, (title, change) in tables.items():
        faulty(f"group_table_{name}", title, "6.3", ended(fault=1214, table=change))
    faulty("group_table_extra", "A byte follows the table of GEND.", "6.3", ended(fault=1214, extra=b"\0"))
    faulty("group_end_truncated", "The GEND payload has 20 bytes.", "6.3", ended_short)


def ended_short():
    def middle(s):
        s.begin(2, 3)
        frame(s, 2)
        s.group = None
        s.chunk("GEND", bytes(20), time=3, fault=1213)

    return between(middle)


def lost_256(s):
    s.begin(2, 4)
    frame(s, 2)
    for _ in range(256):
        s.chunk("note", b"", time=2, lost=True)
    frame(s, 3)
    s.end(fault=1213)


def foreign(s):
    """The chunk has the counter, the size and the time of the right one, and other positions."""
    s.begin(2, 4)
    frame(s, 2)
    frame(s, 3, lost=True)
    s.chunk("MESH", meshes.raw(meshes.TETRAHEDRON.moved(5)), 1, 3, True, silent=True)
    s.end(fault=1213)


order()
cuts()
groups()
ends()
