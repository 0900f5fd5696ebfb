"""Decoders on damaged streams: what they still call intact has to be bit-identical, and damage has to be reported."""

import base64
import concurrent.futures
import itertools
import threading
from typing import NamedTuple

from . import damage
from .compare import content_differences, describe_differences, environment_differences, number
from .decoder import Decoder

#: Damages that a process gets at once.
BATCH = 64
#: Verdicts that are listed with their reasons, at most.
LISTED = 50


class Verdict(NamedTuple):
    """outcome: refused, damaged, unaffected (nothing reported, and everything as it was), failed (no answer), or silent."""

    outcome: str
    reason: str = ""


def report_is_prefix(baseline, report):
    """Frames are those of the beginning, and the end was not seen: a stream that stops at the end of a group."""
    if report.get("summary", {}).get("ended") is True:
        return False
    times = [number(frame["time"]) for frame in report["frames"]]
    return times == [number(frame["time"]) for frame in baseline["frames"]][: len(times)]


def same_content(baseline, report, parts):
    return not list(content_differences(baseline, report, parts, True))


def wrong_environment(environments, found):
    """found: the environment under the last configuration that was read, which may be any of the stream's."""
    differences = [list(environment_differences(one, found, False)) for one in environments]
    return [] if not all(differences) else differences[-1]


def verdict(baseline, environments, report, one, parts):
    """baseline: the decoder's own report on the stream without damage. environments: those under each of its configurations."""
    if isinstance(report, str):
        return Verdict("failed", report)
    wrong = list(content_differences(baseline, report, parts - {"environment"}, False))
    if "environment" in parts:
        wrong += wrong_environment(environments, report.get("environment", {}))
    if wrong:
        return Verdict("silent", wrong[0])
    times = {number(frame["time"]) for frame in report["frames"]}
    lost = sorted((one.others_whole & {number(frame["time"]) for frame in baseline["frames"]}) - times)
    if lost:
        return Verdict(
            "silent", f"frame {lost[0]} is lost, although its group and its configuration are whole"
        )
    if report["status"] != "whole":
        return Verdict(report["status"])
    is_same = same_content(baseline, report, parts)
    if (
        is_same
        and report.get("summary", {}).get("ended") is True
        and "check" in parts
        and one.kind != "block-repeat"
    ):
        return Verdict("silent", "nothing is reported by a decoder that checks")
    if is_same:
        return Verdict("unaffected")
    if report_is_prefix(baseline, report):
        return Verdict("unaffected")
    return Verdict("silent", "something is missing, and nothing is reported")


def judge(baseline, environments, report, one, parts):
    try:
        return verdict(baseline, environments, report, one, parts)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        return Verdict(
            "failed", f"the report has not the form of the protocol: {type(error).__name__}: {error}"
        )


def request_of(content, live):
    request = {"data": base64.b64encode(content).decode()}
    return {**request, "live": True} if live else request


class Result:
    """Counts of one decoder."""

    def __init__(self, name):
        self.name = name
        self.counts = dict.fromkeys(("damages", "refused", "damaged", "unaffected", "failed", "silent"), 0)
        self.kinds = {}
        self.listed = []
        self._lock = threading.Lock()

    def take(self, case, one, found):
        with self._lock:
            self.counts["damages"] += 1
            self.counts[found.outcome] += 1
            self.kinds[one.kind] = self.kinds.get(one.kind, 0) + 1
            if found.outcome in ("failed", "silent") and len(self.listed) < LISTED:
                row = {
                    "case": case.name,
                    "damage": one.name,
                    "outcome": found.outcome,
                    "reason": found.reason,
                }
                self.listed.append(row)

    def as_json(self):
        return {
            "decoder": self.name,
            **self.counts,
            "kinds": dict(sorted(self.kinds.items())),
            "wrong": self.listed,
        }


def batches(cases, sample, exhaustive):
    """(case, list of damages)."""
    for case in cases:
        content = case.content
        made = (damage.every if exhaustive else damage.sampled)(content, sample, case.name)
        while batch := list(itertools.islice(made, BATCH)):
            yield case, batch


def sweep_decoder(command, cases, sample, exhaustive, jobs, timeout, live=False, on_step=lambda count: None):
    """Sweeps the cases that are whole. A case with which the decoder does not agree to begin with is listed as failed."""
    cases = [case for case in cases if case.tier != "faulty"]
    waiting = batches(cases, sample, exhaustive)
    lock = threading.Lock()
    results, disagreed = [], set()

    def take_batch():
        with lock:
            return next(waiting, None)

    def baseline_of(decoder, case):
        """The report on a case and the environments of its configurations, or None."""
        # A stream may end before a later configuration; then an earlier one is the last.
        blocks = (
            damage.blocks_of(damage.chunks_of(case.content))[1:] if "environment" in decoder.parts else []
        )
        contents = [case.content, *(case.content[: block.begin] for block in blocks)]
        report, *cut = decoder.decode_all(request_of(content, live) for content in contents)
        if describe_differences(case.tier, case.expected, report, decoder.parts):
            return None
        return report, [
            one["environment"] for one in [*cut, report] if isinstance(one, dict) and "environment" in one
        ]

    def work(_):
        with Decoder(command, timeout) as decoder:
            with lock:
                if not results:
                    results.append(Result(decoder.name))
            baseline, of = None, None
            while batch := take_batch():
                case, damages = batch
                if of != case.name:
                    baseline, of = baseline_of(decoder, case), case.name
                if baseline is None:
                    disagreed.add(case.name)
                    continue
                answers = decoder.decode_all(request_of(one.content, live) for one in damages)
                for one, answer in zip(damages, answers):
                    results[0].take(case, one, judge(*baseline, answer, one, decoder.parts))
                on_step(len(damages))

    with concurrent.futures.ThreadPoolExecutor(max(jobs, 1)) as pool:
        list(pool.map(work, range(max(jobs, 1))))
    return {**results[0].as_json(), "disagreed": sorted(disagreed)}
