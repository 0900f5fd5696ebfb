"""Pictures from anywhere and comparisons: the pixels of fvvrender, the figures of fvvcompare."""

import json
import math
import threading

import fvv
import numpy
import pytest
from conftest import tool
from PIL import Image
from reference import container
from vectors import path_of as vector

EYE, TARGET = (2.0, 1.4, 3.0), (0.0, 0.9, 0.0)


def drawn(players, folder, *arguments):
    """What fvvrender draws."""
    out = folder / "drawn.png"
    tool("fvvrender", players, "-o", out, "--force", *arguments)
    return numpy.asarray(Image.open(out))


CASES = [
    ({"pose": 1}, ["--camera", 1]),
    ({"pose": "cam2", "frame": 7, "samples": 3}, ["--camera", 2, "--frame", 7, "--samples", 3]),
    ({"pose": 0, "exclude": [0], "size": (80, 48)}, ["--camera", 0, "--leave-one-out", "--size", "80x48"]),
    (
        {"pose": (EYE, TARGET), "size": (96, 64), "focal": 80, "frame": -1},
        ["--pose", "2,1.4,3,0,0.9,0", "--size", "96x64", "--focal", 80, "--frame", 11],
    ),
    (
        {"pose": (EYE, TARGET, (0.1, 0, 1)), "size": (64, 64), "sources": ["cam0", 2], "blend": "paper",
         "visible_by": "depth", "best": 1, "unseen": (255, 0, 128), "background": (0, 40, 255), "frame": 3},
        ["--pose", "2,1.4,3,0,0.9,0,0.1,0,1", "--size", "64x64", "--sources", "0,2", "--blend", "paper",
         "--visible-by", "depth", "--best", 1, "--unseen", "255,0,128", "--background", "0,40,255", "--frame", 3],
    ),
    ({"pose": 1, "pictures": False, "environment": False}, ["--camera", 1, "--no-pictures", "--no-environment"]),
]  # fmt: skip


@pytest.mark.parametrize("ours, theirs", CASES, ids=[str(i) for i in range(len(CASES))])
def test_pixels_are_those_of_fvvrender(players, tmp_path, ours, theirs):
    ours = {"frame": 0, **ours}
    expected = drawn(players, tmp_path, *theirs)
    with fvv.open(players) as clip:
        found = fvv.render(clip, ours.pop("frame"), ours.pop("pose"), **ours)
    assert found.dtype == numpy.uint8 and found.shape == expected.shape
    assert (found == expected).all() and found.std() > 5


def test_a_camera_and_a_frame_may_be_objects(players):
    content = players.read_bytes()
    with fvv.open(content) as clip, fvv.open(players) as other:
        frame = clip[4]
        expected = fvv.render(other, 4, 2)
        assert (fvv.render(clip, frame, frame.cameras[2]) == expected).all()
        assert (fvv.render(clip, frame, 2, threads=1) == expected).all()
        with pytest.raises(fvv.UsageError, match="this clip"):
            fvv.render(other, frame, 2)
    with fvv.open(players, rung=1) as small:
        assert (fvv.render(small, 4, 2) != expected).any()


def test_layers(players):
    with fvv.open(players) as clip:
        camera, mesh = clip[0].cameras[1], clip[0].mesh
        found = fvv.render(clip, 0, 1, layers=True)
        assert (found.pixels == fvv.render(clip, 0, 1)).all()
        assert (numpy.floor(found.values.clip(0, 1).astype(float) * 255 + 0.5) == found.pixels).all()
        assert found.sources == (0, 1, 2) and found.losses == () and found.warnings == ()
        surface = numpy.isfinite(found.depth)
        assert 0.01 < surface.mean() < 0.9
        sums = found.weights.sum(axis=2)
        assert found.weights.shape == (*found.depth.shape, 3) and set(sums[~surface]) == {0}
        assert numpy.abs(sums[sums > 0] - 1).max() < 1e-5
        # Depth and mesh are one surface: points of the depth map lie within the mesh's box, and none is before a vertex.
        rows, columns = numpy.nonzero(surface)
        points = camera.unproject(numpy.stack([columns, rows], 1) + 0.5, found.depth[surface])
        low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
        assert (points > low - 1e-3).all() and (points < high + 1e-3).all()


