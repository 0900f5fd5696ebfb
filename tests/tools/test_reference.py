"""The readers of conformance/reference and the vectors: listings agree, vectors use what their clauses have, fvvinfo reads them."""

import itertools
import math
import subprocess
import sys

import pytest
from conftest import CONFORMANCE, figures, run
from real_capture import read_ply
from reference import (
    calibration,
    colours,
    container,
    environment,
    mesh,
    mesh_delta,
    mesh_fast,
    normals,
    texturing,
    tiles,
    visibility,
)
from vectors import LISTINGS, name_of, names
from vectors import path_of as vector

VECTORS = [vector(name) for name in names()]


def stream(name):
    return vector(name).read_bytes()


def listed(name, suffix=".crc"):
    return (LISTINGS / f"{name}{suffix}").read_text().splitlines()


def test_vectors_and_listings_are_what_the_reference_makes():
    done = subprocess.run(
        [sys.executable, CONFORMANCE / "vectors.py", "--check"], capture_output=True, text=True
    )
    assert (done.stderr, done.returncode) == ("", 0)


@pytest.mark.parametrize("path", VECTORS, ids=name_of)
def test_the_reference_writes_the_same_container(path):
    content = path.read_bytes()
    assert container.rewritten(content) == content


def test_every_vector_has_a_listing():
    with_listing = {name_of(path) for path in VECTORS if not name_of(path).startswith("tiny_")}
    assert len(with_listing) == 15
    assert sorted(path.stem for path in LISTINGS.iterdir() if path.suffix != ".md") == sorted(with_listing)


@pytest.mark.parametrize(
    "name, distinct",
    [
        ("audio_two_sounds", 19),
        ("calibration_moving", 38),
        ("delta_field", 6),  # the fourth frame does not move
        ("delta_stencils", 6),
        ("fast_shapes", 4),
        ("normals_cube", 10),
        ("openexr_bars", 3),
        ("visibility_moving", 5),
        ("visibility_weights", 5),
        ("visibility_sheet", 10),
        ("texturing_explicit", 2),
        ("texturing_default", 2),
    ],
)
def test_lines_of_a_listing_differ(name, distinct):
    suffix = ".txt" if name.startswith(("audio", "texturing")) else ".crc"
    assert len(set(listed(name, suffix))) == distinct


@pytest.mark.parametrize("path", VECTORS, ids=name_of)
def test_fvvinfo_finds_every_frame_whole(path):
    (file,) = figures("fvvinfo", "--check", path)["files"]
    assert (file["integrity"], file["whole_frames"]) == ("complete", file["frames"])


def info(name):
    return figures("fvvinfo", "--check", vector(name))["files"][0]


def text(name):
    return run("fvvinfo", vector(name)).stdout


# Meshes.


def test_the_delta_vector_uses_what_the_profile_has():
    payloads = container.payloads(stream("delta_field"), b"MESH")
    key = mesh.read_raw(payloads[0])
    hierarchy = mesh_delta.Levels(key.positions, key.faces)
    assert len(hierarchy.levels) >= 4 and hierarchy.twins
    steps, sizes = set(), set()
    for payload in payloads[1:]:
        numbers = container.Numbers(payload, 18, 5101)
        for _ in hierarchy.levels:
            steps.add(numbers.next())
            sizes.add(numbers.next())
    assert steps == {4, 6, 9, 15} and 0 in sizes


def test_a_delta_vector_tells_readings_of_the_stencil_apart():
    key = mesh.read_raw(container.payloads(stream("delta_stencils"), b"MESH")[0])
    stencils = mesh_delta.Levels(key.positions, key.faces).stencils
    weighted = [[node for node, weight in stencil if weight] for stencil in stencils]
    first = [[node for node, weight in stencil[:4] if weight] for stencil in stencils]
    assert sum(nodes[:4] != around for nodes, around in zip(weighted, first)) == 48


