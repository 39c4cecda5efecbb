"""What `summary.json` holds, and what that of a folder says."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from retrodict.findings.summary import (
    holds_answer,
    read_summary,
    strangers,
    summarise,
    summary_frame,
    summary_json,
)
from retrodict.inference.outcome import Checks
from retrodict.report.results import result_rows
from retrodict.scene.quantities import DERIVED
from tests.report.conftest import found_of

NAMES = ["speed_b", "e", "e_m", "mu", "vbx", "vby", "omega_b"]
STATISTICS = {
    "unit", "label", "mean", "sd", "median", "interval_50", "interval_90", "interval_95",
    "ess_bulk", "ess_tail", "rhat", "mcse_mean", "error", "error_50", "error_90", "error_95",
    "passed", "withheld", "printed",
}  # fmt: skip


def with_posterior(outcome, **variables):
    data = outcome.idata["posterior"].to_dataset()
    for name, values in variables.items():
        data = data.assign({name: (("chain", "draw"), values)}) if values is not None else (
            data.drop_vars(name)
        )  # fmt: skip
    return replace(outcome, idata=xr.DataTree(children={"posterior": xr.DataTree(data)}))


def test_summary_has_exactly_the_agreed_structure(outcome):
    found = summarise(found_of(outcome))
    assert list(found) == [
        "schema", "scene", "model", "assumptions", "parameters", "derived", "hours", "correlations",
        "measured", "checks", "verdict", "question", "answers", "seconds", "versions", "seed",
        "settings", "complete", "notes", "ladder", "left_out", "causes", "narrowing",
        "questions", "sliding",
    ]  # fmt: skip
    assert found["scene"] == {"title": outcome.scene.title, "name": "made-up"}
    assert found["model"] == "planar-moment+wheels"
    assert list(found["parameters"]) == NAMES
    assert all(set(entry) == STATISTICS for entry in found["parameters"].values())
    assert found["parameters"]["speed_b"]["unit"] == "m/s"
    assert set(found["checks"]) == {
        "divergences", "pareto_k", "max_rhat", "min_ess_bulk", "min_ess_tail", "passed", "reasons",
        "flags",
    }  # fmt: skip
    assert (found["seed"], found["complete"]) == (20, True)
    assert list(found["narrowing"]) == ["speed_b"]
    assert "friction_road" in found["narrowing"]["speed_b"]


def test_a_known_speed_is_no_result_and_an_unknown_one_is(outcome, sparse):
    assert "speed_a" in outcome.idata["posterior"]  # among the inputs
    assert "speed_a" not in summarise(found_of(outcome))["parameters"]
    speeds = ["speed_a", "travelling_speed_b", "speed_b"]
    assert list(summarise(found_of(sparse))["parameters"]) == speeds + NAMES[1:]
    assert [row.name for row in result_rows(found_of(sparse), "si")] == speeds + NAMES[1:]


def test_summary_is_strict_json_where_numbers_are_missing(outcome):
    holes = with_posterior(outcome, e=np.full((4, 500), np.nan), mu=np.full((4, 500), np.nan))
    holes = replace(holes, checks=Checks(0, float("nan"), float("inf"), 1.0, False))
    found = json.loads(json.dumps(summarise(found_of(holes)), allow_nan=False))
    assert found["parameters"]["e"]["mean"] is None
    assert found["parameters"]["mu"]["interval_90"] == [None, None]
    assert not found["parameters"]["mu"]["passed"]
    assert found["checks"]["max_rhat"] is None
    assert found["checks"]["min_ess_bulk"] is None


def test_summary_survives_without_a_posterior(outcome, drop):
    json.dumps(summarise(found_of(drop(outcome, "posterior"))), allow_nan=False)


def test_frame_has_numbers_in_the_units_asked_for(outcome):
    si, us = summary_frame(found_of(outcome)), summary_frame(found_of(outcome), "us")
    derived = [name for name in DERIVED if name in outcome.idata["posterior"] or "pdof" in name]
    assert list(si.index) == [*NAMES, *derived]
    assert {"delta_v_a", "delta_v_b", "pdof_a", "pdof_b"} < set(si.index)
    assert us.loc["pdof_a", "unit"] == "deg"
    assert us.loc["speed_b", "unit"] == "mph"
    assert us.loc["speed_b", "interval_95_high"] * 0.44704 == pytest.approx(
        si.loc["speed_b", "interval_95_high"]
    )
    assert us.loc["speed_b", "rhat"] == si.loc["speed_b", "rhat"]
    assert set(si["checks"]) == {"passed"}


def test_frame_of_a_failed_run_says_so_and_hides_what_failed(failing):
    frame = summary_frame(found_of(failing))
    assert frame.loc["e_m", "checks"] == "failed"
    assert (
        frame.loc["e_m", ["mean", "sd", "median", "interval_50_low", "interval_95_high"]]
        .isna()
        .all()
    )
    assert frame.loc["e_m", "rhat"] > 0
    assert frame.loc["speed_b", "checks"] == "NOT TO BE RELIED ON"
    assert frame.loc["delta_v_b", "checks"] == "failed"  # follows from what failed
    assert frame.loc["delta_v_b", ["mean", "sd"]].isna().all()


def test_a_file_of_another_run_shows(outcome, tmp_path):
    beside = {"report.html": b"<p>", "figures/scene.png": b"PNG"}
    (tmp_path / "figures").mkdir()
    for name, content in beside.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "summary.json").write_bytes(summary_json(found_of(outcome), beside))
    found = read_summary(tmp_path)
    assert {k: v for k, v in found.items() if k != "files"} == summarise(found_of(outcome))
    assert strangers(tmp_path) == ()
    (tmp_path / "figures" / "scene.png").write_bytes(b"PNG of another run")
    (tmp_path / "report.html").unlink()
    assert strangers(tmp_path) == ("report.html", "figures/scene.png")


def test_only_a_finished_run_whose_checks_passed_is_an_answer(outcome, tmp_path):
    assert not holds_answer(tmp_path)
    for complete in (True, False):
        summary = summary_json(found_of(replace(outcome, complete=complete)), {})
        (tmp_path / "summary.json").write_bytes(summary)
        assert holds_answer(tmp_path) == complete
    (tmp_path / "summary.json").write_text("[torn")
    assert not holds_answer(tmp_path)
