"""A slow, plain decoder of calibration tracks, written from clauses 9.2, 9.4 and 9.5 of spec/fvv.md alone.

Uses nothing of libfvv, so that prose and library are held against each other.

    python3 spec/calibration.py STREAM.fvv     # each calibration: its tick, the camera, the CRC-32C of its numbers
"""

import pathlib
import struct
import sys

from delta import Numbers, crc32c

LENSES = {0: 0, 1: 8, 2: 4}  # coefficients of each lens model
MOVES = 1


def chunks(stream):
    """Type, flags, time and payload of each chunk; the container is taken to be in order."""
    at = 24
    while at < len(stream):
        code, flags, _, _, time, size = struct.unpack_from("<4sBBHqQ", stream, at)
        yield code, flags, time, stream[at + 32 : at + 32 + size]
        at += 32 + (size + 7) // 8 * 8


def signed(zigzag):
    return zigzag // 2 if zigzag % 2 == 0 else -(zigzag + 1) // 2


def camera(values, bits, lens):
    """Clause 9.5: a dictionary of numbers. Python's int / int is rounded once, to nearest, ties to even."""
    rotation_bits, position_bits, pixel_bits, lens_bits = bits
    q0, q1, q2, q3 = values[:4]
    n = q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3
    assert 2 ** (2 * rotation_bits - 2) <= n <= 2 ** (2 * rotation_bits + 2)
    rotation = [
        (q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3) / n, 2 * (q1 * q2 - q0 * q3) / n, 2 * (q1 * q3 + q0 * q2) / n,
        2 * (q1 * q2 + q0 * q3) / n, (q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3) / n, 2 * (q2 * q3 - q0 * q1) / n,
        2 * (q1 * q3 - q0 * q2) / n, 2 * (q2 * q3 + q0 * q1) / n, (q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3) / n,
    ]  # fmt: skip
    x, y, z = (value / 2**position_bits for value in values[4:7])
    translation = [-((rotation[i] * x + rotation[i + 1] * y) + rotation[i + 2] * z) for i in range(0, 9, 3)]
    coefficients = [value / 2**lens_bits for value in values[12:-1]]
    r_max = values[-1] / 2**lens_bits
    return {
        "intrinsics": [value / 2**pixel_bits for value in values[7:12]],
        "coefficients": coefficients + [0.0] * (8 - len(coefficients)),
        "r_max": float("inf") if lens == 0 and values[-1] == 0 else r_max,
        "rotation": rotation,
        "translation": translation,
    }


class Track:
    """The cameras that move, chunk by chunk."""

    def __init__(self, lenses):
        self.lenses, self.last, self.number, self.bits = lenses, {}, None, None

    def add(self, payload, key):
        """The cameras that are calibrated, by identifier."""
        number, *bits, count = struct.unpack_from("<H4BH", payload, 0)
        assert (number == 0) == key
        if key:
            self.last = {}
        else:
            assert number == self.number + 1 and bits == self.bits
        self.number, self.bits = number, bits
        assert 8 <= bits[0] <= 25 and max(bits[1:]) <= 40
        numbers, out = Numbers(payload, 8), {}
        for _ in range(count):
            identifier = numbers.next()
            assert identifier in self.lenses and identifier > max(out, default=-1)
            lens = self.lenses[identifier]
            before = self.last.get(identifier, [0] * (12 + LENSES[lens] + 1))
            values = [value + signed(numbers.next()) for value in before]
            assert all(abs(value) <= 2**53 for value in values)
            self.last[identifier] = values
            out[identifier] = camera(values, bits, lens)
        assert numbers.at == len(payload)
        return out


def decode(stream):
    """Tick and cameras of each chunk of the calibration track."""
    lenses, track = {}, None
    for code, flags, time, payload in chunks(stream):
        if code == b"SCEN":
            lenses = {}
        elif code == b"CAMR" and payload[3] & MOVES:
            lenses[struct.unpack_from("<H", payload)[0]] = payload[2]
        elif code == b"GRUP":
            track = Track(lenses)
        elif code == b"CALB":
            yield time, track.add(payload, bool(flags & 2))


def lines(stream):
    """CRC-32C of intrinsics, coefficients, r_max, rotation and translation as f64, 26 in all."""
    for time, cameras in decode(stream):
        for identifier, c in cameras.items():
            numbers = [*c["intrinsics"], *c["coefficients"], c["r_max"], *c["rotation"], *c["translation"]]
            yield f"{time} {identifier} {crc32c(struct.pack('<26d', *numbers)):08x}"


if __name__ == "__main__":
    print("\n".join(lines(pathlib.Path(sys.argv[1]).read_bytes())))
