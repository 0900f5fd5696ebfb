"""The requested quality applies to the whole stream, however its groups are cut."""

import numpy as np
import pytest
from conftest import figures, small_capture
from PIL import Image


@pytest.mark.parametrize("codec", ["av1", "vp9"])
def test_a_short_last_group_does_not_decide(codec, tmp_path):
    """A group of one frame is coded better than others are: judged by it, AV1 had 37.1 dB."""
    small_capture(tmp_path / "s", frames=11, cameras=3, size="160x96")
    stream = ("-o", tmp_path / "o.fvv", "--quality", "42dB", "--group", 10, "--verify", "--no-meshes")
    found = figures("fvvmux", tmp_path / "s", *stream, "--codec", codec)
    assert found["verified"]["psnr"] > 41.5


@pytest.mark.parametrize("group", [1, 2, 3])
@pytest.mark.parametrize("codec", ["h264", "hevc", "av1", "vp9"])
def test_short_groups_do_not_decide_alone(codec, group, tmp_path):
    """In two frames there may be nothing to code: judged by them alone, AV1 had 31.5 dB where 38 was asked."""
    rng = np.random.default_rng(1)
    for i in range(12):
        pixels = np.full((96, 128, 3), 120, np.uint8)  # in the middle of the take
        if i not in (6, 7):
            pixels = np.kron(rng.integers(0, 255, (24, 32, 3)), np.ones((4, 4, 1))).astype(np.uint8)
        Image.fromarray(pixels).save(tmp_path / f"{i}.png")
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n")
    inputs = ("--meshes", tmp_path / "m.obj", "--atlas", tmp_path / "%d.png", "-o", tmp_path / "o.fvv")
    wanted = ("--codec", codec, "--group", group, "--quality", "38dB", "--verify")
    found = figures("fvvmux", *inputs, *wanted)
    assert found["verified"]["atlas"]["psnr"] > 37.9
