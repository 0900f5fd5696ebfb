"""Captures that are odd, as strangers' are: no loss is silent, and bytes stay in proportion.

Each case sets an error and measures the result: fvvdemux writes the decoded meshes, whose
vertices are compared with the source's surface, a sphere, in closed form.
"""

import json
import math
import shutil

import numpy as np
import pictures
import pytest
from conftest import figures, read_json, run


def sphere(radius=0.5, columns=48, centre=(0, 0, 0)):
    """Vertices and faces of a closed ball."""
    rows = columns // 2
    vertices = [(0, radius, 0)]
    for i in range(1, rows):
        for j in range(columns):
            polar, around = math.pi * i / rows, 2 * math.pi * j / columns
            ring = radius * math.sin(polar)
            vertices.append((ring * math.cos(around), radius * math.cos(polar), ring * math.sin(around)))
    vertices.append((0, -radius, 0))

    def at(i, j):
        return 1 + (i - 1) * columns + j % columns

    faces = []
    for j in range(columns):
        faces.append((0, at(1, j + 1), at(1, j)))
        faces.append((len(vertices) - 1, at(rows - 1, j), at(rows - 1, j + 1)))
        for i in range(1, rows - 1):
            faces.append((at(i, j), at(i, j + 1), at(i + 1, j)))
            faces.append((at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)))
    return np.array(vertices) + centre, np.array(faces)


TETRAHEDRON = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


def write_capture(folder, meshes, **more):
    """A capture without cameras. meshes: vertices and faces of each frame."""
    folder.mkdir(parents=True)
    for i, (vertices, faces) in enumerate(meshes):
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
        lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
        (folder / f"{i:04d}.obj").write_text("\n".join(lines) + "\n")
    description = {
        "fvv_capture": 1,
        "name": folder.name,
        "frame_rate": "25",
        "frames": {"first": 0, "count": len(meshes)},
        "units": "metres",
        "up": "+y",
        "cameras": [],
        "meshes": {"pattern": "%04d.obj"},
        **more,
    }
    (folder / "capture.json").write_text(json.dumps(description))
    return folder


def mux(capture, *options, code=0):
    return figures("fvvmux", capture, "-o", capture.with_suffix(".fvv"), "--force", *options, code=code)


def decoded(capture):
    """Vertices and number of faces of each frame of the stream of a capture."""
    out = capture.with_suffix(".out")
    run("fvvdemux", capture.with_suffix(".fvv"), "-o", out, "--meshes", "obj", "--force")
    meshes = []
    for path in sorted((out / "meshes").glob("*.obj")):
        lines = [line.split() for line in path.read_text().splitlines()]
        vertices = np.array([line[1:4] for line in lines if line and line[0] == "v"], float)
        meshes.append((vertices, sum(bool(line) and line[0] == "f" for line in lines)))
    return meshes


def off_by(vertices, centre=(0, 0, 0), radius=0.5):
    return np.abs(np.linalg.norm(vertices - centre, axis=1) - radius)


@pytest.mark.parametrize("used", [True, False])
def test_a_vertex_far_away_takes_nothing_from_the_others(tmp_path, used):
    vertices, faces = sphere()
    if used:
        vertices[7] = (10000, 0, 0)
    else:
        vertices = np.vstack([vertices, [(10000, 0, 0)]])
    capture = write_capture(tmp_path / "far", [(vertices, faces)])
    summary = mux(capture)
    assert summary["lattice"]["step"] < 0.001
    [(found, count)] = decoded(capture)
    assert count == len(faces)
    near = off_by(found)[np.abs(found).max(axis=1) < 1]
    assert len(near) >= len(vertices) - 1 and near.max() <= summary["budget"]["max_error"] * math.sqrt(3)


@pytest.mark.parametrize("used", [True, False])
def test_a_vertex_beyond_any_lattice_is_an_error_that_names_it(tmp_path, used):
    vertices, faces = sphere()
    vertices = np.vstack([vertices, [(1e30, 0, 0)]])
    if used:
        faces[0][0] = len(vertices) - 1
    capture = write_capture(tmp_path / "beyond", [(vertices, faces)])
    done = run("fvvmux", capture, "-o", tmp_path / "out.fvv", code=1)
    assert f"0000.obj: frame 0: vertex {len(vertices) - 1}: x = 1e+30 m" in done.stderr
    assert not (tmp_path / "out.fvv").exists()


