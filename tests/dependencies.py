"""The Python package with the oldest and the newest version of each package in the ranges of pyproject.toml (./run test dependencies).

uv resolves both ends, from wheels alone, for the Python of build/venv; where the oldest version has no wheel for it, the oldest that has.
Writes the table of docs/evidence/tests.md. `--end oldest|newest` runs one end.
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build/default"
WORK = ROOT / "build/dependencies"
PAGE = ROOT / "docs/evidence/tests.md"
ENDS = {"oldest": "lowest-direct", "newest": "highest"}
TESTS = "bindings/python/tests"
#: What runs the tests: the versions of tests/requirements.txt.
RUNNERS = ("pytest", "hypothesis", "jsonschema", "av")
#: They look at our sources with one version of a tool, or at the clock, not at what other packages return.
LEFT_OUT = (
    "test_api.py",
    "test_threads.py",
    "test_write_properties.py",
    "cluster/test_orders.py",
    "capture/test_chain.py",
)
NOT_RUN = "not types and not stub"
LIMIT = 3600  # seconds for the tests of one end


def ranges():
    """Requirements of the package and of its extra "all", as pyproject.toml has them."""
    text = (ROOT / "pyproject.toml").read_text()
    needed = re.search(r"^dependencies = (\[.*?\])$", text, re.M | re.S).group(1)
    extra = re.search(r"^all = (\[.*?^\])$", text, re.M | re.S).group(1)
    return [one for words in (needed, extra) for one in json.loads(re.sub(r",\s*\]", "]", words))]


def runners():
    lines = (ROOT / "tests/requirements.txt").read_text().splitlines()
    return [line for line in lines if line.partition("==")[0] in RUNNERS]


def uv(*arguments):
    done = subprocess.run(
        [sys.executable, "-m", "uv", *map(str, arguments)], capture_output=True, text=True, timeout=1800
    )
    if done.returncode:
        sys.exit(f"dependencies: uv {arguments[0]} failed: {done.stderr[-3000:]}")
    return done.stdout


def environment(end):
    """A virtual environment with this end of all ranges; and what was installed, by name."""
    folder = WORK / end
    uv("venv", "--quiet", "--clear", "--python", sys.executable, folder)
    python = folder / "bin/python"
    uv("pip", "install", "--quiet", "--python", python, "--only-binary", ":all:", "--resolution", ENDS[end],
       *ranges(), *runners())  # fmt: skip
    listed = json.loads(uv("pip", "list", "--python", python, "--format", "json"))
    return python, {one["name"]: one["version"] for one in listed}


def tried(end, python):
    """(tests passed, skipped, failed with their names) with one environment."""
    report = WORK / f"{end}.xml"
    report.unlink(missing_ok=True)
    settings = os.environ | {
        "PYTHONPATH": str(BUILD / "bindings/python"),
        "FVV_TOOLS_DIR": str(BUILD / "tools"),
        "PYTHONDONTWRITEBYTECODE": "1",
        "MPLBACKEND": "agg",
    }
    # -v: the log names each test as it ends, also where the whole does not end.
    command = [python, "-m", "pytest", "-v", "-p", "no:cacheprovider", "-k", NOT_RUN, f"--junit-xml={report}"]
    command += [f"--ignore={TESTS}/{name}" for name in LEFT_OUT]
    try:
        with open(WORK / f"{end}.log", "w") as log:
            done = subprocess.run(
                [*map(str, command), TESTS], cwd=ROOT, env=settings, stdout=log, stderr=log, timeout=LIMIT
            )
    except subprocess.TimeoutExpired:
        failed = re.findall(r"^(\S+) (?:FAILED|ERROR)", (WORK / f"{end}.log").read_text(), re.M)
        sys.exit(
            f"dependencies: {end}: did not end within {LIMIT} s; failed until then: {' '.join(failed) or 'none'}"
        )
    if done.returncode not in (0, 1) or not report.exists():
        sys.exit(f"dependencies: pytest ended with {done.returncode}; see {WORK / end}.log")
    passed, skipped, failed = 0, 0, []
    for case in xml.etree.ElementTree.parse(report).iter("testcase"):
        if case.find("failure") is not None or case.find("error") is not None:
            failed.append(f"{case.get('classname')}::{case.get('name')}")
        elif case.find("skipped") is not None:
            skipped += 1
        else:
            passed += 1
    return passed, skipped, failed


def table(found):
    """The results as Markdown."""
    names = [re.match(r"[\w.-]+", one).group().lower() for one in ranges()]
    rows = [
        (f"`{need}`", [versions.get(name.replace("_", "-"), "none") for versions, _ in found.values()])
        for need, name in zip(ranges(), names)
    ]
    counts = [f"{p} passed, {s} skipped, {len(f)} failed" for _, (p, s, f) in found.values()]
    return markdown(f"with Python {sys.version.split()[0]}", found, [*rows, ("tests", counts)])


def markdown(by, ends, rows):
    """A table with a column for each end; rows: (name, a text for each end). by: what ran."""
    lines = [
        f"Run on {datetime.date.today().isoformat()} {by}:",
        "",
        f"| | {' | '.join(ends)} |",
        "|---" * (1 + len(ends)) + "|",
    ]
    return "\n".join([*lines, *(f"| {name} | {' | '.join(texts)} |" for name, texts in rows)])


def write(text, part="dependencies"):
    page = PAGE.read_text()
    begin, end = f"<!-- {part} -->\n", f"<!-- end of {part} -->"
    head, _, rest = page.partition(begin)
    PAGE.write_text(f"{head}{begin}\n{text}\n\n{end}{rest.partition(end)[2]}")


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--end", choices=ENDS, action="append")
    given = arguments.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    found = {}
    for end in given.end or ENDS:
        python, versions = environment(end)
        print(f"dependencies: {end}: testing", flush=True)
        found[end] = (versions, tried(end, python))
        for name in found[end][1][2]:
            print(f"dependencies: {end}: failed: {name}", flush=True)
    print(table(found))
    if len(found) == len(ENDS):
        write(table(found))
    return 1 if any(failed for _, (_, _, failed) in found.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
