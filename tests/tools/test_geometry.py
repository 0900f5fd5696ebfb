"""What fvvmux does to meshes: decimation by a budget in pixels, winding, and repair of bad meshes."""

import json

import numpy as np
import pytest
from conftest import figures, read_json, run
from PIL import Image

# Decimation, measured by fvvcompare.


@pytest.fixture(scope="module")
def captures(tmp_path_factory):
    root = tmp_path_factory.mktemp("captures")
    for meshes in "hull", "tracked":
        options = ["--rig", "small", "--frames", 3, "--cameras", 4, "--size", "240x135", "--meshes", meshes]
        run("fvvsynth", "-o", root / meshes, *options)
    return root


def mux(capture, path, *options):
    settings = ["--codec", "jpeg", "--quality", 10, "--force", *options]
    return figures("fvvmux", capture, "-o", path, *settings, code=(0, 3))  # 3: a speck vanished


@pytest.mark.parametrize("meshes", [pytest.param("hull", marks=pytest.mark.long), "tracked"])
def test_the_budget_holds_by_another_measure(captures, tmp_path, meshes):
    capture, path = captures / meshes, tmp_path / "out.fvv"
    before = 0
    for pixels in 0.15, 0.05:
        summary = mux(capture, path, "--max-error", pixels, "--verify")
        budget = summary["budget"]
        assert budget["decimated_frames"] == 3 and budget["kept_frames"] == 0
        assert before < budget["triangles"] < budget["triangles_before"] / 2
        before = budget["triangles"]
        assert summary["lattice"]["error_pixels"] <= pixels
        assert budget["rms_pixels"] <= pixels and budget["max_pixels"] <= 6 * pixels
        # The players are within a few metres, so no pixel covers twice what the sharpest does.
        for frame in range(3):
            distances = figures("fvvcompare", capture, path, "--frames", f"{frame}-{frame}")["distance"]
            found = distances["symmetric"]
            assert found["rms"] <= 2 * pixels * budget["pixel"]
            if budget["vanished_pieces"] == 0:  # specks that the lattice swallows have nothing near
                assert found["max"] <= 2 * 6 * pixels * budget["pixel"]
            # Delta frames are counted as a coarser lattice, and err less.
            assert (0.85 if meshes == "hull" else 0.6) < found["rms"] / budget["rms"] < 1.15
        # Fitted to the source, or chords of it.
        assert abs(budget["volume_change"]) < (0.01 if meshes == "hull" else 0.05)


def test_a_run_keeps_its_faces(captures, tmp_path):
    path = tmp_path / "out.fvv"
    mux(captures / "tracked", path, "--mesh-profile", "raw")
    run("fvvdemux", path, "-o", tmp_path / "out")
    temporal = figures("fvvcompare", tmp_path / "out", captures / "tracked")
    counts = {(frame["a"]["faces"], frame["a"]["vertices"]) for frame in temporal["frames"]}
    assert len(counts) == 1 and counts.pop()[0] < 20000


def test_overrides(captures, tmp_path):
    path = tmp_path / "out.fvv"
    hull = captures / "hull"
    kept = mux(hull, path, "--keep-geometry")
    assert "--keep-geometry" in kept["budget"]["reason"]
    assert "triangles" not in kept["budget"]
    some = mux(hull, path, "--triangles", 3000, "--step", "2mm")
    assert some["lattice"]["step"] == 0.002
    assert 2000 < some["budget"]["triangles"] <= 3000
    assert some["budget"]["rms"] > 0 and some["mesh"]["bytes"] < kept["mesh"]["bytes"] / 3
    done = run("fvvmux", hull, "-o", path, "--force", "--keep-geometry", "--triangles", 9, code=2)
    assert "--triangles" in done.stderr or "--keep-geometry" in done.stderr
    done = run("fvvmux", hull, "-o", path, "--force", "--max-error", "0", code=2)
    assert "--max-error: expected pixels such as 0.15, or a length such as 1mm" in done.stderr


def test_what_was_lost_is_reported(captures, tmp_path):
    done = run("fvvmux", captures / "hull", "-o", tmp_path / "out.fvv", "--triangles", 60, "--codec", "jpeg",
                "--quality", 10, "--max-error", 0.01, code=3)  # fmt: skip
    assert "frame 0: " in done.stderr and "of the surface are further off than 0.06 px" in done.stderr


def test_a_capture_from_a_stream_is_not_decimated_again(captures, tmp_path):
    mux(captures / "hull", tmp_path / "once.fvv")
    run("fvvdemux", tmp_path / "once.fvv", "-o", tmp_path / "out")
    again = mux(tmp_path / "out", tmp_path / "twice.fvv")
    assert "brings its lattice" in again["budget"]["reason"]
    assert (
        figures("fvvcompare", tmp_path / "once.fvv", tmp_path / "twice.fvv")["distance"]["symmetric"]["max"]
        < 1e-12
    )


