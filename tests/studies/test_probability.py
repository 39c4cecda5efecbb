"""Exceedance and likelihood ratio against quadrature, and their errors against repeated runs."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from numpyro import distributions as dist
from scipy import integrate, stats

from retrodict.inference.reconstruct import reconstruct
from retrodict.options import RunOptions
from retrodict.scene.asked import Comparison, Proposition, read_proposition
from retrodict.scene.measured import Measured
from retrodict.scene.priors import of_family, of_python
from retrodict.scene.speed_record import SpeedRecord
from retrodict.studies.draws import NotAnswered
from retrodict.studies.probability import _law_of_prior, likelihood_ratio, probability
from tests.models.closed_form import everything_exact, momentum_and_slide
from tests.shared import wall_by_hand as by_hand
from tests.shared.scenes import collision
from tests.studies import gaussian
from tests.studies.gaussian import MEASURED, PRIOR_SCALE, SD, outcome, speed_draws

SLOW, FAST = read_proposition("speed_b at most 18 m/s"), read_proposition("speed_b at least 21 m/s")


def evidence(low: float, high: float) -> float:
    """∫ likelihood × half-normal prior over a range of speeds, by quadrature."""

    def density(v: float) -> float:
        return stats.norm.pdf(MEASURED, v, SD) * stats.halfnorm.pdf(v, scale=PRIOR_SCALE)

    return integrate.quad(density, max(low, 0.0), min(high, 60.0), epsabs=1e-13, limit=200)[0]


def prior(low: float, high: float) -> float:
    return integrate.quad(stats.halfnorm(scale=PRIOR_SCALE).pdf, max(low, 0.0), high)[0]


@pytest.fixture(scope="module")
def drawn():
    return outcome(speed_b=speed_draws())


@pytest.mark.parametrize(
    "text",
    ["speed_b > 20 m/s", "speed_b < 17 m/s", "19 m/s < speed_b < 21 m/s", "speed_b > 50 mph"],
)
def test_a_probability_is_that_of_quadrature(drawn, text):
    asked = read_proposition(text)
    found = probability(drawn, asked)
    exact = evidence(asked.low, asked.high) / evidence(0, math.inf)
    assert found.value == pytest.approx(exact, abs=4 * found.error)
    assert found.error == pytest.approx(math.sqrt(exact * (1 - exact) / 200_000), rel=0.1)


def test_a_compound_is_the_share_of_its_draws_and_the_law_in_closed_form():
    """Two correlated normal speeds: the difference is normal, "and" is an orthant's probability."""
    rng = np.random.default_rng(5)
    a, b = rng.multivariate_normal([20, 18], [[4, 1.2], [1.2, 1]], (4, 20_000)).transpose(2, 0, 1)
    made = outcome(speed_a=a, speed_b=b)
    law = stats.multivariate_normal([20, 18], [[4, 1.2], [1.2, 1]])
    both = law.cdf([19, 17])
    sides = stats.norm(20, 2).cdf(19), stats.norm(18, 1).cdf(17)
    exact = {
        "speed_a - speed_b > 3 m/s": stats.norm(2, math.sqrt(5 - 2.4)).sf(3),
        "speed_a + speed_b < 36 m/s": stats.norm(38, math.sqrt(5 + 2.4)).cdf(36),
        "speed_a < 19 m/s and speed_b < 17 m/s": both,
        "speed_a < 19 m/s or speed_b < 17 m/s": sum(sides) - both,
    }
    for text, wanted in exact.items():
        found = probability(made, read_proposition(text))
        assert found.value == pytest.approx(wanted, abs=4 * found.error)
    counted = np.mean((a < 19) & ((b < 17) | (a - b > 3)))
    asked = "speed_a < 19 m/s and (speed_b < 17 m/s or speed_a - speed_b > 3 m/s)"
    assert probability(made, read_proposition(asked)).value == counted
    never = probability(made, read_proposition("speed_a > 60 m/s and speed_b > 60 m/s"))
    assert (never.value, never.error) == (0, None)
    assert 0 < never.at_most < 0.001
    with pytest.raises(NotAnswered, match="has no e_m"):
        probability(made, read_proposition("speed_a > 3 m/s or e_m > 0.5"))


def test_a_likelihood_ratio_is_that_of_quadrature(drawn):
    """p(D | first) / p(D | second), each with the prior cut to the proposition."""
    found = likelihood_ratio(drawn, Comparison(SLOW, FAST))
    exact = [evidence(p.low, p.high) / prior(p.low, p.high) for p in (SLOW, FAST)]
    assert found.bound == ""
    assert math.log(found.value) == pytest.approx(
        math.log(exact[0] / exact[1]), abs=4 * found.error
    )
    assert found.error < 0.02
    assert "half-normal, scale 30 m/s" in found.prior


def test_exchanged_propositions_have_the_inverse_ratio(drawn):
    one, other = (likelihood_ratio(drawn, Comparison(*p)) for p in ((SLOW, FAST), (FAST, SLOW)))
    assert one.value * other.value == pytest.approx(1)
    assert one.error == pytest.approx(other.error)


