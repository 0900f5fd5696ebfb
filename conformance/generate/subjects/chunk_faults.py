"""Faults of the file header and of chunks: clauses 3 and 4."""

from .. import meshes, payloads
from ..case import faulty
from ..recipes import between, block, finished, frame, group, in_group, opened
from ..writer import Stream

TETRAHEDRON = meshes.raw(meshes.TETRAHEDRON)


def whole(**header):
    """Two groups of two frames behind a file header."""
    s = opened(**header)
    group(s, 0)
    group(s, 2)
    s.finish()
    return s


def bytes_of(data, issue, offset=0):
    s = Stream()
    s.out[:] = data
    s.issue, s.offset = issue, offset
    return s


def file_header():
    good = bytes(whole().out)
    for name, change in (
        ("high_bit", b"\x09FVV\r\n\x1a\n"),
        ("newlines", b"\x89FVV\n\x1a\n\0"),
        ("other_magic", b"\x89FVW\r\n\x1a\n"),
        ("zeros", bytes(8)),
    ):
        faulty(
            f"signature_{name}",
            f"The signature is {change.hex(' ')}.",
            "3.1",
            lambda change=change: bytes_of(change + good[8:], 1001),
        )
    for size in (0, 1, 8, 20, 23):
        faulty(
            f"file_header_of_{size}_bytes",
            f"The stream ends after {size} bytes.",
            "3.1",
            lambda size=size: bytes_of(good[:size], 1005, size),
        )
    faulty(
        "file_header_crc",
        "The CRC of the file header differs in its last bit.",
        "3.1",
        lambda: whole(fault=1002, damage={23: 0x80}),
    )
    faulty(
        "file_header_bit",
        "A bit of written_minor flipped after the CRC was computed.",
        "3.1",
        lambda: whole(fault=1002, damage={10: 0x04}),
    )
    faulty(
        "file_header_reserved",
        "The reserved field of the file header is 1; its CRC matches.",
        "3.1",
        lambda: whole(fault=1003, reserved=1),
    )
    faulty(
        "file_header_reserved_high",
        "The reserved field of the file header is 2^31.",
        "3.1",
        lambda: whole(fault=1003, reserved=2**31),
    )
    for name, fields in (
        ("next_minor", {"written_minor": 3, "reader_minor": 3}),
        ("far_minor", {"written_minor": 65535, "reader_minor": 65535}),
        ("next_major", {"written_major": 1, "reader_major": 1, "written_minor": 0, "reader_minor": 0}),
        ("older", {"reader_minor": 1}),
        ("oldest", {"reader_minor": 0}),
    ):
        shown = f"{fields.get('reader_major', 0)}.{fields['reader_minor']}"
        faulty(
            f"version_{name}",
            f"The stream requires a reader of version {shown}.",
            "3.2",
            lambda fields=fields: whole(fault=1004, **fields),
        )


