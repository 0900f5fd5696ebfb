"""The arithmetic of charts, against figures computed by hand or by others."""

import math

import numpy as np
import pytest
from charts import numbers

# The example of the package bjontegaard on PyPI (1.3.0): rates in kbit/s and PSNR of two presets of an encoder, and its
# result with the method "pchip", which is that of the JCT-VC common test conditions.
ANCHOR = list(zip((9487.76, 4593.60, 2486.44, 1358.24), (40.037, 38.615, 36.845, 34.851)))
OTHER = list(zip((9787.80, 4469.00, 2451.52, 1356.24), (40.121, 38.651, 36.970, 34.987)))
PUBLISHED = -4.417485350589


def test_pareto_keeps_what_nothing_beats_in_both():
    points = [(3, 1.0), (1, 5.0), (2, 5.0), (2, 3.0), (4, 1.0), (5, 0.5)]
    assert numbers.pareto(points) == [(1, 5.0), (2, 3.0), (3, 1.0), (5, 0.5)]


def test_knee_is_the_cheapest_within_the_loss():
    rows = [{"b": 9, "q": 30.0}, {"b": 5, "q": 29.95}, {"b": 4, "q": 29.91}, {"b": 3, "q": 29.8}]
    assert numbers.knee(rows, "b", "q", 0.1)["b"] == 4
    assert numbers.knee(rows, "b", "q", 0.3)["b"] == 3
    assert numbers.knee(rows, "b", "q", 0)["b"] == 9


def test_exponent_of_a_power_law_and_of_noise_around_it():
    x = [1, 2, 5, 10, 50]
    assert numbers.exponent(x, [3 * v**1.5 for v in x]) == pytest.approx((1.5, 1))
    slope, fit = numbers.exponent(x, [v * f for v, f in zip(x, (1, 1.1, 0.9, 1.1, 1))])
    assert slope == pytest.approx(1, abs=0.05)
    assert 0.99 < fit < 1


def test_slopes_of_a_line_and_at_an_extreme():
    assert numbers.slopes(np.array([0.0, 1, 3]), np.array([0.0, 2, 6])) == pytest.approx([2, 2, 2])
    # Where neighbours rise and fall, the curve is flat and does not overshoot.
    assert numbers.slopes(np.array([0.0, 1, 2]), np.array([0.0, 1, 0]))[1] == 0


def test_mean_of_a_line_is_that_of_its_ends():
    x, y = np.array([1.0, 2, 4]), np.array([2.0, 4, 8])
    assert numbers.mean_of_cubic(x, y, 1.5, 3.5) == pytest.approx(5)


def test_bd_rate_by_hand():
    """Where all rates are multiplied by the same factor, that factor is the result."""
    assert numbers.bd_rate(ANCHOR, [(2 * r, q) for r, q in ANCHOR]) == pytest.approx(100)
    assert numbers.bd_rate(ANCHOR, [(r / 4, q) for r, q in ANCHOR]) == pytest.approx(-75)
    # Two lines of log rate over PSNR, ln r = q and ln r = q + 0.5 q / 10 over q in [0, 10]: the mean difference is 0.25.
    first = [(math.exp(q), q) for q in (0, 4, 10)]
    second = [(math.exp(1.05 * q), q) for q in (0, 7, 10)]
    assert numbers.bd_rate(first, second) == pytest.approx(100 * (math.exp(0.25) - 1))


def test_bd_rate_of_a_published_example():
    assert numbers.bd_rate(ANCHOR, OTHER) == pytest.approx(PUBLISHED, abs=1e-9)


def test_bd_rate_extrapolates_nothing():
    above = [(r, q + 4.5) for r, q in ANCHOR]  # 0.7 dB of 5.2 in common
    assert numbers.bd_rate(ANCHOR, above) is None
    assert numbers.bd_rate(ANCHOR, ANCHOR[:1]) is None
    # Points beyond the common range do not count: the curve between them does.
    longer = [(2 * r, q) for r, q in ANCHOR] + [(1e9, 60)]
    assert numbers.bd_rate(ANCHOR, longer) == pytest.approx(100, rel=0.02)
