"""Cameras that move: clauses 9.2, 9.4 and 9.5 of spec/fvv.md."""

import struct

from .container import FLAGS, Numbers, chunks, crc32c, demand, unzigzag

LENSES = {0: 0, 1: 8, 2: 4}  # coefficients of each lens model
MOVES = 1


def camera(values, bits, lens):
    """Clause 9.5: the numbers of a camera by name. Python's int / int is rounded once, to nearest, ties to even."""
    rotation_bits, position_bits, pixel_bits, lens_bits = bits
    q0, q1, q2, q3 = values[:4]
    n = q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3
    demand(2 ** (2 * rotation_bits - 2) <= n <= 2 ** (2 * rotation_bits + 2), 5104, "length of a quaternion")
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
    """A calibration track, chunk by chunk."""

    def __init__(self, lenses):
        self.lenses, self.last, self.number, self.bits = lenses, {}, None, None

    def add(self, payload, key, check=lambda identifier, found: None):
        """Reads a CALB payload and returns the cameras that are calibrated, by identifier. check: raises where one breaks a rule."""
        demand(len(payload) >= 8, 5101, "size")
        number, *bits, count = struct.unpack_from("<H4BH", payload)
        demand(8 <= bits[0] <= 25 and max(bits[1:]) <= 40, 5101, f"bits {bits}")
        demand((number == 0) == key, 5103, f"number {number}, key {key}")
        if key:
            self.last = {}
        else:
            demand(number == self.number + 1 and bits == self.bits, 5103, f"number {number}, bits {bits}")
        demand(count <= len(self.lenses), 5102, f"{count} entries")
        self.number, self.bits = number, bits
        numbers, out = Numbers(payload, 8, 5101), {}
        for _ in range(count):
            identifier = numbers.next()
            demand(identifier in self.lenses and identifier > max(out, default=-1), 5102, f"{identifier}")
            lens = self.lenses[identifier]
            before = self.last.get(identifier, [0] * (12 + LENSES[lens] + 1))
            values = [value + unzigzag(numbers.next()) for value in before]
            demand(all(abs(value) <= 2**53 for value in values), 5104, "a value beyond 2^53")
            self.last[identifier] = values
            out[identifier] = camera(values, bits, lens)
            check(identifier, out[identifier])
        demand(numbers.at == len(payload), 5101, "bytes after the last entry")
        return out


def decode(stream):
    """Yields the tick and the cameras of each chunk of the calibration track."""
    lenses, track = {}, None
    for chunk in chunks(stream):
        if chunk.kind == b"SCEN":
            lenses = {}
        elif chunk.kind == b"CAMR" and chunk.payload[3] & MOVES:
            lenses[struct.unpack_from("<H", chunk.payload)[0]] = chunk.payload[2]
        elif chunk.kind == b"GRUP":
            track = Track(lenses)
        elif chunk.kind == b"CALB":
            yield chunk.time, track.add(chunk.payload, bool(chunk.flags & FLAGS["key"]))


def listing(stream):
    """A line for each camera of each chunk: tick, identifier, and CRC-32C of 26 f64.

    They are intrinsics, coefficients, r_max, rotation and translation.
    """
    for time, cameras in decode(stream):
        for identifier, c in cameras.items():
            numbers = [*c["intrinsics"], *c["coefficients"], c["r_max"], *c["rotation"], *c["translation"]]
            yield f"{time} {identifier} {crc32c(struct.pack('<26d', *numbers)):08x}"