@pytest.mark.long
def test_the_same_bytes_for_any_number_of_threads(captures, tmp_path):
    for meshes in "hull", "tracked":
        streams = set()
        for threads in 1, 3:
            mux(captures / meshes, tmp_path / "out.fvv", "--threads", threads)
            streams.add((tmp_path / "out.fvv").read_bytes())
        assert len(streams) == 1


# Faces that are wound inside out: fvvmux finds them, warns, and turns them round on request.

SIZE = 64
COLOURS = [(200, 40, 40), (40, 200, 40), (40, 40, 200)]


def ball(whole):
    """A ball around the origin with its faces outwards, or the half of it at negative z, which is open."""
    rings, sides = 8, 16
    upper = np.pi if whole else np.pi / 2
    points, faces = [], []
    for polar in np.linspace(0.01, upper - 0.01, rings):  # from -z
        for around in np.arange(sides) * 2 * np.pi / sides:
            points.append((np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), -np.cos(polar)))
    for ring in range(rings - 1):
        for side in range(sides):
            a, b = ring * sides + side, ring * sides + (side + 1) % sides
            faces += [(a, b, b + sides), (a, b + sides, a + sides)]
    return np.array(points), np.array(faces)


def scene(folder, inside_out, whole=True, cameras=3, normals=None):
    """A capture of one frame. normals: 1 for those of the ball, -1 for their opposites."""
    folder.mkdir()
    points, faces = ball(whole)
    lines = ["v {} {} {}".format(*p) for p in points]
    if normals:
        lines += ["vn {} {} {}".format(*(normals * p)) for p in points]
    for face in faces + 1:
        corners = [f"{i}//{i}" if normals else str(i) for i in (face[::-1] if inside_out else face)]
        lines.append("f " + " ".join(corners))
    (folder / "mesh_0000.obj").write_text("\n".join(lines) + "\n")
    described = []
    for number in range(cameras):
        # Three sides of the half that is always there; 4 away from the origin, looking at it.
        angle = (number - 1) * 0.6
        Image.new("RGB", (SIZE, SIZE), COLOURS[number]).save(folder / f"{number}_0000.png")
        cos, sin = np.cos(angle), np.sin(angle)
        described.append(
            {
                "id": number,
                "width": SIZE,
                "height": SIZE,
                "intrinsics": {"fx": 80, "fy": 80, "cx": SIZE / 2, "cy": SIZE / 2},
                "rotation": [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]],
                "translation": [0, 0, 4],
                "pictures": f"{number}_%04d.png",
            }
        )
    description = {
        "fvv_capture": 1,
        "name": "ball",
        "frame_rate": "25",
        "frames": {"first": 0, "count": 1},
        "units": "metres",
        "up": "-y",
        "meshes": {"pattern": "mesh_%04d.obj"},
        "cameras": described,
    }
    (folder / "capture.json").write_text(json.dumps(description))
    return folder


def pack(capture, out, *options, code=0):
    return run("fvvmux", capture, "-o", out, "--codec", "jpeg", "--quality", 90, "--step", "1mm",
                "--crop", "none", *options, code=code)  # fmt: skip


