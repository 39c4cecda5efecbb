"""The controls: every quantity of a scene file, in its own words."""

from __future__ import annotations

from pathlib import Path

import pytest

from retrodict.explore.controls import Control, controls
from retrodict.scene import Scene, load_scene, parse_scene
from tests.shared.scene_file import OIL, SCENE

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*/scene.toml"))


@pytest.fixture(scope="module", params=EXAMPLES, ids=lambda path: path.parent.name)
def scene(request: pytest.FixtureRequest) -> Scene:
    return load_scene(request.param)


def by_key(scene: Scene) -> dict[str, Control]:
    return {control.key: control for control in controls(scene)}


def test_every_uncertain_quantity_of_a_scene_has_a_control(scene: Scene) -> None:
    uncertain = [m for m in scene.inputs().values() if m.sd]
    with_sd = [c for c in controls(scene) if c.sd and not c.key.startswith("vehicles.")]
    of_vehicles = [c for c in controls(scene) if c.sd and c.group.startswith("Vehicle")]
    # the place of an edge has its uncertainty in a key of its own
    ends = ("edge.uncertainty", "outline.uncertainty")
    edges = [c for c in controls(scene) if c.key.endswith(ends)]
    inputs = [c for c in with_sd if c.group in ("Impact", "Surfaces")] + of_vehicles + edges
    assert len(inputs) == len(uncertain)


def test_an_outline_is_moved_as_a_whole() -> None:
    found = by_key(parse_scene(SCENE + OIL, "bend"))
    of_oil = [key for key in found if key.startswith("surfaces.oil.outline")]
    assert of_oil == ["surfaces.oil.outline.uncertainty"]
    assert found[of_oil[0]].label == "oil outline uncertainty"
    assert found[of_oil[0]].changes("0.4 m") == {of_oil[0]: "0.4 m"}


def test_a_control_that_is_not_moved_changes_nothing(scene: Scene) -> None:
    for control in controls(scene):
        if control.written is not None:
            assert control.changes(control.text()) == {control.key: control.written}
        value, sd = control.read(control.text())
        assert value == pytest.approx(control.value)
        assert sd == pytest.approx(control.sd, rel=1e-3)
        assert control.value_at(control.position(control.value)) == pytest.approx(
            control.value, abs=control.step if not control.by_factor else 0.005 * control.value
        )


def test_a_scene_accepts_both_ends_of_every_slider() -> None:
    scene = load_scene(next(path for path in EXAMPLES if path.parent.name == "brach-1977"))
    for control in controls(scene):
        for end in control.slider_range:
            text = control.text(control.value_at(end))
            changed = scene.change(control.changes(text))
            now = by_key(changed)[control.key]
            assert now.value == pytest.approx(control.value_at(end)), control.key


def test_a_slider_moves_four_standard_deviations_in_the_unit_of_the_file() -> None:
    scene = load_scene(next(path for path in EXAMPLES if path.parent.name == "brach-1977"))
    speed = by_key(scene)["vehicles.A.approach.speed"]
    assert (speed.unit, speed.value, speed.sd) == ("mph", 45, 2)
    assert speed.slider_range == pytest.approx((37, 53))
    assert speed.text(47.3, 1) == "47.3 ± 1 mph"
    assert [speed.sd_at(x) for x in (-2, 0, 2)] == [0.5, 2, 8]
    heading = by_key(scene)["vehicles.A.rest.heading"]
    assert heading.text() == "218.13 ± 3 deg"  # as written, not unwrapped


def test_a_prior_that_is_changed_names_its_source() -> None:
    scene = load_scene(next(path for path in EXAMPLES if path.parent.name == "brach-1977"))
    prior = by_key(scene)["priors.speed_b.scale"]
    changed = scene.change(prior.changes(prior.text(20)))
    assert changed.priors["speed_b"].numbers == (20,)
    assert "retrodict explore" in changed.priors["speed_b"].source
    assert "priors.speed_a.scale" not in by_key(scene)  # A's speed was measured
