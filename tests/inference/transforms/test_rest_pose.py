"""The coordinates: a bijection whose determinant is exact, with e and e_m inside their bounds."""

from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import E_M, E, quotients

from retrodict import load_scene
from retrodict.inference.density.kernels import CHUNK, SIMULATE
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.fitting.posterior import Posterior
from retrodict.inference.modes import solutions
from retrodict.inference.transforms.choice import Coordinates
from retrodict.inference.transforms.rest_pose import RestPose
from retrodict.inference.transforms.soft_bounds import soft_lower_bound, softness_for
from retrodict.options import DEFAULT_RUNG
from tests.shared.scenes import collision

EXAMPLES = Path(__file__).parents[3] / "examples"
OWN = ("speed_b", "direction_b", "omega_b", "e", "mu", "e_m")


@pytest.fixture(scope="module")
def posterior() -> Posterior:
    return prepare(collision(share=0.0), "planar-moment+wheels")


@partial(jax.jit, static_argnums=0)
def _located(structure: Structure, data: Data, transform: RestPose, w: jax.Array) -> Any:
    return jax.vmap(lambda w: transform.transform_and_log_det(structure, data, w))(w)


def located(posterior: Posterior, w: np.ndarray) -> Any:
    """The unknowns at each row of w, the log determinants, and q."""
    return _located(posterior.programs.structure, posterior.data, posterior.transform, w)


@pytest.mark.slow
def test_log_determinant_is_that_of_the_map(posterior: Posterior) -> None:
    """By differences of order four: derivatives of the map are only near enough to steer by."""
    n = posterior.size

    def unknowns(w: np.ndarray) -> np.ndarray:
        sites, _, _ = located(posterior, w)
        return np.concatenate([sites["measured"].T, [sites[name] for name in OWN]])

    h, rng = 1e-3, np.random.default_rng(0)
    for w in 1.5 * rng.normal(size=(20, n)):
        offsets = h * np.concatenate([k * np.eye(n) for k in (1, -1, 2, -2)] + [np.zeros((1, n))])
        points = w + offsets[np.minimum(np.arange(CHUNK), 4 * n)]
        ends = unknowns(points)[:, : 4 * n].reshape(n, 4, n)
        near, far = ends[:, 0] - ends[:, 1], ends[:, 2] - ends[:, 3]
        expected = np.linalg.slogdet((8 * near - far) / (12 * h))[1]
        found = located(posterior, points)[1][-1]
        assert float(found) == pytest.approx(expected, abs=1e-7)


@pytest.mark.slow
def test_e_and_e_m_stay_within_bounds_however_far_out(posterior: Posterior) -> None:
    rng = np.random.default_rng(1)
    w = jnp.array(rng.normal(size=(500, posterior.size)) * 4)
    sites, log_det, _ = located(posterior, w)
    assert not np.isnan(np.array(log_det)).any()
    for level in (E, E_M):
        values = np.array(sites[level.name])
        assert (values >= level.low).all()
        assert (values <= level.high).all()


@pytest.mark.slow
@pytest.mark.parametrize(("which", "bound", "side"), [(0, 0.0, -1), (1, 1.0, 1)], ids=["e", "e_m"])
def test_every_value_up_to_the_near_bound_is_reached(
    posterior: Posterior, which: int, bound: float, side: int
) -> None:
    """A map that stops short of a bound cuts the posterior off there, and no check notices."""
    transform, constraints = posterior.in_rest_poses, posterior.in_rest_poses.constraints
    near, far = (list(constraints.order).index(place) for place in (1 + which, 3 + which))
    margins = np.linspace(constraints.margin[near], -10 * constraints.softness[near], 500)
    away = np.outer(margins - constraints.margin[near], constraints.along[near])
    w = np.linalg.lstsq(transform.whitening.spread, away.T)[
        0
    ].T  # what the sliding is held at stays
    sites, log_det, _ = located(posterior, w)
    assert np.isfinite(np.array(log_det)).all()
    reached = np.array(sites[("e", "e_m")[which]])
    rises, tellable = side * np.diff(reached), abs(bound - reached[1:]) > 1e-12
    assert (rises[tellable] > 0).all()
    assert (rises > -1e-15).all()
    across = constraints.margin[near] + constraints.margin[far]  # from bound to bound
    assert abs(bound - reached[-1]) < constraints.softness[near] / across / 100
    found = solved_back(posterior, sites)[which]
    np.testing.assert_allclose(found, reached, atol=1e-9)


