"""Pictures of meshes, cameras and masks in all formats: read, or named with a way out."""

import json
import shutil

import numpy as np
import pytest
from conftest import glb_file, run
from PIL import Image

OBJ = """mtllib m.mtl
usemtl m
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 1/1 2/2 3/3
f 1/1 3/3 4/4
"""
KTX2 = b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(68)


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.obj").write_text(OBJ)
    return tmp_path


def ramp():
    y, x = np.mgrid[0:64, 0:64]
    return Image.fromarray(np.dstack([x * 4, y * 4, 128 + 0 * x]).astype(np.uint8))


def glb(image, extension, colour=None, factor=None, others=None, emitted=None, material_has=None):
    """A square whose texture has its picture by an extension alone, or as glTF itself has it.

    colour: of a vertex, others: of the others, which are white without. factor: of its material. emitted: the factor
    of a texture that is emitted, in place of a base colour. material_has: more of its material.
    """
    numbers = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32).tobytes()
    pairs = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32).tobytes()
    corners = np.array([0, 1, 2, 0, 2, 3], np.uint16).tobytes()
    binary, views = b"", []
    colours = np.ones((4, 3), np.float32) * np.float32(1 if others is None else others)
    colours[2] = 1 if colour is None else colour
    for data in (numbers, pairs, corners, image, colours.tobytes()):
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data + b"\0" * (-len(data) % 4)
    texture = {"extensions": {extension: {"source": 0}}} if extension else {"source": 0}
    look = {"baseColorTexture": {"index": 0}} | ({"baseColorFactor": factor} if factor else {})
    material = {"pbrMetallicRoughness": look}
    if emitted:
        material = {"emissiveTexture": {"index": 0}, "emissiveFactor": emitted}
    material |= material_has or {}
    attributes = {"POSITION": 0, "TEXCOORD_0": 1} | ({"COLOR_0": 3} if colour is not None else {})
    document = {
        "asset": {"version": "2.0"},
        "extensionsUsed": [extension] if extension else [],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": views,
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 4,
                "type": "VEC3",
                "min": [0, 0, 0],
                "max": [1, 1, 0],
            },
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
            {"bufferView": 4, "componentType": 5126, "count": 4, "type": "VEC3"},
        ],
        "images": [{"bufferView": 3, "mimeType": "image/webp"}],
        "textures": [texture],
        "materials": [material],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 2, "material": 0}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    return glb_file(document, binary)


def mux(name, *more, code=0):
    return run("fvvmux", "--meshes", name, "-o", "o.fvv", "--quality", 30, *more, "--force", code=code)


def picture_of_stream():
    run("fvvdemux", "o.fvv", "-o", "x", "--force")
    return np.asarray(Image.open("x/atlas/0000.png").convert("RGB"), int)


@pytest.mark.parametrize("lossless", [True, False])
def test_webp_of_an_obj_file(lossless, place):
    ramp().save("t.webp", lossless=lossless, quality=95)
    (place / "m.mtl").write_text("newmtl m\nmap_Kd t.webp\n")
    mux("a.obj")
    assert np.abs(picture_of_stream() - np.asarray(ramp(), int)).mean() < 6
    mux("a.obj", "--atlas", "t.webp")


@pytest.mark.parametrize("extension", ["EXT_texture_webp", None])
def test_webp_of_a_glb_file(extension, place):
    ramp().save("t.webp", lossless=True)
    (place / "a.glb").write_bytes(glb((place / "t.webp").read_bytes(), extension))
    mux("a.glb")
    assert np.abs(picture_of_stream() - np.asarray(ramp(), int)).mean() < 6


def test_webp_of_several_materials(place):
    ramp().save("t.webp", lossless=True)
    ramp().save("t.png")
    (place / "m.mtl").write_text("newmtl m\nmap_Kd t.webp\nnewmtl n\nmap_Kd t.png\n")
    (place / "a.obj").write_text(OBJ.replace("f 1/1 3/3", "usemtl n\nf 1/1 3/3"))
    mux("a.obj")


@pytest.mark.parametrize("kind", ["bmp", "tiff", "gif"])
def test_other_pictures_of_an_obj_file_are_named(kind, place):
    ramp().save(f"t.{kind}")
    (place / "m.mtl").write_text(f"newmtl m\nmap_Kd t.{kind}\n")
    done = mux("a.obj", code=1)
    assert f"t.{kind}: is a {kind.upper()} file, expected PNG" in done.stderr
    assert "--atlas FILE" in done.stderr
    ramp().save("t.png")
    mux("a.obj", "--atlas", "t.png")


def test_other_pictures_beside_a_picture_are_named(place):
    ramp().save("t.bmp")
    ramp().save("t.png")
    (place / "m.mtl").write_text("newmtl m\nmap_Kd t.bmp\nnewmtl n\nmap_Kd t.png\n")
    (place / "a.obj").write_text(OBJ.replace("f 1/1 3/3", "usemtl n\nf 1/1 3/3"))
    assert "t.bmp: is a BMP file" in mux("a.obj", code=1).stderr


