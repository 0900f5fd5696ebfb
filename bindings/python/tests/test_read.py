"""Clips and frames against fvvdemux and fvvinfo; sources, life times, memory and threads."""

import array
import dataclasses
import gc
import io
import json
import mmap
import os
import subprocess
import sys
import threading
import time
import tracemalloc
from fractions import Fraction

import fvv
import numpy
import pytest
from conftest import CONFORMANCE, ROOT, tool
from PIL import Image
from real_capture import read_ply
from vectors import path_of as vector

FIELD = vector("delta_field")


def same(a, b):
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


# Against the tools.


def test_meshes_are_those_of_fvvdemux(players, unpacked):
    with fvv.open(players) as clip:
        for frame in clip:
            positions, faces = read_ply(unpacked / f"meshes/{frame.number:04}.ply")
            mesh = frame.mesh
            metres = mesh.origin + mesh.step * mesh.lattice
            assert numpy.abs(positions - metres).max() < 1e-6 * mesh.step + 1e-7
            assert (faces == mesh.indices).all()


def test_pictures_are_those_of_fvvdemux(players, unpacked):
    with fvv.open(players) as clip:
        # Backwards and forwards: each order decodes the same.
        for frame in [clip[11], clip[3], *clip[4:9], clip[0]]:
            assert set(frame.pictures) == {0, 1, 2}
            for camera, picture in frame.pictures.items():
                expected = numpy.asarray(Image.open(unpacked / f"cam{camera}/{frame.number:04}.png"))
                assert same(picture.whole(), expected)
                x, y, width, height = picture.source
                if picture.pixels.shape[:2] == (height, width):
                    assert same(
                        numpy.ascontiguousarray(picture.pixels),
                        expected[y : y + height, x : x + width].copy(),
                    )


def test_what_fvvinfo_says(players):
    (file,) = json.loads(tool("fvvinfo", "--json", "--check", players))["files"]
    with fvv.open(players) as clip:
        assert len(clip) == file["frames"] == 12
        assert clip.time_base == Fraction(*file["scene"]["time_base"]) and clip.rate == 25
        assert clip.up == file["scene"]["up"] and clip.start == 0
        assert clip.duration == pytest.approx(12 / 25)
        assert [(t.id, t.kind, t.name) for t in clip.tracks] == [
            (t["track"], t["kind"], t["name"]) for t in file["tracks"]
        ]
        assert [(r.number, r.bit_rate, r.size, list(r.tracks)) for r in clip.rungs] == [
            (r["rung"], r["bit_rate"], r["size"], r["tracks"]) for r in file["rungs"]
        ]
        mesh = next(t for t in file["tracks"] if t["kind"] == "mesh")["mesh"]
        assert sum(frame.mesh.vertex_count for frame in clip) == mesh["vertices_sum"]
        assert sum(frame.mesh.face_count for frame in clip) == mesh["triangles_sum"]
        assert clip.problems == [] and isinstance(clip.metadata[0], dict)
    found = fvv.check(players)
    assert (found.frames, found.whole_frames, found.groups, found.chunks) == (
        file["frames"],
        file["whole_frames"],
        file["groups"],
        file["chunk_count"],
    )


def test_texturing(players):
    with fvv.open(players) as clip:  # which has no TEXR
        assert clip.texturing == fvv.Texturing("viewer", 0.05, 3, 0.0, (128, 128, 128))
    stream = CONFORMANCE / "cases/valid/patched_unseen/input.fvv"
    (file,) = json.loads(tool("fvvinfo", "--json", stream))["files"]
    with fvv.open(stream) as clip:
        found = json.loads(json.dumps(dataclasses.asdict(clip.texturing)))
    assert found == {key: file["texturing"][key] for key in found}


def test_rungs(players):
    with fvv.open(players) as best, fvv.open(players, rung=1) as small, fvv.open(players, rung=99) as last:
        assert small.rungs[1].scale == pytest.approx(best.rungs[0].scale / 2)
        sizes = [clip[6].pictures[0].whole().shape for clip in (best, small, last)]
        assert sizes == [(96, 160, 3), (48, 80, 3), (48, 80, 3)]
        assert [t.selected for t in best.tracks] != [t.selected for t in small.tracks]
    with pytest.raises(fvv.UsageError):
        fvv.open(players, rung=-1)


