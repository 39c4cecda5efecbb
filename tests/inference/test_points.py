"""A scene's posterior by weighted points alone is that of a session which kept its coordinates."""

from dataclasses import replace

import numpy as np
import pytest

from retrodict.inference.diagnostics import MIN_ESS
from retrodict.inference.points import answer
from retrodict.inference.warm import Warm
from retrodict.options import DEFAULT_RUNG
from retrodict.scene.records import Measured
from tests.shared.scenes import collision

SCENE = collision(share=0.0, interlocked=True)


@pytest.mark.slow
def test_an_answer_is_that_of_a_session() -> None:
    """By other proposals and points; means within four standard errors of both."""
    found, kept = (
        answer(SCENE, DEFAULT_RUNG, seed=3),
        Warm(SCENE, DEFAULT_RUNG).estimate(SCENE),
    )
    assert found.checks.passed, found.checks.reasons
    assert min(found.checks.min_ess_bulk, found.checks.min_ess_tail) >= MIN_ESS
    for name in ("speed_b", "e", "e_m", "mu"):
        (mean, error), (sure, other) = (
            each.weighted.mean(each.quantities[name]) for each in (found, kept)
        )
        assert abs(mean - sure) < 4 * np.hypot(error, other), name


@pytest.mark.slow
def test_an_answer_depends_on_its_scene_and_seed_alone() -> None:
    first = answer(SCENE, DEFAULT_RUNG)
    answer(
        replace(SCENE, rest=SCENE.rest | {"b": replace(SCENE.rest["b"], x=Measured(9.2, 0.2))}),
        DEFAULT_RUNG,
    )
    again = answer(SCENE, DEFAULT_RUNG)
    np.testing.assert_array_equal(first.draws["speed_b"], again.draws["speed_b"])
    assert not np.array_equal(
        first.draws["speed_b"], answer(SCENE, DEFAULT_RUNG, 1).draws["speed_b"]
    )
