"""A plain reader of tile layouts, written from clauses 4.1, 5, 10.2 and 10.11 of spec/fvv.md alone.

Uses nothing of libfvv, so that prose and library are held against each other. The container is taken to be in order.

    python3 spec/tiles.py STREAM.fvv     # of each group and tile: group, camera, source, destination
"""

import pathlib
import struct
import sys


def chunks(stream):
    """Type, track and payload of all chunks, in order."""
    at = 24
    while at < len(stream):
        track, _, size = struct.unpack_from("<HqQ", stream, at + 6)
        yield stream[at : at + 4], track, stream[at + 32 : at + 32 + size]
        at += 32 + (size + 7) // 8 * 8


def tiles(payload):
    """Camera, source rectangle and destination rectangle of each tile of a TILE or GTIL payload."""
    count, reserved = struct.unpack_from("<II", payload)
    assert count > 0 and reserved == 0 and len(payload) == 8 + 24 * count
    found = []
    for i in range(count):
        camera, flags, *rectangles, reserved = struct.unpack_from("<HH8HI", payload, 8 + 24 * i)
        assert flags == 0 and reserved == 0
        found.append((camera, tuple(rectangles[:4]), tuple(rectangles[4:])))
    return found


def layouts(stream):
    """Of each group: its number, and for each video track that shows tiles the layout that holds."""
    configured, own, number = {}, {}, 0
    for kind, track, payload in chunks(stream):
        if kind == b"SCEN":
            configured = {}
        elif kind == b"TILE":
            configured[track] = tiles(payload)
        elif kind == b"GRUP":
            own = {}
        elif kind == b"GTIL":
            assert track in configured and track not in own
            own[track] = tiles(payload)
        elif kind == b"GEND":
            yield number, {**configured, **own}
            number += 1


def lines(stream):
    for group, by_track in layouts(stream):
        for track in sorted(by_track):
            for camera, *rectangles in by_track[track]:
                yield "  ".join([f"{group} {camera}", *(" ".join(map(str, r)) for r in rectangles)])


if __name__ == "__main__":
    print("\n".join(lines(pathlib.Path(sys.argv[1]).read_bytes())))
