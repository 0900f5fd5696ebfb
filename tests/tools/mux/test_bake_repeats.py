"""--bake-repeats: faces on which a picture repeats are cut at its borders, and show what they showed."""

import io
import json
import pathlib

import numpy as np
import pytest
import trimesh
from conftest import glb_file, run
from PIL import Image

REPEAT, MIRROR, CLAMP = 10497, 33648, 33071
RNG = np.random.default_rng(5)


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for i, name in enumerate("ab"):
        picture(i).save(f"{name}.png")
    (tmp_path / "m.mtl").write_text("".join(f"newmtl {name}\nmap_Kd {name}.png\n" for name in "ab"))
    return tmp_path


def picture(i):
    """Slow ramps, so that a codec and the borders of pixels hardly matter, and unlike at all four borders."""
    y, x = np.mgrid[0:96, 0:64] / [[[96]], [[64]]]
    levels = [40 + 150 * x, 200 - 160 * y, np.full_like(x, 60 + 120 * i)]
    return Image.fromarray(np.stack(levels, -1).round().astype(np.uint8))


def colour(i, u, v):
    """What the picture shows at coordinates from 0 to 1, v down."""
    return np.stack([40 + 150 * u, 200 - 160 * v, np.full_like(u, 60 + 120 * i)], -1)


def wrapped(value, wrap):
    if wrap == CLAMP:
        return value.clip(0, 1)
    whole = np.floor(value)
    return np.where((wrap == MIRROR) & (whole % 2 == 1), 1 - (value - whole), value - whole)


def ball(rings=5, parts=7):
    """(points, triangles) of a closed body."""
    angles, turns = np.linspace(0, np.pi, rings + 2)[1:-1], np.arange(parts) * 2 * np.pi / parts
    points = [(np.sin(a) * np.cos(t), np.sin(a) * np.sin(t), np.cos(a)) for a in angles for t in turns]
    points += [(0, 0, 1), (0, 0, -1)]
    top, bottom = len(points) - 2, len(points) - 1
    faces = []
    for k in range(parts):
        after = (k + 1) % parts
        faces += [
            (top, k, after),
            (bottom, (rings - 1) * parts + after, (rings - 1) * parts + k),
        ]
        for i in range(rings - 1):
            a, b = i * parts + k, i * parts + after
            faces += [(a, a + parts, b), (b, a + parts, b + parts)]
    return np.array(points), np.array(faces)


def coordinates(points, faces, times):
    """u v of each corner: around the axis, with a seam, and down."""
    corners = points[faces]
    u = (np.arctan2(corners[..., 1], corners[..., 0]) / (2 * np.pi)) % 1
    u[u < u.max(1, keepdims=True) - 0.5] += 1
    return np.stack([u * times[0], (1 - corners[..., 2]) / 2 * times[1]], -1)


def obj(points, faces, uv, materials="a"):
    """materials: of the faces, in turn."""
    lines = ["mtllib m.mtl", *(f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in points)]
    lines += [f"vt {u:.9f} {1 - v:.9f}" for u, v in uv.reshape(-1, 2)]
    for i, face in enumerate(faces):
        lines.append(f"usemtl {materials[i % len(materials)]}")
        lines.append("f " + " ".join(f"{v + 1}/{3 * i + k + 1}" for k, v in enumerate(face)))
    return "\n".join(lines) + "\n"


