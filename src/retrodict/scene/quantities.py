"""The label of each named quantity and the units in which it is reported."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from retrodict.scene import fields
from retrodict.scene.energy import ENERGY

Units = Literal["si", "us"]
SYSTEMS: tuple[Units, ...] = ("si", "us")


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit to print in: `symbol`, and how many SI units (or radians) it is worth."""

    symbol: str
    worth: float


_DEGREE = 0.017453292519943295
_UNITS: dict[str, dict[Units, Unit]] = {
    "speed": {"si": Unit("m/s", 1.0), "us": Unit("mph", 0.44704)},
    "length": {"si": Unit("m", 1.0), "us": Unit("ft", 0.3048)},
    "angle": {"si": Unit("deg", _DEGREE), "us": Unit("deg", _DEGREE)},
    "yaw rate": {"si": Unit("rad/s", 1.0), "us": Unit("deg/s", _DEGREE)},
    "mass": {"si": Unit("kg", 1.0), "us": Unit("lb", 0.45359237)},
    "inertia": {"si": Unit("kg m²", 1.0), "us": Unit("lb ft s²", 1.3558179483314004)},
    "inverse speed": {"si": Unit("s/m", 1.0), "us": Unit("1/mph", 1 / 0.44704)},
    "energy": {"si": Unit("kJ", 1000.0), "us": Unit("ft lbf", 1.3558179483314004)},
    "impulse": {"si": Unit("N s", 1.0), "us": Unit("lbf s", 4.4482216152605)},
    "time": {"si": Unit("s", 1.0), "us": Unit("s", 1.0)},
    "grade": {"si": Unit("%", 0.01), "us": Unit("%", 0.01)},
    "number": {"si": Unit("", 1.0), "us": Unit("", 1.0)},
}
_SI_SYMBOLS = {
    "angle": "rad",
    "energy": "J",
    "grade": "",
}  # where numbers are reported in another unit than stored

# reported unknowns, in the order of reports: name -> (label, dimension)
REPORTED: dict[str, tuple[str, str]] = {
    "travelling_speed_a": ("travelling speed of A before its skid", "speed"),
    "speed_a": ("impact speed of A", "speed"),
    "travelling_speed_b": ("travelling speed of B before its skid", "speed"),
    "speed_b": ("impact speed of B", "speed"),
    "e": ("restitution e", "number"),
    "e_m": ("impact moment coefficient e_m", "number"),
    "mu": ("equivalent friction μ", "number"),
    "vbx": ("velocity of B before impact, x", "speed"),
    "vby": ("velocity of B before impact, y", "speed"),
    "omega_b": ("yaw rate of B before impact", "yaw rate"),
}
# unknowns that figures show, in this order: name -> short label
SHORT: dict[str, str] = {
    "travelling_speed_a": "travelling speed of A",
    "speed_a": "impact speed of A",
    "travelling_speed_b": "travelling speed of B",
    "speed_b": "impact speed of B",
    "e": "e",
    "e_m": "e_m",
    "mu": "μ",
}
# unknowns that a scene may ask for, in this order
UNKNOWNS = ("speed_a", "speed_b", "e", "e_m", "mu")

SPEEDS = tuple(name for name in REPORTED if "speed_" in name)

# quantities that follow from the same draws and are reported with the unknowns
DERIVED = (
    "delta_v_a",
    "delta_v_b",
    "pdof_a",
    "pdof_b",
    "energy_lost",
    "Vax",
    "Vay",
    "Omega_a",
    "Vbx",
    "Vby",
    "Omega_b",
)

_SINGLE: dict[str, tuple[str, str]] = {
    "impact_x": ("impact centre, x", "length"),
    "impact_y": ("impact centre, y", "length"),
    "impulse_x": ("impulse on A, x", "impulse"),
    "impulse_y": ("impulse on A, y", "impulse"),
    "Vax": ("velocity of A after impact, x", "speed"),
    "Vay": ("velocity of A after impact, y", "speed"),
    "Vbx": ("velocity of B after impact, x", "speed"),
    "Vby": ("velocity of B after impact, y", "speed"),
    "energy_lost": ("kinetic energy lost in the impact", "energy"),
    "moment_work": ("work of the moment impulse", "energy"),
    "impulse": ("impulse on A", "impulse"),
    "Omega": ("yaw rates after the impact", "yaw rate"),
    "closing_speed": ("closing speed along the normal", "speed"),
    "normal_impulse": ("normal impulse, positive where it parts the vehicles", "impulse"),
    "mu_available": ("friction that the contact can exert", "number"),
    "mu_critical": ("μ at which sliding just ends", "number"),
    **{f"impact_{key}": (label, "energy") for key, label in ENERGY.items()},
    **{f"impact_{key}": (own.label, "number") for key, own in fields.COEFFICIENTS.items()},
}

