"""One group: its table and chain (clause 6), its tracks, and its frames (clauses 7.3 and 11 of spec/fvv.md)."""

import hashlib
import struct

import numpy

from .. import calibration, texturing, visibility
from ..container import FLAGS, Broken, crc32c, demand, uleb128, zigzag
from . import configuration as kinds
from . import meshes, sound, surface
from .environment import Environment
from .lens import check_camera
from .samples import check_sample

KEY = FLAGS["key"]
CHUNK_LIMIT, ROW_LIMIT = 1 << 20, 1024
DEFAULTS = texturing.Texturing()
KIND_OF = {
    b"MESH": kinds.MESH,
    b"CALB": kinds.CALIBRATION,
    b"VPKT": kinds.VIDEO,
    b"TILE": kinds.VIDEO,
    b"VISI": kinds.VISIBILITY,
    b"COLR": kinds.COLOURS,
    b"BACK": kinds.ENVIRONMENT,
    b"AUDI": kinds.AUDIO,
    b"DATA": kinds.DATA,
}


def sha256(data):
    return hashlib.sha256(data).hexdigest()


class Frame:
    """What is known of one time of a group. good: nothing in it is invalid or lost."""

    def __init__(self):
        self.arrays, self.good = {}, True


class Group:
    """chunk() takes its chunks in order; frames() has those that are whole. block: None if it is not known or not valid."""

    def __init__(self, chunk, block):
        self.sequence, self.digest, self.start, self.end = struct.unpack("<IIqq", chunk.payload)
        self.offset, self.block, self.intact, self.ended = chunk.offset, block, True, False
        self.until = None  # offset of what follows GEND
        self.covered, self.rows, self.table, self.time = [chunk.covered], {}, bytearray(), self.start
        self.times, self.frame_times, self.whole_before = set(), set(), None
        self.keys, self.samples, self.own_tiles = set(), {}, {}
        self.frames, self.sounds, self.environments = {}, [], {}
        self.tracks, self.mesh_times, self.key_times = {}, {}, {}
        self.colours, self.surfaces, self.calibration_lost = {}, {}, False
        self.coloured_patches = set()  # mesh track and time
        self.invalid = (
            set()
        )  # tracks of which a chunk was invalid, up to the next with the key flag: FVV-9009
        cameras = block.cameras.values() if block else ()
        self.static = {camera.id: camera.numbers for camera in cameras if not camera.moves}
        self.lenses = {camera.id: camera.lens for camera in cameras if camera.moves}
        self.calibrated, self.calibration_time = dict(self.static), None

    def damage(self):
        """Something before this place is lost or invalid: clause 7.4."""
        self.intact = False

    # Container

    def place(self, chunk):
        """FVV-1208 to 1212 and 4104, in the order of clause 2.5."""
        kind, known = chunk.kind, chunk.kind in KIND_OF
        demand(len(self.covered) < CHUNK_LIMIT, 7001, "too many chunks in a group")
        row = kind, chunk.track, chunk.flags
        demand(len(self.rows) < ROW_LIMIT or row in self.rows, 7001, "too many rows of a table")
        demand(self.start <= chunk.time < self.end, 1208, f"time {chunk.time}")
        demand(chunk.time >= self.time, 1209, f"time {chunk.time} after {self.time}")
        if not known:
            return
        demand((kind, chunk.track, chunk.time) not in self.times, 1209, "a second chunk of one time")
        if self.block is None:
            return
        track = self.block.tracks.get(chunk.track)
        demand(track, 1210, f"track {chunk.track}")
        demand(track.kind == KIND_OF[kind], 1211, f"track {chunk.track} of kind {track.kind}")
        if kind == b"TILE":
            taken = chunk.track in self.own_tiles or chunk.track in self.samples
            demand(not taken, 4104, "a second layout, or one after a sample")
        else:
            if kind == b"VPKT" and chunk.track in self.own_tiles and chunk.track not in self.samples:
                demand(self.own_tiles[chunk.track][0] == chunk.time, 4104, "a layout of another time")
            demand(chunk.flags & KEY or chunk.track in self.keys, 1212, "first chunk of its track")

    def take(self, chunk):
        """Counts an intact chunk, whether it obeys the rules or not."""
        self.covered.append(chunk.covered)
        row = self.rows.setdefault((chunk.kind, chunk.track, chunk.flags), len(self.rows))
        difference = (chunk.time - self.time + 2**63) % 2**64 - 2**63
        self.table += uleb128(row) + uleb128(chunk.size) + uleb128(zigzag(difference) % 2**64)
        self.time = chunk.time
        self.times.add((chunk.kind, chunk.track, chunk.time))
        if self.makes_frame(chunk) and self.intact:
            self.frame_times.add(chunk.time)
        if chunk.kind in KIND_OF and chunk.kind != b"TILE":
            self.keys.add(chunk.track)
        if chunk.kind == b"VPKT":
            self.samples.setdefault(chunk.track, chunk.time)
        if self.intact:
            self.whole_before = chunk.time

    def makes_frame(self, chunk):
        """Clause 11. Where the tracks are not known, the types say it."""
        if chunk.kind in (b"MESH", b"VPKT") or self.block is None:
            return chunk.kind in (b"MESH", b"VPKT")
        track = self.block.tracks.get(chunk.track)
        data = chunk.kind == b"DATA" and track and track.kind == kinds.DATA
        foreign = chunk.kind not in KIND_OF and track and track.kind not in KIND_OF.values()
        return bool((data or foreign) and track.flags & kinds.FRAMES)

    def end_payload(self):
        """The one correct payload of GEND."""
        rows = b"".join(struct.pack("<4sHBx", *row) for row in self.rows)
        counts = len(self.covered), crc32c(b"".join(self.covered)), len(self.frame_times), len(self.rows)
        return struct.pack("<6I", self.sequence, *counts, len(self.table)) + rows + bytes(self.table)

    def finish(self, chunk):
        """FVV-1213 and 1214. The group is whole unless this fails."""
        expected, payload = self.end_payload(), chunk.payload
        demand(len(payload) >= 24, 1213, "size")
        if self.block is None:  # nor is the number of frames
            expected = expected[:12] + payload[12:16] + expected[16:]
        demand(payload[:16] == expected[:16] and chunk.time == self.end, 1213, "sums of the group")
        demand(payload == expected, 1214, "table of the group")
        self.ended = True

    # Content

    def mesh_at(self, track, time):
        return self.mesh_times.get(track) == time

    def key_at(self, track, time):
        return self.mesh_at(track, time) and self.key_times.get(track) == time

    def mesh_of(self, track):
        sequence = self.tracks[b"MESH", track].sequence
        return sequence.mesh if sequence else None

    def described(self, track, time):
        """What COLR describes: a key mesh, or the patch of a frame after it."""
        return self.mesh_of(track) if self.key_at(track, time) else self.tracks[b"MESH", track].sequence.patch

    def surface(self, mesh):
        if id(mesh.faces) not in self.surfaces:
            faces = [tuple(face) for face in mesh.faces.tolist()]
            self.surfaces[id(mesh.faces)] = visibility.Surface(len(mesh.positions), faces), mesh.faces
        return self.surfaces[id(mesh.faces)][0]

    def frame(self, time):
        return self.frames.setdefault(time, Frame())

    def spoil(self, time):
        self.frame(time).good = False

    def state(self, chunk, make):
        name = chunk.kind, chunk.track
        if name not in self.tracks:
            self.tracks[name] = make()
        return self.tracks[name]

    def lose(self, chunk):
        """A chunk is invalid: its frame is not good, if it is part of one, and what depends on it is lost."""
        if chunk.kind not in (b"AUDI", b"BACK"):
            self.spoil(chunk.time)
        state = self.tracks.get((chunk.kind, chunk.track))
        if chunk.kind == b"CALB":
            self.calibration_lost = True
            self.tracks.pop((chunk.kind, chunk.track), None)
        elif chunk.kind == b"COLR":
            for track in self.coloured(chunk.payload):
                there = self.key_at(track, chunk.time) or not self.mesh_at(track, chunk.time)
                if track in self.colours or there:
                    self.colours[track] = "lost"
        elif hasattr(state, "lose"):
            state.lose()

    def coloured(self, payload):
        """The mesh track that an invalid COLR names; if it names none, all of them."""
        meshes_of_block = [i for i, track in self.block.tracks.items() if track.kind == kinds.MESH]
        named = struct.unpack_from("<H", payload, 2) if len(payload) >= 4 else ()
        return [i for i in meshes_of_block if i in named] or meshes_of_block

    def content(self, chunk):
        """Decodes the payload of a chunk. Broken: it is invalid."""
        if self.block is None or chunk.track in self.block.stopped:
            return
        track = self.block.tracks.get(chunk.track)
        reader = getattr(self, "_" + chunk.kind.decode("ascii", "replace"), None)
        if not reader or track is None or track.kind != KIND_OF[chunk.kind]:
            return
        if not self.intact and chunk.kind not in (b"MESH", b"VPKT"):
            return
        key = bool(chunk.flags & KEY)
        if key and chunk.kind != b"TILE":
            self.invalid.discard(chunk.track)
        try:
            reader(chunk, key, track.rank == 0)
        except Broken:
            self.invalid.add(chunk.track)
            self.lose(chunk)
            raise

    def _MESH(self, chunk, key, shown):
        track = self.state(chunk, meshes.Track)
        if not self.intact:
            track.sequence = None
        self.mesh_times[chunk.track] = chunk.time
        if key:
            self.key_times[chunk.track] = chunk.time
            self.colours.pop(chunk.track, None)
        if not track.add(chunk, key):
            self.spoil(chunk.time)
            return
        if not shown:
            return
        mesh, scene, arrays = track.sequence.mesh, self.block.scene, self.frame(chunk.time).arrays
        name = f"mesh/{chunk.track}/"
        arrays[name + "lattice"] = mesh.positions.astype("<i4").tobytes()
        arrays[name + "faces"] = mesh.faces.astype("<u4").tobytes()
        arrays[name + "positions"] = mesh.metres(scene.origin, scene.step).tobytes()
        if mesh.texture is not None:
            arrays[name + "uvs"] = mesh.coordinates().tobytes()
        if mesh.normals is not None:
            arrays[name + "normals"] = mesh.directions().tobytes()
        self._keep_colours(chunk.track)
        self._colour(chunk.track, chunk.time)

    def _colour(self, track, time):
        colours = self.colours.get(track)
        if isinstance(colours, numpy.ndarray):
            self.frame(time).arrays[f"mesh/{track}/colours"] = colours.tobytes()
        elif colours is not None:
            self.spoil(time)

    def _keep_colours(self, track):
        """Of the vertices that a patched frame keeps; those of its patch have `unseen` of TEXR until its own come."""
        sequence, colours = self.tracks[b"MESH", track].sequence, self.colours.get(track)
        if sequence.kept is None or not isinstance(colours, numpy.ndarray):
            return
        unseen = numpy.array((self.block.texturing or DEFAULTS).unseen, numpy.uint8)
        count = len(sequence.mesh.positions) - len(sequence.kept)
        self.colours[track] = numpy.concatenate([colours[sequence.kept], numpy.tile(unseen, (count, 1))])

    def _colour_patch(self, track, time, rows):
        colours = self.colours.get(track)
        if isinstance(colours, numpy.ndarray) and (track, time) not in self.coloured_patches:
            self.coloured_patches.add((track, time))
            colours[len(colours) - len(rows) :] = rows

    def _COLR(self, chunk, key, shown):
        track, colours = surface.colours_of(chunk, key, self)
        if colours is not None and not self.key_at(track, chunk.time):
            self._colour_patch(track, chunk.time, colours)
        elif track not in self.colours and shown:
            self.colours[track] = "lost" if colours is None else colours
        if shown and track in self.colours and self.mesh_of(track) is not None:
            self._colour(track, chunk.time)

    def _VISI(self, chunk, key, shown):
        states = self.state(chunk, surface.Visibility).add(chunk, key, self)
        if states is None:
            self.spoil(chunk.time)
        elif shown:
            for camera, values in states.items():
                array = surface.weights(values).tobytes()
                self.frame(chunk.time).arrays[f"visibility/{chunk.track}/{camera}"] = array

    def _CALB(self, chunk, key, shown):
        self.calibrated, self.calibration_time = dict(self.static), chunk.time
        if key:
            self.calibration_lost = False
        elif self.calibration_lost:
            self.spoil(chunk.time)
            return
        track = self.state(chunk, lambda: calibration.Track(self.lenses))
        for camera, c in track.add(chunk.payload, key, self._check_moving).items():
            self.calibrated[camera] = numbers_of(c)
        for camera, numbers in self.calibrated.items():
            self.frame_camera(chunk.time, camera, numbers)

    def _check_moving(self, camera, c):
        try:
            check_camera(self.lenses[camera], *parts_of(numbers_of(c)))
        except Broken as broken:
            raise Broken(5105, str(broken)) from broken

    def frame_camera(self, time, camera, numbers):
        self.frame(time).arrays[f"camera/{camera}"] = struct.pack("<26d", *numbers)

    def _TILE(self, chunk, key, shown):
        self.own_tiles[chunk.track] = chunk.time, None
        configured = self.block.layouts.get(chunk.track)
        demand(configured, 4105, "the track shows no tiles")
        layout = kinds.tiles(chunk.payload)
        names = {tile.camera for tile in configured}
        demand(all(tile.camera in names for tile in layout), 4105, "a camera without a tile in the block")
        kinds.check_places(layout, self.block.videos[chunk.track], self.block.cameras)
        self.own_tiles[chunk.track] = chunk.time, layout

    def _VPKT(self, chunk, key, shown):
        check_sample(chunk.payload, key, self.block.videos[chunk.track])
        layout = self.own_tiles.get(chunk.track)
        if chunk.track in self.invalid or (layout and layout[1] is None):
            self.spoil(chunk.time)
        elif shown:
            arrays = self.frame(chunk.time).arrays
            arrays[f"video/{chunk.track}/sample"] = chunk.payload
            arrays[f"video/{chunk.track}/key"] = bytes([key])

    def _AUDI(self, chunk, key, shown):
        audio = self.block.audios[chunk.track]
        packets = self.state(chunk, lambda: sound.Track(audio)).add(chunk, key, self)
        if chunk.track not in self.invalid:
            self.sounds.append((chunk.track, packets))

    def _DATA(self, chunk, key, shown):
        if shown and self.block.tracks[chunk.track].flags & kinds.FRAMES:
            self.frame(chunk.time).arrays[f"data/{chunk.track}"] = chunk.payload

    def _BACK(self, chunk, key, shown):
        demand(key, 8003, "no key flag")
        self.environments[chunk.track] = Environment(chunk.payload)

    # Frames

    def whole_times(self):
        """The times of the frames that are whole: all that a later intact chunk, or GEND, follows."""
        done = self.ended and self.intact
        return [time for time in sorted(self.frame_times) if done or time < self.whole_before]

    def whole(self):
        """Yields time and hashes of the arrays of each intact frame."""
        for time, arrays in self.contents():
            yield time, {name: sha256(data) for name, data in arrays.items()}

    def contents(self):
        """Yields time and arrays, as bytes, of each intact frame."""
        if self.block is None:
            return
        for time in self.whole_times():
            frame = self.frame(time)
            if frame.good:
                yield time, dict(sorted(self._all(time, frame).items()))

    def _all(self, time, frame):
        arrays = dict(frame.arrays)
        for camera, numbers in self.static.items():
            arrays[f"camera/{camera}"] = struct.pack("<26d", *numbers)
        t = self.block.texturing or DEFAULTS
        unseen = 65536.0 * t.unseen[0] + 256.0 * t.unseen[1] + t.unseen[2]
        numbers = t.threshold, t.depth_bias, t.depth_slope, float(t.best), unseen, float(t.blend)
        arrays["texturing"] = struct.pack("<6d", *numbers)
        for track, layout in self.block.layouts.items():
            if track in self.own_tiles:
                layout = self.own_tiles[track][1]
            if layout and track not in self.block.stopped and self.block.rank(track) == 0:
                rows = [tile.row() for tile in layout]
                arrays[f"tiles/{track}"] = numpy.array(rows, "<u4").tobytes()
        return arrays


def numbers_of(c):
    return (*c["intrinsics"], *c["coefficients"], c["r_max"], *c["rotation"], *c["translation"])


def parts_of(numbers):
    return numbers[:5], numbers[5:13], numbers[13], numbers[14:23], numbers[23:]
