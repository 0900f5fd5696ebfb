"""fvv-conformance run, sweep, render, show and list."""

import argparse
import os
import pathlib
import sys

from . import FORMAT, __version__, rendering
from . import show as showing
from .cases import BadCase, default_folder, load
from .decoder import DecoderError
from .outputs import OutputExists, as_text, html, junit, print_result, table, without_controls, write_file
from .running import as_json, test_decoder, with_distinct_names
from .sweep import sweep_decoder

DONE, FAILED, USAGE = 0, 1, 2


def parser():
    top = argparse.ArgumentParser(
        prog="fvv-conformance",
        description=f"Tests decoders of fvv {FORMAT}. PROTOCOL.md says what a decoder under test is.",
        epilog="Exit codes: 0 all agree, 1 something differs or cannot be run, 2 usage.",
    )
    top.add_argument("--version", action="version", version=f"fvv-conformance {__version__}, format {FORMAT}")
    commands = top.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", help="compare decoders with the expected results of all cases")
    sweep = commands.add_parser(
        "sweep", help="damage the cases: what decoders call intact has to be bit-identical"
    )
    listing = commands.add_parser("list", help="print the names and titles of cases")
    rendering.add_parser(commands)
    show = showing.add_parser(commands)
    show.set_defaults(only=None)
    show.add_argument(
        "--cases", metavar="DIR", type=pathlib.Path, help="default: those that came with the package"
    )
    for one in run, sweep, listing:
        one.add_argument(
            "--cases", metavar="DIR", type=pathlib.Path, help="default: those that came with the package"
        )
        one.add_argument(
            "--only",
            metavar="GLOB",
            action="append",
            help="names such as 'faulty/*' or 'mesh_*'; may be repeated",
        )
    for one in run, sweep:
        one.add_argument(
            "--decoder",
            metavar="CMD",
            action="append",
            required=True,
            help="a program that speaks the protocol; may be repeated",
        )
        one.add_argument(
            "--timeout", metavar="S", type=float, default=20, help="seconds for one answer (default 20)"
        )
        one.add_argument(
            "--jobs",
            metavar="N",
            type=int,
            default=min(2, os.cpu_count() or 1),
            help="processes of a decoder (default 2)",
        )
        one.add_argument("--json", metavar="FILE", help="write the result; - is standard output")
        one.add_argument("--force", action="store_true", help="replace files that exist")
    run.add_argument("--junit", metavar="FILE", help="write JUnit XML")
    run.add_argument("--html", metavar="FILE", help="write a page with a matrix of cases and decoders")
    run.add_argument("--sweep-result", metavar="FILE", help="for the page: what sweep --json wrote")
    sweep.add_argument(
        "--sample", metavar="N", type=int, default=200, help="damages of each case (default 200)"
    )
    sweep.add_argument(
        "--all", action="store_true", help="every cut and every bit of cases up to 8 kB as well"
    )
    sweep.add_argument("--live", action="store_true", help="streams are pushed from front to back")
    return top


class Progress:
    """A count on a terminal, and nothing elsewhere."""

    def __init__(self, label):
        self.label, self.count = label, 0
        self.shown = sys.stderr.isatty()

    def step(self, count=1):
        self.count += count
        if self.shown:
            print(f"\r{self.label}: {self.count}", end="", file=sys.stderr, flush=True)

    def close(self):
        if self.shown and self.count:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def write_outputs(outputs, force):
    """outputs: (path, function that makes the text). Looks for files that exist before anything is made."""
    for path, make in outputs:
        if path == "-":
            print(make(), end="")
        else:
            write_file(path, make(), force)


def refuse_existing(paths, force):
    for path in paths:
        if path and path != "-" and not force and pathlib.Path(path).exists():
            raise OutputExists(f"{path}: exists; --force replaces it")


