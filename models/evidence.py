"""What is measured after an impact: what a model predicts of each item, and how it errs."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import numpyro
import numpyro.distributions as dist
from jaxtyping import Array, Float
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure

from retrodict.mechanics import Car, wheel_paths
from retrodict.scene.records import VEHICLES, WHEELS

# of the Student-t in a robust scene: it has a mean and a variance, and an item four standard
# deviations out pulls no harder than one at two
FREEDOM = 4.0


class Motion(NamedTuple):
    """What a model says of a vehicle after the impact.

    Args:
        after: velocity: x and y, m/s, and the yaw rate, rad/s, where the model has one.
        delta_v: change of velocity in the impact, m/s.
        heading: at impact, rad.
        rest: x, y, m, and heading, rad, where the model has one.
        path: of the centre of gravity, from impact to rest; None where nothing asks for it.
        car: its axles and track.
    """

    after: Float[Array, " velocity"]
    delta_v: Float[Array, "2"]
    heading: Float[Array, ""]
    rest: Float[Array, " pose"]
    path: Float[Array, "steps 3"] | None
    car: Car


Predict = Callable[[Motion], Array]

_YAW: dict[str, Predict] = {  # of models whose vehicles turn
    "rest_heading": lambda motion: motion.rest[2],
    "departure_yaw_rate": lambda motion: motion.after[2],
}
_ALL: dict[str, Predict] = {
    "rest_x": lambda motion: motion.rest[0],
    "rest_y": lambda motion: motion.rest[1],
    "departure_direction": lambda motion: jnp.arctan2(motion.after[1], motion.after[0]),
    "departure_speed": lambda motion: jnp.hypot(motion.after[0], motion.after[1]),
    "departure_delta_v": lambda motion: jnp.hypot(*motion.delta_v),
    "departure_delta_v_forward": lambda motion: motion.delta_v @ _axis(motion.heading),
    "departure_delta_v_left": lambda motion: motion.delta_v @ _axis(motion.heading + np.pi / 2),
}


def explained(name: str, turns: bool) -> bool:
    """Whether a model predicts an item of evidence.

    Args:
        name: of the item, as in `Scene.evidence`.
        turns: whether the model's vehicles yaw.
    """
    stem = name[:-2]
    return stem in _ALL or stem.startswith("mark_") or (turns and stem in _YAW)


def observe(
    structure: Structure,
    data: Data,
    x: parts.Values,
    after: Float[Array, " separation"],
    rests: Float[Array, "2 rest"],
    paths: Float[Array, "2 steps 3"] | None,
) -> None:
    """Compare what a model predicts with what was measured.

    Args:
        structure: which items there are.
        data: what was measured.
        x: measured inputs.
        after: velocities after the impact, A's first.
        rests: of A and B.
        paths: of A and B; None where there are no marks.
    """
    cars, changes, velocities = (
        parts.cars(structure, x),
        parts.delta_v(x, after),
        after.reshape(2, -1),
    )
    passed = dict(structure.marks)
    for i, v in enumerate(VEHICLES):
        k2, front, rear, track = (jnp.asarray(own)[i] for own in cars[:4])
        car = Car(k2, front, rear, track)
        path = None if paths is None else paths[i]
        motion = Motion(velocities[i], changes[i], x[f"heading_{v}"], rests[i], path, car)
        for name in structure.evidence:
            if not name.endswith(f"_{v}"):
                continue
            value, sd = data.evidence[name]
            if name in passed:
                predicted = _aside(jnp.asarray(data.marks[name]), _track(motion, passed[name]))
            else:
                predicted = (_ALL | _YAW)[name[:-2]](motion)
            if "direction" in name:  # the representative nearest to what was measured
                off = predicted - value
                predicted = value + jnp.arctan2(jnp.sin(off), jnp.cos(off))
            law = (
                dist.StudentT(FREEDOM, predicted, sd)
                if structure.robust
                else dist.Normal(predicted, sd)
            )
            numpyro.sample(name, law, obs=value)


def _axis(angle: Array) -> Float[Array, "2"]:
    return jnp.stack([jnp.cos(angle), jnp.sin(angle)])


def _track(motion: Motion, of: str) -> Float[Array, "steps 2"]:
    """Where the centre of gravity, or a wheel, goes."""
    assert motion.path is not None, "marks ask for paths"
    if of == "centre":
        return motion.path[:, :2]
    return wheel_paths(motion.path, motion.car)[:, WHEELS.index(of)]


def _aside(point: Float[Array, "2"], track: Float[Array, "steps 2"]) -> Float[Array, ""]:
    """How far a track passes a point by, positive where it leaves the point to its left."""
    start, way = track[:-1], jnp.diff(track, axis=0)
    square = jnp.sum(way**2, axis=1)
    share = jnp.sum((point - start) * way, axis=1) / jnp.where(square > 0, square, 1.0)
    apart = point - start - jnp.clip(share, 0.0, 1.0)[:, None] * way
    nearest = jnp.argmin(jnp.sum(apart**2, axis=1))
    (along_x, along_y), (x, y) = way[nearest], apart[nearest]
    left = along_x * y - along_y * x
    return jnp.where(left < 0, -1.0, 1.0) * jnp.sqrt(x**2 + y**2 + 1e-12)
