"""Who joins a stream late says so: cases have the report of such a reader, and the runner asks for it where a decoder offers it."""

import pytest
from fvv_conformance import cases, running
from reference.decoder import report

CASES = [case for case in cases.load(cases.default_folder()) if "joined" in case.expected]


def test_there_are_cases_of_both_kinds():
    assert {case.expected["joined"]["status"] for case in CASES} == {"whole", "damaged"}
    assert {case.expected["status"] for case in CASES} == {"whole", "damaged"}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_decoder_that_ignores_who_joined_is_found(case):
    parts = {"check", "mesh", "join"}
    asked = list(running.requests_for(case, parts))
    assert asked[1:] == [{"path": str(case.path), "live": True, "joined": True}]
    assert list(running.requests_for(case, parts - {"join"})) == asked[:1]
    right = [report(case.content), report(case.content, live=True, joined=True)]
    assert running.judge(case, right, parts) == []
    ignored = running.judge(case, [right[0]] * 2, parts)
    assert bool(ignored) == (case.tier == "faulty")
    assert all(line.startswith("joined: ") for line in ignored)


def test_what_is_not_offered_is_counted():
    (line,) = running.not_joined(CASES, {"mesh"})
    assert f"{len(CASES)} reports" in line
    assert list(running.not_joined(CASES, {"join"})) == []
