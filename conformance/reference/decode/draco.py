"""Meshes in the Draco profile: spec/draco.md, and the density bound of clause 8.4 of spec/fvv.md.

Here are clauses 1, 3 and 5 to 7 of spec/draco.md; entropy coding is in draco_symbols.py, edgebreaker in draco_edgebreaker.py.
"""

from ..container import demand, unzigzag
from .draco_edgebreaker import NONE, Edgebreaker, following, preceding
from .draco_symbols import ISSUE, BinaryDecoder, Buffer, symbols

SEQUENTIAL, EDGEBREAKER = 0, 1
POSITION, NORMAL, TEX_COORD, INT32, INTEGERS = 0, 1, 3, 5, 1
DIFFERENCE, PARALLELOGRAM, MULTI_PARALLELOGRAM = 0, 1, 4
WRAP = 1
MOST_PARALLELOGRAMS = 4


class Sequential:
    """Connectivity of method 0: corners are listed, in numbers whose size depends on the points."""

    def __init__(self, buffer, header):
        faces, points = buffer.number(), buffer.number()
        demand((points, faces) == (header.vertices, header.faces), 3008, f"{points} points, {faces} faces")
        way = buffer.u8()
        demand(way == 1, ISSUE, f"corners in way {way}")
        if 1 << 16 <= points < 1 << 21:
            self.indices = [buffer.number() for _ in range(3 * faces)]
            return
        self.indices = buffer.rows(1 if points < 1 << 8 else 2 if points < 1 << 16 else 4, 3 * faces)


