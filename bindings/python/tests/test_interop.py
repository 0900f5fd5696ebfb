"""Converters to and from other packages: what the other package reads is what the clip has."""

import gc
import importlib
import io
import os
import subprocess
import sys

import fvv
import numpy
import pytest
from conftest import CONFORMANCE, tool
from scenes import ball
from vectors import path_of as vector

MOVING = vector("calibration_moving")
SHAPES = vector("fast_shapes")  # texture coordinates, and faces that change
CUBE = vector("normals_cube")  # normals are sent in five frames
RNG = numpy.random.default_rng(1)


def optional(module):
    """A package that is too large for tests/requirements.txt."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        pytest.skip(f"{error}; {module} is too large for tests/requirements.txt")


def seen_by(camera, count=50):
    """Points before a camera: (count, 3) metres."""
    pixels = RNG.uniform((0, 0), (camera.width, camera.height), (count, 2))
    return camera.unproject(pixels, RNG.uniform(1, 5, count))


@pytest.fixture(scope="module")
def textured(tmp_path_factory):
    """Two frames with an atlas and texture coordinates."""
    folder = tmp_path_factory.mktemp("textured")
    tool("fvvsynth", "-o", folder / "capture", "--rig", "small", "--cameras", 2, "--size", "96x64", "--frames", 2,
         "--atlas", "--atlas-size", 512)  # fmt: skip
    tool("fvvmux", folder / "capture/capture.json", "-o", folder / "out.fvv", "--keep-geometry")
    return folder / "out.fvv"


def stream_of(mesh):
    target = io.BytesIO()
    with fvv.Writer(target, rate=25, keep_geometry=True, step="1mm") as writer:
        writer.add(mesh)
    return target.getvalue()


@pytest.mark.parametrize("origin", [(441548.0, 5121948.0, 2345.0), (4075580.0, -931853.0, 4801568.0)])
def test_positions_far_from_0_keep_their_shape(origin):
    """Those of UTM and of the earth's centre: float32 has decimetres there."""
    points, faces = ball()
    content = stream_of((points + origin, faces))
    with fvv.open(content) as clip:
        mesh = clip[0].mesh
        again = stream_of(mesh)
    radii = numpy.linalg.norm(mesh.positions - origin, axis=1)
    assert mesh.positions.dtype == numpy.float64 and numpy.abs(radii - 0.5).max() < 1e-3
    assert numpy.abs(mesh.positions - (mesh.origin + mesh.step * mesh.lattice)).max() < 1e-8
    assert abs(mesh.to_trimesh().area - numpy.pi) < 0.1
    with fvv.open(again) as clip:
        distances = numpy.abs(clip[0].mesh.positions[:, None] - mesh.positions[None]).max(axis=2)
    assert distances.min(axis=0).max() < 1e-3


# trimesh.


def test_meshes_in_trimesh(players):
    with fvv.open(players) as clip:
        mesh = clip[0].mesh
    found = mesh.to_trimesh()
    assert (found.vertices == mesh.positions).all() and (found.faces == mesh.indices).all()
    assert (found.visual.vertex_colors[:, :3] == mesh.colours).all()
    assert found.metadata["track"] == mesh.track
    with fvv.open(CUBE) as clip:
        sent, computed = clip[0].mesh, clip[9].mesh
    assert numpy.abs(sent.to_trimesh().vertex_normals - sent.normals).max() < 1e-6
    assert (
        "vertex_normals" in sent.to_trimesh()._cache and "vertex_normals" not in computed.to_trimesh()._cache
    )


def test_textures_in_trimesh(textured):
    with fvv.open(textured) as clip:
        mesh, atlas = clip[0].mesh, clip[0].atlas
    found = mesh.to_trimesh(atlas)
    picture = numpy.asarray(found.visual.material.image)
    assert (picture == atlas.pixels).all()
    # trimesh's own way from texture coordinates to colours finds the pixels that the format means.
    colours = found.visual.material.to_color(found.visual.uv)[:, :3]
    height, width, _ = picture.shape
    at = (mesh.uvs * (width - 1, height - 1)).round().astype(int)
    ours = picture[at[:, 1], at[:, 0]]
    assert (numpy.abs(colours.astype(int) - ours) <= 2).all(axis=1).mean() > 0.95
    back = fvv.interop.mesh_from_trimesh(found)
    assert numpy.abs(back.uvs - mesh.uvs).max() < 1e-6 and (back.indices == mesh.indices).all()


