"""Offsets between recordings, found from sound, flashes and motion."""

import wave
from fractions import Fraction

import numpy
import pytest
from fvv.errors import Error, UsageError
from fvv_capture import synchronise
from fvv_capture.synchronise import Signal

RATE = 25.0


def write_wav(path, samples, rate):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes((numpy.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())


def claps(times, seconds, rate, seed, gain=1.0, noise=0.01):
    """Short decaying bursts at times, in noise."""
    random = numpy.random.default_rng(seed)
    out = noise * random.standard_normal(int(seconds * rate))
    decay = numpy.exp(-numpy.arange(int(0.08 * rate)) / (0.01 * rate))
    for time in times:
        start = round(time * rate)
        if 0 <= start < len(out) - len(decay):
            out[start : start + len(decay)] += (
                gain * 0.8 * decay * numpy.random.default_rng(5).standard_normal(len(decay))
            )
    return out


@pytest.mark.parametrize("rates", [(48000, 48000), (44100, 16000)])
def test_sound_gives_offsets_to_a_millisecond(tmp_path, rates):
    times = [1.1, 2.35, 4.02]
    shifts = {"a": 0.0, "b": 0.0374, "c": -0.8123}
    signals = {}
    for seed, (name, shift) in enumerate(shifts.items()):
        rate = rates[seed % 2]
        write_wav(
            tmp_path / f"{name}.wav", claps([t + shift for t in times], 6, rate, seed, 1 / (1 + seed)), rate
        )
        signals[name] = synchronise.sound_signal(str(tmp_path / f"{name}.wav"))
    found = synchronise.offsets(signals)
    for name, shift in shifts.items():
        assert abs(found[name].seconds - shift) < 0.0015
        assert found[name].confidence > synchronise.TRUSTED
        assert found[name].residual < 0.002


def ball(shift, count=80, seed=0, flash=None, rate=RATE):
    """A ball on an uneven path before a still background, with noise."""
    random = numpy.random.default_rng(seed)
    y, x = numpy.mgrid[0:90, 0:160]
    for i in range(count):
        t = i / rate + shift
        cx = 80 + 55 * numpy.sin(2.1 * t + 1.3 * numpy.sin(1.7 * t)) * numpy.cos(0.6 * t)
        cy = 45 + 25 * numpy.sin(3.4 * t + numpy.sin(2.9 * t * t / 3))
        picture = numpy.where((x - cx) ** 2 + (y - cy) ** 2 < 120, 220.0, 60 + 0.3 * x)
        if flash is not None:
            # Open for the whole frame: light in two frames in proportion.
            lit = min(max(t + 1 / rate - flash, 0), 0.02) - min(max(t - flash, 0), 0.02)
            picture = picture + 4000 * lit
        picture = picture + 2 * random.standard_normal(picture.shape)
        yield numpy.repeat(numpy.clip(picture, 0, 255).astype(numpy.uint8)[:, :, None], 3, axis=2)


def test_motion_gives_offsets_to_half_a_frame():
    shifts = {"a": 0.0, "b": 0.3, "c": -0.215, "d": 0.017}
    signals = {
        name: synchronise.motion_signal(ball(shift, seed=n), RATE)
        for n, (name, shift) in enumerate(shifts.items())
    }
    found = synchronise.offsets(signals, most=1.5)
    for name, shift in shifts.items():
        # A recording that begins earlier shows what the reference shows, later.
        assert abs(found[name].seconds + shift) < 0.5 / RATE
        assert found[name].confidence > synchronise.TRUSTED


def test_flashes_give_offsets_to_half_a_frame():
    shifts = {"a": 0.0, "b": 0.12, "c": -0.21}
    signals = {
        name: synchronise.flash_signal(ball(shift, 60, n, flash=1.2), RATE)
        for n, (name, shift) in enumerate(shifts.items())
    }
    found = synchronise.offsets(signals, most=1.0)
    for name, shift in shifts.items():
        assert abs(found[name].seconds + shift) < 0.5 / RATE
        assert found[name].confidence > synchronise.TRUSTED


def test_confidence_is_low_where_nothing_decides():
    random = numpy.random.default_rng(3)
    noise = {name: Signal(random.standard_normal(100).astype(numpy.float32), RATE) for name in "abc"}
    assert max(o.confidence for o in synchronise.offsets(noise).values()) < synchronise.TRUSTED
    periodic = numpy.sin(numpy.arange(400) * 2 * numpy.pi / 10).astype(numpy.float32)
    twins = {"a": Signal(periodic, RATE), "b": Signal(periodic, RATE)}
    assert max(o.confidence for o in synchronise.offsets(twins).values()) < synchronise.TRUSTED
    still = {name: Signal(numpy.zeros(50, numpy.float32), RATE) for name in "ab"}
    assert [o.confidence for o in synchronise.offsets(still).values()] == [0, 0]


def test_one_recording_of_something_else_does_not_move_the_others():
    random = numpy.random.default_rng(4)
    base = random.standard_normal(300).astype(numpy.float32)
    signals = {
        "a": Signal(base[10:260], RATE),
        "b": Signal(base[20:270], RATE),
        "other": Signal(random.standard_normal(250).astype(numpy.float32), RATE),
        "c": Signal(base[5:255], RATE),
    }
    found = synchronise.offsets(signals, most=2.0)
    assert abs(found["b"].seconds + 10 / RATE) < 0.01
    assert abs(found["c"].seconds - 5 / RATE) < 0.01
    assert found["other"].confidence < synchronise.TRUSTED < found["b"].confidence


def test_silent_files_and_single_recordings_are_refused(tmp_path):
    with pytest.raises(UsageError, match="two recordings"):
        synchronise.offsets({"a": Signal(numpy.zeros(9, numpy.float32), RATE)})
    (tmp_path / "a.mp4").write_bytes(b"nothing")
    with pytest.raises(UsageError, match="has no sound"):
        synchronise.measure("sound", ["a"], lambda name: str(tmp_path / "a.mp4"), lambda name: [], RATE)


@pytest.mark.parametrize("method", ["flash", "motion"])
@pytest.mark.parametrize("shape", [(0, 0, 3), (48, 64), (48, 64, 2)])
def test_a_picture_that_opencv_cannot_use_is_named(method, shape):
    """Empty, without colours, and of another number of channels."""
    whole = [numpy.full((48, 64, 3), 9, numpy.uint8)] * 3
    pictures = [*whole, numpy.zeros(shape, numpy.uint8)]
    with pytest.raises(Error, match=r"^recording b: frame 3: OpenCV \S+: .*\(\w+\)$"):
        synchronise.measure(method, ["a", "b"], str, lambda name: pictures if name == "b" else whole, 25.0)


@pytest.mark.parametrize("method", ["flash", "motion"])
def test_pictures_of_other_sizes(method):
    """A recording whose pictures change their size midway: those of one shape still have a signal."""
    pictures = [numpy.full((48, 64, 3), 9, numpy.uint8)] * 3 + [numpy.full((96, 64, 3), 9, numpy.uint8)]
    if method == "flash":
        synchronise.flash_signal(pictures, 25.0)
        return
    with pytest.raises(Error, match=r"^recording b: frame 3: OpenCV"):
        synchronise.motion_signal(pictures, 25.0, "recording b")


ONSETS = 2000.0


def onsets(seed, begins, seconds, drift=0.0):
    """Of sound whose events, one in 0.8 s on average, all hear: by a recorder that begins at `begins` and whose clock gains."""
    random = numpy.random.default_rng(7)
    events = numpy.cumsum(random.exponential(0.8, 1200))
    heights = random.uniform(1, 6, len(events))
    out = 0.3 * numpy.maximum(numpy.random.default_rng(seed).standard_normal(int(seconds * ONSETS)), 0)
    decay = numpy.exp(-numpy.arange(60) / 20)
    for time, height in zip(events, heights):
        n = round((time - begins) * (1 + drift) * ONSETS)
        if 0 <= n < len(out) - len(decay):
            out[n : n + len(decay)] += height * decay
    return Signal(out.astype(numpy.float32), ONSETS)


def test_recordings_may_begin_minutes_apart():
    signals = {"a": onsets(1, 100, 60), "b": onsets(2, 3, 150), "c": onsets(3, 140.5, 30)}
    found = synchronise.offsets(signals)
    for name, seconds in (("b", 97.0), ("c", -40.5)):
        assert abs(found[name].seconds - seconds) < 0.001
        assert found[name].confidence > synchronise.TRUSTED
        assert found[name].drift == 0


def test_a_clock_that_drifts_is_followed():
    """145 parts per million are 35 ms in four minutes; the offset alone is at the beginning."""
    clocks = {"a": (5.0, 0.0), "b": (19.3, 145e-6), "c": (3.0, -60e-6)}
    signals = {name: onsets(n, begins, 240, d) for n, (name, (begins, d)) in enumerate(clocks.items())}
    found = synchronise.offsets(signals)
    for name, (begins, drift) in clocks.items():
        assert abs(found[name].drift - drift) < 5e-6
        # Its own time when the reference begins, and four minutes later.
        for t in (0.0, 240.0):
            own = (5.0 + t - begins) * (1 + drift)
            assert abs(t * (1 + found[name].drift) + found[name].seconds - own) < 0.002
        assert found[name].confidence > synchronise.TRUSTED


def test_timecode_gives_offsets():
    codes = {"a": "10:00:00:05", "b": "09:59:58:00", "c": "10:00:00:05"}
    found = synchronise.timecode_offsets(codes, Fraction(25))
    assert [round(o.seconds, 9) for o in found.values()] == [0, 2.2, 0]
    midnight = synchronise.timecode_offsets({"a": "23:59:59:00", "b": "00:00:01:00"}, Fraction(25))
    assert midnight["b"].seconds == pytest.approx(-2)
    # Drop frame: 18 numbers in ten minutes are left out, so that an hour is an hour.
    ntsc = Fraction(30000, 1001)
    assert synchronise.timecode_seconds("01:00:00;00", ntsc) == pytest.approx(3600, abs=0.005)
    assert synchronise.timecode_seconds("00:01:00;02", ntsc) == pytest.approx(float(1800 / ntsc))
    assert synchronise.timecode_seconds("01:00:00:00", ntsc) == pytest.approx(3603.6)
    for text in ("", "10:00:00", "aa:00:00:00"):
        with pytest.raises(UsageError, match="expected HH:MM:SS:FF"):
            synchronise.timecode_seconds(text, ntsc)
