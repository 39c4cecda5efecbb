"""The corner range against every corner, and points between, of a model in closed form."""

from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from retrodict.studies.corners import LIMITS, corners
from retrodict.studies.draws import NotAnswered
from tests.models.closed_form import momentum_and_slide
from tests.shared.scenes import collision

SCENE = collision(share=0.0, berm=False)  # rest positions, friction, A's speed and Gamma


def outcome(scene=SCENE, model="momentum+slide"):
    return SimpleNamespace(scene=scene, description=SimpleNamespace(name=model))


def brute_force(limit: float) -> np.ndarray:
    """B's speed where each of the six measurements that count is at a limit, or at or between."""
    q = np.array(list(product(np.linspace(-limit, limit, 5), repeat=6)))
    scale = np.sqrt(np.log1p(0.06**2))
    friction = 0.5 * np.exp(scale * q[:, 4] - scale**2 / 2)
    return momentum_and_slide(SCENE, q[:, :4].reshape(-1, 2, 2), friction, -0.894 * q[:, 5])[0]


@pytest.mark.slow
def test_it_is_the_range_over_all_corners_and_points_between():
    found = corners(outcome())
    assert tuple(each.limit for each in found) == LIMITS
    for each in found:
        speeds = brute_force(each.limit)
        assert each.least == pytest.approx(speeds.min(), rel=1e-6)
        assert each.greatest == pytest.approx(speeds.max(), rel=1e-6)
    one, two = found
    assert two.greatest - two.least > 1.9 * (one.greatest - one.least)


def test_what_is_not_solved_back_is_refused():
    for scene in (
        replace(SCENE, rest={"a": SCENE.rest["a"]}),
        replace(SCENE, approach=SCENE.approach | {"a": replace(SCENE.approach["a"], speed=None)}),
    ):
        with pytest.raises(NotAnswered, match="does not have"):
            corners(outcome(scene))
    with pytest.raises(NotAnswered, match="not one of this version"):
        corners(outcome(model="another"))
