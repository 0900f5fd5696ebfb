"""Samples of video at the bounds of what their clauses allow: headers that encoders here do not write. Clauses 10.4, 10.5, 10.7 to 10.9."""

import struct

from ...case import valid
from ...recipes import frame
from .sample_faults import joined, leb128, nal_units, obus, sample, unit
from .video_cases import TRACK, of, opened_with


def right(name, title, clause, setup, data, *, key=True):
    """The sample follows a good key sample."""

    def make():
        s = opened_with(setup)
        s.begin(0, 2)
        frame(s, 0)
        s.chunk("VPKT", setup.clip.samples[0][1], TRACK, 0, True)
        frame(s, 1)
        s.chunk("VPKT", data, TRACK, 1, key)
        s.end()
        s.finish()
        return s

    valid(f"sample_{name}", title, clause, make)


def jpeg():
    setup = of("jpeg")
    good = setup.clip.samples[1][1]
    at = good.index(b"\xff\xc0")

    def allowed(name, title, data):
        right(f"jpeg_{name}", title, "10.4", setup, data)

    def wrong(name, title, data):
        sample(f"jpeg_{name}", title, "10.4", 4201, setup, data)

    def before(segment):
        return good[:at] + segment + good[at:]

    for marker in (0xC1, 0xC3, 0xC5, 0xC7, 0xC9, 0xCB, 0xCD, 0xCF):
        data = good[: at + 1] + bytes([marker]) + good[at + 2 :]
        allowed(f"header_{marker:02x}", f"The frame header has the marker {marker:02X}.", data)
    for marker in (0xC4, 0xC8, 0xCC, 0xDB, 0xDF, 0xE0, 0xFE):
        segment = bytes([0xFF, marker, 0, 2])
        allowed(f"segment_{marker:02x}", f"A segment {marker:02X} without content.", before(segment))
    for marker in (0x01, 0xBF, 0xD0, 0xD7, 0xD8, 0xD9, 0xDA):
        segment = bytes([0xFF, marker, 0, 2])
        wrong(f"segment_{marker:02x}", f"A marker {marker:02X} before the frame header.", before(segment))
    for size in 0, 1:
        wrong(f"segment_size_{size}", f"A segment has the size {size}.", before(bytes([0xFF, 0xFE, 0, size])))
    allowed("segment_300", "A segment of 300 bytes.", before(b"\xff\xfe\x01\x2c" + bytes(298)))
    wrong("segment_beyond", "A segment goes on after the end.", before(b"\xff\xfe\xff\xff"))
    rest = good[at:]
    to_end = before(b"\xff\xfe" + struct.pack(">H", 2 + len(rest)))
    wrong("segment_to_end", "A segment ends where the sample does.", to_end)
    wrong(
        "segment_almost",
        "Three bytes follow a segment.",
        before(b"\xff\xfe" + struct.pack(">H", len(rest) - 1)),
    )
    wrong("no_marker", "A byte that is no marker after a segment.", before(b"\0"))
    header = good[at : at + 19]
    wrong(
        "header_size_16", "The frame header is a byte too short.", good.replace(header[:4], b"\xff\xc0\0\x10")
    )
    wrong("header_size_7", "The frame header has seven bytes.", good.replace(header[:4], b"\xff\xc0\0\7"))
    two = header[:3] + b"\x0e" + header[4:9] + b"\2" + header[10:16]
    wrong("components_2", "A JPEG sample has two components.", good[:at] + two + good[at + 19 :])
    none = header[:3] + b"\x08" + header[4:9] + b"\0"
    wrong("components_0", "A JPEG sample has no component.", good[:at] + none + good[at + 19 :])
    wrong("width_256", "A JPEG sample is 256 pixels wider.", good[: at + 7] + b"\1\x40" + good[at + 9 :])
    wrong("height_256", "A JPEG sample is 256 pixels higher.", good[: at + 5] + b"\1\x20" + good[at + 7 :])
    wrong("ends_early", "A JPEG sample ends within its frame header.", good[: at + 8] + b"\xff\xd9")
    wrong("markers_alone", "A JPEG sample is SOI and EOI.", b"\xff\xd8\xff\xd9")


