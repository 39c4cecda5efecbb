"""Vehicles that go on together, as points or as one rigid body: no coefficient of the impact is left."""

from __future__ import annotations

import jax.numpy as jnp
import numpyro
from jaxtyping import Array, Float
from retrodict.models import evidence, parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description
from retrodict.models.impact import MOMENTUM, SHORT, Impact, Separation

from retrodict.mechanics.together import Masses, common_motion


def as_points(structure: Structure, data: Data, x: parts.Values) -> Separation:
    """B's approach; then both at the velocity of their common centre of gravity, eqs 19 and 20."""
    before = jnp.stack([parts.approach_of_a(x)[:2], parts.velocity_of_b(structure, data)])
    _close_in(x, before)
    mass = masses(x).mass
    V = mass @ before / mass.sum()
    after = jnp.stack([V, V])
    _record(structure, data, x, before, after)
    return after.reshape(-1)


def as_body(structure: Structure, data: Data, x: parts.Values) -> Separation:
    """B's approach; then the motion of one rigid body, eqs 19 to 21."""
    before = jnp.stack([parts.approach_of_a(x), parts.approach_of_b(structure, data)])
    _close_in(x, before)
    after = common_motion(before.reshape(-1), _apart(x), masses(x)).reshape(2, 3)
    _record(structure, data, x, before, after)
    return after.reshape(-1)


def masses(x: parts.Values) -> Masses:
    """Masses and yaw inertias of both vehicles."""
    both = [[x[f"{name}_{v}"] for v in "ab"] for name in ("mass", "yaw_inertia")]
    return Masses(*map(jnp.stack, both))


def _apart(x: parts.Values) -> Float[Array, "2"]:
    """From A's centre of gravity to B's, m."""
    of_a, of_b = parts.levers(x)
    return of_a - of_b


def _close_in(x: parts.Values, before: Float[Array, "2 velocity"]) -> None:
    # nothing tells in which direction the contact pushes: the centres of gravity approach each other
    past = before[1, :2] - before[0, :2]
    parts.close_in(-(past @ _apart(x)))


def _record(
    structure: Structure,
    data: Data,
    x: parts.Values,
    before: Float[Array, "2 velocity"],
    after: Float[Array, "2 velocity"],
) -> None:
    """Record the energy lost, which is evidence where it was stated, and the motion."""
    mass, inertia = masses(x)
    weights = jnp.stack([mass, mass, inertia], axis=1)[:, : before.shape[1]]
    lost = jnp.sum(weights * (before**2 - after**2)) / 2
    numpyro.deterministic("energy_lost", lost)
    evidence.observe_impact(structure, data, {"energy_lost": lost})
    parts.record_motion(after.reshape(-1), (after - before)[:, :2])


_TOGETHER = (
    "the vehicles interlock and go on as one from the impact to rest: they do not part again"
)


def _joined(name: str, title: str, *further: str) -> Description:
    return Description(
        name=name,
        title=title,
        equations=(*MOMENTUM, *further),
        assumptions=(SHORT, _TOGETHER, "the centres of gravity approach each other"),
        left_out=("how the vehicles crush, and that they may part on the way",),
    )


_ANGULAR = (
    "angular momentum about the common centre of gravity: SAE 770014 eq 21 with e_m = 0, so that both "
    "turn at one yaw rate"
)

AS_POINTS = Impact(
    description=_joined("joined", "vehicles that go on together, momentum alone"),
    forward_model=as_points,
    answers=("speed_a", "speed_b"),
    levels=(),
    unknowns=None,
    priors=("speed_a", "speed_b"),
    nesting=frozenset({"together"}),
    evidence=evidence.of_impact("energy_lost"),
    kind="together",
)
AS_BODY = Impact(
    description=_joined("joined-body", "vehicles that go on together as one body", _ANGULAR),
    forward_model=as_body,
    answers=("speed_a", "speed_b"),
    levels=(),
    unknowns=None,
    priors=("speed_a", "speed_b", "omega_a", "omega_b"),
    nesting=frozenset({"together", "yaw"}),
    evidence=evidence.of_impact("energy_lost"),
    needs=("impact_centre",),
    kind="together",
)
