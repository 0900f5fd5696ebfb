"""fvv.analysis on the cases of @fvv/analysis (tests/analysis/cases.json), and on a stream of fvvmux."""

import json
import math
import types

import fvv
import numpy
import pytest
from conftest import ROOT
from fvv import analysis

CASES = json.loads((ROOT / "tests/analysis/cases.json").read_text())
MEASURES = CASES["measures"]
STEP = 0.25  # of which all coordinates of the cases are multiples


def mesh_of(name, track=0):
    case = CASES["meshes"][name]
    lattice = numpy.array(case["points"]) / STEP
    assert (lattice == lattice.round()).all()
    return types.SimpleNamespace(
        track=track,
        origin=numpy.array(case["origin"]),
        step=STEP,
        lattice=lattice.astype(numpy.int32),
        indices=numpy.array(case["faces"], numpy.uint32),
    )


def frame_of(names, metadata=()):
    cameras = {c["id"]: fvv.Camera(c["id"], c["K"], c["R"], c["t"], c["size"]) for c in CASES["cameras"]}
    pictures = {
        i: types.SimpleNamespace(pixels=numpy.zeros((c.height, c.width, 3)), source=(0, 0, c.width, c.height))
        for i, c in cameras.items()
    }
    return types.SimpleNamespace(
        ticks=7,
        number=2,
        meshes={track: mesh_of(name, track) for track, name in enumerate(names)},
        cameras=cameras,
        pictures=pictures,
        _description=types.SimpleNamespace(metadata=metadata, up="+y"),
    )


