"""Completions of a tool for bash, zsh and fish, from what it reports with --help-json."""

import re
import shlex


def options_of(tool):
    return [option for group in tool["groups"] for option in group["options"]]


def brief(text):
    """The first words of a text, for a column beside the names."""
    text = re.split(r"[;:(]|\. |, where |, which ", text)[0].strip()
    if len(text) > 60:
        text = text[:60].rsplit(" ", 1)[0].rstrip(",")
    return text


def bash_value(value):
    """Commands that complete a value, in the function of bash()."""
    if value.get("choices"):
        return f'_fvv_words {shlex.quote(" ".join(value["choices"]))}'
    if value.get("takes") == "folder":
        return "_fvv_files -"
    if value.get("takes") == "file":
        return " ".join(["_fvv_files", *value.get("extensions", [])])
    return ":"


BASH_HEAD = """# bash completion of {name}, generated from its options.

_fvv_words() {{ mapfile -t COMPREPLY < <(compgen -W "$1" -- "$cur"); }}

# Folders, and files with one of these extensions; without any, all files; "-": no files.
_fvv_files() {{
  local extension
  compopt -o filenames 2>/dev/null
  if [[ $# -eq 0 ]]; then
    mapfile -t COMPREPLY < <(compgen -f -- "$cur")
    return
  fi
  mapfile -t COMPREPLY < <(compgen -d -- "$cur"; for extension; do compgen -f -X "!*.$extension" -- "$cur"; done)
}}

_{name}() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} prev=${{COMP_WORDS[COMP_CWORD-1]}} word
  COMPREPLY=()
  # --name=value is three words here.
  if [[ $cur == "=" ]]; then
    cur=
  elif [[ $prev == "=" ]]; then
    prev=${{COMP_WORDS[COMP_CWORD-2]}}
  fi
  case $prev in
"""


def bash(tool):
    name = tool["tool"]
    lines = [BASH_HEAD.format(name=name).rstrip("\n")]
    for option in options_of(tool):
        if option["value"]:
            lines.append(f"    {'|'.join(option['names'])}) {bash_value(option)}; return ;;")
    names = " ".join(n for option in options_of(tool) for n in option["names"])
    lines += ["  esac", "  if [[ $cur == -* ]]; then", f'    _fvv_words "{names}"', "    return", "  fi"]
    for positional in tool["positionals"]:
        if positional.get("choices"):
            # Until one of them is there.
            lines += [
                '  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do',
                f"    case $word in {'|'.join(positional['choices'])}) prev=; break ;; esac",
                "  done",
                f"  if [[ -n $prev ]]; then {bash_value(positional)}; return; fi",
            ]
    values = [p for p in tool["positionals"] if not p.get("choices")]
    lines += [f"  {bash_value(values[-1]) if values else ':'}", "}", f"complete -F _{name} {name}"]
    return "\n".join(lines) + "\n"


def zsh_text(text):
    return re.sub(r"([\[\]:\\])", r"\\\1", text)


def zsh_value(value, name):
    name = zsh_text(name)
    if value.get("choices"):
        return f":{name}:({' '.join(value['choices'])})"
    if value.get("takes") == "folder":
        return f":{name}:_files -/"
    if value.get("takes") == "file":
        extensions = value.get("extensions", [])
        # Not *.(fvv): a last pair of parentheses without a bar has qualifiers in it.
        ends = extensions[0] if len(extensions) == 1 else f"({'|'.join(extensions)})"
        pattern = f' -g "*.{ends}"' if extensions else ""
        return f":{name}:_files{pattern}"
    return f":{name}: "


def zsh(tool):
    specifications = []
    for option in options_of(tool):
        value = zsh_value(option, option["value"]) if option["value"] else ""
        text = f"[{zsh_text(brief(option['text']))}]"
        for name in option["names"]:
            others = f"({' '.join(option['names'])})" if not option.get("repeated") else "*"
            equals = "=" if value and name.startswith("--") else "+" if value else ""
            specifications.append(shlex.quote(f"{others}{name}{equals}{text}{value}"))
    for positional in tool["positionals"]:
        start = "*" if positional.get("repeated") else ""
        specifications.append(shlex.quote(start + zsh_value(positional, positional["name"])))
    joined = " \\\n  ".join(specifications)
    return f"#compdef {tool['tool']}\n# Generated from the options of {tool['tool']}.\n\n_arguments -s -S \\\n  {joined}\n"


def fish_value(value):
    if value.get("choices"):
        return f"-x -a {shlex.quote(' '.join(value['choices']))}"
    if value.get("takes") == "folder":
        return "-x -a '(__fish_complete_directories)'"
    if value.get("takes") == "file":
        suffixes = " ".join(f"(__fish_complete_suffix .{e})" for e in value.get("extensions", []))
        return f"-k -x -a {shlex.quote(suffixes)}" if suffixes else "-r -F"
    return "-x"


def fish_quoted(text):
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"


def fish(tool):
    lines = [f"# Generated from the options of {tool['tool']}."]
    for option in options_of(tool):
        names = " ".join(("-l " + n[2:]) if n.startswith("--") else ("-s " + n[1:]) for n in option["names"])
        value = " " + fish_value(option) if option["value"] else ""
        lines.append(f"complete -c {tool['tool']} {names}{value} -d {fish_quoted(brief(option['text']))}")
    for positional in tool["positionals"]:
        if positional.get("choices"):
            words = " ".join(positional["choices"])
            lines.append(
                f"complete -c {tool['tool']} -n 'not __fish_seen_subcommand_from {words}' {fish_value(positional)}"
            )
        elif positional.get("extensions"):
            lines.append(f"complete -c {tool['tool']} {fish_value(positional)}")
    return "\n".join(lines) + "\n"
