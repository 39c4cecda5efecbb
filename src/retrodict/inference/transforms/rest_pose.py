"""Rest-pose coordinates of a posterior: a bijection that is no part of the model.

A rest pose measured to a hand's breadth pins the velocities after the impact to a thin curved
regression, so neither the paper's unknowns nor their whitening makes an easy target. Sampled instead is
q = (z_a, z_b, xi): how many standard deviations each rest pose misses its measurement by, and the
measured inputs as standard normal deviates. A quadratic in q, fitted to run-outs beforehand, gives
velocities after the impact; the impact model's closed-form inverse gives its unknowns. Any smooth
bijection with its Jacobian keeps the density exact, however roughly the quadratic fits.

e and e_m have hard bounds, and a posterior often leans on them (e near 0 is normal in hard
crashes). Both are quotients of functions linear in the motion, so that each bound is a margin: such a
function that stays above zero, as the opening velocity does. `constrain` moves q along one direction
for each margin, which changes it with the least change of all else, so that the margins lie at infinity
and every point within them is reached. A simpler impact model holds such functions at zero (no moment
impulse, no sliding left): then q is moved to points where they are zero, and has fewer coordinates than
entries. The share of the sliding that friction leaves is an entry of q itself, and the motion is held
at it. Margins are exactly linear in the motion and nearly so in q: q is moved as if they were linear in
it; then the motion is changed by the small remainder, the solution of linear equations.
"""

from __future__ import annotations

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from retrodict.inference.transforms.constraints import Constrained, constrain
from retrodict.inference.transforms.layout import (
    friction_scale,
    held_of,
    length_for_regressions,
    levels_of,
    log_det_of,
    margins,
    reduced,
    samples_sliding,
    separation_at,
    shaping_inputs,
    split,
    with_response_surface,
)
from retrodict.inference.transforms.parameters import (
    Affine,
    Constraints,
    Located,
    Q,
    Quadratic,
    Regressions,
    ResponseSurface,
)
from retrodict.inference.transforms.soft_bounds import soft_lower_bound
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import SLIDING, quotients
from retrodict.scene.names import parsed
from retrodict.scene.records import VEHICLES


def unknowns_of(
    structure: Structure,
    data: Data,
    q: Q,
    separation: Float[Array, " separation"],
    x: parts.Values,
) -> tuple[parts.Values, Float[Array, ""]]:
    """A value for each of the model's sample sites, and log |d sites / d separation|."""
    unknowns = RUNGS[structure.rung].impact.unknowns
    assert unknowns is not None, "else the structure is not in rest poses"
    sites, log_det = unknowns(separation, x)
    v_bx, v_by = sites.pop("velocity_b")
    direction = jnp.arctan2(v_by, v_bx)
    if "direction_b" in structure.known_of_b:
        middle = data.inputs["direction_b"][0]
        direction = middle + jnp.arctan2(jnp.sin(direction - middle), jnp.cos(direction - middle))
    if structure.uncertain:
        sites["measured"] = split(structure, q)[1]
    return sites | {"speed_b": jnp.sqrt(v_bx**2 + v_by**2), "direction_b": direction}, log_det


def example_regressions(structure: Structure) -> Regressions:
    """Regressions of the right shapes and no meaning."""
    v = len(structure.rests)
    sizes = [v + len(shaping_inputs(structure, vehicle)) for vehicle in VEHICLES]
    for_a, for_b = (Quadratic(np.zeros(v), np.zeros((v, k)), np.zeros((v, k, k))) for k in sizes)
    return for_a, for_b


def example_constraints(structure: Structure) -> Constraints:
    """Constraints of the right shapes and no meaning."""
    n, v, levels = _length(structure), len(structure.rests), levels_of(structure)
    m = len(margins(levels, np.ones(len(levels)), *np.ones((2, len(levels)))))
    nowhere = np.zeros((m, n))
    across, side = np.zeros((m, 2 * v + 1)), np.ones(len(levels))
    return Constraints(
        *(np.zeros(n), side, np.arange(m), np.zeros(m), nowhere, nowhere, across),
        *(np.ones(m), np.ones(())),
    )


def _length(structure: Structure) -> int:
    """Number of entries of q."""
    return length_for_regressions(structure) + samples_sliding(structure)


