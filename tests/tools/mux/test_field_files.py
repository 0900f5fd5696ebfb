"""Mesh files as programs in the field write them: all mean what an independent reader makes of them."""

import json
import struct

import numpy as np
import pytest
import trimesh
from conftest import run
from PIL import Image

QUICK = ("--keep-geometry", "--max-error", "0.1mm", "--units", "metres")

POSITIONS = [(x, y, z) for z in (0.3, 0.6) for y in (0.2, 0.9) for x in (0.1, 1.1)]
QUADS = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]


def box(head="", vertex="v {} {} {}", corner="{}/{}", between="\n", faces=QUADS):
    """An OBJ file: a box with texture coordinates of its own for each corner."""
    lines = [*head.splitlines(), *(vertex.format(*p) for p in POSITIONS)]
    lines += [f"vt {0.1 + 0.03 * (i // 4)} {0.1 + 0.2 * (i % 4)}" for i in range(24)]
    lines += [
        "f " + " ".join(corner.format(v, 4 * q + k + 1) for k, v in enumerate(quad))
        for q, quad in enumerate(faces)
    ]
    return between.join(lines) + between


LIBRARY = "newmtl m\nmap_Kd t.png\n"


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pixels = np.random.default_rng(1).integers(0, 255, (16, 16, 3), np.uint8)
    Image.fromarray(pixels).resize((256, 256)).save("t.png")
    (tmp_path / "m.mtl").write_text(LIBRARY)
    return tmp_path


def mux(meshes, *more, code=0):
    return run("fvvmux", "--meshes", meshes, "-o", "o.fvv", *QUICK, *more, "--force", code=code, warns=True)


def mesh_of(frame=0, folder="x"):
    run("fvvdemux", "o.fvv", "-o", folder, "--meshes", "ply", "--force", warns=True, code=(0, 3))
    return trimesh.load(f"{folder}/meshes/{frame:04}.ply", process=False)


def summary(done):
    return json.loads(done.stdout)


def test_the_usual_file(place):
    (place / "a.obj").write_text(box("mtllib m.mtl\nusemtl m"))
    assert mux("a.obj").stderr == ""
    assert "atlas" in run("fvvinfo", "o.fvv").stdout
    assert mesh_of().area == pytest.approx(2 * (0.7 + 0.3 + 0.21), rel=1e-3)


SPELLINGS = {
    "byte order mark": "\ufeff" + box("mtllib m.mtl\nusemtl m"),
    "quotes": box('mtllib "my scan.mtl"\nusemtl m'),
    "backslash": box("mtllib sub\\m.mtl\nusemtl m"),
    "blanks": box("mtllib my scan.mtl\nusemtl m"),
    "absolute": box("mtllib C:\\Users\\me\\scan\\m.mtl\nusemtl m"),
    "absolute path": box("mtllib /home/me/scan/m.mtl\nusemtl m"),
    "capitals": box("mtllib M.MTL\nusemtl m"),
    "one of two libraries": box("mtllib gone.mtl m.mtl\nusemtl m"),
    "carriage returns": box("mtllib m.mtl\nusemtl m", between="\r"),
    "both line ends": box("mtllib m.mtl\nusemtl m", between="\r\n"),
    "colours that are no numbers": box("mtllib m.mtl\nusemtl m", vertex="v {} {} {} nan NaN -nan(ind)"),
    "trailing slash": box("mtllib m.mtl\nusemtl m", corner="{}/{}/"),
    "no material": box("mtllib m.mtl"),
    "empty material": box("mtllib m.mtl\nusemtl "),
    "unknown material": box("mtllib m.mtl\nusemtl other"),
    "tabs and continued lines": box("mtllib m.mtl\nusemtl m").replace(" ", "\t").replace("f\t1", "f\\\n\t1"),
    "one texture coordinate": box("mtllib m.mtl\nusemtl m") + "vt 0.5\n",
    "unused texture coordinates": box("mtllib m.mtl\nusemtl m") + "vt nan -nan(ind)\n",
    "old keyword of faces": box("mtllib m.mtl\nusemtl m").replace("f 1", "fo 1"),
    "library with CR": box("mtllib cr.mtl\nusemtl m"),
    "library with a byte order mark": box("mtllib bom.mtl\nusemtl m"),
    "library of a folder that is gone": box("mtllib scans/today/m.mtl\nusemtl m"),
    "picture of a folder that is gone": box("mtllib gone.mtl\nusemtl m"),
    "single quotes": box("mtllib quotes.mtl\nusemtl m"),
    "a map without a name": box("mtllib empty.mtl\nusemtl m"),
    "two maps, of which the last counts": box("mtllib two.mtl\nusemtl m"),
    "ambient": box("mtllib ka.mtl\nusemtl m"),
    "emitted": box("mtllib ke.mtl\nusemtl m"),
}


