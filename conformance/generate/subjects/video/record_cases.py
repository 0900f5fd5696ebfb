"""Configuration records of video, field by field: what they allow that encoders here do not write, and what they forbid. No case has
samples. Clauses 10.5 and 10.7 to 10.9."""

import struct

from ... import media, payloads
from ...case import faulty, valid
from ...recipes import frame, opened
from .video_cases import TRACK, of

VCFG_FAULT = 4004
CLAUSES = {"avc1": "10.5", "hvc1": "10.7", "vp09": "10.8", "av01": "10.9"}


def stream(codec, record, string, depth, issue=None):
    """A block with that record and a mesh, and after a fault a good block with a mesh."""
    s = opened((1, payloads.track(payloads.MESH, "mesh")), (TRACK, payloads.track(payloads.VIDEO, "video")))
    for i in range(2):
        s.chunk("CAMR", payloads.camera(i, width=32, height=32))
    config = payloads.video(codec, record, string, width=64, height=32, bit_depth=depth)
    s.chunk("VCFG", config, track=TRACK, fault=issue)
    s.chunk("TILE", of("jpeg").layout(), track=TRACK)
    meshes_of_one_group(s, 0)
    if issue:
        of("jpeg").block(s)
        meshes_of_one_group(s, 1)
    s.finish()
    return s


def meshes_of_one_group(s, time):
    s.begin(time, time + 1)
    frame(s, time)
    s.end()


def right(codec, name, title, record, string, depth):
    valid(
        f"record_{codec}_{name}",
        title,
        CLAUSES[codec],
        lambda: stream(codec, record, string, depth),
    )


def wrong(codec, name, title, record, string, depth):
    faulty(
        f"record_{codec}_{name}",
        title,
        CLAUSES[codec],
        lambda: stream(codec, record, string, depth, VCFG_FAULT),
    )


SPS, PPS = bytes.fromhex("6742c00ad904"), bytes.fromhex("68cb8112")
SPS_EXTENSION = bytes.fromhex("6dd0")


def units(*some):
    return b"".join(struct.pack(">H", len(unit)) + unit for unit in some)


def avc_record(
    profile=66, constraints=0xC0, level=10, lengths=0xFF, sps=(SPS,), pps=(PPS,), mark=0xE0, tail=b""
):
    head = bytes([1, profile, constraints, level, lengths, mark | len(sps)])
    return head + units(*sps) + bytes([len(pps)]) + units(*pps) + tail


def depths(luma, chroma, extensions=(), chroma_format=1):
    """The fields that follow the parameter sets in profiles of more than 8 bits."""
    fixed = bytes([0xFC | chroma_format, 0xF8 | luma, 0xF8 | chroma, len(extensions)])
    return fixed + units(*extensions)


