"""docs/evidence/charts/README.md, made from the stored results, and the comparison of headline figures with the committed ones."""

import json
import re
import textwrap

from . import choices, experiment

HEADLINES = experiment.results_file("headlines")
TOLERANCE = 0.05
# Of figures with "time" in their name: ratios of times in the same run, which may differ by this much between processors.
TIME_TOLERANCE = 0.5

HEAD = """# Charts

How fast, how accurate and how steady fvv is, where it fails, and how its costs grow. `./run charts` measures all of this again and
writes this page, its pictures and its figures; `./run charts NAME...` does so for some experiments. The figures here are those of a
generated capture (`fvvsynth`), so that anyone gets the same bytes. Times depend on the machine: compare them within one chart only.

`./run charts --quick` measures the headline figures alone and fails when one is more than {tolerance:.0f} % worse than in
[headlines.json](results/headlines.json) (ratios of times: {time_tolerance:.0f} %, because they depend on the processor). A change that makes one worse on purpose commits new ones: `./run charts --quick --accept`.
"""


def first_sentence(text):
    """The bold sentence of an experiment's text, which says what its chart means."""
    found = re.search(r"\*\*(.+?)\*\*", text, re.S)
    return " ".join(found.group(1).split()) if found else ""


def wrapped(text):
    """Paragraphs in lines of the same length; tables, lists, pictures and headings as they are."""
    out = []
    for paragraph in text.strip().split("\n\n"):
        if not paragraph.startswith(("|", "-", "!", "#", "<")):
            paragraph = "\n".join(
                textwrap.wrap(
                    " ".join(paragraph.split()), 130, break_long_words=False, break_on_hyphens=False
                )
            )
        out.append(paragraph)
    return "\n\n".join(out)


def pictures(text):
    return re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text)


def anchor(title):
    """Of a heading, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def origin(record):
    """A line on where and when the figures were measured."""
    machine = record["machine"]
    versions = ", ".join(f"{name} {version}" for name, version in record["versions"].items())
    return (
        f"<sub>`{record['command']}`, {record['date']}, {record['seconds']} s on {machine['cores']} cores of "
        f"{machine['processor']}; {versions}. Figures: [{record['experiment']}.json](results/{record['experiment']}.json)</sub>"
    )


def measured(experiments):
    """Those that have results, with their records."""
    return [(e, record) for e in experiments if (record := experiment.load(e.name))]


def default_rows(found):
    """The rows of the table of defaults. What a chart does not justify counts as justified where it is chosen for each scene."""
    results = {e.name: record["results"] for e, record in found}
    chosen = choices.chosen_per_scene(results["choices"]) if "choices" in results else {}
    rows = []
    for e, record in found:
        for fields in e.defaults(record["results"]):
            row = experiment.Default(*fields)
            verdict = f"[{e.name}](#{anchor(e.title)}): {row.verdict}"
            if not row.justified and row.option in chosen:
                where = f"[choices](#{anchor(choices.EXPERIMENTS[0].title)})"
                verdict += f". Chosen per scene by default (`--view-loss`): {chosen[row.option]} ({where})"
            elif not row.justified:
                verdict += ". **Not justified**"
            rows.append(row._replace(verdict=verdict, justified=row.justified or row.option in chosen))
    return rows


def page(experiments):
    """The text of README.md, of those experiments that have results."""
    found = measured(experiments)
    texts = [e.text(record["results"]) for e, record in found]
    lines = [
        HEAD.format(tolerance=100 * TOLERANCE, time_tolerance=100 * TIME_TOLERANCE),
        "## What they say",
        "",
    ]
    lines += [f"- [{e.title}](#{anchor(e.title)}): {first_sentence(t)}" for (e, _), t in zip(found, texts)]
    lines += [
        "",
        "## Defaults and the charts that justify them",
        "",
        "| option | default | what the chart says |",
    ]
    lines += ["|---|---|---|"]
    for row in default_rows(found):
        shown = f"`{row.option}`" if " --" in row.option else row.option
        lines.append(f"| {shown} | {row.value} | {row.verdict} |")
    for (e, record), text in zip(found, texts):
        lines += ["", f"## {e.title}", "", wrapped(text), "", origin(record)]
    return "\n".join(lines) + "\n"


def compare(committed, now):
    """[(figure, committed, now, verdict)] with the verdicts "same", "better", "worse", "new" and "gone"."""
    rows = []
    for figure in sorted({*committed, *now}):
        before, after = committed.get(figure), now.get(figure)
        tolerance = TIME_TOLERANCE if "time" in figure else TOLERANCE
        if before is None:
            verdict = "new"
        elif after is None:
            verdict = "gone"
        elif after > before + tolerance * abs(before):
            verdict = "worse"
        else:
            verdict = "better" if after < before - tolerance * abs(before) else "same"
        rows.append((figure, before, after, verdict))
    return rows


def table(rows):
    """The comparison as lines of text."""

    def cell(value):
        return "-" if value is None else f"{value:.5g}"

    width = max([6, *(len(figure) for figure, *_ in rows)])
    lines = [f"{'figure':{width}}{'committed':>12}{'now':>12}{'change':>9}"]
    for figure, before, after, verdict in rows:
        change = f"{100 * (after / before - 1):+.1f} %" if before and after is not None else ""
        lines.append(f"{figure:{width}}{cell(before):>12}{cell(after):>12}{change:>9}  {verdict}")
    return "\n".join(lines)


def committed_headlines():
    return json.loads(HEADLINES.read_text()) if HEADLINES.exists() else {}


def accept(now):
    HEADLINES.parent.mkdir(parents=True, exist_ok=True)
    HEADLINES.write_text(json.dumps(experiment.rounded(dict(sorted(now.items()))), indent=1) + "\n")
