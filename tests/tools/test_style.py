"""Style of sources: formatting, types of JavaScript, files in a folder, lines in a file, plain English, subjects of commits.

With FVV_STYLE=changed, formats and English are checked in the files alone that differ from what is published.
"""

import collections
import functools
import os
import pathlib
import re
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BIN = pathlib.Path(sys.executable).parent
# js/*/dist and node_modules are generated or from others.
FOLDERS = ["libfvv", "bindings", "tools", "tests", "bench"] + sorted(
    str(p.relative_to(ROOT))
    for p in (ROOT / "js").glob("[!n]*/*")
    if p.is_dir() and p.name not in {"dist", "node_modules"}
)
PYTHON = ["spec", "bench", "bindings", "conformance", "tests", "tests/same_bytes", "js/docs"]
GENERATED = {"format.h", "layout.h", "crc32c_table.h"}

# One concept, one file: small enough to read, and few enough in a folder to find it.
MOST_FILES = 25  # in a folder, without its subfolders
MOST_LINES = 800  # in a file
# Folders and files that exceed a limit, with the reason. Remove an entry when its folder or file no longer does.
LARGE_FOLDERS = {}
LONG_FILES = {}


def git(*arguments):
    """The lines that git prints; None: there is no git, or it has no answer."""
    try:
        done = subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True)
    except FileNotFoundError:
        return None
    return done.stdout.splitlines() if done.returncode == 0 else None


@functools.cache
def changed():
    """The files that differ from what a remote has, without remotes from the commit before; None: all are to be checked."""
    if os.environ.get("FVV_STYLE") != "changed":
        return None
    unpublished = git("rev-list", "HEAD", "--not", "--remotes") or ["HEAD"]
    base = unpublished[-1] + "~1" if git("branch", "--remotes") else "HEAD~1"
    differ = git("diff", "--name-only", "--relative", base)
    new = git("ls-files", "--others", "--exclude-standard")
    return None if differ is None or new is None else {ROOT / name for name in differ + new}


def to_check(paths):
    return [p for p in paths if changed() is None or p in changed()]


def sources(*suffixes):
    found = [p for folder in FOLDERS for p in sorted((ROOT / folder).rglob("*")) if p.suffix in suffixes]
    assert found, f"no files with {suffixes}"
    return [p for p in found if p.name not in GENERATED]


