"""What the models share: measured inputs, bodies, poses, ground, recorded motion."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import numpyro
from jax.scipy.special import ndtr, ndtri
from jaxtyping import Array, Float
from numpyro import distributions as dist
from retrodict.models import priors
from retrodict.models.arrays import Data, Structure

from retrodict.constants import GRAVITY
from retrodict.mechanics import (
    Bodies,
    Car,
    Ground,
    Incline,
    Path,
    Wheels,
    Zone,
    against_barrier,
    lever_arms,
)
from retrodict.scene.priors import FIXED
from retrodict.scene.records import VEHICLES, WHEELS

Values = dict[str, Float[Array, ""]]

# name of the condition that the vehicles close in, a site without a value
CLOSE_IN = "close_in"
# names of the velocities after the impact, by vehicle
AFTER = (("Vax", "Vay", "Omega_a"), ("Vbx", "Vby", "Omega_b"))


def measured(structure: Structure, data: Data) -> Values:
    """Sample the measured inputs, as functions of standard normal deviates."""
    count = len(structure.uncertain)
    if structure.family("speed_a") == FIXED and "speed_a" not in structure.names:
        numpyro.deterministic("speed_a", jnp.asarray(data.inputs["speed_a"])[0])
    if not count:
        return from_standard(structure, data, jnp.zeros(0))
    deviates = numpyro.sample("measured", dist.Normal(0.0, 1.0).expand((count,)).to_event(1))
    values = from_standard(structure, data, deviates)
    for name in structure.names:
        numpyro.deterministic(name, values[name])
    return values


def from_standard(structure: Structure, data: Data, xi: Float[Array, " inputs"]) -> Values:
    """Measured inputs from standard normal deviates.

    Args:
        structure: static structure of the scene, with the uncertain inputs and their laws.
        data: numbers of the scene, with the locations and scales of the inputs.
        xi: standard normal deviates, one for each uncertain input, in the order of the structure.

    Returns:
        Every measured input by name.
    """
    values = {name: pair[0] for name, pair in data.inputs.items()}
    if structure.uncertain:
        pairs = [data.inputs[name] for name in structure.names]
        location, scale = jnp.stack(pairs, axis=1)
        x = location + scale * xi
        x = jnp.where(_has_law(structure, "lognormal"), jnp.exp(x), x)
        if "halfnormal" in dict(structure.uncertain).values():
            half = -scale * ndtri(ndtr(-xi) / 2)
            x = jnp.where(_has_law(structure, "halfnormal"), half, x)
        if "logitnormal" in dict(structure.uncertain).values():
            x = jnp.where(_has_law(structure, "logitnormal"), jax.nn.sigmoid(x), x)
        if "uniform" in dict(structure.uncertain).values():
            even = location + scale * (2 * ndtr(xi) - 1)
            x = jnp.where(_has_law(structure, "uniform"), even, x)
        if "own" in dict(structure.uncertain).values():  # of A's speed alone
            i, law = structure.names.index("speed_a"), priors.given("speed_a", structure, data)
            assert law is not None, "the law is the user's own"
            x = x.at[i].set(priors.quantile(law, xi[i]))
        values |= dict(zip(structure.names, x, strict=True))
    for v, _ in structure.recorded:  # from its mean to the speed at the moment of the impact
        times, speeds = jnp.asarray(data.records[v]).T
        speed = jnp.interp(values[f"time_zero_{v}"], times, speeds)
        values[f"speed_{v}"] += speed - data.inputs[f"speed_{v}"][0]
    return values


def as_recorded(structure: Structure, data: Data, x: Values) -> Data:
    """The numbers of a scene with B's measured speed at the moment of the impact in its record.

    B's speed is not an input, because its law is part of the impact model.

    Args:
        structure: static structure of the scene, with the vehicles whose speeds were recorded.
        data: numbers of the scene.
        x: measured inputs by name.
    """
    if "b" not in dict(structure.recorded):
        return data
    speed = jnp.stack([x["speed_b"], data.inputs["speed_b"][1]])
    return data._replace(inputs=data.inputs | {"speed_b": speed})


def _has_law(structure: Structure, law: str) -> np.ndarray:
    return np.array([own == law for _, own in structure.uncertain])


def vehicles(x: Values) -> tuple[str, ...]:
    """Vehicles of a scene: A and B, or A alone where it struck a barrier."""
    return tuple(v for v in VEHICLES if f"mass_{v}" in x)


def levers(x: Values) -> Float[Array, "vehicles 2"]:
    """Vectors from each centre of gravity to the impact centre, road frame, m."""
    rows = []
    for v in vehicles(x):
        angle = x[f"heading_{v}"] + x[f"impact_angle_{v}"]
        rows.append(x[f"impact_distance_{v}"] * jnp.stack([jnp.cos(angle), jnp.sin(angle)]))
    return jnp.stack(rows)


def bodies(x: Values) -> Bodies:
    """Masses, inertias, lever arms and Gamma for the impact equations."""
    if "b" not in vehicles(x):
        _, _, d3, d4 = lever_arms(levers(x)[0], jnp.zeros(2))
        return against_barrier(x["mass_a"], x["yaw_inertia_a"], d3, d4, x["Gamma"])
    masses = (x["mass_a"], x["mass_b"], x["yaw_inertia_a"], x["yaw_inertia_b"])
    return Bodies(*masses, *lever_arms(*levers(x)), x["Gamma"])


def approach_of_a(x: Values) -> Float[Array, "3"]:
    """A's velocity before impact, (v_ax, v_ay, omega_a)."""
    speed, direction = x["speed_a"], x["direction_a"]
    return jnp.stack([speed * jnp.cos(direction), speed * jnp.sin(direction), x["omega_a"]])


