"""The modes of a posterior: damped least squares from many crashes of the prior at once.

In standard normal deviates the posterior is a sum of squares, so that each step of Gauss and Newton,
damped after Levenberg and Marquardt, uses what is known of its shape. All numbers of turns to rest are
sought together: a rest heading whose turns were not counted is compared modulo one turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from retrodict.inference.errors import Unanswerable
from retrodict.inference.fitting.deviates import Crashes, Quantities, Turns
from retrodict.scene.names import parsed

# Integration steps of the crashes that are searched, and of those that coordinates are fitted to, where
# measurements ask for more: a third and half of what takes nearly all the time.
ROUGH, SUFFICIENT = 16, 24

Counted = tuple[tuple[str, int], ...]
"""Numbers of turns by vehicle, in the order of the vehicles."""


@dataclass(frozen=True)
class Search:
    """Settings of the search.

    Args:
        crashes: crashes of the prior from which starts are chosen.
        best: starts that fit the evidence best, whatever their numbers of turns.
        of_turns: starts of each pair of numbers of turns.
        turns: pairs of numbers of turns, those of the best starts.
        rounds: steps of each search at most.
        stride: longest step, in deviates.
        still: decrease of the potential by a step at which a search has arrived.
        after: steps after which searches that are far behind are given up.
        behind: potential above the lowest that counts as far behind.
        met: distance, in standard deviations of the posterior, at which a search has met another: only
            that of the lower potential goes on.
        apart: distance between modes, in standard deviations of the posterior about one of them.
        improbable: log evidence by which another mode may be lower and still count.
        few_turned: log evidence by which a mode may be lower and have neighbouring turns searched.
        uncounted: share of the evidence of all numbers of turns that are left out together.
    """

    crashes: int = 2048
    best: int = 16
    of_turns: int = 2
    turns: int = 12
    rounds: int = 40
    stride: float = 3.0
    still: float = 1e-4
    after: int = 10
    behind: float = 60.0
    met: float = 1.0
    apart: float = 2.0
    improbable: float = 12.0
    few_turned: float = 9.0
    uncounted: float = 1e-3


@dataclass(frozen=True)
class Peak:
    """A local maximum of the posterior in standard normal deviates.

    Args:
        u: deviates at the peak, shape (n,).
        potential: minus the log density at the peak, up to a constant.
        residuals: residuals of the evidence, shape (items,).
        slopes: derivatives of the residuals by the deviates, shape (items, n).
        quantities: quantities of the crash at the peak, by name.
        turns: whole turns from the written rest heading of each vehicle whose rotation is unknown.
    """

    u: Float[np.ndarray, " n"]
    potential: float
    residuals: Float[np.ndarray, " items"]
    slopes: Float[np.ndarray, "items n"]
    quantities: dict[str, np.ndarray]
    turns: dict[str, int]

    @property
    def precision(self) -> Float[np.ndarray, "n n"]:
        """Inverse covariance of the posterior about the peak, in the Gauss-Newton approximation."""
        return np.eye(self.u.size) + self.slopes.T @ self.slopes

    @property
    def log_evidence(self) -> float:
        """Log of the peak's share of the evidence by the Laplace approximation, up to a constant."""
        return float(-self.potential - np.linalg.slogdet(self.precision)[1] / 2)

    def distance(self, other: Peak) -> float:
        """Distance to another peak, in standard deviations of the posterior about either."""
        off = self.u - other.u
        return float(np.sqrt(min(off @ self.precision @ off, off @ other.precision @ off)))


class Ends(NamedTuple):
    """Ends of searches.

    Args:
        starts: index of the start of each search.
        u: deviates, shape (ends, n).
        residuals: residuals of the evidence, shape (ends, items).
        slopes: derivatives of the residuals by the deviates, shape (ends, items, n).
    """

    starts: Int[np.ndarray, " ends"]
    u: Float[np.ndarray, "ends n"]
    residuals: Float[np.ndarray, "ends items"]
    slopes: Float[np.ndarray, "ends items n"]


