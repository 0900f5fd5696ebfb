"""./run charts [NAME...] [--quick [--accept]] [--list] [--draw]: measures, draws, and writes docs/evidence/charts."""

import argparse
import importlib
import pathlib
import pkgutil
import sys
import time

from . import drawing, experiment, report

# Experiments of other modules follow, by the modules' names.
ORDER = (
    "system",
    "choices",
    "mesh",
    "texture",
    "visibility",
    "hull",
    "chain",
    "cameras",
    "rungs",
    "groups",
    "presets",
    "track",
    "calibration",
    "paper",
    "growth",
)


def all_experiments():
    """Those of all modules of this folder that list some."""
    folder = str(pathlib.Path(__file__).parent)
    names = [
        m.name.removeprefix(f"{__package__}.") for m in pkgutil.walk_packages([folder], f"{__package__}.")
    ]
    names.remove("__main__")
    names.sort(key=lambda name: (ORDER.index(name) if name in ORDER else len(ORDER), name))
    modules = [importlib.import_module(f"{__package__}.{name}") for name in names]
    return [e for module in modules for e in getattr(module, "EXPERIMENTS", ())]


def quick(experiments, accept):
    """Returns the exit code: 1 when a headline figure is worse than the committed one, or gone."""
    now = {}
    for one in experiments:
        results = one.measure(True)
        if results is not None:
            now |= {f"{one.name}.{f}": v for f, v in one.headlines(results).items()}
    if accept:
        report.accept(now)
        print(f"charts: wrote {report.HEADLINES}")
        return 0
    names = {e.name for e in experiments}
    committed = {f: v for f, v in report.committed_headlines().items() if f.split(".")[0] in names}
    rows = report.compare(committed, now)
    print(report.table(rows))
    bad = [figure for figure, _, _, verdict in rows if verdict in ("worse", "gone")]
    if bad:
        print(
            f"charts: worse than docs/evidence/charts/results/headlines.json, or gone: {', '.join(bad)}",
            file=sys.stderr,
        )
        print("charts: on purpose: ./run charts --quick --accept", file=sys.stderr)
    return 1 if bad else 0


def main():
    experiments = all_experiments()
    parser = argparse.ArgumentParser(
        prog="./run charts", description="Measure, draw, and write docs/evidence/charts."
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="experiments; default: all")
    parser.add_argument(
        "--quick", action="store_true", help="headline figures alone; exit code 1 when one is worse"
    )
    parser.add_argument(
        "--accept",
        action="store_true",
        help="with --quick: write docs/evidence/charts/results/headlines.json",
    )
    parser.add_argument("--draw", action="store_true", help="measure nothing; draw and write the page again")
    parser.add_argument("--list", action="store_true", help="print the experiments")
    arguments = parser.parse_args()
    if wrong := set(arguments.names) - {e.name for e in experiments}:
        parser.error(
            f"no experiment {', '.join(sorted(wrong))}; there are {', '.join(e.name for e in experiments)}"
        )
    if arguments.accept and (arguments.names or not arguments.quick):
        parser.error("--accept goes with --quick and no names")
    chosen = [e for e in experiments if not arguments.names or e.name in arguments.names]
    if arguments.list:
        print("\n".join(f"{e.name:20} {e.title}" for e in chosen))
        return 0
    if arguments.quick:
        return quick(chosen, arguments.accept)
    for one in chosen:
        if not arguments.draw:
            begin = time.perf_counter()
            results = one.measure(False)
            experiment.store(one.name, results, time.perf_counter() - begin)
        if record := experiment.load(one.name):
            with drawing.styled():
                one.draw(record["results"], experiment.PAGES)
            print(f"{one.name}: {report.first_sentence(one.text(record['results']))}", flush=True)
    (experiment.PAGES / "README.md").write_text(report.page(experiments))
    unjustified = sum(not row.justified for row in report.default_rows(report.measured(experiments)))
    print(f"charts.defaults_unjustified: {unjustified}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
