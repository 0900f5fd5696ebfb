#!/usr/bin/env python3
"""Changes one token of the reference decoder at a time and runs the cases on it: what survives, no case shows.

A mutant is killed when a case disagrees, or the decoder fails or takes far too long. Only cases that call the function of
the token are run, those that killed other mutants of it first, until one disagrees. Survivors that behave like the
decoder itself have a row with the reason in mutants.json. Nothing is written into the package.
"""

import argparse
import ast
import fnmatch
import importlib.machinery
import io
import json
import os
import pathlib
import pickle
import random
import resource
import select
import signal
import sys
import time
import tokenize
from typing import NamedTuple

import numpy  # noqa: F401  (loaded once, before the forks)
from fvv_conformance.cases import default_folder, load
from fvv_conformance.compare import describe_differences
from fvv_conformance.questions import answer_differences, questions_of, request_of
from fvv_conformance.running import late_ways_of, ways_of

HERE = pathlib.Path(__file__).resolve().parent
PACKAGE = HERE / "reference"
EQUIVALENT = HERE / "mutants.json"
WRITERS = {"tiny.py", "examples.py", "possible.py", "__main__.py"}  # they decode no stream
MEMORY = 3 << 30
PROCESS_SECONDS = 1800
OPERATORS = {
    "<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==",
    "+": "-", "-": "+", "*": "+", "//": "*", "/": "*", "%": "+", "**": "*",
    "<<": ">>", ">>": "<<", "&": "|", "|": "&", "^": "&", "+=": "-=", "-=": "+=", "<<=": ">>=", ">>=": "<<=", "|=": "&=",
}  # fmt: skip
NAMES = {
    "and": "or",
    "or": "and",
    "not": "",
    "True": "False",
    "False": "True",
    "break": "continue",
    "continue": "break",
}
NAMES |= {"min": "max", "max": "min", "any": "all", "all": "any"}


TEXTS = {}  # sources as they were in the beginning


class Mutant(NamedTuple):
    """token: which one of its line, from 0 on. function: line at which the innermost function begins; 0: outside of all."""

    file: str
    line: int
    column: int
    token: int
    old: str
    new: str
    source: str
    function: int

    def key(self):
        return self.file, self.source, self.token, self.new

    def __str__(self):
        return f"{self.file}:{self.line}: {self.old} -> {self.new or 'nothing'}: {self.source}"


def numbers(text):
    """The numbers that take the place of one."""
    try:
        value = ast.literal_eval(text)
    except (SyntaxError, ValueError):
        return []
    if isinstance(value, int):
        return [str(value + 1)] + ([str(value - 1)] if value else [])
    return [repr(value * 2)] if isinstance(value, float) and value else []


def functions(text):
    """(first line, last line) of every function, outer ones first."""
    found = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)]
    return [(node.lineno, node.end_lineno) for node in found]


def mutants_of(path):
    name, depth, counts, before = str(path.relative_to(PACKAGE)), 0, {}, ""
    text = TEXTS[name] = path.read_text()
    lines, spans = text.splitlines(), functions(text)
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        kind = tokenize.tok_name[token.type]
        depth += {"FSTRING_START": 1, "FSTRING_END": -1}.get(kind, 0)
        line, column = token.start
        counts[line] = counts.get(line, -1) + 1
        source = lines[line - 1].strip() if line <= len(lines) else ""
        unpacks = token.string in ("*", "**") and before in ("(", ",", "[", "{", "=", "return", "")
        before = token.string.strip()
        if depth or unpacks or source.startswith(("import ", "from ", "@")):
            continue
        new = []
        if kind == "NUMBER":
            new = numbers(token.string)
        elif kind == "OP" and token.string in OPERATORS:
            new = [OPERATORS[token.string]]
        elif kind == "NAME" and token.string in NAMES:
            new = [NAMES[token.string]]
        inside = [first for first, last in spans if first <= line <= last]
        for one in new:
            where = line, column, counts[line]
            yield Mutant(name, *where, token.string, one, source, max(inside, default=0))


def mutated(mutant, text):
    lines = text.splitlines(keepends=True)
    line = lines[mutant.line - 1]
    lines[mutant.line - 1] = line[: mutant.column] + mutant.new + line[mutant.column + len(mutant.old) :]
    return "".join(lines)


class TooSlow(Exception):
    pass


def too_slow(*_):
    raise TooSlow


