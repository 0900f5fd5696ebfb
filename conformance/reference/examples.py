"""The worked examples of spec/fvv.md, computed by the readers in this folder; spec/generate.py writes them."""

from collections import defaultdict
from typing import NamedTuple

from .decode import draco
from .decode.draco_edgebreaker import BY_NUMBER, Edgebreaker
from .decode.draco_symbols import Buffer
from .mesh import Mesh
from .mesh_delta import Levels, Sequence, Weights, predicted
from .mesh_patched import runs
from .range_coder import probability
from .visibility import Surface, decode_stream, side


class Script:
    """Takes the place of a range decoder: finds the given decisions and notes the estimate of each."""

    def __init__(self, decisions):
        self.decisions, self.estimates = iter(decisions), []

    def decision(self, context):
        self.estimates.append(probability(context))
        return next(self.decisions)

    def even(self):
        self.estimates.append(None)
        return next(self.decisions)

    def ends(self):
        return next(self.decisions, None) is None


def points(vertices):
    return ", ".join(str(v) for v in vertices)


def vectors(rows):
    return " ".join("(" + ", ".join(str(x) for x in row) + ")" for row in rows)


def grid(side):
    """A square of side * side vertices, 10 lattice steps apart, slightly bent so that few distances are equal."""
    positions = [(10 * x + y % 2, 10 * y + x % 3, x * y % 4) for y in range(side) for x in range(side)]
    corners = [side * y + x for y in range(side - 1) for x in range(side - 1)]
    faces = [face for a in corners for face in ((a, a + 1, a + side), (a + 1, a + side + 1, a + side))]
    return Mesh(positions, faces)


def levels():
    mesh = grid(6)
    found = Levels(mesh.positions, mesh.faces)
    survivors = sorted(found.neighbours)
    (level,) = found.levels
    taken = level[len(survivors) :]
    stencil = found.stencils[taken[3]]
    return [
        "A grid of 6 x 6 vertices, number 6 y + x at (10 x + y mod 2, 10 y + x mod 3, x y mod 4), with the faces",
        "(a, a + 1, a + 6) and (a + 1, a + 7, a + 6) for each cell. The first pass leaves 24 nodes, so there is no second",
        "one and one level:",
        "",
        f"    taken      {points(taken)}",
        f"    survivors  {points(survivors)}",
        f"    stencil of vertex {taken[3]}: nodes {points(node for node, _ in stencil)}",
        f"                          weights {points(weight for _, weight in stencil)}",
    ]


def weights():
    offsets = [(2, 2, 0), (42, -12, 30), (-37, -48, -35), (-47, -57, -1), (59, 49, 40), (59, 39, -58)]
    got = Weights(offsets)
    return [
        "Six nodes of which one has weight 0 in the end:",
        "",
        f"    u      = {vectors(got.u[:3])}",
        f"             {vectors(got.u[3:])}",
        f"    q      = {points(got.q)}",
        f"    w      = {points(got.w)}",
        f"    m      = {vectors([got.m])}",
        f"    C      = {vectors(got.c)}",
        f"    t      = {got.t}, h = {got.h}",
        f"    K      = {vectors(got.k)}",
        f"    d      = {got.d}, g = {vectors([got.g])}",
        f"    c      = {points(got.corrections)}",
        f"    weight = {points(got.weights)}",
    ]


