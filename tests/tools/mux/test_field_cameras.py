"""Cameras and meshes whose units, axes, poses or map coordinates are not those that programs expect."""

import json

import numpy as np
import pytest
import trimesh
from conftest import figures, run
from PIL import Image


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write_sphere(folder, origin, mesh=lambda vertices: vertices):
    """Four cameras around a sphere of 0.6 m; mesh: what its file has instead of its vertices."""
    folder.mkdir()
    sphere = trimesh.creation.icosphere(3, 0.6)
    lines = ["v {:.9f} {:.9f} {:.9f}".format(*v) for v in mesh(sphere.vertices + origin)]
    lines += ["f {} {} {}".format(*f) for f in sphere.faces + 1]
    (folder / "m.obj").write_text("\n".join(lines) + "\n")
    cameras = []
    for i in range(4):
        angle = i * np.pi / 2
        z = np.array([-np.cos(angle), 0, -np.sin(angle)])
        rotation = np.array([np.cross([0, -1, 0], z), [0, -1, 0], z])
        Image.fromarray(np.full((96, 128, 3), 90 + 40 * i, np.uint8)).save(folder / f"{i}.png")
        cameras.append(
            {
                "id": i,
                "width": 128,
                "height": 96,
                "intrinsics": {"fx": 150, "fy": 150, "cx": 64, "cy": 48},
                "rotation": rotation.tolist(),
                "translation": (-rotation @ (origin - 3 * z)).tolist(),
                "pictures": f"{i}.png",
            }
        )
    capture = {
        "fvv_capture": 1,
        "frame_rate": 25,
        "frames": {"first": 0, "count": 1},
        "units": "metres",
        "up": "+y",
        "meshes": {"pattern": "m.obj"},
        "cameras": cameras,
    }
    (folder / "capture.json").write_text(json.dumps(capture))


def test_map_coordinates(place):
    """A capture in UTM coordinates is the same capture at the origin: float32 has decimetres there."""
    reports, pictures = [], []
    for name, origin in (("near", np.zeros(3)), ("far", np.array([441548.0, 5121948.0, 2345.0]))):
        write_sphere(place / name, origin)
        options = ("--visibility", "weight", "--match-colours", "off", "--max-error", "2mm")
        reports.append(figures("fvvmux", name, "-o", f"{name}.fvv", *options))
        pose = ",".join(str(x) for x in (*(origin + [2.4, 0.5, 1.2]), *origin))
        run("fvvrender", f"{name}.fvv", "--pose", pose, "--size", "160x120", "-o", f"{name}.png")
        pictures.append(np.asarray(Image.open(f"{name}.png").convert("RGB")).astype(float))
    assert np.abs(pictures[0] - pictures[1]).mean() < 0.5
    assert pictures[0].max() > 80
    near, far = reports
    assert far["budget"]["volume_change"] == pytest.approx(near["budget"]["volume_change"], abs=2e-3)
    assert far["colours"]["not_shown"] == pytest.approx(near["colours"]["not_shown"], abs=0.03)
    assert far["texture_inset"]["length"] == pytest.approx(near["texture_inset"]["length"], abs=1e-3)
    assert far["visibility"]["bits_per_pair"] == pytest.approx(near["visibility"]["bits_per_pair"], rel=0.3)


UTM, ECEF = (441548.0, 5121948.0, 2345.0), (-3959340.5, 3352854.25, 3697471.75)


