"""Skids in several pieces and critical-speed yaw marks: the posterior is that of the closed form."""

import numpy as np
import pytest

import retrodict as rd
from retrodict.constants import GRAVITY
from tests.models.test_alone import draws, same
from tests.scene.test_alone import SKID
from tests.scene.test_marks_before import PIECES, YAW

COUNT = 400_000


def lognormal(rng, mean, sd):
    scale = np.sqrt(np.log1p((sd / mean) ** 2))
    return mean * np.exp(scale * rng.standard_normal(COUNT) - scale**2 / 2)


def logitnormal(rng, median, sd):
    x = np.log(median / (1 - median)) + sd / (median * (1 - median)) * rng.standard_normal(COUNT)
    return 1 / (1 + np.exp(-x))


@pytest.mark.slow
def test_a_skid_in_pieces_adds_up_the_squares_of_its_speeds() -> None:
    rng = np.random.default_rng(0)
    gravel, road = lognormal(rng, 0.5, 0.05), lognormal(rng, 0.72, 0.05)
    drag, braking = lognormal(rng, 0.35, 0.05), logitnormal(rng, 0.9, 0.05)
    lengths = [lognormal(rng, length, 0.5) for length in (9, 12, 6)]
    end = 0.2 * rng.standard_normal(COUNT)
    lost = sum(f * s for f, s in zip((braking * gravel, road, drag), lengths, strict=True))
    same(draws(PIECES)[1], np.sqrt(end**2 + 2 * GRAVITY * lost))


@pytest.mark.slow
def test_one_piece_is_the_skid() -> None:
    piece = SKID.replace('skid = "30 ± 0.5 m"', 'skids = [{ length = "30 ± 0.5 m" }]')
    assert piece != SKID
    one, other = draws(SKID)[1], draws(piece)[1]
    assert one.mean() == pytest.approx(other.mean(), abs=0.05 * one.std())
    assert one.std() == pytest.approx(other.std(), rel=0.05)


def test_a_yaw_mark_gives_the_critical_speed_with_the_error_of_the_method() -> None:
    """v = (1 ± 0.08) sqrt(f g r): by the worked problem's arc, r = 60.15 m and 20.6 m/s."""
    rng = np.random.default_rng(1)
    ordinate, friction = lognormal(rng, 0.3, 0.01), lognormal(rng, 0.72, 0.05)
    radius = 12**2 / (8 * ordinate) + ordinate / 2
    critical = np.sqrt(friction * GRAVITY * radius)
    assert np.median(critical) == pytest.approx(20.6, abs=0.05)
    # v over critical is normal about 1, so that a critical speed has its size as weight, v its prior
    speed = critical * (1 + 0.08 * rng.standard_normal(COUNT))
    (scale,) = rd.parse_scene(YAW, "yaw").priors["speed_a"].numbers
    weight = critical * np.exp(-((speed / scale) ** 2) / 2)
    same(draws(YAW)[1], rng.choice(speed, COUNT, p=weight / weight.sum()))


@pytest.mark.slow
def test_a_yaw_mark_narrows_the_speed_before_a_skid_into_a_crash() -> None:
    """Speeds of a crossing, with and without a mark at A's speed before its skid."""
    from tests.models.test_as_people_write import CLASSROOM

    rest = 'rest = { distance = "25.9 ft"'
    arc = '{ chord = "15 m", middle_ordinate = "0.45 ± 0.02 m", error = "5 %" }'
    skid = f'approach = {{ skid = "5 ± 0.3 m" }}\n{rest}'
    mark = f'approach = {{ skid = "5 ± 0.3 m", yaw_mark = {arc} }}\n{rest}'
    both = []
    for text in (skid, mark):
        scene = rd.parse_scene(CLASSROOM.replace(rest, text), "crossing")
        found = rd.reconstruct(scene, method="importance")
        assert found.checks.passed
        both.append(np.ravel(found.idata["posterior"]["travelling_speed_a"]))
    without, with_mark = both
    critical = np.sqrt(0.83 * GRAVITY * (15**2 / (8 * 0.45) + 0.225))
    weights = np.array([without.std() ** -2, (0.06 * critical) ** -2])
    expected = weights @ [without.mean(), critical] / weights.sum()
    assert with_mark.std() < without.std()
    assert with_mark.mean() == pytest.approx(expected, abs=0.5 * without.std())