@pytest.mark.parametrize("name", SPELLINGS)
def test_spellings_bring_their_picture(name, place):
    (place / "sub").mkdir()
    (place / "sub/m.mtl").write_text("newmtl m\nmap_Kd ../t.png\n")
    (place / "my scan.mtl").write_text('newmtl m\nmap_Kd "t.png"\n')
    (place / "ka.mtl").write_text("newmtl m\nmap_Ka t.png\n")
    (place / "ke.mtl").write_text("newmtl m\nmap_Ke t.png\n")
    (place / "cr.mtl").write_bytes(LIBRARY.replace("\n", "\r").encode())
    (place / "bom.mtl").write_bytes(("\ufeff" + LIBRARY).encode())
    (place / "gone.mtl").write_text("newmtl m\nmap_Kd ../../textures/t.png\n")
    (place / "quotes.mtl").write_text("newmtl m\nmap_Kd 't.png'\n")
    (place / "empty.mtl").write_text("newmtl m\nmap_Ka t.png\nmap_Kd\n")
    (place / "two.mtl").write_text("newmtl m\nmap_Kd missing.png\nmap_Kd t.png\n")
    (place / "a.obj").write_bytes(SPELLINGS[name].encode())
    assert mux("a.obj").stderr == ""
    assert "atlas" in run("fvvinfo", "o.fvv").stdout
    assert mesh_of().area == pytest.approx(2 * (0.7 + 0.3 + 0.21), rel=1e-3)


@pytest.mark.parametrize("face", ["f 1 2", "f 3", "f 1/1 2/1"])
def test_faces_that_are_lines_or_points_are_counted(face, place):
    (place / "a.obj").write_text(box() + face + "\n")
    done = mux("a.obj", "--json")
    assert summary(done)["mesh"]["lines_and_points"]["count"] == 1
    assert mesh_of().area == pytest.approx(2 * (0.7 + 0.3 + 0.21), rel=1e-3)


@pytest.mark.parametrize("corners", ["1 3 4 2", "1 3/2 4/3 2/4", "1/0 3/0 4/0 2/0", "1/25 3/25 4/25 2/25"])
def test_a_face_without_texture_coordinates_has_the_colour_of_its_material(corners, place):
    """That is a warning. A pair that is no number is none."""
    (place / "m.mtl").write_text("newmtl m\nKd 1 0 0\nmap_Kd t.png\n")
    text = box("mtllib m.mtl\nusemtl m").replace("1/1 3/2 4/3 2/4", corners) + "vt nan nan\n"
    (place / "a.obj").write_text(text)
    done = mux("a.obj", "--quality", 30, "--json", code=3)
    assert "the material's colour alone" in done.stderr
    assert summary(done)["mesh"]["untextured_faces"]["count"] == 2
    run("fvvdemux", "o.fvv", "-o", "x", "--meshes", "obj", "--pictures", "png", "--force")
    mesh = trimesh.load("x/meshes/0000.obj", process=False)
    atlas = np.asarray(Image.open("x/atlas/0000.png").convert("RGB"))
    at = mesh.visual.uv[mesh.faces[np.abs(mesh.triangles_center[:, 2] - 0.3) < 0.01]].mean((0, 1))
    shown = atlas[int((1 - at[1]) * atlas.shape[0]), int(at[0] * atlas.shape[1])]
    assert np.abs(shown.astype(int) - (255, 0, 0)).max() < 30


