"""Command lines in the manner of the tools in C++: help on one screen, all of it as text or as JSON, and near names for options that
do not exist. Needs the standard library alone: the documentation is built from it without the extension module."""

from __future__ import annotations

import argparse
import difflib
import json
import sys
import textwrap
from collections.abc import Callable
from typing import Any, NoReturn

WIDTH, TEXT_COLUMN = 100, 32
EXIT_CODES = ((0, "done"), (1, "failed"), (2, "usage"), (3, "done with warnings"))
#: What completions offer for a value, by its name in the help; FILE.png is a file with that extension.
TAKES = {"FILE": "file", "OUT": "file", "FOLDER": "folder"}


class _Print(argparse.Action):
    """Prints what its function returns, and ends the program."""

    def __init__(self, text: Callable[[], str], **settings: Any) -> None:
        super().__init__(nargs=0, default=argparse.SUPPRESS, **settings)
        self._text = text

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        print(self._text())
        parser.exit()


class Section:
    """Options under one title of the help."""

    def __init__(self, parser: Parser, title: str) -> None:
        self.title = title
        self.options: list[argparse.Action] = []
        self.rare: list[argparse.Action] = []  #: Of the options, those that only --help-all shows.
        self._parser = parser

    def add(self, *names: str, rare: bool = False, **settings: Any) -> None:
        """An option, as `argparse.ArgumentParser.add_argument` takes it."""
        option = self._parser.add_argument(*names, **settings)
        self.options.append(option)
        if rare:
            self.rare.append(option)


class Parser(argparse.ArgumentParser):
    """The options of a tool. summary, notes: sentences; examples: command lines."""

    def __init__(
        self,
        tool: str,
        version: str,
        summary: str,
        examples: list[str],
        notes: list[str],
        has_rare: bool = False,
    ) -> None:
        super().__init__(prog=tool, description=summary, add_help=False, allow_abbrev=False)
        self._version = version
        self._examples = examples
        self._notes = notes
        self._has_rare = has_rare
        self._positionals_shown: list[argparse.Action] = []
        self._sections: list[Section] = []
        self._about = Section(self, "Help")
        own = self._about.add
        own("-h", "--help", action=_Print, text=self.format_help,
            help="the options that people need most" if has_rare else "this text")  # fmt: skip
        if has_rare:
            own("--help-all", action=_Print, text=self._all_help, help="all options")
        own("--version", action=_Print, text=lambda: f"{tool} {version}", help=f"of {tool}")
        self.add_argument("--help-json", action=_Print, text=lambda: json.dumps(self.as_json(), indent=2))

    def positional(self, name: str, **settings: Any) -> None:
        """An argument without a name of its own on the command line."""
        self._positionals_shown.append(self.add_argument(name, **settings))

    def section(self, title: str) -> Section:
        """A new section, after those before."""
        self._sections.append(Section(self, title))
        return self._sections[-1]

    def parse(self, arguments: list[str]) -> argparse.Namespace:
        """Parses a command line. Ends the program (SystemExit) after help, and for arguments that are wrong."""
        options = [option for section in [*self._sections, self._about] for option in section.options]
        by_name = {name: option for option in options for name in option.option_strings}
        by_name["--help-json"] = self._about.options[0]
        joined: list[str] = []
        for i, argument in enumerate(arguments):
            name = argument.partition("=")[0]
            if argument == "--":
                joined += arguments[i:]
                break
            before = by_name.get(joined[-1]) if joined else None
            if name in by_name or not argument.startswith("-"):
                joined.append(argument)
            elif before is not None and before.nargs is None:
                joined[-1] += f"={argument}"  # else argparse takes "-y" of "--up -y" for an option
            elif argument.startswith("--"):
                near = difflib.get_close_matches(name, by_name, 1)
                self.error(
                    f"the following argument was not expected: {name}",
                    f"Did you mean {near[0]} for {name}?" if near else "",
                )
            else:
                joined.append(argument)
        return self.parse_args(joined)

    def error(self, message: str, hint: str = "") -> NoReturn:
        """Ends the program with the exit code of a wrong command line."""
        more = "--help or --help-all" if self._has_rare else "--help"
        print(f"{self.prog}: {message}", f"Run with {more} for more information.", sep="\n", file=sys.stderr)
        self.exit(2, f"{hint}\n" if hint else None)

    def format_help(self) -> str:
        """The help, without the options that are rare."""
        return self._text(not self._has_rare)

    def _all_help(self) -> str:
        return self._text(True)

    def _text(self, with_rare: bool) -> str:
        lines = [*textwrap.wrap(self.description or "", WIDTH), f"Usage: {self._usage_line()}", ""]
        lines += [line for one in self._positionals_shown for line in _row(one)]
        for section in [*self._sections, self._about]:
            shown = [one for one in section.options if with_rare or one not in section.rare]
            lines += ["", f"{section.title}:", *(line for one in shown for line in _row(one))]
        lines += ["", "Examples:", *(f"  {example}" for example in self._examples), ""]
        codes = ", ".join(f"{code} {text}" for code, text in EXIT_CODES)
        lines += textwrap.wrap(" ".join([f"Exit code: {codes}.", *self._notes]), WIDTH)
        return "\n".join(lines)

    def _usage_line(self) -> str:
        names = [f"[{_name(one)}]" if one.nargs == "?" else _name(one) for one in self._positionals_shown]
        return " ".join([self.prog, "[OPTIONS]", *names])

    def as_json(self) -> dict[str, Any]:
        """The document that the tools in C++ print, in the same shape (tools/cli/option_help.h)."""
        return {
            "fvv_help": 1,
            "tool": self.prog,
            "version": self._version,
            "summary": self.description,
            "positionals": [_described(one) for one in self._positionals_shown],
            "usage": self._usage_line(),
            "groups": [
                {"title": section.title, "options": [_described(one) for one in section.options]}
                for section in [*self._sections, self._about]
            ],
            "examples": self._examples,
            "exit_codes": [{"code": code, "text": text} for code, text in EXIT_CODES],
            "notes": " ".join(self._notes),
        }


