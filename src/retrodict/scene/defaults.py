"""What is assumed where a scene file is silent: each figure with its grade and its source."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import Literal

Grade = Literal["A", "B", "C"]


@dataclass(frozen=True, slots=True)
class Default:
    """An assumed figure.

    Args:
        quantity: what it is for, in words.
        value: the figure: one standard deviation, unless `quantity` says otherwise.
        unit: "%", "m", "deg", "deg/s", or "wheelbases".
        grade: A, read in a source; B, derived from figures read; C, judgement.
        source: where it comes from and why.
    """

    quantity: str
    value: float
    unit: str
    grade: Grade
    source: str

    def __str__(self) -> str:
        return f"{self.value:g} {self.unit} (grade {self.grade}: {self.source})"

    def of(self, value: float) -> float:
        """The figure in SI units or radians; `value` is what a percent is of, or the wheelbase."""
        worth = {
            "%": abs(value) / 100,
            "wheelbases": value,
            "m": 1.0,
            "deg": radians(1),
            "deg/s": radians(1),
        }
        return self.value * worth[self.unit]


_HEADING = "judgement: with tyre marks; allow 8 deg without marks"

DEFAULTS: dict[str, Default] = {
    "mass": Default(
        "mass",
        2,
        "%",
        "C",
        "judgement: for a weighed vehicle; allow 4 % for kerb weight and occupants",
    ),
    "yaw_inertia": Default(
        "yaw inertia, given or estimated",
        8,
        "%",
        "B",
        "published estimators differ by about 10 %; the mass's own uncertainty is small beside it "
        "and not added",
    ),
    "yaw_radius": Default(
        "radius of gyration in yaw, where no yaw inertia is given (a value): I = m k²",
        0.49,
        "wheelbases",
        "B",
        "between 0.474 (Carpenter's spreadsheet in PyCrash, github.com/joe-cormier/pycrash, "
        "credited there to Heydinger 1999, fig. 9) and 0.498, the mean of ten cars and SUVs in "
        "PyCrash's data",
    ),
    "cg_to_front_axle": Default(
        "centre of gravity behind the front axle, where only the wheelbase is given (a value)",
        0.45,
        "wheelbases",
        "C",
        "judgement: a passenger car with its engine in front",
    ),
    "cg_position": Default(
        "both axle distances, where only the wheelbase is given",
        0.03,
        "wheelbases",
        "C",
        "judgement: spread of the centre of gravity along cars",
    ),
    "impact_distance": Default(
        "centre of gravity to impact centre, distance",
        0.10,
        "m",
        "C",
        "judgement: the impact centre read off a damage profile",
    ),
    "impact_angle": Default(
        "centre of gravity to impact centre, angle",
        3,
        "deg",
        "C",
        "judgement: the impact centre read off a damage profile",
    ),
    "heading": Default("heading at impact", 3, "deg", "C", _HEADING),
    "direction": Default("direction of travel before impact, where given", 3, "deg", "C", _HEADING),
    "yaw_rate": Default(
        "yaw rate before impact (that of vehicle A is assumed to be 0)",
        2,
        "deg/s",
        "C",
        "judgement: a vehicle that tracks straight or along a gentle bend",
    ),
    "rest_position": Default(
        "rest position, each coordinate",
        0.15,
        "m",
        "C",
        "judgement: a centre of gravity placed from the outline of a vehicle at rest; "
        "no published figure known",
    ),
    "rest_heading": Default(
        "heading at rest",
        3,
        "deg",
        "C",
        "judgement: read from the outline of a vehicle at rest; no published figure known",
    ),
    "impact_point": Default(
        "impact point, each coordinate",
        0.3,
        "m",
        "C",
        "judgement: placed from gouges and a change of the tyre marks; no published figure known",
    ),
    "length": Default(
        "overhang beyond both axles, for drawing (a value)",
        1.9,
        "m",
        "C",
        "judgement: a passenger car",
    ),
    "width": Default(
        "width beyond the track, for drawing (a value)",
        0.25,
        "m",
        "C",
        "judgement: a passenger car",
    ),
}
