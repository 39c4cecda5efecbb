"""A scene's posterior as a function in good coordinates: its density, and its unknowns."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import jax
import numpy as np

from retrodict.inference.density.compiled import Programs, in_chunks, programs_for
from retrodict.inference.density.kernels import EVALUATE, rows_of
from retrodict.inference.density.log_density import Evaluated
from retrodict.inference.fitting import regression
from retrodict.inference.fitting.basins import Basins
from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.fitting.optimise import Potential
from retrodict.inference.fitting.search import Peak
from retrodict.inference.transforms import layout
from retrodict.inference.transforms.choice import Transform
from retrodict.inference.transforms.parameters import Affine
from retrodict.inference.transforms.rest_pose import RestPose
from retrodict.inference.transforms.standard import Deviates
from retrodict.models import parts
from retrodict.models.arrays import Data, in_steps, steps_of

LEAST_WEIGHT = 1e-3  # weight from which on another mode counts
_AS_DRAWS = 10  # number of draws that the whitening at the mode counts for when draws whiten


@dataclass(frozen=True)
class Posterior:
    """A posterior ready to be sampled: near w = 0 it is close to a standard normal.

    Args:
        programs: compiled functions, among them the density and its gradient.
        data: the scene's numbers.
        transform: the coordinates, centred and whitened at the mode.
        regression_error: error of the fitted regressions for A and B, in standard deviations of the
            rest pose, shape (2,).
        log_evidence: log evidence by the Laplace approximation at the mode.
        unresolved: integration error of the run-outs' predictions, in standard deviations.
        basins: share of the density that belongs to this peak, in deviates; None for all of it.
        peak: peak that the coordinates are about, in deviates; None where there is none.
    """

    programs: Programs
    data: Data
    transform: Transform
    regression_error: np.ndarray
    log_evidence: float
    unresolved: float
    basins: Basins | None = None
    peak: Peak | None = None

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return self.transform.whitening.size

    @cached_property
    def potential(self) -> Potential:
        """Minus the log density."""
        return Potential(self._exact, self._alike)

    def _exact(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The potential at points, and exact minus surrogate predictions."""
        there = self._located(w)
        return -there.log_density, there.missed

    def _alike(self, w: np.ndarray, missed: np.ndarray) -> np.ndarray:
        """The potential at points if surrogates missed by the given amounts: needs no run-out."""
        return -self._located(w, missed).log_density

    def log_density(self, w: np.ndarray) -> np.ndarray:
        """The log density at many points at once; w has shape (any, q)."""
        return self.evaluate(w)[0]

    @property
    def refits(self) -> bool:
        """Whether a fit to draws improves the coordinates or the surrogates."""
        structure = self.programs.structure
        return structure.in_deviates or bool(layout.with_response_surface(structure))

    def refit(self, w: np.ndarray) -> Posterior:
        """The same posterior, whitened by draws or with response surfaces fitted to them.

        Args:
            w: the draws, shape (any, q).
        """
        whitens = self.programs.structure.in_deviates
        return self.whitened_by(w) if whitens else self.with_responses(w)

    def whitened_by(self, w: np.ndarray) -> Posterior:
        """The same posterior, whitened by draws if its coordinates are deviates; else unchanged.

        Args:
            w: the draws, shape (any, q).
        """
        if not isinstance(self.transform, Deviates):
            return self
        spread = np.asarray(self.transform.whitening.spread)
        # part of the former spread, so that few draws do not make it flat
        covariance = (w.shape[0] * np.cov(w.T) + _AS_DRAWS * np.eye(self.size)) / (
            w.shape[0] + _AS_DRAWS
        )
        centre = np.asarray(self.transform.whitening.centre) + spread @ w.mean(axis=0)
        whitened = Affine.about(centre, spread @ np.linalg.cholesky(covariance))
        return replace(self, transform=self.transform._replace(whitening=whitened))

    def with_responses(self, w: np.ndarray) -> Posterior:
        """The same posterior with responses fitted to the run-outs at points; w has shape (any, q)."""
        structure, quantities = self.programs.structure, self.evaluate(w)[1]
        on_way = RestPose.surrogates(structure)[len(structure.rest_components) :]
        predicted = {k: quantities[f"predicted/{k}"] for k in on_way}
        responses = regression.responses(structure, self.data, run_outs_of(quantities), predicted)
        return replace(self, transform=self.in_rest_poses._replace(responses=responses))

    def converted_to(self, other: Posterior, w: np.ndarray) -> np.ndarray:
        """Points in the coordinates of the same posterior, whitened by draws or as it was before.

        Args:
            other: posterior whose coordinates are asked for.
            w: points in these coordinates, shape (any, q).
        """
        if not self.programs.structure.in_deviates:
            return w
        return other.transform.whitening.inverse(self.transform.whitening.transform(w))

    def evaluate(self, w: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """`log_density`; and the model's unknowns and what follows from them, at the same points."""
        there = self._located(w)
        return there.log_density, there.quantities

    def constrained(self, w: np.ndarray) -> np.ndarray:
        """q at w after constraints have moved it, shape (q,)."""
        return np.asarray(self._located(w[None]).q[0])

    def _located(self, w: np.ndarray, missed: np.ndarray | None = None) -> Evaluated[np.ndarray]:
        """Values of the posterior at points; rest poses by their surrogate if `missed` is given."""
        data, transform = self._numbers
        structure = self.programs.structure
        if structure.in_deviates:
            return self._at_deviates(w)
        if missed is None:
            count = len(RestPose.surrogates(structure))
            missed = np.full((len(w), count), np.nan)
        elif structure.steps is None:
            data = data._replace(steps=data.steps._replace(number=np.array(0)))
        return in_chunks(
            lambda at: self.programs(EVALUATE, data, transform, *at),
            (w, missed),
            rows_of(structure),
        )

    def _at_deviates(self, w: np.ndarray) -> Evaluated[np.ndarray]:
        """`_located` where coordinates are deviates: the transform needs no compiled program."""
        u = self.deviates(w)
        log_likelihood, quantities = self.crashes.at(u)
        log_prior = -np.square(u).sum(axis=1) / 2 - u.shape[1] / 2 * np.log(2 * np.pi)
        if self.basins is not None:
            log_likelihood = log_likelihood + self.basins.log_share(u)
        return Evaluated(
            log_prior + log_likelihood + self.log_volume, quantities, u, np.zeros((len(w), 0))
        )

    @property
    def in_deviates(self) -> Deviates:
        """The transform where deviates are coordinates."""
        assert isinstance(self.transform, Deviates), "else rest poses are coordinates"
        return self.transform

    @property
    def in_rest_poses(self) -> RestPose:
        """The transform where rest poses are coordinates."""
        assert isinstance(self.transform, RestPose), "else deviates are coordinates"
        return self.transform

    def deviates(self, w: np.ndarray) -> np.ndarray:
        """Deviates at points, where these are coordinates; shape (any, n)."""
        return self.in_deviates.transform(w)

    def at_deviates(self, u: np.ndarray) -> np.ndarray:
        """Points w at given deviates, where these are coordinates; shape (any, n)."""
        return self.in_deviates.inverse(u)

    @property
    def log_volume(self) -> float:
        """Log |d deviates / d w|, the same everywhere."""
        return self.in_deviates.log_volume

    @cached_property
    def crashes(self) -> Crashes:
        """The crashes that the model allows, as functions of deviates."""
        return Crashes(programs_for(self.programs.structure.without_transform), self.data)

    def differentiable(self) -> Posterior:
        """The same posterior by programs with reverse-mode derivatives, in as many integration steps."""
        structure = self.programs.structure
        if not structure.in_deviates or structure.steps:
            return self
        fixed = structure.differentiable
        if not structure.paced:
            fixed, _ = in_steps(fixed, self.data, steps_of(structure, self.data))
        return replace(self, programs=programs_for(fixed))

    @cached_property
    def _numbers(self) -> tuple[Data, Transform]:
        """Arguments of the programs besides w, given to JAX once: that takes as long as a call."""
        return jax.device_put((self.data, self.transform))


def run_outs_of(quantities: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Velocities after the impact and deviates of the inputs, a row for each crash."""
    V = np.stack(
        [quantities[k] for of_one in parts.AFTER for k in of_one if k in quantities], axis=1
    )
    return V, quantities.get("measured", np.zeros((len(V), 0)))
