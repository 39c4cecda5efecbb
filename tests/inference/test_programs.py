"""Compiled programs: one set for all scenes of a structure."""

from dataclasses import replace

from retrodict.models.arrays import steps_of

from retrodict.inference.posterior import prepare
from tests.scenes import collision

RUNG = "planar-moment+wheels"


def test_a_scene_that_takes_more_steps_compiles_nothing() -> None:
    scene = collision(share=0.0)
    posterior = prepare(scene, RUNG)
    sharp = {v: replace(p, x=replace(p.x, sd=p.x.sd / 30)) for v, p in scene.rest.items()}
    other = prepare(replace(scene, rest=sharp), RUNG)
    steps = [steps_of(p.programs.structure, p.data) for p in (posterior, other)]
    assert steps[0] < steps[1]
    assert other.programs is posterior.programs
