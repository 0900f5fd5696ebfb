"""Captures that are odd, as strangers' are: no loss is silent, and bytes stay in proportion.

Each case sets an error and measures the result: fvvdemux writes the decoded meshes, whose
vertices are compared with the source's surface, a sphere, in closed form.
"""

import json
import math

import numpy as np
import pytest
from conftest import figures, run


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
