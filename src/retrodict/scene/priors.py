"""Priors of the unknowns: read from priors.toml, or overridden by the scene file."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from retrodict.scene.defaults import Grade


@dataclass(frozen=True, slots=True)
class Prior:
    """Prior distribution of an unknown.

    Args:
        numbers: parameters of the distribution, SI units or radians, in the order of priors.toml.
        text: description for a report, a single line.
        reason: reason for these numbers.
        source: source of the numbers.
        grade: grade as in `Default`; an override counts as C, because nobody graded it.
        overridden: whether the scene file gives the prior.
    """

    numbers: tuple[float, ...]
    text: str
    reason: str
    source: str
    grade: Grade
    overridden: bool = False


def default_priors() -> dict[str, Prior]:
    """The priors of a scene that overrides none, by name.

    Returns:
        "speed_a", "speed_b": scale of a half-normal, m/s.
        "omega_a", "omega_b": sd of a normal at 0, rad/s.
        "e": parameters high, low and v (m/s) of a half-normal with scale
            high + (low - high) exp(-closing speed / v).
        "mu": scale of a half-normal in 1 - mu / mu_critical; median friction where sliding goes on.
        "e_m": centre and scale of a normal cut to (-1, 1).
        "impulse": sd of a normal at 0 of each component of delta-v, m/s.
        "Omega": sd of a normal at 0 of each vehicle's yaw rate after the impact, rad/s.
    """
    return {
        name: Prior(
            tuple(prior["numbers"].values()),
            prior["text"].format(*prior["numbers"].values()),
            prior["reason"],
            prior["source"],
            prior["grade"],
        )
        for name, prior in _defaults().items()
    }


def overridden(name: str, numbers: Mapping[str, float], source: str) -> Prior:
    """A prior with other numbers than the default's.

    Args:
        name: name of the unknown, as in `default_priors`.
        numbers: parameters that differ, by their keys in priors.toml, SI units or radians.
        source: source of these numbers.

    Returns:
        The prior; its reason names the default in whose place it stands.
    """
    prior = _defaults()[name]
    now = (prior["numbers"] | numbers).values()
    default = prior["text"].format(*prior["numbers"].values())
    reason = f"written in the scene file, in place of: {default}"
    return Prior(tuple(now), prior["text"].format(*now), reason, source, "C", True)


def prior_keys() -> dict[str, tuple[str, ...]]:
    """Keys of the numbers of each prior, by its name, in the order of `Prior.numbers`."""
    return {name: tuple(prior["numbers"]) for name, prior in _defaults().items()}


@cache
def _defaults() -> dict[str, Any]:
    return tomllib.loads(resources.files(__package__).joinpath("priors.toml").read_text("utf-8"))
