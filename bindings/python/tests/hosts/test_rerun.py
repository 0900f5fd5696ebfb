"""A clip in Rerun, written by its SDK and read back. rerun-sdk asks for a newer numpy than tests/requirements.txt has: ./run test rerun
makes an environment for it."""

import collections
import io
import os
import pathlib
import re
import subprocess
import sys
import time

import fvv
import numpy
import pytest
from conftest import ROOT, tool
from fvv.interop.conventions import straightened

rerun = pytest.importorskip("rerun", reason="rerun-sdk is not installed here: ./run test rerun")
chunk = pytest.importorskip("rerun.chunk", reason="this rerun-sdk does not read recordings: ./run test rerun")
import PIL.Image  # noqa: E402  # rerun-sdk has it

EXECUTABLES = dict(
    re.findall(
        r'^(rerun-\w+-fvv) = "fvv\.interop\.rerun:(\w+)"$', (ROOT / "pyproject.toml").read_text(), re.M
    )
)


@pytest.fixture(scope="session")
def programs(tmp_path_factory):
    """A folder with what pip installs for [project.scripts]."""
    folder = tmp_path_factory.mktemp("bin")
    assert EXECUTABLES.keys() == {"rerun-importer-fvv", "rerun-loader-fvv"}
    for name, function in EXECUTABLES.items():
        text = f"#!{sys.executable}\nimport sys\nfrom fvv.interop.rerun import {function}\nsys.exit({function}())\n"
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    return folder


def recorded(programs, *arguments, name="rerun-importer-fvv", code=0):
    """What the executable writes, as a file, and what it says on standard error."""
    done = subprocess.run([programs / name, *map(str, arguments)], capture_output=True, timeout=300)
    assert done.returncode == code, done.stderr
    path = programs / "out.rrd"
    path.write_bytes(done.stdout)
    return path, done.stderr.decode()


def rows_of(path):
    """By entity: rows in order of their frame, each a dict of components; "frame" and "seconds" are times."""
    found = collections.defaultdict(list)
    for part in chunk.RrdReader(str(path)).stream():
        batch = part.to_record_batch()
        for i in range(batch.num_rows):
            row = {}
            for name in batch.schema.names:
                cell = batch.column(name)[i]
                if name == "frame":
                    row[name] = cell.as_py()
                elif name == "seconds":
                    row[name] = cell.value / 1e9
                elif ":" in name and cell.is_valid:
                    row[name] = cell.values
            found[part.entity_path].append(row)
    return {path: sorted(rows, key=lambda row: row.get("frame") or -1) for path, rows in found.items()}


def flat(values):
    while hasattr(values, "flatten") and hasattr(values, "type") and "list" in str(values.type):
        values = values.flatten()
    return values.to_numpy(zero_copy_only=False)


def picture(row):
    with PIL.Image.open(io.BytesIO(flat(row["EncodedImage:blob"]).tobytes())) as image:
        return numpy.asarray(image.convert("RGB"))


def test_a_recording_has_what_the_clip_has(players, programs):
    path, said = recorded(
        programs, players, "--application-id", "app", "--recording-id", "it", "--a-later-option", "1"
    )
    rows = rows_of(path)
    with fvv.open(players) as clip:
        meshes = rows["/players/mesh/1"]
        assert [row["frame"] for row in meshes] == list(range(12)) and not said
        for frame, row in zip(clip, meshes):
            mesh = frame.mesh
            assert row["seconds"] == pytest.approx(frame.time, abs=1e-9)
            assert (flat(row["Mesh3D:vertex_positions"]).reshape(-1, 3) == mesh.positions).all()
            assert (flat(row["Mesh3D:triangle_indices"]).reshape(-1, 3) == mesh.indices).all()
            colours = flat(row["Mesh3D:vertex_colors"]).astype(">u4").view("u1").reshape(-1, 4)
            assert (colours[:, :3] == mesh.colours).all() and (colours[:, 3] == 255).all()
        for camera in clip[0].cameras.values():
            (placed,) = rows[f"/players/cameras/{camera.name}"]
            axes = flat(placed["Transform3D:mat3x3"]).reshape(3, 3).T  # by columns
            centre = flat(placed["Transform3D:translation"])
            own = rows[f"/players/cameras/{camera.name}/picture"]
            intrinsics = [row for row in own if "Pinhole:image_from_camera" in row]
            assert [row["frame"] for row in intrinsics] == [0, 5, 10]  # the crop is that of a group
            pixels = [row for row in own if "EncodedImage:blob" in row]
            assert len(pixels) == 12
            for index in (0, 7, 11):
                sent, mesh = clip[index].pictures[camera.id], clip[index].mesh
                last = [row for row in intrinsics if row["frame"] <= index][-1]
                k = flat(last["Pinhole:image_from_camera"]).reshape(3, 3).T
                local = (mesh.positions - centre) @ axes
                at = (local / local[:, 2:]) @ k.T
                assert numpy.abs(at[:, :2] - sent.camera.project(mesh.positions)).max() < 0.01
                shown = picture(pixels[index])
                assert shown.shape == sent.pixels.shape
                assert numpy.abs(shown.astype(int) - sent.pixels).mean() < 5  # JPEG of small pictures