def avc():
    def string(profile, constraints=0xC0, level=10):
        return f"avc1.{profile:02x}{constraints:02x}{level:02x}"

    def good(name, title, record, profile, depth=8, text=None):
        right("avc1", name, title, record, text or string(profile), depth)

    def bad(name, title, record, profile, depth=8, text=None):
        wrong("avc1", name, title, record, text or string(profile), depth)

    for profile in 66, 77, 88, 100:
        good(
            f"without_depths_{profile}",
            f"Profile {profile} without bit depths has 8.",
            avc_record(profile),
            profile,
        )
        bad(
            f"without_depths_{profile}",
            f"Profile {profile} without bit depths, and VCFG has 10 bits.",
            avc_record(profile),
            profile,
            10,
        )
    good(
        "without_depths_110",
        "Profile 110 without bit depths: that of VCFG may be 10.",
        avc_record(110),
        110,
        10,
    )
    for profile in 66, 77, 88:
        record = avc_record(profile, tail=depths(0, 0))
        bad(f"extra_{profile}", f"Profile {profile} has no bit depths in the record.", record, profile)
    for profile, depth in (100, 8), (110, 9), (110, 10), (122, 14), (244, 12):
        record = avc_record(profile, tail=depths(depth - 8, depth - 8))
        good(f"depth_{profile}_{depth}", f"Profile {profile} with {depth} bits.", record, profile, depth)
    bad("luma", "Luma has 9 bits, chroma 8.", avc_record(100, tail=depths(1, 0)), 100)
    bad("chroma", "Chroma has 9 bits, luma 8.", avc_record(100, tail=depths(0, 1)), 100)
    bad("both", "Luma and chroma have 9 bits, VCFG 8.", avc_record(100, tail=depths(1, 1)), 100)
    for count in 1, 2:
        record = avc_record(100, tail=depths(0, 0, [SPS_EXTENSION] * count))
        good(f"extension_{count}", f"{count} extensions of sequence parameter sets.", record, 100)
    bad(
        "extension_kind",
        "An extension is a NAL unit of type 7.",
        avc_record(100, tail=depths(0, 0, [SPS])),
        100,
    )
    bad(
        "extension_cut",
        "Two extensions are counted, and one is there.",
        avc_record(100, tail=depths(0, 0)[:-1] + b"\2" + units(SPS_EXTENSION)),
        100,
    )
    for name, record in (
        ("lengths", avc_record(lengths=0x7F)),
        ("sps", avc_record(mark=0x60)),
        ("luma", avc_record(100, tail=depths(0, 0)[:1] + b"\x78\xf8\0")),
        ("chroma", avc_record(100, tail=depths(0, 0)[:2] + b"\xf0\0")),
        ("format", avc_record(100, tail=b"\xf9" + depths(0, 0)[1:])),
    ):
        bad(f"reserved_{name}", "A reserved bit is 0.", record, record[1])
    good("chroma_format_3", "The chroma format 3.", avc_record(244, tail=depths(0, 0, chroma_format=3)), 244)
    for least, name in (4, "sps"), (2, "pps"), (2, "extension"):
        unit = {"sps": SPS, "pps": PPS, "extension": SPS_EXTENSION}[name]
        for size in least, least - 1:
            some = {"tail": depths(0, 0, [unit[:size]])} if name == "extension" else {name: [unit[:size]]}
            add = good if size == least else bad
            add(
                f"{name}_size_{size}",
                f"A parameter set ({name}) of {size} bytes.",
                avc_record(100, **some),
                100,
            )
    good("upper_case", "Digits of the codec string in upper case.", avc_record(66), 66, text="avc1.42C00A")
    good(
        "several",
        "Two sequence and three picture parameter sets.",
        avc_record(sps=[SPS] * 2, pps=[PPS] * 3),
        66,
    )
    good("pps_255", "255 picture parameter sets.", avc_record(pps=[PPS[:2]] * 255), 66)
    good("sps_31", "31 sequence parameter sets.", avc_record(sps=[SPS] * 31), 66)
    good("sps_long", "A sequence parameter set of 300 bytes.", avc_record(sps=[SPS + bytes(294)]), 66)
    bad("no_pps", "No picture parameter set.", avc_record(pps=()), 66)
    bad("sps_kind", "A sequence parameter set is a NAL unit of type 8.", avc_record(sps=[PPS]), 66)
    bad("pps_kind", "A picture parameter set is a NAL unit of type 7.", avc_record(pps=[SPS]), 66)
    bad("sps_empty", "A sequence parameter set has no byte.", avc_record(sps=[b""]), 66)
    bad("lengths_2", "lengthSizeMinusOne is 2.", avc_record(lengths=0xFE), 66)
    for name, text in (
        ("level", string(66, level=11)),
        ("constraints", string(66, 0x80)),
        ("long", string(66) + "0"),
    ):
        bad(f"string_{name}", "The codec string differs from the record.", avc_record(), 66, text=text)


VPS_UNIT, SPS_UNIT, PPS_UNIT = b"\x40\x01\x0c", b"\x42\x01\x01", b"\x44\x01\xc1"
HEVC_KINDS = {32: VPS_UNIT, 33: SPS_UNIT, 34: PPS_UNIT}


