"""fvvmux --plan, --part and --merge: the bytes of one run, from groups that processes encode alone."""

import json
import shutil

import numpy as np
import pytest
from conftest import figures, run
from PIL import Image

GROUP = 4


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    """Folders by name: still cameras with sound and a room; hulls, unlike cameras of which one moves; an atlas; an
    empty stage at the end."""
    root = tmp_path_factory.mktemp("captures")
    small = ("--rig", "small", "--cameras", 3, "--size", "160x96")
    run("fvvsynth", *small, "--frames", 9, "--sound", "--environment", "-o", root / "small")
    hulls = ("--meshes", "hull", "--hull-cells", 48, "--exposure", 0.4)
    run("fvvsynth", "--size", "160x96", "--frames", 6, *hulls, "-o", root / "studio")
    run("fvvsynth", *small, "--frames", 6, "--atlas", "--atlas-size", 512, "-o", root / "atlas")
    shutil.copytree(root / "small", root / "empty")
    description = json.loads((root / "empty/capture.json").read_text())
    description["meshes"] = {**description["meshes"], "empty": [4, [7, 8]]}
    for camera in description["cameras"]:
        for key in "pictures", "masks":
            camera.pop(key, None)
    (root / "empty/capture.json").write_text(json.dumps(description))
    return root


def files(folder):
    return sorted(path.name for path in folder.iterdir() if path.name != ".fvv-output")


def plan(capture, folder, *options):
    run("fvvmux", capture, "--plan", folder, *options, code=(0, 3), warns=True)
    return len((folder / ".fvv-output").read_text().split("file group-")) // 2


def encode_all(capture, folder, *options):
    """Plans and encodes, the groups one by one from the last to the first."""
    groups = plan(capture, folder, *options)
    for group in reversed(range(1, groups)):
        run("fvvmux", "--part", group, folder, "--threads", 1, code=(0, 3), warns=True)
    return groups


# Each choice of a plan that a group needs is in one of them.
CASES = {
    "defaults": ("small", ()),
    "live": ("small", ("--live", "--repeat-configuration", "--codec", "hevc", "--bitrate", "60k")),
    "stills": (
        "small",
        ("--codec", "jpeg", "--quality", 80, "--video-tracks", 2, "--no-delta", "--no-sound"),
    ),
    "ladder": ("small", ("--ladder", "1,0.5", "--mesh-ladder", "on", "--max-error", 0.4)),
    "views": ("small", ("--view-loss", "0.1dB")),
    "rungs": ("small", ("--ladder", "auto")),
    "preset": ("small", ("--preset", "live")),
    # Visibility does not pay, which the first group decides; the rate cannot be kept, which is a warning.
    "starved": ("small", ("--bitrate", "8k", "--max-error", "1mm", "--skip-bad-frames")),
    "selected": (
        "small",
        (
            "--frames",
            "2-8",
            "--cameras",
            "0,2",
            "--no-environment",
            "--visibility",
            "none",
            "--colours",
            "off",
        )
        + ("--texture-best", 2, "--texture-blend", "paper", "--texture-unseen", "1,2,3", "--keep-geometry"),
    ),
    # No quality reaches that, which is a warning.
    "pictures": (
        "small",
        ("--no-meshes", "--crop", "none", "--tile-fill", "keep", "--tile", "96x64", "--quality", "99dB"),
    ),
    "moving": ("studio", ("--undistort", "--match-colours", "on", "--video-size", "256x256")),
    "forced": (
        "studio",
        ("--winding", "flip", "--texture-inset", "3mm", "--triangles", 300, "--cameras", "0-2"),
    ),
    "atlas": ("atlas", ("--ladder", "200k,60k", "--atlas-scale", 0.25, "--texture-bits", 10)),
    "empty": ("empty", ("--step", "3mm", "--mesh-profile", "fast")),
}


