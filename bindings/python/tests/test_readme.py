"""The Python samples of the READMEs of the package and of the project, and of the guide, run."""

import re
import shutil

import pytest
from conftest import ROOT

PAGES = ["bindings/python/README.md", "README.md", "docs/guide/python.md"]
SAMPLES = [s for page in PAGES for s in re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.S)]


def test_there_are_samples():
    assert len(SAMPLES) >= 10


@pytest.mark.parametrize("number", range(len(SAMPLES)))
def test_sample(players, tmp_path, monkeypatch, number):
    shutil.copy(players, tmp_path / "players.fvv")
    (tmp_path / "capture").symlink_to(players.parent / "capture")
    monkeypatch.chdir(tmp_path)
    exec(compile("import fvv\n" + SAMPLES[number], f"sample {number}", "exec"), {})