def test_frames_are_scenes_of_trimesh(players):
    with fvv.open(players) as clip:
        frame = clip[3]
        scene = frame.to_trimesh()
        cameras = dict(frame.cameras.items())
        mesh = frame.mesh
    assert list(scene.metadata["cameras"]) == [camera.name for camera in cameras.values()]
    assert scene.camera.name == cameras[0].name
    for camera in cameras.values():
        theirs = scene.metadata["cameras"][camera.name]
        to_world, _ = scene.graph[camera.name]
        points = seen_by(camera)
        local = numpy.linalg.inv(to_world) @ numpy.vstack([points.T, numpy.ones(len(points))])
        # It looks along -z with y up; its principal point is the picture's centre.
        across = theirs.K @ (local[:3] * [[1], [-1], [-1]])
        pixels = (across[:2] / across[2]).T + camera.K[:2, 2] - theirs.resolution / 2
        assert (local[2] < 0).all() and numpy.abs(pixels - camera.project(points)).max() < 1e-9
    back = fvv.interop.mesh_from_trimesh(scene)
    assert (back.positions == mesh.positions).all() and (back.indices == mesh.indices).all()
    assert fvv.compare(mesh, tuple(back), samples=100).distance.symmetric.max < 1e-6


def test_meshes_from_trimesh():
    import trimesh

    box = trimesh.creation.box((1, 2, 3))
    box.vertex_normals = box.vertices / numpy.linalg.norm(box.vertices, axis=1)[:, None]
    found = fvv.interop.mesh_from_trimesh(box, normals=True)
    assert numpy.shares_memory(found.positions, box.vertices) and found.uvs is None
    assert (found.normals == box.vertex_normals).all() and len(found.normals) == 8
    scene = trimesh.Scene()
    scene.add_geometry(box)
    scene.add_geometry(box, transform=trimesh.transformations.translation_matrix((5, 0, 0)))
    both = fvv.interop.mesh_from_trimesh(scene)
    assert both.positions[:, 0].max() == 5.5 and both.indices.shape == (24, 3)
    for wrong in (trimesh.Scene(), "box"):
        with pytest.raises(fvv.UsageError):
            fvv.interop.mesh_from_trimesh(wrong)


# USD.


def stage_of(clip, path, **options):
    from pxr import Usd

    clip.to_usd(path, **options)
    return Usd.Stage.Open(str(path))


def usd_pixels(stage, identifier, code, points):
    """Where USD's own camera projects points, in pixels."""
    from pxr import Gf, UsdGeom

    prim = UsdGeom.Camera.Get(stage, f"/fvv/cameras/camera_{identifier}")
    frustum = prim.GetCamera(code).frustum
    matrix = numpy.array(frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix())
    root = numpy.array(UsdGeom.Xformable(stage.GetDefaultPrim()).ComputeLocalToWorldTransform(code))
    clipped = numpy.hstack([points, numpy.ones((len(points), 1))]) @ root @ matrix
    assert isinstance(frustum.GetPosition(), Gf.Vec3d)
    places = clipped[:, :2] / clipped[:, 3:]
    size = [prim.GetPrim().GetAttribute(f"fvv:{side}").Get(code) for side in ("width", "height")]
    return (places * (1, -1) + 1) / 2 * size


def faults_of(path):
    """What USD itself finds wrong with a file: its checks are validators since 26.11 at the latest."""
    from pxr import Usd, UsdUtils

    if hasattr(UsdUtils, "ComplianceChecker"):
        checker = UsdUtils.ComplianceChecker(skipARKitRootLayerCheck=True)
        checker.CheckCompliance(str(path))
        return checker.GetErrors() + checker.GetFailedChecks() + checker.GetWarnings()
    from pxr import UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    found = UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(str(path)))
    return [f"{one.GetName()}: {one.GetMessage()}" for one in found]