@pytest.mark.parametrize("compress", ["none", "meshopt", "draco"])
@pytest.mark.parametrize("origin", [UTM, ECEF])
@pytest.mark.parametrize("form", ["glb", "gltf"])
def test_gltf_of_map_coordinates(form, origin, compress, place):
    """Positions are relative to an origin that the node and its extras have; what does not fit is not lost."""
    if form == "gltf" and compress == "draco":
        return  # is refused: Draco has no animations
    sphere = trimesh.creation.icosphere(2, 0.6)
    for frame in range(2):
        lines = [
            "v {:.9f} {:.9f} {:.9f}".format(*(v + origin + (0.1 * frame, 0, 0))) for v in sphere.vertices
        ]
        lines += ["f {} {} {}".format(*f) for f in sphere.faces + 1]
        (place / f"m{frame}.obj").write_text("\n".join(lines) + "\n")
    more = ("--units", "metres", "--up", "+y", "--step", "1mm", "--keep-geometry")
    run("fvvmux", "--meshes", "m%d.obj", "-o", "o.fvv", *more)
    options = () if compress == "none" else ("--compress", compress)
    done = run("fvvdemux", "o.fvv", "-o", "x", "--meshes", form, *options, warns=True)
    assert "relative to an origin" in done.stderr
    files = sorted((place / "x/meshes").glob("*.glb"))
    assert len(files) == (1 if form == "gltf" else 2)
    for file in files:
        document = gltf_document(file)
        (node,) = document["nodes"]
        assert np.allclose(node["extras"]["origin"], origin, atol=70)
        assert all(np.abs(document["accessors"][0][end]).max() < 2**21 for end in ("min", "max"))
    # Packed again, the points are what they were.
    frames = ("--fps", "25") if form == "gltf" else ()
    again = "x/meshes/0000-0001.glb" if form == "gltf" else "x/meshes/%04d.glb"
    run("fvvmux", "--meshes", again, "-o", "p.fvv", "--step", "1mm", "--keep-geometry", *frames)
    found = []
    for stream in ("o", "p"):
        run("fvvdemux", f"{stream}.fvv", "-o", stream, "--meshes", "ply")
        for path in sorted((place / stream / "meshes").glob("*.ply")):
            found.append(np.sort(trimesh.load(path, process=False).vertices, 0))
    assert len(found) == 4
    for a, b in zip(found[:2], found[2:]):
        assert np.abs(a - b).max() <= 1.01e-3
    assert np.abs(found[1].mean(0) - origin - (0.1, 0, 0)).max() < 2e-3


def test_gltf_near_the_origin_has_no_origin_of_its_own(place):
    write_sphere(place / "c", np.array([50.0, -20.0, 3.0]))
    run("fvvmux", "--meshes", "c/m.obj", "-o", "o.fvv", "--units", "metres", "--step", "1mm")
    run("fvvdemux", "o.fvv", "-o", "x", "--meshes", "glb")
    (node,) = gltf_document(place / "x/meshes/0000.glb")["nodes"]
    assert node == {"mesh": 0}


def gltf_document(path):
    content = path.read_bytes()
    return json.loads(content[20 : 20 + int.from_bytes(content[12:16], "little")])


@pytest.mark.parametrize(
    "mesh, found, advice",
    [
        (
            lambda v: 1000 * v,
            "all cameras are inside the mesh",
            "meshes times 0.001: the mesh would be in 4 of 4",
        ),
        (lambda v: 0.01 * v, "pixels at most", "meshes times 100: the mesh would be in 4 of 4"),
        (lambda v: v + (0, 40, 0), "no camera sees the mesh", ""),
    ],
)
def test_meshes_that_do_not_fit_the_cameras(place, mesh, found, advice):
    write_sphere(place / "c", np.zeros(3), mesh)
    message = run("fvvmux", "c", "-o", "o.fvv", code=3, warns=True).stderr
    assert found in message
    assert advice in message
    assert ("would be" in message) == bool(advice)


def test_axes_that_do_not_fit_the_cameras(place):
    """The subject stands 5 m from the origin; its mesh has z up, the cameras have y up."""
    write_sphere(place / "c", np.array([0.0, 5.0, 0.0]), lambda v: np.stack([v[:, 0], -v[:, 2], v[:, 1]], 1))
    message = run("fvvmux", "c", "-o", "o.fvv", code=3, warns=True).stderr
    assert "with z up turned to y up (x, z, -y): the mesh would be in 4 of 4 pictures" in message


