"""Two results beside each other: differences in standard deviations and in Monte Carlo errors."""

import dataclasses
import math

import numpy as np
import pytest

from retrodict.findings import compute
from retrodict.findings.changes import changed_keys
from retrodict.findings.differences import NothingInCommon, differences
from retrodict.result import Result
from retrodict.scene.load import parse_scene
from retrodict.scene.write import scene_toml
from tests.report.conftest import fail, make_outcome, make_scene, without

ANGLE = "pdof_a"


@pytest.fixture(scope="module")
def one():
    return compute(make_outcome())


def with_draws(outcome, **changes):
    """The same outcome with other draws of some quantities."""
    posterior = outcome.idata["posterior"].to_dataset()
    idata = outcome.idata.copy()
    idata["posterior"] = type(idata)(posterior.assign(**changes))
    return dataclasses.replace(outcome, idata=idata)


def test_a_result_does_not_differ_from_itself(one):
    found = differences(one, one)
    table = found.table()
    assert list(table.index) == [*one.quantities, *one.derived]
    assert (table["difference"] == 0).all()
    assert found.verdict.startswith(
        "Impact speed of B, 19.2 ± 0.9 → 19.2 ± 0.9 m/s, by 0.00 of its"
    )
    assert found.verdict.endswith(
        "The answers agree within Monte Carlo error. Both are of the same scene."
    )
    assert found.verdicts["us"].startswith("Impact speed of B, 42.9 ± 2.0 → 42.9 ± 2.0 mph")
    assert found.changes().empty


def test_differences_are_in_deviations_and_in_errors(one):
    """The means of draws moved by one standard deviation differ by that, and by it over both errors."""
    outcome = make_outcome()
    speed = outcome.idata["posterior"]["speed_b"]
    sd = float(speed.std(ddof=1))
    other = compute(with_draws(outcome, speed_b=speed + sd))
    table = differences(one, other).table("us")
    row, error = table.loc["speed_b"], one.quantities["speed_b"].mcse_mean
    assert row["unit"] == "mph"
    assert row["difference"] * 0.44704 == pytest.approx(sd)
    assert row["difference_in_sd"] == pytest.approx(1)
    assert row["difference_in_errors"] == pytest.approx(sd / (math.sqrt(2) * error))
    assert differences(other, one).table().loc["speed_b", "difference_in_sd"] == pytest.approx(-1)
    verdict = differences(one, other).verdict
    assert verdict.startswith("Impact speed of B, 19.2 ± 0.9 → 20.1 ± 0.9 m/s, ")
    assert "The answers differ." in verdict
    assert "by 1.00 of its standard deviation" in verdict


def test_other_draws_of_the_same_agree_within_their_error(one):
    speed = np.random.default_rng(1).normal(19.2, 0.9, (4, 500))
    other = compute(with_draws(make_outcome(), speed_b=(("chain", "draw"), speed)))
    assert "agree within Monte Carlo error" in differences(one, other).verdict


def test_a_wider_answer_differs_even_where_its_mean_does_not(one):
    speed = make_outcome().idata["posterior"]["speed_b"]
    other = compute(with_draws(make_outcome(), speed_b=speed + 0.5 * (speed - speed.mean())))
    assert "The answers differ." in differences(one, other).verdict


def test_angles_differ_by_the_shorter_way_round(one):
    found = one.derived[ANGLE]
    ends = [dataclasses.replace(found, mean=mean) for mean in (math.pi - 0.1, 0.1 - math.pi)]
    pair = [dataclasses.replace(one, derived=one.derived | {ANGLE: end}) for end in ends]
    assert differences(*pair).table().loc[ANGLE, "difference"] == pytest.approx(math.degrees(0.2))


def test_what_is_withheld_has_no_number_and_the_verdict_says_so(one):
    table = (found := differences(one, compute(fail(make_outcome())))).table()
    numbers = ["mean_other", "sd_other", "difference", "difference_in_sd", "difference_in_errors"]
    assert table.loc["e_m", numbers].isna().all()
    assert table.loc["e_m", "mean_one"] > 0
    assert table.loc["delta_v_a", numbers].isna().all()  # follows from what failed
    assert table.loc["e_m", "checks"] == "failed"
    assert table.loc["speed_b", "checks"] == "NOT TO BE RELIED ON"
    assert found.verdict.startswith("NOT TO BE RELIED ON: checks of the second result failed.")


def test_results_with_nothing_in_common_are_refused(one):
    with pytest.raises(NothingInCommon, match="no quantity of which both have draws"):
        differences(one, compute(without(make_outcome(), "posterior")))


def test_the_keys_that_differ_are_named_with_both_values():
    scene = parse_scene(scene_toml(make_scene()), "made-up")
    text = scene.text
    for old, new in (
        ("value = 20.1, sd = 0.5", "value = 21.5, sd = 0.5"),
        ('errors = "normal"', 'errors = "robust"'),
        ('title = "Two cars', 'title = "The same two cars'),  # changes no number
    ):
        assert old in text
        text = text.replace(old, new)
    changed = changed_keys(scene, parse_scene(text, "other"))
    assert changed == {
        "errors": ("normal", "robust"),
        "vehicles.A.approach.speed": ("20.1 ± 0.5 m/s", "21.5 ± 0.5 m/s"),
    }
    assert changed_keys(scene, scene) == {}


def test_a_value_is_shown_as_the_file_spells_it():
    scene = parse_scene(scene_toml(make_scene()), "made-up")
    old = (
        'approach.speed = { value = 20.1, sd = 0.5, unit = "m/s", source = "event data recorder" }'
    )
    assert old in scene.text
    mph = parse_scene(scene.text.replace(old, 'approach.speed = "45 ± 2 mph"'), "mph")
    same = parse_scene(scene.text.replace(old, 'approach.speed = "20.1 ± 0.5 m/s"'), "same")
    assert changed_keys(scene, mph) == {
        "vehicles.A.approach.speed": ("20.1 ± 0.5 m/s", "45 ± 2 mph")
    }
    assert changed_keys(scene, same) == {}


def test_a_notebook_shows_verdict_table_and_changes_escaped(one):
    other = dataclasses.replace(make_outcome(), seed=21, settings={"method": "<b>"})
    found = Result(make_outcome()).compare(Result(other))
    assert found.run["seed"] == ("20", "21")
    page = found._repr_html_()
    assert "speed_b" in page
    assert "<b>" not in page
    assert "\n" not in repr(found)
    assert "speed_b" in str(found)