@pytest.mark.slow
def test_the_error_of_a_ratio_is_that_of_repeated_runs():
    runs = [
        likelihood_ratio(outcome(speed_b=speed_draws(seed, 500)), Comparison(SLOW, FAST))
        for seed in range(40)
    ]
    spread = np.std([math.log(run.value) for run in runs], ddof=1)
    assert spread == pytest.approx(np.mean([run.error for run in runs]), rel=0.35)


def test_where_no_draw_holds_a_proposition_there_is_a_bound(drawn):
    asked = read_proposition("speed_b > 40 m/s")
    found = probability(drawn, asked)
    assert (found.value, found.error, found.at_least) == (0, None, 0)
    assert found.at_most == pytest.approx(3 / found.effective, rel=0.01)  # the rule of three
    assert evidence(40, math.inf) / evidence(0, math.inf) < found.at_most
    assert found.few
    ratio = likelihood_ratio(drawn, Comparison(SLOW, asked))
    assert ratio.bound == "at least"
    exact = [evidence(p.low, p.high) / prior(p.low, min(p.high, 200)) for p in (SLOW, asked)]
    assert ratio.value < exact[0] / exact[1]
    assert likelihood_ratio(drawn, Comparison(asked, SLOW)).bound == "at most"


@pytest.mark.slow
def test_bounds_hold_the_probability_as_often_as_they_say():
    """Of a rare proposition, by some draws in each of many runs: Clopper and Pearson's are cautious."""
    asked = read_proposition("speed_b > 24.2 m/s")
    exact = evidence(asked.low, math.inf) / evidence(0, math.inf)
    runs = [probability(outcome(speed_b=speed_draws(seed, 200)), asked) for seed in range(60)]
    assert sum(run.few for run in runs) > 50
    assert np.mean([run.at_most >= exact for run in runs]) >= 0.9
    assert np.mean([run.at_least <= exact for run in runs]) >= 0.9


def test_hardly_a_draw_makes_a_bound_and_not_a_ratio():
    rare = read_proposition("speed_b > 24.2 m/s")
    made = outcome(speed_b=speed_draws(1, 200))
    assert 0 < probability(made, rare).value < 10 / 800
    found = likelihood_ratio(made, Comparison(SLOW, rare))
    assert (found.bound, found.error) == ("at least", None)
    exact = [evidence(p.low, p.high) / prior(p.low, min(p.high, 300)) for p in (SLOW, rare)]
    assert found.value < exact[0] / exact[1]


def test_what_cannot_be_compared_is_refused(drawn):
    never = Proposition("speed_b", -math.inf, -1.0, "speed_b < -1 m/s")
    with pytest.raises(NotAnswered, match="excludes"):
        likelihood_ratio(drawn, Comparison(never, FAST))
    far = [read_proposition(t) for t in ("40 m/s < speed_b < 50 m/s", "speed_b > 50 m/s")]
    with pytest.raises(NotAnswered, match="nearer to the answer"):
        likelihood_ratio(drawn, Comparison(*far))
    with pytest.raises(NotAnswered, match="has no e_m"):
        probability(drawn, read_proposition("e_m > 0.5"))


def test_a_measured_speed_is_the_prior_of_the_model():
    """A's speed, 20 ± 2 m/s: where nothing else speaks of it, no proposition is favoured."""
    scene = outcome().scene
    speed = Measured(20.0, 2.0)
    scene = replace(
        scene, approach=scene.approach | {"a": replace(scene.approach["a"], speed=speed)}
    )
    draws = np.random.default_rng(0).normal(20, 2, (4, 20_000))
    made = replace(outcome(speed_a=draws), scene=scene)
    pair = [read_proposition(t) for t in ("speed_a < 19 m/s", "speed_a > 21 m/s")]
    found = likelihood_ratio(made, Comparison(*pair))
    assert found.prior_first == pytest.approx(stats.norm.cdf(-0.5))
    assert math.log(found.value) == pytest.approx(0, abs=4 * found.error)


def test_a_recorded_speed_is_the_prior_over_all_moments_of_the_impact():
    """Braking from 22 to 18 m/s in the window: flat-topped, its edges blurred by 0.4 m/s."""
    record = SpeedRecord((-1.0, 0.0), (22.0, 18.0), -1.0, 0.0, 0.4)
    scene = outcome().scene
    own = replace(scene.approach["a"], speed=Measured(*record.moments), record=record)
    rng = np.random.default_rng(0)
    draws = rng.uniform(18, 22, (4, 20_000)) + 0.4 * rng.standard_normal((4, 20_000))
    made = replace(
        outcome(speed_a=draws), scene=replace(scene, approach=scene.approach | {"a": own})
    )
    pair = [read_proposition(t) for t in ("speed_a < 18 m/s", "speed_a > 21 m/s")]
    found = likelihood_ratio(made, Comparison(*pair))
    below = [
        integrate.quad(lambda v, at=at: stats.norm.cdf((at - v) / 0.4) / 4, 18, 22)[0]
        for at in (18, 21)
    ]
    assert found.prior_first == pytest.approx(below[0], abs=1e-5)
    assert found.prior_second == pytest.approx(1 - below[1], abs=1e-5)
    assert math.log(found.value) == pytest.approx(0, abs=4 * found.error)


