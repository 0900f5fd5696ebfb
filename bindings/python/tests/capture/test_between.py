"""Silhouettes between two pictures."""

import json

import cv2
import numpy
import pytest
from fvv_capture import footage, pipeline


def disc(x, y=40, radius=14, size=(80, 120)):
    out = numpy.zeros(size, numpy.uint8)
    cv2.circle(out, (round(x), y), radius, 255, -1)
    return out


@pytest.fixture
def moving(tmp_path):
    """A disc that moves by 8 pixels a frame, as masks and pictures of two cameras."""
    entries = []
    for name in ("a", "b"):
        for kind in ("pictures", "masks"):
            (tmp_path / kind / name).mkdir(parents=True)
            for n in range(5):
                cv2.imwrite(str(tmp_path / kind / name / f"{n:04d}.png"), disc(30 + 8 * n))
        recording = footage.find(tmp_path / "pictures")[name]
        entry = {**footage.camera_of(recording), "id": len(entries), "name": name}
        for kind in ("pictures", "masks"):
            entry[kind] = str(tmp_path / kind / name / "%04d.png")
        entries.append(entry)
    head = {"fvv_capture": 1, "frame_rate": "25", "frames": {"first": 0, "count": 5}, "units": "metres"}
    return json.dumps({**head, "cameras": entries})


def shown(description, frame, late):
    work = pipeline.Work(description, "", (None, None), pipeline.Options(), late=late)
    cameras, _, masks = pipeline.keys_of(work, frame)
    return masks, pipeline.silhouettes(work, frame, cameras, masks)


@pytest.mark.parametrize("part", [-0.5, -0.25, 0.25, 0.45])
def test_a_silhouette_moves_to_the_time_of_the_frame(moving, part):
    masks, found = shown(moving, 2, (part, 0.0))
    wanted = disc(30 + 8 * (2 + part))
    both = [(found[0] & wanted).sum() / (found[0] | wanted).sum() for found in (found, masks)]
    assert both[0] > 0.9
    assert both[0] > both[1]
    # That of a camera whose picture is of that moment, and of one that is late by nearly nothing, stays.
    assert found[1] is masks[1]
    assert shown(moving, 2, (0.04, 0.0))[1][0] is not None
    assert (shown(moving, 2, (0.04, 0.0))[1][0] == masks[0]).all()


def test_the_first_and_the_last_frame_have_no_neighbour_on_one_side(moving):
    for frame, part in ((0, -0.4), (4, 0.4)):
        masks, found = shown(moving, frame, (part, part))
        assert all((a == b).all() for a, b in zip(masks, found))
