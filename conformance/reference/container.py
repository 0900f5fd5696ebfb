"""Chunks, their CRCs, and the numbers inside them: clauses 2.3 and 3 to 7 of spec/fvv.md.

`chunks` takes a stream apart, `Stream` writes one: fields come from spec/chunks.json, and counter, digest, chain, table and
index from the prose.
"""

import json
import pathlib
import re
import struct
from typing import NamedTuple

SPEC = pathlib.Path(__file__).resolve().parent.parent.parent / "spec"
DATA = json.loads((SPEC / "chunks.json").read_text())
STRUCTURES = {s["name"]: s for s in DATA["structures"]}
CHUNKS = {c["code"]: c for c in DATA["chunks"]}
FLAGS = {v["name"].lower(): v["value"] for e in DATA["enums"] if e["prefix"] == "FLAG" for v in e["values"]}
PACKED = {"u8": "B", "u16": "H", "u32": "I", "u64": "Q", "i32": "i", "i64": "q", "f64": "d"}


KINDS = {v["name"]: v["value"] for e in DATA["enums"] if e["prefix"] == "TRACK" for v in e["values"]}
FRAME_KINDS = (KINDS["MESH"], KINDS["VIDEO"])


class Broken(ValueError):
    """A rule is broken. issue: its number; the text says what was found."""

    def __init__(self, issue, text):
        super().__init__(f"FVV-{issue}: {text}")
        self.issue = issue


def demand(condition, issue, text):
    if not condition:
        raise Broken(issue, text)


def crc_table():
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0x82F63B78 if value & 1 else 0)
        table.append(value)
    return table


CRC_TABLE = crc_table()


def crc32c(data):
    """Clause 2.3."""
    value = 0xFFFFFFFF
    for byte in data:
        value = value >> 8 ^ CRC_TABLE[(value ^ byte) & 255]
    return value ^ 0xFFFFFFFF


def uleb128(value):
    """Clause 2.3, the shortest form."""
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out) + bytes([value])


def zigzag(value):
    return 2 * value if value >= 0 else -2 * value - 1


def unzigzag(value):
    return value >> 1 ^ -(value & 1)


class Numbers:
    """ULEB128 numbers in a row. issue: of a number that is cut, not in its shortest form, or not below 2^64."""

    def __init__(self, data, at, issue):
        self.data, self.at, self.issue = data, at, issue

    def next(self):
        value = shift = 0
        while True:
            demand(self.at < len(self.data), self.issue, "a number is cut")
            byte = self.data[self.at]
            self.at += 1
            value |= (byte & 127) << shift
            demand(value < 1 << 64, self.issue, "a number of more than 64 bits")
            shift += 7
            if byte < 128:
                demand(byte or shift == 7, self.issue, "a number that is not in its shortest form")
                return value


class Chunk(NamedTuple):
    """kind: the four bytes of the type."""

    kind: bytes
    flags: int
    track: int
    time: int
    payload: bytes


def chunks(stream):
    """Yields each Chunk of a stream that is in order."""
    at = STRUCTURES["file header"]["size"]
    while at < len(stream):
        kind, flags, _, track, time, size = struct.unpack_from("<4sBBHqQ", stream, at)
        yield Chunk(kind, flags, track, time, stream[at + 32 : at + 32 + size])
        at += 32 + (size + 7) // 8 * 8


def payloads(stream, kind):
    """The payloads of all chunks of one type, in order."""
    return [chunk.payload for chunk in chunks(stream) if chunk.kind == kind]


class Part(NamedTuple):
    """Bytes of a stream that belong together, with the name and the meaning of the field."""

    data: bytes
    name: str
    meaning: str


class Section(NamedTuple):
    """A chunk, or the file header."""

    title: str
    offset: int
    parts: list


def joined(parts):
    return b"".join(part.data for part in parts)


def number(value):
    return f"{value:g}" if isinstance(value, float) else str(value)


def structure(name, values, meanings=None):
    """The fixed part of a structure. values: by name of the field; fields that are not named are 0."""
    meanings, parts = meanings or {}, []
    fields = STRUCTURES[name]["fields"]
    unknown = set(values) - {field["name"] for field in fields}
    if unknown:
        raise KeyError(f"{name} has no field {sorted(unknown)[0]}")
    for field in fields:
        kind, count = re.fullmatch(r"(\w+)(?:\[(\d+)\])?", field["type"]).groups()
        value = values.get(field["name"], [0] * int(count) if count else 0)
        items = list(value) if count else [value]
        data = struct.pack(f"<{len(items)}{PACKED[kind]}", *items)
        default = ", ".join(number(item) for item in items) if any(items) else "0"
        parts.append(Part(data, field["name"], meanings.get(field["name"], default)))
    return parts


