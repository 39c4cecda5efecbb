"""The table of an event data recorder as CSV: speed before the impact, delta-v, yaw rate."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from retrodict.interchange.cells import NoNumber, number
from retrodict.interchange.headings import is_no_value, number_in, units_in
from retrodict.interchange.recorder_map import (
    RECORDED,
    RecordedSpeedEntry,
    RecorderEntry,
    taken_as,
)
from retrodict.interchange.source_file import SourceFile
from retrodict.interchange.table_in import Row, TableIn, plain, read_table
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
        columns = {key: column for key, column in entry.columns if column is not None}
        asked = columns
        if entry.long:
            asked = {"time": columns["time"], "parameter": entry.long.parameter}
            asked["value"] = entry.long.value
            if entry.long.unit:
                asked["unit"] = entry.long.unit
        table = read_table(file, entry, asked, "recorder")
        self.left = table.left
        headings = table.headings
        if entry.long:  # a parameter has the unit in its name
            headings = {key: str(columns[key]) for key in columns} | {"time": headings["time"]}
        # the column of each quantity in the map's unit
        self.units = {key: self._in_its_unit(key, headings.get(key, "")) for key in columns}
        rows = self._first_table(table)
        self.curves = {}
        for column in columns:
            if column != "time":
                curve = self._curve(column, self._cells(column, rows, table.places))
                summed = column.startswith("acceleration")
                self.curves[column] = _integrated(curve) if summed else curve
        if entry.long:
            self._other_parameters(rows, table.places["parameter"], columns)

    def _in_its_unit(self, key: str, heading: str) -> list[float]:
        """The worth of a heading's units; refuse the map's if it is none of them, like Speed (km/h)."""
        stated = units_in(heading, RECORDED[key])
        wanted = self.entry.units[key]
        if stated and not any(math.isclose(worth, wanted, rel_tol=1e-6) for _, worth in stated):
            said = " and ".join(f'"{unit}"' for unit, _ in stated)
            fix = (
                f"its header says {said}, but units in the map does not; "
                f'write {key} = "{stated[0][0]}"'
            )
            raise self.file.refuse(fix, f"column {shown(heading)[1:-1]}")
        return [worth for _, worth in stated]

    def _first_table(self, table: TableIn) -> list[Row]:
        """Rows until those of something else, such as the heading of a table with other columns."""
        places = [p for key, p in table.places.items() if key not in ("parameter", "unit")]
        begun = False
        for i, row in enumerate(table.rows):
            numeric = any(_is_number(row.cell(place), self.entry.decimal) for place in places)
            time = row.cell(table.places["time"])
            if begun and not numeric and time and not is_no_value(time):
                if row.number in table.again:
                    continue
                self.left.append(f"{_span([r.number for r in table.rows[i:]])}: below the table")
                return table.rows[:i]
            begun = begun or numeric
        return [row for row in table.rows if row.number not in table.again]

    def _cells(
        self, column: str, rows: list[Row], places: dict[str, int]
    ) -> Iterator[tuple[int, str, str]]:
        """Number of each row that has a column, its time and its value."""
        if (long := self.entry.long) is None:
            for row in rows:
                yield row.number, row.cell(places["time"]), row.cell(places[column])
            return
        name, there = plain(str(getattr(self.entry.columns, column))), False
        for row in rows:
            if plain(row.cell(places["parameter"])) != name:
                continue
            there = True
            if long.unit:
                self._of_unit(column, row.cell(places["unit"]), row.number)
            yield row.number, row.cell(places["time"]), row.cell(places["value"])
        if not there:
            has = {shown(row.cell(places["parameter"])): None for row in rows}
            fix = f"no row has this parameter; it has {', '.join(list(has)[:12])}"
            raise self.file.refuse(fix, column, shown(str(getattr(self.entry.columns, column))))

    def _of_unit(self, column: str, unit: str, row: int) -> None:
        """Refuse a row whose unit is not that of the map."""
        try:
            same = math.isclose(factor(unit, RECORDED[column]), self.entry.units[column])
        except QuantityError:
            same = False
        if not same:
            fix = f"its unit is not that of {column} in the map; correct units in the map"
            raise self.file.refuse(fix, f"row {row}", shown(unit))

    def _other_parameters(self, rows: list[Row], place: int, columns: dict[str, Any]) -> None:
        asked = {plain(str(column)) for column in columns.values()}
        names = {cell: None for row in rows if (cell := row.cell(place))}
        self.left += [
            f"parameter {shown(name)}: not in the map" for name in names if plain(name) not in asked
        ]

    def all(self) -> tuple[list[Taken], list[str]]:
        """Everything taken, and lines on what is left."""
        taken = [*self._speed(), *self._delta_v(), *self._yaw_rate()]
        for column in self.curves:
            if getattr(self.entry, taken_as(column)) is None:
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
        there = [each for each in _DELTA_V if each[0] in self.curves]
        moment = entry.at
        if isinstance(moment, str):
            moment = self._end_of_pulse([self.curves[column] for column, *_ in there])
        end = "_at_least" if entry.ended == "early" else ""
        for column, name, sign in there:
            key = f"vehicles.{self.entry.vehicle}.departure.{name}{end}"
            yield self._value(key, column, moment, sign, entry.uncertainty.value, "m/s")

    def _end_of_pulse(self, curves: list[Curve]) -> Measured:
        """The time at which delta-v changes by no more than 0.8 km/h within 20 ms (49 CFR 563.5)."""
        first = max(curve.times[0] for curve in curves)
        last = min(curve.times[-1] for curve in curves)
        begun, change, end = False, 0.0, max(first, last - _QUIET)
        for t in [*(t for t in curves[0].times if first <= t < end), end]:
            later = min(t + _QUIET, last)
            begun = begun or math.hypot(*(self._at(c, t) for c in curves)) > _SMALL
            change = math.hypot(*(self._at(c, later) - self._at(c, t) for c in curves))
            if begun and change <= _SMALL:
                return Measured(later)
        if not begun:
            fix = "its delta-v nowhere exceeds 0.8 km/h; there is no pulse"
        else:
            fix = (
                f"the pulse has not ended: delta-v still changes by {3.6 * change:.2g} km/h within "
                'the last 20 ms; write at = "last", ended = "early"'
            )
        raise self.file.refuse(fix, "recorder.delta_v.at")

    def _yaw_rate(self) -> Iterator[Taken]:
        if (entry := self.entry.yaw_rate) is None:
            return
        for column, sign in (("yaw_rate", 1.0), ("yaw_rate_clockwise", -1.0)):
            if column in self.curves:
                key = f"vehicles.{self.entry.vehicle}.{entry.to}.yaw_rate"
                yield self._value(key, column, entry.at, sign, entry.uncertainty.value, "rad/s")

    def _value(
        self, key: str, column: str, moment: Measured | None, sign: float, sd: float, unit: str
    ) -> Taken:
        curve = self.curves[column]
        time = curve.times[-1] if moment is None else moment.value
        self._recorded(curve, time, f"recorder.{taken_as(column)}.at")
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

    def _in_si(self, key: str, cell: str) -> float:
        unit = self.entry.units[key]
        return number_in(cell, self.entry.decimal, self.units[key], unit) * unit

    def _curve(self, column: str, cells: Iterable[tuple[int, str, str]]) -> Curve:
        """A column over time; a row without a number is left, with a line unless its cell is empty."""
        curve = Curve([], [], [])
        without: dict[int, str] = {}  # rows without a value, and what they have instead
        for row, time_cell, cell in cells:
            if not cell:
                continue
            if nothing := next((each for each in (cell, time_cell) if is_no_value(each)), ""):
                without[row] = nothing
                continue
            try:
                time, value = self._in_si("time", time_cell), self._in_si(column, cell)
            except NoNumber as error:
                said = f"time = {shown(time_cell)}, {column} = {shown(cell)}"
                self.left.append(f"row {row}: {said} {error}")
                continue
            if curve.times and time <= curve.times[-1]:
                fix = (
                    f"times do not increase ({curve.times[-1]:g}, then {time:g} s); sort the table, "
                    "or choose one event of it by below or only in the map"
                )
                raise self.file.refuse(fix, f"row {row}")
            curve.times.append(time)
            curve.values.append(value)
            curve.rows.append(row)
        if without:
            what = ", ".join(list({shown(cell): None for cell in without.values()})[:4])
            many = f" ({len(without)} of them)" if len(without) > 1 else ""
            self.left.append(f"{column}, {_span(list(without))}{many}: no value ({what})")
        if not curve.times:
            raise self.file.refuse("no row has a time and a number in it; correct the map", column)
        return curve


_QUIET = 0.020  # s
_SMALL = 0.8 / 3.6  # m/s
_DELTA_V = (  # column, key of the scene file, sign
    ("delta_v", "delta_v", 1.0),
    ("delta_v_forward", "delta_v_forward", 1.0),
    ("delta_v_left", "delta_v_left", 1.0),
    ("delta_v_right", "delta_v_left", -1.0),
    ("acceleration_forward", "delta_v_forward", 1.0),
    ("acceleration_left", "delta_v_left", 1.0),
    ("acceleration_right", "delta_v_left", -1.0),
)


def _integrated(curve: Curve) -> Curve:
    """The integral over time from the first row, by straight lines between rows."""
    total, values = 0.0, [0.0]
    for (t, t_next), (v, v_next) in zip(
        itertools.pairwise(curve.times), itertools.pairwise(curve.values), strict=True
    ):
        total += (t_next - t) * (v + v_next) / 2
        values.append(total)
    return curve._replace(values=values)


def _is_number(cell: str, decimal: str) -> bool:
    try:
        number(re.split(r"[\[(/]", cell)[0].strip(), decimal)
    except NoNumber:
        return False
    return True


def _rows(curve: Curve) -> str:
    return _span(curve.rows)


def _span(rows: list[int]) -> str:
    return f"row {rows[0]}" if rows[0] == rows[-1] else f"rows {rows[0]} to {rows[-1]}"
