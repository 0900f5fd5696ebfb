"""fvv-conformance is installed alone, with its cases and render vectors."""

import pathlib
import shutil
import subprocess
import sys
import venv

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def test_package_has_runner_and_cases(tmp_path):
    # A copy: the build writes next to its sources.
    source = tmp_path / "source"
    shutil.copytree(
        ROOT / "conformance", source, ignore=shutil.ignore_patterns("__pycache__", "node_modules")
    )
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([*pip, "-w", tmp_path, source], check=True)
    (wheel,) = tmp_path.glob("fvv_conformance-*-py3-none-any.whl")
    venv.create(tmp_path / "venv", with_pip=True)
    python = tmp_path / "venv/bin/python"
    subprocess.run([python, "-m", "pip", "install", "--quiet", "--no-index", wheel], check=True)
    program = tmp_path / "venv/bin/fvv-conformance"
    version = subprocess.run([program, "--version"], check=True, capture_output=True, text=True, cwd=tmp_path)
    assert "format 0.2" in version.stdout
    listed = subprocess.run(
        [program, "list"], check=True, capture_output=True, text=True, cwd=tmp_path
    ).stdout
    assert len(listed.splitlines()) == len(list((ROOT / "conformance/cases").glob("*/*/expected.json")))
    code = "from fvv_conformance import rendering as r; print(len(list(r.default_folder().glob('*/picture.png'))))"
    vectors = subprocess.run([python, "-c", code], check=True, capture_output=True, text=True, cwd=tmp_path)
    assert int(vectors.stdout) == len(list((ROOT / "conformance/render/vectors").iterdir()))