def velocity_of_b(structure: Structure, data: Data) -> Float[Array, "2"]:
    """Sample B's speed and direction before the impact, as measured or from their priors.

    Args:
        structure: static structure of the scene, with what was measured of B.
        data: numbers of the scene.

    Returns:
        x and y of its velocity, m/s.
    """
    if "speed_b" in structure.known_of_b:
        law = dist.TruncatedNormal(*data.inputs["speed_b"], low=0.0)
        speed = numpyro.sample("speed_b", law)
    else:
        speed = priors.unknown("speed_b", structure, data, dist.HalfNormal)
    if "direction_b" in structure.known_of_b:
        law = dist.Normal(*data.inputs["direction_b"])
    else:
        law = dist.Uniform(-jnp.pi, jnp.pi)
    direction = numpyro.sample("direction_b", law)
    v_bx = numpyro.deterministic("vbx", speed * jnp.cos(direction))
    v_by = numpyro.deterministic("vby", speed * jnp.sin(direction))
    return jnp.stack([v_bx, v_by])


def approach_of_b(structure: Structure, data: Data) -> Float[Array, "3"]:
    """Sample B's velocity before the impact.

    Args:
        structure: static structure of the scene, with what was measured of B.
        data: numbers of the scene.

    Returns:
        x and y, m/s, and the yaw rate, rad/s.
    """
    velocity = velocity_of_b(structure, data)
    if "omega_b" in structure.known_of_b:
        law = dist.Normal(*data.inputs["omega_b"])
    else:
        law = dist.Normal(0.0, data.priors["omega_b"][0])
    omega_b = numpyro.sample("omega_b", law)
    return jnp.append(velocity, omega_b)


def impact_poses(x: Values) -> Float[Array, "vehicles 3"]:
    """Poses of the vehicles at impact: the impact centre minus each lever, and the headings."""
    centre = jnp.stack([x["impact_x"], x["impact_y"]]) - levers(x)
    headings = jnp.stack([x[f"heading_{v}"] for v in vehicles(x)])
    return jnp.concatenate([centre, headings[:, None]], axis=1)


def cars(structure: Structure, x: Values) -> Car:
    """The vehicles for the run-out, stacked."""
    columns = [
        (
            x[f"yaw_inertia_{v}"] / x[f"mass_{v}"],
            x[f"front_axle_{v}"],
            x[f"rear_axle_{v}"],
            x[f"track_{v}"],
        )
        for v in vehicles(x)
    ]
    k2, front, rear, track = (jnp.stack(pair) for pair in zip(*columns, strict=True))
    wheels = _wheels(x) if structure.rolling else None
    if not any(f"cg_height_{v}" in x for v in vehicles(x)):
        return Car(k2, front, rear, track, wheels)
    # at no height loads are static
    height = jnp.stack([x.get(f"cg_height_{v}", jnp.zeros(())) for v in vehicles(x)])
    return Car(k2, front, rear, track, wheels, height)


def _wheels(x: Values) -> Wheels:
    """Drag and steer of the vehicles' wheels; locked by default."""
    drag = []
    for v in vehicles(x):
        own = jnp.stack([x.get(f"drag_{wheel}_{v}", jnp.ones(())) for wheel in WHEELS])
        if f"drag_factor_{v}" in x:  # times the odds: shares stay below 1, locked stays locked
            times = x[f"drag_factor_{v}"] * own
            own = times / (1 - own + times)
        drag.append(own)
    steer = [x.get(f"steer_{v}", jnp.zeros(())) for v in vehicles(x)]
    front = jnp.array([1.0, 1.0, 0.0, 0.0])
    return Wheels(jnp.stack(drag), jnp.stack(steer)[:, None] * front)


