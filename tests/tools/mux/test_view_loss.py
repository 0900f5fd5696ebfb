"""fvvmux --view-loss: what a scene needs is chosen by cameras that are drawn from the others."""

import json
import re
import shutil
import struct
from xml.etree import ElementTree

import pytest
from conftest import figures, run

SMALL = "--rig", "small", "--cameras", 7, "--size", "192x112", "--frames", 4
GOAL, NONE = ("--view-loss", "0.1dB"), ("--view-loss", "none")


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    root = tmp_path_factory.mktemp("captures")
    run("fvvsynth", *SMALL, "-o", root / "tracked")
    run("fvvsynth", *SMALL, "--meshes", "hull", "--hull-cells", 64, "-o", root / "hull")
    return root


# In so small pictures meshes take more bytes than usual. Views of exact meshes gain by a stricter threshold, also at places between the
# cameras (docs/encoding/view-loss.md); those of a hull of so few cells do not.
@pytest.mark.parametrize("name, most, threshold", [("tracked", 0.95, 0.25), ("hull", 0.85, 0.05)])
def test_bytes_fall_and_views_do_not(captures, name, most, threshold, tmp_path):
    before = figures("fvvmux", captures / name, "-o", tmp_path / "a.fvv", *NONE)
    after = figures("fvvmux", captures / name, "-o", tmp_path / "b.fvv", *GOAL, "--verify")
    found = after["view_loss"]
    assert "view_loss" not in before
    assert found["measured"] and found["goal"] == 0.1
    assert found["loss"] <= 0.1
    assert found["loss"] == pytest.approx(found["without"]["psnr"] - found["chosen"]["psnr"])
    assert found["finest"]["psnr"] > found["chosen"]["psnr"] - 0.5
    assert 38 <= found["picture_psnr"] < 42
    assert found["threshold"] == threshold
    assert after["bytes"] < most * before["bytes"]
    assert after["budget"]["max_error"] == found["max_error"]
    assert after["verified"]["psnr"] > 37


def test_what_is_chosen_is_what_options_would_set(captures, tmp_path):
    # Without an option the weights of the first group are found before it is known whether they are sent, and its colours use them.
    weights = "--visibility", "weight"
    summary = figures("fvvmux", captures / "hull", "-o", tmp_path / "a.fvv", *GOAL, *weights)
    after = summary["view_loss"]
    assert after["blend"] == "viewer"
    usual = {"threshold": 0.05, "best": 3}
    texturing = [(f"--texture-{name}", after[name]) for name in usual if after[name] != usual[name]]
    run(  # it may warn that the step errs by more than the budget
        "fvvmux", captures / "hull", "-o", tmp_path / "b.fvv", "--quality", summary["video"]["quality"],
        "--max-error", after["max_error"], "--step", f"{after['step']}m", *sum(texturing, ()),
        "--colours", 300, *weights, code=(0, 3), warns=True,
    )  # fmt: skip
    assert (tmp_path / "a.fvv").read_bytes() == (tmp_path / "b.fvv").read_bytes()


def test_it_is_the_goal_unless_another_one_is_stated(captures, tmp_path):
    def packed(*options):
        out = "-o", tmp_path / "a.fvv", "--force", "--frames", "0-1"
        found = figures("fvvmux", captures / "tracked", *out, *options)
        return (tmp_path / "a.fvv").read_bytes(), found.get("view_loss")

    usual, found = packed()
    assert found["measured"] and found["goal"] == 0.1
    assert packed(*GOAL)[0] == usual != packed(*NONE)[0]
    for other in (
        NONE,
        ("--quality", "42dB"),
        ("--max-error", 0.15),
        ("--bitrate", "2M"),
        ("--ladder", "42dB,30dB"),
    ):
        assert packed(*other)[1] is None
    for preset in "fast", "live":
        found = packed("--preset", preset)[1]
        assert not found["measured"] and f"--preset {preset}" in found["reason"]
    assert packed("--preset", "fast", *GOAL)[1]["measured"]


def test_options_override_the_choice(captures, tmp_path):
    stream = ("-o", tmp_path / "a.fvv", "--force", *GOAL)
    after = figures("fvvmux", captures / "tracked", *stream, "--quality", "41dB", "--max-error", 0.25)
    assert after["view_loss"]["picture_psnr"] == 41
    assert after["budget"]["max_error"] == 0.25
    assert figures("fvvmux", captures / "tracked", *stream, "--quality", 24)["video"]["quality"] == 24


def test_what_cannot_be_measured_stays_and_says_why(captures, tmp_path):
    for options, reason in (
        (("--no-meshes",), "no meshes"),
        (("--cameras", 0), "no two cameras"),
        (("--bitrate", "200k"), "bit rate"),
    ):
        out = ("-o", tmp_path / "a.fvv", "--force", *options)
        run("fvvmux", captures / "tracked", *out, *NONE)
        before = (tmp_path / "a.fvv").read_bytes()
        found = figures("fvvmux", captures / "tracked", *out, *GOAL)["view_loss"]
        assert not found["measured"] and reason in found["reason"]
        assert (tmp_path / "a.fvv").read_bytes() == before


