"""What the profession does today: carry the measurements' uncertainty back through the closed form.

Neither knows a prior, so nothing keeps e or e_m within bounds, and what the measurements say of each
other is lost. Both are here to be compared with, and are compared with the posterior by themselves.
"""

from __future__ import annotations

import numpy as np

from retrodict.inference.density.compiled import in_chunks
from retrodict.inference.errors import Unanswerable
from retrodict.inference.samplers.draws import Draws, Task
from retrodict.inference.samplers.importance import apart
from retrodict.inference.transforms.rest_pose import length_for_regressions


def monte_carlo(task: Task) -> Draws:
    """Sample the measurements and solve each sample back."""
    return _compared(task, "solve_back")


def linear(task: Task) -> Draws:
    """The law of propagation of uncertainty (GUM, JCGM 100:2008, 5.1): first derivatives only."""
    return _compared(task, "propagate")


def _compared(task: Task, way: str) -> Draws:
    """Measurements at random taken back that way, held against the posterior."""
    posterior = task.posterior
    structure = posterior.programs.structure
    if structure.open:
        raise Unanswerable(
            "this method solves back from where both vehicles slid to rest, which this scene does not "
            "tell: use another method"
        )
    n = length_for_regressions(structure)
    if n > posterior.size:
        raise Unanswerable(
            f"this method solves back as many unknowns as there are measurements, and the model "
            f"{structure.rung} has fewer: use planar-moment or momentum, or another method"
        )
    q = np.random.default_rng(task.seed).standard_normal((task.chains, task.draws, n))
    programs, data = posterior.programs, posterior.data

    def follow(q: np.ndarray) -> dict[str, np.ndarray]:
        sites = programs(way, data, posterior.transform, q)
        return sites | programs("simulate", data, sites)

    quantities = in_chunks(follow, q.reshape(-1, n))
    return Draws(q, {}, faults=apart(quantities, task), quantities=quantities)
