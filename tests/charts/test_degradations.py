"""What the stability sheets do to captures and streams is what they say."""

import math
import pathlib

import numpy as np
import pytest
from charts import degradations
from PIL import Image

TINY = pathlib.Path(__file__).resolve().parent.parent.parent / "conformance/tiny"


def test_a_rotation_turns_by_its_angle_about_its_axis():
    turn = degradations.rotation_by((0, 0, 2), math.pi / 2)
    assert turn @ (1, 0, 0) == pytest.approx([0, 1, 0])
    assert turn @ (0, 0, 1) == pytest.approx([0, 0, 1])
    assert np.trace(degradations.rotation_by((1, 2, 3), 0.3)) == pytest.approx(1 + 2 * math.cos(0.3))


@pytest.mark.parametrize("direction", [0, 1, 4])
def test_a_turned_camera_stays_in_its_place_and_moves_its_picture(direction):
    camera = {
        "intrinsics": {"fx": 400.0},
        "rotation": degradations.rotation_by((1, 1, 0), 0.4).tolist(),
        "translation": [1.0, 2.0, 3.0],
    }
    rotation, translation = degradations.turned(camera, 2.5, direction)
    centre = degradations.centre_of(camera)
    assert degradations.centre_of({"rotation": rotation, "translation": translation}) == pytest.approx(centre)
    # What was in the middle of the picture.
    ahead = np.array(rotation) @ (centre + np.array(camera["rotation"])[2]) + translation
    assert 400 * ahead[:2] / ahead[2] == pytest.approx([2.5 * math.cos(direction), 2.5 * math.sin(direction)])


def test_degrees_between_directions():
    assert degradations.degrees_between((1, 0, 0), (0, 3, 0)) == pytest.approx(90)
    assert degradations.degrees_between((1, 1, 0), (2, 2, 0)) == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize("pixels, side", [(0, 5), (1, 7), (2, 9), (-1, 3), (-2, 1), (-3, 0)])
def test_masks_grow_and_shrink_by_pixels(pixels, side):
    mask = np.zeros((21, 21), np.uint8)
    mask[8:13, 8:13] = 255
    assert (np.asarray(degradations.grown(Image.fromarray(mask), pixels)) > 0).sum() == side**2


def test_chunks_cover_a_stream():
    stream = (TINY / "tetrahedron.fvv").read_bytes()
    found = list(degradations.chunks(stream))
    assert [kind for kind, _, _ in found][:1] == [b"SCEN"]
    assert [kind for kind, _, _ in found][-2:] == [b"INDX", b"FOOT"]
    assert found[0][1] == 24 and found[-1][2] == len(stream)
    assert all(a[2] == b[1] for a, b in zip(found, found[1:]))


def test_losses_are_chunks_of_groups():
    stream = (TINY / "tetrahedron.fvv").read_bytes()
    same, lost = degradations.with_losses(stream, 0, np.random.default_rng(1))
    assert (same, lost) == (stream, 0)
    rest, lost = degradations.with_losses(stream, 1, np.random.default_rng(1))
    kinds = [kind for kind, _, _ in degradations.chunks(stream)]
    assert [kind for kind, _, _ in degradations.chunks(rest)] == [
        k for k in kinds if k not in degradations.GROUP_TYPES
    ]
    assert lost == sum(kind in degradations.GROUP_TYPES for kind in kinds)


def test_a_plate_is_closed_and_has_its_volume():
    vertices, faces = degradations.plate(2, 0.5, 3)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(2 * 2 * 0.5)
    edges = {(int(f[k]), int(f[(k + 1) % 3])) for f in faces for k in range(3)}
    assert len(edges) == 3 * len(faces) and all((y, x) in edges for x, y in edges)


def test_pieces_are_counted_without_stray_vertices():
    faces = np.array([(0, 1, 2), (2, 1, 3), (4, 5, 6), (9, 8, 10)])
    assert degradations.pieces(faces, 11) == 3
    chain = np.array([(i, i + 1, i + 2) for i in range(50)])
    assert degradations.pieces(chain[::-1], 52) == 1
