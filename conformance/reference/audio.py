"""Sound, and alternatives of one track: clauses 5.2, 20.1 and 20.2 of spec/fvv.md."""

import struct
from fractions import Fraction

from .container import Part, Stream, chunks, crc32c, demand, structure
from .mesh import raw_parts
from .tiny import TETRAHEDRON

MESH, AUDIO = 1, 7
PLACED, MOVES = 1, 2
AAC_RATES = (96000, 88200, 64000, 48000, 44100, 32000, 24000, 22050, 16000, 12000, 11025, 8000, 7350)


def track(payload):
    """Kind, time base or None, alternate group, rank, bit rate, size and name of a TRAK payload."""
    kind, flags, name_size, numerator, denominator, group, rank, rate, size = struct.unpack_from(
        "<BBHIIHHII", payload
    )
    demand(flags < 2 and len(payload) == 24 + name_size, 2101, "size or flags")
    demand((numerator == 0) == (denominator == 0), 2105, "half a time base")
    demand(numerator == 0 or kind > 5 and kind != 8, 2105, "a time base of its own")
    demand(group or not rank, 2106, "a rank without an alternate group")
    base = Fraction(numerator, denominator) if denominator else None
    return kind, base, group, rank, rate, size, payload[24:].decode()


def configuration(payload):
    """Codec, channels, flags, packet duration, pre-roll, position, record and language of an ACFG payload."""
    codec, channels, flags, language, record, duration, preroll, reserved = struct.unpack_from(
        "<4sBBHIIII", payload
    )
    position = struct.unpack_from("<3d", payload, 24)
    demand(
        len(payload) == 48 + record + language and reserved == 0 and flags < 4, 4301, "size or reserved bits"
    )
    demand(codec in (b"opus", b"mp4a"), 4302, "codec")
    demand(
        0 < channels <= 8 and flags != MOVES and (flags & PLACED or not any(position)),
        4303,
        "channels or place",
    )
    body = payload[48 : 48 + record]
    if codec == b"opus":
        demand(body[:9] == b"OpusHead\1" and body[9] == channels, 4304, "identification header")
        demand(duration % 120 == 0 and 120 <= duration <= 5760, 4303, "packet duration")
        rate = 48000
    else:
        index = struct.unpack_from(">H", body)[0] >> 7 & 15
        demand(body[0] >> 3 == 2 and index < len(AAC_RATES), 4304, "AudioSpecificConfig")
        demand(duration == 1024, 4303, "packet duration")
        rate = AAC_RATES[index]
    return codec, rate, flags, duration, preroll, position, payload[48 + record :].decode()


def packets(payload, flags):
    """Start, number of pre-roll packets, position or None, and the packets of an AUDI payload."""
    start, count, preroll = struct.unpack_from("<qII", payload)
    at, position = 16, None
    if flags & MOVES:
        position, at = struct.unpack_from("<3d", payload, at), at + 24
    sizes = struct.unpack_from(f"<{count}H", payload, at)
    at += 2 * count
    demand(preroll < count and all(sizes) and at + sum(sizes) == len(payload), 4305, "sizes")
    found = []
    for size in sizes:
        found.append(payload[at : at + size])
        at += size
    return start, preroll, position, found


def check_alternates(tracks):
    for one, (kind, _, group, rank, *_) in tracks.items():
        for other, (other_kind, _, other_group, other_rank, *_) in tracks.items():
            if group and one < other and group == other_group:
                demand(kind == other_kind and rank != other_rank, 2106, f"tracks {one} and {other}")


