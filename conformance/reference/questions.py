"""Answers to the questions of ../PROTOCOL.md on one frame: where points are seen, which ray a pixel has, and which cameras colour
a place."""

import functools
import struct

import numpy

from . import projection, texturing
from .decoder import read


@functools.lru_cache(maxsize=4)
def frames_of(data):
    """Of each frame that is whole its group and its arrays, as bytes by name. A stream is asked several questions."""
    return [(group, arrays) for group in read(data, {}).groups for _, arrays in group.contents()]


def project(data, request):
    lens, numbers = camera_of(data, request)
    return {"pixels": [projection.project(lens, numbers, point) for point in request["points"]]}


def unproject(data, request):
    lens, numbers = camera_of(data, request)
    return {"rays": [projection.unproject(lens, numbers, pixel) for pixel in request["pixels"]]}


def camera_of(data, request):
    """The lens model of the camera of a request, and its numbers at that frame."""
    return camera_at(*frames_of(bytes(data))[request["frame"]], request["camera"])


def camera_at(group, arrays, camera):
    return group.block.cameras[camera].lens, struct.unpack("<26d", arrays[f"camera/{camera}"])


def unit(vector):
    return vector / numpy.linalg.norm(vector)


class Surface:
    """A mesh track of a frame, with what says which cameras show its places."""

    def __init__(self, group, arrays, track):
        self.group, self.arrays, self.track = group, arrays, track
        self.points = numpy.frombuffer(arrays[f"mesh/{track}/positions"], "<f4").reshape(-1, 3).astype(float)
        self.faces = numpy.frombuffer(arrays[f"mesh/{track}/faces"], "<u4").reshape(-1, 3)
        self.texturing = group.block.texturing or texturing.Texturing()

    def tiles(self):
        """Camera, source and destination of every tile, in the order of the stream."""
        for name, data in self.arrays.items():
            if name.startswith("tiles/"):
                for row in numpy.frombuffer(data, "<u4").reshape(-1, 9).tolist():
                    yield row[0], row[1:5], row[5:]

    def seen(self, camera, corners, barycentric):
        """The visibility weight of a place, or None: the stream has none for this camera."""
        for name, data in self.arrays.items():
            kind, _, rest = name.partition("/")
            if kind != "visibility" or int(rest.split("/")[1]) != camera:
                continue
            if self.group.tracks[b"VISI", int(rest.split("/")[0])].mesh_track == self.track:
                return float(sum(b * data[corner] for b, corner in zip(barycentric, corners)))
        return None

    def is_hidden(self, face, point, centre):
        """Without visibility weights: whether a face has its back to a camera, or another one is between it and a place."""
        a, b, c = self.points[self.faces[face]]
        if not numpy.dot(numpy.cross(b - a, c - a), centre - point) > 0:
            return True
        return any(
            is_between(point, centre, *self.points[corners])
            for other, corners in enumerate(self.faces)
            if other != face
        )

    def weights(self, face, barycentric, normal, eye):
        """Clause 17.5: by camera, what it adds to the colour of a place."""
        corners, normal, eye = self.faces[face], numpy.array(normal), numpy.array(eye)
        point = numpy.array(barycentric) @ self.points[corners]
        viewer, sights = unit(eye - point), {}
        shown = texturing.place(self.texturing, point, normal, viewer)
        for camera, source, destination in self.tiles():
            if f"camera/{camera}" not in self.arrays:
                continue
            lens, numbers = camera_at(self.group, self.arrays, camera)
            pixel = projection.project(lens, numbers, shown)
            if pixel is None:
                continue
            centre = -numpy.array(numbers[14:23]).reshape(3, 3).T @ numpy.array(numbers[23:])
            seen = self.seen(camera, corners, barycentric)
            if seen is None:
                seen = 0.0 if self.is_hidden(face, point, centre) else 255.0
            at = [(pixel[i] - source[i]) * destination[2 + i] / source[2 + i] for i in range(2)]
            border = min(*at, destination[2] - at[0], destination[3] - at[1])
            ray = unit(centre - point)
            sights[camera] = texturing.Sight(float(normal @ ray), float(viewer @ ray), seen, border)
        found = texturing.weights(self.texturing, sights) or {}
        return {str(camera): weight for camera, weight in found.items()}


def is_between(start, end, a, b, c):
    """Whether the triangle a b c is met on the way from one point to another."""
    way = end - start
    normal = numpy.cross(b - a, c - a)
    along = normal @ way
    if along == 0:
        return False
    t = normal @ (a - start) / along
    if not 1e-9 < t < 1:
        return False
    met = start + t * way
    sides = [numpy.cross(q - p, met - p) @ normal for p, q in ((a, b), (b, c), (c, a))]
    return all(side >= 0 for side in sides)


def weigh(data, request):
    surface = Surface(*frames_of(bytes(data))[request["frame"]], request["mesh"])
    fields = "face", "barycentric", "normal", "eye"
    return {"weights": [surface.weights(*(place[f] for f in fields)) for place in request["places"]]}


ANSWERS = {"project": project, "unproject": unproject, "weigh": weigh}
