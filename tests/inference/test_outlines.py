"""A surface within an outline has its part in the posterior where wheels cross it, and else none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from retrodict.inference.outcome import Outcome
from retrodict.inference.reconstruct import reconstruct
from retrodict.options import RunOptions
from retrodict.scene.records import Measured, Outline, Scene, Surface
from tests.shared.scenes import collision


def iced(x: float, y: float, friction: float = 0.1, sd: float = 0.0) -> Scene:
    """The collision with a square of 3 m about a point on the road."""
    bare = collision(share=0.0, berm=False)
    corners = tuple((x + a, y + b) for a, b in ((-1.5, -1.5), (1.5, -1.5), (1.5, 1.5), (-1.5, 1.5)))
    outline = Outline(corners, Measured(0.0, sd))
    ice = Surface("ice", Measured(friction), Measured(0.0), None, outline)
    return replace(bare, surfaces=(*bare.surfaces, ice))


def answered(scene: Scene) -> Outcome:
    return reconstruct(scene, RunOptions(method="laplace", seed=2), pictured=False)


def drawn(outcome: Outcome, name: str) -> np.ndarray:
    return np.asarray(outcome.idata["posterior"][name])


@pytest.mark.slow
def test_ice_beside_the_way_alters_nothing_and_on_it_the_speed_of_who_slid_over_it() -> None:
    bare = answered(collision(share=0.0, berm=False))
    beside = answered(iced(400.0, 300.0))
    for name in ("speed_b", "e", "mu", "Vbx"):
        np.testing.assert_allclose(drawn(beside, name), drawn(bare, name), rtol=1e-5)
    crossed = answered(iced(4.2, -7.3, sd=0.2))
    # less was lost to friction over about 3.9 m of B's way, by its slide and by its yaw
    of_bare, of_crossed = (
        np.mean(
            drawn(o, "Vbx") ** 2 + drawn(o, "Vby") ** 2 + 3007 / 1778 * drawn(o, "Omega_b") ** 2
        )
        for o in (bare, crossed)
    )
    assert of_bare - of_crossed == pytest.approx(2 * 9.81 * (0.5 - 0.1) * 3.9, rel=0.3)
    assert drawn(crossed, "speed_b").mean() < drawn(bare, "speed_b").mean()
    assert drawn(crossed, "edge_ice").std() == pytest.approx(0.2, rel=0.2)