@pytest.mark.parametrize("scale", [0.001, 1000])
def test_a_first_frame_of_another_size_does_not_decide_for_the_others(tmp_path, scale):
    vertices, faces = sphere()
    capture = write_capture(tmp_path / "sizes", [(vertices * scale, faces)] + [(vertices, faces)] * 4)
    done = run("fvvmux", capture, "-o", capture.with_suffix(".fvv"), "--json", code=(0, 3))
    # What the small one loses on the lattice of the others is reported.
    assert (done.returncode == 3) == (scale < 1)
    if scale < 1:
        assert "frame 0: faces with " in done.stderr and "of the area vanish on the lattice" in done.stderr
        assert done.stderr.count("\n") == 1
    allowed = json.loads(done.stdout)["budget"]["max_error"]
    assert 0.00005 < allowed < 0.0005
    for found, count in decoded(capture)[1:]:
        assert count == len(faces) and off_by(found).max() <= allowed * math.sqrt(3)


@pytest.mark.parametrize("count", [1, 2])
def test_pieces_smaller_than_the_lattice_vanish_with_a_warning(tmp_path, count):
    vertices, faces = sphere()
    speck, its_faces = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]) * 1e-5, np.array(TETRAHEDRON)
    for i in range(count):
        faces = np.vstack([faces, its_faces + len(vertices)])
        vertices = np.vstack([vertices, speck + (i + 1, 0, 0)])
    capture = write_capture(tmp_path / "specks", [(vertices, faces)])
    out = tmp_path / "out.fvv"
    done = run("fvvmux", capture, "-o", out, "--step", "1mm", "--keep-geometry", code=3)
    what = "1 piece of" if count == 1 else "2 pieces of"
    assert f"frame 0: {what} " in done.stderr and "on the lattice, whose step is 1 mm" in done.stderr
    assert done.stderr.count("\n") == 1
    # What was asked to be dropped is no loss.
    run("fvvmux", capture, "-o", out, "--force", "--step", "1mm", "--keep-geometry", "--min-component", 5)


def test_millimetres_that_are_called_metres_lose_nothing(tmp_path):
    vertices, faces = sphere()
    capture = write_capture(tmp_path / "huge", [(vertices * 1000, faces)])
    summary = mux(capture)
    [(found, count)] = decoded(capture)
    assert count == len(faces) and off_by(found, radius=500).max() <= summary["budget"][
        "max_error"
    ] * math.sqrt(3)


def test_coordinates_of_maps_get_an_origin_near_them(tmp_path):
    vertices, faces = sphere()
    east, north = 500123.4, 5400321.7
    capture = write_capture(tmp_path / "map", [(vertices + (east, north, 100), faces)] * 2)
    summary = mux(capture, "--verify")
    assert summary["lattice"]["origin"] == [500123, 5400322, 100]
    for found, count in decoded(capture):
        assert count == len(faces)
        # Doubles of OBJ and of the source are a nanometre apart there.
        off = off_by(found, (east, north, 100)).max()
        assert off <= summary["budget"]["max_error"] * math.sqrt(3) + 1e-8
    near = mux(write_capture(tmp_path / "near", [(vertices + (100, 0, 0), faces)]))
    assert near["lattice"]["origin"] == [0, 0, 0]


def test_a_step_that_swallows_faces_is_reported_with_its_frames(tmp_path):
    capture = write_capture(tmp_path / "coarse", [sphere()] * 2)
    done = run("fvvmux", capture, "-o", tmp_path / "out.fvv", "--step", "20cm", code=3)
    for frame in 0, 1:
        assert f"frame {frame}: faces with " in done.stderr
    assert "whose step is 200 mm, as --step says" in done.stderr


def moving(frames=25, columns=48):
    """Of constant connectivity; it grows and moves, so that no motion is a whole number of steps."""
    vertices, faces = sphere(columns=columns)
    return [(vertices * (1 + 0.003 * i) + (0.0137 * i, 0.003 * math.sin(i), 0), faces) for i in range(frames)]