def test_a_source_of_ones_own_and_threads(players):
    content, reads = players.read_bytes(), []

    class Ranges:
        size = len(content)

        def read_at(self, offset, size):
            reads.append(size)
            if broken:
                raise KeyError("gone")
            return content[offset : offset + size]

    broken = False
    with fvv.open(players) as clip:
        expected = [fvv.render(clip, i, 0) for i in (3, 8)]
    with fvv.open(Ranges()) as clip:
        before = len(reads)
        found = {}

        def work(place, index):
            found[place] = fvv.render(clip, index, 0)

        threads = [threading.Thread(target=work, args=pair) for pair in enumerate((3, 8))]
        for thread in threads:
            thread.start()
        meshes = [frame.mesh.vertex_count for frame in clip]
        for thread in threads:
            thread.join()
        assert len(meshes) == 12 and len(reads) > before
        assert all((found[place] == picture).all() for place, picture in enumerate(expected))
        # The frame that was drawn last is kept: other poses read nothing.
        again, before = fvv.render(clip, 3, 0), len(reads)
        assert (again == expected[0]).all() and fvv.render(clip, 3, 1).any() and len(reads) == before
        fvv.render(clip, 8, 0)
        broken = True
        with pytest.raises(KeyError, match="gone"):
            fvv.render(clip, 3, 0)
        with pytest.raises(KeyError, match="gone"):
            fvv.compare(clip, clip)
    with pytest.raises(fvv.UsageError, match="closed"):
        fvv.render(clip, 3, 0)
    with pytest.raises(fvv.UsageError, match="closed"):
        fvv.compare(clip, players)


WRONG = [
    ({"pose": 9}, "pose: camera 9 is not in the stream"),
    ({"pose": "cam9"}, "pose: camera cam9"),
    ({"pose": (EYE,)}, "pose: expected"),
    ({"pose": (EYE, "abc")}, "pose: expected"),
    ({"pose": (EYE, EYE)}, "pose: eye and target are the same point"),
    ({"pose": (EYE, (math.nan, 0, 0))}, "pose: expected numbers within 1e9"),
    ({"sources": [0, 77]}, "sources: camera 77"),
    ({"sources": []}, "sources: expected a camera"),
    ({"exclude": [0, 1, 2]}, "no camera is left"),
    ({"samples": 2}, "samples: expected 1, 3, 5 or 7, found 2"),
    ({"size": (0, 5)}, "size: expected"),
    ({"focal": 5.0}, "focal: expected with"),
    ({"blend": "mean"}, "blend: expected one of viewer, paper"),
    ({"visible_by": "eye"}, "visible_by: expected one of"),
    ({"best": 9}, "best: expected 1 to 8"),
    ({"background": (0, 0, 256)}, "background: expected three numbers"),
]


@pytest.mark.parametrize("given, message", WRONG, ids=[message.split(":")[0] for _, message in WRONG])
def test_arguments_of_render(players, given, message):
    given = {"pose": 0, **given}
    with fvv.open(players) as clip, pytest.raises(fvv.Error, match=message) as caught:
        fvv.render(clip, 0, given.pop("pose"), **given)
    assert isinstance(caught.value, fvv.UsageError) or "no camera is left" in message


def test_damage_and_limits(players):
    content = bytearray(players.read_bytes())
    sample = max(container.payloads(bytes(content), b"VPKT")[:12], key=len)
    content[content.index(sample) + 20] ^= 255
    with fvv.open(bytes(content)) as clip:
        losses = {i: fvv.render(clip, i, 0, layers=True).losses for i in range(len(clip))}
        lost = min(i for i, lines in losses.items() if lines)
        with pytest.warns(RuntimeWarning, match="no picture of camera"):
            found = fvv.render(clip, lost, 0)
    with fvv.open(players) as clip:
        assert (fvv.render(clip, lost, 0) != found).any()
    with fvv.open(players, limits=fvv.Limits(max_picture_memory=1000)) as clip:
        with pytest.raises(fvv.LimitError, match="max_picture_memory"):
            fvv.render(clip, 0, 0)
        assert fvv.render(clip, 0, 0, pictures=False).any()
    with fvv.open(players, limits=fvv.Limits(max_faces=5)) as clip, pytest.raises(fvv.LimitError) as caught:
        fvv.render(clip, 0, 0)
    assert caught.value.chunk == "MESH" and caught.value.file == str(players)


# Comparison.