def middle_colour(stream, picture):
    run("fvvrender", stream, "--camera", 1, "-o", picture, "--visible-by", "depth", "--best", 1)
    return np.asarray(Image.open(picture))[SIZE // 2, SIZE // 2].astype(int)


@pytest.mark.parametrize("whole", [True, False])
def test_faces_with_their_backs_to_the_cameras_are_found_and_turned(tmp_path, whole):
    capture = scene(tmp_path / "turned", inside_out=True, whole=whole)
    done = pack(capture, tmp_path / "as_it_is.fvv", code=3)
    assert done.stderr.startswith(f"fvvmux: warning: {capture / 'capture.json'}: 100 % of the surface")
    assert "--winding flip" in done.stderr and done.stderr.count("\n") == 1
    assert "winding   as in the files: 100 %" in done.stdout
    assert pack(capture, tmp_path / "meant.fvv", "--winding", "keep").stderr == ""
    done = pack(capture, tmp_path / "flipped.fvv", "--winding", "flip", "--verify")
    assert done.stderr == "" and "winding   flipped: 0 %" in done.stdout
    done = pack(capture, tmp_path / "auto.fvv", "--winding", "auto", "--json")
    winding = read_json(done, "fvvmux")["mesh"]["winding"]
    assert winding == {"flipped": True, "turned_away": 0, "by_cameras": True}
    read = {
        name: (tmp_path / f"{name}.fvv").read_bytes() for name in ("as_it_is", "meant", "flipped", "auto")
    }
    assert read["as_it_is"] == read["meant"] != read["flipped"] == read["auto"]
    assert np.abs(middle_colour(tmp_path / "flipped.fvv", tmp_path / "v.png") - COLOURS[1]).max() < 60
    run("fvvrender", tmp_path / "meant.fvv", "--camera", 1, "-o", tmp_path / "unseen.png",
         "--visible-by", "depth", "--unseen", "10,200,60", warns=True)  # fmt: skip
    assert (np.asarray(Image.open(tmp_path / "unseen.png"))[SIZE // 2, SIZE // 2] == [10, 200, 60]).all()


def test_faces_that_are_right_stay(tmp_path):
    capture = scene(tmp_path / "right", inside_out=False)
    outputs = [tmp_path / "default.fvv", tmp_path / "auto.fvv"]
    for out, options in zip(outputs, [(), ("--winding", "auto")]):
        assert pack(capture, out, *options).stderr == ""
    assert outputs[0].read_bytes() == outputs[1].read_bytes()
    done = pack(capture, tmp_path / "flipped.fvv", "--winding", "flip", code=3)
    assert "with --winding flip 100 % of the surface" in done.stderr
    assert "--winding: expected keep, flip or auto, found" in pack(
        capture, tmp_path / "x.fvv", "--winding", "turn", code=2).stderr  # fmt: skip


def test_without_cameras_the_volume_decides(tmp_path):
    capture = scene(tmp_path / "turned", inside_out=True, cameras=0)
    done = pack(capture, tmp_path / "x.fvv", code=3)
    assert "100 % of the sampled meshes enclose a negative volume: the faces are inside out (" in done.stderr
    assert pack(capture, tmp_path / "y.fvv", "--winding", "auto").stderr == ""


@pytest.mark.parametrize("normals", [1, -1])
def test_normals_point_out_when_faces_are_turned(tmp_path, normals):
    """Normals in the file either agree with its faces or point out of the ball while the faces are inside out."""
    capture = scene(tmp_path / "turned", inside_out=True, normals=normals)
    pack(capture, tmp_path / "x.fvv", "--winding", "flip", "--normals", "always", "--verify")
    run("fvvdemux", tmp_path / "x.fvv", "-o", tmp_path / "out", "--meshes", "obj")
    rows = [line.split() for line in next((tmp_path / "out/meshes").glob("*.obj")).read_text().splitlines()]
    points, sent = (np.array([row[1:4] for row in rows if row[0] == key], float) for key in ("v", "vn"))
    faces = np.array([[c.split("/")[0] for c in row[1:4]] for row in rows if row[0] == "f"], int) - 1
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    assert ((np.cross(b - a, c - a) * (a + b + c)).sum(1) > 0).all()
    assert ((sent * points).sum(1) > 0.98).all()


# One bad mesh: fvvmux repairs it and reports that, or refuses it by file and element.

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
REPAIRED = {
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
# Name: what the mesh of frame 3 is, and the message after "fvvmux: meshes/3.obj".
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
def mux_six(fvvmux, tmp_path):
    """Muxes six tetrahedra, of which frame 3 is the given OBJ; the stream is out.fvv."""
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

    def mux_six(bad, *options):
        for i in range(FRAMES):
            (tmp_path / f"meshes/{i}.obj").write_text(bad if i == BAD else TETRAHEDRON)
        return fvvmux("capture.json", "-o", "out.fvv", "--json", *options, cwd=tmp_path)

    mux_six.stream = tmp_path / "out.fvv"
    return mux_six


@pytest.mark.parametrize("profile", ["raw", "draco"])
@pytest.mark.parametrize("name", REPAIRED)
def test_a_mesh_that_can_be_repaired_is_counted_and_read_back(mux_six, fvvinfo, name, profile):
    text, changes = REPAIRED[name]
    done = mux_six(text, "--mesh-profile", profile, "--verify")
    assert (done.returncode, done.stderr) == (0, b"")
    summary = read_json(done, "fvvmux")
    counted = {k: v for k, v in summary["mesh"].items() if isinstance(v, dict) and v.get("count")}
    assert counted == {change: {"count": count, "frames": 1} for change, count in changes.items()}
    assert summary["verified"]["meshes"] == FRAMES
    assert fvvinfo("--check", mux_six.stream).returncode == 0


@pytest.mark.parametrize("name", REFUSED)
def test_a_mesh_that_no_stream_can_hold_is_refused_by_file_and_element(mux_six, name):
    text, message = REFUSED[name]
    done = mux_six(text)
    found, advice = done.stderr.decode().rsplit(" (", 1)
    assert (done.returncode, found) == (1, f"fvvmux: meshes/{BAD}.obj{message}")
    assert advice.endswith("--skip-bad-frames leaves out frames whose files cannot be used)\n")
    assert f"frame {BAD}" in done.stderr.decode()
    assert not mux_six.stream.exists()


def test_an_empty_file_is_found_before_any_work(mux_six):
    done = mux_six("")
    assert (done.returncode, done.stderr) == (
        1,
        b"fvvmux: capture.json: 1 of 6 meshes is empty, first: meshes/3.obj\n"
        b"fvvmux: capture.json: --skip-bad-frames leaves out frames whose files cannot be used\n",
    )
    assert not mux_six.stream.exists()


def test_frames_before_a_bad_one_can_be_taken_alone(mux_six):
    done = mux_six(REFUSED["NaN"][0], "--frames", "0-2")
    assert (done.returncode, done.stderr) == (0, b"")
    assert read_json(done, "fvvmux")["frames"] == BAD
