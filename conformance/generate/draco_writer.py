"""Draco bitstreams written by hand, most of the sequential method: what the encoders at hand do not write, allowed or not.

Clauses 1 to 3 and 6 of spec/draco.md; differences are the only prediction.
"""

import struct

from reference.container import uleb128, zigzag
from reference.decode.draco_edgebreaker import LEAST_VALENCE, MOST_VALENCE, split_events
from reference.decode.draco_symbols import BinaryDecoder, Buffer, symbols

PLAIN, DIFFERENCES = 1, 0  # ways of corners
DIFFERENCE, NO_PREDICTION = 0, -2
POSITION, NORMAL, TEX_COORD = 0, 1, 3
SMALL = 12  # bits of the probabilities of tags


def shares(symbols, total):
    """Probabilities of the symbols 0 and on: in proportion, at least 1 each that occurs, `total` in all."""
    counts = [0] * (max(symbols) + 1)
    for symbol in symbols:
        counts[symbol] += 1
    out = [max(1, count * total // len(symbols)) if count else 0 for count in counts]
    largest = out.index(max(out))
    out[largest] += total - sum(out)
    return out


def alphabet(probabilities):
    out, at = uleb128(len(probabilities)), 0
    while at < len(probabilities):
        run = 0
        while run < 64 and at + run < len(probabilities) and not probabilities[at + run]:
            run += 1
        if run:
            out += bytes([run - 1 << 2 | 3])
            at += run
            continue
        value, more = probabilities[at], 0
        while value >> 6 + 8 * more:
            more += 1
        out += bytes([(value & 63) << 2 | more]) + (value >> 6).to_bytes(more, "little")
        at += 1
    return out


def rans(symbols, probabilities, bits):
    """The coder of clause 2.3: symbols from the last to the first."""
    starts, base, out = [0], 4 << bits, bytearray()
    for probability in probabilities:
        starts.append(starts[-1] + probability)
    state = base
    for symbol in reversed(symbols):
        probability = probabilities[symbol]
        while state >= probability << 10:
            out.append(state & 255)
            state >>= 8
        state = (state // probability << bits) + state % probability + starts[symbol]
    value = state - base
    size = next(n for n in (1, 2, 3, 4) if value < 1 << 8 * n - 2)
    out += (value | size - 1 << 8 * size - 2).to_bytes(size, "little")
    return alphabet(probabilities) + uleb128(len(out)) + bytes(out)


def precision(width):
    return min(max(3 * width // 2, 12), 20)


def padded(probabilities, least_symbols):
    return probabilities + [0] * max(0, least_symbols - len(probabilities))


def raw(numbers, width, least_symbols=0):
    bits = precision(width)
    return bytes([1, width]) + rans(numbers, padded(shares(numbers, 1 << bits), least_symbols), bits)


def tagged(numbers, components, least_symbols=0):
    rows = [numbers[i : i + components] for i in range(0, len(numbers), components)]
    tags = [max(number.bit_length() for number in row) for row in rows]
    packed = at = 0
    for row, tag in zip(rows, tags):
        for number in row:
            packed |= number << at
            at += tag
    return (
        bytes([0])
        + rans(tags, padded(shares(tags, 1 << SMALL), least_symbols), SMALL)
        + packed.to_bytes((at + 7) // 8, "little")
    )


def values(
    rows, *, prediction=DIFFERENCE, transform=1, size=None, width=None, least=None, most=None, least_symbols=0
):
    """size: bytes of numbers without entropy coding; width: of a raw alphabet; neither: tags. least_symbols: of the alphabet."""
    flat = [value for row in rows for value in row]
    low = min(flat) if least is None else least
    high = max(flat) if most is None else most
    last, numbers = [min(max(0, low), high)] * len(rows[0]), []
    for row in rows:
        numbers += [
            zigzag(value - (before if prediction == DIFFERENCE else 0)) for value, before in zip(row, last)
        ]
        last = row
    if size:
        coded = bytes([0, size]) + b"".join(number.to_bytes(size, "little") for number in numbers)
    elif width:
        coded = b"\1" + raw(numbers, width, least_symbols)
    else:
        coded = b"\1" + tagged(numbers, len(rows[0]), least_symbols)
    head = struct.pack("<b", prediction)
    if prediction == NO_PREDICTION:
        return head + coded
    return head + bytes([transform]) + coded + struct.pack("<2i", low, high)


def corners(shape, way):
    flat, points = [corner for face in shape.faces for corner in face], len(shape.positions)
    if way == DIFFERENCES:
        steps = [b - a for a, b in zip([0, *flat], flat)]
        return raw([2 * step if step >= 0 else -2 * step + 1 for step in steps], 5)
    if 1 << 16 <= points < 1 << 21:
        return b"".join(map(uleb128, flat))
    return struct.pack(f"<{len(flat)}{'B' if points < 1 << 8 else 'H' if points < 1 << 16 else 'I'}", *flat)


def sequential(
    shape, *, way=PLAIN, head=b"DRACO\2\2\1\0\0\0", counts=None, coding=1, positions=None, **of_values
):
    """of_values: of all attributes, see values(). counts, positions: bytes in the place of the right ones."""
    columns = [(POSITION, shape.positions), (TEX_COORD, shape.texture), (NORMAL, shape.normals)]
    columns = [(kind, rows) for kind, rows in columns if rows]
    out = head + (uleb128(len(shape.faces)) + uleb128(len(shape.positions)) if counts is None else counts)
    out += bytes([way]) + corners(shape, way)
    out += b"\1" + uleb128(len(columns))
    for number, (kind, rows) in enumerate(columns):
        out += bytes([kind, 5, len(rows[0]), 0]) + uleb128(number)
    out += bytes([coding]) * len(columns)
    out += values(shape.positions, **of_values) if positions is None else positions
    return out + b"".join(values(rows, **of_values) for _, rows in columns[1:])


def with_tagged_lists(data):
    """A bitstream of the valence traversal, with tags in place of the raw alphabets of its lists."""
    buffer = Buffer(data, 12)
    buffer.number(), buffer.number(), buffer.u8(), buffer.number(), buffer.number()
    split_events(buffer, buffer.number())
    BinaryDecoder(buffer)
    out = data[: buffer.at]
    for _ in range(LEAST_VALENCE, MOST_VALENCE + 1):
        count = buffer.number()
        numbers = symbols(buffer, count, 1)
        out += uleb128(count) + (tagged(numbers, 1) if numbers else b"")
    return out + data[buffer.at :]
