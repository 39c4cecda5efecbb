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
        unit: "%", "m", "deg", "deg/s", "wheelbases", or "of the friction".
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
            "of the friction": 1.0,
        }
        return self.value * worth[self.unit]


@dataclass(frozen=True, slots=True)
class SurfaceFriction:
    """The friction assumed of a kind of surface.

    Args:
        value: sliding friction of a car's tyres, mean.
        sd: one standard deviation.
        grade: as of a `Default`.
        source: what was read.
    """

    value: float
    sd: float
    grade: Grade
    source: str

    def __str__(self) -> str:
        return f"{self.value:g} ± {self.sd:g} (grade {self.grade}: {self.source})"


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
    "skid": Default(
        "skid on locked wheels up to the impact, length",
        0.5,
        "m",
        "C",
        "judgement: the place where a skid starts; no published figure known",
    ),
    "departure_direction": Default(
        "direction of travel after impact, where given",
        8,
        "deg",
        "C",
        "judgement: read off a scene without marks; 3 deg do with tyre marks",
    ),
    "mark": Default(
        "mark on the way to rest, across the path",
        0.15,
        "m",
        "C",
        "judgement: which point of the vehicle passed there, 0.15 m, over which the 0.03 m of a point "
        "from drone photographs (Drones 2022, 6(9), 259) add nothing; allow 0.5 m from a photograph "
        "alone",
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
    "grip": Default(
        "factor of the friction for the tyres of one vehicle (that factor is assumed to be 1)",
        5,
        "%",
        "B",
        "between vehicles on one surface the friction's standard deviation is about 0.04, on 0.75: "
        "derived from the averages of skid tests, 0.72 to 0.78 on dry asphalt",
    ),
    "rolling_drag": Default(
        "braking force of a rolling wheel (a value)",
        0.03,
        "of the friction",
        "B",
        "rolling resistance of 0.01 (new) to 0.02 (worn) of the load on asphalt (Carvill, Mechanical "
        "Engineer's Data Handbook), over friction of 0.5 to 0.8",
    ),
    "rolling_drag_sd": Default(
        "braking force of a rolling wheel, uncertainty",
        0.02,
        "of the friction",
        "C",
        "judgement: a dragging brake or bearing; write your own for a wheel in gear or rubbing on "
        "bent metal",
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

FRICTION: dict[str, SurfaceFriction] = {
    "dry asphalt": SurfaceFriction(
        0.75,
        0.07,
        "B",
        "later tests average 0.72 to 0.78 (Mechanical Forensics, Friction Table Update), clean dry "
        "paving 0.6 to 0.8 (Kentucky research report 178)",
    ),
    "wet asphalt": SurfaceFriction(
        0.50, 0.07, "B", "0.50 (Noon 1994), 0.45 to 0.55 (a tyre maker), about 0.5 (m-smac)"
    ),
    "dry concrete": SurfaceFriction(
        0.80, 0.08, "B", "0.75 (Noon 1994), 0.80 to 0.90 (a tyre maker)"
    ),
    "wet concrete": SurfaceFriction(
        0.57, 0.07, "B", "0.60 (Noon 1994), 0.50 to 0.60 (a tyre maker)"
    ),
    "gravel": SurfaceFriction(
        0.50,
        0.15,
        "B",
        "0.35 (Noon 1994), 0.60 to 0.70 (a tyre maker, dry crushed stone): sources disagree by a "
        "factor of two",
    ),
    "dry soil": SurfaceFriction(0.55, 0.08, "B", "0.50 to 0.60 (a tyre maker)"),
    "wet grass": SurfaceFriction(0.20, 0.06, "B", "0.20 (Noon 1994), alone"),
    "packed snow": SurfaceFriction(
        0.30,
        0.06,
        "B",
        "0.35 at -6 °C (vehicle traction experiments), 0.20 to 0.25 (Noon 1994), 0.25 to 0.35 (a "
        "tyre maker)",
    ),
    "ice": SurfaceFriction(
        0.12,
        0.05,
        "B",
        "0.09 at -6 °C (vehicle traction experiments), 0.10 to 0.15 (Noon 1994), 0.05 to 0.15 (a "
        "tyre maker); black or wet ice up to 0.6 elsewhere",
    ),
}
