"""The whole way from recordings to captures and streams, on a generated scene."""

import errno
import hashlib
import json
import os
import shutil
import subprocess
import sys
import unittest.mock
import wave
from fractions import Fraction

import av
import cv2
import fvv
import fvv_capture.process
import jsonschema
import numpy
import pytest
from conftest import ROOT, tool
from fvv_capture import command
from fvv_capture.process import Request, process

CAMERAS = 6
FRAMES = 10
SIZE = (320, 180)


def empty_stage(folder):
    """The background of a camera, as the median of what masks leave of its pictures; what is never seen is filled in."""
    pictures = [cv2.imread(str(p)) for p in sorted(folder.glob("[0-9]*.png"))]
    masks = [cv2.imread(str(p), cv2.IMREAD_GRAYSCALE) for p in sorted(folder.glob("mask_*.png"))]
    stack = numpy.ma.array(
        pictures, mask=[numpy.repeat(cv2.dilate(m, None)[:, :, None] > 0, 3, 2) for m in masks]
    )
    median = numpy.ma.median(stack, axis=0)
    hidden = numpy.ma.getmaskarray(median)[:, :, 0]
    return cv2.inpaint(
        median.filled(0).astype(numpy.uint8), hidden.astype(numpy.uint8) * 255, 3, cv2.INPAINT_TELEA
    )


@pytest.fixture(scope="session")
def shoot(tmp_path_factory):
    """made/: the capture with its truth; recordings/, masks/, empty/: as somebody films it; room.json: the calibration."""
    place = tmp_path_factory.mktemp("shoot")
    made = place / "made"
    size = f"{SIZE[0]}x{SIZE[1]}"
    tool("fvvsynth", "-o", made, "--rig", "small", "--cameras", CAMERAS, "--size", size, "--frames", FRAMES)
    for camera in range(CAMERAS):
        name, source = f"cam{camera}", made / f"cam{camera}"
        for folder in ("recordings", "masks", "empty"):
            (place / folder / name).mkdir(parents=True)
        for n in range(FRAMES):
            shutil.copy(source / f"{n:04d}.png", place / "recordings" / name)
            shutil.copy(source / f"mask_{n:04d}.png", place / "masks" / name / f"{n:04d}.png")
        plate = empty_stage(source)
        for n in range(4):
            noise = numpy.random.default_rng(n).normal(0, 1, plate.shape)
            cv2.imwrite(
                str(place / "empty" / name / f"{n:04d}.png"),
                numpy.clip(plate + noise, 0, 255).astype(numpy.uint8),
            )
    document = json.loads((made / "capture.json").read_text())
    for camera in document["cameras"]:
        del camera["masks"]
    document["meshes"] = {"pattern": str(made / "meshes/%04d.ply")}
    (place / "room.json").write_text(json.dumps(document))
    return place


