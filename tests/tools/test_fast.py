"""Fast meshes: the decoder that was written from the specification reads the vector, and the tools do."""

import json
import sys

import fast
from conftest import ROOT, Tool, tool_path

sys.path.insert(0, str(ROOT / "conformance/real"))
from real_capture import read_ply  # noqa: E402

VECTORS = ROOT / "conformance" / "fast"


def test_plain_decoder_gives_the_listed_meshes():
    wanted = (VECTORS / "shapes.crc").read_text().split()
    assert list(fast.mesh_crcs((VECTORS / "shapes.fvv").read_bytes())) == wanted
    assert len(set(wanted)) == 4


def test_vector_uses_what_the_profile_has():
    modes, codes, sizes = set(), set(), []
    for payload in fast.mesh_payloads((VECTORS / "shapes.fvv").read_bytes()):
        vertices, faces = fast.streams(payload)
        modes.update(vertices.modes)
        codes.update(faces.codes)
        sizes.append((len(vertices.elements), bool(payload[1])))
    assert modes == {0, 1, 2, 3}
    assert {code & 15 for code in codes if code < 0xF0} == set(range(16))
    assert {code >> 4 for code in codes} == set(range(16))
    assert codes >= set(range(0xF0, 0x100))
    assert any(size > 256 for size, _ in sizes) and {textured for _, textured in sizes} == {False, True}


def test_fvvinfo_finds_every_frame_whole_and_names_the_profile(fvvinfo):
    done = fvvinfo("--check", "--json", VECTORS / "shapes.fvv")
    assert (done.returncode, done.stderr) == (0, b"")
    report = json.loads(done.stdout)["files"][0]
    assert report["tracks"][0]["mesh"]["profiles"] == {
        "fast": {"chunks": 4, "bytes": report["tracks"][0]["bytes"]}
    }
    assert b": 4 fast of " in fvvinfo(VECTORS / "shapes.fvv").stdout


def test_fvvdemux_writes_the_meshes_in_their_order(tmp_path):
    path = tool_path("fvvdemux")
    assert path, "fvvdemux was not built"
    done = Tool(path)(VECTORS / "shapes.fvv", "-o", tmp_path / "out")
    assert (done.returncode, done.stderr) == (0, b"")
    stream = (VECTORS / "shapes.fvv").read_bytes()
    for number, mesh in enumerate(map(fast.decode, fast.mesh_payloads(stream))):
        positions, faces = read_ply(tmp_path / "out/meshes" / f"{number:04}.ply")
        assert (positions == [[0.001 * index for index in position] for position in mesh.positions]).all()
        assert (faces == mesh.faces).all()
    assert number == 3
