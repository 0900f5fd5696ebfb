"""Several pictures of one mesh become one atlas; texture coordinates of all kinds keep what they show."""

import io

import numpy as np
import pytest
import trimesh
from conftest import glb_file, run
from PIL import Image

# Four squares of 1 in a row, from x = 0: what each shows at its left and its right half.
RED, GREEN, BLUE, YELLOW = (210, 40, 40), (40, 170, 60), (40, 60, 200), (220, 200, 40)
GREY = (128, 128, 128)
HALVES = {"a.png": (RED, GREEN), "b.png": (BLUE, YELLOW)}
SHOWN = [*HALVES["a.png"], *HALVES["b.png"]]


def picture(left, right, size=(64, 48)):
    pixels = np.zeros((size[1], size[0], 3), np.uint8)
    pixels[:, : size[0] // 2] = left
    pixels[:, size[0] // 2 :] = right
    return Image.fromarray(pixels)


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, halves in HALVES.items():
        # Unlike sizes.
        picture(*halves, size=(64, 48) if name == "a.png" else (160, 96)).save(name)
    materials = "".join(f"newmtl {name[0]}\nmap_Kd {name}\n" for name in HALVES)
    (tmp_path / "m.mtl").write_text(materials + "newmtl c\nKd 1 0.5 0\n")
    return tmp_path


def square(i):
    """Corners of a square as wide as half a picture is long: four triangles, two for each half."""
    xs = (i, i + 0.5, i + 1)
    return [(x, y, 0) for y in (0, 1) for x in xs]


TRIANGLES = [(0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4)]
UVS = [(u, v) for v in (0, 1) for u in (0, 0.5, 1)]  # v points up


def obj(materials, shift=(0, 0), scale=1):
    """A square for each material; None: without texture coordinates, of the last one."""
    lines = ["mtllib m.mtl"]
    for i, material in enumerate(materials):
        lines += [f"v {x} {y} {z}" for x, y, z in square(i)]
        lines += [f"vt {u * scale + shift[0]} {v * scale + shift[1]}" for u, v in UVS]
        lines += [f"usemtl {material}"]
        for triangle in TRIANGLES:
            corners = [6 * i + k + 1 for k in triangle]
            lines += ["f " + " ".join(f"{k}" if material == "c" else f"{k}/{k}" for k in corners)]
    return "\n".join(lines) + "\n"


def ply(numbers, comments):
    lines = ["ply", "format ascii 1.0", *(f"comment TextureFile {name}" for name in comments)]
    lines += [f"element vertex {6 * len(numbers)}", *(f"property float {axis}" for axis in "xyz")]
    lines += [f"element face {4 * len(numbers)}", "property list uchar int vertex_indices"]
    lines += ["property list uchar float texcoord", "property int texnumber", "end_header"]
    lines += [" ".join(map(str, p)) for i in range(len(numbers)) for p in square(i)]
    for i, number in enumerate(numbers):
        for triangle in TRIANGLES:
            pairs = [str(value) for k in triangle for value in UVS[k]]
            lines += [f"3 {' '.join(str(6 * i + k) for k in triangle)} 6 {' '.join(pairs)} {number}"]
    return "\n".join(lines) + "\n"


def glb(squares):
    """squares: of each the index of its image, or a linear colour; with a shift of coordinates and a wrap."""
    binary, views, accessors, primitives, materials, textures, samplers, images = (
        b"",
        [],
        [],
        [],
        [],
        [],
        [],
        [],
    )

    def view(data):
        nonlocal binary
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data + b"\0" * (-len(data) % 4)
        return len(views) - 1

    def accessor(values, kind, code):
        values = np.asarray(values, {5126: np.float32, 5123: np.uint16}[code])
        one = {"bufferView": view(values.tobytes()), "componentType": code, "type": kind}
        one["count"] = values.size if kind == "SCALAR" else len(values)
        if kind == "VEC3":
            one |= {"min": values.min(0).tolist(), "max": values.max(0).tolist()}
        accessors.append(one)
        return len(accessors) - 1

    for name in HALVES:
        file = io.BytesIO()
        Image.open(name).save(file, "PNG")
        images.append({"bufferView": view(file.getvalue()), "mimeType": "image/png"})
    for i, (shown, shift, wrap) in enumerate(squares):
        attributes = {"POSITION": accessor(square(i), "VEC3", 5126)}
        if isinstance(shown, int):
            pairs = [(u + shift, 1 - v + shift) for u, v in UVS]
            attributes["TEXCOORD_0"] = accessor(pairs, "VEC2", 5126)
            samplers.append({"wrapS": wrap, "wrapT": wrap})
            textures.append({"source": shown, "sampler": len(samplers) - 1})
            look = {"baseColorTexture": {"index": len(textures) - 1}}
        else:
            look = {"baseColorFactor": [*shown, 1]}
        materials.append({"pbrMetallicRoughness": look})
        indices = accessor(np.ravel(TRIANGLES), "SCALAR", 5123)
        primitives.append({"attributes": attributes, "indices": indices, "material": len(materials) - 1})
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "accessors": accessors,
        "images": images,
        "samplers": samplers,
        "textures": textures,
        "materials": materials,
        "meshes": [{"primitives": primitives}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    return glb_file(document, binary)


def shown(name, *more, code=0):
    """What the stream's mesh shows in the middle of each half of each square, from left to right."""
    done = run("fvvmux", "--meshes", name, "-o", "o.fvv", "--quality", "40", "--force", *more, code=code)
    run("fvvdemux", "o.fvv", "-o", "x", "--meshes", "glb", "--force")
    return done, shown_by("x/meshes/0000.glb")


def shown_by(file):
    (mesh,) = trimesh.load(file, process=False).geometry.values()
    texture = np.asarray(mesh.visual.material.baseColorTexture.convert("RGB"), int)
    uv = mesh.visual.uv[mesh.faces].mean(1)
    middles = mesh.vertices[mesh.faces].mean(1)[:, 0]
    found = {}
    for (u, v), x in zip(uv, middles):
        row, column = int((1 - v) * texture.shape[0]), int(u * texture.shape[1])
        pixel = texture[min(row, len(texture) - 1), min(column, texture.shape[1] - 1)]
        found.setdefault(int(2 * x), []).append(pixel)
    return [np.mean(found[half], 0) for half in sorted(found)]


def check(found, expected):
    assert len(found) == len(expected)
    for pixel, colour in zip(found, expected):
        assert np.abs(pixel - colour).max() <= 12, (found, expected)


def test_materials_of_obj(place):
    (place / "a.obj").write_text(obj("ab"))
    check(shown("a.obj")[1], SHOWN)


def test_a_material_that_is_one_colour(place):
    (place / "a.obj").write_text(obj("acb"))
    check(shown("a.obj")[1], [RED, GREEN, (255, 128, 0), (255, 128, 0), BLUE, YELLOW])


def test_faces_that_lack_coordinates_of_their_picture(place):
    (place / "a.obj").write_text(obj("ab").replace("f 7/7", "f 7"))
    done = run("fvvmux", "--meshes", "a.obj", "-o", "o.fvv", code=3)
    assert "triangles without texture coordinates, whose material has a picture: 2 in 1 frames" in done.stderr


def test_materials_of_glb(place):
    (place / "a.glb").write_bytes(glb([(1, 0, 10497), ((1, 0, 0), 0, 0), (0, 0, 10497)]))
    check(shown("a.glb")[1], [BLUE, YELLOW, (255, 0, 0), (255, 0, 0), RED, GREEN])


def test_frames_of_several_materials(place):
    for frame in range(2):
        (place / f"m{frame}.obj").write_text(obj("ab"))
    check(shown("m%d.obj")[1], SHOWN)


ORANGE = [(255, 128, 0)] * 2
SHOWN_BY = {"a": HALVES["a.png"], "b": HALVES["b.png"], "c": ORANGE}


@pytest.mark.parametrize("more", [(), ("--codec", "jpeg"), ("--ladder", "1,0.5"), ("--bit-depth", "10")])
@pytest.mark.parametrize("takes", [["a", "ab", "cab"], ["ab", "a", "b"], ["bcaab", "a", "acb", "b"]])
def test_materials_that_change_from_frame_to_frame(takes, more, place):
    """Each of the frames has an atlas of its own size, and all are sent with one."""
    if "10" in more:
        more = (*more, "--codec", "hevc")
    for frame, materials in enumerate(takes):
        (place / f"m{frame}.obj").write_text(obj(materials))
    done = run("fvvmux", "--meshes", "m%d.obj", "-o", "o.fvv", "--quality", "40", "--verify", *more)
    assert not done.stderr
    run("fvvdemux", "o.fvv", "-o", "x", "--meshes", "glb", "--force")
    for frame, materials in enumerate(takes):
        check(shown_by(f"x/meshes/{frame:04}.glb"), [half for name in materials for half in SHOWN_BY[name]])


def test_pictures_that_change_their_size_on_the_same_faces(place):
    """Connectivity stays: texture coordinates of the key frame would be wrong."""
    for frame, width in enumerate((64, 320, 32, 200)):
        folder = place / f"f{frame}"
        folder.mkdir()
        picture(RED, GREEN, size=(width, 48)).save(folder / "a.png")
        picture(BLUE, YELLOW, size=(64, 48 + 3 * width)).save(folder / "b.png")
        (folder / "m.mtl").write_text((place / "m.mtl").read_text())
        (folder / "m.obj").write_text(obj("ab"))
    run("fvvmux", "--meshes", "f%d/m.obj", "-o", "o.fvv", "--quality", "40", "--verify")
    run("fvvdemux", "o.fvv", "-o", "x", "--meshes", "glb", "--force")
    for frame in range(4):
        check(shown_by(f"x/meshes/{frame:04}.glb"), SHOWN)


def test_a_scale_of_a_later_frame_is_said(place):
    for name, halves in HALVES.items():
        picture(*halves, size=(9000 if name == "b.png" else 7000, 16)).save(name)
    for frame, materials in enumerate(["a", "ab"]):
        (place / f"m{frame}.obj").write_text(obj(materials))
    done = run("fvvmux", "--meshes", "m%d.obj", "-o", "o.fvv", "--quality", "40", code=3)
    assert "m1.obj" in done.stderr and "0.75 of their width" in done.stderr


@pytest.mark.parametrize("wrap", [10497, 33648, 33071])
@pytest.mark.parametrize("shift", [1, -2])
def test_whole_shifts_of_glb(wrap, shift, place):
    (place / "a.glb").write_bytes(glb([(0, shift, wrap)]))
    if wrap == 33071:  # clamped: the edge
        check(shown("a.glb")[1], [GREEN, GREEN] if shift > 0 else [RED, RED])
    else:
        mirrored = wrap == 33648 and shift % 2
        check(shown("a.glb")[1], [GREEN, RED] if mirrored else [RED, GREEN])


@pytest.mark.parametrize("shift", [(3, -2), (-2e-5, 0), (0, 1.00002)])
def test_whole_shifts_and_rounding_of_obj(shift, place):
    (place / "a.obj").write_text(obj("a", shift))
    check(shown("a.obj")[1], [RED, GREEN])
    check(shown("a.obj", "--atlas", "a.png")[1], [RED, GREEN])


def test_a_picture_that_repeats_on_a_face(place):
    (place / "a.obj").write_text(obj("a", scale=3))
    done = run("fvvmux", "--meshes", "a.obj", "-o", "o.fvv", code=1)
    assert "repeats" in done.stderr and "--atlas none" in done.stderr
    run("fvvmux", "--meshes", "a.obj", "-o", "o.fvv", "--atlas", "none")


def test_the_picture_of_a_ply_file(place):
    (place / "a.ply").write_text(ply([0], ["a.png"]))
    check(shown("a.ply")[1], [RED, GREEN])


def test_pictures_of_a_ply_file(place):
    (place / "a.ply").write_text(ply([1, -1, 0], ["a.png", "b.png"]))
    check(shown("a.ply")[1], [BLUE, YELLOW, GREY, GREY, RED, GREEN])


def test_a_missing_picture_of_a_ply_file_is_a_warning(place):
    (place / "a.ply").write_text(ply([0], ["gone.png"]))
    done = run("fvvmux", "--meshes", "a.ply", "-o", "o.fvv", code=3)
    assert "gone.png" in done.stderr and "atlas" in done.stderr


def test_a_picture_elsewhere_is_not_read(place):
    (place / "in").mkdir()
    (place / "in/a.ply").write_text(ply([0], ["../../etc/a.png"]))
    run("fvvmux", "--meshes", "in/a.ply", "-o", "o.fvv", "--atlas", "embedded", code=1)


def test_pictures_that_are_too_large_together(place):
    """They are made smaller, and it is said."""
    for name, halves in HALVES.items():
        picture(*halves, size=(9000, 16)).save(name)
    (place / "a.obj").write_text(obj("ab"))
    done, found = shown("a.obj", code=3)
    assert "0.75 of their width" in done.stderr
    check(found, SHOWN)