def peaks(
    crashes: Crashes,
    seed: int,
    settings: Search | None = None,
) -> list[Peak]:
    """The modes of a posterior that may count, the one of most evidence first.

    Args:
        crashes: crashes that the model allows.
        seed: integer seed of the crashes from which the search begins.
        settings: settings of the search; None for the defaults.

    Raises:
        Unanswerable: no crash of the prior has a likelihood.
    """
    settings = settings or Search()
    exact, crashes = crashes, crashes.in_steps(ROUGH)
    rng = np.random.default_rng([seed, 6])
    first = rng.standard_normal((settings.crashes, crashes.size))
    first = np.concatenate([np.zeros((1, crashes.size)), first])
    residuals, quantities = crashes.with_quantities(first)
    chosen = _starts(crashes, residuals, quantities, settings)
    if not chosen.size:
        raise Unanswerable(
            "no crash of the prior has a likelihood; check headings and the contact line, and that the "
            "vehicles came together at all"
        )
    found = _distinct(descended(crashes, first[chosen], settings), crashes, settings)
    asked = {counted(peak.turns) for peak in found}
    while beside := _turned_once_more(found, asked, settings):
        asked |= beside.keys()
        starts = np.stack([peak.u for peak in beside.values()])
        counts = {v: np.array([dict(key)[v] for key in beside]) for v in found[0].turns}
        further = descended(crashes, starts, settings, counts)
        found = _distinct(further, crashes, settings, found)
    return _of_likely_turns(_refined(found, exact, settings), settings)


def _refined(found: list[Peak], crashes: Crashes, settings: Search) -> list[Peak]:
    """Peaks of the crashes near those that were found in fewer integration steps."""
    counts = {v: np.array([peak.turns[v] for peak in found]) for v in found[0].turns}
    ends = descended(crashes, np.stack([peak.u for peak in found]), settings, counts)
    return _distinct(ends, crashes, settings)


def counted(turns: dict[str, int]) -> Counted:
    """Numbers of turns by vehicle as a key, by which peaks can be grouped."""
    return tuple(sorted(turns.items()))


def _turned_once_more(
    found: list[Peak], asked: set[Counted], settings: Search
) -> dict[Counted, Peak]:
    """Numbers of turns not searched yet that are one turn from those of a peak, each with that peak.

    Their searches start at the peak: few crashes of the prior lie near these numbers of turns, and the
    distance from one number to the next is short.
    """
    beside: dict[Counted, Peak] = {}
    least = found[0].log_evidence - settings.few_turned
    for peak in (peak for peak in found if peak.log_evidence > least):
        for v, count in peak.turns.items():
            for more in (-1, 1):
                key = counted(peak.turns | {v: count + more})
                if key not in asked:
                    beside.setdefault(key, peak)
    return beside


def _of_likely_turns(found: list[Peak], settings: Search) -> list[Peak]:
    """Peaks of the numbers of turns that have all but a share `uncounted` of the evidence."""
    share: dict[Counted, float] = {}
    for peak in found:
        relative = float(np.exp(peak.log_evidence - found[0].log_evidence))
        share[counted(peak.turns)] = share.get(counted(peak.turns), 0.0) + relative
    likely = sorted(share, key=lambda key: -share[key])
    so_far = np.cumsum([share[key] for key in likely])
    count = int(np.searchsorted(so_far, (1 - settings.uncounted) * so_far[-1])) + 1
    return [peak for peak in found if counted(peak.turns) in likely[:count]]


def turns_of(crashes: Crashes, quantities: Quantities) -> dict[str, np.ndarray]:
    """Whole turns from the written rest heading of vehicles whose rotation is unknown, by vehicle."""
    found = {}
    for name in crashes.modulo:
        off = quantities[f"predicted/{name}"] - crashes.data.evidence[name][0]
        turns = np.nan_to_num(np.round(off / (2 * np.pi)))
        found[parsed(name).vehicle] = turns.astype(int)
    return found


def _starts(
    crashes: Crashes,
    residuals: Float[np.ndarray, "crashes items"],
    quantities: Quantities,
    settings: Search,
) -> np.ndarray:
    """Rows at which searches start: the first, the best, and the best of each number of turns."""
    # Cauchy log density, so that one sharp item does not outweigh all others
    score = np.nan_to_num(-np.log1p(residuals**2).sum(axis=1), nan=-np.inf)
    allowed = np.isfinite(residuals).all(axis=1)
    order = [i for i in np.argsort(-score) if allowed[i]]
    chosen = dict.fromkeys([0] if allowed[0] else [])
    chosen |= dict.fromkeys(order[: settings.best])
    turns = list(zip(*turns_of(crashes, quantities).values(), strict=True))
    if turns:
        found: dict[tuple[int, ...], int] = {}
        for i in order:
            count = found.get(turns[i], 0)
            if count < settings.of_turns and (count or len(found) < settings.turns):
                found[turns[i]] = count + 1
                chosen[i] = None
    return np.array(list(chosen), int)


