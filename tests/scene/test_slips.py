"""Slips of the pen: each is refused or warned of, in words that say what is wrong."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from retrodict.scene import SceneError, parse_scene
from retrodict.scene.load import load_scene
from retrodict.scene.plausibility import plausibility_warnings
from retrodict.scene.records import Scene
from retrodict.scene.slips import CONFLICT, _least_squares, as_bearings, misfit, with_centres
from tests.shared import random_scenes

ROOT = Path(__file__).parents[2]
USERS = ROOT / "benchmarks" / "users" / "scenes"
SPEED = '"30 ± 1.5 mph"'
ROAD = 'kind = "dry asphalt"'
REST_A, REST_B = '["1.9 m", "0.8 m"]', '["7.1 m", "7.1 m"]'
FAR = '["112 ± 0.5 m", "0 ± 0.5 m"]'
FORWARD = 'value = -32.2, sd = 1.5, unit = "km/h"'
OTHER_SIGN = "had the other sign"

# scene; what is written instead of what; what must be said
SLIPS = [
    # angles
    ("corner", 'angle = "6 deg"', 'angle = "96 deg"', "all would fit if "),
    ("corner", 'angle = "75 deg"', 'angle = "-75 deg"', f"angle of B's impact centre {OTHER_SIGN}"),
    ("corner", 'angle = "75 deg"', 'angle = "75 rad"', "between -6.283 and 6.283 rad"),
    ("corner", 'contact_line = "0', 'contact_line = "90', "counted from the x axis"),
    ("corner", 'contact_line = "0 ± 4 deg"', 'contact_line = "0 deg"', 'like "-8.9 ± 3 deg"'),
    ("corner", 'impact = { heading = "0 deg" }', 'impact = { heading = "180 deg" }', "a heading"),
    ("corner", 'impact = { heading = "90 deg"', 'impact = { heading = "-90 deg"', "a heading"),
    ("corner", 'impact = { heading = "0 deg" }', 'impact = { heading = "0" }', 'write "0 deg"'),
    ("corner", 'rotation = "104 deg"', 'rotation = "-104 deg"', "differ by 104 deg"),
    ("corner", 'rotation = "104 deg"', 'rotation = "22 deg"', "within 45 deg of that"),
    ("corner", 'heading = "104 deg"', 'heading = "-76 deg"', "differ by -76 deg"),
    ("corner", 'heading = "93 deg"', 'heading = "273 deg"', "differ by -177 deg"),
    ("corner", 'heading = "93 deg"', 'heading = "933 deg"', "whole turns go into rotation"),
    ("module-components", 'heading = "90 deg"', 'heading = "-90 deg"', "A's heading at impact was 180"),
    ("module-components", '"-170 deg"', '"10 deg"', "B's heading at impact was 180 deg off"),
    ("module-components", 'angle = "60 deg"', 'angle = "-60 deg"', f"B's impact centre {OTHER_SIGN}"),
    ("module-components", '"95 ± 5 deg"', '"5 ± 5 deg"', "impact.contact_line: "),
    ("rear-end-motorway", 'angle = "180 deg"', 'angle = "0 deg"', "A's impact centre lay at its other"),
    ("rear-end-motorway", '"2.6 m", angle = "0', '"2.6 m", angle = "180', "B's impact centre lay at"),
    ("rear-end-motorway", 'line = "0 ± 2', 'line = "90 ± 2', "counted from the x axis"),
    ("rear-end-motorway", 'direction = "0 deg"', 'direction = "180 deg"', "travels backwards"),
    ("parked-car", 'angle = "165 deg"', 'angle = "-165 deg"', f"B's impact centre {OTHER_SIGN}"),
    # places
    ("corner", REST_B, '["-7.1 m", "7.1 m"]', f"x of B's rest position {OTHER_SIGN}"),
    ("corner", REST_B, '["7.1 m", "-7.1 m"]', f"y of B's rest position {OTHER_SIGN}"),
    ("corner", REST_B, '["71 m", "71 m"]', "B's rest position"),
    ("corner", REST_B, '["7.1 m"]', "write position = "),
    ("corner", REST_B, '["7.1", "7.1"]', 'write "7.1 m"'),
    ("corner", REST_B, '["7,1 m", "7,1 m"]', "decimal point"),
    ("corner", REST_B, '["50311 m", "7.1 m"]', "origin near the impact"),
    ("corner", REST_A, '["-1.9 m", "-0.8 m"]', f"x of A's rest position {OTHER_SIGN}"),
    ("corner", REST_A, '["19 m", "8 m"]', "A's rest position was in ft, not in m"),
    ("rear-end-motorway", FAR, '["-112 ± 0.5 m", "0 ± 0.5 m"]', f"x of A's rest position {OTHER_SIGN}"),
    ("rear-end-motorway", FAR, '["0 ± 0.5 m", "112 ± 0.5 m"]', "x and y of A's rest position were"),
    ("officer", 'distance = "7.05 ft"', 'distance = "7.05 m"', "outside the vehicle"),
    ("officer", 'distance = "3.3 ft"', 'distance = "3.3 in"', "default uncertainty is over 100 %"),
    ("corner", 'distance = "2.0 m"', 'distance = "20 m"', "outside the vehicle"),
    ("corner", 'distance = "2.0 m"', 'distance = "0.2 m"', "within each other at impact"),
    ("corner", 'distance = "0.95 m"', 'distance = "0 m"', "between 0.01 and 20 m"),
    # vehicles
    ("corner", '"1520 kg"', '"1520 lb"', "1520 kg were it in kilograms"),
    ("corner", '"1520 kg"', '"15200 kg"', "is more than cars with a wheelbase of 2.70 m have"),
    ("corner", '"1520 kg"', '"152 kg"', "is less than cars with a wheelbase of 2.70 m have"),
    ("corner", '"1520 kg"', '"1,520 kg"', "vehicles.A.mass"),
    ("officer", '"3520 lb ± 3 %"', '"3520 kg ± 3 %"', "1597 kg were it in pounds"),
    ("parked-car", '"3050 lb"', '"3050 kg"', "1383 kg were it in pounds"),
    ("rear-end-motorway", '"7400 ± 200 kg"', '"7.4 ± 0.2 kg"', "between 50 and 100000 kg"),
    ("corner", 'wheelbase = "2.70 m"', 'wheelbase = "2.70 ft"', "wheelbase of 0.82 m"),
    ("corner", 'wheelbase = "2.70 m"', 'wheelbase = "270 m"', "between 0.05 and 20 m"),
    ("corner", 'wheelbase = "2.70 m"', 'wheelbase = "4.60 m"', "not the length of the vehicle"),
    ("corner", 'track = "1.50 m"', 'track = "1.50 ft"', "of the wheelbase, where cars have"),
    ("officer", 'wheelbase = "107.4 in"', 'wheelbase = "107.4 ft"', "between 0.164 and 65.62 ft"),
    ("officer", 'length = "190.6 in"', 'length = "72.2 in"', "shorter than the wheelbase of 107.4 in"),
    ("rear-end-motorway", "front_left = 0.42", "front_left = 42", "between 0 and 1"),
    # motion
    ("corner", SPEED, '"30 ± 1.5 m/s"', "A's speed was in mph, not in m/s"),
    ("corner", SPEED, '"300 ± 1.5 mph"', "momentum or a rotation is off by 36"),
    ("corner", SPEED, '"-30 ± 1.5 mph"', "between 0 and 335.5 mph"),
    ("corner", SPEED, '"30 mph"', 'write it like "45 ± 2 mph"'),
    ("corner", SPEED, '"30 ± 1.5"', 'write "30 ± 1.5 m/s"'),
    ("corner", SPEED, '"30 ± 1.5 %"', "no unit"),
    ("corner", SPEED, '"30 ± 1.5 mhp"', 'did you mean "mph"'),
    ("officer", '"38 ft" }', '"38 ft", speed = "44 ± 2 mph" }', "A's speed was that before its skid"),
    ("officer", 'skid = "38 ft"', 'skid = "38"', 'write "38 m"'),
    ("officer", "approach = { skid", "skid = { length", "belongs in [vehicles.A.approach]"),
    ("module-components", "value = -32.2", "value = 32.2", f"A's delta_v_forward {OTHER_SIGN}"),
    ("module-components", FORWARD, FORWARD.replace("km/h", "m/s"), "delta_v_forward was in km/h"),
    ("module-components", "value = 52, sd = 2, unit = \"km/h\"", "value = 52, sd = 2, unit = \"m/s\"",
     "A's speed was in km/h, not in m/s"),
    ("module-components", "value = -32.2, sd = 1.5", "value = -32.2", "needs an uncertainty"),
    # the road
    ("corner", ROAD, 'friction = "7 ± 0.3"', "between 0.01 and 1.5"),
    ("corner", ROAD, 'friction = "0.72 ± 0.3"', "see that it is not half a range"),
    ("corner", ROAD, 'friction = "0.72 ± 0.03 g"', "write it without a unit"),
    ("corner", ROAD, 'kind = "tarmac"', 'write one of "dry asphalt"'),
    ("corner", ROAD, 'drag_factor = "0.72 ± 0.03"', "belongs in [vehicles.A]"),
]  # fmt: skip


def said(text: str, name: str) -> str:
    """What `retrodict check` says of a scene file, but that it is fine."""
    try:
        return "\n".join(plausibility_warnings(parse_scene(text, name)))
    except SceneError as error:
        return str(error)


@cache
def written(name: str) -> str:
    return (USERS / f"{name}.toml").read_text("utf-8")


@pytest.mark.parametrize(("name", "old", "new", "words"), SLIPS)
def test_each_slip_is_named(name: str, old: str, new: str, words: str) -> None:
    text = written(name)
    assert old in text
    assert words not in said(text, name)
    assert words in said(text.replace(old, new, 1), name)


def test_there_are_at_least_as_many_slips_as_users_made() -> None:
    assert len({slip[:3] for slip in SLIPS}) >= 66


def test_both_impact_centres_mirrored_are_named() -> None:
    text = written("corner").replace('"6 deg"', '"-6 deg"').replace('"75 deg"', '"-75 deg"')
    assert f"the angles of both impact centres {OTHER_SIGN}" in said(text, "corner")


def test_exchanged_components_of_delta_v_are_named() -> None:
    text = written("module-components")
    text = text.replace("value = -32.2", "value = 0").replace("value = 11.1", "value = -32.2")
    text = text.replace("value = 0,", "value = 11.1,")
    assert "delta_v_forward and delta_v_left were exchanged" in said(text, "module-components")


def test_exchanged_rests_are_named_where_rotations_are_written() -> None:
    a = '["1.9 m", "0.8 m"], heading = "104 deg", rotation = "104 deg"'
    b = '["7.1 m", "7.1 m"], heading = "93 deg", rotation = "3 deg"'
    text = written("corner").replace(a, "of A").replace(b, a).replace("of A", b)
    assert "the rest poses of A and B seem exchanged" in said(text, "corner")


@cache
def crashes() -> tuple[Scene, ...]:
    """Simulated crashes in which both vehicles travelled nearly along their headings."""

    def crash(seed: int) -> Scene:
        rng = np.random.default_rng(seed)
        off = np.radians(3)
        scene, _ = random_scenes.scene(rng, off=rng.normal(0, off))
        heading = scene.vehicles["b"].heading
        along = replace(heading, sd=float(np.hypot(heading.sd, off)), assumed="value")
        approach = scene.approach | {"b": replace(scene.approach["b"], direction=along)}
        return replace(scene, approach=approach)

    return tuple(map(crash, range(40)))


def test_no_crash_without_a_slip_is_in_conflict() -> None:
    assert max(map(misfit, crashes())) < CONFLICT


def scenes() -> Iterator[Path]:
    """Scenes of two vehicles as users write them, and the examples."""
    for file in sorted([*USERS.glob("*.toml"), *(ROOT / "examples").glob("*/scene.toml")]):
        tables = tomllib.loads(file.read_text("utf-8"))
        if "barrier" not in tables and not tables.get("alone"):
            yield file


@pytest.mark.parametrize("file", [*scenes()], ids=lambda file: f"{file.parent.name}-{file.stem}")
def test_no_scene_of_users_is_in_conflict(file: Path) -> None:
    assert misfit(load_scene(file)) < CONFLICT


def _x_mirrored(scene: Scene) -> Scene:
    rest = scene.rest["b"]
    x = replace(rest.x, value=-rest.x.value)
    return replace(scene, rest=scene.rest | {"b": replace(rest, x=x)})


def _from_x(scene: Scene) -> Scene:
    line = scene.contact.Gamma
    turned = replace(line, value=line.value + np.pi / 2)
    return replace(scene, contact=replace(scene.contact, Gamma=turned))


def _rests_exchanged(scene: Scene) -> Scene:
    return replace(scene, rest={"a": scene.rest["b"], "b": scene.rest["a"]})


def _mph_as_m_s(scene: Scene) -> Scene:
    approach = scene.approach["a"]
    assert approach.speed
    speed = replace(approach.speed, value=round(approach.speed.value / 0.44704))
    return replace(scene, approach=scene.approach | {"a": replace(approach, speed=speed)})


@pytest.mark.parametrize(
    ("slip", "named", "share"),
    [
        (as_bearings, "compass bearings", 0.5),
        (lambda scene: with_centres(scene, "ab"), "both impact centres", 0.35),
        (_from_x, "counted from the x axis", 0.8),
        (_x_mirrored, "x of B's rest position", 0.3),
        (_rests_exchanged, "the rest positions of A and B", 0.3),
        (_mph_as_m_s, "A's speed was in mph, not in m/s", 0.3),
    ],
)
def test_slips_of_crashes_at_random_are_named(
    slip: Callable[[Scene], Scene], named: str, share: float
) -> None:
    """Of so many: the others fit as well with the slip as without."""
    named_in = [
        any(named in line for line in plausibility_warnings(slip(own))) for own in crashes()
    ]
    assert np.mean(named_in) >= share


def test_least_squares_with_bounds_are_those_of_scipy() -> None:
    rng = np.random.default_rng(5)
    for _ in range(30):
        rows, right = rng.normal(size=(12, 8)), rng.normal(size=12)
        low = np.full(8, -np.inf)
        low[[0, 2]] = 0
        expected = lsq_linear(rows, right, bounds=(low, np.inf), tol=1e-13)
        x, distance = _least_squares(rows, right, [0, 2])
        assert distance == pytest.approx(np.sqrt(2 * expected.cost), rel=1e-7)
        assert x == pytest.approx(expected.x, abs=1e-5)
