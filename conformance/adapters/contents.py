"""Contents that are wrong in a container that is right: two decoders have to name the same rule, at the same chunk.

A byte, a number or the length of one payload changes, or a chunk is left out, doubled or gets another track or key flag; counters,
CRCs, digests, chains, tables and the index are made again. What comes first of several violations is computable (clause 2.5), so
that all readers that check agree.
"""

import base64
import random
import struct

from reference import container

FIELDS = (0, 1, 2, 3, 127, 128, 255, 256, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 1)
CONTAINER = (b"GRUP", b"GEND", b"INDX", b"FOOT")


def changed(payload, rng):
    """Other bytes of the same meaning, most of them wrong."""
    data = bytearray(payload)
    way = rng.randrange(6)
    if not data or way == 0:
        return bytes(data) + bytes([rng.randrange(256)])
    if way == 1:
        return bytes(data[: rng.randrange(len(data))])
    at = rng.randrange(min(len(data), rng.choice((8, 32, 256, 1 << 20))))
    if way == 2:
        data[at] = rng.randrange(256)
    elif way == 3:
        data[at] ^= 1 << rng.randrange(8)
    else:
        size = rng.choice((1, 2, 4))
        at -= at % size
        value = rng.choice(FIELDS) % (1 << 8 * size)
        if way == 5 and at + 8 <= len(data):
            size, at = 8, at - at % 8
            value = struct.unpack(
                "<Q", struct.pack("<d", rng.choice((0.0, -0.0, -1.0, 1e308, float("nan"), float("inf"))))
            )[0]
        if at + size <= len(data):
            data[at : at + size] = value.to_bytes(size, "little")
    return bytes(data)


def wrong(stream, rng):
    """The stream with one wrong chunk, or None if it has a chunk that is not known."""
    chunks = list(container.chunks(stream))
    if any(chunk.kind.decode("latin-1") not in container.CHUNKS for chunk in chunks):
        return None
    targets = [i for i, chunk in enumerate(chunks) if chunk.kind not in CONTAINER]
    if not targets:
        return None
    at = rng.choice(targets)
    chunk, way = chunks[at], rng.randrange(12)
    if way == 0 and chunk.kind != b"SCEN":
        del chunks[at]
    elif way == 1 and chunk.kind != b"SCEN":
        chunks.insert(at, chunk)
    elif way == 2 and chunk.track:
        chunks[at] = chunk._replace(track=rng.choice([c.track for c in chunks if c.track] + [99]))
    elif way == 3 and container.CHUNKS[chunk.kind.decode()]["place"] == "frame":
        chunks[at] = chunk._replace(flags=chunk.flags ^ container.FLAGS["key"])
    else:
        chunks[at] = chunk._replace(payload=changed(chunk.payload, rng))
    return container.joined_chunks(chunks)


def first_issue(report):
    """(rule, place) of the first issue; of several at one place the one that is reported first."""
    rows = [(int(row["offset"]), row["issue"]) for row in report.get("issues", [])]
    lowest = min((offset for offset, _ in rows), default=None)
    return next(((issue, offset) for offset, issue in rows if offset == lowest), None)


def streams(cases, count, seed):
    """Yields (name, stream): count wrong streams of each case that is whole."""
    for case in cases:
        if case.tier == "faulty" or len(case.content) > 30000:
            continue
        for number in range(count):
            rng = random.Random(f"{seed}/{case.name}/{number}")
            found = wrong(case.content, rng)
            if found and found != case.content:
                yield f"{case.name}/{number}", found


def compare(decoders, wanted, count, seed=0):
    """Two decoders over wrong streams: (how many, differences as lines)."""
    one, other = decoders
    names, contents = zip(*streams(wanted, count, seed))
    requests = [{"data": base64.b64encode(content).decode()} for content in contents]
    lines = []
    for name, a, b in zip(names, one.decode_all(iter(requests)), other.decode_all(iter(requests))):
        if isinstance(a, str) or isinstance(b, str):
            lines.append(f"{name}: {a if isinstance(a, str) else b}")
            continue
        found = first_issue(a), first_issue(b)
        frames = [[frame["time"] for frame in report["frames"]] for report in (a, b)]
        if found[0] != found[1]:
            lines.append(f"{name}: {one.name} {found[0]}, {other.name} {found[1]}")
        elif frames[0] != frames[1]:
            lines.append(f"{name}: frames of {one.name} {frames[0]}, of {other.name} {frames[1]}, {found[0]}")
    return len(names), lines
