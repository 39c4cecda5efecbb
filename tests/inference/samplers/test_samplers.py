"""The methods beside NUTS: exact ones agree with it, approximations say what they are."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.outcome import Outcome
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.samplers import METHODS, Draws, Task, importance, psis
from retrodict.inference.samplers.proposal import HEAVY, LIGHT, Proposal, Tails
from retrodict.options import DEFAULT_RUNG, RunOptions
from tests.shared.scenes import collision

SCENE = collision(share=0.0, interlocked=True)
OWN = ("speed_b", "e", "e_m", "mu", "omega_b")


@pytest.fixture(scope="module")
def reference() -> Outcome:
    return reconstruct(SCENE, RunOptions(draws=2000, seed=3))


def _apart(found: Outcome, reference: Outcome, name: str) -> float:
    """Difference of the means in standard errors of both."""
    error, means = 0.0, []
    for outcome in (found, reference):
        draws = outcome.idata["posterior"][name].values
        means.append(draws.mean())
        error += draws.var() / outcome.checks.min_ess_bulk
    return float(abs(means[0] - means[1]) / np.sqrt(error))


@pytest.fixture(scope="module")
def sliding() -> Outcome:
    """Of the same rest poses, where friction may end the sliding and not reverse it."""
    return reconstruct(collision(share=0.0), RunOptions(draws=2000, seed=3))


@pytest.mark.slow
@pytest.mark.parametrize("method", ["importance", "smc"])
@pytest.mark.parametrize("of", ["reference", "sliding"])
def test_exact_methods_agree_with_nuts(
    method: str, of: str, request: pytest.FixtureRequest
) -> None:
    reference: Outcome = request.getfixturevalue(of)
    found = reconstruct(reference.scene, RunOptions(method=method, seed=3))
    assert found.checks.passed, found.checks.reasons
    assert found.checks.divergences is None
    assert METHODS[method].exact
    for name in OWN:
        assert _apart(found, reference, name) < 4, name
        draws, sure = (o.idata["posterior"][name].values for o in (found, reference))
        assert draws.std() == pytest.approx(sure.std(), rel=0.1)


@pytest.mark.slow
def test_tempering_finds_the_evidence_that_importance_sampling_finds(reference: Outcome) -> None:
    found = reconstruct(SCENE, RunOptions(method="smc", seed=4)).idata["sample_stats"].attrs
    posterior = prepare(SCENE, DEFAULT_RUNG)
    n = posterior.size
    w = np.random.default_rng(0).standard_normal((20_000, n))
    weight = np.exp(posterior.log_density(w) - stats.norm.logpdf(w).sum(axis=1))
    assert found["log_evidence"] == pytest.approx(np.log(weight.mean()), abs=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["linear", "laplace", "monte-carlo"])
def test_approximations_say_that_they_are(method: str, reference: Outcome) -> None:
    found = reconstruct(SCENE, RunOptions(method=method))
    assert any("an approximation" in note for note in found.notes)
    assert found.settings["method"] == method
    # far from bounds and with little curvature they are not far off
    speed, sure = (o.idata["posterior"]["speed_b"].values for o in (found, reference))
    assert abs(speed.mean() - sure.mean()) < 0.5 * sure.std()


@pytest.mark.parametrize(
    ("shift", "spread", "off"),
    [(0, 1, 0), (0.1, 1.1, 0), (0.2, 1, 0.2), (0.5, 1, 0.5), (0, 2, 1), (np.nan, 1, 1)],
)
def test_an_approximation_is_held_against_the_weighted_posterior(
    shift: float, spread: float, off: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The posterior of e is standard normal, as weighted draws of a wider one have it."""
    rng = np.random.default_rng(0)
    wide = rng.normal(0, 2, 20_000)
    log_weight = stats.norm.logpdf(wide) - stats.norm.logpdf(wide, 0, 2)
    drawn = (wide, log_weight, {"speed_b": wide, "e": wide, "measured": wide}, wide.size)
    monkeypatch.setattr(importance, "weighted_points", lambda *_: drawn)
    steady = rng.normal(0, 1, 20_000)
    of_e = {"speed_b": steady, "e": shift + spread * steady, "measured": steady}
    task = Task(None, 1, steady.size, 0, 0, lambda *_: None)  # type: ignore[arg-type]
    found = importance.disagreements(of_e, task)
    assert len(found) == bool(off)
    if off and np.isfinite(shift):
        assert found[0].startswith("restitution e")
        assert float(found[0].split("off by ")[1].split()[0]) == pytest.approx(off, abs=0.03)