def test_the_fast_vector_uses_what_the_profile_has():
    modes, codes, sizes = set(), set(), []
    for payload in container.payloads(stream("fast_shapes"), b"MESH"):
        vertices, faces = mesh_fast.streams(payload)
        modes.update(vertices.modes)
        codes.update(faces.codes)
        sizes.append((len(vertices.elements), bool(payload[1])))
    assert modes == {0, 1, 2, 3}
    assert {code & 15 for code in codes if code < 0xF0} == set(range(16))
    assert {code >> 4 for code in codes} == set(range(16))
    assert codes >= set(range(0xF0, 0x100))
    assert any(size > 256 for size, _ in sizes) and {textured for _, textured in sizes} == {False, True}


def test_fvvinfo_names_the_fast_profile():
    (track,) = info("fast_shapes")["tracks"]
    assert track["mesh"]["profiles"] == {"fast": {"chunks": 4, "bytes": track["bytes"]}}
    assert ": 4 fast of " in text("fast_shapes")


def test_fvvdemux_writes_fast_meshes_in_their_order(tmp_path):
    run("fvvdemux", vector("fast_shapes"), "-o", tmp_path / "out")
    payloads = container.payloads(stream("fast_shapes"), b"MESH")
    for number, decoded in enumerate(map(mesh_fast.decode, payloads)):
        positions, faces = read_ply(tmp_path / "out/meshes" / f"{number:04}.ply")
        assert (positions == [[0.001 * index for index in position] for position in decoded.positions]).all()
        assert (faces == decoded.faces).all()
    assert number == 3


def test_normals_have_length_1_or_0():
    lengths = {round(math.hypot(*n), 6) for n in itertools.chain(*normals.frames(stream("normals_cube")))}
    assert lengths == {0, 1}


@pytest.mark.parametrize("bits", [2, 3, 6])
def test_indices_of_normals_come_back_but_for_the_rim(bits):
    last = 2**bits - 2
    for pair in itertools.product(range(last + 1), repeat=2):
        again = normals.nearest(bits, normals.sent(bits, pair))
        assert again == pair or {0, last} & set(pair)
        assert normals.sent(bits, again) == pytest.approx(normals.sent(bits, pair), abs=1e-12)


def test_fvvinfo_reports_normals():
    (track,) = info("normals_cube")["tracks"]
    assert track["mesh"]["normals"] == {"chunks": 5, "bits": [9, 9]}
    assert "normals of 9 bits in 5 chunks" in text("normals_cube")


# Cameras.


def test_the_calibration_vector_uses_what_the_track_has():
    frames = list(calibration.decode(stream("calibration_moving")))
    assert {tuple(cameras) for _, cameras in frames} == {(2, 9, 300), (2, 300)}
    pans = [cameras[2]["rotation"] for _, cameras in frames]
    assert min(rotation[0] for rotation in pans) < -0.97  # about 180 degrees
    zooms = [cameras[300]["intrinsics"][0] for _, cameras in frames]
    assert max(zooms) > 7 * min(zooms)
    assert {cameras[2]["r_max"] for _, cameras in frames} == {1.5, float("inf")}


def test_fvvinfo_reports_cameras_that_move():
    file = info("calibration_moving")
    assert [camera["moves"] for camera in file["cameras"]] == [True] * 3
    track = file["tracks"][1]
    assert (track["kind"], track["chunks"], track["key_chunks"]) == ("calibration", 14, 2)


def test_the_tiles_vector_uses_what_clause_10_11_has():
    found = [by_track[2] for _, by_track in tiles.layouts(stream("tiles_crops"))]
    assert found[0] == found[3]
    assert len({str(layout) for layout in found}) == 4
    assert [camera for camera, *_ in found[2]] == [1]
    assert any(source[2:] != destination[2:] for layout in found for _, source, destination in layout)
    assert "3 layouts of groups" in text("tiles_crops")


def test_fvvinfo_counts_openexr_samples():
    (track,) = info("openexr_bars")["tracks"]
    assert track["chunks"] == 3


# Visibility and texturing.


def test_cameras_that_are_lost_have_no_weights():
    decoded = [states for _, states in visibility.decode(stream("visibility_moving"))]
    assert [sorted(states) for states in decoded] == [[2, 7, 9], [2, 7, 9], [2, 7], [2, 7, 9], [2, 7, 9]]
    # The sheet waves; cameras that move add to what turns.
    turned = [sum(bool(a) != bool(b) for a, b in zip(decoded[0][c], decoded[4][c])) for c in (2, 7, 9)]
    assert min(turned[1:]) > turned[0]