class Suite:
    """The cases, and what the decoder itself does with them: processor time, and the functions that each case calls."""

    def __init__(self, cases):
        self.cases = {case.name: case for case in cases}
        self.content = {case.name: case.content for case in cases}
        self.seconds, self.calls, self.kills = {}, {}, {}

    def disagreements(self, name, module):
        """Differences of one case, with the decoder that is loaded."""
        case, parts = self.cases[name], set(module.PARTS)
        for way in ways_of(case, parts):
            answer = module.report(self.content[name], bool(way.get("live")))
            yield from describe_differences(case.tier, case.expected, json.loads(json.dumps(answer)), parts)
        for _ in late_ways_of(case, parts):
            answer = module.report(self.content[name], True, True)
            wanted = case.expected["joined"]
            tier = "valid" if wanted["status"] == "whole" else "faulty"
            yield from describe_differences(tier, wanted, json.loads(json.dumps(answer)), parts)
        for question in questions_of(case, parts):
            answer = module.ANSWERS[question["op"]](self.content[name], request_of(case, question))
            yield from answer_differences(question, json.loads(json.dumps(answer)))

    def measure(self):
        """Runs all cases without a change, in a process of its own."""
        self.seconds, self.calls = in_process(self._measured, 3600)

    def _measured(self):
        module, seconds, calls = decoder(), {}, {}
        for name in self.cases:
            seen = set()

            def called(frame, event, _, seen=seen):
                if event == "call":
                    seen.add(frame.f_code)

            start = time.process_time()
            sys.setprofile(called)
            try:
                wrong = list(self.disagreements(name, module))
            finally:
                sys.setprofile(None)
            if wrong:
                raise SystemExit(
                    f"mutants: without a change the reference decoder disagrees: {name}: {wrong[0]}"
                )
            seconds[name] = time.process_time() - start
            inside = [code for code in seen if code.co_filename.startswith(str(PACKAGE))]
            calls[name] = {
                (str(pathlib.Path(code.co_filename).relative_to(PACKAGE)), code.co_firstlineno)
                for code in inside
            }
        return seconds, calls

    def reached(self):
        return set().union(*self.calls.values())

    def order(self, mutant):
        """The cases for a mutant: killers of its function, then of its file, then the quick ones."""
        place = (mutant.file, mutant.function)
        names = [name for name, calls in self.calls.items() if not mutant.function or place in calls]
        of_place, of_file = self.kills.get(place, {}), self.kills.get(mutant.file, {})
        return sorted(names, key=lambda n: (-of_place.get(n, 0), -of_file.get(n, 0), self.seconds[n], n))

    def killed(self, mutant, name):
        for place in ((mutant.file, mutant.function), mutant.file):
            counts = self.kills.setdefault(place, {})
            counts[name] = counts.get(name, 0) + 1

    def killer(self, mutant, names):
        """The first case that shows the mutant and how, or None. Runs in a process of its own."""
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        signal.signal(signal.SIGPROF, too_slow)
        load_mutated(mutant)
        name = names[0] if names else ""
        try:
            module = decoder()
            for name in names:
                signal.setitimer(signal.ITIMER_PROF, 3 + 20 * self.seconds[name])
                wrong = next(self.disagreements(name, module), None)
                signal.setitimer(signal.ITIMER_PROF, 0)
                if wrong:
                    return name, wrong
        except BaseException as error:  # also what a mutant raises that no decoder does
            return name, type(error).__name__
        return None


def load_mutated(mutant):
    """Python's loader of sources compiles the changed text in place of the file."""
    target, original = str(PACKAGE / mutant.file), importlib.machinery.SourceFileLoader.get_code

    def get_code(self, name):
        if self.get_filename(name) != target:
            return original(self, name)
        return compile(mutated(mutant, TEXTS[mutant.file]), target, "exec")

    importlib.machinery.SourceFileLoader.get_code = get_code


def decoder():
    from reference import __main__ as module

    return module


class Process:
    """A function in a forked process, at low priority; result() is what it returned."""

    def __init__(self, function, seconds):
        self.end, there = os.pipe()
        self.deadline = time.monotonic() + seconds
        self.child = os.fork()
        if not self.child:
            os.close(self.end)
            os.nice(5)
            status = 1
            try:
                with os.fdopen(there, "wb") as file:
                    pickle.dump(function(), file)
                status = 0
            except SystemExit as error:
                print(error, file=sys.stderr)
            finally:
                os._exit(status)
        os.close(there)
        self.data = bytearray()

    def finished(self):
        """Reads what is there."""
        if time.monotonic() > self.deadline:
            os.kill(self.child, signal.SIGKILL)
        if not select.select([self.end], [], [], 0.01)[0]:
            return False
        some = os.read(self.end, 1 << 20)
        self.data += some
        return not some

    def result(self):
        """None when the process was killed or failed."""
        os.close(self.end)
        _, status = os.waitpid(self.child, 0)
        return None if status else pickle.loads(bytes(self.data))