def motion():
    former, moved, step, residual = 1013, [(40000, 6), (25536, -3)], 6, -5
    state = predicted(former, moved, step)
    # A mesh of which one vertex has a stencil of three nodes; what is asked of the decoder comes from the reader.
    sequence = Sequence(Mesh([(0, 0, 0), (9, 0, 0), (0, 9, 0), (0, 0, 9)], [(0, 1, 2), (1, 2, 3)]))
    sequence.now = [[0] * 3, [3, 0, 0], [-1, 0, 0], [20, 0, 0]]
    sequence.before[0] = [-4, 0, 0]
    sequence.last[0] = [1, 0, 0]
    contexts = defaultdict(lambda: [32768, 32768])
    script = Script([1, 1, 1, 0, 0, 1, 1])
    assert sequence.residual(0, 0, [1, 2, 3], 0, script, contexts) == residual and script.ends()
    some, *more, first, negative = contexts
    return [
        f"On one axis the state was {former}, the nodes of a stencil have the weights {points(w for w, _ in moved)} and the",
        f"motions {points(m for _, m in moved)}, and the step is {step}:",
        "",
        f"    sum       = {sum(w * m for w, m in moved)}; {former} + ((sum + 32768) >> 16) = "
        f"{former + (sum(w * m for w, m in moved) + 32768 >> 16)}",
        f"    predicted = {state}, a multiple of G = 2",
        f"    residual  = {residual}: state {state + residual * step}, motion {state + residual * step - former}, "
        f"position {state + residual * step + 2 >> 2}",
        "",
        "The residual is on x, those of the nodes around are 3, -1 and 20, the vertex had -4 in the previous frame and a",
        "positive residual before that. The sum of magnitudes is 3 + 1 + 15 = 19, which is class "
        f"{some[1][1]}. Decisions and contexts:",
        "",
        f"    some      1        axis {some[1][0]}, around {some[1][1]}, before {some[1][2]}, preceding axes {some[1][3]}",
        *(
            f"    more      {bit}        around {key[1]}, {key[2]} before"
            for bit, key in zip((1, 1, 0), more)
        ),
        f"    digits    0, 1     the first with the context of {first[1]} digits, the second with even odds",
        f"    negative  1        axis {negative[1][0]}, last sign {negative[1][1]:+}, around {negative[1][2]:+}",
    ]


OCTAHEDRON = Mesh(
    [(90, 0, 0), (-90, 0, 0), (0, 90, 0), (0, -90, 0), (0, 0, 90), (0, 0, -90)],
    [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)],
)


