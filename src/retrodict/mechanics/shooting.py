"""Shooting: post-impact velocities that bring a vehicle from its impact pose to its rest pose.

A rest heading does not determine the number of whole turns, so there is one problem for each number.
Each is solved by Newton's method from several starts; all starts, turns and cells of a grid of
frictions run in one batched program.

Newton's method is written here and not taken from a library: with three unknowns and a fixed number of
iterations it needs twenty lines, and the run-out and its Jacobian come from one pass.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from retrodict.constants import GRAVITY
from retrodict.mechanics.motion import Car, Ground
from retrodict.mechanics.runout import rest
from retrodict.mechanics.tyre import Wheels

TURNS = tuple(range(-3, 4))
TOLERANCE = 1e-6  # m, and rad: of the rest pose

_ROUNDS = 16
# Problems at once. More would leave the processor's cache, and a fixed number needs one program,
# which takes longer to compile than to run, for grids of all sizes.
_BATCH = 7
_STEPS = 96  # of the run-outs
_SCREEN_STEPS = 24  # of the run-outs that choose the starts
_LEAST = 0.02  # m: shortest distance that the starts are made for
_SAME = 1e-3  # of the speed (and 1 m/s): closer velocities are one solution

# What sliding friction brings to rest after a time T went c d / T at first, d being the way: c is 2
# if it slows down evenly. Friction shared with a fast spin holds back less, at first or at last.
# So T, c for the way and for the turn, and the angle from the chord to the first direction span the
# starts; the best of each T goes to Newton.
_TIMES = np.linspace(0.0, 1.0, 6)  # from the shortest to the longest, in the logarithm
_WAYS = np.array([1.4, 1.8, 2.2])
_SPINS = np.array([1.2, 1.6, 2.0, 2.6])
_ANGLES = np.array([-0.5, -0.2, 0.0, 0.2, 0.5])  # rad


class Departures(NamedTuple):
    """Velocities after the impact that end at a rest pose, for each cell of a grid.

    Solutions come first, those with the least rotation before others; then, for every number of
    turns without a solution, the velocity with the smallest miss. Cells with fewer rows than others
    are filled up with rows of nan.

    Args:
        velocity: Vx, Vy, Omega, m/s and rad/s, shape (*grid, rows, 3).
        miss: distance and angle by which the run-out misses, m and rad, shape (*grid, rows, 2).
        converged: whether both are within the tolerance, shape (*grid, rows).
        turns: whole turns beyond the shortest rotation between the headings, shape (*grid, rows).
        rotation: rotation from impact to rest, rad, shape (*grid, rows).
    """

    velocity: Float[np.ndarray, "*grid rows 3"]
    miss: Float[np.ndarray, "*grid rows 2"]
    converged: Bool[np.ndarray, "*grid rows"]
    turns: Int[np.ndarray, "*grid rows"]
    rotation: Float[np.ndarray, "*grid rows"]


def departures(
    start: Float[Array | np.ndarray, "*#grid 3"] | Sequence[float],
    rest_pose: Float[Array | np.ndarray, "*#grid 3"] | Sequence[float],
    car: Car,
    ground: Ground,
    turns: Iterable[int] | None = TURNS,
    steps: int = _STEPS,
    tolerance: float = TOLERANCE,
) -> Departures:
    """All velocities after the impact that bring a skidding vehicle to its rest pose.

    Poses, the car's numbers and the ground's friction may have leading axes, which broadcast to a
    grid of problems; where the surfaces lie and how they slope is the same for all.

    Args:
        start: x, y, heading at the impact, m and rad, shape (*grid, 3).
        rest_pose: x, y, heading at rest, m and rad, shape (*grid, 3).
        car: inertia, axles and track, each of shape (*grid,) or a number; of its wheels (*grid, 4).
        ground: friction of the surfaces, shape (*grid, surfaces), where they lie, and their slope.
        turns: whole turns to try beyond the shortest rotation from one heading to the other, which
            lies in [-pi, pi), positive counter-clockwise; None where the total rotation is known:
            it is then the difference of the headings as they are.
        steps: number of integration steps of each run-out.
        tolerance: largest miss of a solution's rest pose, m and rad.

    Returns:
        The solutions. For each number of turns, what Newton's method found from six starts; it
        proves neither that there are no others, nor that there are none where it found none.

    Source:
        The run-out problem behind SAE 770014, Tables 1 and 2.
    """
    poses = [np.asarray(start, float), np.asarray(rest_pose, float)]
    numbers = [np.asarray(v, float)[..., None] for v in car[:4]]
    wheels = [] if car.wheels is None else [np.asarray(v, float) for v in car.wheels]
    grips = [np.atleast_1d(np.asarray(v, float)) for v in ground[:2] if v is not None]
    arrays = [*poses, *numbers, *wheels, *grips]
    grid = np.broadcast_shapes(*(a.shape[:-1] for a in arrays))
    flat = [np.broadcast_to(a, (*grid, a.shape[-1])).reshape(-1, a.shape[-1]) for a in arrays]
    here, there = flat[:2]
    k2, front, rear, track = (jnp.asarray(a[:, 0]) for a in flat[2:6])
    turning = Wheels(*(jnp.asarray(a) for a in flat[6:8])) if wheels else None
    cars = Car(k2, front, rear, track, turning)

    shortest, whole = _turns(there[:, 2] - here[:, 2], turns)
    rotations = shortest[:, None] + 2 * np.pi * whole
    # one row a problem, filled up to whole batches
    problems = len(here) * whole.shape[1]
    rows = np.minimum(np.arange(-(-problems // _BATCH) * _BATCH), problems - 1)
    cell = rows // whole.shape[1]
    friction, dependence, *_ = *flat[6 + len(wheels) :], None
    inputs = (
        here[cell],
        (there - here)[cell, :2],
        rotations.reshape(-1)[rows],
        jax.tree.map(lambda a: a[cell], cars),
        (friction[cell], None if dependence is None else dependence[cell]),
    )
    batches = [
        _solve(*jax.tree.map(lambda a: a[i : i + _BATCH], inputs), ground[2:], tolerance, steps)  # noqa: B023
        for i in range(0, len(rows), _BATCH)
    ]
    velocity, miss = (
        np.concatenate(a)[:problems].reshape(*whole.shape, len(_TIMES), -1)
        for a in zip(*batches, strict=True)
    )
    cells = [
        _rows(*cell, tolerance)
        for cell in zip(velocity, miss, whole, rotations, np.sqrt(cars.k2), strict=True)
    ]
    most = max(len(cell.turns) for cell in cells)
    filled = [_filled(cell, most) for cell in cells]
    stacked = (np.stack(column) for column in zip(*filled, strict=True))
    return Departures(*(a.reshape(*grid, *a.shape[1:]) for a in stacked))


def _turns(
    rotation: Float[np.ndarray, " cells"], turns: Iterable[int] | None
) -> tuple[Float[np.ndarray, " cells"], Int[np.ndarray, "cells turns"]]:
    """The shortest rotation between two headings, and the whole turns to try, as of `departures`."""
    shortest = (rotation + np.pi) % (2 * np.pi) - np.pi
    if turns is None:
        return shortest, np.rint((rotation - shortest) / (2 * np.pi)).astype(int)[:, None]
    return shortest, np.tile(np.array(list(turns), int), (len(rotation), 1))


@partial(jax.jit, static_argnames="steps")
def _solve(
    start: Float[Array, "problems 3"],
    offset: Float[Array, "problems 2"],
    rotation: Float[Array, " problems"],
    car: Car,
    frictions: tuple[Float[Array, "problems surfaces"], Float[Array, "problems surfaces"] | None],
    where: tuple[Any, ...],
    tolerance: float,
    steps: int,
) -> tuple[Float[Array, "problems starts 3"], Float[Array, "problems starts 2"]]:
    """Result of Newton's method from every start, and its miss."""

    def solve(
        start: Array,
        offset: Array,
        rotation: Array,
        car: Car,
        frictions: tuple[Array, Array | None],
    ) -> tuple[Array, Array]:
        ground = Ground(*frictions, *where)
        return _from_starts(start, offset, rotation, car, ground, tolerance, steps)

    return jax.vmap(solve)(start, offset, rotation, car, frictions)


