"""Tracks of timed payloads of other formats: clause 21."""

from .. import payloads
from ..case import faulty, valid
from ..recipes import frame, group, opened

TRACK = 6
CAPTIONS = b"WEBVTT\n\n00:00.000 --> 00:01.000\nThe ball is in.\n"


def tracks(kind=payloads.DATA, **fields):
    mesh = (1, payloads.track(payloads.MESH, "mesh"))
    return [mesh, (TRACK, payloads.track(kind, "captions", **fields))]


def begun(config=None, fault=None, **fields):
    s = opened(*tracks(**fields))
    s.chunk("DCFG", payloads.data() if config is None else config, TRACK, fault=fault)
    return s


def ended(s):
    s.finish()
    return s


def captions(**config):
    """At the first frame of each group, and between frames."""
    s = begun(payloads.data(**config))
    for start in 0, 4:
        s.begin(start, start + 4)
        frame(s, start)
        s.chunk("DATA", CAPTIONS + bytes([start]), TRACK, start, True)
        s.chunk("DATA", b"", TRACK, start + 1)
        frame(s, start + 2)
        s.end()
    return ended(s)


def splats():
    """Nothing but a data track shows the scene: its times are frames."""
    s = opened((TRACK, payloads.track(payloads.DATA, "splats", flags=1)))
    s.chunk("DCFG", payloads.data("model/gltf-binary", "KHR_gaussian_splatting", b"shared"), TRACK)
    for start in 0, 3:
        s.begin(start, start + 3)
        for time in range(start, start + 3):
            s.chunk("DATA", bytes([time]) * (100 + time), TRACK, time, True)
        s.end()
    return ended(s)


def rungs():
    """Alternatives of two sizes beside a mesh; a reader that does not choose takes rank 0."""
    data = [payloads.track(payloads.DATA, "", flags=1, alternate_group=1, rank=rank) for rank in range(2)]
    s = opened((1, payloads.track(payloads.MESH, "mesh")), (2, data[0]), (3, data[1]))
    for track in 2, 3:
        s.chunk("DCFG", payloads.data("application/octet-stream", "spz"), track)
    s.begin(0, 2)
    for time in 0, 1:
        frame(s, time)
        for track in 3, 2:
            s.chunk("DATA", bytes([track, time]), track, time, True)
    s.end()
    return ended(s)


def fault(name, title, issue, config, *, clauses="21.1", first=None, track=TRACK, more=None):
    def make():
        s = opened(*tracks())
        if first is not None:
            s.chunk("DCFG", first, TRACK)
        s.chunk("DCFG", config, track, fault=issue)
        group(s, 0)
        return ended(s)

    faulty(f"data_{name}", title, clauses, make)


def kind():
    s = begun()
    group(s, 0)
    s.begin(2, 4)
    frame(s, 2)
    s.chunk("DATA", b"x", 1, 3, True, fault=1211)
    s.end()
    group(s, 4)
    return ended(s)


def not_key():
    s = begun()
    group(s, 0)
    s.begin(2, 4)
    frame(s, 2)
    s.chunk("DATA", b"x", TRACK, 3, fault=1212)
    s.end()
    group(s, 4)
    return ended(s)


valid("data_captions", "Captions beside meshes.", "21", captions)
valid("data_record", "A codec and a record.", "21.1", lambda: captions(codec="wvtt", record=b"\0\1\2"))
valid("data_frames", "Splats alone: the times of the track are frames.", "11 21", splats)
valid("data_rungs", "Data in two rungs.", "5.2 21", rungs)
good = payloads.data("text/vtt", "wvtt", b"rec")
fault("config_short", "A DCFG payload has 7 bytes.", 4401, good[:7])
fault("config_cut", "The codec lacks its last byte.", 4401, good[:-1])
fault(
    "config_record", "The record is said to have 2^32 - 1 bytes.", 4401, payloads.data(record_size=2**32 - 1)
)
fault("config_empty", "The media type is empty.", 4401, payloads.data(""))
fault("config_text", "The media type is no UTF-8.", 2104, payloads.data(b"text/\xff"), clauses="2.2 21.1")
fault("config_twice", "A track has two DCFG.", 2206, good, first=good)
fault("config_of_mesh", "DCFG names a mesh track.", 2206, good, first=good, track=1)
faulty("data_of_mesh_track", "DATA belongs to a mesh track.", "6.2", kind)
faulty("data_not_key", "The first DATA of a group is no key.", "6.2", not_key)
