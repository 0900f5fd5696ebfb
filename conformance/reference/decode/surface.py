"""What the surface has besides its shape: visibility (clause 17) and colours (clause 19 of spec/fvv.md)."""

import math
import struct

import numpy

from .. import colours, visibility
from ..container import Numbers, demand
from ..range_coder import RangeDecoder
from .configuration import CAMERAS, MESH
from .meshes import LATTICE_MAX, VERTICES

WEIGHTS = numpy.array([127, 0, 255, 85, 170, 113, 142], numpy.uint8)  # by state, clause 17.4


class Visibility:
    """A visibility track in one group."""

    def __init__(self):
        self.number, self.mesh_track, self.count, self.before, self.lost = None, None, None, {}, False

    def lose(self):
        self.lost = True

    def add(self, chunk, key, group):
        """The states of each camera of a VISI chunk, or None if something that it needs is lost."""
        payload, lost, self.lost = chunk.payload, self.lost and not key, True
        demand(len(payload) >= 16, 6001, "size")
        reserved, threshold, mesh_track, count, number, cameras = struct.unpack_from("<BBHIII", payload)
        demand(reserved == 0, 6001, "reserved byte")
        demand(0 < cameras <= (len(payload) - 16) // 2, 6004, f"{cameras} cameras")
        demand(cameras <= CAMERAS and count <= VERTICES, 7001, f"{cameras} cameras, {count} vertices")
        table = self._table(payload, cameras)
        demand((number == 0) == key, 6006, f"number {number}, key flag {key}")
        if not key and not lost:
            demand(number == self.number + 1, 6006, f"number {number} after {self.number}")
            demand((mesh_track, count) == (self.mesh_track, self.count), 6006, "another mesh than before")
        track = group.block.tracks.get(mesh_track)
        demand(track and track.kind == MESH, 6005, f"mesh track {mesh_track}")
        there = group.mesh_at(mesh_track, chunk.time)
        demand(there, 6005, "no mesh of this time")
        mesh = group.mesh_of(mesh_track)
        if group.calibration_lost or mesh is None or lost:
            return None
        demand(count == len(mesh.positions), 6005, f"{count} vertices")
        pairs = self._pairs(table, group)
        self.number, self.mesh_track, self.count = number, mesh_track, count
        self.before = self._states(payload, pairs, threshold, mesh, {} if key else self.before, group)
        self.lost = False
        return self.before

    def _table(self, payload, cameras):
        """(camera, offset of its stream, size) of each camera."""
        numbers, table, camera, pairs = Numbers(payload, 16, 6004), [], 0, []
        for i in range(cameras):
            step, size = numbers.next(), numbers.next()
            demand(step > 0 or i == 0, 6003, "cameras do not increase")
            camera += step
            demand(camera < 65535, 6003, f"camera {camera}")
            table.append((camera, size))
        at = numbers.at
        demand(at + sum(size for _, size in table) <= len(payload), 6004, "sizes of the streams")
        for camera, size in table:
            pairs.append((camera, at, size))
            at += size
        return pairs

    def _pairs(self, table, group):
        for camera, _, _ in table:
            demand(camera in group.block.cameras, 6003, f"camera {camera}")
            demand(camera in group.calibrated, 6003, f"camera {camera} is not calibrated")
        return table

    def _states(self, payload, pairs, threshold, mesh, before, group):
        positions = mesh.positions.tolist()
        surface = group.surface(mesh)
        scene, states = group.block.scene, {}
        for camera, at, size in pairs:
            numbers = group.calibrated[camera]
            centre = centre_of(numbers, scene)
            facing = surface.facing(positions, centre, threshold)
            former = before.get(camera, [0] * len(positions))
            decoder = RangeDecoder(payload[at : at + size]) if size else None
            states[camera] = visibility.decode_stream(decoder, surface, facing, former)
        return states


def centre_of(numbers, scene):
    """Clause 17.2: the camera's centre in steps of the lattice."""
    rotation, t = numbers[14:23], numbers[23:]
    out = []
    for a in range(3):
        metres = -((rotation[a] * t[0] + rotation[3 + a] * t[1]) + rotation[6 + a] * t[2])
        steps = (metres - scene.origin[a]) / scene.step
        demand(
            math.isfinite(steps) and abs(round(steps)) <= LATTICE_MAX, 6003, "a centre outside the lattice"
        )
        out.append(round(steps))
    return out


def weights(states):
    return WEIGHTS[numpy.array(states)]


def colours_of(chunk, key, group):
    """(mesh track, R G B of each vertex) of a COLR chunk; colours None if its mesh is lost."""
    payload = chunk.payload
    demand(len(payload) >= 16 and key, 6201, "size, or no key flag")
    luma, chroma, mesh_track, count, size, _ = struct.unpack_from("<BBHIII", payload)
    demand(1 <= luma <= 64 and 1 <= chroma <= 64 and 1 <= size <= 1 << 24, 6201, "steps or cell size")
    demand(count <= VERTICES, 7001, f"{count} vertices")
    track = group.block.tracks.get(mesh_track)
    demand(track and track.kind == MESH and group.mesh_at(mesh_track, chunk.time), 6202, "no mesh")
    if group.mesh_of(mesh_track) is None:
        return mesh_track, None
    mesh = group.described(mesh_track, chunk.time)
    demand(mesh, 6202, "no key mesh and no patch")
    rows = colours.decode_chunk(payload, mesh.positions.tolist())
    return mesh_track, numpy.array(rows, numpy.uint8)
