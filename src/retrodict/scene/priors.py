"""Priors of the unknowns: read from priors.toml, or the user's own: other numbers, another law."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

from retrodict.scene.defaults import Grade

# families of priors that a scene file may name, and the keys of their numbers
FAMILIES: dict[str, tuple[str, ...]] = {
    "normal": ("mean", "sd"),
    "lognormal": ("mean", "sd"),
    "uniform": ("low", "high"),
    "beta": ("alpha", "beta"),
    "fixed": ("value",),
}
FIXED, OF_PYTHON = "fixed", "python"
# unknowns whose prior may be of a family, and the bounds at which it is cut, SI units
SUPPORT: dict[str, tuple[float, float]] = {
    "speed_a": (0.0, math.inf),
    "speed_b": (0.0, math.inf),
    "e": (0.0, 1.0),
    "e_m": (-1.0, 1.0),
    "mu": (0.0, math.inf),
}
_TEXTS = {
    "normal": "normal, {0:.3g} ± {1:.3g}",
    "lognormal": "log-normal, mean {0:.3g}, sd {1:.3g}",
    "uniform": "uniform from {0:.3g} to {1:.3g}",
    "beta": "beta, α = {0:.3g}, β = {1:.3g}",
    "fixed": "fixed at {0:.6g}",
}
_BY_FILE = "written in the scene file"


@dataclass(frozen=True, slots=True)
class Prior:
    """Prior distribution of an unknown.

    Args:
        numbers: parameters of the distribution, SI units or radians, in the order of priors.toml, or of
            `FAMILIES`.
        text: description for a report, a single line.
        reason: reason for these numbers.
        source: source of the numbers.
        grade: grade as in `Default`; an override counts as C, because nobody graded it.
        overridden: whether the user gives the prior.
        family: family of the distribution, a key of `FAMILIES` or "python"; empty for the default's.
        law: NumPyro distribution of the family "python"; else None.
    """

    numbers: tuple[float, ...]
    text: str
    reason: str
    source: str
    grade: Grade
    overridden: bool = False
    family: str = ""
    law: Any = None

    @property
    def fixed(self) -> bool:
        """Whether the unknown is not unknown: it has one value."""
        return self.family == FIXED


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
    text = prior["text"].format(*now)
    return Prior(tuple(now), text, _in_place_of(name, _BY_FILE), source, "C", True)


def of_family(name: str, family: str, numbers: Mapping[str, float], source: str) -> Prior:
    """A prior of a family.

    Args:
        name: name of the unknown, a key of `SUPPORT`.
        family: name of the family, a key of `FAMILIES`.
        numbers: parameters of the distribution, by their keys in `FAMILIES`, SI units.
        source: source of these numbers.
    """
    values = tuple(numbers[key] for key in FAMILIES[family])
    text = _in_words(name, _TEXTS[family].format(*values), family)
    return Prior(values, text, _in_place_of(name, _BY_FILE), source, "C", True, family)


def of_python(name: str, law: object, words: str) -> Prior:
    """A prior that is a NumPyro distribution.

    Args:
        name: name of the unknown, a key of `SUPPORT`.
        law: distribution of a number, SI units.
        words: description of the distribution.
    """
    text = _in_words(name, words, OF_PYTHON)
    reason = _in_place_of(name, "given in Python")
    return Prior((), text, reason, "the user of the program", "C", True, OF_PYTHON, law)


def keys_of(name: str, prior: Prior) -> tuple[str, ...]:
    """Keys of a prior's numbers, in their order; empty for a distribution given in Python."""
    if prior.family:
        return FAMILIES.get(prior.family, ())
    return tuple(_defaults()[name]["numbers"])


def fixed_of(priors: Mapping[str, Prior]) -> frozenset[str]:
    """Names of the unknowns that a prior fixes.

    Args:
        priors: prior of each unknown, by name.
    """
    return frozenset(name for name, prior in priors.items() if prior.fixed)


def _in_words(name: str, law: str, family: str) -> str:
    """A law in words, with its unit and what it is cut at."""
    low, high = SUPPORT[name]
    unit = " m/s" if name.startswith("speed_") else ""
    cut = ""
    if family in ("normal", "lognormal", OF_PYTHON):
        cut = f", cut to {low:g} to {high:g}" if math.isfinite(high) else f", cut at {low:g}"
    if name != "mu":
        return f"{law}{unit}{cut}"
    return (
        f"friction that the contact can exert: {law}{cut}; |μ| is that friction, or |μ_c| where sliding "
        "ends before"
    )


def _in_place_of(name: str, given: str) -> str:
    prior = _defaults()[name]
    default = prior["text"].format(*prior["numbers"].values())
    return f"the user's own, {given}, in place of: {default}"


@cache
def _defaults() -> dict[str, Any]:
    return tomllib.loads(resources.files(__package__).joinpath("priors.toml").read_text("utf-8"))
