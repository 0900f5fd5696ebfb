"""Speaks the protocol of ../PROTOCOL.md for the Python package fvv: clips with random access, and fvv.check.

What the package does not give as it was sent is not claimed: encoded video, the packets that groups repeat, and texturing.
"""

import hashlib
import itertools
import struct

import fvv
import numpy
from protocol import serve

FILE_HEADER, CHUNK_HEADER = 24, 32
PARTS = ["check", "mesh", "camera", "visibility", "colours", "environment"]


def sha256(array, kind=None):
    data = array if kind is None else numpy.ascontiguousarray(array, kind).tobytes()
    return hashlib.sha256(data).hexdigest()


def mesh_arrays(track, mesh):
    yield f"mesh/{track}/lattice", sha256(mesh.lattice, "<i4")
    yield f"mesh/{track}/faces", sha256(mesh.indices, "<u4")
    yield f"mesh/{track}/positions", sha256(mesh.positions, "<f4")
    if mesh.uvs is not None:
        yield f"mesh/{track}/uvs", sha256(mesh.uvs, "<f4")
    if mesh.has_normals:
        yield f"mesh/{track}/normals", sha256(mesh.normals, "<f4")
    if mesh.colours is not None:
        yield f"mesh/{track}/colours", sha256(mesh.colours, "u1")


def camera_array(camera):
    K = camera.K
    numbers = [K[0, 0], K[1, 1], K[0, 2], K[1, 2], K[0, 1], *camera.distortion, camera.r_max]
    return sha256(numpy.array([*numbers, *camera.R.ravel(), *camera.t]), "<f8")


def uleb128(data, count):
    """The first count numbers, or as many as there are."""
    out, value, shift = [], 0, 0
    for byte in data:
        if len(out) == count:
            break
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            out.append(value)
            value = shift = 0
    return out


class Visibility:
    """Tracks and cameras of visibility: the package has the weights of a mesh and a camera without the track."""

    def __init__(self, clip):
        self._at = {}
        chunks = clip.chunks()
        best = {track.id for track in clip.tracks if track.rank == 0}
        for row in chunks[chunks["type"] == b"VISI"]:
            if row["track"] not in best or row["size"] < 16:
                continue
            payload = clip.read_at(int(row["offset"]) + CHUNK_HEADER, int(row["size"]))
            mesh_track, count = *struct.unpack_from("<H", payload, 2), *struct.unpack_from("<I", payload, 12)
            numbers = uleb128(payload[16:], 2 * count)
            cameras = list(itertools.accumulate(numbers[::2]))
            self._at.setdefault(int(row["time"]), []).append((int(row["track"]), mesh_track, cameras))

    def arrays(self, frame):
        for track, mesh_track, cameras in self._at.get(frame.ticks, []):
            for camera in cameras:
                weights = frame._load_visibility(mesh_track, camera)
                if weights is not None:
                    yield f"visibility/{track}/{camera}", sha256(weights, "u1")


def frame_arrays(frame, visibility):
    arrays = {}
    for track, mesh in frame.meshes.items():
        arrays.update(mesh_arrays(track, mesh))
    for identifier, camera in frame.cameras.items():
        arrays[f"camera/{identifier}"] = camera_array(camera)
    arrays.update(visibility.arrays(frame))
    return arrays


def environment_arrays(parts, pictures, lights):
    for i, part in enumerate(parts):
        yield f"part/{i}/positions", sha256(part.mesh.positions, "<f4")
        yield f"part/{i}/faces", sha256(part.mesh.indices, "<u4")
        if part.uvs is not None:
            yield f"part/{i}/uvs", sha256(part.uvs, "<f4")
    for i, picture in enumerate(pictures):
        yield f"picture/{i}", sha256(picture)
    for i, light in enumerate(lights):
        numbers = [*light.position, *light.direction, *light.colour, light.intensity, light.range]
        yield f"light/{i}", sha256(numpy.array([*numbers, light.inner_cone, light.outer_cone]), "<f8")


def counts_of_environments(clip):
    """(track, parts, pictures, lights) of the last environment of each track, in order of the tracks."""
    found = {}
    chunks = clip.chunks()
    for row in chunks[chunks["type"] == b"BACK"]:
        if row["size"] >= 44:
            payload = clip.read_at(int(row["offset"]) + CHUNK_HEADER, 44)
            found[int(row["track"])] = struct.unpack_from("<3I", payload, 32)
    return [(track.id, *found[track.id]) for track in clip.tracks if track.id in found and track.rank == 0]


