"""Prints what fvvcapture says of its options, in the shape of the other tools' --help-json: python3 capture_help.py PACKAGE_FOLDER
As in python_api.py the package is not imported: the functions that make its parsers are taken from their sources."""

import argparse
import ast
import json
import os
import pathlib
import sys

CODES = [(0, "done"), (1, "failed"), (2, "usage"), (3, "done, with warnings")]


def value_of(body, name):
    """A constant of a module; of a dictionary its keys."""
    for node in body:
        if isinstance(node, (ast.Assign, ast.AnnAssign)):
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            if ast.unparse(target) != name:
                continue
            if isinstance(node.value, ast.Dict):
                return tuple(ast.literal_eval(key) for key in node.value.keys)
            return ast.literal_eval(node.value)
    raise SystemExit(f"capture_help.py: {name} is no constant")


def function_of(path, name):
    """A function of a module that needs argparse, os, and constants of this module and of its neighbours."""
    body = ast.parse(path.read_text()).body
    found = next(node for node in body if getattr(node, "name", None) == name)
    found.returns = None
    for argument in found.args.args:
        argument.annotation = None
    used = {node.id for node in ast.walk(found) if isinstance(node, ast.Name)}
    known = {"argparse": argparse, "os": os, "__version__": ""}
    for node in body:
        if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module:
            neighbour = ast.parse((path.parent / f"{node.module}.py").read_text()).body
            known |= {
                a.name: value_of(neighbour, a.name) for a in node.names if a.name in used and a.name.isupper()
            }
    known |= {name: value_of(body, name) for name in used if name.isupper() and name not in known}
    exec(compile(ast.Module([found], []), str(path), "exec"), known)
    return known[name]


def described(action):
    out = {} if action.option_strings else {"name": action.metavar or action.dest}
    if action.option_strings:
        takes_value = action.nargs != 0
        shown = action.metavar or ("|".join(action.choices) if action.choices else "TEXT")
        shown = " ".join(shown) if isinstance(shown, tuple) else shown
        out = {"names": action.option_strings, "value": shown if takes_value else None}
    out["text"] = action.help or ""
    if action.choices:
        out["choices"] = list(action.choices)
    # The number of processors is another on every machine.
    preset = action.default
    is_shown = isinstance(preset, (str, int, float)) and preset not in ("", False) and action.dest != "jobs"
    if is_shown and action.nargs != 0 and "default" not in out["text"]:
        out["default"] = str(preset)
    if action.required and action.option_strings:
        out["required"] = True
    if isinstance(action, argparse._AppendAction):
        out["repeated"] = True
    return out


def help_of(parser, examples):
    groups = []
    positionals = []
    for group in parser._action_groups:
        actions = [a for a in group._group_actions if a.option_strings and a.dest not in ("help", "version")]
        positionals += [a for a in group._group_actions if not a.option_strings]
        if actions:
            groups.append({"title": group.title, "options": [described(a) for a in actions]})
    names = [a.metavar or a.dest for a in positionals]
    shown = [f"[{n}]" if a.nargs == "?" else n for a, n in zip(positionals, names)]
    return {
        "tool": parser.prog,
        "summary": parser.description,
        "usage": " ".join([parser.prog, "[OPTIONS]", *shown]),
        "positionals": [described(a) for a in positionals],
        "groups": groups,
        "examples": examples,
        "exit_codes": [{"code": code, "text": text} for code, text in CODES],
        "notes": "A part of the Python package: pip install fvv[capture].",
    }


def main(package):
    folder = pathlib.Path(package) / "capture"
    parser = function_of(folder / "command.py", "parser")()
    lines = [line.strip() for line in parser.epilog.splitlines() if line.startswith("  ")]
    board = argparse.ArgumentParser(
        prog="fvvcapture calibrate", description="Calibrates cameras from a board."
    )
    function_of(folder / "calibrate/command.py", "add_arguments")(board)
    of_board = [line for line in lines if line.startswith(board.prog)]
    print(
        json.dumps(
            [help_of(parser, [line for line in lines if line not in of_board]), help_of(board, of_board)]
        )
    )


if __name__ == "__main__":
    main(sys.argv[1])