def run(*command):
    done = subprocess.run([str(c) for c in command], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_clang_format():
    paths = to_check(sources(".c", ".h", ".cpp"))
    if paths:
        run(BIN / "clang-format", "--dry-run", "--Werror", *paths)


def test_ruff():
    run(BIN / "ruff", "check", *PYTHON)
    run(BIN / "ruff", "format", "--check", *PYTHON)


def test_prettier():
    prettier = ROOT / "js/node_modules/.bin/prettier"
    if not prettier.exists():
        pytest.skip("no js/node_modules: run npm ci in js")
    paths = to_check(sources(".js", ".mjs", ".ts", ".css", ".html"))
    if paths:
        run(prettier, "--config", "js/package.json", "--check", *paths)


def test_declarations_of_js_packages():
    js = ROOT / "js"
    tsc = js / "node_modules/.bin/tsc"
    if not tsc.exists() or not (js / "decoder/dist/index.d.ts").exists():
        pytest.skip("no tsc or no js/decoder/dist: run npm ci in js and build the decoder")
    if not to_check(sources(".js", ".ts")):
        return
    strict = ["--noEmit", "--strict", "--target", "es2022", "--lib", "es2023,dom,dom.iterable"]
    resolved = ["--module", "nodenext", "--moduleResolution", "nodenext"]
    declared = sorted(p for package in js.glob("[!n]*/src") for p in package.rglob("*.d.ts"))
    assert len(declared) > 5
    # The sources' own, too: those in dist may be older.
    run(tsc, *strict, *resolved, *declared, js / "testing/types/consumer.ts")


def written_sources():
    """Sources that people write and read, with paths relative to the root."""
    suffixes = {".c", ".h", ".cpp", ".js", ".mjs", ".py"}
    skipped = {"dist", "node_modules", "__pycache__"}
    found = []
    for folder in ["libfvv", "bindings", "tools", "js", "tests", "conformance", "bench"]:
        for directory, folders, names in os.walk(ROOT / folder):
            folders[:] = sorted(set(folders) - skipped)
            paths = [pathlib.Path(directory, name).relative_to(ROOT) for name in sorted(names)]
            found += [p for p in paths if p.suffix in suffixes and p.name not in GENERATED]
    assert len(found) > 100
    return found


def test_folders_hold_few_files():
    counts = collections.Counter(p.parent.as_posix() for p in written_sources())
    large = {folder: n for folder, n in counts.items() if n > MOST_FILES}
    assert large.keys() == LARGE_FOLDERS.keys(), f"more than {MOST_FILES} files: {large}"


def test_files_are_short_enough():
    counts = {p.as_posix(): len((ROOT / p).read_text().splitlines()) for p in written_sources()}
    long = {path: n for path, n in counts.items() if n > MOST_LINES}
    assert long.keys() == LONG_FILES.keys(), f"more than {MOST_LINES} lines: {long}"


def test_lower_layers_never_include_higher_ones():
    below = {
        "base": [],
        "container": ["base"],
        "mesh": ["base"],
        "calibration": ["base"],
        "visibility": ["base", "mesh"],
        "video": ["base"],
        "environment": ["base", "mesh", "video"],
        "stream": ["base", "container", "mesh", "calibration", "visibility", "video", "environment"],
    }
    for layer, allowed in below.items():
        for path in (ROOT / "libfvv/src" / layer).iterdir():
            for line in path.read_text().splitlines() if path.suffix in {".c", ".h", ".cpp"} else []:
                if line.startswith('#include "') and not line.startswith('#include "fvv/'):
                    folder = line.split('"')[1].split("/")[0]
                    assert folder in [layer, *allowed], f"{path.name} in {layer} includes {line}"


def test_names_of_test_cases_have_no_semicolon():
    # CMake splits such a name in two, and ctest runs neither half but passes both.
    bad = [
        p.name
        for p in sources(".cpp")
        if any(";" in n for n in re.findall(r'TEST_CASE\("([^"]*)"', p.read_text()))
    ]
    assert not bad


# Texts, messages and comments are plain technical English: phrases that engineers stumble over do not come back.

# Globs. Add a folder when all its files pass.
PLACES = [
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "README.md",
    "SECURITY.md",
    "bench/*.[chjmp]*",
    "bench/charts/*.py",
    "bindings/**/*.[ch]*",
    "bindings/**/*.md",
    "bindings/**/*.py*",
    "conformance/**/*.md",
    "conformance/**/*.py",
    "docs/**/*.md",
    "js/*/README.md",
    "js/*/conformance/*.md",
    "js/site/descriptions.json",
    "js/[!n]*/**/*.[ch]",
    "js/[!n]*/**/*.html",
    "js/[!n]*/**/*.js",
    "js/[!n]*/**/*.mjs",
    "js/[!n]*/**/*.ts",
    "js/docs/pages/*.md",
    "js/docs/references/*.py",
    "libfvv/**/*.[ch]",
    "libfvv/**/*.cpp",
    "tests/**/*.[ch]",
    "tests/**/*.cpp",
    "tests/**/*.py",
    "tools/**/*.[ch]*",
    "spec/*.json",
    "spec/*.md",
    "spec/*.py",
]
PHRASES = [
    r"nobody",
    r"so many",
    r"(?:is|are|was|were|be|been) told(?! apart)",
    r"answers? (?:NULL|nothing|with NULL|whether|how|which|where|false|true|the)",
    r"stands? (?:in|on|where|there|beside|behind)",
    r"speaks? of",
    r"own affair",
    r"(?:its|their|no) business",
    r"lets? go",
    r"who(?:so)?ever",
    r"whatever it is",
    r"averse",
    r"without a word",
    r"as it stands",
    r"breadths? of",
    r"untold",
    r"(?:is|are|was|were|be|been|that|when|one|those|size|lattice point) asked for",
    r"held against",
    r"hand(?:s|ed) (?:in|out)",
    r"(?:has|have) (?:the|no) say",
    r"knows nothing",
    r"for ever",
    r"anew",
    r"what is odd",
    r"hang together",
    r"behind the (?:last|first|header|end|configuration|frame header)",
]
PATTERN = re.compile(r"\b(?:" + "|".join(PHRASES) + r")\b", re.IGNORECASE)


def one_line(text):
    """The text without line ends, so that a phrase is found across lines of comments, quotes and string literals."""
    text = re.sub(r'"[ \t]*\n\s*"', "", text)
    return re.sub(r"\s*\n\s*(?://+|\*|>|#)?\s*", " ", text)


@pytest.mark.parametrize("place", PLACES)
def test_plain_english(place):
    paths = [
        p for p in sorted(ROOT.glob(place)) if not {"node_modules", "dist", "__pycache__"} & set(p.parts)
    ]
    paths = [p for p in paths if p.name != "test_style.py"]
    assert paths, f"no files match {place}"
    found = []
    for path in to_check(paths):
        text = one_line(path.read_text())
        if path.suffix == ".md":
            text = re.sub(r"`[^`]*`", "``", text)  # names of code, as in the table of words
        for match in PATTERN.finditer(text):
            around = text[max(0, match.start() - 40) : match.end() + 40]
            found.append(f"{path.relative_to(ROOT)}: ...{around}...")
    assert not found, "\n".join(found)


SUBJECT = re.compile(r"[\w.*+/-]+(, [\w.*+/-]+)*: \S.*")
LONGEST_SUBJECT = 72


def test_subjects_of_commits():
    """`area: ...` of at most 72 characters, since the last tag. The imperative is for readers to judge."""
    tag = git("describe", "--tags", "--abbrev=0")
    if not tag:
        reason = "no git, or no tag before this commit (a shallow clone has none)"
        print(f"skipped: subjects of commits: {reason}")
        pytest.skip(reason)
    subjects = git("log", "--no-merges", "--format=%s", f"{tag[0]}..HEAD")
    wrong = [s for s in subjects if len(s) > LONGEST_SUBJECT or not SUBJECT.fullmatch(s)]
    assert not wrong, "\n".join(wrong)


LITERAL = re.compile(r'"(?:[^"\\\n]|\\.)*"')


def test_libraries_know_no_dashes():
    """Libraries name options by option_name(): each front end spells them in its own words."""
    found = []
    for path in sorted((ROOT / "libfvv").rglob("*.[ch]*")):
        for number, line in enumerate(path.read_text().split("\n"), 1):
            if line.lstrip().startswith(("//", "#include")):
                continue
            for literal in LITERAL.findall(line):
                if re.search(r"--[a-z]", literal):
                    found.append(f"{path.relative_to(ROOT)}:{number}: {literal}")
    assert not found, "\n".join(found)