@pytest.mark.parametrize(
    "case", [case if case == "defaults" else pytest.param(case, marks=pytest.mark.long) for case in CASES]
)
def test_the_bytes_and_warnings_are_those_of_one_run(captures, tmp_path, case):
    name, options = CASES[case]
    capture, options = captures / name, ("--group", GROUP, *options)
    whole = run("fvvmux", capture, "-o", tmp_path / "whole.fvv", *options, code=(0, 3), warns=True)
    groups = encode_all(capture, tmp_path / "parts", *options)
    assert groups > 1
    shutil.move(captures / name, captures / "elsewhere")  # what is merged needs no capture
    try:
        merge = ("--merge", tmp_path / "parts", "-o", tmp_path / "merged.fvv")
        merged = run("fvvmux", *merge, code=(0, 3), warns=True)
    finally:
        shutil.move(captures / "elsewhere", captures / name)
    assert (tmp_path / "merged.fvv").read_bytes() == (tmp_path / "whole.fvv").read_bytes()
    assert (merged.returncode, merged.stderr) == (whole.returncode, whole.stderr)
    assert (whole.returncode == 3) == (case in ("starved", "forced", "pictures"))
    assert ("--quality: cameras 0, 1, 2: 99 dB were" in whole.stderr) == (case == "pictures")


@pytest.fixture(scope="module")
def encoded(captures):
    folder = captures / "encoded"
    assert encode_all(captures / "small", folder, "--group", GROUP) == 3
    return folder


@pytest.fixture
def parts(encoded, tmp_path):
    """A folder with all parts of the capture "small"."""
    return shutil.copytree(encoded, tmp_path / "parts")


def fails(*arguments, code=1):
    return run("fvvmux", *arguments, code=code).stderr


def test_a_part_is_what_one_receives_who_joins_late(parts):
    found = run("fvvinfo", "--check", parts / "group-1.fvv", code=1)
    assert "group 1, expected 0: groups are missing [FVV-1205]" in found.stderr
    assert "4 of 4 frames are whole" in found.stdout
    found = run("fvvinfo", "--check", parts / "group-0.fvv", code=3)
    assert found.stderr.endswith("no footer: the stream is live or truncated\n")


def test_parts_are_encoded_from_their_own_frames(captures, tmp_path):
    """Elsewhere, with no file of other frames than those of the group."""
    groups = plan(captures / "small", tmp_path / "parts", "--group", GROUP)
    assert groups == 3
    shutil.copytree(captures / "small", tmp_path / "moved")
    for path in list((tmp_path / "moved").rglob("*.*")):
        number = path.stem[-4:]
        if path.name != "capture.json" and not (number.isdigit() and 4 <= int(number) < 8):
            path.unlink()
    moved = ("--capture", tmp_path / "moved")
    run("fvvmux", "--part", 1, tmp_path / "parts", *moved)
    here, there = tmp_path / "here", tmp_path / "parts"
    shutil.copytree(there, here)
    run("fvvmux", "--part", 1, here, "--force")
    assert (here / "group-1.fvv").read_bytes() == (there / "group-1.fvv").read_bytes()
    assert "0008" in fails("--part", 2, tmp_path / "parts", *moved)
    assert "group-2.fvv" not in files(tmp_path / "parts")


def test_the_plan_decides_how_masks_are_read(captures, tmp_path):
    """Labels of 0 and 1 but for one bright mask in another group: the parts know of it where its file is not."""
    folder = shutil.copytree(captures / "small", tmp_path / "capture")
    for path in folder.rglob("mask_*.png"):
        mask = np.asarray(Image.open(path).convert("L")) > 127
        bright = int(path.stem[-4:]) >= GROUP
        Image.fromarray(np.where(mask, 255 if bright else 1, 0).astype(np.uint8)).save(path)
    options = ("--group", GROUP, "--crop", "none", "--tile-fill", "flat")
    run("fvvmux", folder, "--plan", tmp_path / "parts", *options, code=(0, 3), warns=True)
    whole = shutil.copytree(tmp_path / "parts", tmp_path / "whole")
    run("fvvmux", "--part", 0, whole, "--force", code=(0, 3), warns=True)
    for path in folder.rglob("*_*.png"):
        if int(path.stem[-4:]) >= GROUP:
            path.unlink()
    run("fvvmux", "--part", 0, tmp_path / "parts", "--force", code=(0, 3), warns=True)
    assert (tmp_path / "parts/group-0.fvv").read_bytes() == (whole / "group-0.fvv").read_bytes()


