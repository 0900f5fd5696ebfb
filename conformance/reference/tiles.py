"""Tile layouts of video frames, of the configuration and of single groups: clauses 10.2 and 10.11 of spec/fvv.md."""

import struct

from .container import chunks


def tiles(payload):
    """Camera, source rectangle and destination rectangle of each tile of a TILE payload."""
    count, reserved = struct.unpack_from("<II", payload)
    assert count > 0 and reserved == 0 and len(payload) == 8 + 24 * count
    found = []
    for i in range(count):
        camera, flags, *rectangles, reserved = struct.unpack_from("<HH8HI", payload, 8 + 24 * i)
        assert flags == 0 and reserved == 0
        found.append((camera, tuple(rectangles[:4]), tuple(rectangles[4:])))
    return found


def layouts(stream):
    """Yields for each group its number, and the layout in force of each video track that has tiles."""
    configured, own, number = {}, None, 0
    for kind, _, track, _, payload in chunks(stream):
        if kind == b"SCEN":
            configured = {}
        elif kind == b"GRUP":
            own = {}
        elif kind == b"TILE" and own is None:
            configured[track] = tiles(payload)
        elif kind == b"TILE":
            assert track in configured and track not in own
            own[track] = tiles(payload)
        elif kind == b"GEND":
            yield number, {**configured, **own}
            number, own = number + 1, None


def listing(stream):
    """A line for each group and tile: group, camera, source, destination."""
    for group, by_track in layouts(stream):
        for track in sorted(by_track):
            for camera, *rectangles in by_track[track]:
                yield "  ".join([f"{group} {camera}", *(" ".join(map(str, r)) for r in rectangles)])
