"""Texts, messages and comments are plain technical English: phrases that engineers stumble over do not come back."""

import re

import pytest
from conftest import ROOT

# Globs. Add a folder when all its files pass.
PLACES = [
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "README.md",
    "SECURITY.md",
    "bench/*.[chjmp]*",
    "conformance/**/*.md",
    "conformance/**/*.py",
    "docs/*.md",
    "js/*/README.md",
    "js/*/conformance/*.md",
    "js/site/descriptions.json",
    "js/[!n]*/**/*.[ch]",
    "js/[!n]*/**/*.html",
    "js/[!n]*/**/*.js",
    "js/[!n]*/**/*.mjs",
    "js/[!n]*/**/*.ts",
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
    paths = [p for p in sorted(ROOT.glob(place)) if not {"node_modules", "dist"} & set(p.parts)]
    paths = [p for p in paths if p.name != "test_english.py"]
    assert paths, f"no files match {place}"
    found = []
    for path in paths:
        text = one_line(path.read_text())
        for match in PATTERN.finditer(text):
            around = text[max(0, match.start() - 40) : match.end() + 40]
            found.append(f"{path.relative_to(ROOT)}: ...{around}...")
    assert not found, "\n".join(found)
