"""The extension of Blender, as Blender installs it: without windows, by the modules of Python that Blender's makers publish. They are too large
for tests/requirements.txt: ./run test blender makes environments with the oldest and the newest one.

Pictures of Cycles are compared with those of fvvrender, and kept in FVV_PICTURES if that names a folder."""

import os
import pathlib
import subprocess
import sys
import tempfile
import time
import zipfile

import numpy
import pytest
from conftest import ROOT, tool
from vectors import path_of

# Blender keeps extensions where its users' settings are.
os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp(prefix="fvv-blender-")
bpy = pytest.importorskip("bpy", reason="bpy is not installed here: ./run test blender")
sys.path.insert(0, str(ROOT / "bindings/blender"))
import build as extension  # noqa: E402

PACKAGE = pathlib.Path(os.environ["FVV_PACKAGE"])  # of the build
IDENTIFIER = "free_viewpoint_video"
SIZE = (480, 288)


def wheel_of(package, folder):
    """A wheel of the package that was built, as pip makes it."""
    tag = f"cp{sys.version_info.major}{sys.version_info.minor}"
    path = folder / f"fvv-0.0.1-{tag}-{tag}-linux_x86_64.whl"
    texts = {
        "METADATA": "Metadata-Version: 2.1\nName: fvv\nVersion: 0.0.1\n",
        "WHEEL": f"Wheel-Version: 1.0\nGenerator: fvv\nRoot-Is-Purelib: false\nTag: {tag}-{tag}-linux_x86_64\n",
        "RECORD": "",
    }
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as out:
        for file in sorted(package.rglob("*")):
            if file.suffix in (".py", ".so"):
                out.write(file, f"fvv/{file.relative_to(package)}")
        for name, text in texts.items():
            out.writestr(f"fvv-0.0.1.dist-info/{name}", text)
    return path


