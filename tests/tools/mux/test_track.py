"""fvvmux --track: meshes whose faces change in every frame as motion."""

import collections
import itertools
import json

import numpy as np
import pytest
from conftest import run, small_capture
from PIL import Image

OPTIONS = ("--no-pictures", "--max-error", "8mm")


@pytest.fixture(scope="module")
def capture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("remeshed") / "capture"
    small_capture(folder, "--meshes", "remeshed", frames=4)
    return folder


def mux(capture, output, *options, **expected):
    return json.loads(run("fvvmux", capture, *OPTIONS, *options, "--json", "-o", output, **expected).stdout)


def test_tracked_frames_take_fewer_bytes_within_the_error(capture, tmp_path):
    three = ("--frames", "0-2")
    keys = mux(capture, tmp_path / "keys.fvv", *three)
    assert "tracking" not in keys["mesh"] and keys["mesh"]["delta"]["frames"] == 0
    for how, most in ("auto", 1), ("always", 0.8):
        found = mux(
            capture, tmp_path / f"{how}.fvv", "--track", how, "--verify", *three, code=(0, 3), warns=True
        )
        assert found["mesh"]["tracking"]["on"]
        assert found["bytes"] <= most * keys["bytes"]
        run("fvvcompare", capture, tmp_path / f"{how}.fvv", *three, "--max-rms", 0.0085)
    assert found["mesh"]["delta"]["frames"] >= 1


