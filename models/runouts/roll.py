"""The run-out along the measured path: V² = 2 g f L, the drag factor f from the wheels' states."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.description import Description
from retrodict.models.run_out import NORMAL_ERRORS, OF_WHEELS, RunOut, level

from retrodict.mechanics import (
    Car,
    Ground,
    Path,
    Way,
    Wheels,
    rest,
    rolled,
    rolled_back,
    run_out,
    way_taken,
)
from retrodict.mechanics.rollout import MEAN_YAW_RATE, WayTaken, turning
from retrodict.mechanics.rotation import cos_sin
from retrodict.mechanics.runout import ROWS
from retrodict.scene.records import WHEELS, Measured, Scene

_SOURCE = "run-outs on wheels simulated at random, of which this model misses so much (grade B)"


def rest_poses(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, " separation"]
) -> Float[Array, "vehicles 3"]:
    """Rest poses of the vehicles for velocities after the impact."""
    steps = structure.steps or data.steps
    ends = []
    for i, v in enumerate(structure.vehicles):
        start, velocity, car, ground = _of_one(structure, data, x, after, i)
        if v in structure.integrated:
            ends.append(rest(start, velocity, car._replace(wheels=None), ground, steps))
        else:
            at = jnp.ones(1)
            ends.append(_along_its_way(data, x, v, start, velocity, car, ground, at)[0])
    return jnp.stack(ends)


def paths(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, " separation"]
) -> Path:
    """Paths of the vehicles to rest, stacked."""
    steps = structure.steps or ROWS
    ways = []
    for i, v in enumerate(structure.vehicles):
        start, velocity, car, ground = _of_one(structure, data, x, after, i)
        if v in structure.integrated:
            ways.append(run_out(start, velocity, car._replace(wheels=None), ground, steps))
        else:
            at = jnp.linspace(0.0, 1.0, steps + 2)
            pose = _along_its_way(data, x, v, start, velocity, car, ground, at)
            ways.append(_slowing_evenly(pose, velocity, at))
    return Path(*(jnp.stack(rows) for rows in zip(*ways, strict=True)))


def _slowing_evenly(
    pose: Float[Array, "rows 3"], velocity: Float[Array, "3"], at: Float[Array, " rows"]
) -> Path:
    """The path through poses at shares of its length, at constant deceleration."""
    first, left = jnp.hypot(velocity[0], velocity[1]), jnp.sqrt(1 - at)
    legs = jnp.diff(pose[:, :2], axis=0, append=pose[-1:, :2])
    length = jnp.sum(jnp.hypot(legs[:, 0], legs[:, 1]))
    time = 2 * length / jnp.maximum(first, 1e-9) * (1 - left)
    course = jnp.arctan2(legs[:, 1], legs[:, 0])
    speed = first * left
    turns, lasts = (jnp.diff(rows, append=rows[-1:]) for rows in (pose[:, 2], time))
    Omega = turns / jnp.maximum(lasts, 1e-9)
    columns = [speed * jnp.cos(course), speed * jnp.sin(course), Omega]
    return Path(pose, jnp.stack(columns, axis=1), time)


def inverse(
    structure: Structure, data: Data, x: parts.Values, v: str
) -> Callable[[Float[Array, "3"]], Float[Array, "3"]]:
    """The function from the rest pose of a rolling vehicle to its velocity after the impact."""
    still, i = jnp.zeros(3 * len(structure.vehicles)), structure.vehicles.index(v)
    start, _, car, ground = _of_one(structure, data, x, still, i)
    taken = _taken(data, v, start, car, ground)
    # an unmeasured rest heading is relative to the heading at impact
    heading = 0.0 if f"rest_heading_{v}" in structure.evidence else start[2]

    def back(end: Float[Array, "3"]) -> Float[Array, "3"]:
        return _off_its_way(x, v, rolled_back(end.at[2].add(heading), start, taken))

    return back


def _of_one(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, " separation"], i: int
) -> tuple[Float[Array, "3"], Float[Array, "3"], Car, Ground]:
    """Pose at impact, velocity after it, car and ground of one vehicle."""
    car = jax.tree.map(lambda both: jnp.asarray(both)[i], parts.cars(structure, x))
    ground = parts.ground(structure, data, x)
    ground = ground._replace(coefficients=jnp.asarray(ground.coefficients)[i])
    return parts.impact_poses(x)[i], after.reshape(-1, 3)[i], car, ground


def _taken(data: Data, v: str, start: Float[Array, "3"], car: Car, ground: Ground) -> WayTaken:
    x_y_heading = jnp.asarray(data.ways[v])
    return way_taken(Way(x_y_heading[:, :2], x_y_heading[:, 2]), start, car, ground)


def _along_its_way(
    data: Data,
    x: parts.Values,
    v: str,
    start: Float[Array, "3"],
    velocity: Float[Array, "3"],
    car: Car,
    ground: Ground,
    at: Float[Array, " rows"],
) -> Float[Array, "rows 3"]:
    own = _of_its_way(x, v, velocity)
    return rolled(own, start, _taken(data, v, start, car, ground), at)


# Approximation errors of a vehicle with a measured rest pose: the ratio of its speed after the impact
# to that of its way, and the differences of course and yaw rate.


def offsets(v: str) -> tuple[str, str, str]:
    """Names of the inputs for the approximation errors of a vehicle."""
    return f"roll_speed_{v}", f"roll_course_{v}", f"roll_yaw_rate_{v}"


def _of_its_way(x: parts.Values, v: str, velocity: Float[Array, "3"]) -> Float[Array, "3"]:
    """The velocity without the approximation errors: the one that the measured way belongs to."""
    if f"roll_speed_{v}" not in x:
        return velocity
    c, s = cos_sin(x[f"roll_course_{v}"])
    Vx, Vy, Omega = velocity
    along = jnp.stack([c * Vx + s * Vy, c * Vy - s * Vx]) / x[f"roll_speed_{v}"]
    return jnp.append(along, Omega - x[f"roll_yaw_rate_{v}"])


def _off_its_way(x: parts.Values, v: str, own: Float[Array, "3"]) -> Float[Array, "3"]:
    """Inverse of `_of_its_way`."""
    c, s = cos_sin(x[f"roll_course_{v}"])
    Vx, Vy, Omega = own
    velocity = x[f"roll_speed_{v}"] * jnp.stack([c * Vx - s * Vy, s * Vx + c * Vy])
    return jnp.append(velocity, Omega + x[f"roll_yaw_rate_{v}"])


def way_of(scene: Scene, v: str) -> Float[np.ndarray, "points 3"]:
    """Measured points of a vehicle after the impact: x, y and heading (NaN where unknown).

    Marks of its centre of gravity by their distance from the impact, then the rest position; marks that
    lie farther off than the rest position are left out.

    Args:
        scene: scene with the marks and rest pose of the vehicle.
        v: vehicle, "a" or "b".
    """
    start, end = scene.at_impact(v), scene.rest.get(v)
    seen = [(mark.x, mark.y, math.nan) for mark in scene.marks.get(v, ()) if mark.of == "centre"]
    seen.sort(key=lambda point: math.dist(start, point[:2]))
    if end is not None:
        rest_at = (end.x.value, end.y.value)
        seen = [point for point in seen if math.dist(start, point[:2]) < math.dist(start, rest_at)]
        seen.append((*rest_at, end.heading.value if end.heading else math.nan))
    if not seen:  # nothing asks where it went
        heading = scene.vehicles[v].heading.value
        seen.append((start[0] + math.cos(heading), start[1] + math.sin(heading), math.nan))
    return np.array(seen)


def spreads(free: float, steer: float, first: float, turned: float) -> tuple[float, float, float]:
    """Standard deviations of the model error: of ln(speed), course and rotation (rad).

    Fitted by hand to what `benchmarks/roll.py` charts.

    Args:
        free: freedom of the vehicle to roll: 1 less the drag of its wheels, weighted by their loads.
        steer: steer angle of the front wheels, rad.
        first: share of the path up to the first point that was measured on it.
        turned: rotation from impact to rest, rad.
    """
    steered = 0.5 * min(abs(steer) / 0.07, 1.0) * free**4
    of_speed = math.hypot(0.04, 0.23 * free**2, steered)
    of_course = math.hypot(0.045, 0.5 * free**2.1, steered) * first**0.8
    return of_speed, of_course, math.hypot(0.8, math.hypot(0.15, 0.45 * free) * turned)


def approximations(scene: Scene) -> dict[str, Measured]:
    """Approximation errors of each vehicle that rolled to rest, as inputs."""
    found: dict[str, Measured] = {}
    for v in scene.rolling:
        if v not in scene.rest:
            continue
        of_speed, of_course, of_yaw_rate = _missed(scene, v)
        mean = math.exp(of_speed**2 / 2)  # where the median is 1
        relative = Measured(mean, mean * math.sqrt(math.expm1(of_speed**2)), "lognormal")
        errors = (relative, Measured(0.0, of_course), Measured(0.0, of_yaw_rate))
        for name, error in zip(offsets(v), errors, strict=True):
            found[name] = replace(error, source=_SOURCE, assumed="sd")
    return found


def _missed(scene: Scene, v: str) -> tuple[float, float, float]:
    """Standard deviations of a vehicle's approximation errors.

    Args:
        scene: scene with the rest pose of the vehicle.
        v: vehicle, "a" or "b".

    Returns:
        Standard deviations of ln(speed), of the course, rad, and of the yaw rate, rad/s.
    """
    vehicle, way = scene.vehicles[v], way_of(scene, v)
    wheels = vehicle.wheels
    drag, steer = np.ones(4), 0.0
    if wheels is not None:
        drag = np.array([getattr(wheels, wheel).value for wheel in WHEELS])
        steer = math.hypot(wheels.steer.value, wheels.steer.sd)
    front, rear = vehicle.front_axle.value, vehicle.rear_axle.value
    k2 = vehicle.yaw_inertia.value / vehicle.mass.value
    car = Car(k2, front, rear, vehicle.track.value, Wheels(drag, np.zeros(4)))
    loads = np.array([rear, rear, front, front]) / (front + rear) / 2
    legs = np.hypot(*np.diff(np.vstack([scene.at_impact(v), way[:, :2]]), axis=0).T)
    turned = float(np.nan_to_num(way[-1, 2] - vehicle.heading.value))
    grip = vehicle.grip.value * scene.surfaces[0].friction.value
    share, speed = turning(turned, legs.sum(), grip, car, np)
    of_speed, of_course, of_turn = spreads(
        1 - float(loads @ drag), steer, legs[0] / legs.sum(), turned
    )
    lasts = MEAN_YAW_RATE * share * 2 * legs.sum() / speed
    return float(of_speed), float(of_course), float(of_turn / lasts)


def _refusal(scene: Scene) -> str:
    rolling = scene.rolling
    if not rolling:
        return "no wheel rolls"
    if not any(v in scene.rest for v in rolling):
        return "of no vehicle that rolls it was measured where it came to rest"
    if scene.slope is not None:  # it stands in for fuller ones, with errors found on level ground
        return "takes the road as level, and a slope moves a car that rolls by more than its errors"
    return ""


RUN_OUT = RunOut(
    description=Description(
        name="roll",
        title="a run-out along the measured way",
        equations=(
            "run-out of a vehicle that rolls: V² = 2 g f L, f the mean over the way of the drag factor, "
            "which is the wheels' load shares times friction times the force of each against the "
            "course, by its state and slip angle; D. Struble (2020) sums it so",
            "rotation = 0.55 Ω (2 L / V) s, s the share of the way on which it turns: as long as "
            "friction at the wheels takes to end the rotation that was measured",
        ),
        assumptions=(
            "the way is the straight lines from the impact through the marks of its centre of gravity "
            "to rest, as measured; another velocity makes it longer and turns it; marks count as that "
            "way, and not as evidence besides",
            "the model error enters as three inputs: errors of the speed, course and yaw rate after the "
            "impact; their standard deviations come from simulated run-outs (grade B)",
            "wheels keep their state from impact to rest; a vehicle whose wheels are all locked skids "
            "as a rigid body",
            NORMAL_ERRORS,
        ),
        left_out=(
            "curvature of the path of a steered, rolling car, beyond these errors; steering or braking "
            "in between; load transfer, pitch and roll; slopes",
        ),
    ),
    rests=("x", "y", "heading"),
    seen=level,
    rest_poses=rest_poses,
    paths=paths,
    needs=OF_WHEELS,
    nesting=frozenset({"yaw", "rolling"}),
    integrated=lambda scene: tuple(v for v in scene.vehicles if v not in scene.rolling),
    ways=lambda scene: {v: way_of(scene, v) for v in scene.rolling},
    approximations=approximations,
    inverse=inverse,
    refusal=_refusal,
)