def test_a_budget_in_millimetres_drives_lattice_motion_and_decimation(tmp_path):
    frames = moving()
    capture = write_capture(tmp_path / "budget", frames)
    default = mux(capture)
    assert default["budget"]["unit"] == "metres" and "triangles" not in default["budget"]
    before = default["mesh"]["bytes"]
    for text, metres in ("1mm", 0.001), ("0.5cm", 0.005):
        summary = mux(capture, "--max-error", text, "--verify")
        assert summary["budget"]["max_error"] == metres
        step, steps = summary["lattice"]["step"], summary["mesh"]["delta"]["max_error_steps"]
        assert (0.5 + steps) * step <= metres * (1 + 1e-9) and steps >= 1
        assert summary["budget"]["rms"] <= metres and summary["budget"]["max"] <= 6 * metres
        assert summary["budget"]["triangles"] < len(frames[0][1])
        assert summary["mesh"]["bytes"] < before
        before = summary["mesh"]["bytes"]
        for i, (found, _) in enumerate(decoded(capture)):
            centre = (0.0137 * i, 0.003 * math.sin(i), 0)
            # Vertices of the source, moved by lattice and motion alone.
            assert off_by(found, centre, 0.5 * (1 + 0.003 * i)).max() <= metres * math.sqrt(3)
    kept = mux(capture, "--max-error", "1mm", "--keep-geometry")
    assert kept["mesh"]["bytes"] < default["mesh"]["bytes"]


def test_a_budget_whose_unit_has_no_meaning_is_refused(tmp_path):
    capture = write_capture(tmp_path / "none", [sphere()])
    for text in "5", "0.15px":
        done = run("fvvmux", capture, "-o", tmp_path / "out.fvv", "--max-error", text, code=2)
        assert "--max-error: expected a length such as 1mm, because there are no cameras" in done.stderr
    for text in "1px mm", "mm", "-1mm", "1e9mm", "1 km":
        done = run("fvvmux", capture, "-o", tmp_path / "out.fvv", f"--max-error={text}", code=2)
        assert "--max-error: expected pixels such as 0.15, or a length such as 1mm" in done.stderr
    unknown = write_capture(tmp_path / "unknown", [sphere()], units="unknown")
    done = run("fvvmux", unknown, "-o", tmp_path / "out.fvv", "--max-error", "1mm", code=2)
    assert "its scale is unknown" in done.stderr
    assert mux(unknown, "--max-error", "0.01")["budget"]["unit"] == "units"


def test_a_given_lattice_that_breaks_a_given_budget_is_reported(tmp_path):
    capture = write_capture(tmp_path / "both", [sphere()])
    done = run("fvvmux", capture, "-o", tmp_path / "out.fvv", "--step", "5mm", "--max-error", "1mm",
                "--keep-geometry", code=3)  # fmt: skip
    assert (
        "the lattice step of 5 mm, as --step says, errs by more than --max-error allows, 1 mm" in done.stderr
    )


def test_few_frames_that_share_their_faces_do_not_make_the_whole_stream_finer(tmp_path):
    meshes = [sphere(columns=40 + 2 * i) for i in range(20)]
    capture = write_capture(tmp_path / "mixed", [meshes[0], *meshes])  # the first two are the same
    mixed = mux(capture)
    assert mixed["mesh"]["delta"]["frames"] == 1
    assert mixed["mesh"]["bytes"] <= mux(capture, "--no-delta")["mesh"]["bytes"]


EMPTY_PLY = """ply
format ascii 1.0
element vertex 0
property float x
property float y
property float z
element face 0
property list uchar int vertex_indices
end_header
"""


def describe(capture, change):
    """Changes the capture.json of a capture."""
    path = capture / "capture.json"
    description = json.loads(path.read_text())
    change(description)
    path.write_text(json.dumps(description))


def groups_of(stream):
    """Of each group: its first tick, the one after it, and the times of its meshes."""
    groups = []
    for chunk in figures("fvvinfo", stream, "--chunks")["files"][0]["chunks"]:
        if chunk["type"] == "GRUP":
            groups.append([int(chunk["time"]), None, []])
        if chunk["type"] == "GEND":
            groups[-1][1] = int(chunk["time"])
        if chunk["type"] == "MESH":
            groups[-1][2].append(int(chunk["time"]))
    return groups


