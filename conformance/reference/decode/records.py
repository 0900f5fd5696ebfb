"""Configuration records and codec strings of video: FVV-4004, clauses 10.4 to 10.9 of spec/fvv.md."""

import struct

from ..container import demand

AVC_WITHOUT_DEPTHS = (66, 77, 88, 100)  # profiles of 8 bits, whose records may end before the bit depths


def well_formed(condition, text):
    demand(condition, 4004, text)


class Bytes:
    """A record from front to back; what is not there is FVV-4004."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, size):
        well_formed(self.at + size <= len(self.data), "the record is cut")
        self.at += size
        return self.data[self.at - size : self.at]

    def u8(self):
        return self.take(1)[0]

    def u16(self):
        return int.from_bytes(self.take(2), "big")

    def left(self):
        return len(self.data) - self.at


def parameter_sets(record, count, kind, least, nal_kind):
    """least: bytes that one has."""
    for _ in range(count):
        unit = record.take(record.u16())
        well_formed(len(unit) >= least and nal_kind(unit) == kind, f"a NAL unit that is none of type {kind}")


def with_reserved(byte, bits):
    """The lowest bits of a byte whose others are reserved and 1."""
    well_formed(byte >> bits == 0xFF >> bits, "reserved bits")
    return byte & (1 << bits) - 1


def avc(data, string, depth):
    record = Bytes(data)
    well_formed(record.u8() == 1, "version")
    profile, constraints, level = record.take(3)
    well_formed(record.u8() == 0xFF, "reserved bits, or lengthSizeMinusOne")
    for bits, kind, least in (5, 7, 4), (8, 8, 2):
        count = with_reserved(record.u8(), bits)
        well_formed(count > 0, "no parameter set")
        parameter_sets(record, count, kind, least, lambda unit: unit[0] & 31)
    if record.left() and profile not in (66, 77, 88):
        with_reserved(record.u8(), 2)  # chroma format
        luma, chroma = (with_reserved(x, 3) for x in record.take(2))
        well_formed(luma == chroma == depth - 8, "bit depths")
        parameter_sets(record, record.u8(), 13, 2, lambda unit: unit[0] & 31)
    elif profile in AVC_WITHOUT_DEPTHS:
        well_formed(depth == 8, f"profile {profile} with {depth} bits")
    well_formed(not record.left(), "bytes after the record")
    well_formed(string.lower() == b"avc1.%02x%02x%02x" % (profile, constraints, level), "codec string")


def hevc_string(general, compatibility, constraints, level):
    """Annex E of ISO/IEC 14496-15: compatibility flags in reverse order of bits, constraint bytes up to the last that is not 0."""
    reverse = int(f"{compatibility:032b}"[::-1], 2)
    text = f"hvc1.{general & 31}.{reverse:x}.{'H' if general & 32 else 'L'}{level}"
    for byte in constraints.rstrip(b"\0"):
        text += f".{byte:02x}"
    return text.encode()


def hevc(data, string, depth):
    record = Bytes(data)
    well_formed(record.u8() == 1, "version")
    general = record.u8()
    well_formed(general >> 6 == 0, "general_profile_space")
    compatibility = int.from_bytes(record.take(4), "big")
    constraints, level = record.take(6), record.u8()
    for bits in 4, None, 2, 2:  # segmentation of two bytes, parallelism, chroma format
        byte = record.u8()
        if bits:
            with_reserved(byte, bits)
    luma, chroma = (with_reserved(x, 3) for x in record.take(2))
    well_formed(luma == chroma == depth - 8, "bit depths")
    record.take(2)  # frame rate
    well_formed(record.u8() & 3 == 3, "lengthSizeMinusOne")
    well_formed(record.u8() == 3, "arrays")
    for kind in 32, 33, 34:
        well_formed(record.u8() == 0x80 | kind, f"an array that is not complete, or not of type {kind}")
        count = record.u16()
        well_formed(count > 0, "an empty array")
        parameter_sets(record, count, kind, 3, lambda unit: unit[0] >> 1 & 63)
    well_formed(not record.left(), "bytes after the record")
    wanted = hevc_string(general, compatibility, constraints, level)
    tier = len(b"hvc1")  # only hexadecimal digits may have either case
    well_formed(string.lower() == wanted.lower() and string[:tier] == wanted[:tier], "codec string")


def vp9(data, string, depth):
    well_formed(len(data) == 12 and data[:4] == b"\1\0\0\0", "size, version or flags")
    profile, level, bits = data[4:7]
    chroma = bits >> 1 & 7
    well_formed(profile < 4 and chroma < 4, f"profile {profile}, subsampling {chroma}")
    well_formed(bits >> 4 == depth and depth in ((10, 12) if profile > 1 else (8,)), "bit depth")
    well_formed((chroma > 1) == bool(profile & 1), "chroma subsampling")
    well_formed(data[10:] == b"\0\0", "codecInitializationDataSize")
    well_formed(string == b"vp09.%02d.%02d.%02d" % (profile, level, depth), "codec string")


def obus(data, issue):
    """Yields type and payload of each OBU; all have a size."""
    at = 0
    while at < len(data):
        head = data[at]
        demand(not head & 0x80 and head & 2, issue, "an OBU without a size, or with the forbidden bit")
        at += 2 if head & 4 else 1
        size = shift = 0
        while True:
            demand(at < len(data) and shift < 56, issue, "the size of an OBU is cut")
            size |= (data[at] & 127) << shift
            at, shift = at + 1, shift + 7
            if data[at - 1] < 128:
                break
        demand(at + size <= len(data), issue, "an OBU is cut")
        yield head >> 3 & 15, data[at : at + size]
        at += size


def av1(data, string, depth):
    well_formed(len(data) >= 4 and data[0] == 0x81, "marker or version")
    profile, level, tier = data[1] >> 5, data[1] & 31, data[2] >> 7
    well_formed(not data[3] & 0xE0 and (data[3] & 16 or not data[3] & 15), "reserved bits")
    high, twelve = data[2] >> 6 & 1, data[2] >> 5 & 1
    well_formed(profile < 3 and (not twelve or profile == 2 and high), "profile and bit depth")
    well_formed(depth == (12 if twelve else 10 if high else 8), "bit depth")
    units = list(obus(data[4:], 4004))
    well_formed(units and units[0][0] == 1 and all(kind == 5 for kind, _ in units[1:]), "OBUs of the record")
    header = units[0][1]
    well_formed(header and header[0] >> 5 == profile and not header[0] & 8, "sequence header")
    text = f"av01.{profile}.{level:02d}{'H' if tier else 'M'}.{depth:02d}"
    well_formed(string == text.encode(), "codec string")


def nothing(data, string, depth):
    well_formed(not data and not string, "a record or a codec string")


RECORDS = {b"jpeg": nothing, b"oexr": nothing, b"avc1": avc, b"hvc1": hevc, b"vp09": vp9, b"av01": av1}


class Video:
    """A VCFG payload. codec is known unless FVV-4002 was found."""

    def __init__(self, payload, check_text):
        demand(len(payload) >= 24, 4001, "size")
        codec, width, height, shows, depth, _, transfer, matrix, full, text, record = struct.unpack_from(
            "<4sII6BHI", payload
        )
        demand(len(payload) == 24 + record + text, 4001, "size")
        self.codec, self.width, self.height, self.shows = codec, width, height, shows
        self.tiles, self.known = shows == 0, codec in RECORDS and shows < 2
        if not self.known:
            return
        demand(max(width, height) <= 16384, 7001, f"{width} x {height} pixels")
        demand(width > 0 and height > 0 and 8 <= depth <= 16 and full < 2, 4003, "range")
        self.string, self.record, self.depth = payload[24 + record :], payload[24 : 24 + record], depth
        if codec == b"jpeg":
            demand(depth == 8, 4003, f"{depth} bits of JPEG")
        if codec == b"oexr":
            demand((depth, transfer, matrix, full) == (16, 8, 0, 1), 4003, "bits or colours of OpenEXR")
        check_text(self.string)