def test_a_page_of_a_server_is_no_empty_stage(place):
    for frame in (0, 2):
        (place / f"m{frame}.obj").write_text(box(corner="{0}"))
    (place / "m1.obj").write_text("<html>404</html>\n")
    assert (
        'm1.obj:1: expected an OBJ keyword such as v or f, found "<html>404</html>"'
        in mux("m%d.obj", code=1).stderr
    )


@pytest.mark.parametrize("corner", ["{0}/", "{0}//", "{0}"])
def test_corners_without_texture(corner, place):
    (place / "a.obj").write_text(box(corner=corner))
    assert mux("a.obj").stderr == ""
    assert mesh_of().area == pytest.approx(2 * (0.7 + 0.3 + 0.21), rel=1e-3)


@pytest.mark.parametrize("codec", ["h264", "jpeg", "vp9"])
def test_a_quality_that_cannot_be_reached_is_a_warning(codec, place):
    """Chroma at half the resolution: no quality brings 42 dB of a noise of colours."""
    noise = np.random.default_rng(2).integers(0, 2, (128, 128, 3), np.uint8) * 255
    Image.fromarray(noise).save("t.png")
    (place / "a.obj").write_text(box("mtllib m.mtl\nusemtl m"))
    done = mux("a.obj", "--codec", codec, "--json", code=3)
    atlas = summary(done)["atlas"]
    assert atlas["sample_psnr"] < 42
    assert "--quality: the atlas: 42 dB were to be reached" in done.stderr
    assert f" {atlas['quality']}\n" in done.stderr
    mux("a.obj", "--codec", codec, "--quality", f"{atlas['sample_psnr'] - 0.5:.1f}dB")


def test_a_library_that_is_missing_is_a_warning(place):
    (place / "a.obj").write_text(box("mtllib gone.mtl\nusemtl m"))
    done = mux("a.obj", code=3)
    assert "gone.mtl" in done.stderr and "missing" in done.stderr and "atlas" in done.stderr
    assert mesh_of().area == pytest.approx(2 * (0.7 + 0.3 + 0.21), rel=1e-3)


def test_the_first_frame_does_not_decide_for_all(place):
    """A picture that later frames bring is not dropped in silence."""
    (place / "m0000.obj").write_text(box(corner="{0}"))
    for frame in (1, 2):
        (place / f"m{frame:04}.obj").write_text(box("mtllib m.mtl\nusemtl m"))
    done = mux("m%04d.obj", code=1)
    assert "m0000.obj" in done.stderr


def test_an_empty_stage_between_textured_frames(place):
    for frame in (0, 2):
        (place / f"m{frame:04}.obj").write_text(box("mtllib m.mtl\nusemtl m"))
    (place / "m0001.obj").write_text("# nothing\n")
    mux("m%04d.obj", "--quality", 30)
    assert "atlas" in run("fvvinfo", "o.fvv").stdout


# Polygons with an area of 3, whose fan around the first corner is larger.
CONCAVE = {
    "dart": [(0, 0, 0), (3, 1, 0), (0, 2, 0), (1, 1, 0)][::-1],
    "L": [(1, 1, 0), (0, 1, 0), (0, 0, 0), (2, 0, 0), (2, 2, 0), (1, 2, 0)],
    "comb": [(0, 0, 0), (5, 0, 0), (5, 1, 0), (4, 1, 0), (4, 0.5, 0), (1, 0.5, 0), (1, 1, 0), (0, 1, 0)],
}
# The same, of polygons that touch themselves: at a corner, along an edge, with a hole cut open.
TOUCHING = {
    "waist": [(0, 0, 0), (2, 1, 0), (4, 0, 0), (4, 2, 0), (2, 1, 0), (0, 2, 0)],
    "corner on an edge": [(0, 0, 0), (4, 0, 0), (4, 2, 0), (2, 0, 0), (0, 2, 0)],
    "spike": [(0, 0, 0), (2, 0, 0), (2, 1, 0), (2, 2, 0), (2, 1, 0), (0, 1, 0)],
    "spike inside": [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 0.5, 0), (1, 1, 0), (0, 1, 0)],
    "hole": [(0, 0, 0), (1, 1, 0), (1, 2, 0), (2, 2, 0), (2, 1, 0), (1, 1, 0)]
    + [(0, 0, 0), (3, 0, 0), (3, 3, 0), (0, 3, 0)],
}
CROSSING = {
    "bow": [(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1, 0)],
    "uneven bow": [(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 0.6, 0)],
    "star": [(np.cos(0.8 * np.pi * k), np.sin(0.8 * np.pi * k), 0) for k in range(5)],
}


