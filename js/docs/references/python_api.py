"""Writes the reference of the Python package as Markdown, from its sources: python3 python_api.py PACKAGE_FOLDER OUT.md
Nothing is imported, so that the extension module need not be built; its docstrings are in its stub."""

import ast
import pathlib
import re
import sys


def shown(node):
    """Whether users see a member."""
    name = getattr(node, "name", "_")
    return not name.startswith("_") or name in {"__init__", "__getitem__", "__iter__", "__len__"}


def signature(node, owner=None):
    """A function as it is called, or a property with its type."""
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    if any(ast.unparse(d) == "property" for d in node.decorator_list):
        return f"{node.name}: {ast.unparse(node.returns)}" if node.returns else node.name
    arguments = ast.unparse(node.args)
    if owner:
        arguments = re.sub(r"^(?:self|cls)(?:, )?(?:/, )?", "", arguments)
    name = owner if node.name == "__init__" else node.name
    return f"{name}({arguments}){'' if node.name == '__init__' else returns}"


def escaped(text):
    """A docstring as Markdown: code spans stay, the rest has no markup but paragraphs."""
    # What is said of a parameter is an item of a list.
    text = re.sub(r"(?m)^((?:\*{0,2}[a-z_]+(?:, )?)+): (?=\S)", r"- `\1`: ", text or "")
    text = re.sub(r"(?m)(?<!\n)\n(- `)", r"\n\n\1", text)
    parts = re.split(r"(``?[^`]+``?)", text)
    return "".join(
        p if p.startswith("`") else re.sub(r"([*\[\]<{}])", r"\\\1", p).replace("\\<", "&lt;") for p in parts
    )


def fields_of(node, lines):
    """(name, type, default, comment) of the fields of a dataclass; comments begin with #: and end their line."""
    for member in node.body:
        if not isinstance(member, ast.AnnAssign) or member.target.id.startswith("_"):
            continue
        text = " ".join(lines[member.lineno - 1 : member.end_lineno])
        comment = re.search(r"#: ?(.*?)(?:\s*\))?$", text)
        above = re.match(r"\s*#: ?(.*)", lines[member.lineno - 2])
        default = f" = {ast.unparse(member.value)}" if member.value else ""
        note = comment[1] if comment else above[1] if above else ""
        yield member.target.id, ast.unparse(member.annotation), default, note


def write_class(name, node, lines, out):
    bases = ", ".join(ast.unparse(b) for b in node.bases)
    out += [f"## {name}", "", "```python", f"class {name}" + (f"({bases})" if bases else ""), "```", ""]
    out += [escaped(ast.get_docstring(node)), ""]
    fields = [f for f in fields_of(node, lines)]
    if fields:
        out += ["| field | type | |", "|---|---|---|"]
        for field, kind, default, note in fields:
            cell = f"{kind}{default}".replace("|", "\\|")
            out.append(f"| `{field}` | `{cell}` | {escaped(note)} |".replace("||", "| |"))
        out.append("")
    for member in node.body:
        if not isinstance(member, ast.FunctionDef) or not shown(member):
            continue
        if any(ast.unparse(d).endswith("overload") for d in member.decorator_list):
            continue
        text = ast.get_docstring(member)
        if text is None and member.name.startswith("__"):
            continue
        title = name if member.name == "__init__" else member.name.replace("__", "\\_\\_")
        out += [f"### {title} {{#{name}.{member.name}}}", "", "```python", signature(member, name), "```", ""]
        out += [escaped(text), ""]


def main(package, target):
    package = pathlib.Path(package)
    text = (package / "__init__.py").read_text()
    module = ast.parse(text)
    names = next(
        [e.value for e in node.value.elts]
        for node in module.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
    )
    origins = {}  # name: (file, name there)
    for node in module.body:
        if isinstance(node, ast.ImportFrom) and node.module:
            file = "_core.pyi" if node.module == "_core" else node.module.replace(".", "/") + ".py"
            origins.update({a.asname or a.name: (file, a.name) for a in node.names})
    found = {"def": [], "class": [], "other": []}
    for name in names:
        file, original = origins.get(name, ("__init__.py", name))
        if not (package / file).exists():
            continue
        source = (package / file).read_text()
        body = ast.parse(source).body
        # Of an overloaded function the last one has the docstring.
        named = [n for n in body if getattr(n, "name", None) == original]
        values = [
            n.value for n in body if isinstance(n, ast.Assign) and ast.unparse(n.targets[0]) == original
        ]
        if named:
            kind = "class" if isinstance(named[-1], ast.ClassDef) else "def"
            found[kind].append((name, named[-1], source.splitlines()))
        elif values:
            found["other"].append((name, ast.unparse(values[-1])))
        elif not (package / name).is_dir():
            raise SystemExit(f"{package}: {name} of __all__ is not found in {file}")
    out = ["# Python", "", "The names of the module `fvv`. [fvv for Python](./) explains them by tasks.", ""]
    out += ["## Functions", ""]
    for name, node, _ in found["def"]:
        title = signature(node).replace(f"{node.name}(", f"{name}(", 1)
        out += [f"### {name} {{#fvv.{name}}}", "", "```python", f"fvv.{title}", "```", ""]
        out += [escaped(ast.get_docstring(node)), ""]
    for name, node, lines in found["class"]:
        write_class(name, node, lines, out)
    if found["other"]:
        out += ["## Other names", ""]
        out += [f"- `{name}`: `{value}`" for name, value in found["other"]]
    pathlib.Path(target).parent.mkdir(parents=True, exist_ok=True)
    pathlib.Path(target).write_text("\n".join(out) + "\n")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