def chunk_bytes():
    """Clauses 4.1 to 4.4."""

    def mesh(**chunk):
        return lambda: in_group(lambda s: frame(s, 3, **chunk))

    def scene(**chunk):
        s = Stream()
        s.chunk("SCEN", payloads.scene(), **chunk)
        s.chunk("TRAK", payloads.track(payloads.MESH), track=1)
        group(s, 0)
        s.finish()
        return s

    faulty(
        "header_crc_bit",
        "A bit of the size in a MESH header flipped.",
        "4.1 7.4",
        mesh(damage={17: 0x01}, fault=1101),
    )
    faulty("header_crc_value", "The CRC of a MESH header is 0.", "4.1", mesh(header_crc=0, fault=1101))
    faulty(
        "header_type_byte",
        "The type of a chunk has a control character; its CRC matches.",
        "4.1",
        lambda: in_group(lambda s: s.chunk(b"ME\x1fH", b"", flags=0, fault=1101)),
    )
    faulty(
        "header_type_high_byte",
        "The type of a chunk has a byte above 0x7E; its CRC matches.",
        "4.1",
        lambda: in_group(lambda s: s.chunk(b"ME\x7fH", b"", flags=0, fault=1101)),
    )
    faulty(
        "header_scene",
        "The header of SCEN, the first chunk, has a wrong CRC.",
        "4.1",
        lambda: scene(damage={0: 0x20}, fault=1101),
    )
    faulty(
        "bytes_between_chunks",
        "Eight zero bytes lie between two chunks of a group.",
        "4.1 7.4",
        lambda: in_group(lambda s: (s.raw(bytes(8), fault=1101), frame(s, 3))),
    )
    faulty(
        "bytes_unaligned",
        "Three bytes lie between two groups: all that follows is shifted.",
        "4.1 7.4",
        lambda: between(lambda s: s.raw(b"fvv", fault=1101)),
    )

    for name, flags in (("reserved", 0x0B), ("top_bit", 0x83), ("last", 0x07), ("not_critical", 0x02)):
        faulty(
            f"flags_{name}",
            f"A MESH chunk has the flags 0x{flags:02x}.",
            "4.2",
            mesh(flags=flags, fault=1102),
        )
    faulty("flags_scene_key", "SCEN has the key flag.", "4.2", lambda: scene(flags=3, fault=1102))
    faulty(
        "flags_end_not_last",
        "GEND does not have the last flag.",
        "4.2",
        lambda: between(lambda s: group(s, 2, fault=1102, flags=1)),
    )
    faulty(
        "flags_group_not_key",
        "GRUP does not have the key flag.",
        "4.2",
        lambda: between(lambda s: (s.begin(2, 3, fault=1102, flags=1), frame(s, 2), s.end())),
    )
    faulty(
        "flags_unknown_last",
        "An unknown chunk that is not critical has the last flag and a reserved one.",
        "4.2",
        lambda: in_group(lambda s: s.chunk("zzzz", b"", time=2, flags=0x0C, fault=1102)),
    )
    faulty(
        "flags_index_critical",
        "INDX has the critical flag.",
        "4.2",
        lambda: finished(fault_index=1102, index={"flags": 1}),
    )

    faulty("payload_crc_bit", "A bit of a mesh flipped.", "4.3 7.4", mesh(damage={32 + 40: 1}, fault=1103))
    faulty(
        "payload_crc_zero",
        "The CRC of a payload is 0, as if it were not computed.",
        "4.3 12",
        mesh(payload_crc=0, fault=1103),
    )
    faulty(
        "payload_crc_burst",
        "16 bytes of a mesh were overwritten with 0xFF.",
        "4.3 7.4",
        mesh(damage={32 + 16 + i: 0xA5 for i in range(16)}, fault=1103),
    )
    faulty(
        "payload_crc_empty",
        "The CRC of an empty payload is not 0.",
        "4.3",
        lambda: in_group(lambda s: s.chunk("note", b"", time=2, payload_crc=1, fault=1103)),
    )
    faulty(
        "payload_crc_scene",
        "A bit of the lattice's step flipped; no repetition of the block follows.",
        "4.3 7.4",
        lambda: scene(damage={32 + 41: 1}, fault=1103),
    )
    faulty(
        "payload_crc_track",
        "A bit in the name of a track flipped.",
        "4.3 7.4",
        lambda: named_track(damage={32 + 25: 2}, fault=1103),
    )
    faulty(
        "payload_crc_end",
        "A bit in the table of GEND flipped.",
        "4.3 7.4",
        lambda: between(lambda s: group(s, 2, fault=1103, damage={32 + 33: 1})),
    )
    faulty(
        "payload_crc_group",
        "A bit in the payload of GRUP flipped.",
        "4.3 7.4",
        lambda: between(lambda s: (s.begin(2, 3, fault=1103, damage={32: 1}), frame(s, 2), s.end())),
    )

    note = b"odd" + bytes(10)
    for name, padding in (("first", b"\x01\0\0"), ("last", b"\0\0\x80")):
        faulty(
            f"padding_{name}",
            f"The {name} byte of padding is not 0.",
            "4.3",
            lambda padding=padding: in_group(
                lambda s: s.chunk("note", note, time=2, padding=padding, fault=1104)
            ),
        )
    faulty(
        "padding_of_group_end", "A byte in the padding of GEND is 0xFF.", "4.3", lambda: between(padded_end)
    )

    for name, counter in (("repeated", 1), ("skipped", 3), ("zero", 0)):
        faulty(
            f"counter_{name}",
            f"The counter of the second mesh is {counter} instead of 2.",
            "4.4",
            mesh(counter=counter, fault=1105),
        )
    faulty(
        "counter_lost_chunk",
        "The second of three meshes of a group was left out.",
        "4.4 7.4",
        lambda: in_group(lambda s: (frame(s, 3, lost=True), frame(s, 4, fault=1105))),
    )
    faulty(
        "counter_duplicate_chunk",
        "The second mesh of a group was sent twice.",
        "4.4 7.4",
        lambda: in_group(lambda s: (frame(s, 3), s.raw(s.last, fault=1105), frame(s, 4))),
    )
    faulty("counter_of_scene", "The counter of SCEN is 1.", "4.4", lambda: scene(counter=1, fault=1105))
    faulty(
        "counter_of_group",
        "The counter of GRUP is that of the chunk before plus one.",
        "4.4",
        lambda: between(lambda s: (s.begin(2, 3, fault=1105, counter=s.counter + 1), frame(s, 2), s.end())),
    )
    faulty(
        "counter_of_footer",
        "The counter of FOOT is 0.",
        "4.4",
        lambda: finished(fault_foot=1105, foot={"counter": 0}),
    )
    faulty("counter_swapped_chunks", "Two meshes of a group changed places.", "4.4", swapped)

    faulty(
        "unknown_critical_in_block",
        "The configuration block has a critical chunk of an unknown type.",
        "4.5",
        lambda: between(lambda s: None, more=lambda s: s.chunk("NEWT", b"x", flags=1, fault=1106)),
    )
    faulty(
        "unknown_critical_in_group",
        "A group has a critical chunk of a private type.",
        "4.5",
        lambda: in_group(lambda s: s.chunk("pRIV", b"", time=2, flags=1, fault=1106)),
    )
    faulty(
        "unknown_critical_case",
        "The type 'mesh' is not MESH: it is a private type, and critical.",
        "4.5",
        lambda: in_group(lambda s: s.chunk("mesh", TETRAHEDRON, 1, 3, flags=3, fault=1106)),
    )

    faulty("size_of_2_63", "The payload size of a chunk is 2^63.", "4.1", mesh(size=2**63, fault=1108))
    faulty(
        "size_of_2_62",
        "The payload size of a chunk is 2^62: beyond every limit.",
        "13",
        mesh(size=2**62, fault=7001),
        refused=True,
    )
    faulty(
        "size_of_2_64", "The payload size of a chunk is 2^64 - 1.", "4.1", mesh(size=2**64 - 1, fault=1108)
    )

    faulty("fields_scene_time", "SCEN has a time.", "4.6", lambda: scene(time=1, fault=1109))
    faulty("fields_scene_track", "SCEN has a track.", "4.6", lambda: scene(track=1, fault=1109))
    faulty(
        "fields_meta_track",
        "META has a track.",
        "4.6 5.3",
        lambda: between(lambda s: None, more=lambda s: s.chunk("META", b"{}", track=1, fault=1109)),
    )
    faulty("fields_mesh_without_track", "A MESH chunk has the track 0.", "4.6", mesh(track=0, fault=1109))
    faulty(
        "fields_group_track",
        "GRUP has a track.",
        "4.6",
        lambda: between(lambda s: (s.begin(2, 3, fault=1109, track=1), frame(s, 2), s.end())),
    )
    faulty(
        "fields_index_time", "INDX has a time.", "4.6", lambda: finished(fault_index=1109, index={"time": 5})
    )


def named_track(**chunk):
    s = Stream()
    s.chunk("SCEN", payloads.scene())
    s.chunk("TRAK", payloads.track(payloads.MESH, "mesh"), track=1, **chunk)
    group(s, 0)
    block(s)
    group(s, 2)
    s.finish()
    return s


def padded_end(s):
    """The table of this group has 3 bytes, so its GEND has 5 of padding."""
    s.begin(2, 3)
    frame(s, 2)
    s.end(fault=1104, padding=b"\0\0\xff\0\0")


def swapped():
    s = opened()
    s.begin(0, 4)
    frame(s, 0)
    frame(s, 1)
    first = s.last
    frame(s, 2)
    second = s.last
    del s.out[len(s.out) - len(first) - len(second) :]
    s.raw(second, fault=1105)
    s.raw(first)
    frame(s, 3)
    s.end()
    group(s, 4)
    s.finish()
    return s


file_header()
chunk_bytes()
