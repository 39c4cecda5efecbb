"""Bodies without wheels: the posterior is that of momentum and v² = 2 f g d with their drag factor."""

import numpy as np
import pytest

import retrodict as rd
from retrodict.constants import GRAVITY
from tests.scene.test_sliding import MOTORCYCLE


@pytest.mark.slow
def test_the_speeds_are_those_of_the_closed_form():
    found = rd.reconstruct(rd.parse_scene(MOTORCYCLE, "motorcycle"), method="importance")
    assert found.checks.passed
    of_a, of_b = (np.ravel(found.idata["posterior"][f"speed_{v}"]) for v in "ab")
    # momentum at the measured values; B's part along A's course is what makes A's speed uncertain
    V_a, V_b = np.sqrt(2 * np.array([0.45, 0.7]) * GRAVITY * np.array([4.0, 6.0]))
    P = 330 * V_a * np.exp(1j * np.radians(60)) + 1500 * V_b * np.exp(1j * np.radians(70))
    courses = np.exp(1j * np.radians([10, 90]))
    exact = np.linalg.solve(
        np.array([[330 * courses[0].real, 1500 * courses[1].real],
                  [330 * courses[0].imag, 1500 * courses[1].imag]]),
        [P.real, P.imag],
    )  # fmt: skip
    assert np.median(of_a) == pytest.approx(exact[0], abs=0.3 * of_a.std())
    assert np.median(of_b) == pytest.approx(exact[1], abs=0.3 * of_b.std())
