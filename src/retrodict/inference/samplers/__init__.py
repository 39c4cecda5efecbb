"""The methods that draw from a posterior, behind one interface: a new method is a file and a line."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from retrodict.inference.density.compiled import Programs
from retrodict.inference.samplers import importance, laplace, nuts, propagation, smc
from retrodict.inference.samplers.draws import Draws, Progress, Task
from retrodict.inference.transforms.choice import Transform
from retrodict.models.arrays import Data


def _no_kernels(programs: Programs, warmup: int, data: Data, transform: Transform) -> None:
    """Compile nothing, for a method that has no kernels of its own."""


@dataclass(frozen=True)
class Method:
    """A method of drawing from a posterior.

    Args:
        title: name of the method, in words.
        exact: whether its draws tend to the posterior as they grow in number; the report calls other
            methods approximations.
        draws: default number of draws kept of each chain.
        draw: function that makes the draws of a task.
        resumes: whether the method has chains that can be continued after an interruption.
        solves_back: whether the method needs rest poses as coordinates, even if they do not cover the
            posterior.
        follows: whether its draws form Markov chains, which may never come to another mode.
        weighs: whether its draws give the evidence, by which several solutions are weighted.
        compile_ahead: function that compiles the method's own kernels in the background, called with
            (programs, warmup, data, transform).
    """

    title: str
    exact: bool
    draws: int
    draw: Callable[[Task], Draws]
    resumes: bool = False
    solves_back: bool = False
    follows: bool = False
    weighs: bool = False
    compile_ahead: Callable[[Programs, int, Data, Transform], None] = _no_kernels


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
