"""Colours that meshes bring for their vertices: sent, and drawn as they are in the file."""

import json
import struct

import numpy as np
import pytest
import trimesh
from conftest import glb_file, run
from PIL import Image

SIZE = 96
# A square before a dark wall of the same mesh: its left half is one colour, its right half another.
LEFT, RIGHT = (200, 40, 80), (30, 180, 120)
FACES = [(0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6)]
PLACES = [(x, y, 0) for y in (-1, 1) for x in (-1, -0.01, 0.01, 1)]
COLOURS = [LEFT, LEFT, RIGHT, RIGHT] * 2


def ply(kind="uchar", white=255, names=("red", "green", "blue"), of_faces=False):
    properties = "".join(f"property {kind} {name}\n" for name in names)
    rows = [" ".join(map(str, p)) for p in PLACES]
    faces = [f"3 {a} {b} {c}" for a, b, c in FACES]
    if of_faces:
        faces = [
            f"{row} {' '.join(str(v * white / 255) if white == 1 else str(v) for v in COLOURS[a])}"
            for row, (a, b, c) in zip(faces, FACES)
        ]
    else:
        rows = [
            f"{row} {' '.join(f'{v * white / 255:.6f}' if 'float' in kind else str(v * white // 255) for v in c)}"
            for row, c in zip(rows, COLOURS)
        ]
    return (
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        + ("" if of_faces else properties)
        + "element face 6\nproperty list uchar int vertex_indices\n"
        + (properties if of_faces else "")
        + "end_header\n"
        + "\n".join(rows + faces)
        + "\n"
    ).encode()


def obj(row):
    lines = ["v " + row.format(p=p, c=[v / 255 for v in c], b=c) for p, c in zip(PLACES, COLOURS)]
    return "\n".join(lines + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES] + [""]).encode()


