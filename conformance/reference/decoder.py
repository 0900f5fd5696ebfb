"""The reference decoder: what a stream contains, what of it is intact, and which rules it breaks.

`report(data)` reads a stream from front to back, as clauses 3 to 7 of spec/fvv.md describe it, and returns the decode report
of ../PROTOCOL.md. It is slow and complete: every rule of spec/issues.md is checked, and after damage it continues.
"""

import struct
from typing import NamedTuple

from .container import CHUNKS, DATA, FLAGS, Broken, crc32c, demand
from .decode.configuration import Block, TooMany
from .decode.group import KIND_OF, Group, sha256
from .decode.scan import FILE_HEADER, Damage, scan

CONFIGURATION = {code.encode() for code, chunk in CHUNKS.items() if chunk["place"] == "configuration"}
KNOWN = {code.encode(): chunk for code, chunk in CHUNKS.items()}
SIGNATURE = bytes.fromhex(DATA["format"]["signature"])
CRITICAL, KEY, LAST = FLAGS["critical"], FLAGS["key"], FLAGS["last"]
KIND_NAMES = {
    v["value"]: v["name"].lower() for e in DATA["enums"] if e["prefix"] == "TRACK" for v in e["values"]
}
RESET = (b"SCEN", b"GRUP", b"INDX")
GROUP_LIMIT = 4_194_304


class Issue(NamedTuple):
    offset: int
    number: int
    text: str


class Refused(Exception):
    """A reader stops here; the issue is noted."""


