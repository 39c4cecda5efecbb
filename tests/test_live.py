"""A warm session and a sweep, as a notebook uses them."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import retrodict as rd
from retrodict.inference.warm import Warm
from retrodict.studies.probability import Probability

EXAMPLES = Path(__file__).parents[1] / "examples"
SCENE = EXAMPLES / "brach-1977" / "scene.toml"
MODEL = "planar-moment+wheels"
SPEED = "vehicles.A.approach.speed"


@pytest.fixture(scope="module")
def session() -> rd.Session:
    return rd.session(SCENE, model=MODEL)


def test_a_changed_number_changes_the_answer(session: rd.Session) -> None:
    """A faster A leaves less for B to bring: by the paper's conservation of momentum (eq 19)."""
    slow, fast = (session.update({SPEED: f"{v} ± 1 mph"}) for v in (42, 50))
    assert slow.checks.passed, slow.checks.reasons
    assert fast.checks.passed, fast.checks.reasons
    assert fast.draws["speed_b"].mean() > slow.draws["speed_b"].mean()
    assert session.answer is fast
    assert session.scene.approach["a"].speed.value == pytest.approx(50 * 0.44704)
    assert "planar-moment+wheels, checks passed" in repr(fast)
    assert len(repr(fast)) < 120


def test_the_summary_is_in_the_units_asked_for(session: rd.Session) -> None:
    answer = session.update({SPEED: "45 ± 2 mph"})
    si, us = answer.summary(), answer.summary("us")
    assert si.loc["speed_b", "unit"] == "m/s"
    assert us.loc["speed_b", "unit"] == "mph"
    assert si.loc["speed_b", "mean"] == pytest.approx(0.44704 * us.loc["speed_b", "mean"])
    assert si.loc["e", "sd"] == pytest.approx(us.loc["e", "sd"])
    assert (si["as_many_draws"] > 1000).all()
    assert (si["checks"] == "passed").all()
    found = answer.probability("speed_b > 43 mph").numbers
    assert isinstance(found, Probability)
    share = np.mean(answer.draws["speed_b"] > 43 * 0.44704)
    assert found.value == pytest.approx(share, abs=4 * np.sqrt(0.25 / answer.draws["speed_b"].size))
    assert found.error is not None
    assert 0 < found.error < 0.02
    assert found.at_least < found.value < found.at_most
    with pytest.raises(ValueError, match="speed_c"):
        answer.probability("speed_c > 3 mph")


def test_what_cannot_be_used_leaves_the_session_as_it_was(session: rd.Session) -> None:
    before, answer = session.scene, session.answer
    with pytest.raises(rd.SceneError, match="speed"):
        session.update({SPEED: "45 ± 2 kg"})
    with pytest.raises(rd.SceneError, match="wrong"):
        session.update({"vehicles.A.approach.wrong": "45 mph"})
    assert session.scene is before
    assert session.answer is answer


def test_a_model_that_the_scene_does_not_allow_is_named() -> None:
    with pytest.raises(ValueError, match="'momentum': no model has that name; the scene allows"):
        rd.session(SCENE, model="momentum")
    pole = EXAMPLES / "iihs-cf10028-barrier" / "scene.toml"
    with pytest.raises(
        ValueError, match=r"the same model as planar-moment\+spin; the scene allows"
    ):
        rd.session(pole, model="planar-moment+wheels")


@pytest.mark.slow
def test_coordinates_that_no_longer_do_are_fitted_anew(
    session: rd.Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A rest pose forty standard deviations off."""
    fitted: list[rd.Scene] = []
    whole = Warm.__init__

    def counted(self: Warm, scene: rd.Scene, *others: object) -> None:
        fitted.append(scene)
        whole(self, scene, *others)

    monkeypatch.setattr(Warm, "__init__", counted)
    answer = session.update({"vehicles.B.rest.position": ["12.0 ± 0.15 m", "-16.0 ± 0.15 m"]})
    assert fitted == [answer.scene]
    assert answer.estimate.refitted
    assert answer.checks.passed, answer.checks.reasons


@pytest.mark.slow
def test_a_sweep_has_a_row_for_every_combination() -> None:
    stages: list[tuple[str, int, int]] = []
    table = rd.sweep(
        SCENE,
        {SPEED: ["43 ± 2 mph", "47 ± 2 mph"], "surfaces.road.friction": ["0.5 ± 0.05"]},
        model=MODEL,
        units="us",
        progress=lambda *stage: stages.append(stage),
    )
    assert isinstance(table, pd.DataFrame)
    assert list(table[SPEED]) == ["43 ± 2 mph", "47 ± 2 mph"]
    assert (table["checks"] == "passed").all()
    assert table["speed_b_mean"].between(30, 60).all()
    assert (table["speed_b_low_95"] < table["speed_b_mean"]).all()
    assert stages[-1][1:] == (2, 2)


def test_a_sweep_refuses_a_bad_variant_before_it_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("retrodict.live.Session", None)  # would fail if it began
    with pytest.raises(rd.SceneError, match="speed"):
        rd.sweep(SCENE, {SPEED: ["43 ± 2 mph", "fast"]})


def test_an_interrupted_sweep_keeps_what_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    class Stopped:
        model = MODEL
        checks = SimpleNamespace(passed=True, reasons=())
        asked = 0

        def __init__(self, *_: object) -> None: ...

        def update(self, _: rd.Scene) -> "Stopped":
            self.asked += 1
            if self.asked > 1:
                raise KeyboardInterrupt
            return self

        def summary(self, _: str) -> pd.DataFrame:
            row = dict.fromkeys(("mean", "sd", "low_95", "high_95"), 1.0)
            return pd.DataFrame.from_dict({"speed_b": row}, orient="index")

    monkeypatch.setattr("retrodict.live.Session", Stopped)
    table = rd.sweep(SCENE, {SPEED: ["43 ± 2 mph", "45 ± 2 mph", "47 ± 2 mph"]})
    assert list(table[SPEED]) == ["43 ± 2 mph"]
    assert list(table["speed_b_mean"]) == [1.0]
