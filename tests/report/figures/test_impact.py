"""An impact drawn from above, in its numbers and its units."""

import numpy as np
import pytest

from retrodict.mechanics import Bodies, Coefficients, against_barrier, impulse
from retrodict.report.figures.impact import plot_impact

BODIES = Bodies(1857, 1778, 3374, 3007, 1.636, 0.653, 0.205, 2.079, -0.155)
APPROACH = [-20.1, 0, 0, 18.9, -3.6, -0.3]
HIT = Coefficients(0.1, 0.35, 0.7)


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def arrows(figure):
    """Start and end of each arrow."""
    return [(np.array(each.xyann), np.array(each.xy)) for each in figure.axes[0].texts]


def test_arrows_have_the_direction_and_ratio_of_the_velocities():
    before_a, after_a, before_b, _, push = arrows(plot_impact(APPROACH, BODIES, HIT))
    np.testing.assert_allclose(before_a[0], [2.079, 0.205])
    np.testing.assert_allclose(before_b[0], [-0.653, -1.636])
    by_a, by_b = before_a[1] - before_a[0], before_b[1] - before_b[0]
    np.testing.assert_allclose(by_b / np.hypot(*by_a), np.array([18.9, -3.6]) / 20.1)
    assert np.hypot(*(after_a[1] - after_a[0])) < np.hypot(*by_a)
    P = np.asarray(impulse(APPROACH, BODIES, HIT)[0])
    np.testing.assert_allclose(push[1] / np.hypot(*push[1]), P / np.hypot(*P))


def test_numbers_are_in_the_units_asked_for():
    line, a, _, push = legend(plot_impact(APPROACH, BODIES, HIT, "us"))
    assert line == "contact line"
    assert a.startswith("A: 45 → ")
    assert a.endswith("deg/s")
    assert push.endswith("lbf s")


def test_a_barrier_has_no_velocities():
    wall = against_barrier(1857, 3374, 0.205, 2.079, 0.0)
    figure = plot_impact([-12, 0, 0, 0, 0, 0], wall, Coefficients(0.1, 0.2, 0.9))
    assert not [each for each in legend(figure) if each.startswith("B")]


def test_what_is_no_single_impact_is_refused_in_a_line():
    with pytest.raises(ValueError, match="no finite velocities after"):
        plot_impact([np.nan] * 6, BODIES, HIT)
    with pytest.raises(ValueError, match="one impact is drawn"):
        plot_impact(APPROACH, BODIES, HIT._replace(e=np.array([0.1, 0.2])))
