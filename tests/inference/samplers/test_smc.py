"""Tempered SMC against posteriors of known shape: evidence, moments, bends, and two modes apart."""

from collections.abc import Callable
from dataclasses import replace
from time import sleep
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats
from scipy.special import logsumexp

from retrodict.inference.errors import Interrupted
from retrodict.inference.samplers import Draws, Task, smc
from retrodict.inference.samplers.proposal import LIGHT, Proposal

SIZE = 6
START = replace(Proposal.first(SIZE, LIGHT), sd=np.full(SIZE, 1.25))


def drawn(density: Callable[[np.ndarray], np.ndarray], **changes) -> Draws:
    posterior = SimpleNamespace(log_density=density, size=SIZE)
    task = {"chains": 4, "draws": 512, "warmup": 0, "seed": 1, "progress": lambda *_: None}
    return smc.tempered(Task(posterior, **(task | changes)), START)  # type: ignore[arg-type]


def test_a_narrow_normal_far_from_the_start_has_its_evidence_and_moments() -> None:
    rng = np.random.default_rng(0)
    root = np.linalg.qr(rng.normal(size=(SIZE, SIZE)))[0] * np.geomspace(0.02, 1, SIZE)
    law = stats.multivariate_normal(rng.normal(size=SIZE), root @ root.T)
    found = drawn(lambda w: law.logpdf(w) + 3)
    assert found.complete
    assert not found.faults
    assert found.attributes["log_evidence"] == pytest.approx(3, abs=0.25)
    w = found.w.reshape(-1, SIZE)
    off = np.linalg.solve(root, (w - law.mean).T)
    assert np.abs(off.mean(axis=1)).max() < 0.12
    assert off.std(axis=1) == pytest.approx(np.ones(SIZE), abs=0.12)


def test_two_modes_keep_their_weights() -> None:
    centres, weights = np.array([[-2.0], [2.0]]) * np.eye(SIZE)[0], np.log([0.25, 0.75])

    def density(w: np.ndarray) -> np.ndarray:
        each = [stats.norm.logpdf(w, centre, 0.2).sum(axis=1) for centre in centres]
        return logsumexp(np.array(each).T + weights, axis=1)

    found = drawn(density)
    assert np.mean(found.w[..., 0] > 0) == pytest.approx(0.75, abs=0.08)
    assert found.attributes["log_evidence"] == pytest.approx(0, abs=0.25)


def test_a_ridge_that_bends_is_followed() -> None:
    """w_1 is normal about w_0²: its mean is 1, if it starts wide enough to reach to 9."""

    def density(w: np.ndarray) -> np.ndarray:
        constrained = stats.norm.logpdf(w[:, 1], w[:, 0] ** 2, 0.1)
        return constrained + stats.norm.logpdf(np.delete(w, 1, axis=1)).sum(axis=1)

    w = 2 * drawn(lambda half: density(2 * half)).w  # starts twice as wide
    assert w[..., 0].std() == pytest.approx(1, abs=0.15)
    assert w[..., 1].mean() == pytest.approx(1, abs=0.25)


def test_where_there_is_no_density_no_draw_lies() -> None:
    def density(w: np.ndarray) -> np.ndarray:
        return np.where(w[:, 0] > 0, stats.norm.logpdf(w).sum(axis=1), np.nan)

    found = drawn(density)
    assert (found.w[..., 0] > 0).all()
    assert found.attributes["log_evidence"] == pytest.approx(np.log(0.5), abs=0.15)


def far(distance: float) -> Callable[[np.ndarray], np.ndarray]:
    """The log density of a narrow normal at a distance along each coordinate."""
    return lambda w: stats.norm.logpdf(w, distance, 0.3).sum(axis=1)


def test_a_posterior_far_from_the_start_is_found() -> None:
    found = drawn(far(3.0))
    assert not found.faults
    assert found.attributes["log_evidence"] == pytest.approx(0, abs=0.15)
    assert found.w.mean(axis=(0, 1)) == pytest.approx(np.full(SIZE, 3.0), abs=0.05)
    assert found.w.std(axis=(0, 1)) == pytest.approx(np.full(SIZE, 0.3), rel=0.1)


def test_a_posterior_that_is_not_where_it_was_sought_is_a_fault() -> None:
    found = drawn(far(6.0))
    assert any("from where it was sought" in fault for fault in found.faults)
    assert found.more is None


def test_populations_too_small_to_agree_on_the_evidence_are_a_fault() -> None:
    found = drawn(far(6.0), draws=8, seed=2)
    assert any("disagree on the log evidence" in fault for fault in found.faults)


def test_more_draws_are_those_of_the_same_populations_moved_on() -> None:
    found = drawn(lambda w: stats.norm.logpdf(w).sum(axis=1), draws=64)
    assert found.more is not None
    again = found.more()
    assert again.w.shape == (4, 128, SIZE)
    assert again.attributes["log_evidence"] == found.attributes["log_evidence"]
    assert np.isin(found.w, again.w).all()


def test_an_interrupt_before_a_population_is_done_keeps_nothing() -> None:
    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    def slowly(w: np.ndarray) -> np.ndarray:
        sleep(0.05)
        return stats.norm.logpdf(w).sum(axis=1)

    with pytest.raises(Interrupted):
        drawn(slowly, progress=stop)
