"""Video of a clip as it was sent, for programs that decode it by themselves."""

from __future__ import annotations

import dataclasses
import struct
from collections.abc import Iterator

from ..clip import Clip

HEADER = 32
START = b"\0\0\0\1"


@dataclasses.dataclass(frozen=True)
class Sample:
    """One picture of a video."""

    ticks: int  #: Its time, in ticks of the clip's time base.
    is_key: bool  #: It decodes alone.
    data: bytes  #: H.264 as Annex B of ITU-T H.264 has it: start codes, and parameter sets before each key picture.


def h264_samples(clip: Clip) -> dict[int, list[Sample]]:
    """The samples of each video track of the rung that is read, by track, of tracks in H.264 without damage. Other codecs are left
    out."""
    found: dict[int, list[Sample]] = {}
    chosen = {track.id for track in clip.tracks if track.kind == "video" and track.selected}
    damaged = set()
    for group in sorted({int(one) for one in clip.chunks()["group"]}):
        sets = _parameter_sets(clip, group)
        for row in clip.chunks(group):
            track = int(row["track"])
            if row["type"] != b"VPKT" or track not in chosen:
                continue
            if track not in sets:
                damaged.add(track)
                continue
            sample = clip.read_at(int(row["offset"]) + HEADER, int(row["size"]))
            units = list(_units(sample))
            if row["key"]:
                units = [*sets[track], *units]
            data = b"".join(START + unit for unit in units)
            found.setdefault(track, []).append(Sample(int(row["time"]), bool(row["key"]), data))
    return {track: samples for track, samples in found.items() if track not in damaged}


def _units(sample: bytes) -> Iterator[bytes]:
    at = 0
    while at + 4 <= len(sample):
        (size,) = struct.unpack_from(">I", sample, at)
        yield sample[at + 4 : at + 4 + size]
        at += 4 + size


def _parameter_sets(clip: Clip, group: int) -> dict[int, list[bytes]]:
    """Of each track in H.264 the sequence and picture parameter sets, from the configuration of a group (spec/fvv.md clauses 4 and 10)."""
    found = {}
    at = clip._stream.configuration_offset(group)
    while at + HEADER <= clip.size:
        kind, track, size = _header(clip.read_at(at, HEADER))
        if kind == b"GRUP":
            break
        if kind == b"VCFG":
            payload = clip.read_at(at + HEADER, size)
            (record_size,) = struct.unpack_from("<I", payload, 20)
            if payload[:4] == b"avc1":
                found[track] = _of_record(payload[24 : 24 + record_size])
        at += HEADER + size + -size % 8
    return found


def _header(header: bytes) -> tuple[bytes, int, int]:
    """Type, track and payload size."""
    (track,) = struct.unpack_from("<H", header, 6)
    (size,) = struct.unpack_from("<Q", header, 16)
    return header[:4], track, size


def _of_record(record: bytes) -> list[bytes]:
    """The parameter sets of an AVCDecoderConfigurationRecord."""
    found, at = [], 6
    for count in (record[5] & 31, None):
        if count is None:
            count, at = record[at], at + 1
        for _ in range(count):
            (size,) = struct.unpack_from(">H", record, at)
            found.append(record[at + 2 : at + 2 + size])
            at += 2 + size
    return found
