"""The way down a potential: its slope, its curvature, and its minimum."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple, override

import numpy as np
from jaxtyping import Float

Point = Float[np.ndarray, " w"]
Points = Float[np.ndarray, "any w"]
Slope = Float[np.ndarray, " w"]
Curvature = Float[np.ndarray, "w w"]
Values = Float[np.ndarray, " any"]
Missed = Float[np.ndarray, "any items"]
Arrived = Callable[[Point], bool]

_STEP = 0.05  # of differences, in standard deviations
_STILL, _MOST = 1e-3, 400  # slope at which a search ends, and steps that it may take
# By surrogates a search ends too where a quadratic about the point lies no lower than this, and where
# so many steps have led no lower: their slope does not quite lead down.
_LOWER, _LAST = 1e-2, 4
# After so many steps it is given up where so many times their way down as of late would not reach what
# is asked for: on a scene's other branch, where searches took half of the time of all (measured).
_AFTER, _TIMES = 10, 4
_OUTSIDE, _BACK = 1e10, 1e8  # the value where there is no potential, and how it rises outwards
_STRIDE, _ROUNDS = 0.25, 30  # of many searches at once: share of the way to w = 0, and how many
_LEVEL = 1e-300  # least slope that is divided by


class Potential(ABC):
    """A function of w, with its derivatives."""

    @abstractmethod
    def __call__(self, w: Point) -> tuple[float, Slope]:
        """Value and slope at w; outside of where it is finite, such as lead back in."""

    @abstractmethod
    def curvature(self, w: Point) -> Curvature:
        """The Hessian at w; zero where that is no number."""

    @abstractmethod
    def minimise(self, start: Point, arrived: Arrived | None = None, most: float = np.inf) -> Found:
        """Its minimum near a start; or where a search from there arrived at what was known, or was given
        up because the minimum will be higher than `most`."""

    def minimise_from(self, starts: Points, arrived: Arrived) -> list[Found]:
        """Where searches from many starts ended, but for those that arrived on the way."""
        return [self.minimise(start, arrived) for start in starts]


class Found(NamedTuple):
    """Where a search ended: the point, the potential there (infinite if nowhere), and its slope."""

    w: Point
    value: float
    slope: Slope


@dataclass(frozen=True)
class Differentiated(Potential):
    """A potential with a program for its slope.

    Args:
        at: value and slope.
    """

    at: Callable[[Point], tuple[float, Slope]]

    @override
    def __call__(self, w: Point) -> tuple[float, Slope]:
        value, slope = self.at(w)
        values = _or_back(w[None], np.array([value]))
        return float(values[0]), _leading_back(w[None], values, slope[None])[0]

    @override
    def curvature(self, w: Point) -> Curvature:
        steps = _STEP * np.eye(w.size)
        rows = [self.at(w + step)[1] - self.at(w - step)[1] for step in steps]
        return _numbers((np.array(rows) + np.transpose(rows)) / (4 * _STEP))

    @override
    def minimise(self, start: Point, arrived: Arrived | None = None, most: float = np.inf) -> Found:
        return _minimise(self, start, arrived, method="BFGS", jac=True)


@dataclass(frozen=True)
class Differenced(Potential):
    """A potential with a good surrogate about each point, whose values come by the batch.

    A slope and all of the curvature then cost little more than a value, and no program for the slope
    has to be compiled, which takes as long as compiling that of the values.

    Args:
        at: values at points, and what the surrogate misses there.
        alike: values of surrogates at points, each of one that misses so much.
        sloped: values and slopes at one point more than there are coordinates, if there is a program.
    """

    at: Callable[[Points], tuple[Values, Missed]]
    alike: Callable[[Points, Missed], Values]
    sloped: Callable[[Points], tuple[Values, Points]] | None = None
    _known: dict[bytes, _Local] = field(default_factory=dict, init=False, repr=False, compare=False)

    @override
    def __call__(self, w: Point) -> tuple[float, Slope]:
        values, missed = self._at(w[None])
        return float(values[0]), self._slopes(w[None], values, missed)[0]

    @override
    def curvature(self, w: Point) -> Curvature:
        return self._about(w).curvature

    @override
    def minimise(self, start: Point, arrived: Arrived | None = None, most: float = np.inf) -> Found:
        values: list[float] = []

        def ended(w: Point) -> bool:
            here = self._about(w)
            values.append(here.value)
            if here.lower() < _LOWER or (arrived and arrived(w)):
                return True
            if len(values) <= _LAST:
                return False
            lower = values[-1 - _LAST] - here.value
            hopeless = len(values) > _AFTER and here.value - most > _TIMES * lower
            return lower < _LOWER or hopeless

        return _minimise(
            lambda w: self._about(w).value,
            start,
            ended,
            method="trust-exact",
            jac=lambda w: self._about(w).slope,
            hess=lambda w: self._about(w).curvature,
        )

    @override
    def minimise_from(self, starts: Points, arrived: Arrived) -> list[Found]:
        w, stride = starts.copy(), _STRIDE * np.linalg.norm(starts, axis=1)
        values, missed = map(np.array, self._at(w))
        # all downhill at once while that is quick: most arrive
        for _ in range(_ROUNDS):
            under_way = np.flatnonzero([not arrived(each) for each in w])
            if not under_way.size:
                break
            slopes = self._slopes(w[under_way], values[under_way], missed[under_way])
            steep = np.maximum(np.linalg.norm(slopes, axis=1), _LEVEL)
            moved = w[under_way] - np.minimum(1.0, stride[under_way] / steep)[:, None] * slopes
            there, missed_there = self._at(moved)
            lower = there < values[under_way]
            stride[under_way[~lower]] /= 2
            w[under_way[lower]], values[under_way[lower]] = moved[lower], there[lower]
            missed[under_way[lower]] = missed_there[lower]
        return [self.minimise(each, arrived) for each in w if not arrived(each)]

    def _at(self, w: Points) -> tuple[Values, Missed]:
        values, missed = self.at(w)
        return _or_back(w, values), missed

    def _slopes(self, w: Points, values: Values, missed: Missed) -> Points:
        count, n = w.shape
        steps = _STEP * np.concatenate([np.eye(n), -np.eye(n)])
        points = (w[:, None] + steps).reshape(-1, n)
        ends = self.alike(points, np.repeat(missed, 2 * n, axis=0)).reshape(count, 2, n)
        with np.errstate(invalid="ignore"):
            slopes = (ends[:, 0] - ends[:, 1]) / (2 * _STEP)
        return _leading_back(w, values, slopes)

    def _about(self, w: Point) -> _Local:
        """What it is like about w; of the last two points this is known, a search asks it again."""
        at = w.tobytes()
        if at not in self._known:
            self._known[at] = self._measured(w)
            if len(self._known) > 2:
                del self._known[next(iter(self._known))]
        return self._known[at]

    def _measured(self, w: Point) -> _Local:
        if self.sloped:
            return self._by_slopes(w, self.sloped)
        n, steps, (i, j) = w.size, _STEP * np.eye(w.size), np.triu_indices(w.size, 1)
        values, missed = self._at(w[None])
        points = np.concatenate([w[None], w + steps, w - steps, w + steps[i] + steps[j]])
        ends = self.alike(points, np.repeat(missed, len(points), axis=0))
        here, ahead, behind, both = np.split(ends, [1, 1 + n, 1 + 2 * n])
        with np.errstate(invalid="ignore"):
            slope = (ahead - behind) / (2 * _STEP)
            curvature = np.diag(ahead + behind - 2 * here)
            curvature[i, j] = curvature[j, i] = both - ahead[i] - ahead[j] + here
        slope = _leading_back(w[None], values, slope[None])[0]
        return _Local(float(values[0]), slope, _numbers(curvature / _STEP**2))

    @staticmethod
    def _by_slopes(w: Point, sloped: Callable[[Points], tuple[Values, Points]]) -> _Local:
        points = np.concatenate([w[None], w + _STEP * np.eye(w.size)])
        values, slopes = sloped(points)
        values = _or_back(points, values)
        slopes = _leading_back(points, values, slopes)
        by_w = _numbers(slopes[1:] - slopes[0]) / _STEP
        return _Local(float(values[0]), slopes[0], (by_w + by_w.T) / 2)


class _Local(NamedTuple):
    """What a potential is like about a point."""

    value: float
    slope: Slope
    curvature: Curvature

    def lower(self) -> float:
        """By how much the minimum of a quadratic through here is lower; infinite if it has none."""
        values, vectors = np.linalg.eigh(self.curvature)
        if not values[0] > 0:
            return np.inf
        return float(np.sum((vectors.T @ self.slope) ** 2 / values) / 2)


def spread(curvature: Curvature, least: float) -> Float[np.ndarray, "w w"]:
    """Square root of the covariance of a normal of this curvature, or of `least` where it has less."""
    values, vectors = np.linalg.eigh(curvature)
    return vectors @ np.diag(1 / np.sqrt(np.clip(values, least, 1e4))) @ vectors.T


def _numbers(values: np.ndarray) -> np.ndarray:
    return np.nan_to_num(values, posinf=0, neginf=0)


def _or_back(w: Points, values: Values) -> Values:
    """Values; where there are none, such as rise outwards."""
    return np.where(np.isfinite(values), values, _OUTSIDE + _BACK * np.sum(w**2, axis=1))


def _leading_back(w: Points, values: Values, slopes: Points) -> Points:
    """Slopes, zero where they are no number; where there are no values, those of `_or_back`."""
    return np.where((values < _OUTSIDE)[:, None], _numbers(slopes), 2 * _BACK * w)


def _minimise(
    potential: Callable[[Point], Any],
    start: Point,
    arrived: Arrived | None,
    *,
    method: str,
    jac: Any,
    hess: Any = None,
) -> Found:
    from scipy.optimize import minimize  # slow to import, and compilers are at work by now

    def report(intermediate_result: Any) -> None:
        if arrived and arrived(intermediate_result.x):
            raise StopIteration

    options = {"gtol": _STILL, "maxiter": _MOST}
    end = minimize(potential, start, (), method, jac, hess, callback=report, options=options)
    return Found(end.x, np.inf if end.fun >= _OUTSIDE else float(end.fun), end.jac)