def listing(stream):
    """A line for each track, audio configuration and chunk of sound. Frames are counted as clause 11 says."""
    tracks, sounds, ends, times, tick, group_end = {}, {}, {}, set(), None, 0
    for chunk in chunks(stream):
        demand(chunk.kind != b"TRAK" or not sounds, 1201, "a track after other chunks")
        if chunk.kind == b"SCEN":
            tick, tracks, sounds = Fraction(*struct.unpack_from("<II", chunk.payload)), {}, {}
        elif chunk.kind == b"TRAK":
            tracks[chunk.track] = track(chunk.payload)
            kind, base, group, rank, rate, size, name = tracks[chunk.track]
            yield f"track {chunk.track} kind {kind} base {base} group {group} rank {rank} rate {rate} size {size} {name}"
        elif chunk.kind == b"ACFG":
            sounds[chunk.track] = configuration(chunk.payload)
            codec, rate, flags, duration, preroll, position, language = sounds[chunk.track]
            demand(tracks[chunk.track][:2] == (AUDIO, Fraction(1, rate)), 4304, "time base")
            yield f"audio {chunk.track} {codec.decode()} {rate} {flags} {duration} {preroll} {position} {language}"
        elif chunk.kind == b"GRUP":
            check_alternates(tracks)
            ends, group_end = {}, struct.unpack_from("<q", chunk.payload, 16)[0]
        elif chunk.kind == b"AUDI":
            _, rate, flags, duration, *_ = sounds[chunk.track]
            start, preroll, position, found = packets(chunk.payload, flags)
            demand(ends.get(chunk.track, start) == start, 4306, "start")
            demand(not preroll or chunk.track not in ends, 4306, "pre-roll")
            demand(chunk.time * tick <= Fraction(start + preroll * duration, rate), 4306, "time")
            demand(
                Fraction(start + (len(found) - 1) * duration, rate) < group_end * tick, 4306, "last packet"
            )
            ends[chunk.track] = start + len(found) * duration
            crc = crc32c(b"".join(found))
            yield f"sound {chunk.track} time {chunk.time} start {start} {preroll} of {len(found)} {position} {crc:08x}"
        elif chunk.kind in (b"MESH", b"VPKT"):
            times.add(chunk.time)
    yield f"frames {len(times)}"


SILENCE = bytes.fromhex("f8fffe")  # a packet of Opus: 20 ms, mono, CELT
DURATION = 960
PREROLL = 4


def opus_head(channels):
    body = struct.pack("<8sBBHIhB", b"OpusHead", 1, channels, 312, 48000, 0, 0)
    return Part(body, "record", "identification header of Opus")


def audio_stream():
    """Two groups of three frames: a mesh in two ranks, and two sounds of 20 ms packets, one of which moves."""
    stream = Stream()
    stream.scene()
    for rank, size in enumerate((4, 1)):
        stream.track(
            1 + rank, MESH, "mesh", alternate_group=1, rank=rank, bit_rate=8000 >> rank, nominal_size=size
        )
    for identifier, name in (3, "clap"), (4, "steps"):
        stream.track(
            identifier, AUDIO, name, time_base_numerator=1, time_base_denominator=48000, bit_rate=1200
        )
    for identifier in 3, 4:
        values = {"codec": b"opus", "channels": 1, "packet_duration": DURATION, "preroll": PREROLL}
        values |= {"record_size": 19, "language_size": 5}
        if identifier == 4:
            values |= {"flags": PLACED | MOVES, "position": (1.0, 0.0, 2.0)}
        parts = structure("ACFG payload", values)
        stream.chunk("ACFG", [*parts, opus_head(1), Part(b"en-GB", "language", "")], track=identifier)
    for group in range(2):
        stream.begin_group(3 * group, 3 * group + 3)
        for frame in range(3 * group, 3 * group + 3):
            for identifier in 2, 1:
                stream.chunk("MESH", raw_parts(TETRAHEDRON), track=identifier, time=frame, key=True)
            for identifier in 3, 4:
                sound_chunk(stream, identifier, frame, frame == 3 * group)
        stream.end_group()
    return stream.finish()


def sound_chunk(stream, identifier, frame, first):
    """Two packets for a frame of 40 ms; the second group repeats four before its own."""
    preroll = PREROLL if first and frame else 0
    count = 2 + preroll
    values = {"start": (2 * frame - preroll) * DURATION, "packet_count": count, "preroll_count": preroll}
    parts = structure("AUDI payload", values)
    if identifier == 4:
        parts.append(Part(struct.pack("<3d", 1.0, 0.25 * frame, 2.0), "position", ""))
    parts.append(Part(struct.pack(f"<{count}H", *[len(SILENCE)] * count), "sizes", ""))
    parts += [Part(SILENCE, "packet", "Opus") for _ in range(count)]
    stream.chunk("AUDI", parts, track=identifier, time=frame, key=first)
