"""Writing: the bytes of fvvmux, values that come back, outputs that are whole or absent, and errors."""

import io
import json
import os
import re
import signal
import stat
import subprocess
import sys
import threading
import time
import warnings

import fvv
import numpy
import pytest
from conftest import tool
from scenes import FACES, TETRAHEDRON, ball, camera, picture, read_capture

TINY = {"codec": "jpeg", "quality": 80, "group": 4, "keep_geometry": True, "threads": 1}


def written(frames, rate=25, **options):
    """The bytes of a stream of these tuples, and the summary."""
    target = io.BytesIO()
    with fvv.Writer(target, rate=rate, **options) as writer:
        writer.extend(frames)
    return target.getvalue(), writer.summary


def tetrahedra(count):
    return [((TETRAHEDRON + [0.01 * i, 0, 0], FACES),) for i in range(count)]


def command(options):
    """Keyword arguments as fvvmux takes them."""
    out = []
    for name, value in options.items():
        out.append("--" + name.replace("_", "-"))
        if value is not True:
            out.append(",".join(map(str, value)) if isinstance(value, (tuple, list)) else str(value))
    return out


# The bytes of fvvmux.


def test_mux_is_fvvmux(players, tmp_path):
    steps = []
    summary = fvv.mux(
        players.parent / "capture", tmp_path / "out.fvv", group=5, ladder=[1, 0.5], visibility="weight",
        colours=True, keep_geometry=True, segments=tmp_path / "segments",
        progress=lambda done, of: steps.append((done, of)),
    )  # fmt: skip
    assert (tmp_path / "out.fvv").read_bytes() == players.read_bytes()
    assert steps[-1] == (12, 12) and summary["frames"] == 12 and summary["warnings"] == []
    tool("fvvmux", players, "--segments", tmp_path / "theirs")
    names = {p.relative_to(tmp_path / "theirs") for p in (tmp_path / "theirs").rglob("*") if p.suffix != ""}
    assert len(names) > 5
    for name in names:
        if (tmp_path / "theirs" / name).is_file() and name.name != ".fvv-output":
            assert (tmp_path / "segments" / name).read_bytes() == (tmp_path / "theirs" / name).read_bytes()


@pytest.mark.parametrize(
    "options",
    [
        {"codec": "jpeg", "max_error": "2mm"},
        {"codec": "jpeg", "quality": 60, "keep_geometry": True, "visibility": "weight", "ladder": (1, 0.5)},
        {"no_pictures": True, "max_error": "0.5px", "mesh_profile": "fast", "no_delta": True},
        {"no_meshes": True, "codec": "h264", "quality": "35dB", "scale": 0.5, "tile_fill": "keep"},
    ],
    ids=["error", "ladder", "meshes", "pictures"],
)
def test_a_writer_is_fvvmux(players, tmp_path, options):
    # All frames are one group, so that both plan by the same frames; a writer leaves room in cropped layouts.
    options = {"crop": "none", "group": 4, **options}
    folder = players.parent / "capture"
    tool("fvvmux", folder, "-o", tmp_path / "theirs.fvv", "--no-sound", "--frames", "0-3", *command(options))
    described, cameras, frame = read_capture(folder)
    with fvv.Writer(
        tmp_path / "own.fvv", rate=25, cameras=cameras, name=described["name"], up=described["up"], **options
    ) as writer:
        for i in range(4):
            mesh, pictures, masks = frame(i)
            writer.add(mesh, pictures, masks, time=i / 25)
    assert (tmp_path / "own.fvv").read_bytes() == (tmp_path / "theirs.fvv").read_bytes()
    assert writer.summary["frames"] == 4 and writer.frames == 4


def test_a_capture_may_be_patterns_of_files(tmp_path):
    from scenes import ball

    for i in range(2):
        positions, faces = ball(6, shift=0.01 * i)
        lines = [f"v {x} {y} {z}" for x, y, z in positions] + [
            "f {} {} {}".format(*face + 1) for face in faces
        ]
        (tmp_path / f"{i}.obj").write_text("\n".join(lines) + "\n")
    described = tmp_path / "capture.json"
    meshes = {"meshes": tmp_path / "%d.obj", "fps": 10, "units": "metres"}
    fvv.mux(None, tmp_path / "a.fvv", **meshes, write_capture=described)
    fvv.mux(described, tmp_path / "b.fvv")
    assert (tmp_path / "a.fvv").read_bytes() == (tmp_path / "b.fvv").read_bytes()
    assert json.loads(described.read_text())["meshes"] == {"pattern": "%d.obj"}
    with pytest.raises(fvv.UsageError, match="capture: expected a path, or None and meshes"):
        fvv.mux(None, tmp_path / "c.fvv")
    with pytest.raises(fvv.UsageError, match="fps: is an option of fvv.mux"):
        fvv.Writer(tmp_path / "c.fvv", rate=25, **meshes)


