"""Shared by the tests of conformance: where streams and cases are."""

import json
import pathlib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
CONFORMANCE = ROOT / "conformance"


class Case:
    """A folder of conformance/cases."""

    def __init__(self, folder):
        self.name, self.path = f"{folder.parent.name}/{folder.name}", folder / "input.fvv"
        self.data = self.path.read_bytes()
        self.expected = json.loads((folder / "expected.json").read_text())


def cases(tier):
    return [Case(path.parent) for path in sorted((CONFORMANCE / "cases" / tier).glob("*/expected.json"))]


def vectors():
    """Streams of valid cases that other writers wrote, most of them libfvv."""
    return sorted(CONFORMANCE.glob("cases/valid/vector_*/input.fvv"))