def near(found, expected, tolerance=2e-9):
    return numpy.allclose(found, expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize("case", CASES["picks"], ids=lambda case: case["name"])
def test_picks(case):
    found = analysis.pick(frame_of(case["meshes"]), case["ray"]["origin"], case["ray"]["direction"])
    expected = case["expected"]
    if expected is None:
        assert found is None
        return
    named = (found.time, found.frame, found.track, found.face, found.camera, found.object, found.touching)
    assert named == (7, 2, expected["track"], expected["face"], expected["camera"], None, ())
    assert near(found.position, expected["position"]) and near(found.normal, expected["normal"])
    assert near(found.barycentric, expected["barycentric"]) and near(found.distance, expected["distance"])


@pytest.mark.parametrize(("origin", "direction"), [([0, 0, 0], [0, 0, 0]), ([0, math.nan, 0], [1, 0, 0])])
def test_a_ray_without_a_direction_is_refused(origin, direction):
    with pytest.raises(fvv.UsageError, match="pick: expected a ray of finite numbers"):
        analysis.pick(frame_of(["box"]), origin, direction)


def test_pieces():
    for case in CASES["pieces"]:
        found = analysis.pieces(frame_of([case["mesh"]]))
        assert len(found) == len(case["pieces"])
        for number, (one, expected) in enumerate(zip(found, case["pieces"])):
            assert [case["of_faces"][face] for face in one.faces] == [number] * expected["faces"]
            assert near(one.centre, expected["centre"]) and one.objects == ()
            assert near([one.area, one.radius], [expected["area"], expected["radius"]])


def test_paths_of_objects():
    paths = analysis.ObjectPaths(CASES["objects"]["value"])
    assert paths.names == {one["id"]: one["name"] for one in CASES["objects"]["list"]}
    assert (paths.find("ball"), paths.find("umpire")) == (9, None)
    for case in CASES["objects"]["centres"]:
        found = paths.centre(case["id"], case["time"])
        assert (found is None) == (case["expected"] is None), case
        assert found is None or near(found, case["expected"])
    for case in CASES["objects"]["pieces"]:
        assert list(paths.at(case["centre"], case["time"])) == case["expected"], case["name"]
    with pytest.raises(KeyError):
        paths.centre(5, 0)


@pytest.mark.parametrize("case", CASES["objects"]["paths"])
def test_points_of_a_path(case):
    texts = [
        json.dumps({"objects": CASES["objects"]["value"]}),
        json.dumps({"mesh_error": case["mesh_error"]}),
    ]
    found = analysis.path(frame_of(["box"], texts), case["id"])
    assert list(found) == [one["time"] for one in case["expected"]]
    for one, point in zip(case["expected"], found.values()):
        assert (point is None) == (one["position"] is None)
        assert point is None or near(point.position, one["position"])
        assert point is None or near(point.uncertainty, case["uncertainty"])
    assert analysis.path(frame_of(["box"]), 9) == {}


def test_what_is_not_as_the_registry_says_is_ignored():
    good = json.dumps({"objects": CASES["objects"]["value"]})
    assert analysis.ObjectPaths.of(['{"name":"x"}', "{", good]) is not None
    for value in CASES["objects"]["refused"]:
        assert analysis.ObjectPaths.of([json.dumps({"objects": value})]) is None, value
    assert analysis.ObjectPaths.of(["null", "[]", "{"]) is None


def point(case):
    return analysis.Point(case["position"], case["uncertainty"])


def same(found, expected, tolerance=1e-7):
    if found is None or expected is None:
        return found is expected
    return near([found.value, found.uncertainty], [expected["value"], expected["uncertainty"]], tolerance)


def test_distances_angles_and_heights():
    for case in MEASURES["distances"]:
        assert same(analysis.distance(point(case["a"]), point(case["b"])), case["expected"])
    for case in MEASURES["angles"]:
        assert same(
            analysis.angle(point(case["at"]), point(case["a"]), point(case["b"])), case["expected"], 1e-5
        )
    for case in MEASURES["heights"]:
        floor = analysis.Floor(
            numpy.array(case["floor"]["up"]), case["floor"]["level"], case["floor"]["uncertainty"]
        )
        assert same(analysis.height(point(case["point"]), floor), case["expected"])


@pytest.mark.parametrize("case", MEASURES["motions"], ids=lambda case: case["name"])
def test_motion(case):
    found = analysis.motion([one and (one["seconds"], point(one)) for one in case["samples"]])
    assert len(found) == len(case["expected"])
    for one, expected in zip(found, case["expected"]):
        assert (one is None) == (expected is None)
        if one is not None:
            assert near(one.seconds, expected["seconds"]) and near(one.velocity, expected["velocity"], 1e-4)
            assert same(one.speed, expected["speed"], 1e-4)
            assert same(one.acceleration, expected["acceleration"], 1e-4)


def test_motion_asks_for_enough_samples():
    with pytest.raises(fvv.UsageError, match="around: expected an integer of 2 or more, found 1"):
        analysis.motion([], 1)


def test_what_a_stream_says_of_its_meshes():
    for case in MEASURES["mesh_errors"]:
        found, expected = analysis.MeshError.of(case["texts"]), case["expected"]
        assert (found is None) == (expected is None)
        if found is not None:
            assert (found.vertex, found.pixels, found.metres) == tuple(expected.values())


@pytest.mark.parametrize("case", MEASURES["points"], ids=lambda case: case["name"])
def test_the_uncertainty_of_a_place(case):
    stated = case["mesh_error"]
    frame = frame_of(["box"], [json.dumps({"mesh_error": stated})] if stated else [])
    ray = MEASURES["rays"][case["ray"]]
    found = analysis.point(frame, analysis.pick(frame, ray["origin"], ray["direction"]), hull=case["hull"])
    assert (found is None) == (case["expected"] is None)
    assert found is None or near(found.uncertainty, case["expected"], 1e-9)


def test_a_packed_stream(tmp_path):
    """Two boxes, one of which falls: a stream that fvv.mux packs with names."""
    capture = tmp_path / "capture"
    capture.mkdir()
    box = numpy.array(CASES["meshes"]["box"]["points"], float)
    faces = numpy.array(CASES["meshes"]["box"]["faces"])
    height = [3 - 4.905 * (i / 25) ** 2 for i in range(10)]
    for i, up in enumerate(height):
        points = numpy.concatenate([box, box / 8 + [4, up, 0]])
        lines = ["v {:.6f} {:.6f} {:.6f}".format(*p) for p in points]
        lines += ["f {} {} {}".format(*f) for f in numpy.concatenate([faces, faces + 8]) + 1]
        (capture / f"{i:04d}.obj").write_text("\n".join(lines) + "\n")
    names = tmp_path / "names.json"
    names.write_text(json.dumps({"ball": {"frame": 0, "at": [4.125, 3.1, 0.25]}}))
    out = tmp_path / "out.fvv"
    fvv.mux(None, out, meshes=str(capture / "%04d.obj"), objects=str(names), max_error=0.001)
    samples = []
    with fvv.open(out) as clip:
        paths = analysis.ObjectPaths.of([json.dumps(one) for one in clip.metadata])
        ball = paths.find("ball")
        for frame, up in zip(clip, height):
            found = analysis.pick(frame, [4.125, up + 9, 0.25], [0, -1, 0])
            assert found.object == ball and abs(found.position[1] - up - 0.125) < 0.001
            place = analysis.centre(frame, ball)
            assert abs(place.position[1] - up - 0.0625) < place.uncertainty
            samples.append((frame.time, place))
    speeds = analysis.motion(samples)
    assert [one is None for one in speeds] == [True] * 2 + [False] * 6 + [True] * 2
    for time, one in zip([i / 25 for i in range(10)], speeds):
        if one is not None:
            assert abs(one.speed.value - 9.81 * time) <= one.speed.uncertainty
            assert one.speed.uncertainty < 0.2
