"""Vehicles that close in slowly: e and e_m are quotients of small numbers, and both branches may count.

What importance sampling draws about each mode is compared with populations tempered from the prior,
which know of none.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.special import logsumexp

from retrodict.inference.modes import ModeSearch
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers import METHODS, Task
from retrodict.inference.transforms.choice import Coordinates
from retrodict.options import DEFAULT_RUNG
from retrodict.scene import load_scene
from tests.shared.posteriors import from_the_prior

SCENES = Path(__file__).parents[1] / "data"
LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "log_evidence"),
    [("low-closing", -17.43), ("sideswipe", -12.54)],
)
def test_parts_about_each_mode_agree_with_tempering_from_the_prior(
    name: str, log_evidence: float
) -> None:
    scene = load_scene(SCENES / f"{name}.toml")
    where = ModeSearch(scene, 0).on(DEFAULT_RUNG, Coordinates.DEVIATES)
    drawn = [
        METHODS["importance"].draw(Task(each.posterior, 4, 2000, 0, 0, lambda *_: None))
        for each in where.found
    ]
    assert not any(each.faults for each in drawn)
    evidence = np.array([each.attributes["log_evidence"] for each in drawn])
    total = logsumexp(evidence)
    # Another forward model and sampler, written independently, found -18.6 for the first with a former
    # prior of mu; draws of those posteriors, weighted by the present prior over that one, give these
    assert abs(total - log_evidence) < 0.2
    whole = from_the_prior(scene, DEFAULT_RUNG)
    tempered = METHODS["smc"].draw(Task(whole, 8, 1024, 0, 5, lambda *_: None))
    assert abs(total - tempered.attributes["log_evidence"]) < 1.0
    known = tempered.known(whole)
    for quantity in ("speed_b", "e", "e_m", "mu"):
        values = np.concatenate([np.asarray(each.quantities[quantity]) for each in drawn])
        sizes = [len(each.quantities[quantity]) for each in drawn]
        weight = np.repeat(np.exp(evidence - total) / sizes, sizes)
        order = np.argsort(values)
        share = np.cumsum(weight[order])
        for level in LEVELS:  # of the probability, below the quantiles of what was tempered
            bound = np.quantile(known[quantity], level)
            below = np.interp(bound, values[order], share)
            assert below == pytest.approx(level, abs=0.06), (quantity, level)


@pytest.mark.slow
def test_a_low_closing_speed_is_answered_from_both_branches() -> None:
    """True e_m 0.30: the branch with it below 0 has little weight; the values are of weighted draws."""
    found = reconstruct(load_scene(SCENES / "low-closing.toml"), pictured=False)
    assert found.checks.passed, found.checks.reasons
    assert "the first sampler, nuts, was not accepted" in found.notes[0]
    low, middle, high = found.idata["posterior"]["e_m"].quantile((0.05, 0.5, 0.95)).values
    assert low == pytest.approx(0.39, abs=0.06)
    assert middle == pytest.approx(0.71, abs=0.06)
    assert high == pytest.approx(0.97, abs=0.03)