def test_every_option_of_fvvmux_has_its_name():
    words = set(re.findall(r"^ +(?:-\w,)?--([a-z-]+)", tool("fvvmux", "--help-all"), re.M))
    assert len(words) > 45
    others = {"help", "help-all", "version", "json", "output", "force", "segments", "cameras", "report"}
    others.add("write-capture")  # a parameter of fvv.mux
    others |= {"objects", "data"}  # any text may be the name of a file
    of_parts = {"plan", "part", "merge", "capture"}  # fvv.distributed
    arriving = {"realtime", "in-place", "max-delay", "idle"}  # fvv.Writer takes frames as they come
    for word in words - others - of_parts - arriving:
        name = word.replace("-", "_")
        with pytest.raises(fvv.UsageError) as caught:
            fvv.mux("/nowhere", io.BytesIO(), **{name: "?"})
        assert re.match(rf"{name}: expected .*, found", str(caught.value)), caught.value


# Values.


@pytest.mark.parametrize("profile", ["draco", "raw", "fast"])
def test_positions_come_back_within_half_a_step(profile):
    frames = [(ball(8, shift=0.01 * i),) for i in range(6)]
    content, summary = written(frames, **TINY, step="1mm", mesh_profile=profile)
    assert fvv.check(content).ok and summary["frames"] == 6
    with fvv.open(content) as clip:
        assert len(clip) == 6 and clip.rate == 25
        for ((positions, faces),), frame in zip(frames, clip):
            mesh = frame.mesh
            assert mesh.step == 0.001
            assert (mesh.vertex_count, mesh.face_count) == (len(positions), len(faces))
            distances = numpy.abs(mesh.positions[:, None] - positions[None]).max(axis=2)
            # A delta frame may be off by a further step.
            assert distances.min(axis=0).max() <= 0.0005 + 0.001 * (frame.index % 4 != 0) + 1e-6


def test_what_was_read_can_be_written(players):
    # Meshes of a stream are on its lattice: the same lattice keeps them exactly.
    with fvv.open(players) as clip:
        keys = clip[::5]
        content, _ = written([(frame.mesh,) for frame in keys], keep_geometry=True, step=clip[0].mesh.step)
        with fvv.open(content) as again:
            for one, other in zip(keys, again):
                assert sorted(one.mesh.lattice.tolist()) == sorted(other.mesh.lattice.tolist())


def test_pictures_and_masks():
    cameras = [camera(3, 0.1, name="left"), camera(1, -0.1, (80, 60), name="right")]
    grey = {3: 60, 1: 120}
    frames = []
    for i in range(5):
        pictures = {c.id: picture(c, grey[c.id]) for c in cameras}
        masks = {"left": numpy.ones((48, 64), bool), 1: numpy.full((60, 80), 255, numpy.uint8)}
        frames.append({"mesh": (TETRAHEDRON + 0.01 * i, FACES), "pictures": pictures, "masks": masks})
    content, _ = written(frames, cameras=cameras, name="two", up="+y", tile_fill="keep", crop="none", **TINY)
    with fvv.open(content) as clip:
        assert clip.up == "+y" and list(clip[0].pictures) == [1, 3]
        for frame in clip:
            for c in cameras:
                found = frame.pictures[c.id].whole()
                assert found.shape == (c.height, c.width, 3)
                assert numpy.abs(found.astype(int) - picture(c, grey[c.id])).mean() < 4
                assert frame.cameras[c.name].K.tobytes() == c.K.tobytes()
    # In the cameras' order, from rows with gaps between them, and of one camera alone.
    wide = [numpy.zeros((c.height, c.width + 7, 3), numpy.uint8) for c in cameras]
    for image, c in zip(wide, cameras):
        image[:, : c.width] = picture(c, grey[c.id])
    same, _ = written(
        [(f["mesh"], [w[:, : c.width] for w, c in zip(wide, cameras)], f["masks"]) for f in frames],
        cameras=cameras, name="two", up="+y", tile_fill="keep", crop="none", **TINY,
    )  # fmt: skip
    assert same == content
    content, _ = written([(f["mesh"], [f["pictures"][3], None]) for f in frames], cameras=cameras, **TINY)
    with fvv.open(content) as clip:
        assert list(clip[0].pictures) == [3] and list(clip[0].cameras) == [1, 3]


