"""Survey points from CSV: a column map says which column is what."""

from __future__ import annotations

from collections.abc import Callable

from retrodict.interchange.cells import NoNumber, number
from retrodict.interchange.column_map import SurveyEntry
from retrodict.interchange.geodetic import degrees_in, projected, refuse_degrees
from retrodict.interchange.points import Point
from retrodict.interchange.source_file import SourceFile
from retrodict.interchange.stations import place
from retrodict.interchange.table_in import Row, read_table
from retrodict.scene.errors import shown


def survey_points(file: SourceFile, survey: SurveyEntry) -> tuple[list[Point], list[str]]:
    """The points of a survey.

    Args:
        file: table of the points, as CSV.
        survey: the map's [survey] table.

    Returns:
        Every point with where it stands, those that cannot be used with the reason; and a line on each
        column that the map leaves out.

    Raises:
        SceneError: the file is no table, or lacks a column.
    """
    wanted = {key: column for key, column in survey.columns if column is not None}
    table = read_table(file, survey, wanted, "survey")
    points = [_point(row, table.places, survey) for row in table.rows]
    if not points:
        raise file.refuse("has no points below its header; export it anew")
    if survey.baseline is None:
        headings = [table.headings.get(key, "") for key in ("x", "y")]
        refuse_degrees(file, points, survey, headings)
    if survey.unit == "deg":
        points = projected(file, points, survey)
    return points, table.left


def _point(row: Row, places: dict[str, int], survey: SurveyEntry) -> Point:
    def cell(key: str) -> str:
        return row.cell(places.get(key))

    fault, x, y, heading = "", 0.0, 0.0, None
    try:
        x, y = _place(cell, survey)
    except NoNumber as error:
        fault = str(error)
    if written := cell("heading"):
        try:
            heading = number(written, survey.decimal) * (survey.angle_unit or 1.0)
        except NoNumber as error:
            fault = fault or f"heading = {shown(written)} {error}"
    return Point(
        name=cell("id"),
        group=cell("description"),
        x=x,
        y=y,
        where=f"row {row.number}",
        heading=heading,
        fault=fault,
    )


def _place(cell: Callable[[str], str], survey: SurveyEntry) -> tuple[float, float]:
    """The coordinates of a point, with the column at fault where a cell cannot be read."""
    if survey.baseline is not None:
        cells = cell("station"), cell("offset")
        try:
            return place(cells, survey)
        except NoNumber as error:
            raise NoNumber(f"{shown(', '.join(filter(None, cells)))} {error}") from None
    found = []
    for key, axis in zip(("x", "y"), survey.axes, strict=True):
        try:
            if survey.unit == "deg":
                found.append(degrees_in(cell(key), survey.decimal, axis))
            else:
                found.append(number(cell(key), survey.decimal))
        except NoNumber as error:
            raise NoNumber(f"{key} = {shown(cell(key))} {error}") from None
    return found[0], found[1]
