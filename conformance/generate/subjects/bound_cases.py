"""Numbers just inside and just outside of their bounds, where other cases are far from them."""

import math
import struct

from .. import payloads
from ..case import faulty, valid
from ..recipes import block, group, opened
from ..writer import Stream

WIDEST = math.ldexp(1.5, 1023 - 28)  # 2^28 steps of it are the last finite binary order


def scene_alone(**fields):
    s = Stream()
    s.chunk("SCEN", payloads.scene(**fields))
    s.finish()
    return s


def wrong_scene(name, title, issue, payload):
    def make():
        s = Stream()
        s.chunk("SCEN", payload, fault=issue)
        s.chunk("TRAK", payloads.track(payloads.MESH, "mesh"), track=1)
        group(s, 0)
        s.finish()
        return s

    faulty(f"scene_{name}", title, "5.1", make)


def later_scene(name, title, issue, **fields):
    def make():
        s = opened()
        group(s, 0)
        s.chunk("SCEN", payloads.scene(**fields), fault=issue)
        s.chunk("TRAK", payloads.track(payloads.MESH, "mesh"), track=1)
        group(s, 2)
        block(s)
        group(s, 4)
        s.finish()
        return s

    faulty(f"scene_{name}", title, "5.1", make)


def scenes():
    valid(
        "lattice_widest",
        "A step whose lattice just fits into binary64.",
        "5.1",
        lambda: scene_alone(lattice_step=WIDEST),
        uncommon=True,
    )
    wrong_scene(
        "lattice_beyond",
        "A step whose lattice is just beyond binary64.",
        2003,
        payloads.scene(lattice_step=math.ldexp(1.0, 1024 - 28)),
    )
    wrong_scene(
        "lattice_sum_beyond",
        "Origin and step are finite for themselves, and their sum is not.",
        2003,
        payloads.scene(lattice_origin=(0.0, -1.79e308, 0.0), lattice_step=1e299),
    )
    good = payloads.scene()
    for at in range(50, 55):
        payload = good[:at] + b"\1" + good[at + 1 :]
        wrong_scene(f"reserved_{at}", f"Byte {at} of SCEN, which is reserved, is 1.", 2001, payload)
    for name, fields in (
        ("numerator", {"time_base_numerator": 1 + (1 << 24)}),
        ("denominator", {"time_base_denominator": 25 + (1 << 24)}),
    ):
        later_scene(
            f"changes_{name}",
            f"The time base of the second block differs in the last byte of its {name}.",
            2002,
            **fields,
        )
    step = struct.unpack("<d", struct.pack("<d", 0.001)[:7] + b"\x40")[0]
    later_scene("changes_step_high", "The step differs in its last byte.", 2003, lattice_step=step)
    valid("block_changes_duration", "The nominal duration changes in its last byte.", "5.1", other_duration)
    for axis, origin in enumerate(((5e-324, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))):
        later_scene(
            f"changes_origin_{axis}", "The second block has another origin.", 2003, lattice_origin=origin
        )


def other_duration():
    s = opened()
    group(s, 0)
    block(s, scene=payloads.scene(frame_duration=1 + (1 << 56)))
    group(s, 2)
    s.finish()
    return s


scenes()
