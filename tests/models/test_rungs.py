"""Each rung against a posterior known otherwise: by quadrature, or by weights in its own unknowns."""

from dataclasses import replace
from typing import Any

import jax
import numpy as np
import pytest
from jax.flatten_util import ravel_pytree
from numpyro import handlers
from numpyro.infer.util import constrain_fn, potential_energy, unconstrain_fn
from retrodict.models import RUNGS, rungs_for
from scipy import stats

from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.samplers import METHODS, Task
from retrodict.inference.samplers.importance import log_evidence
from retrodict.inference.transforms.choice import Coordinates
from retrodict.scene.records import Approach, Mark, Measured, Rest, Scene
from tests.models.closed_form import everything_exact, momentum_and_slide
from tests.shared.scenes import collision, rolls

SCENE = collision(share=0.0, berm=False)
QUICK = "momentum+slide"  # the others: -m slow


def drawn(posterior: Posterior, draws: int = 2000) -> dict[str, np.ndarray]:
    """Quantities at draws by importance sampling, a row each."""
    task = Task(posterior, 4, draws, 0, 0, lambda *_: None)
    return METHODS["importance"].draw(task).known(posterior)


def test_momentum_and_slide_by_quadrature() -> None:
    """Four rest coordinates decide four unknowns, so the posterior is an integral over them."""
    scene = everything_exact(SCENE)
    posterior = prepare(scene, "momentum+slide")
    x, _ = np.polynomial.hermite_e.hermegauss(14)
    weights = np.polynomial.hermite_e.hermegauss(14)[1] / np.sqrt(2 * np.pi)
    z = np.stack(np.meshgrid(x, x, x, x, indexing="ij"), axis=-1).reshape(-1, 2, 2)
    mass = np.prod(np.stack(np.meshgrid(*[weights] * 4, indexing="ij")), axis=0).ravel()

    speed, log_factor = momentum_and_slide(scene, z)
    # over rest coordinates, of which the grid's normal weights are the likelihood
    share = mass * np.exp(log_factor)

    found, evidence = drawn(posterior), log_evidence(posterior, np.random.default_rng(1))
    assert evidence.value == pytest.approx(np.log(share.sum()), abs=5 * evidence.error + 1e-9)
    share /= share.sum()
    mean = share @ speed
    sd = np.sqrt(share @ (speed - mean) ** 2)
    assert found["speed_b"].mean() == pytest.approx(mean, abs=5 * sd / np.sqrt(4000))
    assert found["speed_b"].std() == pytest.approx(sd, rel=5 / np.sqrt(2 * 4000))


@pytest.mark.parametrize(
    "name",
    [
        name if name == QUICK else pytest.param(name, marks=pytest.mark.slow)
        for name in rungs_for(SCENE)
    ],
)
def test_rung_agrees_with_weights_in_its_own_unknowns(name: str) -> None:
    agrees(rolled() if name.endswith("+roll") else SCENE, name)


def rolled() -> Scene:
    """Both vehicles on wheels of which some roll, found to some paces.

    In a rung's own unknowns velocity and what the way misses of it make a ridge no sharper than that.
    """
    scene = rolls(rolls(SCENE, "a", (0.9, 0.9, 0.5, 0.5)), "b", (0.9, 0.5, 0.4, 0.9))
    return replace(scene, rest={v: roughly(scene.rest[v]) for v in scene.rest})


def roughly(rest: Rest) -> Rest:
    """The same pose, seen from afar."""
    assert rest.heading is not None
    x, y = (replace(m, sd=1.0) for m in (rest.x, rest.y))
    return Rest(x, y, replace(rest.heading, sd=0.3), turns_known=True)


def of_b_what_was_recorded(**changes: Any) -> Scene:
    """Of B, motion after the impact in place of a rest pose, as it is under the paper's numbers."""
    departure = {
        "direction": Measured(-0.83, 0.05),
        "speed": Measured(8.0, 0.3),
        "yaw_rate": Measured(9.9, 0.3),
    }
    return replace(SCENE, rest={"a": SCENE.rest["a"]}, departure={"b": departure}, **changes)


def unknown_speed_of_a() -> dict[str, Approach]:
    """And B's known, so that the other is sought."""
    a, b = SCENE.approach["a"], SCENE.approach["b"]
    return {"a": replace(a, speed=None), "b": replace(b, speed=Measured(19.0, 0.5))}


def roughly_where_b_stopped() -> Rest:
    """Its position, to a few paces: the weights the rung is held against see no sharper ridge."""
    b = SCENE.rest["b"]
    return Rest(replace(b.x, sd=2.0), replace(b.y, sd=2.0), None, turns_known=False)


def at_mark() -> dict[str, Measured]:
    """What a film may show of B as it passes."""
    return {"speed": Measured(6.8, 0.3), "course": Measured(-0.85, 0.05)}


