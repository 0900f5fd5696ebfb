"""Help, version and misspelt options of fvvcapture and of its command calibrate, as tests/tools/cli/test_help.py tests the other tools."""

import json
import re
import shutil
import subprocess
import sys

import fvv
import pytest
from conftest import ROOT
from fvv_capture.arguments import calibrate_parser, capture_parser

COMMANDS = pytest.mark.parametrize("name", ["fvvcapture", "fvvcapture calibrate", "fvvcapture live"])


def called(name, *arguments):
    program = [sys.executable, "-m", "fvv_capture", *name.split()[1:], *arguments]
    return subprocess.run(program, capture_output=True, text=True, timeout=60)


@COMMANDS
def test_help_fits_a_screen(name):
    done = called(name, "--help")
    lines = done.stdout.splitlines()
    assert (done.returncode, done.stderr) == (0, "") and 5 < len(lines) <= 60
    assert max(map(len, lines)) <= 100 and lines[1].startswith(f"Usage: {name} ")


@COMMANDS
def test_version(name):
    done = called(name, "--version")
    assert (done.returncode, done.stdout) == (0, f"{name} {fvv.__version__}\n")


@COMMANDS
def test_a_misspelt_option_is_an_error_with_the_near_name(name):
    done = called(name, "--versoin")
    assert (done.returncode, done.stdout) == (
        2,
        "",
    ) and "Did you mean --version for --versoin?" in done.stderr
    done = called(name, "--zzyzx-qqq")
    assert done.returncode == 2 and "--zzyzx-qqq" in done.stderr and "Did you mean" not in done.stderr


@COMMANDS
def test_help_as_json_has_what_the_help_has(name):
    found = json.loads(called(name, "--help-json").stdout)
    assert (found["fvv_help"], found["tool"], found["version"]) == (1, name, fvv.__version__)
    options = [option for group in found["groups"] for option in group["options"]]
    names = {one for option in options for one in option["names"]}
    text = called(name, "--help-all" if "--help-all" in names else "--help").stdout
    assert max(map(len, text.splitlines())) <= 100
    heads = re.findall(r"^  (-[^\s,]+(?:, -[^\s,]+)*)", text, re.M)
    assert names == {one for head in heads for one in head.split(", ")} and len(names) > 20
    assert all(option["text"] for option in options + found["positionals"])
    assert all(example.startswith(f"{name} ") for example in found["examples"]) and found["examples"]
    assert [code["code"] for code in found["exit_codes"]] == [0, 1, 2, 3]


def test_help_as_json_says_what_a_value_may_be():
    groups = json.loads(called("fvvcapture", "--help-json").stdout)["groups"]
    options = {name: option for group in groups for option in group["options"] for name in option["names"]}
    assert (options["--output"]["takes"], options["--output"]["required"]) == ("file", True)
    assert (options["--sheet"]["takes"], options["--sheet"]["extensions"]) == ("file", ["png"])
    assert options["--plate"]["takes"] == "folder" and options["--calibration"]["repeated"]
    assert options["--key"]["choices"] == ["auto", "chroma", "difference", "both"]
    assert options["--min-share"]["default"] == "0.02" and options["--json"]["value"] is None


def test_the_documentation_reads_the_same():
    script = [
        sys.executable,
        "-I",
        "-S",
        ROOT / "js/docs/references/capture_help.py",
        ROOT / "bindings/python/fvv",
    ]
    read = json.loads(subprocess.run(script, capture_output=True, text=True, check=True).stdout)
    for found in read:
        assert found == {**json.loads(called(found["tool"], "--help-json").stdout), "version": ""}
    assert [found["tool"] for found in read] == ["fvvcapture", "fvvcapture calibrate", "fvvcapture live"]


def test_values_may_begin_with_a_minus_sign():
    found = capture_parser("").parse(
        [
            "videos",
            "-o",
            "out",
            "--up",
            "-y",
            "--bounds",
            "-1,0,-1,1,2,1",
            "--floor",
            "-0.1",
            "--offset",
            "left=-3",
        ]
    )
    assert (found.up, found.bounds, found.floor, found.offset) == ("-y", "-1,0,-1,1,2,1", -0.1, ["left=-3"])
    assert calibrate_parser("").parse(["walk", "--up", "-z"]).up == "-z"


@pytest.mark.parametrize(
    "arguments", [["videos", "-o", "--force"], ["videos", "-o", "out", "--up"], ["-o", "out"]]
)
def test_a_value_that_is_missing_is_an_error(arguments, capsys):
    with pytest.raises(SystemExit) as caught:
        capture_parser("").parse(arguments)
    assert caught.value.code == 2 and "Run with --help or --help-all" in capsys.readouterr().err


@pytest.mark.skipif(not shutil.which("mandoc"), reason="needs mandoc")
def test_a_manual_page_and_completions_can_be_made(tmp_path):
    program = tmp_path / "fvvcapture"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m fvv_capture "$@"\n')
    program.chmod(0o755)
    script = [sys.executable, ROOT / "tools/manual/manual.py", "--date", "2026-01-01", tmp_path, program]
    subprocess.run(script, check=True)
    page = tmp_path / "share/man/man1/fvvcapture.1"
    lint = subprocess.run(["mandoc", "-Tlint", "-Wwarning", page], capture_output=True, text=True)
    assert (lint.returncode, lint.stdout) == (0, "")
    complete = f'source "{tmp_path}/share/bash-completion/completions/fvvcapture"; COMP_WORDS=(fvvcapture --key ch); COMP_CWORD=2'
    done = subprocess.run(
        ["bash", "--norc", "-c", f'{complete}; _fvvcapture; echo "${{COMPREPLY[@]}}"'],
        capture_output=True,
        text=True,
    )
    assert (done.stdout, done.stderr) == ("chroma\n", "")
