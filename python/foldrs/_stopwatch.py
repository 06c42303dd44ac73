"""Wall time by stage."""

from __future__ import annotations

import time


class Stopwatch:
    """Runs from when it is made; every lap is the time since the one before.

    Attributes
    ----------
    stages : dict of str to float
        Seconds by stage, in the order they were run.
    """

    def __init__(self) -> None:
        self.stages: dict[str, float] = {}
        self._start = self._lap = time.perf_counter()

    def lap(self, stage: str) -> None:
        """Count the time since the last lap for a stage; it may have several."""
        now = time.perf_counter()
        self.stages[stage] = self.stages.get(stage, 0.0) + now - self._lap
        self._lap = now

    @property
    def seconds(self) -> float:
        """Seconds since it was made."""
        return time.perf_counter() - self._start
