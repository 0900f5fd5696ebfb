"""Streams that begin with any group: right for a reader whose caller says that it joined late, and for no other. Clause 6.1."""

from ..case import faulty, valid
from ..recipes import block, group, opened


def from_seven(*steps):
    """Groups from number 7 on. steps: how many numbers are left out before each of the others."""
    s = opened()
    s.sequence = 7
    s.raw(b"", fault=1205)
    group(s, 14)
    for i, step in enumerate(steps):
        s.sequence += step
        group(s, 16 + 2 * i)
    return s


def repeated():
    s = opened()
    group(s, 0)
    block(s)
    group(s, 2)
    return s


faulty(
    "sequence_first_live",
    "A stream without a footer begins with the number 7: it is whole for who joined late.",
    "6.1 6.4",
    lambda: from_seven(0, 0),
    joined="whole",
)
faulty(
    "sequence_first_live_gap",
    "The same, and a group is missing later, for who joined late too.",
    "6.1 6.4",
    lambda: from_seven(0, 1, 0),
    joined="damaged",
)
valid(
    "joined_at_zero",
    "Who joins late may meet the first group, and a repeated block.",
    "6.1 6.4",
    repeated,
    joined="whole",
)
