"""The fullest rung's density against one written out with SciPy, and the parts of all."""

import math
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from numpyro.infer.util import log_density
from retrodict.models import RUNGS, parts
from scipy import stats

from retrodict.mechanics import Coefficients, contact_velocity, critical_mu, separation
from retrodict.scene.records import Edge, Measured, Outline, Scene, Surface
from tests.models.test_friction import density
from tests.shared.scenes import collision, rolls

RUNG = RUNGS["planar-moment+wheels"]


def test_density_is_priors_times_likelihood() -> None:
    """numpyro's joint against scipy.stats, term by term."""
    scene = collision(share=0.02)
    structure, data = RUNG.of_scene(scene)
    xi = np.random.default_rng(2).normal(size=len(structure.uncertain)) * 0.5
    x = parts.from_standard(structure, data, jnp.array(xi))
    mu = 0.25
    own = {"speed_b": 19.0, "direction_b": -0.2, "omega_b": 0.3, "e": 0.1, "mu": mu, "e_m": 0.7}
    sites = {"measured": jnp.array(xi)} | own
    found, _ = log_density(RUNG.model, (structure, data), {}, sites)

    expected = stats.halfnorm(scale=30).logpdf(19.0) - math.log(2 * math.pi)
    expected += stats.norm(0, 1).logpdf(0.3)
    expected += stats.truncnorm(-4, 0, loc=1, scale=0.5).logpdf(0.7)
    expected += stats.norm.logpdf(xi).sum()
    for deviate, name in zip(xi, structure.names, strict=True):
        measured, value = scene.inputs()[name], float(x[name])
        if measured.law == "lognormal":
            s = math.sqrt(math.log1p((measured.sd / measured.value) ** 2))
            law = stats.lognorm(
                s, scale=measured.value / math.sqrt(1 + (measured.sd / measured.value) ** 2)
            )
            assert law.mean() == pytest.approx(measured.value)
            assert law.std() == pytest.approx(measured.sd)
        else:
            law = stats.norm(measured.value, measured.sd)
        assert law.cdf(value) == pytest.approx(stats.norm.cdf(deviate))
    v_b = 19.0 * np.array([math.cos(-0.2), math.sin(-0.2)])
    before, to = jnp.array([*parts.approach_of_a(x), *v_b, 0.3]), parts.bodies(x)
    normal = np.array([np.cos(to.Gamma), np.sin(to.Gamma)])
    closing = abs(float(contact_velocity(before, to) @ normal))
    scale = 0.13 + (0.55 - 0.13) * math.exp(-closing / 5)
    expected += stats.truncnorm(0, 1 / scale, scale=scale).logpdf(0.1)
    critical = float(critical_mu(before, to, 0.1, 0.7))
    assert mu < critical
    expected += math.log(density(mu, critical))
    after = separation(before, to, Coefficients(0.1, mu, 0.7))
    poses = np.array(RUNG.run_out.rest_poses(structure, data, x, after)).ravel()
    for pose, measured in zip(poses, scene.evidence().values(), strict=True):
        expected += stats.norm(measured.value, measured.sd).logpdf(pose)
    assert float(found) == pytest.approx(float(expected), rel=1e-10)


def test_vehicles_touch_at_the_impact_centre() -> None:
    structure, data = RUNG.of_scene(collision())
    x = parts.from_standard(structure, data, jnp.zeros(len(structure.uncertain)))
    centre = np.array(parts.impact_poses(x))[:, :2] + np.array(parts.levers(x))
    np.testing.assert_allclose(
        centre, np.tile([[float(x["impact_x"]), float(x["impact_y"])]], (2, 1))
    )


def test_lever_arms_of_the_example_are_the_recovered_ones() -> None:
    """d1..d4 = 1.636, 0.653, 0.205, 2.079 m."""
    structure, data = RUNG.of_scene(collision(share=0.0))
    x = parts.from_standard(structure, data, jnp.zeros(len(structure.uncertain)))
    np.testing.assert_allclose(parts.bodies(x)[4:8], (1.636, 0.653, 0.205, 2.079), atol=1e-12)


def test_scenes_that_differ_in_numbers_share_a_structure() -> None:
    other = collision(rest=((-3.0, 2.0, 3.7), (9.0, -12.0, 12.6)))
    assert RUNG.of_scene(collision())[0] == RUNG.of_scene(other)[0]
    assert RUNG.of_scene(collision())[0] != RUNG.of_scene(collision(share=0.0))[0]
    assert hash(RUNG.of_scene(collision())[0]) == hash(RUNG.of_scene(other)[0])


