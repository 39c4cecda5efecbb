"""The height of a centre of gravity: optional, with an uncertainty, and not that of the roof."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from retrodict.mechanics import Car, Ground
from retrodict.mechanics.motion import vector_field
from retrodict.scene import SceneError, parse_scene
from retrodict.scene.plausibility import plausibility_warnings
from retrodict.scene.write import scene_toml
from tests.shared.scene_file import SCENE, changed

HIGH = changed(('track = "1.54 m"', 'track = "1.54 m"\ncg_height = "0.53 ± 0.03 m"'))


def test_none_is_assumed() -> None:
    assert parse_scene(SCENE, "scene").vehicles["a"].cg_height is None
    named = SCENE.replace('mass = "1778 kg"', 'class = "compact car"')
    assert parse_scene(named, "scene").vehicles["b"].cg_height is None


def test_it_is_an_input_with_an_uncertainty() -> None:
    scene = parse_scene(HIGH, "scene")
    found = scene.inputs()["cg_height_a"]
    assert (found.value, found.sd, found.law) == (0.53, 0.03, "lognormal")
    assert "cg_height_b" not in scene.inputs()
    assert parse_scene(scene_toml(scene), "scene").inputs()["cg_height_a"] == found
    without = parse_scene(HIGH.replace("0.53 ± 0.03 m", "20 in"), "scene").inputs()["cg_height_a"]
    assert without.sd == pytest.approx(0.05 * 0.508)
    assert without.assumed == "sd"


@pytest.mark.parametrize(
    ("written", "said"),
    [('cg_height = "14 ft"', "between 0.3281 and 9.843 ft"), ('height = "1.4 m"', '"cg_height"')],
)
def test_what_it_is_not_says_what_to_write(written: str, said: str) -> None:
    with pytest.raises(SceneError, match=said):
        parse_scene(HIGH.replace('cg_height = "0.53 ± 0.03 m"', written), "scene")


def test_a_wheel_that_may_lift_is_a_warning() -> None:
    assert not warnings("0.53 ± 0.03 m")
    (line,) = warnings("1.40 ± 0.03 m")
    assert line.startswith("vehicles.A.cg_height: above 1.31 m a wheel of it may lift")


@pytest.mark.slow
def test_above_that_height_one_does_at_some_angle() -> None:
    """It slides without spin on locked wheels, at every angle."""
    car = Car(1.8, 1.35, 1.50, 1.54)

    def lifts(height: float) -> bool:
        slopes = vector_field(car._replace(height=height), Ground(0.5 * 1.02))
        angles, none = np.linspace(0, 2 * np.pi, 720), np.zeros(720)
        ways = (none, none, none, 10 * np.cos(angles), 10 * np.sin(angles), none, none)
        return bool(np.isnan(jax.vmap(slopes)(ways)[0]).any())

    assert not lifts(1.305)
    assert lifts(1.315)


def warnings(height: str) -> list[str]:
    scene = parse_scene(HIGH.replace("0.53 ± 0.03 m", height), "scene")
    return [line for line in plausibility_warnings(scene) if "cg_height" in line]
