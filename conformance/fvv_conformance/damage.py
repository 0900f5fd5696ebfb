"""Damage to streams: cuts, flipped bits, lost, repeated and exchanged bytes, chunks and groups. Always the same for the same bytes."""

import random
import struct
from typing import NamedTuple

FILE_HEADER = 24
CHUNK_HEADER = 32
#: Bytes up to which every cut and every bit is tried by `every`.
SMALL = 8192
#: Types of chunks that are in groups alone.
IN_GROUPS = frozenset((b"MESH", b"VPKT", b"CALB", b"VISI", b"BACK", b"AUDI", b"COLR"))
#: Shapes of damage, and how often sampling picks each.
SHAPES = {
    "cut": 4,
    "bit": 8,
    "burst": 3,
    "zeros": 2,
    "delete": 3,
    "insert": 1,
    "repeat": 2,
    "exchange": 2,
    "chunk-delete": 2,
    "chunk-repeat": 2,
    "chunk-exchange": 2,
}


class Damage(NamedTuple):
    """name: what was done, such as bit-812. others_whole: frames of these times have to be intact all the same."""

    name: str
    kind: str
    content: bytes
    others_whole: frozenset = frozenset()


class Chunk(NamedTuple):
    """A chunk with its padding: [begin, end)."""

    begin: int
    end: int
    kind: bytes
    time: int
    track: int


def chunks_of(stream):
    """The chunks of a stream that is in order."""
    found = []
    at = FILE_HEADER
    while at + CHUNK_HEADER <= len(stream):
        kind, _, _, track, time, size = struct.unpack_from("<4sBBHqQ", stream, at)
        end = at + CHUNK_HEADER + (size + 7) // 8 * 8
        if end > len(stream):
            break
        found.append(Chunk(at, end, kind, time, track))
        at = end
    return found


class Span(NamedTuple):
    """A group from GRUP to GEND, or a configuration block: [begin, end). times: of chunks within."""

    begin: int
    end: int
    head_end: int  # of its first chunk
    times: frozenset
    second: bytes = b""  # type of the chunk after the first


def groups_of(chunks):
    found, first, times = [], None, set()
    for i, chunk in enumerate(chunks):
        if chunk.kind == b"GRUP":
            first, times, second = chunk, set(), chunks[i + 1].kind if i + 1 < len(chunks) else b""
        elif chunk.kind == b"GEND" and first:
            found.append(Span(first.begin, chunk.end, first.end, frozenset(times), second))
            first = None
        elif first and chunk.track:
            times.add(chunk.time)
    return found


def blocks_of(chunks):
    """Configuration blocks: from SCEN to what is not part of it."""
    found, first, end = [], None, 0
    for chunk in chunks:
        if chunk.kind in (b"SCEN", b"GRUP", b"INDX") and first:
            found.append(Span(first.begin, end, first.end, frozenset()))
            first = None
        if chunk.kind == b"SCEN":
            first = chunk
        end = chunk.end
    if first:
        found.append(Span(first.begin, end, first.end, frozenset()))
    return found