def test_what_the_commands_print(captures, tmp_path):
    folder, out = tmp_path / "parts", tmp_path / "out.fvv"
    found = figures("fvvmux", captures / "small", "--plan", folder, "--group", GROUP)
    assert found["plan"] == {"folder": str(folder), "groups": 3, "frames": 9}
    assert figures("fvvmux", "--part", "1-2", folder)["parts"] == {
        "folder": str(folder),
        "first": 1,
        "last": 2,
    }
    merged = figures("fvvmux", folder, "--merge", "-o", out)["merged"]
    assert merged == {"file": str(out), "groups": 3, "bytes": out.stat().st_size}


def test_missing_parts_are_named(captures, tmp_path):
    folder, out = tmp_path / "parts", tmp_path / "out.fvv"
    assert plan(captures / "small", folder, "--group", 2) == 5
    run("fvvmux", "--part", 3, folder)
    message = fails("--merge", folder, "-o", out)
    assert f"{folder}: of 5 groups 1 to 2, 4 are missing" in message
    (folder / "group-3.json").unlink()
    assert "1 to 4 are missing" in fails("--merge", folder, "-o", out)
    assert not out.exists()


def test_damaged_parts_are_refused(parts, tmp_path):
    good = (parts / "group-1.fvv").read_bytes()
    for at in 20, 300, len(good) // 2, len(good) - 9:
        (parts / "group-1.fvv").write_bytes(good[:at] + bytes([good[at] ^ 1]) + good[at + 1 :])
        assert "group-1.fvv" in fails("--merge", parts, "-o", tmp_path / "out.fvv")
    for damaged in good[:-1], good + good[-64:], b"":
        (parts / "group-1.fvv").write_bytes(damaged)
        assert "group-1.fvv" in fails("--merge", parts, "-o", tmp_path / "out.fvv")
    (parts / "group-1.fvv").write_bytes(good)
    (parts / "group-1.json").write_text("{}")
    assert "report of the part is damaged" in fails("--merge", parts, "-o", tmp_path / "out.fvv")
    assert not (tmp_path / "out.fvv").exists()


def test_parts_of_another_plan_or_group_are_refused(captures, parts, tmp_path):
    good = (parts / "group-1.fvv").read_bytes()
    shutil.copy(parts / "group-2.fvv", parts / "group-1.fvv")
    assert "is not group 1 of the plan" in fails("--merge", parts, "-o", tmp_path / "out.fvv")
    encode_all(captures / "small", tmp_path / "other", "--group", GROUP, "--texture-best", 2)
    shutil.copy(tmp_path / "other/group-1.fvv", parts / "group-1.fvv")
    assert "configuration is not that of the plan" in fails("--merge", parts, "-o", tmp_path / "out.fvv")
    (parts / "group-1.fvv").write_bytes(good)
    run("fvvmux", "--merge", parts, "-o", tmp_path / "out.fvv")


def test_parts_of_other_choices_are_refused(captures, tmp_path):
    """The configuration of streams says little of how they were encoded: it is the same for many qualities."""
    jpeg = ("--group", GROUP, "--codec", "jpeg")
    encode_all(captures / "small", tmp_path / "fine", *jpeg, "--quality", 90)
    encode_all(captures / "small", tmp_path / "coarse", *jpeg, "--quality", 20)
    fine, coarse = (tmp_path / name for name in ("fine", "coarse"))
    before = {name: (fine / name).read_bytes() for name in files(fine)}
    merge = ("--merge", fine, "-o", tmp_path / "out.fvv")
    for suffixes, message in {
        (".fvv",): "the report of the part is that of another stream",
        (".json",): "was encoded by another plan, with other choices",
        (".fvv", ".json"): "was encoded by another plan, with other choices",
    }.items():
        for suffix in suffixes:
            shutil.copy(coarse / f"group-1{suffix}", fine)
        found = fails(*merge)
        assert f"{fine}/group-1.fvv: {message}: encode group 1 again, by this plan" in found
        for name, text in before.items():
            (fine / name).write_bytes(text)
    shutil.copy(fine / "group-2.json", fine / "group-1.json")
    assert "group-1.fvv: the report of the part is that of group 2: encode group 1" in fails(*merge)
    (fine / "group-1.json").write_bytes(before["group-1.json"])
    run("fvvmux", *merge)


