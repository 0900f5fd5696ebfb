"""fvvdemux --meshes glb and obj: what other programs load is the mesh and the texture of the frame."""

import json

import numpy as np
import pytest
import trimesh
from conftest import run
from PIL import Image

FRAME = "meshes/0001."
# Where +y comes from, in the axes of a stream with that direction up.
TURNED = {
    "+y": lambda x, y, z: (x, y, z),
    "+x": lambda x, y, z: (-y, x, z),
    "+z": lambda x, y, z: (x, z, -y),
    "-x": lambda x, y, z: (y, -x, z),
    "-y": lambda x, y, z: (x, -y, -z),
    "-z": lambda x, y, z: (x, -z, y),
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The capture and its stream."""
    root = tmp_path_factory.mktemp("textured")
    run(
        "fvvsynth",
        "-o",
        root / "capture",
        "--atlas",
        "--rig",
        "small",
        "--frames",
        2,
        "--cameras",
        2,
        "--size",
        "160x96",
    )
    run("fvvmux", root / "capture", "-o", root / "s.fvv", "--codec", "jpeg", "--keep-geometry")
    return root / "capture", root / "s.fvv"


def loaded(path):
    """Positions, faces, texture coordinates (v up), and the picture."""
    scene = trimesh.load(path, process=False, maintain_order=True)
    mesh = scene if isinstance(scene, trimesh.Trimesh) else next(iter(scene.geometry.values()))
    material = mesh.visual.material
    picture = material.baseColorTexture if path.suffix == ".glb" else material.image
    return np.array(mesh.vertices), np.array(mesh.faces), np.array(mesh.visual.uv), np.array(picture)


def test_glb_and_obj_have_the_mesh_and_the_texture(made, tmp_path):
    _, stream = made
    for form in "ply", "obj", "glb":
        run("fvvdemux", stream, "-o", tmp_path / form, "--meshes", form)
    plain = trimesh.load(tmp_path / "ply" / (FRAME + "ply"), process=False)
    atlas = np.array(Image.open(tmp_path / "ply/atlas/0001.png"))
    assert atlas.std() > 10
    coordinates = []
    for form in "obj", "glb":
        positions, faces, uv, picture = loaded(tmp_path / form / (FRAME + form))
        assert np.abs(positions - plain.vertices).max() < 1e-6
        assert (faces == plain.faces).all()
        assert (picture == atlas).all()
        coordinates.append(uv)
    assert np.abs(coordinates[0] - coordinates[1]).max() < 1e-6
    assert np.ptp(coordinates[0], axis=0).min() > 0.5
    # A GLB is for other programs: capture.json has cameras and pictures alone.
    described = json.loads((tmp_path / "glb/capture.json").read_text())
    assert "meshes" not in described and "atlas" not in described and len(described["cameras"]) == 2
    # OBJ is also what fvvmux reads.
    run("fvvmux", tmp_path / "obj", "-o", tmp_path / "again.fvv", "--codec", "jpeg", "--keep-geometry")


def test_without_pictures_there_is_no_texture(made, tmp_path):
    _, stream = made
    for form in "obj", "glb":
        run("fvvdemux", stream, "-o", tmp_path / form, "--meshes", form, "--pictures", "none")
    assert b"mtllib" not in (tmp_path / "obj" / (FRAME + "obj")).read_bytes()
    assert not list((tmp_path / "obj/meshes").glob("*.mtl"))
    glb = (tmp_path / "glb" / (FRAME + "glb")).read_bytes()
    assert b"image" not in glb and b"TEXCOORD" not in glb


def test_jpg_is_the_picture_of_the_glb_too(made, tmp_path):
    _, stream = made
    run("fvvdemux", stream, "-o", tmp_path / "out", "--meshes", "glb", "--pictures", "jpg", "--frames", 1)
    glb = (tmp_path / "out" / (FRAME + "glb")).read_bytes()
    assert b'"mimeType":"image/jpeg"' in glb
    assert (tmp_path / "out/atlas/0001.jpg").read_bytes() in glb


@pytest.mark.parametrize("up", TURNED)
def test_up_becomes_plus_y(made, tmp_path, up):
    capture, _ = made
    description = json.loads((capture / "capture.json").read_text())
    description["up"] = up
    path = capture / f"up{up}.json"
    path.write_text(json.dumps(description))
    run("fvvmux", path, "-o", tmp_path / "s.fvv", "--codec", "jpeg", "--keep-geometry", "--frames", 1,
        "--visibility", "none")  # fmt: skip
    for form in "ply", "glb":
        run("fvvdemux", tmp_path / "s.fvv", "-o", tmp_path / form, "--meshes", form)
    own = trimesh.load(next((tmp_path / "ply/meshes").iterdir()), process=False)
    turned = loaded(next((tmp_path / "glb/meshes").iterdir()))[0]
    assert np.abs(np.stack(TURNED[up](*own.vertices.T), 1) - turned).max() < 1e-6