def avc():
    setup = of("h264")
    (_, key), (_, delta) = setup.clip.samples[:2]
    for head in (0x05, 0x25, 0x45):
        units = [bytes([head if u[0] & 31 == 5 else u[0]]) + u[1:] for u in nal_units(key)]
        right(
            f"h264_ref_{head:02x}", "An IDR picture with another nal_ref_idc.", "10.5", setup, joined(units)
        )
    for kind in (1, 4, 6, 13, 21, 31):
        units = [*nal_units(delta), bytes([kind, 0x80])]
        title = f"A NAL unit of type {kind} is no IDR picture."
        right(f"h264_type_{kind}", title, "10.5", setup, joined(units), key=False)
    one = [*nal_units(delta), b"\x0c"]
    right("h264_one_byte", "A NAL unit of one byte.", "10.5", setup, joined(one), key=False)
    sample(
        "h264_length_cut", "The sample ends in a length.", "10.5", 4202, setup, delta + b"\0\0\1", key=False
    )


def hevc():
    setup = of("hevc")
    (_, key), (_, delta) = setup.clip.samples[:2]
    slice_ = nal_units(delta)[0]

    def typed(kind, rest=slice_):
        return bytes([rest[0] & 0x81 | kind << 1]) + rest[1:]

    def allowed(name, title, data, key=False):
        right(f"hevc_{name}", title, "10.7", setup, data, key=key)

    def wrong(name, title, data, key=False):
        sample(f"hevc_{name}", title, "10.7", 4203, setup, data, key=key)

    for kind in (0, 5, 10, 15, 24, 31):
        allowed(f"type_{kind}", f"A picture of type {kind} is no IRAP picture.", joined([typed(kind)]))
    for kind in (16, 17, 21, 23):
        allowed(f"type_{kind}", f"A picture of type {kind} is an IRAP picture.", joined([typed(kind)]), True)
    for kind in (6, 7, 9):
        wrong(f"type_{kind}", f"A leading picture of type {kind}.", joined([typed(kind)]))
    for kind in (32, 35, 39, 63):
        data = joined([typed(kind, b"\0\1"), slice_])
        allowed(f"beside_{kind}", f"A NAL unit of type {kind} without a payload.", data)
    allowed("temporal_7", "The greatest temporal identifier.", joined([slice_[:1] + b"\7" + slice_[2:]]))
    allowed("temporal_4", "nuh_temporal_id_plus1 is 4.", joined([slice_[:1] + b"\4" + slice_[2:]]))
    wrong("slice_empty", "A slice segment without a payload.", joined([slice_, slice_[:2]]))
    second = slice_[:2] + bytes([slice_[2] & 0x7F]) + slice_[3:]
    allowed("two_slices", "A picture of two slice segments.", joined([slice_, second]))
    wrong("no_units", "A sample without a slice segment.", joined([b"\x4e\1"]))


