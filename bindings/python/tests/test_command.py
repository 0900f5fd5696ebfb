"""python -m fvv: what it prints and draws, its exit codes, and what it does not overwrite."""

import io
import json
import os
import subprocess
import sys
import urllib.request

import fvv
import jsonschema
import numpy
import pytest
from conftest import CONFORMANCE, ROOT, VECTORS, tool
from fvv import command, information, outputs, plots
from PIL import Image
from vectors import name_of
from vectors import path_of as vector

FIELD = vector("delta_field")
SCHEMA = json.loads((ROOT / "spec/fvvinfo.schema.json").read_text())


def run(capsys, *arguments):
    """(code, stdout, stderr)."""
    code = command.main([str(one) for one in arguments])
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.fixture(scope="module")
def damaged(tmp_path_factory):
    """A stream without its last group's end and footer."""
    content = (vector("audio_two_sounds")).read_bytes()
    path = tmp_path_factory.mktemp("damaged") / "cut.fvv"
    path.write_bytes(content[: content.rindex(b"GEND") - 4])
    return path


# Chunks and bytes of clips.


def test_chunks_are_those_of_fvvinfo(players):
    (file,) = json.loads(tool("fvvinfo", "--json", "--chunks", players))["files"]
    with fvv.open(players) as clip:
        chunks = clip.chunks()
        first = next(c["offset"] for c in file["chunks"] if c["type"] == "GRUP")
        of_groups = {"MESH", "VISI", "VPKT", "AUDI", "COLR", "TILE"}
        listed = [c for c in file["chunks"] if c["type"] in of_groups and c["offset"] > first]
        assert len(chunks) == len(listed) > 60
        for one, other in zip(chunks, listed):
            assert one["type"].decode() == other["type"] and one["track"] == other["track"]
            assert (one["offset"], one["size"], one["time"]) == (
                other["offset"],
                other["size"],
                int(other["time"]),
            )
            # A chunk is where it is said to be.
            assert clip.read_at(int(one["offset"]), 64).find(one["type"]) >= 0
        by_track = {t["track"]: t["bytes"] for t in file["tracks"]}
        for track in clip.tracks:
            assert chunks["size"][chunks["track"] == track.id].sum() == by_track[track.id]
        keys = chunks[(chunks["type"] == b"MESH") & chunks["key"]]
        assert keys["group"].tolist() == [0, 1, 2] and keys["time"].tolist() == [0, 5, 10]
        assert (clip.chunks(1) == chunks[chunks["group"] == 1]).all()
        for group in (3, -1):
            with pytest.raises(fvv.UsageError):
                clip.chunks(group)
    with pytest.raises(fvv.UsageError, match="closed"):
        clip.chunks()


def test_a_clip_is_a_source(players):
    content = players.read_bytes()
    with fvv.open(players) as clip:
        assert clip.size == len(content) and clip.read_at(0, clip.size) == content
        assert clip.read_at(clip.size, 0) == b"" and clip.read_at(5, 7) == content[5:12]
        for offset, size in ((clip.size, 1), (0, clip.size + 1), (2**63, 2**63), (-1, 4), (4, -1)):
            with pytest.raises(fvv.UsageError):
                clip.read_at(offset, size)
        with fvv.open(clip) as again:
            assert (again[7].mesh.lattice == clip[7].mesh.lattice).all()
    with pytest.raises(fvv.UsageError, match="closed"):
        clip.read_at(0, 1)


def test_chunks_of_damaged_groups():
    content = FIELD.read_bytes()
    last = content.rindex(b"GEND")
    with fvv.open(content) as clip:
        whole = clip.chunks()
    with fvv.open(content[: last + 20] + bytes([content[last + 20] ^ 1]) + content[last + 21 :]) as clip:
        found = clip.chunks()
        assert set(found["offset"]) <= set(whole["offset"]) and clip.problems


# info.


def test_info(players, capsys):
    code, out, err = run(capsys, "info", players)
    assert (code, err) == (0, "")
    assert (
        "12 frames at 25 Hz in 3 groups" in out and "cam0, cam1, cam2" in out and len(out.splitlines()) < 40
    )