def test_sound_is_that_of_the_file(players, unpacked):
    import av

    with fvv.open(players) as clip:
        sounds = clip.audio
        assert sounds and clip.problems == []
        for sound in sounds:
            with av.open(str(unpacked / f"audio/{sound.track}.opus")) as file:
                packets = [bytes(packet) for packet in file.demux(audio=0) if packet.size]
            assert list(sound.packets) == packets
            samples = sound.samples()
            assert samples.shape[1] == sound.channels and samples.shape[0] == round(
                sound.duration * sound.rate
            )
            assert sound.start == 0 and sound.duration >= clip.duration
            assert numpy.abs(samples).max() > 0.001


# Frames by number and time.


def test_indexing(players):
    with fvv.open(players) as clip:
        assert [f.index for f in clip] == list(range(12)) == [f.number for f in clip]
        assert clip[-1].index == 11 and [f.index for f in clip[::5]] == [0, 5, 10]
        assert clip[3:3] == [] and [f.index for f in clip[-2:]] == [10, 11]
        for index in (12, -13, 10**30):
            with pytest.raises(
                IndexError, match=f"there is no frame {index}: the clip has 12 frames, 0 to 11, or -12 to -1"
            ):
                clip[index]
        with pytest.raises(TypeError):
            clip["1"]
        assert [f.time for f in clip[:3]] == [0, 0.04, 0.08]
        assert clip.at(0.1).index == 2 and clip.at(Fraction(1, 25)).index == 1 and clip.at(0.4799).index == 11
        for seconds in (-0.01, 0.48, 1e9):
            with pytest.raises(fvv.UsageError, match="the clip is from 0 s to before 0.48 s"):
                clip.at(seconds)
        for seconds in (float("nan"), float("inf"), "1.5x"):
            with pytest.raises(fvv.UsageError, match="expected seconds, a finite number"):
                clip.at(seconds)
    empty = ROOT / "conformance/tiny/empty.fvv"
    with fvv.open(empty) as clip, pytest.raises(IndexError, match="there is no frame 0: the clip has none"):
        clip[0]


# Cameras.


def test_cameras(players):
    with fvv.open(players) as clip:
        frame = clip[0]
        assert list(frame.cameras) == [0, 1, 2] and len(frame.cameras) == 3
        for identifier, camera in frame.cameras.items():
            assert (
                frame.cameras[camera.name] is camera is frame.cameras[identifier] and camera.id == identifier
            )
        with pytest.raises(KeyError):
            frame.cameras["nothing"]
        with pytest.raises(KeyError):
            frame.cameras[77]
        assert 77 not in frame.cameras and 1 in frame.pictures


def test_projection(players):
    with fvv.open(players) as clip:
        frame = clip[0]
        camera, points = frame.cameras[1], frame.mesh.positions.astype(float)
        local = points @ camera.R.T + camera.t
        assert camera.lens == "none"
        expected = (local / local[:, 2:]) @ camera.K.T
        pixels = camera.project(points)
        assert numpy.abs(pixels - expected[:, :2]).max() < 1e-8
        assert numpy.abs(camera.depth(points) - local[:, 2]).max() < 1e-12
        assert numpy.abs(camera.unproject(pixels, camera.depth(points)) - points).max() < 1e-9
        origin, directions = camera.ray(pixels)
        assert numpy.abs(origin - camera.centre).max() < 1e-12 and camera.centre == pytest.approx(
            -camera.R.T @ camera.t
        )
        assert numpy.abs(numpy.linalg.norm(directions, axis=1) - 1).max() < 1e-12
        towards = points - origin
        assert numpy.abs(numpy.cross(directions, towards)).max() < 1e-9
        # Any leading axes, a single point, a list, one depth for all.
        assert camera.project(points[:6].reshape(2, 3, 3)).shape == (2, 3, 2)
        assert camera.project(points[0]).shape == (2,) and camera.depth(points[0]).shape == ()
        assert same(camera.project(points[:2].tolist()), pixels[:2])
        assert camera.depth(camera.unproject(pixels[:4], 2.5)) == pytest.approx(2.5)
        behind = camera.centre - camera.R[2]
        assert numpy.isnan(camera.project(behind)).all() and camera.depth(behind) == pytest.approx(-1)
        for wrong in (points[:, :2], 3.0):
            with pytest.raises(fvv.UsageError):
                camera.project(wrong)
        with pytest.raises(fvv.UsageError):
            camera.unproject(pixels[:3], [1.0, 2.0])


def test_the_camera_of_a_picture_projects_into_its_pixels(players):
    with fvv.open(players) as clip:
        frame = clip[0]
        for identifier, picture in frame.pictures.items():
            x, y, width, height = picture.source
            rows, columns = picture.pixels.shape[:2]
            assert (picture.camera.width, picture.camera.height) == (columns, rows)
            whole = frame.cameras[identifier].project(frame.mesh.positions)
            own = picture.camera.project(frame.mesh.positions)
            assert numpy.abs((whole - [x, y]) * [columns / width, rows / height] - own).max() < 1e-8