def rolled(points, count):
    return points[count:] + points[:count]


def area_of(points):
    p = np.array(points, float)
    return np.linalg.norm(np.sum([np.cross(p[i], p[(i + 1) % len(p)]) for i in range(len(p))], axis=0)) / 2


def turned(points):
    """In a plane of its own."""
    a, b = 0.7, 1.1
    rotation = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]]) @ np.array(
        [[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]]
    )
    return (np.array(points) @ rotation.T + 1).tolist()


def write_polygon(path, points):
    if path.suffix == ".obj":
        lines = [f"v {x} {y} {z}" for x, y, z in points] + [
            "f " + " ".join(map(str, range(1, len(points) + 1)))
        ]
    else:
        lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
        lines += [f"property double {axis}" for axis in "xyz"]
        lines += ["element face 1", "property list uchar int vertex_indices", "end_header"]
        lines += [f"{x} {y} {z}" for x, y, z in points]
        lines += [f"{len(points)} " + " ".join(map(str, range(len(points))))]
    path.write_text("\n".join(lines) + "\n")


def check_polygon(path, points):
    write_polygon(path, points)
    assert mux(path.name, "--winding", "keep").stderr == ""
    mesh = mesh_of()
    assert mesh.area == pytest.approx(area_of(points), rel=1e-3)
    normal = np.sum([np.cross(points[i], points[(i + 1) % len(points)]) for i in range(len(points))], axis=0)
    # Rounding to the lattice gives corners in a straight line a little area.
    assert np.all(mesh.face_normals[mesh.area_faces > 1e-3] @ normal > 0)


@pytest.mark.parametrize("suffix", [".obj", ".ply"])
@pytest.mark.parametrize("start", range(4))
@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("name", CONCAVE)
def test_concave_polygons_keep_their_area_and_side(name, reverse, start, suffix, place):
    points = turned(rolled(CONCAVE[name], start))
    check_polygon(place / f"a{suffix}", points[::-1] if reverse else points)


@pytest.mark.parametrize("start", [0, 3])
@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("name", TOUCHING)
def test_polygons_that_touch_themselves(name, reverse, start, place):
    points = turned(rolled(TOUCHING[name], start))
    check_polygon(place / "a.obj", points[::-1] if reverse else points)


@pytest.mark.parametrize("turn", [lambda points: points, turned])
@pytest.mark.parametrize("name", CROSSING)
def test_polygons_that_cross_themselves_are_a_warning(name, turn, place):
    write_polygon(place / "a.ply", turn(CROSSING[name]))
    done = mux("a.ply", "--json", code=3)
    assert "polygons that cross themselves: 1 in 1 frames" in done.stderr
    assert summary(done)["mesh"]["self_crossing_polygons"] == {"count": 1, "frames": 1}


def test_concave_polygons_keep_their_texture(place):
    """The corners of an L, each with the texture coordinates of its place."""
    points = CONCAVE["L"]
    lines = ["mtllib m.mtl", "usemtl m", *(f"v {x} {y} {z}" for x, y, z in points)]
    lines += [f"vt {x / 2} {y / 2}" for x, y, _ in points]
    (place / "a.obj").write_text("\n".join([*lines, "f " + " ".join(f"{i}/{i}" for i in range(1, 7))]) + "\n")
    mux("a.obj", "--quality", 30)
    run("fvvdemux", "o.fvv", "-o", "x", "--meshes", "obj", "--force")
    mesh = trimesh.load("x/meshes/0000.obj", process=False)
    assert mesh.area == pytest.approx(3, rel=1e-3)
    assert np.allclose(mesh.visual.uv * 2, mesh.vertices[:, :2], atol=2e-3)


