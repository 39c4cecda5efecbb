"""The sentences: the answer, and what is taken for granted."""

import re
from dataclasses import replace

from retrodict.models import RUNGS

from retrodict.findings.sentences import WITHHELD, assumptions, simplifications
from retrodict.findings.summary import (
    summarise,
)
from retrodict.inference.misfit import UNEXPLAINED, UNSUPPORTED
from tests.report.conftest import found_of


def test_what_a_run_out_misses_is_an_assumption(outcome, rolled):
    assert assumptions(outcome) == outcome.description.assumptions
    # its end of rotation has a heading
    place, heading = assumptions(rolled)[len(rolled.description.assumptions) :]
    assert "B's heading by 8.0 deg after 20 m of it" in heading
    assert "each coordinate of B's place by 4.0 % of its way from the impact" in place
    assert "judgement" in place
    assert summarise(found_of(rolled))["assumptions"] == list(assumptions(rolled))
    whole = replace(rolled.scene, rest=outcome.scene.rest)
    heading = assumptions(replace(rolled, scene=whole))[-1]
    assert "B's heading by 8.0 deg after 20 m of it" in heading


def test_what_is_of_a_class_is_an_assumption_and_named_as_assumed(outcome):
    a = replace(outcome.scene.vehicles["a"], kind="minivan")  # of which the yaw inertia is assumed
    scene = replace(outcome.scene, vehicles=outcome.scene.vehicles | {"a": a})
    (line,) = assumptions(replace(outcome, scene=scene))[len(outcome.description.assumptions) :]
    assert line.startswith("of vehicle A these were not measured, but are those of the library's")
    assert line.endswith("minivan, with the spread among such vehicles: yaw inertia")
    findings = found_of(replace(outcome, scene=scene))
    assert findings.assumptions[-1] == line
    (row,) = (row for row in findings.measured if row.name == "yaw_inertia_a")
    assert row.assumed == "value"


def test_answer_gives_the_speed_with_its_interval_in_both_systems(outcome):
    assert found_of(outcome).answers["si"] == (
        "Vehicle B (saloon B) was travelling at about 19.1 m/s (69 km/h; 43 mph) before impact; "
        "given the model and the inputs below, with 95 % probability between "
        "17.4 and 21.0 m/s (63 and 76 km/h; 39 and 47 mph)."
    )
    assert "about 43 mph (19.1 m/s; 69 km/h)" in found_of(outcome).answers["us"]


def test_answer_states_both_speeds_where_neither_is_known(sparse):
    of_a, of_b, struck = found_of(sparse).answers["si"].split(". ")
    assert of_a.startswith(
        "Vehicle A (saloon A) was travelling at about 20.3 m/s (73 km/h; 45 mph) before impact"
    )
    assert of_b.startswith("Vehicle B (saloon B) was travelling at about 22.")
    assert "before it skidded" in of_b
    assert struck.startswith("It struck at about 19.1 m/s")


def test_what_the_model_leaves_out_of_the_scene_is_said(outcome):
    berm = replace(outcome.scene.surfaces[0], name="berm")
    scene = replace(outcome.scene, surfaces=(outcome.scene.surfaces[0], berm))
    simple = RUNGS["planar-moment+spin"].description(scene)
    left_out, locked = simplifications(replace(outcome, scene=scene, description=simple))
    assert left_out.endswith("everywhere: it leaves out the berm.")
    assert locked.startswith("All wheels of A and B are taken as locked")
    full = RUNGS["planar-moment+wheels"].description(scene)
    assert simplifications(replace(outcome, scene=scene, description=full)) == (locked,)


def test_no_speed_is_rounded_to_tens(outcome):
    speed = outcome.idata["posterior"]["speed_b"]
    wide = outcome.idata.copy()
    wide["posterior"] = (
        wide["posterior"]
        .to_dataset()
        .assign(speed_b=12 + 4.6 / 0.9 * (speed - float(speed.median())))
    )
    said = found_of(replace(outcome, idata=wide)).answers["us"]
    assert re.search(r"about 27 mph \(12 m/s; 43 km/h\)", said), said


def test_a_misfit_stands_beside_the_answer(outcome):
    flag = f"{UNEXPLAINED}: the probability of so large a misfit is 7e-05"
    off = replace(outcome, checks=replace(outcome.checks, flags=(flag,)))
    assert f"But {UNEXPLAINED}" in found_of(off).answers["si"]
    assert UNEXPLAINED not in found_of(outcome).answers["si"]
    flag = f"restitution e of about 0.90 {UNSUPPORTED}: one of them is wrong"
    off = replace(outcome, checks=replace(outcome.checks, flags=(flag,)))
    assert found_of(off).answers["si"].endswith(f"But {flag}.")


def test_each_speed_is_withheld_by_its_own_checks(sparse):
    half = replace(sparse, checks=replace(sparse.checks, failed=("speed_a",)))
    of_a, of_b, _ = found_of(half).answers["si"].split(". ")
    assert of_a == (
        "Vehicle A (saloon A): its speed before impact is withheld, because checks of the draws failed"
    )
    assert "22." in of_b


def test_answer_is_withheld_when_checks_fail(failing):
    text = found_of(failing).answers["si"]
    assert WITHHELD in text
    assert not any(c.isdigit() for c in text)