def descended(
    crashes: Crashes,
    u: Float[np.ndarray, "starts n"],
    settings: Search,
    turns: Turns | None = None,
) -> Ends:
    """Ends of the searches that were not given up.

    Args:
        crashes: crashes that the model allows.
        u: deviates at the starts, shape (starts, n).
        settings: settings of the search.
        turns: whole turns to count for each angle of `Crashes.modulo`; None for the nearest.
    """
    u, n = u.copy(), u.shape[1]
    residuals, slopes = crashes.linearised(u, turns)
    potential = _potential(u, residuals)
    damping = np.ones(len(u))
    arrived = np.zeros(len(u), bool)
    for done in range(settings.rounds):
        under_way = np.flatnonzero(~arrived)
        if not under_way.size:
            break
        own, J, r = u[under_way], slopes[under_way], residuals[under_way]
        normal = J.swapaxes(1, 2) @ J + np.eye(n) * (1 + damping[under_way, None, None])
        downhill = -(own + np.einsum("kmi,km->ki", J, r))
        step = np.linalg.solve(normal, downhill[..., None])[..., 0]
        length = np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)
        moved = own + step * np.minimum(1, settings.stride / length)
        asked = turns and {v: own[under_way] for v, own in turns.items()}
        there, slopes_there = crashes.linearised(moved, asked)
        heights = _potential(moved, there)
        taken = heights < potential[under_way]
        damping[under_way] = np.where(
            taken, damping[under_way] / 5, np.minimum(4 * damping[under_way], 1e10)
        )
        index = under_way[taken]
        u[index], residuals[index], slopes[index] = moved[taken], there[taken], slopes_there[taken]
        potential[index] = heights[taken]
        # upper bound of the step's decrease if the surface were the local quadratic
        small = np.einsum("ki,ki->k", downhill, step) < settings.still
        arrived[under_way] |= small | (damping[under_way] >= 1e10)
        if turns is None:
            met = _met(u, potential, slopes, settings.met)
            potential[met], arrived[met] = np.inf, True
        if done >= settings.after:
            arrived |= potential > potential.min() + settings.behind
    kept = potential <= potential.min() + settings.behind
    return Ends(np.flatnonzero(kept), u[kept], residuals[kept], slopes[kept])


def _met(
    u: Float[np.ndarray, "searches n"],
    potential: Float[np.ndarray, " searches"],
    slopes: Float[np.ndarray, "searches items n"],
    distance: float,
) -> Bool[np.ndarray, " searches"]:
    """Searches that are within a distance of one whose potential is lower."""
    off = u[:, None] - u
    squared = np.square(off).sum(axis=2) + np.square(off @ slopes.swapaxes(1, 2)).sum(axis=2)
    return ((squared < distance**2) & (potential < potential[:, None])).any(axis=1)


def _potential(
    u: Float[np.ndarray, "any n"], residuals: Float[np.ndarray, "any items"]
) -> Float[np.ndarray, " any"]:
    """Half the squares of deviates and residuals; infinite where there is no crash."""
    squares = np.square(u).sum(axis=1) + np.square(residuals).sum(axis=1)
    return np.nan_to_num(squares / 2, nan=np.inf, posinf=np.inf)


def _distinct(
    ends: Ends, crashes: Crashes, settings: Search, known: list[Peak] | None = None
) -> list[Peak]:
    """Peaks at ends of searches and those that are known, each once, the one of most evidence first."""
    quantities = crashes.at(ends.u)[1]
    turns = turns_of(crashes, quantities)
    every = [
        Peak(
            u,
            float(_potential(u[None], ends.residuals[i : i + 1])[0]),
            ends.residuals[i],
            ends.slopes[i],
            {name: values[i] for name, values in quantities.items()},
            {v: int(count[i]) for v, count in turns.items()},
        )
        for i, u in enumerate(ends.u)
    ]
    every += known or []
    found: list[Peak] = []
    for peak in sorted(every, key=lambda peak: peak.potential):
        if not any(_same(crashes, peak, other, settings) for other in found):
            found.append(peak)
    found.sort(key=lambda peak: -peak.log_evidence)
    least = found[0].log_evidence - settings.improbable
    return [peak for peak in found if peak.log_evidence > least]


def _same(crashes: Crashes, peak: Peak, other: Peak, settings: Search) -> bool:
    """Whether two ends are of one mode: near each other, or no dip lies between them."""
    if peak.turns != other.turns:
        return False
    if peak.distance(other) < settings.apart:
        return True
    shares = np.linspace(0, 1, 11)[1:-1, None]
    between = (1 - shares) * peak.u + shares * other.u
    heights = _potential(between, crashes.residuals(between))
    return bool(heights.max() < max(peak.potential, other.potential) + 1)