@pytest.mark.slow
def test_linear_is_the_law_of_propagation(reference: Outcome) -> None:
    """Draws are normal about what the measured values give: no skewness is left."""
    draws = (
        reconstruct(SCENE, RunOptions(method="linear", draws=3000)).idata["posterior"]["e_m"].values
    )
    assert abs(stats.skew(draws.ravel())) < 0.1
    assert stats.skew(
        reconstruct(SCENE, RunOptions(method="monte-carlo", draws=3000))
        .idata["posterior"]["e_m"]
        .values.ravel()
    ) == pytest.approx(0.2, abs=0.2)


def test_weights_of_a_narrow_proposal_are_refused() -> None:
    """A normal half as wide as its target: the weights have infinite variance, and k shows it."""
    w = np.random.default_rng(1).normal(0, 0.5, (4000, 5))
    log_weight = stats.norm.logpdf(w).sum(axis=1) - stats.norm.logpdf(w, 0, 0.5).sum(axis=1)
    quantities = psis.judged(psis.smoothed(log_weight)[1])
    assert quantities["attributes"]["pareto_k"] > psis.MAX_PARETO_K
    assert "Pareto k" in quantities["faults"][0]
    for sd in (0.4, 0.5):  # narrower than the proposal, and the proposal itself
        wide = stats.norm.logpdf(w, 0, sd).sum(axis=1) - stats.norm.logpdf(w, 0, 0.5).sum(axis=1)
        assert psis.judged(psis.smoothed(wide)[1])["faults"] == ()


def test_resampling_takes_each_draw_as_often_as_its_weight_asks() -> None:
    share = np.array([0.5, 0.0, 0.25, 0.25])
    index = psis.resampled(share, share.size, np.random.default_rng(0))
    assert sorted(index) == [0, 0, 2, 3]
    assert (np.diff(index) >= 0).all()


@pytest.mark.parametrize("of_cube", [False, True])
@pytest.mark.parametrize("tails", [LIGHT, HEAVY])
def test_proposals_have_the_density_that_they_are_drawn_from(tails: Tails, of_cube: bool) -> None:
    """Against SciPy's; and weighted by it, draws find the volume and the moments of a normal."""
    middle, root = np.array([1.0, -2.0, 0.5]), np.array([[2.0, 0, 0], [0.5, 1, 0], [-1, 0.3, 0.4]])
    _, sd, axes = np.linalg.svd(root.T)
    proposal = Proposal(middle, axes.T, sd, tails, 100.0)
    rng = np.random.default_rng(0)
    w = proposal.at(rng.random((20_000, 5))) if of_cube else proposal.draw(20_000, rng)
    normal = stats.multivariate_normal(middle, root @ root.T)
    wide = sd * np.clip(np.sqrt(sd), 1, 1.25)  # wider than the posterior where it is wide
    z = (w - middle) @ axes.T / wide
    share, freedom = tails
    student = stats.multivariate_t(np.zeros(3), np.eye(3), df=freedom).pdf(z)
    density = ((1 - share) * stats.norm.pdf(z).prod(axis=1) + share * student) / wide.prod()
    np.testing.assert_allclose(proposal.log_density(w), np.log(density), rtol=1e-9, atol=1e-9)
    weight = normal.pdf(w) / density
    error = weight.std() / np.sqrt(weight.size)
    assert abs(weight.mean() - 1) < 4 * error
    covariance = (w - middle).T @ ((w - middle) * weight[:, None]) / weight.size
    np.testing.assert_allclose(covariance, root @ root.T, atol=0.12)


