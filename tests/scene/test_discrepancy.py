"""How far a run-out misses a real car: with the way, with how freely it rolled, and once only."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from retrodict.scene import discrepancy, parse_scene
from retrodict.scene.records import Mark, Measured, RunOutError, Scene
from tests.shared.scene_file import changed, without
from tests.shared.scenes import collision

DEGREE = math.pi / 180
ROLLS = (
    'wheels = { front_left = "{0}", front_right = "{0}", rear_left = "{0}", rear_right = "{0}" }'
)


def of_b(wheels: str, x: str = "6.1 m", more: str = "") -> Scene:
    """The example with B's wheels so, and its rest that far along x."""
    mass = 'mass = "1778 kg"'
    text = changed((mass, f"{mass}\n{wheels}\n{more}"), ('["6.1 m",', f'["{x}",'))
    return parse_scene(text, "bend")


def four(word: str) -> str:
    return ROLLS.replace("{0}", word)


def test_a_way_goes_through_its_points_in_whichever_order_they_were_written() -> None:
    points = [(3.0, 4.0), (3.0, 0.0), (30.0, 40.0)]
    for order in (points, points[::-1]):
        assert discrepancy.path_length((0.0, 0.0), order, (6.0, 8.0)) == pytest.approx(3 + 4 + 5)
    assert discrepancy.path_length((0.0, 0.0), [], (6.0, 8.0)) == pytest.approx(10)


def test_freedom_is_what_the_loads_leave_of_the_drags() -> None:
    assert discrepancy.freedom(1.2, 1.5, [1.0] * 4) == pytest.approx(0)
    assert discrepancy.freedom(1.2, 1.5, [0.0] * 4) == pytest.approx(1)
    # 1.5 of 2.7 of the load are on the front wheels
    assert discrepancy.freedom(1.2, 1.5, [1.0, 1.0, 0.0, 0.0]) == pytest.approx(1.2 / 2.7)
    assert discrepancy.freedom(1.3, 1.3, [0.4, 0.0, 0.0, 0.0]) == pytest.approx(0.9)


@pytest.mark.parametrize("wheels", ["", 'wheels = "locked"', four("locked")])
def test_locked_cars_stay_as_sharp_as_they_were_measured(wheels: str) -> None:
    for x in ("6.1 m", "60 m"):
        evidence = of_b(wheels, x).evidence()
        for name in ("rest_x_b", "rest_y_b", "rest_heading_b"):
            assert evidence[name].model_sd == 0
            assert evidence[name].sd == evidence[name].measured_sd
        assert evidence["rest_x_b"].sd == 0.15


def test_a_place_is_missed_in_proportion_to_the_way_and_a_heading_up_to_its_size() -> None:
    scenes = [of_b(four("0"), x) for x in ("8 m", "100 m", "200 m")]
    for scene in scenes:
        way, found = (
            scene.path_to("b", *(getattr(scene.rest["b"], p).value for p in "xy")),
            scene.evidence(),
        )
        assert found["rest_x_b"].model_sd == pytest.approx(0.04 * way)
        assert found["rest_y_b"].model_sd == pytest.approx(0.04 * way)
        expected = 8 * DEGREE * min(1, way / 20)
        assert found["rest_heading_b"].model_sd == pytest.approx(expected)
    near = scenes[0].path_to("b", 8.0, -9.0)
    centre = (0.1 - 1.76 * math.cos(68 * DEGREE), -0.2 - 1.76 * math.sin(68 * DEGREE))
    assert near == pytest.approx(math.dist(centre, (8.0, -9.0)))


def test_the_less_freely_a_car_rolls_the_better_it_is_followed() -> None:
    missed = [
        of_b(four(drag)).evidence()["rest_x_b"].model_sd for drag in ("0", "0.25", "0.5", "1")
    ]
    assert missed == pytest.approx([missed[0] * free for free in (1, 0.75, 0.5, 0)])


def test_errors_of_measurement_and_of_the_run_out_add_as_independent_ones() -> None:
    for m in of_b(four("rolling"), "40 m").evidence().values():
        assert m.sd == pytest.approx(math.hypot(m.measured_sd, m.model_sd))
    plain = Measured(3.0, 0.3, source="taped")
    both = plain.with_model_sd(0.4)
    assert (both.sd, both.model_sd, both.source) == (pytest.approx(0.5), 0.4, "taped")
    assert both.measured_sd == pytest.approx(0.3)
    assert plain.with_model_sd(0.0) is plain


def test_a_mark_is_missed_by_the_way_up_to_it() -> None:
    scene = collision()
    error = RunOutError(position=Measured(0.04), heading=Measured(8 * DEGREE))
    b = replace(scene.vehicles["b"], run_out_error=error)
    marks = (Mark(6.0, -9.0, 0.2, "centre"), Mark(3.0, -5.0, 0.2, "rear_left"))
    scene = replace(scene, vehicles=scene.vehicles | {"b": b}, marks={"b": marks})
    found = scene.evidence()
    for i, mark in enumerate(marks, start=1):
        way = scene.path_to("b", mark.x, mark.y)
        assert found[f"mark_{i}_b"].model_sd == pytest.approx(0.04 * way)
        assert found[f"mark_{i}_b"].measured_sd == pytest.approx(0.2)
    # the rest lies beyond the mark of the centre, and its way goes through that
    rest = scene.rest["b"].x.value, scene.rest["b"].y.value
    expected = scene.path_to("b", 6.0, -9.0) + math.dist((6.0, -9.0), rest)
    assert scene.path_to("b", *rest) == pytest.approx(expected)
    assert found["rest_x_b"].model_sd == pytest.approx(0.04 * expected)
    assert found["rest_x_a"].model_sd == 0


def test_what_is_written_counts_as_it_is() -> None:
    scene = of_b(four("0.5"), "60 m", 'run_out_error = { position = "2 %", heading = "5 deg" }')
    way, found = scene.path_to("b", 60.0, -9.0), scene.evidence()
    assert found["rest_x_b"].model_sd == pytest.approx(0.02 * way)
    assert found["rest_heading_b"].model_sd == pytest.approx(5 * DEGREE)
    locked = of_b("", "60 m", 'run_out_error = { position = "1 %" }').evidence()
    assert locked["rest_x_b"].model_sd == pytest.approx(0.01 * way)
    assert locked["rest_heading_b"].model_sd == 0
    off = of_b(four("0"), "60 m", 'run_out_error = { position = "0 %", heading = "0 deg" }')
    assert not any(m.model_sd for name, m in off.evidence().items() if name.endswith("_b"))


def test_a_default_is_called_one_and_says_where_it_comes_from() -> None:
    assumed = of_b(four("0")).vehicles["b"].run_out_error
    for part, figure in ((assumed.position, "4 % (grade C"), (assumed.heading, "8 deg (grade C")):
        assert part.assumed == "value"
        assert figure in part.source
    written = parse_scene(without("notes"), "bend").vehicles["a"].run_out_error
    assert "0.61 (1 less the mean drag of its wheels)" in written.position.source
