"""What was measured of a method on a set of scenes, against which targets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

POSITION, HEADING, WORST = 1.0, 0.01, 50.0  # targets: mm, degrees, mm
BATCHED, JACOBIAN, FASTER = 20.0, 5.0, 500.0  # targets: µs, times, times


class Row(NamedTuple):
    """A method on a set of scenes: errors of each, cost of one on average, in µs."""

    scenes: str
    method: str
    setting: str
    mark: str
    of: np.ndarray  # indices of the scenes
    position: np.ndarray  # mm
    heading: np.ndarray  # degrees
    evaluations: float  # of the slope, on average
    batched: float
    threads: float  # a batch in each of two threads
    single: float
    jacobian: float
    plain: float = np.nan  # SciPy's `single` with a right-hand side in plain numbers

    @property
    def share_within(self) -> float:
        """Share of the scenes whose rest pose is within `POSITION` and `HEADING`."""
        return float(((self.position <= POSITION) & (self.heading <= HEADING)).mean())

    @property
    def accurate(self) -> bool:
        """Whether the targets of accuracy are met."""
        return self.share_within >= 0.99 and bool(self.position.max() <= WORST)

    @property
    def cost(self) -> float:
        """µs a scene batched, in one thread or two."""
        return float(np.nanmin([self.batched, self.threads]))

    @property
    def figures(self) -> list[float]:
        """Its figures in the table."""
        quantiles = [f(e) for e in (self.position, self.heading) for f in (np.median, p99, np.max)]
        costs = (self.batched, self.threads, self.single, self.jacobian)
        return [*quantiles, self.share_within, self.evaluations, *costs]


def by_set(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Rows by set of scenes."""
    sets = dict.fromkeys(row.scenes for row in rows)
    return {name: [row for row in rows if row.scenes == name] for name in sets}


def p99(errors: np.ndarray) -> float:
    """What 99 % of them stay below."""
    return float(np.quantile(errors, 0.99))
