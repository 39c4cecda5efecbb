"""Scenes with a known truth and few unknowns: the paper's cars, forward through the impact to rest."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure

from retrodict import load_scene
from retrodict.mechanics import Bodies, Coefficients, contact_velocity, critical_mu, separation
from retrodict.scene.records import Measured, Scene

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "brach-1977-berm" / "scene.toml"
TRUTH = {"speed_b": 19.3, "direction_b": np.radians(-12.0), "omega_b": -0.3, "e": 0.1, "e_m": 0.7}
RUNG = RUNGS["planar-moment+wheels"]
SHARE = 0.7  # of its critical value is mu
STEPS = 768  # of the run-outs that make the rest poses

_separation, _critical = jax.jit(separation), jax.jit(critical_mu)


def sharp(scene: Scene) -> Scene:
    """The scene with nothing uncertain but A's speed, Gamma, frictions and rest poses."""

    def exact(record: Any) -> Any:
        known = {n: getattr(record, n) for n in record.__dataclass_fields__}
        fixed = {k: replace(m, sd=0.0) for k, m in known.items() if isinstance(m, Measured)}
        return replace(record, **fixed)

    a = scene.approach["a"]
    return replace(
        scene,
        vehicles={v: exact(vehicle) for v, vehicle in scene.vehicles.items()},
        approach=scene.approach | {"a": replace(exact(a), speed=a.speed)},
        contact=replace(exact(scene.contact), Gamma=scene.contact.Gamma),
        surfaces=tuple(
            replace(s, edge=s.edge and replace(s.edge, offset=replace(s.edge.offset, sd=0.0)))
            for s in scene.surfaces
        ),
    )


def made(
    speed: float = 0.5,
    friction_sd: float | None = None,
    turn: float = 0.0,
    sds: float = 1.0,
    grip: float = 1.0,
) -> tuple[Scene, dict[str, float]]:
    """A scene whose rest poses are where its truth leads.

    Args:
        speed: factor on all velocities before the impact; at 1 they are the paper's.
        friction_sd: relative, of both surfaces; None for what the example has.
        turn: of the contact line, rad.
        sds: factor on every standard deviation.
        grip: factor on the friction of both surfaces.

    Returns:
        The scene, and what was true of it: the unknowns, the spin of B after the impact (rad/s), the
        closing speed (m/s).
    """
    scene = sharp(load_scene(EXAMPLE))

    def blurred(m: Measured, value: float | None = None) -> Measured:
        value = m.value if value is None else value
        return replace(m, value=value, sd=sds * m.sd)

    a, contact = scene.approach["a"], scene.contact
    assert a.speed is not None
    surfaces = []
    for s in scene.surfaces:
        value = grip * s.friction.value
        sd = grip * s.friction.sd if friction_sd is None else friction_sd * value
        surfaces.append(replace(s, friction=replace(s.friction, value=value, sd=sds * sd)))
    scene = replace(
        scene,
        approach=scene.approach | {"a": replace(a, speed=blurred(a.speed, speed * a.speed.value))},
        contact=replace(contact, Gamma=blurred(contact.Gamma, contact.Gamma.value + turn)),
        surfaces=tuple(surfaces),
    )
    structure, data = RUNG.of_scene(scene)
    x = {k: jnp.asarray(m.value) for k, m in scene.inputs().items()}
    bodies = Bodies(*map(float, parts.bodies(x)))
    truth = TRUTH | {"speed_b": speed * TRUTH["speed_b"], "omega_b": speed * TRUTH["omega_b"]}
    v, course = truth["speed_b"], truth["direction_b"]
    before = jnp.array(
        [*parts.approach_of_a(x).tolist(), v * np.cos(course), v * np.sin(course), truth["omega_b"]]
    )
    critical = float(_critical(before, bodies, truth["e"], truth["e_m"]))
    truth["mu"] = float(np.clip(SHARE * critical, -1.0, 1.0))
    after = _separation(before, bodies, Coefficients(truth["e"], truth["mu"], truth["e_m"]))
    poses = np.asarray(_rests(replace(structure, steps=STEPS), data, x, after))
    rest = {}
    for vehicle, (px, py, heading) in zip("ab", poses.tolist(), strict=True):
        r = scene.rest[vehicle]
        values = (blurred(r.x, px), blurred(r.y, py), blurred(r.heading, heading))
        rest[vehicle] = replace(r, x=values[0], y=values[1], heading=values[2], turns_known=True)
    normal = np.array([np.cos(bodies.Gamma), np.sin(bodies.Gamma)])
    closing = abs(float(np.asarray(contact_velocity(before, bodies)) @ normal))
    return replace(scene, rest=rest), truth | {"spin": float(after[5]), "closing": closing}


@partial(jax.jit, static_argnums=0)
def _rests(structure: Structure, data: Data, x: parts.Values, after: Any) -> Any:
    return RUNG.run_out.rest_poses(structure, data, x, after)
