"""Faulty samples of every codec: clauses 10.4, 10.5, 10.7 to 10.9 and 10.12."""

import struct

from reference import openexr

from ... import media
from ...case import faulty
from ...recipes import frame
from .video_cases import TRACK, exr, of, opened_with


def sample(name, title, clause, issue, setup, data, *, key=True, second=True):
    """The sample that follows a good key sample, or with second=False the first of its group; a good group follows."""

    def make():
        s = opened_with(setup)
        end = setup.groups(s)
        s.begin(end, end + 3)
        if second:
            frame(s, end)
            s.chunk("VPKT", setup.clip.samples[0][1], TRACK, end, True)
        frame(s, end + 1)
        s.chunk("VPKT", data, TRACK, end + 1, key, fault=issue)
        frame(s, end + 2)
        s.end()
        setup.groups(s, end + 3)
        s.finish()
        return s

    faulty(f"sample_{name}", title, clause, make)


def jpeg():
    setup = of("jpeg")
    good = setup.clip.samples[1][1]
    at = good.index(b"\xff\xc0")

    def case(name, title, data, **more):
        sample(f"jpeg_{name}", title, "10.4", 4201, setup, data, **more)

    case("no_key", "A JPEG sample does not have the key flag.", good, key=False)
    case("empty", "A JPEG sample has no byte.", b"")
    case("no_start", "A JPEG sample does not begin with SOI.", b"\0" + good[1:])
    case("no_end", "A JPEG sample does not end with EOI.", good[:-2])
    case("extra", "A byte follows EOI.", good + b"\0")
    case("width", "A JPEG sample is 65 pixels wide.", good[: at + 7] + b"\0\x41" + good[at + 9 :])
    case("height", "A JPEG sample is 31 pixels high.", good[: at + 5] + b"\0\x1f" + good[at + 7 :])
    case("precision", "A JPEG sample has 12 bits.", good[: at + 4] + b"\x0c" + good[at + 5 :])
    case("components", "A JPEG sample has four components.", media.clip("jpeg_cmyk").samples[0][1])
    case(
        "no_frame",
        "A JPEG sample has no frame header before the scan.",
        good[:at] + b"\xff\xe0" + good[at + 2 :],
    )


def nal_units(data):
    at, out = 0, []
    while at < len(data):
        size = struct.unpack_from(">I", data, at)[0]
        out.append(data[at + 4 : at + 4 + size])
        at += 4 + size
    return out


def joined(units):
    return b"".join(struct.pack(">I", len(unit)) + unit for unit in units)


def nal(name, codec, clause, issue, slice_kind):
    setup = of(name)
    (_, key), (_, delta) = setup.clip.samples[:2]

    def case(what, title, data, **more):
        sample(f"{name}_{what}", title, clause, issue, setup, data, **more)

    units = nal_units(delta)
    case("empty", f"An {codec} sample has no byte.", b"", key=False)
    case("cut", f"The last NAL unit of an {codec} sample lacks a byte.", delta[:-1], key=False)
    case("extra", f"A byte follows the last NAL unit of an {codec} sample.", delta + b"\0", key=False)
    case("length_zero", "A NAL unit has the length 0.", bytes(4) + delta, key=False)
    case("length_greatest", "A NAL unit has the length 2^32 - 1.", b"\xff" * 4 + delta[4:], key=False)
    case(
        "forbidden",
        "The forbidden bit of a NAL unit is 1.",
        joined([bytes([units[0][0] | 0x80]) + units[0][1:], *units[1:]]),
        key=False,
    )
    case(
        "annex_b",
        "The NAL units are in Annex B form, with start codes.",
        b"".join(b"\0\0\0\1" + unit for unit in units),
        key=False,
    )
    case("key_without_flag", "A sample with a key picture does not have the key flag.", key, key=False)
    case("flag_without_key", "A sample without a key picture has the key flag.", delta, key=True)
    return setup, key, delta, case, slice_kind


