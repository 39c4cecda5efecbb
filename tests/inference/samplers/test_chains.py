"""Chains that get nowhere are seen early, and another method answers."""

import numpy as np
import pytest

from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers.chains import gets_nowhere
from retrodict.options import RunOptions
from tests.shared import random_scenes


@pytest.mark.parametrize(
    ("n_steps", "step_size", "nowhere"),
    [(63, 0.008, True), (63, 0.08, False), (7, 0.008, False)],
    ids=["full trees of short steps", "full trees that cross", "short trees of a narrow density"],
)
def test_a_chain_whose_full_trees_do_not_cross_gets_nowhere(
    n_steps: int, step_size: float, nowhere: bool
) -> None:
    block = {"n_steps": np.full(50, n_steps), "step_size": np.full(50, step_size)}
    assert gets_nowhere(block) == nowhere


@pytest.mark.slow
def test_a_run_whose_chains_get_nowhere_ends_soon_and_importance_answers() -> None:
    scene, truth = random_scenes.scene(np.random.default_rng(14), "grazing")
    found = reconstruct(scene, RunOptions(method="nuts", seed=14), pictured=False)
    assert found.checks.passed
    assert found.settings["method"] == "importance"
    assert "a chain gets nowhere" in found.notes[0]
    speed = found.idata["posterior"]["speed_b"]
    assert abs(truth["speed_b"] - float(speed.mean())) < 4 * float(speed.std())
