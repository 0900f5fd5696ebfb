"""When cameras began, and how fast their clocks go: from sound, from flashes of light, from motion, or from timecode.

Each recording gives a signal over time; pairs of signals are correlated, the peak is found between samples by a parabola, and
the offsets of all recordings are the least squares of the pairs' (as in Hasler et al., "Markerless motion capture with
unsynchronized moving cameras", CVPR 2009, who use sound alone). A clock that is fast or slow moves the peak in the course of the
recordings: the lags of short windows then lie on a line, whose slope is the drift.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any, Literal

import numpy
from fvv import recordings
from fvv.errors import UsageError
from fvv.interop.optional_import import optional_import
from numpy.typing import NDArray

from . import footage
from .opencv import named

cv2: Any = optional_import("cv2", "capture")
signal: Any = optional_import("scipy.signal", "capture")

Method = Literal["sound", "flash", "motion", "timecode"]

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
#: Seconds of a window that a drift is found by, and how many of them there are at least and at most.
WINDOW = 6.0
_WINDOWS = (6, 60)
#: The largest drift that is looked for; quartzes are right to a tenth of it.
MOST_DRIFT = 1e-3
#: That of a cheap clock: signals are made this coarse, of their length, to be found whatever their drift.
TYPICAL_DRIFT = 1e-4
#: Correlation of a window that counts.
_ALIKE = 0.3
_DAY = 86400


@dataclasses.dataclass(frozen=True)
class Signal:
    """Samples at a constant rate."""

    values: NDArray[numpy.float32]
    rate: float  #: Values a second.
    start: float = 0.0  #: Seconds of the recording at which the first value is.


@dataclasses.dataclass(frozen=True)
class Offset:
    """Of one recording."""

    #: By which it begins earlier than the reference: its picture at t (1 + drift) + seconds shows what the reference's at t shows.
    seconds: float
    confidence: float  #: 0 to 1; see `pair_offset`. Of the reference that of its best pair.
    residual: float  #: Seconds, rms: how far the pairs of this recording disagree with the offsets of all.
    drift: float = 0.0  #: Seconds that its clock gains on the reference's in a second; 0 where none shows.


@dataclasses.dataclass(frozen=True)
class Pair:
    """How the second of two recordings lies on the time line of the first: at t (1 + drift) + seconds."""

    seconds: float
    drift: float
    confidence: float
    middle: float = 0.0  #: Of what both have, seconds of the first: where the lag is known best.


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


def pair_offset(a: Signal, b: Signal, most: float | None = None) -> tuple[float, float]:
    """(seconds by which b begins earlier than a, at most `most` either way; confidence). None: any.

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
    # At lag k the value y[n + k] is beside x[n].
    products = signal.correlate(y, x, "full", "fft")
    # Of all of both signals: what is alike by chance in a short overlap is then little.
    energy = max(math.sqrt(float(x @ x) * float(y @ y)), 1e-9)
    lags = numpy.arange(-len(x) + 1, len(y))
    overlap = numpy.minimum(len(x), len(y) - lags) - numpy.maximum(0, -lags)
    shift = b.start - a.start
    usable = overlap >= least
    if most is not None:
        usable &= numpy.abs(lags / a.rate + shift) <= most
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


def pair_clock(a: Signal, b: Signal, most: float | None = None) -> Pair:
    """Offset and drift of b against a. A drift spreads the peak over many values: where recordings are long, the offset is looked
    for in coarse signals, then the drift around it, then the offset by a clock of a's speed."""
    seconds, confidence = pair_offset(a, b, most)
    best = Pair(seconds, 0.0, confidence, _middle(a, b, seconds))
    blur = int(TYPICAL_DRIFT * min(len(a.values), len(b.values)))
    starts = [seconds] if blur < 2 else [seconds, pair_offset(_coarse(a, blur), _coarse(b, blur), most)[0]]
    for start in starts:
        drift = _drift(a, b, start)
        if drift == 0:
            continue
        span = (b.start + len(b.values) / b.rate) / (1 + drift) - b.start
        times = (b.start + numpy.arange(max(int(span * b.rate), 1)) / b.rate) * (1 + drift)
        at = b.start + numpy.arange(len(b.values)) / b.rate
        steady = Signal(numpy.interp(times, at, b.values).astype(numpy.float32), b.rate, b.start)
        seconds, confidence = pair_offset(a, steady, most)
        if confidence > best.confidence:
            seconds *= 1 + drift
            best = Pair(seconds, drift, confidence, _middle(a, b, seconds))
    return best


def _coarse(of: Signal, width: int) -> Signal:
    """Means of width values."""
    count = len(of.values) // width
    means = of.values[: count * width].reshape(count, width).mean(axis=1, dtype=numpy.float32)
    return Signal(means, of.rate / width, of.start + (width - 1) / 2 / of.rate)