def vp9():
    setup = of("vp9")
    (_, key), (_, delta) = setup.clip.samples[:2]

    def allowed(name, title, data, key=False):
        right(f"vp9_{name}", title, "10.8", setup, data, key=key)

    def wrong(name, title, data, key=False):
        sample(f"vp9_{name}", title, "10.8", 4204, setup, data, key=key)

    def superframe(*frames, width=2, mark=None):
        mark = bytes([0xC0 | width - 1 << 3 | len(frames) - 1]) if mark is None else mark
        table = b"".join(len(one).to_bytes(width, "little") for one in frames)
        return b"".join(frames) + mark + table + mark

    hidden = bytes([delta[0] & ~2]) + delta[1:]
    existing = b"\x88"  # frame marker 2, profile 0, show_existing_frame
    allowed("existing", "A sample shows a frame that exists.", existing)
    allowed("existing_profile_3", "The same in profile 3.", b"\xb4")
    wrong("reserved", "The reserved bit of profile 3 is 1.", b"\xb8")
    allowed("hidden_and_existing", "A hidden frame, and one that shows it.", superframe(hidden, existing))
    for width in 1, 3, 4:
        if width > 1 or len(hidden) < 256 > len(delta):
            allowed(
                f"width_{width}",
                f"An index with {width} bytes a size.",
                superframe(hidden, delta, width=width),
            )
    allowed("eight", "A superframe of eight frames.", superframe(*[hidden] * 7, delta))
    allowed("one", "A superframe of one frame.", superframe(delta))
    allowed(
        "key_first",
        "A superframe that begins with a hidden key frame.",
        superframe(bytes([key[0] & ~2]) + key[1:], existing),
        True,
    )
    wrong("index_short", "An index is a byte too large for the frames.", superframe(hidden, delta)[1:])
    wrong("sync_cut", "A key frame ends in its sync code.", key[:3], True)
    for at in 1, 2, 3:
        data = key[:at] + bytes([key[at] ^ 1]) + key[at + 1 :]
        wrong(f"sync_{at}", f"Byte {at} of the sync code differs.", data, True)
    wrong("marker_3", "The frame marker is 3.", bytes([delta[0] | 0xC0]) + delta[1:])
    wrong("marker_0", "The frame marker is 0.", bytes([delta[0] & 0x3F]) + delta[1:])


def av1():
    setup = of("av1")
    (_, key), (_, delta) = setup.clip.samples[:2]
    head, payload = obus(delta)[0]

    def allowed(name, title, data, key=False):
        right(f"av1_{name}", title, "10.9", setup, data, key=key)

    def wrong(name, title, data, key=False):
        sample(f"av1_{name}", title, "10.9", 4205, setup, data, key=key)

    def of_kind(kind, body=b"\0"):
        return unit(kind << 3 | 2, body)

    for kind in (0, 4, 5, 7, 9, 14, 15):
        allowed(f"kind_{kind}", f"An OBU of type {kind} before the frame.", of_kind(kind) + delta)
    for kind in (3, 6):
        allowed(
            f"existing_{kind}", f"An OBU of type {kind} shows a frame that exists.", of_kind(kind, b"\x80")
        )
    for kind in (1, 2, 3):
        allowed(f"frame_type_{kind}", f"A shown frame of type {kind}.", of_kind(6, bytes([kind << 5 | 0x10])))
    hidden = of_kind(6, b"\x20")
    allowed("hidden_and_shown", "A hidden frame and a shown one.", hidden + delta)
    wrong("hidden", "A sample shows no frame.", hidden)
    wrong("frame_empty", "A frame has no byte.", of_kind(6, b""))
    wrong("header_empty", "A frame header has no byte.", of_kind(3, b"") + delta)
    wrong("sequence_empty", "A sequence header has no byte.", of_kind(1, b"") + delta)
    wrong("sequence_reduced", "A sequence header of a still picture.", of_kind(1, b"\x08") + delta)
    sequence = next(unit(*u) for u in obus(key) if u[0] >> 3 & 15 == 1)
    allowed("sequence_again", "A sequence header before a frame that is no key frame.", sequence + delta)
    allowed("key_hidden", "A hidden key frame is no key.", sequence + of_kind(6, b"\0") + delta)
    extension = bytes([head | 4, 0x20]) + leb128(len(payload)) + payload
    allowed("extension", "An OBU with an extension byte.", extension)
    padding = of_kind(15, bytes(130))
    allowed("padding_130", "Padding of 130 bytes after the frame.", delta + padding)
    wrong("tile_list_first", "A tile list before the frame.", of_kind(8, bytes(4)) + delta)
    wrong("delimiter_last", "A temporal delimiter after the frame.", delta + struct.pack("BB", 0x12, 0))


jpeg()
avc()
hevc()
vp9()
av1()