def _from_starts(
    start: Float[Array, "3"],
    offset: Float[Array, "2"],
    rotation: Float[Array, ""],
    car: Car,
    ground: Ground,
    tolerance: float,
    steps: int,
) -> tuple[Float[Array, "starts 3"], Float[Array, "starts 2"]]:
    """Velocities that Newton's method finds for one problem from every start, and their misses."""
    # speeds (Vx, Vy, k Omega) and distances (x, y, k heading): all in m/s and m
    k = jnp.sqrt(car.k2)
    weight = jnp.stack([jnp.ones_like(k), jnp.ones_like(k), k])
    target = (start + jnp.append(offset, rotation)) * weight

    def misses(u: Float[Array, "3"], steps: int) -> Float[Array, "3"]:
        return rest(start, u / weight, car, ground, steps) * weight - target

    def value_and_jacobian(u: Array) -> tuple[Array, Array]:
        def twice(u: Array) -> tuple[Array, Array]:
            r = misses(u, steps)
            return r, r

        jacobian, r = jax.jacfwd(twice, has_aux=True)(u)
        return r, jacobian

    guesses = _guesses(offset, rotation, car, ground) * weight
    screened = jax.vmap(jax.vmap(partial(misses, steps=_SCREEN_STEPS)))(guesses)
    best = jnp.nan_to_num((screened**2).sum(axis=-1), nan=jnp.inf).argmin(axis=1)
    u = jnp.take_along_axis(guesses, best[:, None, None], axis=1)[:, 0]

    def newton(u: Float[Array, "3"]) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
        u, r = _newton(value_and_jacobian, u)
        return u / weight, r / weight

    velocity, r = jax.vmap(newton)(u)
    miss = jnp.stack([jnp.hypot(r[:, 0], r[:, 1]), jnp.abs(r[:, 2])], axis=1)
    # a vehicle already at its rest pose has no velocity
    standing = jnp.stack([jnp.hypot(*offset), jnp.abs(rotation)])
    stands = (standing <= tolerance).all()
    return jnp.where(stands, 0.0, velocity), jnp.where(stands, standing, miss)