def flipped(stream, bit):
    out = bytearray(stream)
    out[bit // 8] ^= 1 << bit % 8
    return bytes(out)


def exchanged(stream, a, b):
    """Two spans (begin, end), the first before the second."""
    return stream[: a[0]] + stream[b[0] : b[1]] + stream[a[1] : b[0]] + stream[a[0] : a[1]] + stream[b[1] :]


def structured(stream):
    """Damage to groups and configuration blocks: what is not touched has to survive."""
    chunks = chunks_of(stream)
    groups, blocks = groups_of(chunks), blocks_of(chunks)
    every = frozenset().union(*(group.times for group in groups))
    for i, group in enumerate(groups):
        others = every - group.times
        # Without its GRUP an unknown chunk is part of the block before, whose digest then is another.
        after_head = others if group.second in IN_GROUPS else frozenset()
        yield Damage(f"group-delete-{i}", "group-delete", stream[: group.begin] + stream[group.end :], others)
        yield Damage(
            f"group-head-delete-{i}",
            "group-head-delete",
            stream[: group.begin] + stream[group.head_end :],
            after_head,
        )
        yield Damage(
            f"group-tail-delete-{i}",
            "group-tail-delete",
            stream[: group.head_end] + stream[group.end :],
            others,
        )
        yield Damage(
            f"group-repeat-{i}",
            "group-repeat",
            stream[: group.end] + stream[group.begin : group.end] + stream[group.end :],
        )
        if i + 1 < len(groups):
            after = groups[i + 1]
            content = exchanged(stream, (group.begin, group.end), (after.begin, after.end))
            yield Damage(f"group-exchange-{i}", "group-exchange", content)
    for i, block in enumerate(blocks):
        body = stream[block.begin : block.end]
        yield Damage(f"block-delete-{i}", "block-delete", stream[: block.begin] + stream[block.end :])
        for k, group in enumerate(groups):
            # The block that holds for the group, once more: nothing changes but offsets.
            holds = max((b.begin for b in blocks if b.begin < group.begin), default=None)
            if holds == block.begin and block.end != group.begin:
                content = stream[: group.begin] + body + stream[group.begin :]
                yield Damage(f"block-repeat-{i}-{k}", "block-repeat", content, every)


def span_in(numbers, size, longest=64):
    length = min(numbers.randint(1, longest), size)
    begin = numbers.randrange(size - length + 1)
    return begin, begin + length


def one(shape, stream, chunks, numbers):
    """A damage of a shape at a random place; None: the stream has no such place."""
    size = len(stream)
    if shape == "cut":
        at = numbers.randrange(size)
        return Damage(f"cut-{at}", shape, stream[:at])
    if shape == "bit":
        bit = numbers.randrange(8 * size)
        return Damage(f"bit-{bit}", shape, flipped(stream, bit))
    if shape.startswith("chunk-"):
        return one_of_chunks(shape, stream, chunks, numbers)
    begin, end = span_in(numbers, size)
    name = f"{shape}-{begin}-{end}"
    if shape == "burst":
        return Damage(name, shape, stream[:begin] + numbers.randbytes(end - begin) + stream[end:])
    if shape == "zeros":
        return Damage(name, shape, stream[:begin] + bytes(end - begin) + stream[end:])
    if shape == "delete":
        return Damage(name, shape, stream[:begin] + stream[end:])
    if shape == "insert":
        return Damage(name, shape, stream[:begin] + numbers.randbytes(end - begin) + stream[begin:])
    if shape == "repeat":
        return Damage(name, shape, stream[:end] + stream[begin:])
    other = span_in(numbers, size)
    first, second = sorted([(begin, end), other])
    if first[1] > second[0]:
        return None
    return Damage(f"{name}-{other[0]}-{other[1]}", shape, exchanged(stream, first, second))


def one_of_chunks(shape, stream, chunks, numbers):
    if len(chunks) < 2:
        return None
    i, k = sorted(numbers.sample(range(len(chunks)), 2))
    a, b = chunks[i], chunks[k]
    if shape == "chunk-delete":
        return Damage(f"{shape}-{a.begin}", shape, stream[: a.begin] + stream[a.end :])
    if shape == "chunk-repeat":
        return Damage(f"{shape}-{a.begin}", shape, stream[: a.end] + stream[a.begin :])
    if k > i + 1 and numbers.random() < 0.5:
        k = i + 1
        b = chunks[k]
    return Damage(
        f"{shape}-{a.begin}-{b.begin}", shape, exchanged(stream, (a.begin, a.end), (b.begin, b.end))
    )


def sampled(stream, count, seed):
    """count damages of all shapes, and those of groups and blocks, of which there are few; never the stream itself."""
    if not stream:
        return
    numbers = random.Random(seed)
    chunks = chunks_of(stream)
    few = [damage for damage in structured(stream) if damage.content != stream]
    yield from few if len(few) <= count // 2 else numbers.sample(few, count // 2)
    names = set()
    for _ in range(4 * count):
        shape = numbers.choices(list(SHAPES), SHAPES.values())[0]
        damage = one(shape, stream, chunks, numbers)
        if damage and damage.name not in names and damage.content != stream:
            names.add(damage.name)
            yield damage
        if len(names) >= count:
            return


def every(stream, count, seed):
    """Every cut and every bit of a small stream, and count damages of all shapes."""
    if len(stream) <= SMALL:
        for size in range(len(stream)):
            yield Damage(f"cut-{size}", "cut", stream[:size])
        for bit in range(8 * len(stream)):
            yield Damage(f"bit-{bit}", "bit", flipped(stream, bit))
        yield from (damage for damage in sampled(stream, count, seed) if damage.kind not in ("cut", "bit"))
    else:
        yield from sampled(stream, 4 * count, seed)
