"""The benchmark of rolling wheels: its truth agrees with the package, and its errors are honest."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks.rolling import runs, scenes, scores, truth
from retrodict.mechanics import (
    Bodies,
    Car,
    Coefficients,
    Ground,
    Wheels,
    Zone,
    contact_velocity,
    critical_mu,
    lever_arms,
    rest,
    separation,
)
from retrodict.mechanics.contact import towards_b
from retrodict.scene import parse_scene
from retrodict.scene.records import VEHICLES, WHEELS, Measured, RunOutError
from tests.shared.scenes import collision

DEGREE = np.pi / 180
_rest = jax.jit(partial(rest, steps=None))


def random_impact(rng: np.random.Generator) -> tuple[np.ndarray, truth.Impact]:
    mass, inertia = rng.uniform(900, 2400, 2), rng.uniform(1000, 5000, 2)
    bodies = truth.Impact(mass, inertia, rng.normal(0, 1.5, (2, 2)), rng.uniform(-1.5, 1.5))
    return rng.normal(size=6) * [10, 10, 1, 10, 10, 1], bodies


def as_retrodict(bodies: truth.Impact) -> Bodies:
    return Bodies(*bodies.mass, *bodies.inertia, *lever_arms(*bodies.lever), bodies.Gamma)


@pytest.mark.parametrize("seed", range(5))
def test_impact_agrees_with_the_package(seed: int) -> None:
    rng = np.random.default_rng(seed)
    before, bodies = random_impact(rng)
    e, mu, e_m = rng.uniform(0, 0.5), rng.uniform(-1, 1), rng.uniform(-1, 1)
    theirs = as_retrodict(bodies)
    found = truth.separation(before, bodies, e, mu, e_m)
    expected = separation(jnp.asarray(before), theirs, Coefficients(e, mu, e_m))
    assert_allclose(found, expected, atol=1e-9)
    limit = truth.critical_mu(before, bodies, e, e_m)
    assert_allclose(limit, critical_mu(jnp.asarray(before), theirs, e, e_m), rtol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_restitution_friction_and_sliding_are_what_they_are_defined_as(seed: int) -> None:
    """By contact velocities and impulses, whoever solved the equations."""
    rng = np.random.default_rng(seed)
    before, bodies = random_impact(rng)
    normal = np.array([np.cos(bodies.Gamma), np.sin(bodies.Gamma)])
    tangent = np.array([-normal[1], normal[0]])
    theirs = as_retrodict(bodies)
    after = truth.separation(before, bodies, 0.2, 0.4, 0.7)
    was, slip = (np.asarray(contact_velocity(jnp.asarray(v), theirs)) for v in (before, after))
    assert_allclose(slip @ normal, -0.2 * (was @ normal))
    assert_allclose(truth.closing_speed(before, bodies), towards_b(theirs) * (was @ normal))
    impulse = (after - before)[:2]
    assert_allclose(impulse @ tangent, 0.4 * (impulse @ normal))
    limit = truth.critical_mu(before, bodies, 0.2, 0.7)
    ended = jnp.asarray(truth.separation(before, bodies, 0.2, limit, 0.7))
    assert_allclose(contact_velocity(ended, theirs) @ tangent, 0, atol=1e-9)


@pytest.mark.parametrize("wheels", ["LLLL", "RLLL", "LLRR", "RRRR"])
def test_run_out_agrees_with_the_package(wheels: str) -> None:
    """To 5 mm and 0.05 deg, over up to 150 m: another right-hand side, solver and clock."""
    rng = np.random.default_rng(len(wheels.replace("L", "")))
    for _ in range(3):
        drag = np.where([w == "R" for w in wheels], rng.uniform(0.02, 0.2, 4), 1.0)
        car = truth.Car(
            rng.uniform(1.5, 2.2), rng.uniform(1.1, 1.4), rng.uniform(1.3, 1.6), 1.5, drag, 0.15
        )
        pose = np.array([1.0, -2.0, rng.uniform(-3, 3)])
        velocity = rng.normal(size=3) * [6, 6, 3]
        friction = rng.uniform(0.35, 0.85)
        poses = truth.path(pose, velocity, car, friction)
        turning = Wheels(jnp.asarray(drag), car.steer * jnp.array([1.0, 1.0, 0.0, 0.0]))
        no_zone = Zone(np.zeros((0, 2)), np.zeros((0, 2)))
        found = _rest(
            jnp.asarray(pose),
            jnp.asarray(velocity),
            Car(*car[:4], turning),
            Ground(jnp.array([friction]), None, no_zone),
        )
        assert_allclose(poses[-1, :2], found[:2], atol=5e-3)
        assert_allclose(poses[-1, 2], found[2], atol=0.05 * DEGREE)
        assert_allclose(poses[0], pose)


def test_every_pattern_of_wheels_comes_in_sixteen_scenes_and_none_is_all_locked() -> None:
    for vehicle in (0, 1):
        assert {pair[vehicle] for pair in scenes.PATTERNS[:16]} == set(range(16))
    assert len(set(scenes.PATTERNS)) == 255
    assert (0, 0) not in scenes.PATTERNS


@pytest.fixture(scope="module")
def crashes() -> list[scenes.Made]:
    return [scenes.crash(index) for index in range(16)]


@pytest.mark.slow
def test_scenes_are_read_as_they_were_meant(crashes: list[scenes.Made]) -> None:
    """What a scene takes as uncertain is what its truth varies, and all evidence is there."""
    of_vehicle = {"mass", "yaw_inertia", "impact_distance", "impact_angle", "heading", "grip"}
    of_vehicle |= {"steer", "speed", "direction", "omega", "drag_factor"}
    of_vehicle |= {*(f"drag_{wheel}" for wheel in WHEELS)}
    varied = {f"{name}_{v}" for name in of_vehicle for v in VEHICLES}
    varied |= {"impact_x", "impact_y", "Gamma", "friction_road"}
    for made in crashes:
        scene = parse_scene(made.text, "scene")
        assert {name for name, m in scene.inputs().items() if m.sd} <= varied
        kinds = ("rest_x", "rest_y", "rest_heading", "mark_1")
        assert set(scene.evidence()) == {f"{kind}_{v}" for kind in kinds for v in VEHICLES}
        for v, letters in zip(VEHICLES, made.plan.wheels, strict=True):
            wheels = scene.vehicles[v].wheels
            rolls = [wheels is not None and getattr(wheels, w).value < 1 for w in WHEELS]
            assert "".join("LR"[r] for r in rolls) == letters
            assert made.truth[f"way_{v}"] < scenes.WAY


def test_errors_are_as_large_as_the_scenes_say(crashes: list[scenes.Made]) -> None:
    """Deviations of what was measured from the truth are standard normal."""
    deviations = []
    for made in crashes:
        scene = parse_scene(made.text, "scene")
        measured = {k: m for k, m in scene.evidence().items() if k.startswith("rest")}
        measured |= {k: m for k, m in scene.inputs().items() if m.law == "normal" and m.sd}
        deviations += [(m.value - made.truth[k]) / m.sd for k, m in measured.items()]
    assert len(deviations) > 200
    assert abs(np.mean(deviations)) < 0.15
    assert 0.85 < np.std(deviations) < 1.15


@pytest.mark.parametrize(
    ("measured", "mean", "median"),
    [
        (Measured(2.0, 0.3), 2.0, 2.0),
        (Measured(2.0, 0.6, "lognormal"), 2.0, 2.0 / np.sqrt(1.09)),
        (Measured(0.3, 0.1, "logitnormal"), 0.31, 0.3),  # the mean as docs/scene-file.md has it
    ],
)
def test_truth_is_drawn_by_the_law_that_the_scene_states(
    measured: Measured, mean: float, median: float
) -> None:
    rng = np.random.default_rng(0)
    drawn = [scenes.draw(measured, rng) for _ in range(20_000)]
    assert_allclose(np.mean(drawn), mean, rtol=0.02)
    assert_allclose(np.median(drawn), median, rtol=0.02)
    assert_allclose(np.std(drawn), measured.sd, rtol=0.03)


@pytest.mark.parametrize("law", ["normal", "lognormal", "logitnormal"])
def test_a_true_value_determines_the_normal_number_that_it_was_drawn_by(law: str) -> None:
    measured = Measured(0.3, 0.05, law)  # type: ignore[arg-type]
    drawn = scenes.draw(measured, np.random.default_rng(1))
    assert scenes.deviate(measured, drawn) == pytest.approx(
        np.random.default_rng(1).standard_normal(), rel=1e-9
    )


def test_a_locked_car_is_measured_to_the_end_and_a_rolling_one_the_less_the_further() -> None:
    scene, error = collision(berm=False), RunOutError(Measured(0.04), Measured(8 * DEGREE))
    b = replace(scene.vehicles["b"], run_out_error=error)
    scene = replace(scene, vehicles=scene.vehicles | {"b": b})
    assert scenes.errors(scene, "a", 100.0) == (0.15, 3 * DEGREE)
    of_b = scenes.errors(scene, "b", 50.0)
    assert_allclose(of_b, [np.hypot(0.15, 2.0), np.hypot(3, 8) * DEGREE])


def made_up_row(**differing: object) -> runs.Row:
    row = {
        "scene": 0, "wheels_a": "RLLL", "wheels_b": "LLLL", "rolling": 1, "drag": "rolling",
        "asked": "speed_b", "status": "answered", "model": "momentum+slide", "method": "nuts",
        "seconds": 10,
        "speed_b_true": 20, "speed_b_median": 20.5, "speed_b_sd": 1,
        "speed_b_low_50": 20.1, "speed_b_high_50": 21, "speed_b_low_90": 19,
        "speed_b_high_90": 22, "speed_b_low_99.9": 17, "speed_b_high_99.9": 24,
    }  # fmt: skip
    return {column: str((row | differing).get(column, "")) for column in runs.COLUMNS}


def test_an_answer_is_wrong_where_the_checks_passed_and_the_truth_is_out_of_reach() -> None:
    off = {"speed_b_true": 25}
    assert not scores.wrong(made_up_row(), "speed_b")
    assert scores.wrong(made_up_row(**off), "speed_b")
    assert not scores.wrong(made_up_row(**off, status="withheld"), "speed_b")


def test_scores_count_what_is_in_the_rows(tmp_path: Path) -> None:
    rows = [
        made_up_row(),
        made_up_row(scene=1, speed_b_true=22.5, seconds=100),
        made_up_row(scene=2, status="withheld", reason="a | b"),
        made_up_row(scene=3, status="timed out", speed_b_median="", model="", seconds=300),
    ]
    parts = scores.parts(rows)
    assert "Answered: 2 of 4 (50%" in parts["summary"][0]
    assert "1 of 2 (50%" in parts["summary"][1]
    assert "MISSED" in parts["summary"][3]
    assert parts["groups"][2:] == [
        "| 1 or 2 | 4 | 2 | 1 | 0 | 1 | 0 of 2 | 1 of 2 | 0 | 55.0 | 300.0 |"
    ]
    assert len(parts["unanswered"]) == 4
    scores.draw(rows, tmp_path / "chart.png")
    assert (tmp_path / "chart.png").stat().st_size