@pytest.fixture(scope="session")
def fvv(tmp_path_factory):
    """The package, from the extension that Blender installed."""
    folder = tmp_path_factory.mktemp("extension")
    path = extension.build(wheel_of(PACKAGE, folder), folder)
    scripts = pathlib.Path(bpy.utils.system_resource("SCRIPTS"))
    checker = scripts / "addons_core/bl_pkg/cli/blender_ext.py"
    done = subprocess.run(
        [sys.executable, checker, "validate", path], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0 and "ERROR" not in done.stdout, done.stdout + done.stderr
    import addon_utils

    addon_utils.enable("bl_pkg", default_set=True)
    bpy.ops.extensions.package_install_files(filepath=str(path), repo="user_default", enable_on_install=True)
    assert f"bl_ext.user_default.{IDENTIFIER}" in [one.module for one in bpy.context.preferences.addons]
    import fvv

    assert fvv.__file__.startswith(os.environ["BLENDER_USER_RESOURCES"])
    return fvv


@pytest.fixture(scope="session")
def stream(tmp_path_factory):
    """12 frames in groups of 5 of a tracked scene: 5 cameras, visibility, colours, sound, surroundings."""
    folder = tmp_path_factory.mktemp("stream")
    tool("fvvsynth", "-o", folder / "capture", "--rig", "small", "--cameras", 5, "--size", "480x288", "--frames", 12,
         "--sound", "--environment")  # fmt: skip
    tool("fvvmux", folder / "capture/capture.json", "-o", folder / "players.fvv", "--group", 5,
         "--visibility", "weight", "--colours", "on", "--keep-geometry")  # fmt: skip
    return folder / "players.fvv"


@pytest.fixture
def scene(fvv):
    """An empty scene in front of black, that Cycles renders."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    addons = [one.module for one in bpy.context.preferences.addons]
    if f"bl_ext.user_default.{IDENTIFIER}" not in addons:
        bpy.ops.preferences.addon_enable(module=f"bl_ext.user_default.{IDENTIFIER}")
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", 25, False
    scene.cycles.pixel_filter_type = "BOX"  # as fvvrender's
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.resolution_percentage = 100
    scene.world = bpy.data.worlds.new("black")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    return scene


def imported(path, **options):
    """The root of what File > Import makes of a stream."""
    begin = time.perf_counter()
    assert bpy.ops.import_scene.fvv(filepath=str(path), **options) == {"FINISHED"}
    print(f"blender.import_seconds {time.perf_counter() - begin:.3f}")
    return next(one for one in bpy.data.objects if "fvv_source" in one)


def below(root, key):
    return {one[key]: one for one in root.children if key in one}


def rendered(tmp_path, scene, name):
    """(height, width, 3), 0 to 255."""
    kept = os.environ.get("FVV_PICTURES")
    scene.render.filepath = str(pathlib.Path(kept or tmp_path) / f"{name}.png")
    bpy.ops.render.render(write_still=True)
    return pixels_of(scene.render.filepath)


def pixels_of(path):
    image = bpy.data.images.load(str(path))
    width, height = image.size
    flat = numpy.empty(width * height * 4, numpy.float32)
    image.pixels.foreach_get(flat)
    bpy.data.images.remove(image)
    return (flat.reshape(height, width, 4)[::-1, :, :3] * 255).round()


def psnr(a, b):
    return 10 * numpy.log10(255**2 / ((a - b.astype(float)) ** 2).mean())


def positions_of(item):
    flat = numpy.zeros(3 * len(item.data.vertices), numpy.float32)
    item.data.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def test_meshes_follow_the_timeline(fvv, scene, stream):
    root = imported(stream)
    assert (scene.frame_start, scene.frame_end, scene.render.fps / scene.render.fps_base) == (1, 12, 25)
    assert scene.view_settings.view_transform == "Standard"
    turned = numpy.array(root.matrix_world)[:3, :3]
    assert (turned @ (0, 1, 0)).round(6).tolist() == [0, 0, 1]
    with fvv.open(stream) as clip:
        for number in (8, 1, 12, 40, -3):
            scene.frame_set(number)
            mesh = clip[min(max(number - 1, 0), 11)].mesh
            item = below(root, "fvv_track")[mesh.track]
            assert (positions_of(item) == mesh.positions).all()
            assert [list(face.vertices) for face in item.data.polygons[:50]] == mesh.indices[:50].tolist()
    begin = time.perf_counter()
    for number in range(1, 13):
        scene.frame_set(number)
    print(f"blender.frames_per_s {12 / (time.perf_counter() - begin):.2f}")


def test_faces_may_change(fvv, scene):
    path = path_of("fast_shapes")
    root = imported(path, first=0)
    with fvv.open(path) as clip:
        counts = set()
        for frame in clip:
            scene.frame_set(frame.index)
            data = below(root, "fvv_track")[frame.mesh.track].data
            counts.add((len(data.vertices), len(data.polygons)))
            assert (len(data.vertices), len(data.polygons)) == (
                frame.mesh.vertex_count,
                frame.mesh.face_count,
            )
            if frame.mesh.uvs is not None:
                uvs = numpy.zeros(6 * frame.mesh.face_count, numpy.float32)
                data.uv_layers.active.data.foreach_get("uv", uvs)
                ours = frame.mesh.uvs[frame.mesh.indices].reshape(-1, 2)
                assert numpy.abs(uvs.reshape(-1, 2) * (1, -1) + (0, 1) - ours).max() < 1e-6
        assert len(counts) > 1


def test_cameras_are_where_they_were(fvv, scene, stream):
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    root = imported(stream)
    axes = numpy.array(root.matrix_world)
    random = numpy.random.default_rng(1)
    with fvv.open(stream) as clip:
        for identifier, camera in clip[0].cameras.items():
            scene.render.resolution_x, scene.render.resolution_y = camera.width, camera.height
            aspect = camera.K[0, 0] / camera.K[1, 1]
            scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = max(1, 1 / aspect), max(1, aspect)
            pixels = random.uniform((0, 0), (camera.width, camera.height), (50, 2))
            points = camera.unproject(pixels, random.uniform(1, 5, 50))
            world = numpy.hstack([points, numpy.ones((len(points), 1))]) @ axes.T
            item = below(root, "fvv_camera")[identifier]
            places = [world_to_camera_view(scene, item, Vector(point[:3])) for point in world]
            at = numpy.array([(x * camera.width, (1 - y) * camera.height) for x, y, _ in places])
            assert numpy.abs(at - pixels).max() < 1e-3


def between(fvv, clip, first, second):
    """A camera between two of a clip."""
    a, b = (clip[0].cameras[one] for one in (first, second))
    centre = (a.centre + b.centre) / 2
    forward = a.R[2] + b.R[2]
    forward /= numpy.linalg.norm(forward)
    right = numpy.cross(a.R[1] + b.R[1], forward)
    right /= numpy.linalg.norm(right)
    R = numpy.stack([right, numpy.cross(forward, right), forward])
    K = ((520, 0, SIZE[0] / 2), (0, 520, SIZE[1] / 2), (0, 0, 1))
    return fvv.Camera(99, K, R, -R @ centre, SIZE)


def blender_camera(scene, root, camera):
    """Blender's, for a camera with its principal point in the middle."""
    from fvv.interop.conventions import along_minus_z
    from mathutils import Matrix

    data = bpy.data.cameras.new("own")
    data.sensor_fit, data.lens = "HORIZONTAL", camera.K[0, 0] * data.sensor_width / camera.width
    item = bpy.data.objects.new("own", data)
    scene.collection.objects.link(item)
    item.parent = root
    item.matrix_local = Matrix(along_minus_z(camera).tolist())
    bpy.context.view_layer.update()
    return item


def test_colours_by_view_in_cycles(fvv, scene, stream, tmp_path):
    """With the environment, where cameras were and where none was."""
    root = imported(stream)
    assert root["fvv_colours"] == "view"
    with fvv.open(stream) as clip:
        own = between(fvv, clip, 1, 2)
        for number, pose in ((1, 1), (8, 3), (5, own)):
            scene.frame_set(number)
            is_own = pose is own
            scene.camera = blender_camera(scene, root, own) if is_own else below(root, "fvv_camera")[pose]
            found = rendered(tmp_path, scene, "between" if is_own else f"view_{pose}")
            expected = fvv.render(clip, number - 1, pose, samples=5)
            alone = fvv.render(clip, number - 1, pose, samples=5, environment=False, layers=True)
            action = alone.coverage == 1
            print(f"blender.psnr_db {psnr(found, expected):.2f}")
            print(f"blender.action_psnr_db {psnr(found[action], expected[action]):.2f}")
            assert psnr(found, expected) > 30 and psnr(found[action], expected[action]) > 30


def test_pictures_are_backgrounds(fvv, scene, stream):
    root = imported(stream)
    scene.frame_set(6)
    with fvv.open(stream) as clip:
        for identifier, item in below(root, "fvv_camera").items():
            (background,) = item.data.background_images
            picture = clip[5].pictures[identifier]
            image = background.image
            flat = numpy.empty(4 * image.size[0] * image.size[1], numpy.float32)
            image.pixels.foreach_get(flat)
            shown = flat.reshape(image.size[1], image.size[0], 4)[::-1, :, :3] * 255
            whole = clip[5].cameras[identifier]
            scale = picture.camera.width / picture.source[2]
            assert abs(image.size[0] - whole.width * scale) <= 1 and item.data.show_background_images
            left, top = (round(one * scale) for one in picture.source[:2])
            tile = shown[top : top + picture.pixels.shape[0], left : left + picture.pixels.shape[1]]
            assert numpy.abs(tile - picture.pixels).max() < 1


def test_sound_is_in_the_sequencer(fvv, scene, stream):
    if not bpy.app.build_options.audaspace:
        pytest.skip("this wheel of bpy has no sound")
    imported(stream, first=10)
    editor = scene.sequence_editor
    strips = list(editor.strips if hasattr(editor, "strips") else editor.sequences)
    with fvv.open(stream) as clip:
        assert len(strips) == len(clip.audio) > 0
        for strip, sound in zip(strips, clip.audio):
            assert abs(strip.frame_final_start - 10 - 25 * sound.start) <= 1
            assert abs(strip.frame_final_duration - 25 * sound.duration) <= 1
            content = strip.sound.packed_file.data
            codes = numpy.frombuffer(content[44:], "<i2").reshape(-1, sound.channels)
            assert numpy.abs(codes / 32767 - sound.samples().clip(-1, 1)).max() < 1e-4


def test_baked_colours_in_cycles(fvv, scene, stream, tmp_path):
    root = imported(stream, colours="baked", environment=False)
    with fvv.open(stream) as clip:
        for identifier, number in ((1, 1), (3, 8)):
            scene.frame_set(number)
            scene.camera = below(root, "fvv_camera")[identifier]
            found = rendered(tmp_path, scene, f"baked_{identifier}")
            expected = fvv.render(clip, number - 1, identifier, samples=5, environment=False)
            print(f"blender.baked_psnr_db {psnr(found, expected):.2f}")
            assert psnr(found, expected) > 30


def test_an_atlas_is_a_texture(fvv, scene, tmp_path):
    tool("fvvsynth", "-o", tmp_path / "capture", "--rig", "small", "--cameras", 2, "--size", "480x288", "--frames", 2,
         "--atlas", "--atlas-size", 1024)  # fmt: skip
    tool("fvvmux", tmp_path / "capture/capture.json", "-o", tmp_path / "atlas.fvv", "--keep-geometry")
    root = imported(tmp_path / "atlas.fvv")
    scene.frame_set(2)
    scene.camera = below(root, "fvv_camera")[1]
    found = rendered(tmp_path, scene, "atlas")
    with fvv.open(tmp_path / "atlas.fvv") as clip:
        mesh, camera, atlas = clip[1].mesh, clip[1].cameras[1], clip[1].atlas.pixels
        depth = fvv.render(clip, 1, 1, samples=1, environment=False, layers=True).depth
    column, row = numpy.floor(camera.project(mesh.positions)).astype(int).T
    row, column = row.clip(0, SIZE[1] - 1), column.clip(0, SIZE[0] - 1)
    front = numpy.abs(camera.depth(mesh.positions) - depth[row, column]) < 0.005
    v, u = (mesh.uvs[:, ::-1] * (numpy.array(atlas.shape[:2]) - 1)).round().astype(int).T
    wrong = numpy.abs(found[row, column] - atlas[v, u].astype(float))[front]
    assert front.sum() > 500 and numpy.median(wrong) < 4


def test_motion_blur(fvv, scene, stream):
    scene.render.use_motion_blur = True
    root = imported(stream)
    with fvv.open(stream) as clip:
        meshes = [frame.mesh for frame in clip]
        same = [
            (a.indices.shape == b.indices.shape and (a.indices == b.indices).all())
            for a, b in zip(meshes, meshes[1:])
        ]
        middle = next(i for i in range(1, 11) if same[i - 1] and same[i])
        scene.frame_set(middle + 1)
        data = below(root, "fvv_track")[meshes[0].track].data
        flat = numpy.zeros(3 * len(data.vertices), numpy.float32)
        data.attributes["velocity"].data.foreach_get("vector", flat)
        expected = (meshes[middle + 1].positions - meshes[middle - 1].positions) / 0.08
        assert numpy.abs(flat.reshape(-1, 3) - expected).max() < 1e-3
        assert numpy.abs(expected).max() > 0.1


def grown(mask, by):
    """A mask and the pixels at most `by` pixels beside it."""
    out = mask.copy()
    for down in range(-by, by + 1):
        for across in range(-by, by + 1):
            out |= numpy.roll(mask, (down, across), (0, 1))
    return out


def test_motion_blur_in_cycles(fvv, scene, stream, tmp_path):
    """With a shutter that is open from the frame before to the frame after."""
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 2.0
    root = imported(stream, environment=False, colours="sent")
    scene.camera = below(root, "fvv_camera")[1]
    with fvv.open(stream) as clip:
        covered = [fvv.render(clip, i, 1, environment=False, layers=True).coverage > 0 for i in range(6, 9)]
    scene.frame_set(8)
    blurred = rendered(tmp_path, scene, "blurred").max(axis=2) > 2
    before, now, after = covered
    assert not (blurred & ~grown(before | now | after, 2)).any()
    left = before & ~grown(now | after, 1)
    assert left.sum() > 50 and (blurred & left).sum() > 0.8 * left.sum()
    scene.render.use_motion_blur = False
    scene.frame_set(8)
    sharp = rendered(tmp_path, scene, "sharp").max(axis=2) > 2
    assert not (sharp & ~grown(now, 2)).any()


def test_cameras_that_move_and_have_lenses(fvv, scene, tmp_path):
    tool("fvvsynth", "-o", tmp_path / "capture", "--rig", "studio", "--size", "480x288", "--frames", 3)
    tool("fvvmux", tmp_path / "capture/capture.json", "-o", tmp_path / "studio.fvv", "--preset", "live")
    root = imported(tmp_path / "studio.fvv", colours="view")
    places = {}
    with fvv.open(tmp_path / "studio.fvv") as clip:
        for number in (1, 3):
            scene.frame_set(number)
            for identifier, item in below(root, "fvv_camera").items():
                places.setdefault(identifier, []).append(numpy.array(item.matrix_world))
        moving = {one.id for one in clip[0].cameras.values() if one.moves}
        assert moving and moving == {one for one, (a, b) in places.items() if (a != b).any()}
        assert len({one.lens for one in clip[0].cameras.values()}) > 1
        own = between(fvv, clip, 1, 2)
        scene.camera = blender_camera(scene, root, own)
        found = rendered(tmp_path, scene, "studio")
        expected = fvv.render(clip, 2, own, samples=5)
        action = fvv.render(clip, 2, own, samples=5, environment=False, layers=True).coverage == 1
        print(f"blender.lenses_psnr_db {psnr(found[action], expected[action]):.2f}")
        assert action.sum() > 2000 and psnr(found[action], expected[action]) > 30


def test_a_saved_file_shows_the_clip_again(fvv, scene, stream, tmp_path):
    imported(stream)
    scene.frame_set(3)
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    bpy.context.scene.frame_set(9)
    root = next(one for one in bpy.data.objects if "fvv_source" in one)
    assert len(bpy.app.handlers.frame_change_pre) == 1
    with fvv.open(stream) as clip:
        for item in below(root, "fvv_track").values():
            assert (positions_of(item) == clip[8].mesh.positions).all()
    for item in [*root.children, root]:
        bpy.data.objects.remove(item)
    bpy.context.scene.frame_set(2)
    assert not bpy.app.handlers.frame_change_pre


def test_a_clip_is_taken_out_again(fvv, scene, stream):
    with fvv.open(stream) as clip:
        shown = fvv.interop.blender.load(clip, colours="sent")
        scene.frame_set(3)
        assert len(shown.meshes) == 1 and len(shown.cameras) == 5
        shown.remove()
        shown.remove()
    assert not bpy.data.objects and not bpy.data.meshes and not bpy.data.cameras
    assert not bpy.app.handlers.frame_change_pre


def test_damage_is_named(fvv, scene, stream, tmp_path):
    content = bytearray(stream.read_bytes())
    with fvv.open(stream) as clip:
        row = next(one for one in clip.chunks() if one["type"] == b"MESH" and one["group"] == 1)
        content[int(row["offset"]) + 32 + 40] ^= 1
    (tmp_path / "broken.fvv").write_bytes(content)
    root = imported(tmp_path / "broken.fvv")
    scene.frame_set(6)
    assert "MESH" in root["fvv_problem"]
    assert all(not one.data.vertices for one in below(root, "fvv_track").values())
    scene.frame_set(2)
    assert "fvv_problem" not in root
    (tmp_path / "cut.fvv").write_bytes(content[:30])
    with pytest.raises(RuntimeError, match="cut.fvv"):
        bpy.ops.import_scene.fvv(filepath=str(tmp_path / "cut.fvv"))


def test_colours_are_chosen_by_one_click(fvv, scene, stream):
    root = imported(stream)
    item = below(root, "fvv_track").popitem()[1]
    bpy.context.view_layer.objects.active = item
    with fvv.open(stream) as clip:
        scene.frame_set(4)
        sent = clip[3].mesh.colours
        for name, expected in (("sent", sent), ("baked", fvv.interop.blender.baked(clip[3], clip[3].mesh))):
            assert bpy.ops.object.fvv_colours(colours=name) == {"FINISHED"}
            flat = numpy.zeros(4 * len(sent), numpy.float32)
            item.data.color_attributes["colours"].data.foreach_get("color_srgb", flat)
            assert (numpy.rint(flat.reshape(-1, 4)[:, :3] * 255) == expected).all()
            assert item.data.materials[0].name == "fvv colours"
    assert bpy.ops.object.fvv_colours(colours="view") == {"FINISHED"}
    assert item.data.materials[0].name.endswith("view")


def vertices_of(item):
    """Of an object after its modifiers, in metres of the scene."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    flat = numpy.zeros(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", flat)
    to_world = numpy.array(evaluated.matrix_world)
    return flat.reshape(-1, 3) @ to_world[:3, :3].T + to_world[:3, 3]


@pytest.mark.parametrize("kind", ["abc", "usdc"])
def test_other_formats_by_blenders_exporters(fvv, scene, tmp_path, kind):
    """Of a clip whose faces change."""
    stream = path_of("fast_shapes")
    root = imported(stream, first=1)
    path = str(tmp_path / f"out.{kind}")
    if kind == "abc":
        bpy.ops.wm.alembic_export(filepath=path, start=1, end=scene.frame_end)
    else:
        bpy.ops.wm.usd_export(filepath=path, export_animation=True)
    expected = []
    for number in range(1, scene.frame_end + 1):
        scene.frame_set(number)
        expected.append(vertices_of(below(root, "fvv_track").popitem()[1]))
    assert len({len(one) for one in expected}) > 1
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    if kind == "abc":
        bpy.ops.wm.alembic_import(filepath=path)
    else:
        bpy.ops.wm.usd_import(filepath=path)
    (item,) = (one for one in bpy.data.objects if one.type == "MESH")
    for number, vertices in enumerate(expected, 1):
        bpy.context.scene.frame_set(number)
        found = vertices_of(item)
        assert found.shape == vertices.shape, number
        assert numpy.abs(found - vertices).max() < 1e-4


def animated_ball(scene):
    """A ball with an image and a UV map that becomes longer and turns."""
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, segments=24, ring_count=12)
    ball = bpy.context.object
    material = bpy.data.materials.new("ball")
    material.use_nodes = True
    image = bpy.data.images.new("ball", 64, 64)
    rows, columns = numpy.mgrid[:64, :64] / numpy.float32(63)
    values = numpy.stack([rows, columns, 1 - rows, numpy.ones_like(rows)], axis=-1)
    image.pixels.foreach_set(values.astype(numpy.float32).ravel())
    tree = material.node_tree
    texture, emission = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeEmission")
    texture.image = image
    tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    ball.data.materials.append(material)
    scene.frame_start, scene.frame_end = 5, 8
    for number, length, turn in ((5, 1.0, 0.0), (8, 1.5, 0.6)):
        ball.scale, ball.rotation_euler = (1, 1, length), (0, turn, 0)
        ball.keyframe_insert("scale", frame=number)
        ball.keyframe_insert("rotation_euler", frame=number)
    return ball, numpy.rint(values[::-1, :, :3] * 255)


def test_export_with_a_texture(fvv, scene, tmp_path):
    ball, pixels = animated_ball(scene)
    path = tmp_path / "ball.fvv"
    assert bpy.ops.export_scene.fvv(filepath=str(path), source="texture", max_error=0.001) == {"FINISHED"}
    with fvv.open(path) as clip:
        assert (len(clip), clip.rate, clip.up) == (4, 24, "+z") and fvv.check(path).ok
        for frame in clip:
            scene.frame_set(5 + frame.index)
            exported = vertices_of(ball)
            nearest = numpy.linalg.norm(exported[:, None] - frame.mesh.positions, axis=2)
            assert nearest.min(axis=1).max() < 0.002
            assert psnr(frame.atlas.pixels, pixels) > 30 and frame.mesh.uvs is not None
        mesh = clip[0].mesh  # which is not turned yet
        assert (
            mesh.uvs[mesh.positions[:, 2].argmax(), 1]
            < 0.01
            < 0.99
            < mesh.uvs[mesh.positions[:, 2].argmin(), 1]
        )


@pytest.mark.parametrize("source", ["cameras", "ring"])
def test_export_of_what_cameras_see(fvv, scene, tmp_path, source):
    ball, _ = animated_ball(scene)
    bpy.ops.mesh.primitive_cube_add(location=(0, 0, -0.9))
    bpy.context.object.name = "not exported"
    ball.select_set(True)
    bpy.context.object.select_set(False)
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y = 192, 128
    if source == "cameras":
        for place, turn in (((3, 0, 0), 0), ((0, 3, 0.5), 1)):
            camera = bpy.data.objects.new("own", bpy.data.cameras.new("own"))
            camera.location, camera.data.shift_x = place, 0.05 * turn
            constraint = camera.constraints.new("TRACK_TO")
            constraint.target, constraint.track_axis, constraint.up_axis = ball, "TRACK_NEGATIVE_Z", "UP_Y"
            scene.collection.objects.link(camera)
    path = tmp_path / "seen.fvv"
    assert bpy.ops.export_scene.fvv(filepath=str(path), selected=True, source=source, count=6) == {"FINISHED"}
    assert not [one for one in bpy.data.objects if one.name.startswith("ring")]
    assert not bpy.data.objects["not exported"].hide_render
    with fvv.open(path) as clip:
        assert len(clip) == 4 and fvv.check(path).ok
        frame = clip[2]
        assert len(frame.pictures) == (2 if source == "cameras" else 6)
        for identifier, picture in frame.pictures.items():
            # Where the mesh is in the picture there are its colours, and nowhere else.
            drawn = fvv.render(clip, 2, identifier, environment=False, layers=True)
            whole = picture.whole()
            if whole.shape != drawn.pixels.shape:
                continue
            inside = drawn.coverage == 1
            assert inside.sum() > 300
            assert psnr(drawn.pixels[inside], whole[inside]) > 25