def test_a_changed_capture_is_refused(captures, tmp_path):
    shutil.copytree(captures / "small", tmp_path / "capture")
    plan(tmp_path / "capture", tmp_path / "parts", "--group", GROUP)
    description = tmp_path / "capture/capture.json"
    description.write_text(description.read_text() + "\n")
    message = fails("--part", 1, tmp_path / "parts")
    assert f"{description}: is not the file that was planned" in message
    assert "group-1.fvv" not in files(tmp_path / "parts")


def test_a_damaged_plan_is_refused(captures, tmp_path):
    plan(captures / "small", tmp_path / "parts", "--group", GROUP)
    path = tmp_path / "parts/plan.cbor"
    good = path.read_bytes()
    for at in 0, 30, len(good) // 2, len(good) - 1:
        path.write_bytes(good[:at] + bytes([good[at] ^ 4]) + good[at + 1 :])
        assert "plan.cbor" in fails("--part", 1, tmp_path / "parts")
    path.write_bytes(good[: len(good) // 2])
    assert "plan.cbor: is no plan, or a damaged one" in fails("--part", 1, tmp_path / "parts")
    path.write_bytes(good.replace(b"plans of version ", b"plans of versiom "))
    assert "plan again, with the version that encodes" in fails("--part", 1, tmp_path / "parts")


def test_nothing_is_replaced_without_force(captures, parts, tmp_path):
    part = parts / "group-1.fvv"
    before = part.read_bytes()
    assert "already exists" in fails("--part", 1, parts)
    run("fvvmux", "--part", 1, parts, "--force")
    assert part.read_bytes() == before
    assert "already exists" in fails(captures / "small", "--plan", parts)
    for name in "plan.cbor", "group-0.fvv", "group-2.json":
        assert "which this run reads" in fails("--merge", parts, "-o", parts / name, "--force")
    # The folder is a plan's with all of its parts, and no more than that.
    run("fvvmux", captures / "small", "--plan", parts, "--group", GROUP, "--force")
    assert files(parts) == ["group-0.fvv", "group-0.json", "plan.cbor"]
    (parts / "mine.txt").write_text("mine")
    assert "did not write" in fails(captures / "small", "--plan", parts, "--force")


def test_a_part_that_fails_leaves_nothing(captures, tmp_path):
    shutil.copytree(captures / "small", tmp_path / "capture")
    plan(tmp_path / "capture", tmp_path / "parts", "--group", GROUP)
    broken = sorted((tmp_path / "capture").rglob("*0006.png"))[0]
    broken.write_bytes(broken.read_bytes()[:200])
    assert broken.name in fails("--part", 1, tmp_path / "parts")
    assert files(tmp_path / "parts") == ["group-0.fvv", "group-0.json", "plan.cbor"]
    broken.unlink()
    shutil.copy(captures / "small" / broken.relative_to(tmp_path / "capture"), broken)
    run("fvvmux", "--part", 1, tmp_path / "parts")


@pytest.mark.parametrize(
    "arguments",
    [
        ("--part", 1, "--quality", "40dB"),
        ("--part", 1, "-o", "out.fvv"),
        ("--part", 1, "--merge", "-o", "out.fvv"),
        ("--part", "one"),
        ("--part", 3),
        ("--merge",),
        ("--merge", "-o", "out.fvv", "--threads", 2),
        ("--merge", "-o", "out.fvv", "--capture", "elsewhere"),
        ("--plan", "new", "-o", "out.fvv"),
        ("--plan", "new", "--verify"),
        ("--plan", "new", "--segments", "out"),
    ],
)
def test_what_does_not_fit_together(parts, tmp_path, arguments):
    names = {"out.fvv", "out", "new"}
    fails(parts, *[tmp_path / word if word in names else word for word in arguments], code=2)
    assert files(tmp_path) == ["parts"]
