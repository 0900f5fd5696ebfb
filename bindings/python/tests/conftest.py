"""Streams to read: the vectors of conformance, and small generated ones."""

import os
import pathlib
import subprocess
import sys

import hypothesis
import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
CONFORMANCE = ROOT / "conformance"
# For `from reference import ...`, `from real_capture import ...`, `from shared_capture import ...`.
sys.path[:0] = [str(CONFORMANCE), str(ROOT / "tests/real"), str(ROOT / "tests")]

from shared_capture import eight_frames  # noqa: E402, F401
from vectors import names, path_of  # noqa: E402

VECTORS = [path_of(name) for name in names()]

hypothesis.settings.register_profile(
    "suite", max_examples=1000, deadline=None, derandomize=True, database=None
)
hypothesis.settings.register_profile("nightly", max_examples=20000, deadline=None, database=None)
hypothesis.settings.load_profile(os.environ.get("FVV_HYPOTHESIS", "suite"))


def examples(share):
    """A property's share of the profile's examples: more where they are cheap, and fewer where pictures are encoded."""
    return max(1, min(20000, round(share * hypothesis.settings.default.max_examples)))


def tool(name, *arguments, code=0):
    """Runs a tool of the build that FVV_TOOLS_DIR names and returns its standard output."""
    path = pathlib.Path(os.environ["FVV_TOOLS_DIR"]).resolve() / name / name
    done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    assert done.returncode == code, done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def players(tmp_path_factory):
    """12 frames in groups of 5 of a tracked scene: 3 cameras in two sizes, visibility, colours, sound."""
    folder = tmp_path_factory.mktemp("players")
    tool(
        "fvvsynth",
        "-o",
        folder / "capture",
        "--rig",
        "small",
        "--cameras",
        3,
        "--size",
        "160x96",
        "--frames",
        12,
        "--sound",
    )
    tool("fvvmux", folder / "capture/capture.json", "-o", folder / "players.fvv", "--group", 5, "--ladder", "1,0.5",
         "--visibility", "weight", "--colours", "on", "--keep-geometry")  # fmt: skip
    return folder / "players.fvv"


@pytest.fixture(scope="session")
def unpacked(players):
    """What fvvdemux makes of players."""
    folder = players.parent / "unpacked"
    tool("fvvdemux", players, "-o", folder)
    return folder