def linear(value):
    value /= 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def glb(kind, factor=None):
    """kind: of COLOR_0, None: none; factor: of the base colour."""
    places = np.array(PLACES, np.float32)
    corners = np.array(FACES, np.uint16)
    light = np.array([[linear(v) for v in c] for c in COLOURS])
    parts = [places.tobytes(), corners.tobytes()]
    accessors = [
        {
            "bufferView": 0,
            "componentType": 5126,
            "count": 8,
            "type": "VEC3",
            "min": [-1, -1, 0],
            "max": [1, 1, 0],
        },
        {"bufferView": 1, "componentType": 5123, "count": 18, "type": "SCALAR"},
    ]
    attributes = {"POSITION": 0}
    if kind == "float":
        parts.append(light.astype(np.float32).tobytes())
        accessors.append({"bufferView": 2, "componentType": 5126, "count": 8, "type": "VEC3"})
    if kind == "uint16":
        alpha = np.c_[np.round(light * 65535), np.full(8, 65535)]
        parts.append(alpha.astype(np.uint16).tobytes())
        accessors.append(
            {"bufferView": 2, "componentType": 5123, "count": 8, "type": "VEC4", "normalized": True}
        )
    if kind:
        attributes["COLOR_0"] = 2
    views, binary = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(part)})
        binary += part + b"\0" * (-len(part) % 4)
    primitive = {"attributes": attributes, "indices": 1}
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [primitive]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    if factor:
        primitive["material"] = 0
        document["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [*map(linear, factor), 1]}}]
    return glb_file(document, binary)


MATERIALS = ("mtllib m.mtl\n" + "".join("v {} {} {}\n".format(*p) for p in PLACES)).encode() + b"".join(
    f"usemtl {'left' if i < 2 else 'right'}\nf {a + 1} {b + 1} {c + 1}\n".encode()
    for i, (a, b, c) in enumerate(FACES)
    if i not in (2, 3)  # the faces between both halves
)
FILES = {
    "bytes.ply": ply(),
    "bytes in shorts.ply": ply("ushort"),
    "bytes in signed shorts.ply": ply("short"),
    "shorts in integers.ply": ply("int", 65535),
    "capitals.ply": ply(names=("Red", "Green", "Blue")),
    "ambient.ply": ply(names=("ambient_red", "ambient_green", "ambient_blue")),
    "materials.obj": MATERIALS,
    "shorts.ply": ply("ushort", 65535),
    "floats.ply": ply("float", 1),
    "floats to 255.ply": ply("float", 255),
    "diffuse.ply": ply(names=("diffuse_red", "diffuse_green", "diffuse_blue")),
    "floats.obj": obj("{p[0]} {p[1]} {p[2]} {c[0]} {c[1]} {c[2]}"),
    "bytes.obj": obj("{p[0]} {p[1]} {p[2]} {b[0]} {b[1]} {b[2]}"),
    "weights.obj": obj("{p[0]} {p[1]} {p[2]} 1 {c[0]} {c[1]} {c[2]}"),
    "opacity.obj": obj("{p[0]} {p[1]} {p[2]} {c[0]} {c[1]} {c[2]} 1"),
    "floats.glb": glb("float"),
    "integers with opacity.glb": glb("uint16"),
}


def drawn(path, folder):
    """The middles of the left and the right half, from the front."""
    stream = folder / "o.fvv"
    done = run("fvvmux", "--meshes", path, "-o", stream, "--up", "+y")
    view = ("--pose", "0,0,2,0,0,0", "--size", f"{SIZE}x{SIZE}")
    run("fvvrender", stream, "--frame", 0, *view, "-o", folder / "view.png")
    pixels = np.asarray(Image.open(folder / "view.png").convert("RGB"), int)
    return done, pixels[SIZE // 2, SIZE // 4], pixels[SIZE // 2, 3 * SIZE // 4]


@pytest.mark.parametrize("name", ["floats.ply", "floats.obj"])
def test_light_above_white_does_not_make_the_others_bytes(name, tmp_path):
    brightest = max(FILES[name].split(), key=lambda word: float(word) if word.startswith(b"0.7") else 0)
    (tmp_path / name).write_bytes(FILES[name].replace(brightest, b"1.5"))
    done, left, right = drawn(tmp_path / name, tmp_path)
    assert is_colour(left, (255, 40, 80)) and is_colour(right, RIGHT), (left, right)


def is_colour(pixel, colour):
    """Light changes how bright it is: what is compared are ratios."""
    scale = pixel.sum() / sum(colour)
    return 0.5 < scale <= 1.1 and np.abs(pixel / scale - colour).max() <= 8


@pytest.mark.parametrize("name", FILES)
def test_colours_arrive(name, tmp_path):
    (tmp_path / name).write_bytes(FILES[name])
    kd = [
        "newmtl {}\nKd {} {} {}\n".format(n, *(v / 255 for v in c))
        for n, c in (("left", LEFT), ("right", RIGHT))
    ]
    (tmp_path / "m.mtl").write_text("".join(kd))
    done, left, right = drawn(tmp_path / name, tmp_path)
    assert is_colour(left, LEFT) and is_colour(right, RIGHT), (left, right)


def test_colours_of_faces(tmp_path):
    (tmp_path / "a.ply").write_bytes(ply(of_faces=True))
    done, left, right = drawn(tmp_path / "a.ply", tmp_path)
    assert is_colour(left, LEFT), left
    # A vertex has the mean of the faces around it: on the border both colours mix.
    assert right[1] > right[0] and right[1] > 2 * left[1], (left, right)


def test_the_base_colour_of_a_material(tmp_path):
    (tmp_path / "a.glb").write_bytes(glb(None, LEFT))
    done, left, right = drawn(tmp_path / "a.glb", tmp_path)
    assert is_colour(left, LEFT) and is_colour(right, LEFT), (left, right)


def test_off(tmp_path):
    (tmp_path / "a.ply").write_bytes(ply())
    done = run(
        "fvvmux", "--meshes", tmp_path / "a.ply", "-o", tmp_path / "o.fvv", "--colours", "off", "--json"
    )
    assert not json.loads(done.stdout)["colours"]["sent"]


def test_a_frame_without_colours_is_a_warning(tmp_path):
    (tmp_path / "m0.ply").write_bytes(FILES["bytes.ply"])
    # Another mesh: a key frame of its own.
    other = FILES["bytes.ply"].replace(b"uchar red", b"uchar other").replace(b"3 0 1 5\n", b"3 0 1 4\n")
    (tmp_path / "m1.ply").write_bytes(other)
    done = run("fvvmux", "--meshes", tmp_path / "m%d.ply", "-o", tmp_path / "o.fvv", code=3)
    assert "m1.ply: frame 1: has no colours of vertices" in done.stderr


def test_a_scan_looks_like_the_scan(tmp_path):
    """The colours of 10,242 vertices differ from the file's by what does not show."""
    body = trimesh.creation.icosphere(subdivisions=5)
    waves = np.clip(127 + 120 * np.sin(12 * body.vertices), 0, 255).astype(np.uint8)
    body.visual.vertex_colors = np.c_[waves, np.full(len(waves), 255)]
    body.export(tmp_path / "scan.ply")
    done = run("fvvmux", "--meshes", tmp_path / "scan.ply", "-o", tmp_path / "o.fvv", "--json")
    colours = json.loads(done.stdout)["colours"]
    assert colours["sent"] and colours["psnr"] > 42 and colours["not_shown"] == 0


@pytest.fixture(scope="module")
def scanned(tmp_path_factory):
    """A sphere with colours of vertices, its stream, and places and colours of the file."""
    folder = tmp_path_factory.mktemp("scanned")
    body = trimesh.creation.icosphere(subdivisions=3)
    colours = np.clip(127 + 120 * np.sin(3 * body.vertices), 0, 255).astype(np.uint8)
    body.visual.vertex_colors = np.c_[colours, np.full(len(colours), 255)]
    body.export(folder / "scan.ply")
    run("fvvmux", "--meshes", folder / "scan.ply", "-o", folder / "o.fvv", "--keep-geometry")
    return folder / "o.fvv", np.asarray(body.vertices), colours


def in_file(path):
    """Places and display colours of vertices."""
    if path.suffix != ".glb":
        mesh = trimesh.load(path, process=False, force="mesh")
        return np.asarray(mesh.vertices), np.asarray(mesh.visual.vertex_colors, float)[:, :3]
    content = path.read_bytes()
    size = struct.unpack_from("<I", content, 12)[0]
    document, binary = json.loads(content[20 : 20 + size]), content[28 + size :]
    attributes = document["meshes"][0]["primitives"][0]["attributes"]

    def array(name):
        accessor = document["accessors"][attributes[name]]
        view = document["bufferViews"][accessor["bufferView"]]
        begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(binary, "<f4", 3 * accessor["count"], begin).reshape(-1, 3).astype(float)

    light = array("COLOR_0")
    return array("POSITION"), 255 * np.where(
        light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055
    )


@pytest.mark.parametrize("kind", ["ply", "obj", "glb", "gltf", "meshopt"])
def test_colours_come_back(scanned, tmp_path, kind):
    stream, places, colours = scanned
    how = ["--meshes", kind] if kind != "meshopt" else ["--meshes", "glb", "--compress", "meshopt"]
    run("fvvdemux", stream, "-o", tmp_path / "out", *how)
    [path] = [p for p in (tmp_path / "out/meshes").iterdir() if p.suffix in (".ply", ".obj", ".glb")]
    if kind in ("ply", "meshopt"):  # packed again, and, where others cannot read it, unpacked
        again = ["--meshes", path, "-o", tmp_path / "again.fvv", "--keep-geometry", "--json"]
        assert json.loads(run("fvvmux", *again).stdout)["colours"]["sent"]
    if kind == "meshopt":
        run("fvvdemux", tmp_path / "again.fvv", "-o", tmp_path / "plain")
        path = tmp_path / "plain/meshes/0000.ply"
    where, found = in_file(path)
    near = [int(np.argmin(((places - p) ** 2).sum(1))) for p in where]
    assert len(near) == len(places) and np.sqrt(((found - colours[near]) ** 2).mean()) < 4


def test_meshes_that_have_pictures_get_no_colours(eight_frames, tmp_path):
    run("fvvmux", eight_frames, "-o", tmp_path / "s.fvv", "--frames", "0-0", "--colours", "on")
    run("fvvdemux", tmp_path / "s.fvv", "-o", tmp_path / "out")
    assert b"red" not in (tmp_path / "out/meshes/0000.ply").read_bytes()[:600]


COLOURED = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{}"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n{}3 0 1 2\n"
)


def triangle(colour):
    properties = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    row = "" if colour is None else " {} {} {}".format(*colour)
    return COLOURED.format(
        properties if colour else "", "".join(f"{p}{row}\n" for p in ("0 0 0", "1 0 0", "0 1 0"))
    )


RED, DARK_RED, GREEN = (255, 0, 0), (250, 4, 0), (0, 255, 0)
TAKES = {
    "changing": (RED, GREEN, RED),
    "almost the same": (RED, DARK_RED, RED),
    "none in the first frame": (None, GREEN, GREEN),
    "none in between": (RED, None, GREEN),
}


@pytest.mark.parametrize("track", ["never", "always"])
@pytest.mark.parametrize("name", TAKES)
def test_colours_that_change_on_the_same_faces(name, track, tmp_path):
    """A key frame's colours hold for its delta frames: frames of other colours are no delta frames."""
    for i, colour in enumerate(TAKES[name]):
        (tmp_path / f"{i}.ply").write_text(triangle(colour))
    stream = tmp_path / "o.fvv"
    warned = None in TAKES[name]
    done = run(
        "fvvmux",
        "--meshes",
        tmp_path / "%d.ply",
        "-o",
        stream,
        "--track",
        track,
        warns=warned,
        code=3 if warned else 0,
    )
    assert ("has no colours of vertices" in done.stderr) == warned
    run("fvvdemux", stream, "-o", tmp_path / "x", "--meshes", "ply")
    for i, colour in enumerate(TAKES[name]):
        mesh = trimesh.load(tmp_path / f"x/meshes/{i:04}.ply", process=False)
        if colour is None:
            assert mesh.visual.kind is None
        else:
            assert np.abs(mesh.visual.vertex_colors[:, :3].astype(int) - colour).max() < 8
