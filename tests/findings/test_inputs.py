"""Inputs and evidence, with what became of them."""

import numpy as np
import pytest

from retrodict.findings.inputs import input_rows
from retrodict.inference.pointwise import by_item


def test_inputs_table_holds_every_input_and_item_of_evidence(outcome):
    rows = input_rows(outcome)
    assert [r.name for r in rows if r.kind == "input"] == list(outcome.scene.inputs())
    assert [r.name for r in rows if r.kind == "evidence"] == list(outcome.scene.evidence())


def test_a_run_out_s_own_error_is_listed_separately_and_counts_in_every_shift(rolled):
    evidence = rolled.scene.evidence()
    rows = {row.name: row for row in input_rows(rolled) if row.kind == "evidence"}
    missed = 0.04 * rolled.scene.path_to("b", 6.6, -9.4)
    assert 0.4 < missed < 0.6
    of_rest = rows["rest_x_b"]
    assert of_rest.format_measured("si") == "6.60 ± 0.30"
    assert of_rest.format_model("si") == f"± {missed:.2f}"
    assert of_rest.format_model("us") == f"± {missed / 0.3048:.1f}"
    assert of_rest.shift == pytest.approx((of_rest.mean - 6.6) / np.hypot(0.3, missed))
    assert rows["departure_direction_a"].format_model("si") == ""
    assert {name[-1] for name, m in evidence.items() if m.model_sd} == {"b"}


def test_evidence_of_every_kind_is_listed_with_label_value_unit_and_source(sparse):
    listed = {
        row.label: (f"{row.format_measured('si')} {row.unit('si')}", row.source, row.assumed)
        for row in input_rows(sparse)
        if row.kind == "evidence"
    }
    assert listed == {
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
    rows = {row.name: row for row in input_rows(outcome)}
    y = rows["rest_y_b"]
    predicted = by_item(outcome.idata, "posterior_predictive")["rest_y_b"].values
    assert y.shift == pytest.approx((predicted.mean() + 9.4) / 0.3)
    assert y.format_shift() == "+1.7"
    mass = outcome.idata["posterior"]["mass_a"].values
    assert rows["mass_a"].shift == pytest.approx((mass.mean() - 1857.0) / 40.0)
    assert rows["track_a"].shift is None  # exact
    assert (rows["yaw_inertia_a"].assumed, rows["front_axle_a"].assumed) == ("value", "sd")
    assert rows["speed_a"].source == "event data recorder"


def test_inputs_are_given_in_either_system(outcome):
    speed = next(row for row in input_rows(outcome) if row.name == "speed_a")
    assert f"{speed.format_measured('si')} {speed.unit('si')}" == "20.10 ± 0.50 m/s"
    assert f"{speed.format_measured('us')} {speed.unit('us')}" == "45.0 ± 1.1 mph"


def test_inputs_have_no_shift_without_a_posterior(outcome, drop):
    rows = input_rows(drop(outcome, "posterior"))
    assert all(row.shift is None for row in rows if row.kind == "input")