def run(arguments, cases):
    refuse_existing([arguments.json, arguments.junit, arguments.html], arguments.force)
    tested = []
    for command in arguments.decoder:
        progress = Progress("cases")
        tested.append(test_decoder(command, cases, arguments.jobs, arguments.timeout, progress.step))
        progress.close()
    result = as_json(list(with_distinct_names(tested)), cases)
    if arguments.sweep_result:
        import json

        result["sweep"] = json.loads(pathlib.Path(arguments.sweep_result).read_text())["sweep"]
    print_result(
        result, sys.stderr if "-" in (arguments.json, arguments.junit, arguments.html) else sys.stdout
    )
    outputs = [
        (arguments.json, lambda: as_text(result)),
        (arguments.junit, lambda: junit(result)),
        (arguments.html, lambda: html(result)),
    ]
    write_outputs([(path, make) for path, make in outputs if path], arguments.force)
    return FAILED if any(one["disagreements"] for one in result["decoders"]) else DONE


def print_sweep(rows, stream):
    headings = ["decoder", "damages", "refused", "reported", "unaffected", "failed", "silent"]
    keys = ["damages", "refused", "damaged", "unaffected", "failed", "silent"]
    lines = [[without_controls(row["decoder"]), *(row[key] for key in keys)] for row in rows]
    for line in table(headings, lines):
        print(line, file=stream)
    for row in rows:
        for wrong in row["wrong"]:
            text = (
                f"{row['decoder']}: {wrong['case']}: {wrong['damage']}: {wrong['outcome']}: {wrong['reason']}"
            )
            print(without_controls(text), file=stream)
        for case in row["disagreed"]:
            print(
                without_controls(f"{row['decoder']}: {case}: left out: wrong without damage already"),
                file=stream,
            )


def sweep(arguments, cases):
    refuse_existing([arguments.json], arguments.force)
    rows = []
    for command in arguments.decoder:
        progress = Progress("damages")
        rows.append(
            sweep_decoder(
                command,
                cases,
                arguments.sample,
                arguments.all,
                arguments.jobs,
                arguments.timeout,
                arguments.live,
                progress.step,
            )
        )
        progress.close()
    print_sweep(rows, sys.stderr if arguments.json == "-" else sys.stdout)
    silent = sum(row["silent"] for row in rows)
    if arguments.json:
        result = {
            "fvv_conformance_sweep": 1,
            "format": FORMAT,
            "sweep": rows,
            "figures": {"sweep.silent_wrong": silent},
        }
        write_outputs([(arguments.json, lambda: as_text(result))], arguments.force)
    return FAILED if any(row["silent"] or row["failed"] or row["disagreed"] for row in rows) else DONE


def render(arguments):
    refuse_existing([arguments.json], arguments.force)
    vectors = rendering.load_vectors(arguments.vectors or rendering.default_folder(), arguments.only)
    results = []
    for command in arguments.renderer:
        progress = Progress("pictures")
        results.append(rendering.test_renderer(command, vectors, arguments.timeout, progress.step))
        progress.close()
    for line in rendering.lines_of(results):
        print(without_controls(line), file=sys.stderr if arguments.json == "-" else sys.stdout)
    if arguments.json:
        write_outputs([(arguments.json, lambda: as_text(rendering.as_json(results)))], arguments.force)
    return FAILED if any(drawn.problem for one in results for drawn in one.drawn) else DONE


def list_cases(cases):
    for case in cases:
        print(f"{case.name}: {case.expected.get('title', '')}")
    return DONE


def main(given=None):
    arguments = parser().parse_args(given)
    try:
        if arguments.command == "render":
            return render(arguments)
        cases = load(arguments.cases or default_folder(), arguments.only)
        if not cases:
            raise BadCase(f"{arguments.cases or default_folder()}: no cases found")
        if arguments.command == "list":
            return list_cases(cases)
        if arguments.command == "show":
            return showing.show(arguments, cases)
        return run(arguments, cases) if arguments.command == "run" else sweep(arguments, cases)
    except (BadCase, DecoderError, OutputExists, OSError) as error:
        print(f"fvv-conformance: {error}", file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        return FAILED
