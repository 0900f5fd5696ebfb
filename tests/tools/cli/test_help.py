"""Help, version, and options that do not exist, of every tool."""

import json
import os
import pathlib
import re
import subprocess

import pytest

TOOLS = pathlib.Path(os.environ["FVV_TOOLS_DIR"]).resolve()
NAMES = sorted(p.name for p in TOOLS.iterdir() if os.access(p / p.name, os.X_OK) and (p / p.name).is_file())


def called(name, *arguments):
    return subprocess.run([TOOLS / name / name, *arguments], capture_output=True, text=True, timeout=60)


def test_all_tools_are_here():
    assert {"fvvmux", "fvvinfo", "fvvdemux", "fvvrender", "fvvserve", "fvvimport"} <= set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_help_fits_a_screen(name):
    done = called(name, "--help")
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert 5 < len(lines) <= 60
    assert max(map(len, lines)) <= 100
    assert lines[1].startswith(f"Usage: {name} ")


@pytest.mark.parametrize("name", NAMES)
def test_every_tool_has_a_version(name):
    done = called(name, "--version")
    assert done.returncode == 0
    assert re.fullmatch(rf"{name} \d+\.\d+\.\d+\n", done.stdout)


@pytest.mark.parametrize("name", NAMES)
def test_a_misspelt_option_is_an_error_with_the_near_name(name):
    done = called(name, "--versoin")
    assert done.returncode == 2
    assert "Did you mean --version for --versoin?" in done.stderr


@pytest.mark.parametrize("name", NAMES)
def test_help_as_json_has_what_the_help_has(name):
    done = called(name, "--help-json")
    assert (done.returncode, done.stderr) == (0, "")
    found = json.loads(done.stdout)
    assert (found["fvv_help"], found["tool"]) == (1, name)
    assert called(name, "--version").stdout == f"{name} {found['version']}\n"
    options = [option for group in found["groups"] for option in group["options"]]
    names = {n for option in options for n in option["names"]}
    text = called(name, "--help-all" if "--help-all" in names else "--help").stdout
    # "  -o, --output FOLDER": all names of an option at the beginning of its line.
    heads = re.findall(r"^  (-[^\s,]+(?:, -[^\s,]+)*)", text, re.M)
    assert names == {name for head in heads for name in head.split(", ")}
    assert all(option["text"] for option in options + found["positionals"])
    assert all(example.split()[0] == name for example in found["examples"]) and found["examples"]
    assert {0, 1, 2} <= {code["code"] for code in found["exit_codes"]}
    assert "Exit code" not in found["notes"] + found["exit_codes"][-1]["text"]


def test_help_as_json_says_what_a_value_may_be():
    groups = json.loads(called("fvvdemux", "--help-json").stdout)["groups"]
    options = {name: option for group in groups for option in group["options"] for name in option["names"]}
    assert options["--meshes"]["choices"][0] == "ply"
    assert options["--meshes"]["names"] == ["--meshes", "--format"]
    assert (options["--output"]["takes"], options["--output"]["required"]) == ("folder", True)
    assert options["--quality"]["range"] == "[1..100]"
    assert options["--json"]["value"] is None
    codec = json.loads(called("fvvmux", "--help-json").stdout)
    assert codec["positionals"][0]["extensions"] == ["json", "fvv"]
    titles = [group["title"] for group in codec["groups"]]
    assert titles[0] == "Files" and "Meshes" in titles


def test_no_name_is_made_up_for_what_is_like_nothing():
    done = called("fvvmux", "capture", "-o", "x.fvv", "--zzyzx-qqq", "3")
    assert done.returncode == 2
    assert "Did you mean" not in done.stderr


def test_short_help_of_fvvmux_is_a_part_of_all_help():
    short, everything = (called("fvvmux", option).stdout for option in ("--help", "--help-all"))
    found = set(re.findall(r"--[a-z][a-z-]+", short.split("Examples:")[0]))
    known = set(re.findall(r"--[a-z][a-z-]+", everything))
    assert len(found) > 25
    assert found <= known
    assert len(known) > 60
    assert max(map(len, everything.splitlines())) <= 100
    assert "fvvmux players -o players.fvv" in short


@pytest.mark.parametrize("name", NAMES)
def test_help_says_what_something_is_the_same_as(name):
    found = json.loads(called(name, "--help-json").stdout)
    options = [option for group in found["groups"] for option in group["options"]]
    for option in options + found["positionals"]:
        text = option["text"].lower()
        # An option is read alone: there is nothing before it that it could be the same as.
        assert not re.match(r"the same\b|in the same way|likewise\b", text), option
        assert "in the same way" not in text, option
        assert all(named.startswith("--") for named in re.findall(r"the same as (\S+)", text)), option


def test_former_names_of_options_warn_and_are_not_in_the_help(tmp_path):
    for name, former, now in [
        ("fvvmux", "--background", "--tile-fill"),
        ("fvvmux", "--no-background", "--no-environment"),
        ("fvvmux", "--no-audio", "--no-sound"),
        ("fvvdemux", "--no-background", "--no-environment"),
        ("fvvdemux", "--no-audio", "--no-sound"),
    ]:
        help_all = called(name, "--help-all" if name == "fvvmux" else "--help").stdout
        assert f"{now}" in help_all and not re.search(rf"{former}\b", help_all)
        value = [] if former.startswith("--no-") else ["flat"]
        done = called(name, tmp_path / "none", "-o", tmp_path / "out", former, *value)
        assert f"{name}: warning: {former}: is called {now} now" in done.stderr
        both = called(name, tmp_path / "none", "-o", tmp_path / "out", former, *value, now, *value)
        assert both.returncode == 2 and former in both.stderr
