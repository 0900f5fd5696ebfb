"""The command line of fvvcompare: what it prints, in which form, and its exit codes."""

import csv
import json

import numpy as np
import pytest
from conftest import TINY, Tool, read_json

CELLS = 12


@pytest.fixture(scope="module")
def fvvcompare():
    return Tool("fvvcompare")


def write_capture(folder, heights, **changes):
    """A capture of a square of side 1 in z = height, one frame for each height."""
    folder.mkdir()
    side = np.linspace(0, 1, CELLS + 1)
    for number, height in enumerate(heights):
        lines = [f"v {x} {y} {height}" for y in side for x in side]
        for y in range(CELLS):
            for x in range(CELLS):
                a = y * (CELLS + 1) + x + 1
                lines.append(f"f {a} {a + 1} {a + CELLS + 2} {a + CELLS + 1}")
        (folder / f"{number:04d}.obj").write_text("\n".join(lines) + "\n")
    document = {
        "fvv_capture": 1,
        "frame_rate": 25,
        "frames": {"first": 0, "count": len(heights)},
        "units": "metres",
        "meshes": {"pattern": "%04d.obj"},
        **changes,
    }
    (folder / "capture.json").write_text(json.dumps(document))
    return folder


@pytest.fixture(scope="module")
def planes(tmp_path_factory):
    """Two captures of three frames that are 1, 2 and 3 mm apart."""
    root = tmp_path_factory.mktemp("planes")
    return write_capture(root / "a", [0, 0, 0]), write_capture(root / "b", [0.001, 0.002, 0.003])


def test_text_has_the_figures_and_their_settings(fvvcompare, planes):
    done = fvvcompare(*planes, "--samples", 1000)
    assert (done.returncode, done.stderr) == (0, b"")
    text = done.stdout.decode()
    assert "3 frames compared, 1000 samples of each surface, D1 and D2 at vertices" in text
    assert "peak of PSNR: 1414.2136 mm (diagonal of A's bounding box)" in text
    rows = {line[:26].strip(): line[26:].split() for line in text.splitlines() if line.startswith("  ")}
    assert rows["distance, rms"] == ["2.1602", "mm"] * 3  # the root of (1 + 4 + 9) / 3
    assert rows["distance, Hausdorff"] == ["3.0000", "mm"] * 3
    psnr = 10 * np.log10(2 / ((1 + 4 + 9) / 3 * 1e-6))
    assert rows["D1 PSNR, point to point"] == [f"{psnr:.2f}", "dB"] * 3
    assert "temporal: rms 1.0000 mm, max 1.0000 mm in 2 pairs of frames" in text


