import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from retrodict.inference.outcome import Checks
from retrodict.report.findings import (
    DERIVED,
    assumptions,
    holds_answer,
    inputs_table,
    read_summary,
    statistics,
    strangers,
    summarise,
    summary_frame,
    summary_json,
)
from retrodict.report.results import MARK, WITHHELD, answer, result_rows

NAMES = ["speed_b", "e", "e_m", "mu", "vbx", "vby", "omega_b"]
STATISTICS = {
    "unit", "label", "mean", "sd", "median", "hdi_50", "hdi_90", "hdi_95", "ess_bulk", "ess_tail",
    "rhat", "mcse_mean", "error", "error_50", "error_90", "error_95", "passed",
}  # fmt: skip


def with_posterior(outcome, **variables):
    data = outcome.idata["posterior"].to_dataset()
    for name, values in variables.items():
        data = data.assign({name: (("chain", "draw"), values)}) if values is not None else (
            data.drop_vars(name)
        )  # fmt: skip
    return replace(outcome, idata=xr.DataTree(children={"posterior": xr.DataTree(data)}))


def test_summary_has_exactly_the_agreed_structure(outcome):
    found = summarise(outcome)
    assert list(found) == [
        "scene", "model", "assumptions", "parameters", "checks", "seconds", "versions", "seed",
        "settings", "complete", "ladder", "left_out", "narrowing",
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
    assert "speed_a" not in summarise(outcome)["parameters"]
    speeds = ["speed_a", "speed_b", "initial_speed_b"]
    assert list(summarise(sparse)["parameters"]) == speeds + NAMES[1:]
    assert [row.name for row in result_rows(sparse, "si")] == speeds + NAMES[1:]


def test_statistics_are_those_of_the_draws(outcome):
    draws = outcome.idata["posterior"]["speed_b"].values
    found = summarise(outcome)["parameters"]["speed_b"]
    assert found["mean"] == pytest.approx(draws.mean())
    assert found["median"] == pytest.approx(np.median(draws))
    assert found["sd"] == pytest.approx(draws.std(ddof=1))
    assert found["mcse_mean"] == pytest.approx(draws.std() / np.sqrt(draws.size), rel=0.25)


@pytest.mark.parametrize(("level", "z"), [(50, 0.674), (90, 1.645), (95, 1.960)])
def test_shortest_intervals_of_normal_draws_are_known(outcome, level, z):
    rng = np.random.default_rng(1)
    many = xr.Dataset({"speed_b": (("chain", "draw"), rng.normal(size=(4, 10000)))})
    normal = replace(outcome, idata=xr.DataTree(children={"posterior": xr.DataTree(many)}))
    found = statistics(normal, ("speed_b",))["speed_b"]
    low, high = found[f"hdi_{level}"]
    # a shortest interval slides easily, its length does not
    assert high - low == pytest.approx(2 * z, rel=0.03)
    assert low == pytest.approx(-z, abs=0.2)
    assert 30_000 < found["ess_bulk"] < 50_000
    assert found["rhat"] < 1.001


def test_chains_that_disagree_show_in_rhat(outcome):
    apart = np.random.default_rng(0).normal(size=(4, 500)) + np.arange(4)[:, None]
    found = summarise(with_posterior(outcome, e_m=apart))["parameters"]["e_m"]
    assert found["rhat"] > 1.2
    assert found["ess_bulk"] < 50


def test_summary_is_strict_json_where_numbers_are_missing(outcome):
    holes = with_posterior(outcome, e=np.full((4, 500), np.nan), mu=np.full((4, 500), np.nan))
    holes = replace(holes, checks=Checks(0, float("nan"), float("inf"), 1.0, False))
    found = json.loads(json.dumps(summarise(holes), allow_nan=False))
    assert found["parameters"]["e"]["mean"] is None
    assert found["parameters"]["mu"]["hdi_90"] == [None, None]
    assert not found["parameters"]["mu"]["passed"]
    assert found["checks"]["max_rhat"] is None
    assert found["checks"]["min_ess_bulk"] is None


def test_summary_survives_without_a_posterior(outcome, drop):
    json.dumps(summarise(drop(outcome, "posterior")), allow_nan=False)


def test_a_parameter_that_failed_its_own_checks_says_so(failing):
    parameters = summarise(failing)["parameters"]
    assert [name for name, entry in parameters.items() if not entry["passed"]] == ["e_m"]


def test_inputs_table_holds_every_input_and_item_of_evidence(outcome):
    rows = inputs_table(outcome)
    assert [r.name for r in rows if r.kind == "input"] == list(outcome.scene.inputs())
    assert [r.name for r in rows if r.kind == "evidence"] == list(outcome.scene.evidence())


def test_a_run_out_s_own_error_is_told_apart_and_counts_in_every_shift(rolled):
    evidence = rolled.scene.evidence()
    rows = {row.name: row for row in inputs_table(rolled) if row.kind == "evidence"}
    missed = 0.04 * rolled.scene.way_to("b", 6.6, -9.4)
    assert 0.4 < missed < 0.6
    of_rest = rows["rest_x_b"]
    assert of_rest.told_measured("si") == "6.60 ± 0.30"
    assert of_rest.told_model("si") == f"± {missed:.2f}"
    assert of_rest.told_model("us") == f"± {missed / 0.3048:.1f}"
    assert of_rest.shift == pytest.approx((of_rest.mean - 6.6) / np.hypot(0.3, missed))
    assert rows["departure_direction_a"].told_model("si") == ""
    assert {name[-1] for name, m in evidence.items() if m.model_sd} == {"b"}


def test_what_a_run_out_misses_is_an_assumption(outcome, rolled):
    assert assumptions(outcome) == outcome.description.assumptions
    # its end of rotation has a heading
    place, heading = assumptions(rolled)[len(rolled.description.assumptions) :]
    assert "B's heading by 8.0 deg after 20 m of it" in heading
    assert "each coordinate of B's place by 4.0 % of its way from the impact" in place
    assert "judgement" in place
    assert summarise(rolled)["assumptions"] == list(assumptions(rolled))
    whole = replace(rolled.scene, rest=outcome.scene.rest)
    heading = assumptions(replace(rolled, scene=whole))[-1]
    assert "B's heading by 8.0 deg after 20 m of it" in heading


def test_evidence_of_every_kind_is_told_with_label_value_unit_and_source(sparse):
    told = {
        row.label: (f"{row.told_measured('si')} {row.unit('si')}", row.source, row.assumed)
        for row in inputs_table(sparse)
        if row.kind == "evidence"
    }
    assert told == {
        "rest of B, x": ("6.60 ± 0.30 m", "total station", ""),
        "rest of B, y": ("−9.40 ± 0.30 m", "total station", ""),
        "direction of travel of A after impact": (
            "140.0 ± 8.0 deg", "first metres of the marks", "",
        ),
        "delta-v of A along its heading": ("−13.0 ± 1.0 m/s", "event data recorder", ""),
        "mark 1 of B, distance from its path": ("0.00 ± 0.20 m", "taped", ""),
        "mark 2 of B, distance from its path": ("0.00 ± 0.15 m", "photograph", "sd"),
        "mark 2 of B, speed there": ("6.00 ± 0.50 m/s", "film", ""),
        "mark 2 of B, direction of travel there": ("−55.0 ± 6.0 deg", "film", ""),
        "end of rotation of B, x": ("5.50 ± 0.50 m", "tyre marks", ""),
        "end of rotation of B, y": ("−7.00 ± 0.50 m", "tyre marks", ""),
        "end of rotation of B, heading": ("−50.0 ± 5.0 deg", "tyre marks", ""),
    }  # fmt: skip


def test_shift_is_counted_in_measured_standard_deviations(outcome):
    rows = {row.name: row for row in inputs_table(outcome)}
    y = rows["rest_y_b"]
    predicted = outcome.idata["posterior_predictive"]["rest_y_b"].values
    assert y.shift == pytest.approx((predicted.mean() + 9.4) / 0.3)
    assert y.told_shift() == "+1.7"
    mass = outcome.idata["posterior"]["mass_a"].values
    assert rows["mass_a"].shift == pytest.approx((mass.mean() - 1857.0) / 40.0)
    assert rows["track_a"].shift is None  # exact
    assert (rows["yaw_inertia_a"].assumed, rows["front_axle_a"].assumed) == ("value", "sd")
    assert rows["speed_a"].source == "event data recorder"


def test_inputs_are_told_in_either_system(outcome):
    speed = next(row for row in inputs_table(outcome) if row.name == "speed_a")
    assert f"{speed.told_measured('si')} {speed.unit('si')}" == "20.10 ± 0.50 m/s"
    assert f"{speed.told_measured('us')} {speed.unit('us')}" == "45.0 ± 1.1 mph"


def test_inputs_have_no_shift_without_a_posterior(outcome, drop):
    rows = inputs_table(drop(outcome, "posterior"))
    assert all(row.shift is None for row in rows if row.kind == "input")


def test_answer_gives_the_speed_with_its_interval_in_both_systems(outcome):
    assert answer(outcome, "si") == (
        "Vehicle B (saloon B) was travelling at about 19.1 m/s (69 km/h; 43 mph) before impact; "
        "given the model and the inputs below, with 95 % probability between "
        "17.5 and 21.0 m/s (63 and 76 km/h; 39 and 47 mph)."
    )
    assert "about 43 mph (19.1 m/s; 69 km/h)" in answer(outcome, "us")


def test_answer_tells_both_speeds_where_neither_is_known(sparse):
    of_a, of_b = answer(sparse, "si").split(". ")
    assert of_a.startswith(
        "Vehicle A (saloon A) was travelling at about 20.3 m/s (73 km/h; 45 mph)"
    )
    assert of_b.startswith("Vehicle B (saloon B) was travelling at about 19.1 m/s")


def test_each_speed_is_withheld_by_its_own_checks(sparse):
    half = replace(sparse, checks=replace(sparse.checks, failed=("speed_a",)))
    of_a, of_b = answer(half).split(". ")
    assert of_a == (
        "Vehicle A (saloon A): its speed before impact is withheld, because checks of the draws failed"
    )
    assert "19.1 m/s" in of_b


def test_answer_is_withheld_when_checks_fail(failing):
    text = answer(failing)
    assert WITHHELD in text
    assert not any(c.isdigit() for c in text)


def test_rows_of_a_failed_run_are_marked_or_withheld(failing):
    for row in result_rows(failing, "si"):
        told = [row.median, row.mean, *row.intervals.values()]
        if row.name == "e_m":
            assert set(told) == {WITHHELD}
        else:
            assert all(text.endswith(MARK) for text in told)


def test_what_follows_from_a_failed_quantity_is_withheld(failing):
    assert all(row.withheld for row in result_rows(failing, "si", DERIVED))


def test_rows_of_a_good_run_are_bare_and_in_the_units_asked_for(outcome):
    speed = result_rows(outcome, "us")[0]
    assert (speed.unit, speed.mean) == ("mph", "42.9 ± 2.0")
    assert result_rows(outcome, "si")[0].mean == "19.2 ± 0.9"
    assert result_rows(outcome, "si", ("energy_lost",))[0].unit == "kJ"


def test_no_digit_is_printed_that_the_monte_carlo_error_reaches(outcome):
    """2000 independent draws of sd 0.89: the limits are known to 0.06, the median to 0.025."""
    rows = {row.name: row for row in result_rows(outcome, "si")}
    speed = rows["speed_b"]
    assert (speed.mean, speed.last_digit) == ("19.2 ± 0.9", "0.1")
    assert 0.05 < float(speed.monte_carlo_error) < 0.1
    assert speed.intervals[95] == "17.5 to 21.0"


def test_frame_has_numbers_in_the_units_asked_for(outcome):
    si, us = summary_frame(outcome), summary_frame(outcome, "us")
    assert list(si.index) == NAMES
    assert us.loc["speed_b", "unit"] == "mph"
    assert us.loc["speed_b", "hdi_95_high"] * 0.44704 == pytest.approx(
        si.loc["speed_b", "hdi_95_high"]
    )
    assert us.loc["speed_b", "rhat"] == si.loc["speed_b", "rhat"]
    assert set(si["checks"]) == {"passed"}


def test_frame_of_a_failed_run_says_so_and_hides_what_failed(failing):
    frame = summary_frame(failing)
    assert frame.loc["e_m", "checks"] == "failed"
    assert frame.loc["e_m", ["mean", "sd", "median", "hdi_50_low", "hdi_95_high"]].isna().all()
    assert frame.loc["e_m", "rhat"] > 0
    assert frame.loc["speed_b", "checks"] == "NOT TO BE RELIED ON"


def test_a_file_of_another_run_shows(outcome, tmp_path):
    beside = {"report.html": b"<p>", "figures/scene.png": b"PNG"}
    (tmp_path / "figures").mkdir()
    for name, content in beside.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "summary.json").write_bytes(summary_json(outcome, beside))
    found = read_summary(tmp_path)
    assert {k: v for k, v in found.items() if k != "files"} == summarise(outcome)
    assert strangers(tmp_path) == ()
    (tmp_path / "figures" / "scene.png").write_bytes(b"PNG of another run")
    (tmp_path / "report.html").unlink()
    assert strangers(tmp_path) == ("report.html", "figures/scene.png")


def test_only_a_finished_run_whose_checks_passed_is_an_answer(outcome, tmp_path):
    assert not holds_answer(tmp_path)
    for complete in (True, False):
        summary = summary_json(replace(outcome, complete=complete), {})
        (tmp_path / "summary.json").write_bytes(summary)
        assert holds_answer(tmp_path) == complete
    (tmp_path / "summary.json").write_text("[torn")
    assert not holds_answer(tmp_path)
