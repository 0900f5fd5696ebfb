"""Arithmetic of charts: Pareto lines, knees, BD-rates, exponents of growth."""

import math

import numpy as np


def pareto(points):
    """Of (cost, error) pairs those that no other beats in both, by cost."""
    out, best = [], math.inf
    for cost, error in sorted(points):
        if error < best:
            out.append((cost, error))
            best = error
    return out


def slopes(x, y):
    """Slopes of a piecewise cubic that is monotone where the data are (Fritsch and Carlson 1980; ends: three-point)."""
    step, rise = np.diff(x), np.diff(y) / np.diff(x)
    if len(x) == 2:
        return np.repeat(rise, 2)
    out = np.zeros(len(x))
    for i in range(1, len(x) - 1):
        if rise[i - 1] * rise[i] > 0:
            a, b = 2 * step[i] + step[i - 1], step[i] + 2 * step[i - 1]
            out[i] = (a + b) / (a / rise[i - 1] + b / rise[i])
    for end, near, far in (0, 0, 1), (-1, -1, -2):
        slope = ((2 * step[near] + step[far]) * rise[near] - step[near] * rise[far]) / (
            step[near] + step[far]
        )
        if slope * rise[near] <= 0:
            slope = 0
        elif rise[near] * rise[far] <= 0 and abs(slope) > 3 * abs(rise[near]):
            slope = 3 * rise[near]
        out[end] = slope
    return out


def mean_of_cubic(x, y, low, high):
    """The mean over low to high of the piecewise cubic through the points; x rises."""
    slope = slopes(x, y)
    total = 0.0
    for i in range(len(x) - 1):
        a, b = max(low, x[i]), min(high, x[i + 1])
        if a >= b:
            continue
        step = x[i + 1] - x[i]

        def value(at, i=i, step=step):
            t = (at - x[i]) / step
            return (
                (2 * t**3 - 3 * t**2 + 1) * y[i]
                + (t**3 - 2 * t**2 + t) * step * slope[i]
                + (3 * t**2 - 2 * t**3) * y[i + 1]
                + (t**3 - t**2) * step * slope[i + 1]
            )

        total += (b - a) / 6 * (value(a) + 4 * value((a + b) / 2) + value(b))  # exact for cubics
    return total / (high - low)


def bd_rate(reference, other):
    """Bytes of other over those of reference at the same quality, minus 1, in percent (Bjontegaard 2001).

    Both are [(bytes, quality in dB)]. Piecewise cubic over quality of the logarithm of bytes; None where the qualities
    overlap by less than a quarter of the smaller range, because nothing is extrapolated.
    """
    curves = []
    for points in (reference, other):
        best = {}
        for size, quality in points:
            best[quality] = min(size, best.get(quality, math.inf))
        quality = np.array(sorted(best))
        curves.append((quality, np.log([best[q] for q in quality])))
    if min(len(q) for q, _ in curves) < 2:
        return None
    low = max(q[0] for q, _ in curves)
    high = min(q[-1] for q, _ in curves)
    if high - low < 0.25 * min(q[-1] - q[0] for q, _ in curves):
        return None
    first, second = (mean_of_cubic(q, size, low, high) for q, size in curves)
    return 100 * (math.exp(second - first) - 1)


def exponent(x, y):
    """p of the power law y = c x^p that fits best, and its R^2, on logarithms."""
    x, y = np.log(np.asarray(x, float)), np.log(np.asarray(y, float))
    slope, offset = np.polyfit(x, y, 1)
    left = ((y - slope * x - offset) ** 2).sum()
    spread = ((y - y.mean()) ** 2).sum()
    return float(slope), float(1 - left / spread) if spread > 0 else 1.0


def knee(rows, cost, quality, loss=0.1):
    """Of rows the cheapest whose quality is at most loss below the best of all."""
    best = max(row[quality] for row in rows)
    return min((row for row in rows if row[quality] >= best - loss), key=lambda row: row[cost])
