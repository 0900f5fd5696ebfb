"""The cases: folders with input.fvv and expected.json in the tiers valid, uncommon and faulty."""

import fnmatch
import json
import pathlib
from typing import NamedTuple

TIERS = ("valid", "uncommon", "faulty")


class Case(NamedTuple):
    """name: tier and folder, such as valid/mesh_raw. expected: expected.json, what the case shows and the report of a decoder."""

    name: str
    tier: str
    path: pathlib.Path  # of input.fvv
    expected: dict

    @property
    def content(self):
        return self.path.read_bytes()


class BadCase(ValueError):
    """A case that is not complete."""


def default_folder():
    """The cases of a wheel, or those of the checkout."""
    here = pathlib.Path(__file__).resolve().parent
    installed = here / "cases"
    return installed if installed.is_dir() else here.parent / "cases"


def read_json(path):
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadCase(f"{path}: {error}") from error


def load(folder, only=None):
    """Cases below a folder, in order of their names. only: patterns of names with * and ?; None: all."""
    found = []
    for tier in TIERS:
        for case in sorted((pathlib.Path(folder) / tier).glob("*/expected.json")):
            name = f"{tier}/{case.parent.name}"
            if only and not any(
                fnmatch.fnmatch(name, pattern) or fnmatch.fnmatch(case.parent.name, pattern)
                for pattern in only
            ):
                continue
            path = case.parent / "input.fvv"
            if not path.is_file():
                raise BadCase(f"{path}: missing")
            found.append(Case(name, tier, path, read_json(case)))
    return found
