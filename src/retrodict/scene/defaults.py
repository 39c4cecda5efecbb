"""Assumed values where a scene file is silent: each figure with its grade and its source."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import Literal

Grade = Literal["A", "B", "C"]


@dataclass(frozen=True, slots=True)
class Default:
    """An assumed figure.

    Args:
        quantity: name of the quantity that the figure is for, in words.
        value: the figure: one standard deviation, unless `quantity` says otherwise.
        unit: "%", "m", "m/s", "deg", "deg/s", "wheelbases", "of the friction", or "of the load".
        grade: A, read in a source; B, derived from figures read; C, judgement.
        source: source of the figure, and the reason for it.
    """

    quantity: str
    value: float
    unit: str
    grade: Grade
    source: str

    def __str__(self) -> str:
        return f"{self.value:g} {self.unit} (grade {self.grade}: {self.source})"

    def amount(self, value: float) -> float:
        """The figure in SI units or radians.

        Args:
            value: quantity that the figure refers to: for "%" the value that it is a percentage of,
                for "wheelbases" the wheelbase, m, for "of the load" the friction; else unused.
        """
        if self.unit == "of the load":
            return self.value / value
        worth = {
            "%": abs(value) / 100,
            "wheelbases": value,
            "m": 1.0,
            "m/s": 1.0,
            "deg": radians(1),
            "deg/s": radians(1),
            "of the friction": 1.0,
        }
        return self.value * worth[self.unit]


@dataclass(frozen=True, slots=True)
class SurfaceFriction:
    """Assumed friction of a kind of surface, or drag factor of a kind of body.

    Args:
        value: mean sliding friction of a car's tyres.
        sd: standard deviation of the friction.
        grade: grade of the figures, as in `Default`.
        source: source of the figures.
    """

    value: float
    sd: float
    grade: Grade
    source: str

    def __str__(self) -> str:
        return f"{self.value:g} ± {self.sd:g} (grade {self.grade}: {self.source})"


# largest drag that a word for a wheel stands for: on ice the engine can all but lock a wheel
MOST_ROLLING = 0.8

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
    "cg_height": Default(
        "height of the centre of gravity, where given",
        5,
        "%",
        "C",
        "judgement: measured, but with other occupants and load; allow 10 % for a figure of its class",
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
    "course": Default(
        "direction of travel before impact off the heading, where no direction is given",
        3,
        "deg",
        "C",
        "judgement: a vehicle whose wheels do not slide; for one that slid sideways write "
        'direction = "unknown"',
    ),
    "yaw_rate": Default(
        "yaw rate before impact (0 is assumed where none is given and the vehicle did not slide)",
        5,
        "deg/s",
        "C",
        "judgement: a vehicle that tracks straight or on a bend of 100 m radius at 9 m/s; one that "
        "turns yaws at its speed over the radius: write that",
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
    "standing": Default(
        "speed of a vehicle that stood, where 0 is written without an uncertainty",
        0.2,
        "m/s",
        "C",
        "judgement: a vehicle that nobody saw move",
    ),
    "run_out": Default(
        "distance from impact to rest, where given in place of a position",
        5,
        "%",
        "C",
        "judgement: paced or taped along the marks; no published figure known",
    ),
    "run_out_direction": Default(
        "direction from impact to rest, where given in place of a position",
        3,
        "deg",
        "C",
        "judgement: read off a sketch to scale; no published figure known",
    ),
    "impact_side": Default(
        "angle of the impact centre, where none is given, about the side that the other came from",
        40,
        "deg",
        "C",
        "judgement: from corner to corner of a car's outline",
    ),
    "impact_reach": Default(
        "distance of the impact centre, where none is given, about a quarter of length and width",
        30,
        "%",
        "C",
        "judgement: the middle between half the width and half the length of a car",
    ),
    "impact_point": Default(
        "impact point, each coordinate",
        0.3,
        "m",
        "C",
        "judgement: placed from gouges and a change of the tyre marks; no published figure known",
    ),
    "uphill": Default(
        "direction in which the road rises",
        5,
        "deg",
        "C",
        "judgement: read off a map or along the road; 5 deg alter a grade's part along a course little",
    ),
    "grip": Default(
        "factor of the friction for the tyres of one vehicle (that factor is assumed to be 1)",
        5,
        "%",
        "B",
        "between vehicles on one surface the friction's standard deviation is about 0.04, on 0.75: "
        "derived from the averages of skid tests, 0.72 to 0.78 on dry asphalt",
    ),
    "rolling": Default(
        "braking force of a rolling wheel (a value)",
        0.014,
        "of the load",
        "B",
        "between 0.010 (a tyre in EDCRASH's manual, which has 0.013 of one with little air; 0.010 to "
        "0.015 on new asphalt or concrete, The Engineering ToolBox) and 0.020 (worn asphalt, Carvill, "
        "Mechanical Engineer's Data Handbook)",
    ),
    "rolling_sd": Default(
        "braking force of a rolling wheel, uncertainty",
        0.007,
        "of the load",
        "C",
        "judgement: half the value, for a dragging brake or bearing",
    ),
    "rolling_in_gear": Default(
        "braking force of a rolling wheel that is driven and left in gear (a value)",
        0.2,
        "of the load",
        "B",
        "where the ranges of EDCRASH's manual for engine braking meet: 0.15 to 0.20 in high gear, 0.20 "
        "to 0.40 in low gear",
    ),
    "rolling_in_gear_sd": Default(
        "braking force of a rolling wheel that is driven and left in gear, uncertainty",
        0.08,
        "of the load",
        "C",
        "judgement: 0.40 lies 2.5 of it above, and below is room for a torque converter or a clutch "
        "that slips",
    ),
    "damaged": Default(
        "braking force of a damaged wheel, rubbing or bent (a value: the median)",
        0.5,
        "of the friction",
        "B",
        "anything from 0 to 1 (EDCRASH's manual)",
    ),
    "damaged_sd": Default(
        "braking force of a damaged wheel, uncertainty: that of its logit is four times this",
        0.425,
        "of the friction",
        "B",
        "makes everything from 0 to 1 as probable, to within 0.01 of the distribution function, after "
        "EDCRASH's manual",
    ),
    "drag_factor": Default(
        "factor of what the drags of one vehicle's wheels have in common, where a word gives one of "
        "them (that factor is assumed to be 1)",
        30,
        "%",
        "B",
        "tyres differ from 0.007 to 0.017 of the load about 0.010 (a survey quoted at ecomodder.com), "
        "new and worn asphalt by a factor of two (as for a rolling wheel): each taken as 95 %, that is "
        "22 % and 17 %, together 28 %",
    ),
    "run_out_position": Default(
        "what a run-out misses of where a vehicle went, each coordinate, in per cent of its way from "
        "the impact, were its wheels free; times 1 less their mean drag",
        4,
        "%",
        "C",
        "judgement: a grade of 0.4 % that nobody measured alters by so much the way of a car "
        "that rolls at 0.1 g. Published validations (of SMAC, EDSMAC, PC-Crash) compare paths with "
        "staged crashes, but no figure by length of way could be read. On locked wheels 0: friction and "
        "grip are unknowns already",
    ),
    "run_out_heading": Default(
        "what a run-out misses of the heading after a long way, were the wheels free; times 1 less "
        "their mean drag",
        8,
        "deg",
        "C",
        "judgement: as of a heading without tyre marks; no published figure could be read",
    ),
    "run_out_settled": Default(
        "way on which what a run-out misses of the heading grows to that (a value)",
        20,
        "m",
        "C",
        "judgement: some car lengths, after which a rolling car points along its course",
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

# drag factors of bodies without wheels, by what slides
SLIDING: dict[str, SurfaceFriction] = {
    "motorcycle on its side": SurfaceFriction(
        0.42,
        0.12,
        "B",
        "on pavement 0.45 to 0.58 of two without fairings (Day and Smith 1984), 0.26 to 0.33 of one "
        "with and without (Raftery 1995), as quoted by axiomforensic.com, 2020",
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
