"""The layers of tests/layers.json: no file uses a folder that its own folder may not use."""

import ast
import functools
import json
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TABLE = json.loads((ROOT / "tests/layers.json").read_text())
LAYERS = TABLE["layers"]
# Where an include or an import may start, besides the file's own folder.
C_ROOTS = ["libfvv/src", "libfvv", "tools", "tests", "bench", "js/decoder/wasm"] + sorted(
    str(p.relative_to(ROOT)) for p in ROOT.glob("libfvv/**/include")
)
PACKAGES = {"@fvv/" + p.parent.name: f"js/{p.parent.name}/src" for p in (ROOT / "js").glob("*/package.json")}
GENERATED_OR_FOREIGN = {"dist", "node_modules", "build"}


@functools.cache
def sources():
    return tuple(found_sources())


def found_sources():
    for folder in ["libfvv", "bindings", "tools", "tests", "bench", "js", "conformance", "spec"]:
        for path in sorted((ROOT / folder).rglob("*")):
            parts = set(path.relative_to(ROOT).parts)
            if (
                path.suffix in {".c", ".h", ".cpp", ".js", ".mjs", ".ts", ".py"}
                and not parts & GENERATED_OR_FOREIGN
            ):
                yield path


@functools.cache
def relative_to_root(path):
    return path.relative_to(ROOT).as_posix()


@functools.cache
def layer_of(path):
    """The row of the table that a file belongs to: the longest folder that holds it."""
    relative = relative_to_root(path)
    rows = [row for row in LAYERS if relative.startswith(row + "/")]
    return max(rows, key=len, default=None)


@functools.cache
def used_by(path):
    """The files of this project that a file includes or imports."""
    return tuple(find_used(path))


@functools.cache
def is_file(path):
    return path.is_file()


def find_used(path):
    text = path.read_text()
    if path.suffix in {".c", ".h", ".cpp"}:
        for name in re.findall(r'^\s*#\s*include\s+"([^"]+)"', text, re.M):
            candidates = [path.parent / name] + [ROOT / root / name for root in C_ROOTS]
            found = next((c for c in candidates if is_file(c)), None)
            if found:
                yield found.resolve()
    elif path.suffix == ".py":
        for name in re.findall(r"^\s*(?:from|import)\s+\.?(\w[\w.]*)", text, re.M):
            for root in [path.parent, ROOT, ROOT / "conformance", ROOT / "bindings/python"]:
                candidate = root / name.replace(".", "/")
                found = next(
                    (c for c in [candidate.with_suffix(".py"), candidate / "__init__.py"] if is_file(c)),
                    None,
                )
                if found:
                    yield found.resolve()
                    break
    else:
        # Examples in comments use other packages; types are no dependency.
        text = re.sub(r"/\*.*?\*/|^\s*//.*?$|import type[^;]*;", "", text, flags=re.S | re.M)
        for name in re.findall(r"""(?:^|[^\w.])(?:from|import)\s*\(?\s*["']([^"']+)["']""", text):
            package = next((p for p in PACKAGES if name == p or name.startswith(p + "/")), None)
            if package:
                yield ROOT / PACKAGES[package] / "index.js"
            elif name.startswith("."):
                found = (path.parent / name).resolve()
                if is_file(found) and ROOT in found.parents:
                    yield found


def allowed(row):
    for entry in LAYERS[row]:
        yield from TABLE["groups"].get(entry, [entry])


def within(path, folder):
    return folder == "*" or relative_to_root(path).startswith(folder + "/")


def test_every_folder_of_sources_has_a_row():
    missing = {p.parent.relative_to(ROOT).as_posix() for p in sources() if layer_of(p) is None}
    assert not missing, f"tests/layers.json has no row for {sorted(missing)}"


def test_no_row_without_files():
    empty = [row for row in LAYERS if not any(within(p, row) for p in sources())]
    assert not empty, empty


def test_files_use_what_their_folder_may_use():
    wrong, seen = [], 0
    for path in sources():
        row = layer_of(path)
        for used in used_by(path):
            seen += 1
            if within(used, row) or any(within(used, folder) for folder in allowed(row)):
                continue
            wrong.append(f"{path.relative_to(ROOT)} uses {used.relative_to(ROOT)}")
    assert seen > 1000, "the test no longer finds includes and imports"
    assert not wrong, "\n".join(wrong)


def test_the_core_uses_no_cxx_library():
    core = [p for p in sources() if within(p, "libfvv/src") or within(p, "libfvv/include")]
    assert core
    for path in core:
        for used in used_by(path):
            assert within(used, "libfvv/src") or within(used, "libfvv/include"), path


def test_the_neighbours_of_the_core_know_public_headers_alone():
    neighbours = [row for row in LAYERS if row.startswith("libfvv/") and not row.startswith("libfvv/src/")]
    assert len(neighbours) > 10
    inside = {row: [used for used in allowed(row) if not used.endswith("/include")] for row in neighbours}
    assert not any(inside.values()), inside


def test_fvv_capture_uses_the_public_names_of_fvv_alone():
    """No module or name of fvv that begins with an underscore, and nothing relative that leaves the package."""
    folder = ROOT / "bindings/python/fvv_capture"
    seen, wrong = 0, []
    for path in sorted(folder.rglob("*.py")):
        depth = len(path.relative_to(folder).parts)
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom):
                names = [*(node.module or "").split("."), *(alias.name for alias in node.names)]
                ours = node.level == 0 and names[0] == "fvv"
                wrong += [f"{path.name}: {node.lineno}"] * (node.level > depth)
            elif isinstance(node, ast.Import):
                names = [part for alias in node.names for part in alias.name.split(".")]
                ours = names[0] == "fvv"
            else:
                continue
            seen += ours
            if ours and any(name.startswith("_") and not name.startswith("__") for name in names):
                wrong.append(f"{path.name}: {node.lineno}")
    assert seen > 30
    assert wrong == []


def cycle_in(graph):
    """The files of a cycle, each using the next one; None if there is none."""
    done, path = set(), []

    def visit(node):
        if node in path:
            return [*path[path.index(node) :], node]
        if node in done:
            return None
        path.append(node)
        found = next(filter(None, map(visit, graph.get(node, []))), None)
        path.pop()
        done.add(node)
        return found

    return next(filter(None, map(visit, graph)), None)


def test_javascript_has_no_cycles_of_imports():
    scripts = [p for p in sources() if p.suffix in {".js", ".mjs"} and within(p, "js")]
    assert len(scripts) > 100
    graph = {p: sorted(used_by(p)) for p in scripts}
    cycle = cycle_in(graph)
    assert cycle is None, " -> ".join(p.relative_to(ROOT).as_posix() for p in cycle)
    assert cycle_in({1: [2], 2: [3], 3: [2]}) == [2, 3, 2]


def test_the_decoder_reaches_networks_through_one_file():
    seam = ROOT / "js/decoder/src/sources/network.js"
    asks = re.compile(r"(?<![\w.#*])fetch\(|globalThis\.fetch|XMLHttpRequest|EventSource\(|new WebSocket\(")
    comments = re.compile(r"/\*.*?\*/|^\s*//.*?$", re.S | re.M)
    scripts = sorted((ROOT / "js/decoder/src").rglob("*.js"))
    found = [p for p in scripts if asks.search(comments.sub("", p.read_text()))]
    assert found == [seam]
