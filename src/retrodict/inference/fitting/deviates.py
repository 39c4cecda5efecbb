"""A scene's crashes as functions of standard normal deviates of all unknowns, and their residuals.

The posterior is a sum of squares in these coordinates: half the square of the deviates, plus half that
of the residuals.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import jax
import numpy as np
from jaxtyping import Float, Int

from retrodict.inference.density.compiled import Programs, in_chunks
from retrodict.inference.density.kernels import CRASHES, rows_of
from retrodict.inference.density.together import room
from retrodict.inference.fitting.ceilings import ceilings
from retrodict.inference.own import SLOPE, TERM
from retrodict.models import evidence as items
from retrodict.models.arrays import Data, in_steps, steps_of
from retrodict.scene.names import parsed
from retrodict.scene.records import FREEDOM

_STEP = 1e-3  # step of a deviate in difference quotients

Deviates = Float[np.ndarray, "crashes n"]
Residuals = Float[np.ndarray, "crashes items"]
Quantities = dict[str, np.ndarray]
Turns = dict[str, Int[np.ndarray, " crashes"]]
"""Whole turns from the written rest heading of vehicles whose rotation is unknown."""


@dataclass(frozen=True)
class Crashes:
    """The crashes that a model allows, as functions of deviates.

    Args:
        programs: compiled programs of the scene's structure.
        data: numbers of the scene.
        modulo: names of the items of evidence that are angles whose whole turns were not counted.
    """

    programs: Programs
    data: Data
    modulo: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Number of deviates."""
        return self.programs.structure.deviates

    def at(
        self, u: Deviates, names: frozenset[str] | None = None
    ) -> tuple[Float[np.ndarray, " crashes"], Quantities]:
        """Log likelihood of crashes, minus infinity where there is none, and their quantities.

        Args:
            u: deviates, shape (crashes, n).
            names: quantities that are needed, of those that residuals need; None for all.
        """
        if (others := room()) is not None:
            log_likelihood, quantities = others.at(self.programs, self.data, u, names)
        else:
            data = self._on_device

            def some(u: Deviates) -> tuple[Any, dict[str, Any]]:
                log_likelihood, every = self.programs(CRASHES, data, u)
                # what nobody needs is not copied
                return log_likelihood, {k: every[k] for k in names or every}

            rows = rows_of(self.programs.structure)
            log_likelihood, quantities = in_chunks(some, np.asarray(u, float), rows)
        return np.nan_to_num(
            log_likelihood, nan=-np.inf, posinf=-np.inf, neginf=-np.inf
        ), quantities

    def in_steps(self, count: int) -> Crashes:
        """The crashes in so many integration steps at most; where wheels roll, steps adapt."""
        structure = self.programs.structure
        if structure.steps or structure.paced or steps_of(structure, self.data) <= count:
            return self
        return replace(self, data=in_steps(structure, self.data, count)[1])

    def residuals(self, u: Deviates, turns: Turns | None = None) -> Residuals:
        """Residuals whose half squares are minus the log likelihood of each item.

        Residuals are prediction minus measurement, in standard deviations of the measurement; NaN where
        the model allows no such crash.

        Args:
            u: deviates, shape (crashes, n).
            turns: whole turns to count for each angle of `modulo`; None for the nearest.
        """
        return self._residuals(*self.at(u, self._for_residuals), turns)

    def with_quantities(
        self, u: Deviates, turns: Turns | None = None
    ) -> tuple[Residuals, Quantities]:
        """`residuals` of crashes, and all their quantities by name."""
        log_likelihood, quantities = self.at(u)
        return self._residuals(log_likelihood, quantities, turns), quantities

    def of_nearest_turns(self, u: Deviates) -> tuple[Float[np.ndarray, " crashes"], Quantities]:
        """`at`, by the nearest of the turns that each angle of `modulo` may have."""
        log_likelihood, quantities = self.at(u)
        if not self.modulo:
            return log_likelihood, quantities
        as_written = {parsed(name).vehicle: np.zeros(len(u), int) for name in self.modulo}
        potential, of_nearest = (
            np.square(self._residuals(log_likelihood, quantities, turns)).sum(axis=1) / 2
            for turns in (as_written, None)
        )
        log_likelihood = log_likelihood + np.nan_to_num(potential - of_nearest)
        return log_likelihood, quantities

    @cached_property
    def _for_residuals(self) -> frozenset[str]:
        """Names of the quantities that residuals follow from."""
        evidence = self.programs.structure.evidence
        bounds = [f"log_likelihood/{name}" for name in evidence if _is_bound(name)]
        own = [f"{kind}{name}" for kind in (TERM, SLOPE) for name, _ in self.programs.structure.own]
        return frozenset([*(f"predicted/{name}" for name in evidence), *bounds, *own])

    def _residuals(
        self, log_likelihood: np.ndarray, quantities: Quantities, turns: Turns | None
    ) -> Residuals:
        structure = self.programs.structure
        found = []
        for name in structure.evidence:
            value, sd = self.data.evidence[name]
            off = quantities[f"predicted/{name}"] - value
            if _is_bound(name):
                height = np.minimum(quantities[f"log_likelihood/{name}"], 0)
                found.append(np.sign(off) * np.sqrt(-2 * height))
                continue
            if name in self.modulo and turns is not None:
                off = off - 2 * np.pi * turns[parsed(name).vehicle]
            elif name in self.modulo:
                off = np.arctan2(np.sin(off), np.cos(off))
            off = off / sd
            if structure.robust:
                heavy = (FREEDOM + 1) * np.log1p(off**2 / FREEDOM)
                off = np.sign(off) * np.sqrt(heavy)
            found.append(off)
        for name, highest in self.ceilings.items():
            height = np.asarray(quantities[f"{TERM}{name}"])
            off = np.sqrt(2 * np.maximum(highest - np.nan_to_num(height, nan=-np.inf), 0))
            found.append(np.where(quantities[f"{SLOPE}{name}"] > 0, -off, off))
        residuals = np.stack(found, axis=1) if found else np.zeros((len(log_likelihood), 0))
        return np.where(np.isfinite(log_likelihood)[:, None], residuals, np.nan)

    @cached_property
    def ceilings(self) -> dict[str, float]:
        """Highest value of each likelihood term of the user's own, by name."""
        return ceilings(self.programs.structure, self.data, self.at)

    def linearised(
        self, u: Deviates, turns: Turns | None = None
    ) -> tuple[Residuals, Float[np.ndarray, "crashes items n"]]:
        """Residuals of crashes, and their derivatives by the deviates, by difference quotients.

        Arguments as of `residuals`.
        """
        count, n = u.shape
        # beyond a nearby bound there may be no crash
        ends = np.concatenate([u[:, None], u[:, None] + _STEP * np.eye(n)], axis=1)
        every = turns and {v: np.repeat(own, n + 1) for v, own in turns.items()}
        residuals = self.residuals(ends.reshape(-1, n), every).reshape(count, n + 1, -1)
        slopes = np.moveaxis(residuals[:, 1:] - residuals[:, :1], 1, -1) / _STEP
        return residuals[:, 0], np.nan_to_num(slopes)

    @cached_property
    def _on_device(self) -> Data:
        return jax.device_put(self.data)


def _is_bound(name: str) -> bool:
    """Whether an item of evidence states a bound."""
    if name in items.OF_IMPACT:
        return items.OF_IMPACT[name].bound is not None
    kind, _, mark = parsed(name)
    return mark is None and items.PREDICTIONS[kind].at_least
