"""Diagnostics: what fails the draws, and what is flagged about the scene without failing them."""

import numpy as np
import pytest
import xarray as xr

from retrodict.inference.diagnostics import judge
from retrodict.inference.misfit import UNEXPLAINED
from retrodict.inference.outcome import Checks
from retrodict.inference.prior_check import Reference
from tests.shared.scenes import collision


def tree(seed: int = 0, **changes: np.ndarray) -> xr.DataTree:
    """Independent draws that pass every check, with some variables replaced."""
    rng = np.random.default_rng(seed)
    shape, dims = (4, 500), ("chain", "draw")
    values = {name: rng.normal(size=shape) for name in collision().reported()}
    values |= {
        "mu": np.full(shape, 0.3) + 0.01 * rng.normal(size=shape),
        "mu_critical": np.ones(shape),
        "closing_speed": np.full(shape, 6.0),
    }
    values |= {name: np.ones(shape) for name in ("energy_lost", "normal_impulse")}
    values |= {"moment_work": -np.ones(shape)}
    stats = {"diverging": np.zeros(shape, bool), "energy": rng.normal(size=shape)}
    scene = collision()
    predicted = {
        name: m.value + m.sd * rng.normal(size=shape) for name, m in scene.evidence().items()
    }
    groups = {"posterior": values, "sample_stats": stats, "posterior_predictive": predicted}
    for name, value in changes.items():
        next(group for group in groups.values() if name in group)[name] = value
    return xr.DataTree.from_dict(
        {k: xr.Dataset({n: (dims, v) for n, v in g.items()}) for k, g in groups.items()}
    )


def test_independent_draws_pass() -> None:
    checks = judge(tree(), collision())
    assert checks.passed
    assert checks.reasons == ()
    assert checks.flags == ()
    assert checks.max_rhat < 1.01
    assert checks.min_ess_bulk > 1000


def of_prior(draws: xr.DataTree, left: int, **values: np.ndarray) -> xr.DataTree:
    """The draws beside 500 crashes of the prior, of which the evidence leaves so many."""
    weights = np.where(np.arange(500) < left, 1 / left, 0.0)
    groups = {"prior": values, "sample_stats_prior": {"weight": weights}}
    for name, group in groups.items():
        draws[name] = xr.DataTree(
            xr.Dataset({k: (("chain", "draw"), v[None]) for k, v in group.items()})
        )
    return draws


def test_weak_evidence_is_flagged() -> None:
    for left, flagged in ((150, 1), (25, 0)):
        checks = judge(of_prior(tree(), left), collision())
        assert checks.passed
        assert ["leave 30% of crashes" in flag for flag in checks.flags] == [True] * flagged


def test_draws_of_a_part_of_the_posterior_fail_where_crashes_of_the_prior_show_the_rest() -> None:
    """Half of the posterior of e is standard normal about 2, and no draw is there."""
    values = np.random.default_rng(1).normal(size=500)

    def judged(values: np.ndarray, left: int) -> Checks:
        weights = np.where(np.arange(500) < left, 1 / left, 0.0)
        return judge(tree(), collision(), reference=Reference({"e": values}, weights, {}))

    assert judged(values, 100).passed
    elsewhere = values + 2 * (np.arange(500) % 2)
    checks = judged(elsewhere, 100)
    assert checks.failed == ("e",)
    assert "100 crashes of the prior" in checks.reasons[0]
    assert judged(elsewhere, 20).passed  # too few crashes say nothing


def test_one_divergence_fails() -> None:
    diverging = np.zeros((4, 500), bool)
    diverging[2, 17] = True
    checks = judge(tree(diverging=diverging), collision())
    assert not checks.passed
    assert checks.divergences == 1
    assert "1 divergent" in checks.reasons[0]


def test_a_chain_elsewhere_fails_that_quantity_by_name() -> None:
    speed = np.random.default_rng(1).normal(size=(4, 500))
    speed[3] += 2
    checks = judge(tree(speed_b=speed), collision())
    assert not checks.passed
    assert checks.failed == ("speed_b",)
    assert "R-hat" in checks.reasons[0]
    assert "speed of B" in checks.reasons[0]


