"""Inverse regression: velocities after the impact from rest poses and inputs.

`shoot` finds the velocities by Newton's method from many starts at once; `fit` then fits the quadratics
of the rest-pose transform by least squares to run-outs. Nothing here needs to be exact: it only shapes
coordinates.

A component of a rest pose that was not measured is replaced by its velocity (for x the velocity along
x, for the heading the yaw rate), counted from that of a likely crash.
"""

from __future__ import annotations

import numpy as np

from retrodict.inference.density.compiled import Programs, programs_for
from retrodict.inference.density.kernels import BATCH, INPUTS, REACHED
from retrodict.inference.errors import Unanswerable
from retrodict.inference.fitting.quadratic import as_quadratic, least_squares, terms
from retrodict.inference.transforms import layout
from retrodict.inference.transforms.parameters import Regressions, ResponseSurface
from retrodict.models.arrays import Data, Structure, in_steps, steps_of
from retrodict.scene.records import VEHICLES

_ROUNDS = 4
# standard deviations of a rest pose: a run-out that misses by more does not reach it
_REACHES = 1.0
_STEP = 1e-4  # step of velocities in difference quotients, m/s and rad/s
_UNIT = 1.0  # unit of velocities that replace unmeasured components, m/s and rad/s
_NEAR = 6.0  # distance from the measured rest over which run-outs lose weight, standard deviations
_TURNING = np.array([1.0, 1.0, 1.4])  # weights of V_x, V_y and the yaw rate (m) in a step's length
_ABOUT = 0.03  # spread of starts about a likely crash, share of the speed


def shoot(programs: Programs, data: Data, likely: np.ndarray) -> np.ndarray:
    """Velocities after the impact that end at the measured rest poses, near those of a likely crash.

    Args:
        programs: compiled programs of the scene's structure.
        data: numbers of the scene; inputs are at their measured values.
        likely: velocities after the impact of a crash that nearly ends there, in the order of the
            returned ones; velocities of unmeasured components count from them.

    Returns:
        (V_ax, V_ay, Omega_a, V_bx, V_by, Omega_b), m/s and rad/s; without the yaw rates where the rung
        has none. The velocity of an unmeasured component is that of the likely crash. Vehicles whose
        run-out is inverted in closed form need not end at the measured rest pose.

    Raises:
        Unanswerable: no start came near the measured rest pose of a vehicle.
    """
    size = len(programs.structure.rests)
    xi = np.zeros((BATCH, len(programs.structure.uncertain)))
    target, sd = _target_poses(programs, data, likely)
    starts = BATCH // (size + 1)
    V = _about(likely.reshape(2, size), starts)
    V = np.where(_undetermined(programs), target, V)
    best = np.full((2,), np.inf)
    found = np.zeros((2, size))
    damping = np.ones((starts, 2, 1))
    previous, cost_before = V.copy(), np.full((starts, 2), np.inf)
    for _ in range(14):
        # run-outs of a start: with its velocities, and with each of them increased by _STEP
        nudged = np.repeat(V[:, None], size + 1, axis=1)
        for j in range(size):
            nudged[:, j + 1, :, j] += _STEP
        batch = np.resize(nudged.reshape(-1, 2 * size), (BATCH, 2 * size))
        ends = _reached(programs, data, batch, xi)[: starts * (size + 1)]
        ends = ends.reshape(starts, size + 1, 2, size)
        miss = (ends[:, 0] - target) / sd
        cost = np.nan_to_num(np.sum(miss**2, axis=-1), nan=np.inf)
        worse = ~(cost <= cost_before)
        for v in range(2):
            i = int(np.argmin(cost[:, v]))
            if cost[i, v] < best[v]:
                best[v], found[v] = cost[i, v], V[i, v]
        if np.all(best < 1e-6):
            break
        damping = np.where(worse[..., None], damping / 4, np.minimum(damping * 2, 1))
        step = _newton(V, miss, (ends[:, 1:] - ends[:, :1]) / (_STEP * sd))
        # a start that got worse goes back and tries a shorter step
        V_next = np.where(worse[..., None], (V + 3 * previous) / 4, V + damping * step)
        previous = np.where(worse[..., None], previous, V)
        cost_before = np.where(worse, cost_before, cost)
        V = V_next
    for vehicle, missed in zip(VEHICLES, np.sqrt(best), strict=True):
        if missed > _REACHES and vehicle not in programs.structure.inverted:
            raise Unanswerable(
                f"vehicle {vehicle.upper()}: no velocities after the impact bring it to its measured "
                f"rest (the nearest run-out misses by {missed:.1f} standard deviations); "
                "check its rest position, heading and rotation, and the friction"
            )
    return found.ravel()