def test_tracked_meshes_in_usd(players, tmp_path):
    from pxr import UsdGeom

    with fvv.open(players) as clip:
        stage = stage_of(clip, tmp_path / "out.usdc")
        assert faults_of(tmp_path / "out.usdc") == []
        assert stage.GetTimeCodesPerSecond() == 25 == stage.GetFramesPerSecond()
        assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0, 11)
        assert UsdGeom.GetStageMetersPerUnit(stage) == 1 and UsdGeom.GetStageUpAxis(stage) == "Y"
        mesh = UsdGeom.Mesh.Get(stage, f"/fvv/mesh_{clip[0].mesh.track}")
        colour = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("displayColor")
        for frame in clip:
            ours = frame.mesh
            assert (numpy.array(mesh.GetPointsAttr().Get(frame.index)) == ours.positions).all()
            corners = numpy.array(mesh.GetFaceVertexIndicesAttr().Get(frame.index)).reshape(-1, 3)
            assert (corners == ours.indices).all()
            box = numpy.array(mesh.GetExtentAttr().Get(frame.index))
            assert (box == [ours.positions.min(axis=0), ours.positions.max(axis=0)]).all()
            light = numpy.array(colour.Get(frame.index)).astype(float)
            srgb = numpy.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
            assert (numpy.rint(srgb * 255) == ours.colours).all()
            for identifier, camera in frame.cameras.items():
                points = seen_by(camera)
                pixels = usd_pixels(stage, identifier, frame.index, points)
                assert numpy.abs(pixels - camera.project(points)).max() < 1e-3
        assert mesh.GetFaceVertexIndicesAttr().GetNumTimeSamples() == 1
        assert mesh.GetPointsAttr().GetNumTimeSamples() == 12
        assert mesh.GetSubdivisionSchemeAttr().Get() == "none"
        prim = UsdGeom.Camera.Get(stage, "/fvv/cameras/camera_0").GetPrim()
        assert prim.GetDisplayName() == clip[0].cameras[0].name


def test_meshes_that_change_in_usd(tmp_path):
    from pxr import UsdGeom

    with fvv.open(SHAPES) as clip:
        stage = stage_of(clip, tmp_path / "shapes.usda")
        assert (tmp_path / "shapes.usda").read_bytes().startswith(b"#usda")
        assert UsdGeom.GetStageUpAxis(stage) == "Z"
        mesh = UsdGeom.Mesh.Get(stage, "/fvv/mesh_1")
        st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st")
        for frame in clip:
            corners = numpy.array(mesh.GetFaceVertexIndicesAttr().Get(frame.index)).reshape(-1, 3)
            assert (corners == frame.mesh.indices).all()
            assert sum(mesh.GetFaceVertexCountsAttr().Get(frame.index)) == 3 * frame.mesh.face_count
            if frame.mesh.uvs is not None:
                uvs = numpy.array(st.Get(frame.index)) * (1, -1) + (0, 1)
                assert numpy.abs(uvs - frame.mesh.uvs).max() < 1e-6
        assert any(frame.mesh.uvs is not None for frame in clip)
    with fvv.open(CUBE) as clip:
        stage = stage_of(clip, tmp_path / "cube.usd", frames=slice(0, 5))
        normals = UsdGeom.Mesh.Get(stage, "/fvv/mesh_1").GetNormalsAttr()
        assert normals.GetTimeSamples() == [frame.time * float(clip.rate) for frame in clip[:5]]
        assert (numpy.array(normals.Get(clip[2].time * float(clip.rate))) == clip[2].mesh.normals).all()


def test_patches_in_usd(tmp_path):
    """Patches come, change and go between frames of one key mesh: points, faces and colours are those of each frame."""
    from pxr import UsdGeom

    with fvv.open(CONFORMANCE / "cases/valid/patched_colours/input.fvv") as clip:
        stage = stage_of(clip, tmp_path / "patched.usdc")
        mesh = UsdGeom.Mesh.Get(stage, "/fvv/mesh_1")
        colour = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("displayColor")
        assert len({frame.mesh.vertex_count for frame in clip}) > 1
        for frame in clip:
            assert (numpy.array(mesh.GetPointsAttr().Get(frame.index)) == frame.mesh.positions).all()
            corners = numpy.array(mesh.GetFaceVertexIndicesAttr().Get(frame.index)).reshape(-1, 3)
            assert (corners == frame.mesh.indices).all()
            assert sum(mesh.GetFaceVertexCountsAttr().Get(frame.index)) == 3 * frame.mesh.face_count
            assert len(colour.Get(frame.index)) == frame.mesh.vertex_count


