"""Manual pages and completions: of all tools, clean, and used by real shells."""

import json
import os
import pathlib
import re
import shutil
import subprocess

import pytest

TOOLS = pathlib.Path(os.environ["FVV_TOOLS_DIR"]).resolve()
SHARE = TOOLS / "manual/share"
NAMES = [
    "fvvcompare",
    "fvvdemux",
    "fvvimport",
    "fvvinfo",
    "fvvmux",
    "fvvrecover",
    "fvvrender",
    "fvvserve",
    "fvvsynth",
]

pytestmark = pytest.mark.skipif(not SHARE.exists(), reason="this build has no manual pages (sanitizers)")


def need(program):
    return pytest.mark.skipif(not shutil.which(program), reason=f"needs {program}")


def options_of(name):
    done = subprocess.run([TOOLS / name / name, "--help-json"], capture_output=True, text=True, check=True)
    return [n for group in json.loads(done.stdout)["groups"] for o in group["options"] for n in o["names"]]


@need("mandoc")
@pytest.mark.parametrize("name", NAMES)
def test_manual_page_is_clean_and_has_all_options(name):
    page = SHARE / f"man/man1/{name}.1"
    lint = subprocess.run(["mandoc", "-Tlint", "-Wwarning", page], capture_output=True, text=True)
    assert (lint.returncode, lint.stdout, lint.stderr) == (0, "", "")
    text = subprocess.run(["mandoc", "-Tascii", page], capture_output=True, text=True).stdout
    text = "".join(c for i, c in enumerate(text) if c != "\b" and text[i + 1 : i + 2] != "\b")
    for part in ("NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXIT STATUS", "EXAMPLES", "SEE ALSO"):
        assert f"\n{part}\n" in text
    for option in options_of(name):
        assert option in text


def completed(name, *words, folder=None):
    """What bash offers after these words, the last of which is unfinished."""
    script = (
        f'source "{SHARE}/bash-completion/completions/{name}"\n'
        'COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))\n'
        f"_{name}\n"
        'printf "%s\\n" "${COMPREPLY[@]}"\n'
    )
    done = subprocess.run(
        ["bash", "--norc", "-c", script, "bash", name, *words], capture_output=True, text=True, cwd=folder
    )
    assert (done.returncode, done.stderr) == (0, "")
    return sorted(done.stdout.split())


@pytest.mark.parametrize("name", NAMES)
def test_bash_completes_all_options(name):
    assert set(completed(name, "--")) == {n for n in options_of(name) if n.startswith("--")}


def test_bash_completes_choices_and_files(tmp_path):
    for file in ("a.fvv", "b.txt", "capture.json"):
        (tmp_path / file).touch()
    (tmp_path / "folder").mkdir()
    assert completed("fvvmux", "--codec", "h") == ["h264", "hevc"]
    assert completed("fvvmux", "--codec", "=", "av") == ["av1"]
    assert completed("fvvmux", "", folder=tmp_path) == ["a.fvv", "capture.json", "folder"]
    assert completed("fvvinfo", "--check", "", folder=tmp_path) == ["a.fvv", "folder"]
    assert completed("fvvdemux", "a.fvv", "-o", "", folder=tmp_path) == ["folder"]
    assert "colmap" in completed("fvvimport", "", folder=tmp_path)
    assert completed("fvvimport", "colmap", "", folder=tmp_path) == [
        "a.fvv",
        "b.txt",
        "capture.json",
        "folder",
    ]
    assert completed("fvvmux", "--threads", "") == []


@need("zsh")
@pytest.mark.parametrize("name", NAMES)
def test_zsh_loads_the_completion(name):
    # _arguments reads its own specifications only in the line editor: here each is compared with its grammar.
    script = (
        "emulate -L zsh; zmodload zsh/zutil\n"
        "_arguments() { shift 2; for s; do [[ $s == (\\**|\\(*\\)*|:*) ]] || print -r -- $s; done; print $# }\n"
        f'source "{SHARE}/zsh/site-functions/_{name}"\n'
    )
    done = subprocess.run(["zsh", "-f", "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert len(done.stdout.split()) == 1 and int(done.stdout) >= len(options_of(name))


@need("zsh")
@pytest.mark.parametrize("name, expected", [("fvvinfo", {"a.fvv"}), ("fvvmux", {"a.fvv", "capture.json"})])
def test_zsh_finds_files_by_extension(tmp_path, name, expected):
    for file in ("a.fvv", "b.txt", "capture.json"):
        (tmp_path / file).touch()
    last = (SHARE / f"zsh/site-functions/_{name}").read_text().splitlines()[-1]
    (pattern,) = re.findall('-g "(.*)"', last)
    done = subprocess.run(
        ["zsh", "-f", "-c", f"print -l {pattern}"], cwd=tmp_path, capture_output=True, text=True
    )
    assert set(done.stdout.split()) == expected


@need("fish")
@pytest.mark.parametrize("name", NAMES)
def test_fish_completes_all_options(name):
    script = f'source "{SHARE}/fish/vendor_completions.d/{name}.fish"; complete -C "{name} --"'
    done = subprocess.run(["fish", "--no-config", "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert {line.split("\t")[0] for line in done.stdout.splitlines()} == {
        n for n in options_of(name) if n.startswith("--")
    }


@need("fish")
def test_fish_completes_choices():
    script = f'source "{SHARE}/fish/vendor_completions.d/fvvmux.fish"; complete -C "fvvmux --codec h"'
    done = subprocess.run(["fish", "--no-config", "-c", script], capture_output=True, text=True)
    assert [line.split("\t")[0] for line in done.stdout.splitlines()][:2] == ["h264", "hevc"]
