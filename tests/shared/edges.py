"""The edges of the mechanics: impacts and run-outs at them, and what is right there."""

from __future__ import annotations

import math
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from retrodict.mechanics import (
    Bodies,
    Car,
    Coefficients,
    Ground,
    Zone,
    contact_velocity,
    rest,
    separation,
    solve,
    step_error,
)
from retrodict.mechanics.solve import NAMES
from tests.shared import reference

BODIES = Bodies(1857.0, 1778.0, 3374.0, 3007.0, 1.636, 0.653, 0.205, 2.079, -0.155)  # SAE 770014
BEFORE = np.array([-20.1, 3.0, 0.2, 18.9, -3.6, -0.3])
COEFFICIENTS = Coefficients(0.1, 0.35, 0.7)
CAR = Car(1.8, 1.3, 1.5, 1.5)
SPINNING = [12.0, 3.0, 8.0]  # m/s and rad/s
PLAIN = Zone(np.zeros((0, 2)), np.zeros((0, 2)))

Array = np.ndarray

_rest = jax.jit(rest, static_argnames="steps")
_separation = jax.jit(separation)


def grazing(offset: float) -> Bodies:
    """The paper's cars, Gamma such that they meet `offset` off the contact line, rad."""
    x, y = contact_velocity(jnp.asarray(BEFORE), BODIES).tolist()
    return BODIES._replace(Gamma=math.atan2(y, x) - math.pi / 2 + offset)


def undone(before: Array, bodies: Bodies, c: Coefficients) -> dict[str, float]:
    """B's approach and the coefficients that `solve` finds in what `separation` made of them.

    Raises:
        NotDetermined: as `solve`.
    """
    after = np.asarray(_separation(jnp.asarray(before), bodies, c))
    known = dict(zip(NAMES, [*before, *after.tolist(), *map(float, c)], strict=True))
    return solve(known, bodies, (*NAMES[3:6], *NAMES[12:])).values


def skid(velocity: list[float], friction: float, steps: int | None = None, **car: Any) -> Array:
    """The rest pose on one surface."""
    ground = Ground(jnp.array([friction]), None, PLAIN)
    start = jnp.array([0.0, 0.0, 0.3])
    return np.asarray(_rest(start, jnp.array(velocity), CAR._replace(**car), ground, steps=steps))


def error_of_steps(steps: int) -> Array:
    """What `step_error` gives for `SPINNING` on 0.5."""
    ground, start = Ground(jnp.array([0.5]), None, PLAIN), jnp.array([0.0, 0.0, 0.3])
    return np.asarray(step_error(start, jnp.array(SPINNING), CAR, ground, steps))


def by_reference(velocity: list[float], friction: float) -> Array:
    """The same by SciPy."""
    scene = reference.CAR._replace(
        pose=np.array([0.0, 0.0, 0.3]),
        velocity=np.array(velocity),
        coefficients=np.full(2, friction),
    )
    return reference.solve(scene)[0]


def endless_sliding() -> tuple[Bodies, Array]:
    """Cars that graze such that friction unloads the contact faster than it brakes."""
    bodies = Bodies(2132.9, 2126.4, 2599.7, 4526.9, 0.66105, -0.27271, 1.83123, -0.62968, -0.62705)
    return bodies, np.array([9.71544, -1.73468, 0.15864, -6.76114, -18.05650, -1.49781])


def parted_by_spin() -> Bodies:
    """Two equal cars that touch off centre, such that equal spins part the contact points."""
    return Bodies(1500.0, 1500.0, 2500.0, 2500.0, 1.5, 0.0, -1.5, 0.0, 0.0)


def soft(share: float) -> tuple[Array, Bodies, Coefficients]:
    """Two equal cars whose eq 22 divides by 2/m - 2 h²/I at e_m = -1: h such a share of its root."""
    h = share * math.sqrt(2500.0 / 1500.0)
    bodies = Bodies(1500.0, 1500.0, 2500.0, 2500.0, -h, 0.0, h, 0.0, 0.0)
    return np.array([20.0, 0.0, 0.0, 0.0, 0.0, 0.0]), bodies, Coefficients(0.1, 0.0, -1.0)


def grazed_edge(offset: float) -> reference.Scene:
    """An edge so far beyond where the foremost wheel would come to rest, m."""
    still = reference.CAR._replace(velocity=np.array([8.0, 1.0, 2.0]))
    end = reference.solve(still)[0]
    foremost = float((end[0] + reference.wheels(end, still)[0]).max())
    return still._replace(point=np.array([foremost + offset, 0.0]))


def on_edge(scene: reference.Scene, steps: int | None) -> Array:
    """The rest pose of a scene of the reference."""
    ground = Ground(scene.coefficients, None, Zone(scene.point[None], scene.inward[None]))
    car = Car(scene.k2, scene.front_axle, scene.rear_axle, scene.track)
    return np.asarray(_rest(scene.pose, scene.velocity, car, ground, steps=steps))