@pytest.mark.slow
def test_every_point_is_bent_to_where_its_levels_are_reached(posterior: Posterior) -> None:
    """Also the one in ten thousand: density zero there would be a divergence of NUTS."""
    w = np.random.default_rng(3).standard_normal((20_000, posterior.size))
    worst = 0.0
    for some in np.split(w, len(w) // CHUNK):
        sites, log_det, _ = located(posterior, some)
        assert np.isfinite(log_det).all()
        for found, name in zip(solved_back(posterior, sites), ("e", "e_m"), strict=True):
            worst = max(worst, float(np.abs(found - sites[name]).max()))
    assert worst < 1e-11


@pytest.mark.slow
def test_no_crash_is_reached_twice() -> None:
    """Far out the linear equations led back to the mode, which passed for another."""
    scene = load_scene(EXAMPLES / "brach-1977" / "scene.toml")
    (only,) = solutions(scene, DEFAULT_RUNG, coordinates=Coordinates.PINNED)
    assert isinstance(only.posterior.transform, RestPose)


def solved_back(posterior: Posterior, sites: dict[str, jax.Array]) -> np.ndarray:
    """e and e_m by the paper's inverse, from the motion that a forward impact gave."""
    quantities = posterior.programs(SIMULATE, posterior.data, sites)
    after = jnp.stack([quantities[name] for of_one in parts.AFTER for name in of_one], axis=1)

    @jax.jit
    @jax.vmap
    def quotient(after: jax.Array, deviates: jax.Array) -> jax.Array:
        x = parts.from_standard(posterior.programs.structure, posterior.data, deviates)
        over, under = quotients((E, E_M), after, x)
        return over / under

    return np.array(quotient(after, sites["measured"])).T


def test_soft_bounds_are_the_identity_away_from_the_bounds() -> None:
    inside = np.linspace(0.2, 0.8, 7)
    np.testing.assert_allclose(soft_lower_bound(inside, 0.01)[0], inside, atol=1e-6)
    assert 0 < float(soft_lower_bound(-0.05, 0.01)[0]) < 1e-3


@pytest.mark.parametrize("level", [-0.2, -0.03, 0.004, 0.5, 0.98, 1.02])
def test_slopes_of_soft_bounds_and_of_their_inverse_are_their_derivatives(level: float) -> None:
    def way(x: Any) -> tuple[jax.Array, jax.Array]:
        return soft_lower_bound(x, 0.02)

    def both(x: float) -> np.ndarray:
        return np.array(way(x))

    h = 1e-5
    _, log_slope = both(level)
    slopes = np.array(jax.jacfwd(lambda x: jnp.stack(way(x)))(level))
    differences = (both(level + h) - both(level - h)) / (2 * h)
    np.testing.assert_allclose(slopes, differences, rtol=1e-5, atol=1e-8)
    assert np.exp(log_slope) == pytest.approx(slopes[0], rel=1e-9)


@pytest.mark.parametrize("mean", [-4.0, -2.0, 0.0, 1.0, 2.0, 4.0])
def test_a_normal_cut_off_at_zero_looks_like_a_normal_when_lifted(mean: float) -> None:
    """By quadrature: how many draws of the normal about its mode importance sampling keeps."""
    level = np.linspace(-12, 14, 4001)
    step = level[1] - level[0]
    sd, top = 1.0, max(mean, 1.0)
    for _ in range(6):
        bounded, log_slope = map(np.array, soft_lower_bound(level, softness_for(sd, top)))
        log_density = log_slope - (bounded - mean) ** 2 / 2
        mode = int(np.argmax(log_density))
        sd, top = step / np.sqrt(-np.diff(log_density, 2)[mode - 1]), bounded[mode]
    w = (level - level[mode]) / sd
    density = np.exp(log_density - log_density[mode])[abs(w) < 5]
    density /= density.sum() * step / sd
    normal = np.exp(-(w[abs(w) < 5] ** 2) / 2) / np.sqrt(2 * np.pi)
    assert np.sum(density**2 / normal) * step / sd < 1 / 0.97


@pytest.mark.slow
def test_the_posterior_is_near_a_standard_normal_in_its_coordinates(posterior: Posterior) -> None:
    """Importance sampling from a standard normal wastes few draws: what makes NUTS quick."""
    rng = np.random.default_rng(3)
    w = rng.normal(size=(300, posterior.size))
    log_weight = np.array([0.5 * (row**2).sum() - posterior.potential(row)[0] for row in w])
    weight = np.exp(log_weight - log_weight.max())
    assert weight.sum() ** 2 / (weight**2).sum() > 0.5 * len(w)
