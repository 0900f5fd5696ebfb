"""Distances between surfaces, on balls of which they are known."""

import mesh_only
import numpy as np
import pytest
import trimesh
from track import scenes, surface


def ball(radius, splits=4):
    return mesh_only.icosphere(splits, radius)


def test_subdivision_makes_four_faces_of_one_and_normals_point_out():
    vertices, faces = ball(1, 1)
    points, normals = surface.dense(vertices, faces, 1)
    assert len(points) == len(vertices) + len(faces) * 3 // 2
    assert ((points * normals).sum(1) > 0.8).all() and np.linalg.norm(normals, axis=1) == pytest.approx(1)


def test_d2_of_two_balls_and_of_an_offset():
    inner, outer = ball(1), ball(1.01)
    assert surface.d2(inner, outer) == pytest.approx(10 * np.log10(3 * 2**2 / 0.01**2), abs=0.1)
    assert surface.to_plane(inner[0], surface.dense(*outer)) == pytest.approx(-0.01, abs=0.001)


def test_flicker_is_change_and_not_distance():
    places = ball(1)[0]
    still, moving = surface.Flicker(), surface.Flicker()
    for i in range(4):
        still.add(places, ball(1.01))
        moving.add(places, ball(1.01 if i % 2 else 1.012))
    assert still.rms() == 0
    assert moving.rms() == pytest.approx(0.002, rel=0.05)


@pytest.mark.parametrize("scene", [scenes.touching_hands, scenes.opened_jacket])
def test_made_up_bodies_are_closed_and_share_no_vertices(scene):
    first, second = (trimesh.Trimesh(*mesh, process=False) for mesh in scenes.sequence(scene, 2))
    assert first.is_watertight and first.is_winding_consistent and 0.04 < first.volume < 0.08
    assert not set(map(tuple, first.vertices.round(6))) & set(map(tuple, second.vertices.round(6)))


def test_hands_that_touch_make_a_ring():
    apart, touching = (
        trimesh.Trimesh(*scenes.zero_level(*scenes.touching_hands(share)), process=False)
        for share in (0, 0.5)
    )
    assert (apart.euler_number, touching.euler_number) == (2, 0)
