"""Payloads of configuration chunks, sound, layouts and environments, with defaults that are right.

Every function takes other values of fields by name, so that a case names only what is special about it.
"""

import math
import struct

from reference.container import uleb128, zigzag

from .packing import pack

# World to camera: the camera looks down, along -z, with its right along +x.
DOWN = (1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0)
IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
NO_PICTURE = 2**32 - 1
MESH, VIDEO, CALIBRATION, VISIBILITY, ENVIRONMENT, DATA, AUDIO, COLOURS = range(1, 9)


def scene(**fields):
    values = {"time_base_numerator": 1, "time_base_denominator": 25, "frame_duration": 1}
    values |= {"lattice_step": 0.001, "up_axis": 3}
    return pack("SCEN payload", **values | fields)


def track(kind, name="", **fields):
    """name: text or bytes."""
    text = name if isinstance(name, bytes) else name.encode()
    values = {"kind": kind, "flags": int(kind in (MESH, VIDEO)), "name_size": len(text)}
    return pack("TRAK payload", **values | fields) + text


def camera(identifier=0, name="", centre=(0.0, 0.0, 1.0), **fields):
    """A pinhole camera of 16 x 16 pixels that looks down."""
    text = name if isinstance(name, bytes) else name.encode()
    rotation = fields.get("rotation", DOWN)
    values = {"id": identifier, "name_size": len(text), "width": 16, "height": 16, "fx": 16.0, "fy": 16.0}
    values |= {"cx": 8.0, "cy": 8.0, "r_max": math.inf, "rotation": rotation}
    values["translation"] = tuple(
        0.0 - sum(rotation[3 * i + j] * centre[j] for j in range(3)) for i in range(3)
    )
    return pack("CAMR payload", **values | fields) + text


def video(codec="jpeg", record=b"", string="", **fields):
    text = string if isinstance(string, bytes) else string.encode()
    values = {
        "codec": codec if isinstance(codec, bytes) else codec.encode(),
        "width": 32,
        "height": 16,
        "bit_depth": 8,
        "full_range": 1,
    }
    values |= {"colour_primaries": 1, "transfer_characteristics": 1, "matrix_coefficients": 6}
    values |= {"codec_string_size": len(text), "record_size": len(record)}
    return pack("VCFG payload", **values | fields) + record + text


def tile(identifier, source=(0, 0, 16, 16), destination=(0, 0, 16, 16), **fields):
    return pack("TILE entry", camera=identifier, source=source, destination=destination, **fields)


def tiles(*entries, **fields):
    return pack("TILE payload", **{"count": len(entries)} | fields) + b"".join(entries)


def texturing(**fields):
    values = {"threshold": 0.05, "depth_bias": 0.2, "depth_slope": 0.5, "best": 3, "unseen": (128, 128, 128)}
    return pack("TEXR payload", **values | fields)


def opus_head(channels=1, preskip=312, rate=48000, gain=0, family=0, table=b"", version=1):
    head = struct.pack("<8sBBHIhB", b"OpusHead", version, channels, preskip, rate, gain, family)
    return head + table


def audio(record=None, language="", codec="opus", **fields):
    """ACFG. The default is one channel of Opus in packets of 20 ms."""
    record = opus_head() if record is None else record
    text = language if isinstance(language, bytes) else language.encode()
    values = {"codec": codec.encode(), "channels": 1, "packet_duration": 960, "preroll": 4}
    values |= {"record_size": len(record), "language_size": len(text)}
    return pack("ACFG payload", **values | fields) + record + text


def sound(start, packets, position=None, preroll=0, **fields):
    """AUDI."""
    values = {"start": start, "packet_count": len(packets), "preroll_count": preroll}
    place = struct.pack("<3d", *position) if position else b""
    sizes = struct.pack(f"<{len(packets)}H", *map(len, packets))
    return pack("AUDI payload", **values | fields) + place + sizes + b"".join(packets)


def data(media_type="text/vtt", codec="", record=b"", **fields):
    """DCFG."""
    kind, text = media_type.encode() if isinstance(media_type, str) else media_type, codec.encode()
    values = {"media_type_size": len(kind), "codec_size": len(text), "record_size": len(record)}
    return pack("DCFG payload", **values | fields) + record + kind + text


def part(mesh, picture=NO_PICTURE, **fields):
    values = {"mesh_size": len(mesh), "picture": picture, "colour": (65535, 32768, 0)}
    values |= {"texture_size": (1.0, 1.0)}
    return pack("BACK part", **values | fields), mesh


def picture(codec, width, height, file, **fields):
    values = {"codec": codec, "width": width, "height": height, "bytes": len(file)}
    return pack("BACK picture", **values | fields), file


def light(kind, **fields):
    """The fields that the type uses have values."""
    values = {"type": kind, "colour": (1.0, 0.5, 0.25), "intensity": 100.0}
    if kind != 0:
        values |= {"position": (1.0, 2.0, 3.0), "range": 10.0}
    if kind != 1:
        values |= {"direction": (0.0, 0.0, -1.0)}
    if kind == 2:
        values |= {"inner_cone": 0.25, "outer_cone": 0.5}
    return pack("BACK light", **values | fields)


def environment(parts=(), pictures=(), lights=(), **fields):
    """BACK. parts, pictures: as part and picture return them."""
    values = {"lattice_step": 0.01, "part_count": len(parts), "picture_count": len(pictures)}
    out = pack("BACK payload", **values | {"light_count": len(lights)} | fields)
    out += b"".join(entry for entry, _ in parts) + b"".join(entry for entry, _ in pictures) + b"".join(lights)
    return out + b"".join(mesh for _, mesh in parts) + b"".join(file for _, file in pictures)


COEFFICIENTS = {0: 0, 1: 8, 2: 4}
# Of CALB below: a quaternion that looks down, its real part first, in steps of 2^-8.
LOOKING_DOWN = (0, 256, 0, 0)
BITS = {"rotation_bits": 8, "position_bits": 4, "pixel_bits": 4, "lens_bits": 16}


def moving_values(q=LOOKING_DOWN, centre=(0, 0, 16), pixels=(256, 256, 128, 128, 0), lens=(), r_max=0):
    """The values of a CALB entry in the units of BITS: by default 1 m above the origin, 16 x 16 pixels."""
    return [*q, *centre, *pixels, *lens, r_max]


def calibration(number, entries, before=None, **fields):
    """CALB. entries: (camera, values) in order; before: the last values by camera, which are replaced."""
    before = {} if before is None else before
    out = pack("CALB payload", **{"number": number, "count": len(entries)} | BITS | fields)
    for identifier, values in entries:
        out += uleb128(identifier)
        former = before.get(identifier, [0] * len(values))
        out += b"".join(uleb128(zigzag(value - last)) for value, last in zip(values, former))
        before[identifier] = list(values)
    return out
