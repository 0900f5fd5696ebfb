"""The connectivity of Draco's edgebreaker method, traversals standard and valence: clause 4 of spec/draco.md.

A corner is 3 * face + 0, 1 or 2.
"""

from ..container import demand
from .draco_symbols import ISSUE, BinaryDecoder, Bits, symbols

C, S, L, R, E = 0, 1, 3, 5, 7
BY_NUMBER = (C, S, L, R, E)
STANDARD, VALENCE = 0, 2
NONE = -1
LEAST_VALENCE, MOST_VALENCE = 2, 7
STEPS = 16  # per face, FVV-3013


def following(corner):
    return corner - 2 if corner % 3 == 2 else corner + 1


def preceding(corner):
    return corner + 2 if corner % 3 == 0 else corner - 1


class Corners:
    """vertex, opposite: of each corner; leftmost: a corner of each vertex, the left one at a border."""

    def __init__(self, faces):
        self.vertex, self.opposite, self.leftmost = [NONE] * 3 * faces, [NONE] * 3 * faces, []

    def add_vertex(self, corner):
        self.leftmost.append(corner)
        self.vertex[corner] = len(self.leftmost) - 1

    def join(self, a, b):
        self.opposite[a], self.opposite[b] = b, a

    def left(self, corner):
        """The next corner of the same vertex, to the left."""
        opposite = self.opposite[following(corner)]
        return NONE if opposite == NONE else following(opposite)

    def right(self, corner):
        opposite = self.opposite[preceding(corner)]
        return NONE if opposite == NONE else preceding(opposite)

    def around(self, vertex):
        """The corners of a vertex: to the left up to the border or the first again, then to the right of the first."""
        first = corner = self.leftmost[vertex]
        while corner != NONE:
            yield corner
            corner = self.left(corner)
            if corner == first:
                return
        corner = self.right(first)
        while corner != NONE:
            yield corner
            corner = self.right(corner)

    def at_border(self, vertex):
        return self.left(self.leftmost[vertex]) == NONE


class StandardSymbols:
    def __init__(self, buffer):
        size = buffer.number()
        self.bits = Bits(buffer.take(size))
        self.start_faces = BinaryDecoder(buffer)

    def symbol(self):
        return 1 + 2 * self.bits.take(2) if self.bits.take(1) else C

    def merge(self, kept, lost):
        pass

    def reached(self, corners, corner):
        pass

    def all_used(self):
        return self.bits.end() == len(self.bits.data)


class ValenceSymbols:
    """The list from which a symbol comes depends on the valence of the active vertex."""

    def __init__(self, buffer, vertices):
        self.start_faces = BinaryDecoder(buffer)
        self.lists = [symbols(buffer, buffer.number(), 1) for _ in range(LEAST_VALENCE, MOST_VALENCE + 1)]
        self.valences, self.active, self.last = [0] * vertices, None, None

    def symbol(self):
        self.last = E
        if self.active is not None:
            demand(self.lists[self.active], ISSUE, "too few symbols for a valence")
            number = self.lists[self.active].pop()
            demand(number < len(BY_NUMBER), ISSUE, f"symbol {number}")
            self.last = BY_NUMBER[number]
        return self.last

    def merge(self, kept, lost):
        self.valences[kept] += self.valences[lost]

    def reached(self, corners, corner):
        here, after, before = {C: (0, 1, 1), S: (0, 1, 1), R: (1, 1, 2), L: (1, 2, 1), E: (2, 2, 2)}[
            self.last
        ]
        self.valences[corners.vertex[corner]] += here
        self.valences[corners.vertex[following(corner)]] += after
        self.valences[corners.vertex[preceding(corner)]] += before
        valence = self.valences[corners.vertex[following(corner)]]
        self.active = min(max(valence, LEAST_VALENCE), MOST_VALENCE) - LEAST_VALENCE

    def all_used(self):
        return not any(self.lists)


def split_events(buffer, count):
    """(source symbol, split symbol, whether on the right) of each topology split, by rising source."""
    events, source = [], 0
    for _ in range(count):
        source += buffer.number()
        distance = buffer.number()
        demand(distance <= source, ISSUE, "a topology split before the first symbol")
        events.append((source, source - distance))
    bits = Bits(buffer.data, buffer.at)
    edges = [bits.take(1) for _ in events]
    buffer.at = bits.end()
    return [(*event, edge) for event, edge in zip(events, edges)]


