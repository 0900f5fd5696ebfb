"""./run conformance: all decoders of this project over all cases and over damaged streams, into build/conformance."""

import argparse
import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))

from adapters import all as adapters  # noqa: E402
from adapters import contents  # noqa: E402
from fvv_conformance import cases, outputs, running, sweep  # noqa: E402
from fvv_conformance.command import Progress, print_sweep  # noqa: E402
from fvv_conformance.decoder import Decoder  # noqa: E402
from kaitai import compare as kaitai  # noqa: E402

DECODERS = ("libfvv", "wasm", "python", "reference", "view", "chromium", "firefox")
#: Browsers decode with the code of "wasm" and take ten times as long: they are compared with cases alone.
SWEPT = ("libfvv", "wasm", "python", "reference")


def runnable(names):
    for name in names:
        if reason := adapters.missing(name):
            print(f"skipped: {name}: {reason}")
        else:
            yield name, adapters.commands()[name][0]


def compare(found, names):
    tested = []
    for name, command in runnable(names):
        progress = Progress(name)
        tested.append(running.test_decoder(command, adapters.cases_for(name, found), 2, 60, progress.step))
        progress.close()
    return running.as_json(list(running.with_distinct_names(tested)), found)


def described(found):
    """The container as the description for Kaitai has it, against the reference decoder: None, if it cannot run."""
    if reason := kaitai.missing():
        print(f"skipped: Kaitai: {reason}")
        return None
    whole = [case for case in found if case.tier != "faulty"]
    readings = kaitai.read([case.path for case in whole])
    wrong = [(case.name, kaitai.differences(case.content, reading)) for case, reading in zip(whole, readings)]
    wrong = [(name, found) for name, found in wrong if found]
    print(f"Kaitai (container): {len(whole) - len(wrong)} of {len(whole)} valid and uncommon streams")
    for name, found in wrong:
        print(f"Kaitai: {name}: {found[0]}")
    return {"agreed": len(whole) - len(wrong), "of": len(whole)}


def damaged(found, names, count, exhaustive):
    rows = []
    for name, command in runnable(names):
        for live in (False, True):
            if live and name in ("python", "reference"):
                continue
            progress = Progress(f"{name}: damages")
            every = exhaustive and not live
            row = sweep.sweep_decoder(
                command, adapters.cases_for(name, found), count, every, 2, 60, live, progress.step
            )
            progress.close()
            row["decoder"] += ", pushed" if live else ""
            rows.append(row)
    return rows


def wrong_contents(found, names, count):
    """How many wrong contents libfvv and the reference decoder judge alike: the same rule, place and frames."""
    pair = [
        Decoder(command, 60) for _, command in runnable([n for n in ("libfvv", "reference") if n in names])
    ]
    if len(pair) < 2:
        return None
    total, lines = contents.compare(pair, found, count)
    for one in pair:
        one.close()
    for line in lines[:20]:
        print(line)
    print(
        f"wrong contents: {total - len(lines)} of {total} are judged alike by libfvv and the reference decoder"
    )
    return {"of": total, "differences": lines}


def main():
    parser = argparse.ArgumentParser(prog="./run conformance", description=__doc__)
    parser.add_argument(
        "--sweep", metavar="N", type=int, default=20, help="damages of each case (default 20); 0: none"
    )
    parser.add_argument(
        "--contents",
        metavar="N",
        type=int,
        default=5,
        help="wrong contents of each case (default 5); 0: none",
    )
    parser.add_argument(
        "--all", action="store_true", help="every cut and every bit of cases up to 8 kB: an hour"
    )
    parser.add_argument(
        "--decoders", metavar="NAME,...", default=",".join(DECODERS), help="only these (default: %(default)s)"
    )
    arguments = parser.parse_args()
    names = arguments.decoders.split(",")
    if unknown := set(names) - set(DECODERS):
        parser.error(f"--decoders: unknown: {', '.join(sorted(unknown))}")
    start = time.monotonic()
    found = cases.load(cases.default_folder())
    result = compare(found, names)
    outputs.print_result(result)
    result["kaitai"] = described(found)
    wrong = wrong_contents(found, names, arguments.contents) if arguments.contents else None
    if wrong:
        result["figures"]["contents.differences"] = len(wrong["differences"])
    result["sweep"] = (
        damaged(found, [name for name in SWEPT if name in names], arguments.sweep, arguments.all)
        if arguments.sweep or arguments.all
        else []
    )
    print()
    print_sweep(result["sweep"], sys.stdout)
    if result["sweep"]:
        result["figures"]["sweep.silent_wrong"] = sum(row["silent"] for row in result["sweep"])
    folder = adapters.ROOT / "build/conformance"
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in (
        ("result.json", outputs.as_text),
        ("junit.xml", outputs.junit),
        ("index.html", outputs.html),
    ):
        outputs.write_file(folder / name, make(result), force=True)
    print()
    for name, value in result["figures"].items():
        print(f"{name}: {json.dumps(value)}")
    print(f"{time.monotonic() - start:.0f} s; {folder.relative_to(adapters.ROOT)}/index.html")
    bad = any(one["disagreements"] for one in result["decoders"])
    bad = bad or (wrong and wrong["differences"])
    bad = bad or (result["kaitai"] and result["kaitai"]["agreed"] < result["kaitai"]["of"])
    return (
        1 if bad or any(row["silent"] or row["failed"] or row["disagreed"] for row in result["sweep"]) else 0
    )


if __name__ == "__main__":
    sys.exit(main())
