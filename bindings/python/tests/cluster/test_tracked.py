"""Tracked hulls: frames in memory and groups of other processes become the bytes of fvvmux."""

import concurrent.futures
import multiprocessing

import fvv
import fvv.distributed
import pytest
from conftest import tool
from scenes import read_capture

OPTIONS = {"track": "auto", "codec": "jpeg", "quality": 5, "crop": "none"}


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hulls") / "in"
    size = "--rig", "small", "--cameras", 7, "--size", "240x135", "--hull-cells", 64
    tool("fvvsynth", "-o", folder, *size, "--frames", 4, "--meshes", "hull")
    return folder


def test_a_writer_tracks_as_fvvmux_does(capture, tmp_path):
    options = OPTIONS | {"group": 4}
    theirs = fvv.mux(capture, tmp_path / "theirs.fvv", **options)
    assert theirs["mesh"]["tracking"]["by_outlines"] >= 2 and theirs["mesh"]["delta"]["frames"] >= 2
    described, cameras, frame = read_capture(capture)
    names = {"name": described["name"], "up": described["up"]}
    with fvv.Writer(tmp_path / "own.fvv", rate=25, cameras=cameras, **names, **options) as writer:
        for i in range(4):
            mesh, pictures, masks = frame(i)
            writer.add(mesh, pictures, masks, time=i / 25)
    assert (tmp_path / "own.fvv").read_bytes() == (tmp_path / "theirs.fvv").read_bytes()


def test_processes_track_as_one_run_does(capture, tmp_path):
    """Masks of cameras whose pictures are not sent count too."""
    options = OPTIONS | {"group": 2, "cameras": [0, 2, 3]}
    whole = fvv.mux(capture, tmp_path / "whole.fvv", **options)
    assert whole["mesh"]["tracking"]["by_outlines"] >= 1
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        fvv.distributed.mux(capture, tmp_path / "out.fvv", pool, **options)
    assert (tmp_path / "out.fvv").read_bytes() == (tmp_path / "whole.fvv").read_bytes()
