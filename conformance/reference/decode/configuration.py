"""A configuration block: clauses 5, 9.2, 10.1, 10.2, 17.5 and 20.1 of spec/fvv.md."""

import math
import struct
from fractions import Fraction

from .. import texturing
from ..container import Broken, crc32c, demand
from .lens import Camera
from .records import RECORDS, Video

MESH, VIDEO, CALIBRATION, VISIBILITY, ENVIRONMENT, DATA, AUDIO, COLOURS = range(1, 9)
WITHOUT_TIME_BASE = (MESH, VIDEO, CALIBRATION, VISIBILITY, ENVIRONMENT, COLOURS)
NAME_LIMIT, CAMERAS, TRACKS = 1 << 20, 1024, 256
PLACED, MOVES = 1, 2
FRAMES = 1  # a flag of TRAK
AAC_RATES = (96000, 88200, 64000, 48000, 44100, 32000, 24000, 22050, 16000, 12000, 11025, 8000, 7350)


def text(data):
    """Clause 2.2."""
    demand(len(data) <= NAME_LIMIT, 7001, f"a text of {len(data)} bytes")
    try:
        demand("\0" not in data.decode("utf-8"), 2104, "U+0000 in a text")
    except UnicodeDecodeError as error:
        raise Broken(2104, "no UTF-8") from error


def lattice_is_valid(origin, step):
    return 0 < step < math.inf and all(math.isfinite(abs(o) + step * 2.0**28) for o in origin)


class TooMany(Broken):
    """A block is beyond a limit of the reader, which stops."""


class Scene:
    def __init__(self, payload):
        demand(len(payload) == 56, 2001, "size")
        numerator, denominator, duration = struct.unpack_from("<IIq", payload)
        *self.origin, self.step = struct.unpack_from("<4d", payload, 16)
        demand(payload[49] < 2 and not any(payload[50:]), 2001, "flags or reserved bytes")
        demand(numerator > 0 and denominator > 0 and duration > 0, 2002, "time base or frame duration")
        demand(lattice_is_valid(self.origin, self.step), 2003, "lattice")
        demand(payload[48] <= 6, 2004, f"up axis {payload[48]}")
        self.tick = Fraction(numerator, denominator)
        self.time_base, self.lattice = payload[:8], payload[16:48]


class Track:
    def __init__(self, payload):
        demand(len(payload) >= 24, 2101, "size")
        self.kind, self.flags, name_size, numerator, denominator, self.group, self.rank = struct.unpack_from(
            "<BBHIIHH", payload
        )
        demand(self.flags <= FRAMES and len(payload) == 24 + name_size, 2101, "size or flags")
        demand(self.kind > 0, 2103, "kind 0")
        decided = {kind: FRAMES * (kind in (MESH, VIDEO)) for kind in WITHOUT_TIME_BASE + (AUDIO,)}
        demand(
            self.flags == decided.get(self.kind, self.flags), 2107, f"flags of a track of kind {self.kind}"
        )
        demand((numerator == 0) == (denominator == 0), 2105, "half a time base")
        demand(not numerator or self.kind not in WITHOUT_TIME_BASE, 2105, "a time base of its own")
        demand(self.group or not self.rank, 2106, "a rank without an alternate group")
        text(payload[24:])
        self.base = Fraction(numerator, denominator) if numerator else None


class Tile:
    """camera, source and destination of an entry."""

    def __init__(self, entry):
        self.camera, flags, *numbers, reserved = struct.unpack("<HH8HI", entry)
        demand(flags == 0 and reserved == 0, 4101, "flags or reserved bytes")
        self.source, self.destination = numbers[:4], numbers[4:]

    def row(self):
        return [self.camera, *self.source, *self.destination]


def overlap(a, b):
    return all(a[i] < b[i] + b[i + 2] and b[i] < a[i] + a[i + 2] for i in (0, 1))


def tiles(payload):
    demand(len(payload) >= 8, 4101, "size")
    count, reserved = struct.unpack_from("<II", payload)
    demand(count > 0 and len(payload) == 8 + 24 * count, 4101, "size")
    demand(count <= CAMERAS, 7001, f"{count} tiles")
    demand(reserved == 0, 4101, "reserved bytes")
    layout = [Tile(payload[at : at + 24]) for at in range(8, len(payload), 24)]
    for tile in layout:
        demand(all(tile.source[2:]) and all(tile.destination[2:]), 4102, "an empty rectangle")
    demand(not any(c % 16 for tile in layout for c in tile.destination[:2]), 4102, "an unaligned destination")
    demand(len({tile.camera for tile in layout}) == len(layout), 4103, "two tiles of a camera")
    for i, tile in enumerate(layout):
        for other in layout[:i]:
            demand(not overlap(tile.destination, other.destination), 4103, "destinations overlap")
    return layout


