"""The capture that tests share which need nothing particular: 8 frames by 3 cameras of 64x48. ctest makes it once (fixture
eight_frames); a test that is run alone makes it for itself. As a script: shared_capture.py TOOLS FOLDER."""

import os
import pathlib
import shutil
import subprocess
import sys

import pytest

OPTIONS = ["--rig", "small", "--cameras", "3", "--size", "64x48", "--frames", "8"]


def make(tools, folder):
    """The capture's folder, made unless it is younger than the tool that makes it."""
    tool, capture = pathlib.Path(tools).resolve() / "fvvsynth/fvvsynth", pathlib.Path(folder) / "capture"
    description = capture / "capture.json"
    if not description.exists() or description.stat().st_mtime < tool.stat().st_mtime:
        shutil.rmtree(capture, ignore_errors=True)
        subprocess.run([tool, "-o", capture, *OPTIONS], check=True, timeout=120)
    return capture


@pytest.fixture(scope="session")
def eight_frames(tmp_path_factory):
    """Folder of a capture that others read too: tests copy it before they change it."""
    return make(
        os.environ["FVV_TOOLS_DIR"], os.environ.get("FVV_EIGHT_FRAMES") or tmp_path_factory.mktemp("eight")
    )


if __name__ == "__main__":
    make(*sys.argv[1:])
