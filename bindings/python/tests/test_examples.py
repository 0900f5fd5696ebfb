"""The scripts in examples/ run, and do what they say."""

import re
import subprocess
import sys

from conftest import ROOT
from PIL import Image

EXAMPLES = ROOT / "bindings/python/examples"


def example(name, *arguments):
    """Runs a script as its first lines say and returns what it prints."""
    path = EXAMPLES / f"{name}.py"
    usage = re.search(rf"^usage: python {name}\.py (.+)$", path.read_text(), re.M)
    assert usage and len(re.sub(r"\[.*?\]", "", usage[1]).split()) <= len(arguments)
    program = [sys.executable, path, *map(str, arguments)]
    done = subprocess.run(program, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_read_and_plot(players, tmp_path):
    printed = example("read_and_plot", players, tmp_path / "chart.png")
    assert printed.startswith("12 frames, 17578 vertices")
    assert Image.open(tmp_path / "chart.png").size == (1440, 420)
