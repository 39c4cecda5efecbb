"""The reference that needs no coordinates: crashes of the prior, weighted by their likelihood.

Where the evidence leaves enough of them they give the posterior a second time, and cannot miss a part
of it. An answer that differs from theirs beyond Monte Carlo error is withheld.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.special import softmax

from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.samplers.psis import effective, log_mean
from retrodict.scene.quantities import describe, si_symbol


@dataclass(frozen=True)
class PriorCheck:
    """Settings of the reference.

    Args:
        first: number of crashes of the prior that are always drawn.
        most: largest number of crashes, where `promising` of the first ones are effective.
        promising: number of effective crashes among the first from which on more are drawn.
        enough: number of effective crashes at which no more are drawn.
        least: number of effective crashes from which on they can refute draws.
        errors: number of standard errors between means, between variances, or between the logs of the
            evidence, that refutes draws.
        heavy: largest weight of one crash above which no draws can be refuted.
    """

    first: int = 4096
    most: int = 65_536
    promising: float = 6.0
    enough: float = 1500.0
    least: float = 40.0
    errors: float = 5.0
    heavy: float = 0.1


SETTINGS = PriorCheck()


@dataclass(frozen=True)
class Reference:
    """Weighted crashes of the prior.

    Args:
        quantities: reported quantities of each crash, by name.
        weights: likelihood weights of the crashes, shape (crashes,); they sum to one, or all are zero.
        every: all quantities of the first crashes, by name.
        log_evidence: log of the mean likelihood of the crashes, and its standard error.
    """

    quantities: dict[str, np.ndarray]
    weights: Float[np.ndarray, " crashes"]
    every: dict[str, np.ndarray]
    log_evidence: tuple[float, float] = (-np.inf, np.inf)

    @property
    def effective(self) -> float:
        """Number of crashes of equal weight that would say as much."""
        return effective(self.weights) if self.weights.any() else 0.0

    def refutes(self, settings: PriorCheck) -> bool:
        """Whether there are enough crashes of weight to refute draws."""
        return self.effective >= settings.least and self.weights.max() <= settings.heavy


def reference(
    crashes: Crashes, names: tuple[str, ...], seed: int, settings: PriorCheck = SETTINGS
) -> Reference:
    """Crashes of the prior, as many as are of use.

    Args:
        crashes: crashes that the model allows, by deviates.
        names: reported quantities, which are compared.
        seed: integer seed of the random number generator.
        settings: settings of the reference.
    """
    rng = np.random.default_rng([seed, 9])
    every: dict[str, np.ndarray] = {}
    kept: list[dict[str, np.ndarray]] = []
    every_height: list[np.ndarray] = []
    count = settings.first
    while True:
        height, quantities = crashes.of_nearest_turns(rng.standard_normal((count, crashes.size)))
        every = every or {k: np.asarray(v) for k, v in quantities.items()}
        kept.append({k: np.asarray(v) for k, v in quantities.items() if k in names})
        every_height.append(height)
        height = np.concatenate(every_height)
        weights = softmax(height) if np.isfinite(height).any() else np.zeros(height.size)
        worth = effective(weights) if weights.any() else 0.0
        drawn = height.size
        if worth < settings.promising or worth >= settings.enough or drawn >= settings.most:
            break
        count = min(drawn, settings.most - drawn)
    found = {k: np.concatenate([some[k] for some in kept]) for k in kept[0]}
    return Reference(found, weights, every, log_mean(height))


def refuted(
    reference: Reference,
    draws: Mapping[str, np.ndarray],
    worth: Mapping[str, float],
    settings: PriorCheck = SETTINGS,
) -> dict[str, str]:
    """Quantities that the reference refutes: a sentence with both numbers, by name of the quantity.

    Args:
        reference: weighted crashes of the prior.
        draws: draws of the posterior, by name, each of any shape.
        worth: effective sample size of each quantity's draws.
        settings: settings of the reference.
    """
    if not reference.refutes(settings):
        return {}
    weights, found = reference.weights, {}
    for name, values in reference.quantities.items():
        if name not in draws:
            continue
        own, count = np.asarray(draws[name], float).ravel(), max(worth.get(name, 1.0), 1.0)
        mean = float(weights @ values)
        sd = float(np.sqrt(weights @ (values - mean) ** 2))
        # the errors of the reference by its own weights, to first order
        of_mean = np.sqrt(np.sum((weights * (values - mean)) ** 2) + own.var() / count)
        of_square = np.sum((weights * ((values - mean) ** 2 - sd**2)) ** 2)
        of_square += np.var((own - own.mean()) ** 2) / count
        errors = abs(own.mean() - mean) / max(of_mean, 1e-300)
        apart = abs(own.var() - sd**2) / max(np.sqrt(of_square), 1e-300)
        if max(errors, apart) > settings.errors:
            label, dimension = describe(name)
            unit = si_symbol(dimension)
            both = " against ".join(
                f"{m:.3g} ± {s:.2g} {unit}".rstrip()
                for m, s in ((own.mean(), own.std()), (mean, sd))
            )
            found[name] = (
                f"{label}: {both} {_by(reference, max(errors, apart))}: part of the posterior is missing"
            )
    return found


def refuted_evidence(
    reference: Reference, log_evidence: float, error: float, settings: PriorCheck = SETTINGS
) -> tuple[str, ...]:
    """The share of the posterior that draws stand for, in a sentence, if not all of it; else nothing.

    Means can agree by chance where a part of the posterior is missing; the evidence cannot.

    Args:
        reference: weighted crashes of the prior.
        log_evidence: log evidence by the draws.
        error: standard error of the log evidence; NaN if unknown.
        settings: settings of the reference.
    """
    if not reference.refutes(settings):
        return ()
    own, of_own = reference.log_evidence
    errors = abs(log_evidence - own) / np.hypot(error, of_own)
    if not errors > settings.errors:  # not a number where an error is unknown
        return ()
    share = np.exp(log_evidence - own)
    return (
        f"the draws stand for {share:.2g} of the posterior {_by(reference, errors)}: part of it is "
        + ("missing" if share < 1 else "counted twice"),
    )


def _by(reference: Reference, errors: float) -> str:
    return (
        f"by {reference.effective:.0f} crashes of the prior weighted by the evidence, {errors:.0f} "
        "standard errors apart"
    )
