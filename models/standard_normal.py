"""A model's unknowns as standard normal deviates: each the quantile of its own prior at its deviate.

In these coordinates the prior of any model is a standard normal on all of R^n, and what it bounds lies
at infinity: they cover whatever the model allows, without branches (Rosenblatt 1952). The log density of
the posterior is that of the deviates plus the log likelihood, without a Jacobian determinant.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from threading import RLock
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float
from numpyro import handlers
from numpyro.primitives import Messenger
from retrodict.models import parts
from retrodict.models.arrays import Data, Structure
from retrodict.models.impact import Impact, Separation
from retrodict.models.priors import deviate, quantile

TRACING = RLock()
"""Held while a model is traced: NumPyro has one stack of handlers, which threads would share."""


class AtDeviates(Messenger):
    """A handler that gives each unobserved `sample` the quantile of its law at its deviates.

    Args:
        model: NumPyro model.
        deviates: deviates of all unknowns in the order in which these are sampled, shape (n,).
    """

    def __init__(self, model: Any, deviates: Float[Array, " n"]) -> None:
        super().__init__(model)
        self.deviates = deviates
        self.sizes: dict[str, int] = {}

    def process_message(self, msg: dict[str, Any]) -> None:
        """Set the value of an unobserved sample site."""
        if msg["type"] != "sample" or msg["is_observed"] or msg["value"] is not None:
            return
        shape = msg["fn"].shape()
        begin, size = sum(self.sizes.values()), math.prod(shape)
        own = self.deviates[begin : begin + size].reshape(shape)
        msg["value"] = quantile(msg["fn"], own)
        self.sizes[msg["name"]] = size


class DeviatesOf(Messenger):
    """A handler that records the deviates of each unobserved `sample`, whose values are given.

    Args:
        model: NumPyro model.
        values: value of each unobserved sample site, by name.
    """

    def __init__(self, model: Any, values: Mapping[str, Array]) -> None:
        super().__init__(model)
        self.values = values
        self.deviates: list[Array] = []

    def process_message(self, msg: dict[str, Any]) -> None:
        """Set the value of an unobserved sample site, and record its deviates."""
        if msg["type"] == "sample" and not msg["is_observed"]:
            msg["value"] = jnp.asarray(self.values[msg["name"]])
            self.deviates.append(deviate(msg["fn"], msg["value"]).reshape(-1))


def sample_unknowns(
    impact: Impact, structure: Structure, data: Data
) -> tuple[parts.Values, Data, Separation]:
    """The part of a model that has all of its unknowns: measured inputs, then the impact.

    Args:
        impact: impact model.
        structure: static part of the scene.
        data: numbers of the scene.

    Returns:
        Measured inputs by name; the numbers of the scene as `as_recorded` gives them; and velocities
        after the impact.
    """
    x = parts.measured(structure, data)
    data = parts.as_recorded(structure, data, x)
    return x, data, impact.forward_model(structure, data, x)


@lru_cache(maxsize=64)
def _sizes(impact: Impact, structure: Structure, shapes: tuple[Any, ...]) -> dict[str, int]:
    leaves, tree = shapes
    data = jax.tree.unflatten(tree, [jax.ShapeDtypeStruct(shape, float) for shape in leaves])

    found: dict[str, int] = {}

    def trace(key: Array, data: Data) -> Array:
        sites = handlers.trace(handlers.seed(sample_unknowns, key)).get_trace(
            impact, structure, data
        )
        for name, site in sites.items():
            if site["type"] == "sample" and not site["is_observed"]:
                found[name] = int(site["value"].size)
        return jnp.zeros(())

    with TRACING:
        jax.eval_shape(trace, jax.random.key(0), data)
    return found


def sizes(impact: Impact, structure: Structure, data: Data) -> dict[str, int]:
    """How many deviates each unknown of a model has, by name, in the order in which it is sampled.

    Args:
        impact: impact model; run-outs have no unknowns.
        structure: static part of the scene.
        data: numbers of the scene, of which only the shapes matter.
    """
    leaves, tree = jax.tree.flatten(data)
    shapes = tuple(tuple(jnp.shape(leaf)) for leaf in leaves)
    return _sizes(impact, structure, (shapes, tree))
