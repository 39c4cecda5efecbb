"""Priors and likelihood terms given in Python: what they do is what quadrature says they do."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from numpyro import distributions as dist
from scipy import stats

import retrodict as rd
from retrodict.inference.density import disk_cache
from retrodict.inference.errors import Unanswerable
from retrodict.inference.own import WITH_QUANTILE, with_own
from retrodict.inference.points import answer
from tests.shared import wall_by_hand as by_hand

PRIORS = by_hand.FAMILIES["normal"]
SCENE = by_hand.scene(PRIORS)
SAID, SURE = 15.0, 0.8  # what a witness said of the speed, m/s, and the standard deviation
WITNESS = {"witness": lambda q: dist.Normal(SAID, SURE).log_prob(q["speed_a"])}


def of_speed(v: np.ndarray) -> np.ndarray:
    return stats.norm(SAID, SURE).logpdf(v)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["importance", "nuts"])
def test_a_witness_moves_the_posterior_as_quadrature_says(method: str, tmp_path: Path) -> None:
    expected = by_hand.posterior(SCENE, PRIORS, of_speed)
    without = by_hand.posterior(SCENE, PRIORS)
    assert abs(expected.mean["speed_a"] - without.mean["speed_a"]) > 0.3 * without.sd["speed_a"]
    result = rd.reconstruct(SCENE, model=by_hand.MODEL, method=method, extra=WITNESS)
    assert result.checks.passed, result.checks.reasons
    assert result.outcome.settings["method"] == method
    posterior, ess = result.idata["posterior"], result.checks.min_ess_bulk
    for name in ("speed_a", "e", "e_m", "mu"):
        found = np.asarray(posterior[name])
        sd = expected.sd[name]
        assert found.mean() == pytest.approx(expected.mean[name], abs=4.5 * sd / math.sqrt(ess)), (
            name
        )
        assert found.std() == pytest.approx(sd, rel=4.5 / math.sqrt(ess)), name
    said = np.asarray(result.idata["log_likelihood"]["own_witness"])
    np.testing.assert_allclose(said, of_speed(np.asarray(posterior["speed_a"])), rtol=1e-9)
    if method == "importance":
        stats_ = result.idata["sample_stats"].attrs
        error = 5 * stats_["log_evidence_sd"]
        assert stats_["log_evidence"] == pytest.approx(math.log(expected.evidence), abs=error)
        page = result.report(tmp_path / "report.html").read_text("utf-8")
        assert "the likelihood term witness: of the user&#39;s own" in page.replace("'", "&#39;")
        stored = rd.load_result(result.save(tmp_path / "out"))
        assert any("the likelihood term witness" in note for note in stored.outcome.notes)
        with pytest.raises(ValueError, match=r'had extra\["witness"\] of the user'):
            rd.reconstruct(stored.scene, model=by_hand.MODEL, method=method)


def test_a_distribution_of_numpyro_is_the_prior() -> None:
    numbers = PRIORS["e"][1]
    scene = with_own(
        by_hand.scene(PRIORS), {"e": dist.TruncatedNormal(*numbers.values(), low=0.0, high=1.0)}
    )
    expected = by_hand.posterior(SCENE, PRIORS)
    estimate = answer(scene, by_hand.MODEL)
    mean, error = estimate.weighted.mean(estimate.quantities["e"])
    assert mean == pytest.approx(expected.mean["e"], abs=5 * error)
    assert "Truncated(Normal(loc=0.1, scale=0.2), low=0, high=1)" in scene.priors["e"].text
    assert "the user's own, given in Python" in scene.priors["e"].reason


@pytest.mark.parametrize("name", WITH_QUANTILE)
def test_every_distribution_that_is_named_has_a_quantile(name: str) -> None:
    numbers: dict[str, Any] = {
        "AsymmetricLaplace": (0.3, 0.1, 1.0), "Exponential": (3.0,), "HalfCauchy": (0.2,),
        "HalfNormal": (0.2,), "LogNormal": (-1.0, 0.5), "LogUniform": (0.1, 0.6), "Uniform": (0.1, 0.6),
    }  # fmt: skip
    law = getattr(dist, name)(*numbers.get(name, (0.3, 0.2)))
    assert with_own(SCENE, {"e": law}).priors["e"].overridden


@pytest.mark.parametrize(
    ("priors", "said"),
    [
        ({"e": dist.Gamma(2.0, 3.0)}, "Gamma has no quantile"),
        ({"e": dist.Normal(jnp.zeros(2), 1.0)}, "no distribution of one number"),
        ({"e": 0.3}, "no distribution of one number"),
        ({"e": dist.Normal(30.0, 1.0)}, "next to no probability between 0 and 1"),
        ({"e": dist.Delta(1.3)}, "next to no probability between 0 and 1"),
        ({"restitution": dist.Normal(0.1, 1.0)}, "is none of speed_a"),
        ({"speed_b": dist.Normal(10.0, 1.0)}, "no vehicle B"),
    ],
)
def test_a_prior_that_cannot_be_used_is_refused_in_one_line(priors: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said) as refused:
        rd.reconstruct(SCENE, model=by_hand.MODEL, priors=priors)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("term", "said"),
    [
        (lambda q: q["speed_c"], "no quantity 'speed_c'; it is given the quantities"),
        pytest.param(
            lambda q: jnp.log(-jnp.abs(q["e"])),
            r"not a number \(NaN\) at",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            lambda q: jnp.where(q["e"] > 2, 0.0, -jnp.inf),
            "infinite at every one",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            lambda q: jnp.array([1.0, 2.0]) * q["e"],
            r"array of shape \(2,\)",
            marks=pytest.mark.slow,
        ),
        (lambda q: math.log(q["e"]), "write it with jax.numpy"),
        pytest.param(lambda q: "high", "cannot be computed", marks=pytest.mark.slow),
    ],
)
def test_a_term_that_is_no_number_is_refused_in_one_line(term: Any, said: str) -> None:
    with pytest.raises(Unanswerable, match=said) as refused:
        rd.reconstruct(SCENE, model=by_hand.MODEL, method="importance", extra={"witness": term})
    assert "\n" not in str(refused.value)
    assert 'extra["witness"]' in str(refused.value)


@pytest.mark.parametrize("name", ["<b>", "", "a/b", "1st", "x" * 41])
def test_a_name_of_a_term_is_a_word(name: str) -> None:
    with pytest.raises(ValueError, match="cannot name a term"):
        rd.reconstruct(SCENE, model=by_hand.MODEL, extra={name: lambda q: 0.0})
    with pytest.raises(ValueError, match="is no function"):
        rd.reconstruct(SCENE, model=by_hand.MODEL, extra={"witness": 3.0})


@pytest.mark.slow
def test_programs_with_the_users_code_are_not_kept_on_disk(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def saved(*_: object) -> None:
        raise AssertionError("a program was saved")

    monkeypatch.setattr(disk_cache, "save", saved)
    monkeypatch.setattr(disk_cache, "load", saved)
    extra = {"own": lambda q: -(((q["speed_a"] - 15.0) / 2.0) ** 2) / 2}
    assert answer(with_own(SCENE, extra=extra), by_hand.MODEL).checks.passed


def test_a_method_without_a_likelihood_refuses_a_term() -> None:
    with pytest.raises(ValueError, match="no likelihood to which a term of your own"):
        rd.reconstruct(SCENE, model=by_hand.MODEL, method="linear", extra=WITNESS)


def test_changes_of_the_scene_file_keep_what_is_the_users_own() -> None:
    scene = rd.load_scene("examples/brach-1977/scene.toml")
    own = with_own(scene, {"e": dist.Beta(2.0, 9.0)}, WITNESS)
    changed = own.change({"vehicles.A.approach.speed": "50 ± 1 mph"})
    assert changed.extra == own.extra
    assert changed.priors["e"] is own.priors["e"]
    head = own.to_toml().splitlines()[0]
    assert "the prior of e as it is" in head
    assert "the term witness of the user's own" in head
    assert rd.parse_scene(own.to_toml(), "again").priors["e"] == scene.priors["e"]