def _common(a: Signal, b: Signal, seconds: float) -> tuple[float, float]:
    """Seconds of a between which both are there."""
    low = max(a.start, b.start - seconds)
    return low, min(a.start + len(a.values) / a.rate, b.start - seconds + len(b.values) / b.rate)


def _middle(a: Signal, b: Signal, seconds: float) -> float:
    return sum(_common(a, b, seconds)) / 2


def _drift(a: Signal, b: Signal, seconds: float) -> float:
    """The slope of the lags of windows over the time that both have; 0 where the windows do not agree, or no slope shows."""
    low, high = _common(a, b, seconds)
    span = high - low
    count = min(int(span / WINDOW), _WINDOWS[1])
    if count < _WINDOWS[0]:
        return 0.0
    x, y = (_normal(s.values) for s in (a, b))
    rate, reach = a.rate, ECHO + MOST_DRIFT * span
    times, lags, weights = [], [], []
    for start in numpy.linspace(low, high - WINDOW, count):
        first = round((start - a.start) * rate)
        part = x[max(first, 0) : first + round(WINDOW * rate)]
        other = round((start + seconds - reach - b.start) * rate)
        around = y[max(other, 0) : other + len(part) + round(2 * reach * rate)]
        if len(around) <= len(part) or not part.any():
            continue
        products = signal.correlate(around, part, "valid", "fft")
        squares = numpy.concatenate([[0.0], numpy.cumsum(around**2)])
        energy = numpy.sqrt((squares[len(part) :] - squares[: -len(part)]) * float(part @ part))
        score = products / numpy.maximum(energy, 1e-9 + 0.1 * float(energy.max()))
        k = int(score.argmax())
        if score[k] < _ALIKE or not 0 < k < len(score) - 1:
            continue
        bend = score[k - 1] - 2 * score[k] + score[k + 1]
        exact = k + (0.5 * (score[k - 1] - score[k + 1]) / bend if bend < 0 else 0.0)
        times.append(start + WINDOW / 2)
        lags.append((max(other, 0) + exact - max(first, 0)) / rate + b.start - a.start)
        weights.append(float(score[k]))
    if len(times) < _WINDOWS[0]:
        return 0.0
    t, lag, w = numpy.array(times), numpy.array(lags), numpy.array(weights)
    # Theil and Sen: the median of the slopes of pairs; those that are near in time say little.
    i, j = numpy.triu_indices(len(t), 1)
    far = t[j] - t[i] > span / 4
    slope = float(numpy.median((lag[j] - lag[i])[far] / (t[j] - t[i])[far]))
    tolerance = max(0.005, 0.5 / rate)
    near = numpy.abs(lag - slope * t - numpy.median(lag - slope * t)) <= tolerance
    if near.sum() < max(_WINDOWS[0], len(t) / 2) or numpy.ptp(t[near]) < span / 2:
        return 0.0
    t, lag, w = t[near], lag[near], w[near]
    t = t - numpy.average(t, weights=w)
    fit = float((w * t * lag).sum() / (w * t * t).sum())
    rest = lag - numpy.average(lag, weights=w) - fit * t
    error = math.sqrt(float((w * rest**2).sum() / w.sum()) / len(t)) / float(t.std())
    return fit if 3 * error < abs(fit) <= MOST_DRIFT else 0.0


def _normal(values: NDArray[numpy.float32]) -> NDArray[numpy.float64]:
    # Rare loud events must not outweigh all others, nor common ones hide them.
    centred = values.astype(numpy.float64) - float(numpy.mean(values))
    spread = float(numpy.std(centred))
    return numpy.asarray(numpy.clip(centred / spread, -8, 8) if spread > 1e-9 else centred * 0)


def offsets(signals: Mapping[str, Signal], most: float | None = None) -> dict[str, Offset]:
    """Of each recording, relative to the first one. most: seconds by which two begin apart; None: any.

    Pairs are weighted by their confidence; those that disagree with the others by more than two frames of the signal are
    left out. A recording without a usable pair has confidence 0.
    """
    names = list(signals)
    if len(names) < 2:
        raise UsageError("expected two recordings or more to synchronise")
    ends = list(itertools.combinations(range(len(names)), 2))
    pairs = [pair_clock(signals[names[i]], signals[names[j]], most) for i, j in ends]
    rate = next(iter(signals.values())).rate
    tolerance = max(2 / rate, 0.002)
    # A pair's lag is known to the tolerance over the time that both have.
    slopes = [pair.drift for pair in pairs]
    drifts = numpy.zeros(len(names))
    if any(slopes):
        drifts, _ = _least(ends, pairs, numpy.ones(len(pairs)), numpy.array(slopes), len(names), 2e-5)
    ratios = numpy.array([(1 + drifts[j]) / (1 + drifts[i]) for i, j in ends])
    # The lag in the middle is what was found, whatever the slope.
    wanted = numpy.array([p.seconds + (1 + p.drift - r) * p.middle for p, r in zip(pairs, ratios)])
    found, errors = _least(ends, pairs, ratios, wanted, len(names), tolerance)
    out = {}
    for n, name in enumerate(names):
        own = [(error, pair.confidence) for error, pair, both in zip(errors, pairs, ends) if n in both]
        agreeing = [(error, c) for error, c in own if error <= 2 * tolerance and c > 0]
        confidence = max((c for _, c in agreeing), default=0.0)
        residual = float(numpy.sqrt(numpy.mean([e * e for e, _ in agreeing]))) if agreeing else 0.0
        out[name] = Offset(float(found[n]), confidence, residual, float(drifts[n]))
    return out


