"""Coordinates made for one scene, reused for another of the same structure without any run-out.

The density stays exact in any coordinates. Those of a neighbouring scene only cost efficiency, and cost
little once the regressions count from the new scene's measurements.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.fitting.whitening import whitened_about
from retrodict.inference.transforms import layout
from retrodict.inference.transforms.parameters import REACH, Quadratic, saturated
from retrodict.inference.transforms.standard import Deviates
from retrodict.models.arrays import Data, Structure
from retrodict.scene.records import VEHICLES


def rebased(
    posterior: Posterior, data: Data, constrained: Float[np.ndarray, " q"] | None = None
) -> Posterior:
    """The posterior of a scene with other numbers, in the coordinates of a fitted posterior.

    Args:
        posterior: fitted posterior.
        data: numbers of the other scene, of the same structure.
        constrained: q at its centre after constraints moved it, shape (q,); None if not known yet.

    Returns:
        The posterior; its log evidence is unknown. Its integration error is that of the fitted one,
        scaled by the largest ratio of former to new standard deviations if that exceeds 1.
    """
    structure, before = posterior.programs.structure, posterior.data
    data = data._replace(steps=before.steps)
    sharper = [before.evidence[k][1] / data.evidence[k][1] for k in structure.evidence]
    found = replace(
        posterior,
        data=data,
        log_evidence=-np.inf,
        peak=None,  # the other scene has its peak elsewhere
        unresolved=posterior.unresolved * float(np.max([1.0, *sharper])),
    )
    transform = posterior.transform
    if isinstance(transform, Deviates):
        return found
    for_a, for_b = (
        _rebased(structure, before, data, v, regression)
        for v, regression in zip(VEHICLES, transform.regressions, strict=True)
    )
    about = whitened_about(
        posterior.programs,
        data,
        (for_a, for_b),
        np.asarray(transform.whitening.centre),
        np.asarray(transform.whitening.spread),
        posterior.constrained(np.zeros(posterior.size)) if constrained is None else constrained,
        np.asarray(transform.constraints.side),
        float(transform.constraints.kept),
    )
    return replace(found, transform=about._replace(responses=transform.responses))


def _rebased(
    structure: Structure, before: Data, now: Data, v: str, regression: Quadratic
) -> Quadratic:
    """A vehicle's regression as a function of deviates from the new measurements.

    The new deviates are affine in the former ones; quadratic terms, whose argument saturates, are
    converted to first order.
    """
    if v in structure.inverted:
        return regression
    rests = structure.rest_components
    own = rests[: len(rests) // 2] if v == VEHICLES[0] else rests[len(rests) // 2 :]
    shaping = [structure.names[i] for i in layout.shaping_inputs(structure, v)]
    pairs = [
        (before.evidence[k], now.evidence[k]) if k in before.evidence else ((0.0, 1.0),) * 2
        for k in own
    ]
    pairs += [(before.inputs[k], now.inputs[k]) for k in shaping]
    (middle, sd), (middle_now, sd_now) = np.array(pairs).transpose(1, 2, 0)
    shift, rate = (middle_now - middle) / sd, sd_now / sd

    constant, linear, quadratic = map(np.asarray, regression)
    bent = saturated(shift, np)
    by_bent = quadratic @ bent
    steepness = rate * (1 - (bent / REACH) ** 2)
    scale = _friction(structure, before) / _friction(structure, now)
    # velocities count over the square root of friction over its measured value
    return Quadratic(
        scale**-0.5 * (constant + linear @ shift + by_bent @ bent),
        scale**-0.5 * (linear * rate + 2 * by_bent * steepness),
        scale**-0.5 * quadratic * np.outer(steepness, steepness),
    )


def _friction(structure: Structure, data: Data) -> float:
    """The measured friction of the first surface, which lies everywhere."""
    name = f"friction_{structure.surfaces[0]}"
    value = float(data.inputs[name][0])
    return np.exp(value) if dict(structure.uncertain).get(name) == "lognormal" else value