def test_at_frames_without_a_mesh_nothing_is_on_stage(tmp_path):
    """Declared empty without a file (0, 3 to 5), and two files without vertices and faces (8, 9)."""
    frames = moving(10)
    capture = write_capture(tmp_path / "stage", frames)
    describe(capture, lambda d: d["meshes"].update(empty=[0, [3, 5]]))
    full = mux(write_capture(tmp_path / "full", frames), "--max-error", "1mm", "--keep-geometry")
    for i in 0, 3, 4, 5:
        (capture / f"{i:04d}.obj").unlink()
    for i in 8, 9:
        (capture / f"{i:04d}.obj").write_text("# nothing\n# on stage\n")
    summary = mux(capture, "--max-error", "1mm", "--keep-geometry", "--verify")
    assert summary["frames"] == 4 and summary["mesh"]["empty_frames"] == 6
    # Each stretch has a key frame.
    assert summary["mesh"]["key"]["frames"] == 2 and summary["mesh"]["bytes"] < 2 * full["mesh"]["bytes"]
    stream = capture.with_suffix(".fvv")
    assert groups_of(stream) == [[0, 3, [1, 2]], [3, 8, [6, 7]], [8, 10, []]]
    info = figures("fvvinfo", "--check", stream)["files"][0]
    assert info["frames"] == 4 and info["times_without_frame"] == 6 and info["integrity"] == "complete"
    out = capture.with_suffix(".out")
    for (found, count), i in zip(decoded(capture), (1, 2, 6, 7)):
        assert (out / "meshes" / f"{i:04d}.obj").exists() and count == len(frames[i][1])
        centre = (0.0137 * i, 0.003 * math.sin(i), 0)
        assert off_by(found, centre, 0.5 * (1 + 0.003 * i)).max() <= 0.001 * math.sqrt(3)
    described = json.loads((out / "capture.json").read_text())
    assert described["frames"] == {"first": 0, "count": 10, "step": 1}
    assert described["meshes"]["empty"] == [0, [3, 5], [8, 9]]
    again = mux(out, "--verify", "--keep-geometry")
    assert again["frames"] == 4 and again["mesh"]["empty_frames"] == 6
    compared = figures("fvvcompare", capture, stream)
    assert compared["compared"] == 4 and compared["distance"]["symmetric"]["max"] <= 0.001 * math.sqrt(3)
    assert compared["warnings"] == [] and compared["losses"] == []
    compared = figures("fvvcompare", tmp_path / "full", stream, code=3)
    assert compared["compared"] == 4 and "6 of 10 frames have no partner" in compared["warnings"][0]


def test_a_mesh_that_is_missing_and_not_declared_is_an_error_with_advice(tmp_path):
    frames = moving(3)
    capture = write_capture(tmp_path / "missing", frames)
    (capture / "0001.obj").unlink()
    done = run("fvvmux", capture, "-o", tmp_path / "out.fvv", code=1)
    assert "1 of 3 meshes is missing: 1 (first: 0001.obj)" in done.stderr
    assert '"meshes": {"empty": ...} says at which frames the stage is empty' in done.stderr
    for empty, why in (
        ([1, 5], "number of a frame"),
        ([[2, 1]], "last one first"),
        ([0, 1, 2], "no frame has"),
    ):
        describe(capture, lambda d, empty=empty: d["meshes"].update(empty=empty))
        assert why in run("fvvmux", capture, "-o", tmp_path / "out.fvv", code=1).stderr
    # Vertices without faces are a mistake.
    describe(capture, lambda d: d["meshes"].update(empty=[1]))
    (capture / "0000.obj").write_text("v 0 0 0\n")
    assert "at least one face" in run("fvvmux", capture, "-o", tmp_path / "out.fvv", code=1).stderr
    # Frames that the capture leaves out are not there at all: the frame before lasts.
    capture = write_capture(tmp_path / "left", moving(4), frames={"first": 0, "count": 4, "left_out": [1]})
    (capture / "0001.obj").unlink()
    assert mux(capture, "--verify")["frames"] == 3
    assert groups_of(capture.with_suffix(".fvv")) == [[0, 4, [0, 2, 3]]]
    decoded(capture)
    described = json.loads((capture.with_suffix(".out") / "capture.json").read_text())
    assert described["frames"] == {"first": 0, "count": 4, "step": 1, "left_out": [1]}


@pytest.fixture
def small(eight_frames, tmp_path):
    """The capture with meshes that keep their faces, to change."""
    return shutil.copytree(eight_frames, tmp_path / "small")


