"""The run-outs of vehicles that go on together: one point that slides, or one body on all wheels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import jax.numpy as jnp
from jaxtyping import Array, Float
from retrodict.models import parts
from retrodict.models.arrays import STEPS, Data, Structure
from retrodict.models.impacts.joined import masses
from retrodict.models.run_out import OF_WHEELS, RunOut
from retrodict.models.runouts import slide, wheels

from retrodict.mechanics import Path, rest
from retrodict.mechanics.integration import Paced
from retrodict.mechanics.together import Layout, joined, layout


def slid(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, "4"]
) -> Float[Array, "2 2"]:
    """Rest positions of both vehicles: as far as one point of their weight slides."""
    return slide.slid(x, after, _mean_friction(structure, data, x))


def slid_along(structure: Structure, data: Data, x: parts.Values, after: Float[Array, "4"]) -> Path:
    """Straight paths of both vehicles to rest, stacked."""
    return slide.slid_along(x, after, _mean_friction(structure, data, x))


def _mean_friction(structure: Structure, data: Data, x: parts.Values) -> Float[Array, "2"]:
    """The mean of both vehicles' friction by weight, for each of them."""
    mass = masses(x).mass
    mean = mass @ slide.friction(structure, data, x) / mass.sum()
    return jnp.stack([mean, mean])


def rest_poses(
    structure: Structure, data: Data, x: parts.Values, after: Float[Array, "6"]
) -> Float[Array, "2 3"]:
    """Rest poses of both vehicles for velocities after the impact."""
    at, pose = _follow(rest, structure, data, x, after)
    return at.poses(pose)


def paths(structure: Structure, data: Data, x: parts.Values, after: Float[Array, "6"]) -> Path:
    """Paths of both vehicles to rest, stacked."""
    at, path = _follow(wheels.in_rows, structure, data, x, after)
    return at.paths(path)


def _follow[T](
    follow: Callable[..., T],
    structure: Structure,
    data: Data,
    x: parts.Values,
    after: Float[Array, "6"],
) -> tuple[Layout, T]:
    """How the vehicles lie, and `follow(pose, velocity, body, ground, steps)` of the body they make."""
    of = masses(x)
    at = layout(parts.impact_poses(x), of.mass)
    V = of.mass @ after.reshape(2, 3)[:, :2] / of.mass.sum()
    grip = jnp.stack([x["grip_a"], x["grip_b"]])
    body = joined(at, of, parts.cars(structure, x), grip)
    # friction of the surfaces alone: each wheel's load has its tyre's grip
    on = parts.ground(structure, data, x | {"grip_a": jnp.ones(()), "grip_b": jnp.ones(())})
    on = on._replace(coefficients=jnp.asarray(on.coefficients)[0])
    steps: Any = structure.steps or data.steps
    if structure.rolling and not structure.steps:
        steps = Paced(data.steps.number / STEPS)
    return at, follow(at.pose, jnp.append(V, after[2]), body, on, steps)


_STAY = "the weight of each vehicle stays on its own wheels"

AS_POINTS = replace(
    slide.RUN_OUT,
    description=replace(
        slide.RUN_OUT.description,
        title="a straight slide to rest",
        assumptions=(
            "both slide straight and as far as one another, as if they did not yaw",
            *slide.RUN_OUT.description.assumptions[1:],
        ),
    ),
    rest_poses=slid,
    paths=slid_along,
)
AS_BODY = RunOut(
    description=replace(
        wheels.RUN_OUT.description,
        title="a skid to rest of the joined body on the wheels of both",
        assumptions=(*wheels.RUN_OUT.description.assumptions, _STAY),
        left_out=(
            "steering or braking in between; load transfer; pitch and roll; slopes that change along "
            "the way",
        ),
    ),
    rests=("x", "y", "heading"),
    seen=lambda scene: replace(
        scene, vehicles={v: replace(own, cg_height=None) for v, own in scene.vehicles.items()}
    ),
    rest_poses=rest_poses,
    paths=paths,
    nesting=wheels.RUN_OUT.nesting,
    needs=OF_WHEELS,
)
