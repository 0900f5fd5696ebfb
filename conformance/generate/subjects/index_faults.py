"""Faults of the index and of the footer: clauses 7.1 and 7.2."""

from ..case import faulty
from ..recipes import block, finished, group, opened


def index_and_footer():
    def changed(which, number, **fields):
        def make():
            s = opened()
            group(s, 0)
            group(s, 2)
            block(s)
            group(s, 4)
            groups, blocks = [dict(g) for g in s.groups], list(s.blocks)
            if which == "groups":
                groups[number] |= fields
            else:
                names = ("offset", "block_size", "digest")
                blocks[number] = tuple(fields.get(n, v) for n, v in zip(names, blocks[number]))
            s.finish(fault_index=1301, groups=groups, blocks=blocks)
            return s

        return make

    for name, title, fields in (
        ("offset", "The offset of a group in INDX is 8 too large.", {"offset": 752}),
        ("size", "The size of a group in INDX is 0.", {"group_size": 0}),
        ("start", "The start of a group in INDX is wrong.", {"start": 3}),
        ("end", "The end of a group in INDX is wrong.", {"end": 1000}),
        ("sequence", "The number of a group in INDX is wrong.", {"sequence": 7}),
        ("frames", "The number of frames of a group in INDX is wrong.", {"frame_count": 200}),
        ("chain", "The chain CRC of a group in INDX is wrong.", {"chain_crc": 1}),
        ("end_size", "The size of GEND in INDX is wrong.", {"end_size": 80}),
        ("block", "A group in INDX belongs to another block.", {"block": 1}),
    ):
        faulty(f"index_group_{name}", title, "7.1", changed("groups", 1, **fields), needs_check=True)
    for name, title, fields in (
        ("offset", "The offset of a block in INDX is wrong.", {"offset": 0}),
        ("size", "The size of a block in INDX is wrong.", {"block_size": 8}),
        ("digest", "The digest of a block in INDX is wrong.", {"digest": 0}),
    ):
        faulty(f"index_block_{name}", title, "7.1", changed("blocks", 1, **fields), needs_check=True)

    def listing(**change):
        def make():
            s = opened()
            group(s, 0)
            block(s)
            group(s, 2)
            s.finish(fault_index=1301, **{name: f(s) for name, f in change.items()})
            return s

        return make

    faulty(
        "index_leaves_group_out",
        "INDX does not list the last group.",
        "7.1 12",
        listing(groups=lambda s: s.groups[:1], blocks=lambda s: s.blocks[:1]),
        needs_check=True,
    )
    faulty(
        "index_lists_group_twice",
        "INDX lists the last group twice.",
        "7.1",
        listing(groups=lambda s: s.groups + s.groups[-1:]),
        needs_check=True,
    )
    faulty(
        "index_leaves_block_out",
        "INDX does not list a repetition of the block.",
        "7.1",
        listing(blocks=lambda s: s.blocks[:1], groups=lambda s: [g | {"block": 0} for g in s.groups]),
        needs_check=True,
    )
    faulty(
        "index_counts",
        "INDX counts more groups than it lists.",
        "7.1",
        listing(group_count=lambda s: 3),
        needs_check=True,
    )
    faulty(
        "index_counts_many",
        "INDX counts 2^32 - 1 groups.",
        "7.1",
        listing(group_count=lambda s: 2**32 - 1),
        needs_check=True,
    )
    faulty(
        "index_short",
        "The INDX payload has 4 bytes.",
        "7.1",
        listing(payload=lambda s: bytes(4)),
        needs_check=True,
    )

    for name, title, fields in (
        ("offset", "The offset of INDX in FOOT is that of the last group.", {"index_offset": 400}),
        ("size", "The size of the stream in FOOT is 8 too small.", {"file_size": 1000}),
        ("crc", "The CRC of INDX in FOOT is wrong.", {"index_crc": 1}),
        ("reserved", "The reserved field of FOOT is not 0.", {"reserved": 1}),
        ("payload", "The FOOT payload has 16 bytes.", {"payload": bytes(16)}),
    ):
        faulty(
            f"footer_{name}",
            title,
            "7.2",
            lambda fields=fields: finished(fault_foot=1302, foot=fields),
            needs_check=True,
        )
    faulty("trailing_zeros", "Eight zero bytes follow FOOT.", "7.2 12", lambda: trailing(bytes(8)))
    faulty("trailing_byte", "One byte follows FOOT.", "7.2", lambda: trailing(b"\n"))
    faulty(
        "trailing_stream",
        "A whole second stream follows FOOT.",
        "7.2 12",
        lambda: trailing(bytes(finished().out)),
    )
    faulty("trailing_chunk", "A good chunk follows FOOT.", "7.2", trailing_chunk)


def trailing(data):
    s = finished()
    s.raw(data, fault=1303)
    return s


def trailing_chunk():
    s = finished()
    s.chunk("note", b"", fault=1303)
    return s


index_and_footer()
