"""Properties of writing: arbitrary meshes, calibrations and layouts come back, and any order of calls keeps what a Writer
promises."""

import io
import os
import pathlib
import shutil
import tempfile

import fvv
import hypothesis
import numpy
import pytest
from conftest import examples
from hypothesis import stateful, strategies
from scenes import FACES, TETRAHEDRON, camera, picture

# Arbitrary meshes are inside out, and texture coordinates left out.
pytestmark = pytest.mark.filterwarnings("ignore::fvv.errors.LossWarning")
QUICK = {"threads": 1, "keep_geometry": True, "group": 3}


def written(frames, **options):
    target = io.BytesIO()
    with fvv.Writer(target, rate=25, **{**QUICK, **options}) as writer:
        writer.extend(frames)
    return target.getvalue()


# Meshes.


@strategies.composite
def meshes(draw):
    """Vertices of any scale, some of them equal, and faces of any of them: degenerate, duplicate, non-manifold. Drawn as
    bytes, because an example takes less time to write than a list takes to draw."""
    scale = 10.0 ** draw(strategies.integers(-6, 6))
    coordinates = numpy.frombuffer(draw(strategies.binary(min_size=12, max_size=42)), numpy.int8)
    count = len(coordinates) // 3
    # Halves of the bytes are small whole numbers, so that vertices meet on lines and planes.
    grid, rest = coordinates[: 3 * count] % 4 - 1, coordinates[: 3 * count] / 41
    positions = scale * numpy.where(coordinates[: 3 * count] % 8 < 6, grid, rest).reshape(-1, 3)
    corners_ = numpy.frombuffer(draw(strategies.binary(min_size=3, max_size=36)), numpy.uint8)
    faces = (corners_[: len(corners_) // 3 * 3] % count).reshape(-1, 3)
    return positions, faces.astype(numpy.uint32), scale


def corners(lattice, faces):
    """The faces that have an area on the lattice, each set of three points once."""
    out = set()
    for face in faces:
        a, b, c = (tuple(map(int, lattice[v])) for v in face)
        u, v = ([q - p for p, q in zip(a, other)] for other in (b, c))
        area = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        if any(area):
            out.add(tuple(sorted((a, b, c))))
    return out


@hypothesis.settings(max_examples=examples(9))
@hypothesis.given(
    meshes(), strategies.sampled_from(["draco", "raw", "fast"]), strategies.sampled_from([256, 1024, 65536])
)
def test_any_mesh_comes_back(mesh, profile, steps):
    positions, faces, scale = mesh
    step = scale / steps
    expected = corners(numpy.rint(positions / step), faces)
    target = io.BytesIO()
    writer = fvv.Writer(target, rate=25, step=step, mesh_profile=profile, **QUICK)
    try:
        writer.add((positions, faces))
        writer.finish()
    except fvv.UsageError:
        # Nothing of it has an area.
        assert not expected
        return
    content = target.getvalue()
    assert fvv.check(content).ok
    with fvv.open(content) as clip:
        mesh = clip[0].mesh
        shift = numpy.rint(mesh.origin / step) if mesh.origin.any() else 0
        assert mesh.step == step and corners(mesh.lattice + shift, mesh.indices) == expected
        assert len(mesh.indices) == len(expected)


@hypothesis.given(meshes(), strategies.sampled_from(["raw", "fast"]))
def test_the_lattice_is_chosen_for_any_mesh(mesh, profile):
    positions, faces, scale = mesh
    target = io.BytesIO()
    writer = fvv.Writer(target, rate=25, mesh_profile=profile, **QUICK)
    try:
        writer.add((positions, faces))
        writer.finish()
    except fvv.UsageError:
        # Without an area on the lattice of 1/8192 of the diagonal.
        size = numpy.ptp(positions[faces.ravel()], axis=0).max()
        assert not corners(numpy.rint(positions / max(size, scale * 1e-6) * 100), faces)
        return
    with fvv.open(target.getvalue()) as clip:
        found = clip[0].mesh
        near = numpy.abs(found.origin + found.step * found.lattice[:, None] - positions[None]).max(axis=2)
        assert near.min(axis=1).max() <= found.step * 0.500001
        used = positions[faces.ravel()]
        assert found.step <= numpy.linalg.norm(numpy.ptp(used, axis=0)) / 2000


@hypothesis.given(meshes(), strategies.binary(min_size=42, max_size=42), strategies.booleans())
def test_any_normals_come_back(mesh, normals, uvs):
    positions, faces, scale = mesh
    sent = numpy.frombuffer(normals, numpy.int8).reshape(-1, 3)[: len(positions)] / 127
    sent[numpy.linalg.norm(sent, axis=1) == 0] = [0, 0, 1]
    target = io.BytesIO()
    writer = fvv.Writer(target, rate=25, step=scale / 256, normals="always", mesh_profile="raw", **QUICK)
    try:
        writer.add((positions, faces, sent, numpy.abs(sent[:, :2]) if uvs else None))
        writer.finish()
    except fvv.UsageError:
        assert not corners(numpy.rint(positions * 256 / scale), faces)
        return
    with fvv.open(target.getvalue()) as clip:
        found = clip[0].mesh
        assert found.has_normals and found.uvs is None
        unit = sent / numpy.linalg.norm(sent, axis=1)[:, None]
        lattice = numpy.rint(positions * 256 / scale)
        at = numpy.rint(found.origin * 256 / scale) + found.lattice
        for place, normal in zip(at, found.normals):
            # One of the source's at this place, or what faces around it agree on where several are welded.
            here = unit[(lattice == place).all(axis=1)]
            assert len(here) and abs(numpy.linalg.norm(normal) - 1) < 1e-5
            if len(here) == 1:
                assert here[0] @ normal > 0.99


@hypothesis.given(strategies.binary(min_size=1, max_size=9), strategies.integers(1, 5), strategies.booleans())
def test_any_sequence_of_meshes_comes_back(shifts, group, delta):
    stage = [None if shift < 80 else shift / 91 for shift in shifts]
    frames = [None if x is None else (TETRAHEDRON + [x, 0, 0], FACES) for x in stage]
    target = io.BytesIO()
    writer = fvv.Writer(
        target, rate=25, step="1mm", threads=1, keep_geometry=True, group=group, no_delta=not delta
    )
    writer.extend((mesh,) for mesh in frames)
    if all(x is None for x in stage):
        try:
            writer.finish()
        except fvv.UsageError:
            return
        raise AssertionError("a stream without a mesh")
    assert writer.finish()["frames"] == sum(x is not None for x in stage)
    content = target.getvalue()
    assert fvv.check(content).ok
    with fvv.open(content) as clip:
        assert [frame.ticks for frame in clip] == [i for i, x in enumerate(stage) if x is not None]
        for frame in clip:
            expected = TETRAHEDRON + [stage[frame.ticks], 0, 0]
            found = frame.mesh.positions
            error = numpy.abs(found[:, None] - expected[None]).max(axis=2).min(axis=1).max()
            assert error <= 0.0005 + 0.001 * delta + 1e-6


# Calibrations.


def rotation(a, b, c):
    def about(axis, t):
        out = numpy.eye(3)
        i, j = (k for k in range(3) if k != axis)
        out[i, i] = out[j, j] = numpy.cos(t)
        out[i, j], out[j, i] = -numpy.sin(t), numpy.sin(t)
        return out

    return about(0, a) @ about(1, b) @ about(2, c)


@strategies.composite
def cameras(draw, identifier=None, size=None, lens=None):
    numbers = numpy.frombuffer(draw(strategies.binary(min_size=32, max_size=32)), numpy.int16) / 2**15
    # A whole turn, 100 m, and lenses up to what a wide one has.
    angles, place, bends = 3.2 * numbers[:3], 100 * numbers[3:6], 0.05 * numbers[6:10]
    width, height = size or (draw(strategies.integers(1, 200)), draw(strategies.integers(1, 200)))
    lens = lens or draw(strategies.sampled_from(["none", "radtan", "fisheye"]))
    across, down = max(width, height) * 8 ** (1 + numbers[10:12]) / 3
    matrix = [
        [across, numbers[12], width * (0.5 + numbers[13] / 2)],
        [0, down, height * (0.5 + numbers[14] / 2)],
        [0, 0, 1],
    ]
    distortion = {"none": [], "radtan": [*bends[:2], *bends[2:] / 50, bends[0]], "fisheye": bends}[lens]
    name = strategies.text(strategies.characters(exclude_characters="\0", codec="utf-8"), max_size=5)
    return fvv.Camera(
        draw(strategies.integers(0, 65534)) if identifier is None else identifier,
        matrix,
        rotation(*angles),
        place,
        (width, height),
        distortion,
        lens,
        draw(name) if identifier is None else "",
    )


@hypothesis.given(strategies.lists(cameras(), min_size=1, max_size=4, unique_by=lambda c: c.id))
def test_any_calibration_comes_back(rig):
    content = written([((TETRAHEDRON, FACES),)], cameras=rig, step="1mm")
    with fvv.open(content) as clip:
        found = clip[0].cameras
        assert list(found) == sorted(c.id for c in rig)
        for c in rig:
            again = found[c.id]
            for name in ("K", "R", "t", "distortion"):
                assert getattr(again, name).tobytes() == getattr(c, name).tobytes(), name
            assert (again.name, again.lens, again.r_max) == (c.name, c.lens, c.r_max)
            assert (again.width, again.height, again.moves) == (c.width, c.height, False)


@hypothesis.settings(max_examples=examples(1 / 2))
@hypothesis.given(strategies.lists(cameras(5, (64, 48), "none"), min_size=1, max_size=5))
def test_any_motion_of_a_camera_comes_back(places):
    content = written(
        [{"mesh": (TETRAHEDRON, FACES), "calibration": {5: place}} for place in places],
        cameras=places[:1],
        step="1mm",
    )
    with fvv.open(content) as clip:
        for frame, place in zip(clip, places):
            found = frame.cameras[5]
            assert found.moves
            # A tenth of a pixel in the picture, and a millimetre in the scene.
            assert numpy.abs(found.centre - place.centre).max() < 1e-3
            corner = numpy.array([[0, 0], [64, 0], [0, 48], [64, 48], [32, 24]], float)
            points = place.unproject(corner, 1) - place.centre + found.centre
            assert numpy.abs(found.project(points) - corner).max() < 0.1


# Layouts.


@hypothesis.settings(max_examples=examples(1 / 5))
@hypothesis.given(
    strategies.lists(
        strategies.tuples(strategies.integers(1, 90), strategies.integers(1, 90), strategies.booleans()),
        min_size=1,
        max_size=5,
    ),
    strategies.sampled_from(["auto", "none"]),
    strategies.sampled_from([1, 0.5]),
)
def test_any_layout_comes_back(sizes, crop, scale):
    rig = [camera(i, 0.1 * i, (width, height)) for i, (width, height, _) in enumerate(sizes)]
    pictures = [numpy.full((c.height, c.width, 3), 30 + 40 * c.id, numpy.uint8) for c in rig]
    masks = [numpy.full((c.height, c.width), 255, numpy.uint8) if s[2] else None for c, s in zip(rig, sizes)]
    content = written(
        [((TETRAHEDRON, FACES), pictures, masks)] * 2, cameras=rig, codec="jpeg", quality=95, crop=crop, scale=scale,
        visibility="none", colours=False, match_colours=False, texture_inset=False, tile_fill="keep",
    )  # fmt: skip
    assert fvv.check(content).ok
    with fvv.open(content) as clip:
        for frame in clip:
            for i, found in frame.pictures.items():
                x, y, width, height = found.source
                assert 0 <= x < x + width <= rig[i].width and 0 <= y < y + height <= rig[i].height
                middle = found.pixels[found.pixels.shape[0] // 2, found.pixels.shape[1] // 2]
                assert numpy.abs(middle.astype(int) - 30 - 40 * i).max() < 12


# Sound.


@hypothesis.settings(max_examples=examples(1 / 5))
@hypothesis.given(
    strategies.integers(1, 12000),
    strategies.sampled_from([1, 2, 3, 4, 6, 8]),
    strategies.floats(-0.1, 0.9),
    strategies.booleans(),
)
def test_any_sound_comes_back(length, channels, start, placed):
    channels = 1 if placed else channels
    samples = numpy.random.default_rng(length).uniform(-1, 1, (length, channels)).astype(numpy.float32)
    audio = fvv.AudioInput(samples, start=start, position=[1, 0, 2] if placed else None, title="noise")
    content = written([((TETRAHEDRON, FACES),)] * 25, audio=[audio], step="1mm", group=5)
    assert fvv.check(content).ok
    with fvv.open(content) as clip:
        if not clip.audio:
            # No packet begins within the stream.
            assert start < 0 and start + length / 48000 <= 0.02
            return
        (found,) = clip.audio
        assert (found.channels, found.title, found.position is not None) == (channels, "noise", placed)
        # Packets of 20 ms, one of them before the sound and the last of them not full.
        assert start - 0.0201 - (start < 0) * 0.1 <= found.start <= max(0, start) + 1e-4
        end = min(1, start + length / 48000)
        assert end - 1e-4 <= found.start + found.duration <= end + 0.05
        assert found.samples().shape == (round(found.duration * 48000), channels)


# Any order of calls.


class Writers(stateful.RuleBasedStateMachine):
    """One writer at a time, of a file; a model of what it holds."""

    def __init__(self):
        super().__init__()
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.path = self.folder / "out.fvv"
        self.writer = None
        self.ended = True
        self.former = None  # the bytes under the name
        self.stage = []

    def teardown(self):
        if self.writer is not None:
            self.writer.close()
        shutil.rmtree(self.folder)

    @stateful.precondition(lambda self: self.ended)
    @stateful.rule(
        force=strategies.booleans(), pictures=strategies.booleans(), group=strategies.integers(1, 4)
    )
    def begin(self, force, pictures, group):
        c = camera(3)
        self.pictures = [picture(c, 60)] if pictures else None
        options = {
            "codec": "jpeg",
            "quality": 30,
            "colours": False,
            "visibility": "none",
            "texture_inset": False,
        }
        try:
            writer = fvv.Writer(
                self.path, rate=25, cameras=[c], force=force, threads=1, keep_geometry=True, step="1mm", group=group,
                **options,
            )  # fmt: skip
        except fvv.UsageError:
            assert self.former is not None and not force
            return
        assert self.former is None or force
        self.writer, self.ended, self.stage = writer, False, []

    @stateful.precondition(lambda self: self.writer)
    @stateful.rule(x=strategies.one_of(strategies.none(), strategies.floats(-1, 1, width=32)))
    def add(self, x):
        mesh = None if x is None else (TETRAHEDRON + [x, 0, 0], FACES)
        try:
            self.writer.add(mesh, self.pictures)
        except fvv.UsageError:
            assert self.ended
        else:
            assert not self.ended
            self.stage.append(x)

    @stateful.precondition(lambda self: self.writer)
    @stateful.rule(
        frame=strategies.sampled_from(
            [
                {"mesh": (TETRAHEDRON, FACES + 1)},
                {"mesh": (TETRAHEDRON + numpy.inf, FACES)},
                {"mesh": 7},
                {"mesh": None, "pictures": {4: 0}},
                {"mesh": None, "time": 1e9},
                {"mesh": None, "masks": ["none"]},
            ]
        )
    )
    def add_wrong(self, frame):
        # A first frame begins the count of times.
        if "time" in frame and not self.stage:
            return
        try:
            self.writer.add(**frame)
        except fvv.UsageError:
            return
        raise AssertionError("a wrong frame was taken")

    @stateful.precondition(lambda self: self.writer)
    @stateful.rule()
    def finish(self):
        meshes = [x for x in self.stage if x is not None]
        try:
            summary = self.writer.finish()
        except fvv.UsageError:
            assert self.ended or not meshes
        else:
            assert not self.ended and meshes
            assert summary["frames"] == (len(self.stage) if self.pictures else len(meshes))
            self.former = self.path.read_bytes()
            with fvv.open(self.former) as clip:
                for frame in clip:
                    x = self.stage[frame.ticks]
                    assert (frame.mesh is None) == (x is None)
                    if x is not None:
                        # 0.15 px of the camera are 7.5 mm there.
                        assert abs(frame.mesh.positions[:, 0].min() - x) <= 0.008
        self.ended = True

    @stateful.precondition(lambda self: self.writer)
    @stateful.rule()
    def close(self):
        self.writer.close()
        self.ended = True

    @stateful.invariant()
    def a_file_is_whole_or_absent(self):
        names = sorted(os.listdir(self.folder))
        assert ("out.fvv" in names) == (self.former is not None)
        assert len(names) == (self.former is not None) + (not self.ended)
        if self.former is not None:
            assert self.path.read_bytes() == self.former

    @stateful.invariant()
    def a_writer_knows_its_frames(self):
        if self.writer is not None:
            assert self.writer.frames == len(self.stage) and self.writer.closed == self.ended


Writers.TestCase.settings = hypothesis.settings(max_examples=examples(1 / 2), stateful_step_count=12)
TestWriters = Writers.TestCase