def test_a_stage_that_is_empty_in_the_middle_is_looked_at_elsewhere(captures, tmp_path):
    shutil.copytree(captures / "tracked", tmp_path / "empty")
    empty = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement face 0\n"
    for frame in 2, 3:
        mesh = tmp_path / f"empty/meshes/{frame:04d}.ply"
        mesh.write_text(empty + "property list uchar int vertex_indices\nend_header\n")
    found = figures("fvvmux", tmp_path / "empty", "-o", tmp_path / "a.fvv", *GOAL, "--group", 2)["view_loss"]
    assert found["measured"] and found["frame"] == 0


def add_specks(ply, count):
    """Adds closed pieces of half a millimetre, 2 cm apart, to a mesh of fvvsynth: each loses all faces on any lattice that is chosen."""
    data = ply.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode()
    vertices, faces = (int(re.search(rf"element {what} (\d+)", header)[1]) for what in ("vertex", "face"))
    split = end + 12 * vertices
    points, corners = b"", b""
    for i in range(count):
        for x, y, z in (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1):
            points += struct.pack(
                "<3f", 0.01 + 0.02 * (i % 40) + 5e-4 * x, 1 + 5e-4 * y, 0.01 + 0.02 * (i // 40) + 5e-4 * z
            )
        for face in (0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2):
            corners += struct.pack("<B3i", 3, *(vertices + 4 * i + corner for corner in face))
    header = header.replace(f"vertex {vertices}", f"vertex {vertices + 4 * count}")
    header = header.replace(f"face {faces}", f"face {faces + 4 * count}")
    ply.write_bytes(header.encode() + data[end:split] + points + data[split:] + corners)


# Of a pixel, 33 mm at that size, half a square millimetre each: 40 are unseen, 4,000 are not.
@pytest.mark.parametrize("count", [40, 4000])
def test_pieces_that_vanish_are_no_warning_where_no_pixel_shows_them(captures, count, tmp_path):
    capture = shutil.copytree(captures / "tracked", tmp_path / "specks")
    add_specks(capture / "meshes/0001.ply", count)
    out = "-o", tmp_path / "a.fvv", "--force", "--frames", "0-1", "--json"
    for goal in NONE, GOAL:
        warns = goal == NONE or count == 4000
        done = run("fvvmux", capture, *out, *goal, code=3 if warns else 0)
        vanished = json.loads(done.stdout)["budget"]["vanished_pieces"]
        assert vanished == count
        assert (f"frame 1: {vanished} pieces of" in done.stderr) == warns
        assert done.stderr.count("\n") == warns


def test_threads_change_nothing(captures, tmp_path):
    for threads in 1, 3:
        run("fvvmux", captures / "tracked", "-o", tmp_path / f"{threads}.fvv", *GOAL, "--threads", threads)
    assert (tmp_path / "1.fvv").read_bytes() == (tmp_path / "3.fvv").read_bytes()


@pytest.mark.parametrize("value", ["0", "-1", "11dB", "0.1px", ""])
def test_other_values_are_refused(captures, value, tmp_path):
    done = run("fvvmux", captures / "tracked", "-o", tmp_path / "a.fvv", "--view-loss", value, code=2)
    assert "--view-loss" in done.stderr


def drawn(page):
    """The charts of a page, as XML without its namespace."""
    return [ElementTree.fromstring(chart) for chart in re.findall(r"<svg.*?</svg>", page, re.S)]


def test_the_page_marks_what_was_chosen_among_what_was_tried(captures, tmp_path):
    stream, page = tmp_path / "a & <b>.fvv", tmp_path / "a.html"
    found = figures("fvvmux", captures / "tracked", "-o", stream, *GOAL, "--report", page)["view_loss"]
    text = page.read_text()
    assert "a &amp; &lt;b&gt;.fvv" in text and "<b>" not in text
    assert not re.search(r"<script|<link|<img|https?:|url\(", text)
    charts, whole = drawn(text), found["candidates"]
    dots = {dot.find("title").text: dot for dot in charts[0].iter("circle") if dot.find("title") is not None}
    assert len(dots) == len(whole) > 20
    assert any(one["measured"] for one in whole)
    chosen = [
        one for one in whole if all(one[key] == found[key] for key in ("max_error", "step", "picture_psnr"))
    ]
    assert len(chosen) == 1 and chosen[0]["loss"] == found["loss"]
    assert chosen[0]["group_bytes"] == found["chosen"]["group_bytes"]
    # The last ring is of what was chosen, and lies on the dot of it.
    ring = [dot for dot in charts[0].iter("circle") if dot.find("title") is None][-1]
    on = [dot for dot in dots.values() if (dot.get("cx"), dot.get("cy")) == (ring.get("cx"), ring.get("cy"))]
    assert len(on) == 1 and on[0].find("title").text.endswith("measured")
    assert [one["threshold"] for one in found["blends"]][:3] == [0.05, 0.15, 0.25]
    assert len(charts[1].findall("rect")) >= 4  # meshes, pictures, container and more


def test_a_page_without_a_choice_has_the_bytes_alone(captures, tmp_path):
    out = "-o", tmp_path / "a.fvv", "--force", "--report", tmp_path / "a.html"
    run("fvvmux", captures / "tracked", *out, *NONE)
    assert len(drawn((tmp_path / "a.html").read_text())) == 1
    run("fvvmux", captures / "tracked", *out, *GOAL, "--cameras", 0)
    text = (tmp_path / "a.html").read_text()
    assert len(drawn(text)) == 1 and "no two cameras" in text
    before = (tmp_path / "a.html").read_bytes()
    run("fvvmux", captures / "tracked", "-o", tmp_path / "b.fvv", "--report", tmp_path / "a.html", code=1)
    assert (tmp_path / "a.html").read_bytes() == before and not (tmp_path / "b.fvv").exists()
    for other in (("--plan", tmp_path / "plan"), ("--realtime", "-o", tmp_path / "b.fvv")):
        run("fvvmux", captures / "tracked", *other, "--report", tmp_path / "b.html", code=2)


def test_each_rung_of_qualities_states_what_views_lose(captures, tmp_path):
    ladder = "--ladder", "40dB,33dB,27dB"
    found = figures("fvvmux", captures / "tracked", "-o", tmp_path / "a.fvv", *GOAL, *ladder)["view_loss"]
    rungs = found["rungs"]
    assert found["picture_psnr"] == 40
    assert [one["picture_psnr"] for one in rungs] == [33, 27]
    assert found["loss"] < rungs[0]["loss"] < rungs[1]["loss"]
    assert found["max_error"] < rungs[0]["max_error"] < rungs[1]["max_error"]


def test_the_scene_decides_about_rungs(captures, tmp_path):
    out = "-o", tmp_path / "a.fvv", "--force", "--frames", "0-1"
    summary = figures("fvvmux", captures / "hull", *out, "--ladder", "auto")
    found, rungs = summary["view_loss"], summary["ladder"]
    assert found["goal"] == 0.1 and len(rungs) == 1 + len(found["rungs"]) in (2, 3, 4)
    losses = [found["loss"]] + [one["loss"] for one in found["rungs"]]
    assert losses == sorted(losses) and losses[1] > losses[0]
    qualities = [found["picture_psnr"]] + [one["picture_psnr"] for one in found["rungs"]]
    assert qualities == sorted(set(qualities), reverse=True)
    assert all(one["scale"] == 1 for one in rungs)
    taken = [one["picture_bytes"] + one["meshes"]["bytes"] for one in rungs]
    assert taken == sorted(taken, reverse=True)
    # The first one is the stream without a ladder.
    alone = figures("fvvmux", captures / "hull", *out)
    assert alone["view_loss"]["picture_psnr"] == qualities[0]
    assert alone["mesh"]["bytes"] == rungs[0]["meshes"]["bytes"]


def test_rungs_that_are_not_measured_are_6_db_apart(captures, tmp_path):
    out = "-o", tmp_path / "a.fvv", "--force", "--frames", "0-1", "--ladder", "auto"
    for options in ("--quality", "40dB"), ("--preset", "fast", "--quality", "40dB"):
        summary = figures("fvvmux", captures / "tracked", *out, *options)
        reached = [one["tracks"][0]["sample_psnr"] for one in summary["ladder"]]
        assert reached == pytest.approx([40, 34, 28], abs=0.9)
    for other in (("--bitrate", "1M"), ("--quality", 24), ("--codec", "exr")):
        assert "--ladder auto" in run("fvvmux", captures / "tracked", *out, *other, code=2).stderr


def test_each_rung_of_sizes_states_what_views_lose(captures, tmp_path):
    out = "-o", tmp_path / "a.fvv", "--frames", "0-1", "--ladder", "1,0.5"
    summary = figures("fvvmux", captures / "tracked", *out)
    found, (rung,) = summary["view_loss"], summary["view_loss"]["rungs"]
    assert rung["scale"] == 0.5
    # By the rule of docs/encoding/ladder.md.
    assert rung["picture_psnr"] == pytest.approx(found["picture_psnr"] - 9)
    assert rung["max_error"] == pytest.approx(2 * found["max_error"], rel=0.01)
    # Half the pixels of so small pictures show much less than any quality of the full size.
    assert rung["loss"] > found["loss"] + 0.5


def test_with_few_cameras_meshes_become_little_coarser(captures, tmp_path):
    """Fewer than six leave surface to colours of vertices, which this measure does not see."""
    for cameras, coarsest, weights in (("0-4", 0.175, "15 %"), ("0-5", 0.3, "2 %")):
        out = "-o", tmp_path / "a.fvv", "--force", "--cameras", cameras, "--view-loss", "3dB"
        summary = figures("fvvmux", captures / "hull", *out, code=(0, 3))
        assert max(one["max_error"] for one in summary["view_loss"]["candidates"]) == coarsest
        # Visibility weights are worth more bytes there.
        assert summary["visibility"]["reason"].endswith(weights)
