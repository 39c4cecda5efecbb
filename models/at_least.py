"""The likelihood of a bound: a delta-v whose recording ended too early, an energy as at most."""

from __future__ import annotations

from typing import ClassVar

import jax.numpy as jnp
from jax.scipy.special import betainc, log_ndtr
from jax.scipy.stats import norm
from jaxtyping import Array, Float
from numpyro import distributions as dist
from numpyro.distributions import constraints

from retrodict.scene.records import FREEDOM

_Number = Float[Array, ""] | float


class AtLeast(dist.Distribution):
    """Law of a bound b that was measured of a quantity q with error sd: Φ((q − b) / sd).

    What was measured is q less a part u ≥ 0 that the recorder lost, all of which are as probable
    before; integrated over u, the normal density of b becomes Φ. A negative bound is one on −q.

    `mean` is what the record is expected to show given q and b, q less the mean of u: b less
    sd φ/Φ. The mean is b where q lies far beyond b, and q where b lies far beyond q. Its distance from
    b is the residual by which the item is judged, and (mean − b) / sd² is the slope of the log
    likelihood by b, as for a normal item; sensitivity studies use this slope.

    Args:
        quantity: predicted quantity q.
        sd: standard deviation of the error of the bound, in the unit of the bound.
        bound: measured bound b.
        robust: whether the error has heavy tails (Student-t).
    """

    arg_constraints: ClassVar[dict[str, object]] = {}
    support = constraints.real
    outwards: ClassVar[float] = 1.0  # the sense from the bound to what satisfies it

    def __init__(self, quantity: _Number, sd: _Number, bound: _Number, robust: bool) -> None:
        self.sign = self.outwards * jnp.where(jnp.asarray(bound) < 0, -1.0, 1.0)
        self.bound, self.sd, self.robust = bound, sd, robust
        self.beyond = self.sign * (quantity - bound) / sd  # standard deviations that q exceeds b by
        super().__init__(batch_shape=(), event_shape=())

    def log_prob(self, value: Array, intermediates: object = None) -> Array:
        """Log likelihood; `value` is the bound that the law was made with."""
        if not self.robust:
            return log_ndtr(self.beyond)
        square = self.beyond**2
        tail = betainc(FREEDOM / 2, 0.5, FREEDOM / (FREEDOM + square)) / 2
        return jnp.where(self.beyond < 0, jnp.log(tail), jnp.log1p(-tail))

    @property
    def mean(self) -> Array:
        """What the record is expected to show."""
        ratio = jnp.exp(norm.logpdf(self.beyond) - log_ndtr(self.beyond))
        return self.bound - self.sign * self.sd * ratio


class AtMost(AtLeast):
    """The mirror of `AtLeast`, of a bound that the quantity stays below: Φ((b − q) / sd).

    What was measured is q plus a part u ≥ 0.
    """

    outwards: ClassVar[float] = -1.0