def ground(structure: Structure, data: Data, x: Values) -> Ground:
    """Friction of the surfaces for the vehicles, stacked, where the surfaces lie, and their slope."""
    inward = data.edges.inward
    shifts = [x[f"edge_{name}"] for name in structure.surfaces[1:]]
    straight, around = shifts[: len(inward)], shifts[len(inward) :]
    shift = jnp.stack(straight)[:, None] * inward if straight else inward
    dependence = [x[f"speed_dependence_{s}"] for s in structure.surfaces]
    friction = jnp.stack([x[f"friction_{s}"] for s in structure.surfaces])
    return Ground(
        coefficients=jnp.stack([held(v, x, friction) for v in vehicles(x)]),
        speed_dependence=None if structure.constant_friction else jnp.stack(dependence),
        zones=Zone(data.edges.point + shift, inward),
        polygons=data.outlines,
        insets=jnp.stack(around) if around else 0.0,
        incline=Incline(x["grade"], x["uphill"]) if "grade" in x else None,
    )


def held(v: str, x: Values, friction: Float[Array, "*any"]) -> Float[Array, "*any"]:
    """Friction that a vehicle's tyres have; the drag factor of one that slides without wheels.

    Args:
        v: vehicle, "a" or "b".
        x: measured inputs by name.
        friction: friction of the surfaces.
    """
    if f"slides_{v}" in x:
        return jnp.broadcast_to(x[f"slides_{v}"], friction.shape)
    return x[f"grip_{v}"] * friction


def each_vehicle[T](function: Callable[..., T], *arguments: Array, car: Car, on: Ground) -> T:
    """Results of function(*arguments, car, ground) for each vehicle, stacked.

    Args:
        function: function of one vehicle: its row of each argument, its car and its ground.
        arguments: arrays with a row for each vehicle.
        car: properties of all vehicles, stacked.
        on: ground with the friction of each vehicle, as `ground` gives it.
    """
    friction = jnp.asarray(on.coefficients)

    def one(own: tuple[Array, ...], friction: Array, car: Car) -> T:
        return function(*own, car, on._replace(coefficients=friction))

    return jax.vmap(one)(arguments, friction, car)


RestPoses = Callable[[Structure, Data, Values, Float[Array, " separation"]], Array]
Paths = Callable[[Structure, Data, Values, Float[Array, " separation"]], Path]


def rest_poses_at(
    structure: Structure, data: Data, z: Float[Array, " components"]
) -> Float[Array, "vehicles component"]:
    """Rest poses z standard deviations from the measured ones, one row for each vehicle.

    Components that were not measured are z itself.
    """
    pairs = [data.evidence.get(name, np.array([0.0, 1.0])) for name in structure.rest_components]
    value, sd = jnp.stack(pairs, axis=1)
    return (value + sd * z).reshape(len(structure.vehicles), -1)


def close_in(closing: Float[Array, ""]) -> None:
    """Rule out vehicles that part before the impact.

    Args:
        closing: number with the sign of the closing speed, positive where the vehicles close in.
    """
    numpyro.factor(CLOSE_IN, jnp.where(closing > 0, 0.0, -jnp.inf))


def delta_v(x: Values, after: Float[Array, " separation"]) -> Float[Array, "vehicles 2"]:
    """Change of velocity of A and of B, m/s: B's by momentum (SAE 770014 eqs 19, 20)."""
    of_a = after[:2] - approach_of_a(x)[:2]
    if "b" not in vehicles(x):
        return of_a[None]
    return jnp.stack([of_a, -x["mass_a"] / x["mass_b"] * of_a])


def record_skids(
    structure: Structure, x: Values, after: Float[Array, " separation"], alone: bool = False
) -> None:
    """Record each vehicle's speed before its skid to the impact.

    Args:
        structure: static structure of the scene.
        x: measured inputs by name.
        after: velocities after the impact.
        alone: whether there was no impact: the speed is then recorded without a skid too.
    """
    for v, speed in _before_skids(structure, x, after).items():
        pieces = _skids(structure, x, v)
        if pieces or alone:
            numpyro.deterministic(f"travelling_speed_{v}", speed)
        if pieces and f"skid_{v}" not in x:
            whole = sum((length for length, _ in pieces), jnp.zeros(()))
            numpyro.deterministic(f"skid_{v}", whole)


