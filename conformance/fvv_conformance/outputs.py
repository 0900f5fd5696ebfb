"""What a run prints and writes: a table, JUnit XML, JSON and an HTML page."""

import json
import os
import pathlib
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

from .cases import TIERS

PAGE = pathlib.Path(__file__).with_name("page.html")


class OutputExists(Exception):
    """A file is there, and --force was not given."""


def write_file(path, text, force=False):
    """All of it or nothing. A file that is there stays unless force is set."""
    path = pathlib.Path(path)
    if path.exists() and not force:
        raise OutputExists(f"{path}: exists; --force replaces it")
    descriptor, part = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(part, 0o644)
        os.replace(part, path)
    except BaseException:
        os.unlink(part)
        raise


def table(headings, rows):
    """Columns of the same width; the first to the left, others to the right."""
    lines = [headings, *rows]
    widths = [max(len(str(line[i])) for line in lines) for i in range(len(headings))]
    for line in lines:
        cells = [str(cell).rjust(width) for cell, width in zip(line[1:], widths[1:])]
        yield "  ".join([str(line[0]).ljust(widths[0]), *cells]).rstrip()


def without_controls(text):
    """Texts of decoders reach terminals and XML."""
    return "".join(c if c.isprintable() else "?" for c in str(text))


def print_result(result, stream=None):
    stream = stream or sys.stdout
    rows = []
    for one in result["decoders"]:
        counts = [f"{one['agreed'][tier]['agreed']}/{one['agreed'][tier]['of']}" for tier in TIERS]
        rows.append(
            [without_controls(f"{one['name']} {one['version']}").strip(), *counts, f"{one['seconds']:.1f}"]
        )
    for line in table(["decoder", *TIERS, "seconds"], rows):
        print(line, file=stream)
    for one in result["decoders"]:
        for line in one["skipped"]:
            print(without_controls(f"{one['name']}: {line}"), file=stream)
        for row in one["disagreements"]:
            for difference in row["differences"][:8]:
                print(without_controls(f"{one['name']}: {row['case']}: {difference}"), file=stream)
            if len(row["differences"]) > 8:
                print(f"{one['name']}: {row['case']}: {len(row['differences']) - 8} more", file=stream)


def junit(result):
    """A suite for each decoder, a test for each case."""
    root = ElementTree.Element("testsuites", name="fvv conformance")
    for one in result["decoders"]:
        bad = {row["case"]: row["differences"] for row in one["disagreements"]}
        suite = ElementTree.SubElement(
            root,
            "testsuite",
            name=without_controls(one["name"]),
            tests=str(len(result["cases"])),
            failures=str(len(bad)),
            errors="0",
            time=str(one["seconds"]),
        )
        for case in result["cases"]:
            test = ElementTree.SubElement(
                suite, "testcase", classname=f"fvv.{case['tier']}", name=case["name"].split("/")[-1]
            )
            if case["name"] in bad:
                lines = [without_controls(line) for line in bad[case["name"]]]
                ElementTree.SubElement(test, "failure", message=lines[0]).text = "\n".join(lines)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def html(result):
    """The page with the result inside. In a script element only "<" could end it."""
    data = json.dumps(result, ensure_ascii=True).replace("<", "\\u003c")
    return PAGE.read_text(encoding="utf-8").replace("/*RESULT*/ null", data)


def as_text(result):
    return json.dumps(result, indent=1) + "\n"
