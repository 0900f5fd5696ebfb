"""Sound to write."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy
from numpy.typing import ArrayLike

from ._core import Sound
from .errors import UsageError

RATE = 48000
# FFmpeg's libopus confuses 5 channels, and has no layout of 7.
CHANNELS = (1, 2, 3, 4, 6, 8)


@dataclasses.dataclass(frozen=True)
class AudioInput:
    """A recording, for `Writer`, which encodes it as Opus."""

    samples: ArrayLike  #: (samples, channels) or (samples,), full scale 1: 1, 2, 3, 4, 6 or 8 channels.
    rate: int = RATE  #: Samples per second: 48000, the rate of Opus.
    start: float = 0.0  #: Time of the first sample, in seconds from the first frame.
    title: str = ""
    language: str = ""  #: BCP 47: "en", "pt-BR".
    #: Where it is heard from, metres: (3,), or (frames, 3) of a source that moves. None: everywhere. One channel then.
    position: ArrayLike | None = None
    bit_rate: int = 0  #: Bits per second; 0: 64,000 for one channel, 48,000 a channel for more.


def sound_arguments(audio: AudioInput | Sound, number: int) -> dict[str, Any]:
    """What the core takes. Raises `UsageError`."""
    where = f"audio {number}"
    if isinstance(audio, Sound):
        return {
            "read": audio,
            "title": audio.title,
            "language": audio.language,
            "positions": audio.position,
        }
    if not isinstance(audio, AudioInput):
        raise UsageError(f"{where}: expected fvv.AudioInput or fvv.Sound, found {type(audio).__name__}")
    if audio.rate != RATE:
        raise UsageError(
            f"{where}: rate: expected {RATE} samples per second, found {audio.rate}: resample it"
        )
    samples = numpy.asarray(audio.samples)
    if samples.ndim == 1:
        samples = samples[:, None]
    if samples.dtype.kind != "f" or samples.ndim != 2 or not len(samples) or samples.shape[1] not in CHANNELS:
        raise UsageError(
            f"{where}: samples: expected floats (samples, 1, 2, 3, 4, 6 or 8 channels), found {samples.dtype} {samples.shape}"
        )
    if not numpy.isfinite(samples).all():
        raise UsageError(f"{where}: samples: expected finite numbers")
    if not -1e6 < audio.start < 1e6:
        raise UsageError(f"{where}: start: expected seconds, found {audio.start}")
    if not 0 <= audio.bit_rate < 1 << 32:
        raise UsageError(f"{where}: bit_rate: expected bits per second, found {audio.bit_rate}")
    positions = None if audio.position is None else numpy.ascontiguousarray(audio.position, numpy.float64)
    if positions is not None:
        if positions.shape != (3,) and (positions.ndim != 2 or positions.shape[1] != 3 or not len(positions)):
            raise UsageError(f"{where}: position: expected (3,) or (frames, 3), found {positions.shape}")
        if not numpy.isfinite(positions).all():
            raise UsageError(f"{where}: position: expected finite metres")
        if samples.shape[1] != 1:
            raise UsageError(
                f"{where}: expected one channel of a sound with a position, found {samples.shape[1]}"
            )
    return {
        "read": None,
        "samples": numpy.ascontiguousarray(samples, numpy.float32),
        "start": float(audio.start),
        "bit_rate": audio.bit_rate,
        "title": audio.title,
        "language": audio.language,
        "positions": positions,
    }