class Order:
    """The order in which the values of vertices are coded: each vertex with the corner at which it was reached."""

    def __init__(self, corners):
        self.table, self.corners, self.entry = corners, [], [None] * len(corners.leftmost)
        self.visited = [False] * (len(corners.vertex) // 3)

    def seen(self, corner):
        return corner == NONE or self.visited[corner // 3]

    def meet(self, corner):
        """Returns whether the vertex is new."""
        vertex = self.table.vertex[corner]
        if self.entry[vertex] is not None:
            return False
        self.entry[vertex] = len(self.corners)
        self.corners.append(corner)
        return True

    def sides(self, corner):
        opposite = self.table.opposite
        return opposite[following(corner)], opposite[preceding(corner)]

    def depth_first(self):
        for first in range(0, len(self.table.vertex), 3):
            if self.seen(first):
                continue
            stack = [first]
            self.meet(following(first))
            self.meet(preceding(first))
            while stack:
                if self.seen(stack[-1]):
                    stack.pop()
                else:
                    self._strip(stack)

    def _strip(self, stack):
        corner = stack[-1]
        while True:
            self.visited[corner // 3] = True
            right, left = self.sides(corner)
            if self.meet(corner) and not self.table.at_border(self.table.vertex[corner]):
                corner = right
            elif self.seen(right) and self.seen(left):
                stack.pop()
                return
            elif self.seen(right):
                corner = left
            elif self.seen(left):
                corner = right
            else:
                stack[-1:] = [left, right]
                return

    def by_degree(self):
        self.degree, self.stacks, self.best = [0] * len(self.entry), ([], [], []), 0
        for first in range(0, len(self.table.vertex), 3):
            self.stacks[0].append(first)
            self.best = 0
            for corner in following(first), preceding(first), first:
                self.meet(corner)
            corner = self._next()
            while corner is not None:
                if not self.seen(corner):
                    self._run(corner)
                corner = self._next()

    def _next(self):
        for priority in range(self.best, 3):
            if self.stacks[priority]:
                self.best = priority
                return self.stacks[priority].pop()
        return None

    def _run(self, corner):
        while corner is not None:
            self.visited[corner // 3] = True
            self.meet(corner)
            right, left = self.sides(corner)
            corner = None
            if not self.seen(left):
                priority = self._priority(left)
                if self.seen(right) and priority <= self.best:
                    corner = left
                    continue
                self._push(left, priority)
            if not self.seen(right):
                priority = self._priority(right)
                if priority <= self.best:
                    corner = right
                    continue
                self._push(right, priority)

    def _push(self, corner, priority):
        self.stacks[priority].append(corner)
        self.best = min(self.best, priority)

    def _priority(self, corner):
        vertex = self.table.vertex[corner]
        if self.entry[vertex] is not None:
            return 0
        self.degree[vertex] += 1
        return 1 if self.degree[vertex] > 1 else 2


def signed(value):
    """The integer of 32 bits that is equal modulo 2^32."""
    return (value + 2**31) % 2**32 - 2**31


class Wrap:
    """Corrections modulo the range of the values."""

    def __init__(self, buffer):
        self.least, self.most = buffer.i32(), buffer.i32()
        self.span = 1 + self.most - self.least
        demand(0 < self.span < 1 << 31, ISSUE, "range of the values")

    def value(self, predicted, correction):
        value = signed(min(max(predicted, self.least), self.most) + correction)
        if value > self.most:
            return value - self.span
        return value + self.span if value < self.least else value


class Attribute:
    """The values of one attribute, a row for each entry of the order."""

    def __init__(self, buffer, components, count, order):
        self.width, self.order, self.rows = components, order, []
        method = buffer.i8()
        allowed = (DIFFERENCE, PARALLELOGRAM, MULTI_PARALLELOGRAM) if order else (DIFFERENCE,)
        demand(method in allowed, ISSUE, f"prediction {method}")
        demand(buffer.i8() == WRAP, ISSUE, "a transform other than wrap")
        numbers = [unzigzag(number) for number in self._numbers(buffer, components * count)]
        self.corrections = [numbers[i : i + components] for i in range(0, len(numbers), components)]
        if method == MULTI_PARALLELOGRAM:
            self.creases = [self._creases(buffer, 3 * len(order.visited)) for _ in range(MOST_PARALLELOGRAMS)]
            self.used = [0] * MOST_PARALLELOGRAMS
        self.wrap = Wrap(buffer)
        predict = {DIFFERENCE: self._last, PARALLELOGRAM: self._one, MULTI_PARALLELOGRAM: self._several}[
            method
        ]
        for entry, correction in enumerate(self.corrections):
            predicted = predict(entry) if entry else [0] * components
            self.rows.append([self.wrap.value(p, c) for p, c in zip(predicted, correction)])

    def _numbers(self, buffer, count):
        coded = buffer.u8()
        demand(coded < 2, ISSUE, f"numbers in way {coded}")
        if coded:
            return symbols(buffer, count, self.width)
        size = buffer.u8()
        demand(1 <= size <= 4, ISSUE, f"numbers of {size} bytes")
        return buffer.rows(size, count)

    def _creases(self, buffer, corners):
        count = buffer.number()
        demand(count <= corners, ISSUE, f"{count} crease flags")
        if not count:
            return []
        decoder = BinaryDecoder(buffer)
        return [decoder.bit() for _ in range(count)]

    def _last(self, entry):
        return self.rows[-1]

    def _parallelogram(self, entry, corner):
        """The fourth corner of the parallelogram on the face opposite to a corner, or None."""
        table, known = self.order.table, self.order.entry
        opposite = table.opposite[corner]
        if opposite == NONE:
            return None
        corners = opposite, following(opposite), preceding(opposite)
        far, after, before = (known[table.vertex[c]] for c in corners)
        if max(far, after, before) >= entry:
            return None
        return [signed(a + b - f) for a, b, f in zip(self.rows[after], self.rows[before], self.rows[far])]

    def _one(self, entry):
        return self._parallelogram(entry, self.order.corners[entry]) or self.rows[-1]

    def _several(self, entry):
        found = []
        for corner in self._around(self.order.corners[entry]):
            predicted = self._parallelogram(entry, corner)
            if predicted:
                found.append(predicted)
                if len(found) == MOST_PARALLELOGRAMS:
                    break
        flags, smooth = len(found) - 1, []
        for predicted in found:
            demand(self.used[flags] < len(self.creases[flags]), ISSUE, "too few crease flags")
            if not self.creases[flags][self.used[flags]]:
                smooth.append(predicted)
            self.used[flags] += 1
        if not smooth:
            return self.rows[-1]
        sums = [signed(sum(column)) for column in zip(*smooth)]
        return [abs(s) // len(smooth) * (1 if s >= 0 else -1) for s in sums]

    def _around(self, first):
        """The corners of a vertex from one on to the left; at a border, from there to the right of the first."""
        corner = first
        while corner != NONE:
            yield corner
            corner = self.order.table.left(corner)
            if corner == first:
                return
        corner = self.order.table.right(first)
        while corner not in (NONE, first):
            yield corner
            corner = self.order.table.right(corner)


def check_attributes(buffer, header, edgebreaker):
    """The numbers of components of the attributes; everything about them but the values is fixed."""
    demand(buffer.u8() == 1, 3010, "attributes decoders")
    by_degree = False
    if edgebreaker:
        demand(buffer.i8() == -1 and buffer.u8() == 0, 3010, "attributes that are not coded per vertex")
        way = buffer.u8()
        demand(way < 2, ISSUE, f"order of vertices {way}")
        by_degree = way == 1
    wanted = [(POSITION, 3)]
    wanted += [(TEX_COORD, 2)] if header.attributes & 1 else []
    wanted += [(NORMAL, 2)] if header.attributes & 2 else []
    demand(buffer.number() == len(wanted), 3010, "number of attributes")
    for kind, components in wanted:
        found = tuple(buffer.take(4))
        demand(found == (kind, INT32, components, 0), 3010, f"attribute {found}")
        buffer.number()
    for _ in wanted:
        demand(buffer.u8() == INTEGERS, 3010, "values that are not coded as integers")
    return [components for _, components in wanted], by_degree


def check_density(data, header):
    demand(max(header.vertices, header.faces) <= 16 * len(data), 3012, f"{len(data)} bytes")


def decode(data, header):
    """The attributes of a bitstream, each a list with a row for each vertex, and its faces, as a list of corners."""
    check_density(data, header)
    demand(len(data) >= 11 and data[:7] == b"DRACO\2\2" and data[7] == 1, 3007, "header")
    demand(data[8] in (SEQUENTIAL, EDGEBREAKER) and data[9:11] == b"\0\0", 3007, "method or flags")
    buffer = Buffer(data, 11)
    edgebreaker = data[8] == EDGEBREAKER
    connectivity = (Edgebreaker if edgebreaker else Sequential)(buffer, header)
    components, by_degree = check_attributes(buffer, header, edgebreaker)
    order, indices = None, None
    if edgebreaker:
        order, indices = Order(connectivity.corners), connectivity.corners.vertex
        (order.by_degree if by_degree else order.depth_first)()
        demand(len(order.corners) == header.vertices, ISSUE, "vertices that no face uses")
    else:
        indices = connectivity.indices
    values = []
    for width in components:
        rows = Attribute(buffer, width, header.vertices, order).rows
        if order:
            rows = [rows[entry] for entry in order.entry]
        values.append(rows)
    demand(buffer.left() == 0, ISSUE, f"{buffer.left()} bytes follow the bitstream")
    return values, indices
