"""Numbers and entropy coding of the Draco profile: clauses 1 and 2 of spec/draco.md. What is cut or malformed is FVV-3009."""

from bisect import bisect_right

from ..container import Numbers, demand

ISSUE = 3009
TAGGED, RAW = 0, 1
SYMBOLS = 1 << 18


class Buffer:
    """The bytes of a bitstream from front to back."""

    def __init__(self, data, at=0):
        self.data, self.at = data, at

    def take(self, size):
        demand(size <= len(self.data) - self.at, ISSUE, "the bitstream is cut")
        self.at += size
        return self.data[self.at - size : self.at]

    def u8(self):
        return self.take(1)[0]

    def i8(self):
        return (self.u8() ^ 128) - 128

    def i32(self):
        return int.from_bytes(self.take(4), "little", signed=True)

    def number(self):
        numbers = Numbers(self.data, self.at, ISSUE)
        value = numbers.next()
        demand(value < 1 << 32, ISSUE, "a number of more than 32 bits")
        self.at = numbers.at
        return value

    def rows(self, size, count):
        """Unsigned numbers of that many bytes."""
        data = self.take(size * count)
        return [int.from_bytes(data[i : i + size], "little") for i in range(0, len(data), size)]

    def left(self):
        return len(self.data) - self.at


class Bits:
    """Bits from the least significant of each byte on."""

    def __init__(self, data, at=0):
        self.data, self.at, self.bit = data, at, 0

    def take(self, count):
        value = 0
        for i in range(count):
            place = self.at + (self.bit >> 3)
            demand(place < len(self.data), ISSUE, "the bits are cut")
            value |= (self.data[place] >> (self.bit & 7) & 1) << i
            self.bit += 1
        return value

    def end(self):
        """The offset after the byte of the last bit."""
        return self.at + (self.bit + 7 >> 3)


def start_state(data, most):
    """State and bytes left of an ANS coder: its last bytes, whose number is in the two highest bits."""
    demand(data, ISSUE, "an empty ANS stream")
    size = (data[-1] >> 6) + 1
    demand(size <= min(len(data), most), ISSUE, "the state of an ANS stream")
    state = int.from_bytes(data[-size:], "little") & (1 << 8 * size - 2) - 1
    return state, len(data) - size


class BinaryDecoder:
    """Bits with one fixed probability."""

    def __init__(self, buffer):
        self.one = 256 - buffer.u8()
        self.data = buffer.take(buffer.number())
        state, self.at = start_state(self.data, 3)
        self.state = state + 4096
        demand(self.state < 4096 << 8, ISSUE, "the state of an ANS stream")

    def bit(self):
        if self.state < 4096 and self.at:
            self.at -= 1
            self.state = self.state << 8 | self.data[self.at]
        rest, product = self.state & 255, (self.state >> 8) * self.one
        if rest < self.one:
            self.state = product + rest
            return True
        self.state -= product + self.one
        return False


class SymbolDecoder:
    """Symbols of an alphabet with the probabilities that precede them."""

    def __init__(self, buffer, bits):
        self.bits = min(max(3 * bits // 2, 12), 20)
        self._table(buffer)
        self.data = buffer.take(buffer.number())
        self.base = 4 << self.bits
        state, self.at = start_state(self.data, 4)
        self.state = state + self.base
        demand(self.state < self.base << 8, ISSUE, "the state of an ANS stream")

    def _table(self, buffer):
        count = buffer.number()
        demand(0 < count <= SYMBOLS, ISSUE, f"{count} symbols")
        self.probabilities = table = []
        while len(table) < count:
            byte = buffer.u8()
            if byte & 3 == 3:
                table += [0] * ((byte >> 2) + 1)
            else:
                value = byte >> 2
                for i in range(byte & 3):
                    value |= buffer.u8() << 8 * i + 6
                table.append(value)
        demand(len(table) == count, ISSUE, "a run of symbols beyond the alphabet")
        self.sums = [0]
        for value in table:
            self.sums.append(self.sums[-1] + value)
        demand(self.sums[-1] == 1 << self.bits, ISSUE, "sum of the probabilities")

    def symbol(self):
        while self.state < self.base and self.at:
            self.at -= 1
            self.state = self.state << 8 | self.data[self.at]
        rest = self.state & (1 << self.bits) - 1
        symbol = bisect_right(self.sums, rest) - 1
        self.state = (self.state >> self.bits) * self.probabilities[symbol] + rest - self.sums[symbol]
        return symbol


def symbols(buffer, count, components):
    """`count` unsigned numbers; with tags, each `components` of them share a number of bits."""
    if not count:
        return []
    scheme = buffer.u8()
    demand(scheme in (TAGGED, RAW), ISSUE, f"symbols of scheme {scheme}")
    bits = 5 if scheme == TAGGED else buffer.u8()
    demand(1 <= bits <= 18, ISSUE, f"an alphabet of {bits} bits")
    decoder = SymbolDecoder(buffer, bits)
    if scheme == RAW:
        return [decoder.symbol() for _ in range(count)]
    demand(len(decoder.probabilities) <= 33, ISSUE, "a tag of more than 32 bits")
    packed, out = Bits(buffer.data, buffer.at), []
    for _ in range(0, count, components):
        size = decoder.symbol()
        out += [packed.take(size) for _ in range(components)]
    buffer.at = packed.end()
    return out