def run(*arguments, code=0):
    """Runs fvvcapture as a program. code: None for any."""
    done = subprocess.run(
        [sys.executable, "-m", "fvv_capture", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert code is None or done.returncode == code, done.stderr
    return done


def given(shoot, *more):
    return [shoot / "recordings", "--calibration", shoot / "room.json", "--fps", 25, "--cell", "25mm", *more]


def digests(folder):
    """Of all files but the report, whose times differ."""
    return {
        str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest()
        for p in sorted(folder.rglob("*"))
        if p.is_file() and p.name != "report.json"
    }


@pytest.fixture(scope="session")
def keyed(shoot):
    """A capture by keys against the empty stage, in one process."""
    run(
        *given(
            shoot,
            "--plate",
            shoot / "empty",
            "--jobs",
            1,
            "-o",
            shoot / "keyed",
            "--grids",
            "--sheet",
            shoot / "look.png",
        )
    )
    return shoot / "keyed"


def test_keys_and_hulls_agree_with_the_truth(shoot, keyed):
    report = json.loads((keyed / "report.json").read_text())
    jsonschema.validate(report, json.loads((ROOT / "spec/fvvcapture.schema.json").read_text()))
    assert report["iou_mean"] > 0.87  # shadows moved since the stage was empty
    assert len(report["frames"]) == FRAMES
    assert report["flicker"] < 0.05
    kept = []
    for camera in range(CAMERAS):
        for n in range(FRAMES):
            mask = cv2.imread(str(keyed / f"masks/cam{camera}/{n:04d}.png"), cv2.IMREAD_GRAYSCALE) > 0
            truth = cv2.imread(str(shoot / f"masks/cam{camera}/{n:04d}.png"), cv2.IMREAD_GRAYSCALE) > 0
            kept.append((mask & truth).sum() / (mask | truth).sum())
    assert numpy.mean(kept) > 0.85  # figures of 60 pixels: an outline half a pixel off costs a tenth


def test_the_sheet_shows_the_pictures_and_their_outlines(shoot, keyed):
    sheet = cv2.imread(str(shoot / "look.png"))
    assert sheet.shape[0] > 300
    assert sheet.shape[1] > 400
    assert sheet.std() > 20


def test_fvvmux_takes_the_capture(shoot, keyed, tmp_path):
    tool("fvvmux", keyed, "-o", tmp_path / "keyed.fvv", "--scale", 0.5)
    with fvv.open(tmp_path / "keyed.fvv") as clip:
        assert len(clip) == FRAMES
        assert clip[3].mesh.face_count > 500
        assert len(clip[3].pictures) == CAMERAS


def test_grids_are_kept_beside_the_meshes(keyed):
    with numpy.load(keyed / "grids/0004.npz") as grid:
        assert grid["cell"] == pytest.approx(0.025)
        assert len(grid["offsets"]) == len(grid["edges"]) > 1000


def test_processes_and_a_cluster_write_the_same_files(shoot, keyed, tmp_path):
    distributed = pytest.importorskip("dask.distributed")
    more = ["--plate", shoot / "empty", "--grids"]
    run(*given(shoot, *more, "--jobs", 2, "-o", shoot / "two"))
    assert digests(shoot / "two") == digests(keyed)
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        dashboard_address=None,
        local_directory=str(tmp_path),
    ) as cluster:
        run(*given(shoot, *more, "--dask", cluster.scheduler_address, "-o", shoot / "cluster"))
    assert digests(shoot / "cluster") == digests(keyed)


def test_masks_of_another_program_are_used_as_they_are(shoot, tmp_path):
    done = run(*given(shoot, "--masks", shoot / "masks", "--frames", "2-5", "--json", "-o", tmp_path / "out"))
    report = json.loads(done.stdout)
    assert [frame["number"] for frame in report["frames"]] == [2, 3, 4, 5]
    assert report["cameras"][0]["confidence_mean"] is None
    assert report["iou_mean"] > 0.93
    assert not (tmp_path / "out/masks").exists()
    capture = json.loads((tmp_path / "out/capture.json").read_text())
    assert capture["frames"] == {"first": 2, "count": 4}
    tool("fvvmux", tmp_path / "out", "-o", tmp_path / "out.fvv", "--scale", 0.5, "--frames", "2-5")


def test_a_refined_surface_has_the_faces_of_the_hull_and_less_volume(shoot, tmp_path):
    made = {}
    for surface in ("hull", "refined"):
        out = tmp_path / surface
        masks = ["--masks", shoot / "masks", "--frames", "2-2"]
        done = run(*given(shoot, *masks, "--surface", surface, "--json", "-o", out), code=None)
        assert done.returncode in (0, 3), done.stderr
        made[surface] = json.loads(done.stdout)["frames"][0]
    assert made["refined"]["vertices"] == made["hull"]["vertices"] > 0
    assert 0.7 * made["hull"]["volume"] < made["refined"]["volume"] < made["hull"]["volume"]


def test_a_stream_comes_with_predictions_of_left_out_cameras(shoot, tmp_path):
    done = run(
        *given(
            shoot,
            "--masks",
            shoot / "masks",
            "--frames",
            "0-2",
            "--held-out",
            1,
            "--json",
            "-o",
            tmp_path / "a.fvv",
        )
    )
    report = json.loads(done.stdout)
    jsonschema.validate(report, json.loads((ROOT / "spec/fvvcapture.schema.json").read_text()))
    assert {h["camera"] for h in report["held_out"]} == {f"cam{c}" for c in range(CAMERAS)}
    assert numpy.mean([h["psnr"] for h in report["held_out"]]) > 16
    assert report["mux"]["frames"] == 3
    with fvv.open(tmp_path / "a.fvv") as clip:
        assert len(clip) == 3
    assert os.listdir(tmp_path) == ["a.fvv"]


def film(path, folder, count, first):
    """Pictures of a folder as H.264, from number first on."""
    with av.open(str(path), "w") as file:
        stream = file.add_stream("libx264", rate=25, options={"crf": "8"})
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv420p"
        for n in range(first, first + count):
            frame = av.VideoFrame.from_ndarray(
                cv2.imread(str(folder / f"{n:04d}.png"))[:, :, ::-1].copy(), format="rgb24"
            )
            file.mux(stream.encode(frame))
        file.mux(stream.encode())


def test_videos_that_began_at_other_times(shoot, tmp_path):
    begins = [0, 2, 1, 0, 3, 1]
    (tmp_path / "films").mkdir()
    for camera, first in enumerate(begins):
        film(tmp_path / f"films/cam{camera}.mp4", shoot / f"recordings/cam{camera}", FRAMES - first, first)
    # The empty stage is filmed in the same way: compression is a part of what a camera sees.
    (tmp_path / "stage").mkdir()
    for camera in range(CAMERAS):
        film(tmp_path / f"stage/cam{camera}.mp4", shoot / f"empty/cam{camera}", 4, 0)
    offsets = [part for c, first in enumerate(begins) for part in ("--offset", f"cam{c}={-first}")]
    # With a plate: frames are few.
    done = run(tmp_path / "films", "--calibration", shoot / "room.json", "--cell", "25mm", "--plate", tmp_path / "stage",
               *offsets, "--json", "-o", tmp_path / "out", code=None)  # fmt: skip
    report = json.loads(done.stdout)
    assert [f["number"] for f in report["frames"]] == list(range(3, FRAMES))
    assert report["iou_mean"] > 0.85
    # Every film gives the picture of the frame, and not one that it would give without its offset.
    for camera, first in enumerate(begins):
        mask = f"cam{camera}/{{:04d}}.png"
        found = cv2.imread(str(tmp_path / "out/masks" / mask.format(5)), cv2.IMREAD_GRAYSCALE) > 0
        there = agreement(found, shoot / "masks" / mask.format(5))
        assert there > 0.75
        if first:
            assert there > agreement(found, shoot / "masks" / mask.format(5 + first))
            assert there > agreement(found, shoot / "masks" / mask.format(5 - first))
    tool("fvvmux", tmp_path / "out", "-o", tmp_path / "out.fvv", "--scale", 0.5, "--frames", "3-9")


def test_a_film_that_ends_early_is_used_as_far_as_it_goes(shoot, tmp_path):
    (tmp_path / "films").mkdir()
    (tmp_path / "stage").mkdir()
    for camera in range(CAMERAS):
        count = 6 if camera == 4 else FRAMES
        film(tmp_path / f"films/cam{camera}_take.mp4", shoot / f"recordings/cam{camera}", count, 0)
        film(tmp_path / f"stage/cam{camera}.mp4", shoot / f"empty/cam{camera}", 4, 0)
    done = run(tmp_path / "films", "--calibration", shoot / "room.json", "--cell", "25mm", "--plate", tmp_path / "stage", "--name",
               "{camera}_take", "--frames", "3-8", "--mux", "scale=0.5", "--json", "-o", tmp_path / "out.fvv", code=3)  # fmt: skip
    report = json.loads(done.stdout)
    assert [f["number"] for f in report["frames"]] == list(range(3, 9))
    assert report["warnings"] == ["cam4 ends after frame 5: frames 6 to 9 are made without it"]
    assert [f["iou"][4] is None for f in report["frames"]] == [False] * 3 + [True] * 3
    assert report["iou_mean"] > 0.85
    with fvv.open(tmp_path / "out.fvv") as clip:
        assert [len(frame.cameras) for frame in clip] == [CAMERAS] * 3 + [CAMERAS - 1] * 3


def test_recordings_that_were_swapped_are_named(shoot, tmp_path):
    """With masks, so that nothing else is in doubt."""
    for kind in ("recordings", "masks"):
        shutil.copytree(shoot / kind, tmp_path / kind)
        (tmp_path / kind / "cam1").rename(tmp_path / kind / "cam")
        (tmp_path / kind / "cam4").rename(tmp_path / kind / "cam1")
        (tmp_path / kind / "cam").rename(tmp_path / kind / "cam4")
    more = ["--cell", "25mm", "--masks", tmp_path / "masks", "--frames", "4-5", "-o", tmp_path / "out"]
    done = run(tmp_path / "recordings", "--calibration", shoot / "room.json", "--fps", 25, *more, code=None)
    assert done.returncode in (1, 3)
    assert "cam1 does not agree" in done.stderr
    assert "its recording is that of cam4" in done.stderr
    assert "its recording is that of cam1" in done.stderr


def test_offsets_that_are_not_certain_end_it_unless_they_are_accepted(shoot, tmp_path):
    """Sound that has nothing in common: nothing is written, and that is no success."""
    for camera in range(CAMERAS):
        folder = tmp_path / f"recordings/cam{camera}"
        shutil.copytree(shoot / f"recordings/cam{camera}", folder)
        noise = numpy.random.default_rng(camera).normal(0, 3000, 16000).astype("<i2")
        with wave.open(f"{folder}.wav", "wb") as file:
            file.setnchannels(1)
            file.setsampwidth(2)
            file.setframerate(16000)
            file.writeframes(noise.tobytes())
    arguments = [tmp_path / "recordings", "--calibration", shoot / "room.json", "--fps", 25, "--masks", shoot / "masks",
                 "--cell", "40mm", "--synchronise", "sound", "-o", tmp_path / "out"]  # fmt: skip
    done = run(*arguments, code=3)
    assert "offsets by sound are not certain" in done.stderr
    assert "--accept-offsets" in done.stderr
    assert sorted(os.listdir(tmp_path)) == ["recordings"]
    # Those that are given need no sound.
    offsets = [part for c in range(CAMERAS) for part in ("--offset", f"cam{c}=0")]
    run(*arguments, *offsets)


def agreement(mask, path):
    """Intersection over union with a mask on disk."""
    other = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) > 0
    return (mask & other).sum() / (mask | other).sum()