def _name(option: argparse.Action) -> str:
    """Of a value, or of a positional argument: "FILE"; empty for a flag."""
    if option.nargs == 0:
        return ""
    if option.choices is not None and option.metavar is None:
        return "|".join(option.choices)
    shown = option.metavar or option.dest.upper()
    return shown if isinstance(shown, str) else " ".join(shown)


def _default(option: argparse.Action) -> str:
    """The value without the option, if there is one and the text does not name it; as the tools show it."""
    value = option.default
    is_shown = option.nargs != 0 and isinstance(value, (str, int, float)) and value != ""
    return str(value) if is_shown else ""


def _row(option: argparse.Action) -> list[str]:
    """Lines of the help: names and value, then the text in a column of its own."""
    value = _name(option)
    left = "  " + (f"{', '.join(option.option_strings)} {value}".rstrip() if option.option_strings else value)
    preset = _default(option)
    text = (option.help or "") + (f" ({preset})" if preset else "")
    right = textwrap.wrap(text, WIDTH - TEXT_COLUMN)
    if len(left) + 2 > TEXT_COLUMN:
        return [left, *(" " * TEXT_COLUMN + line for line in right)]
    return [left.ljust(TEXT_COLUMN) + right[0], *(" " * TEXT_COLUMN + line for line in right[1:])]


def _described(option: argparse.Action) -> dict[str, Any]:
    value = _name(option)
    out: dict[str, Any]
    if option.option_strings:
        out = {"names": list(option.option_strings), "value": value or None, "text": option.help}
    else:
        out = {"name": value, "text": option.help}
    preset = _default(option)
    if preset:
        out["default"] = preset
    if option.choices is not None:
        out["choices"] = list(option.choices)
    kind, _, extensions = value.partition(".")
    if kind in TAKES:
        out["takes"] = TAKES[kind]
        if extensions:
            out["extensions"] = extensions.split("|")
    if option.required:
        out["required"] = True
    if option.nargs == "+" or isinstance(option.default, list):
        out["repeated"] = True
    return out
