"""Whole and faulty sound: clause 20."""

import math

from .. import media, payloads
from ..case import faulty, valid
from ..packing import patched
from ..recipes import block, frame, group, opened

TRACK = 3
PLACED, MOVES = 1, 2
BASE = {"time_base_numerator": 1, "time_base_denominator": 48000}
SILENCE = bytes.fromhex("f8fffe")  # of Opus: 20 ms, mono
DURATION = 960  # samples of a packet; a frame has 1920


def tracks(base=None, kind=payloads.AUDIO, **fields):
    return [
        (1, payloads.track(payloads.MESH, "mesh")),
        (TRACK, payloads.track(kind, "sound", **(BASE if base is None else base), **fields)),
    ]


def begun(config=None, base=None, fault=None):
    s = opened(*tracks(base))
    s.chunk("ACFG", payloads.audio() if config is None else config, track=TRACK, fault=fault)
    return s


def audio(s, time, payload, first=False, **chunk):
    s.chunk("AUDI", payload, TRACK, time, first, **chunk)


def one(name, title, config=None, *, base=None, duration=DURATION, position=None, clauses="20.1", **more):
    """Two frames with one chunk of sound each."""

    def make():
        s = begun(config, base)
        s.begin(0, 100)
        first = -(-1920 // duration)
        for time, at, count in (0, 0, first), (1, first, 2):
            frame(s, time)
            audio(s, time, payloads.sound(at * duration, [SILENCE] * count, position), time == 0)
        s.end()
        s.finish()
        return s

    valid(f"sound_{name}", title, clauses, make, **more)


def coded(name):
    """Real packets over two groups of five frames, with pre-roll in the second."""
    rate, channels, record, packets = media.sound(name)
    opus = name.startswith("opus")
    size, preroll = (960, 4) if opus else (1024, 2)
    record = payloads.opus_head(channels) if opus else record
    config = payloads.audio(
        record, "de", "opus" if opus else "mp4a", channels=channels, packet_duration=size, preroll=preroll
    )
    base = {"time_base_numerator": 1, "time_base_denominator": rate}

    def make():
        s = begun(config, base)
        sent = 0
        for start in 0, 5:
            s.begin(start, start + 5)
            end = (start + 5) * rate // 25
            count = min(-(-(end - sent * size) // size), len(packets) - sent)
            repeated = min(preroll, sent)
            for time in range(start, start + 5):
                frame(s, time)
                if time == start:
                    part = packets[sent - repeated : sent + count]
                    audio(s, time, payloads.sound((sent - repeated) * size, part, preroll=repeated), True)
                    sent += count
            s.end()
        s.finish()
        return s

    valid(
        f"sound_{name}",
        f"Packets of {name.replace('_', ' ')} in two groups.",
        "20.1 20.2",
        make,
        requirements=(9024,),
    )


def whole():
    for name in "opus_mono", "opus_stereo", "aac_44100", "aac_stereo":
        coded(name)
    for language in ("", "en", "zh-Hant-TW", "x-director"):
        label = language.lower().replace("-", "_") or "none"
        one(f"language_{label}", f"The language is {language!r}.", payloads.audio(language=language))
    one("preroll_zero", "No pre-roll is needed.", payloads.audio(preroll=0))
    one("placed", "Sound from a place.", payloads.audio(flags=PLACED, position=(1.0, -2.0, 0.5)))
    one(
        "moves",
        "Sound that moves: each chunk has a position.",
        payloads.audio(flags=PLACED | MOVES, position=(0.0, 0.0, 1.0)),
        position=(1.0, 2.0, 3.0),
        clauses="20.1 20.2",
    )
    for duration in 120, 480, 1920, 5760:
        one(
            f"opus_{duration}",
            f"Opus packets of {duration} samples.",
            payloads.audio(packet_duration=duration),
            duration=duration,
        )
    family = payloads.opus_head(6, family=1, table=bytes([4, 2, 0, 4, 1, 2, 3, 5]))
    one(
        "opus_six_channels", "Opus with six channels of mapping family 1.", payloads.audio(family, channels=6)
    )
    one(
        "opus_silent_channel",
        "Opus whose third channel is silent, in a record of version 15.",
        payloads.audio(
            payloads.opus_head(3, family=1, version=15, table=bytes([2, 1, 0, 1, 255])), channels=3
        ),
    )
    one(
        "opus_gain",
        "Opus with an output gain and another input rate.",
        payloads.audio(payloads.opus_head(gain=-256, rate=44100)),
    )
    valid("sound_aac_rates", "AAC tracks of every sampling frequency of the table.", "20.1", aac_rates)
    valid("sound_alone", "A stream of sound alone: no frames.", "20 11", sound_alone)
    valid("sound_two_tracks", "Two languages, and alternatives of one of them.", "5.2 20", alternatives)
    valid("sound_silence", "Groups without sound between groups with sound.", "20.2", pauses)
    valid("sound_one_chunk", "All packets of a group in one chunk.", "20.2", one_chunk)
    valid(
        "sound_to_end",
        "The last packet begins in the last sample before the end of its group.",
        "20.2",
        to_end,
    )


AAC_RATES = (96000, 88200, 64000, 48000, 44100, 32000, 24000, 22050, 16000, 12000, 11025, 8000, 7350)


def aac_rates():
    """An AudioSpecificConfig of two bytes: object type 2, index of the rate, one channel."""
    declared = [
        (i + 1, payloads.track(payloads.AUDIO, str(rate), time_base_numerator=1, time_base_denominator=rate))
        for i, rate in enumerate(AAC_RATES)
    ]
    s = opened(*declared)
    for i in range(len(AAC_RATES)):
        record = (2 << 11 | i << 7 | 1 << 3).to_bytes(2, "big")
        s.chunk("ACFG", payloads.audio(record, codec="mp4a", packet_duration=1024), track=i + 1)
    s.begin(0, 10)
    for i in range(len(AAC_RATES)):
        s.chunk("AUDI", payloads.sound(0, [bytes([i + 1])]), i + 1, 0, True)
    s.end()
    s.finish()
    return s


def sound_alone():
    s = opened((TRACK, payloads.track(payloads.AUDIO, "sound", **BASE)))
    s.chunk("ACFG", payloads.audio(), track=TRACK)
    for number in range(2):
        s.begin(number, number + 1)
        audio(s, number, payloads.sound(1920 * number, [SILENCE] * 2), True)
        s.end()
    s.finish()
    return s


def alternatives():
    s = opened(
        (1, payloads.track(payloads.AUDIO, "de", alternate_group=1, rank=0, bit_rate=64000, **BASE)),
        (2, payloads.track(payloads.AUDIO, "de low", alternate_group=1, rank=1, bit_rate=8000, **BASE)),
        (3, payloads.track(payloads.AUDIO, "en", **BASE)),
    )
    for track, language in (1, "de"), (2, "de"), (3, "en"):
        s.chunk("ACFG", payloads.audio(language=language), track=track)
    s.begin(0, 2)
    for time in 0, 1:
        for track in 2, 1, 3:
            s.chunk(
                "AUDI",
                payloads.sound(1920 * time, [SILENCE, SILENCE[:2] + bytes([track])]),
                track,
                time,
                time == 0,
            )
    s.end()
    s.finish()
    return s


def pauses():
    s = begun()
    for number in range(4):
        s.begin(number, number + 1)
        frame(s, number)
        if number % 2:
            audio(s, number, payloads.sound(1920 * number, [SILENCE]), True)
        s.end()
    s.finish()
    return s


def one_chunk():
    s = begun()
    s.begin(0, 10)
    frame(s, 0)
    audio(s, 0, payloads.sound(0, [SILENCE] * 20), True)
    frame(s, 9)
    s.end()
    s.finish()
    return s


def to_end():
    s = begun()
    s.begin(0, 1)
    frame(s, 0)
    audio(s, 0, payloads.sound(1919, [SILENCE]), True)
    s.end()
    s.finish()
    return s


def config_fault(name, title, issue, config=None, *, base=None, clauses="20.1", **fields):
    def make():
        s = begun(payloads.audio(**fields) if config is None else config, base, fault=issue)
        group(s, 0)
        block(s, *tracks())
        s.chunk("ACFG", payloads.audio(), track=TRACK)
        group(s, 2)
        s.finish()
        return s

    faulty(f"sound_{name}", title, clauses, make)


def config_faults():
    good = payloads.audio(language="en")
    config_fault("config_short", "An ACFG payload has 47 bytes.", 4301, good[:47])
    config_fault("config_cut", "The language lacks its last byte.", 4301, good[:-1])
    config_fault("config_flags", "A reserved flag of ACFG is set.", 4301, flags=4)
    config_fault("config_reserved", "The reserved field of ACFG is 1.", 4301, reserved=1)
    config_fault(
        "config_language",
        "The language is no UTF-8.",
        2104,
        payloads.audio(language=b"\x80"),
        clauses="2.2 20.1",
    )
    for name, fields in (
        ("channels_zero", {"channels": 0}),
        ("channels_nine", {"channels": 9}),
        ("duration_zero", {"packet_duration": 0}),
        ("duration_odd", {"packet_duration": 961}),
        ("duration_long", {"packet_duration": 5880}),
        ("moves_alone", {"flags": MOVES}),
        ("position_without_flag", {"position": (0.0, 1.0, 0.0)}),
        ("position_nan", {"flags": PLACED, "position": (0.0, math.nan, 0.0)}),
        ("position_infinite", {"flags": PLACED | MOVES, "position": (math.inf, 0.0, 0.0)}),
    ):
        config_fault(name, f"ACFG has {fields}.", 4303, **fields)
    rate, channels, record, _ = media.sound("aac_44100")
    aac = {"codec": "mp4a", "channels": channels, "packet_duration": 1024, "preroll": 2}
    aac_base = {"time_base_numerator": 1, "time_base_denominator": rate}
    config_fault(
        "aac_duration",
        "AAC packets of 960 samples.",
        4303,
        payloads.audio(record, **aac | {"packet_duration": 960}),
        base=aac_base,
    )
    head = payloads.opus_head()
    for name, title, bad in (
        ("opus_magic", "The record of Opus does not begin with OpusHead.", b"OpusTags" + head[8:]),
        ("opus_version", "The record of Opus has version 16.", payloads.opus_head(version=16)),
        ("opus_channels", "The record of Opus has two channels, ACFG one.", payloads.opus_head(2)),
        ("opus_short", "The record of Opus has 18 bytes.", head[:-1]),
        ("opus_long", "A byte follows the record of Opus.", head + b"\0"),
        (
            "opus_family",
            "The record of Opus has mapping family 2.",
            payloads.opus_head(4, family=2, table=bytes([4, 0, 0, 1, 2, 3])),
        ),
        (
            "opus_streams",
            "The record of Opus has more coupled streams than streams.",
            payloads.opus_head(3, family=1, table=bytes([1, 2, 0, 1, 2])),
        ),
        ("opus_table", "The record of Opus has mapping family 1 and no table.", payloads.opus_head(family=1)),
    ):
        config_fault(name, title, 4304, payloads.audio(bad))
    six = bytes([4, 2, 0, 4, 1, 2, 3, 33])
    config_fault(
        "opus_mapping",
        "A channel of Opus is decoded channel 33 of 6.",
        4304,
        payloads.audio(payloads.opus_head(6, family=1, table=six), channels=6),
    )
    config_fault("record_empty", "The record is empty.", 4304, payloads.audio(b""))
    config_fault(
        "opus_base",
        "The time base of an Opus track is 1/44100.",
        4304,
        base={"time_base_numerator": 1, "time_base_denominator": 44100},
    )
    config_fault("opus_base_none", "An Opus track has no time base of its own.", 4304, base={})
    config_fault(
        "aac_base", "The time base of an AAC track is not a sample.", 4304, payloads.audio(record, **aac)
    )
    config_fault(
        "aac_object",
        "The record of AAC is of the object type 1.",
        4304,
        payloads.audio(bytes([record[0] & 7 | 1 << 3]) + record[1:], **aac),
        base=aac_base,
    )
    config_fault(
        "aac_channels",
        "The record of AAC has another number of channels.",
        4304,
        payloads.audio(record, **aac | {"channels": 2}),
        base=aac_base,
    )
    config_fault(
        "aac_short", "The record of AAC has one byte.", 4304, payloads.audio(record[:1], **aac), base=aac_base
    )


def chunk_fault(
    name, title, issue, payload, *, config=None, before=True, time=3, start=2, end=10, first=False, more=None
):
    """The chunk follows a good one of two packets at time 2, in a group from 2 to 10."""

    def make():
        s = begun(config)
        s.begin(0, 2)
        frame(s, 0)
        s.end()
        s.begin(start, end)
        frame(s, 2)
        if before:
            place = (0.0, 0.0, 1.0) if config else None
            audio(s, 2, payloads.sound(2 * 1920, [SILENCE] * 2, place), True)
        if more:
            more(s)
        audio(s, time, payload, first or not before, fault=issue)
        frame(s, time + 1)
        s.end()
        s.begin(20, 22)
        frame(s, 20)
        audio(s, 20, payloads.sound(20 * 1920, [SILENCE], (0.0, 0.0, 0.0) if config else None), True)
        s.end()
        s.finish()
        return s

    faulty(f"sound_{name}", title, "20.2", make)


def chunk_faults():
    at = 3 * 1920
    good = payloads.sound(at, [SILENCE] * 2)
    chunk_fault("header", "An AUDI payload has 15 bytes.", 4305, good[:15])
    chunk_fault("cut", "The last packet lacks a byte.", 4305, good[:-1])
    chunk_fault("no_packets", "AUDI has no packet.", 4305, payloads.sound(at, []))
    chunk_fault("empty_packet", "A packet is empty.", 4305, payloads.sound(at, [SILENCE, b""]))
    chunk_fault(
        "count",
        "AUDI counts 2^32 - 1 packets.",
        4305,
        patched(good, "AUDI payload", "packet_count", 2**32 - 1),
    )
    chunk_fault(
        "all_preroll",
        "All packets are pre-roll.",
        4305,
        payloads.sound(at, [SILENCE] * 2, preroll=2),
        before=False,
    )
    moving = payloads.audio(flags=PLACED | MOVES)
    chunk_fault(
        "position",
        "The position of a chunk is not finite.",
        4305,
        payloads.sound(at, [SILENCE], (math.nan, 0.0, 0.0)),
        config=moving,
    )
    chunk_fault("no_position", "A chunk of sound that moves has no position.", 4305, good, config=moving)
    chunk_fault(
        "gap",
        "A chunk begins a sample after the end of the one before.",
        4306,
        payloads.sound(at + 1, [SILENCE]),
    )
    chunk_fault(
        "overlap",
        "A chunk begins a packet before the end of the one before.",
        4306,
        payloads.sound(at - DURATION, [SILENCE]),
    )
    chunk_fault(
        "early", "A chunk has a time after its first packet.", 4306, payloads.sound(at, [SILENCE]), time=4
    )
    chunk_fault(
        "beyond_group",
        "The last packet begins at the end of the group.",
        4306,
        payloads.sound(at, [SILENCE] * 15),
    )
    chunk_fault(
        "key_later",
        "A chunk that is not the first of its group has the key flag.",
        4306,
        good,
        first=True,
    )
    chunk_fault(
        "preroll_later",
        "A chunk that is not the first of its group has pre-roll.",
        4306,
        payloads.sound(at, [SILENCE] * 3, preroll=1),
    )
    chunk_fault(
        "preroll_short",
        "The first packet that is played is before the time of its chunk.",
        4306,
        payloads.sound(2 * 1920, [SILENCE] * 4, preroll=1),
        before=False,
        time=3,
    )
    faulty(
        "sound_codec_unknown",
        "The audio codec is unknown; the rest can be shown.",
        "20.1",
        faulty_codec,
        needs_check=True,
    )
    faulty(
        "sound_codec_case",
        "The audio codec is Opus instead of opus.",
        "20.1",
        lambda: faulty_codec("Opus"),
        needs_check=True,
    )
    faulty(
        "sound_start_extreme",
        "The start of a chunk is the greatest number.",
        "20.2",
        lambda: extreme(2**63 - 1),
    )
    faulty(
        "sound_start_least", "The start of a chunk is the least number.", "20.2", lambda: extreme(-(2**63))
    )


def faulty_codec(codec="flac"):
    s = opened(*tracks())
    s.chunk("ACFG", payloads.audio(codec=codec), track=TRACK, fault=4302)
    group(s, 0)
    s.finish()
    return s


def extreme(start):
    s = begun()
    s.begin(0, 2)
    frame(s, 0)
    audio(s, 0, payloads.sound(start, [SILENCE] * 2), True, fault=4306)
    frame(s, 1)
    s.end()
    s.finish()
    return s


whole()
config_faults()
chunk_faults()