def test_cameras_that_move_keep_their_calibration_of_each_frame(tmp_path):
    made = tmp_path / "made"
    tool("fvvsynth", "-o", made, "--rig", "studio", "--size", "320x180", "--frames", 3)
    document = json.loads((made / "capture.json").read_text())
    moving = [camera["name"] for camera in document["cameras"] if "per_frame" in camera]
    assert moving
    for camera in document["cameras"]:
        source = made / os.path.dirname(camera["pictures"])
        for folder, pattern in (("recordings", "{:04d}.png"), ("masks", "mask_{:04d}.png")):
            (tmp_path / folder / camera["name"]).mkdir(parents=True)
            for n in range(3):
                shutil.copy(source / pattern.format(n), tmp_path / folder / camera["name"] / f"{n:04d}.png")
    done = run(tmp_path / "recordings", "--calibration", made, "--fps", 25, "--masks", tmp_path / "masks", "--frames", "1-2",
               "--cell", "25mm", "--json", "-o", tmp_path / "out")  # fmt: skip
    report = json.loads(done.stdout)
    found = {camera["name"]: camera["iou_mean"] for camera in report["cameras"]}
    assert min(found[name] for name in moving) > 0.85
    written = json.loads((tmp_path / "out/capture.json").read_text())
    assert [c["name"] for c in written["cameras"] if "per_frame" in c] == moving
    tool("fvvmux", tmp_path / "out", "-o", tmp_path / "out.fvv", "--frames", "1-2", "--scale", 0.5)


