"""Every ctest entry has one cost and at least one area, so that ./run test quick, AREA, and nightly miss none (docs/evidence/tests.md)."""

import json
import os
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
COSTS = {"quick", "area", "whole", "nightly"}


def known_areas():
    text = (ROOT / "tests/labels.cmake").read_text()
    return set(re.search(r"^set\(FVV_TEST_AREAS ([^)]*)\)", text, re.M)[1].split())


def listed():
    build = os.environ["FVV_BUILD"]
    done = subprocess.run(["ctest", "--show-only=json-v1"], cwd=build, capture_output=True, check=True)
    return json.loads(done.stdout)["tests"]


def entries():
    """Name to labels. Executables that were not built have no cases yet."""
    found = {}
    for test in listed():
        labels = [p["value"] for p in test.get("properties", []) if p["name"] == "LABELS"]
        if not re.search(r"_NOT_BUILT(-\w+)?$", test["name"]):
            found[test["name"]] = labels[0] if labels else []
    assert len(found) > 100
    return found


def test_every_entry_has_one_cost_and_an_area():
    areas = known_areas()
    assert not areas & COSTS
    wrong = {
        name: labels
        for name, labels in entries().items()
        if len(COSTS & set(labels)) != 1 or not areas & set(labels) or set(labels) - COSTS - areas
    }
    assert not wrong


def test_every_area_has_entries():
    assert known_areas() == {label for labels in entries().values() for label in labels} - COSTS


def test_every_area_has_entries_of_its_own_command():
    # ./run test real runs the nightly ones.
    offered = {label for labels in entries().values() if {"quick", "area"} & set(labels) for label in labels}
    assert known_areas() - {"real"} <= offered


def test_a_shorter_form_is_of_an_entry_that_the_whole_run_has():
    # The whole run leaves them out by name.
    found = entries()
    shorter = [name for name in found if re.match("(quick|area): ", name)]
    assert len(shorter) > 15
    whole = [name for name in found if name not in shorter]
    for name in shorter:
        form = re.compile(r"(cli: )?" + name.split(": ")[1] + r"([.:]|$)")
        assert any(form.match(other) for other in whole), name


def test_no_entry_writes_into_the_checkout():
    # Cases that write files of conformance/ again are run by hand: beside a test that reads such a file, they would empty it.
    sources = [p.read_text() for p in (ROOT / "tests").rglob("*_test.cpp")]
    makers = [
        name for text in sources for name in re.findall(r'TEST_CASE\("([^"]*)",\s*"[^"]*\[make\]', text)
    ]
    assert len(makers) >= 9
    assert not [test["name"] for test in listed() if test["name"].split(".", 1)[-1] in makers]
    patterns = [word for test in listed() for word in test.get("command", []) if word.startswith("~[")]
    assert patterns and all("~[make]" in pattern for pattern in patterns)
