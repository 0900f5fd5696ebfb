"""The reference that pdoc makes of the docstrings: every public name has one, and pdoc takes all of them."""

import ast
import dataclasses
import html
import inspect
import re
import subprocess
import sys

import fvv
from conftest import ROOT


def own_members(owner):
    """(name, docstring) of the methods and properties of a class in Python; fields of dataclasses have comments."""
    fields = {field.name for field in dataclasses.fields(owner)} if dataclasses.is_dataclass(owner) else set()
    for name, member in vars(owner).items():
        if not name.startswith("_") and name not in fields:
            yield name, inspect.getdoc(member)


def stub_members(owner):
    """The same of a class of the extension module, whose docstrings are in its stub."""
    stub = ast.parse((ROOT / "bindings/python/fvv/_core.pyi").read_text())
    found = next(node for node in stub.body if isinstance(node, ast.ClassDef) and node.name == owner.__name__)
    for node in found.body:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            yield node.name, ast.get_docstring(node)


def documented():
    """(name, docstring) of everything that users see."""
    for name in fvv.__all__:
        found = getattr(fvv, name)
        if inspect.isfunction(found):
            yield name, found.__doc__
        elif inspect.isclass(found):
            yield name, found.__doc__
            members = stub_members if found.__module__ == "fvv._core" else own_members
            yield from ((f"{name}.{member}", text) for member, text in members(found))


def test_every_public_name_is_explained():
    found = dict(documented())
    assert len(found) > 120
    assert [name for name, text in found.items() if not text] == []


def test_fields_have_comments():
    """Of dataclasses: one sentence about units or meaning, unless the name and the class say all."""
    plain = {
        "id",
        "name",
        "width",
        "height",
        "number",
        "track",
        "tracks",
        "text",
        "title",
        "chunk",
        "bytes",
        "chunks",
        "groups",
        "frames",
    }
    missing = []
    for name in fvv.__all__:
        found = getattr(fvv, name)
        if inspect.isclass(found) and dataclasses.is_dataclass(found):
            source = inspect.getsource(found)
            own = vars(found).get("__annotations__", {})  # others are those of a base class
            for field in (field for field in dataclasses.fields(found) if field.name in own):
                line = re.search(
                    rf"(^    #: .*\n)?^    {field.name}: .*?(?=^    \w|\Z|^    @|^    #: )",
                    source,
                    re.M | re.S,
                )
                if not field.name.startswith("_") and field.name not in plain and "#:" not in line[0]:
                    missing.append(f"{name}.{field.name}")
    assert missing == []


def test_pdoc_writes_the_reference(tmp_path):
    program = [sys.executable, ROOT / "bindings/python/tests/api_reference.py", tmp_path]
    done = subprocess.run(program, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    page = html.unescape((tmp_path / "fvv.html").read_text())
    missing = [name for name, _ in documented() if f'id="{name}"' not in page]
    assert missing == []
    for part in (
        "metres on the axes of the world",
        "How much a camera sees around each vertex",
        "counter-clockwise seen from outside",
    ):
        assert part in re.sub(r"\s+", " ", page)
