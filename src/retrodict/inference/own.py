"""Evidence and priors of the user's own, given in Python: checked, added to a scene, evaluated, worded.

A term is a function of the recorded quantities of a crash that returns a log likelihood. A prior is a
distribution of NumPyro that has a quantile.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float
from numpyro import distributions as dist

from retrodict.inference.errors import Unanswerable
from retrodict.models.arrays import Data, OwnTerm, Structure
from retrodict.models.priors import Beta, Cut
from retrodict.scene.priors import FIXED, SUPPORT, Prior, of_family, of_python
from retrodict.scene.records import Scene

Priors = Mapping[str, dist.Distribution]
Terms = Mapping[str, OwnTerm]

TERM, SLOPE = "log_likelihood/own_", "slope/own_"  # prefixes of what is recorded of a term
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_LEAST = 1e-6  # probability within the bounds of an unknown below which a prior is refused
# distributions of NumPyro with a quantile in closed form, and Beta, whose quantile is ours
WITH_QUANTILE = (
    "AsymmetricLaplace", "Beta", "Cauchy", "Exponential", "Gumbel", "HalfCauchy", "HalfNormal",
    "Laplace", "LogNormal", "Logistic", "LogUniform", "Normal", "TruncatedNormal", "Uniform",
)  # fmt: skip


def with_own(
    scene: Scene,
    priors: Priors | None = None,
    extra: Terms | None = None,
) -> Scene:
    """A scene with priors and likelihood terms of the user's own.

    Args:
        scene: measured scene.
        priors: distribution of an unknown by its name: speed_a, speed_b, e, e_m or mu; SI units.
        extra: log likelihood terms by a name of the user's: functions of the recorded quantities of a
            crash by name, SI units and radians, in `jax.numpy`, that return one number.

    Returns:
        The scene; the same one where nothing is given.

    Raises:
        ValueError: a name or a distribution cannot be used; the message says what to write instead.
    """
    given = {name: _prior(scene, name, law) for name, law in (priors or {}).items()}
    for name, term in (extra or {}).items():
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            raise ValueError(
                f"extra: {name!r} cannot name a term; write letters, digits and _, a letter first"
            )
        if not callable(term):
            raise ValueError(
                f'extra["{name}"] is no function; write one of the recorded quantities, such as '
                'lambda q: dist.Normal(20.0, 3.0).log_prob(q["speed_a"])'
            )
    if not given and not extra:
        return scene
    return replace(scene, priors=scene.priors | given, extra=scene.extra | dict(extra or {}))


def terms(structure: Structure, data: Data, quantities: Mapping[str, Array]) -> dict[str, Array]:
    """The log likelihood terms of the user's own at a crash.

    Args:
        structure: static structure of the scene, with the terms.
        data: numbers of the scene, with the inputs that are exact.
        quantities: quantities of the crash, by name.

    Returns:
        Log likelihood of each term, by `TERM` and its name; and by `SLOPE` and its name a number that
        changes its sign where the term is highest: a sum of the derivatives by the quantities.

    Raises:
        Unanswerable: a term cannot be computed, or returns no number.
    """
    found: dict[str, Array] = {}
    if not structure.own:
        return found
    exact = {name: jnp.asarray(pair)[0] for name, pair in data.inputs.items()}
    seen = {
        name: jnp.asarray(value)
        for name, value in (exact | dict(quantities)).items()
        if jnp.shape(value) == () and ("/" not in name or name.startswith("predicted/"))
    }
    for name, term in structure.own:
        value, by = jax.value_and_grad(lambda q, n=name, t=term: _value(n, t, q))(seen)
        found[f"{TERM}{name}"] = value
        # uneven weights, so that a difference of two quantities does not cancel
        found[f"{SLOPE}{name}"] = sum(
            (slope / (1 + i) for i, slope in enumerate(by.values())), jnp.zeros(())
        )
    return found


def total(found: Mapping[str, Array]) -> Float[Array, ""]:
    """Sum of the log likelihoods among `terms`."""
    return sum((v for name, v in found.items() if name.startswith(TERM)), jnp.zeros(()))


def _value(name: str, term: OwnTerm, quantities: dict[str, Array]) -> Float[Array, ""]:
    known = f"it is given the quantities {', '.join(sorted(quantities))}"
    try:
        value = jnp.asarray(term(quantities), float)
    except KeyError as error:
        raise Unanswerable(
            f'extra["{name}"]: the model has no quantity {error}; {known}'
        ) from error
    except Exception as error:  # whatever the user's code raises
        first = (str(error).splitlines() or [""])[0]
        raise Unanswerable(
            f'extra["{name}"] cannot be computed: {type(error).__name__}: {first}; write it with '
            "jax.numpy, as a function of the recorded quantities that returns one number"
        ) from error
    if value.shape != ():
        raise Unanswerable(
            f'extra["{name}"] returns an array of shape {value.shape}; return one number'
        )
    return value


def _prior(scene: Scene, name: str, law: Any) -> Prior:
    if name not in SUPPORT:
        raise ValueError(f"priors: {name!r} is none of {', '.join(SUPPORT)}")
    if name.startswith("speed_") and scene.inputs().get(name) is not None:
        raise ValueError(f'priors["{name}"]: the scene measures it; leave the prior out')
    if scene.single and name == "speed_b":
        raise ValueError('priors["speed_b"]: the scene has no vehicle B')
    if not isinstance(law, dist.Distribution) or law.batch_shape or law.event_shape:
        raise ValueError(
            f'priors["{name}"] is no distribution of one number; write one of NumPyro, such as '
            "dist.TruncatedNormal(0.1, 0.05, low=0.0, high=1.0)"
        )
    if isinstance(law, dist.Delta):
        value = float(law.v)
        _require_within(name, SUPPORT[name][0] <= value <= SUPPORT[name][1])
        return of_family(name, FIXED, {"value": value}, "given in Python")
    if type(law) is dist.Beta:
        law = Beta(law.concentration1, law.concentration0)
    low, high = SUPPORT[name]
    try:
        within = float(law.cdf(jnp.asarray(high))) - float(law.cdf(jnp.asarray(low)))
        middle = float(Cut(law, low, high).icdf(jnp.asarray(0.5)))
    except (NotImplementedError, ImportError, AttributeError, TypeError):
        raise ValueError(
            f'priors["{name}"]: {type(law).__name__} has no quantile (icdf) that can be computed; those '
            f"of NumPyro that have one: {', '.join(WITH_QUANTILE)}"
        ) from None
    _require_within(name, within > _LEAST and low <= middle <= high)
    return of_python(name, law, _in_words(law))


def _require_within(name: str, holds: bool) -> None:
    if not holds:
        low, high = SUPPORT[name]
        raise ValueError(
            f'priors["{name}"] has next to no probability between {low:g} and {high:g}, where it is '
            "possible; write another"
        )


def _in_words(law: dist.Distribution) -> str:
    """A distribution as it would be written, its numbers to four digits."""
    numbers = ", ".join(f"{key}={float(v):.4g}" for key, v in _numbers(law).items())
    name = re.sub("Distribution$|^TwoSided|^Left(?=T)|^Right(?=T)", "", type(law).__name__)
    base = getattr(law, "base_dist", None)
    inner = (
        f"{_in_words(base)}, " if isinstance(base, dist.Distribution) and base is not law else ""
    )
    return f"{name}({inner}{numbers})".replace(", )", ")")


def _numbers(law: dist.Distribution) -> dict[str, Any]:
    """Parameters of a distribution that are single numbers."""
    return {key: v for key, v in law.get_args().items() if jnp.shape(v) == ()}
