"""Captures with one mesh that is not as it should be: fvvmux mends it and says how, or refuses it by file and element."""

import json
import subprocess

import pytest
from conftest import tool_path

TETRAHEDRON = """v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""
FRAMES, BAD = 6, 3
FAR = "m lies more than 2^28 steps of 0.001 m from the origin 0 m [FVV-3006]"

# Name: what the mesh of frame 3 is, and what the summary counts.
MENDED = {
    "duplicate vertices": (
        TETRAHEDRON.replace("f 2 3 4", "v 1 0 0\nv 0 1 0\nf 5 6 4"),
        {"welded_vertices": 2},
    ),
    "zero-area faces": (
        TETRAHEDRON + "v 0.5 0 0\nf 1 1 2\nf 1 5 2\n",
        {"degenerate_faces": 2, "unreferenced_vertices": 1},
    ),
    "non-manifold edge": (
        TETRAHEDRON + "v 1 1 1\nf 1 2 5\n",
        {"nonmanifold_edges": 1, "boundary_edges": 2},
    ),
    "bow-tie": (TETRAHEDRON + "v -1 0 0\nv 0 -1 0\nv 0 0 -1\nf 1 6 5\nf 1 7 6\nf 1 5 7\nf 5 6 7\n", {}),
    "mixed winding": (TETRAHEDRON.replace("f 1 3 2", "f 1 2 3"), {"flipped_faces": 1}),
    "unreferenced vertex": (TETRAHEDRON + "v 90000 0 0\n", {"unreferenced_vertices": 1}),
    "one triangle": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", {"boundary_edges": 3}),
}
# Name: what the mesh of frame 3 is, and what is said of it behind "fvvmux: meshes/3.obj".
REFUSED = {
    "NaN": (TETRAHEDRON.replace("0 1 0", "0 nan 0"), ':3: expected a finite number after v, found "nan"'),
    "infinity": (TETRAHEDRON.replace("0 1 0", "0 1e999 0"), ':3: expected a finite number after v, found "1e999"'),
    "1e6": (TETRAHEDRON.replace("0 1 0", "0 1e6 0"), f": frame 3: vertex 2: y = 1e+06 {FAR}"),
    "3e38": (TETRAHEDRON.replace("0 1 0", "0 3e38 0"), f": frame 3: vertex 2: y = 3e+38 {FAR}"),
    "no face": (TETRAHEDRON[:32], ": expected at least one face (f), found none"),
    "zero area alone": (
        "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
        ": frame 3: no face is left of 1: 1 degenerate, 0 duplicate, 0 in components of fewer than 0",
    ),
    "index out of range": (TETRAHEDRON + "f 1 2 9\n", ":9: vertex 9 is used, the file has 4"),
}  # fmt: skip


@pytest.fixture
def mux(tmp_path):
    """Muxes six tetrahedra, of which frame 3 is the given OBJ; the stream is out.fvv."""
    tool = tool_path("fvvmux")
    assert tool, "fvvmux was not built"
    (tmp_path / "meshes").mkdir()
    capture = {
        "fvv_capture": 1,
        "frame_rate": 25,
        "frames": {"first": 0, "count": FRAMES},
        "units": "metres",
        "up": "+y",
        "lattice": {"origin": [0, 0, 0], "step": 0.001},
        "meshes": {"pattern": "meshes/%d.obj"},
        "cameras": [],
    }
    (tmp_path / "capture.json").write_text(json.dumps(capture))

    def run(bad, *options):
        for i in range(FRAMES):
            (tmp_path / f"meshes/{i}.obj").write_text(bad if i == BAD else TETRAHEDRON)
        command = [tool, "capture.json", "-o", "out.fvv", "--json", *options]
        return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=60)

    run.stream = tmp_path / "out.fvv"
    run.mesh = tmp_path / f"meshes/{BAD}.obj"
    return run


@pytest.mark.parametrize("profile", ["raw", "draco"])
@pytest.mark.parametrize("name", MENDED)
def test_a_mesh_that_can_be_mended_is_counted_and_read_back(mux, fvvinfo, name, profile):
    text, changes = MENDED[name]
    done = mux(text, "--mesh-profile", profile, "--verify")
    assert (done.returncode, done.stderr) == (0, "")
    summary = json.loads(done.stdout)
    counted = {k: v for k, v in summary["mesh"].items() if isinstance(v, dict) and v.get("count")}
    assert counted == {change: {"count": count, "frames": 1} for change, count in changes.items()}
    assert summary["verified"]["meshes"] == FRAMES
    assert fvvinfo("--check", mux.stream).returncode == 0


@pytest.mark.parametrize("name", REFUSED)
def test_a_mesh_that_no_stream_can_hold_is_refused_by_file_and_element(mux, name):
    text, message = REFUSED[name]
    done = mux(text)
    assert (done.returncode, done.stderr) == (1, f"fvvmux: meshes/{BAD}.obj{message}\n")
    assert not mux.stream.exists()


def test_an_empty_file_is_found_before_any_work(mux):
    done = mux("")
    assert (done.returncode, done.stderr) == (
        1,
        "fvvmux: capture.json: 1 of 6 meshes is empty, first: meshes/3.obj\n",
    )
    assert not mux.stream.exists()


def test_frames_in_front_of_a_bad_one_can_be_taken_alone(mux):
    done = mux(REFUSED["NaN"][0], "--frames", "0-2")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["frames"] == BAD
