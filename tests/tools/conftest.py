"""Shared by the tests of the command line: where the tools are, how one is run, and files to give them."""

import json
import os
import pathlib
import struct
import subprocess
import sys

import jsonschema
import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SPEC = ROOT / "spec"
CONFORMANCE = ROOT / "conformance"
TINY = CONFORMANCE / "tiny"
# For `from reference import ...`, `from real_capture import ...`, `from shared_capture import ...`.
sys.path[:0] = [str(CONFORMANCE), str(ROOT / "tests/real"), str(ROOT / "tests")]

from shared_capture import eight_frames  # noqa: E402, F401


def pytest_configure(config):
    config.addinivalue_line("markers", "long: compares at length; left out under sanitizers")


def tool_path(name):
    """The tool of the build that FVV_TOOLS_DIR names."""
    folder = os.environ.get("FVV_TOOLS_DIR")
    if not folder:
        raise RuntimeError(
            "set FVV_TOOLS_DIR to the folder 'tools' of a build, for instance build/default/tools"
        )
    path = pathlib.Path(folder).resolve() / name / name
    assert path.is_file(), f"{name} was not built"
    return path


class Tool:
    """A tool to call: returns the finished process, with stdout and stderr as bytes."""

    def __init__(self, name):
        self.path = tool_path(name)

    def __call__(self, *arguments, stdin=b"", cwd=None):
        command = [str(self.path), *map(str, arguments)]
        return subprocess.run(command, input=stdin, capture_output=True, cwd=cwd, timeout=60)


def run(name, *arguments, code=0, warns=False):
    """Runs a tool and returns the finished process, with stdout and stderr as text.

    Its exit code has to be `code`, or one of several. Success is silent on stderr unless a warning is expected.
    """
    command = [str(tool_path(name)), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode in (code if isinstance(code, tuple) else (code,)), done.stderr
    if done.returncode == 0 and not warns:
        assert done.stderr == ""
    return done


# Of fvvsynth.
SMALL_HULLS = "--meshes", "hull", "--hull-cells", 40
# Of fvvmux --realtime. What the machine does besides must not matter: no frame is dropped unless a test is about that.
PATIENT = "--max-delay", "60"


def small_capture(folder, *options, frames, cameras=2, size="64x48"):
    """A capture of fvvsynth that takes no time; returns its folder."""
    small = "--rig", "small", "--cameras", cameras, "--size", size, "--frames", frames
    run("fvvsynth", *small, *options, "-o", folder)
    return folder


def glb_file(document, binary):
    """The bytes of a GLB file; binary: a multiple of 4 bytes."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def figures(name, *arguments, code=0):
    """What a tool prints with --json."""
    return read_json(run(name, *arguments, "--json", code=code), name)


def read_json(done, name):
    """The standard output of a finished tool as JSON, checked against the tool's schema."""
    document = json.loads(done.stdout)
    validate(document, name)
    return document


def schema(name):
    return json.loads((SPEC / f"{name}.schema.json").read_text())


def validate(document, name):
    """Fails unless the document is valid by spec/NAME.schema.json."""
    jsonschema.validate(document, schema(name), cls=jsonschema.Draft202012Validator)


@pytest.fixture(scope="session")
def fvvinfo():
    return Tool("fvvinfo")


@pytest.fixture(scope="session")
def fvvmux():
    return Tool("fvvmux")


@pytest.fixture(scope="session")
def tiny_files():
    """Name to path of the files in conformance/tiny."""
    return {path.name: path for path in sorted(TINY.glob("*.fvv"))}