def field(frame, cells=28):
    """Two balls that come near to each other; from frame 2 on a bar connects them. Positive inside; the grid moves with each frame,
    so that no two have the same faces."""
    axes = [np.linspace(-1, 1, cells) + (0.013 * frame if axis == 0 else 0) for axis in range(3)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    near = 0.5 - 0.02 * frame
    out = 0.3 - np.minimum(np.hypot(np.hypot(x - near, y), z), np.hypot(np.hypot(x + near, y), z))
    if frame >= 2:
        bar = np.where(np.abs(x) < near, 0.15 - np.hypot(y, z), -1)
        out = np.maximum(out, bar)
    return axes, out


def write_surface(path, frame):
    """Marching tetrahedra: six to a cell, so that the surface is closed."""
    axes, value = field(frame)
    points, numbers, faces = [], {}, []

    def crossing(a, b):
        key = (min(a, b), max(a, b))
        if key not in numbers:
            t = value[a] / (value[a] - value[b])
            ends = [np.array([axes[k][p[k]] for k in range(3)]) for p in (a, b)]
            points.append(ends[0] + t * (ends[1] - ends[0]))
            numbers[key] = len(points)
        return numbers[key]

    inside = value > 0
    active = np.zeros(inside.shape, bool)
    for shift in np.ndindex(2, 2, 2):
        moved = inside[tuple(slice(s, s - 1 or None) for s in shift)]
        active[:-1, :-1, :-1] |= moved != inside[:-1, :-1, :-1]
    for cell in np.argwhere(active):
        for order in itertools.permutations(range(3)):
            corner, corners = cell.copy(), [tuple(cell)]
            for axis in order:
                corner[axis] += 1
                corners.append(tuple(corner))
            a = [c for c in corners if inside[c]]
            b = [c for c in corners if not inside[c]]
            if not a or not b:
                continue
            if len(a) == 2:
                square = [
                    crossing(a[0], b[0]),
                    crossing(a[0], b[1]),
                    crossing(a[1], b[1]),
                    crossing(a[1], b[0]),
                ]
                made = [square[:3], [square[0], *square[2:]]]
            else:
                made = [[crossing(p, q) for p in a for q in b]]
            out = np.mean([[axes[k][p[k]] for k in range(3)] for p in b], axis=0)
            for face in made:
                p, q, r = (points[v - 1] for v in face)
                outside = np.dot(np.cross(q - p, r - p), out - p) > 0
                faces.append(face if outside else face[::-1])
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in points] + [f"f {a} {b} {c}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def joining(tmp_path_factory):
    folder = tmp_path_factory.mktemp("joining")
    for frame in range(5):
        write_surface(folder / f"{frame}.obj", frame)
    description = {
        "fvv_capture": 1,
        "frame_rate": "30",
        "frames": {"first": 0, "count": 5},
        "units": "metres",
        "meshes": {"pattern": "%d.obj"},
    }
    (folder / "capture.json").write_text(json.dumps(description))
    return folder


def test_where_pieces_become_one_a_patch_is_sent(joining, tmp_path):
    made = {}
    for how in "never", "auto":
        stream = tmp_path / f"{how}.fvv"
        done = run(
            "fvvmux", joining, "--max-error", "5mm", "--track", how, "--verify", "--json", "-o", stream
        )
        made[how] = json.loads(done.stdout)
    assert made["auto"]["bytes"] < 0.9 * made["never"]["bytes"]
    assert made["auto"]["mesh"]["key"]["frames"] < 5
    assert made["auto"]["mesh"]["patched"]["frames"] >= 1
    run("fvvinfo", tmp_path / "auto.fvv")
    out = tmp_path / "out"
    run("fvvdemux", tmp_path / "auto.fvv", "-o", out, "--format", "obj")
    for frame in range(5):
        text = next(out.glob(f"meshes/*{frame}.obj")).read_text().split("\n")
        points = np.array([line.split()[1:4] for line in text if line.startswith("v ")], float)
        faces = [
            [int(v.split("/")[0]) - 1 for v in line.split()[1:]] for line in text if line.startswith("f ")
        ]
        edges = collections.Counter()
        for face in faces:
            for a, b in zip(face, face[1:] + face[:1]):
                edges[tuple(points[a]), tuple(points[b])] += 1
        assert all(edges[b, a] == n for (a, b), n in edges.items()), "the surface is closed, as its source"
    run("fvvcompare", joining, tmp_path / "auto.fvv", "--max-rms", 0.005)


def test_threads_and_parts_give_the_same_bytes(capture, tmp_path):
    groups = ("--track", "always", "--group", 2)
    for threads in 1, 2:
        mux(
            capture,
            tmp_path / f"{threads}.fvv",
            *groups,
            "--threads",
            threads,
            code=(0, 3),
            warns=True,
        )
    whole = (tmp_path / "1.fvv").read_bytes()
    assert whole == (tmp_path / "2.fvv").read_bytes()
    parts = tmp_path / "parts"
    run("fvvmux", capture, *OPTIONS, *groups, "--plan", parts, code=(0, 3), warns=True)
    run("fvvmux", "--part", 1, parts, code=(0, 3), warns=True)
    run("fvvmux", "--merge", parts, "-o", tmp_path / "merged.fvv", code=(0, 3), warns=True)
    assert whole == (tmp_path / "merged.fvv").read_bytes()


def test_meshes_with_texture_coordinates_stay_key_frames(tmp_path):
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
    (tmp_path / "0.obj").write_text(corners + "f 1/1 2/2 3/3\nf 2/2 4/4 3/3\n")
    (tmp_path / "1.obj").write_text(corners + "f 1/1 2/2 4/4\nf 1/1 4/4 3/3\n")
    options = (
        "--meshes",
        tmp_path / "%d.obj",
        "--atlas",
        tmp_path / "%d.png",
        "--max-error",
        "1mm",
        "--units",
        "metres",
    )
    for i in 0, 1:
        Image.new("RGB", (16, 16), (200, 40, 40)).save(tmp_path / f"{i}.png")
    for how, code in ("auto", 0), ("always", 3):
        done = run("fvvmux", *options, "--track", how, "--json", "-o", tmp_path / f"{how}.fvv", code=code)
        tracking = json.loads(done.stdout)["mesh"]["tracking"]
        assert not tracking["on"] and "texture coordinates" in tracking["reason"]
        assert ("--track always" in done.stderr) == (how == "always")


def test_options_that_leave_nothing_to_track_are_refused(capture, tmp_path):
    for other in ("--keep-geometry",), ("--triangles", 500), ("--no-delta",):
        result = run(
            "fvvmux", capture, "--track", "auto", *other, "-o", tmp_path / "x.fvv", code=2, warns=True
        )
        assert "--track" in result.stderr


def test_outlines_judge_hulls(tmp_path):
    """Hulls flicker by more than the budget; by their outlines they are tracked all the same."""
    folder = tmp_path / "hulls"
    size = ("--rig", "small", "--cameras", 7, "--size", "240x135", "--hull-cells", 64)
    run("fvvsynth", *size, "--frames", 5, "--meshes", "hull", "-o", folder)
    small = ("--codec", "jpeg", "--quality", 5)
    found = {}
    for how in "never", "auto":
        output = tmp_path / f"{how}.fvv"
        done = run("fvvmux", folder, *small, "--track", how, "--verify", "--json", "-o", output)
        found[how] = json.loads(done.stdout)["mesh"]
    tracking = found["auto"]["tracking"]
    assert "touch outlines" in tracking["reason"] and tracking["by_outlines"] >= 2
    assert found["auto"]["delta"]["frames"] >= 3
    assert found["auto"]["bytes"] < 0.8 * found["never"]["bytes"]
    # A budget that is a length is one of distances.
    done = run(
        "fvvmux", folder, *small, "--track", "auto", "--max-error", "3mm", "--json", "-o", tmp_path / "mm.fvv"
    )
    tracking = json.loads(done.stdout)["mesh"]["tracking"]
    assert "outlines" not in tracking["reason"] and tracking["by_outlines"] == 0
