"""Draws from nested Laplace approximations: what evidence pins is solved for, given all else.

Evidence pins a few directions of the deviates to a thin sheet, which bends with the other directions and
is thicker in some places than in others. A normal about the peak, over a sheet fitted once, leaves 2 to
15 % of the draws effective. Here the free directions are drawn from a wide normal, and for each draw the
mode and the covariance of the pinned ones are found by some steps of Gauss and Newton (Rue et al. 2009).
Then 35 to 60 % of the draws are effective (measured on simulated crashes of unknown approach).

The steps begin at modes, and go by slopes, that are fitted once to a few hundred draws solved for by
slopes of their own. Each step corrects the slopes by how residuals changed along it (Broyden 1965);
what a few such steps do not bring to its mode goes on by slopes of its own. The draws of the fit also
show, by Laplace's approximation, where the free directions are.

A fifth of each free direction is drawn from its prior: without, the tails of priors with bounds were
missed where nothing else held them (Pareto k 0.8 in `tests/models/test_priors.py`, and an error of 0.04
sd that the scramblings did not show). Directions that change residuals by 2 to 4 sd are free too: solved
for, they left more scenes with weights too uneven.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float
from scipy.special import ndtri

from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.fitting.quadratic import least_squares, terms
from retrodict.inference.fitting.search import SUFFICIENT, Peak
from retrodict.inference.samplers.proposal import HEAVY, Proposal, Tails
from retrodict.inference.samplers.psis import effective, smoothed

_PINNED = 4.0  # change of the residuals per deviate above which a direction is solved for
# Tails of the pinned directions, before draws have shown that they need heavier ones.
_TAILS = Tails(0.3, 8.0)
# Free directions: sd over that at the peak where evidence outweighs the prior; share of the prior.
_WIDE, _PRIOR = 1.15, 0.2
# Steps at most: by fitted slopes, corrected by the change that each step brings; then by slopes of their
# own, which take a crash for each pinned direction; length of the last step. (Where 2 % of the draws did
# not arrive, the far end of e_m was missed: its upper 97.5 % limit was 0.2 sd too low.)
_CORRECTED, _OWN, _ARRIVED = 3, 6, 0.15
# Draws that modes and slopes are fitted to: at least, and for each coefficient; steps by the slopes at
# the peak before those by slopes of their own.
_LEAST, _EACH, _FIRST_CHORDS = 256, 2, 3
# Change of slopes over the slopes at the peak beyond which they are those of an edge. (One of 453 among
# some hundred of about 1 made fitted slopes so steep that two fifths of a posterior were missed.)
_OUTLYING = 10.0
_STRIDE = 30.0  # longest step: the fit may be so far off where the sheet bends most
_NEAR = 4.0  # length of the next step from which on a draw tells the fit nothing of its mode
_STEP = 1e-3  # step of a deviate in difference quotients

Points = Float[np.ndarray, "points n"]
Moments = tuple[Float[np.ndarray, " free"], Float[np.ndarray, " free"]]
"""Mean and standard deviation of the free directions, in standard deviations about the peak."""

EXTRA = 2  # coordinates of the unit cube beyond those of a point: tails of the pinned directions


@dataclass(frozen=True)
class _Free:
    """A normal for each free direction, mixed with its prior; in standard deviations about the peak.

    A direction whose evidence fades away from the peak has its prior's tails, which a normal lacks.

    Args:
        prior_mean, prior_sd: mean and standard deviation of each prior, shape (free,).
        mean, sd: mean and standard deviation of each normal, shape (free,).
    """

    prior_mean: Float[np.ndarray, " free"]
    prior_sd: Float[np.ndarray, " free"]
    mean: Float[np.ndarray, " free"]
    sd: Float[np.ndarray, " free"]

    @property
    def size(self) -> int:
        """Number of free directions."""
        return self.mean.size

    def at(self, points: Float[np.ndarray, "points free"]) -> Float[np.ndarray, "points free"]:
        """Draws from points of the unit cube."""
        of_prior = points < _PRIOR
        z = ndtri(np.where(of_prior, points / _PRIOR, (points - _PRIOR) / (1 - _PRIOR)))
        return np.where(of_prior, self.prior_mean + self.prior_sd * z, self.mean + self.sd * z)

    def log_density(self, x: Float[np.ndarray, "points free"]) -> Float[np.ndarray, " points"]:
        """Log densities of draws."""

        def normal(mean: np.ndarray, sd: np.ndarray) -> np.ndarray:
            return np.exp(-(((x - mean) / sd) ** 2) / 2) / sd

        both = _PRIOR * normal(self.prior_mean, self.prior_sd)
        both += (1 - _PRIOR) * normal(self.mean, self.sd)
        return (np.log(both) - np.log(2 * np.pi) / 2).sum(axis=1)


@dataclass(frozen=True)
class _Sheet:
    """Modes of the pinned directions, and slopes there, as quadratics of the free ones.

    Args:
        middle: mean of the free directions by the draws of the fit, shape (free,).
        mode: coefficients of the modes, shape (terms, pinned).
        slopes: coefficients of the slopes, less those at the peak, shape (terms, pinned items).
        at_peak: slopes at the peak, shape (pinned, items).
        reach: largest distance of each free direction in the fit, shape (free,).
    """

    middle: Float[np.ndarray, " free"]
    mode: Float[np.ndarray, "terms pinned"]
    slopes: Float[np.ndarray, "terms pinned_items"]
    at_peak: Float[np.ndarray, "pinned items"]
    reach: Float[np.ndarray, " free"]

    def at(
        self, x: Float[np.ndarray, "points free"]
    ) -> tuple[Float[np.ndarray, "points pinned"], Float[np.ndarray, "points pinned items"]]:
        """Modes and slopes at free directions."""
        of_x = terms(np.clip(x, -self.reach, self.reach))
        slopes = (of_x @ self.slopes).reshape(len(x), *self.at_peak.shape)
        return of_x @ self.mode, self.at_peak + slopes


@dataclass(frozen=True)
class Nested:
    """A proposal about a peak: free directions, then the pinned ones given these.

    Args:
        posterior: posterior in deviates, of which this is a proposal.
        peak: peak that the proposal is about.
        shown: moments of the free directions as draws have shown them; None before any.
        about: proposal for the pinned directions about their modes, in standard deviations there, as
            draws have shown them; None before any.
    """

    posterior: Posterior
    peak: Peak
    shown: Moments | None = None
    about: Proposal | None = None

    @property
    def size(self) -> int:
        """Coordinates of the unit cube that make a draw."""
        return self.peak.u.size + EXTRA

    def sampled(self, count: int, rng: np.random.Generator) -> tuple[Points, np.ndarray]:
        """Independent draws and their log densities, as of `at`."""
        return self.at(rng.random((count, self.size)))

    def at(self, points: Float[np.ndarray, "points size"]) -> tuple[Points, np.ndarray]:
        """Draws from points of the unit cube.

        Args:
            points: points of the unit cube, shape (any, size).

        Returns:
            The draws in the posterior's coordinates w, shape (any, q), and their log densities.
        """
        free = self._about_peak.size
        x = self._of_free.at(points[:, :free])
        z = self._of_pinned.at(points[:, free:]) if self._pinned else np.zeros((len(x), 0))
        mode, root = self._solved(x)
        v = np.concatenate([mode + np.einsum("kij,kj->ki", root, z), x], axis=1)
        w = self.posterior.at_deviates(self.peak.u + v @ self._axes.T)
        return w, self._density(x, z, root)

    def log_density(self, w: Points) -> Float[np.ndarray, " points"]:
        """Log densities at points w; each takes some crashes to solve for the mode."""
        x, z, root = self._seen(w)
        return self._density(x, z, root)

    def _density(
        self, x: np.ndarray, z: np.ndarray, root: np.ndarray
    ) -> Float[np.ndarray, " points"]:
        """Log densities of free directions and pinned ones, whose covariances have these roots."""
        found = self._of_free.log_density(x) - np.linalg.slogdet(self._axes)[1]
        if self._pinned:
            volume = np.log(np.diagonal(root, axis1=1, axis2=2)).sum(axis=1)
            found += self._of_pinned.log_density(z) - volume
        return found + self.posterior.log_volume

    def _seen(self, w: Points) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Free directions, pinned ones in standard deviations about their modes, and roots, at w."""
        v = np.linalg.solve(self._axes, (self.posterior.deviates(w) - self.peak.u).T).T
        x = v[:, self._pinned :]
        mode, root = self._solved(x)
        z = np.linalg.solve(root, (v[:, : self._pinned] - mode)[..., None])[..., 0]
        return x, z, root

    def moved(self, w: Points, log_weight: Float[np.ndarray, " points"]) -> Nested:
        """The proposal where weighted draws have shown the posterior to be.

        Args:
            w: draws in the posterior's coordinates, shape (any, q).
            log_weight: logs of their importance weights, shape (any,).
        """
        if not np.isfinite(log_weight).any():
            return self
        weights, _ = smoothed(log_weight)
        counts = weights > 0  # elsewhere may be no crash
        weights = weights[counts]
        x, z, _ = self._seen(w[counts])
        shown, about = _moments(x, weights), self._of_pinned
        if self._pinned:
            mean = weights @ z
            covariance = (z - mean).T @ (weights[:, None] * (z - mean))
            about = replace(about, tails=HEAVY).moved(mean, covariance, effective(weights))
        return Nested(self.posterior, self.peak, shown, about)

    @property
    def evaluations(self) -> int:
        """Density evaluations of a draw before its own, where no slopes of its own are asked for."""
        return 1

    @cached_property
    def _svd(self) -> tuple[np.ndarray, np.ndarray]:
        """Singular values of the slopes at the peak, and the directions that belong to them, all n."""
        s, directions = np.linalg.svd(self.peak.slopes)[1:]
        return s, directions.T

    @cached_property
    def _pinned(self) -> int:
        return int((self._svd[0] > _PINNED).sum())

    @cached_property
    def _axes(self) -> Float[np.ndarray, "n n"]:
        """Change of the deviates per standard deviation about the peak, pinned directions first."""
        s, directions = self._svd
        sd = np.ones(len(directions))
        sd[: len(s)] = 1 / np.sqrt(1 + s[: len(sd)] ** 2)
        return directions * sd

    @cached_property
    def _about_peak(self) -> _Free:
        """The free directions before any draws."""
        axes = self._axes[:, self._pinned :]
        deviates = np.linalg.norm(axes, axis=0)  # of one sd about the peak
        wide = 1 + (_WIDE - 1) * (1 - deviates**2)
        return _Free(-(self.peak.u @ axes) / deviates**2, 1 / deviates, np.zeros(len(wide)), wide)

    @cached_property
    def _of_free(self) -> _Free:
        """The free directions as draws have shown them, those of the sheet's fit if no others."""
        free = self._about_peak
        if self.shown is None:
            return replace(free, mean=self._sheet.middle) if self._pinned else free
        mean, sd = self.shown
        return replace(free, mean=mean, sd=sd * free.sd)

    @cached_property
    def _of_pinned(self) -> Proposal:
        n = self._pinned
        return self.about or Proposal.first(n, _TAILS)

    @cached_property
    def _crashes(self) -> Crashes:
        return self.posterior.crashes.in_steps(SUFFICIENT)

    @cached_property
    def _across(self) -> Float[np.ndarray, "n pinned"]:
        """Change of the deviates per standard deviation along each pinned direction."""
        return self._axes[:, : self._pinned]

    @cached_property
    def _at_peak(self) -> Float[np.ndarray, "pinned items"]:
        """Slopes along the pinned directions at the peak."""
        return (self.peak.slopes @ self._across).T

    @cached_property
    def _sheet(self) -> _Sheet:
        """The sheet as some draws show it; the slopes at the peak where too few can be solved for."""
        free, at_peak = self._about_peak.size, self._at_peak
        count = max(_LEAST, _EACH * (1 + free) * (2 + free) // 2)
        x = self._about_peak.at(np.random.default_rng(0).random((count, free)))
        mode, slopes = np.zeros((count, self._pinned)), np.tile(at_peak, (count, 1, 1))
        for _ in range(_FIRST_CHORDS):
            residuals = self._crashes.residuals(self._deviates(mode, x))
            mode, _ = self._stepped(mode, x, residuals, slopes)
        u = self._deviates(mode, x)
        residuals, slopes = self._linearised(mode, x)
        potential = (np.square(u).sum(axis=1) + np.square(residuals).sum(axis=1)) / 2
        mode, step = self._stepped(mode, x, residuals, slopes)
        length = np.linalg.norm(step, axis=1)
        found = (length > 0) & (length < _NEAR) & ~self._at_edge(slopes)  # no step: no crash
        of_x = terms(x)
        weight = found * float(found.sum() >= of_x.shape[1])
        wanted = np.concatenate([mode, (slopes - at_peak).reshape(count, -1)], axis=1)
        fitted = least_squares(of_x, wanted, weight)
        reach = np.abs(x).max(axis=0)
        # the posterior of the free directions, the pinned ones integrated by Laplace's approximation
        precision = self._precision(slopes)
        potential -= np.einsum("ki,kij,kj->k", step, precision, step) / 2
        height = -potential - np.linalg.slogdet(precision)[1] / 2
        log_weight = np.where(found, height - self._about_peak.log_density(x), -np.inf)
        # too few draws to tell a standard deviation better than the slopes at the peak do
        middle = _moments(x, smoothed(log_weight)[0])[0] if found.any() else np.zeros(free)
        return _Sheet(middle, fitted[:, : self._pinned], fitted[:, self._pinned :], at_peak, reach)

    def _solved(
        self, x: Float[np.ndarray, "points free"]
    ) -> tuple[Float[np.ndarray, "points pinned"], Float[np.ndarray, "points pinned pinned"]]:
        """Modes of the pinned directions given the free ones, and roots of their covariances.

        Where no crash is possible the covariance is that of the fit, or at the peak.
        """
        if not self._pinned:
            return np.zeros((len(x), 0)), np.zeros((len(x), 0, 0))
        mode, slopes = self._sheet.at(x)
        far = np.arange(len(x))
        before = moved = np.zeros(0)
        for done in range(_CORRECTED + _OWN):
            at = mode[far]
            if done >= _CORRECTED:
                residuals, slopes[far] = self._linearised(at, x[far])
            else:
                residuals = self._crashes.residuals(self._deviates(at, x[far]))
                if done:
                    slopes[far] = _corrected(slopes[far], moved, residuals - before)
            slopes[far] = self._of_no_edge(slopes[far])
            mode[far], step = self._stepped(at, x[far], residuals, slopes[far])
            on = np.linalg.norm(step, axis=1) > _ARRIVED
            if not on.any():
                break
            before, moved, far = residuals[on], (mode[far] - at)[on], far[on]
        return mode, np.linalg.cholesky(np.linalg.inv(self._precision(slopes)))

    def _at_edge(
        self, slopes: Float[np.ndarray, "points pinned items"]
    ) -> Bool[np.ndarray, " points"]:
        """Whether slopes are so steep that they are those of an edge of what is possible."""
        change = np.linalg.norm(slopes - self._at_peak, axis=(1, 2))
        return change > _OUTLYING * np.linalg.norm(self._at_peak)

    def _of_no_edge(
        self, slopes: Float[np.ndarray, "points pinned items"]
    ) -> Float[np.ndarray, "points pinned items"]:
        """The slopes, those at the peak in place of an edge's."""
        return np.where(self._at_edge(slopes)[:, None, None], self._at_peak, slopes)

    def _linearised(
        self, mode: np.ndarray, x: np.ndarray
    ) -> tuple[Float[np.ndarray, "points items"], Float[np.ndarray, "points pinned items"]]:
        """Residuals and slopes along the pinned directions; at the peak where there is no crash."""
        u = self._deviates(mode, x)
        ends = np.concatenate([u[:, None], u[:, None] + _STEP * self._across.T], axis=1)
        residuals = self._crashes.residuals(ends.reshape(-1, u.shape[1]))
        residuals = residuals.reshape(len(x), self._pinned + 1, -1)
        slopes = np.nan_to_num((residuals[:, 1:] - residuals[:, :1]) / _STEP)
        slopes[~np.isfinite(residuals[:, 0]).all(axis=1)] = self._at_peak
        return residuals[:, 0], slopes

    def _stepped(
        self, mode: np.ndarray, x: np.ndarray, residuals: np.ndarray, slopes: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Modes after a step of Gauss and Newton, and the step before it was shortened.

        Where there is no crash there is no step.
        """
        there = np.isfinite(residuals).all(axis=1, keepdims=True)
        across = self._deviates(mode, x) @ self._across
        uphill = (slopes @ np.nan_to_num(residuals)[..., None])[..., 0] + across
        step = np.linalg.solve(self._precision(slopes), -uphill[..., None])[..., 0]
        step = np.where(there, step, 0.0)
        return mode + _shortened(step), step

    def _precision(
        self, slopes: Float[np.ndarray, "points pinned items"]
    ) -> Float[np.ndarray, "points pinned pinned"]:
        return slopes @ slopes.swapaxes(1, 2) + self._across.T @ self._across

    def _deviates(self, mode: np.ndarray, x: np.ndarray) -> Points:
        return self.peak.u + np.concatenate([mode, x], axis=1) @ self._axes.T


def nested(posterior: Posterior) -> Nested | None:
    """The proposal about a posterior's peak; None where its coordinates are no deviates about one."""
    if posterior.peak is None or not posterior.programs.structure.in_deviates:
        return None
    return Nested(posterior, posterior.peak)


def _moments(x: Float[np.ndarray, "draws free"], weights: Float[np.ndarray, " draws"]) -> Moments:
    """Mean and standard deviation of weighted draws, nearer to 0 and 1 the fewer are effective."""
    mean = weights @ x
    variance = weights @ (x - mean) ** 2
    worth = effective(weights)
    share = worth / (worth + mean.size)
    return share * mean, np.sqrt(share * variance + 1 - share)


def _corrected(
    slopes: Float[np.ndarray, "points pinned items"],
    moved: Float[np.ndarray, "points pinned"],
    change: Float[np.ndarray, "points items"],
) -> Float[np.ndarray, "points pinned items"]:
    """Slopes that agree with how residuals changed along a step (Broyden 1965); as before where NaN."""
    missed = np.nan_to_num(change - np.einsum("kij,ki->kj", slopes, moved))
    squared = np.maximum(np.square(moved).sum(axis=1), 1e-300)
    return slopes + moved[:, :, None] * (missed / squared[:, None])[:, None, :]


def _shortened(step: Float[np.ndarray, "points pinned"]) -> Float[np.ndarray, "points pinned"]:
    length = np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)
    return step * np.minimum(1.0, _STRIDE / length)