def bounded(*surfaces: tuple[Edge | None, Outline | None]) -> tuple[Scene, np.ndarray]:
    """The collision with berms and patches of these bounds, and where its vehicles come to rest."""
    scene = collision(share=0.02, berm=False)
    covering = [
        Surface(f"cover_{i}", Measured(0.2 + 0.1 * i, 0.02, "lognormal"), Measured(0.0), *bounds)
        for i, bounds in enumerate(surfaces)
    ]
    scene = replace(scene, surfaces=(*scene.surfaces, *covering))
    structure, data = RUNG.of_scene(scene)
    x = parts.from_standard(structure, data, jnp.full(len(structure.uncertain), 0.5))
    after = jnp.array([-4.6, 3.0, 1.5, 6.5, -6.0, 6.0])
    return scene, np.array(RUNG.run_out.rest_poses(structure, data, x, after))


@pytest.mark.slow
def test_an_outline_is_the_edge_that_is_its_one_side_within_reach() -> None:
    off = Measured(0.1, 0.3)
    berm = Edge(0.0, 1.75, 0.0, "left", off)
    verge = Edge(0.0, -6.0, 0.0, "right", off)
    around = Outline(((-900.0, 1.75), (-900.0, 900.0), (900.0, 900.0), (900.0, 1.75)), off)
    below = Outline(((-900.0, -6.0), (-900.0, -900.0), (900.0, -900.0), (900.0, -6.0)), off)
    scene, expected = bounded((verge, None), (berm, None))
    outlined, found = bounded((verge, None), (None, around))
    both, as_outlines = bounded((None, below), (None, around))
    np.testing.assert_allclose(found, expected, atol=1e-8)
    np.testing.assert_allclose(as_outlines, expected, atol=1e-8)
    assert [RUNG.of_scene(s)[0].outlines for s in (scene, outlined, both)] == [(), (4,), (4, 4)]
    assert outlined.inputs()["edge_cover_1"] is off
    # either matters, and so does where it lies
    for less in (bounded((verge, None)), bounded((berm, None))):
        assert np.abs(less[1] - expected).max() > 0.1
    exact = replace(around, offset=Measured(0.0))
    assert np.abs(bounded((verge, None), (None, exact))[1] - expected).max() > 1e-3


def test_run_outs_without_other_surfaces_neglect_outlines() -> None:
    patch = Outline(((1.0, -3.0), (5.0, -3.0), (5.0, 1.0)), Measured(0.0, 0.1))
    ice = Surface("ice", Measured(0.1, 0.02, "lognormal"), Measured(0.0), None, patch)
    bare = collision(berm=False)
    scene = replace(bare, surfaces=(*bare.surfaces, ice))
    for name in ("momentum+spin", "momentum+slide"):
        assert RUNGS[name].of_scene(scene)[0] == RUNGS[name].of_scene(bare)[0]


def shares(factor: Measured | None, at: float = 0.0) -> tuple[Scene, np.ndarray, np.ndarray]:
    """B rolling on drags of all kinds, with the drags of A and of B that the model makes of them.

    Args:
        factor: common to them.
        at: how many deviations above its median it lies.
    """
    scene = rolls(collision(share=0.0), "b", (1.0, 0.0, 0.3, 0.9))
    b = scene.vehicles["b"]
    assert b.wheels is not None
    exact = {k: replace(getattr(b.wheels, k), sd=0.0) for k in ("front_left", "front_right")}
    wheels = replace(b.wheels, **exact, factor=factor)
    scene = replace(scene, vehicles=scene.vehicles | {"b": replace(b, wheels=wheels)})
    structure, data = RUNG.of_scene(scene)
    xi = jnp.array([at * (name == "drag_factor_b") for name in structure.names])
    x = parts.from_standard(structure, data, xi)
    drags = np.array(parts.cars(structure, x).wheels.drag)
    return scene, *drags


def test_a_factor_of_the_drags_multiplies_their_odds_and_leaves_them_shares() -> None:
    written, spread = np.array([1.0, 0.0, 0.3, 0.9]), math.sqrt(math.log1p(0.3**2))
    for deviates in (-30.0, -1.0, 0.0, 2.0, 30.0):
        scene, of_a, of_b = shares(Measured(1.0, 0.3, "lognormal"), deviates)
        factor = math.exp(spread * deviates - spread**2 / 2)
        assert of_b[:2] == pytest.approx([1.0, 0.0], abs=0)  # locked and free stay so
        assert of_b[2:] / (1 - of_b[2:]) == pytest.approx(
            factor * written[2:] / (1 - written[2:]), rel=1e-9
        )
        assert np.all((of_b >= 0) & (of_b <= 1))
        np.testing.assert_array_equal(of_a, 1.0)  # locked, of which nothing is written
    assert scene.inputs()["drag_factor_b"].sd == 0.3
    assert "drag_factor_a" not in scene.inputs()


def test_without_a_factor_drags_are_as_they_were_written() -> None:
    for factor in (None, Measured(1.0, 0.0, "lognormal")):
        of_b = shares(factor)[2]
        np.testing.assert_allclose(of_b, [1.0, 0.0, 0.3, 0.9], rtol=1e-15)
    assert "drag_factor_b" not in shares(None)[0].inputs()
