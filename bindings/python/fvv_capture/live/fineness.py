"""Which cell of the hull holds the rate."""

from __future__ import annotations

#: Above this part of the time that processes have, cells become larger; below the other one, smaller again.
FULL, EASY = 0.85, 0.5
#: Factor of a step, and the most steps: cells four times as large.
STEP, MOST = 2 ** (1 / 3), 6
#: Frames that a decision looks at; frames in a row with time to spare before cells become smaller, at first and at most.
LOOKED_AT, ENOUGH, MOST_ENOUGH = 8, 50, 3200


class Fineness:
    """Follows what frames take."""

    def __init__(self, rate: float, processes: int) -> None:
        """rate: frames a second; processes: that make them."""
        self._seconds_there_are = processes / rate
        self._taken: list[float] = []
        self._easy = 0
        self._since_change = LOOKED_AT  # frames
        self._enough = ENOUGH
        self._since_finer: int | None = None
        self.step = 0
        self.load = 0.0  #: Of the last frames: the part of the processes' time that they took.

    @property
    def scale(self) -> float:
        """Of the cell's side."""
        return float(STEP**self.step)

    def drop(self) -> int:
        """After a frame for which no process was free. As `add`."""
        self._since_change += 1
        return self._coarser()

    def add(self, seconds: float) -> int:
        """After a frame that took a process some seconds. Returns the change in steps: 1 coarser, -1 finer."""
        self._taken = [*self._taken[-LOOKED_AT + 1 :], seconds]
        self.load = sum(self._taken) / len(self._taken) / self._seconds_there_are
        self._since_change += 1
        if self._since_finer is not None:
            self._since_finer += 1
        if len(self._taken) < LOOKED_AT:
            return 0
        if self.load > FULL:
            return self._coarser()
        self._easy = self._easy + 1 if self.load < EASY else 0
        if self._easy < self._enough or not self.step:
            return 0
        self._since_finer = 0
        return self._change(-1)

    def _coarser(self) -> int:
        if self.step == MOST or self._since_change < LOOKED_AT:
            return 0
        if self._since_finer is not None and self._since_finer <= self._enough:
            self._enough = min(2 * self._enough, MOST_ENOUGH)  # the finer one was too early
        self._since_finer = None
        return self._change(1)

    def _change(self, by: int) -> int:
        self.step += by
        self._taken.clear()
        self._easy = self._since_change = 0
        return by