def avc_and_hevc():
    nal("h264", "H.264", "10.5", 4202, 1)
    _, key, delta, case, _ = nal("hevc", "HEVC", "10.7", 4203, 1)
    case("two_pictures", "An HEVC sample has two pictures.", key + key)
    units = nal_units(delta)
    case(
        "no_picture",
        "An HEVC sample has a slice segment that is not the first.",
        joined([units[0][:2] + bytes([units[0][2] & 0x7F]) + units[0][3:]]),
        key=False,
    )
    leading = bytes([units[0][0] & 0x81 | 8 << 1]) + units[0][1:]
    case("leading", "An HEVC sample is a leading picture.", joined([leading]), key=False)
    case(
        "temporal",
        "The temporal identifier of a NAL unit is 0.",
        joined([units[0][:1] + bytes([units[0][1] & 0xF8]) + units[0][2:]]),
        key=False,
    )
    case("one_byte", "A NAL unit has one byte.", joined([units[0], b"\x02"]), key=False)


def vp9():
    setup = of("vp9")
    (_, key), (_, delta) = setup.clip.samples[:2]

    def case(what, title, data, **more):
        sample(f"vp9_{what}", title, "10.8", 4204, setup, data, **more)

    def superframe(*frames, sizes=None):
        mark = bytes([0xC0 | 1 << 3 | len(frames) - 1])
        table = b"".join(struct.pack("<H", size) for size in sizes or map(len, frames))
        return b"".join(frames) + mark + table + mark

    hidden = bytes([delta[0] & ~2]) + delta[1:]
    case("empty", "A VP9 sample has no byte.", b"", key=False)
    case(
        "marker",
        "A VP9 frame does not begin with the frame marker.",
        bytes([delta[0] & 0x3F]) + delta[1:],
        key=False,
    )
    case("sync", "A VP9 key frame does not have the sync code.", key[:1] + b"\0" + key[2:])
    case("hidden", "A VP9 sample shows no frame.", hidden, key=False)
    case("two_shown", "A VP9 superframe shows two frames.", superframe(delta, delta), key=False)
    case(
        "hidden_last",
        "A VP9 superframe shows its first frame, not the last.",
        superframe(delta, hidden),
        key=False,
    )
    case(
        "superframe_size",
        "The index of a VP9 superframe does not account for all bytes.",
        superframe(hidden, delta, sizes=(len(hidden), len(delta) - 1)),
        key=False,
    )
    case("superframe_empty", "A VP9 superframe has a frame of 0 bytes.", superframe(b"", delta), key=False)
    case("key_without_flag", "A VP9 key frame is in a sample without the key flag.", key, key=False)
    case("flag_without_key", "A VP9 sample with the key flag does not begin with a key frame.", delta)


def leb128(value):
    out = b""
    while value > 127:
        out += bytes([value & 127 | 128])
        value >>= 7
    return out + bytes([value])


def obus(data):
    """Header byte and payload of each OBU."""
    at, out = 0, []
    while at < len(data):
        head, at, size, shift = data[at], at + 1, 0, 0
        while True:
            byte = data[at]
            at, size, shift = at + 1, size | (byte & 127) << shift, shift + 7
            if byte < 128:
                break
        out.append((head, data[at : at + size]))
        at += size
    return out


def unit(head, payload):
    return bytes([head]) + leb128(len(payload)) + payload


