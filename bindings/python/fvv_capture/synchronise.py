"""When cameras began: offsets between recordings from sound, from flashes of light, or from motion.

Each recording gives a signal over time; pairs of signals are correlated, the peak is found between samples by a parabola, and
the offsets of all recordings are the least squares of the pairs' (as in Hasler et al., "Markerless motion capture with
unsynchronized moving cameras", CVPR 2009, who use sound alone).
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal

import numpy
from fvv import recordings
from fvv.errors import UsageError
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

from .opencv import named

cv2: Any = optional_import("cv2", "capture")
signal: Any = optional_import("scipy.signal", "capture")

Method = Literal["sound", "flash", "motion"]

#: Envelopes of sound have this many values a second: a quarter of a millisecond decides nothing, half a frame does.
ENVELOPE_RATE = 2000
#: By how much an onset exceeds the level before it at least, in logarithm: noise does so by less.
AUDIBLE = 0.7
#: The height of the small pictures that motion and flashes are measured in.
SMALL = 90
#: Seconds within which two lags are one.
ECHO = 0.05
#: Below this confidence an offset is not to be trusted.
TRUSTED = 0.3
#: Pairs below it do not take part while others connect the recordings.
_WEAK = 0.1


@dataclasses.dataclass(frozen=True)
class Signal:
    """Samples at a constant rate."""

    values: NDArray[numpy.float32]
    rate: float  #: Values a second.
    start: float = 0.0  #: Seconds of the recording at which the first value is.


@dataclasses.dataclass(frozen=True)
class Offset:
    """Of one recording."""

    seconds: float  #: By which it begins earlier than the reference: its picture at t + seconds shows what the reference's at t shows.
    confidence: float  #: 0 to 1; see `pair_offset`. Of the reference that of its best pair.
    residual: float  #: Seconds, rms: how far the pairs of this recording disagree with the offsets of all.


def sound_signal(path: str) -> Signal:
    """Onsets of the sound of a file: how much louder each half millisecond is than the 20 ms before it, in logarithm, so that
    microphones at other distances give alike signals."""
    rate, start, samples = recordings.sound(path)
    mono = samples.mean(axis=1)
    step = rate // ENVELOPE_RATE
    mono = mono[: len(mono) // step * step]
    energy = numpy.square(mono, dtype=numpy.float32).reshape(-1, step).mean(axis=1)
    if rate % ENVELOPE_RATE:  # as of 44.1 kHz
        times = numpy.arange(int(len(mono) / rate * ENVELOPE_RATE)) / ENVELOPE_RATE
        energy = numpy.interp(times, numpy.arange(len(energy)) * step / rate, energy).astype(numpy.float32)
    floor = max(float(numpy.median(energy)), 1e-9)
    level = numpy.log1p(energy / floor).astype(numpy.float32)
    width = ENVELOPE_RATE // 50
    before = cv2.blur(level[None, :], (width, 1), anchor=(width - 1, 0))[0]
    return Signal(numpy.maximum(level - before - AUDIBLE, 0), ENVELOPE_RATE, start)


def flash_signal(
    pictures: Iterable[NDArray[numpy.uint8]], rate: float, source: str = "a recording"
) -> Signal:
    """Changes of a picture's brightness from frame to frame. source: what errors name."""
    found = []
    for frame, picture in enumerate(pictures):
        with named(source, frame, is_file=False):
            found.append(float(_small(picture).mean()))
    means = numpy.array(found, numpy.float32)
    return Signal(numpy.diff(means, prepend=means[:1]), rate)


def motion_signal(
    pictures: Iterable[NDArray[numpy.uint8]], rate: float, source: str = "a recording"
) -> Signal:
    """How much of a picture changes from frame to frame, beyond its noise. source: what errors name."""
    found, before = [], None
    for frame, picture in enumerate(pictures):
        with named(source, frame, is_file=False):
            small = cv2.GaussianBlur(_small(picture), (5, 5), 0)
            if before is not None:
                change = cv2.absdiff(small, before).astype(numpy.float32)
                found.append(float(numpy.maximum(change - 3, 0).mean()))
        before = small
    values = numpy.array(found[:1] + found, numpy.float32) if found else numpy.zeros(1, numpy.float32)
    return Signal(values, rate)


def _small(picture: NDArray[numpy.uint8]) -> NDArray[numpy.uint8]:
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    width = max(1, round(grey.shape[1] * SMALL / grey.shape[0]))
    return numpy.asarray(cv2.resize(grey, (width, SMALL), interpolation=cv2.INTER_AREA), numpy.uint8)


