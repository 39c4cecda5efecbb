"""Implausible values are flagged, and no others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from retrodict.scene import parse_scene
from retrodict.scene.load import load_scene
from retrodict.scene.plausibility import assumed_approach, plausibility_warnings
from retrodict.scene.records import Measured, Scene
from tests.shared.scene_file import changed, without

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENE = load_scene(EXAMPLES / "brach-1977" / "scene.toml")


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*/scene.toml")), ids=lambda f: f.parent.name)
def test_nothing_in_the_examples_is_flagged(file: Path) -> None:
    assert plausibility_warnings(load_scene(file)) == ()


GAINS = Path(__file__).parents[2] / "benchmarks" / "users" / "scenes" / "gains-energy.toml"


def test_speeds_that_part_faster_than_they_met_are_said_first() -> None:
    """By momentum A had 40 mph: 10 mph before the impact become 15 after it (10 and 15 mph)."""
    first, *_ = plausibility_warnings(load_scene(GAINS))
    assert first.startswith("vehicles.A.departure, vehicles.B.departure: these speeds part faster ")
    assert "(6.7 m/s, 15 mph) than they met (4.5 m/s, 10 mph, by momentum), by 1.9 times" in first


@pytest.mark.parametrize(
    ("old", "new", "flagged"),
    [
        ('"45 ± 1 mph"', '"36 ± 1 mph"', False),  # 6 mph after 4
        ('"45 ± 1 mph"', '"33 ± 1 mph"', False),
        ('"30 ± 1 mph", direction = "0 deg"', '"10 ± 1 mph", direction = "0 deg"', False),
        ('direction = "0 ± 2 deg" }\n\n[impact]', 'direction = "60 ± 2 deg" }\n\n[impact]', True),
    ],
)
def test_a_gain_of_energy_is_one_beyond_the_errors(old: str, new: str, flagged: bool) -> None:
    text = GAINS.read_text("utf-8")
    assert old in text
    said = plausibility_warnings(parse_scene(text.replace(old, new), "two cars"))
    assert any("part faster" in line for line in said) == flagged


def test_vehicles_on_one_side_of_the_contact_line_are_flagged() -> None:
    angle = SCENE.vehicles["a"].impact_angle
    (odd,) = plausibility_warnings(
        _with(SCENE, "a", impact_angle=replace(angle, value=angle.value + np.pi))
    )
    assert odd.startswith(
        "impact.contact_line: both centres of gravity lie on one side of it, A's 2.0 m"
    )


def _with(scene: Scene, v: str, **parts: Measured) -> Scene:
    return replace(scene, vehicles=scene.vehicles | {v: replace(scene.vehicles[v], **parts)})


def test_a_yaw_inertia_in_another_unit_is_flagged() -> None:
    as_meant = SCENE.vehicles["a"].yaw_inertia
    # a figure in lb ft s² that was written as kg m², and one in kg m² that was written as lb ft s²
    for factor in (1 / 1.3558, 1.3558):
        assert not plausibility_warnings(
            _with(SCENE, "a", yaw_inertia=replace(as_meant, value=factor * as_meant.value))
        )
    # lb ft² for lb ft s²: g in ft/s² apart
    odd = plausibility_warnings(
        _with(SCENE, "a", yaw_inertia=replace(as_meant, value=32.2 * as_meant.value))
    )
    assert len(odd) == 1
    assert odd[0].startswith("vehicles.A.yaw_inertia: ")


def test_a_vehicle_that_travels_backwards_is_flagged() -> None:
    approach = SCENE.approach["a"]
    assert approach.direction is not None
    turned = replace(approach.direction, value=approach.direction.value + np.pi)
    odd = plausibility_warnings(
        replace(SCENE, approach=SCENE.approach | {"a": replace(approach, direction=turned)})
    )
    assert len(odd) == 1
    assert odd[0].startswith("vehicles.A.approach.direction: 180 deg off")


def test_a_rest_far_sharper_than_a_run_out_can_follow_is_flagged() -> None:
    rolled = changed(('front_left = "locked"', 'front_left = "rolling"'))
    near, far = (rolled.replace('"-5.1 ± 0.15 m"', f'"{x} ± 0.15 m"') for x in (-15.1, -105.1))

    def sharp(text: str) -> list[str]:
        found = plausibility_warnings(parse_scene(text, "bend"))
        return [line for line in found if line.startswith("vehicles.A.rest.position")]

    assert not sharp(near)
    scene = parse_scene(far, "bend")
    (odd,) = sharp(far)
    missed = scene.evidence()["rest_x_a"].model_sd
    assert odd.startswith("vehicles.A.rest.position: measured to 0.15 m, but A rolled 107 m, ")
    assert f"misses it by about {missed:.2g} m" in odd
    assert not sharp(far.replace("105.1 ± 0.15", "105.1 ± 5"))


def test_vehicles_within_each_other_are_flagged() -> None:
    near = {v: replace(own, impact_distance=Measured(0.1)) for v, own in SCENE.vehicles.items()}
    odd = [
        line
        for line in plausibility_warnings(replace(SCENE, vehicles=near))
        if "within each other" in line
    ]
    assert len(odd) == 1
    assert odd[0].startswith("vehicles.A.impact_centre, vehicles.B.impact_centre: ")


def test_it_is_said_whose_direction_of_travel_is_assumed():
    text = without("direction", "yaw_rate")
    assert assumed_approach(parse_scene(text, "bend")).startswith(
        "A and B are taken to travel along"
    )
    slid = text.replace('speed = "45 ± 2 mph"', 'speed = "45 ± 2 mph"\ndirection = "unknown"')
    assert assumed_approach(parse_scene(slid, "bend")).startswith("B is taken to travel along its")


@pytest.mark.parametrize(
    ("mass", "said"),
    [
        ("3520 kg", "1597 kg were it in pounds: look at both"),
        ("1600 lb", "less than cars with a wheelbase of 2.75 m have"),
        ("3520 lb", ""),
        ("2300 kg", ""),
    ],
)
def test_a_mass_in_the_wrong_unit_is_flagged(mass: str, said: str) -> None:
    scene = parse_scene(changed(('mass = "1778 kg"', f'mass = "{mass}"')), "bend")
    found = [each for each in plausibility_warnings(scene) if each.startswith("vehicles.B.mass")]
    assert len(found) == bool(said)
    assert all(said in each for each in found)


def test_a_delta_v_towards_the_other_vehicle_is_flagged() -> None:
    """A is struck at its front: an impact takes forward speed from it."""
    for sign, flagged in (("-", False), ("", True)):
        text = changed(('delta_v_forward = "-13 ± 1 m/s"', f'delta_v_forward = "{sign}13 ± 1 m/s"'))
        found = plausibility_warnings(parse_scene(text, "bend"))
        assert any("delta_v_forward" in each and "sign" in each for each in found) == flagged