def test_deep_and_linear_pictures():
    c = camera()
    shades = numpy.repeat(numpy.linspace(0, 65535, 64).astype(numpy.uint16)[None, :, None], 48, 0).repeat(
        3, 2
    )
    content, _ = written(
        [((TETRAHEDRON, FACES), [shades])], cameras=[c], codec="hevc", bit_depth=10, quality=4
    )
    with fvv.open(content) as clip:
        found = clip[0].pictures[0].whole()
        assert found.dtype == numpy.uint16
    light = (numpy.random.default_rng(1).random((48, 64, 3)) * 4).astype(numpy.float16)
    content, _ = written([((TETRAHEDRON, FACES), [light])], cameras=[c], codec="exr", crop="none")
    with fvv.open(content) as clip:
        assert (clip[0].pictures[0].pixels == light).all()
    writer = fvv.Writer(io.BytesIO(), rate=25, cameras=[c], codec="jpeg")
    with pytest.raises(fvv.UsageError, match="frame 0: picture 0: expected uint8 .* found uint16"):
        writer.add((TETRAHEDRON, FACES), [shades])
    writer.close()


def test_normals_are_sent():
    positions, faces = ball(8)
    tilted = positions + [0, 0, 0.3]
    content, _ = written([((positions, faces, tilted),)], normals="always", keep_geometry=True, step="1mm")
    with fvv.open(content) as clip:
        mesh = clip[0].mesh
        assert mesh.has_normals
        order = numpy.abs(mesh.positions[:, None] - positions[None]).max(axis=2).argmin(axis=1)
        expected = tilted[order] / numpy.linalg.norm(tilted[order], axis=1)[:, None]
        assert (mesh.normals * expected).sum(axis=1).min() > 0.999


def test_visibility_is_sent():
    c = camera()
    weights = numpy.array([255, 0, 255, 128], numpy.uint8)
    content, _ = written(
        [((TETRAHEDRON, FACES), [picture(c, 90)], None)] * 0
        + [{"mesh": (TETRAHEDRON, FACES), "pictures": [picture(c, 90)], "visibility": {0: weights}}] * 3,
        cameras=[c], visibility=None, **TINY,
    )  # fmt: skip
    with fvv.open(content) as clip:
        assert clip[0].visibility(0) is not None


def test_an_empty_stage():
    stage = [0.0, None, None, 0.3, 0.4, None]
    meshes = [None if x is None else (TETRAHEDRON + [x, 0, 0], FACES) for x in stage]
    content, summary = written([(mesh,) for mesh in meshes], **TINY)
    with fvv.open(content) as clip:
        # The stream ends where the stage becomes empty for good, as that of fvvmux does.
        assert [frame.ticks for frame in clip] == [0, 3, 4] and clip.duration == pytest.approx(5 / 25)
    c = camera()
    content, _ = written([(mesh, [picture(c, 50)]) for mesh in meshes], cameras=[c], **TINY)
    with fvv.open(content) as clip:
        assert [frame.mesh is not None for frame in clip] == [x is not None for x in stage]
        assert all(frame.pictures[0].pixels.any() for frame in clip)
    with pytest.raises(fvv.UsageError, match="a frame with a mesh"):
        written([(None,), (None,)], **TINY)


def test_cameras_that_move():
    still, first = camera(2, -0.2), camera(7, 0.0)
    places = [camera(7, 0.03 * i) for i in range(6)]
    frames = [
        {
            "mesh": (TETRAHEDRON, FACES),
            "pictures": [picture(still, 40), picture(first, 90)],
            "calibration": {7: place},
        }
        for place in places
    ]
    content, _ = written(frames, cameras=[still, first], **TINY)
    with fvv.open(content) as clip:
        assert [c.moves for c in clip[0].cameras.values()] == [False, True]
        for frame, place in zip(clip, places):
            assert numpy.abs(frame.cameras[7].centre - place.centre).max() < 1e-3
            assert numpy.abs(frame.cameras[7].R - place.R).max() < 1e-4
    writer = fvv.Writer(io.BytesIO(), rate=25, cameras=[still, first], **TINY)
    for wrong in (camera(8), camera(7, 0, (60, 48)), camera(7, 0, distortion=[0.01], lens="radtan"), "here"):
        with pytest.raises(fvv.UsageError, match="frame 0: calibration: expected"):
            writer.add((TETRAHEDRON, FACES), calibration={7: wrong})
    writer.close()