def test_the_video_is_there_undecoded(players, programs, tmp_path):
    """PyAV decodes the samples to the pictures of the clip."""
    av = pytest.importorskip("av", reason="PyAV is not installed here: ./run test rerun")
    path, _ = recorded(programs, players)
    rows = [row for row in rows_of(path)["/players/video/cameras"] if "VideoStream:sample" in row]
    assert [row["frame"] for row in rows] == list(range(12))
    decoder = av.CodecContext.create("h264", "r")
    frames = []
    for row in rows:
        frames += decoder.decode(av.Packet(flat(row["VideoStream:sample"]).tobytes()))
    frames += decoder.decode(None)
    assert len(frames) == 12
    with fvv.open(players) as clip:
        for index in (0, 7):
            film = frames[index].to_ndarray(format="rgb24").astype(int)
            (tile,) = [clip[index].pictures[0].pixels]
            height, width = tile.shape[:2]
            places = [
                (row, column)
                for row in range(0, film.shape[0] - height + 1, 2)
                for column in range(0, film.shape[1] - width + 1, 2)
                if numpy.abs(
                    film[row + height // 2, column + width // 2] - tile[height // 2, width // 2]
                ).max()
                < 9
            ]
            apart = [numpy.abs(film[r : r + height, c : c + width] - tile).mean() for r, c in places]
            assert min(apart) < 4


def test_visibility_is_colours(players, programs):
    path, _ = recorded(programs, players)
    assert "/players/visibility/1" not in rows_of(path)
    path, _ = recorded(programs, players, "--visibility")
    meshes = rows_of(path)["/players/visibility/1"]
    with fvv.open(players) as clip:
        for frame, row in zip(clip, meshes):
            colours = flat(row["Mesh3D:vertex_colors"]).astype(">u4").view("u1").reshape(-1, 4)[:, :3]
            seen = numpy.sum([frame.visibility(one) > 127 for one in frame.cameras], axis=0)
            assert (colours[seen == 3] == (253, 231, 37)).all() and (colours[seen == 0] == (68, 1, 84)).all()
            assert (seen == 3).any() and (seen == 0).any()
    assert len(meshes) == 12


def test_pictures_are_without_the_lens(tmp_path, programs):
    tool("fvvsynth", "-o", tmp_path / "capture", "--rig", "studio", "--frames", 2)
    stream = tmp_path / "studio.fvv"
    tool("fvvmux", tmp_path / "capture/capture.json", "-o", stream, "--quality", 15)
    path, _ = recorded(programs, stream)
    rows = rows_of(path)
    changed = []
    with fvv.open(stream) as clip:
        frame = clip[0]
        for identifier, sent in frame.pictures.items():
            camera = frame.cameras[identifier]
            own = rows[f"/studio/cameras/{camera.name}/picture"]
            if camera.lens == "none":
                continue
            k = (
                flat(next(r for r in own if "Pinhole:image_from_camera" in r)["Pinhole:image_from_camera"])
                .reshape(3, 3)
                .T
            )
            shown = picture(next(row for row in own if "EncodedImage:blob" in row))
            tile = sent.camera
            ideal = fvv.Camera(tile.id, k.astype(float), tile.R, tile.t, (tile.width, tile.height))
            _, places, inside = straightened(tile, ideal)
            expected = sent.pixels.reshape(-1, 3)[places]
            assert inside.mean() > 0.5 and numpy.abs(expected[inside].astype(int) - shown[inside]).mean() < 5
            moved = numpy.abs(places - numpy.arange(places.size).reshape(places.shape))[inside]
            changed.append((moved > 0).mean())
    assert len(changed) >= 2 and max(changed) > 0.1, changed


def reads(frame):
    try:
        return frame.mesh is not None
    except fvv.DamagedError:
        return False


def test_damage_is_a_text_log(players, tmp_path, programs):
    content = bytearray(players.read_bytes())
    with fvv.open(players) as clip:
        row = next(one for one in clip.chunks() if one["type"] == b"MESH" and one["group"] == 1)
        content[int(row["offset"]) + 32 + 40] ^= 1
    broken = tmp_path / "broken.fvv"
    broken.write_bytes(content)
    path, _ = recorded(programs, broken)
    rows = rows_of(path)
    texts = [row["TextLog:text"][0].as_py() for row in rows["/broken/damage"]]
    assert texts and all("MESH" in text and "CRC" in text for text in texts)
    assert {row["TextLog:level"][0].as_py() for row in rows["/broken/damage"]} == {"ERROR"}
    with fvv.open(broken) as clip:
        lost = [frame.number for frame in clip if not reads(frame)]
    meshes = rows["/broken/mesh/1"]
    assert lost and [row["frame"] for row in meshes if "Mesh3D:vertex_positions" in row] == [
        i for i in range(12) if i not in lost
    ]
    # Where a frame is lost the one before it is shown no more.
    assert lost[0] in [
        row["frame"]
        for row in meshes
        if "Mesh3D:vertex_positions" not in row or any("Clear" in n for n in row)
    ]


def test_the_viewer_opens_a_stream(players, programs, tmp_path):
    """As `rerun players.fvv` does, with a file in place of a window."""
    out = tmp_path / "viewer.rrd"
    settings = os.environ | {
        "PATH": f"{programs}:{pathlib.Path(sys.executable).parent}:{os.environ['PATH']}",
        "HOME": str(tmp_path),
        "DO_NOT_TRACK": "1",
    }
    done = subprocess.run(
        ["rerun", players, "--port", "0", "--save", out],
        capture_output=True,
        text=True,
        env=settings,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    rows = rows_of(out)
    # Once, though two executables are there.
    assert [row["frame"] for row in rows["/players/mesh/1"]] == list(range(12))


def test_other_files_are_left_to_others(players, tmp_path, programs):
    other = tmp_path / "other.fvv"
    other.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    for path in (other, tmp_path / "missing.fvv", tmp_path):
        written, said = recorded(programs, path, code=66)
        assert not written.read_bytes() and not said
    recorded(programs, players, "--recording-id", "it", name="rerun-loader-fvv", code=66)
    cut = tmp_path / "cut.fvv"
    cut.write_bytes(players.read_bytes()[:30])
    _, said = recorded(programs, cut, code=1)
    assert "cut.fvv" in said
    path, _ = recorded(programs, players, name="rerun-loader-fvv")
    assert len(rows_of(path)["/players/mesh/1"]) == 12


def test_into_a_recording_of_the_caller(players, tmp_path):
    recording = rerun.RecordingStream("app")
    recording.save(str(tmp_path / "own.rrd"))
    with fvv.open(players) as clip:
        begin = time.perf_counter()
        fvv.interop.rerun.log(clip, recording, prefix="a/b", frames=slice(2, 5), pictures=False)
        recording.flush()
        print(f"{3 / (time.perf_counter() - begin):.1f} frames per second without pictures")
    del recording
    rows = rows_of(tmp_path / "own.rrd")
    assert [row["frame"] for row in rows["/a/b/mesh/1"]] == [2, 3, 4]
    assert not any("picture" in entity for entity in rows)
