"""Texturing that a file carries (TEXR): from fvvmux to fvvinfo and fvvrender."""

import numpy as np
import pytest
from conftest import figures, run
from PIL import Image

POSE = ("--pose", "1.5,1.6,3.2,0,1,0", "--size", "240x135")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The same two frames of a generated scene, without texturing constants and with all of them."""
    folder = tmp_path_factory.mktemp("texturing")
    size = ["--cameras", 3, "--frames", 2, "--size", "160x90"]
    run("fvvsynth", "-o", folder / "capture", "--rig", "small", *size)
    out = folder / "plain.fvv", folder / "explicit.fvv"
    options = ["--codec", "jpeg", "--quality", 85, "--max-error", 0.5]
    run("fvvmux", folder / "capture", "-o", out[0], *options)
    explicit = ["--texture-threshold", 0.75, "--texture-best", 1, "--texture-unseen", "255,0,64",
            "--texture-depth-bias", 0, "--texture-depth-slope", 1.25]  # fmt: skip
    run("fvvmux", folder / "capture", "-o", out[1], *options, *explicit)
    return out


def test_fvvinfo_reports_the_constants(files):
    plain, explicit = (figures("fvvinfo", path)["files"][0] for path in files)
    assert "texturing" not in plain
    assert explicit["texturing"] == {
        "threshold": 0.75, "best": 1, "unseen": [255, 0, 64], "depth_bias": 0, "depth_slope": 1.25
    }  # fmt: skip
    assert "weights from 0.75, 1 cameras at most, 255,0,64" in run("fvvinfo", files[1]).stdout


def test_fvvrender_uses_the_constants_of_the_file(files, tmp_path):
    options = "--threshold", 0.75, "--best", 1, "--unseen", "255,0,64", "--visible-by", "rays"
    pictures = []
    for number, arguments in enumerate([(files[0],), (files[0], *options), (files[1], "--visible-by", "rays"),
                                        (files[1], "--unseen", "0,255,0", "--visible-by", "rays")]):  # fmt: skip
        out = tmp_path / f"{number}.png"
        run("fvvrender", *arguments, "--no-environment", *POSE, "-o", out)
        pictures.append(np.asarray(Image.open(out)).astype(int))
    plain, requested, explicit, other = pictures
    assert (requested == explicit).all()
    unseen = (explicit == [255, 0, 64]).all(axis=2)
    assert unseen.sum() > 200
    assert not (plain == [255, 0, 64]).all(axis=2).any()
    assert (other[unseen] == [0, 255, 0]).all()


def test_tolerances_of_depth_maps_reach_the_renderer(files, tmp_path):
    """With a bias that lets everything be seen, cameras colour what they do not see, unless rays decide."""
    capture = files[0].parent / "capture"
    explicit = tmp_path / "explicit.fvv"
    run("fvvmux", capture, "-o", explicit, "--codec", "jpeg", "--quality", 85, "--max-error", 0.5,
         "--texture-depth-bias", 10000)  # fmt: skip
    differing = {}
    for by in "depth", "rays":
        pictures = []
        for number, path in enumerate((files[0], explicit)):
            out = tmp_path / f"{by}{number}.png"
            run("fvvrender", path, "--no-environment", "--visible-by", by, *POSE, "-o", out)
            pictures.append(np.asarray(Image.open(out)).astype(int))
        differing[by] = (np.abs(pictures[0] - pictures[1]).max(axis=2) > 8).sum()
    assert differing["depth"] > 100 and differing["rays"] == 0


@pytest.mark.parametrize("bad", ["1,2", "1,2,256", "red", "1,2,3,4", "-1,2,3"])
def test_a_malformed_colour_is_refused(files, tmp_path, bad):
    capture = files[0].parent / "capture"
    done = run("fvvmux", capture, "-o", tmp_path / "x.fvv", f"--texture-unseen={bad}", code=2)
    assert "--texture-unseen" in done.stderr