@pytest.mark.parametrize("wide", [1.6, 2.5])
def test_a_skew_that_the_mode_does_not_show_is_found(wide: float) -> None:
    """A normal in 25 coordinates, of one of which the right half is wider.

    Pareto k and the effective share of the first draws let that pass in every second run, with means
    off by 0.1 sd.
    """

    def evaluate(w: np.ndarray) -> tuple[np.ndarray, dict]:
        first = np.where(w[:, 0] > 0, w[:, 0] / wide, w[:, 0])
        return -(first**2 + (w[:, 1:] ** 2).sum(axis=1)) / 2, {}

    toy = SimpleNamespace(size=25, evaluate=evaluate, peak=None)
    mean, sd = (wide - 1) * np.sqrt(2 / np.pi), np.sqrt((1 - 2 / np.pi) * (wide - 1) ** 2 + wide)
    off = []
    for seed in range(10):
        w, log_weight, _, _ = importance.weighted_points(toy, 2000, np.random.default_rng(seed))
        share, k = psis.smoothed(log_weight)
        assert k < psis.MAX_PARETO_K
        off.append((share @ w[:, 0] - mean) / sd)
    assert abs(np.mean(off)) < 0.03
    assert np.std(off) < 0.05


@pytest.mark.slow
def test_importance_finds_back_from_a_poor_proposal_or_says_that_it_cannot() -> None:
    """Coordinates f times as wide divide the evidence by f^n, and change nothing else."""
    posterior = prepare(SCENE, DEFAULT_RUNG)

    def drawn(factor: float) -> Draws:
        whitening = posterior.transform.whitening
        whitening = whitening._replace(spread=factor * np.asarray(whitening.spread))
        narrow = replace(posterior, transform=posterior.transform._replace(whitening=whitening))
        return METHODS["importance"].draw(Task(narrow, 4, 500, 0, 0, lambda *_: None))

    whole = drawn(1.0).attributes
    outcomes = {}
    for factor in (0.02, 0.005, 0.001):
        found = drawn(factor)
        outcomes[factor] = found.faults
        if found.faults:
            assert "Pareto k" in found.faults[0]
            continue
        evidence, error = found.attributes["log_evidence"], found.attributes["log_evidence_sd"]
        error = np.hypot(error, whole["log_evidence_sd"])
        expected = whole["log_evidence"] - posterior.size * np.log(factor)
        assert evidence == pytest.approx(expected, abs=4 * error)
    assert not outcomes[0.02]
    assert outcomes[0.001]


def test_importance_goes_on_to_more_points_and_then_ends() -> None:
    """Of twice as many it keeps twice the draws; of more it chooses the same number."""
    posterior = prepare(SCENE, DEFAULT_RUNG)
    drawn = METHODS["importance"].draw(Task(posterior, 2, 100, 0, 0, lambda *_: None))
    kept = [drawn.w.shape[1]]
    while drawn.more:
        before, drawn = drawn, drawn.more()
        kept.append(drawn.w.shape[1])
        assert drawn.attributes["log_evidence_sd"] < before.attributes["log_evidence_sd"]
        assert drawn.quantities is not None
        assert all(
            len(values) == drawn.w.shape[0] * kept[-1] for values in drawn.quantities.values()
        )
    doublings = int(np.log2(importance._MOST))
    assert kept == [100, *[200] * doublings]


def test_an_unknown_method_is_named() -> None:
    with pytest.raises(ValueError, match="method is one of nuts, importance"):
        reconstruct(SCENE, RunOptions(method="guess"))


def test_a_tail_of_copies_cannot_be_relied_on() -> None:
    """Draws that were resampled from a few: arviz-stats fits no tail to equal weights."""
    found, k = psis.smoothed(np.append(np.linspace(-3, 0, 1500), np.full(500, 1.0)))
    assert found.sum() == pytest.approx(1)
    assert psis.judged(k)["faults"]


def test_draws_that_all_lie_outside_the_support_are_refused() -> None:
    nowhere = np.full(1000, -np.inf)
    found, k = psis.smoothed(nowhere)
    assert found.sum() == pytest.approx(1)
    assert "Pareto k inf" in psis.judged(k)["faults"][0]
    assert psis.log_mean(nowhere) == (-np.inf, np.inf)
