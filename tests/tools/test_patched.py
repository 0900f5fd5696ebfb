"""Patched frames (clause 8.14) in every tool: what comes out is the mesh of the frame, key mesh and patch in one."""

import json
import struct

import numpy
import pytest
import trimesh
from conftest import CONFORMANCE, run
from real_capture import read_ply
from reference import container
from reference.decode import meshes

CASES = CONFORMANCE / "cases/valid"
STEP = 0.001


def case(name):
    return CASES / name / "input.fvv"


def frames(name):
    """Positions in steps and faces of the frames of a stream of one mesh track, by the reference decoder, without vertices
    that no face uses."""
    out = []
    for chunk in container.chunks(case(name).read_bytes()):
        if chunk.kind == b"GRUP":
            track = meshes.Track()
        if chunk.kind == b"MESH":
            assert track.add(chunk, bool(chunk.flags & container.FLAGS["key"]))
            mesh = track.sequence.mesh
            used, faces = numpy.unique(mesh.faces, return_inverse=True)
            out.append((mesh.positions[used], faces.reshape(-1, 3)))
    return out


def test_fvvinfo_counts_them():
    found = json.loads(run("fvvinfo", "--check", "--json", case("patched_colours")).stdout)
    (track,) = (t for t in found["files"][0]["tracks"] if t["kind"] == "mesh")
    assert {name: row["chunks"] for name, row in track["mesh"]["profiles"].items()} == {
        "raw": 1,
        "delta": 3,
        "patched": 3,
    }


@pytest.mark.parametrize("name", ["patched_colours", "patched_moves", "patched_draco", "patched_everything"])
def test_fvvdemux_writes_whole_meshes(tmp_path, name):
    wanted = frames(name)
    for kind in "ply", "obj", "glb":
        run("fvvdemux", case(name), "-o", tmp_path / kind, "--meshes", kind)
    for number, (positions, faces) in enumerate(wanted):
        ply = read_ply(tmp_path / f"ply/meshes/{number:04d}.ply")
        assert (numpy.rint(ply[0] / STEP) == positions).all()
        assert (ply[1] == faces).all()
        for kind in "obj", "glb":
            found = trimesh.load(tmp_path / f"{kind}/meshes/{number:04d}.{kind}", process=False, force="mesh")
            assert len(found.faces) == len(faces)


def glb_frames(path):
    """Frames of a GLB: its mesh and morph targets."""
    data = path.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    (mesh,) = json.loads(data[20 : 20 + size])["meshes"]
    return 1 + len(mesh["primitives"][0].get("targets", ()))


def test_an_animation_goes_on_until_a_patched_frame(tmp_path):
    # Key, three patched frames, of which the third puts the same faces in place of the last ones; delta, patched, delta.
    run("fvvdemux", case("patched_of_patch"), "-o", tmp_path, "--meshes", "gltf")
    files = sorted((tmp_path / "meshes").iterdir())
    faces = [len(mesh) for _, mesh in frames("patched_of_patch")]
    assert [glb_frames(path) for path in files] == [1, 1, 3, 2]
    at = 0
    for path in files:
        found = trimesh.load(path, process=False, force="mesh")
        assert len(found.faces) == faces[at]
        at += glb_frames(path)
    assert at == len(faces)


def test_fvvcompare_finds_no_difference_where_a_patch_is_what_it_replaces(tmp_path):
    """patched_one cuts out faces of a sheet and puts the same faces in their place."""
    run("fvvdemux", case("patched_one"), "-o", tmp_path / "one")
    done = run("fvvcompare", case("patched_one"), tmp_path / "one", "--json")
    found = json.loads(done.stdout)
    assert found["distance"]["symmetric"]["max"] < 1e-6


def test_fvvrecover_keeps_what_does_not_depend_on_a_lost_one(tmp_path):
    data = bytearray(case("patched_groups").read_bytes())
    at = [data.index(b"MESH")]
    while len(at) < 2:
        at.append(data.index(b"MESH", at[-1] + 4))
    data[at[1] + 60] ^= 4
    (tmp_path / "bad.fvv").write_bytes(data)
    run("fvvrecover", tmp_path / "bad.fvv", "-o", tmp_path / "good.fvv", code=3)
    found = json.loads(run("fvvinfo", "--check", "--json", tmp_path / "good.fvv").stdout)
    (track,) = (t for t in found["files"][0]["tracks"] if t["kind"] == "mesh")
    # Frames 1 and 2 of the first group are lost.
    assert {name: row["chunks"] for name, row in track["mesh"]["profiles"].items()} == {
        "raw": 2,
        "patched": 2,
    }


@pytest.mark.parametrize("frame", [0, 1])
def test_fvvrender_draws_patches(tmp_path, frame):
    """Frame 1 has a patch in other colours than the key mesh: the middle of the picture has them."""
    pixels = {}
    for f in 0, frame:
        path = tmp_path / f"{f}.png"
        run("fvvrender", case("patched_colours"), "-o", path, "--frame", f, "--size", "64x64", "--pose", "0.035,0.02,0.3,0.035,0.025,0,0,1,0", "--force")  # fmt: skip
        pixels[f] = path.read_bytes()
    assert (pixels[0] == pixels[frame]) == (frame == 0)
