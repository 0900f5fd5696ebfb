"""The requested quality applies to the whole stream, however its groups are cut."""

import pytest
from conftest import figures, run


@pytest.mark.parametrize("codec", ["av1", "vp9"])
def test_a_short_last_group_does_not_decide(codec, tmp_path):
    """A group of one frame is coded better than others are: judged by it, AV1 had 37.1 dB."""
    run(
        "fvvsynth",
        "--rig",
        "small",
        "--cameras",
        3,
        "--size",
        "160x96",
        "--frames",
        11,
        "-o",
        tmp_path / "s",
    )
    stream = ("-o", tmp_path / "o.fvv", "--quality", "42dB", "--group", 10, "--verify", "--no-meshes")
    found = figures("fvvmux", tmp_path / "s", *stream, "--codec", codec)
    assert found["verified"]["psnr"] > 41.5