def hevc_record(general=1, compatibility=0x60000000, constraints=b"\x90" + bytes(5), level=30, **more):
    values = {
        "depth": (0, 0),
        "lengths": 0x0F,
        "arrays": [(0x80 | k, [u]) for k, u in HEVC_KINDS.items()],
    }
    values |= more
    head = bytes([1, general]) + compatibility.to_bytes(4, "big") + constraints + bytes([level])
    head += (
        b"\xf0\0\xfc\xfd" + bytes(0xF8 | d for d in values["depth"]) + b"\0\0" + bytes([values["lengths"]])
    )
    out = head + bytes([more.get("count", len(values["arrays"]))])
    for kind, some in values["arrays"]:
        out += bytes([kind]) + struct.pack(">H", len(some)) + units(*some)
    return out


def hevc():
    usual = "hvc1.1.6.L30.90"

    def arrays(**changed):
        """changed: the kind byte or the units of an array, by a name such as sps_kind."""
        out = []
        for name, (kind, unit) in zip(("vps", "sps", "pps"), HEVC_KINDS.items()):
            out.append((changed.get(f"{name}_kind", 0x80 | kind), changed.get(f"{name}_units", [unit])))
        return out

    good = lambda name, title, record, text=usual, depth=8: right("hvc1", name, title, record, text, depth)  # noqa: E731
    bad = lambda name, title, record, text=usual, depth=8: wrong("hvc1", name, title, record, text, depth)  # noqa: E731
    good("high_tier", "The high tier.", hevc_record(general=0x21), "hvc1.1.6.H30.90")
    good(
        "profile_31",
        "Profile 31, and all compatibility flags.",
        hevc_record(31, 2**32 - 1),
        "hvc1.31.ffffffff.L30.90",
    )
    good(
        "compatibility_order",
        "Compatibility flags in reverse order.",
        hevc_record(2, 0x20000001),
        "hvc1.2.80000004.L30.90",
    )
    good("level_255", "Level 255.", hevc_record(level=255), "hvc1.1.6.L255.90")
    good("no_constraints", "All constraint bytes are 0.", hevc_record(constraints=bytes(6)), "hvc1.1.6.L30")
    good(
        "six_constraints",
        "Six constraint bytes, of which one in the middle is 0.",
        hevc_record(constraints=b"\xb0\x01\x00\x0f\x00\xff"),
        "hvc1.1.6.L30.b0.01.00.0f.00.ff",
    )
    good(
        "upper_case", "Digits in upper case.", hevc_record(constraints=b"\xbf" + bytes(5)), "hvc1.1.6.L30.BF"
    )
    for depth in 9, 12, 15:
        record = hevc_record(depth=(depth - 8, depth - 8))
        good(f"depth_{depth}", f"{depth} bits.", record, depth=depth)
    for at in 13, 15, 16, 17, 18:
        for bit in 0x80, {13: 0x10, 15: 0x04, 16: 0x04}.get(at, 0x08):
            record = bytearray(hevc_record())
            record[at] ^= bit
            bad(f"reserved_{at}_{bit:02x}", f"A reserved bit of byte {at} is 0.", bytes(record))
    for size in 3, 2:
        add = good if size == 3 else bad
        some = [PPS_UNIT[:size]]
        add(
            f"pps_size_{size}",
            f"A parameter set of {size} bytes.",
            hevc_record(arrays=arrays(pps_units=some)),
        )
    good("lengths_reserved", "Other bits beside lengthSizeMinusOne.", hevc_record(lengths=0xFF))
    bad("array_reserved", "The reserved bit of an array is 1.", hevc_record(arrays=arrays(vps_kind=0xE0)))
    good("several", "Two units in an array.", hevc_record(arrays=arrays(pps_units=[PPS_UNIT] * 2)))
    many = arrays(pps_units=[PPS_UNIT] * 257)
    good("array_257", "257 units in an array.", hevc_record(arrays=many))
    bad("space_2", "general_profile_space is 2.", hevc_record(general=0x81))
    bad("luma", "Luma has 9 bits, chroma 8.", hevc_record(depth=(1, 0)))
    bad("chroma", "Chroma has 9 bits, luma 8.", hevc_record(depth=(0, 1)))
    bad("both", "Luma and chroma have 10 bits, VCFG 8.", hevc_record(depth=(2, 2)))
    bad("order", "The arrays are in another order.", hevc_record(arrays=arrays()[::-1]))
    bad(
        "four_arrays",
        "There are four arrays.",
        hevc_record(arrays=[*arrays(), (0x80 | 39, [b"\x4e\x01\x05"])]),
    )
    for name in "vps", "sps", "pps":
        bad(
            f"{name}_empty",
            f"The array of {name} is empty.",
            hevc_record(arrays=arrays(**{f"{name}_units": []})),
        )
        other = hevc_record(arrays=arrays(**{f"{name}_units": [b"\x4e\x01\x05"]}))
        bad(f"{name}_kind", f"A unit in the array of {name} is of type 39.", other)
    for name in "sps", "pps":
        kind = {"sps": 33, "pps": 34}[name]
        record = hevc_record(arrays=arrays(**{f"{name}_kind": kind}))
        bad(f"{name}_incomplete", f"The array of {name} is not complete.", record)
    bad("string_tier", "The codec string has the other tier.", hevc_record(), "hvc1.1.6.H30.90")
    bad("string_zero", "The codec string has a constraint byte 00 at its end.", hevc_record(), usual + ".00")
    bad("string_case", "The sample entry is in upper case.", hevc_record(), "HVC1.1.6.L30.90")


