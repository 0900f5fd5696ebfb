#!/usr/bin/env python3
"""Writes the conformance cases: conformance/cases/{valid,uncommon,faulty}/NAME, by the package generate/, without libfvv.

--check writes nothing and exits with 1 when a file differs, is missing or is left over. --coverage lists rules and
their cases. With names (NAME or TIER/NAME) only these cases are written or compared.
"""

import argparse
import json
import sys

from generate import case, coverage


def chosen(cases, names):
    found = [c for c in cases if not names or c.name in names or f"{c.tier}/{c.name}" in names]
    known = {c.name for c in found} | {f"{c.tier}/{c.name}" for c in found}
    for name in names:
        if name not in known:
            raise SystemExit(f"generate.py: no case {name}; see conformance/cases")
    return found


def left_over(cases):
    """Folders of cases that are no longer generated, and files that no case has."""
    folders = {case.CASES / c.tier / c.name for c in cases}
    tiers = [case.CASES / tier for tier in ("valid", "uncommon", "faulty")]
    found = [p for tier in tiers if tier.exists() for p in sorted(tier.iterdir())]
    files = [p for folder in found if folder in folders for p in sorted(folder.iterdir())]
    return [p for p in found if p not in folders] + [p for p in files if p.name not in case.FILES]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="only these cases")
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 when a file differs")
    parser.add_argument(
        "--coverage", action="store_true", help="rules without a case; exit 1 when there are any"
    )
    parser.add_argument("--list", action="store_true", help="names and titles")
    arguments = parser.parse_args()
    cases = chosen(case.all_cases(), arguments.names)
    if arguments.list:
        print("\n".join(f"{c.tier}/{c.name}: {c.title}" for c in cases))
        return 0
    if arguments.coverage:
        report = coverage.report(cases)
        print(json.dumps(report, indent=1))
        return 1 if report["missing"] else 0
    left = [] if arguments.names else left_over(cases)
    differing = []
    for one in cases:
        for path, content in case.files(one).items():
            if path.exists() and path.read_bytes() == content:
                continue
            differing.append(path)
            if not arguments.check:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
    found = "differs: run conformance/generate.py" if arguments.check else "written"
    states = dict.fromkeys(left, "is not generated: remove it") | dict.fromkeys(differing, found)
    for path, state in states.items():
        print(f"{path.relative_to(case.CASES.parent)}: {state}", file=sys.stderr)
    return 1 if left or (arguments.check and differing) else 0


if __name__ == "__main__":
    sys.exit(main())
