"""Evidence: the prediction and likelihood of each item, after the impact or of the impact itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import numpyro
from jaxtyping import Array, Float
from numpyro import distributions as dist
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.at_least import AtLeast, AtMost

from retrodict.mechanics import Car, Path, end_of_rotation, wheel_paths
from retrodict.scene.fields import COEFFICIENTS
from retrodict.scene.names import parsed
from retrodict.scene.records import FREEDOM, WHEELS

# degrees of freedom of the Student-t in a robust scene: mean and variance exist, and a residual of
# four standard deviations has no more influence than one of two


class Motion(NamedTuple):
    """The predicted motion of one vehicle after the impact.

    Args:
        after: velocity: x and y, m/s, and the yaw rate, rad/s, where the model has one.
        delta_v: change of velocity in the impact, road frame, m/s.
        heading: heading at the impact, rad.
        start: position at the impact, m.
        rest: rest pose: x, y, m, and heading, rad, where the model has one.
        path: path from impact to rest; None where no evidence needs it.
        car: properties of the vehicle, of which the axles and the track are used.
        over_critical: speed over the critical speed of its yaw mark; NaN without one.
    """

    after: Float[Array, " velocity"]
    delta_v: Float[Array, "2"]
    heading: Float[Array, ""]
    start: Float[Array, "2"]
    rest: Float[Array, " pose"]
    path: Path | None
    car: Car
    over_critical: Float[Array, ""]


class Prediction(NamedTuple):
    """How an item of evidence follows from the motion.

    Args:
        of: function of the motion that gives the measured quantity.
        yaws: whether only models whose vehicles yaw predict the item.
        circular: whether the quantity is an angle that is compared modulo one turn.
        at_least: whether the measured value is a bound that the quantity reaches or exceeds, away
            from zero.
    """

    of: Callable[[Motion], Array]
    yaws: bool = False
    circular: bool = False
    at_least: bool = False


# name of an item, velocities after the impact and the exact value -> that value, with derivatives
Surrogate = Callable[[str, Array, Array], Array]

PREDICTIONS: dict[str, Prediction] = {  # by name of the evidence, without its vehicle
    "rest_x": Prediction(lambda motion: motion.rest[0]),
    "rest_y": Prediction(lambda motion: motion.rest[1]),
    "rest_heading": Prediction(lambda motion: motion.rest[2], yaws=True),
    "run_out_distance": Prediction(lambda motion: _length(_way(motion))),
    "run_out_direction": Prediction(
        lambda motion: jnp.arctan2(_way(motion)[1], _way(motion)[0]), circular=True
    ),
    "departure_direction": Prediction(
        lambda motion: jnp.arctan2(motion.after[1], motion.after[0]), circular=True
    ),
    "departure_speed": Prediction(lambda motion: jnp.hypot(motion.after[0], motion.after[1])),
    "departure_yaw_rate": Prediction(lambda motion: motion.after[2], yaws=True),
    "departure_delta_v": Prediction(lambda motion: jnp.hypot(*motion.delta_v)),
    "departure_delta_v_forward": Prediction(lambda motion: motion.delta_v @ _axis(motion.heading)),
    "departure_delta_v_left": Prediction(
        lambda motion: motion.delta_v @ _axis(motion.heading + np.pi / 2)
    ),
    "yaw_mark": Prediction(lambda motion: motion.over_critical),
    "end_x": Prediction(lambda motion: _end(motion)[0], yaws=True),
    "end_y": Prediction(lambda motion: _end(motion)[1], yaws=True),
    "end_heading": Prediction(lambda motion: _end(motion)[2], yaws=True, circular=True),
}
PREDICTIONS |= {
    f"{name}_at_least": PREDICTIONS[name]._replace(at_least=True)
    for name in ("departure_delta_v", "departure_delta_v_forward", "departure_delta_v_left")
}


class OfImpact(NamedTuple):
    """What an item of evidence states of the impact itself.

    Args:
        quantity: name of the quantity in the impact model.
        bound: kind of bound that the measured value is; None for a value.
    """

    quantity: str
    bound: type[AtLeast] | None = None


OF_IMPACT: dict[str, OfImpact] = {
    "impact_energy_lost": OfImpact("energy_lost"),
    "impact_energy_lost_at_least": OfImpact("energy_lost", AtLeast),
    "impact_energy_lost_at_most": OfImpact("energy_lost", AtMost),
    **{f"impact_{name}": OfImpact(name) for name in COEFFICIENTS},
}


def explained(name: str, turns: bool) -> bool:
    """Whether a model predicts an item of evidence.

    Args:
        name: name of the item, as in `Scene.evidence`.
        turns: whether the model's vehicles yaw.
    """
    kind, _, mark = parsed(name)
    return mark is not None or (kind in PREDICTIONS and (turns or not PREDICTIONS[kind].yaws))


def observe(
    structure: Structure,
    data: Data,
    x: parts.Values,
    after: Float[Array, " separation"],
    rests: Float[Array, "vehicles rest"],
    paths: Path | None,
    surrogate: Surrogate | None = None,
) -> None:
    """The likelihood: one `sample` with `obs=` for each item of evidence.

    Args:
        structure: static structure of the scene, with the names of the items.
        data: numbers of the scene, with the measured value and sd of each item.
        x: measured inputs by name.
        after: velocities after the impact, A's first.
        rests: rest poses of the vehicles, one row each.
        paths: paths of the vehicles to rest, stacked; None where nothing was measured on them.
        surrogate: surrogate of the run-out predictions, which returns the exact value of an item that
            it does not cover; None to use the exact values.
    """
    cars, changes = parts.cars(structure, x), parts.delta_v(x, after)
    starts, velocities = parts.impact_poses(x), after.reshape(len(structure.vehicles), -1)
    passed, over_critical = dict(structure.marks), parts.over_critical_speed(structure, x, after)
    for i, v in enumerate(structure.vehicles):
        k2, front, rear, track = (jnp.asarray(own)[i] for own in cars[:4])
        car = Car(k2, front, rear, track)
        path = None if paths is None else Path(*(rows[i] for rows in paths))
        heading = x[f"heading_{v}"]
        motion = Motion(
            velocities[i], changes[i], heading, starts[i, :2], rests[i], path, car, over_critical[v]
        )
        for name in structure.evidence:
            kind, vehicle, mark = parsed(name)
            if vehicle != v:
                continue
            value = data.evidence[name][0]
            if mark is not None:
                point = jnp.asarray(data.marks[name])
                predicted = _passing(motion, point, passed[name])[kind]
                circular = kind == "mark_course"
            else:
                predict, _, circular, _ = PREDICTIONS[kind]
                predicted = predict(motion)
            if surrogate:
                predicted = surrogate(name, after, predicted)
            if circular:
                # the equivalent angle nearest to the measured one
                off = predicted - value
                predicted = value + jnp.arctan2(jnp.sin(off), jnp.cos(off))
            bound = AtLeast if mark is None and PREDICTIONS[kind].at_least else None
            _sample(name, structure, data, predicted, bound)


def of_impact(*quantities: str) -> tuple[str, ...]:
    """Names of the items of evidence on quantities of the impact, by name in the impact model."""
    return tuple(name for name, item in OF_IMPACT.items() if item.quantity in quantities)


def observe_impact(structure: Structure, data: Data, quantities: Mapping[str, Array]) -> None:
    """The likelihood of what is stated of the impact itself.

    Args:
        structure: static structure of the scene, with the names of the items.
        data: numbers of the scene, with the stated value and sd of each item.
        quantities: quantities of the impact, by name in `OF_IMPACT`, each of shape (); energy_lost is
            the kinetic energy before less that after, J.
    """
    for name, (quantity, bound) in OF_IMPACT.items():
        if name in structure.evidence:
            _sample(name, structure, data, quantities[quantity], bound)


def _sample(
    name: str, structure: Structure, data: Data, predicted: Array, bound: type[AtLeast] | None
) -> None:
    value, sd = data.evidence[name]
    if bound:
        law: dist.Distribution = bound(predicted, sd, value, structure.robust)
    elif structure.robust:
        law = dist.StudentT(FREEDOM, predicted, sd)
    else:
        law = dist.Normal(predicted, sd)
    numpyro.sample(name, law, obs=value)


def _axis(angle: Array) -> Float[Array, "2"]:
    return jnp.stack([jnp.cos(angle), jnp.sin(angle)])


def _way(motion: Motion) -> Float[Array, "2"]:
    """From where the vehicle was struck to where it came to rest, m."""
    return motion.rest[:2] - motion.start


def _length(way: Float[Array, "2"]) -> Float[Array, ""]:
    return jnp.sqrt(way @ way + 1e-12)  # differentiable where a vehicle stays


def _end(motion: Motion) -> Float[Array, "3"]:
    assert motion.path is not None, "the end of rotation asks for paths"
    return end_of_rotation(motion.path, motion.car)


def _passing(motion: Motion, point: Float[Array, "2"], of: str) -> dict[str, Float[Array, ""]]:
    """The track of the centre of gravity, or of a wheel, where it passes closest to a point.

    Returns:
        mark: signed distance to the point, m, positive where the point lies to the left of the track;
        mark_speed (m/s) and mark_course (rad) of the centre of gravity there.
    """
    path = motion.path
    assert path is not None, "marks ask for paths"
    track = path.pose[:, :2]
    if of != "centre":
        track = wheel_paths(path.pose, motion.car)[:, WHEELS.index(of)]
    start, way = track[:-1], jnp.diff(track, axis=0)
    length2 = jnp.sum(way**2, axis=1)
    share = jnp.sum((point - start) * way, axis=1) / jnp.where(length2 > 0, length2, 1.0)
    share = jnp.clip(share, 0.0, 1.0)
    apart = point - start - share[:, None] * way
    nearest = jnp.argmin(jnp.sum(apart**2, axis=1))

    def there(rows: Float[Array, "steps *any"]) -> Float[Array, "*any"]:
        return rows[nearest] + share[nearest] * (rows[nearest + 1] - rows[nearest])

    (along_x, along_y), (x, y) = way[nearest], apart[nearest]
    left = along_x * y - along_y * x
    aside = jnp.where(left < 0, -1.0, 1.0) * jnp.sqrt(x**2 + y**2 + 1e-12)
    V = path.velocity[:, :2]
    # v² is linear in distance under constant deceleration
    speed = jnp.sqrt(there(jnp.sum(V**2, axis=1)) + 1e-12)
    V_x, V_y = there(V.at[-1].set(V[-2]))  # at rest: course of the last motion
    return {"mark": aside, "mark_speed": speed, "mark_course": jnp.arctan2(V_y, V_x)}