class RestPose(NamedTuple):
    """Rest poses determine the motion: they are coordinates, with surrogates for run-outs.

    Args:
        whitening: bijection w -> q.
        regressions: quadratics for A and B.
        constraints: constraints on the levels that the impact model bounds or holds.
        responses: response surface of each vehicle of `layout.with_response_surface`.
    """

    whitening: Affine
    regressions: Regressions
    constraints: Constraints
    responses: tuple[ResponseSurface, ...]

    @staticmethod
    def size_of(structure: Structure) -> int:
        """Number of entries of w: those of q less the number of held levels."""
        return _length(structure) - held_of(structure)

    @classmethod
    def example(cls, structure: Structure) -> RestPose:
        """A transform of the right shapes and no meaning, to compile programs for."""
        n, v = _length(structure), len(structure.rests)
        regressions = example_regressions(structure)
        responses = []
        for vehicle in with_response_surface(structure):
            m = len(structure.on_way_of(vehicle))
            k = regressions[VEHICLES.index(vehicle)].linear.shape[1]
            surface = Quadratic(np.zeros(m), np.zeros((m, k)), np.zeros((m, k, k)))
            responses.append(ResponseSurface(np.zeros(v), np.ones(v), surface))
        whitening = Affine(np.zeros(n), np.zeros((n, cls.size_of(structure))), np.zeros(()))
        return cls(whitening, regressions, example_constraints(structure), tuple(responses))

    @staticmethod
    def surrogates(structure: Structure) -> tuple[str, ...]:
        """Names of predictions with a surrogate: rest poses, then those of response surfaces."""
        on_way = (structure.on_way_of(v) for v in with_response_surface(structure))
        return (*structure.rest_components, *(name for names in on_way for name in names))

    def surrogate(
        self, structure: Structure, data: Data, q: Q, after: Float[Array, "2 v"], name: str
    ) -> Float[Array, ""]:
        """A run-out's prediction: rest poses by the regressions, others by response surfaces.

        Args:
            structure: static structure of the scene.
            data: numbers of the scene.
            q: point, shape (q,).
            after: velocities after the impact at q, m/s and rad/s, shape (2, v).
            name: name of a prediction that has a surrogate.
        """
        z, xi = split(structure, q)
        if name in structure.rest_components:
            return parts.rest_poses_at(structure, data, z).ravel()[
                structure.rest_components.index(name)
            ]
        v = parsed(name).vehicle
        response = self.responses[with_response_surface(structure).index(v)]
        shaping = np.array(shaping_inputs(structure, v), dtype=int)
        items = response(after[VEHICLES.index(v)], xi[shaping])
        return items[structure.on_way_of(v).index(name)]

    def solve_back(self, structure: Structure, data: Data, q: Q) -> parts.Values:
        """The model's unknowns at q = (z, xi) by regressions and closed form, without bounds."""
        at = separation_at(structure, data, self.regressions, q)
        return unknowns_of(structure, data, q, *at)[0]

    def transform_and_log_det(
        self, structure: Structure, data: Data, w: Float[Array, " w"]
    ) -> Located:
        """The unknowns at w, log |d unknowns / d w|, and q after constraints moved it.

        Args:
            structure: static structure of the scene.
            data: numbers of the scene.
            w: point of the sampled space, shape (w,).
        """
        q, log_det = self.whitening.transform_and_log_det(w)
        v = len(structure.rest_components)
        constrained = Constrained(q, jnp.zeros(v + 1), jnp.zeros(q.size), {}, jnp.zeros(()))
        if levels_of(structure):
            constrained = constrain(structure, data, self.constraints, self.regressions, q)
        slopes = reduced(structure, data, self.regressions, constrained.q)[1]
        separation, x = separation_at(structure, data, self.regressions, constrained.q)
        log_det += constrained.log_det + v * jnp.log(friction_scale(structure, data, x))
        log_det += log_det_of(slopes[0]) + log_det_of(slopes[1])
        x["speed_a"] += constrained.motion[v]
        q = constrained.q + constrained.by_q
        sites, log_inverse = unknowns_of(structure, data, q, separation + constrained.motion[:v], x)
        # B's speed and direction take the place of two components of its velocity
        log_det += log_inverse - jnp.log(sites["speed_b"])
        if samples_sliding(structure):  # sliding, held at share times divisor, moves with both
            x = parts.from_standard(structure, data, split(structure, q)[1])
            free = quotients((SLIDING,), separation + constrained.motion[:v], x)[1][0]
            softness = jnp.asarray(self.constraints.kept)
            log_det += (
                jnp.log(jnp.abs(free) * softness) + soft_lower_bound(softness * q[-1], softness)[1]
            )
        return sites | constrained.levels, log_det, q
