"""What is stated of the energy lost in the impact, as evidence: against SciPy and reweighted draws."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest
from numpyro.infer.util import log_density
from retrodict.models import RUNGS, rungs_for
from scipy import stats

import retrodict as rd
from retrodict.scene.quantities import describe
from retrodict.scene.records import FREEDOM, Measured, Scene
from retrodict.studies.conflict import conflicts
from tests.models.test_evidence import SITES, trace_of
from tests.shared.scenes import collision

RUNG = RUNGS["planar-moment+spin"]
BARE = collision(share=0.0, berm=False)


def kinetic_energy(trace: dict, scene: Scene) -> tuple[float, float]:
    """Before and after the impact, J: ½ m v² + ½ I ω² of both vehicles."""
    value = {
        k: float(site["value"]) for k, site in trace.items() if site["type"] == "deterministic"
    }
    approach = scene.approach["a"]
    before = {
        "a": (approach.speed.value, 0.0, approach.yaw_rate.value),
        "b": (value["vbx"], value["vby"], SITES["omega_b"]),
    }
    after = {v: tuple(value[k] for k in (f"V{v}x", f"V{v}y", f"Omega_{v}")) for v in "ab"}
    masses = [(own.mass.value, own.yaw_inertia.value) for own in scene.vehicles.values()]
    first, last = (
        sum(
            m * (x * x + y * y) / 2 + inertia * w * w / 2
            for (m, inertia), (x, y, w) in zip(masses, motion.values(), strict=True)
        )
        for motion in (before, after)
    )
    return first, last


@pytest.mark.slow
@pytest.mark.parametrize("robust", [False, True])
def test_a_scene_weighs_the_energy_that_the_velocities_say_was_lost(robust: bool) -> None:
    before, after = kinetic_energy(trace_of(BARE, RUNG), BARE)
    lost, law = before - after, stats.t(FREEDOM) if robust else stats.norm
    assert lost > 1e5
    stated, least, most = (Measured(x * lost, 0.3 * lost) for x in (0.7, 1.2, 0.9))
    expected = {
        "energy_lost": law.logpdf((stated.value - lost) / stated.sd) - np.log(stated.sd),
        "energy_lost_at_least": law.logcdf((lost - least.value) / least.sd),
        "energy_lost_at_most": law.logcdf((most.value - lost) / most.sd),
    }
    for key, measured in zip(expected, (stated, least, most), strict=True):
        scene = replace(BARE, energy_lost={key: measured}, robust=robust)
        site = trace_of(scene, RUNG)[f"impact_{key}"]
        found = float(site["fn"].log_prob(site["value"]))
        assert found == pytest.approx(expected[key], rel=1e-9), key
        # and nothing else is weighed otherwise
        densities = []
        for of in (scene, replace(scene, energy_lost={})):
            structure, data = RUNG.of_scene(of)
            at = {k: jnp.asarray(v) for k, v in SITES.items()}
            at["measured"] = jnp.zeros(len(structure.uncertain))
            densities.append(float(log_density(RUNG.model, (structure, data), {}, at)[0]))
        assert densities[0] - densities[1] == pytest.approx(expected[key]), key


def test_rungs_that_have_the_energy_explain_it_and_no_others() -> None:
    scene = replace(BARE, energy_lost={"energy_lost": Measured(1e5, 4e4)})
    for name, rung in rungs_for(scene).items():
        has = not name.startswith("momentum+")
        assert rung.explains("impact_energy_lost") == has, name
        assert ("impact_energy_lost" in rung.of_scene(scene)[0].evidence) == has, name


@pytest.mark.slow
def test_a_reconstruction_is_that_of_reweighted_draws(tmp_path: Path) -> None:
    """Draws of a scene without the energy, weighted by the closed form of its likelihood."""
    settings = {"model": "planar-common+spin", "draws": 2000}
    a = replace(BARE.approach["a"], speed=Measured(20.1, 2.0))
    bare = replace(BARE, approach=BARE.approach | {"a": a})
    plain = rd.reconstruct(bare, **settings).idata["posterior"]
    lost, speed = (np.asarray(plain[k]).ravel() for k in ("energy_lost", "speed_b"))
    most = Measured(float(np.quantile(lost, 0.3)), float(lost.std() / 2))
    weights = stats.norm.cdf((most.value - lost) / most.sd)
    weights /= weights.sum()
    result = rd.reconstruct(replace(bare, energy_lost={"energy_lost_at_most": most}), **settings)
    assert result.checks.passed, result.checks.reasons
    posterior = result.idata["posterior"]
    for name, before in (("energy_lost", lost), ("speed_b", speed)):
        found = np.asarray(posterior[name]).ravel()
        mean = float(weights @ before)
        sd = float(np.sqrt(weights @ (before - mean) ** 2))
        error = np.hypot(sd * np.sqrt((weights**2).sum()), found.std() / np.sqrt(1000))
        assert found.mean() == pytest.approx(mean, abs=4 * error), name
        assert found.std() == pytest.approx(sd, rel=0.12), name
    assert abs(float(np.mean(posterior["energy_lost"])) - lost.mean()) > 0.3 * lost.std()
    name = "impact_energy_lost_at_most"
    assert name in {item.name for item in conflicts(result.outcome)}
    assert any("impact.energy_lost_at_most: energies from" in flag for flag in result.checks.flags)
    page = result.report(tmp_path / "report.html").read_text(encoding="utf-8")
    assert describe(name)[0] in page
    assert "impact.energy_lost_at_most: energies from crush" in page
