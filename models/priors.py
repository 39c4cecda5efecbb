"""Priors of the unknowns that a user gives: families of a scene file, and distributions of NumPyro.

Each is a law with a quantile, because every unknown is the quantile of its law at a standard normal
deviate (`standard_normal`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpyro
from jax.scipy.special import betainc, ndtr, ndtri
from jaxtyping import Array, Float
from numpyro import distributions as dist
from retrodict.models.arrays import Data, Structure

from retrodict.scene.priors import FIXED, SUPPORT

# Probabilities nearer to 0 or 1 than this are taken as this: quantiles there are infinite.
_LEAST, _MOST = 1e-300, 1 - 1e-15
_HALVINGS = 60  # of the interval that holds a quantile

Number = Float[Array, "*any"]


def quantile(law: dist.Distribution, deviate: Number) -> Number:
    """The value of a law at a standard normal deviate.

    Args:
        law: distribution with an `icdf`, independent in each dimension.
        deviate: standard normal deviates, in the shape of a value of the law.

    Returns:
        Quantile of the law at the probability Φ(deviate).
    """
    law = elementwise(law)
    if isinstance(law, dist.Normal):
        return jnp.asarray(law.loc + law.scale * deviate)
    return jnp.asarray(law.icdf(jnp.clip(ndtr(deviate), _LEAST, _MOST)))


def deviate(law: dist.Distribution, value: Number) -> Number:
    """The standard normal deviate of a law's value: the inverse of `quantile`.

    Args:
        law: distribution with a `cdf`, independent in each dimension.
        value: value in the support of the law.
    """
    law = elementwise(law)
    if isinstance(law, dist.Normal):
        return jnp.asarray((value - law.loc) / law.scale)
    return ndtri(jnp.clip(law.cdf(value), _LEAST, _MOST))


def unknown(
    name: str,
    structure: Structure,
    data: Data,
    default: Callable[..., dist.Distribution] | None = None,
    site: str = "",
) -> Float[Array, ""]:
    """Sample an unknown from the law that the user gives, or else from the default.

    Args:
        name: name of the unknown, as in `Scene.priors`.
        structure: static structure of the scene, with the families of the user's priors.
        data: numbers of the scene, with those of the priors.
        default: law where the user gives none, by the numbers of the prior.
        site: name of the sample site; empty where it is the unknown's.

    Returns:
        The value; a constant, and no sample site, where the prior fixes it.
    """
    if structure.family(name) == FIXED:
        return numpyro.deterministic(site or name, jnp.asarray(data.priors[name])[0])
    law = given(name, structure, data)
    if law is None:
        assert default is not None, "a prior that is not the user's own has a default"
        law = default(*data.priors[name])
    return numpyro.sample(site or name, law)


def given(name: str, structure: Structure, data: Data) -> dist.Distribution | None:
    """The law of an unknown that the user gives, cut at what is possible; None where there is none.

    Args:
        name: name of the unknown, as in `Scene.priors`.
        structure: static structure of the scene, with the families of the user's priors.
        data: numbers of the scene, with those of the priors.
    """
    family, numbers = structure.family(name), data.priors[name]
    low, high = SUPPORT.get(name, (0.0, 0.0))
    match family:
        case None:
            return None
        case "normal":
            mean, sd = numbers
            return _cut_normal(mean, sd, low, high)
        case "lognormal":
            mean, sd = numbers
            variance = jnp.log1p((sd / mean) ** 2)
            return Cut(dist.LogNormal(jnp.log(mean) - variance / 2, jnp.sqrt(variance)), low, high)
        case "uniform":
            return dist.Uniform(*numbers)
        case "beta":
            return Beta(*numbers)
    return Cut(numbers, low, high)


def _cut_normal(mean: Array, sd: Array, low: float, high: float) -> dist.Distribution:
    """A normal law cut at bounds, the upper of which may be infinite."""
    if high == float("inf"):
        return dist.TruncatedNormal(mean, sd, low=low)
    return dist.TruncatedNormal(mean, sd, low=low, high=high)


class Cut(dist.Distribution):
    """Any law of a number, cut at bounds.

    Args:
        law: distribution with `cdf` and `icdf`.
        low: lower bound.
        high: upper bound; may be infinite.
    """

    support = dist.constraints.real
    arg_constraints: ClassVar[dict[str, Any]] = {}
    pytree_data_fields = ("law",)
    pytree_aux_fields = ("low", "high")

    def __init__(self, law: dist.Distribution, low: float, high: float) -> None:
        self.law, self.low, self.high = law, low, high
        super().__init__(law.batch_shape)

    def log_prob(self, value: Number) -> Number:
        """Log density of a value; minus infinity beyond the bounds."""
        below, above = self._ends
        inside = (value >= self.low) & (value <= self.high)
        density = self.law.log_prob(jnp.clip(value, self.low, self.high)) - jnp.log(above - below)
        return jnp.where(inside, density, -jnp.inf)

    def cdf(self, value: Number) -> Number:
        """Probability of a lower value."""
        below, above = self._ends
        at = self.law.cdf(jnp.clip(value, self.low, self.high))
        return jnp.clip((at - below) / (above - below), 0.0, 1.0)

    def icdf(self, q: Number) -> Number:
        """Inverse of `cdf`."""
        below, above = self._ends
        share = jnp.clip(below + q * (above - below), _LEAST, _MOST)
        return jnp.clip(self.law.icdf(share), self.low, self.high)

    def sample(self, key: Array, sample_shape: tuple[int, ...] = ()) -> Number:
        """Draws of the law."""
        return self.icdf(jax.random.uniform(key, (*sample_shape, *self.batch_shape)))

    @property
    def _ends(self) -> tuple[Number, Number]:
        """Probabilities below the bounds, by the law that is not cut."""
        below = self.law.cdf(jnp.asarray(self.low)) if self._bounds_from_below else jnp.zeros(())
        above = self.law.cdf(jnp.asarray(self.high)) if self.high < float("inf") else jnp.ones(())
        return jnp.asarray(below), jnp.asarray(above)

    @property
    def _bounds_from_below(self) -> bool:
        """Whether the law may extend below the lower bound; a log-normal has no value at 0."""
        return not (isinstance(self.law, dist.LogNormal) and self.low <= 0)


class Beta(dist.Beta):
    """NumPyro's beta distribution, whose own quantile needs TensorFlow Probability."""

    def icdf(self, q: Number) -> Number:
        """Inverse of `cdf`, by bisection."""
        return _beta_quantile(self.concentration1, self.concentration0, q)


