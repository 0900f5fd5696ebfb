"""What the package reads is what the readers of conformance/reference find, bit for bit."""

import struct
import zlib

import fvv
import numpy
import pytest
from conftest import VECTORS
from reference import container, openexr, visibility
from reference.container import crc32c
from vectors import LISTINGS, name_of
from vectors import path_of as vector


def listed(name, suffix=".crc"):
    return (LISTINGS / f"{name}{suffix}").read_text().splitlines()


def crc(array, kind):
    return f"{crc32c(array.astype(kind).tobytes()):08x}"


@pytest.mark.parametrize("name", ["delta_field", "delta_stencils"])
def test_lattice(name):
    with fvv.open(vector(name)) as clip:
        assert [crc(frame.mesh.lattice, "<i4") for frame in clip] == listed(name)


@pytest.mark.parametrize("name", ["delta_field", "fast_shapes", "normals_cube"])
def test_positions_are_the_lattice_in_metres(name):
    with fvv.open(vector(name)) as clip:
        for frame in clip:
            mesh = frame.mesh
            metres = mesh.origin + mesh.step * mesh.lattice
            assert mesh.positions.dtype == numpy.float32 and mesh.lattice.dtype == numpy.int32
            assert (mesh.positions == metres.astype(numpy.float32)).all()
            assert mesh.indices.shape == (mesh.face_count, 3) and mesh.indices.max() < mesh.vertex_count


def test_uvs_and_faces():
    found = []
    with fvv.open(vector("fast_shapes")) as clip:
        for frame in clip:
            mesh = frame.mesh
            data = mesh.lattice.astype("<i4").tobytes() + mesh.indices.astype("<u4").tobytes()
            if mesh.uvs is not None:
                bits = payload_bits(clip, frame)
                indices = mesh.uvs * 2.0**bits
                assert (indices == numpy.rint(indices)).all()
            found.append((mesh.uvs is not None, len(data)))
    assert {textured for textured, _ in found} == {True, False} or all(textured for textured, _ in found)


def payload_bits(clip, frame):
    payload = container.payloads((vector("fast_shapes")).read_bytes(), b"MESH")[frame.index]
    return payload[2]


def test_normals():
    with fvv.open(vector("normals_cube")) as clip:
        assert [crc(frame.mesh.normals, "<f4") for frame in clip] == listed("normals_cube")
        assert [frame.mesh.has_normals for frame in clip] == [True] * 5 + [False] * 5


def test_colours():
    with fvv.open(vector("colours_sheet")) as clip:
        found = ["none" if (c := frame.mesh.colours) is None else crc(c, "u1") for frame in clip]
    assert found == listed("colours_sheet")


def test_cameras_that_move():
    lines = []
    with fvv.open(vector("calibration_moving")) as clip:
        for frame in clip:
            for camera in frame.cameras.values():
                K = camera.K
                numbers = [K[0, 0], K[1, 1], K[0, 2], K[1, 2], K[0, 1], *camera.distortion, camera.r_max]
                packed = struct.pack("<26d", *numbers, *camera.R.ravel(), *camera.t)
                lines.append(f"{frame.ticks} {camera.id} {crc32c(packed):08x}")
                assert camera.moves
    assert sorted(lines) == sorted(listed("calibration_moving"))


@pytest.mark.parametrize("name", ["visibility_moving", "visibility_sheet", "visibility_weights"])
def test_visibility(name):
    stream = (vector(name)).read_bytes()
    # Clause 17.4: the weights of the states, in order.
    table = numpy.array([127, 0, 255, 85, 170, 113, 142], numpy.uint8)
    decoded = list(visibility.decode(stream))
    first = min(track for track, _ in decoded)
    expected = [
        {camera: table[list(states)] for camera, states in found.items()}
        for track, found in decoded
        if track == first
    ]
    with fvv.open(stream) as clip:
        seen = 0
        for frame in clip:
            weights = {i: w for i in frame.cameras if (w := frame.visibility(i)) is not None}
            if not weights:
                continue
            assert weights.keys() == expected[seen].keys()
            for camera, found in weights.items():
                assert found.dtype == numpy.uint8 and not found.flags.writeable
                assert found.shape == (frame.mesh.vertex_count,)
                assert (found == expected[seen][camera]).all()
            seen += 1
    assert seen == len(expected)