SUBSETS = {
    # the rest pose of one vehicle, velocities of the other
    "departure": of_b_what_was_recorded(),
    "speed of A unknown": replace(SCENE, approach=unknown_speed_of_a()),
    "robust": replace(SCENE, robust=True),
    "a mark": replace(SCENE, marks={"b": (Mark(3.0, -4.0, 0.3, "centre"),)}),
    "speed and course at a mark": replace(
        SCENE,
        rest={"a": SCENE.rest["a"]},
        marks={"b": (Mark(3.0, -4.0, 0.3, "centre", **at_mark()),)},
    ),
    "position of B only": replace(SCENE, rest=SCENE.rest | {"b": roughly_where_b_stopped()}),
    "rest of A only": replace(SCENE, rest={"a": SCENE.rest["a"]}),
    "delta-v": replace(
        SCENE, departure={"a": {"delta_v": Measured(13.3, 0.5)}}, rest={"b": SCENE.rest["b"]}
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("which", SUBSETS)
def test_subset_of_evidence_agrees_with_weights_in_the_models_unknowns(which: str) -> None:
    agrees(SUBSETS[which], "planar-common+spin")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("v", "coordinates"), [("a", Coordinates.DEVIATES), ("b", Coordinates.PINNED)]
)
def test_a_vehicle_that_rolls_beside_one_that_skids(v: str, coordinates: Coordinates) -> None:
    """Of the one velocities are coordinates, of the other the rest pose; or both are deviates.

    (Beside A the rest pose of B leaves weights too uneven, which a Pareto k of 1.5 tells.)
    """
    agrees(rolls(SCENE, v, (0.9, 0.5, 0.4, 0.4)), "planar-common+wheels", coordinates)


@pytest.mark.slow
def test_a_vehicle_that_rolls_along_its_way_beside_one_that_skids() -> None:
    """Of the one the inverse in closed form gives coordinates, of the other a regression."""
    scene = rolled()
    agrees(replace(scene, vehicles=scene.vehicles | {"a": SCENE.vehicles["a"]}), "momentum+roll")


@pytest.mark.slow
def test_marks_on_the_way_that_a_vehicle_rolled_along() -> None:
    """They bend the way, and their distance from it is evidence."""
    agrees(replace(rolled(), marks={"b": (Mark(3.0, -4.0, 0.5, "centre"),)}), "momentum+roll")


def agrees(scene: Scene, name: str, coordinates: Coordinates = Coordinates.PINNED) -> None:
    """A Student-t in the model's unconstrained unknowns, weighted by NumPyro's density of it.

    Neither the regressions nor the constraints nor their determinants take part, so all of them must
    be right for the evidence to agree.
    """
    posterior = prepare(scene, name, coordinates)
    structure, data = posterior.programs.structure, posterior.data
    model, ours = RUNGS[name].model, drawn(posterior)
    trace = handlers.trace(handlers.seed(model, 0)).get_trace(structure, data)
    ours = {k: v for k, v in ours.items() if k in trace and trace[k]["type"] == "sample"}
    _, unravel = ravel_pytree(unconstrain_fn(model, (structure, data), {}, first(ours)))
    flat = jax.jit(
        jax.vmap(lambda s: ravel_pytree(unconstrain_fn(model, (structure, data), {}, s))[0])
    )(ours)
    middle, unit = np.mean(flat, axis=0), np.std(flat, axis=0)
    law = stats.multivariate_t(0 * unit, 1.3 * np.corrcoef(flat, rowvar=False), df=8, seed=3)
    t = law.rvs(20_000)

    @jax.jit
    @jax.vmap
    def weighted(u: jax.Array) -> tuple[jax.Array, dict[str, jax.Array]]:
        sites = unravel(u)
        log_density = -potential_energy(model, (structure, data), {}, sites)
        return log_density, constrain_fn(model, (structure, data), {}, sites)

    log_weight, sites = weighted(middle + unit * t)
    log_weight = np.nan_to_num(np.asarray(log_weight), nan=-np.inf) - law.logpdf(t)
    log_weight += np.log(unit).sum()
    weight = np.exp(log_weight - log_weight.max())
    evidence = log_weight.max() + np.log(weight.mean())
    weight /= weight.sum()
    effective = 1 / (weight**2).sum()
    assert effective > 200
    mine = log_evidence(posterior, np.random.default_rng(1))
    assert mine.value == pytest.approx(evidence, abs=5 * np.hypot(mine.error, effective**-0.5))
    for site in ("speed_b", *(q for q in ("e", "e_m", "mu") if q in ours)):
        theirs, draws = np.asarray(sites[site]), ours[site]
        mean = weight @ theirs
        sd = np.sqrt(weight @ (theirs - mean) ** 2)
        error = np.sqrt(1 / effective + 1 / 4000)
        assert draws.mean() == pytest.approx(mean, abs=5 * sd * error), site
        assert draws.std() == pytest.approx(sd, rel=5 * error), site


def first(rows: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The first row of each."""
    return {name: values[0] for name, values in rows.items()}


@pytest.mark.slow
def test_what_a_rung_holds_is_so_in_every_draw() -> None:
    """No moment impulse and no sliding left: eqs 11 and 23 in velocities that the model gives."""
    posterior = prepare(SCENE, "planar-common+spin")
    found = drawn(posterior, 500)
    np.testing.assert_allclose(found["moment_work"], 0, atol=1e-6)
    lever_a, lever_b = np.array([-2.079, -0.205]), np.array([0.653, 1.636])
    x = found["Vax"] - found["Omega_a"] * lever_a[1] - found["Vbx"] + found["Omega_b"] * lever_b[1]
    y = found["Vay"] + found["Omega_a"] * lever_a[0] - found["Vby"] - found["Omega_b"] * lever_b[0]
    Gamma = found["Gamma"]
    np.testing.assert_allclose(y * np.cos(Gamma) - x * np.sin(Gamma), 0, atol=1e-9)


def test_rungs_stand_above_those_they_contain() -> None:
    names = list(RUNGS)
    for i, name in enumerate(names):
        assert not RUNGS[name].nests(RUNGS[name])
        assert not any(RUNGS[lower].nests(RUNGS[name]) for lower in names[:i])
    for kind in ("alone", "together", "impact"):
        own = [name for name in names if RUNGS[name].impact.kind == kind]
        assert all(RUNGS[own[-1]].nests(RUNGS[name]) for name in own[:-1])
    assert not RUNGS["planar+spin"].nests(RUNGS["planar-moment-common+spin"])