@pytest.mark.parametrize("name", ["calibration_moving", "tiny_cameras", "visibility_moving"])
def test_cameras_that_move_in_usd(tmp_path, name):
    with fvv.open(vector(name)) as clip:
        stage = stage_of(clip, tmp_path / "moving.usdc")
        compared, moving = 0, False
        for frame in clip:
            for identifier, camera in frame.cameras.items():
                code = (frame.time - clip.start) * float(clip.rate)
                prim = stage.GetPrimAtPath(f"/fvv/cameras/camera_{identifier}")
                assert prim.GetAttribute("fvv:skew").Get(code) == camera.K[0, 1]
                assert prim.GetAttribute("fvv:lens").Get(code) == camera.lens
                assert numpy.allclose(prim.GetAttribute("fvv:distortion").Get(code), camera.distortion, 1e-12)
                moving |= camera.moves
                # Without what USD's cameras lack: by hand.
                points = seen_by(camera)
                x, y, z = camera.R @ points.T + camera.t[:, None]
                K = camera.K
                expected = numpy.stack([K[0, 0] * x / z + K[0, 2], K[1, 1] * y / z + K[1, 2]], 1)
                found = usd_pixels(stage, identifier, code, points)
                assert numpy.abs(found - expected)[z > 0].max() < 1e-3 * max(camera.width, 100) / 100
                compared += 1
        assert moving and compared >= 2 * len(clip) - 2


def test_any_axis_may_be_up(players, tmp_path, monkeypatch):
    from fvv.interop.conventions import turned
    from pxr import UsdGeom

    for up in ("+x", "+y", "+z", "-x", "-y", "-z"):
        axis = numpy.zeros(3)
        axis["xyz".index(up[1])] = 1 if up[0] == "+" else -1
        for to, expected in (("+y", (0, 1, 0)), ("+z", (0, 0, 1))):
            rotation = turned(up, to)
            assert (rotation @ axis == expected).all() and (rotation @ rotation.T == numpy.eye(3)).all()
            assert numpy.linalg.det(rotation) == 1
        with fvv.open(players) as clip:
            monkeypatch.setattr(fvv.Clip, "up", up)
            stage = stage_of(clip, tmp_path / f"{up}.usda", frames=slice(0, 1))
            monkeypatch.undo()
        root = UsdGeom.Xformable(stage.GetDefaultPrim()).ComputeLocalToWorldTransform(0)
        assert tuple(root.TransformDir(axis.tolist())) == ((0, 0, 1) if up == "+z" else (0, 1, 0))
        assert UsdGeom.GetStageUpAxis(stage) == ("Z" if up == "+z" else "Y")


def test_files_of_usd(players, tmp_path):
    with fvv.open(players) as clip:
        out = tmp_path / "out.usda"
        clip.to_usd(out, slice(0, 1))
        before = out.read_bytes()
        with pytest.raises(fvv.UsageError, match="already exists"):
            clip.to_usd(out, slice(0, 2))
        assert out.read_bytes() == before
        clip.to_usd(out, slice(0, 2), force=True)
        assert len(out.read_bytes()) > len(before)
        with pytest.raises(fvv.UsageError, match="usd, .usdc or .usda"):
            clip.to_usd(tmp_path / "out.obj")
        with pytest.raises(fvv.UsageError, match="expected a frame"):
            clip.to_usd(tmp_path / "none.usda", slice(5, 5))
        mask = os.umask(0)
        os.umask(mask)
        assert out.stat().st_mode & 0o777 == 0o666 & ~mask
    with pytest.raises(fvv.UsageError, match="closed"):
        clip.to_usd(tmp_path / "closed.usda")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.usda"]


# xarray and plain values.


def test_tracked_meshes_in_xarray(players):
    with fvv.open(players) as clip:
        found = clip.to_xarray(slice(2, 9, 3))
        assert dict(found.sizes)["time"] == 3 and list(found.camera) == [0, 1, 2]
        assert list(found.camera_name.values) == [camera.name for camera in clip[0].cameras.values()]
        for frame in clip[2:9:3]:
            here = found.sel(time=frame.time)
            assert (here.positions == frame.mesh.positions).all() and here.number == frame.number
            assert (here.colours == frame.mesh.colours).all()
            for identifier, camera in frame.cameras.items():
                one = here.sel(camera=identifier)
                assert (one.K == camera.K).all() and (one.t == camera.t).all() and one.width == camera.width
        assert (found.indices == clip[0].mesh.indices).all()
        assert (
            found.positions.units == "m" and found.time.units == "s" and found.attrs["topology"] == "constant"
        )
    assert "normals" not in found and found.positions.dtype == numpy.float32


