"""The public names, as a notebook uses them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import retrodict as rd
from retrodict import api
from retrodict.inference import Interrupted
from retrodict.report.figures import registry as figures
from retrodict.scene.case import load_case
from retrodict.scene.quantities import describe
from retrodict.studies import ladder as study
from retrodict.studies.conflict import conflicts
from tests.report.conftest import make_outcome
from tests.studies.made_up import ladder_of, step

SCENE = Path(__file__).parents[1] / "examples" / "brach-1977" / "scene.toml"


FILM = """
schema = 1
title = "B as a film shows it"

[vehicles.A]
mass = "1857 kg"
wheelbase = "2.8 m"
track = "1.5 m"
impact_centre = { distance = "2.09 m", angle = "5.6 deg" }
impact = { heading = "180 deg" }
approach = { speed = "20 ± 1 m/s" }
rest = { position = ["-3.2 m", "2.0 m"], heading = "209 deg", rotation = "29 deg" }

[vehicles.B]
mass = "1778 kg"
wheelbase = "2.8 m"
track = "1.5 m"
impact_centre = { distance = "1.76 m", angle = "90 deg" }
impact = { heading = "-22 deg" }
departure = { yaw_rate = "60 ± 20 deg/s" }
marks = [{ point = ["2 m", "-4.6 m"], speed = "5.1 ± 0.3 m/s", course = "-48 ± 4 deg" }]
end_of_rotation = { x = "3.8 ± 0.5 m", y = "-6.5 ± 0.5 m", heading = "35 ± 5 deg" }

[impact]
point = ["0 m", "0 m"]
contact_line = "-8.9 ± 3 deg"

[surfaces.road]
friction = "0.50 ± 0.03"
"""


def test_public_names_are_there() -> None:
    for name in rd.__all__:
        assert getattr(rd, name) is not None


def test_a_scene_shows_itself_and_is_named_after_its_folder() -> None:
    scene = rd.load_scene(SCENE)
    assert scene.name == "brach-1977"
    page = scene._repr_html_()
    assert "SAE 770014" in page
    assert "<script" not in page


@pytest.mark.parametrize("call", [rd.reconstruct, rd.ladder, rd.calibrate])
def test_a_path_is_read_as_a_scene_file(call, tmp_path) -> None:
    for path in (tmp_path / "none.toml", str(tmp_path / "none.toml")):
        with pytest.raises(rd.SceneError, match="no such file; write the path of a scene file"):
            call(path)


@pytest.mark.slow
def test_what_was_measured_on_the_way_to_rest_goes_from_file_to_report(tmp_path) -> None:
    """Of B no rest is known: numbers are those of its run-out at 8.0 m/s, after which B came at 19.3."""
    (tmp_path / "film.toml").write_text(FILM, encoding="utf-8")
    result = rd.reconstruct(
        str(tmp_path / "film.toml"),
        model="momentum+spin",
        method="importance",
        draws=1000,
    )
    assert result.checks.passed, result.checks.reasons
    low, high = np.quantile(result.idata["posterior"]["speed_b"], [0.05, 0.95])
    assert low < 19.3 < high
    items = set(result.scene.evidence())
    assert {"mark_1_speed_b", "mark_1_course_b", "end_x_b", "end_y_b", "end_heading_b"} < items
    for group in ("posterior_predictive", "log_likelihood", "observed_data"):
        assert set(result.idata[group]["evidence"]["item"].values) == items
    assert {item.name for item in conflicts(result.outcome)} == items
    page = result.report(tmp_path / "report.html").read_text(encoding="utf-8")
    for name in items:
        assert describe(name)[0] in page

    again = rd.replay(result.archive(tmp_path / "film.retrodict.zip"))
    assert again.reproduced
    assert {each.sameness for each in again.numbers} == {"bits"}
    assert all(again.draws.values())
    assert not again.versions


def test_the_default_model_is_the_one_that_the_ladder_chooses(monkeypatch) -> None:
    ladder = ladder_of(step("low", 19.0), step("full", 19.1))
    ran = []

    def reconstructed(scene, options, **_):
        ran.append(options.model)
        return make_outcome()

    monkeypatch.setattr(api, "_reconstruct", reconstructed)
    monkeypatch.setattr(study, "ladder", lambda scene, **_: ladder)
    monkeypatch.setattr(study, "allowed", lambda scene: ["low", "full"])
    assert api.reconstruct(ladder.scene).ladder is ladder
    none = replace(ladder, choice=None)
    monkeypatch.setattr(study, "ladder", lambda scene, **_: none)
    api.reconstruct(ladder.scene)
    assert api.reconstruct(ladder.scene, model="middle").ladder is None
    monkeypatch.setattr(study, "allowed", lambda scene: ["full"])  # nothing to compare
    assert api.reconstruct(ladder.scene).ladder is None
    assert ran == ["low", "full", "middle", "full"]
    monkeypatch.setattr(study, "allowed", lambda scene: ["low", "full"])
    monkeypatch.setattr(study, "ladder", lambda scene, **_: replace(none, complete=False))
    with pytest.raises(Interrupted):
        api.reconstruct(ladder.scene)


def test_a_result_names_itself_in_a_line() -> None:
    """The draws, the scene and its text are tens of kilobytes."""
    result = api.Result(make_outcome())
    assert repr(result) == "<Result of 'made-up': planar-moment+wheels, seed 20, checks passed>"
    scene, ladder = result.scene, ladder_of(step("low", 19.0), step("full", 19.1))
    records = [
        result.outcome,
        scene,
        result.findings,
        result.probability("speed_b > 45 mph"),
        ladder,
        rd.Calibration(scene, "planar+spin", "nuts", 0, 1000),
        rd.Validation((), "auto", "nuts"),
        result.compare(result),
        result.findings.quantities["speed_b"],
    ]
    for each in records:
        said = repr(each)
        assert len(said) < 400, said
        assert "\n" not in said
    assert repr(scene).startswith("<Scene 'made-up': 'Two cars on a made-up road', ")
    assert repr(ladder) == "<Ladder of 'made-up': 2 models, choice low>"


def test_a_report_is_written_by_suffix_with_its_case(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(figures, "FIGURES", {})
    (tmp_path / "case.toml").write_text('schema = 1\nnumber = "17/26"\nunits = "us"\n')
    result = api.Result(make_outcome())
    path = result.report(tmp_path / "report.HTML", case=tmp_path / "case.toml")
    page = path.read_text("utf-8")
    assert "17/26" in page
    assert page.index("US customary units") < page.index("SI units")
    page = result.report(path, "si", load_case(tmp_path / "case.toml")).read_text("utf-8")
    assert page.index("SI units") < page.index("US customary units")