def test_sound():
    seconds = numpy.arange(48000) / 48000
    tone = (0.5 * numpy.sin(2 * numpy.pi * 440 * seconds)).astype(numpy.float32)
    both = numpy.stack([tone, -tone], axis=1)
    audio = [
        fvv.AudioInput(both, title="tone", language="en", start=0.5),
        fvv.AudioInput(tone.astype(float), position=[1, 2, 3], bit_rate=32000),
        fvv.AudioInput(tone[::2].repeat(2), position=numpy.outer(numpy.arange(50), [0, 0, 0.1])),
    ]
    content, summary = written(tetrahedra(50), audio=audio, **TINY)
    assert fvv.check(content).ok and summary["warnings"] == [] and len(summary["audio"]) == 3
    with fvv.open(content) as clip:
        first, placed, moving = clip.audio
        assert (first.title, first.language, first.channels, first.codec) == ("tone", "en", 2, "opus")
        assert (
            0.479 < first.start <= 0.5  # a packet earlier
            and placed.position.tolist() == [1, 2, 3]
            and moving.position is None
        )
        samples = first.samples()
        begin = 24000 - round(first.start * 48000)
        heard = samples[begin : begin + 48000]
        for channel, expected in enumerate((tone, -tone)):
            assert numpy.corrcoef(heard[: len(tone), channel], expected[: len(heard)])[0, 1] > 0.99
        # Packets of a clip stay as they are.
        again, _ = written(tetrahedra(50), audio=clip.audio[:2], **TINY)
        for one, other in zip(clip.audio, fvv.open(again).audio):
            assert (one.packets, one.packets_start, one.record) == (
                other.packets,
                other.packets_start,
                other.record,
            )
            assert (one.title, repr(one.position)) == (other.title, repr(other.position))
    with pytest.warns(fvv.LossWarning, match="sound 0: its sound goes on after the last frame"):
        written(tetrahedra(20), audio=audio[:1], **TINY)
    with pytest.warns(fvv.LossWarning, match="sound 0: has no sound at the time of the frames"):
        written(tetrahedra(2), audio=[fvv.AudioInput(tone, start=7)], **TINY)
    with pytest.raises(fvv.UsageError, match="frame 5: sound 0 moves, and has no position here"):
        written(tetrahedra(6), audio=[fvv.AudioInput(tone, position=numpy.zeros((5, 3)))], **TINY)


@pytest.mark.parametrize(
    ("sound", "text"),
    [
        ("beep", "audio 0: expected fvv.AudioInput or fvv.Sound, found str"),
        (
            fvv.AudioInput(numpy.zeros(9), rate=44100),
            "audio 0: rate: expected 48000 samples per second, found 44100",
        ),
        (fvv.AudioInput([1, 2, 3]), r"samples: expected floats .*, found int64 \(3, 1\)"),
        (fvv.AudioInput(numpy.zeros((9, 9))), r"found float64 \(9, 9\)"),
        (fvv.AudioInput(numpy.zeros(0)), r"found float64 \(0, 1\)"),
        (fvv.AudioInput([0, numpy.nan]), "samples: expected finite numbers"),
        (
            fvv.AudioInput(numpy.zeros((9, 2)), position=[0, 0, 0]),
            "expected one channel of a sound with a position",
        ),
        (
            fvv.AudioInput(numpy.zeros(9), position=[0, 0]),
            r"position: expected \(3,\) or \(frames, 3\), found \(2,\)",
        ),
        (fvv.AudioInput(numpy.zeros(9), position=[0, 0, numpy.inf]), "position: expected finite metres"),
        (fvv.AudioInput(numpy.zeros(9), start=numpy.nan), "start: expected seconds"),
        (fvv.AudioInput(numpy.zeros(9), bit_rate=-1), "bit_rate: expected bits per second"),
        (fvv.AudioInput(numpy.zeros(9), bit_rate=5), "audio 0: "),
        (fvv.AudioInput(numpy.zeros(9), language="?"), "language: expected a tag"),
    ],
)
def test_wrong_sound(sound, text):
    with pytest.raises(fvv.UsageError, match=text):
        written(tetrahedra(1), audio=[sound], **TINY)


def test_a_ladder():
    c = camera(size=(160, 96))
    noise = numpy.random.default_rng(0).integers(0, 255, (96, 160, 3), numpy.uint8)
    content, _ = written([((TETRAHEDRON, FACES), [noise])] * 4, cameras=[c], ladder=(1, 0.5), **TINY)
    with fvv.open(content) as best, fvv.open(content, rung=1) as least:
        assert [rung.scale for rung in best.rungs] == [1, 0.5]
        assert best[0].pictures[0].pixels.size > 3 * least[0].pictures[0].pixels.size


def test_times():
    writer = fvv.Writer(io.BytesIO(), rate=30000 / 1001, **TINY)
    assert abs(float(writer.rate) - 30000 / 1001) < 1e-5
    for i in range(5):
        writer.add((TETRAHEDRON, FACES), time=100 + i * 1001 / 30000 + 0.001 * (-1) ** i)
    for wrong in (100 + 4 * 1001 / 30000, 105.0, float("nan"), float("inf"), [1]):
        with pytest.raises(fvv.UsageError, match=r"frame 5: time: expected .*, found"):
            writer.add((TETRAHEDRON, FACES), time=wrong)
    writer.add((TETRAHEDRON, FACES), time=100 + 5 * 1001 / 30000)
    assert writer.finish()["frames"] == 6
    for wrong in (0, -25, float("nan"), "fast", 1e12):
        with pytest.raises(fvv.UsageError, match="rate: expected"):
            fvv.Writer(io.BytesIO(), rate=wrong)