def test_meshes_that_change_in_xarray():
    with fvv.open(SHAPES) as clip:
        found = clip.to_xarray()
        assert found.attrs["topology"] == "changes" and "positions" not in found
        assert list(found.vertex_count) == [frame.mesh.vertex_count for frame in clip]
        dicts = list(clip.to_dicts())
        for frame, one in zip(clip, dicts):
            assert one["time"] == frame.time and (one["mesh"]["indices"] == frame.mesh.indices).all()
            assert ("uvs" in one["mesh"]) == (frame.mesh.uvs is not None)
    with fvv.open(vector("tiles_crops")) as clip:
        found = clip.to_xarray()
        missing = [frame.mesh is None for frame in clip]
        assert any(missing) and (found.face_count == 0).values.tolist() == missing
        assert numpy.isnan(found.positions).all(("vertex", "axis")).values.tolist() == missing
    with fvv.open(MOVING) as clip:
        found = clip.to_xarray()
        for frame in clip:
            uncalibrated = numpy.isnan(found.K.sel(time=frame.time)).all(("row", "column"))
            assert uncalibrated.values.tolist() == [i not in frame.cameras for i in found.camera.values]


# imageio.


def test_imageio_reads_each_picture_by_its_number(players):
    import imageio.v3 as iio

    fvv.interop.imageio.register()
    fvv.interop.imageio.register()
    with fvv.open(players) as clip:
        for index in (7, 0, 11, -2):
            found = iio.imread(players, index=index, camera="cam1")
            assert (found == clip[index].pictures[1].whole()).all()
        assert (iio.imread(players) == clip[0].pictures[0].whole()).all()
        everything = iio.imread(players, index=..., camera=2)
        assert everything.shape == (12, 96, 160, 3) and (everything[5] == clip[5].pictures[2].whole()).all()
        assert [len(picture) for picture in iio.imiter(players, camera=0)] == [96] * 12
        properties = iio.improps(players, index=..., camera=2)
        assert (properties.shape, properties.dtype, properties.n_images) == (everything.shape, "uint8", 12)
        assert iio.improps(players, index=3).shape == (96, 160, 3)
        stream, frame = iio.immeta(players, index=...), iio.immeta(players, index=4, camera=1)
        assert stream["fps"] == 25 and stream["frames"] == 12 and len(stream["cameras"]) == 3
        assert frame["time"] == 0.16 and (frame["K"] == clip[4].cameras[1].K).all()
    for name in (CONFORMANCE / "tiny/tetrahedron.fvv",):
        with pytest.raises(fvv.UsageError, match="no picture"):
            iio.imread(name)
    with pytest.raises(OSError):
        iio.imwrite(players.parent / "out.fvv", everything[0])


def test_imageio_leaves_other_files_alone(players, tmp_path):
    import imageio.v3 as iio

    fvv.interop.imageio.register()
    other = tmp_path / "other.fvv"
    other.write_bytes(b"something else")
    with pytest.raises(OSError):
        iio.imread(other)
    iio.imwrite(tmp_path / "grey.png", numpy.full((4, 5, 3), 77, numpy.uint8))
    assert (iio.imread(tmp_path / "grey.png") == 77).all()


# DLPack.


def test_dlpack_shares_memory(players):
    with fvv.open(players) as clip:
        frame = clip[0]
        arrays = [frame.mesh.positions, frame.mesh.indices, frame.mesh.colours, frame.pictures[0].pixels]
        arrays += [frame.pictures[0].pixels[::-1, ::2]]
        shared = [numpy.from_dlpack(fvv.interop.shared(array)) for array in arrays]
        copies = [array.copy() for array in arrays]
        for ours, theirs in zip(arrays, shared):
            assert numpy.shares_memory(ours, theirs) and ours.strides == theirs.strides
    del frame, arrays, clip
    gc.collect()
    again = [numpy.zeros(1 << 20) for _ in range(8)]  # takes memory that was released
    assert all((one == copy).all() for one, copy in zip(shared, copies)) and len(again) == 8


def test_torch(players):
    torch = optional("torch")
    with fvv.open(players) as clip:
        positions = clip[0].mesh.positions
    tensor = torch.from_dlpack(fvv.interop.shared(positions))
    assert tensor.data_ptr() == positions.ctypes.data and tuple(tensor.shape) == positions.shape


# Packages that are too large for tests/requirements.txt.