@jax.custom_jvp
def _beta_quantile(alpha: Number, beta: Number, q: Number) -> Number:
    def halved(_: int, ends: tuple[Array, Array]) -> tuple[Array, Array]:
        middle = (ends[0] + ends[1]) / 2
        above = betainc(alpha, beta, middle) < q
        return jnp.where(above, middle, ends[0]), jnp.where(above, ends[1], middle)

    shape = jnp.broadcast_shapes(*(jnp.shape(each) for each in (alpha, beta, q)))
    ends = jax.lax.fori_loop(0, _HALVINGS, halved, (jnp.zeros(shape), jnp.ones(shape)))
    return (ends[0] + ends[1]) / 2


@_beta_quantile.defjvp
def _by_probability(
    at: tuple[Number, Number, Number], moved: tuple[Number, Number, Number]
) -> tuple[Number, Number]:
    """The derivative by the probability alone: the numbers of a prior are not differentiated."""
    value = _beta_quantile(*at)
    density = jnp.exp(dist.Beta(at[0], at[1]).log_prob(value))
    return value, moved[2] / jnp.maximum(density, 1e-300)


def elementwise(law: dist.Distribution) -> dist.Distribution:
    """The law of one element of a law that is the same, or independent, in each."""
    while isinstance(law, dist.Independent | dist.ExpandedDistribution):
        law = law.base_dist
    return law
