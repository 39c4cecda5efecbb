"""The highest value of each likelihood term of the user's own, from which its residual is counted.

The search for modes is one of least squares. A term whose highest value is c has the residual
sqrt(2 (c - term)), as an item of evidence with a normal error has.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache

import jax
import numpy as np

from retrodict.inference.errors import Unanswerable
from retrodict.inference.own import TERM
from retrodict.models.arrays import Data, Structure
from retrodict.models.parts import CLOSE_IN

# deviates of crashes -> their log likelihoods, and their quantities by name
Evaluate = Callable[[np.ndarray], tuple[np.ndarray, dict[str, np.ndarray]]]

_FIRST, _NEXT = 1024, 512  # crashes of the prior, and those about the best one in each round
_SPREADS = (0.3, 0.03, 3e-3, 3e-4, 3e-5)  # of the crashes in each round, deviates


@dataclass(frozen=True)
class _Asked:
    """A posterior whose terms are asked for; those of the same numbers are one."""

    structure: Structure
    numbers: bytes
    evaluate: Evaluate = field(compare=False)


def ceilings(structure: Structure, data: Data, evaluate: Evaluate) -> dict[str, float]:
    """Highest value of each term of the user's own, by name.

    Args:
        structure: static structure of the scene, with the terms.
        data: numbers of the scene.
        evaluate: function of deviates of crashes, shape (crashes, n), that returns their log likelihoods
            and quantities.

    Raises:
        Unanswerable: a term is not a number at a crash of the prior, or nowhere more than minus
            infinity.
    """
    if not structure.own:
        return {}
    numbers = jax.tree.leaves((data.inputs, data.priors))
    content = b"".join(np.asarray(each, float).tobytes() for each in numbers)
    return _ceilings(
        _Asked(replace(structure, steps=None, transform="standard"), content, evaluate)
    )


@lru_cache(maxsize=32)
def _ceilings(asked: _Asked) -> dict[str, float]:
    size, rng = asked.structure.deviates, np.random.default_rng(0)
    first = rng.standard_normal((_FIRST, size))
    first[0] = 0.0
    _, quantities = asked.evaluate(first)
    found = {}
    for name, _ in asked.structure.own:
        height = np.asarray(quantities[f"{TERM}{name}"])
        allowed = np.isfinite(np.asarray(quantities[f"condition/{CLOSE_IN}"]))
        if wrong := int(np.isnan(height[allowed]).sum()):
            raise Unanswerable(
                f'extra["{name}"] is not a number (NaN) at {wrong} of {int(allowed.sum())} crashes of '
                "the prior; return a number, or -jnp.inf for what is impossible"
            )
        height = np.where(allowed & (height < np.inf), height, -np.inf)
        if not np.isfinite(height).any():
            raise Unanswerable(
                f'extra["{name}"] is infinite at every one of {len(first)} crashes of the prior: it '
                "contradicts the scene, or its unit is not SI"
            )
        best, most = first[np.argmax(height)], height.max()
        for spread in _SPREADS:
            about = best + spread * rng.standard_normal((_NEXT, size))
            height = np.nan_to_num(
                asked.evaluate(about)[1][f"{TERM}{name}"], nan=-np.inf, posinf=-np.inf
            )
            if height.max() > most:
                best, most = about[np.argmax(height)], height.max()
        found[name] = float(most)
    return found
