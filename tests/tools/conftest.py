"""What the tests of the command line share: where the tools are, how one is run, and streams to give them."""

import os
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SPEC = ROOT / "spec"
TINY = ROOT / "conformance" / "tiny"
sys.path.insert(0, str(SPEC))


def pytest_configure(config):
    config.addinivalue_line("markers", "long: compares at length; left out under sanitizers")


def tool_path(name):
    """The tool of the build that FVV_TOOLS_DIR names, or None when it was not built."""
    folder = os.environ.get("FVV_TOOLS_DIR")
    if not folder:
        raise RuntimeError(
            "set FVV_TOOLS_DIR to the folder 'tools' of a build, for instance build/default/tools"
        )
    path = pathlib.Path(folder).resolve() / name / name
    return path if path.is_file() else None


class Tool:
    def __init__(self, path):
        self.path = path

    def __call__(self, *arguments, stdin=b"", cwd=None):
        """Runs the tool; the answer has returncode, stdout and stderr, both as bytes."""
        command = [str(self.path), *map(str, arguments)]
        return subprocess.run(command, input=stdin, capture_output=True, cwd=cwd, timeout=60)


@pytest.fixture(scope="session")
def fvvinfo():
    path = tool_path("fvvinfo")
    assert path, "fvvinfo was not built"
    return Tool(path)


@pytest.fixture(scope="session")
def tiny_files():
    """Name to path of the files in conformance/tiny."""
    return {path.name: path for path in sorted(TINY.glob("*.fvv"))}