def glb(points, faces, uv, wrap, animated=False):
    corners = points[faces].reshape(-1, 3).astype("<f4")
    png = io.BytesIO()
    picture(0).save(png, "PNG")
    parts = [corners.tobytes(), uv.reshape(-1, 2).astype("<f4").tobytes(), png.getvalue()]
    accessors = [
        {
            "bufferView": 0,
            "componentType": 5126,
            "count": len(corners),
            "type": "VEC3",
            "min": corners.min(0).tolist(),
            "max": corners.max(0).tolist(),
        },
        {"bufferView": 1, "componentType": 5126, "count": len(corners), "type": "VEC2"},
    ]
    document = {
        "asset": {"version": "2.0"},
        "images": [{"bufferView": 2, "mimeType": "image/png"}],
        "samplers": [{"wrapS": wrap[0], "wrapT": wrap[1]}],
        "textures": [{"source": 0, "sampler": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    if animated:
        parts += [np.array([0, 0.08], "<f4").tobytes(), np.array([[1, 1, 1], [2, 1, 0.5]], "<f4").tobytes()]
        accessors += [
            {"bufferView": 3, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [0.08]},
            {"bufferView": 4, "componentType": 5126, "count": 2, "type": "VEC3"},
        ]
        channel = {"sampler": 0, "target": {"node": 0, "path": "scale"}}
        document["animations"] = [{"samplers": [{"input": 2, "output": 3}], "channels": [channel]}]
    views, binary = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(part)})
        binary += part + bytes(-len(part) % 4)
    document |= {"accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(binary)}]}
    return glb_file(document, binary)


def through(name, *more):
    done = run(
        "fvvmux", "--meshes", name, "-o", "o.fvv", "--bake-repeats", "--keep-geometry", "--step", "0.00005m",
        "--units", "metres", "--texture-bits", "16", "--codec", "jpeg", "--quality", "98", "--force", *more,
    )  # fmt: skip
    assert done.stderr == ""
    run("fvvdemux", "o.fvv", "-o", "x", "--meshes", "glb", "--force")
    return meshes()


def meshes():
    for path in sorted(pathlib.Path("x/meshes").glob("*.glb")):
        (mesh,) = trimesh.load(path, process=False).geometry.values()
        yield mesh


def is_closed(mesh):
    """Each edge is that of two faces, in opposite directions, where ends are places of the lattice."""
    _, places = np.unique(mesh.vertices.round(5), axis=0, return_inverse=True)
    faces = places.ravel()[mesh.faces]
    edges = np.concatenate([faces[:, [i, (i + 1) % 3]] for i in range(3)])
    edges = edges[edges[:, 0] != edges[:, 1]]
    forth = {}
    for a, b in edges:
        forth[a, b] = forth.get((a, b), 0) + 1
        forth[b, a] = forth.get((b, a), 0) - 1
    return not any(forth.values())


def nearest(triangles, points):
    """The triangle that each point is on, and where."""
    faces, places = [], []
    for point in points:
        all_of_them = trimesh.triangles.closest_point(triangles, np.broadcast_to(point, (len(triangles), 3)))
        distances = np.linalg.norm(all_of_them - point, axis=1)
        faces.append(distances.argmin())
        places.append(all_of_them[faces[-1]])
        assert distances.min() < 4e-4
    return np.array(faces), np.array(places)


def check_colours(mesh, points, faces, uv, wrap=(REPEAT, REPEAT), pictures=(0,), count=300):
    """At random points of the source, the stream shows what the source does."""
    original = points[faces]
    areas = np.linalg.norm(np.cross(original[:, 1] - original[:, 0], original[:, 2] - original[:, 0]), axis=1)
    chosen = RNG.choice(len(faces), count, p=areas / areas.sum())
    weights = RNG.dirichlet((1, 1, 1), count)
    asked = (original[chosen] * weights[..., None]).sum(1)
    at = (uv[chosen] * weights[..., None]).sum(1)
    places = [wrapped(at[:, k], wrap[k]) for k in range(2)]
    shown = np.array([pictures[i % len(pictures)] for i in chosen])
    expected = np.where((shown == 1)[:, None], colour(1, *places), colour(0, *places))
    # Beside a border pixels and codecs mix.
    inner = np.all(
        [(place > 0.03) & (place < 0.97) | (wrap[k] == CLAMP) for k, place in enumerate(places)], 0
    )
    assert inner.mean() > 0.7
    face, near = nearest(mesh.triangles, asked)
    part = trimesh.triangles.points_to_barycentric(mesh.triangles[face], near)
    there = (mesh.visual.uv[mesh.faces[face]] * part[..., None]).sum(1)
    pixels = np.asarray(mesh.visual.material.baseColorTexture.convert("RGB"), float)
    column = (there[:, 0] * pixels.shape[1]).astype(int).clip(0, pixels.shape[1] - 1)
    row = ((1 - there[:, 1]) * pixels.shape[0]).astype(int).clip(0, pixels.shape[0] - 1)
    off = np.abs(pixels[row, column] - expected).max(1)[inner]
    assert np.quantile(off, 0.99) < 14, (np.median(off), off.max())


def check_whole(mesh, points, faces):
    assert is_closed(mesh)
    assert mesh.area == pytest.approx(trimesh.Trimesh(points, faces, process=False).area, rel=1e-4)


@pytest.mark.parametrize("times", [(1.5, 2.2), (3, 2.5), (12, 7)])
@pytest.mark.parametrize("more", [(), ("--atlas", "a.png")])
def test_an_obj_file(times, more, place):
    points, faces = ball()
    uv = coordinates(points, faces, times)
    (place / "a.obj").write_text(obj(points, faces, uv))
    (mesh,) = through("a.obj", *more)
    assert len(mesh.faces) > len(faces)
    check_whole(mesh, points, faces)
    check_colours(mesh, points, faces, uv)
    # Whole tiles: the pieces cover as many pictures as the faces did.
    sides = mesh.visual.uv[mesh.faces]
    a, b = sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0]
    before = [uv[:, k] - uv[:, 0] for k in (1, 2)]
    expected = np.abs(before[0][:, 0] * before[1][:, 1] - before[0][:, 1] * before[1][:, 0]).sum()
    assert np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() == pytest.approx(expected, rel=2e-3)


def test_pictures_of_several_materials(place):
    points, faces = ball()
    uv = coordinates(points, faces, (4, 3))
    (place / "a.obj").write_text(obj(points, faces, uv, "ab"))
    (mesh,) = through("a.obj")
    check_whole(mesh, points, faces)
    check_colours(mesh, points, faces, uv, pictures=(0, 1))


@pytest.mark.parametrize("wrap", [(REPEAT, MIRROR), (MIRROR, CLAMP), (CLAMP, REPEAT), (CLAMP, CLAMP)])
def test_wraps_of_gltf(wrap, place):
    points, faces = ball()
    uv = coordinates(points, faces, (3, 2)) - [1.3, 0.6]
    (place / "a.glb").write_bytes(glb(points, faces, uv, wrap))
    (mesh,) = through("a.glb")
    check_whole(mesh, points, faces)
    check_colours(mesh, points, faces, uv, wrap)


@pytest.mark.parametrize("options", ["-clamp on", "-clamp ON -bm 1", "-blendu on -clamp on"])
@pytest.mark.parametrize("materials", ["a", "ab"])
def test_a_library_that_clamps(options, materials, place):
    (place / "m.mtl").write_text("".join(f"newmtl {name}\nmap_Kd {options} {name}.png\n" for name in "ab"))
    points, faces = ball()
    uv = coordinates(points, faces, (3, 2)) - [1.3, 0.6]
    (place / "a.obj").write_text(obj(points, faces, uv, materials))
    (mesh,) = through("a.obj")
    check_whole(mesh, points, faces)
    check_colours(mesh, points, faces, uv, (CLAMP, CLAMP), range(len(materials)))
    done = run("fvvmux", "--meshes", "a.obj", "-o", "o.fvv", "--force", code=1)
    assert "the picture ends on the face" in done.stderr and "--bake-repeats" in done.stderr


def test_one_picture_clamped_and_repeated(place):
    (place / "m.mtl").write_text("newmtl a\nmap_Kd -clamp on a.png\nnewmtl b\nmap_Kd -clamp off a.png\n")
    points, faces = ball()
    uv = coordinates(points, faces, (1, 1)) * 0 + [[[1.2, 0.4], [1.4, 0.4], [1.4, 0.6]]]
    (place / "a.obj").write_text(obj(points, faces, uv, "ab"))
    run("fvvmux", "--meshes", "a.obj", "-o", "o.fvv", "--codec", "jpeg", "--quality", "95")
    run("fvvdemux", "o.fvv", "-o", "x", "--meshes", "glb")
    (mesh,) = trimesh.load("x/meshes/0000.glb", process=False).geometry.values()
    pixels = np.asarray(mesh.visual.material.baseColorTexture.convert("RGB"), float)
    at = (mesh.visual.uv[mesh.faces].mean(1) * [1, -1] + [0, 1]) * pixels.shape[1::-1]
    reds = [pixels[int(row), min(int(column), pixels.shape[1] - 1), 0] for column, row in at]
    expected = [colour(0, np.array(u), np.array(0.5))[0] for u in (1, 1 / 3)]
    near = [np.abs(np.array(reds) - red) < 8 for red in expected]
    assert near[0].sum() == near[1].sum() == len(faces) / 2


def test_an_animation_is_cut_alike_in_all_frames(place):
    points, faces = ball()
    uv = coordinates(points, faces, (3, 2))
    (place / "a.glb").write_bytes(glb(points, faces, uv, (REPEAT, REPEAT), animated=True))
    (place / "still.glb").write_bytes(glb(points, faces, uv, (REPEAT, REPEAT)))
    (still,) = through("still.glb")
    first, second, third = through("a.glb", "--fps", "25")
    assert np.array_equal(first.faces, second.faces) and np.array_equal(first.faces, third.faces)
    assert len(first.faces) == len(still.faces) > len(faces)
    check_whole(third, points * [2, 1, 0.5], faces)
    check_colours(second, points * [1.5, 1, 0.75], faces, uv)


def test_the_error_names_the_option(place):
    points, faces = ball()
    (place / "a.obj").write_text(obj(points, faces, coordinates(points, faces, (3, 2))))
    done = run("fvvmux", "--meshes", "a.obj", "-o", "o.fvv", code=1)
    assert "repeats" in done.stderr and "--bake-repeats" in done.stderr


def test_too_many_pieces_are_an_error(place):
    points, faces = ball()
    (place / "a.obj").write_text(obj(points, faces, coordinates(points, faces, (9000, 9000))))
    done = run("fvvmux", "--meshes", "a.obj", "-o", "o.fvv", "--bake-repeats", code=1)
    assert "a.obj: face " in done.stderr and "pieces" in done.stderr and "--atlas none" in done.stderr


def test_the_capture_says_so_too(place):
    points, faces = ball()
    (place / "a.obj").write_text(obj(points, faces, coordinates(points, faces, (3, 2))))
    command = ("fvvmux", "--meshes", "a.obj", "--units", "metres", "--bake-repeats")
    run(*command, "--write-capture", "capture.json")
    assert json.loads((place / "capture.json").read_text())["atlas"] == {
        "embedded": True,
        "bake_repeats": True,
    }
    run(*command, "-o", "a.fvv")
    run("fvvmux", "capture.json", "-o", "b.fvv", "--verify")
    assert (place / "a.fvv").read_bytes() == (place / "b.fvv").read_bytes()


@pytest.mark.parametrize(
    "arguments",
    [
        ("--meshes", "a.obj", "--atlas", "none", "--bake-repeats"),
        ("capture.json", "--bake-repeats"),
    ],
)
def test_wrong_uses(arguments, place):
    (place / "capture.json").write_text("{}")
    done = run("fvvmux", *arguments, "-o", "o.fvv", code=2)
    assert "--bake-repeats" in done.stderr
