"""What may be measured of a vehicle's motion just after the impact.

An item is one entry of `ITEMS`, its prediction in `PREDICTIONS` of models/evidence.py, and a row in
docs/scene-file.md.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Item:
    """One measurement: a key of `[vehicles.X.departure]`.

    Args:
        label: in words; {} stands for the vehicle.
        dimension: as in `quantities`.
        low: the least value accepted, in m/s, deg or deg/s.
        high: the greatest, likewise.
        example: how it could be written.
        default: key of `DEFAULTS` for the uncertainty where none is written; empty where one must be.
    """

    label: str
    dimension: str
    low: float
    high: float
    example: str
    default: str = ""


ITEMS: dict[str, Item] = {
    "direction": Item(
        "direction of travel of {} after impact",
        "angle",
        -360,
        360,
        "35 ± 8 deg",
        default="departure_direction",
    ),
    "speed": Item("speed of {} after impact", "speed", 0, 150, "45 ± 2 mph"),
    "yaw_rate": Item(
        "measured yaw rate of {} after impact", "yaw rate", -2000, 2000, "35 ± 5 deg/s"
    ),
    "delta_v": Item("measured delta-v of {}", "speed", 0, 150, "12 ± 1 m/s"),
    "delta_v_forward": Item("delta-v of {} along its heading", "speed", -150, 150, "-12 ± 1 m/s"),
    "delta_v_left": Item(
        "delta-v of {} to the left of its heading", "speed", -150, 150, "-12 ± 1 m/s"
    ),
    # of a recorder that stopped before the impact was over: lower bounds
    "delta_v_at_least": Item("delta-v of {}, at least", "speed", 0, 150, "12 ± 1 m/s"),
    "delta_v_forward_at_least": Item(
        "delta-v of {} along its heading, at least as far from 0",
        *("speed", -150, 150, "-12 ± 1 m/s"),
    ),
    "delta_v_left_at_least": Item(
        "delta-v of {} to the left of its heading, at least as far from 0",
        *("speed", -150, 150, "-12 ± 1 m/s"),
    ),
}
