"""The list of cases, and their files: input.fvv and expected.json of each."""

import json
import pathlib
import re
from typing import NamedTuple

from reference import possible, questions
from reference.container import DATA
from reference.decoder import read, report

CASES = pathlib.Path(__file__).resolve().parent.parent / "cases"
FORMAT = f"{DATA['format']['major']}.{DATA['format']['minor']}"
MOST_BYTES = 65535  # of one input
FILES = ("input.fvv", "expected.json")  # of one case
# Rules that make a reader stop: what was found before is all that there is. Others leave the rest usable.
# Each chunk decodes all the same: attributes that differ within a group, an environment that is not needed or known
# already, a codec of sound that players skip.
NEEDS_CHECK = {3016, 3032, 4302, 8003, 8004}
REFUSED = {1001, 1004, 1005, 1106, 1108}
# Faults that cost an ancillary chunk or one track, and no frame: clause 5.
ANCILLARY = (b"META", b"TEXR", b"ACFG", b"DCFG")
STOPPED = {2205, 2206, 4002}


class Case(NamedTuple):
    """make: returns a writer.Stream or bytes. refused: nothing after the fault is read, although the rule's number allows it.
    limits: it is beyond the limits that every reader supports (clause 13). questions: requests on single frames (PROTOCOL.md).
    joined: the status for a reader that joined late."""

    tier: str
    name: str
    title: str
    clauses: tuple
    rules: tuple
    requirements: tuple
    make: object
    needs_check: bool = False
    refused: bool = False
    source: str = ""
    limits: bool = False
    questions: tuple = ()
    joined: str = ""


_cases = {}


def add(case):
    if not re.fullmatch(r"[a-z0-9_]+", case.name):
        raise ValueError(f"{case.name}: not a name of lower-case letters, digits and _")
    if (case.tier, case.name) in _cases:
        raise ValueError(f"{case.tier}/{case.name} exists twice")
    _cases[case.tier, case.name] = case


def issue(number):
    return f"FVV-{number}"


def valid(
    name,
    title,
    clauses,
    make,
    *,
    uncommon=False,
    requirements=(),
    rules=(),
    source="",
    limits=False,
    questions=(),
    joined="",
):
    """A stream without fault. rules: those whose limit it reaches; requirements: those on programs that it shows."""
    add(
        Case(
            "uncommon" if uncommon else "valid",
            name,
            title,
            tuple(clauses.split()),
            tuple(map(issue, rules)),
            tuple(map(issue, requirements)),
            make,
            source=source,
            limits=limits,
            questions=tuple(questions),
            joined=joined,
        )
    )


def faulty(name, title, clauses, make, *, needs_check=False, refused=False, joined=""):
    """A stream with one fault, which its writer.Stream states. needs_check: decoding alone does not meet it."""
    add(
        Case(
            "faulty",
            name,
            title,
            tuple(clauses.split()),
            (),
            (),
            make,
            needs_check=needs_check,
            refused=refused,
            joined=joined,
        )
    )


def all_cases():
    from . import subjects  # here, since the subjects add their cases by this module

    subjects.load()
    return [_cases[key] for key in sorted(_cases)]


def text(value):
    """The file of a case: a line for each question, which has many numbers, and for each other value."""
    rows = [json.dumps(row) for row in value.get("questions", [])]
    places = [f"question {i}" for i in range(len(rows))]
    out = json.dumps(value | ({"questions": places} if rows else {}), indent=1, ensure_ascii=False)
    for place, row in zip(places, rows):
        out = out.replace(f'"{place}"', row)
    return (out + "\n").encode()


def description(case, fault):
    """The beginning of expected.json: what the case shows."""
    out = {"name": case.name, "title": case.title, "clauses": list(case.clauses)}
    rules = [issue(fault[0])] if fault else list(case.rules)
    if rules:
        out["rules"] = rules
    if case.requirements:
        out["requirements"] = list(case.requirements)
    if case.source:
        out["source"] = case.source
    return out | {"format": FORMAT}


def required(data, fault):
    """The times of the frames that a decoder has to find for all the fault: those of groups that end before it, and where it
    costs no more than an ancillary chunk or a track all of them. A decoder may trust the index."""
    issue_number, offset = fault
    if data[offset : offset + 4] in (b"INDX", b"FOOT"):
        return []
    costs_none = issue_number in STOPPED or data[offset : offset + 4] in ANCILLARY
    out = []
    for group in read(data, {}).groups:
        if group.ended and (costs_none or group.until <= offset):
            out += [time for time, _ in group.whole()]
    return out


def found_by_who_joined(case, data):
    """The report for a caller who says that it joined late."""
    found = report(data, live=True, joined=True)
    if found["status"] != case.joined:
        raise ValueError(f"{case.tier}/{case.name}: {found['status']} for who joined late")
    return {part: found[part] for part in ("status", "issues", "frames", "sounds", "environment")}


def rounded(value):
    """An answer without the digits in which the functions of the C libraries of two machines may differ."""
    if isinstance(value, dict):
        return {name: rounded(one) for name, one in value.items()}
    if isinstance(value, list):
        return [rounded(one) for one in value]
    return round(value, 10) if isinstance(value, float) else value


def expectation(case, data, fault):
    """The report in expected.json. What the stream holds comes from the reference decoder; status, issue and place from the writer."""
    found = report(data)
    if fault:
        found["frames"] = possible.frames(data)
    refused = bool(fault) and (case.refused or fault[0] in REFUSED)
    out = {"status": "refused" if refused else "damaged" if fault else "whole"}
    out["issues"] = [{"issue": issue(fault[0]), "offset": fault[1]}] if fault else []
    if case.needs_check or (fault and fault[0] in NEEDS_CHECK):
        out["needs_check"] = True
    if case.limits or (fault and fault[0] == 7001):
        out["limits"] = True
    if not found["summary"]["ended"]:
        # Without a footer only a reader from front to back finds an index.
        del found["summary"]["indexed"]
    out |= {part: found[part] for part in ("frames", "sounds", "environment", "summary")}
    if case.joined:
        out["joined"] = found_by_who_joined(case, data)
    if case.questions:
        out["questions"] = [q | rounded(questions.ANSWERS[q["op"]](data, q)) for q in case.questions]
    if fault and not refused and (times := required(data, fault)):
        out["required"] = times
    return out


def made(case):
    """The input and (rule, offset) of its fault, or None."""
    stream = case.make()
    if isinstance(stream, bytes):
        return stream, None
    data = bytes(stream.out)
    fault = (stream.issue, stream.offset) if stream.issue else None
    if bool(fault) != (case.tier == "faulty"):
        raise ValueError(f"{case.tier}/{case.name}: {'no' if not fault else 'a'} fault")
    if len(data) > MOST_BYTES:
        raise ValueError(f"{case.tier}/{case.name} has {len(data)} bytes, more than {MOST_BYTES}")
    return data, fault


def files(case):
    """The files of a case by path."""
    data, fault = made(case)
    folder = CASES / case.tier / case.name
    return {
        folder / FILES[0]: data,
        folder / FILES[1]: text(description(case, fault) | expectation(case, data, fault)),
    }
