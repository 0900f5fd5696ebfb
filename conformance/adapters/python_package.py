"""Speaks the protocol of ../PROTOCOL.md for the Python package fvv: clips with random access, and fvv.check.

What the package does not give as it was sent is not claimed: encoded video, the packets that groups repeat, and texturing.
"""

import hashlib
import itertools
import struct

import fvv
import numpy
from protocol import serve

CHUNK_HEADER = 32
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


def is_whole(ticks, runs):
    return any(first <= ticks <= last for first, last in runs)


def read(content, runs):
    """What a clip holds. runs: the times of whole frames, by fvv.check; random access does not meet all faults."""
    with fvv.open(content) as clip:
        visibility = Visibility(clip)
        frames, intact = [], []
        for frame in clip:
            try:
                # A group of a wrong time may repeat those of an earlier one.
                if not is_whole(frame.ticks, runs) or any(frame.ticks == other.ticks for other in intact):
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
    issues = [(p.chunk_offset, p.issue) for p in found.problems if p.issue is not None]
    out = {
        "status": "damaged" if found.problem_count else "whole",
        "issues": [{"issue": f"FVV-{issue}", "offset": offset} for offset, issue in sorted(issues)],
        "summary": {"groups": found.groups, "frames": found.frames, "ended": found.complete},
    }
    try:
        out.update(read(content, found.whole))
    except fvv.Error:
        out.update({"frames": [], "environment": {}})
        if found.problem_count:
            out["status"] = "refused"
    return out


class NoVisibility:
    """`fvv.Reader` has the visibility of a frame without the tracks of its weights."""

    def arrays(self, frame):
        return ()


def joined(content):
    """The report of who joins a stream late."""
    reader = fvv.Reader(join=True, pictures=False)
    found, issues = [], []
    for event in [*reader.feed(content), *reader.finish()]:
        if isinstance(event, fvv.reader.FrameEvent):
            arrays = frame_arrays(event.frame, NoVisibility())
            found.append({"time": event.frame.ticks, "arrays": arrays})
        elif isinstance(event, fvv.reader.Damage):
            issues.append({"issue": f"FVV-{event.problem.issue}", "offset": event.problem.chunk_offset})
    return {"status": "damaged" if issues else "whole", "issues": issues, "frames": found}


def or_none(row):
    return None if numpy.isnan(row).any() else row.tolist()


def project(content, request):
    with fvv.open(content) as clip:
        camera = clip[request["frame"]].cameras[request["camera"]]
        return {"pixels": [or_none(row) for row in camera.project(request["points"])]}


def unproject(content, request):
    with fvv.open(content) as clip:
        camera = clip[request["frame"]].cameras[request["camera"]]
        _, directions = camera.ray(request["pixels"])
        return {"rays": [or_none(camera.R @ row) for row in directions]}


QUESTIONS = {"project": project, "unproject": unproject}

if __name__ == "__main__":
    hello = {"name": "fvv for Python", "version": fvv.__version__, "format": "0.2"}
    serve({**hello, "parts": [*PARTS, "join", *QUESTIONS]}, report, QUESTIONS, joined)