def environments(clip, frames):
    """Those of the last configuration. The package joins the environments of several tracks."""
    last = [frame for frame in frames if frame._description is frames[-1]._description]
    joined = next((found for frame in reversed(last) if (found := frame.environment) is not None), None)
    if joined is None:
        return {}
    tracks = counts_of_environments(clip)
    lists = (joined.parts, joined.pictures, joined.lights)
    if len(tracks) == 1:
        # The last chunk may be that of another configuration.
        tracks = [(tracks[0][0], *map(len, lists))]
    elif [sum(counts) for counts in zip(*(row[1:] for row in tracks))] != list(map(len, lists)):
        return {}  # one of several is lost: which one is not known
    out, at = {}, [0, 0, 0]
    for track, *counts in tracks:
        some = [values[i : i + count] for values, i, count in zip(lists, at, counts)]
        at = [i + count for i, count in zip(at, counts)]
        out[str(track)] = dict(environment_arrays(*some))
    return out


def chunk_at(content, problem):
    """Issues are reported where the chunk begins, also those of a place within its payload."""
    at, before = FILE_HEADER, None
    if problem.offset < FILE_HEADER:
        return problem.offset if problem.issue == 1005 else 0
    is_payload = problem.issue >= 2000 and problem.issue != 7001
    while at + CHUNK_HEADER <= len(content):
        (size,) = struct.unpack_from("<Q", content, at + 16)
        end = at + CHUNK_HEADER + (size + 7) // 8 * 8
        kind = content[at : at + 4].decode("latin-1")
        if problem.offset == at and is_payload and before is not None:
            former = content[before : before + 4].decode("latin-1")
            if kind != problem.chunk or former == problem.chunk:
                return before
        if at <= problem.offset < end:
            return at
        at, before = end, at
    return before if is_payload and problem.offset == at and before is not None else problem.offset


#: Chunks of configuration blocks, and issues after which a reader from front to back stops.
BLOCK = {"SCEN", "TRAK", "META", "CAMR", "VCFG", "ACFG", "TEXR"}
FINAL = {1106, 1108, 7001}


def doubtful(clip, content, problems):
    """Times of frames that fvv.check does not call whole, by its problems. Random access does not meet all of them."""
    chunks, times = clip.chunks(), set()
    for problem in problems:
        offset, issue = chunk_at(content, problem), problem.issue
        group = chunks["group"][chunks["offset"] == offset]
        if issue >= 3000 and issue not in FINAL:
            found = chunks["offset"] == offset
        elif issue in FINAL or 2000 <= issue < 3000 or (issue == 1201 and problem.chunk in BLOCK):
            found = chunks["offset"] >= offset
        else:
            found = (chunks["offset"] >= offset) & numpy.isin(chunks["group"], group)
        times.update(int(time) for time in chunks["time"][found])
    return times


def read(content, problems):
    """What a clip holds."""
    with fvv.open(content) as clip:
        visibility = Visibility(clip)
        frames, intact = [], []
        times = doubtful(clip, content, problems)
        for frame in clip:
            try:
                if frame.ticks in times:
                    continue
                frames.append({"time": frame.ticks, "arrays": frame_arrays(frame, visibility)})
                intact.append(frame)
            except fvv.Error:
                continue
        try:
            environment = environments(clip, intact)
        except fvv.Error:
            environment = {}
        return {"frames": frames, "environment": environment}


def report(content, live):
    found = fvv.check(content)
    issues = [(chunk_at(content, p), p.issue) for p in found.problems if p.issue is not None]
    out = {
        "status": "damaged" if found.problem_count else "whole",
        "issues": [{"issue": f"FVV-{issue}", "offset": offset} for offset, issue in sorted(issues)],
        "summary": {"groups": found.groups, "frames": found.frames, "ended": found.complete},
    }
    try:
        out.update(read(content, [p for p in found.problems if p.issue is not None]))
    except fvv.Error:
        out.update({"frames": [], "environment": {}})
        if found.problem_count:
            out["status"] = "refused"
    return out


if __name__ == "__main__":
    serve({"name": "fvv for Python", "version": fvv.__version__, "format": "0.2", "parts": PARTS}, report)