def visibility():
    mesh, camera = OCTAHEDRON, (2000, 900, 300)
    surface = Surface(6, mesh.faces)
    facing = surface.facing(mesh.positions, camera, 0)
    former = [4, 0, 2, 1, 2, 3]
    sides, levels = [1, 1, 0, 1, 0], [1, 0, 1, 1, 0, 0, 1]
    script = Script([*sides, *levels])
    states = decode_stream(script, surface, facing, former)
    assert script.ends()
    order = [vertex for vertex in surface.order if facing[vertex]]
    rows, counts = [], [defaultdict(int), defaultdict(int)]
    for vertex, bit, estimate in zip(order, sides, script.estimates):
        hidden, seen = (sum(count[face] for face in surface.around[vertex]) for count in counts)
        rim = int(not all(facing[c] for c in surface.corners(vertex)))
        rows.append((vertex, side(former[vertex]), seen, hidden, rim, estimate, bit))
        for face in surface.around[vertex]:
            counts[bit][face] += 1
    more = []
    decisions, estimates = iter(levels), iter(script.estimates[len(sides) :])
    for vertex, bit in zip(order, sides):
        others = sum(facing[c] and sides[order.index(c)] != bit for c in surface.corners(vertex))
        before = (former[vertex] + 1) // 2 if side(former[vertex]) == 1 + bit else 0
        taken = [next(decisions) for _ in range(min((states[vertex] - 1) // 2 + 1, 2))] if others else []
        chances = points(next(estimates) for _ in taken)
        more.append((vertex, before, others, chances, points(taken), states[vertex]))
    faces = ", ".join(f"{i} ({points(face)})" for i, face in enumerate(mesh.faces))
    return [
        "An octahedron with the vertices (90, 0, 0), (-90, 0, 0), (0, 90, 0), (0, -90, 0), (0, 0, 90), (0, 0, -90) and the",
        f"faces {faces}.",
        f"The camera is at {camera}; the threshold is 0. Coding order: {points(surface.order)}. Vertices that face the camera:",
        f"{points(order)}. Their states in the previous chunk were {points(former[v] for v in order)}.",
        "p is the probability of a 1 in units of 2^-12:",
        "",
        "    vertex   f   sum of 1s   sum of 0s   rim   p      decision",
        *(f"    {v:<8} {f:<3} {s:<11} {h:<11} {rim:<5} {p:<6} {bit}" for v, f, s, h, rim, p, bit in rows),
        "",
        "    vertex   e   others   p            decisions   state",
        *(f"    {v:<8} {e:<3} {o:<8} {p:<12} {bits:<11} {state}" for v, e, o, p, bits, state in more),
    ]


def patched():
    first = points(runs([face in (3, 4, 5) for face in range(10)]))
    second = points(runs([face == 0 or face >= 7 for face in range(9)]))
    return [
        "A base mesh has 10 faces. A patched frame leaves out faces 3, 4 and 5, and has a patch of 2 faces, which",
        "become faces 7 and 8. The next patched frame leaves out these and face 0. The runs are",
        "",
        f"    first     {first}",
        f"    second    {second}",
    ]


BITSTREAM = bytes.fromhex(
    "445241434f02020101000000040400030000012f01011001ff000001000503000001"
    "0101010009030110012013011003005c90c7c7c8a1059cffffff64000000"
)


class Counts(NamedTuple):
    vertices: int
    faces: int
    attributes: int


class Followed(Edgebreaker):
    """Notes what each symbol does."""

    def _add(self, symbol, number):
        self.rows = [*getattr(self, "rows", []), ["CSLRE"[BY_NUMBER.index(symbol)], 3 * number]]
        super()._add(symbol, number)
        face = self.corners.vertex[3 * number : 3 * number + 3]
        self.rows[-1] += [points(face), self.stack[-1]]


def tetrahedron_by_draco():
    header, buffer = Counts(4, 4, 0), Buffer(BITSTREAM, 11)
    followed = Followed(buffer, header)
    after_connectivity = buffer.at
    components, by_degree = draco.check_attributes(buffer, header, True)
    assert not by_degree
    after_headers = buffer.at
    order = draco.Order(followed.corners)
    order.depth_first()
    values = draco.Attribute(buffer, components[0], 4, order)
    assert buffer.left() == 0
    wrap = values.wrap
    flat = followed.corners.vertex
    faces = [tuple(flat[i : i + 3]) for i in range(0, len(flat), 3)]
    corners = order.corners
    rows = [
        (e, corners[e], flat[corners[e]], *vectors([values.corrections[e], values.rows[e]]).split(" ("))
        for e in range(4)
    ]
    text = BITSTREAM.hex(" ")
    return [
        f"A tetrahedron with the corners (100, 100, 100), (100, -100, -100), (-100, 100, -100), (-100, -100, 100), {len(BITSTREAM)} bytes:",
        "",
        *(f"    {at // 3:>3}    {text[at : at + 72].strip()}" for at in range(0, len(text), 72)),
        "",
        f"Bytes 11 to {after_connectivity - 1} are the connectivity: standard traversal, {header.vertices} points, {header.faces} faces, {followed.count} symbols, {followed.splits} splits,",
        f"{len(followed.events)} events, a byte of symbols and the flag of one start face. Each symbol with its first corner c, V of its corners, and the active corner afterwards:",
        "",
        "    symbol   c   vertices   active",
        *(f"    {symbol:<8} {c:<3} {vertices:<10} {active}" for symbol, c, vertices, active in followed.rows),
        "",
        f"The start face becomes {faces[-1]}; all faces are {', '.join(map(str, faces))}. Bytes {after_connectivity} to {after_headers - 1} declare one position of",
        f"integers in the order depth first. Its values are predicted by a parallelogram, and lie between {wrap.least} and {wrap.most}:",
        "",
        "    entry   corner   vertex   correction           value",
        *(f"    {e:<7} {corner:<8} {vertex:<8} {one:<20} ({other}" for e, corner, vertex, one, other in rows),
    ]


EXAMPLES = {"runs": patched, "levels": levels, "weights": weights, "motion": motion, "visibility": visibility}
EXAMPLES["draco"] = tetrahedron_by_draco
