"""What fvvrecover may keep of a damaged stream, judged by the undamaged one and read by the Python container reader alone."""

import struct
from typing import NamedTuple

from reference.container import CHUNKS, chunks

# Chunks without the key flag that continue the one before of their track.
CHAINED = {b"MESH", b"CALB", b"VISI", b"VPKT", b"AUDI"}
# Frames are whole without these.
BESIDE = {b"AUDI", b"BACK"}
FRAMES = {b"MESH", b"VPKT"}


class Group(NamedTuple):
    digest: int  # of its configuration
    start: int
    end: int
    chunks: list
    raw: bytes  # from GRUP to GEND

    def frames(self):
        """Time to the chunks of the frame, layouts left out: one may move with the first sample that is kept."""
        times = {chunk.time for chunk in self.chunks if chunk.kind in FRAMES}
        out = {time: [] for time in sorted(times)}
        for chunk in self.chunks:
            if chunk.time in times and chunk.track and chunk.kind not in BESIDE | {b"TILE"}:
                out[chunk.time].append(chunk)
        return out

    def layouts(self):
        return {chunk.track: chunk.payload for chunk in self.chunks if chunk.kind == b"TILE"}


def groups_of(stream):
    """The groups of an intact stream."""
    found, at, inside, begin, head = [], 24, None, 0, None
    for chunk in chunks(stream):
        size = 32 + (len(chunk.payload) + 7) // 8 * 8
        place = CHUNKS.get(chunk.kind.decode("ascii"), {}).get("place")
        if chunk.kind == b"GRUP":
            inside, begin = [], at
            _, digest, start, end = struct.unpack_from("<IIqq", chunk.payload)
            head = (digest, start, end)
        elif chunk.kind == b"GEND":
            found.append(Group(*head, inside, stream[begin : at + size]))
            inside = None
        elif inside is not None and place != "end":
            inside.append(chunk)
        at += size
    assert at == len(stream)
    return found


def chain_before(group, chunk):
    """The chunk that this one continues, None for a key."""
    former = None
    for other in group.chunks:
        if other == chunk:
            return None if chunk.flags & 2 else former
        if (other.kind, other.track) == (chunk.kind, chunk.track):
            former = other
    raise AssertionError("not a chunk of the original")


def judge(original, kept):
    """Fails unless every group of `kept` is one of `original`, in order, with nothing but whole frames, and what they are
    decoded from. Returns the times of the frames."""
    sources = {group.start: group for group in groups_of(original)}
    times, last = [], None
    for number, group in enumerate(groups_of(kept)):
        source = sources[group.start]
        assert (group.digest, group.end) == (source.digest, source.end)
        assert struct.unpack_from("<I", group.raw, 32)[0] == number
        assert last is None or group.start >= last
        last = group.end
        frames, expected = group.frames(), source.frames()
        for time, parts in frames.items():
            assert parts == expected[time], f"frame {time}"
        for chunk in group.chunks:
            if chunk.kind == b"TILE":
                continue
            assert chunk in source.chunks, chunk[:4]
            if chunk.kind in CHAINED and not chunk.flags & 2:
                assert chain_before(source, chunk) in group.chunks, chunk[:4]
        sampled = {chunk.track for chunk in group.chunks if chunk.kind == b"VPKT"}
        for track, layout in source.layouts().items():
            assert track not in sampled or group.layouts()[track] == layout
        for track, layout in group.layouts().items():
            assert source.layouts()[track] == layout
        if group.chunks == source.chunks and group.raw[32:36] == source.raw[32:36]:
            assert group.raw == source.raw  # byte for byte where the number is the same
        times += frames
    return times


def offsets(stream):
    """Offset, type and size with header and padding of each chunk of an intact stream."""
    at = 24
    for chunk in chunks(stream):
        size = 32 + (len(chunk.payload) + 7) // 8 * 8
        yield at, chunk.kind, size
        at += size