PLY_HEAD = "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
TRIANGLE = "0 0 0\n1 0 0\n0 1 0\n"
FACE = "element face {}\nproperty list uchar int vertex_indices\nend_header\n"
STRIPS = "element tristrips {}\nproperty list int int vertex_indices\nend_header\n"
PLY = {
    "carriage returns": (
        (PLY_HEAD.format(3) + FACE.format(1) + TRIANGLE + "3 0 1 2\n").replace("\n", "\r"),
        0.5,
    ),
    "a face of two corners": (PLY_HEAD.format(3) + FACE.format(2) + TRIANGLE + "3 0 1 2\n2 0 1\n", 0.5),
    "capitals in the first line": (
        ("PLY" + PLY_HEAD[3:]).format(3) + FACE.format(1) + TRIANGLE + "3 0 1 2\n",
        0.5,
    ),
    "a face of one corner": (PLY_HEAD.format(3) + FACE.format(2) + TRIANGLE + "1 0\n3 0 1 2\n", 0.5),
    "unused vertices": (
        PLY_HEAD.format(5) + FACE.format(1) + TRIANGLE + "nan nan nan\n-inf 0 NaN\n3 0 1 2\n",
        0.5,
    ),
    "remarks before the format": (
        "ply\ncomment a\nobj_info b\n\n" + PLY_HEAD[4:].format(3) + FACE.format(1) + TRIANGLE + "3 0 1 2\n",
        0.5,
    ),
    "empty lines": (PLY_HEAD.format(3) + FACE.format(1) + "\n" + TRIANGLE + "\n \n3 0 1 2\n", 0.5),
    "a byte order mark": ("\ufeff" + PLY_HEAD.format(3) + FACE.format(1) + TRIANGLE + "3 0 1 2\n", 0.5),
    "a blank after the first word": (
        "ply \n" + PLY_HEAD[4:].format(3) + FACE.format(1) + TRIANGLE + "3 0 1 2\n",
        0.5,
    ),
    "a face of no corners": (PLY_HEAD.format(3) + FACE.format(2) + TRIANGLE + "0\n3 0 1 2\n", 0.5),
    "a strip": (PLY_HEAD.format(4) + STRIPS.format(1) + TRIANGLE + "1 1 0\n4 0 1 2 3\n", 1),
    "elements of several lines": (
        PLY_HEAD.format(3) + FACE.format(1) + "0 0\n0\n1\n0 0\n0 1 0\n3\n0 1 2\n",
        0.5,
    ),
    "strips": (PLY_HEAD.format(4) + STRIPS.format(1) + TRIANGLE + "1 1 0\n7 0 1 2 -1 1 3 2\n", 1),
}


@pytest.mark.parametrize("name", PLY)
def test_ply_files(name, place):
    text, area = PLY[name]
    (place / "a.ply").write_bytes(text.encode())
    mux("a.ply")
    mesh = mesh_of()
    assert mesh.area == pytest.approx(area, rel=1e-3)
    assert np.all(mesh.face_normals[:, 2] > 0), "one side"


def test_binary_ply_of_a_depth_camera(place):
    head = PLY_HEAD.format(4).replace("ascii", "binary_little_endian") + FACE.format(1)
    vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (np.nan,) * 3]
    body = b"".join(struct.pack("<3f", *v) for v in vertices) + struct.pack("<B3i", 3, 0, 1, 2) + b"\r\n"
    (place / "a.ply").write_bytes(head.encode() + body)
    mux("a.ply")
    assert mesh_of().area == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize(
    "remark",
    [
        "comment TextureFile C:\\scan\\t.png",
        'comment TEXTUREFILE "t.png"',
        "comment\ttexturefile\tT.PNG",
        "comment  TextureFile:  gone/t.png",
        "obj_info TextureFile t.png",
    ],
)
def test_pictures_of_ply_files(remark, place):
    text = PLY_HEAD.format(3) + "property float S\nproperty float T\n" + FACE.format(1)
    text += "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n"
    (place / "a.ply").write_text(text.replace("element vertex", remark + "\nelement vertex"))
    assert mux("a.ply", "--quality", 30).stderr == ""
    assert "atlas" in run("fvvinfo", "o.fvv").stdout


