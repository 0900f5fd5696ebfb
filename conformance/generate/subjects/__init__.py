"""The cases, by subject. Each module adds its cases when it is imported."""

import importlib
import pathlib


def load():
    for path in sorted(pathlib.Path(__file__).parent.glob("[a-z]*.py")):
        importlib.import_module(f"{__name__}.{path.stem}")
