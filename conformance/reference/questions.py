"""Answers to the questions of ../PROTOCOL.md on one frame: where points are seen, and which ray a pixel has."""

import functools
import struct

from . import projection
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
    group, arrays = frames_of(bytes(data))[request["frame"]]
    camera = request["camera"]
    return group.block.cameras[camera].lens, struct.unpack("<26d", arrays[f"camera/{camera}"])


ANSWERS = {"project": project, "unproject": unproject}
