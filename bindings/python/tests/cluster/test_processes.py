"""Clips and what they hold in several processes: pickled, forked, spawned, in the manner of PyTorch's DataLoader and of Dask."""

import array
import concurrent.futures
import copy
import functools
import gzip
import io
import mmap
import multiprocessing
import os
import pickle
import shutil
import signal
import subprocess
import sys
import threading

import fvv
import numpy
import pytest
from conftest import VECTORS

CONTEXTS = [
    name for name in ("fork", "spawn", "forkserver") if name in multiprocessing.get_all_start_methods()
]
PROTOCOLS = range(2, pickle.HIGHEST_PROTOCOL + 1)
SECONDS = 60  # longer than any worker here takes


def again(value, protocol=pickle.HIGHEST_PROTOCOL):
    return pickle.loads(pickle.dumps(value, protocol))


def parts_of_mesh(mesh):
    arrays = (mesh.positions, mesh.lattice, mesh.indices, mesh.normals, mesh.uvs, mesh.colours, mesh.origin)
    return (
        mesh.track,
        mesh.step,
        mesh.has_normals,
        [None if a is None else (a.dtype, a.shape, a.tobytes()) for a in arrays],
    )


def parts_of_camera(camera):
    arrays = (camera.K, camera.R, camera.t, camera.distortion)
    plain = (camera.id, camera.name, camera.width, camera.height, camera.lens, camera.r_max, camera.moves)
    return (plain, [a.tobytes() for a in arrays])


def parts_of_picture(picture):
    camera = None if picture.camera is None else parts_of_camera(picture.camera)
    whole = picture.whole()
    return (
        picture.source,
        picture.pixels.dtype,
        picture.pixels.tobytes(),
        whole.shape,
        whole.tobytes(),
        camera,
    )


def pictures_of(frame):
    return [*frame.pictures.values(), *([] if frame.atlas is None else [frame.atlas])]


def parts_of_frame(frame):
    """Everything of a frame, as bytes that compare."""
    return (
        frame.ticks,
        [parts_of_mesh(mesh) for mesh in frame.meshes.values()],
        [parts_of_camera(camera) for camera in frame.cameras.values()],
        [parts_of_picture(picture) for picture in pictures_of(frame)],
    )


@pytest.mark.parametrize("path", VECTORS, ids=lambda path: path.parent.name)
def test_values_of_every_vector_pickle(path):
    with fvv.open(path) as clip:
        for frame in clip[:4]:
            try:
                pictures = pictures_of(frame)
            except fvv.DamagedError as error:
                assert "JPEG" in str(error)  # vectors about other things have a sample that is none
                pictures = []
            for values, parts in (
                (frame.meshes.values(), parts_of_mesh),
                (frame.cameras.values(), parts_of_camera),
                (pictures, parts_of_picture),
            ):
                for value in values:
                    assert (
                        parts(again(value))
                        == parts(value)
                        == parts(copy.copy(value))
                        == parts(copy.deepcopy(value))
                    )


@pytest.mark.parametrize("protocol", PROTOCOLS)
def test_protocols(players, protocol):
    with fvv.open(players) as clip:
        frame = clip[3]
        assert (
            parts_of_frame(again(clip, protocol)[3])
            == parts_of_frame(again(frame, protocol))
            == parts_of_frame(frame)
        )
        assert parts_of_mesh(again(frame.mesh, protocol)) == parts_of_mesh(frame.mesh)


def test_a_picture_takes_its_own_pixels_along_and_a_mesh_shares_its_memory(players):
    with fvv.open(players) as clip:
        picture, mesh = clip[0].pictures[1], clip[0].mesh
        assert len(pickle.dumps(picture)) < picture.pixels.nbytes + 2000
        buffers = []
        small = pickle.dumps(mesh, 5, buffer_callback=buffers.append)
        assert len(small) < 2000 and len(buffers) >= 2
        assert parts_of_mesh(pickle.loads(small, buffers=buffers)) == parts_of_mesh(mesh)


def test_what_is_no_state_is_refused(players):
    with fvv.open(players) as clip:
        mesh = clip[0].mesh
    state = list(mesh.__getstate__())
    faces = numpy.array(state[4])
    faces[5, 1] = mesh.vertex_count
    lattice = numpy.array(state[3])
    lattice[3, 2] = 1 << 29
    wrong = [
        (*state[:4], faces, *state[5:]),
        (*state[:3], lattice, *state[4:]),
        (*state[:3], lattice[:, :2], *state[4:]),
        (*state[:9], numpy.zeros((2, 3), "u1")),
        (*state[:3], numpy.zeros((0, 3), "i4"), *state[4:9], None),
        tuple(state[:9]),
    ]
    for one in wrong:
        with pytest.raises(fvv.UsageError):
            fvv.Mesh.__new__(fvv.Mesh).__setstate__(one)


# A clip is its path.


