"""Chunks of a stream that may be damaged: clauses 4.1, 4.3, 7.3, 7.4 and 13 of spec/fvv.md."""

import struct
from typing import NamedTuple

from ..container import crc32c

HEADER, FILE_HEADER = 32, 24
LIMIT = 256 << 20  # bytes of one payload
INDEX_LIMIT = 8 + 68 * 4_194_304
RESERVED_FLAGS = 0xF8


class Chunk(NamedTuple):
    """A chunk whose CRCs match. covered: bytes 0 to 27 of its header; end: the offset after its padding."""

    offset: int
    kind: bytes
    flags: int
    track: int
    time: int
    counter: int
    size: int
    crc: int
    payload: bytes
    covered: bytes
    padding: bytes
    end: int


class Damage(NamedTuple):
    """Bytes that are no intact chunk. kind: the type if the header is good. fatal: the reader stops here."""

    offset: int
    issue: int
    text: str
    kind: bytes = b""
    fatal: bool = False


def printable(kind):
    return all(0x20 <= byte <= 0x7E for byte in kind)


def header_at(data, at):
    """Whether there is a header: 32 bytes with a printable type and a matching CRC."""
    if at + HEADER > len(data) or not printable(data[at : at + 4]):
        return False
    return crc32c(data[at : at + 28]) == int.from_bytes(data[at + 28 : at + 32], "little")


def resume(data, at):
    """The first header from an offset on, or None (clause 7.4, number 1)."""
    for offset in range(at, len(data) - HEADER + 1):
        if not data[offset + 4] & RESERVED_FLAGS and header_at(data, offset):
            return offset
    return None


def limit(kind):
    return INDEX_LIMIT if kind == b"INDX" else LIMIT


def scan(data):
    """Yields each Chunk and each Damage of a stream, in order, from the end of the file header on."""
    at, checked = FILE_HEADER, 0
    while at is not None and at < len(data):
        if at + HEADER > len(data):
            yield Damage(at, 1107, "the stream ends inside a chunk header")
            return
        if not header_at(data, at):
            yield Damage(at, 1101, "no chunk header")
            at = resume(data, at + 1)
            continue
        kind, flags, counter, track, time, size, crc = struct.unpack_from("<4sBBHqQI", data, at)
        begin = at + HEADER
        end = begin + (size + 7) // 8 * 8
        if size > limit(kind):
            yield Damage(at, 1108 if size >> 63 else 7001, f"a payload of {size} bytes", kind, True)
            return
        if end > len(data):
            yield Damage(at, 1107, f"{len(data) - begin} of {size} bytes of payload", kind)
            at = resume(data, begin)
            continue
        payload = data[begin : begin + size]
        checked += size
        if checked > (64 << 20) + 5 * len(data):
            yield Damage(at, 7001, "too many bytes were checked more than once", kind, True)
            return
        if crc32c(payload) != crc:
            yield Damage(at, 1103, "the CRC of the payload differs", kind)
            at = end if header_at(data, end) else resume(data, begin)
            continue
        covered, padding = data[at : at + 28], data[begin + size : end]
        yield Chunk(at, kind, flags, track, time, counter, size, crc, payload, covered, padding, end)
        at = end
