"""Crashes at random whose truth is known: geometry, coefficients and measurement errors are drawn."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from retrodict.mechanics import (
    Bodies,
    Car,
    Coefficients,
    Ground,
    Zone,
    audit,
    contact_velocity,
    critical_mu,
    lever_arms,
    rest,
    separation,
)
from retrodict.scene.records import (
    Approach,
    Contact,
    Edge,
    Measured,
    Rest,
    Scene,
    Surface,
    Vehicle,
)

DEGREE = np.pi / 180
ASKED = ("speed_b", "e", "mu", "e_m")
_CLOSING = {"slow": (0.3, 3.0), "grazing": (0.3, 6.0)}  # along the normal, m/s; others from 3 on
_GRAZING = 0.25  # of the speed along the contact line, at most

_audit, _contact_velocity, _critical_mu, _separation = map(
    jax.jit, (audit, contact_velocity, critical_mu, separation)
)
_rest = jax.jit(rest, static_argnames="steps")


def scene(
    rng: np.random.Generator, kind: str = "ordinary", off: float | None = None
) -> tuple[Scene, dict[str, float]]:
    """A plausible crash at random, measured with errors, and what was true of it.

    Args:
        rng: of every number.
        kind: "ordinary"; "slow", which closes in at less than 3 m/s; "grazing", which slides along the
            contact line at four times as much or more; or "lorry", in which A or B has five to twenty
            times the mass.
        off: angle from B's heading to its direction of travel, rad; None for one at random, of some
            11 deg.

    Returns:
        The scene and the true speed_b (m/s), e, mu and e_m.
    """
    while True:
        drawn = _crash(rng, kind, off)
        if drawn is not None:
            return drawn


class Cars(NamedTuple):
    """Two cars as they touch, in the road's axes; A heads along -x.

    Args:
        mass: kg, shape (2,), A first; so are all but the last two.
        front: centre of gravity to front axle, m.
        rear: to rear axle, m.
        track: m.
        inertia: in yaw, kg m².
        heading: rad.
        corner: impact centre, ahead of the centre of gravity and to its left, m, shape (2, 2).
        lever: the same in the road's axes, m, shape (2, 2).
        normal: of the contact line, from A to B.
        Gamma: angle of the contact line from the y axis, rad.
    """

    mass: np.ndarray
    front: np.ndarray
    rear: np.ndarray
    track: np.ndarray
    inertia: np.ndarray
    heading: np.ndarray
    corner: np.ndarray
    lever: np.ndarray
    normal: np.ndarray
    Gamma: float


def cars(rng: np.random.Generator) -> Cars | None:
    """Two cars at random; None where they would lie inside one another."""
    mass, front = rng.uniform(900, 2400, 2), rng.uniform(1.1, 1.4, 2)
    rear, track = rng.uniform(1.3, 1.6, 2), rng.uniform(1.4, 1.6, 2)
    inertia = mass * front * rear * rng.uniform(0.9, 1.15, 2)
    heading = np.array([np.pi, rng.uniform(-np.pi, np.pi)])
    # where on each body the other struck: anywhere on its outline
    corner = rng.uniform(-1, 1, (2, 2)) * [2.2, 0.85]
    side = rng.integers(0, 2, 2)
    corner[range(2), side] = np.sign(corner[range(2), side]) * np.array([2.2, 0.85])[side]
    lever = np.array(
        [
            [np.cos(h) * x - np.sin(h) * y, np.sin(h) * x + np.cos(h) * y]
            for h, (x, y) in zip(heading, corner, strict=True)
        ]
    )
    outward = lever[0] / np.hypot(*lever[0]) - lever[1] / np.hypot(*lever[1])
    if np.hypot(*outward) < 1.2:
        return None
    across = np.arctan2(outward[1], outward[0]) + rng.normal(0, 0.2)
    Gamma = (across + np.pi / 2) % np.pi - np.pi / 2  # the normal has no sense
    normal = np.array([np.cos(across), np.sin(across)])
    return Cars(mass, front, rear, track, inertia, heading, corner, lever, normal, Gamma)


def _crash(
    rng: np.random.Generator, kind: str, off: float | None
) -> tuple[Scene, dict[str, float]] | None:
    truth: dict[str, float] = {}

    def measure(value: float, sd: float, law: str = "normal") -> Measured:
        """What someone read off, whose error is as large as he says."""
        if law == "lognormal":
            return Measured(value * np.exp(sd * rng.standard_normal()), sd * value, "lognormal")
        return Measured(value + sd * rng.standard_normal(), sd)

    drawn = cars(rng)
    if drawn is None:
        return None
    mass, front, rear, track, inertia, heading, corner, lever, normal, Gamma = drawn
    if kind == "lorry":
        heavier = np.where(np.arange(2) == rng.integers(2), rng.uniform(5, 20), 1.0)
        mass, inertia = mass * heavier, inertia * heavier
    speed_a, speed_b = rng.uniform(8, 25), rng.uniform(3, 30)
    course = heading[1] + (rng.normal(0, 0.2) if off is None else off)
    approach = jnp.array(
        [-speed_a, 0.0, 0.0, speed_b * np.cos(course), speed_b * np.sin(course), 0.0]
    )
    bodies = Bodies(*mass, *inertia, *lever_arms(*lever), Gamma)
    meeting = np.asarray(_contact_velocity(approach, bodies))
    closing, along = meeting @ normal, abs(meeting[0] * normal[1] - meeting[1] * normal[0])
    least, most = _CLOSING.get(kind, (3.0, np.inf))
    if not least <= closing < most or (kind == "grazing" and closing > _GRAZING * along):
        return None
    truth |= {"speed_b": speed_b, "e": abs(rng.normal(0, 0.15)), "e_m": rng.uniform(0.2, 1)}
    limit = float(_critical_mu(approach, bodies, truth["e"], truth["e_m"]))
    truth["mu"] = limit * rng.uniform(0.2, 0.95)
    coefficients = Coefficients(truth["e"], truth["mu"], truth["e_m"])
    energy = _audit(approach, bodies, coefficients)
    if abs(truth["mu"]) > 1 or truth["e"] > 0.5 or energy.after > energy.before:
        return None
    after = np.asarray(_separation(approach, bodies, coefficients)).reshape(2, 3)
    if np.abs(after[:, 2]).max() > 12:
        return None

    friction = np.array([rng.uniform(0.35, 0.85), 0.0])
    friction[1] = friction[0] * rng.uniform(0.6, 1.1)
    edge_at = rng.uniform(3, 12)
    ground = Ground(friction, None, Zone(np.array([[0.0, edge_at]]), np.array([[0.0, 1.0]])))
    rests = {}
    for i, v in enumerate("ab"):
        pose = jnp.array([*-lever[i], heading[i]])
        car = Car(inertia[i] / mass[i], front[i], rear[i], track[i])
        x, y, turned = np.asarray(_rest(pose, jnp.asarray(after[i]), car, ground, steps=1000))
        rests[v] = Rest(measure(x, 0.2), measure(y, 0.2), measure(turned, 4 * DEGREE), True)

    def vehicle(i: int) -> Vehicle:
        angle = (np.arctan2(corner[i, 1], corner[i, 0]) + np.pi) % (2 * np.pi) - np.pi
        return Vehicle(
            name=f"car {'AB'[i]}",
            mass=measure(mass[i], 0.02, "lognormal"),
            yaw_inertia=measure(inertia[i], 0.06, "lognormal"),
            front_axle=Measured(front[i], 0.0, "lognormal"),
            rear_axle=Measured(rear[i], 0.0, "lognormal"),
            track=Measured(track[i], 0.0, "lognormal"),
            impact_distance=measure(np.hypot(*corner[i]), 0.03, "lognormal"),
            impact_angle=measure(angle, 2 * DEGREE),
            heading=measure(heading[i], 2 * DEGREE),
            length=4.6,
            width=1.75,
        )

    def road(name: str, f: float, edge: Edge | None) -> Surface:
        return Surface(name, measure(f, 0.06, "lognormal"), Measured(0.0), edge)

    return (
        Scene(
            title="A crash at random",
            name="random",
            text="",
            vehicles={"a": vehicle(0), "b": vehicle(1)},
            approach={
                "a": Approach(
                    measure(speed_a, 0.9), measure(np.pi, DEGREE), measure(0.0, 2 * DEGREE)
                ),
                "b": Approach(None, None, None),
            },
            rest=rests,
            contact=Contact(Measured(0.0, 0.05), Measured(0.0, 0.05), measure(Gamma, 3 * DEGREE)),
            surfaces=(
                road("road", friction[0], None),
                road("berm", friction[1], Edge(0.0, edge_at, 0.0, "left", Measured(0.0, 0.1))),
            ),
        ),
        truth,
    )