def test_pyvista(players):
    optional("pyvista")
    with fvv.open(players) as clip, fvv.open(SHAPES) as shapes, fvv.open(CUBE) as cube:
        mesh = clip[0].mesh
        textured = next(frame.mesh for frame in shapes if frame.mesh.uvs is not None)
        for one in (mesh, textured, cube[0].mesh):
            back = fvv.interop.mesh_from_pyvista(one.to_pyvista())
            assert (back.positions == one.positions).all() and (back.indices == one.indices).all()
            assert (back.normals is not None) == one.has_normals
            assert one.uvs is None or numpy.abs(back.uvs - one.uvs).max() < 1e-6
    assert (mesh.to_pyvista().point_data["colours"] == mesh.colours).all()
    with pytest.raises(fvv.UsageError):
        fvv.interop.mesh_from_pyvista("sphere")


def test_open3d(players):
    optional("open3d")
    with fvv.open(players) as clip, fvv.open(SHAPES) as shapes:
        mesh = clip[0].mesh
        textured = next(frame.mesh for frame in shapes if frame.mesh.uvs is not None)
    found = mesh.to_open3d()
    assert (numpy.asarray(found.vertices) == mesh.positions).all()
    assert (numpy.asarray(found.triangles) == mesh.indices).all()
    assert (numpy.rint(numpy.asarray(found.vertex_colors) * 255) == mesh.colours).all()
    corners = numpy.asarray(textured.to_open3d().triangle_uvs).reshape(-1, 3, 2) * (1, -1) + (0, 1)
    assert numpy.abs(corners - textured.uvs[textured.indices]).max() < 1e-6


def test_absent_packages_are_named(players):
    program = (
        "import sys, fvv\n"
        "for name in ('trimesh', 'pxr', 'xarray', 'pyvista', 'open3d', 'imageio'): sys.modules[name] = None\n"
        f"clip = fvv.open({str(players)!r})\n"
        "mesh = clip[0].mesh\n"
        "for call in (mesh.to_trimesh, mesh.to_open3d, mesh.to_pyvista, clip.to_xarray, fvv.interop.imageio.register,\n"
        "             lambda: clip.to_usd('absent.usda')):\n"
        "    try: call()\n"
        "    except ImportError as error: print(str(error).split('fvv')[1])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["[trimesh]", "[open3d]", "[pyvista]", "[xarray]", "[imageio]", "[usd]"]


# Rerun. What needs its SDK is in hosts/test_rerun.py.


@pytest.mark.parametrize(
    "lens, distortion", [("radtan", [-0.2, 0.05, 0.001, -0.002]), ("fisheye", [0.05, -0.01])]
)
def test_a_picture_without_the_lens_shows_points_where_a_pinhole_does(lens, distortion):
    from fvv.interop.conventions import straightened

    k = numpy.array([[200.0, 3, 150], [0, 210, 110], [0, 0, 1]])
    camera = fvv.Camera(0, k, numpy.eye(3), [0.1, 0.2, 0.3], (320, 240), distortion, lens)
    straight = k.copy()
    straight[0, 1] = 0
    ideal = fvv.Camera(0, straight, numpy.eye(3), [0.1, 0.2, 0.3], (320, 240))
    _, places, inside = straightened(camera, ideal)
    points = numpy.random.default_rng(1).uniform([-1, -1, 2], [1, 1, 5], (5000, 3))
    local = points + camera.t
    x, y = numpy.floor((local / local[:, 2:]) @ straight.T)[:, :2].astype(int).T
    there = (x >= 0) & (x < 320) & (y >= 0) & (y < 240)
    rows, columns = numpy.divmod(places[y[there], x[there]], 320)
    expected = camera.project(points)[there]
    off = numpy.stack([columns, rows], axis=1) + 0.5 - expected
    assert there.sum() > 3000 and inside[y[there], x[there]].mean() > 0.9
    # Half a pixel at either end, and the scale of the lens.
    assert numpy.abs(off[inside[y[there], x[there]]]).max() < 1.5
    without = ((local / local[:, 2:]) @ straight.T)[there, :2]
    assert numpy.abs(expected - without).max() > 5


def test_without_rerun_it_says_what_to_install(players, tmp_path, monkeypatch, capsys):
    from fvv.interop.rerun import main

    monkeypatch.setitem(sys.modules, "rerun", None)
    assert main([str(tmp_path / "missing.fvv"), "--recording-id", "it"]) == 66
    assert main([str(players), "--recording-id", "it"]) == 1
    assert "pip install fvv[rerun]" in capsys.readouterr().err
