"""One word, one meaning: the names that docs/guide/glossary.md forbids are in no option, JSON key, public header or export."""

import ast
import json
import os
import pathlib
import re
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent

# Names with a forbidden word that stay, and why.
STAY = {
    "options": {
        "--background": "fvvrender: the colour behind everything; fvvmux: the former spelling of --tile-fill, for one version",
        "--no-background": "the former spelling of --no-environment, for one version",
    },
    "JSON": {},
    "C": {},
    "Python": {"background": "the colour behind everything that render draws"},
    "JavaScript": {},
}


# Names that are still to change, as patterns.
PENDING = {}


def words_of(name):
    """The words of an identifier in any convention: setQuality, FVV_TRACK_MESH, --max-error."""
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|[0-9]+", name)]


def forbidden():
    """The words of the last column of the glossary's table."""
    page = (ROOT / "docs/guide/glossary.md").read_text()
    rows = page[page.index("## One word, one meaning") :].splitlines()
    cells = [row.strip("|").split("|")[-1] for row in rows if row.startswith("| ")]
    return {word for cell in cells[1:] for word in re.findall(r"`(\w+)`", cell)}


def options():
    """Of all programs."""
    folder = pathlib.Path(os.environ["FVV_TOOLS_DIR"]).resolve()
    found = set()
    for program in sorted(folder.glob("fvv*/fvv*")):
        if program.name == program.parent.name and os.access(program, os.X_OK):
            done = subprocess.run([program, "--help-json"], capture_output=True, text=True)
            found |= set(re.findall(r'"(--[a-z][a-z0-9-]*)"', done.stdout))
    capture = (ROOT / "bindings/python/fvv_capture/arguments.py").read_text()
    return found | set(re.findall(r'"(--[a-z][a-z0-9-]*)', capture))


def keys():
    """Of what the schemas describe."""
    found = set()

    def walk(value):
        if isinstance(value, dict):
            if isinstance(value.get("properties"), dict):
                found.update(value["properties"])
            for inner in value.values():
                walk(inner)
        elif isinstance(value, list):
            for inner in value:
                walk(inner)

    for path in [*(ROOT / "spec").glob("*.schema.json"), ROOT / "conformance/case.schema.json"]:
        walk(json.loads(path.read_text()))
    return found


def without_comments(text):
    return re.sub(r"""/\*.*?\*/|//[^\n]*|"[^"\n]*"|'[^'\n]*'""", "", text, flags=re.S)


def identifiers(pattern):
    found = set()
    for path in sorted(ROOT.glob(pattern)):
        found |= set(re.findall(r"[A-Za-z_]\w*", without_comments(path.read_text())))
    return found


def exports_of_python():
    """Public classes, functions, methods, fields and arguments of fvv."""
    found = set()
    for path in [
        *(ROOT / "bindings/python/fvv").glob("*.py"),
        *(ROOT / "bindings/python/fvv/interop").glob("*.py"),
    ]:
        tree = ast.parse(path.read_text())
        owners = [tree, *(node for node in tree.body if isinstance(node, ast.ClassDef))]
        for node in (node for owner in owners for node in owner.body):
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)) and not node.name.startswith("_"):
                found.add(node.name)
                if isinstance(node, ast.FunctionDef):
                    found |= {one.arg for one in [*node.args.args, *node.args.kwonlyargs]}
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                found.add(node.target.id)
    return {name for name in found if not name.startswith("_")}


# What of the platform is no name of ours.
OF_BROWSERS = re.compile(r"ImageBitmap\w*|ImageData\w*|\w*ImageElement|CanvasImage\w*|ImageDecoder")
SURFACES = {
    "options": (options, 150),
    "JSON": (keys, 250),
    "C": (lambda: identifiers("libfvv/include/fvv/*.h"), 800),
    "Python": (exports_of_python, 200),
    "JavaScript": (
        lambda: {n for n in identifiers("js/*/src/*.d.ts") if not OF_BROWSERS.fullmatch(n)},
        300,
    ),
}


@pytest.mark.parametrize("surface", SURFACES)
def test_names_have_no_forbidden_word(surface):
    collect, least = SURFACES[surface]
    names, words = collect(), forbidden()
    assert len(names) >= least, "the names are no longer found"
    found = {name for name in names if words & set(words_of(name))}
    pending = re.compile(PENDING.get(surface, "(?!)"))
    wrong = sorted(name for name in found - STAY[surface].keys() if not pending.fullmatch(name))
    assert wrong == [], "docs/guide/glossary.md says which words to use"


def test_the_table_is_read():
    assert {"background", "images", "reach"} <= forbidden()
    assert words_of("setQuality") == ["set", "quality"]
    assert words_of("FVV_TRACK_MESH") == ["fvv", "track", "mesh"]
    assert words_of("--no-background") == ["no", "background"]
    assert words_of("BackgroundPart") == ["background", "part"]