def test_an_output_is_replaced_only_with_force_and_only_if_it_is_ours(shoot, tmp_path):
    out = tmp_path / "out"
    more = ["--masks", shoot / "masks", "--frames", "0-0", "--jobs", 1, "-o", out]
    run(*given(shoot, *more))
    assert "--force" in run(*given(shoot, *more), code=2).stderr
    run(*given(shoot, *more, "--force"))
    (out / "mine.txt").write_text("keep")
    assert "mine.txt" in run(*given(shoot, *more, "--force"), code=2).stderr
    assert (out / "mine.txt").read_text() == "keep"
    assert sorted(os.listdir(tmp_path)) == ["out"]


@pytest.mark.parametrize("missing", [False, True])
def test_all_outputs_are_written_or_none(shoot, tmp_path, capsys, monkeypatch, missing):
    """The chart comes last: without it there is no stream and no sheet. Without matplotlib nothing is begun."""
    arguments = [
        *given(shoot, "--masks", shoot / "masks", "--frames", "0-0", "--jobs", 1, "-o", tmp_path / "a.fvv")
    ]
    arguments += ["--sheet", tmp_path / "sheet.png", "--chart", tmp_path / "chart.png"]
    with monkeypatch.context() as patched:
        if missing:
            patched.setitem(sys.modules, "matplotlib.figure", None)
            patched.setitem(sys.modules, "matplotlib", None)
            patched.setattr(fvv_capture.process, "_shoot", None)
        else:
            disk = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "chart.png")
            patched.setattr(fvv_capture.process, "chart", unittest.mock.Mock(side_effect=disk))
        assert command.main([str(a) for a in arguments]) == (2 if missing else 1)
    assert ("pip install fvv[plot]" if missing else "chart.png") in capsys.readouterr().err
    assert os.listdir(tmp_path) == []
    assert command.main([str(a) for a in arguments]) in (0, 3)
    assert sorted(os.listdir(tmp_path)) == ["a.fvv", "chart.png", "sheet.png"]
    assert cv2.imread(str(tmp_path / "chart.png")).std() > 10


