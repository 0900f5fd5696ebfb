"""Cameras that do not agree with the others, and what happened to them: on a body whose masks are exact."""

import numpy
import pytest
import trimesh
from fvv import Camera
from fvv_capture import agreement, hull

NAMES = [f"cam{i}" for i in range(8)]
SIZE = (320, 240)
BOUNDS = ((-0.8, -0.1, -0.8), (0.8, 2.0, 0.8))
OPTIONS = hull.HullOptions(least_views=4)


def camera(number):
    """On a ring of 3.2 m around the body, turned to its middle; their heights differ."""
    angle = 2 * numpy.pi * number / len(NAMES)
    centre = numpy.array([3.2 * numpy.sin(angle), 1.0 + 0.25 * (number % 3), 3.2 * numpy.cos(angle)])
    forward = numpy.array([0.0, 0.9, 0.0]) - centre
    forward /= numpy.linalg.norm(forward)
    right = numpy.cross(forward, [0.0, 1.0, 0.0])
    right /= numpy.linalg.norm(right)
    rotation = numpy.array([right, numpy.cross(forward, right), forward])
    k = [[300, 0, SIZE[0] / 2], [0, 300, SIZE[1] / 2], [0, 0, 1]]
    return Camera(number, k, rotation, -rotation @ centre, SIZE, name=NAMES[number])


def body(time):
    """Somebody with an arm stretched out, who walks: no half turn or mirror leaves it as it is."""
    parts = [
        trimesh.creation.capsule(1.0, 0.18),
        trimesh.creation.icosphere(3, 0.14),
        trimesh.creation.capsule(0.5, 0.06),
        trimesh.creation.capsule(0.6, 0.08),
    ]
    upright = trimesh.transformations.rotation_matrix(numpy.pi / 2, [1, 0, 0])
    sideways = trimesh.transformations.rotation_matrix(-numpy.pi / 2, [0, 1, 0])
    for part, place in zip(parts, ([0, 1.4, 0], [0, 1.75, 0.05], [0.6, 1.3, 0.1], [-0.15, 0.6, 0.25])):
        part.apply_transform(sideways if place[0] > 0.5 else upright)
        part.apply_translation(numpy.array(place) + [0.06 * time, 0, 0.02 * time])
    return trimesh.util.concatenate(parts)


CAMERAS = [camera(i) for i in range(len(NAMES))]


def masks(time=0):
    made = body(time)
    return [hull.coverage(made.vertices, made.faces, one) for one in CAMERAS]


def doubts(of, moment=lambda index, by: None):
    found = agreement.find(CAMERAS, of, BOUNDS, OPTIONS, NAMES, moment)
    return {NAMES[d.camera]: d for d in found}


def shifted(mask, dx, dy):
    return numpy.roll(numpy.roll(mask, dx, axis=1), dy, axis=0)


@pytest.fixture(scope="module")
def exact():
    return masks()


def test_cameras_that_agree_are_not_doubted(exact):
    assert doubts(exact) == {}
    # Nor are outlines that noise has eaten, alike in all of them.
    random = numpy.random.default_rng(2)
    assert doubts([m * (random.random(m.shape) > 0.02) for m in exact]) == {}


@pytest.mark.parametrize("by", [(6, 0), (-5, 4), (0, -6)])
def test_a_camera_that_was_pushed_is_named_with_the_way(exact, by):
    exact = [*exact]
    exact[3] = shifted(exact[3], *by)
    found = doubts(exact)
    assert list(found) == ["cam3"]
    assert f"by about {by[0]:+d}, {by[1]:+d} pixels" in found["cam3"].cause
    assert found["cam3"].better > found["cam3"].iou + 0.1


@pytest.mark.parametrize(
    ("change", "said"),
    [(lambda m: m[::-1, ::-1], "upside down"), (lambda m: m[:, ::-1], "mirrored")],
)
def test_a_camera_that_was_turned_is_named_alone(exact, change, said):
    exact = [*exact]
    exact[2] = numpy.ascontiguousarray(change(exact[2]))
    found = doubts(exact)
    assert list(found) == ["cam2"]
    assert said in found["cam2"].cause


