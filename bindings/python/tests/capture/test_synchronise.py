"""Offsets between recordings, found from sound, flashes and motion."""

import wave

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