def check_places(layout, video, cameras):
    """FVV-2203 and 4102 of a layout of a configuration or a group. cameras: by identifier."""
    for tile in layout:
        demand(tile.camera in cameras, 2203, f"camera {tile.camera} of a tile")
    for tile in layout:
        for (x, y, width, height), whole in (tile.source, cameras[tile.camera]), (tile.destination, video):
            demand(x + width <= whole.width and y + height <= whole.height, 4102, "a rectangle outside")


class Bits:
    def __init__(self, data):
        self.bits, self.left = int.from_bytes(data, "big"), 8 * len(data)

    def take(self, count):
        demand(count <= self.left, 4304, "the record is cut")
        self.left -= count
        return self.bits >> self.left & (1 << count) - 1


def aac_record(record):
    """Samples per second and channels of an AudioSpecificConfig of AAC-LC."""
    bits = Bits(record)
    demand(bits.take(5) == 2, 4304, "no AAC-LC")
    index = bits.take(4)
    demand(index < len(AAC_RATES), 4304, "sampling frequency")
    rate = AAC_RATES[index]
    channels = bits.take(4)
    demand(0 < channels < 8, 4304, "channel configuration")
    demand(bits.take(1) == 0, 4304, "frames of 960 samples")
    return rate, 8 if channels == 7 else channels


def opus_record(record):
    demand(len(record) >= 19 and record[:8] == b"OpusHead" and record[8] < 16, 4304, "identification header")
    channels, family = record[9], record[18]
    demand(channels > 0, 4304, "no channels")
    if family == 0:
        demand(channels <= 2 and len(record) == 19, 4304, "mapping family 0")
    else:
        demand(family == 1 and len(record) == 21 + channels, 4304, "channel mapping table")
        streams, coupled = record[19:21]
        demand(streams > 0 and coupled <= streams and streams + coupled <= 255, 4304, "streams")
        demand(all(c == 255 or c < streams + coupled for c in record[21:]), 4304, "channel mapping")
    return 48000, channels


class Audio:
    def __init__(self, payload, track):
        demand(len(payload) >= 48, 4301, "size")
        self.codec, channels, self.flags, language, record, self.duration, _, reserved = struct.unpack_from(
            "<4sBBHIIII", payload
        )
        position = struct.unpack_from("<3d", payload, 24)
        demand(len(payload) >= 48 + record + language, 4301, "size")
        demand(reserved == 0 and self.flags < 4, 4301, "reserved bits")
        text(payload[48 + record : 48 + record + language])
        self.known = self.codec in (b"opus", b"mp4a")
        if not self.known:
            return
        demand(1 <= channels <= 8 and self.duration > 0, 4303, "channels or packet duration")
        demand(self.flags != MOVES and all(map(math.isfinite, position)), 4303, "flags or position")
        demand(self.flags & PLACED or not any(position), 4303, "a position without the flag")
        opus = self.codec == b"opus"
        valid = self.duration % 120 == 0 and self.duration <= 5760 if opus else self.duration == 1024
        demand(valid, 4303, f"packets of {self.duration} samples")
        rate, found = (opus_record if opus else aac_record)(payload[48 : 48 + record])
        demand(found == channels, 4304, f"{found} channels in the record")
        demand(track.base == Fraction(1, rate), 4304, "time base of the track")
        self.rate = rate


class Data:
    """Clause 21.1."""

    def __init__(self, payload):
        demand(len(payload) >= 8, 4401, "size")
        *texts, record = struct.unpack_from("<HHI", payload)
        demand(len(payload) >= 8 + record + sum(texts), 4401, "size")
        demand(max(texts) <= NAME_LIMIT, 7001, "a text")
        demand(texts[0] > 0, 4401, "no media type")
        at = 8 + record
        for size in texts:
            text(payload[at : at + size])
            at += size


