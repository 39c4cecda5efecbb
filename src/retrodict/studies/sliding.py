"""An answer under each of two assumptions: that sliding ended within the contact, and that it did not.

Which it was decides much of a speed that follows from delta-v along a grazing contact, and no source
says how often sliding ends in a contact of a kind (docs/validation.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Float

from retrodict.inference.pareto import weighted_quantiles
from retrodict.studies.comparison import SHARE
from retrodict.studies.fit import LEVELS, Summary, summary

if TYPE_CHECKING:
    from retrodict.inference.outcome import Outcome

TOLERANCE = 0.02  # scale of what is left of the sliding where it counts as ended
LEFT = 0.05  # of the sliding, at least, where it counts as having gone on
_HUGE = 1e9  # critical friction of a contact in which no friction ends the sliding
_MIN_EFFECTIVE = 100  # draws: fewer make limits of an interval that move with the seed

Draws = Float[np.ndarray, " draws"]


@dataclass(frozen=True, slots=True)
class BySliding:
    """A speed under both assumptions (m/s).

    Args:
        name: flat name of the speed.
        ended: the speed if sliding along the contact line ended within the contact.
        went_on: the speed if more than `LEFT` of the sliding was left.
        effective: effective number of draws behind each assumption, the smaller.
    """

    name: str
    ended: Summary
    went_on: Summary
    effective: float


def by_sliding(outcome: Outcome, *names: str) -> tuple[BySliding, ...]:
    """Speeds under both assumptions, where these differ and the evidence allows both.

    Args:
        outcome: the reconstruction.
        names: flat names of the speeds.

    Returns:
        A record for each speed whose two medians differ by more than a quarter of its standard
        deviation; none where the model or the user decides on μ, parts may have interlocked, or fewer
        than 100 effective draws are left to an assumption.
    """
    if (log_weight := log_ratio_of_ended(outcome)) is None:
        return ()
    weight = np.exp(log_weight - log_weight.max())
    went_on = left_of_sliding(outcome) > LEFT
    effective = min(float(weight.sum() ** 2 / (weight**2).sum()), float(went_on.sum()))
    if effective < _MIN_EFFECTIVE:
        return ()
    posterior = outcome.idata["posterior"]
    found = []
    for name in names:
        draws = np.asarray(posterior[name]).ravel()
        each = BySliding(name, weighted(draws, weight), summary(draws[went_on]), effective)
        if abs(each.went_on.median - each.ended.median) > SHARE * draws.std(ddof=1):
            found.append(each)
    return tuple(found)


def left_of_sliding(outcome: Outcome) -> Draws:
    """Share of the sliding that is left after the contact, 1 − μ/μ_c, of each draw.

    Args:
        outcome: a reconstruction by a model with a free μ.
    """
    mu, critical = _friction(outcome)
    return 1 - mu / critical


def log_ratio_of_ended(outcome: Outcome) -> Draws | None:
    """Log density of μ where sliding ends, less that of the default prior, at each draw.

    Args:
        outcome: a reconstruction.

    Returns:
        The logarithms, whose exponentials have mean 1 over the prior; None where the model has no free
        μ, the user gave its prior, or parts may have interlocked.
    """
    scene, tree = outcome.scene, outcome.idata
    if "log_prior" not in tree.children or "mu" not in tree["log_prior"].data_vars:
        return None
    if "mu_critical" not in tree["posterior"].data_vars:
        return None
    if scene.priors["mu"].family or scene.contact.interlocked:
        return None
    _, critical = _friction(outcome)
    size = np.abs(critical)
    left = left_of_sliding(outcome)
    default = np.asarray(tree["log_prior"]["mu"]).ravel()
    constant = np.log(2 / (TOLERANCE * np.sqrt(2 * np.pi)))
    return constant - left**2 / (2 * TOLERANCE**2) - np.log(size) - default


def weighted(draws: Draws, weight: Draws) -> Summary:
    """Median, sd and central intervals of weighted draws.

    Args:
        draws: values, shape (draws,).
        weight: weights of any scale, shape (draws,).
    """
    share = weight / weight.sum()
    half = np.array(LEVELS) / 200
    median, low, high = (weighted_quantiles(share, draws, q) for q in (0.5, 0.5 - half, 0.5 + half))
    sd = float(np.sqrt(share @ (draws - share @ draws) ** 2))
    bounds = zip(low.tolist(), high.tolist(), strict=True)
    return Summary(float(median), sd, dict(zip(LEVELS, bounds, strict=True)))


def _friction(outcome: Outcome) -> tuple[Draws, Draws]:
    """μ and its critical value, which is huge where friction does not end the sliding."""
    posterior = outcome.idata["posterior"]
    mu, critical = (np.asarray(posterior[name]).ravel() for name in ("mu", "mu_critical"))
    return mu, np.clip(
        np.nan_to_num(critical, nan=_HUGE, posinf=_HUGE, neginf=-_HUGE), -_HUGE, _HUGE
    )
