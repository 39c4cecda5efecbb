"""Shooting for a rest pose: round trips, several turns, and Tables 1 and 2 of SAE 770014."""

import importlib.util
import math
from functools import partial
from pathlib import Path
from types import ModuleType

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from retrodict import load_scene, mechanics
from retrodict.mechanics import Car, Departures, Ground, Wheels, Zone

CAR = Car(k2=1.8, front_axle=1.3, rear_axle=1.5, track=1.5)
EDGE = Zone(jnp.array([[3.0, 0.0]]), jnp.array([[1.0, 0.0]]))
GROUND = Ground(jnp.array([0.6, 0.4]), jnp.zeros(2), EDGE)
SCENES = 56
STEPS = 48  # half the default: here both ways must agree with each other, not with nature
START = np.array([0.0, 0.0, 0.4])

departures = partial(mechanics.departures, steps=STEPS)
rest = partial(mechanics.rest, steps=STEPS)
_rests = jax.jit(
    jax.vmap(
        lambda pose, V, car, f, c: rest(pose, V, car, Ground(f, c, EDGE)),
    )
)


def end(V: np.ndarray) -> np.ndarray:
    """Where CAR comes to rest from START."""
    cars = Car(*(jnp.full(len(V), v) for v in CAR[:4]))
    f, c = (jnp.tile(a, (len(V), 1)) for a in GROUND[:2])
    return np.array(_rests(jnp.tile(START, (len(V), 1)), jnp.array(V), cars, f, c))


@pytest.fixture(scope="module")
def round_trips() -> tuple[np.ndarray, np.ndarray, Car, Departures]:
    """Random velocities, rotations and cars, and what their rest poses lead back to."""
    rng = np.random.default_rng(0)
    n = SCENES
    car = Car(*(rng.uniform(*r, n) for r in ((1.3, 2.3), (1.1, 1.5), (1.1, 1.5), (1.4, 1.6))))
    way, speed = rng.uniform(-math.pi, math.pi, n), rng.uniform(1, 16, n)
    spin = np.linspace(0, 10, n) * rng.choice([-1, 1], n)
    V = np.stack([speed * np.cos(way), speed * np.sin(way), spin], axis=1)
    start = np.stack([rng.uniform(-1, 4, n), rng.uniform(-1, 1, n), rng.uniform(-3, 3, n)], axis=1)
    ground = Ground(rng.uniform(0.3, 0.9, (n, 2)), rng.uniform(0, 0.01, (n, 2)), EDGE)
    there = np.array(_rests(start, V, car, *ground[:2]))
    rotation = there[:, 2] - start[:, 2]
    there[:, 2] = np.angle(np.exp(1j * there[:, 2]))  # a rest heading as it is measured
    return V, rotation, car, departures(start, there, car, ground)


@pytest.mark.slow
def test_the_velocity_is_among_the_solutions(
    round_trips: tuple[np.ndarray, np.ndarray, Car, Departures],
) -> None:
    """Scenes of 1 to 16 m/s, 0 to 10 rad/s and an edge on the way: all were found.

    Left out are those that turn more often than was tried. Nine tenths are required: Newton's
    method promises nothing, and another machine's rounding may send some starts elsewhere, but
    losing every tenth scene would call for better starts.
    """
    V, rotation, car, found = round_trips
    tried = np.abs(rotation) < 7 * math.pi
    weight = np.stack([np.ones(SCENES), np.ones(SCENES), np.sqrt(car.k2)], axis=1)[:, None]
    apart = np.linalg.norm((found.velocity - V[:, None]) * weight, axis=-1)
    speed = np.linalg.norm(V * weight[:, 0], axis=-1)
    hit = np.where(found.converged, apart, np.inf).min(axis=1) < 1e-3 * (1 + speed)
    print(f"found {hit[tried].sum()} of {tried.sum()}")
    assert tried.sum() >= 50
    assert hit[tried].mean() >= 0.9


def test_each_number_of_turns_has_its_spin(
    round_trips: tuple[np.ndarray, np.ndarray, Car, Departures],
) -> None:
    """All seven were found in every scene: more turns take more spin, and spin can be any."""
    found = round_trips[3]
    several = [len(set(t[c])) for t, c in zip(found.turns, found.converged, strict=True)]
    print(f"turns found: {np.bincount(several)}")
    assert np.mean(several) >= 0.9 * 7
    one = Departures(*(a[0] for a in found))
    order = np.argsort(one.rotation[one.converged])
    spins, rotations = one.velocity[one.converged, 2][order], one.rotation[one.converged][order]
    assert (np.diff(spins) > 0).all()
    assert np.diff(rotations) == pytest.approx(2 * math.pi)
    assert (np.diff(np.abs(one.rotation[one.converged])) >= 0).all()  # as documented


@pytest.mark.slow
def test_what_is_said_of_a_solution_is_so() -> None:
    V = np.array([[6.0, -2.0, 5.0]])
    there = end(V)[0]
    found = departures(START, there - [0, 0, 2 * math.pi], CAR, GROUND)
    again = end(found.velocity)
    turned = there + np.outer(found.rotation - (there[2] - START[2]), [0, 0, 1])
    assert found.converged.all()
    np.testing.assert_allclose(again, turned, atol=2e-6)
    np.testing.assert_allclose(found.miss.max(), 0, atol=1e-6)
    shortest = found.rotation - 2 * math.pi * found.turns
    np.testing.assert_allclose(shortest, shortest[0])
    assert -math.pi <= shortest[0] < math.pi