def test_openexr():
    stream = (vector("openexr_bars")).read_bytes()
    samples = container.payloads(stream, b"VPKT")
    with fvv.open(stream) as clip:
        assert len(clip) == len(samples)
        for frame, sample in zip(clip, samples):
            picture = frame.pictures[3]
            assert picture.pixels.dtype == numpy.float16 and picture.pixels.shape == (21, 22, 3)
            assert picture.pixels.astype("<f2").tobytes() == openexr.read(sample)
            assert picture.source == (0, 0, 22, 21) and not picture.pixels.flags.writeable


def test_layouts_of_groups():
    lines = []
    with fvv.open(vector("tiles_crops")) as clip:
        groups = {}
        for frame in clip:
            groups.setdefault(frame._located()[2], frame)
        for group, frame in groups.items():
            for camera in sorted(frame._stream.picture_cameras(frame.index)):
                lines.append((group, camera))
        # Only what a header needs of each sample is there: it cannot be decoded.
        with pytest.raises(fvv.DamagedError):
            clip[0].pictures[0].pixels  # noqa: B018
    assert lines == sorted(tuple(map(int, line.split()[:2])) for line in listed("tiles_crops", ".txt"))


def test_sound():
    with fvv.open(vector("audio_two_sounds")) as clip:
        clap, steps = clip.audio
        assert (clap.title, clap.codec, clap.rate, clap.language) == ("clap", "opus", 48000, "en-GB")
        assert len(clap.packets) == 12 and clap.packets_start == 0 and clap.position is None
        samples = clap.samples()
        assert samples.dtype == numpy.float32 and samples.shape == (12 * 960, 1)
        assert clap.duration == 0.24 and numpy.abs(samples).max() < 1e-6
        assert [(t.id, t.kind, t.alternate_group, t.rank) for t in clip.tracks] == [
            (1, "mesh", 1, 0),
            (2, "mesh", 1, 1),
            (3, "audio", 0, 0),
            (4, "audio", 0, 0),
        ]
        assert [r.tracks for r in clip.rungs] == [(1, 3, 4), (2, 3, 4)]
        assert clip[0].mesh.track == 1
    with fvv.open(vector("audio_two_sounds"), rung=1) as clip:
        assert clip[0].mesh.track == 2 and list(clip[0].meshes) == [2]


@pytest.mark.parametrize("path", VECTORS, ids=name_of)
def test_every_vector_is_whole(path):
    found = fvv.check(path)
    assert found.ok and found.frames == found.whole_frames and found.bytes == path.stat().st_size
    if found.frames:
        with fvv.open(path) as clip:
            assert len(clip) == found.frames and clip.problems == []
            assert all(frame.intact for frame in clip)


def listed_environment(environment):
    """The lines of conformance/reference/environment.py but for the first two."""
    for part in environment.parts:
        flags = part.unlit + 2 * part.double_sided + 4 * part.clamped
        colour = [round(65535 * c) for c in part.colour]
        yield f"part picture {'none' if part.picture is None else part.picture} colour {colour} flags {flags}"
        mesh = part.mesh
        for i, p in enumerate((mesh.origin + mesh.step * mesh.lattice).tolist()):
            place = "" if part.uvs is None else f" shows {part.uvs[i, 0]} {part.uvs[i, 1]}"
            yield f"vertex {p[0]} {p[1]} {p[2]}{place}"
        yield from (f"face {a} {b} {c}" for a, b, c in mesh.indices)
    for light in environment.lights:
        yield (
            f"light {light.kind} shadows {light.casts_shadows:d} position {list(light.position)} direction "
            f"{list(light.direction)} colour {list(light.colour)} intensity {light.intensity} range {light.range} "
            f"cone {light.inner_cone} {light.outer_cone}"
        )


def test_environment():
    expected = listed("environment_stage", ".txt")
    pictures = [line for line in expected if line.startswith("picture")]
    with fvv.open(vector("environment_stage")) as clip:
        # It is sent in the first group and holds for the second one.
        environments = [frame.environment for frame in clip]
        unread = clip[0]
    for environment in environments:
        assert list(listed_environment(environment)) == [
            line for line in expected[2:] if line not in pictures
        ]
        for line, file in zip(pictures, environment.pictures):
            assert f"of {len(file)} bytes, CRC-32 {zlib.crc32(file):08x}" in line
        assert len(environment.pictures) == len(pictures) == 2
    with pytest.raises(fvv.UsageError, match="closed"):
        unread.environment  # noqa: B018
    with fvv.open(vector("delta_field")) as clip:
        assert clip[0].environment is None
    few = fvv.Limits(max_vertices=3)
    with fvv.open(vector("environment_stage"), limits=few) as clip, pytest.raises(fvv.LimitError):
        clip[0].environment  # noqa: B018
