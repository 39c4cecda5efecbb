"""What is computed of a posterior: its density in sampled coordinates, and what goes with that.

Pure functions of a rung and a scene's structure; a scene's numbers come in as arguments.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float
from numpyro import handlers
from numpyro.infer.util import log_density

from retrodict.inference.transforms import rest_pose
from retrodict.inference.transforms.choice import transform_of
from retrodict.inference.transforms.parameters import Numbers, TransformParameters
from retrodict.mechanics import either_side, towards_b
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import quotients

# Slope of a potential, root of mean square, to which steeper ones are cut. That of a standard normal is
# about 1, and those of draws stay below 2.5 (measured); beyond them it may rise to thousands within a
# step, and at points of a rolling car's differentiated steps it is any number.
_STEEPEST = 3.0


class Evaluated[A](NamedTuple):
    """What points are known by, in arrays of JAX or of NumPy.

    Args:
        log_density: posterior, in w.
        quantities: the model's unknowns, and what follows from them.
        q: where coordinates take it.
        missed: by what surrogates miss those predictions that have one.
    """

    log_density: A
    quantities: dict[str, A]
    q: A
    missed: A


class Target:
    """The posterior of a rung and a scene's structure.

    Args:
        structure: which inputs are uncertain, and which evidence and surfaces there are.
    """

    def __init__(self, structure: Structure) -> None:
        self.structure = structure
        self.rung = RUNGS[structure.rung]

    def log_density(
        self, w: Float[Array, " q"], data: Data, transform: TransformParameters
    ) -> Float[Array, ""]:
        """Log posterior density in w: the model's joint at the unknowns, times the Jacobian.

        The value is exact; the gradient takes the run-outs' slopes from surrogates (regressions and
        response surfaces). Leapfrog steps keep volume and are reversible under any field of forces, and
        NUTS weights its points by the value, so it samples the same density; the quality of surrogates
        changes only the effective sample size. Run-outs need not be differentiated: a gradient costs
        little more than a value, and the sampler compiles in half the time. Only where rest poses do not
        determine the motion, and for what was measured on the way, run-outs are differentiated.
        """
        return self.evaluate(w, data, transform).log_density

    def evaluate(
        self,
        w: Float[Array, " q"],
        data: Data,
        transform: TransformParameters,
        missed: Float[Array, " surrogates"] | None = None,
    ) -> Evaluated[Array]:
        """`log_density`, and what else a point is known by.

        Args:
            w: the point.
            data: the scene's numbers.
            transform: its coordinates.
            missed: by what surrogates miss, so that no run-out is needed; where it is not given, or no
                number, run-outs give it.
        """
        kind = transform_of(self.structure)
        sites, log_det, q = kind.forward_and_log_det(self.structure, data, transform, w)
        names = kind.surrogates(self.structure)
        off = jnp.zeros(len(names))

        def surrogate(name: str, after: Float[Array, " separation"], exact: Array) -> Array:
            nonlocal off
            if name not in names:
                return exact
            near = rest_pose.surrogate_value(
                self.structure, data, transform, q, after.reshape(2, -1), name
            )
            i, by = names.index(name), jax.lax.stop_gradient(exact - near)
            if missed is not None:
                by = jnp.where(jnp.isnan(missed[i]), by, missed[i])
            off = off.at[i].set(by)
            return near + by

        given = {} if kind.exact_gradient else {"surrogate": surrogate}
        joint, trace = log_density(self.rung.model, (self.structure, data), given, sites)
        return Evaluated(joint + log_det, sites | _recorded(trace), q, off)

    def inputs(self, data: Data, xi: Numbers) -> tuple[Array, Array, Array, Array]:
        """Impact poses, k², friction and its scale of each row of deviates."""

        def one(deviates: Array) -> tuple[Array, Array, Array, Array]:
            x = parts.from_standard(self.structure, data, deviates)
            friction = x[f"friction_{self.structure.surfaces[0]}"]
            scale = rest_pose.friction_scale(self.structure, data, x)
            k2 = jnp.asarray(parts.cars(self.structure, x).k2)
            return parts.impact_poses(x), k2, friction, scale

        return jax.vmap(one)(jnp.asarray(xi))

    def reached(self, data: Data, separation: Numbers, xi: Numbers) -> Array:
        """Where each motion comes to rest."""

        def one(V: Array, deviates: Array) -> Array:
            x = parts.from_standard(self.structure, data, deviates)
            return self.rung.run_out.rest_poses(self.structure, data, x, V)

        return jax.vmap(one)(jnp.asarray(separation), jnp.asarray(xi))

    def levels(self, data: Data, transform: TransformParameters, q: Numbers) -> tuple[Array, ...]:
        """Quotients of the levels at q by the regressions, their slopes by q, and the slopes by z.

        Then the normal's sense from A to B as measured, which shows where the vehicles close in; 0 where
        both stand on one side of the contact.
        """

        def value(q: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
            at = rest_pose.separation_at(self.structure, data, transform, q)
            both = quotients(rest_pose.levels_of(self.structure), *at)
            return both, both

        q = jnp.asarray(q)
        slopes, values = jax.jacfwd(value, has_aux=True)(q)
        as_measured = parts.from_standard(
            self.structure, data, jnp.zeros(len(self.structure.uncertain))
        )
        by_z = rest_pose.reduced(self.structure, data, transform, q)[1]
        to = parts.bodies(as_measured)
        return *values, *slopes, by_z, jnp.where(either_side(to), towards_b(to), 0.0)

    def potential(self, w: Array, data: Data, transform: TransformParameters) -> Array:
        """Minus the log density."""
        return -self.log_density(w, data, transform)

    def steered(self, w: Array, data: Data, transform: TransformParameters) -> Array:
        """`potential`, with a gradient that is cut where it is steeper than at draws of a posterior.

        NUTS samples the same density under any field of forces, and diverges where these grow faster
        than its steps are short: beside a steep bound that no draw reaches, or where the differentiated
        steps of a rolling vehicle blow up, though the value is smooth there.
        """
        value, slope = jax.value_and_grad(self.potential)(w, data, transform)
        steepness = jnp.sqrt(jnp.mean(slope**2))
        shorter = slope * jnp.minimum(1.0, _STEEPEST / steepness)
        slope = jax.lax.stop_gradient(jnp.where(jnp.isfinite(steepness), shorter, 0.0))
        return jax.lax.stop_gradient(value) + jnp.sum(slope * (w - jax.lax.stop_gradient(w)))

    def simulate(self, data: Data, sites: Mapping[str, Numbers]) -> dict[str, Array]:
        """What the model records of each crash, whose unknowns are rows of `sites`."""

        def one(values: parts.Values) -> dict[str, Array]:
            conditioned = handlers.substitute(self.rung.model, values)
            trace = handlers.trace(handlers.seed(conditioned, 0)).get_trace(self.structure, data)
            return _recorded(trace)

        return jax.vmap(one)(jax.tree.map(jnp.asarray, sites))

    def prior(self, keys: Array, data: Data) -> dict[str, Array]:
        """The unknowns of a crash from the prior by each key."""

        def one(key: Array) -> dict[str, Array]:
            trace = handlers.trace(handlers.seed(self.rung.model, key)).get_trace(
                self.structure, data
            )
            return {
                k: s["value"]
                for k, s in trace.items()
                if s["type"] == "sample" and not s["is_observed"]
            }

        return jax.vmap(one)(keys)

    def paths(self, data: Data, separation: Numbers, xi: Numbers) -> dict[str, Array]:
        """How each motion comes to rest: its poses, their times, and the velocities before impact."""

        def one(V: Array, deviates: Array) -> dict[str, Array]:
            x = parts.from_standard(self.structure, data, deviates)
            taken = self.rung.run_out.paths(self.structure, data, x, V)
            before = V.reshape(len(self.structure.vehicles), -1)[:, :2] - parts.delta_v(x, V)
            return {"pose": taken.pose, "time": taken.time, "before": before}

        return jax.vmap(one)(jnp.asarray(separation), jnp.asarray(xi))

    def potential_and_gradient(
        self, w: Numbers, data: Data, transform: TransformParameters
    ) -> tuple[Array, Array]:
        """`potential`, and its slope by w."""
        return jax.value_and_grad(self.potential)(w, data, transform)

    def evaluate_rows(
        self, data: Data, transform: TransformParameters, w: Numbers, missed: Numbers
    ) -> Evaluated[Array]:
        """`evaluate` at each row of w, given each row of what surrogates miss."""

        def one(w: Array, missed: Array) -> Evaluated[Array]:
            return self.evaluate(w, data, transform, missed)

        return jax.vmap(one)(jnp.asarray(w), jnp.asarray(missed))

    def evaluate_with_slopes(
        self, data: Data, transform: TransformParameters, w: Numbers, missed: Numbers
    ) -> tuple[Evaluated[Array], Array]:
        """`evaluate_rows`, and the slopes of the potential there."""

        def value(w: Array, missed: Array) -> tuple[Array, Evaluated[Array]]:
            there = self.evaluate(w, data, transform, missed)
            return -there.log_density, there

        slopes, there = jax.vmap(jax.grad(value, has_aux=True))(jnp.asarray(w), jnp.asarray(missed))
        return there, slopes


def _recorded(trace: dict[str, Any]) -> dict[str, Array]:
    """What a run of the model records: quantities, predictions of the evidence and their likelihoods."""
    quantities = {k: s["value"] for k, s in trace.items() if s["type"] == "deterministic"}
    for k, s in trace.items():
        if s["type"] == "sample" and s["is_observed"]:
            quantities[f"predicted/{k}"] = s["fn"].mean
            quantities[f"log_likelihood/{k}"] = s["fn"].log_prob(s["value"])
    return quantities
