"""The corner range: the least and the greatest speed over all measurements at their limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retrodict.studies.draws import NotAnswered

if TYPE_CHECKING:
    from retrodict.inference.fitting.posterior import Posterior
    from retrodict.inference.outcome import Outcome

LIMITS = (1.0, 2.0)  # standard deviations
_STEP = 0.01  # step of finite differences, in standard deviations
_ROUNDS, _CLOSE, _MISSED = 12, 1e-4, 0.05  # standard deviations of a rest pose


@dataclass(frozen=True, slots=True)
class Corner:
    """The range of B's speed before the impact over a box of measurements (m/s).

    Args:
        limit: half-width of the box, in standard deviations of each measurement.
        least, greatest: least and greatest of the speeds that measurements in the box solve back to.
    """

    limit: float
    least: float
    greatest: float


def corners(outcome: Outcome) -> tuple[Corner, ...]:
    """The range of B's speed with every measurement up to so many standard deviations off.

    The measured rest poses and inputs are solved back to B's speed, without priors or bounds, as the
    methods `monte-carlo` and `linear` do; the run-outs are inverted exactly. The least and the greatest
    value over the box are sought from the corner that the derivatives point to (L-BFGS-B), so that an
    extreme inside the box is found too.

    Args:
        outcome: the reconstruction, whose model is solved back.

    Returns:
        One record a limit.

    Raises:
        NotAnswered: the scene is not solved back, for rest poses or A's speed were not measured, the
            wheels rolled, or the model has fewer unknowns.
    """
    from retrodict.inference.transforms.layout import length_for_regressions  # imports jax

    posterior = _posterior(outcome)
    solve_back = _solver(posterior)
    count = length_for_regressions(posterior.programs.structure)
    return tuple(
        Corner(limit, *(sign * _least(solve_back, count, limit, sign) for sign in (1.0, -1.0)))
        for limit in LIMITS
    )


def _posterior(outcome: Outcome) -> Posterior:
    from retrodict.inference.fitting.about_peak import prepare
    from retrodict.inference.transforms.choice import Coordinates  # imports jax
    from retrodict.inference.transforms.layout import length_for_regressions
    from retrodict.models import RUNGS

    name = outcome.description.name
    if name not in RUNGS:
        raise NotAnswered(f"the model {name} is not one of this version")
    if outcome.scene.single:
        raise NotAnswered("corners are of the speed of a vehicle B, and the scene has none")
    structure, _ = RUNGS[name].of_scene(outcome.scene)
    halfnormal = ("speed_a", "halfnormal") in structure.uncertain
    if structure.in_deviates or structure.unmeasured or structure.paced or halfnormal:
        raise NotAnswered(
            "corners are solved back from the rest of both vehicles on locked wheels and A's measured "
            "speed, which this scene does not have"
        )
    posterior = prepare(outcome.scene, name, Coordinates.SOLVED_BACK)
    if length_for_regressions(structure) > posterior.size:
        raise NotAnswered(
            f"corners solve back as many unknowns as there are measurements, and the model {name} has "
            "fewer: ask them of planar-moment or momentum"
        )
    return posterior


def _solver(posterior: Posterior) -> Callable[[np.ndarray], np.ndarray]:
    """A function from measurements, in standard deviations from their values, to B's speed."""
    import jax

    from retrodict.inference.density.kernels import BATCH, REACHED
    from retrodict.inference.samplers.propagation import SOLVE_BACK
    from retrodict.inference.transforms import layout

    programs, data, transform = posterior.programs, posterior.data, posterior.in_rest_poses
    structure = programs.structure
    count = len(structure.rest_components)
    value, sd = np.array([data.evidence[name] for name in structure.rest_components]).T
    separations = jax.jit(
        jax.vmap(lambda q: layout.separation_at(structure, data, transform.regressions, q)[0])
    )

    def solve_back(q: np.ndarray) -> np.ndarray:
        rows = np.resize(q, (BATCH, q.shape[1])).copy()
        wanted = rows[:, :count].copy()
        for _ in range(_ROUNDS):  # the regressions are near: what they miss is taken off
            ends = programs(REACHED, data, separations(rows), rows[:, count:])
            missed = (np.asarray(ends).reshape(BATCH, -1) - value) / sd - wanted
            off = np.abs(missed[: len(q)]).max()
            if off < _CLOSE:
                break
            rows[:, :count] -= missed
        if not off < _MISSED:
            raise NotAnswered("no run-out ends at some corner of the rest poses")
        return np.asarray(programs(SOLVE_BACK, data, transform, rows)["speed_b"])[: len(q)]

    return solve_back


def _least(
    solve_back: Callable[[np.ndarray], np.ndarray], count: int, limit: float, sign: float
) -> float:
    """The least value of sign times the speed in the box."""
    from scipy.optimize import minimize

    steps = _STEP * np.concatenate([np.zeros((1, count)), np.eye(count), -np.eye(count)])

    def with_gradient(q: np.ndarray) -> tuple[float, np.ndarray]:
        found = sign * solve_back(q + steps)
        return float(found[0]), (found[1 : count + 1] - found[count + 1 :]) / (2 * _STEP)

    start = -limit * np.sign(with_gradient(np.zeros(count))[1])
    return float(
        minimize(
            with_gradient, start, jac=True, method="L-BFGS-B", bounds=[(-limit, limit)] * count
        ).fun
    )
