"""The speeds that a recorder kept up to the impact, and what they say of the speed at it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise


@dataclass(frozen=True, slots=True)
class SpeedRecord:
    """Recorded speeds up to the impact, whose time on the recorder's clock is uncertain.

    The speed at impact is interpolated linearly between the recorded speeds, at a time distributed
    uniformly from `low` to `high`, and has a normal error.

    Args:
        times: times of the recorded speeds, s, increasing; `low` and `high` lie within them.
        speeds: recorded speeds at `times`, m/s.
        low: earliest time of the impact, s.
        high: latest time of the impact, s.
        sd: standard deviation of a recorded speed, m/s.
    """

    times: tuple[float, ...]
    speeds: tuple[float, ...]
    low: float
    high: float
    sd: float

    @property
    def within(self) -> tuple[tuple[float, float], ...]:
        """Time (s) and speed (m/s) at `low`, at each record between `low` and `high`, and at `high`."""
        inner = [
            (t, v) for t, v in zip(self.times, self.speeds, strict=True) if self.low < t < self.high
        ]
        return ((self.low, self._at(self.low)), *inner, (self.high, self._at(self.high)))

    @property
    def moments(self) -> tuple[float, float]:
        """Mean and standard deviation of the speed at the impact, m/s."""
        mean = square = 0.0
        for (t, v), (t_next, v_next) in pairwise(self.within):
            share = (t_next - t) / (self.high - self.low)
            mean += share * (v + v_next) / 2
            square += share * (v * v + v * v_next + v_next * v_next) / 3
        return mean, math.sqrt(max(square - mean * mean, 0.0) + self.sd**2)

    def _at(self, time: float) -> float:
        for (t, v), (t_next, v_next) in pairwise(zip(self.times, self.speeds, strict=True)):
            if time <= t_next:
                return v + (v_next - v) * (time - t) / (t_next - t)
        return self.speeds[-1]