WEDGES = (
    "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\n"
)
#: Texture coordinates of a face whose colour is that of the upper left corner of its picture.
THERE = "6 0.1 0.9 0.2 0.9 0.1 0.8"
FIRST, SECOND, NEUTRAL = (220, 30, 40), (30, 40, 220), (128, 128, 128)
#: Properties of a face; both faces; what they show; whether that is a warning.
NUMBERED = {
    "both": (WEDGES, f"3 0 1 2 {THERE} 1", f"3 1 3 2 {THERE} 0", (SECOND, FIRST), False),
    "number before corners": (
        "property int texnumber\n" + WEDGES[: WEDGES.index("property int")],
        f"1 3 0 1 2 {THERE}",
        f"0 3 1 3 2 {THERE}",
        (SECOND, FIRST),
        False,
    ),
    "one without": (WEDGES, f"3 0 1 2 {THERE} 0", f"3 1 3 2 {THERE} -1", (FIRST, NEUTRAL), False),
    "the first without": (WEDGES, "3 0 1 2 0 -1", f"3 1 3 2 {THERE} 1", (NEUTRAL, SECOND), False),
    "no coordinates": (WEDGES, f"3 0 1 2 {THERE} 0", "3 1 3 2 0 0", (FIRST, NEUTRAL), True),
    "no numbers": (
        WEDGES,
        f"3 0 1 2 {THERE} 0",
        "3 1 3 2 6 nan nan nan nan nan nan 0",
        (FIRST, NEUTRAL),
        True,
    ),
}


def numbered(properties, faces, pictures=("first.png", "second.png")):
    head = PLY_HEAD.format(4).replace(
        "element", "".join(f"comment TextureFile {name}\n" for name in pictures) + "element"
    )
    faces = "\n".join(faces) + "\n"
    return f"{head}element face 2\n{properties}end_header\n{TRIANGLE}1 1 0\n{faces}"


def shown_colours():
    """Of the faces, from left to right."""
    run("fvvdemux", "o.fvv", "-o", "x", "--meshes", "obj", "--pictures", "png", "--force")
    mesh = trimesh.load("x/meshes/0000.obj", process=False)
    atlas = np.asarray(Image.open("x/atlas/0000.png").convert("RGB")).astype(int)
    places = mesh.visual.uv[mesh.faces].mean(1)[np.argsort(mesh.triangles_center[:, 0])]
    return [atlas[int((1 - v) * atlas.shape[0]), int(u * atlas.shape[1])] for u, v in places]


@pytest.mark.parametrize("name", NUMBERED)
def test_numbered_pictures_of_ply_files(name, place):
    for file, colour in ("first.png", FIRST), ("second.png", SECOND):
        Image.new("RGB", (64, 64), colour).save(file)
    properties, *faces, expected, warned = NUMBERED[name]
    (place / "a.ply").write_text(numbered(properties, faces))
    done = mux("a.ply", "--quality", 40, "--winding", "keep", code=3 if warned else 0)
    assert ("triangles without texture coordinates" in done.stderr) == warned
    assert np.abs(np.array(shown_colours()) - expected).max() < 20


@pytest.mark.parametrize("more", [(), ("--atlas", "first.png")])
def test_faces_that_all_have_no_number_show_the_only_picture(more, place):
    Image.new("RGB", (64, 64), FIRST).save("first.png")
    faces = f"3 0 1 2 {THERE} -1", f"3 1 3 2 {THERE} -1"
    (place / "a.ply").write_text(numbered(WEDGES, faces, ("first.png",)))
    assert mux("a.ply", "--quality", 40, *more).stderr == ""
    assert np.abs(np.array(shown_colours()) - FIRST).max() < 20


@pytest.mark.parametrize("file", ["cut.png", "inks.jpg"])
def test_a_picture_that_cannot_be_decoded_is_named(file, place):
    (place / "cut.png").write_bytes((place / "t.png").read_bytes()[:99])
    Image.open("t.png").convert("CMYK").save("inks.jpg")
    (place / "m.mtl").write_text(f"newmtl m\nmap_Kd {file}\n")
    (place / "a.obj").write_text(box("mtllib m.mtl\nusemtl m"))
    assert mux("a.obj", code=1).stderr.startswith(f"fvvmux: {file}: ")


