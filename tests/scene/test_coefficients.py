"""Coefficients of the impact in a scene file: measured ones are evidence, exact ones are fixed."""

from __future__ import annotations

import pytest
from retrodict.models import rungs_for

from retrodict.explore.controls import controls
from retrodict.scene import SceneError, parse_scene
from retrodict.scene.priors import default_priors
from retrodict.scene.records import Measured
from retrodict.scene.write import scene_toml
from tests.shared.scene_file import SCENE, without


def stated(*lines: str, scene: str = SCENE) -> str:
    return scene.replace("[impact]\npoint", "\n".join(["[impact]", *lines, "point"]))


BARE = without("fast", "slow", "over", 'source = "bumper', "[priors.e]")


def test_a_measured_coefficient_is_evidence_and_is_written_again() -> None:
    text = stated(
        'e = { value = 0.1, sd = 0.05, source = "a test" }',
        'e_m = "0.8 ± 0.1"',
        'mu = "0.5 ± 10 %"',
    )
    scene = parse_scene(text, "bend")
    assert scene.coefficients["e"] == Measured(0.1, 0.05, source="a test")
    assert scene.evidence()["impact_mu"] == Measured(0.5, 0.05)
    assert scene.evidence()["impact_e_m"].sd == 0.1
    assert parse_scene(scene_toml(scene), "bend").coefficients == scene.coefficients
    control = next(c for c in controls(scene) if c.key == "impact.e")
    assert (control.group, control.value, control.sd) == ("Evidence", 0.1, 0.05)
    assert not parse_scene(SCENE, "bend").coefficients


@pytest.mark.slow
def test_rungs_that_have_a_coefficient_explain_it_and_no_others() -> None:
    lines = ('e = "0.1 ± 0.05"', 'e_m = "0.8 ± 0.1"', 'mu = "0.5 ± 0.1"')
    scene = parse_scene(stated(*lines), "bend")
    for name, rung in rungs_for(scene).items():
        for coefficient in ("e", "e_m", "mu"):
            has = coefficient in rung.answers
            assert rung.explains(f"impact_{coefficient}") == has, name
            assert (f"impact_{coefficient}" in rung.of_scene(scene)[0].evidence) == has, name


def test_an_exact_coefficient_is_fixed_and_not_asked() -> None:
    scene = parse_scene(stated("e = 0.6", scene=BARE), "bend")
    prior = scene.priors["e"]
    assert (prior.family, prior.numbers, prior.text) == ("fixed", (0.6,), "fixed at 0.6")
    assert prior.source == "impact.e, written without an uncertainty"
    assert default_priors()["e"].text in prior.reason
    assert not scene.coefficients
    assert "e" not in scene.reported()
    assert (
        "e"
        not in parse_scene(without("question"), "bend")
        .change({"impact.e": 0.6, "priors.e": None})
        .question
    )
    again = parse_scene(scene_toml(scene), "bend")
    assert again.priors["e"].numbers == (0.6,)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (stated("e = 1.4"), "impact.e = 1.4: not plausible; write a plain number between 0 and 1"),
        (stated('mu = "-0.3 ± 0.1"'), "its sign follows from the sliding"),
        (stated("e = 0.6"), "impact.e = 0.6: priors.e is written too; keep one of them"),
        (
            stated('e = "0.6 ± 0.1"').replace("fast = 0.2", 'family = "fixed"\nvalue = 0.6')
            .replace('slow = 0.6\nover = "12 mph"\n', ""),
            "priors.e is written too",
        ),
        (stated("mu = 0.5"), "mu is fixed by its prior, so that nothing is asked"),
    ],
)  # fmt: skip
def test_what_contradicts_is_refused(text: str, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        parse_scene(text, "bend.toml")
    assert said in str(caught.value)
