"""A reconstruction whose posterior is known in closed form: B's speed, measured once, and its prior."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from scipy import stats

from retrodict.inference.outcome import Outcome
from retrodict.scene.measured import Measured
from tests.report.conftest import make_outcome, make_scene

CHAINS, DRAWS = 4, 50_000
PRIOR_SCALE, MEASURED, SD = 30.0, 20.0, 1.5  # m/s


def outcome(**posterior: np.ndarray) -> Outcome:
    """The made-up scene, with these draws in the place of its own; of shape (chain, draw)."""
    made = make_outcome(make_scene())
    data = xr.Dataset({k: (("chain", "draw"), v) for k, v in posterior.items()})
    return replace(made, idata=xr.DataTree.from_dict({"/posterior": data}))


def speed_draws(seed: int = 0, draws: int = DRAWS) -> np.ndarray:
    """Exact draws of a speed with a half-normal prior and one normal measurement: a cut normal."""
    precision = PRIOR_SCALE**-2 + SD**-2
    mean, sd = MEASURED / SD**2 / precision, precision**-0.5
    law = stats.truncnorm(-mean / sd, np.inf, mean, sd)
    return law.rvs((CHAINS, draws), random_state=np.random.default_rng(seed))


def exact(value: float) -> Measured:
    return Measured(value)