def vp9_record(profile=0, level=10, depth=8, chroma=1, full=0, head=b"\1\0\0\0", data=b"\0\0"):
    return head + bytes([profile, level, depth << 4 | chroma << 1 | full, 1, 1, 1]) + data


def vp9():
    def string(profile=0, level=10, depth=8):
        return f"vp09.{profile:02d}.{level:02d}.{depth:02d}"

    def good(name, title, *, text=None, **fields):
        named = {key: fields[key] for key in ("profile", "level", "depth") if key in fields}
        right("vp09", name, title, vp9_record(**fields), text or string(**named), fields.get("depth", 8))

    def bad(name, title, *, text=None, vcfg=None, **fields):
        named = {key: fields[key] for key in ("profile", "level", "depth") if key in fields}
        depth = fields.get("depth", 8) if vcfg is None else vcfg
        wrong("vp09", name, title, vp9_record(**fields), text or string(**named), depth)

    good("chroma_0", "4:2:0 with chroma on the left, in profile 0.", chroma=0)
    good("full_range", "Full range.", full=1)
    good("level_62", "Level 6.2.", level=62)
    for profile, depth, chroma in (1, 8, 2), (1, 8, 3), (2, 10, 0), (2, 12, 1), (3, 10, 3), (3, 12, 2):
        good(
            f"profile_{profile}_{depth}_{chroma}",
            f"Profile {profile}, {depth} bits, subsampling {chroma}.",
            profile=profile,
            depth=depth,
            chroma=chroma,
        )
    for profile, depth, chroma in (
        (0, 8, 2),
        (1, 8, 1),
        (1, 8, 0),
        (2, 10, 3),
        (3, 10, 1),
        (1, 8, 4),
        (1, 8, 7),
        (4, 10, 1),
    ):
        bad(
            f"profile_{profile}_{depth}_{chroma}",
            f"Profile {profile} does not have the subsampling {chroma}.",
            profile=profile,
            depth=depth,
            chroma=chroma,
        )
    for profile, depth in (0, 10), (1, 10), (2, 8), (3, 8), (2, 9), (2, 11), (0, 12):
        chroma = 1 + profile % 2
        bad(
            f"depth_{profile}_{depth}",
            f"Profile {profile} does not have {depth} bits.",
            profile=profile,
            depth=depth,
            chroma=chroma,
        )
    bad("vcfg_depth", "VCFG has 12 bits, the record 10.", profile=2, depth=10, vcfg=12)
    for at in 1, 2:
        bad(f"flags_{at}", "The record has flags.", head=b"\1" + bytes(at - 1) + b"\1" + bytes(3 - at))
    bad("version_2", "The record has version 2.", head=b"\2\0\0\0")
    bad("data_high", "codecInitializationDataSize is 256.", data=b"\1\0")
    bad("data_low", "codecInitializationDataSize is 1, without data.", data=b"\0\1")
    bad("long", "The record has 13 bytes.", data=b"\0\0\0")
    for name, text in ("profile", string(1)), ("level", string(level=11)), ("depth", string(depth=10)):
        bad(f"string_{name}", f"The codec string has another {name}.", text=text)
    bad("string_long", "The codec string goes on after the depth.", text=string() + ".01")