def test_live_to_a_pipe():
    source, sink = os.pipe()
    seen, reader = [], fvv.Reader()

    def receive():
        with open(source, "rb", buffering=0) as pipe:
            while data := pipe.read(1 << 16):
                seen.extend(e for e in reader.feed(data) if isinstance(e, fvv.FrameEvent))
            reader.finish()

    thread = threading.Thread(target=receive)
    thread.start()
    with (
        open(sink, "wb", buffering=0) as pipe,
        fvv.Writer(pipe, rate=25, live=True, repeat_configuration=True, **TINY) as writer,
    ):
        for i, (mesh,) in enumerate(tetrahedra(10)):
            writer.add(mesh)
            if i == 7:
                deadline = time.monotonic() + 10
                while len(seen) < 4 and time.monotonic() < deadline:
                    time.sleep(0.001)
                assert len(seen) >= 4  # a group is there before the stream ends
    thread.join()
    assert [event.frame.number for event in seen] == list(range(10))


def test_a_function_takes_the_bytes():
    parts = []
    with fvv.Writer(parts.append, rate=25, **TINY) as writer:
        writer.extend(tetrahedra(6))
    assert all(isinstance(part, bytes) for part in parts)
    assert b"".join(parts) == written(tetrahedra(6), **TINY)[0]


# Outputs.


