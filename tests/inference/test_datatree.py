"""The tree of draws: what of the prior the evidence leaves."""

import numpy as np
import pytest

from retrodict.inference.datatree import _weights


@pytest.mark.parametrize(
    ("fits", "closing", "kept"),
    [
        (np.full(500, -3.0), 5.0, 1.0),  # no difference was detected
        (np.where(np.arange(500) < 100, 0.0, -np.inf), 5.0, 0.2),
        (np.where(np.arange(500) < 1, 0.0, -900.0), 5.0, 1 / 500),
        (np.full(500, np.nan), 5.0, 0.0),  # none fits: that is not little
        (np.full(500, -3.0), -5.0, 0.0),  # none closes in
    ],
)
def test_the_share_of_the_prior_that_evidence_leaves(
    fits: np.ndarray, closing: float, kept: float
) -> None:
    prior = {"log_likelihood/x": fits, "closing_speed": np.full(500, closing)}
    weights = _weights(prior, ["x"])
    assert weights.sum() == pytest.approx(float(kept > 0))
    assert np.sum(weights**2) == pytest.approx(kept and 1 / (500 * kept))
