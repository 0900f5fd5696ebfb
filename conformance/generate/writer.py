"""Streams, whole or with a fault at a known place: clauses 3 to 7 of spec/fvv.md.

A fault is made while the stream is written, so that everything around it (counters, digests, chains, tables, index) is
right. `fault=1103` at a chunk says that this chunk breaks FVV-1103, first of all.
"""

import struct

from reference.container import CHUNKS, DATA, FLAGS, KINDS, STRUCTURES, uleb128, zigzag

from .packing import crc32c, pack

HEADER = STRUCTURES["chunk header"]["size"]
FILE_HEADER = STRUCTURES["file header"]["size"]


def flipped(data, damage):
    """data with bits flipped: damage is a mask by offset."""
    data = bytearray(data)
    for offset, mask in damage.items():
        data[offset] ^= mask
    return bytes(data)


class Group:
    """What GEND and INDX say of a group."""

    def __init__(self, offset, sequence, start, end, foreign=frozenset()):
        """foreign: tracks of data, and of kinds that this version does not know, whose times are frames."""
        self.foreign = foreign
        self.offset, self.sequence, self.start, self.end = offset, sequence, start, end
        self.headers, self.chunks = [], []

    def frames(self):
        """Clause 11."""
        makers = (b"MESH", b"VPKT")

        def counts(code, track):
            free = code == b"DATA" or code.decode("latin-1") not in CHUNKS
            return code in makers or (free and track in self.foreign)

        return len({time for code, track, _, _, time in self.chunks if counts(code, track)})

    def kinds(self):
        return list(dict.fromkeys(chunk[:3] for chunk in self.chunks))

    def rows(self):
        return b"".join(
            pack("GEND row", type=code, track=track, flags=flags) for code, track, flags in self.kinds()
        )

    def table(self):
        kinds, before, out = self.kinds(), self.start, b""
        for code, track, flags, size, time in self.chunks:
            change = (time - before + 2**63) % 2**64 - 2**63
            out += uleb128(kinds.index((code, track, flags))) + uleb128(size) + uleb128(zigzag(change))
            before = time
        return out


