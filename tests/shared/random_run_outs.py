"""Run-outs at random over wide ranges: W only falls, time goes on, and SciPy ends where they end."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import jax
import numpy as np

from retrodict.mechanics import Car, Ground, Wheels, Zone, rest, run_out, step_error
from tests.shared import reference
from tests.shared.reference import Scene

WITHIN = 1e-3  # m, and rad: of the rest pose, against the reference

Array = np.ndarray


class Found(NamedTuple):
    """What is wrong with each run-out.

    Args:
        rest: x, y, heading.
        refused: whether it says that it could not be followed: not a number.
        faults: by law, whether broken.
    """

    rest: Array
    refused: Array
    faults: dict[str, Array]


def draw(number: int, seed: int = 0, rolling: bool = False) -> list[Scene]:
    """Run-outs as wild as a scene file may ask for.

    Args:
        number: of them.
        seed: of the random numbers.
        rolling: whether wheels roll, with a drag from 0.05 and steered by up to 0.5 rad.

    Returns:
        Friction from 0.05 to 1.5, falling with speed in some; up to 50 m/s and 20 rad/s, each at
        times zero or tiny; cars from small to lorry; an edge, at times through the start.
    """
    rng = np.random.default_rng([seed, int(rolling)])
    return [_one(rng, rolling) for _ in range(number)]


def _one(rng: np.random.Generator, rolling: bool) -> Scene:
    front, rear, track = rng.uniform(0.6, 3.5), rng.uniform(0.6, 3.5), rng.uniform(1.0, 2.5)
    course, across, heading = rng.uniform(-np.pi, np.pi, 3)
    speed = rng.choice([rng.uniform(0, 50), 0.0, 10 ** rng.uniform(-6, 0)], p=[0.9, 0.05, 0.05])
    spin = rng.choice([rng.uniform(-20, 20), 0.0, 10 ** rng.uniform(-6, 0)], p=[0.8, 0.15, 0.05])
    inward = np.array([np.cos(across), np.sin(across)])
    return Scene(
        pose=np.array([0.0, 0.0, heading]),
        velocity=np.array([speed * np.cos(course), speed * np.sin(course), spin]),
        k2=front * rear * rng.uniform(0.5, 1.5),
        front_axle=front,
        rear_axle=rear,
        track=track,
        coefficients=np.exp(rng.uniform(np.log(0.05), np.log(1.5), 2)),
        speed_dependence=rng.uniform(0, 0.02, 2) * (rng.random() < 0.5),
        point=rng.uniform(-2, 30) * inward,
        inward=inward,
        drag=np.where(rng.random(4) < 0.25, 1.0, rng.uniform(0.05, 1, 4)) if rolling else None,
        steer=np.array([1.0, 1.0, 0.0, 0.0]) * rng.uniform(-0.5, 0.5) if rolling else None,
    )


def _placed(scene: tuple) -> tuple:
    """Start, velocity, car and ground of a row of `_columns`."""
    pose, velocity, *numbers, friction, dependence, point, inward, turning = scene
    car = Car(*numbers, None if turning is None else Wheels(*turning))
    return pose, velocity, car, Ground(friction, dependence, Zone(point[None], inward[None]))


@jax.jit
def _run_all(batch: tuple) -> tuple:
    def one(scene: tuple) -> tuple:
        path = run_out(*_placed(scene))
        return path.pose[-1], path.velocity, path.time

    return jax.lax.map(one, batch)


@partial(jax.jit, static_argnums=1)
def _in_steps(batch: tuple, steps: int) -> tuple:
    def one(scene: tuple) -> tuple:
        at = _placed(scene)
        return rest(*at, steps=steps), step_error(*at, steps)

    return jax.vmap(one)(batch)


def _columns(scenes: Sequence[Scene]) -> tuple:
    turning = None
    if scenes[0].drag is not None:
        turning = tuple(np.array([getattr(s, name) for s in scenes]) for name in ("drag", "steer"))
    return (*(np.array(column) for column in list(zip(*scenes, strict=True))[:10]), turning)


def examine(scenes: Sequence[Scene]) -> Found:
    """Follow run-outs and hold each against the laws.

    Args:
        scenes: as `draw` makes them, all rolling or none.

    Returns:
        What was found.
    """
    columns = _columns(scenes)
    ends, velocity, time = map(np.asarray, _run_all(columns))
    W2 = velocity[..., 0] ** 2 + velocity[..., 1] ** 2 + columns[2][:, None] * velocity[..., 2] ** 2
    refused = ~np.isfinite(ends).all(1)
    return Found(
        ends,
        refused,
        {
            "energy falls": (np.diff(W2, axis=1) > 1e-9 * W2[:, :1]).any(1),
            "time goes on": (np.diff(time, axis=1) < 0).any(1),
            "comes to rest": (W2[:, -1] != 0) & ~refused,
        },
    )


def in_fixed_steps(scenes: Sequence[Scene], found: Found, steps: int) -> tuple[Array, Array]:
    """What fixed steps miss by, and what `step_error` says of it, m, of those not refused.

    Args:
        scenes: of which the adaptive rest pose is taken for true.
        found: of these.
        steps: of each.
    """
    ends, errors = map(np.asarray, _in_steps(_columns(scenes), steps))
    off = np.abs(ends - found.rest)
    return tuple(np.hypot(*e[~found.refused, :2].T) for e in (off, errors))  # type: ignore[return-value]


def differences(scenes: Sequence[Scene], found: Found) -> Array:
    """Largest difference of rest poses from the reference's, m and rad; zero where refused.

    Args:
        scenes: of which the reference takes a good part of a second each.
        found: of these.
    """
    moving = [np.hypot(*s.velocity[:2]) + abs(s.velocity[2]) > 1e-3 for s in scenes]
    runs = iter(reference.runs([s for s, moves in zip(scenes, moving, strict=True) if moves]))
    # what hardly moves stays, and SciPy does not start
    ends = [next(runs).rest if m else s.pose for s, m in zip(scenes, moving, strict=True)]
    return np.where(found.refused, 0.0, np.abs(found.rest - np.array(ends)).max(1))
