"""Minimum and curvature of a potential whose surrogate is cheap beside its exact value.

Values come by the batch, so that a slope and all of the curvature cost little more than a value, and no
program for derivatives has to be compiled.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

Point = Float[np.ndarray, " w"]
Points = Float[np.ndarray, "any w"]
Slope = Float[np.ndarray, " w"]
Curvature = Float[np.ndarray, "w w"]
Values = Float[np.ndarray, " any"]
Missed = Float[np.ndarray, "any items"]

_STEP = 0.05  # step of difference quotients, in standard deviations
_STILL, _MOST = 1e-3, 400  # slope at which a search ends, and steps that it may take
# A search also ends where the minimum of a quadratic about the point is lower by less than _LOWER, or
# where _LAST steps gained less: the surrogate's slope is not exactly that of the potential.
_LOWER, _LAST = 1e-2, 4
_OUTSIDE, _BACK = 1e10, 1e8  # potential outside the support: constant, and factor of |w|²


class Found(NamedTuple):
    """End of a search: the point, and the potential there (infinite if nowhere)."""

    w: Point
    value: float


@dataclass(frozen=True)
class Potential:
    """A function of w with a good surrogate about each point.

    Args:
        at: function from points to exact values there, and to what the surrogate misses.
        alike: function from points and misses to the values of surrogates that miss by these amounts.
    """

    at: Callable[[Points], tuple[Values, Missed]]
    alike: Callable[[Points, Missed], Values]
    _known: dict[bytes, _Local] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __call__(self, w: Point) -> tuple[float, Slope]:
        """Value and slope at w; outside the support a quadratic that leads back in."""
        values, missed = self._at(w[None])
        n = w.size
        steps = _STEP * np.concatenate([np.eye(n), -np.eye(n)])
        ends = self.alike(w + steps, np.repeat(missed, 2 * n, axis=0)).reshape(2, n)
        with np.errstate(invalid="ignore"):
            slope = (ends[0] - ends[1]) / (2 * _STEP)
        return float(values[0]), _leading_back(w, float(values[0]), slope)

    def curvature(self, w: Point) -> Curvature:
        """The Hessian at w; entries that are no number are zero."""
        return self._about(w).curvature

    def minimise(self, start: Point) -> Found:
        """The minimum near a start."""
        from scipy.optimize import minimize  # slow to import, and compilers are at work by now

        values: list[float] = []

        def stop_where_still(intermediate_result: Any) -> None:
            here = self._about(intermediate_result.x)
            values.append(here.value)
            level = len(values) > _LAST and values[-1 - _LAST] - here.value < _LOWER
            if here.lower() < _LOWER or level:
                raise StopIteration

        end = minimize(
            lambda w: self._about(w).value,
            start,
            method="trust-exact",
            jac=lambda w: self._about(w).slope,
            hess=lambda w: self._about(w).curvature,
            callback=stop_where_still,
            options={"gtol": _STILL, "maxiter": _MOST},
        )
        return Found(end.x, np.inf if end.fun >= _OUTSIDE else float(end.fun))

    def _at(self, w: Points) -> tuple[Values, Missed]:
        values, missed = self.at(w)
        outwards = _OUTSIDE + _BACK * np.sum(w**2, axis=1)
        return np.where(np.isfinite(values), values, outwards), missed

    def _about(self, w: Point) -> _Local:
        """Value, slope and curvature about w; kept for the last two points, which searches reuse."""
        at = w.tobytes()
        if at not in self._known:
            self._known[at] = self._measured(w)
            if len(self._known) > 2:
                del self._known[next(iter(self._known))]
        return self._known[at]

    def _measured(self, w: Point) -> _Local:
        n, steps, (i, j) = w.size, _STEP * np.eye(w.size), np.triu_indices(w.size, 1)
        values, missed = self._at(w[None])
        points = np.concatenate([w[None], w + steps, w - steps, w + steps[i] + steps[j]])
        ends = self.alike(points, np.repeat(missed, len(points), axis=0))
        here, ahead, behind, both = np.split(ends, [1, 1 + n, 1 + 2 * n])
        with np.errstate(invalid="ignore"):
            slope = (ahead - behind) / (2 * _STEP)
            curvature = np.diag(ahead + behind - 2 * here)
            curvature[i, j] = curvature[j, i] = both - ahead[i] - ahead[j] + here
        value = float(values[0])
        return _Local(value, _leading_back(w, value, slope), _numbers(curvature / _STEP**2))


class _Local(NamedTuple):
    """A potential about a point."""

    value: float
    slope: Slope
    curvature: Curvature

    def lower(self) -> float:
        """Decrease of the potential to the minimum of its quadratic; infinite if there is none."""
        values, vectors = np.linalg.eigh(self.curvature)
        if not values[0] > 0:
            return np.inf
        return float(np.sum((vectors.T @ self.slope) ** 2 / values) / 2)


def spread(curvature: Curvature, least: float) -> Float[np.ndarray, "w w"]:
    """Square root of the covariance of a normal of this curvature, which is raised to `least`."""
    values, vectors = np.linalg.eigh(curvature)
    return vectors @ np.diag(1 / np.sqrt(np.clip(values, least, 1e4))) @ vectors.T


def _numbers(values: np.ndarray) -> np.ndarray:
    return np.nan_to_num(values, posinf=0, neginf=0)


def _leading_back(w: Point, value: float, slope: Slope) -> Slope:
    """A slope, zero where it is no number; outside the support the slope of the quadratic."""
    return _numbers(slope) if value < _OUTSIDE else 2 * _BACK * w
