"""Questions on single frames: the reference decoder projects as OpenCV does, and what a decoder gets wrong is found."""

import random

import cv2
import numpy
import pytest
from fvv_conformance import cases, outputs, running
from fvv_conformance.questions import answer_differences, not_offered, questions_of, request_of
from reference import projection, questions, texturing
from reference.decode.lens import FISHEYE, RADTAN, radius

CASES = cases.load(cases.default_folder(), ["projection_*"])
WEIGHTS = cases.load(cases.default_folder(), ["weights_*"])
K = numpy.array([[500.0, 0, 320], [0, 480, 240], [0, 0, 1]])
POSE = (1.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0)


def opencv(lens, k, point):
    still = numpy.zeros(3)
    if lens == FISHEYE:
        return cv2.fisheye.projectPoints(numpy.array([[point]]), still, still, K, numpy.array(k[:4]))[
            0
        ].ravel()
    return cv2.projectPoints(numpy.array([point]), still, still, K, numpy.array(k))[0].ravel()


@pytest.mark.parametrize("lens", [RADTAN, FISHEYE])
def test_the_reference_projects_as_opencv_does(lens):
    rng, compared = random.Random(lens), 0
    for _ in range(100):
        if lens == RADTAN:
            k = [rng.uniform(-0.1, 0.1) * (0.1 if i in (2, 3) else 1) for i in range(8)]
        else:
            k = [rng.uniform(-0.02, 0.02) for _ in range(4)] + [0.0] * 4
        r_max = min(0.8 * radius(lens, k), 1.0)
        numbers = (500.0, 480.0, 320.0, 240.0, 0.0, *k, r_max, *POSE)
        point = [rng.uniform(-0.7, 0.7), rng.uniform(-0.7, 0.7), 1.0]
        pixel = projection.project(lens, numbers, point)
        if pixel is None:
            continue
        compared += 1
        assert pixel == pytest.approx(opencv(lens, k, point), abs=1e-9)
        assert projection.unproject(lens, numbers, pixel) == pytest.approx(point, abs=1e-8)
    assert compared > 50


def differences(wanted=CASES):
    """By case, what the reference decoder answers wrongly."""
    out = {}
    for case in wanted:
        for row in questions_of(case, questions.ANSWERS):
            answer = questions.ANSWERS[row["op"]](case.content, request_of(case, row))
            out.setdefault(case.name, []).extend(answer_differences(row, answer))
    return out


def test_the_reference_answers_every_question():
    found = differences(CASES + WEIGHTS)
    assert len(found) == len(CASES) + len(WEIGHTS) >= 19
    assert not any(found.values())


@pytest.mark.parametrize("index", range(8))
@pytest.mark.parametrize("factor", [0, -1])
def test_a_coefficient_that_is_ignored_or_of_the_wrong_sign_is_found(monkeypatch, index, factor):
    right = projection.pixel_of

    def wrong(lens, numbers, x, y):
        numbers = list(numbers)
        numbers[5 + index] *= factor
        return right(lens, numbers, x, y)

    monkeypatch.setattr(projection, "pixel_of", wrong)
    found = {name for name, lines in differences().items() if lines}
    assert "valid/projection_radtan_each" in found
    assert ("valid/projection_fisheye_each" in found) == (index < 4)


def rules():
    """Changes of the rule of clause 17.5, each with a case that shows it."""

    def of_sight(**changes):
        def change(weight_of):
            return lambda rule, sight: weight_of(
                rule, sight._replace(**{name: make(sight) for name, make in changes.items()})
            )

        return change

    def of_rule(**changes):
        return lambda weight_of: lambda rule, sight: weight_of(rule._replace(**changes), sight)

    return {
        "without the border of tiles": (of_sight(border=lambda s: 100.0), "default"),
        "a border of 7.5 pixels": (of_sight(border=lambda s: s.border + s.border / 15), "default"),
        "without the viewer": (of_sight(direction=lambda s: 0.0), "default"),
        "without visibility": (of_sight(seen=lambda s: 255.0), "visibility"),
        "visibility is all or none": (of_sight(seen=lambda s: 255.0 * (s.seen >= 127.5)), "visibility"),
        "visibility from 128 on": (of_sight(seen=lambda s: 0.0 if s.seen < 170 else s.seen), "blend_1"),
        "the default threshold": (of_rule(threshold=0.05), "threshold"),
        "the other blend": (of_rule(blend=0), "blend_1"),
    }


@pytest.mark.parametrize("name", rules())
def test_another_rule_for_weights_is_found(monkeypatch, name):
    change, case = rules()[name]
    monkeypatch.setattr(texturing, "weight_of", change(texturing.weight_of))
    wanted = [one for one in WEIGHTS if one.name == f"valid/weights_{case}"]
    assert any(differences(wanted).values())


def test_a_place_of_pictures_without_the_inset_is_found(monkeypatch):
    monkeypatch.setattr(texturing, "place", lambda rule, point, normal, viewer: point)
    wanted = [one for one in WEIGHTS if one.name == "valid/weights_inset"]
    assert any(differences(wanted).values())


def test_answers_of_another_form_are_differences():
    row = {"op": "project", "frame": 0, "camera": 1, "points": [[0, 0, 1]] * 2, "pixels": [[1.0, 2.0], None]}
    assert answer_differences(row, {"pixels": [[1.0, 2.0000001], None]}) == []
    assert "expected [1.0, 2.0]" in answer_differences(row, {"pixels": [[1.0, 2.1], None]})[0]
    for wrong in ([[1.0, 2.0]], [None, None], [[1.0, 2.0], [3.0, 4.0]], [[1.0], None], ["a", None], None):
        assert answer_differences(row, {"pixels": wrong}), wrong
    assert answer_differences(row, "died")
    weights = {"op": "weigh", "frame": 0, "mesh": 1, "places": [{}], "weights": [{"3": 0.25, "5": 0.75}]}
    assert answer_differences(weights, {"weights": [{"3": 0.25, "5": 0.75, "6": 0}]}) == []
    assert answer_differences(weights, {"weights": [{"3": 0.25, "6": 0.75}]})
    assert answer_differences(weights, {"weights": [[0.25, 0.75]]})
    ray = {"op": "unproject", "frame": 0, "camera": 1, "pixels": [[1, 2]], "rays": [[0.5, 0.25, 1.0]]}
    assert answer_differences(ray, {"rays": [[1.0, 0.5, 2.0]]}) == []
    assert answer_differences(ray, {"rays": [[0.5, 0.25, 0]]})


def test_a_program_without_reports_is_asked_its_questions_alone():
    case = WEIGHTS[0]
    assert [r["op"] for r in running.requests_for(case, {"weigh", "render"})] == ["weigh"]
    assert list(running.requests_for(CASES[0], {"weigh"})) == []
    assert [r.get("op") for r in running.requests_for(case, {"mesh", "weigh"})] == [None, "weigh"]


def test_what_a_decoder_does_not_offer_is_printed(capsys):
    lines = list(not_offered(CASES, {"mesh", "project"}))
    assert len(lines) == 1
    assert lines[0].startswith("unproject: not offered, ")
    tested = running.Tested("one", "1", "0.2", ["mesh"], [], 0.0, tuple(lines))
    outputs.print_result(running.as_json([tested], CASES))
    assert "one: unproject: not offered" in capsys.readouterr().out
