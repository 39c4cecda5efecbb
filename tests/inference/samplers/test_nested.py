"""Nested Laplace proposals have the density that they say, and fit a posterior that bends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from retrodict.models import RUNGS
from scipy import stats

from retrodict.inference.density.compiled import programs_for
from retrodict.inference.fitting.about_peak import prepare
from retrodict.inference.fitting.deviates import Crashes
from retrodict.inference.modes import solutions
from retrodict.inference.samplers import METHODS, Task, smc
from retrodict.inference.samplers.importance import adapted, evaluated, weighted_points
from retrodict.inference.samplers.nested import _PRIOR, Nested, _corrected, _Free, nested
from retrodict.inference.samplers.proposal import HEAVY, Proposal
from retrodict.inference.samplers.psis import effective, log_mean, smoothed
from retrodict.inference.transforms.choice import Coordinates
from retrodict.options import DEFAULT_RUNG
from retrodict.scene.load import load_scene
from retrodict.scene.records import Scene
from retrodict.studies import calibration

POINTS = 4000
EDGES = "benchmarks/users/scenes/slow-side-24.toml"
EXAMPLE = "examples/brach-1977/scene.toml"
NUMBER = 9  # of a simulated crash


@cache
def crash() -> Scene:
    """A crash that `calibrate` simulates."""
    design = calibration.design()
    structure, data = RUNGS[DEFAULT_RUNG].of_scene(design)
    batch, place = divmod(NUMBER, calibration._BATCH)
    rng = np.random.default_rng([0, batch])
    _, quantities = calibration._truths(programs_for(structure), data, rng)
    own = {name: values[place] for name, values in quantities.items()}
    return calibration._measured(design, structure, own, np.random.default_rng([0, NUMBER, 1]))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "end"),
    [
        pytest.param(crash, 0.956, id="simulated"),  # its true e_m
        pytest.param(lambda: load_scene(EXAMPLE), 0.97, id="example"),
    ],
)
def test_the_far_end_of_a_hyperbola_is_drawn(scene: Callable[[], Scene], end: float) -> None:
    """The spins after the impact determine e_m times the spin by the force alone.

    In rest poses that hyperbola is straight. Tempering that began at a normal about the mode found a
    fifth of this tail; solving for too few modes of the example left out all of it.
    """
    shares = {}
    for coordinates in (Coordinates.PINNED, Coordinates.DEVIATES):
        posterior = prepare(scene(), DEFAULT_RUNG, coordinates)
        chance = np.random.default_rng(3)
        _, log_weight, quantities, _ = weighted_points(posterior, 2 * POINTS, chance)
        weights, k = smoothed(log_weight)
        beyond = quantities["e_m"] > end
        share = float(weights[beyond].sum())
        error = float(np.sqrt(np.square(weights * (beyond - share)).sum()))
        assert k < 0.7
        assert share > 5 * error > 0
        shares[coordinates] = share, error
    (one, error), (other, another) = shares.values()
    assert abs(one - other) < 4 * np.hypot(error, another)
    drawn = smc.draw(Task(posterior, 4, 512, 0, 1, lambda *_: None))
    beyond = posterior.evaluate(drawn.w.reshape(-1, posterior.size))[1]["e_m"] > end
    assert one / 2 < beyond.mean() < 2 * one


@pytest.mark.slow
def test_points_have_the_density_of_draws() -> None:
    posterior = prepare(crash(), DEFAULT_RUNG, Coordinates.DEVIATES)
    proposal = nested(posterior)
    assert proposal is not None
    w, log_density = proposal.sampled(200, np.random.default_rng(4))
    np.testing.assert_allclose(proposal.log_density(w), log_density, rtol=1e-6, atol=1e-6)


@pytest.mark.slow
def test_the_evidence_is_that_by_another_proposal() -> None:
    """Weights of draws whose stated density were off would have another mean."""
    posterior = prepare(crash(), DEFAULT_RUNG, Coordinates.DEVIATES)
    chance = np.random.default_rng(5)
    proposal = nested(posterior)
    assert proposal is not None
    about_mode = adapted(
        posterior, Proposal.first(posterior.size, HEAVY), lambda at: at.draw(2048, chance)
    ).next
    found, shares = [], []
    for each, count in ((proposal, POINTS), (about_mode, 10 * POINTS)):
        w, log_density = each.sampled(count, chance)
        log_weight = evaluated(posterior, w)[0] - log_density
        found.append(log_mean(log_weight))
        shares.append(effective(smoothed(log_weight)[0]) / count)
    (one, error), (other, another) = found
    assert max(error, another) < 0.2  # one draw in many thousands is of a mode that was not found
    assert abs(one - other) < 4 * np.hypot(error, another)
    assert shares[0] > 2 * shares[1]


@pytest.mark.slow
def test_coordinates_without_a_shear_do_as_well() -> None:
    """The sheet is solved for, so that none has to be fitted."""
    shares = []
    for coordinates in (Coordinates.DEVIATES, Coordinates.UNBENT):
        posterior = prepare(crash(), DEFAULT_RUNG, coordinates)
        proposal = nested(posterior)
        assert proposal is not None
        w, log_density = proposal.sampled(POINTS, np.random.default_rng(6))
        weights, k = smoothed(evaluated(posterior, w)[0] - log_density)
        assert k < 0.7
        shares.append(effective(weights) / POINTS)
    assert abs(shares[0] - shares[1]) < 0.1


def test_free_directions_are_mixtures_of_two_normals() -> None:
    """Draws and their density, against SciPy's."""
    middle, wide, own, sd = np.array([[-1.5, 0.0], [3.0, 1.0], [0.2, -0.1], [0.9, 1.1]])
    free = _Free(middle, wide, own, sd)
    points = np.random.default_rng(7).random((POINTS, 2))
    x = free.at(points)
    density = np.ones(POINTS)
    for i in range(2):
        prior, near = stats.norm(middle[i], wide[i]), stats.norm(own[i], sd[i])

        def below(v: np.ndarray, prior: Any = prior, near: Any = near) -> np.ndarray:
            return _PRIOR * prior.cdf(v) + (1 - _PRIOR) * near.cdf(v)

        assert stats.kstest(x[:, i], below).pvalue > 1e-3
        density *= _PRIOR * prior.pdf(x[:, i]) + (1 - _PRIOR) * near.pdf(x[:, i])
    np.testing.assert_allclose(free.log_density(x), np.log(density), rtol=1e-10)