def test_pictures_of_frames_without_a_mesh_stay(small, tmp_path):
    describe(small, lambda d: d["meshes"].update(empty=[0, 4, 5]))
    for i in 0, 4:
        next((small / "meshes").glob(f"{i:04d}.*")).unlink()
    (small / "meshes" / "0007.ply").write_text(EMPTY_PLY)
    summary = mux(small, "--verify")
    assert summary["frames"] == 8 and summary["mesh"]["empty_frames"] == 4
    assert summary["verified"]["meshes"] == 4
    stream = small.with_suffix(".fvv")
    assert groups_of(stream) == [[0, 4, [1, 2, 3]], [4, 7, [6]], [7, 8, []]]
    [mesh] = [track for track in figures("fvvinfo", stream)["files"][0]["tracks"] if track["kind"] == "mesh"]
    assert mesh["mesh"]["frames_without"] == 4
    out = tmp_path / "out"
    run("fvvdemux", stream, "-o", out)
    assert sorted(path.name for path in (out / "meshes").iterdir()) == [f"{i:04d}.ply" for i in (1, 2, 3, 6)]
    assert len(list((out / "cam0").iterdir())) == 8
    assert json.loads((out / "capture.json").read_text())["meshes"]["empty"] == [0, [4, 5], 7]
    assert mux(out, "--verify", "--cameras", "0")["mesh"]["empty_frames"] == 4
    for frame, shows in (0, False), (3, True), (4, False), (7, False):
        drawn = figures("fvvrender", stream, "--frame", frame, "--camera", "0", "-o", out / f"{frame}.png")
        assert (drawn["surface"]["pixels"] > 0) == shows


def test_frames_that_cannot_be_used_are_left_out_on_request(small, tmp_path):
    """A mesh that is cut, one with NaN, one beyond the lattice, a missing and a truncated picture, one of another size."""
    meshes = sorted((small / "meshes").iterdir())
    whole = mux(small)
    meshes[1].write_bytes(meshes[1].read_bytes()[:-7])
    (small / "cam1" / "0002.png").unlink()
    spoiled = bytearray(meshes[3].read_bytes())
    start = spoiled.index(b"end_header\n") + 11
    wide = b"property double x" in spoiled
    spoiled[start : start + (8 if wide else 4)] = np.array([np.nan], "<f8" if wide else "<f4").tobytes()
    meshes[3].write_bytes(spoiled)
    picture = small / "cam0" / "0005.png"
    picture.write_bytes(picture.read_bytes()[:100])
    pictures.write_png(small / "cam0" / "0006.png", np.zeros((40, 64, 3), np.uint8))
    stream = tmp_path / "out.fvv"
    done = run("fvvmux", small, "-o", stream, code=1)
    assert "--skip-bad-frames leaves out frames whose files cannot be used" in done.stderr
    done = run("fvvmux", small, "-o", stream, "--skip-bad-frames", "--verify", "--json", code=3)
    summary = read_json(done, "fvvmux")
    assert summary["frames"] == 3 and summary["verified"]["meshes"] == 3 and whole["frames"] == 8
    expected = {1: "0001.ply", 2: "0002.png", 3: "0003.ply", 5: "0005.png", 6: "0006.png"}
    assert [frame["frame"] for frame in summary["left_out"]] == list(expected)
    for frame in summary["left_out"]:
        assert expected[frame["frame"]] in frame["reason"] and "--skip" not in frame["reason"]
        assert f"frame {frame['frame']} is left out: {frame['reason']}" in done.stderr
    assert done.stderr.count("\n") == 5
    # The frame before lasts: nothing says that the stage is empty.
    assert groups_of(stream) == [[0, 8, [0, 4, 7]]]
    assert figures("fvvinfo", "--check", stream)["files"][0]["times_without_frame"] == 5
    out = tmp_path / "out"
    run("fvvdemux", stream, "-o", out)
    assert sorted(path.name for path in (out / "cam0").iterdir()) == ["0000.png", "0004.png", "0007.png"]
    assert json.loads((out / "capture.json").read_text())["frames"]["left_out"] == [[1, 3], [5, 6]]
    assert mux(out, "--verify")["frames"] == 3


