"""What the rungs are built from: a scene as arrays, its measured inputs, poses, ground, evidence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import numpyro
import numpyro.distributions as dist
from jaxtyping import Array, Float

import retrodict._precision  # noqa: F401
from retrodict.mechanics import Bodies, Car, Ground, Zone, lever_arms, rest
from retrodict.scene.records import VEHICLES, Measured, Scene

Values = dict[str, Float[Array, ""]]

# measured of B before impact: evidence on what the impact's inverse gives, not an input of its own
OF_B = ("direction_b", "omega_b")
_RESTS = tuple(f"rest_{part}_{v}" for v in VEHICLES for part in ("x", "y", "heading"))


@dataclass(frozen=True, slots=True)
class Structure:
    """What of a scene decides the program and not its numbers: one compiled program serves all
    scenes of one structure.

    Args:
        uncertain: measured inputs that carry an uncertainty, with their error laws.
        surfaces: names, the one that lies everywhere first.
        known_of_b: which of `OF_B` was measured.
        constant_friction: whether no surface's friction depends on speed.
        steps: of each run-out's integration; `inference` takes as many as the scene needs.
    """

    uncertain: tuple[tuple[str, str], ...]
    surfaces: tuple[str, ...]
    known_of_b: tuple[str, ...]
    constant_friction: bool
    steps: int = 48

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the uncertain inputs, in their order."""
        return tuple(name for name, _ in self.uncertain)


class Data(NamedTuple):
    """A scene's numbers, as arguments of the compiled programs.

    NumPy arrays: JAX would compile a small program for every step of their making.

    Args:
        inputs: (location, scale) of every measured input: of the quantity itself, or of its
            logarithm where the law is lognormal and the input uncertain.
        evidence: (value, sd) of every item of evidence.
        edges: where each edge runs: point and unit normal into the zone, m.
    """

    inputs: dict[str, Float[Array | np.ndarray, "2"]]
    evidence: dict[str, Float[Array | np.ndarray, "2"]]
    edges: Zone


def of_scene(scene: Scene) -> tuple[Structure, Data]:
    """A scene as a program's structure and its arguments."""
    inputs = scene.inputs()
    uncertain = tuple((k, m.law) for k, m in inputs.items() if m.sd > 0 and k not in OF_B)
    edges = [s.edge for s in scene.surfaces if s.edge is not None]
    sign = {"left": 1.0, "right": -1.0}
    angles = np.array([e.direction for e in edges])
    turn = np.array([sign[e.side] for e in edges])
    zones = Zone(
        point=np.array([[e.x, e.y] for e in edges]).reshape(-1, 2),
        inward=(turn * np.stack([-np.sin(angles), np.cos(angles)])).T.reshape(-1, 2),
    )
    return (
        Structure(
            uncertain=uncertain,
            surfaces=tuple(s.name for s in scene.surfaces),
            known_of_b=tuple(k for k in OF_B if k in inputs),
            constant_friction=all(
                s.speed_dependence.value == 0 == s.speed_dependence.sd for s in scene.surfaces
            ),
        ),
        Data(
            inputs={k: _location_and_scale(m) for k, m in inputs.items()},
            evidence={k: np.array([m.value, m.sd]) for k, m in scene.evidence().items()},
            edges=zones,
        ),
    )


def _location_and_scale(m: Measured) -> Float[np.ndarray, "2"]:
    """Of the normal law, or of the logarithm's normal with the measured mean and sd."""
    if m.law == "lognormal" and m.sd > 0:
        variance = np.log1p((m.sd / m.value) ** 2)
        return np.array([np.log(m.value) - variance / 2, np.sqrt(variance)])
    return np.array([m.value, m.sd])


