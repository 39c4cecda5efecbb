"""What an impact model is: its story, and what leads back from velocities after it to its unknowns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.card import Card

from retrodict.mechanics import (
    Coefficients,
    axes,
    contact_velocity,
    inverse_log_det,
    separation,
    undo,
)

Separation = Float[Array, " separation"]
Story = Callable[[Structure, Data, parts.Values], Separation]


class Level(NamedTuple):
    """A quotient of functions of the motion that the impact model bounds, or holds fixed.

    Args:
        name: of the quantity, a sample site where it is bounded.
        near: the bound that crashes lie closer to.
        far: the other; the same where the model holds the quantity there.
        sampled: whether it is a coordinate itself: the motion is held at its value.
    """

    name: str
    near: float
    far: float
    sampled: bool = False

    @property
    def held(self) -> bool:
        """Whether coordinates hold the motion at it."""
        return self.fixed or self.sampled

    @property
    def fixed(self) -> bool:
        """Whether the model holds it."""
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
        card: what it is, in words.
        story: samples the unknowns and gives the velocities after the impact; arguments are
            structure, data and the measured inputs.
        answers: which of the quantities asked for it infers.
        levels: what it bounds or holds fixed.
        unknowns: velocities after the impact and inputs -> a value for each sample site but the
            direction of B, which stands as "velocity_b", and log |d sites / d velocities|.
        priors: names of the priors it uses, in `Scene.priors`.
        fullness: what it lets free beyond momentum.
    """

    card: Card
    story: Story
    answers: tuple[str, ...]
    levels: tuple[Level, ...]
    unknowns: Callable[[Separation, parts.Values], tuple[parts.Values, Float[Array, ""]]]
    priors: tuple[str, ...]
    fullness: frozenset[str]


SHORT = "the impact is short: vehicles do not move and tyres do nothing while it lasts"
MOMENTUM = ("momentum along x and y: SAE 770014 eqs 19, 20",)
_SLIDING = (
    "restitution e and equivalent friction μ along the contact line: SAE 770014 eqs 22, 23",
)
_SLIDING_ENDS = (
    "restitution e along the normal of the contact line: SAE 770014 eq 22",
    "sliding along the contact line ends within the contact: μ of eq 23 at its critical value",
)
_MOMENT = (
    "impact moment coefficient e_m: SAE 770014 eq 24, the sign of its bracket corrected, so "
    "that Ω_b − Ω_a = e_m [(ω_b + f_b/I_b) − (ω_a + f_a/I_a)]",
)
_NO_MOMENT = ("no moment impulse: SAE 770014 eq 24 with e_m = 1",)
_NOT_REVERSED = (
    "friction opposes the sliding along the contact line and does not reverse it, unless the scene says "
    "that parts interlocked"
)
_COMMON_VELOCITY = "the vehicles reach a common velocity along the contact line: μ = μ_c"

E, E_M = Level("e", 0.0, 1.0), Level("e_m", 1.0, -1.0)
NO_MOMENT = Level("moment", 0.0, 0.0)  # and so e_m = 1, whatever the spin by the force alone
NO_SLIP = Level("slip", 0.0, 0.0)
# the share that friction leaves: a coordinate, for crashes lie near its bound, and near where A slides
# along B neither way and all shares meet
SLIDING = Level("sliding", 0.0, 1.0, sampled=True)


def quotients(
    levels: Sequence[Level], after: Separation, x: parts.Values
) -> tuple[Float[Array, " levels"], Float[Array, " levels"]]:
    """What each level is a quotient of: each linear in the motion.

    Args:
        levels: which.
        after: velocities after the impact.
        x: measured inputs.

    Returns:
        Numerators and denominators: for e (-opening, closing velocity), for e_m (spin kept, spin by
        the force alone), for moment (what of spin the force alone does not explain, 1), for slip (the
        sliding left, 1), for sliding (that left, that without friction); m/s and rad/s.
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


def planar_unknowns(
    moment: bool, slides: bool
) -> Callable[[Separation, parts.Values], tuple[parts.Values, Float[Array, ""]]]:
    """How velocities after a planar impact lead back to its unknowns.

    Args:
        moment: whether e_m is one of them, and not 1.
        slides: whether mu is, and sliding does not end within the contact.

    Returns:
        For `Impact.unknowns`.
    """

    def unknowns(after: Separation, x: parts.Values) -> tuple[parts.Values, Float[Array, ""]]:
        to, approach_a = parts.bodies(x), parts.approach_of_a(x)
        approach_b, found, log_det = inverse_log_det(after, approach_a, to)
        e, mu, e_m = map(jnp.asarray, found)
        sites = {"velocity_b": approach_b[:2], "omega_b": approach_b[2], "e": e}
        # what is held instead of a coefficient stands for it in the determinant
        if moment:
            sites["e_m"] = e_m
        else:
            log_det = log_det + jnp.log(jnp.abs(undo(after, approach_a, to).free_spin))
            e_m = jnp.ones(())
        if slides:
            sites["mu"] = mu
        else:
            before = jnp.concatenate([approach_a, approach_b])

            def slip(mu: Array) -> Array:
                end = separation(before, to, Coefficients(e, mu, e_m))
                return contact_velocity(end, to) @ axes(to)[1]

            slope = jax.jvp(slip, (mu,), (jnp.ones(()),))[1]
            log_det = log_det + jnp.log(jnp.abs(slope))
        return sites, jnp.asarray(log_det)

    return unknowns


def planar(name: str, title: str, levels: tuple[Level, ...], story: Story) -> Impact:
    """A planar impact: all that follows from what it bounds and what it holds.

    Args:
        name: identifier.
        title: one line.
        levels: e, then e_m bounded or held, then the sliding likewise.
        story: samples the unknowns and gives the velocities after the impact.
    """
    moment, slides = E_M in levels, NO_SLIP not in levels
    freed = (("e_m",) if moment else ()) + (("mu",) if slides else ())
    return Impact(
        card=Card(
            name=name,
            title=title,
            equations=(
                *MOMENTUM,
                "angular momentum: SAE 770014 eq 21, its misprinted last term corrected to "
                "m_a (d2+d4)(V_ay − v_ay)",
                *(_SLIDING if slides else _SLIDING_ENDS),
                *(_MOMENT if moment else _NO_MOMENT),
            ),
            assumptions=(
                SHORT,
                "the vehicles close in, each from its own side of the contact where it has one",
                *(() if moment else ("the contact passes no moment impulse: e_m = 1",)),
                _NOT_REVERSED if slides else _COMMON_VELOCITY,
            ),
            left_out=("secondary impacts, and crush as evidence",),
        ),
        story=story,
        answers=("speed_a", "speed_b", "e", *freed),
        levels=levels,
        unknowns=planar_unknowns(moment, slides),
        priors=("speed_a", "speed_b", "omega_b", "e", *freed),
        fullness=frozenset({"contact", *freed}),
    )
