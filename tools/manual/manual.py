#!/usr/bin/env python3
"""Manual pages, and completions for bash, zsh and fish, of what programs report with --help-json.

manual.py --date YYYY-MM-DD OUT PROGRAM... writes OUT/share with the folders in which systems look for them.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys

import shells


def roff(text):
    """Text as it is, for man(7): nothing in it is a request."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return re.sub(r"^([.'])", r"\\&\1", text)


def bold(text):
    return f"\\fB{roff(text)}\\fR"


def italic(text):
    return f"\\fI{roff(text)}\\fR"


def limits(option):
    """What is said of a value after its text."""
    out = []
    if option.get("range"):
        low, high = option["range"].strip("[]").split("..")
        out.append(f"From {low} to {high}.")
    if option.get("default"):
        out.append(f"Default: {option['default']}.")
    if option.get("needs"):
        out.append(f"With {' and '.join(option['needs'])} only.")
    if option.get("excludes"):
        out.append(f"Not with {' or '.join(option['excludes'])}.")
    if option.get("required"):
        out.append("Required.")
    return " ".join([option["text"].rstrip(".") + ".", *out])


def entry(head, option):
    return [".TP", head, roff(limits(option))]


def page(tool, others, date):
    """The manual page of a tool, as the lines of a man(7) source."""
    name, summary = tool["tool"], tool["summary"].rstrip(".")
    lines = [
        f'.TH {name.upper()} 1 {date} "fvv {tool["version"]}" "User Commands"',
        ".SH NAME",
        f"{name} \\- {roff(summary[0].lower() + summary[1:])}",
        ".SH SYNOPSIS",
        bold(name) + roff(tool["usage"].removeprefix(name)),
        ".SH DESCRIPTION",
        roff(summary + "."),
    ]
    if tool["notes"]:
        lines += [".PP", roff(tool["notes"])]
    for positional in tool["positionals"]:
        lines += entry(italic(positional["name"]), {**positional, "required": False})
    lines.append(".SH OPTIONS")
    for group in tool["groups"]:
        if len(tool["groups"]) > 1:
            lines.append(f'.SS "{roff(group["title"])}"')
        for option in group["options"]:
            value = f" {italic(option['value'])}" if option["value"] else ""
            lines += entry(", ".join(map(bold, option["names"])) + value, option)
    lines += [".SH EXIT STATUS"]
    for code in tool["exit_codes"]:
        lines += [".TP", bold(str(code["code"])), roff(code["text"] + ".")]
    lines += [".SH EXAMPLES", ".nf", *map(roff, tool["examples"]), ".fi", ".SH SEE ALSO"]
    lines.append(", ".join(f"{bold(other)}(1)" for other in others if other != name))
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--date", required=True, help="of the pages: when the version was released")
    parser.add_argument("out", type=pathlib.Path, help="folder to write share into")
    parser.add_argument("programs", nargs="+")
    arguments = parser.parse_args()
    tools = []
    for program in arguments.programs:
        done = subprocess.run([program, "--help-json"], capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"manual.py: {program} --help-json: exit code {done.returncode}: {done.stderr.strip()}")
        tools.append(json.loads(done.stdout))
    names = sorted(tool["tool"] for tool in tools)
    share = arguments.out / "share"
    for tool in tools:
        name = tool["tool"]
        for path, text in {
            f"man/man1/{name}.1": page(tool, names, arguments.date),
            f"bash-completion/completions/{name}": shells.bash(tool),
            f"zsh/site-functions/_{name}": shells.zsh(tool),
            f"fish/vendor_completions.d/{name}.fish": shells.fish(tool),
        }.items():
            (share / path).parent.mkdir(parents=True, exist_ok=True)
            (share / path).write_text(text)


if __name__ == "__main__":
    main()
