"""What a scene file may state of the energy lost in the impact, and what is said of it."""

from __future__ import annotations

import numpy as np
import pytest

from retrodict.explore.controls import controls
from retrodict.scene import SceneError, parse_scene
from retrodict.scene.energy import CLASS_STIFFNESS_ERROR, ENERGY
from retrodict.scene.plausibility import plausibility_warnings
from retrodict.scene.records import Measured
from retrodict.scene.write import scene_text, scene_toml
from tests.shared.scene_file import SCENE

LINE = 'contact_line = "-8.9 ± 3 deg"\n'


def stating(*lines: str) -> str:
    return SCENE.replace(LINE, LINE + "\n".join(lines) + "\n")


def test_a_scene_file_states_the_energy_and_states_it_again() -> None:
    text = stating(
        'energy_lost_at_least = { value = 60, sd = 25, unit = "kJ", source = "crush" }',
        'energy_lost_at_most = "100000 ± 40000 ft lb"',
    )
    scene = parse_scene(text, "stated")
    assert list(scene.energy_lost) == ["energy_lost_at_least", "energy_lost_at_most"]
    assert scene.energy_lost["energy_lost_at_least"] == Measured(6e4, 2.5e4, source="crush")
    most = scene.evidence()["impact_energy_lost_at_most"]
    assert (most.value, most.sd) == pytest.approx((135581.79, 54232.72), rel=1e-6)
    assert scene_text(scene).as_written
    assert parse_scene(scene_toml(scene), "stated").energy_lost == scene.energy_lost
    assert not parse_scene(SCENE, "bend").energy_lost


def test_it_can_be_changed_by_key_and_by_a_slider() -> None:
    scene = parse_scene(SCENE, "bend").change({"impact.energy_lost": "60 kJ ± 40 %"})
    stated = scene.evidence()["impact_energy_lost"]
    assert (stated.value, stated.sd) == pytest.approx((6e4, 2.4e4))
    control = next(c for c in controls(scene) if c.key == "impact.energy_lost")
    assert (control.group, control.unit, control.value, control.sd) == ("Evidence", "kJ", 60, 24)
    assert not scene.change({"impact.energy_lost": None}).energy_lost


@pytest.mark.parametrize(
    ("lines", "key", "fix"),
    [
        (['energy_lost = "60 kJ"'], "energy_lost", "38% or more"),
        (
            ['energy_lost = "60 ± 20 kN"'],
            "energy_lost",
            'does not measure an energy; did you mean "kJ"',
        ),
        (['energy_lost = "60 ± 20"'], "energy_lost", 'write "60 ± 20 J"'),
        (['energy_lost_at_most = "-1 ± 20 kJ"'], "energy_lost_at_most", "between 0 and 100000 kJ"),
        (
            ['energy_lost = "60 ± 30 kJ"', 'energy_lost_at_least = "50 ± 30 kJ"'],
            *("energy_lost", "the same twice"),
        ),
        (
            ['energy_lost_at_least = "60 ± 30 kJ"', 'energy_lost_at_most = "50 ± 30 kJ"'],
            *("energy_lost_at_most", "not above energy_lost_at_least"),
        ),
    ],
)
def test_what_is_wrong_is_said_in_one_line(lines: list[str], key: str, fix: str) -> None:
    with pytest.raises(SceneError) as found:
        parse_scene(stating(*lines), "stated")
    (problem,) = found.value.problems
    assert problem.key == f"impact.{key}"
    assert fix in problem.fix


@pytest.mark.parametrize("key", ENERGY)
def test_it_comes_with_a_warning_and_with_another_where_it_is_sharper(key: str) -> None:

    def said(value: str) -> str:
        found = plausibility_warnings(parse_scene(stating(f'{key} = "{value}"'), "stated"))
        (line,) = [each for each in found if each.startswith("impact.energy")]
        return line

    wide, sharp = said("60 kJ ± 38 %"), said("60 ± 6 kJ")
    assert wide.startswith(f"impact.{key}: energies from crush and stiffness by class missed")
    assert "is smaller" not in wide
    assert sharp.startswith(wide)
    assert "its uncertainty of 10% is smaller: write ± 38%" in sharp


# crush profiles and stiffness by class of the RICSAC crashes (Calspan 1978) by Neades, "Developments
# in Road Vehicle Crush Analysis for Forensic Collision Investigation", thesis, De Montfort University
# 2011, Appendix D: width (cm), A (N/cm), B (N/cm²), six depths (cm); and the loss, ft lbf, by Brach,
# SAE 871993, table 2
RICSAC = {
    "RICSAC-1": (
        64877,
        (117, 624, 23, (10, 14, 18, 26, 31, 38)),
        (288, 246, 46, (1, 30, 27, 30, 23, 10)),
    ),
    "RICSAC-4": (
        128819,
        (105, 624, 23, (16, 20, 25, 32, 38, 46)),
        (106, 684, 28, (91, 81, 74, 61, 50, 38)),
    ),
    "RICSAC-6": (
        58949,
        (138, 624, 23, (1, 1, 3, 4, 4, 6)),
        (196, 246, 46, (10, 30, 45, 49, 43, 21)),
    ),
    "RICSAC-8": (
        71189,
        (185, 624, 23, (7, 9, 0, 0, 0, 0)),
        (215, 251, 35, (16, 21, 23, 15, 11, 2)),
    ),
    "RICSAC-10": (
        100750,
        (121, 528, 32, (18, 26, 36, 23, 23, 23)),
        (135, 251, 35, (23, 17, 15, 13, 11, 1)),
    ),
    "RICSAC-11": (
        103231,
        (83, 454, 30, (56, 51, 47, 43, 38, 32)),
        (82, 624, 23, (75, 67, 58, 47, 36, 28)),
    ),
}


def test_crush_by_class_misses_the_loss_of_staged_crashes_by_about_that_much() -> None:
    """∫ (A C + B C²/2 + A²/2B) dl of both cars (CRASH3), the force taken at a right angle."""
    off = []
    for loss, *cars in RICSAC.values():
        energy = 0.0
        for width, A, B, depths in cars:
            depth = np.array(depths)
            by_length = A * depth + B * depth**2 / 2 + A**2 / (2 * B)  # N
            energy += float(np.trapezoid(by_length, dx=width / 100 / (len(depths) - 1)))
        off.append(energy / (loss * 1.3558179) - 1)
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(CLASS_STIFFNESS_ERROR, abs=0.02)
    assert (min(off), max(off)) == pytest.approx((-0.66, 0.26), abs=0.01)
