"""fvvsynth --atlas: tracked meshes with texture coordinates and a texture map, through the whole chain."""

import json

import numpy as np
import pytest
from conftest import figures, run
from PIL import Image
from real_capture import luma, read_ply, read_ply_texture, triangle_set

FRAMES = 3
SMALL = ("--rig", "small", "--frames", FRAMES)


def files(folder):
    paths = [path for path in folder.rglob("*") if path.is_file() and path.name != ".fvv-output"]
    return {path.relative_to(folder).as_posix(): path for path in paths}


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("atlas") / "players"
    run("fvvsynth", "-o", folder, *SMALL, "--atlas", "--visibility", "--threads", 1)
    return folder


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bare") / "players"
    run("fvvsynth", "-o", folder, *SMALL, "--visibility")
    return folder


def test_the_atlas_changes_only_the_vertices_of_meshes(capture, bare):
    with_atlas, without = files(capture), files(bare)
    assert set(with_atlas) == set(without) | {"atlas.png"}
    description = json.loads(with_atlas["capture.json"].read_text())
    assert description.pop("atlas") == {"pictures": "atlas.png"}
    assert description == json.loads(without["capture.json"].read_text())
    for name, path in without.items():
        if name.startswith("meshes/"):
            (positions, faces), (opened, corners) = read_ply(path), read_ply(with_atlas[name])
            assert np.array_equal(positions[faces], opened[corners])
            assert np.array_equal(opened[: len(positions)], positions), "copies follow the vertices"
        elif name.startswith("visibility/vertices_"):
            opened = read_ply(with_atlas[name.replace("visibility/vertices_", "meshes/")[:-3] + "ply"])[0]
            seen = np.load(with_atlas[name])
            assert seen.shape == (7, len(opened))
            assert np.array_equal(seen[:, : np.load(path).shape[1]], np.load(path))
        elif name != "capture.json":
            assert path.read_bytes() == with_atlas[name].read_bytes(), name


def test_texture_coordinates_are_inside_the_atlas_and_the_same_in_all_frames(capture):
    first = read_ply_texture(capture / "meshes/0000.ply")
    assert first.min() > 0 and first.max() < 1
    faces = read_ply(capture / "meshes/0000.ply")[1]
    for frame in range(1, FRAMES):
        path = capture / f"meshes/{frame:04d}.ply"
        assert np.array_equal(read_ply_texture(path), first)
        assert np.array_equal(read_ply(path)[1], faces)


@pytest.mark.long
def test_the_same_bytes_for_any_number_of_threads(capture, tmp_path):
    run("fvvsynth", "-o", tmp_path / "again", *SMALL, "--atlas", "--visibility", "--threads", 3)
    again = files(tmp_path / "again")
    assert {k: v.read_bytes() for k, v in again.items()} == {
        k: v.read_bytes() for k, v in files(capture).items()
    }


@pytest.mark.parametrize(
    "codec, rate, size, limit, scale",
    [
        ("jpeg", 25, (8200, 16), "8192x8192 and 67108864 pixels (textures of browsers)", "0.99"),
        # 1,000 frames/s leave level 5.2 of H.264 2,073,600 macroblocks / 1000 for each.
        ("h264", 1000, (800, 800), "8192x8192 and 530841 pixels (H.264 level 5.2)", "0.91"),
    ],
)
def test_an_atlas_beyond_the_limits_of_decoders_is_warned_of(tmp_path, codec, rate, size, limit, scale):
    Image.new("RGB", size, (90, 120, 30)).save(tmp_path / "atlas.png")
    (tmp_path / "mesh.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
        "f 1/1 3/2 2/3\nf 1/1 2/2 4/3\nf 1/1 4/2 3/3\nf 2/1 3/2 4/3\n"
    )
    description = {
        "fvv_capture": 1,
        "name": "solid",
        "frame_rate": str(rate),
        "frames": {"first": 0, "count": 1},
        "units": "metres",
        "up": "+y",
        "meshes": {"pattern": "mesh.obj"},
        "atlas": {"pictures": "atlas.png"},
        "cameras": [],
    }
    (tmp_path / "capture.json").write_text(json.dumps(description))
    command = ["fvvmux", tmp_path, "--codec", codec, "--quality", "40", "-o", tmp_path / "x.fvv", "--force"]
    warning = run(*command, code=3).stderr
    assert warning.startswith(f"fvvmux: warning: {tmp_path}/capture.json: ") and warning.count("\n") == 1
    for value in f"{size[0]}x{size[1]} pixels", limit, f"--atlas-scale {scale}":
        assert value in warning
    run(*command, "--atlas-scale", scale)