def test_the_visibility_vectors_use_what_clause_17_has():
    for name, tracks in ("sheet", {2, 3}), ("weights", {2}):
        decoded = list(visibility.decode(stream(f"visibility_{name}")))
        assert {track for track, _ in decoded} == tracks
        for _, states in decoded:
            assert sorted(states) == [2, 7, 300]
            assert len({tuple(row) for row in states.values()}) == 3
        assert {s for _, states in decoded for row in states.values() for s in row} == set(range(7))
    payloads = container.payloads(stream("visibility_sheet"), b"VISI")
    assert {(p[0], p[1]) for p in payloads} == {(0, 64), (0, 10)}
    assert [p[8] for p in payloads] == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4]


@pytest.mark.parametrize("name", ["sheet", "moving", "weights"])
def test_fvvinfo_names_visibility(name):
    assert "visibility" in text(f"visibility_{name}").lower()


def test_facing_is_decided_by_the_cosine():
    camera = [3000, -1000, 2500]
    for corners in ([0, 0, 0], [900, 40, 10], [30, 800, -20]), ([5, 5, 5], [6, 900, 70], [-700, 3, 400]):
        u, v, w = ([corners[i][a] - corners[0][a] for a in range(3)] for i in (1, 2, 0))
        n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        w = [camera[a] - sum(c[a] for c in corners) / 3 for a in range(3)]
        cosine = sum(map(math.prod, zip(n, w))) / math.hypot(*n) / math.hypot(*w)
        assert 0.1 < cosine < 0.99
        passes = [visibility.face_faces(corners, camera, t) for t in range(256)]
        assert abs(sum(passes) - 256 * cosine) < 2
        assert passes == sorted(passes, reverse=True)


def test_the_texturing_vectors_have_all_constants_and_none():
    explicit, default = (
        set(texturing.groups(stream(f"texturing_{name}"))) for name in ("explicit", "default")
    )
    assert default == {texturing.Texturing()}
    (constants,) = explicit
    assert all(a != b for a, b in zip(constants, texturing.Texturing()))
    assert info("texturing_explicit")["texturing"] == {
        **constants._asdict(),
        "unseen": list(constants.unseen),
        "blend": "paper",
    }
    assert "texturing" not in info("texturing_default")


def test_weights_are_those_of_clause_17_5():
    paper = texturing.Texturing(threshold=0.25, blend=1)
    sights = {i: texturing.Sight(facing) for i, facing in enumerate((0.5, 0.2, 1.0, 0.3, 0.7), 1)}
    assert texturing.weights(paper, sights) == pytest.approx({3: 1 / 2.2, 5: 0.7 / 2.2, 1: 0.5 / 2.2})
    assert texturing.weights(paper._replace(threshold=0.7, best=1), sights) == {3: 1}
    assert texturing.weights(paper, {2: texturing.Sight(0.2)}) is None


def test_the_worked_example_of_clause_17_5():
    viewer = texturing.Texturing(threshold=0.05, best=2)
    sights = {
        1: texturing.Sight(0.81, 0.99),
        2: texturing.Sight(0.525, 0.91, 170, 4.5),
        3: texturing.Sight(0.905, 0.51),
        4: texturing.Sight(0.05, 1.0),
    }
    singly = [round(texturing.weight_of(viewer, sight), 4) for sight in sights.values()]
    assert singly == [2000.0, 8.3333, 3.6, 0.0]
    assert texturing.weights(viewer, sights) == pytest.approx({1: 0.99763, 2: 0.00237}, abs=5e-6)


