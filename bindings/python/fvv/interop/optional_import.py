"""Imports of optional packages: when one is missing, the error names the extra that installs it."""

from __future__ import annotations

import importlib
from typing import Any


def optional_import(module: str, extra: str) -> Any:
    """A module of another package. ImportError names the extra of this package that installs it; a package that is installed and
    does not work raises what it raises."""
    package = module.split(".")[0]
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.split(".")[0] != package:
            raise
        raise ImportError(f"{package} is needed: pip install fvv[{extra}]") from error
