"""An impact with a barrier: what it samples, its density, and where the motion leads."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import jax.numpy as jnp
import numpy as np
import pytest
from numpyro import handlers
from numpyro.infer.util import log_density
from retrodict.models import RUNGS, parts, rungs_for
from scipy import stats

from retrodict.inference.errors import Unanswerable
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers import METHODS, Task
from retrodict.options import RunOptions
from retrodict.scene.records import Approach, Barrier, Contact, Measured, Scene
from tests.models.test_friction import density
from tests.shared.scenes import collision

WALL = Barrier("wall", "wall")


def against_wall() -> Scene:
    """The paper's A alone, which struck a wall: its motion after the impact was measured."""
    scene = collision(share=0.02, berm=False)
    direction = Measured(math.pi)
    departure = {"delta_v": Measured(13.0, 0.5), "yaw_rate": Measured(0.6, 0.2)}
    return replace(
        scene,
        vehicles={"a": scene.vehicles["a"]},
        approach={"a": Approach(None, direction, Measured(0.0))},
        rest={},
        departure={"a": departure},
        barrier=WALL,
    )


@pytest.mark.parametrize("name", ["planar-common", "planar", "planar-moment"])
def test_density_is_priors_times_likelihood(name: str) -> None:
    """numpyro's joint against scipy.stats, term by term; no quantity of a vehicle B in it."""
    scene, rung = against_wall(), RUNGS[f"{name}+spin"]
    structure, data = rung.of_scene(scene)
    xi = np.random.default_rng(2).normal(size=len(structure.uncertain)) * 0.3
    own = {"e": 0.1}
    own |= {"e_m": 0.7} if "moment" in name else {}
    if "common" not in name:
        conditioned = handlers.substitute(rung.model, {"measured": jnp.array(xi)} | own)
        once = handlers.trace(handlers.seed(conditioned, 0)).get_trace(structure, data)
        own["mu"] = 0.5 * float(once["mu_critical"]["value"])
    sites = {"measured": jnp.array(xi)} | own
    found, trace = log_density(rung.model, (structure, data), {}, sites)
    known = {k: float(s["value"]) for k, s in trace.items() if s["type"] == "deterministic"}
    assert not [k for k in trace if k.endswith("_b")]

    closing = known["closing_speed"]
    scale = 0.13 + (0.55 - 0.13) * math.exp(-closing / 5)
    expected = stats.norm.logpdf(xi).sum()
    expected += stats.halfnorm(scale=scale).logpdf(0.1) - math.log(
        stats.halfnorm(scale=scale).cdf(1)
    )
    if "e_m" in own:
        expected += stats.truncnorm(-4, 0, loc=1, scale=0.5).logpdf(0.7)
    if "mu" in own:
        expected += math.log(density(own["mu"], known["mu_critical"]))
    expected += stats.norm(known["delta_v_a"], 0.5).logpdf(13.0)
    expected += stats.norm(known["Omega_a"], 0.2).logpdf(0.6)
    assert float(found) == pytest.approx(expected, abs=1e-8)


def test_a_central_impact_rebounds_with_the_share_e_of_its_speed() -> None:
    """V = -e v where the velocity, the lever and the wall's normal lie on one line."""
    scene = against_wall()
    car = replace(
        scene.vehicles["a"], heading=Measured(0.0), impact_angle=Measured(0.0),
        impact_distance=Measured(2.0),
    )  # fmt: skip
    ahead = Approach(Measured(15.0, 1.0), Measured(0.0), Measured(0.0))
    contact = replace(scene.contact, Gamma=Measured(0.0))
    scene = replace(scene, vehicles={"a": car}, approach={"a": ahead}, contact=contact)
    rung = RUNGS["planar+spin"]
    structure, data = rung.of_scene(scene)
    x = parts.from_standard(structure, data, np.zeros(len(structure.uncertain)))
    given = handlers.substitute(
        rung.impact.forward_model, {"e": jnp.array(0.3), "mu": jnp.array(0.0)}
    )
    with handlers.seed(rng_seed=0):
        after = given(structure, data, x)
    np.testing.assert_allclose(after, [-0.3 * 15.0, 0.0, 0.0], atol=1e-12)


def central() -> Scene:
    """All is exact but the speed and the measured delta-v, and on one line with the wall's normal."""
    scene = against_wall()
    exact = {
        each.name: replace(value, sd=0.0)
        for each in fields(scene.vehicles["a"])
        if isinstance(value := getattr(scene.vehicles["a"], each.name), Measured)
    }
    straight = {"heading": Measured(0.0), "impact_angle": Measured(0.0)}
    surfaces = tuple(replace(s, friction=replace(s.friction, sd=0.0)) for s in scene.surfaces)
    return replace(
        scene,
        vehicles={"a": replace(scene.vehicles["a"], **exact | straight)},
        approach={"a": Approach(None, Measured(0.0), Measured(0.0))},
        contact=Contact(Measured(0.0), Measured(0.0), Measured(0.0)),
        departure={"a": {"delta_v": Measured(9.0, 0.5)}},
        surfaces=surfaces,
    )


def test_the_speed_of_a_central_impact_by_quadrature() -> None:
    """Delta-v is (1 + e) v: an integral over the speed v and the restitution e."""
    v, e = np.linspace(1e-3, 15, 600)[:, None], np.linspace(0.5 / 400, 1 - 0.5 / 400, 400)
    law = stats.halfnorm(scale=0.13 + (0.55 - 0.13) * np.exp(-v / 5))
    weight = law.pdf(e) / law.cdf(1) * stats.halfnorm(scale=30).pdf(v)
    weight = (weight * stats.norm((1 + e) * v, 0.5).pdf(9.0)).sum(axis=1)
    weight /= weight.sum()
    mean = weight @ v[:, 0]
    sd = np.sqrt(weight @ (v[:, 0] - mean) ** 2)

    posterior = prepare(central(), "planar-common+spin")
    assert posterior.size == 2
    task = Task(posterior, 4, 2000, 0, 0, lambda *_: None)
    found = METHODS["importance"].draw(task).known(posterior)["speed_a"]
    assert found.mean() == pytest.approx(mean, abs=5 * sd / np.sqrt(4000))
    assert found.std() == pytest.approx(sd, rel=5 / np.sqrt(2 * 4000))


def test_momentum_alone_is_no_model_of_a_barrier() -> None:
    scene = against_wall()
    for name, rung in rungs_for(scene).items():
        if name.startswith("momentum"):
            assert rung.refusal(scene).startswith("uses conservation of momentum only")
            assert not rung.refusal(collision()).startswith("goes by momentum")
        elif not name.endswith("roll"):
            assert not rung.refusal(scene)
    with pytest.raises(Unanswerable, match=r"momentum\+spin uses conservation of momentum only"):
        reconstruct(scene, RunOptions(model="momentum+spin"))


@pytest.mark.parametrize("name", [n for n, rung in RUNGS.items() if rung.impact.against_barrier])
def test_a_model_is_described_without_a_vehicle_b(name: str) -> None:
    said = RUNGS[name].description(against_wall())
    every = " ".join(
        [*said.equations, *said.assumptions, *said.left_out, *(" ".join(p) for p in said.priors)]
    )
    for word in ("vehicle B", "of B", "B's", "_b", "both vehicles"):
        assert word not in every
    assert said.priors[0][0] == "impact speed of A"