def span(offset, size):
    return f"bytes {offset} to {offset + size - 1}"


def spans(headers):
    """The chain and the digest go over bytes 0 to 27 of each header."""
    return ", ".join(f"{offset} to {offset + 27}" for offset, _ in headers)


class Stream:
    """Writes a stream as clause 3.3 orders it; data() returns what was written so far."""

    def __init__(self):
        version = DATA["format"]
        signature = bytes.fromhex(version["signature"])
        parts = structure(
            "file header",
            {
                "signature": signature,
                "written_major": version["major"],
                "written_minor": version["minor"],
                "reader_major": version["reader_major"],
                "reader_minor": version["reader_minor"],
            },
            {"signature": '0x89, "FVV", CR LF, Ctrl-Z, LF'},
        )
        crc = crc32c(joined(parts)[:20])
        parts[-1] = Part(struct.pack("<I", crc), "crc", f"CRC-32C of {span(0, 20)}")
        self.sections = [Section("File header", 0, parts)]
        self.size = len(joined(parts))
        self.configuration = []  # (offset, bytes 0 to 27) of the headers of the block that holds
        self.shown = set()  # tracks of data in the block whose times are frames
        self.group = None  # what GEND and INDX will say of the open group
        self.groups = []
        self.blocks = []  # configuration blocks as INDX lists them
        self.counter = 0

    def data(self):
        return b"".join(joined(section.parts) for section in self.sections)

    def chunk(self, code, payload=(), track=0, time=0, key=False):
        """Writes one chunk of payload parts and returns the offset of its header."""
        names = set(CHUNKS[code]["flags"]) | ({"key"} if key else set())
        flags = sum(FLAGS[name] for name in names)
        self.counter = 0 if code in ("SCEN", "GRUP", "INDX") else self.counter + 1 & 255
        body, offset = joined(payload), self.size
        values = {
            "type": code.encode("ascii"),
            "flags": flags,
            "counter": self.counter,
            "track": track,
            "time": time,
            "payload_size": len(body),
            "payload_crc": crc32c(body),
        }
        meanings = {
            "type": f'"{code}"',
            "flags": ", ".join(name for name in FLAGS if name in names) or "none",
            "payload_crc": f"CRC-32C of {span(offset + 32, len(body))}",
            "header_crc": f"CRC-32C of {span(offset, 28)}",
        }
        parts = structure("chunk header", values, meanings)
        covered = joined(parts)[:28]
        parts[-1] = parts[-1]._replace(data=struct.pack("<I", crc32c(covered)))
        padding = bytes(-len(body) % 8)
        parts += payload
        if padding:
            parts.append(Part(padding, "padding", "to a multiple of 8 bytes"))
        self.sections.append(Section(f"{code}, {CHUNKS[code]['title']}", offset, parts))
        self.size += 32 + len(body) + len(padding)
        if code == "SCEN":
            self.configuration, self.shown = [], set()
        if code == "TRAK" and len(body) > 1 and body[0] == KINDS["DATA"] and body[1]:
            self.shown.add(track)
        place = CHUNKS[code]["also"] if "also" in CHUNKS[code] and self.group else CHUNKS[code]["place"]
        if place == "configuration":
            self.configuration.append((offset, covered))
        elif self.group:
            self.group["headers"].append((offset, covered))
            if place == "frame":
                self.group["chunks"].append((code, track, flags, len(body), time))
        return offset

    def scene(self, step=0.001, origin=(0.0, 0.0, 0.0), up_axis=3):
        values = {
            "time_base_numerator": 1,
            "time_base_denominator": 25,
            "frame_duration": 1,
            "lattice_origin": origin,
            "lattice_step": step,
            "up_axis": up_axis,
        }
        meanings = {
            "time_base_denominator": "25: a tick is 1/25 s",
            "frame_duration": "1 tick",
            "lattice_origin": ", ".join(number(value) for value in origin),
            "lattice_step": f"{step:g} m",
            "up_axis": "3: +z" if up_axis == 3 else str(up_axis),
        }
        self.chunk("SCEN", structure("SCEN payload", values, meanings))

    def track(self, identifier, kind, name, **more):
        """more: further fields of TRAK."""
        text = name.encode()
        values = {"kind": kind, "flags": int(kind in FRAME_KINDS), "name_size": len(text), **more}
        meanings = {"flags": "1: frames"} if values["flags"] else {}
        parts = structure("TRAK payload", values, meanings | ({"kind": "1: mesh"} if kind == 1 else {}))
        self.chunk("TRAK", [*parts, Part(text, "name", f'"{name}"')], track=identifier)

    def begin_group(self, start, end):
        digest = crc32c(b"".join(covered for _, covered in self.configuration))
        values = {"sequence": len(self.groups), "configuration_crc": digest, "start": start, "end": end}
        meanings = {"configuration_crc": f"digest: CRC-32C of bytes {spans(self.configuration)}"}
        self.group = {"headers": [], "chunks": [], "start": start, "end": end}
        payload = structure("GRUP payload", values, meanings)
        self.group["offset"] = self.chunk("GRUP", payload, time=start)
        begin = self.configuration[0][0]
        if not self.blocks or self.blocks[-1]["offset"] != begin:
            self.blocks.append(
                {"offset": begin, "block_size": self.group["offset"] - begin, "digest": digest}
            )

    def makes_frame(self, code, track):
        """Clause 11."""
        return code in ("MESH", "VPKT") or (code == "DATA" and track in self.shown)

    def end_group(self):
        group, self.group = self.group, None
        rows = list(dict.fromkeys(chunk[:3] for chunk in group["chunks"]))
        table, before = [], group["start"]
        for code, track, flags, size, time in group["chunks"]:
            row = rows.index((code, track, flags))
            table.append(Part(uleb128(row), "row", f"{row}: {code} of track {track}"))
            table.append(Part(uleb128(size), "size", f"{size} bytes of payload"))
            table.append(Part(uleb128(zigzag(time - before)), "time", f"{time - before} ticks later"))
            before = time
        chain = crc32c(b"".join(covered for _, covered in group["headers"]))
        values = {
            "sequence": len(self.groups),
            "chunk_count": len(group["headers"]),
            "chain_crc": chain,
            "frame_count": len({chunk[4] for chunk in group["chunks"] if self.makes_frame(*chunk[:2])}),
            "kind_count": len(rows),
            "table_size": len(joined(table)),
        }
        meanings = {"chain_crc": f"CRC-32C of bytes {spans(group['headers'])}"}
        payload = structure("GEND payload", values, meanings)
        for code, track, flags in rows:
            row = {"type": code.encode("ascii"), "track": track, "flags": flags}
            names = ", ".join(name for name, bit in FLAGS.items() if flags & bit)
            payload += structure("GEND row", row, {"type": f'"{code}"', "flags": names})
        offset = self.chunk("GEND", payload + table, time=group["end"])
        self.groups.append(
            {
                "offset": group["offset"],
                "group_size": self.size - group["offset"],
                "start": group["start"],
                "end": group["end"],
                "sequence": values["sequence"],
                "frame_count": values["frame_count"],
                "chain_crc": chain,
                "end_size": self.size - offset,
                "block": len(self.blocks) - 1,
            }
        )

    def finish(self):
        counts = {"group_count": len(self.groups), "block_count": len(self.blocks)}
        payload = structure("INDX payload", counts)
        for block in self.blocks:
            payload += structure("INDX block", block, {"digest": "as in GRUP"})
        for group in self.groups:
            payload += structure("INDX entry", group, {"chain_crc": "as in GEND"})
        values = {"index_crc": crc32c(joined(payload)), "index_offset": self.chunk("INDX", payload)}
        values["file_size"] = self.size + 32 + STRUCTURES["FOOT payload"]["size"]
        self.chunk("FOOT", structure("FOOT payload", values, {"index_crc": "payload_crc of INDX"}))
        return self.data()


def rewritten(stream):
    """The same configuration and groups in a container of this version."""
    return joined_chunks(chunks(stream))


def joined_chunks(given):
    """A stream of chunks of configurations and groups, in a container that is right, with an INDX and a FOOT of its own."""
    out = Stream()
    for chunk in given:
        code = chunk.kind.decode("ascii")
        if code == "GRUP":
            out.begin_group(*struct.unpack_from("<qq", chunk.payload, 8))
        elif code == "GEND":
            out.end_group()
        elif code not in ("INDX", "FOOT"):
            payload = [Part(chunk.payload, "payload", "")]
            out.chunk(code, payload, chunk.track, chunk.time, bool(chunk.flags & FLAGS["key"]))
    return out.finish()
