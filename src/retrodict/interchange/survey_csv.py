"""Survey points from CSV: a column map says which column is what."""

from __future__ import annotations

from retrodict.interchange.column_map import SurveyEntry
from retrodict.interchange.points import Point
from retrodict.interchange.source_file import SourceFile
from retrodict.interchange.table_in import NoNumber, Row, number, read_table
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
    return points, table.left


def _point(row: Row, places: dict[str, int], survey: SurveyEntry) -> Point:
    def cell(key: str) -> str:
        return row.cell(places.get(key))

    fault, numbers = "", {}
    for key in ("x", "y", "heading"):
        if key == "heading" and not cell(key):
            continue
        try:
            numbers[key] = number(cell(key), survey.decimal)
        except NoNumber as error:
            fault = fault or f"{key} = {shown(cell(key))} {error}"
    heading = numbers.get("heading")
    if heading is not None and survey.angle_unit is not None:
        heading *= survey.angle_unit
    return Point(
        name=cell("id"),
        group=cell("description"),
        x=numbers.get("x", 0.0),
        y=numbers.get("y", 0.0),
        where=f"row {row.number}",
        heading=heading,
        fault=fault,
    )