def test_known_rotation_and_a_grid_of_everything() -> None:
    """Leading axes of poses and of friction broadcast; headings count as they are."""
    V = np.array([[6.0, -2.0, 5.0], [3.0, 4.0, -7.0]])
    f = jnp.array([[0.6, 0.4], [0.6 * 1.21, 0.4 * 1.21], [0.3, 0.2]])
    found = departures(START, end(V)[:, None], CAR, GROUND._replace(coefficients=f), turns=None)
    assert found.velocity.shape[:2] == (2, 3)
    assert found.converged[..., 0].all()
    # all frictions times 1.21: all velocities times 1.1
    expected = V[:, None] * np.array([1, 1.1, math.sqrt(0.5)])[:, None]
    np.testing.assert_allclose(found.velocity[:, :, 0], expected, atol=1e-3)


def test_a_vehicle_at_its_rest_pose_has_not_moved_or_turned_in_place() -> None:
    found = departures(START, START + np.array([0, 0, 2 * math.pi]), CAR, GROUND)
    assert (found.converged[0], found.turns[0], found.rotation[0]) == (True, 0, pytest.approx(0))
    np.testing.assert_array_equal(found.velocity[0], 0)
    np.testing.assert_allclose(found.miss[0], 0, atol=1e-6)
    assert found.converged.all()
    turned = found.turns != 0
    assert (np.sign(found.velocity[turned, 2]) == np.sign(found.turns[turned])).all()
    known = departures(START, START, CAR, GROUND, turns=None)
    np.testing.assert_array_equal(known.velocity, np.zeros((1, 3)))


@pytest.mark.slow  # a program of its own
def test_a_polygon_is_crossed_as_its_edge_is() -> None:
    wide = np.array([[2.0, -900.0], [900.0, -900.0], [900.0, 900.0], [2.0, 900.0]])
    ground = Ground(*GROUND[:2], polygons=(wide,), insets=[1.0])
    there = end(np.array([[6.0, -2.0, 5.0]]))[0]
    by_edge, by_polygon = (departures(START, there, CAR, on, turns=None) for on in (GROUND, ground))
    assert by_edge.converged[0]
    np.testing.assert_allclose(by_polygon.velocity[0], by_edge.velocity[0], atol=1e-6)


def test_what_has_no_solution_is_said_to_have_none() -> None:
    """A tolerance that no arithmetic meets: the nearest run-out for each number of turns."""
    found = departures(START, [5.0, 1.0, 0.9], CAR, GROUND, turns=(0, 1), tolerance=0.0)
    assert not found.converged[found.miss.max(axis=1) > 0].any()
    assert sorted(set(found.turns)) == [0, 1]
    assert np.isfinite(found.velocity).all()


@pytest.mark.slow
def test_rolling_wheels() -> None:
    """Front wheels locked by the damage, rear ones dragging."""
    car = CAR._replace(wheels=Wheels(jnp.array([1.0, 1.0, 0.2, 0.2]), jnp.zeros(4)))
    V = jnp.array([7.0, 3.0, 3.0])
    there = rest(jnp.array(START), V, car, GROUND)
    found = departures(START, np.array(there), car, GROUND, turns=None)
    apart = np.abs(found.velocity - np.array(V)).max(axis=1)[found.converged]
    assert apart.min() < 1e-3


EXAMPLE = Path(__file__).parents[2] / "examples" / "brach-1977"


def script(name: str) -> ModuleType:
    """A script of the example, which is no package."""
    spec = importlib.util.spec_from_file_location(f"brach_{name}", EXAMPLE / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_rest_poses_of_sae_770014_are_those_recovered() -> None:
    """What scene.toml says is what recover.py computes, to the last digit written."""
    rest_of = load_scene(EXAMPLE / "scene.toml").rest
    written = [[rest_of[v].x.value, rest_of[v].y.value, rest_of[v].heading.value] for v in "ab"]
    apart = np.abs(script("recover").rest_poses() - np.array(written))
    assert (apart <= [0.00051, 0.00051, math.radians(0.0051)]).all()


def test_tables_1_and_2_of_sae_770014() -> None:
    """SAE 770014, Tables 1 and 2, whose numbers are rounded to 1 ft/s and 5 deg/s.

    All 18 cells come within 1 ft/s and 10 deg/s. Four had to: A's rest pose is made from its first
    cell, B's from the row of road 0.50. V_ay at road 0.50, berm 0.425 is printed as 9 and comes out
    as 8.07. It would be 7.95, had A's rest pose been made with Table 3's 2.4 m/s instead of the same
    number's other rounding, 8 ft/s; so this cell is no independent check either.
    """
    example = script("tables")
    found = example.tables()
    assert found.converged[..., 0].all()
    here = found.velocity[..., 0, :] / example.US
    apart = np.abs(here - example.PAPER)
    assert (apart <= [1, 1, 10]).all()
    # a pose gives back the velocity it was made from, to the rounding of Table 3's SI units
    assert (apart[example.MADE_FROM] <= [0.1, 0.1, 5]).all()
    # speed rises as the square root of the road's friction, and hardly with the berm's
    speed = np.hypot(here[..., 0], here[..., 1])
    root = np.sqrt(example.ROAD / example.ROAD[0])[:, None]
    np.testing.assert_allclose(speed / speed[:, :1], np.broadcast_to(root, (2, 3, 3)), rtol=0.03)
    np.testing.assert_allclose(speed / speed[..., :1], 1, rtol=0.02)
