"""Readers that check name the same rule at the same chunk, whatever is wrong with a content."""

import pathlib
import sys

import pytest

CONFORMANCE = pathlib.Path(__file__).resolve().parent.parent.parent / "conformance"
sys.path.insert(0, str(CONFORMANCE))

from adapters import all as adapters  # noqa: E402
from adapters import contents  # noqa: E402
from fvv_conformance import cases, decoder  # noqa: E402

WHOLE = [case for case in cases.load(cases.default_folder()) if case.tier != "faulty"]


def test_two_readers_agree():
    names = ("libfvv", "reference")
    for name in names:
        if reason := adapters.missing(name):
            print(f"skipped: {name}: {reason}")
            pytest.skip(reason)
    pair = [decoder.Decoder(adapters.commands()[name][0], 60) for name in names]
    total, lines = contents.compare(pair, WHOLE, 3)
    for one in pair:
        one.close()
    assert total > 900
    assert lines == []


def test_a_wrong_content_is_in_a_right_container():
    """Nothing but the content can be what a reader finds: no rule of chunks, groups or the index is broken by accident."""
    from reference.decoder import report

    found = [report(stream) for _, stream in list(contents.streams(WHOLE[::20], 2, 1))]
    numbers = [int(one["issues"][0]["issue"][4:]) for one in found if one["issues"]]
    assert len(numbers) > 10
    assert sum(number >= 1300 for number in numbers) > len(numbers) / 2
    assert not any(1101 <= number <= 1105 for number in numbers)