def test_the_surface_that_cameras_show_lies_inside_the_mesh():
    inset = texturing.Texturing(inset=0.01)
    point, normal = (1.0, 2.0, 3.0), (0.0, 0.0, 1.0)
    assert texturing.place(texturing.Texturing(), point, normal, (0, 0, 1)) == point
    assert texturing.place(inset, point, normal, (0, 0, 1)) == pytest.approx((1, 2, 2.99))
    # From 60 degrees on the way is 2 insets long.
    aslant = (math.sin(math.pi / 3), 0, 0.5)
    assert texturing.place(inset, point, normal, aslant) == pytest.approx((1 - 0.01 * math.sqrt(3), 2, 2.99))
    assert texturing.place(inset, point, normal, (1, 0, 0)) == pytest.approx((0.98, 2, 3))
    assert texturing.place(inset, point, normal, (0, 0, -1)) == pytest.approx((1, 2, 3.02))


def test_broken_rules_of_texturing_have_their_numbers():
    (good,) = set(container.payloads(stream("texturing_explicit"), b"TEXR"))
    assert texturing.decode(good + b"of a later version") == texturing.decode(good)
    for bad, issue in (
        (good[:39], 6101),
        (good[:39] + b"\1", 6101),
        (good[:36] + b"\2" + good[37:], 6102),
        (good[:32] + b"\0" + good[33:], 6102),
        (b"\0" * 6 + b"\xf8\x7f" + good[8:], 6102),
        (good[:24] + b"\0" * 6 + b"\xf0\xbf" + good[32:], 6102),
    ):
        with pytest.raises(container.Broken, match=f"FVV-{issue}"):
            texturing.decode(bad)


# Colours.


def test_the_colours_vector_uses_what_clause_19_has():
    decoded = [rgb for _, rgb in colours.decode(stream("colours_sheet"))]
    assert [rgb is None for rgb in decoded] == 2 * [False, False, False, True]
    assert decoded[0] == decoded[2] and decoded[0] != decoded[4]
    payloads = container.payloads(stream("colours_sheet"), b"COLR")
    assert [(p[0], p[1]) for p in payloads] == [(9, 20), (1, 3)]
    positions = mesh.read_raw(container.payloads(stream("colours_sheet"), b"MESH")[4]).positions
    cells = {colours.cell_of(p, 67) for p in positions}
    assert min(min(c) for c in cells) < 0 < max(max(c) for c in cells)
    assert any(not (set(colours.around(c)) - {c}) & cells for c in cells)


@pytest.mark.parametrize(
    "at, byte, issue", [(0, 0, 6201), (1, 65, 6201), (4, 1, 6202), (12, 1, 6203), (40, 7, 6204)]
)
def test_broken_rules_of_colours_have_their_numbers(at, byte, issue):
    positions = mesh.read_raw(container.payloads(stream("colours_sheet"), b"MESH")[0]).positions
    broken = bytearray(container.payloads(stream("colours_sheet"), b"COLR")[0])
    colours.decode_chunk(bytes(broken), positions)
    broken[at] = byte
    with pytest.raises(container.Broken, match=f"FVV-{issue}"):
        colours.decode_chunk(bytes(broken), positions)


def test_fvvinfo_reports_colours():
    (track,) = (t for t in info("colours_sheet")["tracks"] if t["kind"] == "colours")
    assert track["colours"]["cell_size"] == [50, 67]
    assert track["chunks"] == track["key_chunks"] == 2
    assert "cells of 0.05 to 0.067 m" in text("colours_sheet")


# Environment.


def test_the_environment_vector_has_each_type_of_light():
    assert sum(line.startswith("light") for line in listed("environment_stage", ".txt")) == 3


@pytest.mark.parametrize(
    "at, byte, issue",
    [(44, 1, 8001), (31, 0x80, 8002), (52, 9, 8005), (144, 2, 8007), (149, 9, 8006), (176, 3, 8008)],
)
def test_broken_rules_of_an_environment_have_their_numbers(at, byte, issue):
    broken = bytearray(container.payloads(stream("environment_stage"), b"BACK")[0])
    broken[at] = byte
    with pytest.raises(container.Broken, match=f"FVV-{issue}"):
        list(environment.lines(bytes(broken)))


def test_fvvinfo_reports_the_environment():
    (track,) = (t for t in info("environment_stage")["tracks"] if t["kind"] == "environment")
    assert track["environment"] == {"parts": 2, "vertices": 8, "triangles": 4, "pictures": 2, "lights": 3}