def test_a_file_is_whole_or_absent(tmp_path):
    path = tmp_path / "out.fvv"
    with fvv.Writer(path, rate=25, **TINY) as writer:
        writer.extend(tetrahedra(6))
        assert not path.exists() and len(list(tmp_path.iterdir())) == 1
    assert list(tmp_path.iterdir()) == [path] and fvv.check(path).ok
    umask = os.umask(0)
    os.umask(umask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~umask
    content = path.read_bytes()
    with pytest.raises(fvv.UsageError, match="already exists; force=True") as caught:
        fvv.Writer(path, rate=25)
    assert caught.value.file == str(path)
    path.chmod(0o640)
    # While a clip is read from what is replaced.
    with fvv.open(path) as clip, fvv.Writer(path, rate=25, force=True, **TINY) as writer:
        for frame in clip[:3]:
            writer.add(frame.mesh)
        assert path.read_bytes() == content
    assert len(fvv.open(path)) == 3 and stat.S_IMODE(path.stat().st_mode) == 0o640
    content = path.read_bytes()
    with pytest.raises(ZeroDivisionError), fvv.Writer(path, rate=25, force=True, **TINY) as writer:
        writer.extend(tetrahedra(6))
        1 / 0  # noqa: B018
    with pytest.raises(fvv.UsageError), fvv.Writer(path, rate=25, force=True, **TINY):
        pass  # no frame
    writer = fvv.Writer(path, rate=25, force=True, **TINY)
    writer.extend(tetrahedra(6))
    del writer
    assert list(tmp_path.iterdir()) == [path] and path.read_bytes() == content


def test_what_appears_meanwhile_is_not_replaced(tmp_path):
    path = tmp_path / "out.fvv"
    writer = fvv.Writer(path, rate=25, **TINY)
    writer.extend(tetrahedra(3))
    path.write_text("mine")
    with pytest.raises(fvv.UsageError, match="already exists"):
        writer.finish()
    assert list(tmp_path.iterdir()) == [path] and path.read_text() == "mine"


def test_targets_that_are_refused(tmp_path, players):
    with pytest.raises(fvv.UsageError, match="expected a file to write"):
        fvv.Writer(tmp_path, rate=25)
    with pytest.raises(FileNotFoundError):
        fvv.Writer(tmp_path / "missing/out.fvv", rate=25)
    with pytest.raises(TypeError, match="expected a path, a binary file object or a function"):
        fvv.Writer(7, rate=25)
    capture = players.parent / "capture"
    before = (capture / "meshes/0001.ply").read_bytes()
    os.link(capture / "meshes/0001.ply", tmp_path / "alias.fvv")
    with pytest.raises(fvv.UsageError, match="is read by this call"):
        fvv.mux(capture, tmp_path / "alias.fvv", force=True)
    assert (capture / "meshes/0001.ply").read_bytes() == before
    with pytest.raises(fvv.UsageError, match="verify: BytesIO cannot be read back"):
        fvv.mux(capture, io.BytesIO(), verify=True)
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken/file").write_text("mine")
    with pytest.raises(fvv.UsageError, match="an empty folder"):
        fvv.mux(capture, tmp_path / "out.fvv", segments=tmp_path / "taken")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["alias.fvv", "taken"]


def test_a_sink_that_fails_ends_the_writer():
    class Full(io.BytesIO):
        def write(self, data):
            raise OSError(28, "No space left on device")

    writer = fvv.Writer(Full(), rate=25, **TINY)
    with pytest.raises(OSError, match="No space left"):
        writer.extend(tetrahedra(8))
    for call in (lambda: writer.add((TETRAHEDRON, FACES)), writer.finish, writer.__enter__):
        with pytest.raises(fvv.UsageError, match="cannot be used any more: it failed: .*No space left"):
            call()
    writer.close()

    def slow(data):
        taken.append(data[:1000])
        return min(len(data), 1000)

    taken = []
    target = io.BytesIO()
    target.write = slow
    with fvv.Writer(target, rate=25, **TINY) as writer:
        writer.extend(tetrahedra(6))
    assert b"".join(taken) == written(tetrahedra(6), **TINY)[0]


def test_use_after_the_end(tmp_path):
    for end in (fvv.Writer.finish, fvv.Writer.close):
        writer = fvv.Writer(tmp_path / f"{end.__name__}.fvv", rate=25, **TINY)
        writer.extend(tetrahedra(2))
        end(writer)
        for call in (lambda w: w.add((TETRAHEDRON, FACES)), fvv.Writer.finish, fvv.Writer.__enter__):
            with pytest.raises(fvv.UsageError, match="cannot be used any more"):
                call(writer)
        writer.close()
        assert writer.closed and writer.frames == 2
    assert [p.name for p in tmp_path.iterdir()] == ["finish.fvv"]


def test_nothing_leaks(tmp_path):
    done = subprocess.run(
        [sys.executable, __file__.replace("test_write", "write_close"), tmp_path],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) < 1 << 20, f"grew by {int(done.stdout)} bytes"


# Errors.


def test_a_refused_frame_changes_nothing():
    c = camera(4)
    good = {"mesh": (TETRAHEDRON, FACES), "pictures": [picture(c, 70)]}
    wrong = {
        "frame 1: mesh: expected a finite number|not finite|finite": {
            "mesh": (TETRAHEDRON * numpy.nan, FACES)
        },
        "frame 1: .*index|frame 1: .*face": {"mesh": (TETRAHEDRON, FACES + 9)},
        "frame 1: mesh: indices: face 0: expected vertices from 0 on, found -1": {
            "mesh": (TETRAHEDRON, FACES.astype(int) - 1)
        },
        r"frame 1: mesh: positions: expected float32 or float64 \(vertices, 3\), found float64 \(4, 2\)": {
            "mesh": (TETRAHEDRON[:, :2], FACES)
        },
        r"frame 1: mesh: indices: expected integers of 32 or 64 bits \(faces, 3\), found float64": {
            "mesh": (TETRAHEDRON, FACES * 1.0)
        },
        "frame 1: mesh: normals: expected one for each of 4 vertices, found 3": {
            "mesh": (TETRAHEDRON, FACES, TETRAHEDRON[:3])
        },
        "frame 1: mesh: expected an fvv.Mesh": {"mesh": "ball"},
        "frame 1: pictures: expected identifiers or names": {"pictures": {5: picture(c, 70)}},
        "frame 1: pictures: expected one for each of 1 cameras, found 2": {"pictures": [picture(c, 70)] * 2},
        r"frame 1: pictures: expected of cameras \[4\], as in the first frame, found of \[\]": {
            "pictures": None
        },
        "frame 1: camera 4: expected a picture of 64x48 pixels, found 48x64": {
            "pictures": [picture(c, 70).swapaxes(0, 1)]
        },
        r"frame 1: picture 0: expected uint8, uint16 or floats \(height, width, 3\), found uint8 \(48, 64\)": {
            "pictures": [picture(c, 70)[:, :, 0]]
        },
        r"frame 1: masks: expected of cameras \[\], as in the first frame, found of \[4\]": {
            "masks": [numpy.ones((48, 64), bool)]
        },
        r"frame 1: visibility: expected of cameras \[\]": {"visibility": [numpy.ones(4, numpy.uint8)]},
    }
    target = io.BytesIO()
    with fvv.Writer(target, rate=25, cameras=[c], **TINY) as writer:
        writer.add(**good)
        for text, change in wrong.items():
            with pytest.raises(fvv.UsageError, match=text):
                writer.add(**{**good, **change})
            assert writer.frames == 1
        writer.add(**good)
    assert target.getvalue() == written([good] * 2, cameras=[c], **TINY)[0]


def test_a_refused_first_frame_decides_nothing():
    # Found by test_write_properties.Writers.
    c, target = camera(), io.BytesIO()
    with fvv.Writer(target, rate=25, cameras=[c], **TINY) as writer:
        with pytest.raises(
            fvv.UsageError, match="frame 0: masks: expected with a picture of camera 0, found alone"
        ):
            writer.add(masks=[numpy.ones((48, 64), bool)])
        for wrong in (
            {"masks": ["none"], "pictures": [7]},
            {"mesh": (TETRAHEDRON, FACES + 1), "visibility": [None]},
        ):
            with pytest.raises(fvv.UsageError):
                writer.add(**wrong, time=77)
        writer.add((TETRAHEDRON, FACES), [picture(c, 9)], time=5)
        writer.add((TETRAHEDRON, FACES), [picture(c, 9)], time=5.04)
    with fvv.open(target.getvalue()) as clip:
        assert len(clip) == 2 and list(clip[0].pictures) == [0]


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"codec": "mpeg2"}, 'codec: expected jpeg, h264, .*, found "mpeg2"'),
        ({"bit_depth": 10}, "bit_depth: "),
        ({"max_error": "1px mm"}, 'max_error: expected pixels .*, found "1px mm"'),
        ({"group": 0}, 'group: expected a whole number from 1 to 100000, found "0"'),
        ({"group": 2.5}, 'found "2.5"'),
        ({"ladder": [1, 2]}, "ladder: expected 2 to 8 falling scales"),
        ({"tile": (64, 48), "scale": 0.5}, "tile: expected without scale, found both"),
        ({"tile": (0, 48)}, 'tile: expected WIDTHxHEIGHT .*, found "0x48"'),
        ({"quality": 20, "bitrate": "1M"}, "quality: expected without bitrate"),
        ({"max-error": 1}, "there is no option max-error"),
        ({"colour": "on"}, "there is no option colour"),
        ({"frames": "1-2"}, "frames: is an option of fvv.mux"),
        ({"verify": True}, "verify: is an option of fvv.mux"),
        ({"up": "y"}, "up: expected"),
        ({"cameras": [7]}, "cameras: expected fvv.Camera, found int"),
        ({"cameras": [camera(1), camera(1, 1)]}, "two of them have the identifier 1"),
    ],
)
def test_wrong_options(tmp_path, options, text):
    with pytest.raises(fvv.UsageError, match=text) as caught:
        fvv.Writer(tmp_path / "out.fvv", rate=25, **options)
    assert "--" not in str(caught.value) and not list(tmp_path.iterdir())


