"""The methods that draw from a posterior, one interface: a new one is a file and a line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from retrodict.inference.density.compiled import Programs
from retrodict.inference.samplers import importance, laplace, nuts, propagation, smc
from retrodict.inference.samplers.draws import Draws, Progress, Task
from retrodict.inference.transforms.parameters import TransformParameters
from retrodict.models.arrays import Data


def _no_kernels(
    programs: Programs, warmup: int, data: Data, transform: TransformParameters
) -> None:
    """Of a method that has no kernels of its own."""


@dataclass(frozen=True)
class Method:
    """A way to draw from a posterior.

    Args:
        title: what it is, in words.
        exact: whether its draws tend to the posterior as they grow in number; others are
            approximations, of which the report says so.
        draws: kept of each chain unless set otherwise.
        draw: does it.
        resumes: whether it has chains that an interrupted run can go on with.
        solves_back: whether it needs rest poses as coordinates, even if they do not cover the posterior.
        follows: whether its draws follow one another, so that they may never come to another mode.
        weighs: whether draws bring the evidence, by which several solutions are weighted.
        compile_ahead: has its own kernels compiled, of (programs, warmup, data, transform).
    """

    title: str
    exact: bool
    draws: int
    draw: Callable[[Task], Draws]
    resumes: bool = False
    solves_back: bool = False
    follows: bool = False
    weighs: bool = False
    compile_ahead: Callable[[Programs, int, Data, TransformParameters], None] = _no_kernels


METHODS = {
    "nuts": Method(
        "No-U-Turn sampler",
        True,
        700,
        nuts.draw,
        resumes=True,
        follows=True,
        compile_ahead=nuts.compile_ahead,
    ),
    "importance": Method(
        "importance sampling, normal proposal with heavy tails, Pareto-smoothed",
        True,
        750,
        importance.draw,
        weighs=True,
    ),
    "smc": Method("tempered sequential Monte Carlo", True, 512, smc.draw, weighs=True),
    "laplace": Method(
        "Laplace's approximation in the flattened coordinates", False, 600, laplace.draw
    ),
    "monte-carlo": Method(
        "Monte Carlo over the measurements, solved back in closed form, without priors",
        False,
        600,
        propagation.monte_carlo,
        solves_back=True,
    ),
    "linear": Method(
        "linear propagation of the measurements' uncertainty (GUM), without priors",
        False,
        600,
        propagation.linear,
        solves_back=True,
    ),
}

__all__ = ["METHODS", "Draws", "Method", "Progress", "Task"]