@pytest.mark.parametrize(
    ("more", "code", "said"),
    [
        (["--frames", "0-99"], 2, "expected frames from 0 to 9"),
        (["--cameras", "stranger"], 2, "there is no camera stranger"),
        (["--offset", "cam0"], 2, "expected NAME=VALUE"),
        (["--cell", "0mm"], 2, "expected a length"),
        (["--cell", "3mm", "--max-error", "1"], 2, "not both"),
        (["--floor", "0"], 2, "expected with --up"),
        (["--bounds", "0,0,0,1,1"], 2, "expected 6 numbers"),
        (["--synchronise", "sound"], 2, "expected a file of sound beside"),
        (["--plate", "{masks}/cam0"], 2, "found none"),
        (["--bounds", "50,50,50,51,51,51"], 1, "no frame has anything"),
        (["--mux", "scale=0.5"], 2, "expected with -o NAME.fvv"),
    ],
)
def test_what_cannot_be_done_is_said(shoot, tmp_path, capsys, more, code, said):
    more = [part.format(masks=shoot / "masks") for part in more]
    arguments = [shoot / "recordings", "--calibration", shoot / "room.json", "--fps", "25", "--jobs", "1"]
    if "--plate" not in more:
        arguments += ["--masks", shoot / "masks"]
    if "--cell" not in more:
        arguments += ["--cell", "40mm"]
    assert command.main([str(a) for a in [*arguments, *more, "-o", tmp_path / "out"]]) == code
    found = capsys.readouterr().err
    assert said in found
    assert found.startswith("fvvcapture: ")
    assert found.count("\n") == 1
    assert os.listdir(tmp_path) == []


def test_process_is_a_function_too(shoot, tmp_path):
    stages = []
    request = Request(
        str(shoot / "recordings"), str(shoot / "room.json"), str(tmp_path / "out"), masks=str(shoot / "masks"),
        rate=Fraction(25), frames=(0, 1),
    )  # fmt: skip
    result = process(request, progress=lambda stage, done, count: stages.append(stage))
    assert result.warnings == []
    assert "key and carve" in stages
    assert len(result.report["frames"]) == 2