def test_a_vertex_beyond_the_lattice_is_found_when_that_is_chosen(tmp_path):
    frames = moving(6)
    frames[2][0][5] = (1e30, 0, 0)
    capture = write_capture(tmp_path / "beyond", frames)
    done = run("fvvmux", capture, "-o", tmp_path / "out.fvv", code=1)
    assert "0002.obj: frame 2: vertex 5: x = 1e+30 m" in done.stderr
    assert done.stderr.endswith("(--skip-bad-frames leaves out frames whose files cannot be used)\n")
    summary = mux(capture, "--skip-bad-frames", "--verify", "--max-error", "1mm", "--keep-geometry", code=3)
    assert [frame["frame"] for frame in summary["left_out"]] == [2]
    assert "0002.obj: frame 2: vertex 5" in summary["left_out"][0]["reason"]
    assert summary["frames"] == 5 and summary["mesh"]["key"]["frames"] == 1
    for (found, _), i in zip(decoded(capture), (0, 1, 3, 4, 5)):
        centre = (0.0137 * i, 0.003 * math.sin(i), 0)
        assert off_by(found, centre, 0.5 * (1 + 0.003 * i)).max() <= 0.001 * math.sqrt(3)
    for i in range(6):
        (capture / f"{i:04d}.obj").write_text("f 1 2 3\n")
    done = run("fvvmux", capture, "-o", tmp_path / "out.fvv", "--skip-bad-frames", code=1)
    assert "--skip-bad-frames leaves nothing; frame 0: " in done.stderr
    # A parser's error names the frame too.
    done = run("fvvmux", capture, "-o", tmp_path / "out.fvv", code=1)
    assert "0000.obj:1: " in done.stderr and "(frame 0; --skip-bad-frames leaves out" in done.stderr


@pytest.mark.parametrize("kind", ["stills", "masks"])
def test_pictures_that_were_turned_and_cut_are_put_in_their_place(small, tmp_path, kind):
    """64 x 48 lose 6 columns at the left and 2 at the right, get 4 rows at the bottom, and are turned by 90 degrees."""
    sources = sorted((small / "cam0").glob("[0-9]*.png"))
    before = [pictures.read_png(path) for path in sources]
    folder = small / "turned"
    folder.mkdir()
    for i, image in enumerate(before):
        cut = np.concatenate([image[:, 6:-2], np.full((4, 56, 3), 99, np.uint8)])
        # Turned back by 90 degrees clockwise it is as before.
        pictures.write_png(folder / f"{i:04d}.png", np.ascontiguousarray(np.rot90(cut)))
        if kind == "masks":
            pictures.write_png(folder / f"mask_{i:04d}.png", np.full((56, 52), 255, np.uint8))
    stored = {"pattern": "turned/%04d.png"}

    def use(camera, **more):
        camera["pictures"] = {**stored, **more}
        if kind == "masks":
            camera["masks"] = {"pattern": "turned/mask_%04d.png", **more}
        else:
            camera.pop("masks", None)

    describe(small, lambda d: use(d["cameras"][0]))
    done = run("fvvmux", small, "-o", tmp_path / "out.fvv", code=1)
    advice = 'state "rotate": 90 or 270, and "place": [x, y] with the pixel'
    assert "52 x 56" in done.stderr and advice in done.stderr
    describe(small, lambda d: use(d["cameras"][0], rotate=90))
    done = run("fvvmux", small, "-o", tmp_path / "out.fvv", code=1)
    assert "56 x 52" in done.stderr and '(cut or padded? state "place": [x, y]' in done.stderr
    describe(small, lambda d: use(d["cameras"][0], rotate=90, place=[70, 0]))
    assert (
        'beyond the camera\'s picture by "place"'
        in run("fvvmux", small, "-o", tmp_path / "out.fvv", code=1).stderr
    )
    describe(small, lambda d: use(d["cameras"][0], rotate=90, place=[6, 0]))
    options = ["--codec", "jpeg", "--quality", "100", "--crop", "none", "--tile-fill", "flat"]
    mux(small, *(options if kind == "masks" else options[:-2]), "--verify")
    out = tmp_path / "out"
    run("fvvdemux", small.with_suffix(".fvv"), "-o", out)
    for i, image in enumerate(before):
        found = pictures.read_png(out / "cam0" / f"{i:04d}.png")
        assert found.shape == image.shape
        # The luma: JPEG halves the chroma.
        weights = np.array([0.299, 0.587, 0.114])
        off = np.abs(found @ weights - image @ weights)
        assert off[:, 8:-4].mean() < 1
        if kind != "masks":
            # Nothing is known there: the edge goes on.
            assert np.abs(found[:, 1] @ weights - image[:, 6] @ weights).mean() < 4
