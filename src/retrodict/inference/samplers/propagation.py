"""Common practice today: carry the measurements' uncertainty back through the closed form.

Neither method here knows a prior, so nothing keeps e or e_m within bounds, and what the measurements say
of each other is lost. Both serve for comparison, and their draws are compared with the posterior.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from retrodict.inference.density.compiled import in_chunks
from retrodict.inference.density.kernels import SIMULATE, Kernel
from retrodict.inference.density.log_density import Target
from retrodict.inference.errors import Unanswerable
from retrodict.inference.samplers.draws import Draws, Task
from retrodict.inference.samplers.importance import disagreements
from retrodict.inference.transforms import layout
from retrodict.inference.transforms.parameters import Numbers
from retrodict.inference.transforms.rest_pose import RestPose
from retrodict.models import parts
from retrodict.models.arrays import Data


def monte_carlo(task: Task) -> Draws:
    """Sample the measurements and solve each sample back."""
    return _compared(task, SOLVE_BACK)


def linear(task: Task) -> Draws:
    """The law of propagation of uncertainty (GUM, JCGM 100:2008, 5.1): first derivatives only."""
    return _compared(task, _PROPAGATE)


def _solve_back(target: Target, data: Data, transform: RestPose, q: Numbers) -> parts.Values:
    """The model's unknowns at each row of q, without priors or bounds."""
    return jax.vmap(lambda q: transform.solve_back(target.structure, data, q))(q)


def _propagate(target: Target, data: Data, transform: RestPose, q: Numbers) -> parts.Values:
    """The model's unknowns at each row of q, to first order about the measured values."""

    def exact(q: Array) -> parts.Values:
        return transform.solve_back(target.structure, data, q)

    def to_first_order(q: Array) -> parts.Values:
        return jax.tree.map(jnp.add, *jax.jvp(exact, (jnp.zeros_like(q),), (q,)))

    return jax.vmap(to_first_order)(jnp.asarray(q))


SOLVE_BACK = Kernel("solve_back", _solve_back, 0)
_PROPAGATE = Kernel("propagate", _propagate, 0)


def _compared(task: Task, way: Kernel[[Data, RestPose, Numbers], parts.Values]) -> Draws:
    """Random measurements solved back by a kernel, and compared with the posterior."""
    posterior = task.posterior
    structure = posterior.programs.structure
    transform = posterior.transform
    if not isinstance(transform, RestPose) or structure.unmeasured:
        raise Unanswerable(
            "this method solves back from where both vehicles slid to rest, which this scene does not "
            "give: use another method"
        )
    n = layout.length_for_regressions(structure)
    if n > posterior.size:
        raise Unanswerable(
            f"this method solves back as many unknowns as there are measurements, and the model "
            f"{structure.rung} has fewer: use planar-moment or momentum, or another method"
        )
    q = np.random.default_rng(task.seed).standard_normal((task.chains, task.draws, n))
    programs, data = posterior.programs, posterior.data

    def follow(q: np.ndarray) -> parts.Values:
        sites = programs(way, data, transform, q)
        return sites | programs(SIMULATE, data, sites)

    quantities = in_chunks(follow, q.reshape(-1, n))
    faults = disagreements(quantities, task)
    return Draws(q, {}, faults=faults, quantities=quantities, conditioned=False)