def test_many_quantities_fail_in_one_sentence_about_the_worst() -> None:
    rng = np.random.default_rng(1)
    shifts = {"speed_b": 2.0, "e": 0.5, "mu": 0.5}
    apart = {
        name: rng.normal(size=(4, 500)) + shift * (np.arange(4) == 3)[:, None]
        for name, shift in shifts.items()
    }
    checks = judge(tree(**apart), collision())
    assert set(checks.failed) == set(shifts)
    (reason,) = checks.reasons
    assert reason.startswith("impact speed of B: R-hat")
    assert reason.endswith("; 2 more quantities fail likewise")


def test_slow_draws_fail_by_their_effective_size() -> None:
    steps = np.random.default_rng(2).normal(size=(4, 500))
    slow = np.zeros_like(steps)
    for i in range(1, 500):
        slow[:, i] = 0.98 * slow[:, i - 1] + 0.2 * steps[:, i]
    checks = judge(tree(e=slow), collision())
    assert "e" in checks.failed
    assert checks.min_ess_bulk < 400


def test_nan_fails() -> None:
    broken = np.random.default_rng(3).normal(size=(4, 500))
    broken[0, 0] = np.nan
    assert "e_m" in judge(tree(e_m=broken), collision()).failed


def test_a_quantity_without_a_digit_fails() -> None:
    """An sd of 0.2 with an error above 0.1 in either tail: rounded to units, nothing of it is left."""
    rng = np.random.default_rng(5)
    speed = 20 + rng.normal(0, 0.2, (4, 500)) + np.where(rng.random((4, 500)) < 0.026, 2.0, 0.0)
    checks = judge(tree(speed_b=speed), collision())
    assert checks.failed == ("speed_b",)
    assert "leaves no digit of sd" in checks.reasons[0]
    assert judge(tree(speed_b=20 + rng.normal(0, 0.2, (4, 500))), collision()).passed


def test_coarse_quantities_are_named_until_there_are_draws_enough() -> None:
    """200 draws pin the limits of a normal to 0.19 sd: a unit of 0.3, not of 0.94."""
    draws = np.repeat(np.random.default_rng(6).normal(size=(4, 50)), 10, axis=1)
    assert "e" not in judge(tree(e=0.3 * draws), collision()).imprecise
    assert "e" in judge(tree(e=0.94 * draws), collision()).imprecise


def test_slow_energy_fails() -> None:
    energy = np.cumsum(np.random.default_rng(4).normal(size=(4, 500)), axis=1)
    checks = judge(tree(energy=energy), collision())
    assert any("E-BFMI" in reason for reason in checks.reasons)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mu_critical": np.full((4, 500), 0.2)}, "critical"),
        ({"mu_critical": np.full((4, 500), -0.2)}, None),  # sliding the other way is not reversed
        ({"normal_impulse": -np.ones((4, 500))}, "holds the vehicles together"),
        ({"energy_lost": -np.ones((4, 500))}, "gains kinetic energy"),
        (
            {"e": np.random.default_rng(1).normal(0.88, 0.01, (4, 500))},
            "e of about 0.88 is beyond",
        ),
    ],
)
def test_odd_scenes_are_flagged_and_not_failed(changes: dict, words: str | None) -> None:
    checks = judge(tree(**changes), collision())
    assert checks.passed
    assert len(checks.flags) == (0 if words is None else 1)
    assert words is None or words in checks.flags[0]


def test_an_item_that_the_rest_contradicts_and_the_misfit_are_flagged() -> None:
    checks = judge(tree(rest_x_a=np.full((4, 500), 50.0)), collision())
    assert checks.passed
    misfit, item = checks.flags
    assert misfit.startswith(UNEXPLAINED)
    assert "rest of A, x" in item


def test_a_known_fault_fails_whatever_the_draws() -> None:
    checks = judge(tree(), collision(), ("interrupted",))
    assert not checks.passed
    assert checks.reasons == ("interrupted",)
