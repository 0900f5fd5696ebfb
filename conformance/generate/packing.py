"""Bytes of structures of spec/chunks.json, and CRC-32C, which is computed many times for the same bytes."""

import functools
import re
import struct

from reference.container import CRC_TABLE, PACKED, STRUCTURES


@functools.lru_cache(maxsize=4096)
def crc32c(data):
    """Clause 2.3."""
    value, table = 0xFFFFFFFF, CRC_TABLE
    for byte in data:
        value = value >> 8 ^ table[(value ^ byte) & 255]
    return value ^ 0xFFFFFFFF


@functools.cache
def layout(name):
    """Field names of a structure with their struct letter and count, 0 for a single value."""
    out = []
    for field in STRUCTURES[name]["fields"]:
        kind, count = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", field["type"]).groups()
        out.append((field["name"], PACKED[kind], int(count or 0)))
    return out


def pack(name, **values):
    """The fixed part of a structure; fields that are not given are 0."""
    out = b""
    for field, letter, count in layout(name):
        value = values.pop(field, (0,) * count if count else 0)
        out += struct.pack(f"<{count}{letter}", *value) if count else struct.pack(f"<{letter}", value)
    if values:
        raise KeyError(f"{name} has no field {sorted(values)[0]}")
    return out


def field_offset(name, field):
    """The offset of a field in a structure."""
    at = 0
    for other, letter, count in layout(name):
        if other == field:
            return at
        at += struct.calcsize(f"<{count or 1}{letter}")
    raise KeyError(f"{name} has no field {field}")


def patched(data, name, field, value):
    """data, which begins with a structure, with another value of one field."""
    letter, count = next((letter, count) for other, letter, count in layout(name) if other == field)
    packed = struct.pack(f"<{count or 1}{letter}", *(value if count else [value]))
    at = field_offset(name, field)
    return data[:at] + packed + data[at + len(packed) :]