def test_losses_are_warnings(tmp_path):
    uvs = numpy.zeros((4, 2))
    with pytest.warns(fvv.LossWarning, match="texture coordinates are left out") as found:
        _, summary = written([((TETRAHEDRON, FACES, None, uvs),)] * 3, **TINY)
    assert len(found) == len(summary["warnings"]) == 1
    # As errors they end the writer, as any exception inside of it.
    with warnings.catch_warnings():
        warnings.simplefilter("error", fvv.LossWarning)
        with pytest.raises(fvv.LossWarning), fvv.Writer(tmp_path / "out.fvv", rate=25, **TINY) as writer:
            writer.add((TETRAHEDRON, FACES, None, uvs))
        late = fvv.Writer(
            tmp_path / "late.fvv", rate=25, audio=[fvv.AudioInput(numpy.zeros(9), start=9)], **TINY
        )
        late.add((TETRAHEDRON, FACES))
        with pytest.raises(fvv.LossWarning):
            late.finish()
        assert late.closed
    assert not list(tmp_path.iterdir())


def test_a_camera_from_arrays(players):
    with fvv.open(players) as clip:
        for known in clip[0].cameras.values():
            made = fvv.Camera(
                known.id, known.K, known.R, known.t, (known.width, known.height), known.distortion, known.lens,
                known.name, known.r_max,
            )  # fmt: skip
            points = clip[0].mesh.positions
            assert (made.project(points) == known.project(points)).all() and made.name == known.name
    bent = camera(1, distortion=[-0.2, 0.05], lens="radtan")
    assert 0.5 < bent.r_max < 10 and bent.distortion.tolist() == [-0.2, 0.05] + [0] * 6
    good = {"id": 1, "K": numpy.eye(3), "R": numpy.eye(3), "t": numpy.zeros(3), "size": (4, 4)}
    fvv.Camera(**good)
    for name, value, text in [
        ("id", -1, "id: expected 0 to 65534"),
        ("id", 65535, "id: expected 0 to 65534"),
        ("K", numpy.eye(4), "K: expected a 3 x 3 matrix"),
        ("K", -numpy.eye(3), "K: expected fx skew cx"),
        ("K", numpy.diag([0, 1, 1]), "camera 1: "),
        ("R", -numpy.eye(3), "camera 1: "),
        ("R", 2 * numpy.eye(3), "camera 1: "),
        ("t", [0, numpy.nan, 0], "camera 1: "),
        ("t", [0, 0], "t: expected 3 numbers"),
        ("size", (0, 4), "size: expected a width and a height from 1 to 16384"),
        ("lens", "pinhole", "lens: expected none, radtan or fisheye"),
        ("distortion", numpy.ones(9), "distortion: expected at most 8 numbers, found 9"),
        ("r_max", -1, "camera 1: "),
        ("name", "a\0b", "camera 1: .*NUL"),
    ]:
        with pytest.raises(fvv.UsageError, match=text):
            fvv.Camera(**{**good, name: value})


