"""Options of streams, by the table of fvv_mux: keyword arguments in, the texts that the core takes out."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from typing import Any

import numpy

from . import _core
from .errors import UsageError

#: By the name of the keyword argument.
TABLE = {str(row["name"]).replace("-", "_"): row for row in _core.option_table()}
#: Those of `fvv.mux` that frames from arrays do not have.
OF_CAPTURES = frozenset(name for name, row in TABLE.items() if row["of_capture"])
_FORMER = {
    "budget": "max_error",
    **{str(row["former"]).replace("-", "_"): name for name, row in TABLE.items() if row["former"]},
}


def current_name(name: str, stacklevel: int) -> str:
    """The name that an argument has now, with a warning where the next version does not know the given one."""
    now = _FORMER.get(name)
    if now is None:
        return name
    warnings.warn(
        f"{name} is called {now} now; the next version does not know the former name",
        DeprecationWarning,
        stacklevel=stacklevel + 1,
    )
    return now


def _text(name: str, value: Any) -> str:
    """An option's value in the words of fvvmux."""
    if isinstance(value, (bool, numpy.bool_)):
        return "on" if value else "off"
    if isinstance(value, (list, tuple)):
        return str(TABLE[name]["separator"]).join(str(part) for part in value)
    return str(value)


def option_texts(given: Mapping[str, Any], stacklevel: int = 3) -> dict[str, str]:
    """By the identifiers of the table. None is as if it was not given. stacklevel: of the caller of the package."""
    found: dict[str, str] = {}
    for given_name, value in given.items():
        name = current_name(given_name, stacklevel)
        if value is None:
            continue
        if name not in TABLE:
            raise UsageError(f"there is no option {given_name}")
        identifier = TABLE[name]["name"]
        if identifier in found:
            raise UsageError(f"{name}: expected once, found also as {given_name}")
        found[identifier] = _text(name, value)
    return found


def camera_names(cameras: str | Iterable[int | str] | None) -> list[str]:
    """As the core has them; none: all."""
    if cameras is None:
        return []
    return cameras.split(",") if isinstance(cameras, str) else [str(camera) for camera in cameras]