def test_a_pickled_clip_is_its_path(players, tmp_path, monkeypatch):
    path = tmp_path / "here.fvv"
    shutil.copy(players, path)
    monkeypatch.chdir(tmp_path)
    with fvv.open("here.fvv", rung=1, limits=fvv.Limits(max_faces=100_000)) as clip:
        kept = pickle.dumps(clip)
        expected = parts_of_frame(clip[7])
        assert len(kept) < 1000
    monkeypatch.chdir("/")
    with pickle.loads(kept) as clip:
        assert clip.rung == 1 and parts_of_frame(clip[7]) == expected
    with open(path, "ab") as file:
        file.write(bytes(8))
    with pytest.raises(fvv.UsageError, match="bytes here, expected"):
        pickle.loads(kept)
    path.unlink()
    with pytest.raises(FileNotFoundError):
        pickle.loads(kept)
    with pytest.raises(fvv.UsageError, match="closed"):
        pickle.dumps(clip)


class Ranges:
    """A client of a storage service that can be pickled."""

    def __init__(self, path):
        self.path = path
        self.size = os.path.getsize(path)

    def read_at(self, offset, size):
        with open(self.path, "rb") as file:
            return os.pread(file.fileno(), size, offset)


class Connection(Ranges):
    """One that cannot."""

    def __init__(self, path):
        super().__init__(path)
        self.lock = threading.Lock()


def test_what_else_pickles_and_what_does_not(players):
    content = players.read_bytes()
    with fvv.open(players) as clip:
        expected = parts_of_frame(clip[2])
    with open(players, "rb") as file, open(players, "rb", buffering=0) as raw:
        for source in (content, bytearray(content), array.array("B", content), numpy.frombuffer(content, "u1"), io.BytesIO(content),
                       Ranges(players), file, raw):  # fmt: skip
            with fvv.open(source) as clip, again(clip) as other:
                assert parts_of_frame(other[2]) == expected
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
            for source in (mapped, memoryview(content), Connection(players)):
                with fvv.open(source) as clip, pytest.raises(fvv.UsageError, match="Open it by its path"):
                    pickle.dumps(clip)


def test_a_compressed_file_is_not_taken_for_its_path(players, tmp_path):
    packed = tmp_path / "players.fvv.gz"
    with gzip.open(packed, "wb") as file:
        file.write(players.read_bytes())
    with gzip.open(packed) as file, fvv.open(file) as clip:
        assert clip[2].mesh.vertex_count
        with pytest.raises(fvv.UsageError, match="players.fvv.gz: a clip of this GzipFile cannot be pickled"):
            pickle.dumps(clip)


# Workers, as those of PyTorch's DataLoader: each is given the data set and then indices.


class Surfaces:
    """A map-style data set: what torch.utils.data.Dataset asks for."""

    def __init__(self, path):
        self.clip = fvv.open(path)

    def __len__(self):
        return len(self.clip)

    def __getitem__(self, index):
        frame = self.clip[index]
        return parts_of_frame(frame)


def work(dataset, indices, results):
    for index in iter(indices.get, None):
        try:
            results.put((index, dataset[index]))
        except Exception as error:
            results.put((index, error))


def loaded(dataset, context, workers=2):
    """Each sample, from processes that share the data set."""
    context = multiprocessing.get_context(context)
    indices, results = context.Queue(), context.Queue()
    processes = [context.Process(target=work, args=(dataset, indices, results)) for _ in range(workers)]
    for process in processes:
        process.start()
    for index in range(len(dataset)):
        indices.put(index)
    found = dict(results.get(timeout=SECONDS) for _ in range(len(dataset)))
    for _ in processes:
        indices.put(None)
    for process in processes:
        process.join(SECONDS)
        assert process.exitcode == 0
    return [found[index] for index in range(len(dataset))]


@pytest.mark.parametrize("context", CONTEXTS)
def test_a_data_set_in_workers(players, context):
    dataset = Surfaces(players)
    expected = [
        dataset[index] for index in range(len(dataset))
    ]  # decoders and their threads are at work before the fork
    assert loaded(dataset, context) == expected
    assert [dataset[index] for index in range(len(dataset))] == expected
    dataset.clip.close()


class Shared(Surfaces):
    """Of any source."""

    def __init__(self, source):
        self.clip = fvv.open(source)