_FAMILIES: dict[str, tuple[str, str]] = {
    "drag_front_left": ("braking of {}'s front left wheel over friction", "number"),
    "drag_front_right": ("braking of {}'s front right wheel over friction", "number"),
    "drag_rear_left": ("braking of {}'s rear left wheel over friction", "number"),
    "drag_rear_right": ("braking of {}'s rear right wheel over friction", "number"),
    "drag_factor": ("factor common to the drags of {}'s wheels", "number"),
    "steer": ("steer angle of {}'s front wheels", "angle"),
    "roll_speed": ("speed of {} after impact over that by its way", "number"),
    "roll_course": ("direction of {} after impact less that of its way", "angle"),
    "roll_yaw_rate": ("yaw rate of {} after impact less that by its rotation", "yaw rate"),
    "impact_speed": ("impact speed of {}", "speed"),
    "Omega": ("yaw rate of {} after impact", "yaw rate"),
    "delta_v": ("change of velocity of {} (delta-v)", "speed"),
    "pdof": ("principal direction of force on {} (PDOF), clockwise from straight ahead", "angle"),
    "yaw_mark": ("speed of {} over the critical speed of its yaw mark", "number"),
    "rest_x": ("rest of {}, x", "length"),
    "rest_y": ("rest of {}, y", "length"),
    "rest_heading": ("rest of {}, heading", "angle"),
    "time_zero": ("time of the impact in the record of {}", "time"),
}

_PIECE = re.compile(r"skid_(\d+)(.*)")  # of a skid in several pieces
_OWN = "own_"  # before the name of a likelihood term of the user's own
_OF_EDGES = {"edge": ("place of the {}'s edge", "length")}
_AT_MARKS: dict[str, tuple[str, str]] = {
    "": ("distance from its path", "length"),
    "speed": ("speed there", "speed"),
    "course": ("direction of travel there", "angle"),
}


def describe(name: str) -> tuple[str, str]:
    """Label and dimension of a quantity by its flat name.

    Args:
        name: flat name in `Scene.inputs`, `Scene.evidence` or `REPORTED`, or of a variable of the
            posterior.

    Returns:
        (label, dimension); dimension is a key for `unit_of`.

    Raises:
        KeyError: no quantity has that name.
    """
    if name in REPORTED:
        return REPORTED[name]
    if name.startswith(_OWN):
        return f"the user's own term {name.removeprefix(_OWN)}", "number"
    if single := _SINGLE.get(name) or fields.flat_labels(fields.IMPACT | fields.SLOPE).get(name):
        return single
    of_surfaces = fields.flat_labels(fields.SURFACE) | _OF_EDGES
    for family, (label, dimension) in of_surfaces.items():
        if name.startswith(f"{family}_"):
            return label.format(name.removeprefix(f"{family}_")), dimension
    family, _, vehicle = name.rpartition("_")
    if family.startswith("mark_"):
        number, _, item = family.removeprefix("mark_").partition("_")
        label, dimension = _AT_MARKS[item]
        return f"mark {number} of {vehicle.upper()}, {label}", dimension
    if (piece := _PIECE.match(family)) and (known := fields.described(f"skid{piece[2]}")):
        label, dimension = known
        return label.format(f"{vehicle.upper()}, piece {piece[1]}"), dimension
    label, dimension = fields.described(family) or _FAMILIES[family]
    return label.format(vehicle.upper()), dimension


def unit_of(dimension: str, units: Units = "si") -> Unit:
    """The unit that a dimension is reported in ("si" or "us" customary).

    Raises:
        ValueError: `units` is neither.
    """
    by_system = _UNITS[dimension]
    if units not in by_system:
        raise ValueError(f'units are "si" or "us"; not {units!r}')
    return by_system[units]


def label_and_unit(name: str, units: Units) -> tuple[str, Unit]:
    """Label of a quantity, and the unit that it is printed in.

    Args:
        name: flat name of the quantity.
        units: "si" or "us".

    Returns:
        (label, unit).

    Raises:
        KeyError: no quantity has that name.
    """
    label, dimension = describe(name)
    return label, unit_of(dimension, units)


def si_symbol(dimension: str) -> str:
    """The SI unit that numbers of a dimension are stored in (angles in rad)."""
    return _SI_SYMBOLS.get(dimension, _UNITS[dimension]["si"].symbol)