def test_damaged_captures(tmp_path):
    (tmp_path / "capture.json").write_text("{")
    with pytest.raises(fvv.DamagedError, match="capture.json"):
        fvv.mux(tmp_path, tmp_path / "out.fvv")
    with pytest.raises(fvv.Error, match="missing"):
        fvv.mux(tmp_path / "missing", tmp_path / "out.fvv")
    assert [p.name for p in tmp_path.iterdir()] == ["capture.json"]


# Threads and signals.


def test_adding_lets_other_threads_run():
    counts, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counts[0] += 1

    thread = threading.Thread(target=count)
    writer = fvv.Writer(io.BytesIO(), rate=25, group=1, keep_geometry=True, step="0.1mm", mesh_level=10)
    mesh = ball(120)
    thread.start()
    begin = counts[0]
    writer.add(mesh)
    grown = counts[0] - begin
    stop.set()
    thread.join()
    writer.close()
    assert grown > 1000


def test_a_writer_is_used_by_one_call_at_a_time():
    refused = []

    def sink(data):
        for call in (lambda: writer.add((TETRAHEDRON, FACES)), writer.finish, writer.close):
            with pytest.raises(fvv.UsageError, match="in use by another call"):
                call()
            refused.append(1)

    with fvv.Writer(sink, rate=25, **TINY) as writer:
        writer.extend(tetrahedra(4))
    assert len(refused) > 3


def test_a_signal_cancels(tmp_path, players):
    class Interrupted(Exception):
        pass

    def interrupt(*_):
        raise Interrupted

    former = signal.signal(signal.SIGALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        begin = time.monotonic()
        with pytest.raises(Interrupted):
            fvv.mux(players.parent / "capture", tmp_path / "out.fvv", codec="av1", mesh_level=10, threads=1)
        assert time.monotonic() - begin < 20
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, former)
    assert not list(tmp_path.iterdir())


# Decimation.


def test_decimation_keeps_its_budget():
    mesh = ball(40)
    some = fvv.decimate(mesh, "5mm")
    assert (
        len(some.indices) < len(mesh[1]) / 2 and some.rms <= 0.005 < some.rms + 0.002 and not some.unchanged
    )
    assert some.rms_pixels is None
    assert numpy.abs(numpy.asarray(mesh[0])[some.vertices] - some.positions).max() < 0.05
    seen = fvv.decimate(mesh, "0.2px", cameras=[camera(size=(640, 480))])
    assert seen.rms_pixels <= 0.2 and len(seen.indices) < len(mesh[1])
    assert 100 <= len(fvv.decimate(mesh, triangles=200).indices) <= 200
    assert len(fvv.decimate((TETRAHEDRON, FACES), "1mm").indices) == 4
    assert fvv.decimate((TETRAHEDRON, FACES), "1mm", step=0.7).unchanged
    content, _ = written([(some.mesh(),)], keep_geometry=True)
    assert fvv.open(content)[0].mesh.face_count == len(some.indices)
    for arguments, text in [
        ({}, "either max_error or triangles"),
        ({"max_error": "1mm", "triangles": 5}, "either max_error or triangles"),
        ({"max_error": 0.15}, "because there are no cameras"),
        ({"max_error": "1 inch"}, "max_error: expected pixels"),
        ({"triangles": 0}, "triangles: expected 1 or more"),
        ({"max_error": "1mm", "scale": 2}, "scale: expected"),
        ({"max_error": "1mm", "step": 0}, "step: expected"),
    ]:
        with pytest.raises(fvv.UsageError, match=text):
            fvv.decimate(mesh, **arguments)
    with pytest.raises(fvv.UsageError, match="mesh: "):
        fvv.decimate((mesh[0] + numpy.inf, mesh[1]), "1mm")


def test_objects_with_vertices_and_faces():
    class Trimesh:
        vertices, faces = TETRAHEDRON, FACES.astype(numpy.int64)

    assert written([(Trimesh(),)], **TINY)[0] == written([((TETRAHEDRON, FACES),)], **TINY)[0]
    lists = (TETRAHEDRON.tolist(), FACES.tolist())
    assert written([(lists,)], **TINY)[0] == written([((TETRAHEDRON, FACES),)], **TINY)[0]
    turned = (numpy.asfortranarray(TETRAHEDRON), FACES[::-1][::-1].astype(">u4"))
    assert written([(turned,)], **TINY)[0] == written([((TETRAHEDRON, FACES),)], **TINY)[0]


def test_the_summary_is_that_of_fvvmux(tmp_path, players):
    theirs = json.loads(
        tool(
            "fvvmux",
            players.parent / "capture",
            "-o",
            tmp_path / "theirs.fvv",
            "--json",
            "--no-pictures",
            "--frames",
            "2",
        )
    )
    own = fvv.mux(players.parent / "capture", tmp_path / "own.fvv", no_pictures=True, frames=2)
    assert list(own) == [*theirs, "warnings"] and own["frames"] == theirs["frames"] == 1
