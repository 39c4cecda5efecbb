"""How far the run-out along the measured way misses the one on wheels, by which wheels are locked.

python3 -m uv run python -m benchmarks.roll [run-outs of each pattern]

Prints a row for each pattern, straight or steered, and number of points that were seen on the way:
mean and standard deviation of the error of the speed (its logarithm), of the course and of the
rotation, and which share of them lies within the 90 % that
`retrodict.models.runouts.roll.spreads` states.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from retrodict.models.runouts.roll import spreads

from retrodict.mechanics import Car, Ground, Way, Wheels, Zone, rolled, run_out, way_taken

PATTERNS = {
    "none locked": (0, 0, 0, 0),
    "front left": (1, 0, 0, 0),
    "rear left": (0, 0, 1, 0),
    "left": (1, 0, 1, 0),
    "front": (1, 1, 0, 0),
    "rear": (0, 0, 1, 1),
    "front left, rear right": (1, 0, 0, 1),
    "all but rear right": (1, 1, 1, 0),
}
STEPS = 1024
SEEN = (0, 1)  # points on the way besides its ends
NINETY = 1.645


class Crashes(NamedTuple):
    """Run-outs that depart along x; a row each."""

    car: Car
    friction: np.ndarray
    heading: np.ndarray
    velocity: np.ndarray


def crashes(rng: np.random.Generator, locked: tuple[int, ...], steered: bool, n: int) -> Crashes:
    """Speeds of 3 to 20 m/s, yaw rates up to 6 rad/s, headings up to a quarter turn off the course."""
    front, rear, track = (
        rng.uniform(1.1, 1.4, n),
        rng.uniform(1.3, 1.6, n),
        rng.uniform(1.4, 1.6, n),
    )
    drag = np.where(locked, 1.0, rng.uniform(0.01, 0.12, (n, 1)))
    steer = rng.normal(0, 0.1, (n, 1)) * [1, 1, 0, 0] if steered else np.zeros((n, 4))
    k2 = front * rear * rng.uniform(0.9, 1.15, n)
    zero = np.zeros(n)
    velocity = np.stack([rng.uniform(3, 20, n), zero, rng.uniform(-6, 6, n)], axis=1)
    car = Car(k2, front, rear, track, Wheels(drag, steer))
    quarter = np.pi / 2
    return Crashes(car, rng.uniform(0.4, 0.85, n), rng.uniform(-quarter, quarter, n), velocity)


@jax.jit
def followed(them: Crashes) -> tuple[jax.Array, jax.Array]:
    """Poses on the way, and at rest, by the run-out on wheels."""

    def one(each: Crashes) -> tuple[jax.Array, jax.Array]:
        start = jnp.array([0.0, 0.0, 1.0]) * each.heading
        path = run_out(start, each.velocity, each.car, _road(each), STEPS)
        return path.pose[::8], path.pose[-1]

    return jax.vmap(one)(them)


@jax.jit
def missed(
    them: Crashes, points: jax.Array, heading: jax.Array
) -> tuple[jax.Array, jax.Array, jax.Array]:
    """Logarithm of the true speed over the model's, its course and its rotation less the true ones."""

    def one(each: Crashes, points: jax.Array, at_rest: jax.Array) -> tuple[jax.Array, ...]:
        heading = jnp.full(len(points), jnp.nan).at[-1].set(at_rest)
        start = jnp.array([0.0, 0.0, 1.0]) * each.heading
        taken = way_taken(Way(points, heading), start, each.car, _road(each))
        end = rolled(each.velocity, start, taken, jnp.ones(1))[0]
        # the way that the true velocity would have made, against the true one
        longer = jnp.hypot(end[0], end[1]) / jnp.hypot(*points[-1])
        return jnp.log(longer) / 2, taken.course, end[2] - at_rest

    return jax.vmap(one)(them, points, heading)


def _road(each: Crashes) -> Ground:
    return Ground(each.friction[None], None, Zone(jnp.zeros((0, 2)), jnp.zeros((0, 2))))


def seen(pose: np.ndarray, end: np.ndarray, count: int) -> np.ndarray:
    """So many points evenly along each way, and its end."""
    ways = np.concatenate([pose[:, :, :2], end[:, None, :2]], axis=1)
    far = np.cumsum(np.hypot(*np.moveaxis(np.diff(ways, axis=1), 2, 0)), axis=1)
    far = np.pad(far, ((0, 0), (1, 0)))
    shares = np.arange(1, count + 1) / (count + 1)
    found = [
        [[np.interp(s * d[-1], d, way[:, i]) for i in (0, 1)] for s in shares] + [way[-1].tolist()]
        for way, d in zip(ways, far, strict=True)
    ]
    return np.array(found)


def stated(them: Crashes, points: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """Standard deviations that the model states for each run-out, shape (3, run-outs)."""
    wheels = them.car.wheels
    assert wheels is not None, "some roll"
    front = them.car.rear_axle / (them.car.front_axle + them.car.rear_axle) / 2
    loads = np.stack([front, front, 0.5 - front, 0.5 - front], axis=1)
    free = 1 - np.sum(loads * wheels.drag, axis=1)
    x, y = np.moveaxis(np.diff(points, axis=1, prepend=0.0), 2, 0)
    legs = np.hypot(x, y)
    of_each = zip(
        free,
        np.asarray(wheels.steer)[:, 0],
        legs[:, 0] / legs.sum(axis=1),
        heading - them.heading,
        strict=True,
    )
    return np.array([spreads(*each) for each in of_each]).T


def main(count: int = 200) -> None:
    """Print the table."""
    print("| locked | front wheels | seen on the way | ln speed | course, rad | rotation, rad |")
    print("| --- " * 6 + "|")
    for i, (name, locked) in enumerate(PATTERNS.items()):
        for steered in (False, True):
            them = crashes(np.random.default_rng([i, steered]), locked, steered, count)
            pose, end = map(np.asarray, followed(them))
            for number in SEEN:
                points = seen(pose, end, number)
                off = np.stack(missed(them, points, end[:, 2]))
                within = np.mean(np.abs(off) < NINETY * stated(them, points, end[:, 2]), axis=1)
                cells = (
                    f"{mean:+.2f} ± {sd:.2f} ({share:.0%})"
                    for mean, sd, share in zip(off.mean(1), off.std(1), within, strict=True)
                )
                how = "steered" if steered else "straight"
                print(f"| {name} | {how} | {number} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