@pytest.mark.slow
def test_draws_move_it_to_where_the_posterior_is() -> None:
    """Moved away, it comes back; the evidence is the same wherever it is."""
    posterior = prepare(crash(), DEFAULT_RUNG, Coordinates.UNBENT)
    proposal = nested(posterior)
    assert proposal is not None
    n = proposal._of_free.size
    away = replace(proposal, shown=(np.full(n, 0.3), np.full(n, 1.2)))
    chance = np.random.default_rng(8)

    def weighted(at: Nested) -> tuple[np.ndarray, np.ndarray]:
        w, log_density = at.sampled(POINTS, chance)
        return w, evaluated(posterior, w)[0] - log_density

    first = weighted(away)
    back = away.moved(*first)
    assert back.shown is not None
    assert np.abs(back.shown[0]).mean() < 0.2
    then = weighted(back)
    assert effective(smoothed(then[1])[0]) > 1.5 * effective(smoothed(first[1])[0])
    (one, error), (other, another) = log_mean(first[1]), log_mean(then[1])
    assert abs(one - other) < 4 * np.hypot(error, another)
    nowhere = away.moved(first[0], np.full(POINTS, -np.inf))
    assert nowhere is away


@pytest.mark.slow
def test_fitted_slopes_lead_to_the_modes_and_few_draws_need_their_own(monkeypatch) -> None:
    posterior = prepare(crash(), DEFAULT_RUNG, Coordinates.UNBENT)
    proposal = nested(posterior)
    assert proposal is not None
    x = proposal._of_free.at(np.random.default_rng(9).random((1000, proposal._of_free.size)))
    proposal._solved(x[:1])  # fits them
    asked = []
    at = Crashes.at
    monkeypatch.setattr(
        Crashes, "at", lambda self, u, *names: asked.append(len(u)) or at(self, u, *names)
    )
    mode, _ = proposal._solved(x)
    assert sum(asked) < 5 * len(x)  # slopes of their own take one for each pinned direction more
    _, step = proposal._stepped(mode, x, *proposal._linearised(mode, x))
    assert np.quantile(np.linalg.norm(step, axis=1), 0.95) < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("method", ["importance", "smc"])