def _newton(V: np.ndarray, miss: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Newton's steps to where nothing is missed, limited in length; shape (starts, 2, v).

    Args:
        V: velocities after the impact of each start, m/s and rad/s, shape (starts, 2, v).
        miss: misses of the rest poses, in standard deviations, shape (starts, 2, v).
        slopes: derivatives of the misses by each velocity, shape (starts, velocity, 2, v).
    """
    J = np.nan_to_num(np.moveaxis(slopes, 1, -1), posinf=0.0, neginf=0.0)
    ridge = J.swapaxes(-1, -2) @ J
    relative = 1e-9 * np.trace(ridge, axis1=-2, axis2=-1)[..., None, None]
    ridge += (relative + 1e-12) * np.eye(V.shape[-1])
    step = -np.linalg.solve(ridge, J.swapaxes(-1, -2) @ np.nan_to_num(miss)[..., None])[..., 0]
    weight = _TURNING[: V.shape[-1]]
    limit = 0.3 * np.linalg.norm(V * weight, axis=-1, keepdims=True) + 0.5
    length = np.linalg.norm(step * weight, axis=-1, keepdims=True)
    return step * np.minimum(1, limit / np.maximum(length, 1e-12))


def fit(
    programs: Programs, data: Data, separation: np.ndarray
) -> tuple[Regressions, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """The quadratic regressions about a solution of `shoot`.

    Args:
        programs: compiled programs of the scene's structure.
        data: numbers of the scene.
        separation: velocities after the impact that end at the measured rest poses, m/s and rad/s.

    Returns:
        The regressions for A and B; the error of each (A, B), which measures how curved the sampler's
        target remains: root of the median over run-outs of the mean square miss, in standard deviations
        of the rest pose; and the run-outs of the last round: velocities after the impact and deviates
        of the inputs.
    """
    structure = programs.structure
    n, size = layout.length_for_regressions(structure), len(structure.rests)
    sample = np.clip(1.3 * np.random.default_rng(0).standard_normal((BATCH, n)), -3.5, 3.5)
    xi = sample[:, 2 * size :]
    target, sd = _target_poses(programs, data, separation)
    mine = [slice(size * v, size * (v + 1)) for v in range(2)]
    scale = np.asarray(programs(INPUTS, data, xi)[3])
    shaping = [layout.shaping_inputs(structure, v) for v in "ab"]
    regressions = _linear(programs, data, separation)
    error = np.full(2, np.inf)
    for _ in range(_ROUNDS):
        V = np.concatenate(
            [
                scale[:, None] * _value(regressions[v], sample[:, mine[v]], xi[:, shaping[v]])
                for v in range(2)
            ],
            axis=1,
        )
        z = (_reached(programs, data, V, xi) - target) / sd
        for v in range(2):
            wanted, got, velocity = (a[:, mine[v]] for a in (sample, z.reshape(BATCH, -1), V))
            error[v] = np.sqrt(np.median(np.sum((got - wanted) ** 2, axis=1)) / size)
            A = terms(np.hstack([got, xi[:, shaping[v]]]))
            # run-outs that miss by far are weakly informative on the regression where the posterior lies
            weight = np.exp(-0.25 * (np.linalg.norm(got, axis=1) / _NEAR) ** 2)
            weight = np.where(np.isfinite(got).all(axis=1), weight, 0.0)
            if np.sum(weight > 0.1) > 1.2 * A.shape[1]:
                regressions[v] = least_squares(A, velocity / scale[:, None], weight)
    for_a, for_b = (
        as_quadratic(c, size + len(s)) for c, s in zip(regressions, shaping, strict=True)
    )
    return (for_a, for_b), error, (V, xi)


def responses(
    structure: Structure,
    data: Data,
    run_outs: tuple[np.ndarray, np.ndarray],
    predicted: dict[str, np.ndarray],
) -> tuple[ResponseSurface, ...]:
    """Response surfaces of the vehicles of `with_response_surface`, fitted to run-outs.

    Args:
        structure: static structure of the scene.
        data: numbers of the scene.
        run_outs: velocities after the impact, and deviates of the inputs, a row for each run-out.
        predicted: predictions of these run-outs for each item along the path to rest, by name.
    """
    vehicles = layout.with_response_surface(structure)
    return tuple(_response(structure, data, run_outs, predicted, v) for v in vehicles)


def _response(
    structure: Structure,
    data: Data,
    run_outs: tuple[np.ndarray, np.ndarray],
    predicted: dict[str, np.ndarray],
    v: str,
) -> ResponseSurface:
    size, i = len(structure.rests), VEHICLES.index(v)
    names = structure.on_way_of(v)
    velocity, shape = run_outs[0].reshape(-1, 2, size)[:, i], run_outs[1]
    items = np.stack([predicted[name] for name in names], axis=1)
    followed = np.isfinite(np.concatenate([velocity, items], axis=1)).all(axis=1)
    if not followed.any():
        raise Unanswerable(f"vehicle {v.upper()}: none of its likely run-outs can be followed")
    velocity, items = velocity[followed], items[followed]
    shape = shape[followed][:, layout.shaping_inputs(structure, v)]
    centre, unit = velocity.mean(axis=0), velocity.std(axis=0)
    A = terms(np.hstack([(velocity - centre) / unit, shape]))
    value, sd = np.array([data.evidence[name] for name in names]).T
    off = np.linalg.norm((items - value) / sd, axis=1)
    # run-outs far from the measurements are weakly informative, but enough of them must have weight
    reach = max(_NEAR, np.sort(off)[min(2 * A.shape[1], len(off) - 1)])
    surface = least_squares(A, items, np.exp(-0.25 * (off / reach) ** 2))
    return ResponseSurface(centre, unit, as_quadratic(surface, size + shape.shape[1]))


def unresolved(programs: Programs, data: Data, run_outs: tuple[np.ndarray, np.ndarray]) -> float:
    """Change of rest poses by finer integration steps, in standard deviations of their measurement.

    Args:
        programs: compiled programs of the scene's structure.
        data: numbers of the scene.
        run_outs: velocities after the impact and deviates of the inputs, as `fit` returns them.

    Returns:
        The 90 % quantile of the change by four times as many steps, over all measured components of the
        run-outs that can be followed.
    """
    s = programs.structure
    if not s.integrated:
        return 0.0
    finer, finely = in_steps(s, data, 4 * steps_of(s, data))
    V, xi = run_outs
    rests = [
        np.asarray(p(REACHED, d, V, xi))
        for p, d in ((programs, data), (programs_for(finer), finely))
    ]
    sd = np.array([data.evidence.get(name, (0.0, np.inf))[1] for name in s.rest_components])
    moved = (rests[1] - rests[0]).reshape(len(rests[0]), -1) / sd
    return float(np.nanquantile(np.abs(moved[:, np.isfinite(sd)]), 0.9))


def _value(coefficients: np.ndarray, z: np.ndarray, shape: np.ndarray) -> np.ndarray:
    return terms(np.hstack([z, shape])) @ coefficients


def _linear(programs: Programs, data: Data, separation: np.ndarray) -> list[np.ndarray]:
    """First regressions: linear in the rest pose and the inputs, by difference quotients."""
    structure = programs.structure
    p, size = len(structure.uncertain), len(structure.rests)
    _, sd = _target_poses(programs, data, separation)
    V, xi = np.tile(separation, (BATCH, 1)), np.zeros((BATCH, p))
    for j in range(size):
        V[1 + j, [j, size + j]] += _STEP
    h = 0.01
    for j in range(p):
        xi[1 + size + j, j] = h
    ends = _reached(programs, data, V, xi)
    regressions = []
    for v, vehicle in enumerate("ab"):
        shape = layout.shaping_inputs(structure, vehicle)
        own = separation[size * v : size * (v + 1)]
        J_V = ((ends[1 : 1 + size, v] - ends[0, v]) / _STEP).T
        J_xi = ((ends[1 + size : 1 + size + p, v] - ends[0, v]) / h).T[:, shape]
        back = np.linalg.pinv(J_V)
        k = size + len(shape)
        regression = np.zeros((1 + k + k * (k + 1) // 2, size))
        regression[0] = own
        regression[1 : 1 + size] = (back * sd[v]).T
        regression[1 + size : 1 + k] = -(back @ J_xi).T
        # the friction's square root stands outside the regression: take its slope out again
        name = f"friction_{structure.surfaces[0]}"
        if name in structure.names:
            i = structure.names.index(name)
            slope = 0.5 * float(data.inputs[name][1])
            regression[1 + size + shape.index(i)] -= slope * own
        regressions.append(regression)
    return regressions


def _undetermined(programs: Programs) -> np.ndarray:
    """Mask of the unmeasured components of the rest poses, a row each for A and B."""
    structure = programs.structure
    return np.array([name in structure.unmeasured for name in structure.rest_components]).reshape(
        2, -1
    )


def _about(likely: np.ndarray, starts: int) -> np.ndarray:
    """Starts about likely velocities, which are the first start; shape (starts, 2, v)."""
    off = np.random.default_rng(0).standard_normal((starts, *likely.shape))
    off[0] = 0
    return likely + _ABOUT * np.linalg.norm(likely, axis=1)[:, None] * off


def _target_poses(
    programs: Programs, data: Data, separation: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Target of `_reached` and its standard deviations, a row each for A and B."""
    structure = programs.structure
    pairs = [
        np.array((velocity, _UNIT) if name in structure.unmeasured else data.evidence[name])
        for name, velocity in zip(structure.rest_components, separation, strict=True)
    ]
    value, sd = np.stack(pairs, axis=1).reshape(2, 2, -1)
    return value, sd


def _reached(programs: Programs, data: Data, V: np.ndarray, xi: np.ndarray) -> np.ndarray:
    """Rest poses of run-outs, with the velocity in the place of each unmeasured component."""
    ends = np.asarray(programs(REACHED, data, V, xi))
    return np.where(_undetermined(programs), V.reshape(ends.shape), ends)
