"""What an impact model is: a forward model, and its inverse from velocities after the impact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description

from retrodict.mechanics import undo
from retrodict.scene.records import SceneKind

Separation = Float[Array, " separation"]
ForwardModel = Callable[[Structure, Data, parts.Values], Separation]


class Level(NamedTuple):
    """A quotient of functions of the motion that an impact model bounds or fixes.

    Args:
        name: name of the quantity, and of its sample site where the level is not `held`.
        near: the bound that most crashes are closer to.
        far: the other bound; equal to `near` where the quantity is fixed.
        sampled: whether the quantity is itself a coordinate, which constrains the motion to its value.
    """

    name: str
    near: float
    far: float
    sampled: bool = False

    @property
    def held(self) -> bool:
        """Whether the coordinates constrain the motion to the value of the quantity."""
        return self.fixed or self.sampled

    @property
    def fixed(self) -> bool:
        """Whether the model fixes the quantity."""
        return self.near == self.far

    @property
    def low(self) -> float:
        """The lower bound."""
        return min(self.near, self.far)

    @property
    def high(self) -> float:
        """The upper bound."""
        return max(self.near, self.far)


@dataclass(frozen=True)
class Impact:
    """An impact model.

    Args:
        description: the model in words.
        forward_model: function of structure, data and the measured inputs that samples the unknowns
            and returns the velocities after the impact.
        answers: names of the reported quantities that the model infers.
        levels: quotients that the model bounds or fixes.
        unknowns: function of the velocities after the impact and the inputs that returns a value for
            each sample site, with B's speed and direction as the vector "velocity_b" (m/s), and
            log |d sites / d velocities|; None where the velocities do not determine them.
        priors: names of the priors that the model uses, as in `Scene.priors`.
        nesting: effects that the model adds to momentum; a model contains those with a subset of its
            effects.
        against_barrier: the model in words where A strikes a barrier; None where it does not apply.
        evidence: names of the items of evidence that its forward model observes.
        needs: keys of a scene file that it needs and other impact models do without.
        kind: kind of scene that it is a model of, as `Scene.kind`.
    """

    description: Description
    forward_model: ForwardModel
    answers: tuple[str, ...]
    levels: tuple[Level, ...]
    unknowns: Callable[[Separation, parts.Values], tuple[parts.Values, Float[Array, ""]]] | None
    priors: tuple[str, ...]
    nesting: frozenset[str]
    against_barrier: Description | None = None
    evidence: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    kind: SceneKind = "impact"


SHORT = "the impact is short: vehicles do not move and tyres do nothing while it lasts"
MOMENTUM = ("momentum along x and y: SAE 770014 eqs 19, 20",)

E, E_M = Level("e", 0.0, 1.0), Level("e_m", 1.0, -1.0)
NO_MOMENT = Level("moment", 0.0, 0.0)  # so that e_m = 1, whatever the spin by the force alone
NO_SLIP = Level("slip", 0.0, 0.0)
# share of the sliding that remains after friction. It is a coordinate because crashes lie near its
# bound, and near zero sliding, where all shares coincide
SLIDING = Level("sliding", 0.0, 1.0, sampled=True)


def quotients(
    levels: Sequence[Level], after: Separation, x: parts.Values
) -> tuple[Float[Array, " levels"], Float[Array, " levels"]]:
    """Numerator and denominator of each level; both are linear in the velocities after the impact.

    Args:
        levels: levels to compute.
        after: velocities after the impact, A's first, m/s and rad/s.
        x: measured inputs by name.

    Returns:
        Numerators and denominators: for e (-opening, closing velocity), for e_m (spin kept, spin by
        the force alone), for moment (spin kept less spin by the force alone, 1), for slip (sliding
        left, 1), for sliding (sliding left, sliding without friction); m/s and rad/s.
    """
    to = parts.bodies(x)
    found = undo(after, parts.approach_of_a(x), to)
    pairs = {
        "e": (-found.opening, found.closing),
        "e_m": (found.spin, found.free_spin),
        "moment": (found.spin - found.free_spin, jnp.ones(())),
        "slip": (found.sliding, jnp.ones(())),
        "sliding": (found.sliding, found.free_sliding),
    }
    over, under = zip(*(pairs[level.name] for level in levels), strict=True)
    return jnp.stack(over), jnp.stack(under)
