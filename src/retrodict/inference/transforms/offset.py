"""The transform of rolling vehicles: offsets from the velocities of the measured path.

Bounds are no margins here: beyond them there is no density.
"""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.inference.transforms.parameters import (
    Guess,
    Q,
    TransformParameters,
)
from retrodict.inference.transforms.protocol import Located, Transform
from retrodict.inference.transforms.rest_pose import (
    example_regressions,
    friction_scale,
    length_for_regressions,
    levels_of,
    log_det_of,
    reduced,
    spins,
    split,
    unknowns_of,
)
from retrodict.mechanics import either_side, towards_b
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import E, quotients
from retrodict.models.runouts import roll
from retrodict.scene.records import VEHICLES

_NO_CRASH = {"e": 0.1, "e_m": 0.5, "mu": 0.1}


class Offset(Transform):
    """Each vehicle by the misses of its rest pose or by offsets from a guessed velocity; w is q."""

    exact_gradient = True
    refit_to_draws = False
    by_regressions = False

    def length(self, structure: Structure) -> int:
        """Number of entries of q."""
        return length_for_regressions(structure)

    def example(self, structure: Structure) -> TransformParameters:
        """Parameters of the right shapes and no meaning."""
        parameters = super().example(structure)
        nothing = Guess(np.zeros(2), np.ones((2, 3)), np.zeros(()))
        return parameters._replace(regressions=example_regressions(structure), guess=nothing)

    def from_q(
        self,
        structure: Structure,
        data: Data,
        parameters: TransformParameters,
        q: Q,
        log_det: Float[Array, ""],
    ) -> Located:
        """The unknowns, the log determinant with that given, and q as it was moved."""
        sites, volume = _unknowns(structure, data, parameters, q)
        return sites, volume + log_det, q


def _unknowns(
    structure: Structure, data: Data, parameters: TransformParameters, q: Q
) -> tuple[parts.Values, Float[Array, ""]]:
    """Unknowns at q, and log |d unknowns / d q|."""
    guess, impact = parameters.guess, RUNGS[structure.rung].impact
    assert guess is not None, "parameters of offsets have one"
    last, spun = len(structure.rest_components) - 1, jnp.asarray(guess.spun) > 0
    deviate, q = q[last], q.at[last].set(jnp.where(spun, 0.0, q[last]))
    x = parts.from_standard(structure, data, split(structure, q)[1])
    scale = friction_scale(structure, data, x)
    velocities, slopes = reduced(structure, data, parameters, q)
    separation = scale * velocities.reshape(2, -1)
    volumes = [log_det_of(own) + len(own) * jnp.log(scale) for own in slopes]
    # of B but for its yaw rate
    flat = log_det_of(slopes[1][:2, :2]) + 2 * jnp.log(scale)
    for i, v in enumerate(VEHICLES):
        if v not in structure.integrated or v not in data.ways:
            continue
        u, units = q[3 * i : 3 * i + 3], jnp.asarray(guess.off)[i]
        off = dict(zip(roll.offsets(v), units * u, strict=True))
        off[f"roll_speed_{v}"] = jnp.exp(off[f"roll_speed_{v}"])
        end = jnp.nan_to_num(jnp.asarray(data.ways[v])[-1])
        V = roll.inverse(structure, data, x | off, v)(end)
        taken = jnp.asarray(guess.taken)[i] > 0
        own = jnp.log(V[0] ** 2 + V[1] ** 2) + jnp.log(units[0] * units[1])
        separation = separation.at[i].set(jnp.where(taken, V, separation[i]))
        volumes[i] = jnp.where(taken, own + jnp.log(units[2]), volumes[i])
        flat = jnp.where(taken, own, flat) if v == "b" else flat
    if spins(structure):
        middle, sd = data.inputs["omega_b"]
        # both yaw rates of B go together one to one (SAE 770014, eq 21)
        still = impact.unknowns(separation.at[1, 2].set(0.0).ravel(), x)[0]["omega_b"]
        turned = separation.at[1, 2].set(middle + sd * deviate - still)
        separation = jnp.where(spun, turned, separation)
        volumes[1] = jnp.where(spun, flat + jnp.log(sd), volumes[1])
    sites, log_inverse = unknowns_of(structure, data, q, separation.ravel(), x)
    log_det = log_inverse - jnp.log(sites["speed_b"]) + volumes[0] + volumes[1]
    bounded, inside = levels_of(structure), jnp.array(True)
    if bounded:
        over, under = quotients(bounded, separation.ravel(), x)
        low, high = (np.array([getattr(b, end) for b in bounded]) for end in ("low", "high"))
        inside = ((over / under > low) & (over / under < high)).all()
        # vehicles close in, each from its own side of the contact where it has one
        to, closing = parts.bodies(x), under[bounded.index(E)]
        inside &= (towards_b(to) * closing > 0) | ~either_side(to)
    # no crash stands for those outside: one is put in their place whose run-outs are short
    for name in [name for name in sites if name != "measured"]:
        sites[name] = jnp.where(inside, sites[name], _NO_CRASH.get(name, 1.0))
    return sites, jnp.where(inside, log_det, -jnp.inf)
