"""The specification is consistent: generated files, schemas and their example, links."""

import importlib.util
import json
import re
import subprocess
import sys

import jsonschema
import pytest
from conftest import ROOT, SPEC, schema, validate

SCHEMAS = sorted(SPEC.glob("*.schema.json"))
EXAMPLES = re.findall(r"^```json\n(.*?)^```", (SPEC / "capture.md").read_text(), flags=re.S | re.M)


def pages():
    listed = ROOT.rglob("*.md")
    hidden = {"build", "node_modules"}
    for page in sorted(listed):
        parts = page.relative_to(ROOT).parts
        if not any(part in hidden or part.startswith((".", "build-")) for part in parts):
            yield page


def test_generated_files_and_issues_agree():
    command = [sys.executable, SPEC / "generate.py", "--check"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.stderr, done.returncode) == ("", 0)


@pytest.fixture(scope="module")
def generate():
    spec = importlib.util.spec_from_file_location("generate", SPEC / "generate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_core_of_the_specification_is_short(generate):
    text = (SPEC / "fvv.md").read_text()
    words = generate.core_words(text)
    assert 14000 < words <= 17500
    assert generate.core_words(text + "\n## Appendix Z\n\nmore words\n") == words
    sample = "## 1 A\n\ntwo words\n\n| a | table |\n\n    code = 1\n\n> **Why?** three words more\n\n## Appendix A\n\nx\n"
    assert generate.core_words(sample) == len("## 1 A two words > **Why?** three words more".split())


def test_a_requirement_without_a_number_is_found(generate):
    text = "## 3 Stream\n\nA reader MUST stop\n(FVV-1001).\n\n- It MUST go on.\n\n### 3.1 B\n\n> It MUST do this.\n\nIt MUST NOT.\n"
    assert list(generate.unnumbered(text)) == [("3", "- It MUST go on."), ("3.1", "It MUST NOT.")]


def test_contents_lead_to_every_clause(generate):
    text = (SPEC / "fvv.md").read_text()
    headings = re.findall(r"^###? (.*)$", text, flags=re.M)
    anchors = [generate.anchor(heading) for heading in headings if heading != "Contents"]
    contents = text.split("<!-- contents -->")[1].split("<!-- end contents -->")[0]
    assert re.findall(r"\(#(.*?)\)", contents) == anchors
    assert len(set(anchors)) == len(anchors) > 90


def test_numbers_of_issues_and_requirements_are_unique():
    data = json.loads((SPEC / "chunks.json").read_text())
    numbers = [entry["number"] for entry in data["issues"] + data["requirements"]]
    assert len(set(numbers)) == len(numbers)
    assert {entry["number"] // 1000 for entry in data["requirements"]} == {9}


def test_the_page_about_draco_names_every_part_that_the_checker_reports():
    source = (ROOT / "libfvv/src/mesh/draco_check.c").read_text()
    page = " ".join((ROOT / "docs/format/draco.md").read_text().split())
    parts = set(re.findall(r'broken\(w, "(.*?)"\)', source)) | set(re.findall(r'= {"(.*?)", {', source))
    parts |= set(re.findall(r'"([a-z ]+)", {\d', source))
    assert len(parts) >= 9
    assert [part for part in sorted(parts) if part not in page] == []


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text().split()) <= 900


def test_pages_that_files_name_are_there():
    """Help, comments and messages name pages by their path from the root; the build of the documentation checks links."""
    name = re.compile(r"(?<![\w/.-])docs/[\w./-]*\w\.md\b")
    files = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if files.returncode:
        pytest.skip("no git checkout")
    gone, found = [], 0
    for path in map(ROOT.joinpath, files.stdout.split("\n")[:-1]):
        if (
            path.suffix
            not in {".md", ".c", ".h", ".cpp", ".py", ".js", ".mjs", ".ts", ".json", ".cmake", ".txt", ""}
            or not path.is_file()
        ):
            continue
        for page in name.findall(path.read_text(errors="replace")):
            found += 1
            if not (ROOT / page).is_file():
                gone.append(f"{path.relative_to(ROOT)}: {page}")
    assert found > 100
    assert gone == []


@pytest.mark.parametrize("path", SCHEMAS, ids=lambda path: path.name)
def test_schema_is_a_schema(path):
    jsonschema.Draft202012Validator.check_schema(json.loads(path.read_text()))


def test_all_schemas_are_there():
    assert [path.name for path in SCHEMAS] == [
        "capture.schema.json",
        "fvvcapture-calibrate.schema.json",
        "fvvcapture-calibration.schema.json",
        "fvvcapture-live.schema.json",
        "fvvcapture.schema.json",
        "fvvcompare.schema.json",
        "fvvdemux.schema.json",
        "fvvimport.schema.json",
        "fvvinfo.schema.json",
        "fvvmux.schema.json",
        "fvvrecover.schema.json",
        "fvvrender.schema.json",
        "marks.schema.json",
        "segments.schema.json",
    ]


def test_examples_of_a_capture_fit_its_schema():
    assert EXAMPLES
    for example in EXAMPLES:
        validate(json.loads(example), "capture")


def test_schema_of_marks_takes_what_the_player_takes():
    cases = json.loads((ROOT / "tests/analysis/marks.json").read_text())
    for document in cases["valid"]:
        validate(document, "marks")
    for case in cases["refused"]:
        assert not jsonschema.Draft202012Validator(schema("marks")).is_valid(case["document"]), case


def accepts(**changes):
    """Whether the schema of a capture accepts the first example with these changes."""
    document = json.loads(EXAMPLES[0]) | changes
    return jsonschema.Draft202012Validator(schema("capture")).is_valid(document)


def test_schema_of_a_capture_refuses_what_the_page_forbids():
    assert accepts()
    for change in {"framerate": 25}, {"frame_rate": 29.97}, {"units": "ells"}, {"fvv_capture": 2}:
        assert not accepts(**change)


def test_schema_of_a_capture_takes_a_pattern_or_an_animated_file():
    assert accepts(meshes={"pattern": "%d.glb"})
    assert accepts(meshes={"file": "50%.glb"})
    assert accepts(meshes={"file": "a.glb", "animation": "run", "start": "3/2"})
    assert accepts(meshes={"file": "a.glb", "animation": 0, "start": 2})
    for wrong in (
        {"file": ""},
        {"animation": 0},
        {"file": "a.glb", "pattern": "%d.ply"},
        {"file": "a.glb", "start": "-1"},
    ):
        assert not accepts(meshes=wrong)


def test_schema_of_a_capture_takes_sound():
    good = {"file": "a%.wav", "stream": 1, "offset": "-1/2", "title": "hall", "language": "pt-BR"}
    assert accepts(audio=[good, {"file": "b.mp4", "offset": 3}])
    assert accepts(audio=[{"file": "a.wav", "position": [0, 1, 2.5]}])
    assert accepts(audio=[{"file": "a.wav", "per_frame": [{"frame": 0, "position": [0, 1, 2.5]}]}])
    for bad in (
        {},
        {"file": ""},
        {"file": "a.wav", "offset": 0.5},
        {"file": "a.wav", "language": "en_GB"},
        {"file": "a.wav", "position": [0, 1]},
        {"file": "a.wav", "position": [0, 1, 2], "per_frame": [{"frame": 0, "position": [0, 1, 2]}]},
        {"file": "a.wav", "volume": 1},
    ):
        assert not accepts(audio=[bad]), bad


def test_schema_of_a_capture_takes_stills_or_a_video():
    definitions = schema("capture")["$defs"]
    validator = jsonschema.Draft202012Validator({"$ref": "#/$defs/source", "$defs": definitions})
    for good in [
        "%d.png",
        {"pattern": "%d.png", "offset": -3, "rotate": 90},
        {"video": "a%.mp4", "stream": 1, "start": "-1/2"},
    ]:
        assert validator.is_valid(good)
    for bad in [
        {"pattern": "a.png", "start": 1},
        {"video": ""},
        {"video": "a", "rotate": 45},
        {"start": 1},
        {"video": "a", "offset": 1},
    ]:
        assert not validator.is_valid(bad)


def test_schema_of_a_capture_takes_an_atlas_of_stills_a_video_or_embedded_images():
    for pictures in (
        "%d.png",
        "atlas.png",
        {"pattern": "atlas.png", "rotate": 90},
        {"video": "a.mp4", "start": 1},
    ):
        assert accepts(atlas={"pictures": pictures, "texture_bits": 12})
        assert not accepts(atlas={"pictures": pictures, "embedded": True})
    assert accepts(atlas={"embedded": True})
    for wrong in {}, {"pictures": 1}, {"pictures": {"file": "a.png"}}, {"embedded": False}:
        assert not accepts(atlas=wrong)


def test_relative_links_lead_to_files():
    missing, seen = [], 0
    for page in pages():
        text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(), flags=re.S)
        for link in re.findall(r"\]\(([^)\s]+)\)", text):
            target = link.split("#")[0]
            if not target or re.match(r"[a-z][a-z0-9+.-]*:", target):
                continue
            seen += 1
            if not (page.parent / target).exists():
                missing.append(f"{page.relative_to(ROOT)}: {link}")
    assert seen > 5
    assert missing == []