def test_draws_at_edges_spoil_no_slopes(method: str) -> None:
    """The evidence is that of the prior's draws, where one in 488 slopes is 400 times the others."""
    (found,) = solutions(load_scene(EDGES), DEFAULT_RUNG)
    posterior = found.posterior
    chance = np.random.default_rng(12)
    u = chance.standard_normal((200_000, posterior.size))
    evidence, error = log_mean(posterior.crashes.at(u)[0])
    task = Task(posterior, 4, METHODS[method].draws, 0, 2, lambda *_: None)
    drawn = METHODS[method].draw(task).attributes
    error = np.hypot(error, drawn["log_evidence_sd"])
    assert drawn["log_evidence"] == pytest.approx(evidence, abs=4 * error)


@pytest.mark.slow
@pytest.mark.parametrize("jump", [1e3, 1e10])
def test_slopes_across_an_edge_leave_covariances_as_they_are_at_the_peak(
    jump: float, monkeypatch
) -> None:
    """Of a jump of residuals by a thousandth of a deviate; 1e10 left a precision without a root."""
    posterior = prepare(crash(), DEFAULT_RUNG, Coordinates.DEVIATES)
    proposal = nested(posterior)
    assert proposal is not None
    x = np.zeros((50, proposal._of_free.size))
    _, sound = proposal._solved(x)
    residuals = Crashes.residuals

    def edged(self, u: np.ndarray, *turns) -> np.ndarray:
        # residuals jump to and fro at each of the steps, however short
        jumps = jump * (np.round(u.sum(axis=1) * 1e6) % 2)
        return residuals(self, u, *turns) + jumps[:, None]

    monkeypatch.setattr(Crashes, "residuals", edged)
    _, root = proposal._solved(x)
    assert np.isfinite(root).all()
    volume, of_sound = (np.linalg.slogdet(each)[1] for each in (root, sound))
    np.testing.assert_allclose(volume, of_sound, atol=1.0)


def test_corrected_slopes_agree_with_the_change_along_a_step() -> None:
    """Broyden's condition, and nothing else changes: directions across the step keep their slopes."""
    chance = np.random.default_rng(10)
    slopes, moved, change = (chance.normal(size=shape) for shape in ((5, 3, 7), (5, 3), (5, 7)))
    change[0] = np.nan  # no crash at the end of the step
    found = _corrected(slopes, moved, change)
    np.testing.assert_array_equal(found[0], slopes[0])
    np.testing.assert_allclose(np.einsum("kij,ki->kj", found, moved)[1:], change[1:])
    across = np.cross(moved, chance.normal(size=(5, 3)))
    kept = np.einsum("kij,ki->kj", found - slopes, across)
    np.testing.assert_allclose(kept, 0, atol=1e-12)


@pytest.mark.slow
def test_draws_of_the_fit_show_the_middle_of_the_free_directions() -> None:
    """It is nearer to the posterior's mean than the peak is."""
    posterior = prepare(crash(), DEFAULT_RUNG, Coordinates.UNBENT)
    proposal = nested(posterior)
    assert proposal is not None
    w, log_density = proposal.sampled(POINTS, np.random.default_rng(11))
    log_weight = evaluated(posterior, w)[0] - log_density
    known = proposal.moved(w, log_weight).shown
    assert known is not None
    off = proposal._sheet.middle - known[0]
    assert np.square(off).sum() < np.square(known[0]).sum() / 2


@pytest.mark.slow
def test_rest_poses_have_none() -> None:
    assert nested(prepare(crash(), DEFAULT_RUNG, Coordinates.PINNED)) is None