class Reader:
    """Reads one stream. place: start, configuration, group, between, index, end, or lost where damage hides it."""

    group_type = Group

    def __init__(self, data, blocks, joined=False):
        self.data, self.joined = data, joined
        self.issues, self.refused = [], False
        self.place, self.counter, self.suppressed, self.damaged, self.loss = (
            "start",
            -1,
            False,
            False,
            False,
        )
        self.block, self.blocks, self.first_scene = None, dict(blocks), None
        self.group, self.groups, self.sequence, self.last_end = None, [], None, None
        self.entries, self.listed, self.index, self.ended, self.indexed = [], [], None, False, False
        self.environments, self.run = {}, (0, None)

    # Issues

    def note(self, offset, issue, text):
        self.issues.append(Issue(offset, issue, text))

    def order_broken(self, offset, issue, text):
        """A rule of clauses 3 to 6: one is reported up to the next GRUP or SCEN."""
        self.damaged = self.loss = True
        if not self.suppressed:
            self.note(offset, issue, text)
        self.suppressed = True
        if self.group:
            self.group.damage()

    # File header

    def file_header(self):
        data = self.data
        if len(data) < FILE_HEADER:
            self.note(len(data), 1005, "the stream ends inside its file header")
            raise Refused
        if data[:8] != SIGNATURE:
            self.note(0, 1001, "no signature")
            raise Refused
        _, _, major, minor, reserved, crc = struct.unpack_from("<4HII", data, 8)
        if crc32c(data[:20]) != crc:
            self.damaged = True
            self.note(0, 1002, "CRC of the file header")
            return
        if major != DATA["format"]["major"] or not 2 <= minor <= DATA["format"]["minor"]:
            self.note(0, 1004, f"version {major}.{minor}")
            raise Refused
        if reserved:
            self.damaged = True
            self.note(0, 1003, "reserved field of the file header")

    # Chunks

    def run_through(self):
        self.file_header()
        for found in scan(self.data):
            if self.place == "end":
                self.note(found.offset, 1303, "bytes after FOOT")
                self.damaged = True
                return
            if isinstance(found, Damage):
                self.lose(found)
            else:
                self.take(found)
        self.finish()

    def lose(self, found):
        self.note(found.offset, found.issue, found.text)
        self.damaged = self.suppressed = self.loss = True
        self.counter = None
        if self.group:
            self.group.damage()
        if found.fatal:
            raise Refused
        if self.place == "configuration":
            self.block.complete = False
        if self.place in ("start", "between") or found.kind in (b"GRUP", b"SCEN", b"GEND"):
            self.close_group()
            self.close_block()
            self.place = "lost"

    def take(self, chunk):
        known = KNOWN.get(chunk.kind)
        if known is None and chunk.flags & CRITICAL and not self.is_ignored(chunk.track):
            self.note(chunk.offset, 1106, f"unknown critical chunk {chunk.kind!r}")
            raise Refused
        if chunk.kind in (b"SCEN", b"GRUP"):
            self.leave(chunk)
            self.suppressed = False
        broken = 0
        try:
            self.check_header(chunk, known)
            self.check_place(chunk, known)
            self.check_counter(chunk)
        except Broken as failure:
            self.order_broken(chunk.offset, failure.issue, str(failure))
            broken = failure.issue
        self.counter = chunk.counter
        self.enter(chunk, known, broken)

    def is_ignored(self, track):
        """Whether a critical chunk of the track is ignored with its track: clause 4.5."""
        block = self.group.block if self.group else self.block
        if self.group and block is None:
            return track != 0
        kind = block.tracks[track].kind if block and track in block.tracks else 0
        return bool(kind) and kind not in KIND_OF.values()

    def leave(self, chunk):
        """A block or a group begins: the group before it must have ended."""
        if self.place != "group":
            return
        group = self.group
        self.close_group()
        self.place = "lost"
        group.damage()
        self.order_broken(chunk.offset, 1203, "the group before has no GEND")

    def check_header(self, chunk, known):
        demand(not chunk.flags & ~(CRITICAL | KEY | LAST), 1102, f"flags {chunk.flags}")
        if known is None:
            return
        flags = sum(FLAGS[name] for name in known["flags"])
        frame = chunk.kind in KIND_OF
        demand(chunk.flags & ~(KEY if frame else 0) == flags, 1102, f"flags {chunk.flags}")
        timed = frame or chunk.kind in (b"GRUP", b"GEND")
        if chunk.kind == b"TILE" and not chunk.flags & KEY:
            timed = False
        demand(timed or chunk.time == 0, 1109, f"time {chunk.time}")
        own = known["track"]
        demand(chunk.track == 0 if own == "none" else chunk.track, 1109, f"track {chunk.track}")

    def check_place(self, chunk, known):
        kind, place = chunk.kind, self.place
        if known is None:
            return
        layout = kind == b"TILE" and chunk.flags & KEY
        in_group = kind in KIND_OF and kind != b"TILE" or layout or kind == b"GEND"
        if place == "group":
            demand(in_group, 1203, f"{kind.decode()} inside a group")
            return
        if place == "lost":
            return
        demand(not in_group, 1201, f"{kind.decode()} outside of a group")
        if kind == b"SCEN":
            demand(place in ("start", "configuration", "between"), 1201, "SCEN after the groups")
        elif kind == b"GRUP":
            demand(place in ("start", "configuration", "between"), 1201, "GRUP after INDX")
        elif kind == b"INDX":
            demand(place in ("configuration", "between"), 1201 if place != "start" else 1202, "place of INDX")
        elif kind == b"FOOT":
            demand(place == "index", 1201, "FOOT without INDX before it")
        else:
            demand(place == "configuration", 1201, f"{kind.decode()} outside of a configuration block")
            demand(kind != b"TRAK" or not self.block.names, 1201, "TRAK after other chunks")

    def check_counter(self, chunk):
        expected = 0 if chunk.kind in RESET else None if self.counter is None else self.counter + 1 & 255
        demand(expected in (None, chunk.counter), 1105, f"counter {chunk.counter}, expected {expected}")

    # Content

    def enter(self, chunk, known, broken):
        """Reads a chunk in its place; nothing of one that breaks a rule is used, but for beginning a block or a group."""
        kind = chunk.kind
        try:
            if kind == b"SCEN":
                self.close_group()
                self.block, self.place = Block(chunk.offset), "configuration"
                self.configure(chunk, broken)
            elif kind == b"GRUP":
                self.close_group()
                self.begin(chunk, broken)
            elif self.place == "group":
                self.in_group(chunk, broken)
            elif kind == b"INDX":
                self.close_block()
                self.place, self.index = "index", None if broken else chunk
                self.indexed = not broken
                self.check_index(chunk)
            elif kind == b"FOOT":
                self.place = "end"
                self.check_footer(chunk)
            elif self.place == "configuration" and (known is None or kind in CONFIGURATION):
                self.configure(chunk, broken)
            elif self.place == "configuration":
                self.block.complete = False
                self.close_block()
                self.place = "lost"
        except Broken as failure:
            self.payload_broken(chunk, failure)
            broken = True
        if any(chunk.padding) and not broken:
            self.order_broken(chunk.offset, 1104, "padding")

    def payload_broken(self, chunk, failure):
        self.damaged = True
        if not self.issues or self.issues[-1].offset != chunk.offset:
            self.note(chunk.offset, failure.issue, str(failure))

    def configure(self, chunk, broken):
        """broken: the issue of its header, place or counter. After 1105 the digest shows whether all chunks are there."""
        self.block.complete &= not broken
        self.block.valid &= broken in (0, 1105)
        self.block.names |= chunk.kind not in (b"SCEN", b"TRAK") and chunk.kind in KNOWN
        try:
            self.block.add(chunk, self.first_scene)
        except TooMany as failure:
            self.note(chunk.offset, failure.issue, str(failure))
            raise Refused from failure
        except Broken as failure:
            # An ancillary chunk, or a codec that is not known, takes no more than itself or its track: clause 5.
            self.block.valid &= failure.issue == 4002 or not chunk.flags & CRITICAL
            raise
        if chunk.kind == b"SCEN":
            self.first_scene = self.first_scene or self.block.scene

    def close_block(self, chunk=None):
        """The end of a configuration block; its whole is checked once. What it lacks is only known when a GRUP names its digest."""
        block, was = self.block, self.place
        if was != "configuration" or block is None:
            return
        digest = block.digest()
        if block.valid:
            try:
                block.finish()
            except Broken as failure:
                block.valid = False
                self.note_whole(block, chunk, failure.issue, str(failure))
        if block.valid and (issue := block.silent()):
            self.note_whole(block, chunk, issue, "an audio or data track without configuration")
        if block.valid:
            self.blocks[digest] = block
        if self.run[1] != digest:
            self.run = self.run[0] + 1, digest

    def note_whole(self, block, chunk, issue, text):
        """A rule of the whole block. chunk: the GRUP that names its digest, which shows that nothing of it is missing."""
        if block.complete and chunk and chunk.payload[4:8] == block.digest().to_bytes(4, "little"):
            self.damaged = True
            self.note(block.at, issue, text)

    def begin(self, chunk, broken):
        self.close_block(chunk)
        self.place = "lost"
        demand(len(chunk.payload) == 24, 1204, "size of GRUP")
        sequence, digest, start, end = struct.unpack("<IIqq", chunk.payload)
        known = self.blocks.get(digest)
        group = self.group = self.group_type(chunk, known)
        self.place = "group"
        group.at_block, group.run = self.block, self.run[0]
        if broken:
            group.damage()
        loss, self.loss = self.loss, False
        first = sequence if self.joined else 0
        expected = first if self.sequence is None else self.sequence + 1
        last_end, self.sequence, self.last_end = self.last_end, sequence, end
        try:
            demand(start < end and start == chunk.time, 1206, f"from {start} to {end}")
            demand(last_end is None or start >= last_end, 1206, "start before the end of the group before")
        except Broken:
            group.damage()
            raise
        if sequence < expected:
            group.damage()
            raise Broken(1205, f"sequence number {sequence}, expected {expected}: it is repeated")
        if not loss:
            demand(self.block is not None, 1202, "a group without a configuration")
            demand(self.block.digest() == digest, 1207, "digest of the configuration")
            demand(sequence == expected, 1205, f"sequence number {sequence}, expected {expected}")

    def in_group(self, chunk, broken):
        group = self.group
        if chunk.kind == b"GEND":
            self.end_group(chunk, broken)
            return
        if (
            chunk.kind in CONFIGURATION
            and not (chunk.kind == b"TILE" and chunk.flags & KEY)
            or chunk.kind
            in (
                b"INDX",
                b"FOOT",
            )
        ):
            self.leave_group(chunk)
            return
        if not broken and group.intact:
            try:
                group.place(chunk)
            except Broken as failure:
                self.order_broken(chunk.offset, failure.issue, str(failure))
                if failure.issue == 7001:
                    raise Refused from failure
                broken = True
        group.take(chunk)
        if not broken:
            group.content(chunk)
            if chunk.kind == b"BACK" and chunk.track in group.environments:
                same = self.environments.setdefault((self.run[0], chunk.track), chunk.payload)
                demand(same == chunk.payload, 8004, "another environment under one configuration")

    def leave_group(self, chunk):
        self.close_group()
        self.place = "lost"
        if chunk.kind in (b"INDX", b"FOOT"):
            self.place = "index" if chunk.kind == b"INDX" else "end"

    def end_group(self, chunk, broken):
        group = self.group
        try:
            if not broken and group.intact:
                group.finish(chunk)
        except Broken as failure:
            self.order_broken(chunk.offset, failure.issue, str(failure))
        group.until = chunk.end
        if group.ended and not any(chunk.padding):
            block = group.at_block
            if block and (not self.listed or self.listed[-1][0] != block.offset):
                self.listed.append((block.offset, group.offset - block.offset, group.digest))
            frames, chain = len(group.frame_times), crc32c(b"".join(group.covered))
            self.entries.append(
                (
                    group.offset,
                    chunk.end - group.offset,
                    group.start,
                    group.end,
                    group.sequence,
                    frames,
                    chain,
                    chunk.end - chunk.offset,
                    len(self.listed) - 1,
                )
            )
        self.close_group()
        self.place = "between"

    def close_group(self):
        if self.group:
            self.groups.append(self.group)
        self.group = None

    # End

    def index_payload(self):
        out = struct.pack("<II", len(self.entries), len(self.listed))
        out += b"".join(struct.pack("<QII", *block) for block in self.listed)
        return out + b"".join(struct.pack("<QQqqIIIII", *entry) for entry in self.entries)

    def check_index(self, chunk):
        listed = self.damaged or chunk.payload.startswith(self.index_payload())
        demand(listed, 1301, "INDX does not list the stream")

    def check_footer(self, chunk):
        self.ended = True
        demand(len(chunk.payload) == 24, 1302, "size of FOOT")
        offset, size, crc, reserved = struct.unpack("<QQII", chunk.payload)
        demand(reserved == 0, 1302, "reserved field of FOOT")
        demand(size == chunk.end, 1302, f"size of the stream {size}")
        if self.index:
            demand((offset, crc) == (self.index.offset, self.index.crc), 1302, "INDX in FOOT")

    def finish(self):
        if self.place == "group" and not self.suppressed:
            self.note(len(self.data), 1203, "the stream ends inside a group")
            self.damaged = True
        self.close_block()

    def results(self):
        frames, sounds = [], {}
        for group in self.groups:
            if group.block is None:
                continue
            frames += [{"time": time, "arrays": arrays} for time, arrays in group.whole()]
            for track, packets in group.sounds:
                sounds.setdefault(track, []).append(packets)
        return {
            "status": "refused" if self.refused else "damaged" if self.issues else "whole",
            "issues": [
                {"issue": f"FVV-{issue.number}", "offset": issue.offset}
                for issue in sorted(self.issues, key=lambda issue: issue.offset)
            ],
            "frames": frames,
            "sounds": {
                str(track): {**sound_of(parts), "chunks": [sound_of([part]) for part in parts]}
                for track, parts in sorted(sounds.items())
            },
            "environment": self.environment(),
            "summary": self.summary(),
        }

    def environment(self):
        """Clause 18.5: the environment of the last group, found as a reader with an index finds it."""
        groups = [group for group in self.groups if group.block]
        if not groups:
            return {}
        last, out = groups[-1], {}
        of_block = next(group for group in groups if group.at_block is last.at_block)
        of_run = next(group for group in groups if group.run == last.run)
        for group in of_run, of_block, last:
            for track, environment in group.environments.items():
                out[str(track)] = {name: sha256(data) for name, data in environment.arrays()}
        return out

    def summary(self):
        block = self.block
        tracks = []
        for identifier, track in block.tracks.items() if block else ():
            entry = {"id": identifier, "kind": KIND_NAMES.get(track.kind, "unknown")}
            coded = block.videos.get(identifier) or block.audios.get(identifier)
            if coded and identifier not in block.stopped:
                entry["codec"] = coded.codec.decode("latin-1")
            tracks.append(entry)
        return {
            "groups": len(self.groups),
            "frames": sum(len(group.frame_times) for group in self.groups),
            "tracks": tracks,
            "cameras": list(block.cameras) if block else [],
            "ended": self.ended,
            "indexed": self.indexed,
        }


def sound_of(parts):
    return {
        "packets": sum(packets.count for packets in parts),
        "start": parts[0].start,
        "sha256": sha256(b"".join(packets.data for packets in parts)),
    }


def report(data, live=False, joined=False):
    """The decode report of a stream. live: nothing that comes later serves what came before. joined: the caller joined it late."""
    if joined:
        return read(bytes(data), {}, joined=True).results()
    reader = read(bytes(data), {})
    if not live and any(group.block is None and group.digest in reader.blocks for group in reader.groups):
        reader = read(bytes(data), reader.blocks)  # a repetition after the group serves it
    return reader.results()


def read(data, blocks, reader_type=Reader, joined=False):
    """A Reader that has read a stream. blocks: configuration blocks by digest that are known before."""
    reader = reader_type(data, blocks, joined)
    try:
        reader.run_through()
    except Refused:
        reader.refused = True
    reader.close_group()
    return reader
