"""Coordinates made for a scene, taken over to one of the same structure with other numbers: no run-out.

The density stays exact in any coordinates. Those of a neighbouring scene only cost efficiency, and cost
little once the regressions count from what is measured now.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.fitting.whitening import whitened_about
from retrodict.inference.transforms import rest_pose
from retrodict.inference.transforms.parameters import REACH, Quadratic, saturated
from retrodict.models.arrays import Data, Structure
from retrodict.scene.records import VEHICLES


def rebased(
    posterior: Posterior, data: Data, constrained: Float[np.ndarray, " q"] | None = None
) -> Posterior:
    """A posterior of other numbers, in the coordinates of one that was fitted.

    Args:
        posterior: as it was fitted.
        data: the other numbers, of the same structure.
        constrained: where constraints take its centre; None where that is not known yet.

    Returns:
        The posterior; its log evidence is unknown. How well it is resolved is what the fitted one was,
        in the standard deviations that now hold.
    """
    structure, before = posterior.programs.structure, posterior.data
    data = data._replace(steps=before.steps)
    sharper = [before.evidence[k][1] / data.evidence[k][1] for k in structure.evidence]
    found = replace(
        posterior,
        data=data,
        log_evidence=-np.inf,
        peak=None,  # that of the other numbers is elsewhere
        unresolved=posterior.unresolved * float(np.max([1.0, *sharper])),
    )
    transform = posterior.transform
    if not transform.regressions[0].constant.size:
        return found
    for_a, for_b = (
        _rebased(structure, before, data, v, regression)
        for v, regression in zip(VEHICLES, transform.regressions, strict=True)
    )
    if structure.in_deviates:
        return replace(found, transform=transform._replace(regressions=(for_a, for_b)))
    about = whitened_about(
        posterior.programs,
        data,
        (for_a, for_b),
        np.asarray(transform.centre),
        np.asarray(transform.spread),
        posterior.constrained(np.zeros(posterior.size)) if constrained is None else constrained,
        np.asarray(transform.constraints.side),
        float(transform.constraints.kept),
    )
    return replace(found, transform=about._replace(responses=transform.responses))


def _rebased(
    structure: Structure, before: Data, now: Data, v: str, regression: Quadratic
) -> Quadratic:
    """A vehicle's regression by deviates from what is measured now.

    They are affine in those before; quadratic terms, whose argument saturates, follow to first order.
    """
    if v in structure.inverted:
        return regression
    rests = structure.rest_components
    own = rests[: len(rests) // 2] if v == VEHICLES[0] else rests[len(rests) // 2 :]
    shaping = [structure.names[i] for i in rest_pose.shaping_inputs(structure, v)]
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
    """The measured friction of the surface that lies everywhere."""
    name = f"friction_{structure.surfaces[0]}"
    value = float(data.inputs[name][0])
    return np.exp(value) if dict(structure.uncertain).get(name) == "lognormal" else value
