"""Writes spec/frame-pipe.md from the files of fvvsynth."""

import json
import struct

import numpy as np
from PIL import Image

SIGNATURE = b"\x89FVP\r\n\x1a\n"


def head(description, version=1):
    text = description if isinstance(description, bytes) else json.dumps(description).encode()
    return SIGNATURE + struct.pack("<2I", version, len(text)) + text


def record(kind, number=0, content=b"", vertices=0, faces=0, time=0, size=None):
    size = len(content) if size is None else size
    return struct.pack("<4s3I2qQ", kind, vertices, faces, 0, number, time, size) + content


END = record(b"ENDS")


def frame(folder, description, number, time=0, source=None):
    """The record of a frame; source: the number of the files that are taken for it."""
    source = number if source is None else source
    positions, faces = mesh(folder / (description["meshes"]["pattern"] % source))
    parts = [positions.tobytes(), faces.tobytes()]
    for camera in description["cameras"]:
        parts.append(Image.open(folder / (camera["pictures"] % source)).convert("RGB").tobytes())
        parts.append(Image.open(folder / (camera["masks"] % source)).convert("L").tobytes())
    return record(b"FRAM", number, b"".join(parts), len(positions), len(faces), time)


def mesh(path):
    """Positions and faces of a binary PLY file of triangles."""
    top, _, body = path.read_bytes().partition(b"end_header\n")
    count = {
        line.split()[1]: int(line.split()[2]) for line in top.splitlines() if line.startswith(b"element")
    }
    positions = np.frombuffer(body, "<f4", 3 * count[b"vertex"]).reshape(-1, 3)
    rows = np.frombuffer(body, np.dtype([("n", "u1"), ("v", "<u4", 3)]), count[b"face"], positions.nbytes)
    assert (rows["n"] == 3).all()
    return positions, np.ascontiguousarray(rows["v"])