# Sources.


class Ranges:
    """An object with read_at, as a client of a storage service is."""

    def __init__(self, content):
        self.content, self.size, self.read = content, len(content), 0

    def read_at(self, offset, size):
        assert size and offset + size <= self.size
        self.read += size
        return memoryview(self.content)[offset : offset + size]


def test_sources_give_the_same(players, tmp_path):
    content = players.read_bytes()

    def taste(source):
        with fvv.open(source) as clip:
            return [(f.ticks, f.mesh.positions.tobytes(), f.pictures[1].pixels.tobytes()) for f in clip[::4]]

    expected = taste(players)
    assert taste(str(players)) == taste(content) == taste(bytearray(content)) == expected
    assert (
        taste(memoryview(content))
        == taste(array.array("B", content))
        == taste(io.BytesIO(content))
        == expected
    )
    ranges = Ranges(content)
    assert taste(ranges) == expected and ranges.read
    with open(players, "rb") as file:
        assert taste(file) == expected
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
            assert taste(mapped) == expected
    odd = tmp_path / "k\N{LATIN SMALL LETTER O WITH DIAERESIS}nig.fvv"
    odd.write_bytes(content)
    assert taste(odd) == expected


def test_only_what_is_needed_is_read(players):
    ranges = Ranges(players.read_bytes())
    with fvv.open(ranges) as clip:
        assert clip[0].mesh.vertex_count and ranges.read < ranges.size / 2


