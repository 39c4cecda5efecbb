"""Coordinates where rest poses do not pin the motion: their determinants, and where they lead."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from retrodict.models import RUNGS
from retrodict.models.arrays import in_steps

from retrodict.inference.density.compiled import programs_for
from retrodict.inference.density.kernels import SIMULATE
from retrodict.inference.fitting.pilot import prior_pilot
from retrodict.inference.fitting.posterior import Posterior, prepare, unresolved
from retrodict.inference.fitting.steps import RESOLVED
from retrodict.inference.transforms import velocity
from retrodict.inference.transforms.parameters import plain
from retrodict.scene.records import Approach, Departure, Mark, Measured, Scene, Wheels
from tests.models.test_barrier import against_wall
from tests.shared.scenes import DEGREE, collision


def departed(**changes) -> Scene:
    """Motion after the impact in place of any rest pose, as it is under the paper's numbers."""
    a = Departure(
        direction=Measured(2.81, 0.05), speed=Measured(7.4, 0.3), yaw_rate=Measured(0.61, 0.2)
    )
    b = Departure(
        direction=Measured(-0.83, 0.05), speed=Measured(8.0, 0.3), yaw_rate=Measured(9.9, 0.3)
    )
    scene = replace(collision(berm=False), rest={}, departure={"a": a, "b": b})
    return replace(scene, **changes)


def course_known() -> Scene:
    scene = departed()
    b = Approach(None, Measured(-0.2, DEGREE), Measured(0.0, DEGREE))
    return replace(scene, approach=scene.approach | {"b": b})


def rolled() -> Scene:
    scene = collision(berm=False)
    drag = [Measured(0.2, 0.05, "logitnormal")] * 4
    wheels = Wheels(*drag, steer=Measured(0.0, 2 * DEGREE))
    return replace(
        scene, vehicles=scene.vehicles | {"b": replace(scene.vehicles["b"], wheels=wheels)}
    )


OTHER_PLANAR = ("planar-common", "planar-moment-common", "planar-moment")
SCENES = {"departed": departed(), "course known": course_known(), "rolled": rolled()}


# every rung with one scene and every scene with some rung; all pairs: -m slow
@pytest.mark.parametrize(
    ("rung", "which"),
    [
        pytest.param(rung, which, marks=() if (i + j) % len(SCENES) == 0 else pytest.mark.slow)
        for i, rung in enumerate(name for name in RUNGS if not name.endswith("slide"))
        for j, which in enumerate(SCENES)
    ],
)
def test_log_determinant_is_that_of_the_map(rung: str, which: str) -> None:
    has_its_determinant(SCENES[which], rung)


@pytest.mark.parametrize(
    "rung",
    ["planar+spin", *(pytest.param(f"{n}+spin", marks=pytest.mark.slow) for n in OTHER_PLANAR)],
)
def test_log_determinant_is_that_of_the_map_against_a_wall(rung: str) -> None:
    has_its_determinant(against_wall(), rung)


def has_its_determinant(scene: Scene, rung: str) -> None:
    structure, data = RUNGS[rung].of_scene(scene)
    own = len(velocity.names(structure))
    rng = np.random.default_rng(3)

    def flat(q: jax.Array) -> tuple[jax.Array, tuple]:
        sites, log_det = velocity.locate(structure, data, q)
        values = jnp.concatenate([jnp.atleast_1d(value) for value in sites.values()])
        return values, (sites.get("e", 0.5), log_det)

    # where e is so near to a bound that it rounds to it, no difference quotient is defined
    candidates = rng.normal(size=(100, own + len(structure.uncertain)))
    candidates[:, :4] *= 4
    slopes, (e, log_det) = jax.jit(jax.vmap(jax.jacfwd(flat, has_aux=True)))(candidates)
    chosen = np.flatnonzero((e > 1e-4) & (e < 1 - 1e-4))[:5]
    assert len(chosen) == 5
    np.testing.assert_allclose(
        log_det[chosen], np.linalg.slogdet(slopes[chosen])[1], rtol=0, atol=1e-6
    )


@pytest.mark.parametrize(
    "rung",
    [
        "momentum+spin",
        "planar-common+spin",
        pytest.param("planar-moment+spin", marks=pytest.mark.slow),
    ],
)
def test_the_unknowns_lead_to_the_velocities_that_were_asked_for(rung: str) -> None:
    """By the model itself, forward, wherever e lies well inside its bounds."""
    scene = departed()
    posterior = prepare(scene, rung)
    structure, data = posterior.programs.structure, posterior.data
    q = np.asarray(posterior.transform.centre)
    sites = jax.tree.map(np.asarray, velocity.locate(structure, data, jnp.asarray(q))[0])
    rows = {name: np.tile(value, (500, *[1] * np.ndim(value))) for name, value in sites.items()}
    quantities = {k: np.asarray(v)[0] for k, v in posterior.programs(SIMULATE, data, rows).items()}
    for name, value in zip(velocity.names(structure), q, strict=False):
        if name in ("Vax", "Vay") and rung.startswith("momentum"):
            assert quantities[name] == pytest.approx(value, abs=1e-9)
    again = velocity.coordinates_near(structure, data, sites | quantities)
    moved = again - q
    assert np.abs(moved[: len(velocity.names(structure))]).max() < (
        1e-9 if rung.startswith("momentum") else 0.2
    )


@pytest.mark.slow
@pytest.mark.parametrize(("steps", "few"), [(3, True), (48, False)])
def test_steps_too_few_for_a_mark_are_seen(steps: int, few: bool) -> None:
    """No rest pose was measured: only the mark's distance from the path is informative."""
    scene = departed(marks={"b": (Mark(3.0, -4.0, 0.1, "centre"),)})
    structure, data = in_steps(*RUNGS["planar-moment+spin"].of_scene(scene), steps)
    centre = np.asarray(prepare(scene, "planar-moment+spin").transform.centre)
    transform = plain(centre, 0.01 * np.eye(centre.size))
    posterior = Posterior(programs_for(structure), data, transform, np.zeros(2), 0.0, 0.0)
    assert (unresolved(posterior) > RESOLVED) is few


def test_no_search_begins_from_vehicles_that_part() -> None:
    structure, data = RUNGS["planar-moment+spin"].of_scene(departed())
    score, quantities = prior_pilot(programs_for(structure), data)
    parting = quantities["closing_speed"] < 0
    assert parting.any()
    assert score[parting].max() < score[~parting].min()
