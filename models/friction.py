"""The prior of the equivalent friction mu between vehicles, as a NumPyro distribution."""

from __future__ import annotations

from typing import Any, ClassVar

import jax
import jax.numpy as jnp
from jax.scipy.special import ndtr
from jaxtyping import Array, Float
from numpyro import distributions as dist

# Where mu_c exceeds this, sliding as a rule goes on. Judgement: in the staged crashes that the prior
# cites (SAE 2014-01-0469) mu that ended the sliding was 1.7 to 2.5, by printed delta-v and Gamma, and
# was not used to set this, because these crashes score the program (docs/validation.md)
_MOST, _FADING = 2.0, 4
# shape of a log-logistic: 90 % within 19^(±1/5), a factor of 1.8, of its median
_SHAPE = 5.0
_LEAST = 1e-9  # size of mu_c: where there is no sliding to end, neither is there friction
_ROUNDING = 1e-6  # of mu_c: by how much mu may come out beyond it
_HALVINGS = 64  # of the interval that holds a quantile
_FARTHEST = 2e3  # medians: where the log-logistic leaves a probability of 3e-17


class Friction(dist.Distribution):
    """Distribution of mu below the mu_c that ends the sliding: a mixture of two kinds of contact.

    Either sliding nearly ends within the contact, and 1 - mu / mu_c is half-normal; or it goes on, and
    mu is log-logistic, cut at mu_c. The odds of the second kind are (mu_c / 2)^4.

    Args:
        critical: critical friction mu_c, of either sign, and huge in grazing contacts; any shape.
        scale: scale of the half-normal 1 - mu / mu_c where sliding ends.
        median: median of the log-logistic friction where sliding goes on, before the cut at mu_c.
        interlocked: whether parts may interlock and reverse the sliding: then 1 - mu / mu_c is normal
            about zero, and nothing is cut.
    """

    support = dist.constraints.real
    arg_constraints: ClassVar[dict[str, Any]] = {}
    pytree_data_fields = ("critical", "scale", "median")
    pytree_aux_fields = ("interlocked",)

    def __init__(
        self,
        critical: Float[Array, "*any"],
        scale: Float[Array, ""],
        median: Float[Array, ""],
        interlocked: bool = False,
    ) -> None:
        self.critical, self.scale, self.median = critical, scale, median
        self.interlocked = interlocked
        super().__init__(jnp.shape(critical))

    def log_prob(self, value: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Log density of mu."""
        size, log_odds = self._size_and_log_odds()
        mu = jnp.where(self.critical < 0, -value, value)
        share = mu / size
        ends = dist.Normal(0.0, self.scale).log_prob(1 - share) - jnp.log(size)
        mu = jnp.maximum(mu, _LEAST**2)
        x, most = (_SHAPE * jnp.log(v / self.median) for v in (mu, size))
        goes_on = jnp.log(_SHAPE / mu) + x - 2 * jax.nn.softplus(x)
        if not self.interlocked:  # all below mu_c
            ends, goes_on = ends + jnp.log(2.0), goes_on + jax.nn.softplus(-most)
        both = jnp.logaddexp(ends - jax.nn.softplus(log_odds), goes_on - jax.nn.softplus(-log_odds))
        inside = self.interlocked | (share < 1 + _ROUNDING)
        return jnp.where(inside, both, -jnp.inf)

    def cdf(self, value: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Probability of less friction than `value`, by size where mu_c is negative."""
        return self._below(jnp.where(self.critical < 0, -value, value))

    def icdf(self, q: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Inverse of `cdf`: friction by its probability, by bisection; a Newton step for derivatives."""
        critical, scale, median, wanted = jax.lax.stop_gradient(
            (self.critical, self.scale, self.median, q)
        )
        still = Friction(critical, scale, median, self.interlocked)
        size, _ = still._size_and_log_odds()
        far = 10 * scale * size
        low, high = jnp.broadcast_arrays(-far, size, wanted)[:2]
        if self.interlocked:
            high = high + far + _FARTHEST * median

        def halved(_: int, ends: tuple[Array, Array]) -> tuple[Array, Array]:
            middle = (ends[0] + ends[1]) / 2
            above = still._below(middle) < wanted
            return jnp.where(above, middle, ends[0]), jnp.where(above, ends[1], middle)

        ends = jax.lax.fori_loop(0, _HALVINGS, halved, (low, high))
        mu = (ends[0] + ends[1]) / 2
        density = jnp.exp(still.log_prob(jnp.where(critical < 0, -mu, mu)))
        off = (self._below(mu) - q) / jnp.where(density > 0, density, 1.0)
        # the last digits of the probability would move mu by more than bisection left open
        off = off - jax.lax.stop_gradient(off)
        return jnp.where(self.critical < 0, off - mu, mu - off)

    def _below(self, mu: Float[Array, "*any"]) -> Float[Array, "*any"]:
        """Probability of less friction than mu, in the sense of mu_c."""
        size, log_odds = self._size_and_log_odds()
        ends = ndtr((mu / size - 1) / self.scale)
        x = _SHAPE * jnp.log(jnp.maximum(mu, _LEAST**2) / self.median)
        goes_on = jax.nn.sigmoid(x)
        if not self.interlocked:
            ends, goes_on = 2 * ends, goes_on / jax.nn.sigmoid(_SHAPE * jnp.log(size / self.median))
        goes_on = jnp.where(mu > 0, goes_on, 0.0)
        return ends * jax.nn.sigmoid(-log_odds) + goes_on * jax.nn.sigmoid(log_odds)

    def sample(self, key: Array, sample_shape: tuple[int, ...] = ()) -> Float[Array, "*any"]:
        """Draws of mu."""
        shape = (*sample_shape, *self.batch_shape)
        keys = jax.random.split(key, 3)
        which, u = (jax.random.uniform(k, shape) for k in keys[:2])
        off = self.scale * jax.random.normal(keys[2], shape)
        (size, log_odds), most = self._size_and_log_odds(), jnp.ones(())
        if not self.interlocked:
            off, most = jnp.abs(off), jax.nn.sigmoid(_SHAPE * jnp.log(size / self.median))
        goes_on = self.median * (u * most / (1 - u * most)) ** (1 / _SHAPE)
        mu = jnp.where(which < jax.nn.sigmoid(-log_odds), (1 - off) * size, goes_on)
        return jnp.where(self.critical < 0, -mu, mu)

    def _size_and_log_odds(self) -> tuple[Float[Array, "*any"], Float[Array, "*any"]]:
        """Size of mu_c, and log odds that sliding goes on."""
        size = jnp.maximum(jnp.abs(self.critical), _LEAST)
        return size, _FADING * jnp.log(size / _MOST)