def in_process(function, seconds):
    process = Process(function, seconds)
    while not process.finished():
        pass
    found = process.result()
    if found is None:
        raise SystemExit(2)
    return found


def judge(suite, chosen, jobs, progress):
    """Yields each mutant with its killer: (case, difference), None for a survivor."""
    waiting, running, more = iter(chosen), {}, True
    while more or running:
        while more and len(running) < jobs:
            mutant = next(waiting, None)
            more = mutant is not None
            if not more:
                break
            names = suite.order(mutant)
            running[mutant] = Process(lambda m=mutant, n=names: suite.killer(m, n), PROCESS_SECONDS)
        for mutant, process in list(running.items()):
            if not process.finished():
                continue
            del running[mutant]
            late = time.monotonic() > process.deadline
            found = process.result()
            if found is None and (late or not process.data):
                found = "", "the process was ended: too much time or memory"
            elif found:
                suite.killed(mutant, found[0])
            progress()
            yield mutant, found


def rows():
    listed = json.loads(EQUIVALENT.read_text())["equivalent"]
    return {(row["file"], row["line"], row["token"], row["to"]): row["reason"] for row in listed}


def parsed():
    parser = argparse.ArgumentParser(prog="./run mutants", description=__doc__.split("\n")[0])
    parser.add_argument(
        "count", nargs="?", type=int, default=500, help="mutants, chosen at random (default 500)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the choice (default 1)")
    parser.add_argument(
        "--file", metavar="GLOB", default="*", help="files of the decoder, such as 'decode/draco*'"
    )
    parser.add_argument("--line", metavar="TEXT", default="", help="lines that contain this text")
    parser.add_argument(
        "--minutes", type=float, help="begin no mutant after this time; the others are not counted"
    )
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", metavar="FILE", help="write the result")
    return parser.parse_args()


def choose(suite, arguments):
    """The mutants to run; how many there are in all, and in functions that a case calls."""
    files = [p for p in sorted(PACKAGE.rglob("*.py")) if p.name not in WRITERS]
    files = [p for p in files if fnmatch.fnmatch(str(p.relative_to(PACKAGE)), arguments.file)]
    every = [mutant for path in files for mutant in mutants_of(path) if arguments.line in mutant.source]
    reached = suite.reached()
    alive = [m for m in every if not m.function or (m.file, m.function) in reached]
    random.Random(arguments.seed).shuffle(alive)
    return alive[: arguments.count], len(every), len(alive)


def main():
    arguments = parsed()
    suite = Suite(load(default_folder()))
    print(f"{len(suite.cases)} cases without a change...", file=sys.stderr, flush=True)
    suite.measure()
    chosen, every, alive = choose(suite, arguments)
    print(
        f"{len(chosen)} of {alive} mutants in functions that cases call ({every} in all)",
        file=sys.stderr,
        flush=True,
    )
    start, equivalent, survivors, killed = time.monotonic(), rows(), [], 0
    done = [0]

    def progress():
        done[0] += 1
        if done[0] % 25 == 0:
            print(
                f"{done[0]} of {len(chosen)}, {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True
            )

    def in_time():
        for mutant in chosen:
            if arguments.minutes and time.monotonic() - start > 60 * arguments.minutes:
                return
            yield mutant

    result = []
    for mutant, found in judge(suite, in_time(), arguments.jobs, progress):
        result.append({**mutant._asdict(), "killer": found})
        killed += found is not None
        if found is None and mutant.key() not in equivalent:
            survivors.append(mutant)
            print(mutant, flush=True)
    named = len(result) - killed - len(survivors)
    print(f"mutants {len(result)}: {killed} killed, {named} equivalent, {len(survivors)} unexplained")
    print(f"mutants.killed_percent {100 * killed / max(1, len(result) - named):.1f}")
    print(f"mutants.unexplained {len(survivors)}")
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(result, indent=1) + "\n")
    return 1 if survivors or not result else 0


if __name__ == "__main__":
    sys.exit(main())