def as_json(value):
    """A result of fvv.compare with the names and values of fvvcompare's JSON."""
    if isinstance(value, dict):
        return {name: as_json(one) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [as_json(one) for one in value]
    return None if value == math.inf else value


@pytest.fixture(scope="module")
def coarse(players):
    """The players on a coarser lattice."""
    out = players.parent / "coarse.fvv"
    tool("fvvmux", players.parent / "capture/capture.json", "-o", out, "--keep-geometry", "--step", "10mm",
         "--no-sound", "--visibility", "none", "--codec", "jpeg")  # fmt: skip
    return out


def test_figures_are_those_of_fvvcompare(players, coarse):
    import dataclasses

    expected = json.loads(
        tool(
            "fvvcompare",
            players,
            coarse,
            "--json",
            "--samples",
            2000,
            "--frames",
            "2-7",
            "--points",
            "samples",
        )
    )
    with fvv.open(players) as a, fvv.open(coarse.read_bytes()) as b:
        steps = []
        found = fvv.compare(
            a,
            b,
            range(2, 8),
            samples=2000,
            points="samples",
            progress=lambda done, pairs: steps.append((done, pairs)),
        )
        assert fvv.compare(players, coarse, range(2, 8), samples=2000, points="samples", threads=1) == found
    assert steps == [(i, 6) for i in range(7)]
    ours = as_json(dataclasses.asdict(found))
    for name in (
        "unit",
        "peak",
        "distance",
        "d1",
        "d2",
        "normals",
        "turned",
        "temporal",
        "frames",
        "losses",
        "warnings",
    ):
        assert ours[name] == expected[name], name
    assert (found.frames_a, found.frames_b) == (expected["a"]["frames"], expected["b"]["frames"]) == (12, 12)
    assert 1e-3 < found.distance.symmetric.rms < 5e-3 and found.temporal.pairs == 5


def test_meshes_and_arrays(players, coarse):
    with fvv.open(players) as a, fvv.open(coarse) as b:
        meshes = [[frame.mesh for frame in clip[2:4]] for clip in (a, b)]
        clips = fvv.compare(a, b, range(2, 4), samples=500)
        assert fvv.compare(*meshes, samples=500).distance == clips.distance
        assert fvv.compare(meshes[0][0], meshes[1][0], samples=500).distance == clips.frames[0].distance
        assert fvv.compare(a, meshes[1], samples=500, start=2).distance == clips.distance
        mesh = meshes[0][1]
    moved = mesh.positions.astype(float) + (0, 0, 0.25)
    found = fvv.compare(
        (mesh.positions, mesh.indices), (moved, mesh.indices.astype(int)), samples=500, peak=1
    )
    # No point is nearer to a surface that has moved than the surface has moved.
    assert 0.02 < found.distance.symmetric.rms < found.distance.symmetric.max <= 0.25 + 1e-9
    assert found.peak == 1 and found.unit == "metres" and found.temporal is None
    same = fvv.compare(mesh, mesh, samples=500)
    assert same.distance.symmetric.max < 1e-6 and same.d1.symmetric.psnr == math.inf


def test_a_stream_without_pictures_is_drawn(tmp_path):
    with fvv.Writer(tmp_path / "meshes.fvv", rate=25) as writer:
        writer.add(
            ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
        )
    with fvv.open(tmp_path / "meshes.fvv") as clip:
        drawn = fvv.render(clip, 0, ((2, 2, 2), (0.3, 0.3, 0.3)), size=(64, 48))
        assert drawn[24, 32].any() and not drawn[0, 0].any()
        with pytest.raises(fvv.DamagedError, match="no camera is left"):
            fvv.render(clip, 0, ((2, 2, 2), (0.3, 0.3, 0.3)), size=(64, 48), pictures=True)


def test_arguments_of_compare(players):
    mesh = ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    bad = ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 3)])
    assert fvv.compare(mesh, mesh, samples=10).distance.symmetric.max < 1e-12
    wrong = [
        (mesh, 5, {}, "b: expected a path"),
        (mesh, [], {}, "b: expected a path"),
        (mesh, bad, {}, "b: "),
        (mesh, ([(0, 0)], [(0, 0, 0)]), {}, r"b: positions: expected float32 or float64 \(vertices, 3\)"),
        (mesh, (mesh[0], [(0.5, 1, 2)]), {}, "b: indices: expected integers"),
        (players, players, {"frames": 99}, "frames: expected a frame of"),
        (players, players, {"frames": range(0, 9, 2)}, "frames: expected"),
        (players, players, {"samples": 0}, "samples: expected"),
        (players, players, {"points": "faces"}, "points: expected"),
        (players, players, {"peak": 0}, "peak: expected"),
    ]
    for a, b, options, message in wrong:
        with pytest.raises(fvv.UsageError, match=message):
            fvv.compare(a, b, **options)
    with pytest.raises(fvv.Error, match="unlike frame rates"):
        fvv.compare(players, vector("normals_cube"))
    with pytest.raises(FileNotFoundError):
        fvv.compare(players, players.parent / "absent.fvv")
    with pytest.raises(ZeroDivisionError):
        fvv.compare(players, players, samples=10, progress=lambda done, pairs: 1 // (2 - done))
