"""Typed kernels: the functions of a target that are compiled. Samplers define further ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Concatenate

import jax
from jaxtyping import Array

from retrodict.inference.density.log_density import Target
from retrodict.models.arrays import Data, Structure

BATCH = 512  # run-outs per call of `REACHED`
CHUNK = 500  # draws per call of `SIMULATE` and `LOG_PRIOR`, and crashes that `PRIOR` gives
# Points per call of `EVALUATE` and `CRASHES`: smaller batches take longer per point, and a curvature
# takes some 400. Where wheels roll, a batch takes as many steps as its longest run-out: of RICSAC 10, 64
# points far from the posterior take 0.4 of the time of 256 per point, and near it as long (measured).
_ROWS, _ROWS_PACED = 256, 64


def rows_of(structure: Structure) -> int:
    """Points per call of `EVALUATE` and `CRASHES`."""
    return _ROWS_PACED if structure.paced else _ROWS


@dataclass(frozen=True)
class Kernel[**P, R]:
    """A function that is compiled once for each structure.

    Args:
        name: name that identifies its compiled programs.
        function: function of a target, then the arguments.
        level: XLA's optimisation level, 0 to 3; None for its default, 3.
    """

    name: str
    function: Callable[Concatenate[Target, P], R]
    level: int | None = None


def _prior(target: Target, seed: int, data: Data) -> dict[str, Array]:
    """`CHUNK` crashes from the prior."""
    # a generator whose program compiles in a third of the time
    return target.prior(jax.random.split(jax.random.key(seed, impl="unsafe_rbg"), CHUNK), data)


# Level 0 for kernels that run a few times: optimising them would take longer than it saves. At the
# default, 3, kernels that run through batches take half as long again to compile (measured).
INPUTS = Kernel("inputs", Target.inputs, 0)
LEVELS = Kernel("levels", Target.levels, 0)
PRIOR = Kernel("prior", _prior, 0)
PATHS = Kernel("paths", Target.paths, 0)
LOG_PRIOR = Kernel("log_prior", Target.log_prior, 0)
REACHED = Kernel("reached", Target.reached, 1)
EVALUATE = Kernel("evaluate", Target.evaluate_rows, 1)
CRASHES = Kernel("crashes", Target.crashes, 1)
SIMULATE = Kernel("simulate", Target.simulate, 1)
