"""Nested Laplace proposals have the density that they say, and fit a posterior that bends."""

from __future__ import annotations

import numpy as np

from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.samplers.importance import adapted, evaluated
from retrodict.inference.samplers.nested import nested
from retrodict.inference.samplers.proposal import Proposal
from retrodict.inference.samplers.psis import effective, log_mean, smoothed
from retrodict.inference.transforms.choice import Coordinates
from retrodict.options import DEFAULT_RUNG
from tests.inference.fitting.test_ridge import crash

POINTS = 4000


def test_the_evidence_is_that_by_another_proposal() -> None:
    """Weights of draws whose stated density were off would have another mean."""
    posterior = prepare(crash(), DEFAULT_RUNG, Coordinates.DEVIATES)
    chance = np.random.default_rng(5)
    proposal = nested(posterior)
    assert proposal is not None
    about_mode = adapted(
        posterior, Proposal.first(posterior.size), lambda at: at.draw(2048, chance)
    ).next
    found, shares = [], []
    for each, count in ((proposal, POINTS), (about_mode, 10 * POINTS)):
        w, log_density = each.sampled(count, chance)
        log_weight = evaluated(posterior, w)[0] - log_density
        found.append(log_mean(log_weight))
        shares.append(effective(smoothed(log_weight)[0]) / count)
    (one, error), (other, another) = found
    assert max(error, another) < 0.2  # one draw in many thousands is of a mode that was not found
    assert abs(one - other) < 4 * np.hypot(error, another)
    assert shares[0] > 2 * shares[1]


def test_coordinates_without_a_shear_do_as_well() -> None:
    """The sheet is solved for, so that none has to be fitted."""
    shares = []
    for coordinates in (Coordinates.DEVIATES, Coordinates.UNBENT):
        posterior = prepare(crash(), DEFAULT_RUNG, coordinates)
        proposal = nested(posterior)
        assert proposal is not None
        w, log_density = proposal.sampled(POINTS, np.random.default_rng(6))
        weights, k = smoothed(evaluated(posterior, w)[0] - log_density)
        assert k < 0.7
        shares.append(effective(weights) / POINTS)
    assert abs(shares[0] - shares[1]) < 0.1


def test_rest_poses_have_none() -> None:
    assert nested(prepare(crash(), DEFAULT_RUNG, Coordinates.PINNED)) is None
