"""The density of a posterior in sampled coordinates, and its simulations, predictions and paths.

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

from retrodict.inference import own
from retrodict.inference.transforms import layout
from retrodict.inference.transforms.choice import Transform
from retrodict.inference.transforms.parameters import Numbers, Regressions
from retrodict.inference.transforms.standard import Deviates
from retrodict.mechanics import either_side, towards_b
from retrodict.models import RUNGS, parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import quotients
from retrodict.models.priors import elementwise
from retrodict.models.standard_normal import AtDeviates, sample_unknowns

# Root mean square to which steeper gradients of a potential are cut. That of a standard normal is about
# 1, and those at draws stay below 2.5 (measured); beyond the draws it may rise to thousands within a
# step, and where a rolling car's steps are differentiated it can be any number.
_STEEPEST = 3.0
# Potential outside of the support: a density of e^-500 in place of zero.
OUTSIDE = 500.0


class Evaluated[A](NamedTuple):
    """Values of the posterior at points, as arrays of JAX or of NumPy.

    Args:
        log_density: log posterior density in w.
        quantities: the model's unknowns, and the quantities derived from them, by name.
        q: q after constraints moved it; the deviates, where these are coordinates.
        missed: exact minus surrogate prediction of each item that has a surrogate.
    """

    log_density: A
    quantities: dict[str, A]
    q: A
    missed: A


class Target:
    """The posterior of a rung and a scene's structure.

    Args:
        structure: static structure of the scene: its uncertain inputs, evidence and surfaces.
    """

    def __init__(self, structure: Structure) -> None:
        self.structure = structure
        self.rung = RUNGS[structure.rung]

    def log_density(
        self, w: Float[Array, " q"], data: Data, transform: Transform
    ) -> Float[Array, ""]:
        """Log posterior density in w: the model's joint at the unknowns, times the Jacobian.

        The value is exact; the gradient takes the run-outs' slopes from surrogates (regressions and
        response surfaces). Leapfrog steps keep volume and are reversible under any field of forces, and
        NUTS weights its points by the value, so it samples the same density; the quality of surrogates
        changes only the effective sample size. Run-outs need not be differentiated: a gradient costs
        little more than a value, and the sampler compiles in half the time. Run-outs are differentiated
        only where rest poses do not determine the motion, and for evidence along the path to rest.
        """
        return self.evaluate(w, data, transform).log_density

    def evaluate(
        self,
        w: Float[Array, " q"],
        data: Data,
        transform: Transform,
        missed: Float[Array, " surrogates"] | None = None,
    ) -> Evaluated[Array]:
        """`log_density`, and the other values of `Evaluated` at a point.

        Args:
            w: point in the sampled coordinates, shape (w,).
            data: the scene's numbers.
            transform: the coordinates.
            missed: exact minus surrogate predictions, so that no run-out is needed, shape (surrogates,);
                run-outs give those that are NaN, or all if None.
        """
        sites, log_det, q = transform.transform_and_log_det(self.structure, data, w)
        if isinstance(transform, Deviates):
            log_likelihood, quantities = self.crash(q, data)
            log_prior = jax.scipy.stats.norm.logpdf(q).sum()
            return Evaluated(log_prior + log_likelihood + log_det, quantities, q, jnp.zeros(0))
        names = transform.surrogates(self.structure)
        off = jnp.zeros(len(names))

        def surrogate(name: str, after: Float[Array, " separation"], exact: Array) -> Array:
            nonlocal off
            if name not in names:
                return exact
            near = transform.surrogate(self.structure, data, q, after.reshape(2, -1), name)
            i, by = names.index(name), jax.lax.stop_gradient(exact - near)
            if missed is not None:
                by = jnp.where(jnp.isnan(missed[i]), by, missed[i])
            off = off.at[i].set(by)
            return near + by

        given = {"surrogate": surrogate}
        joint, trace = log_density(self.rung.model, (self.structure, data), given, sites)
        quantities = sites | _recorded(trace)
        terms = own.terms(self.structure, data, quantities)
        return Evaluated(joint + log_det + own.total(terms), quantities | terms, q, off)

    def crash(self, u: Numbers, data: Data) -> tuple[Array, dict[str, Array]]:
        """The crash at standard normal deviates of all unknowns.

        Args:
            u: deviates, shape (n,).
            data: the scene's numbers.

        Returns:
            Its log likelihood, minus infinity where the vehicles part; and its unknowns, what follows
            from them, predictions of the evidence, and divisors of what the impact model bounds.
        """
        model = AtDeviates(self.rung.model, jnp.asarray(u))
        trace = handlers.trace(model).get_trace(self.structure, data)
        samples = {k: s for k, s in trace.items() if s["type"] == "sample"}
        observed = [s for s in samples.values() if s["is_observed"]]
        log_likelihood = sum((s["fn"].log_prob(s["value"]) for s in observed), jnp.zeros(()))
        unknowns = {k: s["value"] for k, s in samples.items() if not s["is_observed"]}
        quantities = unknowns | _recorded(trace)
        levels = () if self.structure.single else layout.levels_of(self.structure)
        if levels:
            names = (name for of_one in parts.AFTER for name in of_one if name in quantities)
            after = jnp.stack([quantities[name] for name in names])
            deviates = unknowns.get("measured", jnp.zeros(0))
            x = parts.from_standard(self.structure, data, deviates)
            for level, divisor in zip(levels, quotients(levels, after, x)[1], strict=True):
                quantities[f"divisor/{level.name}"] = divisor
        terms = own.terms(self.structure, data, quantities)
        return log_likelihood + own.total(terms), quantities | terms

    def crashes(self, data: Data, u: Numbers) -> tuple[Array, dict[str, Array]]:
        """`crash` at each row of u."""
        return jax.vmap(lambda row: self.crash(row, data))(jnp.asarray(u))

    def inputs(self, data: Data, xi: Numbers) -> tuple[Array, Array, Array, Array]:
        """Impact poses, k², friction and `layout.friction_scale` of each row of deviates."""

        def one(deviates: Array) -> tuple[Array, Array, Array, Array]:
            x = parts.from_standard(self.structure, data, deviates)
            friction = x[f"friction_{self.structure.surfaces[0]}"]
            scale = layout.friction_scale(self.structure, data, x)
            k2 = jnp.asarray(parts.cars(self.structure, x).k2)
            return parts.impact_poses(x), k2, friction, scale

        return jax.vmap(one)(jnp.asarray(xi))

    def reached(self, data: Data, separation: Numbers, xi: Numbers) -> Array:
        """Rest poses of each motion, a row of velocities after the impact and one of deviates."""

        def one(V: Array, deviates: Array) -> Array:
            x = parts.from_standard(self.structure, data, deviates)
            return self.rung.run_out.rest_poses(self.structure, data, x, V)

        return jax.vmap(one)(jnp.asarray(separation), jnp.asarray(xi))

    def levels(self, data: Data, regressions: Regressions, q: Numbers) -> tuple[Array, ...]:
        """Numerators and denominators of the levels at q, and their derivatives by q.

        The motion at q is that of the regressions. Derivatives of the velocities over sqrt(friction) by
        z follow. Last comes the sign of the normal from A to B as measured, which shows where the
        vehicles close in; 0 where both are on one side of the contact.
        """

        def value(q: Array) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
            at = layout.separation_at(self.structure, data, regressions, q)
            both = quotients(layout.levels_of(self.structure), *at)
            return both, both

        q = jnp.asarray(q)
        slopes, values = jax.jacfwd(value, has_aux=True)(q)
        as_measured = parts.from_standard(
            self.structure, data, jnp.zeros(len(self.structure.uncertain))
        )
        by_z = layout.reduced(self.structure, data, regressions, q)[1]
        to = parts.bodies(as_measured)
        return *values, *slopes, by_z, jnp.where(either_side(to), towards_b(to), 0.0)

    def potential(self, w: Array, data: Data, transform: Transform) -> Array:
        """Minus the log density."""
        return -self.log_density(w, data, transform)

    def steered(self, w: Array, data: Data, transform: Transform) -> Array:
        """`potential`, with a gradient that is cut where it is steeper than at draws of a posterior.

        NUTS samples the same density under any field of forces, and diverges where these grow faster
        than its steps are short: beside a steep bound that no draw reaches, or where the differentiated
        steps of a rolling vehicle blow up, though the value is smooth there.
        """
        value, slope = jax.value_and_grad(self.potential)(w, data, transform)
        # leaving the support is then a rejection and no divergence, which is a rise by a thousand
        value = jnp.where(jnp.isfinite(value), value, OUTSIDE)
        slope = jax.lax.stop_gradient(shortened(slope))
        return jax.lax.stop_gradient(value) + jnp.sum(slope * (w - jax.lax.stop_gradient(w)))

    def simulate(self, data: Data, sites: Mapping[str, Numbers]) -> dict[str, Array]:
        """Quantities that the model records of each crash, whose unknowns are rows of `sites`."""

        def one(values: parts.Values) -> dict[str, Array]:
            conditioned = handlers.substitute(self.rung.model, values)
            trace = handlers.trace(handlers.seed(conditioned, 0)).get_trace(self.structure, data)
            return _recorded(trace)

        return jax.vmap(one)(jax.tree.map(jnp.asarray, sites))

    def log_prior(self, data: Data, sites: Mapping[str, Numbers]) -> dict[str, Array]:
        """Log prior density of each unknown of each crash, whose unknowns are rows of `sites`.

        Those of measured inputs are of their standard normal deviates.
        """

        def one(values: parts.Values) -> dict[str, Array]:
            conditioned = handlers.substitute(handlers.seed(sample_unknowns, 0), values)
            trace = handlers.trace(conditioned).get_trace(self.rung.impact, self.structure, data)
            return {k: elementwise(trace[k]["fn"]).log_prob(v) for k, v in values.items()}

        return jax.vmap(one)(jax.tree.map(jnp.asarray, dict(sites)))

    def prior(self, keys: Array, data: Data) -> dict[str, Array]:
        """The unknowns of one crash from the prior for each random key."""

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
        """Path of each motion to rest: its poses, their times, and the velocities before impact."""

        def one(V: Array, deviates: Array) -> dict[str, Array]:
            x = parts.from_standard(self.structure, data, deviates)
            taken = self.rung.run_out.paths(self.structure, data, x, V)
            before = V.reshape(len(self.structure.vehicles), -1)[:, :2] - parts.delta_v(x, V)
            return {"pose": taken.pose, "time": taken.time, "before": before}

        return jax.vmap(one)(jnp.asarray(separation), jnp.asarray(xi))

    def evaluate_rows(
        self, data: Data, transform: Transform, w: Numbers, missed: Numbers
    ) -> Evaluated[Array]:
        """`evaluate` at each row of w, with the row of `missed` that belongs to it."""

        def one(w: Array, missed: Array) -> Evaluated[Array]:
            return self.evaluate(w, data, transform, missed)

        return jax.vmap(one)(jnp.asarray(w), jnp.asarray(missed))


def shortened(slope: Float[Array, " w"]) -> Float[Array, " w"]:
    """A slope of the potential, cut where it is very steep, and none where it is no number.

    Args:
        slope: slope by the coordinates, shape (w,).
    """
    steepness = jnp.sqrt(jnp.mean(slope**2))
    shorter = slope * jnp.minimum(1.0, _STEEPEST / steepness)
    return jnp.where(jnp.isfinite(steepness), shorter, 0.0)


def _recorded(trace: dict[str, Any]) -> dict[str, Array]:
    """Values that a run of the model records: quantities, conditions, predictions and likelihoods."""
    quantities = {k: s["value"] for k, s in trace.items() if s["type"] == "deterministic"}
    for k, s in trace.items():
        if k == parts.CLOSE_IN:
            quantities[f"condition/{k}"] = s["fn"].log_factor
        elif s["type"] == "sample" and s["is_observed"]:
            quantities[f"predicted/{k}"] = s["fn"].mean
            quantities[f"log_likelihood/{k}"] = s["fn"].log_prob(s["value"])
    return quantities
