"""sweep.py FILE...: does fvvinfo --check find every cut and every flipped bit?

For each file, which has to be complete, it tries every shorter length and every single flipped bit. A case that fvvinfo
calls complete, or for which it exits with 0, is silently wrong. Prints {"cases": N, "silent_wrong": M}; FVV_TOOLS_DIR names the build's folder of tools.
"""

import argparse
import collections
import concurrent.futures
import itertools
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile
from typing import NamedTuple

FILE_HEADER_SIZE = 24
EXIT_CODES = {"complete": 0, "truncated": 3, "damaged": 1, "unreadable": 1}
BATCH = 256


class Case(NamedTuple):
    name: str
    content: bytes
    expected: int  # exit code


class Result:
    def __init__(self):
        self.cases = 0
        self.silent_wrong = 0
        self.unexpected = []  # an exit code other than the expected one; the first 20

    def take(self, results):
        for case, code in results:
            if code != case.expected and len(self.unexpected) < 20:
                self.unexpected.append(f"{case.name}: exit code {code}, expected {case.expected}")
        self.silent_wrong += len({case.name for case, code in results if code == 0})


def count(content):
    return 9 * len(content)


def all_cases(name, content):
    for size in range(len(content)):
        yield Case(f"{name}-cut-{size}", content[:size], 3 if size >= FILE_HEADER_SIZE else 1)
    for bit in range(8 * len(content)):
        flipped = bytearray(content)
        flipped[bit // 8] ^= 1 << bit % 8
        yield Case(f"{name}-bit-{bit}", bytes(flipped), 1)


def batches(cases):
    cases = iter(cases)
    while batch := list(itertools.islice(cases, BATCH)):
        yield batch


def run(tool, *arguments, cwd):
    return subprocess.run([str(tool), *arguments], capture_output=True, cwd=cwd, timeout=120)


def judge_batch(tool, folder, cases, alone):
    """Returns (case, exit code) by one run for all cases, and by a separate run for each case in alone."""
    with tempfile.TemporaryDirectory(dir=folder) as work:
        for case in cases:
            pathlib.Path(work, case.name).write_bytes(case.content)
        done = run(tool, "--check", "--json", *(case.name for case in cases), cwd=work)
        files = json.loads(done.stdout)["files"]
        if [file["name"] for file in files] != [case.name for case in cases]:
            raise RuntimeError(f"fvvinfo --json left out files of its batch: {done.stderr.decode()[:200]}")
        codes = [EXIT_CODES[file["integrity"]] for file in files]
        worst = next(code for code in (1, 3, 0) if code in codes)
        if done.returncode != worst:
            raise RuntimeError(
                f"fvvinfo on many files: exit code {done.returncode}, expected the worst, {worst}"
            )
        again = [(cases[i], run(tool, "--check", cases[i].name, cwd=work).returncode) for i in alone]
    return [*zip(cases, codes), *again]


def sweep(tool, folder, files, alone=250):
    """files: name to bytes. alone: how many cases of each file are also run in a process of their own."""
    result = Result()
    random_numbers = random.Random(1)
    workers = os.cpu_count() or 1
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        for name, content in files.items():
            pathlib.Path(folder, name).write_bytes(content)
            if run(tool, "--check", name, cwd=folder).returncode != 0:
                raise ValueError(f"{name}: not complete to begin with")
            cases = count(content)
            chosen = sorted(random_numbers.sample(range(cases), min(alone, cases)))
            # A few batches at a time, so that the cases are never all in memory or on disk.
            waiting = collections.deque()
            for i, batch in enumerate(batches(all_cases(name, content))):
                here = [k - i * BATCH for k in chosen if i * BATCH <= k < (i + 1) * BATCH]
                waiting.append(pool.submit(judge_batch, tool, folder, batch, here))
                if len(waiting) > 2 * workers:
                    result.take(waiting.popleft().result())
            for future in waiting:
                result.take(future.result())
            result.cases += cases
    return result


def memory_folder():
    """The cheapest place for temporary files; None is the system's default."""
    return "/dev/shm" if os.access("/dev/shm", os.W_OK) else None


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file", nargs="+", type=pathlib.Path)
    arguments = parser.parse_args()
    if not os.environ.get("FVV_TOOLS_DIR"):
        parser.error("set FVV_TOOLS_DIR to the folder 'tools' of a build, for instance build/default/tools")
    tool = pathlib.Path(os.environ["FVV_TOOLS_DIR"]).resolve() / "fvvinfo" / "fvvinfo"
    files = {f"{i}-{path.name}": path.read_bytes() for i, path in enumerate(arguments.file)}
    with tempfile.TemporaryDirectory(dir=memory_folder()) as folder:
        result = sweep(tool, folder, files)
    for line in result.unexpected:
        print(line, file=sys.stderr)
    print(json.dumps({"cases": result.cases, "silent_wrong": result.silent_wrong}))
    return 1 if result.silent_wrong or result.unexpected else 0


if __name__ == "__main__":
    sys.exit(main())
