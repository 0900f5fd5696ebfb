"""Writes the reference of the package as HTML, by pdoc: python api_reference.py FOLDER. The docstrings of the extension module
are those of its stub."""

import pathlib
import sys
import types
import warnings

import fvv
import pdoc.doc
import pdoc.doc_pyi
import pdoc.render


def take(target, source):
    """Gives what pdoc shows of a class or its members the docstrings and types of the same in the stub."""
    target.docstring = source.docstring
    for name, member in source.members.items():
        shown = target.members.get(name)
        if shown is None:
            continue
        shown.docstring = member.docstring
        if isinstance(member, pdoc.doc.Function):
            shown.signature, shown.funcdef = member.signature, member.funcdef
        else:
            shown.annotation = member.annotation


def add_option_types():
    """pdoc evaluates what only type checkers import: a stub without a module."""
    module = types.ModuleType("fvv._options")
    exec((pathlib.Path(fvv.__file__).parent / "_options.pyi").read_text(), module.__dict__)
    sys.modules[module.__name__] = module


def main(folder):
    warnings.simplefilter("error")
    add_option_types()
    module, core = pdoc.doc.Module(fvv), pdoc.doc.Module(fvv._core)
    pdoc.doc_pyi.include_typeinfo_from_stub_files(core)
    for name, member in module.members.items():
        if getattr(getattr(fvv, name), "__module__", None) == "fvv._core":
            take(member, core.members[name])
    out = pathlib.Path(folder)
    out.mkdir(parents=True, exist_ok=True)
    (out / "fvv.html").write_text(pdoc.render.html_module(module, {"fvv": module}))


if __name__ == "__main__":
    main(sys.argv[1])
