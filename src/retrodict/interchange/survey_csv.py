"""Survey points from CSV: a column map says which column is what."""

from __future__ import annotations

from retrodict.interchange.column_map import SurveyEntry
from retrodict.interchange.points import Point
from retrodict.interchange.source_file import NoNumber, Row, SourceFile, number, table_rows
from retrodict.scene.errors import shown


def columns_of(
    file: SourceFile, rows: list[Row], wanted: dict[str, int | str], table: str
) -> tuple[dict[str, int], list[Row], list[str]]:
    """Where the columns of a table stand.

    Args:
        file: file of the table, for messages.
        rows: rows of the table.
        wanted: name in the header, or number from 1, of each wanted column, by what it holds.
        table: name of the map's table, for messages.

    Returns:
        Index of each wanted column from 0, the rows below the header, and a line on each other column.

    Raises:
        SceneError: the header has no such column, or two of them.
    """
    if all(isinstance(each, int) for each in wanted.values()):
        return {key: int(each) - 1 for key, each in wanted.items()}, rows, []
    header = rows[0].cells if rows else ()
    names = [_plain(cell) for cell in header]
    places = {}
    for key, column in wanted.items():
        found = [i for i, name in enumerate(names) if name == _plain(str(column))]
        if len(found) != 1:
            has = ", ".join(shown(cell) for cell in header[:12] if cell)
            what = "has no such column" if not found else "has it twice"
            fix = f"the header {what}; it has {has}; correct [{table}.columns] in the map"
            raise file.refuse(fix, key, shown(column))
        places[key] = found[0]
    others = [cell for i, cell in enumerate(header) if cell and i not in places.values()]
    left = [f"column {shown(cell)}: not in the map" for cell in others]
    return places, rows[1:], left


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
    rows = table_rows(file, survey.separator or "")
    wanted = {key: column for key, column in survey.columns if column is not None}
    places, rows, left = columns_of(file, rows, wanted, "survey")
    points = [_point(row, places, survey) for row in rows]
    if not points:
        raise file.refuse("has no points below its header; export it anew")
    return points, left


def _point(row: Row, places: dict[str, int], survey: SurveyEntry) -> Point:
    def cell(key: str) -> str:
        place = places.get(key)
        return row.cells[place] if place is not None and place < len(row.cells) else ""

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


def _plain(name: str) -> str:
    return " ".join(name.split()).casefold()
