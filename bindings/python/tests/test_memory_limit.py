"""max_memory of fvv.mux: a file that takes more is named, with the option as Python writes it."""

import json
import shutil

import fvv
import pytest
from conftest import tool


@pytest.mark.parametrize("kind", ["picture", "video"])
def test_a_file_above_the_memory_limit_is_named_with_the_option_as_python_writes_it(kind, tmp_path, players):
    capture = tmp_path / "capture"
    shutil.copytree(players.parent / "capture", capture)
    if kind == "video":
        film = ["--camera", 0, "--size", "1280x720", "--frames", "0-1", "-o", capture / "film.mp4"]
        tool("fvvrender", players, *film)
        described = json.loads((capture / "capture.json").read_text())
        for camera in described["cameras"]:
            camera.pop("masks", None)
        described["cameras"][0]["pictures"] = {"video": "film.mp4"}
        (capture / "capture.json").write_text(json.dumps(described))
    with pytest.raises(
        fvv.Error, match=r"film\.mp4.* max_memory allows" if kind == "video" else "max_memory allows 9 KiB"
    ):
        fvv.mux(capture, tmp_path / "out.fvv", max_memory="20M" if kind == "video" else "9K")
    assert [p.name for p in tmp_path.iterdir()] == ["capture"]
