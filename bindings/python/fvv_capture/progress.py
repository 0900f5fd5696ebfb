"""How far a long operation is, on a terminal."""

from __future__ import annotations

import sys
import time


class Show:
    """A line on a terminal that counts, cleared at the end; nothing in a pipe."""

    def __init__(self) -> None:
        self._on = sys.stderr.isatty()
        self._last = 0.0
        self._stage = ""
        self._began = time.monotonic()

    def __call__(self, stage: str, done: int, count: int) -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._began = stage, now
        if not self._on or (now - self._last < 0.1 and done < count):
            return
        self._last = now
        left = ""
        if 0 < done < count and now - self._began > 2:
            left = f", {(now - self._began) * (count - done) / done:.0f} s left"
        sys.stderr.write(f"\r\x1b[K{stage}: {done} of {count}{left}")
        sys.stderr.flush()

    def clear(self) -> None:
        if self._on:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
