"""The zip that Blender installs, as far as it needs no Blender: test_blender.py installs it."""

import ast
import re
import subprocess
import sys
import zipfile

import pytest
from conftest import ROOT

FOLDER = ROOT / "bindings/blender"
WHEEL = "fvv-1.2.3-cp311-cp311-manylinux_2_35_x86_64.whl"


@pytest.fixture
def extension(tmp_path):
    (tmp_path / WHEEL).write_bytes(b"PK a wheel")
    done = subprocess.run(
        [sys.executable, FOLDER / "build.py", tmp_path / WHEEL, "-o", tmp_path / "out"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(done.stdout.strip()) as content:
        assert content.filename.endswith("free_viewpoint_video-1.2.3-linux-x64.zip")
        yield content


def modules(source):
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (one.name.partition(".")[0] for one in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.partition(".")[0]


def test_the_zip_has_what_blender_asks_for(extension):
    tomllib = pytest.importorskip("tomllib", reason="Python before 3.11 has no tomllib")
    manifest = tomllib.loads(extension.read("blender_manifest.toml").decode())
    assert extension.read(f"wheels/{WHEEL}") == b"PK a wheel"
    assert extension.read("LICENSE") == (ROOT / "LICENSE").read_bytes()
    assert manifest["schema_version"] == "1.0.0" and manifest["blender_version_min"] == "4.2.0"
    assert (manifest["version"], manifest["type"]) == ("1.2.3", "add-on")
    assert manifest["wheels"] == [f"./wheels/{WHEEL}"] and manifest["platforms"] == ["linux-x64"]
    # Blender's rules for what it shows of an extension before it is installed.
    shown = [manifest["tagline"], *manifest["permissions"].values()]
    assert all(len(text) <= 64 and not re.search(r"[.!?]$", text) for text in shown)
    # Whatever is not stated here Blender's users do not expect of it.
    assert manifest["permissions"].keys() == {"files", "network"}


def test_the_sources_are_all_there(extension):
    listed = {name for name in extension.namelist() if name.endswith(".py")}
    assert listed == {path.name for path in FOLDER.glob("*.py")} - {"build.py"}
    for name in listed:
        used = set(modules(extension.read(name).decode()))
        assert used <= {"bpy", "bpy_extras", "fvv", "os"}, f"{name}: {used}"


@pytest.mark.parametrize("name", ["fvv-1.2.3-py3-none-any.whl", "fvv-1.2.3.tar.gz", WHEEL])
def test_other_files_are_refused(tmp_path, name):
    if name != WHEEL:
        (tmp_path / name).write_bytes(b"PK")
    done = subprocess.run(
        [sys.executable, FOLDER / "build.py", tmp_path / name, "-o", tmp_path / "out"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 1 and name in done.stderr and not (tmp_path / "out").exists()
