"""The scripts in examples/ run, and do what they say."""

import re
import subprocess
import sys

import fvv
import pytest
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


def test_arrays_to_fvv(tmp_path):
    printed = example("arrays_to_fvv", tmp_path / "ball.fvv", 12)
    frames, size, error = re.fullmatch(
        r"(\d+) frames, (\d+) bytes; the ball is off by ([\d.]+) mm at most\n", printed
    ).groups()
    # The surface between vertices is what the budget is about; vertices lie on the lattice.
    assert int(frames) == 12 and 5000 < int(size) < 200_000 and float(error) < 10
    assert fvv.check(tmp_path / "ball.fvv").ok


def test_novel_view(players, tmp_path):
    printed = example("novel_view", players, tmp_path / "views.png")
    assert float(re.search(r"([\d.]+) dB", printed)[1]) > 12
    assert Image.open(tmp_path / "views.png").size == (1440, 360)


def test_rate_against_accuracy(eight_frames, tmp_path):
    printed = example("rate_against_accuracy", eight_frames, tmp_path / "rates.png", 3)
    found = [list(map(float, re.findall(r"[\d.]+(?= M| mm rms)", line))) for line in printed.splitlines()]
    rates, errors = zip(*found)
    # What is more accurate takes more bits.
    assert len(found) == 4 and list(rates) == sorted(rates) and list(errors) == sorted(errors, reverse=True)
    assert (tmp_path / "rates.png").exists()


def test_data_loader(players):
    printed = example("data_loader", players)
    assert printed.splitlines()[-1].startswith("12 samples, the brightest pixel is ")


def test_with_dask(eight_frames, tmp_path):
    pytest.importorskip("dask.distributed", reason="dask is not installed: pip install fvv[dask]")
    printed = example("with_dask", eight_frames, tmp_path / "out.fvv")
    assert printed.startswith("8 frames in 2 tasks") and "the same bytes as a single run: True" in printed
