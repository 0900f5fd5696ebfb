"""The samples of README.md run, in order."""

import re
import shutil

import pytest
from conftest import ROOT

SAMPLES = re.findall(r"```python\n(.*?)```", (ROOT / "bindings/python/README.md").read_text(), re.S)


def test_there_are_samples():
    assert len(SAMPLES) == 12


@pytest.mark.parametrize("number", range(len(SAMPLES)))
def test_sample(players, tmp_path, monkeypatch, number):
    shutil.copy(players, tmp_path / "players.fvv")
    (tmp_path / "capture").symlink_to(players.parent / "capture")
    monkeypatch.chdir(tmp_path)
    exec(compile("import fvv\n" + SAMPLES[number], f"sample {number}", "exec"), {})
