"""What the board asks for beside the drawing, in the words of the trade, each by its key of the file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from retrodict.explore.board.plan import Plan
from retrodict.scene.defaults import DEFAULTS
from retrodict.scene.load import value_at
from retrodict.scene.vehicle_library import VehicleClass, find


@dataclass(frozen=True, slots=True)
class Row:
    """A quantity that is typed.

    Args:
        key: key of the file; {} stands for the vehicle or the surface.
        label: name of the quantity, in words.
        example: text that may be typed.
        default: name of the default in `DEFAULTS` of its uncertainty; empty where there is none.
        otherwise: assumption where nothing is typed, in words.
    """

    key: str
    label: str
    example: str
    default: str = ""
    otherwise: str = ""

    def of(self, name: str) -> str:
        """The key of a vehicle or a surface."""
        return self.key.format(name)


VEHICLE = (
    Row("vehicles.{}.name", "name", "sedan"),
    Row("vehicles.{}.mass", "mass", "1500 kg, or 3307 lb", "mass"),
    Row(
        "vehicles.{}.yaw_inertia",
        "yaw inertia",
        "3374 kg m^2",
        "yaw_inertia",
        "estimated from mass and wheelbase",
    ),
    Row("vehicles.{}.wheelbase", "wheelbase", "2.70 m, or 106.3 in"),
    Row(
        "vehicles.{}.cg_to_front_axle",
        "centre of gravity to front axle",
        "1.35 m",
        "",
        "by the wheelbase",
    ),
    Row(
        "vehicles.{}.cg_to_rear_axle",
        "centre of gravity to rear axle",
        "1.50 m",
        "",
        "by the wheelbase",
    ),
    Row("vehicles.{}.track", "track", "1.52 m"),
    Row("vehicles.{}.length", "length", "4.60 m, or 15' 1\"", "", "for drawing"),
    Row("vehicles.{}.width", "width", "1.80 m", "", "for drawing"),
)
AT_IMPACT = (
    Row("vehicles.{}.impact.heading", "heading at the impact", "180 ± 2 deg", "heading"),
    Row(
        "vehicles.{}.impact_centre.distance",
        "centre of gravity to the place hit",
        "2.09 m",
        "impact_distance",
    ),
    Row(
        "vehicles.{}.impact_centre.angle",
        "its angle from straight ahead",
        "10 deg",
        "impact_angle",
    ),
)
BEFORE = (
    Row(
        "vehicles.{}.approach.speed",
        "speed at the impact, by a recorder or a witness",
        "45 ± 2 mph",
        "",
        "not known: it is inferred",
    ),
    Row("vehicles.{}.approach.skid", "skid up to the impact", "12 m, or 38 ft", "skid", "none"),
    Row(
        "vehicles.{}.approach.direction",
        "direction of travel before it",
        '180 ± 2 deg, or "unknown" if it slid',
        "direction",
        "along the heading",
    ),
    Row(
        "vehicles.{}.approach.yaw_rate",
        "yaw rate before it",
        "0 ± 2 deg/s",
        "yaw_rate",
        "0, if it did not slide",
    ),
)
AFTER = (
    Row("vehicles.{}.rest.heading", "heading at rest", "215 ± 3 deg", "rest_heading"),
    Row(
        "vehicles.{}.rest.rotation",
        "rotation to rest, whole turns counted",
        "743 deg",
        "",
        "turns not known",
    ),
    Row("vehicles.{}.departure.delta_v", "delta-v by its recorder", "12 ± 1 m/s", "", "none"),
    Row(
        "vehicles.{}.departure.speed", "speed just after the impact", "20 ± 2 mph", "", "not known"
    ),
    Row(
        "vehicles.{}.departure.direction",
        "direction just after the impact",
        "35 ± 8 deg",
        "departure_direction",
        "not known",
    ),
)
IMPACT = (
    Row("impact.point[0]", "impact point, x", "0 ± 0.3 m", "impact_point"),
    Row("impact.point[1]", "impact point, y", "0 ± 0.3 m", "impact_point"),
    Row("impact.contact_line", "contact line, from the y axis", "-8.9 ± 3 deg"),
    Row("impact.energy_lost", "energy lost, from crush", "60 ± 25 kJ", "", "not known"),
    Row("barrier.diameter", "diameter of the pole", "0.3 m"),
)
GROUND = (
    Row("surfaces.{}.friction", "friction by skid tests", "0.72 ± 0.03", "", "that of its kind"),
)
EDGE = (
    Row("surfaces.{}.edge.point[0]", "point on its edge, x", "0 m"),
    Row("surfaces.{}.edge.point[1]", "point on its edge, y", "1.75 m"),
    Row("surfaces.{}.edge.direction", "direction of its edge", "0 deg"),
    Row("surfaces.{}.edge.side", "side on which it lies", "left, or right"),
    Row("surfaces.{}.edge.uncertainty", "uncertainty of the edge", "0.1 m", "", "exact"),
)
SLOPE = (
    Row("slope.grade", "grade of the road", "4 ± 0.5 %", "", "level"),
    Row("slope.uphill", "direction uphill", "90 deg", "uphill"),
)
SCENE = (
    Row("title", "title", "Two cars on a bend"),
    Row("questions.exceeds", "was it faster than", "speed_a > 35 mph", "", "not asked"),
)
LISTS = ("questions.exceeds",)  # keys of lists of texts


def said(plan: Plan, key: str) -> str:
    """What the file says at a key, as somebody would type it; empty where it says nothing.

    Args:
        plan: plan of the present state.
        key: key of the file.
    """
    raw = value_at(plan.document, key)
    if key in LISTS and isinstance(raw, list):
        return ", ".join(map(str, raw))
    return in_words(raw)


def in_words(raw: object) -> str:
    """A quantity of a file, as somebody would type it; empty for anything else.

    Args:
        raw: value of a key, as TOML has it.
    """
    if isinstance(raw, dict) and "value" in raw:
        spread = f" ± {raw['sd']}" if "sd" in raw else ""
        return f"{raw['value']}{spread} {raw.get('unit', '')}".rstrip()
    return "" if raw is None or isinstance(raw, dict | list) else str(raw)


def note(plan: Plan, row: Row, key: str) -> tuple[str, str]:
    """What holds where the file is silent: a few words, and the whole with grade and source.

    Args:
        plan: plan of the present state.
        row: quantity.
        key: dotted key, with the vehicle's letter or the surface's name.
    """
    raw = value_at(plan.document, key)
    if raw is None:
        known = _of_class(plan, key)
        if known is not None:
            return known
        return (row.otherwise, row.otherwise)
    text = said(plan, key)
    if row.default and not any(sign in text for sign in ("±", "+/-", "+-", "unknown")):
        default = DEFAULTS[row.default]
        return (
            f"± {default.value:g} {default.unit}, grade {default.grade}",
            f"{default.quantity}: ± {default}",
        )
    if isinstance(raw, dict) and raw.get("source"):
        return ("source", str(raw["source"]))
    return ("", "")


def _of_class(plan: Plan, key: str) -> tuple[str, str] | None:
    """The figure of a vehicle's class at a key; None where there is none."""
    first, _, rest = key.partition(".")
    letter, _, name = rest.partition(".")
    if first != "vehicles" or name not in ("mass", "wheelbase", "track", "length", "width"):
        return None
    kind = value_at(plan.document, f"vehicles.{letter}.class")
    known: VehicleClass | None = find(kind) if isinstance(kind, str) else None
    measured: Any = getattr(known, name, None)
    if measured is None:
        return None
    unit = "kg" if name == "mass" else "m"
    figure = f"{measured.value:.4g} ± {measured.sd:.2g} {unit}"
    grade = measured.source.partition(":")[0]
    return (f"{figure}, {grade}", f"{figure} ({measured.source})")