@pytest.mark.parametrize("path", VECTORS, ids=name_of)
def test_info_and_fvvinfo_print_one_document(path, capsys):
    code, out, err = run(capsys, "info", "--json", path)
    assert (code, err) == (0, "")
    assert out == tool("fvvinfo", "--json", path)
    jsonschema.validate(json.loads(out), SCHEMA)


@pytest.mark.parametrize("options", [(), ("--check",), ("--check", "--chunks")])
def test_inspect_of_whole_cut_and_damaged_streams_is_that_of_fvvinfo(players, tmp_path, options):
    given = {"decode": "--check" in options, "chunks": "--chunks" in options}
    whole = players.read_bytes()
    at = whole.rindex(b"GEND") + 20
    flipped = whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :]
    streams = {
        "whole": (whole, 0),
        "cut": (whole[: len(whole) // 2], 3),
        "damaged": (flipped, 1),
        "none": (b"fvv", 1),
    }
    for name, (content, code) in streams.items():
        path = tmp_path / name
        path.write_bytes(content)
        theirs = json.loads(tool("fvvinfo", "--json", *options, path, code=code))
        assert information.inspect(path, **given) == theirs, name
        jsonschema.validate(theirs, SCHEMA)
        # Of bytes only the name differs.
        (ours,) = information.inspect(content, **given)["files"]
        assert theirs["files"][0] == {**ours, "name": str(path)}, name
    assert theirs["files"][0]["integrity"] == "unreadable"


def test_info_as_json_says_what_is_damaged(tmp_path, capsys):
    path = tmp_path / "cut.fvv"
    path.write_bytes(FIELD.read_bytes()[:-60])
    code, out, _ = run(capsys, "info", "--json", path)
    assert code == 3 and json.loads(out)["files"][0]["integrity"] == "truncated"
    assert run(capsys, "info", "--json", "--rung", "1", path)[0] == 2
    assert run(capsys, "info", "--json", tmp_path / "absent.fvv")[0] == 1


@pytest.mark.parametrize("path", VECTORS, ids=name_of)
def test_info_of_every_vector(path, capsys):
    code, out, err = run(capsys, "info", path)
    if name_of(path) == "tiny_empty":
        assert code == 1 and err.startswith("fvv: ")
    else:
        assert (code, err) == (0, "") and str(path) in out


def test_exit_codes(damaged, tmp_path, capsys):
    code, out, _ = run(capsys, "info", damaged)
    assert code == 3 and "damage\n" in out
    text = tmp_path / "text.fvv"
    text.write_text("no stream")
    for arguments, code, word in (
        (["info", text], 1, "text.fvv"),
        (["info", tmp_path / "missing.fvv"], 1, "missing.fvv"),
        (["info", tmp_path], 2, "expected a file"),
        (["info", FIELD, "--rung", "-1"], 2, "rung"),
        (["plot", FIELD, "-o", tmp_path / "chart.bmp"], 2, ".png, .svg, .pdf"),
        (["plot", FIELD, "-o", tmp_path / "none/chart.png"], 1, "none"),
        (["info"], 2, "FILE"),
        (["spin", FIELD], 2, "spin"),
        ([], 2, "COMMAND"),
    ):
        found, out, err = run(capsys, *arguments)
        assert (found, out) == (code, "") and word in err, arguments
    assert run(capsys, "--help")[0] == 0 and run(capsys, "--version")[1] == f"fvv {fvv.__version__}\n"
    assert list(tmp_path.iterdir()) == [text]


def test_it_is_a_program(players):
    done = subprocess.run([sys.executable, "-m", "fvv", "info", players], capture_output=True, text=True)
    assert done.returncode == 0 and "12 frames" in done.stdout and done.stderr == ""
    with subprocess.Popen(
        [sys.executable, "-m", "fvv", "info", players], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        process.stdout.close()
        assert process.stderr.read() == b"" and process.wait() == 1


# plot.


def test_plot_writes_pictures(players, tmp_path, capsys):
    for kind, begins in (("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")):
        path = tmp_path / f"chart.{kind}"
        assert run(capsys, "plot", players if kind == "png" else FIELD, "-o", path) == (0, "", "")
        assert path.read_bytes().startswith(begins)
        assert path.stat().st_mode & 0o777 == 0o666 & ~umask()
    picture = numpy.asarray(Image.open(tmp_path / "chart.png").convert("RGB"))
    assert picture.shape[1] == 1430
    for colour in (plots.COLOURS["mesh"], plots.COLOURS["video"]):
        rgb = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
        assert (picture == rgb).all(axis=2).sum() > 1000
    first = (tmp_path / "chart.svg").read_bytes()
    assert run(capsys, "plot", FIELD, "--force", "-o", tmp_path / "chart.svg")[0] == 0
    assert (tmp_path / "chart.svg").read_bytes() == first


def umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_what_the_charts_show(players):
    with fvv.open(players) as clip:
        figure = plots.plot(clip)
        sizes, keys, counts, above, side = figure.axes
        times = plots.times_of(clip)
        series = plots.series_of(clip, times)
        chunks = clip.chunks()
        assert sum(int(one.bytes.sum()) for one in series) == chunks["size"].sum()
        mesh = series[0]
        assert mesh.name == "mesh 1" and mesh.state.tolist() == [2, 1, 1, 1, 1, 2, 1, 1, 1, 1, 2, 1]
        for frame in (0, 3, 11):
            chosen = (chunks["type"] == b"MESH") & (chunks["time"] == clip[frame].ticks)
            assert mesh.bytes[frame] == chunks["size"][chosen].sum()
        assert plots.borders_of(clip).tolist() == [0.2, 0.4]
        assert [axes.get_xlabel() for axes in (counts, above, side)] == ["time in s", "x in m", "x in m"]
        assert (above.get_ylabel(), side.get_ylabel()) == ("z in m", "y in m")
        # z grows towards the lower edge of the view from above, as seen by somebody who faces -z.
        assert above.yaxis_inverted() and not side.yaxis_inverted()
        for camera in clip[0].cameras.values():
            x, y, z = camera.centre
            assert side.get_xlim()[0] < x < side.get_xlim()[1] and side.get_ylim()[0] < y < side.get_ylim()[1]
            assert min(above.get_ylim()) < z < max(above.get_ylim())
        assert len(keys.get_yticks()) == len(series)
        for axes in (above, side):
            assert {"cam0", "cam1", "cam2"} <= {text.get_text() for text in axes.texts}


def test_a_chart_has_a_line_for_each_rung(players):
    """A viewer receives one of them: all rungs summed is a rate of no viewer."""
    for rung in (0, 1):
        with fvv.open(players, rung=rung) as clip:
            sizes = plots.plot(clip).axes[0]
            series = plots.series_of(clip, plots.times_of(clip))
            names = [text.get_text() for text in sizes.get_legend().get_texts()]
            lines = {patch.get_label(): patch.get_data().values for patch in sizes.patches if not patch.fill}
            assert len(clip.rungs) == len(lines) == 2 and set(lines) <= set(names)
            for number, (label, values) in enumerate(lines.items()):
                tracks = [
                    t.id for t in clip.tracks if not t.alternate_group or t.id in clip.rungs[number].tracks
                ]
                chunks = clip.chunks()
                sent = chunks["size"][numpy.isin(chunks["track"], tracks)].sum()
                assert values.sum() * 1000 == pytest.approx(sent)
                assert label == f"rung {number}: {8e-6 * sent / clip.duration:.2f} Mbit/s"
            read = [one.name for one in series if rung in one.rungs]
            assert sorted(names) == sorted([*lines, *read]) and len(read) < len(series)
            top = max(patch.get_data().values.max() for patch in sizes.patches if patch.fill)
            assert top == pytest.approx(list(lines.values())[rung].max())


@pytest.mark.parametrize("up", ["+x", "-x", "+y", "-y", "+z", "-z"])
def test_the_views_are_of_a_right_handed_world(up):
    right, down, above, name = plots.axes_of_world(up, [])
    assert name == up.replace("+", "") and plots.axis_name(above) == name
    assert numpy.cross(right, -down) @ above == 1 and numpy.cross(right, above) @ right == 0


def test_errors_of_frames(players, tmp_path, capsys):
    with fvv.open(players) as clip:
        meshes = [frame.mesh for frame in clip]
        moved = [(mesh.positions + (0.003 if i == 4 else 0), mesh.indices) for i, mesh in enumerate(meshes)]
        figure = plots.plot(clip, against=moved)
        axes = figure.axes[3]
        rms = axes.patches[1].get_data().values
        # 3 mm on each axis, seen along the normals of the surface.
        assert 1 < rms[4] < 5.2 and (numpy.delete(rms, 4) < 1e-3).all() and axes.get_ylabel() == "mm"
    path = tmp_path / "chart.png"
    assert run(capsys, "plot", FIELD, "--against", FIELD, "-o", path) == (0, "", "") and path.exists()
    code, _, err = run(capsys, "plot", FIELD, "--against", tmp_path / "none.fvv", "-o", tmp_path / "no.png")
    assert code in (1, 2) and "none.fvv" in err and not (tmp_path / "no.png").exists()


def test_plot_of_what_is_rare(damaged, tmp_path, capsys):
    for path, code in (
        (damaged, 3),
        (vector("calibration_moving"), 0),
        (vector("tiles_crops"), 0),
        (CONFORMANCE / "tiny/empty.fvv", 1),
    ):
        out = tmp_path / f"{path.parent.name}.png"
        found, _, err = run(capsys, "plot", path, "-o", out)
        assert found == code and out.exists() == (code != 1), err


def test_no_window_without_a_display(players, capsys, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "agg")
    code, _, err = run(capsys, "plot", players)
    assert code == 2 and "-o" in err


def test_without_matplotlib(players, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    code, _, err = run(capsys, "plot", players, "-o", tmp_path / "chart.png")
    assert code == 1 and "pip install fvv[plot]" in err


# Outputs.


def test_nothing_is_lost(tmp_path, capsys, monkeypatch):
    clip, chart = tmp_path / "clip.svg", tmp_path / "chart.svg"
    clip.write_bytes(FIELD.read_bytes())
    (tmp_path / "link.svg").symlink_to(clip)
    os.link(clip, tmp_path / "hard.svg")
    for name in ("clip.svg", "link.svg", "hard.svg"):
        for force in ([], ["--force"]):
            code, _, err = run(capsys, "plot", clip, "-o", tmp_path / name, *force)
            assert code == 2 and ("replaced" if force else "already exists; --force replaces it") in err
    chart.write_text("mine")
    assert run(capsys, "plot", clip, "-o", chart)[0] == 2
    (tmp_path / "folder.svg").mkdir()
    assert run(capsys, "plot", clip, "-o", tmp_path / "folder.svg", "-f")[0] == 2
    before = sorted(tmp_path.iterdir())

    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(outputs.os, "replace", full)
        code, _, err = run(capsys, "plot", clip, "-o", chart, "-f")
    assert code == 1 and "No space" in err and chart.read_text() == "mine"
    assert sorted(tmp_path.iterdir()) == before and clip.read_bytes() == FIELD.read_bytes()
    assert run(capsys, "plot", clip, "-o", chart, "-f")[0] == 0 and chart.read_text().startswith("<?xml")


# show.


def test_show(players, tmp_path):
    script = tmp_path / "player.js"
    script.write_text("// a player")
    program = [sys.executable, "-m", "fvv", "show", players, "--no-browser", "--player", script]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        url = process.stdout.readline().strip()
        assert urllib.request.urlopen(url, timeout=10).read().startswith(b"<!doctype html>")
        content = io.BytesIO(urllib.request.urlopen(f"{url}clip.fvv", timeout=10).read())
        assert len(fvv.open(content)) == 12
        process.send_signal(2)
        assert process.wait(10) == 0 and process.stderr.read() == ""
