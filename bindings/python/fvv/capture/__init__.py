"""The former name of the package `fvv_capture`: its modules under this name are the same objects. It goes with the next version."""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import sys
import types
import warnings
from collections.abc import Sequence

warnings.warn("fvv.capture is now the package fvv_capture", DeprecationWarning, stacklevel=2)


class _Alias(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def find_spec(
        self, name: str, path: Sequence[str] | None, target: types.ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if not name.startswith(__name__ + ".") or name == __name__ + ".__main__":
            return None
        found = importlib.util.find_spec("fvv_capture" + name[len(__name__) :])
        return found and importlib.machinery.ModuleSpec(
            name, self, is_package=found.submodule_search_locations is not None
        )

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> types.ModuleType:  # pyright: ignore[reportIncompatibleMethodOverride]
        module = importlib.import_module("fvv_capture" + spec.name[len(__name__) :])
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: types.ModuleType) -> None:
        """The module was executed under its own name; its specification, which the import has replaced, is that one again."""
        assert module.__spec__ is not None
        module.__spec__ = module.__spec__.loader_state


# Before the finder of files: what an older version left in this folder is not found.
sys.meta_path.insert(0, _Alias())