def measured(structure: Structure, data: Data) -> Values:
    """Measured inputs: where uncertain, as far from what was measured as standard deviates say."""
    count = len(structure.uncertain)
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
        structure: which inputs are uncertain.
        data: their locations and scales.
        xi: one deviate for each uncertain input, in order.

    Returns:
        Every measured input by name.
    """
    values = {name: pair[0] for name, pair in data.inputs.items()}
    if structure.uncertain:
        pairs = [data.inputs[name] for name in structure.names]
        location, scale = jnp.stack(pairs, axis=1)
        x = location + scale * xi
        x = jnp.where(_is_lognormal(structure), jnp.exp(x), x)
        values |= dict(zip(structure.names, x, strict=True))
    return values


def _is_lognormal(structure: Structure) -> np.ndarray:
    return np.array([law == "lognormal" for _, law in structure.uncertain])


def levers(x: Values) -> Float[Array, "2 2"]:
    """Vectors from each centre of gravity to the impact centre, road frame, m."""
    rows = []
    for v in VEHICLES:
        angle = x[f"heading_{v}"] + x[f"impact_angle_{v}"]
        rows.append(x[f"impact_distance_{v}"] * jnp.stack([jnp.cos(angle), jnp.sin(angle)]))
    return jnp.stack(rows)


def bodies(x: Values) -> Bodies:
    """Masses, inertias, lever arms and Gamma, as the impact equations take them."""
    masses = (x["mass_a"], x["mass_b"], x["yaw_inertia_a"], x["yaw_inertia_b"])
    return Bodies(*masses, *lever_arms(*levers(x)), x["Gamma"])


def approach_of_a(x: Values) -> Float[Array, "3"]:
    """A's velocity before impact, (v_ax, v_ay, omega_a)."""
    speed, direction = x["speed_a"], x["direction_a"]
    return jnp.stack([speed * jnp.cos(direction), speed * jnp.sin(direction), x["omega_a"]])


def impact_poses(x: Values) -> Float[Array, "2 3"]:
    """Where A and B are at impact: the impact centre less each lever, and the headings."""
    centre = jnp.stack([x["impact_x"], x["impact_y"]]) - levers(x)
    headings = jnp.stack([x["heading_a"], x["heading_b"]])
    return jnp.concatenate([centre, headings[:, None]], axis=1)


def cars(x: Values) -> Car:
    """Both vehicles as the run-out takes them, stacked."""
    columns = [
        (
            x[f"yaw_inertia_{v}"] / x[f"mass_{v}"],
            x[f"front_axle_{v}"],
            x[f"rear_axle_{v}"],
            x[f"track_{v}"],
        )
        for v in VEHICLES
    ]
    k2, front, rear, track = (jnp.stack(pair) for pair in zip(*columns, strict=True))
    return Car(k2, front, rear, track)


def ground(structure: Structure, data: Data, x: Values) -> Ground:
    """The surfaces' friction and the edges where they run."""
    inward = data.edges.inward
    shifts = [x[f"edge_{name}"] for name in structure.surfaces[1:]]
    shift = jnp.stack(shifts)[:, None] * inward if shifts else inward
    dependence = [x[f"speed_dependence_{s}"] for s in structure.surfaces]
    return Ground(
        coefficients=jnp.stack([x[f"friction_{s}"] for s in structure.surfaces]),
        speed_dependence=None if structure.constant_friction else jnp.stack(dependence),
        zones=Zone(data.edges.point + shift, inward),
    )


def rest_poses(
    structure: Structure, data: Data, x: Values, separation: Float[Array, "6"]
) -> Float[Array, "2 3"]:
    """Where both vehicles come to rest after separating with these velocities."""
    on = ground(structure, data, x)
    run = jax.vmap(lambda pose, velocity, car: rest(pose, velocity, car, on, structure.steps))
    return run(impact_poses(x), separation.reshape(2, 3), cars(x))


RestPoses = Callable[[Structure, Data, Values, Float[Array, "6"]], Float[Array, "2 3"]]


def measured_rests(data: Data, z: Float[Array, "6"]) -> Float[Array, "2 3"]:
    """Rest poses that lie z standard deviations from those measured."""
    value, sd = jnp.stack([data.evidence[name] for name in _RESTS], axis=1)
    return (value + sd * z).reshape(2, 3)


def observe(data: Data, poses: Float[Array, "2 3"]) -> None:
    """Compare the rest poses with those measured."""
    for name, predicted in zip(_RESTS, poses.reshape(6), strict=True):
        value, sd = data.evidence[name]
        numpyro.sample(name, dist.Normal(predicted, sd), obs=value)
