"""The ladder: what fits, which rung is chosen, and what other priors would say."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from retrodict.models import rungs_for

from retrodict.inference import Unanswerable
from retrodict.inference.outcome import Mode
from retrodict.inference.samplers.psis import log_mean
from retrodict.scene import load_scene, parse_scene
from retrodict.scene.write import scene_toml
from retrodict.studies import ladder as ladders
from retrodict.studies.comparison import FACTOR, SHARE
from retrodict.studies.ladder import chosen, ladder, refusals, run_rung
from tests.report.conftest import make_outcome, make_scene
from tests.shared.scenes import collision, rolls
from tests.studies.made_up import ladder_of, step

ASKED = ("speed_b",)
PAPER = Path(__file__).parents[2] / "examples" / "brach-1977" / "scene.toml"


def choice(*steps):
    return chosen(steps, ASKED)[1]


def test_the_lowest_rung_that_answers_alike_is_chosen() -> None:
    assert choice(step("low", 19.0), step("middle", 19.1), step("full", 19.0)) == "low"


@pytest.mark.parametrize(
    ("wrong", "word"),
    [
        ({"median": 19.0 + 1.01 * SHARE}, "shifts"),
        ({"median": 19.0, "sd": 1.01 * FACTOR}, "uncertainty"),
        ({"median": 19.0, "sd": 0.99 / FACTOR}, "uncertainty"),
        ({"median": 19.0, "probability": 0.009}, "does not fit"),
        ({"median": 19.0, "reasons": ("R-hat",)}, "not to be relied on"),
    ],
)
def test_a_rung_that_will_not_do_is_passed_over_with_the_reason(wrong, word) -> None:
    judged, choice, _ = chosen(
        (step("low", **wrong), step("middle", 19.0), step("full", 19.0)), ASKED
    )
    assert choice == "middle"
    assert word in judged[0].verdict


def test_where_it_is_in_doubt_going_on_together_comes_first_and_what_it_changes_is_said() -> None:
    together = replace(step("low", 19.0), name="joined+slide", below=())
    apart = replace(step("full", 19.5), name="planar+wheels", below=())
    _, choice, reason = chosen((together, apart), ASKED)
    assert choice == "joined+slide"
    assert "Had the vehicles parted: planar+wheels shifts the impact speed of B by 0.50 " in reason
    unfit = replace(step("low", 19.0, probability=1e-4), name="joined+slide", below=())
    _, choice, reason = chosen((unfit, apart), ASKED)
    assert choice == "planar+wheels"
    assert "No model of vehicles that had gone on together can be relied on and fits" in reason


def test_a_scene_in_doubt_allows_both_kinds_of_models() -> None:
    text = PAPER.read_text("utf-8").replace("[impact]\n", '[impact]\ntogether = "perhaps"\n')
    scene = parse_scene(text, "paper")
    assert scene.question == ("speed_b",)
    names = ladders.allowed(scene)
    assert names[:2] == ["joined+slide", "joined-body+wheels"]
    assert set(names[2:]) <= set(rungs_for(load_scene(PAPER)))
    assert names[2:]
    assert parse_scene(scene_toml(scene), "paper").contact.perhaps_together


def test_share_and_factor_are_the_reader_s() -> None:
    steps = step("low", 19.0), step("full", 19.4, 1.4)
    assert chosen(steps, ASKED)[1] == "full"
    _, choice, reason = chosen(steps, ASKED, share=0.3, factor=1.5)
    assert choice == "low"
    assert "within 0.3 standard deviations" in reason
    assert "a factor of 1.5 in width" in reason


@pytest.mark.parametrize("wrong", [{"share": 0.0}, {"factor": 1.0}, {"share": np.nan}])
def test_a_share_or_factor_out_of_range_is_refused(wrong) -> None:
    with pytest.raises(ValueError, match="share is above 0 and factor above 1"):
        ladder(make_scene(), **wrong)


def test_shift_is_in_standard_deviations_of_the_fuller_rung() -> None:
    """A quarter of the wider rung's sd, which is more than a quarter of the narrower's."""
    shift = 1.1 * SHARE
    assert choice(step("low", 19.0, 1.0), step("full", 19.0 + shift, 1.2)) == "low"
    assert choice(step("low", 19.0, 1.2), step("full", 19.0 + shift, 1.0)) == "full"


def test_a_fuller_rung_that_does_not_fit_does_not_speak() -> None:
    assert choice(step("low", 19.0), step("full", 25.0, probability=1e-4)) == "low"


def test_a_fuller_rung_that_is_not_enough_itself_does_not_speak() -> None:
    judged, choice, reason = chosen(
        (step("low", 19.0), step("middle", 19.5), step("full", 19.0)), ASKED
    )
    assert choice == "low"
    assert judged[1].verdict.startswith("not enough: full shifts")
    assert [s.enough for s in judged] == [True, False, True]
    assert "The largest change: full shifts" in reason


def test_rungs_side_by_side_do_not_speak_of_each_other() -> None:
    assert choice(step("low", 19.0), step("middle", 25.0, below=()), step("full", 19.0)) == "low"


def test_where_none_fits_none_is_chosen_and_it_is_said() -> None:
    found = ladder_of(step("low", 19.0, probability=1e-5), step("full", 19.0, probability=1e-4))
    assert found.choice is None
    assert "No rung fits" in found.reason


@pytest.mark.parametrize("other", [15.0, 60.0, np.inf])
def test_other_priors_agree_with_the_product_of_normals(other) -> None:
    rng = np.random.default_rng(1)
    precision = 1 / 2.5**2 + 30.0**-2  # likelihood 20 ± 2.5, far from nought
    speed = rng.normal(20 / 2.5**2 / precision, precision**-0.5, 50_000)
    found = ladders.reweighted(speed, "other", speed**2 / 2 * (30.0**-2 - other**-2))
    precision = 1 / 2.5**2 + other**-2
    assert found.median == pytest.approx(20 / 2.5**2 / precision, abs=0.06)
    assert found.sd == pytest.approx(precision**-0.5, rel=0.02)
    assert found.pareto_k < 0.7


def test_log_evidence_is_that_of_lognormal_weights() -> None:
    """Weights exp(N(-7, 0.3²)) have the mean exp(-7 + 0.3²/2) and a known relative variance."""
    log_weight = np.random.default_rng(2).normal(-7, 0.3, 8000)
    value, error = log_mean(log_weight)
    assert error == pytest.approx(np.sqrt(np.expm1(0.3**2) / 8000), rel=0.05)
    assert value == pytest.approx(-7 + 0.3**2 / 2, abs=4 * error)


def test_log_evidence_is_that_of_all_solutions_by_a_method_that_has_it() -> None:
    tree = xr.DataTree.from_dict({"/sample_stats": xr.Dataset()})
    outcome = SimpleNamespace(idata=tree, modes=(Mode(1.0, 0.0, {}),))
    assert ladders.log_evidence(outcome) == (None, None)
    tree["sample_stats"].attrs |= {"log_evidence": -7.0, "log_evidence_sd": 0.1}
    assert ladders.log_evidence(outcome) == (-7.0, 0.1)
    outcome.modes = (Mode(0.8, 0.02, {}), Mode(0.2, 0.02, {}))  # together a quarter more
    value, error = ladders.log_evidence(outcome)
    assert value == pytest.approx(-7 + np.log(1.25))
    assert error == pytest.approx(np.hypot(0.1, 0.025))


def test_rungs_that_a_scene_cannot_distinguish_are_skipped() -> None:
    """One locked road of one friction leaves nothing of what wheels add to a spin."""
    plain, berm = collision(berm=False), collision(berm=True)
    refused = refusals(plain, ASKED)
    assert refused["planar+wheels"] == "of this scene the same model as planar+spin"
    assert not refused["planar+spin"]
    left = {name: why for name, why in refusals(berm, ASKED).items() if why}
    assert left == dict.fromkeys(
        (n for n in rungs_for(berm) if n.endswith("roll")), "no wheel rolls"
    )


def test_where_wheels_roll_three_rungs_stand_for_all() -> None:
    """The others take every wheel as locked, or take long."""
    rolling = refusals(rolls(collision(berm=False), "b", (1.0, 0.1, 0.1, 0.1)), ("speed_b",))
    left = [name for name, why in rolling.items() if not why]
    assert left == ["momentum+roll", "planar-moment+roll", "planar-moment+wheels"]
    assert rolling["planar+spin"] == "takes every wheel as locked, and some roll"
    assert "momentum+roll" in rolling["planar+wheels"]


@pytest.fixture
def rungs(monkeypatch):
    """Three made-up rungs: the first answers the speed only, the second explains headings only."""

    def rung(rank, answers, explains=""):
        return SimpleNamespace(
            answers=answers, explains=lambda name: explains in name, rank=rank,
            nests=lambda other: rank > other.rank, impact=SimpleNamespace(kind="impact"),
            of_scene=lambda _: (None, None), refusal=lambda _: "", run_out=None,
        )  # fmt: skip

    made = {
        "low": rung(0, ("speed_b",)),
        "middle": rung(1, ("speed_b", "e"), "heading"),
        "full": rung(2, ("speed_b", "e", "e_m", "mu")),
    }
    monkeypatch.setattr(ladders, "RUNGS", made)
    monkeypatch.setattr(ladders, "rungs_for", lambda _: made)
    monkeypatch.setattr(ladders, "size_of", lambda _: 25)
    return made


def test_only_rungs_that_the_question_allows(rungs) -> None:
    refused = refusals(make_scene(), ("speed_b", "e"))
    assert refused["low"] == "does not answer restitution e"
    assert not refused["middle"]
    assert ladders.allowed(make_scene()) == ["full"]


def test_only_rungs_that_the_evidence_allows(rungs, monkeypatch) -> None:
    scene = make_scene()
    left = {k: v for k, v in scene.evidence().items() if "heading" not in k}
    monkeypatch.setattr(type(scene), "evidence", lambda _: left)
    refused = refusals(scene, ASKED)
    assert refused["middle"] == "explains nothing of what was measured"
    assert not refused["low"]
    monkeypatch.setattr(type(scene), "evidence", lambda _: {})
    with pytest.raises(Unanswerable, match="explains nothing of what was measured"):
        ladder(scene, question=ASKED)


def test_climbing_runs_every_rung_and_an_interrupt_keeps_what_is_finished(
    rungs, monkeypatch
) -> None:
    asked = []

    def run(scene, options, *, progress, pictured, search):
        progress("sampling", 1, 2)
        model = options.model
        asked.append((model, options.method, options.seed))
        assert model in ahead
        assert not pictured  # no figure shows a rung
        if stop_at == model:
            raise KeyboardInterrupt
        if model == "middle":
            raise Unanswerable("no way there")
        return make_outcome(scene)

    ahead = []
    monkeypatch.setattr(ladders, "reconstruct", run)
    monkeypatch.setattr(ladders, "compile_search", lambda scene, model: ahead.append(model))
    stop_at = None
    seen = []
    whole = ladder(make_scene(), question=ASKED, seed=5, progress=lambda *p: seen.append(p))
    assert asked == [(name, "importance", 5) for name in rungs]
    assert ("middle (2 of 3): sampling", 1, 2) in seen
    assert ("full (3 of 3)", 1, 1) in seen
    assert whole.choice == "low"  # the same draws: the fuller one moves nothing
    assert "no way there" in whole.step("middle").verdict
    assert whole.step("full").below == ("low", "middle")
    assert whole.step("low").answers["speed_b"].median == pytest.approx(19.2, abs=0.1)

    stop_at = "full"
    cut = ladder(make_scene(), question=ASKED)
    assert not cut.complete
    assert cut.choice is None
    assert [s.name for s in cut.steps] == ["low", "middle"]


def test_where_wheels_roll_the_fullest_comes_first_and_others_where_it_fails(monkeypatch) -> None:
    asked, failing = [], ()

    def answered(scene, name, *_):
        asked.append(name)
        reasons = ("R-hat",) if name in failing else ()
        return replace(step("low", 19.0, reasons=reasons), name=name)

    monkeypatch.setattr(ladders, "run_rung", answered)
    monkeypatch.setattr(ladders, "compile_search", lambda *_, **__: None)
    scene = rolls(collision(berm=False), "b", (0.2, 0.9, 0.9, 0.2))
    found = ladder(scene, question=ASKED)
    assert asked == ["planar-moment+wheels"]
    assert found.choice == "planar-moment+wheels"
    assert "can be relied on" in found.step("momentum+roll").verdict
    assert [s.name for s in found.steps] == list(rungs_for(found.scene))

    asked.clear()
    failing = ("planar-moment+wheels",)
    assert ladder(scene, question=ASKED).choice == "planar-moment+roll"
    assert asked == ["planar-moment+wheels", "planar-moment+roll"]


@pytest.mark.slow
def test_on_the_paper_s_scene_momentum_with_wheels_is_enough_for_the_speed() -> None:
    scene = load_scene(PAPER)
    impacts = ("momentum", "planar", "planar-moment")
    names = ("momentum+slide", *(f"{impact}+wheels" for impact in impacts))
    judged, choice, _ = chosen([run_rung(scene, name, ASKED, 0) for name in names], ASKED)
    assert choice == "momentum+wheels"
    slide, momentum, planar, fullest = (s.answers["speed_b"] for s in judged)
    assert abs(momentum.median - fullest.median) < fullest.sd / 4
    assert slide.median > fullest.median + 2 * fullest.sd  # B turns twice on its way
    # e_m = 1 fits too, and would move the speed, were it not itself moved where e_m is free
    assert judged[2].counts
    assert abs(planar.median - momentum.median) > planar.sd / 4
    assert not judged[2].enough