def _least(
    ends: Sequence[tuple[int, int]],
    pairs: Sequence[Pair],
    ratios: NDArray[numpy.float64],
    wanted: NDArray[numpy.float64],
    count: int,
    tolerance: float,
) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
    """Values v of recordings, the first 0, so that v[j] - ratio v[i] is nearest to what each pair wants; and how far each pair is
    off. Iteratively reweighted: Geman and McClure's function."""
    rows = numpy.zeros((len(pairs) + 1, count))
    for row, (i, j) in enumerate(ends):
        rows[row, i], rows[row, j] = -ratios[row], 1
    rows[-1, 0] = 1
    confidence = numpy.array([pair.confidence for pair in pairs])
    weights = numpy.where(confidence >= _WEAK, confidence, 1e-6)
    found = errors = numpy.zeros(0)
    for _ in range(10):
        scale = numpy.append(weights, 1.0)
        found = numpy.linalg.lstsq(rows * scale[:, None], numpy.append(wanted, 0.0) * scale, rcond=None)[0]
        errors = numpy.abs(rows[:-1] @ found - wanted)
        weights = numpy.maximum(confidence, 1e-6) / (1 + (errors / tolerance) ** 2) ** 2
        weights = numpy.maximum(weights, 1e-9)
    return found, errors


def timecode_seconds(text: str, rate: Fraction) -> float:
    """Seconds since midnight of "HH:MM:SS:FF" at rate pictures a second; with ; or . before the frames, numbers are left out
    (SMPTE ST 12-1: at 29.97, two at each minute but every tenth). Raises `UsageError`."""
    match = re.fullmatch(r"(\d{1,2}):(\d\d):(\d\d)([:;.])(\d{1,3})", text.strip())
    if match is None:
        raise UsageError(f"timecode {text!r}: expected HH:MM:SS:FF")
    hours, minutes, seconds, frames = (int(match[k]) for k in (1, 2, 3, 5))
    nominal = math.ceil(rate)  # 30 of 29.97
    number = ((hours * 60 + minutes) * 60 + seconds) * nominal + frames
    if match[4] != ":":
        number -= nominal // 15 * (hours * 60 + minutes - (hours * 60 + minutes) // 10)
    return float(number / rate)


def timecode_offsets(codes: Mapping[str, str], rate: Fraction) -> dict[str, Offset]:
    """Of each recording, relative to the first, by the timecode of its first picture. Midnight may lie between."""
    times = {name: timecode_seconds(code, rate) for name, code in codes.items()}
    first = next(iter(times.values()))
    half = _DAY / 2
    return {name: Offset((first - t + half) % _DAY - half, 1.0, 0.0) for name, t in times.items()}


def measure(
    method: Method,
    names: Sequence[str],
    sound_of: Callable[[str], str],
    pictures_of: Callable[[str], Iterable[NDArray[numpy.uint8]]],
    rate: float,
    most: float | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> dict[str, Offset]:
    """Offsets of recordings by name, by sound or pictures. sound_of: the file with a recording's sound; pictures_of: its pictures
    in order; rate: pictures a second. progress: called with recordings read and recordings in all."""
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


def synchronised(
    films: Sequence[footage.Recording],
    method: Method,
    rate: Fraction,
    progress: Callable[[str, int, int], object] = lambda stage, done, count: None,
) -> dict[str, Offset]:
    """Offsets of recordings, from all of their sound or pictures."""
    by_name = {r.name: r for r in films}
    if method == "timecode":
        without = [r.name for r in films if not r.timecode]
        if without:
            raise UsageError(f"expected a timecode in each recording, found none in {', '.join(without)}")
        return timecode_offsets({r.name: r.timecode for r in films}, films[0].rate() or rate)

    def sound_of(name: str) -> str:
        recording = by_name[name]
        if recording.pattern is None:
            return recording.path
        for suffix in (".wav", ".flac", ".m4a", ".mp3", ".ogg", ".opus"):
            if os.path.exists(recording.path + suffix):
                return recording.path + suffix
        raise UsageError(f"{recording.path}: expected a file of sound beside the folder, such as {name}.wav")

    return measure(
        method,
        [r.name for r in films],
        sound_of,
        lambda name: (picture for _, picture in footage.pictures(by_name[name], rate, repeat=True)),
        float(rate),
        progress=lambda done, count: progress("synchronise", done, count),
    )
