"""Modes by damped least squares from crashes of the prior: each found once, at its numbers of turns."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from retrodict.inference.errors import Unanswerable
from retrodict.inference.fitting.about_peak import crashes_of, turned
from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.fitting.search import Peak, Search, peaks
from retrodict.options import DEFAULT_RUNG
from tests.inference.test_modes import turned_scene
from tests.shared.scenes import collision

SCENE = collision(share=0.0, interlocked=True)


@pytest.fixture(scope="module")
def crashes() -> Crashes:
    return crashes_of(SCENE, DEFAULT_RUNG)


@pytest.fixture(scope="module")
def peak(crashes: Crashes) -> Peak:
    return peaks(crashes, seed=0)[0]


@pytest.mark.parametrize("seed", range(3))
def test_the_papers_scene_has_one_mode_whatever_the_seed(
    seed: int, crashes: Crashes, peak: Peak
) -> None:
    (found,) = peaks(crashes, seed)
    assert found.distance(peak) < 0.3
    assert found.potential == pytest.approx(peak.potential, abs=0.01)
    # SAE 770014's Table 4
    assert float(found.quantities["speed_b"]) == pytest.approx(19.3, abs=1.0)
    assert found.turns == {}


def test_a_peak_is_where_the_potential_is_least(crashes: Crashes, peak: Peak) -> None:
    """Its slope is nought; the precision is the potential's curvature but for that of residuals."""
    residuals, slopes = crashes.linearised(peak.u[None])
    downhill = peak.u + slopes[0].T @ residuals[0]
    step = np.linalg.solve(peak.precision, downhill)
    assert downhill @ step < 1e-3
    assert peak.potential == pytest.approx(
        (peak.u @ peak.u + peak.residuals @ peak.residuals) / 2, abs=1e-9
    )
    about = peak.u + stats.norm.rvs(size=(200, peak.u.size), random_state=0) @ np.linalg.inv(
        np.linalg.cholesky(peak.precision)
    )
    heights = crashes.residuals(about)
    potential = (np.square(about).sum(axis=1) + np.square(heights).sum(axis=1)) / 2
    assert np.nanmin(potential) > peak.potential - 1e-3


def test_residuals_are_those_of_the_likelihood(crashes: Crashes) -> None:
    """Half their squares are minus the log likelihood, but for a constant."""
    u = np.random.default_rng(0).normal(size=(300, crashes.size))
    log_likelihood, quantities = crashes.at(u)
    residuals = crashes.residuals(u)
    apart = log_likelihood + np.square(residuals).sum(axis=1) / 2
    inside = np.isfinite(log_likelihood)
    np.testing.assert_array_equal(np.isfinite(residuals).all(axis=1), inside)
    assert 0.2 < inside.mean() < 1
    assert (quantities["closing_speed"][~inside] <= 0).any()
    assert (quantities["closing_speed"][inside] > 0).all()
    np.testing.assert_allclose(apart[inside], apart[inside][0], rtol=1e-8)


def test_the_likelihood_of_the_nearest_turns_is_the_highest_of_any_turns() -> None:
    scene = turned_scene()
    every = crashes_of(scene, DEFAULT_RUNG)
    u = np.random.default_rng(0).normal(size=(300, every.size))
    found, quantities = every.of_nearest_turns(u)
    as_written = quantities["predicted/rest_heading_b"] - scene.rest["b"].heading.value
    counts = np.unique(np.rint(as_written[np.isfinite(found)] / (2 * np.pi)))
    assert counts.size > 3
    turned_by = [crashes_of(turned(scene, {"b": int(k)}), DEFAULT_RUNG).at(u)[0] for k in counts]
    np.testing.assert_allclose(found, np.max(turned_by, axis=0), rtol=1e-9)


def test_the_true_numbers_of_turns_are_found_where_none_was_counted() -> None:
    """B turned twice and a bit: the likeliest; thrice fits too."""
    found = peaks(crashes_of(turned_scene(), DEFAULT_RUNG), seed=0)
    assert found[0].turns == {"b": 2}
    assert {"b": 3} in [peak.turns for peak in found]


def test_searches_that_meet_find_the_modes_that_all_of_them_do(monkeypatch) -> None:
    every, at, asked = crashes_of(turned_scene(), DEFAULT_RUNG), Crashes.at, list[int]()

    def counted(self, u, *names):
        asked.append(len(u))
        return at(self, u, *names)

    monkeypatch.setattr(Crashes, "at", counted)
    alone = peaks(every, 0, Search(met=0.0))
    of_alone = sum(asked)
    asked.clear()
    together = peaks(every, 0)
    assert [peak.turns for peak in together] == [peak.turns for peak in alone]
    assert max(one.distance(other) for one, other in zip(together, alone, strict=True)) < 0.1
    assert 0 < sum(asked) < of_alone


def test_turns_of_two_vehicles_are_sought_together() -> None:
    rest = {
        v: replace(
            pose,
            heading=replace(pose.heading, value=pose.heading.value + 2 * np.pi * turns),
            turns_known=False,
        )
        for (v, pose), turns in zip(SCENE.rest.items(), (1, -2), strict=True)
    }
    found = peaks(crashes_of(replace(SCENE, rest=rest), DEFAULT_RUNG), seed=0)
    assert found[0].turns == {"a": -1, "b": 2}


def test_where_no_crash_has_a_likelihood_none_is_answered(crashes: Crashes) -> None:
    class Nowhere(Crashes):
        def with_quantities(self, u):
            residuals, quantities = super().with_quantities(u)
            return np.full_like(residuals, np.nan), quantities

    nowhere = Nowhere(crashes.programs, crashes.data)
    with pytest.raises(Unanswerable, match="no crash of the prior has a likelihood"):
        peaks(nowhere, seed=0)