def test_an_exact_speed_is_not_compared():
    scene = outcome().scene
    known = replace(scene.approach["a"], speed=gaussian.exact(20.0))
    made = replace(
        outcome(speed_b=speed_draws()), scene=replace(scene, approach=scene.approach | {"a": known})
    )
    pair = [read_proposition(t) for t in ("speed_a < 19 m/s", "speed_a > 21 m/s")]
    with pytest.raises(NotAnswered, match="exact"):
        likelihood_ratio(made, Comparison(*pair))


def test_the_prior_before_a_skid_is_that_of_the_speed_and_of_what_the_skid_took():
    """v0² = v² + K with v half-normal: P(v0 < x) = E[P(v² < x² - K)], by simulation."""
    scene = outcome().scene
    rng = np.random.default_rng(1)
    skid = replace(scene.approach["b"], skid=Measured(12.0, 1.0, "lognormal"))
    v, K = np.abs(rng.normal(0, 30, (1, 500))), rng.normal(120, 8, (1, 500))
    made = outcome(speed_b=speed_draws(), travelling_speed_b=np.sqrt(speed_draws() ** 2 + 120))
    made.idata["prior"] = _prior(v, K)
    made = replace(made, scene=replace(scene, approach=scene.approach | {"b": skid}))
    pair = [
        read_proposition(t) for t in ("travelling_speed_b < 22 m/s", "travelling_speed_b > 23 m/s")
    ]
    found = likelihood_ratio(made, Comparison(*pair))
    many = np.sqrt(rng.normal(0, 30, 400_000) ** 2 + rng.normal(120, 8, 400_000))
    assert found.prior_first == pytest.approx((many < 22).mean(), abs=0.004)
    assert found.prior_second == pytest.approx((many > 23).mean(), abs=0.004)


def _prior(v, K):
    return xr.DataTree(
        xr.Dataset(
            {
                "speed_b": (("chain", "draw"), v),
                "travelling_speed_b": (("chain", "draw"), np.sqrt(v**2 + K)),
            }
        )
    )


@pytest.mark.slow
def test_both_are_those_of_quadrature_in_a_reconstruction():
    """Momentum and a straight slide: four rest coordinates decide the speed; Sobol points."""
    scene = everything_exact(collision(share=0.0, berm=False))
    z = stats.norm.ppf(stats.qmc.Sobol(4, rng=np.random.default_rng(0)).random_base2(16))
    speed, log_weight = momentum_and_slide(scene, z.reshape(-1, 2, 2))
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    middle, sd = weight @ speed, np.sqrt(weight @ (speed - weight @ speed) ** 2)
    low, high = (f"{middle + k * sd:.3f} m/s" for k in (-0.5, 1.0))
    slow, fast = (read_proposition(f"speed_b {t}") for t in (f"at most {low}", f"at least {high}"))

    made = reconstruct(
        scene, RunOptions(model="momentum+slide", method="importance", draws=5000), pictured=False
    )
    exact = [weight @ p.holds(speed) for p in (slow, fast)]
    for asked, wanted in zip((slow, fast), exact, strict=True):
        found = probability(made, asked)
        assert found.value == pytest.approx(wanted, abs=4 * found.error)
        assert found.error < 0.01
    priors = [prior(p.low, min(p.high, 300.0)) for p in (slow, fast)]
    found = likelihood_ratio(made, Comparison(slow, fast))
    wanted = np.log(exact[0] / exact[1] / (priors[0] / priors[1]))
    assert math.log(found.value) == pytest.approx(wanted, abs=4 * found.error)


@pytest.mark.parametrize("family", ["normal", "lognormal", "uniform", "python"])
def test_prior_odds_are_by_the_law_that_the_user_gives(family):
    """The probability of a speed below each quantile of the law that the model samples."""
    named = "normal" if family == "python" else family
    own, numbers = by_hand.FAMILIES[named]["speed_a"]
    prior = of_family("speed_a", own, numbers, "a test")
    if family == "python":
        prior = of_python("speed_a", dist.Normal(*numbers.values()), "normal")
    wanted = np.array([0.01, 0.3, 0.9])
    speeds = by_hand.law("speed_a", own, numbers)(wanted)
    found = [float(_law_of_prior("speed_a", prior).cdf(speed)) for speed in speeds]
    assert found == pytest.approx(wanted, abs=1e-9)
    with pytest.raises(NotAnswered, match="is fixed by its prior"):
        _law_of_prior("speed_a", of_family("speed_a", "fixed", {"value": 10.0}, "a test"))
