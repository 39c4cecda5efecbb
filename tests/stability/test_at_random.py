"""Scenes at random keep every law, and what is odd is flagged; `benchmarks.stability` runs thousands."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared import random_impacts as impacts
from tests.shared import random_run_outs as run_outs


def test_impacts_keep_the_laws_and_a_second_implementation() -> None:
    found = impacts.examine(impacts.draw(2000, seed=1))
    for law, fault in found.faults.items():
        assert fault.max() <= 1, (law, int(fault.argmax()), float(fault.max()))


def test_the_laws_would_notice(monkeypatch) -> None:
    """With the printed sign of eq 24, or a velocity a billionth off, the harness fails."""
    drawn = impacts.draw(200, seed=2)
    after = impacts.solved(drawn)[0][:, :6]
    off = after * (1 + 1e-9 * np.arange(1, 7))
    assert max(law.max() for law in impacts._laws(drawn, after).values()) < 1000
    assert (impacts._laws(drawn, off)["momentum"] > 1).mean() > 0.5
    e_m = drawn.coefficients.e_m
    printed = drawn._replace(coefficients=drawn.coefficients._replace(e_m=-e_m))
    assert (impacts._laws(printed, after)["eq 24"] > 1).mean() > 0.5


def test_what_is_odd_is_flagged_and_only_that_may_be() -> None:
    found = impacts.examine(impacts.draw(2000, seed=3))
    for name, flag in found.flags.items():
        assert not (found.odd[name] & ~flag).any(), name
        assert 0 < flag.mean() < 1, name


@pytest.mark.slow
def test_run_outs_lose_energy_and_end() -> None:
    for rolling in (False, True):
        scenes = run_outs.draw(40, seed=1, rolling=rolling)
        found = run_outs.examine(scenes)
        for law, broken in found.faults.items():
            assert not broken.any(), (law, np.flatnonzero(broken))
        assert found.refused.mean() < 0.1
        few = run_outs.Found(found.rest[:4], found.refused[:4], {})
        assert run_outs.differences(scenes[:4], few).max() < run_outs.WITHIN


@pytest.mark.slow
def test_step_error_shows_coarse_steps() -> None:
    """What is off by over 3 cm it says is off by over 1 cm; of what is right it does not."""
    scenes = run_outs.draw(40, seed=2)
    found = run_outs.examine(scenes)
    off, errors = run_outs.in_fixed_steps(scenes, found, 48)
    assert (off > 0.03).sum() >= 10
    assert (errors[off > 0.03] > 0.01).all()
    right = off < 0.003
    assert right.sum() >= 5
    assert (errors[right] < 0.01).all()