class Edgebreaker:
    """corners: the connectivity, with vertices numbered as Draco outputs them."""

    def __init__(self, buffer, header):
        traversal = buffer.u8()
        demand(traversal in (STANDARD, VALENCE), ISSUE, f"traversal {traversal}")
        points, faces = buffer.number(), buffer.number()
        demand((points, faces) == (header.vertices, header.faces), 3008, f"{points} points, {faces} faces")
        demand(buffer.u8() == 0, 3010, "attributes with seams")
        self.count, self.splits = buffer.number(), buffer.number()
        count, splits = self.count, self.splits
        demand(count <= faces <= count + count // 3, ISSUE, f"{count} symbols of {faces} faces")
        event_count = buffer.number()
        demand(splits <= count and event_count <= count, ISSUE, "splits")
        self.events = split_events(buffer, event_count)
        self.most = points + splits
        self.symbols = StandardSymbols(buffer) if traversal == STANDARD else ValenceSymbols(buffer, self.most)
        self.corners, self.faces, self.steps, self.stack = Corners(faces), 0, 0, []
        self.split_corners, self.lost, joined = {}, [], 0
        for number in range(count):
            symbol = self.symbols.symbol()
            joined += symbol == S
            self._add(symbol, number)
        demand(joined == splits, ISSUE, f"{joined} S symbols, {splits} declared")
        demand(self.symbols.all_used(), ISSUE, "the symbols do not fill their bytes")
        self._start_faces(faces)
        self._renumber()
        demand(len(self.corners.leftmost) == points, ISSUE, f"{len(self.corners.leftmost)} vertices")

    def _step(self, count=1):
        self.steps += count
        demand(self.steps <= STEPS * len(self.corners.vertex) // 3, 3013, "too many steps")

    def _free(self, *free):
        for i, corner in enumerate(free):
            demand(
                corner not in free[:i] and self.corners.opposite[corner] == NONE, ISSUE, "an edge is taken"
            )

    def _add(self, symbol, number):
        corner = 3 * self.faces
        self.faces += 1
        demand(symbol == E or self.stack, ISSUE, "no active edge")
        if symbol == E:
            for i in range(3):
                self.corners.add_vertex(corner + i)
            self.stack.append(corner)
        else:
            {C: self._close, R: self._extend, L: self._extend, S: self._join}[symbol](corner, symbol, number)
            self.stack[-1] = corner
        demand(len(self.corners.leftmost) <= self.most, ISSUE, "too many vertices")
        self.symbols.reached(self.corners, corner)
        if symbol in (R, L, E):
            self._split(number)

    def _close(self, corner, symbol, number):
        """C: a face between two neighbouring edges of the border."""
        table, a = self.corners, self.stack[-1]
        x = table.vertex[following(a)]
        b = following(table.leftmost[x])
        self._free(a, b)
        table.join(a, corner + 1)
        table.join(b, corner + 2)
        before, after = table.vertex[preceding(a)], table.vertex[following(b)]
        demand(x not in (before, after), ISSUE, "a face with one vertex twice")
        table.vertex[corner : corner + 3] = x, after, before
        table.leftmost[before] = corner + 2

    def _extend(self, corner, symbol, number):
        """R and L: a face with a new vertex."""
        table, a = self.corners, self.stack[-1]
        self._free(a)
        new, left, right = (
            (corner + 2, corner + 1, corner) if symbol == R else (corner + 1, corner, corner + 2)
        )
        table.join(new, a)
        table.add_vertex(new)
        vertex = table.vertex[right] = table.vertex[preceding(a)]
        table.leftmost[vertex] = right
        table.vertex[left] = table.vertex[following(a)]

    def _join(self, corner, symbol, number):
        """S: a face that joins two borders; one vertex of each becomes one."""
        table, b = self.corners, self.stack.pop()
        if number in self.split_corners:
            self.stack.append(self.split_corners[number])
        demand(self.stack, ISSUE, "no active edge")
        a = self.stack[-1]
        self._free(a, b)
        table.join(a, corner + 2)
        table.join(b, corner + 1)
        kept, before = table.vertex[preceding(a)], table.vertex[preceding(b)]
        table.vertex[corner : corner + 3] = kept, table.vertex[following(a)], before
        table.leftmost[before] = corner + 2
        at = first = following(b)
        lost = table.vertex[at]
        demand(lost != kept, ISSUE, "a vertex is joined with itself")
        self.symbols.merge(kept, lost)
        table.leftmost[kept] = table.leftmost[lost]
        self._step()  # a vertex at a border has an edge more than corners
        while at != NONE:
            self._step()
            table.vertex[at] = kept
            at = table.left(at)
            demand(at != first, ISSUE, "a vertex is joined with itself")
        table.leftmost[lost] = NONE
        self.lost.append(lost)

    def _split(self, number):
        """Remembers the edges at which later S symbols find their other border."""
        source = self.count - number - 1
        while self.events and self.events[-1][0] >= source:
            found, split, right = self.events.pop()
            demand(found == source, ISSUE, "a topology split at no symbol")
            corner = following(self.stack[-1]) if right else preceding(self.stack[-1])
            self.split_corners[self.count - split - 1] = corner

    def _start_faces(self, faces):
        table = self.corners
        while self.stack:
            corner = self.stack.pop()
            if not self.symbols.start_faces.bit():
                continue
            demand(self.faces < faces, ISSUE, "too many faces")
            n = table.vertex[following(corner)]
            b = following(table.leftmost[n])
            x = table.vertex[following(b)]
            c = following(table.leftmost[x])
            self._free(corner, b, c)
            new = 3 * self.faces
            self.faces += 1
            for i, other in enumerate((corner, b, c)):
                table.join(new + i, other)
            table.vertex[new : new + 3] = x, table.vertex[following(c)], n
        demand(self.faces == faces, ISSUE, f"{self.faces} faces")

    def _renumber(self):
        """The last vertices take the numbers of those that were joined with others."""
        table = self.corners
        count = len(table.leftmost)
        for number in self.lost:
            while count and table.leftmost[count - 1] == NONE:
                count -= 1
            last = count - 1
            if last < number:
                continue
            self._step(table.at_border(last))
            for corner in list(table.around(last)):
                self._step()
                demand(table.vertex[corner] == last, ISSUE, "a vertex of two parts")
                table.vertex[corner] = number
            table.leftmost[number] = table.leftmost[last]
            table.leftmost[last] = NONE
            count -= 1
        del table.leftmost[count:]