class Block:
    """A configuration block, chunk by chunk. valid: no rule is broken so far that a whole block needs; complete: nothing was lost;
    names: TRAK is over; stopped: tracks that a reader ignores (clause 5)."""

    def __init__(self, offset):
        self.offset, self.covered, self.valid, self.complete, self.names = offset, [], True, True, False
        self.scene, self.texturing, self.textured = None, None, False
        self.tracks, self.cameras, self.videos, self.layouts, self.audios = {}, {}, {}, {}, {}
        self.datas = {}
        self.layout_offsets, self.at = {}, offset
        self.stopped = set()

    def digest(self):
        return crc32c(b"".join(self.covered))

    def add(self, chunk, first):
        """Reads a chunk. first: the scene of the stream, or None."""
        self.covered.append(chunk.covered)
        name = chunk.kind.decode("ascii", "replace")
        if hasattr(self, "_" + name):
            getattr(self, "_" + name)(chunk, first)

    def _SCEN(self, chunk, first):
        self.scene = Scene(chunk.payload)
        if first:
            demand(self.scene.time_base == first.time_base, 2002, "another time base than before")
            demand(self.scene.lattice == first.lattice, 2003, "another lattice than before")

    def _room(self, table, most):
        if len(table) >= most:
            raise TooMany(7001, f"more than {most} of one kind")

    def _TRAK(self, chunk, first):
        track = Track(chunk.payload)
        demand(chunk.track not in self.tracks, 2102, f"track {chunk.track} twice")
        self._room(self.tracks, TRACKS)
        self.tracks[chunk.track] = track

    def _META(self, chunk, first):
        text(chunk.payload)

    def _CAMR(self, chunk, first):
        camera = Camera(chunk.payload, text)
        self._room(self.cameras, CAMERAS)
        demand(camera.id not in self.cameras, 2203, f"camera {camera.id} twice")
        self.cameras[camera.id] = camera

    def _declared(self, chunk, kind, issue, there):
        track = self.tracks.get(chunk.track)
        demand(track and track.kind == kind and chunk.track not in there, issue, f"track {chunk.track}")
        return track

    def _VCFG(self, chunk, first):
        self._declared(chunk, VIDEO, 2201, self.videos)
        video = self.videos[chunk.track] = Video(chunk.payload, text)
        if not video.known:
            self.stopped.add(chunk.track)
            raise Broken(4002, f"codec {video.codec} that shows {video.shows}")
        RECORDS[video.codec](video.record, video.string, video.depth)

    def _TILE(self, chunk, first):
        self._declared(chunk, VIDEO, 2201, self.layouts)
        self.layout_offsets[chunk.track] = chunk.offset
        self.layouts[chunk.track] = tiles(chunk.payload)

    def _ACFG(self, chunk, first):
        track = self._declared(chunk, AUDIO, 2205, self.audios)
        self.audios[chunk.track] = None
        self.stopped.add(chunk.track)
        audio = Audio(chunk.payload, track)
        demand(audio.known, 4302, f"codec {audio.codec}")
        self.audios[chunk.track] = audio
        self.stopped.remove(chunk.track)

    def _DCFG(self, chunk, first):
        self._declared(chunk, DATA, 2206, self.datas)
        self.datas[chunk.track] = None
        self.stopped.add(chunk.track)
        self.datas[chunk.track] = Data(chunk.payload)
        self.stopped.remove(chunk.track)

    def _TEXR(self, chunk, first):
        demand(not self.textured, 6101, "a second TEXR")
        self.textured = True
        self.texturing = texturing.decode(chunk.payload)

    def finish(self):
        """The rules about the whole block. What is missing is at SCEN, the rest at the TILE; `at` says where."""
        self.at = self.offset
        ranks = {}
        for identifier, track in self.tracks.items():
            if track.group:
                kind, taken = ranks.setdefault(track.group, (track.kind, set()))
                demand(kind == track.kind and track.rank not in taken, 2106, f"track {identifier}")
                taken.add(track.rank)
        for group, (_, taken) in ranks.items():
            demand(0 in taken, 2106, f"alternate group {group} without rank 0")
        for identifier, track in self.tracks.items():
            demand(track.kind != VIDEO or identifier in self.videos, 2202, f"track {identifier} without VCFG")
        for identifier, video in self.videos.items():
            if identifier not in self.stopped:
                demand(video.tiles == (identifier in self.layouts), 2202, f"TILE of track {identifier}")
        moving = any(camera.moves for camera in self.cameras.values())
        count = sum(track.kind == CALIBRATION for track in self.tracks.values())
        demand(count == moving, 2204, f"{count} calibration tracks")
        for identifier, video in self.videos.items():
            if identifier in self.layouts and identifier not in self.stopped:
                self.at = self.layout_offsets[identifier]
                check_places(self.layouts[identifier], video, self.cameras)

    def silent(self):
        """Stops audio tracks without ACFG and data tracks without DCFG; the block stays valid. The issue, or None."""
        issue = None
        for number, kind, there in (2206, DATA, self.datas), (2205, AUDIO, self.audios):
            found = {i for i, track in self.tracks.items() if track.kind == kind and i not in there}
            self.stopped |= found
            issue = number if found else issue
        return issue

    def rank(self, track):
        return self.tracks[track].rank
