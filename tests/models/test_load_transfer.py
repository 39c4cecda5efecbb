"""Load transfer in the most detailed run-out, where a scene gives the height of a centre of gravity."""

from __future__ import annotations

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpyro.infer.util import log_density
from retrodict.models import RUNGS, parts, rungs_for
from retrodict.models.arrays import Data, Structure

from retrodict.mechanics import rest
from retrodict.scene.records import Measured, Scene
from tests.shared.scenes import collision

RUNG = RUNGS["planar-moment+wheels"]
SCENE = collision(share=0.02)
AFTER = jnp.array([-3.0, 2.0, 3.0, 7.0, -9.0, 9.0])


def high(scene: Scene, height: float, v: str = "a") -> Scene:
    """The scene with the centre of gravity of a vehicle at a height, m."""
    car = replace(scene.vehicles[v], cg_height=Measured(height, 0.03, "lognormal"))
    return replace(scene, vehicles=scene.vehicles | {v: car})


def as_measured(structure: Structure, data: Data) -> parts.Values:
    return parts.from_standard(structure, data, jnp.zeros(len(structure.uncertain)))


def test_without_a_height_loads_are_static() -> None:
    structure, data = RUNG.of_scene(SCENE)
    assert parts.cars(structure, as_measured(structure, data)).height is None
    assert not [name for name in data.inputs if name.startswith("cg_height")]


@pytest.mark.slow
def test_a_height_moves_the_loads_of_its_vehicle_alone() -> None:
    (structure, data), (static, as_before) = map(RUNG.of_scene, (high(SCENE, 0.55), SCENE))
    assert set(structure.uncertain) - set(static.uncertain) == {("cg_height_a", "lognormal")}
    x = as_measured(structure, data)
    ends = RUNG.run_out.rest_poses(structure, data, x, AFTER)
    level = RUNG.run_out.rest_poses(static, as_before, as_measured(static, as_before), AFTER)
    np.testing.assert_allclose(ends[1], level[1], rtol=0, atol=1e-12)
    car = jax.tree.map(lambda both: both[0], parts.cars(structure, x))
    ground = parts.ground(structure, data, x)
    ground = ground._replace(coefficients=jnp.asarray(ground.coefficients)[0])
    alone = rest(parts.impact_poses(x)[0], AFTER[:3], car, ground, int(data.steps.number))
    np.testing.assert_allclose(ends[0], alone, rtol=0, atol=1e-9)
    assert np.abs(ends[0] - level[0]).max() > 1e-3


@pytest.mark.parametrize(
    "name", [name for name in rungs_for(SCENE) if not name.endswith("+wheels")]
)
def test_simpler_run_outs_neglect_it(name: str) -> None:
    rung = RUNGS[name]
    (with_height, its), (without, own) = map(rung.of_scene, (high(SCENE, 0.55), SCENE))
    assert with_height == without
    assert its.inputs.keys() == own.inputs.keys()
    assert any("load transfer" in line for line in rung.description(SCENE).left_out)


@pytest.mark.slow
def test_there_is_no_density_where_a_wheel_lifts() -> None:
    """On friction of 0.5 one lifts on a track of 1.5 m, whatever the way, at a height of 2.5 m."""
    structure, data = RUNG.of_scene(high(SCENE, 2.5))
    sites = {"measured": jnp.zeros(len(structure.uncertain)), "speed_b": 19.0, "direction_b": -0.2}
    sites |= {"omega_b": 0.3, "e": 0.1, "mu": 0.25, "e_m": 0.7}

    @jax.jit
    def density(data: Data) -> jax.Array:
        return log_density(RUNG.model, (structure, data), {}, sites)[0]

    assert not np.isfinite(density(data))
