"""Scene files that are right: what becomes of each entry."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from scipy import special, stats

from retrodict.scene import SceneError, load_scene, parse_scene
from retrodict.scene.quantities import describe, unit_of
from retrodict.scene.records import Measured
from tests.shared.scene_file import OIL, SCENE, changed, stripped, without

DEGREE = math.pi / 180


def close(measured: Measured, value: float, sd: float) -> bool:
    return measured.value == pytest.approx(value) and measured.measured_sd == pytest.approx(sd)


def test_written_quantities_arrive_in_si_and_are_not_called_assumed():
    scene = parse_scene(SCENE, "bend")
    a = scene.vehicles["a"]
    written = {
        "mass_a": (1857, 37, "lognormal"),
        "yaw_inertia_a": (3374, 270, "lognormal"),
        "front_axle_a": (1.35, 0, "lognormal"),
        "rear_axle_a": (1.5, 0, "lognormal"),
        "track_a": (1.54, 0, "lognormal"),
        "impact_distance_a": (2.09, 0.05, "lognormal"),
        "impact_angle_a": (10 * DEGREE, 2 * DEGREE, "normal"),
        "heading_a": (math.pi, 2 * DEGREE, "normal"),
        "speed_a": (20.1168, 0.89408, "normal"),
        "direction_a": (181 * DEGREE, 2 * DEGREE, "normal"),
        "omega_a": (0, DEGREE, "normal"),
        "grip_a": (1.02, 0.04, "lognormal"),
        "skid_a": (12, 0.4, "lognormal"),
        "drag_front_left_a": (1, 0, "logitnormal"),
        "drag_rear_left_a": (0.3, 0.1, "logitnormal"),
        "drag_rear_right_a": (0.2, 0.05, "logitnormal"),
        "steer_a": (3 * DEGREE, 2 * DEGREE, "normal"),
        "impact_x": (0.1, 0.3, "normal"),
        "impact_y": (-0.2, 0.3, "normal"),
        "Gamma": (-8.9 * DEGREE, 3 * DEGREE, "normal"),
        "friction_road": (0.5, 0.03, "lognormal"),
        "friction_berm": (0.4, 0.03, "lognormal"),
        "speed_dependence_berm": (0.002, 0.001, "normal"),
        "edge_berm": (0, 0.2, "normal"),
        "rest_x_a": (-5.1, 0.15, "normal"),
        "rest_y_a": (1.9, 0.15, "normal"),
        "rest_heading_a": (215 * DEGREE, 3 * DEGREE, "normal"),
        "departure_direction_a": (160 * DEGREE, 5 * DEGREE, "normal"),
        "departure_speed_a": (5, 1, "normal"),
        "departure_yaw_rate_a": (35 * DEGREE, 5 * DEGREE, "normal"),
        "departure_delta_v_forward_a": (-13, 1, "normal"),
        "departure_delta_v_left_a": (-2, 1, "normal"),
        "departure_delta_v_b": (30 * 0.44704, 2 * 0.44704, "normal"),
        "mark_1_a": (0, 0.2, "normal"),
        "mark_1_speed_a": (4, 1, "normal"),
        "mark_2_course_a": (170 * DEGREE, 4 * DEGREE, "normal"),
        "end_x_a": (-4, 0.5, "normal"),
        "end_y_a": (1.5, 0.4, "normal"),
        "end_heading_a": (200 * DEGREE, 5 * DEGREE, "normal"),
    }
    found = scene.inputs() | scene.evidence()
    for name, (value, sd, law) in written.items():
        assert close(found[name], value, sd), name
        assert (found[name].law, found[name].assumed) == (law, ""), name
    assert (a.name, a.length, a.width) == ("sedan", 5.2, 1.8)
    assert (scene.title, scene.name, scene.text) == ("Two cars on a bend", "bend", SCENE)
    assert scene.notes == ("a remark", "another")
    assert scene.robust


def test_a_scene_may_be_silent_of_all_but_one_item_of_evidence():
    scene = parse_scene(stripped('departure = { delta_v = "12 ± 1 m/s" }'), "bend")
    assert list(scene.evidence()) == ["departure_delta_v_b"]
    assert (scene.rest, scene.marks, scene.robust) == ({}, {}, False)
    for v in "ab":
        assert (scene.approach[v].speed, scene.approach[v].skid) == (None, None)
    assert scene.question == ("speed_a", "speed_b", "e", "e_m", "mu")
    assert {"speed_a", "speed_b"} < set(scene.reported())
    (road,) = scene.surfaces
    assert (road.edge, road.friction.assumed) == (None, "value")
    assert close(road.friction, 0.75, 0.07)
    assert "dry asphalt" in road.friction.source


def test_the_speed_of_either_vehicle_may_be_known():
    text = stripped('approach = { speed = "45 ± 2 mph" }\nrest = { position = ["9 m", "1 m"] }')
    scene = parse_scene(text + "[surfaces.road]\nfriction = '0.5 ± 0.1'\n", "bend")
    assert scene.approach["a"].speed is None
    assert close(scene.approach["b"].speed, 20.1168, 0.89408)
    assert "speed_b" in scene.inputs()
    assert list(scene.evidence()) == ["rest_x_b", "rest_y_b"]
    assert (scene.rest["b"].heading, scene.rest["b"].turns_known) == (None, False)


def test_what_is_assumed_before_and_after_the_impact_says_so():
    text = changed(
        ('"12 ± 0.4 m"', '"12 m"'), ('"160 ± 5 deg"', '"160 deg"'), ('"170 ± 4 deg"', '"170 deg"')
    )
    scene = parse_scene(text, "bend")
    assumed = {
        "skid_a": (12, 0.5, "0.5 m"),
        "departure_direction_a": (160 * DEGREE, 8 * DEGREE, "8 deg"),
        "mark_2_course_a": (170 * DEGREE, 8 * DEGREE, "8 deg"),
        "mark_2_a": (0, 0.15, "taped; uncertainty assumed: 0.15 m"),
    }
    found = scene.inputs() | scene.evidence()
    for name, (value, sd, figure) in assumed.items():
        assert close(found[name], value, sd), name
        assert found[name].assumed == "sd", name
        assert f"{figure} (grade C" in found[name].source, name


def test_marks_keep_their_place_and_what_passed_there():
    first, second = parse_scene(SCENE, "bend").marks["a"]
    assert (first.x, first.y, first.sd, first.of) == (-2, 0.5, 0.2, "front_left")
    assert (second.x, second.y, second.of) == (-3, 1, "centre")
    assert second.speed is first.course is None


def test_any_part_of_an_end_of_rotation_is_evidence_by_itself():
    text = stripped('end_of_rotation = { heading = "20 ± 5 deg" }')
    scene = parse_scene(text + "[surfaces.road]\nfriction = '0.5 ± 0.1'\n", "bend")
    assert list(scene.evidence()) == ["end_heading_b"]


def test_missing_uncertainties_and_values_are_assumed_and_say_so():
    silent = without("speed_dep", "direction", "yaw_rate", "length", "width", "steer")
    scene = parse_scene(silent.replace('friction = "0.50 ± 0.03"', ""), "bend")
    inertia = 1778 * (0.49 * 2.75) ** 2
    assumed = {
        "mass_b": (1778, 0.02 * 1778, "sd", "2 %"),
        "yaw_inertia_b": (inertia, 0.08 * inertia, "value", "0.49 wheelbases"),
        "front_axle_b": (0.45 * 2.75, 0.03 * 2.75, "value", "0.45 wheelbases"),
        "rear_axle_b": (0.55 * 2.75, 0.03 * 2.75, "value", "0.45 wheelbases"),
        "impact_distance_b": (1.76, 0.10, "sd", "0.1 m"),
        "impact_angle_b": (60 * DEGREE, 3 * DEGREE, "sd", "3 deg"),
        "heading_b": (8 * DEGREE, 3 * DEGREE, "sd", "3 deg"),
        "direction_a": (math.pi, math.hypot(2, 3) * DEGREE, "value", "heading at impact"),
        "direction_b": (8 * DEGREE, math.hypot(3, 3) * DEGREE, "value", "± 3 deg"),
        "grip_b": (1, 0.05, "value", "5 % (grade B"),
        "drag_front_right_a": (0.014 / 0.75, 0.007 / 0.75, "value", "0.014 of the load (grade B"),
        "drag_factor_a": (1, 0.3, "value", "30 % (grade B"),
        "steer_a": (0, 0, "value", "straight ahead"),
        "friction_road": (0.75, 0.07, "value", "dry asphalt: 0.75 ± 0.07 (grade B"),
        "omega_a": (0, 5 * DEGREE, "value", "5 deg/s"),
        "omega_b": (0, 5 * DEGREE, "value", "5 deg/s"),
        "speed_dependence_road": (0, 0, "value", "does not depend"),
        "speed_dependence_berm": (0, 0, "value", "does not depend"),
        "rest_x_b": (6.1, 0.15, "sd", "0.15 m"),
        "rest_heading_b": (-12 * DEGREE, 3 * DEGREE, "sd", "3 deg"),
    }
    found = scene.inputs() | scene.evidence()
    for name, (value, sd, kind, figure) in assumed.items():
        assert close(found[name], value, sd), name
        assert found[name].assumed == kind, name
        assert figure in found[name].source, name
    a, b = scene.vehicles["a"], scene.vehicles["b"]
    assert (a.length, a.width) == pytest.approx((1.35 + 1.5 + 1.9, 1.54 + 0.25))
    assert b.name == "vehicle B"


def test_a_vehicle_whose_wheels_are_locked_has_no_inputs_for_them():
    scene = parse_scene(SCENE, "bend")
    assert scene.vehicles["b"].wheels is None
    assert not [n for n in scene.inputs() if n.endswith("_b") and n.startswith(("drag", "steer"))]
    said = changed(('mass = "1778 kg"', 'mass = "1778 kg"\nwheels = "locked"'))
    assert parse_scene(said, "bend").inputs() == scene.inputs()


def drags(*changes: tuple[str, str], surface: str = "0.50 ± 0.03") -> dict[str, Measured]:
    """Inputs of A's wheels where the example's front left one, which is locked, is written so."""
    text = changed(*changes).replace('friction = "0.50 ± 0.03"', f'friction = "{surface}"')
    return {k: m for k, m in parse_scene(text, "bend").inputs().items() if k.startswith("drag")}


@pytest.mark.parametrize(
    ("word", "share", "sd"),
    [
        ("locked", 1.0, 0.0),
        ("rolling", 0.014 / 0.5, 0.007 / 0.5),
        ("rolling, in gear", 0.2 / 0.5, 0.08 / 0.5),
        ("damaged", 0.5, 0.425),
    ],
)
def test_a_word_gives_a_wheel_its_share_of_the_friction_of_the_road(word, share, sd):
    drag = drags(('front_left = "locked"', f'front_left = "{word}"'))["drag_front_left_a"]
    assert close(drag, share, sd)
    assert drag.law == "logitnormal"
    assert drag.assumed == ("" if word == "locked" else "value")
    assert word in drag.source


def test_an_engine_that_all_but_locks_a_wheel_on_ice_leaves_a_share():
    gear = ('front_left = "locked"', 'front_left = "rolling, in gear"')
    assert close(drags(gear, surface="0.12 ± 0.05")["drag_front_left_a"], 0.8, 0.16)


def test_a_damaged_wheel_is_anywhere_between_free_and_locked():
    drag = drags(('front_left = "locked"', 'front_left = "damaged"'))["drag_front_left_a"]
    scale = drag.sd / (drag.value * (1 - drag.value))
    shares = np.linspace(0.001, 0.999, 999)
    below = stats.norm.cdf((special.logit(shares) - special.logit(drag.value)) / scale)
    np.testing.assert_allclose(below, shares, atol=0.01)


def test_drags_share_a_factor_where_a_word_gives_one_and_no_other_is_written():
    by_word = ('front_right = "rolling"', 'front_right = "0.02 ± 0.01"')
    wheels = 'steer = "3 ± 2 deg"'
    assert close(drags()["drag_factor_a"], 1.0, 0.3)
    assert "drag_factor_a" not in drags(by_word)  # numbers are as they were written
    written = drags((wheels, f'{wheels}\ndrag_factor = "1.1 ± 0.2"'))["drag_factor_a"]
    assert (written.law, written.assumed) == ("lognormal", "")
    assert close(written, 1.1, 0.2)
    assert close(drags((wheels, f"{wheels}\ndrag_factor = 1"))["drag_factor_a"], 1.0, 0.0)


def test_the_question_has_one_order_and_is_all_unless_written():
    assert parse_scene(SCENE, "bend").question == ("speed_b", "mu")
    assert parse_scene(without("question"), "bend").question == ("speed_b", "e", "e_m", "mu")
    asked = parse_scene(without("question", 'speed = "45'), "bend").question
    assert asked == ("speed_a", "speed_b", "e", "e_m", "mu")


def test_friction_that_is_written_counts_whatever_the_kind():
    road = parse_scene(SCENE, "bend").surfaces[0]
    assert close(road.friction, 0.5, 0.03)


@pytest.mark.parametrize(
    ("kind", "low", "high"),
    [
        ("dry asphalt", 0.72, 0.78),
        ("wet asphalt", 0.45, 0.55),
        ("dry concrete", 0.75, 0.90),
        ("wet concrete", 0.50, 0.60),
        ("gravel", 0.35, 0.70),
        ("dry soil", 0.50, 0.60),
        ("packed snow", 0.20, 0.35),
        ("ice", 0.05, 0.15),
    ],
)
def test_friction_of_a_kind_covers_what_was_published(kind, low, high):
    text = changed(('kind = "dry asphalt"\nfriction = "0.50 ± 0.03"', f'kind = "{kind}"'))
    friction = parse_scene(text, "bend").surfaces[0].friction
    assert low <= friction.value <= high
    assert friction.value - 2 * friction.sd <= low
    assert high <= friction.value + 2 * friction.sd


SLID = (None, None)
ALONG = ((8, math.hypot(3, 3)), (0, 5))


@pytest.mark.parametrize("letter", "AB")
@pytest.mark.parametrize(
    ("written", "direction", "yaw_rate"),
    [
        ("", *ALONG),
        ('direction = "unknown"', *SLID),
        ('direction = "unknown"\nyaw_rate = "30 ± 9 deg/s"', None, (30, 9)),
        ('direction = "16 ± 2 deg"', (16, 2), (0, 5)),
        ('direction = "-22 ± 2 deg"', (-22, 2), None),
        ('direction = "-22 ± 2 deg"\nyaw_rate = "0 ± 2 deg/s"', (-22, 2), (0, 2)),
        ('yaw_rate = "unknown"', ALONG[0], None),
        ('yaw_rate = "25 deg/s"', ALONG[0], (25, 5)),
    ],
)
def test_both_vehicles_travel_along_their_headings_unless_they_slid(
    letter: str, written: str, direction: tuple | None, yaw_rate: tuple | None
):
    text = without("direction", "yaw_rate", "rotation") + "\n"
    text = text.replace('heading = "180 ± 2 deg"', 'heading = "8 deg"')
    of_a = "[vehicles.A.approach]\n"
    text = text.replace(of_a, f"{of_a}{written}\n") if letter == "A" else text
    text += f"[vehicles.B.approach]\n{written}\n" if letter == "B" else ""
    approach = parse_scene(text, "bend").approach
    for v, own in approach.items():
        expected = (direction, yaw_rate) if v == letter.lower() else ALONG
        for measured, numbers in zip((own.direction, own.yaw_rate), expected, strict=True):
            if numbers is None:
                assert measured is None
            else:
                assert measured is not None
                assert close(measured, *(number * DEGREE for number in numbers))


@pytest.mark.parametrize(
    ("at_impact", "at_rest", "rotation", "unwrapped"),
    [
        ("180", "215", "35 deg", 215),
        ("180", "-145", "35 deg", 215),
        ("180", "215", "-325 deg", -145),
        ("180", "215", "2 turn", 180 + 755),
        ("180", "215", "-85 deg", None),
        ("8", "-12", "700 deg", 708),
        ("8", "-12", None, -12),
        ("170", "-170", None, 190),
        ("-170", "170", None, -190),
        ("0", "359", None, -1),
    ],
)
def test_rest_heading_counts_whole_turns(at_impact, at_rest, rotation, unwrapped):
    line = f'rotation = "{rotation}"' if rotation else ""
    text = changed(
        ('heading = "180 ± 2', f'heading = "{at_impact} ± 2'),
        ('heading = "215', f'heading = "{at_rest}'),
        ('rotation = "35 deg"', line),
    )
    if unwrapped is None:
        with pytest.raises(SceneError, match=r"rest\.rotation"):
            parse_scene(text, "bend")
        return
    rest = parse_scene(text, "bend").rest["a"]
    assert close(rest.heading, unwrapped * DEGREE, 3 * DEGREE)
    assert rest.turns_known == (rotation is not None)


def test_the_surface_without_an_edge_comes_first():
    scene = parse_scene(SCENE, "bend")
    road, berm = scene.surfaces
    assert (road.name, road.edge) == ("road", None)
    assert berm.edge is not None
    edge = berm.edge
    assert (edge.x, edge.y, edge.direction) == pytest.approx((0, 4, math.pi / 2))
    assert (berm.name, edge.side) == ("berm", "left")


def test_surfaces_with_outlines_come_last_wherever_they_are_written():
    head, _, tables = SCENE.partition("[vehicles.A]")
    text = head + OIL + OIL.replace("oil", "paint") + "[vehicles.A]" + tables
    scene = parse_scene(text, "bend")
    assert [s.name for s in scene.surfaces] == ["road", "berm", "oil", "paint"]
    oil = scene.surfaces[2]
    assert oil.edge is None
    assert oil.outline.corners == ((3, -5), (7, -6), (8, -3))
    assert scene.inputs()["edge_oil"] == Measured(0.0, 0.2)
    exact = parse_scene(text.replace(', uncertainty = "0.2 m" }\n', " }\n"), "bend")
    assert exact.inputs()["edge_oil"] == exact.inputs()["edge_paint"] == Measured(0.0)


def test_one_axle_distance_and_the_wheelbase_give_the_other():
    a = parse_scene(without("cg_to_rear_axle"), "bend").vehicles["a"]
    assert close(a.rear_axle, 2.85 - 1.35, 0)
    a = parse_scene(without("cg_to_front_axle"), "bend").vehicles["a"]
    assert close(a.front_axle, 2.85 - 1.50, 0)
    assert close(a.rear_axle, 1.50, 0)


def test_axle_distances_alone_give_the_wheelbase_of_the_yaw_inertia():
    a = parse_scene(without("wheelbase", "yaw_inertia"), "bend").vehicles["a"]
    assert a.yaw_inertia.value == pytest.approx(1857 * (0.49 * 2.85) ** 2)
    assert a.yaw_inertia.assumed == "value"


def test_vehicles_may_be_written_in_lower_case():
    text = SCENE.replace("vehicles.A", "vehicles.a").replace("vehicles.B", "vehicles.b")
    assert parse_scene(text, "bend").vehicles == parse_scene(SCENE, "bend").vehicles


def test_a_source_is_kept_beside_an_assumed_uncertainty():
    text = changed(('"1778 kg"', '{ value = 1778, unit = "kg", source = "weighed" }'))
    mass = parse_scene(text, "bend").vehicles["b"].mass
    assert mass.source.startswith("weighed; uncertainty assumed: 2 %")


def test_bounds_themselves_are_accepted():
    headings = ('heading = "180', 'heading = "360'), ('heading = "215', 'heading = "-360')
    text = changed(*headings, ('rotation = "35', 'rotation = "3601'))
    with pytest.raises(SceneError, match="between -3600 and 3600"):
        parse_scene(text, "bend")
    text = changed(*headings, ('rotation = "35', 'rotation = "3600'))
    assert close(parse_scene(text, "bend").rest["a"].heading, 3960 * DEGREE, 3 * DEGREE)
    assert parse_scene(changed(('"45 ± 2 mph"', '"0 ± 1 mph"')), "bend").approach["a"].speed


def test_every_quantity_of_a_scene_has_a_label():
    scene = parse_scene(SCENE, "bend")
    names = [*scene.inputs(), *scene.evidence(), "impulse_x", "impulse_y"]
    labels = set()
    for name in names:
        label, dimension = describe(name)
        labels.add(label)
        assert unit_of(dimension, "us").worth > 0
    assert len(labels) == len(names)
    assert unit_of("impulse", "us").worth == pytest.approx(0.45359237 * 9.80665)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
def test_a_file_is_read_with_or_without_a_byte_order_mark(tmp_path, encoding):
    path = tmp_path / "bend.toml"
    path.write_bytes(SCENE.replace("\n", "\r\n").encode(encoding))
    scene = load_scene(path)
    assert scene.name == "bend"
    assert scene.text.startswith("schema = 1")
    assert load_scene(str(path)) == scene
    assert scene.vehicles == parse_scene("\ufeff" + SCENE, "bend").vehicles


def test_importing_the_scene_is_light():
    code = (
        "import sys, retrodict.scene; "
        "print([m for m in ('jax', 'numpyro', 'matplotlib', 'pint', 'pydantic', 'scipy') "
        "if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
