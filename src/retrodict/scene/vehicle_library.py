"""Vehicles that a scene may name by class or model in place of numbers: vehicle_library.toml."""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Any

from retrodict.scene.defaults import DEFAULTS, Default
from retrodict.scene.measured import Measured


@dataclass(frozen=True, slots=True)
class VehicleClass:
    """Figures for a vehicle of which only the class or the model is known.

    Each quantity's sd is the spread within the class; its source has a grade, and says how the figure
    was derived.

    Args:
        name: name of the class or model, as a scene file writes it.
        what: description of the vehicles that the name stands for.
        mass: mass, kg.
        wheelbase: wheelbase, m; None of what has no wheels side by side.
        cg_share: distance from the front axle to the centre of gravity, wheelbases.
        yaw_radius: radius of gyration in yaw, wheelbases.
        track: track, m; None likewise.
        length: length, m; None where no figure is known.
        width: width, m; None where no figure is known.
        models: number of models that means and spreads were taken over; None where they were not.
        articulated: true for a tractor with a trailer, taken as one rigid body.
    """

    name: str
    what: str
    mass: Measured
    wheelbase: Measured | None
    cg_share: Measured
    yaw_radius: Measured
    track: Measured | None
    length: Measured | None = None
    width: Measured | None = None
    models: int | None = None
    articulated: bool = False

    def assumed(self, measured: Measured) -> Measured:
        """A quantity of the class as a scene takes it: with a source that names the class.

        Args:
            measured: quantity of this class.
        """
        return replace(measured, source=f"assumed: the library's {self.name} ({measured.source})")


def vehicles() -> dict[str, VehicleClass]:
    """The library of vehicles that a scene may name by `class`.

    Returns:
        The entries by name, in SI units: the size classes, then models.

    Examples:
        >>> import retrodict as rd
        >>> rd.vehicles()["compact car"].mass.value > rd.vehicles()["subcompact car"].mass.value
        True
    """
    return dict(_library())


def find(name: str) -> VehicleClass | None:
    """The entry with a name, whatever its capitals; None where there is none.

    Args:
        name: name of a class or model, as somebody wrote it.
    """
    return {key.casefold(): each for key, each in _library().items()}.get(name.casefold())


def near(name: str) -> list[str]:
    """Names in the library that resemble a text, the nearest first; all where none does.

    Args:
        name: name of a class or model, as somebody wrote it.
    """
    folded = {key.casefold(): key for key in _library()}
    words = set(name.casefold().split())
    found = difflib.get_close_matches(name.casefold(), folded, 4) or [
        key for key in folded if words & set(key.split())
    ]
    return [folded[key] for key in found] or list(_library())


@cache
def _library() -> dict[str, VehicleClass]:
    text = resources.files(__package__).joinpath("vehicle_library.toml").read_text("utf-8")
    entries: dict[str, Any] = tomllib.loads(text)
    sources = entries.pop("sources")
    return {name: _entry(name, entry, sources) for name, entry in entries.items()}


def _entry(name: str, entry: dict[str, Any], sources: dict[str, str]) -> VehicleClass:
    def read(value: float, sd: float, grade: str, source: str) -> Measured:
        return _measured(value, sd, f"grade {grade}: {sources[source]}")

    read_entry = {k: read(**v) if isinstance(v, dict) else v for k, v in entry.items()}
    known: dict[str, Any] = {"wheelbase": None, "track": None} | _defaults() | read_entry
    return VehicleClass(name, **known)


def _defaults() -> dict[str, Measured]:
    share, radius = DEFAULTS["cg_to_front_axle"], DEFAULTS["yaw_radius"]
    # a yaw inertia goes with the square of its radius
    of_radius = DEFAULTS["yaw_inertia"].amount(radius.value) / 2
    return {
        "cg_share": _measured(share.value, DEFAULTS["cg_position"].value, _graded(share)),
        "yaw_radius": _measured(radius.value, of_radius, _graded(radius)),
    }


def _graded(default: Default) -> str:
    return f"grade {default.grade}: {default.source}"


def _measured(value: float, sd: float, source: str) -> Measured:
    return Measured(value, sd, "lognormal", source, "value")
