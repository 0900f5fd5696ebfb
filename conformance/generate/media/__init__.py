"""Ingredients that other encoders wrote, as make.py keeps them."""

import base64
import functools
import json
import pathlib
from typing import NamedTuple

HERE = pathlib.Path(__file__).resolve().parent


class Clip(NamedTuple):
    """samples: (key, bytes)."""

    codec: str
    width: int
    height: int
    bit_depth: int
    string: str
    record: bytes
    samples: list


@functools.cache
def _file(name):
    return json.loads((HERE / f"{name}.json").read_text())


def clip(name):
    file = _file(name)
    samples = [(sample["key"], base64.b64decode(sample["data"])) for sample in file["samples"]]
    record = base64.b64decode(file["record"])
    return Clip(
        file["codec"],
        file["width"],
        file["height"],
        file["bit_depth"],
        file["codec_string"],
        record,
        samples,
    )


def draco(name):
    """Vertices, faces and bytes of a bitstream."""
    mesh = _file("draco")["meshes"][name]
    return mesh["vertices"], mesh["faces"], base64.b64decode(mesh["data"])


def draco_decoded(name):
    """Positions and faces of a bitstream in decoded order."""
    found = _file("draco")["meshes"][name]["decoded"]
    return [
        [tuple(values[i : i + 3]) for i in range(0, len(values), 3)]
        for values in (found["positions"], found["faces"])
    ]


def sound(name):
    """Rate, channels, record and packets."""
    found = _file("sound")[name]
    packets = [base64.b64decode(packet) for packet in found["packets"]]
    return found["rate"], found["channels"], base64.b64decode(found["record"]), packets


def picture(name):
    """Width, height and the file."""
    found = _file("pictures")[name]
    return found["width"], found["height"], base64.b64decode(found["data"])
