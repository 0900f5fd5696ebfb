"""Runs decoders over cases."""

import concurrent.futures
import time
from typing import NamedTuple

from . import FORMAT
from .cases import TIERS
from .compare import describe_differences
from .decoder import Decoder
from .questions import answer_differences, not_offered, only_questions, questions_of, request_of


class Outcome(NamedTuple):
    """One decoder on one case. differences: none, they agree."""

    case: str
    seconds: float
    differences: list


class Tested(NamedTuple):
    """One decoder on all cases. seconds: from the start of its processes to their end. skipped: what it was not asked, as lines."""

    name: str
    version: str
    format: str
    parts: list
    outcomes: list
    seconds: float
    skipped: tuple = ()

    def counts(self, cases):
        """(agreed, of) for each tier."""
        good = {outcome.case: not outcome.differences for outcome in self.outcomes}
        return {
            tier: (
                sum(good.get(case.name, False) for case in cases if case.tier == tier),
                sum(case.name in good for case in cases if case.tier == tier),
            )
            for tier in TIERS
        }


def ways_of(case, parts):
    """The requests for a report of a case: as a file, and pushed from front to back where the decoder can. A program that has only
    questions gets no such request."""
    if only_questions(parts):
        return
    yield {"path": str(case.path)}
    if "live" in parts:
        yield {"path": str(case.path), "live": True}


def late_ways_of(case, parts):
    """The request for a report as a reader who joined late has it, of cases that expect one."""
    if "joined" in case.expected and "join" in parts:
        yield {"path": str(case.path), "live": True, "joined": True}


def requests_for(case, parts):
    yield from ways_of(case, parts)
    yield from late_ways_of(case, parts)
    for question in questions_of(case, parts):
        yield request_of(case, question)


def judge(case, answers, parts):
    ways, late = len(list(ways_of(case, parts))), len(list(late_ways_of(case, parts)))
    answers, joined, answered = answers[:ways], answers[ways : ways + late], answers[ways + late :]
    differences = []
    for i, answer in enumerate(answers):
        for line in describe_differences(case.tier, case.expected, answer, parts):
            differences.append(f"live: {line}" if i else line)
    for answer in joined:
        expected = case.expected["joined"]
        tier = "valid" if expected["status"] == "whole" else "faulty"
        differences += [f"joined: {line}" for line in describe_differences(tier, expected, answer, parts)]
    for question, answer in zip(questions_of(case, parts), answered):
        differences += answer_differences(question, answer)
    return differences


def test_cases(decoder, cases, on_step):
    """Yields an Outcome for each case that the decoder is asked something of, in order."""
    asked = {case.name: list(requests_for(case, decoder.parts)) for case in cases}
    answers = decoder.decode_all(request for case in cases for request in asked[case.name])
    start = time.monotonic()
    for case in cases:
        if not asked[case.name]:
            on_step()
            continue
        found = [next(answers) for _ in asked[case.name]]
        now = time.monotonic()
        yield Outcome(case.name, now - start, judge(case, found, decoder.parts))
        start = now
        on_step()


def not_joined(cases, parts):
    count = sum("joined" in case.expected for case in cases)
    if count and "join" not in parts:
        yield f"join: not offered, {count} reports of who joined late are skipped"


def slices(items, count):
    """Every count-th item, count times: cases that take long are neighbours."""
    return [items[i::count] for i in range(count)]


def test_decoder(command, cases, jobs, timeout, on_step=lambda: None):
    """cases are shared by jobs processes of the decoder."""
    cases = list(cases)

    def work(some):
        with Decoder(command, timeout) as decoder:
            return decoder, list(test_cases(decoder, some, on_step))

    start = time.monotonic()
    with concurrent.futures.ThreadPoolExecutor(max(jobs, 1)) as pool:
        done = list(pool.map(work, slices(cases, max(1, min(jobs, len(cases))))))
    decoder = done[0][0]
    outcomes = {outcome.case: outcome for _, some in done for outcome in some}
    ordered = [outcomes[case.name] for case in cases if case.name in outcomes]
    seconds = time.monotonic() - start
    skipped = (*not_joined(cases, decoder.parts), *not_offered(cases, decoder.parts))
    parts = sorted(decoder.parts)
    return Tested(decoder.name, decoder.version, decoder.format, parts, ordered, seconds, skipped)


def with_distinct_names(tested):
    """Two commands may run one program: the second is NAME 2."""
    seen = {}
    for one in tested:
        seen[one.name] = seen.get(one.name, 0) + 1
        yield one if seen[one.name] == 1 else one._replace(name=f"{one.name} {seen[one.name]}")


def as_json(tested, cases):
    """The result as plain values; version 1 of its form."""
    agreed = sum(good for one in tested for good, _ in one.counts(cases).values())
    total = sum(of for one in tested for _, of in one.counts(cases).values())
    return {
        "fvv_conformance": 1,
        "format": FORMAT,
        "cases": [
            {
                "name": case.name,
                "tier": case.tier,
                "title": case.expected.get("title", ""),
                "clauses": case.expected.get("clauses", []),
                "rules": case.expected.get("rules", []),
            }
            for case in cases
        ],
        "decoders": [
            {
                "name": one.name,
                "version": one.version,
                "format": one.format,
                "parts": one.parts,
                "agreed": {
                    tier: {"agreed": good, "of": of} for tier, (good, of) in one.counts(cases).items()
                },
                "seconds": round(one.seconds, 3),
                "skipped": list(one.skipped),
                "disagreements": [
                    {"case": outcome.case, "differences": outcome.differences}
                    for outcome in one.outcomes
                    if outcome.differences
                ],
            }
            for one in tested
        ],
        "figures": {
            "conformance.valid": sum(case.tier != "faulty" for case in cases),
            "conformance.faulty": sum(case.tier == "faulty" for case in cases),
            "conformance.agreement_percent": percent(agreed, total),
        },
    }


def percent(part, whole):
    """Rounded down to two places: 100 is all of them."""
    return 10000 * part // whole / 100 if whole else 0.0
