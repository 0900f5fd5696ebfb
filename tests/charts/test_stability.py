"""Arithmetic of the stability sheets and of growth."""

import math

import numpy as np
import pytest
from charts import growth
from charts.stability import camera as stability_camera
from charts.stability import link as stability_link
from charts.stability import mesh as stability_mesh


def test_clicks_are_found_where_the_clock_of_the_recorder_puts_them(tmp_path):
    for ppm in 0, 100:
        samples = stability_link.clicks(ppm)
        expected = np.arange(1, stability_link.SOUND_SECONDS) * (1 + ppm / 1e6)
        found = stability_link.click_times(samples, expected)
        assert np.abs(found - expected).max() <= 0.5 / stability_link.SOUND_RATE + 1e-9
    stability_link.write_wave(tmp_path / "clicks.wav", samples)
    again = stability_link.decoded_sound(tmp_path / "clicks.wav")
    assert np.abs(again[: len(samples)] / 32768 - samples).max() < 1e-3


def test_a_frame_is_its_mesh_and_all_of_its_pictures(tmp_path):
    for name, content in {
        "meshes/0000.ply": "a",
        "cam0/0000.png": "b",
        "meshes/0001.ply": "a",
        "cam0/0001.png": "c",
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(content)
    found = stability_link.frames_of(tmp_path)
    assert set(found) == {0, 1} and found[0] != found[1] and len(found[0]) == 2


def test_a_renamed_mesh_is_the_same_surface():
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1.0)])
    faces = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])
    other, turned = stability_mesh.renamed((vertices, faces), np.random.default_rng(3))
    assert not np.array_equal(turned, faces)

    def corners(v, f):
        return sorted(sorted(map(tuple, triangle)) for triangle in v[f].tolist())

    assert corners(other, turned) == corners(vertices, faces)


def test_what_vanishes_silently_is_counted():
    rows = [
        {"radius_mm": 1, "kept_percent": 0, "kept_code": 3},
        {"radius_mm": 2, "kept_percent": 50, "kept_code": 0},
        {"radius_mm": 3, "kept_percent": 100, "kept_code": 0},
    ]
    assert stability_mesh.whole(rows, "kept") == "3"
    assert stability_mesh.silently(rows, "kept") == "without a warning in 1 of 2 cases"
    assert stability_mesh.silently(rows[2:] + rows[:1], "kept") == "with a warning in all 1 cases"


def test_a_rotation_vector_is_right_far_from_half_a_turn_and_wrong_near_it():
    def error(short):
        rotation = stability_camera.degradations.rotation_by((1, 2, 3), math.radians(180 - short))
        vector = stability_camera.rotation_vector(rotation)
        again = stability_camera.degradations.rotation_by(vector, np.linalg.norm(vector))
        return stability_camera.moved(again, rotation, 1000)

    assert error(90) < 1e-9
    assert error(1e-7) > 1


def test_super_linear_growth_is_named():
    rows = [{"x": x, **{cost: x for cost in growth.COSTS}, "mux_s": x**1.5} for x in (1, 2, 4, 8)]
    exponents = growth.exponents(rows)
    assert exponents["mux_s"]["end"] == pytest.approx(1.5) and exponents["bytes"]["all"] == pytest.approx(1)
    assert growth.super_linear({"exponents": {"frames": exponents}}) == [
        ("mux_s", "frames", pytest.approx(1.5))
    ]


def test_the_peak_of_a_tool_is_not_that_of_this_process(tmp_path):
    ballast = np.ones(60 << 20, np.uint8)  # 60 MiB that the tool does not have
    _, peak, _ = growth.run(
        "fvvsynth", "-o", tmp_path / "peak", "--frames", 1, "--size", "64x48", "--rig", "small", "--force"
    )
    assert 1 < peak < 60 and ballast.any()
