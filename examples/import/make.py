"""Writes survey.csv and before.toml: the paper's scene as a total station would have measured it.

python3 -m uv run python examples/import/make.py
"""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import tomlkit

from retrodict.interchange.points import spots_of
from retrodict.scene import load_scene

HERE = Path(__file__).parent
PAPER = HERE.parent / "brach-1977" / "scene.toml"
FOOT = 0.3048
EAST, NORTH = 1482310.00, 642755.00  # ft: the scene's origin in the survey's grid
AZIMUTH = math.radians(75)  # of the scene's x axis, clockwise from north
COLUMNS = ("Point", "Northing", "Easting", "Elevation", "Code")


def survey() -> str:
    """Points in feet, northing first, to a hundredth of a foot."""
    scene = load_scene(PAPER)
    berm = next(s.edge for s in scene.surfaces if s.edge is not None)
    along = (math.cos(berm.direction), math.sin(berm.direction))
    points = [("origin", 0.0, 0.0), ("gouge", scene.contact.x.value, scene.contact.y.value)]
    for v in ("a", "b"):
        rest, car = scene.rest[v], scene.vehicles[v]
        c, s = math.cos(rest.heading.value), math.sin(rest.heading.value)
        for spot, (ahead, left) in spots_of(car).items():
            if spot.endswith("_corner"):
                x = rest.x.value + c * ahead - s * left
                y = rest.y.value + s * ahead + c * left
                points.append((f"{v.upper()} {spot.removesuffix('_corner')}", x, y))
    points += [("berm", berm.x + d * along[0], berm.y + d * along[1]) for d in (-20, -8, 4, 16)]
    points.append(("hydrant", -14.2, 6.35))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    s, c = math.sin(AZIMUTH), math.cos(AZIMUTH)
    for number, (code, x, y) in enumerate(points, start=1):
        east, north = x * s - y * c, x * c + y * s
        row = (f"{NORTH + north / FOOT:.2f}", f"{EAST + east / FOOT:.2f}", f"{131.4:.2f}")
        writer.writerow((100 + number, *row, code))
    return text.getvalue()


def before() -> str:
    """The paper's scene without what the survey measured."""
    document = tomlkit.parse(PAPER.read_text("utf-8"))
    for v in ("A", "B"):
        del document["vehicles"][v]["rest"]["position"]
        del document["vehicles"][v]["rest"]["heading"]
    del document["impact"]["point"]
    del document["surfaces"]["berm"]["edge"]
    return tomlkit.dumps(document)


if __name__ == "__main__":
    (HERE / "survey.csv").write_text(survey(), "utf-8")
    (HERE / "before.toml").write_text(before(), "utf-8")