def test_json_and_csv_have_every_frame(fvvcompare, planes, tmp_path):
    table = tmp_path / "out.csv"
    done = fvvcompare(*planes, "--json", "--csv", table, "--peak", 0.5)
    assert done.returncode == 0, done.stderr
    document = read_json(done, "fvvcompare")
    assert (document["peak"], document["peak_is"], document["unit"]) == (0.5, "given", "metres")
    assert document["distance"]["symmetric"]["rms"] == pytest.approx(np.sqrt(14 / 3) * 1e-3)
    assert document["temporal"]["rms"] == pytest.approx(1e-3)
    with open(table, newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(document["frames"]) == 3
    for number, (row, frame) in enumerate(zip(rows, document["frames"])):
        assert int(row["frame_a"]) == frame["a"]["frame"] == number
        height = (number + 1) * 1e-3
        assert float(row["symmetric_rms"]) == frame["distance"]["symmetric"]["rms"]
        assert frame["distance"]["symmetric"]["rms"] == pytest.approx(height)
        psnr = 10 * np.log10(0.25 / height**2)
        assert float(row["a_to_b_d2_psnr"]) == pytest.approx(psnr)
        assert frame["d2"]["a_to_b"]["psnr"] == pytest.approx(psnr)
    assert [row["temporal_rms"] == "" for row in rows] == [True, False, False]
    assert fvvcompare(*planes, "--csv", table).returncode == 1, "an existing file is not replaced"
    assert fvvcompare(*planes, "--csv", table, "--force").returncode == 0


def test_equal_sequences_have_no_psnr(fvvcompare, planes):
    done = fvvcompare(planes[0], planes[0], "--json")
    document = read_json(done, "fvvcompare")
    assert done.returncode == 0
    assert document["d1"]["symmetric"] == {"mse": 0, "psnr": None}
    assert b"equal" in fvvcompare(planes[0], planes[0]).stdout


def test_the_same_bytes_for_any_number_of_threads(fvvcompare, planes):
    first = fvvcompare(*planes, "--json", "--threads", 1).stdout
    assert first == fvvcompare(*planes, "--json", "--threads", 4).stdout


def test_bounds_make_it_fail(fvvcompare, planes):
    assert fvvcompare(*planes, "--max-rms", 0.0022, "--max-distance", 0.0031).returncode == 0
    done = fvvcompare(*planes, "--max-rms", 0.0021)
    assert done.returncode == 1
    assert done.stderr.startswith(b"fvvcompare: symmetric rms distance is 0.00216")
    assert done.stdout, "the figures are printed anyway"
    done = fvvcompare(*planes, "--max-distance", 0.0029)
    assert (done.returncode, done.stderr.count(b"\n")) == (1, 1)
    assert b"Hausdorff distance is 0.003" in done.stderr


def test_frames_without_a_partner_give_exit_code_3(fvvcompare, planes, tmp_path):
    shorter = write_capture(tmp_path / "shorter", [0.001, 0.002])
    done = fvvcompare(planes[0], shorter)
    assert done.returncode == 3
    assert b"1 of 3 frames has no partner: 2" in done.stderr
    assert b"2 frames compared" in done.stdout
    assert fvvcompare(planes[0], shorter, "--frames", "0-1").returncode == 0
    (shorter / "0001.obj").unlink()
    done = fvvcompare(planes[0], shorter, "--frames", "0-1", "--json")
    assert done.returncode == 3
    assert b"0001.obj: cannot be opened" in done.stderr
    assert len(read_json(done, "fvvcompare")["losses"]) == 1


@pytest.fixture(scope="module")
def stream(fvvmux, planes, tmp_path_factory):
    """The second capture as a stream of three groups with a frame each."""
    path = tmp_path_factory.mktemp("stream") / "planes.fvv"
    done = fvvmux(planes[1], "-o", path, "--step", "1mm", "--keep-geometry", "--group", 1)
    assert done.returncode == 0, done.stderr
    return path


def test_a_cut_stream_is_compared_as_far_as_it_goes(fvvcompare, planes, stream, tmp_path):
    whole = fvvcompare(planes[1], stream, "--max-distance", 1e-3)
    assert (whole.returncode, whole.stderr) == (0, b"")
    cut = tmp_path / "cut.fvv"
    cut.write_bytes(stream.read_bytes()[:-500])  # into the third group
    done = fvvcompare(planes[1], cut, "--json")
    assert done.returncode == 3
    assert [frame["b"]["frame"] for frame in read_json(done, "fvvcompare")["frames"]] == [0, 1]
    assert b"the stream ends inside a chunk" in done.stderr
    assert b"1 of 3 frames has no partner: 2" in done.stderr


def test_a_damaged_mesh_is_reported_and_shifts_nothing(fvvcompare, planes, stream, tmp_path):
    original = stream.read_bytes()
    # Tables name the type too; the chunk comes first in each group.
    groups = [i for i in range(0, len(original), 8) if original[i : i + 4] == b"GRUP"][:3]
    headers = [original.index(b"MESH", group) for group in groups]
    for number in range(3):
        damaged = bytearray(original)
        damaged[headers[number] + 60] ^= 1
        path = tmp_path / f"{number}.fvv"
        path.write_bytes(damaged)
        done = fvvcompare(planes[1], path, "--json", "--max-distance", 1e-3)
        assert done.returncode == 3
        assert b"CRC of the payload does not match" in done.stderr
        frames = [frame["b"]["frame"] for frame in read_json(done, "fvvcompare")["frames"]]
        assert frames == [n for n in range(3) if n != number]


def test_a_stream_without_its_beginning_keeps_its_times(fvvcompare, planes, stream, tmp_path):
    original = stream.read_bytes()
    groups = [i for i in range(0, len(original), 8) if original[i : i + 4] == b"GRUP"]
    path = tmp_path / "rest.fvv"
    path.write_bytes(original[: groups[0]] + original[groups[1] :])
    done = fvvcompare(planes[1], path, "--json", "--max-distance", 1e-3)
    assert done.returncode == 3
    assert b"frames are numbered from tick 0" in done.stderr
    assert [frame["a"]["frame"] for frame in read_json(done, "fvvcompare")["frames"]] == [1, 2]


@pytest.mark.parametrize(
    "arguments, expected",
    [
        (["--frames", "2-1"], b"--frames: expected a number or two such as 10-19"),
        (["--frames", "1-"], b"--frames: expected a number or two such as 10-19"),
        (["--frames", "0-7"], b"--frames: expected a frame of"),
        (["--json", "--csv", "-"], b"--json: standard output is taken"),
        (["--samples", "0"], b"--samples"),
        (["--peak", "-1"], b"--peak"),
        (["--points", "none"], b"--points"),
    ],
)
def test_usage(fvvcompare, planes, arguments, expected):
    done = fvvcompare(*planes, *arguments)
    assert done.returncode == 2
    assert expected in done.stderr
    assert done.stdout == b""


def test_files_that_are_not_sequences(fvvcompare, planes, tmp_path):
    junk = tmp_path / "junk.fvv"
    junk.write_bytes(b"no stream")
    for other in junk, tmp_path / "absent.fvv", tmp_path, *sorted(TINY.glob("empty.fvv")):
        done = fvvcompare(planes[0], other)
        assert done.returncode == 1
        assert str(other).encode() in done.stderr
        assert done.stderr.count(b"\n") == 1
