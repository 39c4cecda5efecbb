"""The table of an event data recorder as CSV: speed before the impact, delta-v, yaw rate."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from retrodict.interchange.column_map import RECORDED, RecordedSpeedEntry, RecorderEntry
from retrodict.interchange.source_file import SourceFile
from retrodict.interchange.table_in import NoNumber, number, read_table
from retrodict.interchange.taken import Taken, quantity, replaced, rounded
from retrodict.scene.errors import shown
from retrodict.scene.load import value_at
from retrodict.scene.records import Measured
from retrodict.scene.units import QuantityError, factor

_KEPT = 200  # times that a scene file may hold


class Curve(NamedTuple):
    """A column over time, SI units: rows in which both are numbers."""

    times: list[float]
    values: list[float]
    rows: list[int]


def recorder_taken(
    file: SourceFile, entry: RecorderEntry, document: dict[str, Any]
) -> tuple[list[Taken], list[str]]:
    """What a scene takes of a recorder's table.

    Args:
        file: table of the recorder, as CSV.
        entry: the map's [recorder] table.
        document: tables and keys of the scene file.

    Returns:
        The values; and lines on what is left.

    Raises:
        SceneError: the file is no table, lacks a column, or does not cover a time that is asked for.
    """
    return _Recorder(file, entry, document).all()


class _Recorder:
    """A recorder's table and what is taken of it."""

    def __init__(self, file: SourceFile, entry: RecorderEntry, document: dict[str, Any]) -> None:
        self.file, self.entry, self.document = file, entry, document
        wanted = {key: column for key, column in entry.columns if column is not None}
        table = read_table(file, entry, wanted, "recorder")
        self.places, self.rows, self.left = table.places, table.rows, table.left
        for key, column in wanted.items():
            self._in_its_unit(key, column)
        self.curves = {c: self._curve(c) for c in self.places if c != "time"}

    def _in_its_unit(self, key: str, column: str | int) -> None:
        """Refuse a unit of the map that is not the one in the column's header, like Speed (km/h)."""
        match = _UNIT_IN_HEADER.search(str(column))
        try:
            stated = factor(match[1], RECORDED[key]) if match else self.entry.units[key]
        except QuantityError:
            return  # something else in brackets
        if not math.isclose(stated, self.entry.units[key], rel_tol=1e-6):
            assert match
            unit = match[1]
            fix = f'its header says "{unit}", but units in the map does not; write {key} = "{unit}"'
            raise self.file.refuse(fix, f"column {column}")

    def all(self) -> tuple[list[Taken], list[str]]:
        """Everything taken, and lines on what is left."""
        taken = [*self._speed(), *self._delta_v(), *self._yaw_rate()]
        for column in self.curves:
            if not any(getattr(self.entry, key) and column.startswith(key) for key in _TAKEN):
                self.left.append(f"column {column}: [recorder] takes nothing of it")
        return taken, self.left

    def _speed(self) -> Iterator[Taken]:
        if (entry := self.entry.speed) is None:
            return
        curve, key = self.curves["speed"], f"vehicles.{self.entry.vehicle}.approach"
        low, high = (moment.value for moment in entry.impact)
        source = self._source("speed", curve)
        for moment in (low, high):
            self._recorded(curve, moment, "recorder.speed.impact")
        if low == high:
            value = quantity(self._at(curve, low), entry.uncertainty.value, "m/s", source)
            yield self._taken(f"{key}.speed", value, curve, f"at {low:g} s")
            other = f"{key}.speed_record"
        else:
            yield self._taken(f"{key}.speed_record", self._record(curve, entry, source), curve)
            other = f"{key}.speed"
        yield from replaced(self.document, other)

    def _record(self, curve: Curve, entry: RecordedSpeedEntry, source: str) -> dict[str, Any]:
        """The record about the moments at which the impact may have been."""
        low, high = (moment.value for moment in entry.impact)
        first = max((i for i, t in enumerate(curve.times) if t <= low), default=0)
        last = min((i for i, t in enumerate(curve.times) if t >= high), default=len(curve.times))
        kept = slice(first, last + 1)
        if len(curve.times[kept]) > _KEPT:
            fix = f"more than {_KEPT} rows from {low:g} to {high:g} s; thin the table out"
            raise self.file.refuse(fix, "speed")
        return {
            "times": [f"{t:.10g} s" for t in curve.times[kept]],
            "speeds": [f"{v:.6g} m/s" for v in curve.values[kept]],
            "impact": [f"{low:.10g} s", f"{high:.10g} s"],
            "uncertainty": {
                "value": rounded(entry.uncertainty.value),
                "unit": "m/s",
                "source": source,
            },
        }

    def _delta_v(self) -> Iterator[Taken]:
        if (entry := self.entry.delta_v) is None:
            return
        end = "_at_least" if entry.ended == "early" else ""
        for column, name, sign in _DELTA_V:
            if column in self.curves:
                key = f"vehicles.{self.entry.vehicle}.departure.{name}{end}"
                yield self._value(key, column, entry.at, sign, entry.uncertainty.value, "m/s")

    def _yaw_rate(self) -> Iterator[Taken]:
        if (entry := self.entry.yaw_rate) is None:
            return
        for column, sign in (("yaw_rate", 1.0), ("yaw_rate_clockwise", -1.0)):
            if column in self.curves:
                key = f"vehicles.{self.entry.vehicle}.{entry.to}.yaw_rate"
                yield self._value(key, column, entry.at, sign, entry.uncertainty.value, "rad/s")

    def _value(
        self, key: str, column: str, at: Measured | None, sign: float, sd: float, unit: str
    ) -> Taken:
        curve = self.curves[column]
        time = curve.times[-1] if at is None else at.value
        self._recorded(
            curve, time, f"recorder.{next(k for k in _TAKEN if column.startswith(k))}.at"
        )
        value = sign * self._at(curve, time)
        written = quantity(value, sd, unit, self._source(column, curve))
        return self._taken(key, written, curve, f"at {time:g} s")

    def _taken(self, key: str, value: Any, curve: Curve, remark: str = "") -> Taken:
        return Taken(key, value, _rows(curve), value_at(self.document, key), remark)

    def _source(self, column: str, curve: Curve) -> str:
        return self.file.source(f"{column}, {_rows(curve)}")

    def _recorded(self, curve: Curve, time: float, key: str) -> None:
        """Refuse a moment before or after the record, by the map's key that has it."""
        if not curve.times[0] <= time <= curve.times[-1]:
            fix = f"recorded from {curve.times[0]:g} to {curve.times[-1]:g} s, not at {time:g} s"
            raise self.file.refuse(f"{fix}; correct {key} in the map, or add a row", key)

    def _at(self, curve: Curve, time: float) -> float:
        """A column at a time, on the straight line between rows."""
        i = next(i for i, t in enumerate(curve.times) if t >= time)
        if i == 0:
            return curve.values[0]
        (t, t_next), (v, v_next) = curve.times[i - 1 : i + 1], curve.values[i - 1 : i + 1]
        return v + (v_next - v) * (time - t) / (t_next - t)

    def _curve(self, column: str) -> Curve:
        """A column over time; a row without a number is left, with a line unless its cell is empty."""
        curve = Curve([], [], [])
        for row in self.rows:
            cells = {key: row.cell(self.places[key]) for key in ("time", column)}
            if not cells[column]:
                continue
            try:
                time, value = (
                    number(cell, self.entry.decimal) * self.entry.units[key]
                    for key, cell in cells.items()
                )
            except NoNumber as error:
                said = ", ".join(f"{key} = {shown(cell)}" for key, cell in cells.items())
                self.left.append(f"row {row.number}: {said} {error}")
                continue
            if curve.times and time <= curve.times[-1]:
                fix = (
                    f"times do not increase ({curve.times[-1]:g}, then {time:g} s); sort the table"
                )
                raise self.file.refuse(fix, f"row {row.number}")
            curve.times.append(time)
            curve.values.append(value)
            curve.rows.append(row.number)
        if not curve.times:
            raise self.file.refuse("no row has a time and a number in it; correct the map", column)
        return curve


_UNIT_IN_HEADER = re.compile(r"[(\[]([^()\[\]]+)[)\]]\s*$")
_TAKEN = ("speed", "delta_v", "yaw_rate")
_DELTA_V = (  # column, key of the scene file, sign
    ("delta_v", "delta_v", 1.0),
    ("delta_v_forward", "delta_v_forward", 1.0),
    ("delta_v_left", "delta_v_left", 1.0),
    ("delta_v_right", "delta_v_left", -1.0),
)


def _rows(curve: Curve) -> str:
    first, last = curve.rows[0], curve.rows[-1]
    return f"row {first}" if first == last else f"rows {first} to {last}"
