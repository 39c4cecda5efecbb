"""The run-out of a rigid body on four locked wheels over one surface."""

from __future__ import annotations

from dataclasses import replace

from retrodict.models.description import Description
from retrodict.models.run_out import NORMAL_ERRORS, OF_WHEELS, ONE_FRICTION, RunOut, level, rolls
from retrodict.models.runouts import wheels

from retrodict.scene.records import Measured, Scene


def seen(scene: Scene) -> Scene:
    """The scene with its road everywhere, one friction at all speeds, and all wheels locked."""
    road, *others = (
        replace(surface, speed_dependence=Measured(0.0))
        for surface in (*scene.surfaces, *scene.skidded_on)
    )
    skidded_on = tuple(surface for surface in others if surface.name in scene.slid_on)
    vehicles = {
        v: replace(vehicle, wheels=None, grip=Measured(1.0))
        for v, vehicle in scene.vehicles.items()
    }
    return level(replace(scene, vehicles=vehicles, surfaces=(road,), skidded_on=skidded_on))


RUN_OUT = RunOut(
    description=Description(
        name="spin",
        title="a skid to rest on four locked wheels over one surface",
        equations=(
            "run-out: planar rigid body on four locked wheels with static loads, one friction "
            "against the slip of each wheel, in the spirit of Ellis, which SAE 770014 cites",
        ),
        assumptions=(
            "all four wheels of every vehicle are locked, or slide as if they were, from impact to rest",
            ONE_FRICTION,
            NORMAL_ERRORS,
        ),
        left_out=(
            "other surfaces, rolling wheels, differences of tyres; load transfer, pitch and roll; "
            "slopes",
        ),
    ),
    rests=("x", "y", "heading"),
    seen=seen,
    rest_poses=wheels.rest_poses,
    paths=wheels.paths,
    needs=OF_WHEELS,
    nesting=frozenset({"yaw"}),
    refusal=rolls,
)