def chromaticities(picture, x, y):
    """r and g of r + g + b = 1 in linear light at pixel positions whose fraction is dropped."""
    light = np.asarray(picture.convert("RGB"), np.float64)[y.astype(int), x.astype(int)] ** 2 + 1
    return (light / light.sum(1, keepdims=True))[:, :2]


def test_cameras_see_the_colours_of_the_atlas(capture):
    """By pinholes and look-ups of this test alone, in pictures that are lit and the atlas that is not."""
    atlas = Image.open(capture / "atlas.png")
    description = json.loads((capture / "capture.json").read_text())
    positions, faces = read_ply(capture / "meshes/0001.ply")
    texture = read_ply_texture(capture / "meshes/0001.ply")
    seen = np.load(capture / "visibility/faces_0001.npy")
    for row, camera in enumerate(description["cameras"]):
        there = faces[seen[row]]
        points = positions[there].mean(1) @ np.array(camera["rotation"]).T + camera["translation"]
        k = camera["intrinsics"]
        x = k["fx"] * points[:, 0] / points[:, 2] + k["cx"]
        y = k["fy"] * points[:, 1] / points[:, 2] + k["cy"]
        pictured = chromaticities(Image.open(capture / (camera["pictures"] % 1)), x, y)

        def error(u, v, pictured=pictured):
            return np.median(np.abs(chromaticities(atlas, u * atlas.width, v * atlas.height) - pictured))

        u, v = texture[there].mean(1).T
        assert len(there) > 5000
        assert error(u, v) < 0.015
        assert error(u, 1 - v) > 0.08 and error(1 - u, v) > 0.08, "a mirrored atlas would be noticed"


def farthest(folders, name, bits):
    """The largest distance on an axis from a vertex of the second mesh to the nearest of the first with its texture indices."""
    there = {}
    (source, decoded) = (
        zip(np.rint(read_ply_texture(f / name) * 2**bits).astype(int).tolist(), read_ply(f / name)[0])
        for f in folders
    )
    for index, position in source:
        there.setdefault(tuple(index), []).append(position)
    return max(np.abs(np.array(there[tuple(index)]) - p).max(1).min() for index, p in decoded)


@pytest.mark.parametrize("options", [[], pytest.param(["--no-delta"], marks=pytest.mark.long)])
def test_into_a_stream_and_out_of_it(capture, tmp_path, options):
    stream, out = tmp_path / "players.fvv", tmp_path / "out"
    summary = figures("fvvmux", capture, "-o", stream, "--verify", *options)
    assert summary["mesh"]["delta"]["frames"] == (0 if options else FRAMES - 1)
    assert summary["verified"]["atlas"]["pictures"] == FRAMES
    bits = summary["atlas"]["texture_bits"]

    info = figures("fvvinfo", "--check", stream)["files"][0]
    assert (info["integrity"], info["whole_frames"]) == ("complete", FRAMES)
    assert [track["kind"] for track in info["tracks"]] == ["mesh", "video", "video", "visibility"]

    run("fvvdemux", stream, "-o", out)
    assert json.loads((out / "capture.json").read_text())["atlas"]["texture_bits"] == bits
    step = info["scene"]["lattice_step"]
    off = (0.5 + summary["mesh"]["delta"]["max_error_steps"]) * step
    source_atlas = luma(capture / "atlas.png")
    for frame in range(FRAMES):
        # Corners as points in five dimensions: position and texture coordinates.
        name = f"meshes/{frame:04d}.ply"
        is_delta = frame > 0 and not options
        scale = np.array([0 if is_delta else 1 / step] * 3 + [2**bits] * 2)
        triangles = []
        for folder in capture, out:
            positions, faces = read_ply(folder / name)
            corners = np.hstack([positions, read_ply_texture(folder / name)]) * scale
            triangles.append(triangle_set(corners, faces, 1))
        source, decoded = triangles
        assert decoded <= source
        assert len(decoded) > 0.999 * len(source)
        assert farthest((capture, out), name, bits) < off * (1 + 1e-6)
        error = luma(out / f"atlas/{frame:04d}.png") - source_atlas
        assert 10 * np.log10(255**2 / (error**2).mean()) > 41.5


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("--atlas", "--meshes", "hull"),
            "--atlas: expected with --meshes tracked only, found --meshes hull",
        ),
        (("--atlas-size", "512"), "--atlas-size: expected with --atlas only"),
        (("--atlas", "--atlas-size", "1000"), "--atlas-size"),
    ],
)
def test_options_that_do_not_go_together(tmp_path, arguments, message):
    done = run("fvvsynth", "-o", tmp_path / "out", *arguments, code=2)
    assert message in done.stderr
    assert not (tmp_path / "out").exists()
