"""100,000 values inside one another, in each format of text that a tool reads: refused by depth, never a stack that overflows."""

import json
import subprocess
import time

import pytest
from conftest import run, tool_path

DEPTH = 100000
LISTS = "[" * DEPTH + "]" * DEPTH
JSON_FILES = {
    "arrays": LISTS,
    "objects": '{"a":' * DEPTH + "1" + "}" * DEPTH,
    "open": "[" * DEPTH,
    "inside": '{"cameras":' + LISTS + ',"frames":' + LISTS + "}",
}
XML_FILES = {
    "elements": "<a>" * DEPTH + "</a>" * DEPTH,
    "inside": "<document><chunk>" + "<a>" * DEPTH + "</a>" * DEPTH + "</chunk></document>",
    "open": "<a>" * DEPTH,
}
YAML_FILES = {
    "flow lists": "a: " + LISTS,
    "flow maps": "a: " + "{a: " * DEPTH + "}" * DEPTH,
    "open": "a: " + "[" * DEPTH,
    "block lists": "a:\n" + "- " * DEPTH + "1",
    "keys": "? " * DEPTH + "1",
}
DOTTED = ".".join(["a"] * DEPTH)
TOML_FILES = {
    "arrays": f"a = {LISTS}",
    "tables": "a = " + "{a=" * DEPTH + "1" + "}" * DEPTH,
    "dotted key": f"{DOTTED} = 1",
    "dotted table": f"[{DOTTED}]\nb = 1",
    "dotted array": f"[[{DOTTED}]]\nb = 1",
    "dotted inside": "x = {" + DOTTED + " = 1}",
}
# Formats of calibrations, the file, and its contents.
CALIBRATIONS = [
    *(("nerfstudio", "transforms.json", JSON_FILES, name) for name in JSON_FILES),
    *(("panoptic", "c.json", JSON_FILES, name) for name in JSON_FILES),
    *(("opencv", "c.json", JSON_FILES, name) for name in JSON_FILES),
    *(("metashape", "c.xml", XML_FILES, name) for name in XML_FILES),
    *(("qualisys", "c.xml", XML_FILES, name) for name in XML_FILES),
    *(("opencv", "c.xml", XML_FILES, name) for name in XML_FILES),
    *(("opencv", "c.yml", YAML_FILES, name) for name in YAML_FILES),
    *(("kalibr", "c.yaml", YAML_FILES, name) for name in YAML_FILES),
    *(("easymocap", "intri.yml", YAML_FILES, name) for name in YAML_FILES),
    *(("toml", "c.toml", TOML_FILES, name) for name in TOML_FILES),
]


def refused(words, folder, file):
    """In one line that begins with the file, within seconds."""
    begin = time.monotonic()
    words = [str(tool_path(words[0])), *map(str, words[1:])]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1, done.stderr[:500]
    assert file in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr[:500]
    assert time.monotonic() - begin < 20
    return done.stderr


@pytest.mark.parametrize(("kind", "file", "texts", "name"), CALIBRATIONS)
def test_calibrations(kind, file, texts, name, tmp_path):
    (tmp_path / file).write_text(texts[name])
    (tmp_path / "extri.yml").write_text(texts[name])
    source = "." if kind == "easymocap" else file
    size = ["--size", "64x48"] if kind == "easymocap" else []
    refused(["fvvimport", kind, source, *size, "--pictures", "{name}.png", "-o", "o.json"], tmp_path, file)


@pytest.mark.parametrize("name", JSON_FILES)
@pytest.mark.parametrize("file", ["capture.json", "transforms.json"])
def test_captures(file, name, tmp_path):
    (tmp_path / file).write_text(JSON_FILES[name])
    refused(["fvvmux", ".", "-o", "o.fvv"], tmp_path, file)


@pytest.mark.parametrize("name", JSON_FILES)
def test_gltf(name, tmp_path):
    (tmp_path / "m.gltf").write_text(JSON_FILES[name])
    refused(["fvvmux", "--meshes", "m.gltf", "--fps", 25, "-o", "o.fvv"], tmp_path, "m.gltf")


@pytest.fixture(scope="module")
def scene(eight_frames, tmp_path_factory):
    folder = tmp_path_factory.mktemp("scene")
    run("fvvmux", eight_frames, "-o", folder / "s.fvv")
    return folder


@pytest.mark.parametrize("name", JSON_FILES)
def test_paths_of_a_camera(name, scene, tmp_path):
    (tmp_path / "path.json").write_text(JSON_FILES[name])
    words = ["fvvrender", scene / "s.fvv", "--path", "path.json", "-o", "f.mp4"]
    refused(words, tmp_path, "path.json")


@pytest.mark.parametrize("name", ["arrays", "objects"])
def test_metadata_of_a_stream(name, eight_frames, tmp_path):
    """It is text to all tools: it is neither parsed nor refused."""
    capture = json.loads((eight_frames / "capture.json").read_text())
    for path in eight_frames.iterdir():
        if path.name != "capture.json":
            (tmp_path / path.name).symlink_to(path)
    capture["metadata"] = "@"
    text = json.dumps(capture).replace('"@"', JSON_FILES[name])
    (tmp_path / "capture.json").write_text(text)
    refused(["fvvmux", ".", "-o", "o.fvv"], tmp_path, "capture.json")