def av1():
    setup = of("av1")
    (_, key), (_, delta) = setup.clip.samples[:2]

    def case(what, title, data, **more):
        sample(f"av1_{what}", title, "10.9", 4205, setup, data, **more)

    units = obus(key)
    header = next(u for u in units if u[0] >> 3 & 15 == 1)
    rest = b"".join(unit(*u) for u in units if u[0] >> 3 & 15 != 1)
    case("empty", "An AV1 sample has no byte.", b"", key=False)
    case("cut", "The last OBU of an AV1 sample lacks a byte.", delta[:-1], key=False)
    case("extra", "A byte follows the last OBU of an AV1 sample.", delta + b"\0", key=False)
    case("forbidden", "The forbidden bit of an OBU is 1.", bytes([delta[0] | 0x80]) + delta[1:], key=False)
    head, payload = obus(delta)[0]
    case("no_size", "An OBU has no size field.", bytes([head & ~2]) + payload, key=False)
    case("delimiter", "An AV1 sample begins with a temporal delimiter.", b"\x12\0" + delta, key=False)
    case("tile_list", "An AV1 sample has a tile list.", delta + unit(8 << 3 | 2, bytes(4)), key=False)
    case("two_frames", "An AV1 sample shows two frames.", delta + delta, key=False)
    case("no_frame", "An AV1 sample is a sequence header alone.", unit(*header), key=False)
    case("no_sequence_header", "A key sample of AV1 has no sequence header.", rest)
    case("key_without_flag", "A shown key frame is in a sample without the key flag.", key, key=False)
    case("flag_without_key", "An AV1 sample with the key flag has no key frame.", delta)
    case(
        "size_of_9_bytes",
        "The size field of an OBU has nine bytes.",
        bytes([head]) + b"\x80" * 8 + b"\x00" + payload,
        key=False,
    )


def oexr():
    setup = exr(frames=1)
    pixels = openexr.bars(64, 32, 1)
    good = openexr.write(64, 32, pixels, openexr.NONE)

    def case(name, title, data=None, *, key=True, compression=openexr.NONE, **changed):
        data = openexr.write(64, 32, pixels, compression, **changed) if data is None else data
        sample(f"oexr_{name}", title, "10.12", 4206, setup, data, key=key)

    case("no_key", "An OpenEXR sample does not have the key flag.", good, key=False)
    case("magic", "An OpenEXR sample does not begin with the magic number.", b"\0" + good[1:])
    case("version", "The version word has the flag of tiles.", good[:5] + b"\2" + good[6:])
    case("multipart", "The version word has the flag of several parts.", good[:5] + b"\x10" + good[6:])
    case("cut", "The last block lacks a byte.", good[:-1])
    case("extra", "A byte follows the last block.", good + b"\0")
    case("empty", "An OpenEXR sample has no byte.", b"")
    case("window", "The data window is a pixel wider than VCFG.", dataWindow=struct.pack("<4i", 0, 0, 64, 31))
    case(
        "window_offset",
        "The display window does not begin at 0.",
        displayWindow=struct.pack("<4i", 1, 0, 64, 31),
    )
    case("line_order", "The lines are in decreasing order.", lineOrder=b"\1")
    case("no_channels", "The attribute channels is missing.", channels=None)
    case("no_line_order", "The attribute lineOrder is missing.", lineOrder=None)
    channel = openexr.channel
    case(
        "float",
        "The channel G is of 32-bit floats.",
        channels=channel("B") + channel("G", openexr.FLOAT) + channel("R") + b"\0",
    )
    case("alpha", "There is a channel A.", channels=b"".join(map(channel, "ABGR")) + b"\0")
    case(
        "sampling",
        "The channel R is sampled at every second pixel.",
        channels=channel("B") + channel("G") + channel("R", sampling=2) + b"\0",
    )
    case(
        "compression",
        "The compression is PXR24.",
        good.replace(b"compression\0compression\0\1\0\0\0\0", b"compression\0compression\0\1\0\0\0\5"),
    )
    case("tiles", "There is an attribute tiles.", tiles=("tiledesc", bytes(9)))
    case("type", "The type is deepscanline.", type=("string", b"deepscanline"))
    case("chunk_count", "chunkCount is not the number of blocks.", chunkCount=("int", struct.pack("<i", 31)))
    table = len(good) - 32 * (8 + 384) - 256
    first = struct.unpack_from("<Q", good, table)[0]
    case(
        "offset",
        "An entry of the offset table is 8 too large.",
        good[:table] + struct.pack("<Q", first + 8) + good[table + 8 :],
    )
    case(
        "block_line",
        "A block has the y of another line.",
        good[:first] + struct.pack("<i", 1) + good[first + 4 :],
    )
    case(
        "block_size",
        "A block has a byte less than its pixels, without compression.",
        good[: first + 4] + struct.pack("<i", 383) + good[first + 8 :],
    )


jpeg()
avc_and_hevc()
vp9()
av1()
oexr()