def _newton(
    value_and_jacobian: Callable[[Array], tuple[Array, Array]], start: Float[Array, "3"]
) -> tuple[Float[Array, "3"], Float[Array, "3"]]:
    """The point that a damped Newton's method finds from a start, and its residuals."""
    Best = tuple[Float[Array, "3"], Float[Array, "3"], Float[Array, "3 3"]]
    State = tuple[Best, Float[Array, "3"], Float[Array, ""]]

    def improve(state: State, _: None) -> tuple[State, None]:
        best, trial, damping = state
        r, J = value_and_jacobian(trial)
        better = (r**2).sum() < (best[1] ** 2).sum()  # never where r is nan
        u, r, J = (jnp.where(better, a, b) for a, b in zip((trial, r, J), best, strict=True))
        damping = jnp.where(better, damping / 10, damping * 5).clip(1e-14, 1e4)
        square = J.T @ J
        ridge = damping * jnp.trace(square) / 3 + 1e-30
        step = -jnp.linalg.solve(square + ridge * jnp.eye(3), J.T @ r)
        longest = 0.5 * jnp.linalg.norm(u) + 0.1
        step = step * jnp.minimum(1.0, longest / (jnp.linalg.norm(step) + 1e-30))
        return ((u, r, J), u + jnp.nan_to_num(step), damping), None

    nothing = (start, jnp.full(3, jnp.inf), jnp.zeros((3, 3)))
    state = (nothing, start, jnp.asarray(1e-2))
    ((u, r, _), _, _), _ = jax.lax.scan(improve, state, None, length=_ROUNDS)
    return u, r


def _guesses(
    offset: Float[Array, "2"], rotation: Float[Array, ""], car: Car, ground: Ground
) -> Float[Array, "times guesses 3"]:
    """Initial velocities, one row for each time to rest."""
    far = jnp.maximum(jnp.hypot(*offset), _LEAST)
    chord = jnp.where((offset**2).sum() > 0, jnp.arctan2(offset[1], offset[0] + 1e-300), 0.0)
    wheels = jnp.hypot((car.front_axle + car.rear_axle) / 2, car.track / 2)
    to_stop = jnp.stack([2 * far, 2 * jnp.abs(rotation) * car.k2 / wheels]) / GRAVITY  # T² f
    grip = jnp.asarray(ground.coefficients)
    shortest = jnp.sqrt(to_stop.max() / grip.max()) * 0.9
    drag = 1.0 if car.wheels is None else car.wheels.drag.mean().clip(0.02, 1.0)
    longest = jnp.sqrt(to_stop.sum() / (drag * grip.min())) * 1.3
    T = shortest * (longest / shortest) ** _TIMES
    T, c, spin, angle = jnp.broadcast_arrays(
        T[:, None, None, None],
        _WAYS[:, None, None],
        _SPINS[:, None],
        _ANGLES,
    )
    V = c * far / T
    columns = [V * jnp.cos(chord + angle), V * jnp.sin(chord + angle), spin * rotation / T]
    return jnp.stack(columns, axis=-1).reshape(len(_TIMES), -1, 3)


def _rows(
    velocity: Float[np.ndarray, "turns starts 3"],
    miss: Float[np.ndarray, "turns starts 2"],
    turns: Int[np.ndarray, " turns"],
    rotation: Float[np.ndarray, " turns"],
    k: float,
    tolerance: float,
) -> Departures:
    """Distinct solutions, and a smallest miss for turns without one, in the order of `Departures`."""
    rows = []
    for V, off, whole, angle in zip(velocity, miss, turns, rotation, strict=True):
        size = np.nan_to_num(np.hypot(off[:, 0], k * off[:, 1]), nan=np.inf)
        speeds = V * [1, 1, k]
        kept: list[int] = []
        for i in np.argsort(size):
            there = bool((off[i] <= tolerance).all())
            apart = np.linalg.norm(speeds[kept] - speeds[i], axis=1)
            if not kept or (there and (apart > _SAME * (1 + np.linalg.norm(speeds[i]))).all()):
                kept.append(int(i))
                rows.append((not there, abs(angle), size[i], V[i], off[i], whole, angle))
    rows.sort(key=lambda row: row[:3])
    missed, _, _, V, off, whole, angle = zip(*rows, strict=True)
    return Departures(
        np.array(V), np.array(off), ~np.array(missed), np.array(whole, int), np.array(angle)
    )


def _filled(cell: Departures, rows: int) -> Departures:
    def fill(a: np.ndarray) -> np.ndarray:
        empty = np.nan if a.dtype == float else 0
        return np.concatenate([a, np.full((rows - len(a), *a.shape[1:]), empty, a.dtype)])

    return Departures(*map(fill, cell))