MIRROR = np.diag([1, -1, -1])
MISREAD = {
    "with y up and z backwards (OpenGL)": lambda r, t: (MIRROR @ r, MIRROR @ t),
    "whose translation is the camera's place": lambda r, t: (r, -r.T @ t),
    "from camera to world": lambda r, t: (r.T, -r.T @ t),
    "from camera to world, with y up and z backwards (OpenGL)": lambda r, t: (
        (MIRROR @ r).T,
        -(MIRROR @ r).T @ MIRROR @ t,
    ),
}


@pytest.mark.parametrize("name", MISREAD)
def test_cameras_whose_pose_is_of_another_kind(name, place):
    write_sphere(place / "c", np.array([2.0, 9.0, -6.0]))
    capture = json.loads((place / "c/capture.json").read_text())
    for camera in capture["cameras"]:
        r, t = MISREAD[name](np.array(camera["rotation"]), np.array(camera["translation"]))
        camera["rotation"], camera["translation"] = r.tolist(), t.tolist()
    (place / "c/capture.json").write_text(json.dumps(capture))
    message = run("fvvmux", "c", "-o", "o.fvv", code=3, warns=True).stderr
    # On a ring whose cameras see its middle two of them may look alike.
    assert name in message and ": the mesh would be in 4 of 4 pictures" in message


def test_cameras_that_see_nothing(place):
    """One camera whose pose is right is not enough; those that see nothing are named, with what fits."""
    write_sphere(place / "c", np.array([2.0, 9.0, -6.0]))
    capture = json.loads((place / "c/capture.json").read_text())
    for camera in capture["cameras"][1:]:
        r, t = np.array(camera["rotation"]), np.array(camera["translation"])
        camera["rotation"], camera["translation"] = (MIRROR @ r).tolist(), (MIRROR @ t).tolist()
    capture["cameras"][2]["name"] = "left"
    (place / "c/capture.json").write_text(json.dumps(capture))
    message = run("fvvmux", "c", "-o", "o.fvv", code=3, warns=True).stderr
    assert "the mesh is in no picture of camera 1, camera 2 (left), camera 3, in any frame" in message
    assert "their poses with y up and z backwards (OpenGL): the mesh would be in 3 of 3 pictures" in message


@pytest.mark.parametrize("visible", [0, 2, 4, None])
def test_a_camera_of_a_part_of_the_stage_sees_the_mesh_at_times(visible, place):
    """One frame in which it sees something is enough, wherever in the take that is."""
    write_sphere(place / "c", np.zeros(3))
    capture = json.loads((place / "c/capture.json").read_text())
    capture["frames"]["count"] = 5
    capture["meshes"]["pattern"] = "%d.obj"
    lines = (place / "c/m.obj").read_text().splitlines()
    for frame in range(5):
        away = 0 if frame == visible else 1
        moved = [
            "v {} {} {}".format(*line.split()[1:3], float(line.split()[3]) + away)
            if line.startswith("v ")
            else line
            for line in lines
        ]
        (place / f"c/{frame}.obj").write_text("\n".join(moved) + "\n")
    for camera in capture["cameras"]:
        camera["pictures"] = {"pattern": f"p{camera['id']}_%d.png"}
        for frame in range(5):
            (place / f"c/p{camera['id']}_{frame}.png").write_bytes(
                (place / f"c/{camera['id']}.png").read_bytes()
            )
    # Sees what is around the origin alone.
    narrow = capture["cameras"][0]
    narrow["intrinsics"] |= {"fx": 1500, "fy": 1500}
    (place / "c/capture.json").write_text(json.dumps(capture))
    done = run("fvvmux", "c", "-o", "o.fvv", code=(0, 3), warns=True)
    assert ("in no picture of camera 0" in done.stderr) == (visible is None)