@pytest.mark.parametrize("suspects", [8, 4])
def test_recordings_that_were_swapped_are_both_named(exact, suspects, monkeypatch):
    monkeypatch.setattr(agreement, "SUSPECTS", suspects)
    exact = [*exact]
    exact[1], exact[4] = exact[4], exact[1]
    found = doubts(exact)
    assert {name: d.cause for name, d in found.items()} == {
        "cam1": "its recording is that of cam4",
        "cam4": "its recording is that of cam1",
    }
    said = agreement.sentences({5: list(found.values())}, NAMES)
    assert [text.split()[0] for text in said] == ["cam1", "cam4"]
    assert "in frame 5" in said[0]


@pytest.mark.parametrize("late", [-3, 4])
def test_an_offset_that_is_wrong_is_named_with_the_right_one(exact, late):
    exact = [*exact]
    exact[5] = masks(-late)[5]
    found = doubts(exact, lambda index, by: masks(by - late)[index])
    assert list(found) == ["cam5"]
    assert found["cam5"].cause == f"its offset is wrong by {late:+d} pictures"


def test_a_mask_with_a_hole_has_no_cause_but_is_named(exact):
    exact = [*exact]
    exact[6] = exact[6].copy()
    exact[6][110:150] = 0
    found = doubts(exact)
    assert list(found) == ["cam6"]
    assert found["cam6"].cause == ""
    assert "--exclude cam6" in agreement.sentences({0: list(found.values())}, NAMES)[0]


def test_few_cameras_and_none_say_nothing(exact):
    assert agreement.find(CAMERAS[:3], exact[:3], BOUNDS, OPTIONS, NAMES) == []
    nothing = [numpy.zeros(SIZE[::-1], numpy.uint8)] * len(NAMES)
    assert doubts(nothing) == {}
    assert agreement.find([None] * 8, [None] * 8, BOUNDS, OPTIONS, NAMES) == []


def without_arm(mask, arm):
    return numpy.where(arm, 0, mask).astype(numpy.uint8)


def test_what_a_key_dropped_comes_back_where_the_picture_has_changed(exact):
    """One camera takes an arm for a shadow. The others see it, and so does the picture."""
    hidden = body(0).split()[2]
    arm = hull.coverage(hidden.vertices, hidden.faces, CAMERAS[0]) > 0
    arm &= numpy.roll(arm, 12, axis=1)
    keyed = [without_arm(exact[0], arm), *exact[1:]]
    changed = [*exact]
    before = hull.silhouette_iou(*surface(keyed), CAMERAS, exact)
    more = agreement.dropped(CAMERAS, keyed, changed, BOUNDS, OPTIONS)
    after = agreement.added(keyed, more)
    assert (after[0][arm] > 0).mean() > 0.8  # cells are four pixels wide
    assert numpy.mean(hull.silhouette_iou(*surface(after), CAMERAS, exact)) > numpy.mean(before) + 0.01
    # A picture that is as the empty stage there is right: that is what cuts the hull.
    empty = [without_arm(exact[0], arm), *exact[1:]]
    more = agreement.dropped(CAMERAS, keyed, empty, BOUNDS, OPTIONS)
    assert not agreement.added(keyed, more)[0][arm].any()
    # Masks that were given are not changed.
    assert agreement.dropped(CAMERAS, keyed, [None] * 8, BOUNDS, OPTIONS) == [None] * 8


def test_a_shadow_on_the_ground_does_not_come_back(exact):
    """It changes every picture, and is in no mask."""
    ground = trimesh.creation.box((0.8, 0.01, 0.5))
    ground.apply_translation([-0.4, 0.0, 0.3])
    shadows = [hull.coverage(ground.vertices, ground.faces, one) > 0 for one in CAMERAS]
    changed = [numpy.where(shadow, 255, m).astype(numpy.uint8) for shadow, m in zip(shadows, exact)]
    more = agreement.added(exact, agreement.dropped(CAMERAS, exact, changed, BOUNDS, OPTIONS))
    extra = sum(int((m > 0).sum() - (e > 0).sum()) for m, e in zip(more, exact))
    assert extra < 0.06 * sum(int(s.sum()) for s in shadows)


def surface(of):
    made = hull.carve(CAMERAS, of, BOUNDS, hull.HullOptions(least_views=4, cell=0.02))
    return made.positions, made.indices