def test_sources_that_cannot_be_read(tmp_path):
    with pytest.raises(FileNotFoundError):
        fvv.open(tmp_path / "missing.fvv")
    with pytest.raises(fvv.UsageError):
        fvv.open(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(fvv.UsageError):
        fvv.open(tmp_path / "pipe")
    for wrong in (3, None, object(), ["x"]):
        with pytest.raises(TypeError):
            fvv.open(wrong)
    with pytest.raises(BufferError):
        fvv.open(memoryview(bytes(100))[::2])


class Failing(Ranges):
    def __init__(self, content, how, after):
        super().__init__(content)
        self.how, self.left = how, after

    def read_at(self, offset, size):
        self.left -= 1
        return self.how(super().read_at(offset, size)) if self.left < 0 else super().read_at(offset, size)


def raises_key_error(_):
    raise KeyError("as it was raised")


@pytest.mark.parametrize("after", [0, 1, 2, 3, 5, 8])
@pytest.mark.parametrize(
    "how, error",
    [(raises_key_error, KeyError), (lambda part: part[:-1], OSError), (lambda part: "text", TypeError)],
    ids=["raises", "short", "text"],
)
def test_errors_of_read_at_arrive(players, how, error, after):
    source = Failing(players.read_bytes(), how, after)
    with pytest.raises(error), fvv.open(source) as clip:
        for frame in clip:
            frame.mesh.positions.sum()


def test_read_at_may_not_use_its_clip(players):
    class Reentrant(Ranges):
        clip = None

        def read_at(self, offset, size):
            if self.clip is not None:
                self.clip[0].mesh  # noqa: B018
            return super().read_at(offset, size)

    source = Reentrant(players.read_bytes())
    with fvv.open(source) as clip:
        source.clip = clip
        with pytest.raises(fvv.UsageError):
            clip[3].mesh  # noqa: B018
        source.clip = None
        assert clip[3].mesh.vertex_count


# Life times.


def test_use_after_close(players):
    clip = fvv.open(players)
    frame, unused = clip[5], clip[6]
    positions, pixels, camera = frame.mesh.positions, frame.pictures[1].pixels, frame.cameras[2]
    copies = positions.copy(), pixels.copy()
    mesh = frame.mesh
    clip.close()
    clip.close()
    del frame
    gc.collect()
    assert same(positions, copies[0]) and same(pixels.copy(), copies[1])
    assert mesh.normals.shape == positions.shape and camera.project(positions).shape[1] == 2
    assert clip.closed and "closed" in repr(clip)
    calls = [
        lambda: clip[0],
        lambda: next(iter(clip)),
        lambda: clip.at(0.1),
        lambda: unused.mesh,
        lambda: unused.time,
        lambda: unused.pictures,
        lambda: unused.cameras,
        lambda: clip.audio,
        lambda: clip.problems,
        lambda: clip.tracks,
        lambda: clip.duration,
        clip.__enter__,
    ]
    for call in calls:
        with pytest.raises(fvv.UsageError, match="closed"):
            call()


def test_arrays_are_read_only_views(players):
    with fvv.open(players) as clip:
        frame = clip[0]
        mesh, camera = frame.mesh, frame.cameras[0]
        arrays = [mesh.positions, mesh.lattice, mesh.indices, mesh.normals, mesh.colours, mesh.origin,
                  frame.pictures[0].pixels, frame.visibility(0), camera.K, camera.R, camera.t, camera.centre,
                  camera.distortion]  # fmt: skip
        for one in arrays:
            assert not one.flags.writeable
            with pytest.raises(ValueError):
                one[...] = 0
            if not one.flags.owndata:
                with pytest.raises(ValueError):
                    one.flags.writeable = True
        # Two views of one memory, no copies.
        for name in ("positions", "lattice", "indices", "normals", "colours"):
            assert numpy.shares_memory(getattr(mesh, name), getattr(frame.mesh, name))
        assert numpy.shares_memory(frame.pictures[0].pixels, numpy.asarray(frame.pictures[0]))
        assert numpy.asarray(frame.pictures[0], dtype=float).dtype == float
        assert mesh.uvs is None and frame.atlas is None


def test_200_times_open_and_close_leak_nothing(players):
    program = [sys.executable, ROOT / "bindings/python/tests/open_close.py", players]
    done = subprocess.run(program, capture_output=True, text=True, env=os.environ | {"MALLOC_ARENA_MAX": "1"})
    assert done.returncode == 0, done.stderr
    # A clip that leaked its mesh would leave 200 MB.
    assert int(done.stdout) < 4 << 20


def test_python_allocates_little(players):
    with fvv.open(players) as clip:
        clip[0].mesh.positions  # noqa: B018
        gc.collect()
        tracemalloc.start()
        size = 0
        for frame in clip:
            mesh = frame.mesh
            size += mesh.positions.nbytes + mesh.lattice.nbytes + mesh.indices.nbytes
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
    # numpy reports memory of its own arrays to tracemalloc: none of them was copied.
    assert peak < 200_000 < size


# Threads.


def digest(clip):
    return [(f.mesh.positions.tobytes(), f.pictures[1].pixels.tobytes()) for f in clip]


def test_two_threads_read_two_clips(players):
    with fvv.open(players) as clip:
        expected = digest(clip)
    found = {}

    def read(name):
        with fvv.open(players) as clip:
            found[name] = digest(clip)

    begin = time.perf_counter()
    read("alone")
    alone = time.perf_counter() - begin
    threads = [threading.Thread(target=read, args=(i,)) for i in range(2)]
    begin = time.perf_counter()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    print(f"one clip in one thread {alone:.3f} s, two in two threads {time.perf_counter() - begin:.3f} s")
    assert all(one == expected for one in found.values()) and len(found) == 3


def test_threads_share_a_clip_and_may_close_it(players):
    content = players.read_bytes()
    with fvv.open(players) as clip:
        expected = digest(clip)
    for source in (content, Ranges(content)):
        clip = fvv.open(source)
        failures = []

        def work(start, shared=clip, failed=failures):
            try:
                for i in range(start, start + 12):
                    frame = shared[i % 12]
                    got = (frame.mesh.positions.tobytes(), frame.pictures[1].pixels.tobytes())
                    if got != expected[i % 12]:
                        failed.append(i)
            except fvv.UsageError as error:
                if not shared.closed:
                    failed.append(error)

        threads = [threading.Thread(target=work, args=(5 * i,)) for i in range(3)]
        for thread in threads:
            thread.start()
        threads[0].join()
        clip.close()
        for thread in threads:
            thread.join()
        assert failures == []


# Around it.


def test_types():
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--cache-dir", os.devnull,
         ROOT / "bindings/python/fvv", ROOT / "bindings/python/fvv_capture", ROOT / "bindings/python/tests/typed_use.py"],
        capture_output=True, text=True, cwd=ROOT / "bindings/python",
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def test_types_by_pyright():
    program = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable]
    done = subprocess.run(program, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_stub_names_what_the_module_has():
    import ast

    tree = ast.parse((ROOT / "bindings/python/fvv/_core.pyi").read_text())
    stub = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    core = fvv._core
    assert {name for name in dir(core) if not name.startswith("__")} == stub.keys() | {"library_version"}
    for name, node in stub.items():
        if isinstance(node, ast.ClassDef):
            own = {n for n in vars(getattr(core, name)) if not n.startswith("_")}
            assert own == {
                m.name for m in node.body if isinstance(m, ast.FunctionDef) and not m.name.startswith("_")
            }
