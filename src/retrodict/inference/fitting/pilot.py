"""Where motion after the impact is to be sought, when rest poses do not determine it."""

from __future__ import annotations

import numpy as np

from retrodict.inference.density.compiled import Programs
from retrodict.inference.density.kernels import CHUNK, PRIOR, SIMULATE
from retrodict.models.arrays import Data

_ROUNDS = 20  # of CHUNK crashes from the prior

Values = dict[str, np.ndarray]


def prior_pilot(programs: Programs, data: Data) -> tuple[np.ndarray, Values]:
    """How well many crashes from the prior explain the evidence, and what they are.

    Items of evidence count by Cauchy's law, so that one sharp item does not silence all others.
    Nothing here needs to be exact: it only places coordinates.

    Args:
        programs: of the scene's structure.
        data: its numbers.

    Returns:
        Scores, shape (crashes,); and unknowns and what follows from them, a row for each crash.
    """
    scores, crashes = [], []
    for seed in range(_ROUNDS):
        sites = programs(PRIOR, seed, data)
        quantities = sites | programs(SIMULATE, data, sites)
        score = np.zeros(CHUNK)
        for name in programs.structure.evidence:
            value, sd = data.evidence[name]
            score -= np.log1p(((np.asarray(quantities[f"predicted/{name}"]) - value) / sd) ** 2)
        if (
            "closing_speed" in quantities
        ):  # vehicles that part would have been held back by the impulse
            score[np.asarray(quantities["closing_speed"]) < 0] = -np.inf
        scores.append(np.nan_to_num(score, nan=-np.inf))
        crashes.append({name: np.asarray(values) for name, values in quantities.items()})
    return np.concatenate(scores), {k: np.concatenate([c[k] for c in crashes]) for k in crashes[0]}
