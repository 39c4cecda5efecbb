"""What the profession does today: carry the measurements' uncertainty back through the closed form.

Neither knows a prior, so nothing keeps e or e_m within bounds, and what the measurements say of each
other is lost. Both are here to be compared with.
"""

from __future__ import annotations

import numpy as np

from retrodict.inference.coordinates import length
from retrodict.inference.errors import Unanswerable
from retrodict.inference.methods.draws import Draws, Task


def monte_carlo(task: Task) -> Draws:
    """Sample the measurements and solve each sample back."""
    return Draws(_measurements(task), {}, way="solve_back")


def linear(task: Task) -> Draws:
    """The law of propagation of uncertainty (GUM, JCGM 100:2008, 5.1): first derivatives only."""
    return Draws(_measurements(task), {}, way="propagate")


def _measurements(task: Task) -> np.ndarray:
    structure = task.posterior.programs.structure
    n = length(structure)
    if n > task.posterior.size:
        raise Unanswerable(
            f"this method solves back as many unknowns as there are measurements, and the model "
            f"{structure.rung} has fewer: use planar-moment or momentum, or another method"
        )
    return np.random.default_rng(task.seed).standard_normal((task.chains, task.draws, n))