def leb128(value, size=0):
    """In size bytes at least: the number may have leading zeros."""
    out = []
    while value or not out or len(out) < size:
        out.append(value & 127)
        value >>= 7
    return bytes(b | 128 for b in out[:-1]) + bytes(out[-1:])


SEQUENCE = media.clip("av1").record[6:]
METADATA = 5


def obu(kind, payload, extension=None, size=0, head=2):
    first = bytes([kind << 3 | head | (4 if extension is not None else 0)])
    return first + (b"" if extension is None else bytes([extension])) + leb128(len(payload), size) + payload


def av1_record(profile=0, level=0, tier=0, high=0, twelve=0, *, head=0x81, last=0, low=0x0C, obus=None):
    sequence = bytes([profile << 5 | SEQUENCE[0] & 31]) + SEQUENCE[1:]
    third = tier << 7 | high << 6 | twelve << 5 | low
    fixed = bytes([head, profile << 5 | level, third, last])
    return fixed + (obu(1, sequence) if obus is None else obus)


def av1():
    def string(profile=0, level=0, tier="M", depth=8):
        return f"av01.{profile}.{level:02d}{tier}.{depth:02d}"

    usual = string()
    good = lambda name, title, record, text=usual, depth=8: right("av01", name, title, record, text, depth)  # noqa: E731
    bad = lambda name, title, record, text=usual, depth=8: wrong("av01", name, title, record, text, depth)  # noqa: E731
    for profile, high, twelve, depth in (
        (1, 0, 0, 8),
        (1, 1, 0, 10),
        (2, 0, 0, 8),
        (2, 1, 0, 10),
        (2, 1, 1, 12),
    ):
        good(
            f"profile_{profile}_{depth}",
            f"Profile {profile} with {depth} bits.",
            av1_record(profile, high=high, twelve=twelve),
            string(profile, depth=depth),
            depth,
        )
    good("level_31", "Level 31.", av1_record(level=31), string(level=31))
    good("high_tier", "The high tier.", av1_record(level=9, tier=1), string(level=9, tier="H"))
    good("chroma", "Bits of subsampling and chroma position that no rule names.", av1_record(low=0x1F))
    good("delay_15", "An initial presentation delay.", av1_record(last=0x1F))
    good("delay_zero", "An initial presentation delay of 1 frame.", av1_record(last=0x10))
    long_one = obu(METADATA, bytes([4]) + bytes(299))
    usual_header = obu(1, SEQUENCE)
    good(
        "metadata",
        "Metadata after the sequence header, of more than 127 bytes.",
        av1_record(obus=usual_header + long_one),
    )
    good(
        "metadata_twice", "Two OBUs of metadata.", av1_record(obus=usual_header + obu(METADATA, b"\1\0") * 2)
    )
    good(
        "extension",
        "The OBU of the sequence header has an extension byte.",
        av1_record(obus=obu(1, SEQUENCE, 0x28)),
    )
    good("size_8_bytes", "The size of an OBU has eight bytes.", av1_record(obus=obu(1, SEQUENCE, size=8)))
    good("obu_reserved", "The reserved bit of an OBU is 1.", av1_record(obus=obu(1, SEQUENCE, head=3)))
    for size in 3, 127, 128:
        some = obu(METADATA, bytes([3]) * size)
        title = f"Metadata of {size} bytes, twice."
        good(f"metadata_{size}", title, av1_record(obus=usual_header + some + some))
    for bit in 1, 2, 4:
        header = bytes([SEQUENCE[0] | bit]) + SEQUENCE[1:]
        good(f"sequence_bit_{bit}", "A sequence header with other flags.", av1_record(obus=obu(1, header)))
    good("header_2_bytes", "A sequence header of two bytes.", av1_record(obus=obu(1, SEQUENCE[:2])))
    for head in 0x28, 0x29:
        record = av1_record(obus=usual_header + bytes([head, 0]))
        bad(
            f"no_size_{head:02x}",
            "An OBU has no size, and the byte that follows would be a good one.",
            record,
        )
    bad("size_beyond", "An OBU is a byte longer than the record.", av1_record(obus=obu(1, SEQUENCE)[:-1]))
    bad("size_9_bytes", "The size of an OBU has nine bytes.", av1_record(obus=obu(1, SEQUENCE, size=9)))
    bad("size_cut", "The record ends in the size of an OBU.", av1_record(obus=usual_header + b"\x2a\x80"))
    bad("head_alone", "The record ends after the header of an OBU.", av1_record(obus=usual_header + b"\x2a"))
    bad(
        "extension_cut",
        "The record ends after the first byte of an OBU with two.",
        av1_record(obus=usual_header + b"\x2e"),
    )
    bad("no_size", "An OBU has no size.", av1_record(obus=usual_header + b"\x28"))
    bad("forbidden", "The forbidden bit of an OBU is 1.", av1_record(obus=b"\x8a" + usual_header[1:]))
    bad(
        "metadata_first",
        "Metadata before the sequence header.",
        av1_record(obus=obu(METADATA, b"\1\0") + usual_header),
    )
    bad("frame", "A frame header after the sequence header.", av1_record(obus=usual_header + obu(3, b"\0")))
    bad("header_empty", "The sequence header has no byte.", av1_record(obus=obu(1, b"")))
    still = bytes([SEQUENCE[0] | 8]) + SEQUENCE[1:]
    bad("still", "The sequence header is one of a still picture.", av1_record(obus=obu(1, still)))
    bad("three_bytes", "The record has three bytes.", av1_record()[:3])
    bad("version_0", "The record has version 0.", av1_record(head=0x80))
    bad("profile_3", "Profile 3.", av1_record(3), string(3))
    bad("twelve_alone", "12 bits without high_bitdepth.", av1_record(2, twelve=1), string(2, depth=12), 12)
    bad("twelve_profile_1", "12 bits in profile 1.", av1_record(1, high=1, twelve=1), string(1, depth=12), 12)
    bad("vcfg_depth", "VCFG has 8 bits, the record 10.", av1_record(high=1), string(depth=10))
    for bit in 0x20, 0x40:
        bad(f"reserved_{bit:02x}", "A reserved bit is 1.", av1_record(last=bit))
    for bit in 1, 8:
        bad(f"delay_absent_{bit}", "A delay without the flag that it is there.", av1_record(last=bit))
    for name, text in ("level", string(level=1)), ("tier", string(tier="H")), ("depth", string(depth=10)):
        bad(f"string_{name}", f"The codec string has another {name}.", av1_record(), text)
    bad("string_long", "The codec string goes on after the depth.", av1_record(), usual + ".0")
    bad("string_case", "The codec string is in upper case.", av1_record(), usual.upper())


def ranges():
    """FVV-4003 comes before the record."""
    for depth in 7, 17:
        faulty(
            f"record_range_{depth}",
            f"VCFG of VP9 has {depth} bits.",
            "10.1",
            lambda depth=depth: stream("vp09", vp9_record(), "vp09.00.10.08", depth, 4003),
        )
    valid("record_smallest", "An atlas of one pixel.", "10.1", smallest)


def smallest():
    s = opened((1, payloads.track(payloads.MESH, "mesh")), (TRACK, payloads.track(payloads.VIDEO, "video")))
    s.chunk("VCFG", payloads.video("jpeg", shows=1, width=1, height=1), track=TRACK)
    meshes_of_one_group(s, 0)
    s.finish()
    return s


avc()
hevc()
vp9()
av1()
ranges()
