"""Velocities that end at the rest poses, and what stands for parts of them that were not measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from retrodict.models import RUNGS
from retrodict.models.arrays import in_steps

from retrodict.inference.density.compiled import programs_for
from retrodict.inference.density.kernels import BATCH, REACHED
from retrodict.inference.fitting import regression
from retrodict.inference.fitting.about_peak import crashes_of, prepare, unresolved
from retrodict.inference.fitting.posterior import run_outs_of
from retrodict.inference.fitting.search import peaks
from retrodict.inference.fitting.steps import RESOLVED
from retrodict.inference.reconstruct import reconstruct
from retrodict.inference.transforms import layout
from retrodict.options import RunOptions
from retrodict.scene.records import Mark, Scene
from tests.shared.scenes import collision, rolls

pytestmark = pytest.mark.slow


def in_part() -> dict[str, Scene]:
    """Of one vehicle the rest pose, of the other its position or nothing."""
    scene = collision()
    a, b = scene.rest["a"], scene.rest["b"]
    return {
        "A": replace(scene, rest={"a": a}),
        "B": replace(scene, rest={"b": b}),
        "A, and where B was": replace(scene, rest={"a": a, "b": replace(b, heading=None)}),
    }


@pytest.mark.parametrize("which", in_part())
def test_regressions_lead_to_what_was_measured_and_are_velocities_elsewhere(which: str) -> None:
    scene, rung = in_part()[which], "planar-moment+spin"
    structure, data = RUNGS[rung].of_scene(scene)
    programs = programs_for(structure)
    peak = peaks(crashes_of(scene, rung), seed=0)[0]
    crash = {k: np.asarray(v)[None] for k, v in peak.quantities.items()}
    likely = regression.shoot(programs, data, run_outs_of(crash)[0][0])
    regressions = regression.fit(programs, data, likely)[0]
    q = np.random.default_rng(1).standard_normal((BATCH, layout.length_for_regressions(structure)))
    z, xi = np.split(q, [len(structure.rest_components)], axis=1)
    V = np.array([layout.separation_at(structure, data, regressions, row)[0] for row in q[:20]])
    ends = programs(REACHED, data, np.resize(V, (BATCH, 6)), np.resize(xi[:20], xi.shape))
    rests = np.reshape(ends, (BATCH, 6))[:20]
    for i, name in enumerate(structure.rest_components):
        if name in data.evidence:
            value, sd = data.evidence[name]
            missed = (rests[:, i] - value) / sd - z[:20, i]
        else:
            missed = V[:, i] - likely[i] - z[:20, i]
        assert np.median(np.abs(missed)) < 0.5, name


@pytest.mark.parametrize(("steps", "few"), [(3, True), (48, False)])
def test_steps_too_few_for_a_mark_are_seen_beside_rest_poses(steps: int, few: bool) -> None:
    scene = replace(collision(berm=False), marks={"b": (Mark(3.0, -4.0, 0.1, "centre"),)})
    found = prepare(scene, "planar-common+spin")
    structure, data = in_steps(found.programs.structure, found.data, steps)
    # of rest poses as rough as these only the mark is informative
    rough = {name: data.evidence[name] * [1.0, 100.0] for name in structure.rest_components}
    data = data._replace(evidence=data.evidence | rough)
    again = replace(found, programs=programs_for(structure), data=data)
    assert (unresolved(again) > RESOLVED) is few


def test_rest_poses_in_part_are_answered_alike_by_both_methods() -> None:
    """Of A or B alone tails are so long that NUTS hands over."""
    answered_alike_by_both_methods(in_part()["A, and where B was"], "planar-moment+spin")


def test_a_vehicle_that_rolls_is_answered_alike_by_both_methods() -> None:
    """NUTS steers by where it comes to rest near enough; importance sampling asks no slope."""
    rolled = rolls(collision(share=0.0), "a", (0.9, 0.3, 0.2, 0.2))
    answered_alike_by_both_methods(rolled, "planar-moment+wheels")


def answered_alike_by_both_methods(scene: Scene, model: str) -> None:
    by_nuts, by_importance = (
        reconstruct(scene, RunOptions(model=model, method=method))
        for method in ("nuts", "importance")
    )
    assert by_nuts.settings["method"] == "nuts"
    assert by_importance.settings["method"] == "importance"
    assert by_nuts.checks.passed
    assert by_importance.checks.passed
    for name in ("speed_b", "e", "e_m", "mu"):
        one, other = (r.idata["posterior"][name].to_numpy() for r in (by_nuts, by_importance))
        # medians, for the tails of what rests on one vehicle are heavy
        assert abs(np.median(one) - np.median(other)) < 0.2 * np.std(other), name


def test_without_headings_at_rest_less_is_known_and_predicted() -> None:
    """The impact says most of how the cars spun, so that little is lost with them."""
    scene = collision()
    without = {v: replace(pose, heading=None) for v, pose in scene.rest.items()}
    quantities = [
        reconstruct(replace(scene, rest=rest), RunOptions(model="planar-moment+wheels"))
        for rest in (scene.rest, without)
    ]
    assert all(each.checks.passed for each in quantities)
    whole, partly = (each.idata["posterior"]["speed_b"].to_numpy() for each in quantities)
    assert abs(partly.mean() - whole.mean()) < partly.std()
    assert 0.95 * whole.std() < partly.std() < 3 * whole.std()
