"""Each difference of two scenes is made alone, on the first."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from retrodict.inference.errors import Unanswerable
from retrodict.options import DEFAULT_RUNG
from retrodict.scene.load import parse_scene
from retrodict.studies import attribution
from tests.shared.scene_file import SCENE


def test_each_change_is_made_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    def answered(scene: Any, options: Any, **_: Any) -> Any:
        if scene.surfaces[0].friction.value > 1:
            raise Unanswerable("too rough")
        speed = scene.vehicles["a"].mass.value / 100 + scene.contact.Gamma.value
        draws = speed + np.array([[-1.0, 1.0]])
        return SimpleNamespace(
            checks=SimpleNamespace(passed=True), idata={"posterior": {"speed_b": draws}}
        )

    monkeypatch.setattr(attribution, "reconstruct", answered)
    scene = parse_scene(SCENE, "bend")
    changes: dict[str, tuple[str, str | None]] = {
        "vehicles.A.mass": ("1857 ± 37 kg", "1957 ± 37 kg"),
        "impact.contact_line": ("-8.9 ± 3 deg", "1.1 ± 3 deg"),
        "surfaces.road.friction": ("0.50 ± 0.03", "1.2 ± 0.03"),
        "vehicles.C.mass": ("–", "1000 kg"),
        "vehicles.A.grip": ("1.02 ± 0.04", None),
    }
    first, mass, line, rough, nobody, grip = attribution.each_alone(
        scene, changes, DEFAULT_RUNG, "speed_b"
    )
    assert first.mean is not None
    assert mass.mean == pytest.approx(first.mean + 1)
    assert line.mean == pytest.approx(first.mean + np.radians(10))
    assert rough.mean is None
    assert rough.why == "too rough"
    assert nobody.why.startswith("cannot be changed alone: ")
    assert grip.mean == pytest.approx(first.mean)
    assert grip.new == ""
