"""The cases, by subject. Each module adds its cases when it is imported."""

import importlib
import pathlib


def load():
    here = pathlib.Path(__file__).parent
    for path in sorted(here.rglob("[a-z]*.py")):
        importlib.import_module(".".join([__name__, *path.relative_to(here).with_suffix("").parts]))
