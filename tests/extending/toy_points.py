"""A toy file of points: places by name, in JSON."""

import json

from retrodict.interchange.column_map import SurveyEntry
from retrodict.interchange.points import Point
from retrodict.interchange.source_file import SourceFile


def points_of(file: SourceFile, survey: SurveyEntry) -> tuple[list[Point], list[str]]:
    """Every place, and a line on what is left."""
    try:
        places = json.loads(file.content)
    except ValueError as error:
        raise file.refuse(f"not valid JSON ({error}); fix it") from None
    points = [Point(name, "", x, y, f"key {name}") for name, (x, y) in places.items()]
    return points, ["a line"]