def _before_skids(structure: Structure, x: Values, after: Float[Array, " separation"]) -> Values:
    """Speed of each vehicle before its skid to the impact.

    v0² = v² + 2 g (n f exp(−c v̄) cos θ + sin θ cos φ) s of each piece of the skid, v̄ the mean of v0 and
    v; n is the share of the friction that braked, θ the angle of the slope and φ that between the
    direction of travel and uphill. A drag factor stands for n f exp(−c v̄).
    """
    before = after.reshape(len(structure.vehicles), -1)[:, :2] - delta_v(x, after)
    found = {}
    for i, v in enumerate(structure.vehicles):
        found[v] = jnp.hypot(*before[i])
        square = jnp.sum(before[i] ** 2)
        normal, upward = jnp.ones(()), jnp.zeros(())
        if "grade" in x:
            normal = 1 / jnp.sqrt(1 + x["grade"] ** 2)
            course = jnp.arctan2(before[i][1], before[i][0])
            upward = normal * x["grade"] * jnp.cos(course - x["uphill"])
        for length, drag in _skids(structure, x, v):
            speed = initial = jnp.sqrt(square)
            for _ in range(1 if structure.constant_friction else 8):
                slowed = drag((initial + speed) / 2) * normal + upward
                initial = jnp.sqrt(square + 2 * GRAVITY * slowed * length)
            square, found[v] = initial**2, initial
    return found


Drag = Callable[[Float[Array, ""]], Float[Array, ""]]


def _skids(structure: Structure, x: Values, v: str) -> list[tuple[Float[Array, ""], Drag]]:
    """Length, and drag factor at a speed, of each piece of a skid, from the impact backwards."""

    def on(surface: str, braking: Float[Array, ""]) -> Drag:
        return lambda speed: braking * _friction(x, v, surface, speed)

    def constant(drag: Float[Array, ""]) -> Drag:
        return lambda _: drag

    one = jnp.ones(())
    if f"skid_{v}" in x:
        return [(x[f"skid_{v}"], on(structure.surfaces[0], x.get(f"skid_braking_{v}", one)))]
    found: list[tuple[Float[Array, ""], Drag]] = []
    for n, surface in enumerate(dict(structure.skids).get(v, ()), start=1):
        drag = on(surface, x.get(f"skid_{n}_braking_{v}", one)) if surface else None
        known = x.get(f"skid_{n}_drag_factor_{v}", one)
        found.insert(0, (x[f"skid_{n}_{v}"], drag or constant(known)))
    return found


def _friction(x: Values, v: str, surface: str, speed: Float[Array, ""]) -> Float[Array, ""]:
    """Friction of a vehicle on a surface at a speed."""
    return held(v, x, x[f"friction_{surface}"] * jnp.exp(-x[f"speed_dependence_{surface}"] * speed))


def over_critical_speed(
    structure: Structure, x: Values, after: Float[Array, " separation"]
) -> Values:
    """Speed of each vehicle over the critical speed of its yaw mark, which ends where its skid begins.

    The critical speed is √(f g r), r = c²/(8 m) + m/2 from chord c and middle ordinate m of the arc.

    Args:
        structure: static structure of the scene.
        x: measured inputs by name.
        after: velocities after the impact.

    Returns:
        The quotient by vehicle; NaN of one without a yaw mark.
    """
    found = dict.fromkeys(structure.vehicles, jnp.full((), jnp.nan))
    if not structure.yaw_marks:
        return found
    speeds = _before_skids(structure, x, after)
    for v, surface in structure.yaw_marks:
        chord, ordinate = x[f"yaw_chord_{v}"], x[f"yaw_ordinate_{v}"]
        radius = chord**2 / (8 * ordinate) + ordinate / 2
        critical = jnp.sqrt(_friction(x, v, surface, speeds[v]) * GRAVITY * radius)
        found[v] = speeds[v] / critical
    return found


def record_motion(after: Float[Array, " separation"], delta_v: Float[Array, "vehicles 2"]) -> None:
    """Record velocities after the impact and each vehicle's delta-v.

    Args:
        after: velocities of A, then B: x and y (m/s), and the yaw rate (rad/s) where the rung has one.
        delta_v: change of velocity of A and of B, m/s; of A alone where A struck a barrier.
    """
    count = len(delta_v)
    record_velocities(after, count)
    for v, change in zip(VEHICLES[:count], delta_v, strict=True):
        numpyro.deterministic(f"delta_v_{v}", jnp.hypot(*change))


def record_velocities(after: Float[Array, " separation"], count: int) -> None:
    """Record velocities after the impact.

    Args:
        after: velocities as in `record_motion`.
        count: number of vehicles.
    """
    names = [name for of_one in AFTER[:count] for name in of_one[: after.size // count]]
    for name, value in zip(names, after, strict=True):
        numpyro.deterministic(name, value)
