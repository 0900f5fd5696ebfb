"""fvv-conformance show: what a case is, and the values of an array that a decoder has hashed differently.

Hashes say only that arrays differ. The reference decoder, which is in the checkout and not in the package, has the values; a decoder
that writes its own to a file is compared with them.
"""

import pathlib
import sys

from .cases import BadCase

#: By the last word of an array's name, or its first: numpy's type and the numbers of a row (PROTOCOL.md, Frames).
TYPES = {
    "lattice": ("<i4", 3),
    "faces": ("<u4", 3),
    "positions": ("<f4", 3),
    "uvs": ("<f4", 2),
    "normals": ("<f4", 3),
    "colours": ("u1", 3),
    "visibility": ("u1", 1),
    "camera": ("<f8", 26),
    "sample": ("u1", 16),
    "key": ("u1", 1),
    "tiles": ("<u4", 9),
    "texturing": ("<f8", 6),
}
ROWS = 8


def add_parser(commands):
    one = commands.add_parser("show", help="print a case, or the values of one of its arrays")
    one.add_argument("case", metavar="CASE", help="such as valid/mesh_raw, or its name alone")
    one.add_argument("--array", metavar="NAME", help="such as mesh/1/lattice; default: the names of all")
    one.add_argument(
        "--time", metavar="T", type=int, help="of the frame, in ticks; default: the first that has it"
    )
    one.add_argument(
        "--against", metavar="FILE", type=pathlib.Path, help="what your decoder has as that array: raw bytes"
    )
    return one


def type_of(name):
    words = name.split("/")
    return TYPES.get(words[-1]) or TYPES[words[0]]


def rows_of(name, data):
    import numpy

    kind, width = type_of(name)
    numbers = numpy.frombuffer(data, kind, len(data) // numpy.dtype(kind).itemsize)
    return [tuple(numbers[i : i + width].tolist()) for i in range(0, len(numbers), width)]


def frames_of(content):
    """(time, arrays as bytes) of each whole frame, by the reference decoder."""
    folder = pathlib.Path(__file__).resolve().parent.parent
    if not (folder / "reference").exists():
        raise BadCase("show --array needs the reference decoder: use conformance/run of a checkout")
    sys.path.insert(0, str(folder))
    try:
        from reference.decoder import read
    except ImportError as error:
        raise BadCase(f"the reference decoder needs numpy: {error}") from error
    return [frame for group in read(content, read(content, {}).blocks).groups for frame in group.contents()]


def print_array(name, time, data):
    rows = rows_of(name, data)
    print(f"{name} at {time}: {len(data)} bytes, {len(rows)} rows of {type_of(name)[0].lstrip('<')}")
    for i, row in enumerate(rows[:ROWS]):
        print(f"  {i}: {' '.join(f'{value:.9g}' for value in row)}")
    if len(rows) > ROWS:
        print(f"  and {len(rows) - ROWS} more")


def compare(name, wanted, found):
    """Prints the first rows that differ, and returns whether the arrays are equal."""
    ours, theirs = rows_of(name, wanted), rows_of(name, found)
    differing = [i for i, (a, b) in enumerate(zip(ours, theirs)) if a != b]
    if len(wanted) != len(found):
        print(f"{len(found)} bytes, expected {len(wanted)}")
    print(f"{len(differing)} of {min(len(ours), len(theirs))} rows differ")
    for i in differing[:ROWS]:
        print(
            f"  {i}: {' '.join(f'{v:.9g}' for v in theirs[i])}, expected {' '.join(f'{v:.9g}' for v in ours[i])}"
        )
    return wanted == found


def show(arguments, cases):
    """0, or 1 if the arrays differ."""
    found = [case for case in cases if arguments.case in (case.name, case.name.split("/")[-1])]
    if not found:
        raise BadCase(f"{arguments.case}: no case has this name; fvv-conformance list prints all")
    case = found[0]
    print(f"{case.name}: {case.expected['title']}")
    for row in case.expected["issues"]:
        print(f"  first issue {row['issue']} at {row['offset']}")
    if not arguments.array:
        for frame in case.expected["frames"]:
            print(f"  frame {frame['time']}: {' '.join(frame['arrays'])}")
        return 0
    for time, arrays in frames_of(case.content):
        if arguments.array in arrays and arguments.time in (None, time):
            data = arrays[arguments.array]
            print_array(arguments.array, time, data)
            if not arguments.against:
                return 0
            return 0 if compare(arguments.array, data, arguments.against.read_bytes()) else 1
    where = "" if arguments.time is None else f" at {arguments.time}"
    raise BadCase(f"{case.name}: no whole frame{where} has the array {arguments.array}")
