"""The cases of conformance/cases: their files are those of the generator, every rule has a case, and fvvinfo agrees."""

import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys

import jsonschema
import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
CASES = ROOT / "conformance/cases"
TOOLS = pathlib.Path(os.environ["FVV_TOOLS_DIR"])
FOLDERS = sorted(path for tier in ("valid", "uncommon", "faulty") for path in (CASES / tier).iterdir())
MOST_BYTES = 12_000_000


def load(path):
    return json.loads(path.read_text())


def generate(*arguments):
    command = [sys.executable, ROOT / "conformance/generate.py", *arguments]
    return subprocess.run(command, capture_output=True, text=True)


@pytest.mark.long
def test_files_are_those_of_the_generator():
    done = generate("--check")
    assert done.returncode == 0, done.stderr


@pytest.mark.long
def test_every_rule_has_a_case():
    done = generate("--coverage")
    assert done.returncode == 0, done.stdout
    report = json.loads(done.stdout)
    assert report["percent"] == 100
    counts = report["cases"]
    assert counts["valid"] + counts["uncommon"] >= 200
    assert counts["faulty"] >= 200


def test_two_files_a_case():
    assert len(FOLDERS) > 1000
    assert {tuple(sorted(path.name for path in folder.iterdir())) for folder in FOLDERS} == {
        ("expected.json", "input.fvv")
    }


def test_sizes():
    files = [path for folder in FOLDERS for path in folder.iterdir()]
    assert sum(path.stat().st_size for path in files) < MOST_BYTES
    assert max(path.stat().st_size for path in files) < 1 << 16


@pytest.mark.long
def test_schema():
    schema = load(ROOT / "conformance/case.schema.json")
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    for folder in FOLDERS:
        found = [error.message for error in validator.iter_errors(load(folder / "expected.json"))]
        assert not found, f"{folder.name}: {found[0]}"


@pytest.mark.long
def test_a_wrong_file_is_found(tmp_path):
    # In a copy: other tests read the cases meanwhile.
    for part in (
        "conformance/generate",
        "conformance/reference",
        "conformance/cases/valid/mesh_raw_triangle",
        "spec",
    ):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    program = tmp_path / "conformance/generate.py"
    shutil.copy(ROOT / "conformance/generate.py", program)
    path = tmp_path / "conformance/cases/valid/mesh_raw_triangle/expected.json"
    command = [sys.executable, program, "--check", "mesh_raw_triangle"]
    assert subprocess.run(command, capture_output=True).returncode == 0
    good = path.read_bytes()
    path.write_bytes(good.replace(b'"whole"', b'"wrong"'))
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1
    assert "valid/mesh_raw_triangle/expected.json" in done.stderr


def reports():
    """What fvvinfo finds in each input, by the folder."""
    out = {}
    for first in range(0, len(FOLDERS), 200):
        part = [str(folder / "input.fvv") for folder in FOLDERS[first : first + 200]]
        command = [TOOLS / "fvvinfo/fvvinfo", "--check", "--json", *part]
        files = json.loads(subprocess.run(command, capture_output=True, text=True).stdout)["files"]
        out |= {pathlib.Path(file["name"]).parent: file for file in files}
    return out


def chunk_end(data, offset):
    """The end of the chunk at an offset, or of the stream."""
    if offset < 24 or offset + 32 > len(data):
        return len(data)
    size = struct.unpack_from("<Q", data, offset + 16)[0]
    return min(offset + 32 + (size + 7) // 8 * 8, len(data))


def test_fvvinfo_agrees():
    found = reports()
    wrong = []
    for folder in FOLDERS:
        file, expected = found[folder], load(folder / "expected.json")
        problems = [(problem.get("issue"), problem["offset"]) for problem in file["problems"]]
        if not expected["issues"]:
            good = not problems and file["integrity"] in ("complete", "truncated")
        else:
            first = expected["issues"][0]
            end = chunk_end((folder / "input.fvv").read_bytes(), first["offset"])
            good = (
                bool(problems)
                and problems[0][0] == first["issue"]
                and first["offset"] <= problems[0][1] <= end
            )
        if not good:
            wrong.append(
                f"{folder.name}: {expected['issues']}, fvvinfo has {problems[:2]} {file['integrity']}"
            )
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("tier", ["valid", "uncommon", "faulty"])
def test_names(tier):
    for folder in (CASES / tier).iterdir():
        case = load(folder / "expected.json")
        assert case["name"] == folder.name
        assert ("rules" in case) >= (tier == "faulty")
