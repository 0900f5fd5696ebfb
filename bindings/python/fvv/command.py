"""The command line: python -m fvv info|plot|show FILE. Exit codes are those of all tools: 0 done, 1 failed, 2 usage, 3 done, and
something is damaged."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from typing import Any

from . import __version__, information
from . import open as open_clip
from .clip import Clip
from .errors import Error, UsageError
from .outputs import output_of

DONE, FAILED, USAGE, LOSS = 0, 1, 2, 3
FORMATS = ("png", "svg", "pdf")


def parser() -> argparse.ArgumentParser:
    """The arguments; each command has `run`, a function of them that returns an exit code."""
    out = argparse.ArgumentParser(prog="fvv", description="Looks at .fvv streams.", allow_abbrev=False)
    out.add_argument("--version", action="version", version=f"fvv {__version__}")
    commands = out.add_subparsers(dest="command", required=True, metavar="COMMAND")

    def add(name: str, run: Any, about: str) -> argparse.ArgumentParser:
        command = commands.add_parser(name, help=about, description=about, allow_abbrev=False)
        command.add_argument("file", metavar="FILE", help="a .fvv stream")
        if name != "show":  # the player chooses
            command.add_argument(
                "--rung", type=int, default=0, metavar="N", help="the quality to read, 0 the best"
            )
        command.set_defaults(run=run)
        return command

    info = add("info", run_info, "Prints what a clip is, on one screen.")
    info.add_argument("--json", action="store_true", help="all of the stream as JSON, as fvvinfo prints it")
    plot = add(
        "plot", run_plot, "Draws bytes, key frames, vertices and faces over time, and the cameras' layout."
    )
    plot.add_argument(
        "-o", "--output", metavar="OUT", help=f"a file ending in .{', .'.join(FORMATS)}; else a window"
    )
    plot.add_argument("-f", "--force", action="store_true", help="replace OUT if it exists")
    plot.add_argument(
        "--against", metavar="REFERENCE", help="draw the distance to the surface of this stream or capture"
    )
    show = add("show", run_show, "Plays a clip in the browser, from this computer.")
    show.add_argument("--port", type=int, default=0, help="to listen at; default: any that is free")
    show.add_argument(
        "--player", metavar="PATH", help="script of js/player/bundle.mjs in place of the package's own"
    )
    show.add_argument("--no-browser", action="store_true", help="only print the address")
    return out


def _code(clip: Clip) -> int:
    return LOSS if clip.problems else DONE


def run_info(given: argparse.Namespace) -> int:
    if given.json:
        if given.rung:
            raise UsageError("--rung: the JSON describes all rungs", file=given.file)
        found = information.document(given.file)
        print(found)
        return DONE if json.loads(found)["files"][0]["integrity"] == "complete" else LOSS
    with open_clip(given.file, rung=given.rung) as clip:
        print(information.text(clip))
        return _code(clip)


def run_plot(given: argparse.Namespace) -> int:
    from .plots import plot, save

    with open_clip(given.file, rung=given.rung) as clip:
        if given.output is None:
            _open_window(clip, given.against)
            return _code(clip)
        kind = os.path.splitext(given.output)[1][1:].lower()
        if kind not in FORMATS:
            raise UsageError(
                f"{given.output}: expected a name ending in .{', .'.join(FORMATS)}", file=given.output
            )
        # Refused before anything is drawn.
        if not given.force and os.path.isfile(given.output):
            raise UsageError(f"{given.output}: already exists; --force replaces it", file=given.output)
        output = output_of(
            given.output, given.force, [given.file, *([given.against] if given.against else [])]
        )
        try:
            output.write(memoryview(save(plot(clip, against=given.against), kind)))
            output.commit()
        finally:
            output.discard()
        return _code(clip)


def _open_window(clip: Clip, against: str | None) -> None:
    from .plots import plot

    try:
        import matplotlib
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("charts need matplotlib: pip install fvv[plot]") from error
    figure = pyplot.figure()
    if figure.canvas.manager is None or matplotlib.get_backend().lower() in (
        "agg",
        "cairo",
        "pdf",
        "ps",
        "svg",
        "template",
    ):
        raise UsageError(f"there is no display to draw on: pass -o NAME.{FORMATS[0]}")
    plot(clip, figure, against=against)
    pyplot.show()


def run_show(given: argparse.Namespace) -> int:
    import webbrowser

    from .player import Server, script_of

    script = script_of(given.player)
    with (
        open_clip(given.file) as clip,
        Server(clip._stream, os.path.basename(clip.name), script, given.port) as server,
    ):
        print(server.url, flush=True)
        if not given.no_browser:
            webbrowser.open(server.url)
        try:
            server.wait()
        except KeyboardInterrupt:
            return DONE
    return DONE


def main(arguments: list[str]) -> int:
    """Runs a command and returns its exit code; errors are one line on standard error."""

    def run() -> int:
        given = parser().parse_args(arguments)
        code: int = given.run(given)
        return code

    return exit_code("fvv", run)


def exit_code(program: str, run: Callable[[], int]) -> int:
    """What run returns; for what it raises an exit code, and one line on standard error that begins with the program's name."""
    try:
        code = run()
        sys.stdout.flush()
        return code
    except SystemExit as exit:  # argparse has written why
        return exit.code if isinstance(exit.code, int) else USAGE
    except BrokenPipeError:
        # Who reads the output has enough; Python would complain once more as it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except (Error, OSError, ImportError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return USAGE if isinstance(error, UsageError) else FAILED
