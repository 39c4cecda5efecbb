"""Estimates of a vehicle where a scene file is silent: axles, yaw inertia, wheels, model error."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Protocol

from retrodict.scene import discrepancy
from retrodict.scene.defaults import DEFAULTS, MOST_ROLLING
from retrodict.scene.entries.vehicle import VehicleEntry
from retrodict.scene.records import WHEELS, Measured, RunOutError, Vehicle, Wheels
from retrodict.scene.units import LENGTH, Dimension
from retrodict.scene.vehicle_library import VehicleClass


class Complain(Protocol):
    """Function that is called with each problem of a scene file."""

    def __call__(
        self, key: str, fix: str, amount: float = 0.0, dimension: Dimension = LENGTH
    ) -> None:
        """Note a problem.

        Args:
            key: dotted path of the key at fault.
            fix: advice on the value to write; `{amount}` in it is filled in, in the file's unit there.
            amount: value that the advice names, in SI units or radians.
            dimension: dimension of `amount`.
        """


def mean_drag(vehicle: Vehicle) -> Measured:
    """The drag of a vehicle's wheels over friction, weighted by their static loads."""
    if (wheels := vehicle.wheels) is None:
        return Measured(1.0)
    front = vehicle.rear_axle.value / (vehicle.front_axle.value + vehicle.rear_axle.value) / 2
    loads = (front, front, 0.5 - front, 0.5 - front)
    factor = wheels.factor or Measured(1.0)
    drags, sds = [], []
    for wheel, load in zip(WHEELS, loads, strict=True):
        own: Measured = getattr(wheels, wheel)
        drag = factor.value * own.value / (1 - own.value + factor.value * own.value)
        drags.append(load * drag)
        sds.append(load * own.sd)
    common = factor.sd * sum(
        drag * (1 - drag / load) for drag, load in zip(drags, loads, strict=True)
    )
    return Measured(sum(drags), math.hypot(common, *sds))


def wheels_of(entry: VehicleEntry, friction: float) -> Wheels | None:
    """How a vehicle's wheels turned, words as drags on this friction; None where all were locked."""
    if entry.wheels is None:
        return None
    written = dict(entry.wheels)
    drags = {
        wheel: _drag_of_word(drag, friction) if isinstance(drag, str) else drag
        for wheel, drag in written.items()
    }
    ahead = Measured(0.0, source="assumed: the front wheels point straight ahead", assumed="value")
    factor = entry.drag_factor
    if factor is None and any(drag.assumed for drag in drags.values()):
        spread = DEFAULTS["drag_factor"]
        factor = Measured(1.0, spread.amount(1.0), "lognormal", f"assumed: 1 ± {spread}", "value")
    return Wheels(**drags, steer=entry.steer or ahead, factor=factor)


def _drag_of_word(word: str, friction: float) -> Measured:
    """The drag of a wheel described by a word: some of its force does not grow with the friction."""
    if word == "locked":
        return Measured(1.0, 0.0, "logitnormal", word)
    key = word.replace(", ", "_").replace(" ", "_")
    drag, spread = DEFAULTS[key], DEFAULTS[f"{key}_sd"]
    value, sd = drag.amount(friction), spread.amount(friction)
    if value > MOST_ROLLING:
        value, sd = MOST_ROLLING, MOST_ROLLING * (1 - MOST_ROLLING)
    source = f"{word}; assumed: {drag}; uncertainty assumed: {spread}"
    return Measured(value, sd, "logitnormal", source, "value")


def run_out_error(
    entry: VehicleEntry, front: float, rear: float, wheels: Wheels | None
) -> RunOutError:
    """Error of the run-out model for a vehicle: as written, or by how freely the vehicle rolled."""
    drags = [getattr(wheels, wheel).value for wheel in WHEELS] if wheels else [1.0] * 4
    free = discrepancy.freedom(front, rear, drags)

    def assumed(key: str) -> Measured:
        most = DEFAULTS[key]
        source = f"assumed: {free:.2g} (1 less the mean drag of its wheels) times {most}"
        return Measured(free * most.amount(1.0), source=source, assumed="value")

    return RunOutError(
        position=entry.run_out_error.position or assumed("run_out_position"),
        heading=entry.run_out_error.heading or assumed("run_out_heading"),
    )


def axle_distances(
    letter: str, entry: VehicleEntry, known_class: VehicleClass | None, complain: Complain
) -> tuple[Measured, Measured]:
    """Distances from the centre of gravity to front and rear axle, as written or estimated, m."""
    front, rear, wheelbase = entry.cg_to_front_axle, entry.cg_to_rear_axle, entry.wheelbase
    key = f"vehicles.{letter}.wheelbase"
    if front and rear:
        total = front.value + rear.value
        if wheelbase and abs(total - wheelbase.value) > 0.05 * wheelbase.value:
            complain(
                key,
                "the two axle distances add up to {amount}; write a wheelbase within 5 % of that, or "
                "leave it out",
                total,
            )
        return front, rear
    assert wheelbase is not None, "the schema sees to it"
    if front is None and rear is None:
        share, spread = DEFAULTS["cg_to_front_axle"], DEFAULTS["cg_position"]
        ahead, sd = share.amount(wheelbase.value), spread.amount(wheelbase.value)
        source = f"assumed from the wheelbase: {share}; uncertainty assumed: {spread}"
        if known_class:
            of_class = known_class.assumed(known_class.cg_share)
            ahead, sd = of_class.value * wheelbase.value, of_class.sd * wheelbase.value
            source = f"{of_class.value:g} ± {of_class.sd:g} wheelbases, {of_class.source}"
            source += f"; wheelbase {wheelbase.source}" if wheelbase.assumed else ""
        sd = math.hypot(sd, wheelbase.sd / 2)
        front, rear = (
            Measured(value, sd, "lognormal", source, "value")
            for value in (ahead, wheelbase.value - ahead)
        )
        return front, rear
    known = front or rear
    assert known is not None
    other = replace(
        known,
        value=wheelbase.value - known.value,
        sd=math.hypot(wheelbase.sd, known.sd),
        source="the wheelbase less the other axle's distance",
    )
    if other.value < max(0.05, other.sd):
        complain(key, "leaves no room for both axles; write one above {amount}", known.value)
    return (known, other) if front else (other, known)


def estimated_yaw_inertia(
    mass: Measured, wheelbase: Measured, known: VehicleClass | None
) -> Measured:
    """Yaw inertia by the radius of gyration of the class, or the default one, kg m²."""
    if known:  # the mass or the wheelbase of a class may be so uncertain that it counts
        of_class = known.assumed(known.yaw_radius)
        value = mass.value * (of_class.value * wheelbase.value) ** 2
        parts = (mass.sd / mass.value, *(2 * m.sd / m.value for m in (of_class, wheelbase)))
        source = (
            f"estimated as m k² with k = {of_class.value:g} ± {of_class.sd:.2g} wheelbases, "
            f"{of_class.source}; the uncertainties of mass and wheelbase added"
        )
        return Measured(value, math.hypot(*parts) * value, "lognormal", source, "value")
    radius, spread = DEFAULTS["yaw_radius"], DEFAULTS["yaw_inertia"]
    value = mass.value * radius.amount(wheelbase.value) ** 2
    source = f"estimated as m k² with k = {radius}; uncertainty assumed: {spread}"
    return Measured(value, spread.amount(value), "lognormal", source, "value")