def test_a_picture_without_texture_coordinates_is_a_warning(place):
    text = PLY_HEAD.format(3) + FACE.format(1) + TRIANGLE + "3 0 1 2\n"
    (place / "a.ply").write_text(text.replace("element vertex", "comment TextureFile t.png\nelement vertex"))
    assert 'it names "t.png" (TextureFile) and has no texture coordinates' in mux("a.ply", code=3).stderr


def test_a_vertex_of_a_face_must_be_a_number(place):
    (place / "a.ply").write_text(PLY_HEAD.format(3) + FACE.format(1) + "0 0 0\n1 0 0\nnan 1 0\n3 0 1 2\n")
    done = mux("a.ply", code=1)
    assert "vertex 2" in done.stderr and "not finite" in done.stderr


def test_touching_bodies_stay_as_they_are(place):
    """Two open boxes that share an edge, each with all faces outward."""
    lines, faces = [], []
    for x in (0, 1):
        base = len(lines)
        lines += [f"v {x + i % 2} {i // 2 % 2} {x + i // 4}" for i in range(8)]
        quads = [(1, 3, 4, 2), (5, 6, 8, 7), (1, 2, 6, 5), (3, 7, 8, 4), (1, 5, 7, 3), (2, 4, 8, 6)]
        quads.remove((5, 6, 8, 7) if x == 0 else (1, 3, 4, 2))
        faces += ["f " + " ".join(str(base + v) for v in quad) for quad in quads]
    (place / "a.obj").write_text("\n".join(lines + faces) + "\n")
    for winding in ("keep", "auto"):
        done = mux("a.obj", "--winding", winding, "--json", code=(0, 3))
        assert summary(done)["mesh"]["flipped_faces"]["count"] == 0, winding


def test_keep_keeps_a_face_that_is_turned_round(place):
    """Without the option it is turned as its neighbours are."""
    (place / "a.obj").write_text(box("mtllib m.mtl\nusemtl m", faces=[QUADS[0][::-1], *QUADS[1:]]))
    assert summary(mux("a.obj", "--json", code=(0, 3)))["mesh"]["flipped_faces"]["count"] == 2
    kept = mux("a.obj", "--winding", "keep", "--json", code=(0, 3))
    assert summary(kept)["mesh"]["flipped_faces"]["count"] == 0


def test_both_sides_of_a_sheet(place):
    """Faces of opposite winding, each with its own part of the texture."""
    text = "mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    text += "vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nvt 0.5 0\nvt 1 0\nvt 1 1\nvt 0.5 1\n"
    text += "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 1/5 3/7 2/6\nf 1/5 4/8 3/7\n"
    (place / "a.obj").write_text(text)
    mux("a.obj", "--quality", 30, code=(0, 3))
    assert len(mesh_of().faces) == 4


@pytest.mark.parametrize("pattern", ["m%04d.obj", "m####.obj", "m@@@@.obj", "m$F4.obj", "m*.obj"])
def test_sequences_with_steps_and_other_spellings(pattern, place):
    for frame in (0, 2, 4):
        (place / f"m{frame:04}.obj").write_text(box(corner="{0}"))
    mux(pattern)
    assert json.loads(run("fvvinfo", "--json", "o.fvv").stdout)["files"][0]["frames"] == 3


def test_a_list_of_files_is_their_sequence(place):
    """As a shell makes it of a pattern without quotes."""
    for frame in (8, 9, 10):
        (place / f"m{frame}.obj").write_text(box(corner="{0}"))
    files = "m10.obj", "m8.obj", "m9.obj"
    run("fvvmux", "--meshes", *files, "-o", "o.fvv", *QUICK)
    assert json.loads(run("fvvinfo", "--json", "o.fvv").stdout)["files"][0]["frames"] == 3
    run("fvvmux", "--meshes", *files[:2], "--write-capture", "c.json", code=2)
    (place / "m10.obj").unlink()
    run("fvvmux", "--meshes", *files[1:], "--write-capture", "c.json")
    assert json.loads((place / "c.json").read_text())["meshes"] == {"pattern": "m%d.obj"}
    assert "not expected" in run("fvvmux", "o.fvv", "m8.obj", "m9.obj", "-o", "p.fvv", code=2).stderr


