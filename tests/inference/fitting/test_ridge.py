"""The far end of the hyperbola of e_m and the spin by the force alone is drawn too."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from retrodict.models import RUNGS

from retrodict.inference.density.compiled import programs_for
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.samplers import Task, smc
from retrodict.inference.samplers.importance import log_evidence, weighted_points
from retrodict.inference.samplers.psis import smoothed
from retrodict.inference.transforms.choice import Coordinates
from retrodict.options import DEFAULT_RUNG
from retrodict.scene.records import Scene
from retrodict.studies import calibration

pytestmark = pytest.mark.slow
NUMBER, BEYOND = 9, 0.956  # of a simulated crash; its true e_m, far out in the posterior
POINTS = 8000


@cache
def crash() -> Scene:
    """A crash that `calibrate` simulates."""
    design = calibration.design()
    structure, data = RUNGS[DEFAULT_RUNG].of_scene(design)
    batch, place = divmod(NUMBER, calibration._BATCH)
    rng = np.random.default_rng([0, batch])
    _, quantities = calibration._truths(programs_for(structure), data, rng)
    own = {name: values[place] for name, values in quantities.items()}
    return calibration._measured(design, structure, own, np.random.default_rng([0, NUMBER, 1]))


def test_the_tail_of_e_m_is_the_same_in_coordinates_that_straighten_the_ridge() -> None:
    """In rest poses the ridge is straight: there it needs no proposal of its own."""
    shares = {}
    for coordinates in (Coordinates.PINNED, Coordinates.DEVIATES):
        posterior = prepare(crash(), DEFAULT_RUNG, coordinates)
        assert (posterior.ridge is None) == (coordinates is Coordinates.PINNED)
        chance = np.random.default_rng(3)
        _, log_weight, quantities, _ = weighted_points(posterior, POINTS, chance)
        weights, k = smoothed(log_weight)
        beyond = quantities["e_m"] > BEYOND
        share = float(weights[beyond].sum())
        error = float(np.sqrt(np.square(weights * (beyond - share)).sum()))
        assert k < 0.7
        assert share > 5 * error > 0
        shares[coordinates] = share, error
    (one, error), (other, another) = shares.values()
    assert abs(one - other) < 4 * np.hypot(error, another)


def test_tempering_begins_on_the_ridge() -> None:
    posterior = prepare(crash(), DEFAULT_RUNG, Coordinates.DEVIATES)
    _, log_weight, quantities, _ = weighted_points(posterior, POINTS, np.random.default_rng(3))
    share = float(smoothed(log_weight)[0] @ (quantities["e_m"] > BEYOND))
    drawn = smc.draw(Task(posterior, 4, 512, 0, 1, lambda *_: None))
    beyond = posterior.evaluate(drawn.w.reshape(-1, posterior.size))[1]["e_m"] > BEYOND
    assert share / 3 < beyond.mean() < 3 * share  # without the ridge it was a fifth


def test_the_density_of_the_ridge_is_that_of_its_draws() -> None:
    """A narrow normal about any step, weighted by draws of the ridge, integrates to one."""
    ridge = prepare(crash(), DEFAULT_RUNG, Coordinates.DEVIATES).ridge
    assert ridge is not None
    u = ridge.draw(400_000, np.random.default_rng(4))
    step = ridge.steps[-1]
    off = u - step.u
    moved, others = off[:, ridge.at] / 0.2, np.delete(off, ridge.at, axis=1)
    z = (others - off[:, ridge.at, None] * step.tangent) @ np.linalg.inv(step.root).T
    squares = moved**2 + np.square(z).sum(axis=1)
    volume = np.log(0.2) + np.log(np.diag(step.root)).sum()
    log_normal = -squares / 2 - u.shape[1] / 2 * np.log(2 * np.pi) - volume
    weight = np.exp(log_normal - ridge.log_density(u))
    error = weight.std() / np.sqrt(len(weight))
    assert error < 0.1
    assert abs(weight.mean() - 1) < 4 * error


def test_a_model_without_e_m_has_no_ridge() -> None:
    posterior = prepare(crash(), "planar-common+spin", Coordinates.DEVIATES)
    assert posterior.ridge is None
    assert not log_evidence(posterior, np.random.default_rng(5)).faults