@pytest.mark.skipif("fork" not in CONTEXTS, reason="this system has no fork")
def test_sources_after_a_fork(players):
    content = players.read_bytes()
    with fvv.open(players) as clip:
        expected = [parts_of_frame(frame) for frame in clip]
    with open(players, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as mapped:
        # By its path, which the file object has; memory is each process's own.
        for source in (file, content, mapped, io.BytesIO(content), Ranges(players)):
            dataset = Shared(source)
            assert loaded(dataset, "fork") == expected, source
            dataset.clip.close()
    # A position or a connection would be shared: an error, and not damage.
    with gzip.GzipFile(fileobj=io.BytesIO(gzip.compress(content, 1))) as unpacked:
        for source in (Connection(players), unpacked):
            dataset = Shared(source)
            for error in loaded(dataset, "fork"):
                assert isinstance(error, fvv.UsageError) and "shared by processes after a fork" in str(
                    error
                ), error
            assert dataset[5] == expected[5]


def in_child(work):
    """What a forked process exits with: 0 when work() is true."""
    child = os.fork()
    if not child:
        signal.alarm(SECONDS)  # a lock that nothing releases ends it
        code = 1
        try:
            code = 0 if work() else 2
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


@pytest.mark.skipif("fork" not in CONTEXTS, reason="this system has no fork")
def test_a_fork_while_threads_read(players):
    clip = fvv.open(players)
    expected = [parts_of_frame(frame) for frame in clip]
    done = threading.Event()

    def read():
        while not done.is_set():
            for frame in clip:
                parts_of_frame(frame)

    threads = [threading.Thread(target=read) for _ in range(2)]
    for thread in threads:
        thread.start()
    try:
        for _ in range(5):
            assert in_child(lambda: [parts_of_frame(frame) for frame in clip] == expected) == 0
    finally:
        done.set()
        for thread in threads:
            thread.join()
    frame = clip[4]
    assert in_child(lambda: parts_of_frame(frame) == expected[4]) == 0
    clip.close()
    assert in_child(lambda: clip.closed) == 0


@pytest.mark.skipif("fork" not in CONTEXTS, reason="this system has no fork")
def test_a_child_closes_its_own(players, tmp_path):
    path = tmp_path / "players.fvv"
    shutil.copy(players, path)
    clip = fvv.open(path)
    expected = parts_of_frame(clip[8])
    clip.show(inline=False, player=__file__)

    def close():
        clip.close()
        with pytest.raises(fvv.UsageError, match="closed"):
            clip[0].mesh  # noqa: B018
        return clip.closed

    assert in_child(close) == 0 and parts_of_frame(clip[8]) == expected
    shutil.copy(players, tmp_path / "other.fvv")
    os.replace(tmp_path / "other.fvv", path)

    def refused():
        with pytest.raises(fvv.UsageError, match="was replaced"):
            clip[0].mesh  # noqa: B018
        return True

    assert in_child(refused) == 0 and parts_of_frame(clip[8]) == expected
    clip.close()


@pytest.mark.skipif("fork" not in CONTEXTS, reason="this system has no fork")
def test_a_writer_stays_with_its_process(players, tmp_path):
    with fvv.open(players) as clip:
        mesh = clip[0].mesh
    writer = fvv.Writer(tmp_path / "out.fvv", rate=25)
    writer.add(mesh)

    def refused():
        with pytest.raises(fvv.UsageError, match="belongs to the process"):
            writer.add(mesh)
        writer.close()
        writer.__del__()
        return True

    assert in_child(refused) == 0
    writer.add(mesh)
    assert writer.finish()["frames"] == 2


@pytest.mark.skipif("fork" not in CONTEXTS, reason="this system has no fork")
def test_an_interpreter_that_was_forked_ends(players):
    """With everything that it inherited being collected."""
    program = """
import os, sys
import fvv
clip = fvv.open(sys.argv[1])
writer = fvv.Writer(sys.argv[2], rate=25)
for frame in clip:
    frame.pictures[0].pixels
    writer.add(frame.mesh)
child = os.fork()
if child:
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    writer.finish()
    sys.exit(code)
print(clip[1].mesh.vertex_count)
del writer, clip, frame
"""
    out = players.parent / "forked.fvv"
    done = subprocess.run(
        [sys.executable, "-c", program, players, out], capture_output=True, text=True, timeout=SECONDS
    )
    assert done.returncode == 0 and int(done.stdout) and not done.stderr, done.stderr
    with fvv.open(out) as clip:
        assert len(clip) == 12


def vertices(frame):
    return frame.mesh.vertex_count


def shape(mesh, picture, camera):
    return camera.project(mesh.positions).shape, picture.pixels.shape


@pytest.mark.parametrize("context", CONTEXTS)
def test_an_executor_takes_frames_and_what_they_hold(players, context):
    pool = functools.partial(
        concurrent.futures.ProcessPoolExecutor, 2, mp_context=multiprocessing.get_context(context)
    )
    with fvv.open(players) as clip, pool() as executor:
        assert list(executor.map(vertices, clip, timeout=SECONDS)) == [
            frame.mesh.vertex_count for frame in clip
        ]
        frame = clip[0]
        result = executor.submit(shape, frame.mesh, frame.pictures[1], frame.cameras[1]).result(SECONDS)
        assert result == ((frame.mesh.vertex_count, 2), frame.pictures[1].pixels.shape)


def test_dask_takes_frames(players):
    from dask import compute, delayed

    with fvv.open(players) as clip:
        found = compute(*[delayed(vertices)(frame) for frame in clip], scheduler="processes", num_workers=2)
        assert list(found) == [frame.mesh.vertex_count for frame in clip]