class Stream:
    """Appends to `out`. issue, offset: of the fault, if there is one."""

    def __init__(self, fault=None, damage=None, **fields):
        version = DATA["format"]
        values = {
            "signature": bytes.fromhex(version["signature"]),
            "written_major": version["major"],
            "written_minor": version["minor"],
            "reader_major": version["reader_major"],
            "reader_minor": version["reader_minor"],
        } | fields
        crc = values.pop("crc", None)
        head = pack("file header", **values)[:20]
        self.out = bytearray()
        self.issue = self.offset = None
        self._fault(fault)
        self.out += flipped(head + struct.pack("<I", crc32c(head) if crc is None else crc), damage or {})
        self.counter, self.scene_counter = 0, False
        self.block, self.group = None, None  # the open ones
        self.blocks, self.groups, self.sequence = [], [], 0
        self.last = b""

    def _fault(self, issue, offset=None):
        if issue and self.issue is None:
            self.issue, self.offset = issue, len(self.out) if offset is None else offset

    def raw(self, data, fault=None):
        """Bytes that are not a chunk."""
        self._fault(fault)
        self.out += data

    def chunk(
        self,
        code,
        payload=b"",
        track=0,
        time=0,
        key=False,
        *,
        flags=None,
        counter=None,
        size=None,
        payload_crc=None,
        header_crc=None,
        padding=None,
        damage=None,
        lost=False,
        silent=False,
        fault=None,
    ):
        """Writes a chunk and returns its offset.

        damage: bits that flip after the CRCs are made. lost: the chunk is counted but not written. silent: it is written
        but neither counted nor chained.
        """
        kind = code.encode("latin-1") if isinstance(code, str) else code
        known = CHUNKS.get(kind.decode("latin-1"))
        if flags is None:
            names = set(known["flags"]) if known else set()
            flags = sum(FLAGS[name] for name in names | ({"key"} if key else set()))
        if kind in (b"SCEN", b"GRUP", b"INDX"):
            self.counter = 0
        elif not silent:
            self.counter = self.counter + 1 & 255
        self._fault(fault)
        offset = len(self.out)
        length = len(payload) if size is None else size
        crc = crc32c(payload) if payload_crc is None else payload_crc
        shown = self.counter if counter is None else counter
        covered = struct.pack("<4sBBHqQI", kind, flags, shown, track, time, length, crc)
        header = covered + struct.pack("<I", crc32c(covered) if header_crc is None else header_crc)
        filled = bytes(-len(payload) % 8) if padding is None else padding
        self.last = flipped(header + payload + filled, damage or {})
        if not lost:
            self.out += self.last
        if not silent:
            self._count(kind, flags, track, time, len(payload), offset, covered)
        if kind == b"TRAK" and self.block and len(payload) > 1:
            free = payload[0] == KINDS["DATA"] or payload[0] > max(KINDS.values())
            self.block["foreign"] |= {track} if free and payload[1] & 1 else set()
        return offset

    def _count(self, kind, flags, track, time, size, offset, covered):
        if kind == b"SCEN":
            self.block = {"offset": offset, "headers": b"", "listed": False, "foreign": set()}
        if kind in (b"GRUP", b"INDX", b"FOOT", b"GEND"):
            return
        if self.group:
            self.group.headers.append(covered)
            self.group.chunks.append((kind, track, flags, size, time))
        elif self.block is not None:
            self.block["headers"] += covered

    def digest(self):
        return crc32c(self.block["headers"] if self.block else b"")

    def begin(self, start, end, *, fault=None, payload=None, time=None, chained=True, **fields):
        """GRUP. fields: other values than the right ones, which are used in GEND and INDX too."""
        offset = len(self.out)
        values = {"sequence": self.sequence, "configuration_crc": self.digest(), "start": start, "end": end}
        chunk_fields = {name: fields.pop(name) for name in list(fields) if name not in values}
        values |= fields
        body = pack("GRUP payload", **values) if payload is None else payload
        foreign = self.block["foreign"] if self.block else set()
        self.group = Group(offset, values["sequence"], values["start"], values["end"], foreign)
        self.chunk("GRUP", body, time=start if time is None else time, fault=fault, **chunk_fields)
        self.group.headers.append(bytes(self.last[:28]))
        if self.block and not self.block["listed"]:
            self.block["listed"] = True
            self.blocks.append((self.block["offset"], offset - self.block["offset"], self.digest()))
        self.group.block = max(len(self.blocks) - 1, 0)
        self.sequence = (values["sequence"] + 1) % 2**32

    def end(
        self, *, fault=None, rows=None, table=None, time=None, extra=b"", lost=False, listed=True, **fields
    ):
        """GEND. fields: other values than the right ones; rows and table: functions of the right bytes."""
        group, self.group = self.group, None
        right_rows, right_table = group.rows(), group.table()
        rows = rows(right_rows) if rows else right_rows
        table = table(right_table) if table else right_table
        values = {
            "sequence": group.sequence,
            "chunk_count": len(group.headers),
            "chain_crc": crc32c(b"".join(group.headers)),
            "frame_count": group.frames(),
            "kind_count": len(rows) // 8,
            "table_size": len(table),
        }
        chunk_fields = {name: fields.pop(name) for name in list(fields) if name not in values}
        true = dict(values)
        values |= fields
        body = pack("GEND payload", **values) + rows + table + extra
        time = group.end if time is None else time
        at = self.chunk("GEND", body, time=time, fault=fault, lost=lost, **chunk_fields)
        if listed:
            self.groups.append(
                {
                    "offset": group.offset,
                    "group_size": len(self.out) - group.offset,
                    "start": group.start,
                    "end": group.end,
                    "sequence": group.sequence,
                    "frame_count": true["frame_count"],
                    "chain_crc": true["chain_crc"],
                    "end_size": len(self.out) - at,
                    "block": group.block,
                }
            )

    def index_payload(self, blocks=None, groups=None, **counts):
        blocks = self.blocks if blocks is None else blocks
        groups = self.groups if groups is None else groups
        values = {"group_count": len(groups), "block_count": len(blocks)} | counts
        out = pack("INDX payload", **values)
        for offset, size, digest in blocks:
            out += pack("INDX block", offset=offset, block_size=size, digest=digest)
        for group in groups:
            out += pack("INDX entry", **group)
        return out

    def finish(self, *, fault_index=None, fault_foot=None, payload=None, index=None, foot=None, **counts):
        """INDX and FOOT. index, foot: changes of the chunks' fields; foot also has those of the payload."""
        body = self.index_payload(**counts) if payload is None else payload
        at = self.chunk("INDX", body, fault=fault_index, **(index or {}))
        values = {"index_offset": at, "index_crc": crc32c(body)}
        values["file_size"] = len(self.out) + HEADER + STRUCTURES["FOOT payload"]["size"]
        chunk_fields = dict(foot or {})
        values |= {
            name: chunk_fields.pop(name)
            for name in list(chunk_fields)
            if name in values or name == "reserved"
        }
        footer = chunk_fields.pop("payload", None)
        footer = pack("FOOT payload", **values) if footer is None else footer
        self.chunk("FOOT", footer, fault=fault_foot, **chunk_fields)

    def cut(self, size, fault=None, offset=None):
        """Removes bytes from the end. offset: of the chunk that is cut, or where a missing one is expected."""
        del self.out[size:]
        self._fault(fault, offset)