@pytest.mark.parametrize(
    "files", [("a", "b"), ("a", "a1", "a2"), ("a1", "a2", "b1", "b2"), ("a1_x", "a2_y"), ("a08", "a9")]
)
def test_a_star_for_more_than_a_number_is_an_error(files, place):
    """One sequence of several, or one file, would be taken for all."""
    for name in files:
        (place / f"{name}.obj").write_text(box(corner="{0}"))
    done = mux("*.obj", code=2)
    assert "expected files that differ in one number alone" in done.stderr


EMPTY = {
    "a.glb": lambda: glb([]),
    "nodes without meshes.glb": lambda: glb([{"name": "camera"}]),
    "a.gltf": lambda: b'{"asset": {"version": "2.0"}}',
    "scene.gltf": lambda: b'{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{}]}',
    "a.ply": lambda: (PLY_HEAD.format(0) + FACE.format(0)).encode(),
    "vertices alone.ply": lambda: (PLY_HEAD.format(0) + "end_header\n").encode(),
    "binary.ply": lambda: (PLY_HEAD.format(0) + FACE.format(0))
    .replace("ascii", "binary_big_endian")
    .encode(),
    "remarks.obj": lambda: b"# ours\nmtllib gone.mtl\no body\n",
}


@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("name", EMPTY)
def test_empty_stages(name, first, place):
    suffix = name.rpartition(".")[2]
    whole = {
        "obj": lambda: box(corner="{0}").encode(),
        "ply": lambda: (PLY_HEAD.format(3) + FACE.format(1) + TRIANGLE + "3 0 1 2\n").encode(),
    }.get(suffix, lambda: glb([{"mesh": 0}]))
    for frame in range(3):
        content = EMPTY[name] if frame == (0 if first else 1) else whole
        (place / f"m{frame}.{suffix}").write_bytes(content())
    assert mux(f"m%d.{suffix}").stderr == ""
    run("fvvdemux", "o.fvv", "-o", "x", "--meshes", "ply")
    assert len(list((place / "x/meshes").iterdir())) == 2


def glb(nodes, buffers=b"", **more):
    """A GLB file of one unit triangle."""
    data = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], "<f4").tobytes() + buffers
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 3,
                "type": "VEC3",
                "min": [0, 0, 0],
                "max": [1, 1, 0],
            }
        ],
    }
    for key, value in more.items():
        document[key] = document.get(key, []) + value
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    )
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def test_hidden_nodes_are_not_shown(place):
    hidden = {"extensions": {"KHR_node_visibility": {"visible": False}}}
    nodes = [
        {"mesh": 0},
        {"mesh": 0, "translation": [3, 0, 0], **hidden},
        {"children": [3], **hidden},
        {"mesh": 0},
    ]
    data = bytearray(glb(nodes, extensionsUsed=["KHR_node_visibility"]))
    data = bytes(data).replace(b'"nodes": [0, 1, 2, 3]', b'"nodes": [0, 1, 2]   ')
    (place / "a.glb").write_bytes(data)
    assert mux("a.glb").stderr == ""
    assert len(mesh_of().faces) == 1


def test_instances_are_shown(place):
    places = np.array([(0, 0, 0), (2, 0, 0), (4, 0, 0)], "<f4").tobytes()
    instancing = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}
    data = glb(
        [{"mesh": 0, "translation": [0, 1, 0], "extensions": instancing}],
        places,
        bufferViews=[{"buffer": 0, "byteOffset": 36, "byteLength": 36}],
        accessors=[{"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3"}],
        extensionsUsed=["EXT_mesh_gpu_instancing"],
    )
    (place / "a.glb").write_bytes(data)
    assert mux("a.glb").stderr == ""
    mesh = mesh_of()
    assert len(mesh.faces) == 3 and mesh.bounds[1][0] == pytest.approx(5, abs=1e-3)
    assert mesh.bounds[0][1] == pytest.approx(1, abs=1e-3)


def test_unknown_extensions_are_a_warning(place):
    (place / "a.glb").write_bytes(
        glb([{"mesh": 0}], extensionsUsed=["EXT_bend_everything", "KHR_materials_clearcoat"])
    )
    done = mux("a.glb", code=3)
    assert "EXT_bend_everything" in done.stderr and "clearcoat" not in done.stderr