def pair_offset(a: Signal, b: Signal, most: float) -> tuple[float, float]:
    """(seconds by which b begins earlier than a, at most `most` either way; confidence).

    The correlation at each lag is over the part that both have, which is a second, or a quarter of the shorter, at least,
    relative to the energy of both. Confidence is the correlation at its peak, 0 to 1, times how far it is above the highest one outside of the peak, relative to it: 0
    when another lag is as good, as for periodic motion.
    """
    if a.rate != b.rate:
        raise UsageError(f"expected signals of one rate, found {a.rate:g} and {b.rate:g} a second")
    x, y = (_normal(s.values) for s in (a, b))
    least = max(8, min(int(a.rate), min(len(x), len(y)) // 4))
    if min(len(x), len(y)) < least:
        return 0.0, 0.0
    ones = numpy.ones
    # At lag k the value y[n + k] is beside x[n].
    products = signal.correlate(y, x, "full", "fft")
    # Of all of both signals: what is alike by chance in a short overlap is then little.
    energy = max(math.sqrt(float(x @ x) * float(y @ y)), 1e-9)
    overlap = numpy.rint(signal.correlate(ones(len(y)), ones(len(x)), "full", "fft"))
    lags = numpy.arange(-len(x) + 1, len(y))
    shift = b.start - a.start
    usable = (overlap >= least) & (numpy.abs(lags / a.rate + shift) <= most)
    score = numpy.where(usable, products / energy, -1.0)
    # A short overlap correlates by chance: about 1 / sqrt(n).
    score = score - numpy.where(usable, 1 / numpy.sqrt(numpy.maximum(overlap, 1)), 0)
    k = int(score.argmax())
    peak = float(score[k])
    if peak <= 0:
        return 0.0, 0.0
    # The peak ends where the score is below half of it, and is as wide as an echo at least.
    left = right = k
    while left > 0 and score[left - 1] > peak / 2:
        left -= 1
    while right + 1 < len(score) and score[right + 1] > peak / 2:
        right += 1
    wide = math.ceil(ECHO * a.rate)
    left, right = max(0, min(left, k - wide)), max(right, k + wide)
    rest = numpy.concatenate([score[:left], score[right + 1 :]])
    second = max(0.0, float(rest.max())) if len(rest) else 0.0
    exact = float(lags[k])
    if 0 < k < len(score) - 1 and score[k - 1] > -1 and score[k + 1] > -1:
        bend = score[k - 1] - 2 * score[k] + score[k + 1]
        if bend < 0:
            exact += float(0.5 * (score[k - 1] - score[k + 1]) / bend)
    return exact / a.rate + shift, max(0.0, peak * (1 - second / peak))


def _normal(values: NDArray[numpy.float32]) -> NDArray[numpy.float64]:
    # Rare loud events must not outweigh all others, nor common ones hide them.
    centred = values.astype(numpy.float64) - float(numpy.mean(values))
    spread = float(numpy.std(centred))
    return numpy.asarray(numpy.clip(centred / spread, -8, 8) if spread > 1e-9 else centred * 0)


def offsets(signals: Mapping[str, Signal], most: float = 10.0) -> dict[str, Offset]:
    """Of each recording, relative to the first one. most: seconds by which two begin apart.

    Pairs are weighted by their confidence; those that disagree with the others by more than two frames of the signal are
    left out. A recording without a usable pair has confidence 0.
    """
    names = list(signals)
    if len(names) < 2:
        raise UsageError("expected two recordings or more to synchronise")
    pairs = [
        (i, j, *pair_offset(signals[names[i]], signals[names[j]], most))
        for i, j in itertools.combinations(range(len(names)), 2)
    ]
    rate = next(iter(signals.values())).rate
    weights = numpy.array([c if c >= _WEAK else 1e-6 for *_, c in pairs])
    rows = numpy.zeros((len(pairs) + 1, len(names)))
    for row, (i, j, _, _) in enumerate(pairs):
        rows[row, i], rows[row, j] = -1, 1
    rows[-1, 0] = 1
    wanted = numpy.array([seconds for _, _, seconds, _ in pairs] + [0.0])
    tolerance = max(2 / rate, 0.002)
    found = errors = numpy.zeros(0)
    for _ in range(10):
        scale = numpy.append(weights, 1.0)
        found = numpy.linalg.lstsq(rows * scale[:, None], wanted * scale, rcond=None)[0]
        errors = numpy.abs(rows[:-1] @ found - wanted[:-1])
        # Iteratively reweighted: Geman and McClure's function.
        weights = numpy.array([max(c, 1e-6) for *_, c in pairs]) / (1 + (errors / tolerance) ** 2) ** 2
        weights = numpy.maximum(weights, 1e-9)
    out = {}
    for n, name in enumerate(names):
        own = [(errors[row], c) for row, (i, j, _, c) in enumerate(pairs) if n in (i, j)]
        agreeing = [(error, c) for error, c in own if error <= 2 * tolerance and c > 0]
        confidence = max((c for _, c in agreeing), default=0.0)
        residual = float(numpy.sqrt(numpy.mean([e * e for e, _ in agreeing]))) if agreeing else 0.0
        out[name] = Offset(float(found[n]), confidence, residual)
    return out


def measure(
    method: Method,
    names: Sequence[str],
    sound_of: Callable[[str], str],
    pictures_of: Callable[[str], Iterable[NDArray[numpy.uint8]]],
    rate: float,
    most: float = 10.0,
    progress: Callable[[int, int], object] | None = None,
) -> dict[str, Offset]:
    """Offsets of recordings by name. sound_of: the file with a recording's sound; pictures_of: its pictures in order; rate:
    pictures a second. progress: called with recordings read and recordings in all."""
    signals = {}
    for done, name in enumerate(names):
        if method == "sound":
            path = sound_of(name)
            if not recordings.has_sound(path):
                raise UsageError(f"{path}: has no sound to synchronise by", file=path)
            signals[name] = sound_signal(path)
        else:
            make = flash_signal if method == "flash" else motion_signal
            signals[name] = make(pictures_of(name), rate, f"recording {name}")
        if progress is not None:
            progress(done + 1, len(names))
    return offsets(signals, most)
