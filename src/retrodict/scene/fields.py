"""The measured quantities of a scene file, each declared once, by tables of the file.

From an entry follow the key that the schema accepts, its bounds, error law and default, the value in its
record, its line in a file that is made from a scene, its label, its slider, and its row in
docs/scene-file.md (`benchmarks.scene_fields`). With an uncertainty it is an input of every model, by its
flat name. The record has an attribute for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from retrodict.scene import units
from retrodict.scene.defaults import DEFAULTS
from retrodict.scene.kinds import Kind
from retrodict.scene.measured import Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class Field(Kind):
    """A quantity of a scene file that a record keeps.

    Args:
        label: label of the quantity; {} stands for the vehicle or the surface.
        name: attribute of the record; empty where it is the key.
        flat: flat name, less the vehicle or the surface; empty where it is the attribute.
        computed: whether `build` computes what the record keeps, and the schema declares the key itself.
        required: whether a file has to state it, if it is not computed.
        assumed: value where none is written, if it is not computed; None where nothing is assumed.
        reason: reason for the assumed value, if it is exact.
        needs: key without which the quantity says nothing; empty where there is none.
        meaning: text of docs/scene-file.md after the bounds, if it is not computed.
    """

    label: str
    name: str = ""
    flat: str = ""
    computed: bool = False
    required: bool = False
    assumed: float | None = None
    reason: str = ""
    needs: str = ""
    meaning: str = ""

    @property
    def where_unwritten(self) -> Measured | None:
        """Assumed value where a file is silent; None where there is none."""
        if self.assumed is None:
            return None
        if self.default is None:
            return Measured(self.assumed, source=f"assumed: {self.reason}", assumed="value")
        source = f"assumed: {self.assumed:g} ± {self.default}"
        sd = self.default.amount(self.assumed)
        return Measured(self.assumed, sd, self.law, source, "value")


# bounds are generous: they catch slips of a unit or a digit, not unusual vehicles
VEHICLE: dict[str, Field] = {
    "mass": Field(
        units.MASS, 50, 100_000, "1857 ± 37 kg", "lognormal",
        default=DEFAULTS["mass"], label="mass of {}", computed=True,
    ),
    "yaw_inertia": Field(
        units.INERTIA, 5, 5e6, "3374 ± 270 kg m^2", "lognormal",
        default=DEFAULTS["yaw_inertia"], label="yaw inertia of {}", computed=True,
    ),
    "cg_to_front_axle": Field(
        units.LENGTH, 0.05, 20, "1.35 m", "lognormal",
        label="centre of gravity to front axle, {}", name="front_axle", computed=True,
    ),
    "cg_to_rear_axle": Field(
        units.LENGTH, 0.05, 20, "1.35 m", "lognormal",
        label="centre of gravity to rear axle, {}", name="rear_axle", computed=True,
    ),
    "track": Field(
        units.LENGTH, 0.2, 5, "1.54 m", "lognormal", label="track of {}", computed=True,
    ),
    "cg_height": Field(
        units.LENGTH, 0.1, 3, "0.53 ± 0.03 m", "lognormal",
        default=DEFAULTS["cg_height"], label="height of {}'s centre of gravity",
        meaning="centre of gravity above the road, by which deceleration moves load between the wheels "
        "([below](#load-transfer)); else loads are static",
    ),
    "slides": Field(
        units.NUMBER, 0.05, 1.5, "0.45 ± 0.1", "lognormal", uncertainty="required",
        advice="0.1 suits a published range",
        label="drag factor of {}, which slides without wheels",
        meaning="drag factor of a body [without wheels](#bodies-without-wheels), whatever it slides on, "
        'or `"motorcycle on its side"`',
    ),
    "grip": Field(
        units.NUMBER, 0.2, 2, "1 ± 0.05", "lognormal",
        default=DEFAULTS["grip"], label="grip of {}'s tyres, a factor of the friction", assumed=1.0,
        meaning="factor of the surfaces' friction for this vehicle's tyres; else 1",
    ),
}  # fmt: skip
IMPACT_CENTRE: dict[str, Field] = {
    "distance": Field(
        units.LENGTH, 0.01, 20, "2.09 ± 0.05 m", "lognormal",
        default=DEFAULTS["impact_distance"], label="centre of gravity to impact centre, {}",
        name="impact_distance", computed=True,
    ),
    "angle": Field(
        units.ANGLE, -360, 360, "10 ± 2 deg", default=DEFAULTS["impact_angle"],
        label="angle of the impact centre from straight ahead, {}", name="impact_angle", computed=True,
    ),
}  # fmt: skip
POSE_AT_IMPACT: dict[str, Field] = {
    "heading": Field(
        units.DIRECTION, -360, 360, "180 ± 2 deg", default=DEFAULTS["heading"],
        label="heading of {} at impact", computed=True,
    ),
}  # fmt: skip
APPROACH: dict[str, Field] = {
    "speed": Field(
        units.SPEED, 0, 150, "45 ± 2 mph", uncertainty="required", at_zero=DEFAULTS["standing"],
        label="impact speed of {}", computed=True,
    ),
    "direction": Field(
        units.DIRECTION, -360, 360, "180 ± 2 deg", default=DEFAULTS["direction"],
        label="direction of travel of {} before impact", computed=True,
    ),
    "yaw_rate": Field(
        units.YAW_RATE, -2000, 2000, "0 ± 2 deg/s", default=DEFAULTS["yaw_rate"],
        label="yaw rate of {} before impact", flat="omega", computed=True,
    ),
    "skid": Field(
        units.LENGTH, 0.1, 500, "12 ± 0.5 m", "lognormal",
        default=DEFAULTS["skid"], label="skid of {} up to impact",
        meaning="pre-impact skid: its length on the road up to the impact",
    ),
    "skid_braking": Field(
        units.NUMBER, 0.05, 1, "0.8 ± 0.1", "logitnormal",
        label="braking of {} over friction in its skid up to impact", needs="skid",
        meaning="braking force in the skid over the available friction: n in v² = 2 g f n d, the "
        "braking efficiency, as where only the front wheels locked; needs `skid`; else 1",
    ),
}  # fmt: skip
# a piece of a skid up to the impact; {} is the vehicle and the number of the piece
SKID: dict[str, Field] = {
    "length": Field(
        units.LENGTH, 0.1, 500, "12 ± 0.5 m", "lognormal", default=DEFAULTS["skid"],
        label="skid of {}, length", flat="skid", required=True, meaning="length of the piece",
    ),
    "braking": Field(
        units.NUMBER, 0.05, 1, "0.8 ± 0.1", "logitnormal",
        label="skid of {}, braking over friction", flat="skid_braking",
        meaning="as `skid_braking`; else 1",
    ),
    "drag_factor": Field(
        units.NUMBER, 0.02, 1.5, "0.35 ± 0.05", "lognormal", uncertainty="required",
        advice="0.1 suits a published range",
        label="skid of {}, drag factor", flat="skid_drag_factor",
        meaning="in place of `surface` and `braking`: deceleration over g, as of wheels that were "
        "braked in part",
    ),
}  # fmt: skip
# the arc of a critical-speed yaw mark: its radius is c²/(8 m) + m/2
YAW_MARK: dict[str, Field] = {
    "chord": Field(
        units.LENGTH, 2, 200, "12 ± 0.05 m", "lognormal", label="chord of {}'s yaw mark",
        flat="yaw_chord", required=True, meaning="chord c of the arc",
    ),
    "middle_ordinate": Field(
        units.LENGTH, 0.01, 50, "0.45 ± 0.02 m", "lognormal", uncertainty="required",
        advice="0.01 m suits a tape on a mark with sharp edges",
        label="middle ordinate of {}'s yaw mark", flat="yaw_ordinate", required=True,
        meaning="height m of the arc above the middle of its chord",
    ),
}  # fmt: skip
# what may be measured of a vehicle's motion just after the impact; models/evidence.py predicts each
DEPARTURE: dict[str, Field] = {
    "direction": Field(
        units.DIRECTION, -360, 360, "35 ± 8 deg", default=DEFAULTS["departure_direction"],
        label="direction of travel of {} after impact", meaning="direction of travel",
    ),
    "speed": Field(
        units.SPEED, 0, 150, "45 ± 2 mph", uncertainty="required", at_zero=DEFAULTS["standing"],
        label="speed of {} after impact", meaning="speed of the centre of gravity",
    ),
    "yaw_rate": Field(
        units.YAW_RATE, -2000, 2000, "35 ± 5 deg/s", uncertainty="required",
        label="measured yaw rate of {} after impact", meaning="positive counter-clockwise",
    ),
    "delta_v": Field(
        units.SPEED, 0, 150, "12 ± 1 m/s", uncertainty="required",
        label="measured delta-v of {}", meaning="magnitude of the change of velocity",
    ),
    "delta_v_forward": Field(
        units.SPEED, -150, 150, "-12 ± 1 m/s", uncertainty="required",
        label="delta-v of {} along its heading", meaning="its component along the heading at impact",
    ),
    "delta_v_left": Field(
        units.SPEED, -150, 150, "-12 ± 1 m/s", uncertainty="required",
        label="delta-v of {} to the left of its heading",
        meaning="its component to the left of the heading at impact",
    ),
    # of a recorder that stopped before the impact was over: lower bounds
    "delta_v_at_least": Field(
        units.SPEED, 0, 150, "12 ± 1 m/s", uncertainty="required", label="delta-v of {}, at least",
        meaning="the same of a recorder that stopped before the impact was over: a lower bound with its "
        "error",
    ),
    "delta_v_forward_at_least": Field(
        units.SPEED, -150, 150, "-12 ± 1 m/s", uncertainty="required",
        label="delta-v of {} along its heading, at least as far from 0",
        meaning="likewise its component along the heading; a negative one is a bound on how far below 0 "
        "it is",
    ),
    "delta_v_left_at_least": Field(
        units.SPEED, -150, 150, "-12 ± 1 m/s", uncertainty="required",
        label="delta-v of {} to the left of its heading, at least as far from 0",
        meaning="likewise its component to the left of the heading",
    ),
}  # fmt: skip
# where a vehicle came to rest as seen from where it was struck, in place of a position
FROM_IMPACT: dict[str, Field] = {
    "distance": Field(
        units.LENGTH, 0.05, 500, "12 ± 0.5 m", default=DEFAULTS["run_out"],
        label="distance of {} from impact to rest",
        meaning="in place of the position: how far the vehicle came, in a straight line",
    ),
    "direction": Field(
        units.DIRECTION, -360, 360, "35 ± 3 deg", default=DEFAULTS["run_out_direction"],
        label="direction of {} from impact to rest",
        meaning="and in which direction; left out where nobody knows",
    ),
}  # fmt: skip
END_OF_ROTATION: dict[str, Field] = {
    "x": Field(
        units.LENGTH, -1000, 1000, "3 ± 0.5 m", uncertainty="required",
        label="end of rotation of {}, x", meaning="of the centre of gravity",
    ),
    "y": Field(
        units.LENGTH, -1000, 1000, "3 ± 0.5 m", uncertainty="required",
        label="end of rotation of {}, y", meaning="of the centre of gravity",
    ),
    "heading": Field(
        units.DIRECTION, -360, 360, "20 ± 5 deg", uncertainty="required",
        label="end of rotation of {}, heading", meaning="whole turns do not matter",
    ),
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """A table of a vehicle's motion after the impact, each of whose quantities is an item of evidence.

    From an entry of `AFTER` follow the table that the schema accepts, what the scene keeps of it, its
    lines in a file that is made from a scene, and the items with their labels, sliders and rows of
    docs/scene-file.md. `Scene` has an attribute for it, `models/evidence.py` a prediction of each item.

    Args:
        what: description of the table, for the schema.
        table: key of the table in that of the vehicle.
        fields: quantities of the table by key.
        prefix: beginning of an item's flat name, before the quantity's key.
        where: place of the measurements: just after the impact, on the way to rest or at rest.
    """

    what: str
    table: str
    fields: Mapping[str, Field]
    prefix: str
    where: Literal["after the impact", "on the way", "at rest"]

    @property
    def kinds(self) -> tuple[str, ...]:
        """Flat names of the items, less the vehicle."""
        return tuple(f"{self.prefix}{key}" for key in self.fields)


# tables of evidence by attribute of the scene
AFTER: dict[str, Evidence] = {
    "departure": Evidence(
        what="what is known of the motion just after impact",
        table="departure", fields=DEPARTURE, prefix="departure_", where="after the impact",
    ),
    "end_of_rotation": Evidence(
        what="where it stopped sliding sideways and began to roll",
        table="end_of_rotation", fields=END_OF_ROTATION, prefix="end_", where="on the way",
    ),
    "from_impact": Evidence(
        what="where the vehicle came to rest, as a position or from the impact",
        table="rest", fields=FROM_IMPACT, prefix="run_out_", where="at rest",
    ),
}  # fmt: skip
IMPACT: dict[str, Field] = {
    "contact_line": Field(
        units.ANGLE, -180, 180, "-8.9 ± 3 deg", uncertainty="required",
        label="contact line Γ from the y axis", name="Gamma",
        meaning="Γ, from the y axis; without it momentum alone answers",
    ),
}  # fmt: skip
# coefficients of the impact that were measured: items of evidence; exact ones are priors (`build`)
COEFFICIENTS: dict[str, Field] = {
    "e": Field(
        units.NUMBER, 0, 1, "0.1 ± 0.05", label="coefficient of restitution e, as measured",
        meaning="measured [coefficient of restitution](#measured-coefficients) e; without an "
        "uncertainty it is fixed",
    ),
    "e_m": Field(
        units.NUMBER, -1, 1, "0.9 ± 0.2", label="impact moment coefficient e_m, as measured",
        meaning="likewise the impact moment coefficient e_m",
    ),
    "mu": Field(
        units.NUMBER, 0, 5, "0.5 ± 0.1", label="size of the equivalent friction μ, as measured",
        advice="its sign follows from the sliding",
        meaning="likewise the size of the equivalent friction μ; its sign follows from the sliding",
    ),
}  # fmt: skip
SURFACE: dict[str, Field] = {
    "friction": Field(
        units.NUMBER, 0.01, 1.5, "0.50 ± 0.03", "lognormal", uncertainty="required",
        advice="0.03 suits two or more skid tests, 0.05 one test, 0.07 a table",
        label="friction of the {}", computed=True,
    ),
    "speed_dependence": Field(
        units.INVERSE_SPEED, 0, 0.2, "0.002 s/m", label="fall of the {}'s friction with speed",
        assumed=0.0, reason="friction does not depend on speed",
        meaning="c in f exp(-c v), the friction at speed v; else 0",
    ),
}  # fmt: skip
SLOPE: dict[str, Field] = {
    "grade": Field(
        units.GRADE, 0, 30, "4 ± 0.5 %", uncertainty="required", required=True,
        advice="0.2 % suits a survey, 0.5 % a level laid on the road, 1 % a map",
        label="grade of the road", meaning="rise over run",
    ),
    "uphill": Field(
        units.DIRECTION, -360, 360, "90 ± 5 deg", default=DEFAULTS["uphill"], required=True,
        label="direction in which the road rises", meaning="direction in which the ground rises",
    ),
}  # fmt: skip

# tables of the file by the keys that lead to them, as docs/scene-file.md lists them
OF_VEHICLES: dict[str, Mapping[str, Field]] = {
    "": VEHICLE,
    "impact_centre.": IMPACT_CENTRE,
    "impact.": POSE_AT_IMPACT,
    "approach.": APPROACH,
    "approach.skids.": SKID,
    "approach.yaw_mark.": YAW_MARK,
    **{f"{own.table}.": own.fields for own in AFTER.values()},
}
_PREFIXES = {f"{own.table}.": own.prefix for own in AFTER.values()}


def described(family: str) -> tuple[str, str] | None:
    """Label and dimension of a quantity of a vehicle; None where no table has it.

    Args:
        family: flat name, less the vehicle.
    """
    for prefix, table in OF_VEHICLES.items():
        before = _PREFIXES.get(prefix, "")
        labels = flat_labels(table)
        if family.startswith(before) and (name := family.removeprefix(before)) in labels:
            return labels[name]
    return None


def flat_labels(table: Mapping[str, Field]) -> dict[str, tuple[str, str]]:
    """Label and dimension of each quantity of a table, by flat name, less the vehicle or surface.

    Args:
        table: quantities by key.
    """
    return {
        field.flat or field.name or key: (field.label, field.dimension.name)
        for key, field in table.items()
    }