def test_ktx2_of_a_glb_file_is_named(place):
    (place / "a.glb").write_bytes(glb(KTX2, "KHR_texture_basisu"))
    done = mux("a.glb", code=1)
    assert "a.glb: image 0: is a KTX2 file ('ktx extract'" in done.stderr and "--atlas FILE" in done.stderr
    ramp().save("t.png")
    mux("a.glb", "--atlas", "t.png")


def test_pictures_and_masks_of_cameras_in_webp(place):
    """Also masks that are alpha."""
    small = ("--rig", "small", "--cameras", 3, "--size", "96x64", "--frames", 2, "-o", "made")
    quick = ("--quality", 30, "--visibility", "none", "--match-colours", "off", "--texture-inset", "off")
    run("fvvsynth", *small)
    run("fvvmux", "made", "-o", "png.fvv", *quick)
    shutil.copytree("made", "webp")
    capture = json.loads((place / "made/capture.json").read_text())
    for camera in capture["cameras"]:
        for key in "pictures", "masks":
            pattern = camera[key]
            for frame in range(2):
                path = place / "webp" / (pattern % frame)
                image = Image.open(path)
                if key == "masks":
                    cut = Image.new("RGBA", image.size, (9, 9, 9, 0))
                    cut.putalpha(image.convert("L"))
                    image = cut
                image.save(path.with_suffix(".webp"), lossless=True, exact=True)
                path.unlink()
            camera[key] = pattern[: pattern.rindex(".")] + ".webp"
    (place / "webp/capture.json").write_text(json.dumps(capture))
    run("fvvmux", "webp", "-o", "webp.fvv", *quick)
    assert (place / "webp.fvv").read_bytes() == (place / "png.fvv").read_bytes()


def linear(levels):
    part = np.asarray(levels) / 255
    return np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)


def display(light):
    return 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize(
    ("colours", "factor"),
    [
        (1, None),
        (None, [1, 1, 1, 1]),
        (None, [0.5, 1, 0.25, 1]),
        (0.2, None),
        ([1, 0.5, 0], [0.5, 0.5, 1, 1]),
    ],
)
def test_a_picture_is_multiplied_with_one_colour(colours, factor, place):
    """As light: half of it is level 188 of 255."""
    ramp().save("t.png")
    (place / "a.glb").write_bytes(glb((place / "t.png").read_bytes(), None, colours, factor, others=colours))
    done = run("fvvmux", "--meshes", "a.glb", "-o", "o.fvv", "--codec", "jpeg", "--quality", 98)
    assert done.stderr == ""
    tint = np.ones(3) * (1 if colours is None else colours) * (factor or [1, 1, 1, 1])[:3]
    expected = display(linear(np.asarray(ramp())) * tint)
    assert np.abs(picture_of_stream() - expected).mean() < 3


def test_an_emitted_picture_has_its_factor(place):
    ramp().save("t.png")
    content = glb((place / "t.png").read_bytes(), None, emitted=[0.5, 0, 1])
    (place / "a.glb").write_bytes(content)
    run("fvvmux", "--meshes", "a.glb", "-o", "o.fvv", "--codec", "jpeg", "--quality", 98)
    expected = display(linear(np.asarray(ramp())) * [0.5, 0, 1])
    assert np.abs(picture_of_stream() - expected).mean() < 3


@pytest.mark.parametrize(("colour", "warns"), [(1, False), (0.2, True)])
def test_unlike_colours_that_a_texture_is_multiplied_with_are_a_warning(colour, warns, place):
    ramp().save("t.png")
    (place / "a.glb").write_bytes(glb((place / "t.png").read_bytes(), None, colour))
    done = mux("a.glb", code=3 if warns else 0)
    assert ("COLOR_0" in done.stderr) == warns
    mux("a.glb", "--atlas", "t.png")


@pytest.mark.parametrize(
    ("more", "named"),
    [
        ({}, None),
        ({"alphaMode": "OPAQUE", "name": "skin"}, None),
        ({"alphaMode": "MASK", "alphaCutoff": 0.3, "name": "hair"}, '"hair"'),
        ({"alphaMode": "BLEND", "doubleSided": True}, "material 0"),
    ],
)
def test_a_transparent_material_is_shown_whole_with_a_warning(more, named, place):
    ramp().save("t.png")
    (place / "a.glb").write_bytes(glb((place / "t.png").read_bytes(), None, material_has=more))
    said = mux("a.glb", code=3 if named else 0).stderr
    assert ("alphaMode" in said) == bool(named)
    assert not named or f"a.glb: {named} may be transparent" in said
