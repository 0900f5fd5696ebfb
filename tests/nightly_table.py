#!/usr/bin/env python3
"""Writes the result of ./run test nightly into docs/evidence/tests.md: nightly_table.py RESULT.xml... (JUnit, of ctest)."""

import collections
import datetime
import pathlib
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/evidence/tests.md"
BEGIN, END = "<!-- nightly -->\n", "<!-- end of nightly -->\n"


def rows(path):
    """(suite, passed, skipped, failed, seconds) by the word before the colon or dot of an entry's name."""
    suites = collections.defaultdict(lambda: [0, 0, 0, 0.0])
    for case in ElementTree.parse(path).iter("testcase"):
        name = case.get("name")
        row = suites[name.split(":")[0] if ":" in name else name.split(".")[0]]
        status = {"run": 0, "notrun": 1, "disabled": 1}.get(case.get("status"), 2)
        row[1 if case.find("skipped") is not None else status] += 1
        row[3] += float(case.get("time", 0))
    return sorted((suite, *row) for suite, row in suites.items())


def table(paths):
    commit = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True
    ).stdout.strip()
    lines = [f"Run on {datetime.date.today()} at commit {commit or 'unknown'}.", ""]
    lines += ["| tests | build | passed | skipped | failed | seconds |", "|---|---|---|---|---|---|"]
    for path in paths:
        build = "sanitizers" if "asan" in pathlib.Path(path).name else "default"
        lines += [f"| {suite} | {build} | {p} | {s} | {f} | {t:.0f} |" for suite, p, s, f, t in rows(path)]
    return "\n".join(lines) + "\n"


def main():
    text = PAGE.read_text()
    before, rest = text.split(BEGIN)
    PAGE.write_text(before + BEGIN + "\n" + table(sys.argv[1:]) + "\n" + END + rest.split(END)[1])


if __name__ == "__main__":
    main()
