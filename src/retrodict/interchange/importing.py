"""Import of another program's file by a map: a scene file with its values, each with its source."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from retrodict.interchange.column_map import FrameEntry, MapEntry, RestEntry, load_map
from retrodict.interchange.dxf_in import drawing_points
from retrodict.interchange.landxml import landxml_points
from retrodict.interchange.points import (
    Frame,
    Point,
    fitted_line,
    fitted_pose,
    from_east,
    named,
    posed,
    spots_of,
)
from retrodict.interchange.recorder_csv import recorder_taken
from retrodict.interchange.source_file import SourceFile, read_source
from retrodict.interchange.survey_csv import survey_points
from retrodict.interchange.taken import Taken, quantity, replaced, rounded
from retrodict.interchange.vendors import refuse_by_content, refuse_vendor
from retrodict.scene.defaults import DEFAULTS
from retrodict.scene.edit import write_keys
from retrodict.scene.errors import Problem, SceneError, shown
from retrodict.scene.load import READERS, read_text, scene_from, toml_of, value_at
from retrodict.scene.outlines import outline_fault
from retrodict.scene.records import Measured, Scene, Vehicle
from retrodict.scene.text_edit import edited_in_place
from retrodict.scene.write import document_toml

# a map's table on a file of points -> what reads these, with a line on each thing that it leaves
POINTS: dict[str, Callable[[SourceFile, Any], tuple[list[Point], list[str]]]] = {
    "survey": survey_points,
    "drawing": drawing_points,
    "landxml": landxml_points,
}
_MISFIT = 4.0  # standard deviations of a point that points of one line or vehicle may miss it by


@dataclass(frozen=True, slots=True)
class Import:
    """What an import takes, what it leaves, and the scene file that it makes.

    Args:
        taken: values that the scene file takes from the file, one for each key that is written.
        left: lines, each naming something of the file that was not taken, with the reason.
        scene: scene that the new text describes; None while something is still missing from it.
        text: new text of the scene file.
    """

    taken: tuple[Taken, ...]
    left: tuple[str, ...]
    scene: Scene | None
    text: str


def import_evidence(file: str | Path, map_file: str | Path, into: str | Path) -> Import:
    """The scene file with what a map takes from a file of another program. Nothing is written.

    Args:
        file: survey points as CSV or LandXML, a drawing as DXF, or a recorder's table as CSV.
        map_file: map (TOML) that says how to read the file and what to take; see docs/import.md.
        into: the scene file (TOML), which needs no evidence yet.

    Returns:
        What was taken and left, and the new text of the scene file.

    Raises:
        SceneError: the file, the map or the scene file cannot be used; says why, where, and the fix.

    Examples:
        >>> import retrodict as rd
        >>> folder = "examples/import"
        >>> found = rd.import_evidence(
        ...     f"{folder}/survey.csv", f"{folder}/survey.toml", f"{folder}/before.toml"
        ... )
        >>> "vehicles.A.rest.position" in [each.key for each in found.taken]
        True
    """
    refuse_vendor(file)
    if Path(into).suffix.lower() in set(READERS) - {".toml"}:
        raise SceneError(str(into), [Problem("", "", "write the path of a scene file in TOML")])
    entry = load_map(map_file)
    text = read_text(into)
    document = toml_of(text, str(into))
    source = read_source(file)
    refuse_by_content(source, entry)
    if entry.recorder is not None:
        taken, left = recorder_taken(source, entry.recorder, document)
    else:
        taken, left = _Taking(source, str(map_file), entry, document, str(into)).all()
    if not taken:
        fix = (
            "takes nothing; write what to take: [impact_point], [rest.A], [[marks.A]], [edges.NAME], "
            "[outlines.NAME]"
        )
        raise SceneError(str(map_file), [Problem("", "", fix)])
    changes = {each.key: each.value for each in taken}
    changed = deepcopy(document)
    write_keys(changed, changes, str(into))
    name = Path(into).stem if Path(into).stem != "scene" else Path(into).resolve().parent.name
    new = edited_in_place(text, changes, changed, str(into))
    if not new:
        new = document_toml(changed)
        left.append("comments of the scene file: its layout could not be kept, it is written anew")
    scene = _finished(document, changed, name, new, str(into), left)
    toml_of(new, str(into))  # refuses what is too long to be read again
    return Import(tuple(taken), tuple(left), scene, new)


def placed_points(file: str | Path, map_file: str | Path) -> tuple[tuple[str, float, float], ...]:
    """Every point of a file in the scene's frame, as a map says.

    Args:
        file: survey points as CSV, or a drawing as DXF.
        map_file: map (TOML) that says how to read the file; see docs/import.md.

    Returns:
        Name, x and y (m) of each point that can be used; none of a recorder's table.

    Raises:
        SceneError: the file or the map cannot be used.
    """
    refuse_vendor(file)
    entry = load_map(map_file)
    if entry.recorder is not None:
        return ()
    taking = _Taking(read_source(file), str(map_file), entry, {}, "")
    taking.read()
    return tuple(
        (point.name, *taking.frame.position(point)) for point in taking.points if not point.fault
    )


def _finished(
    document: dict[str, Any],
    changed: dict[str, Any],
    name: str,
    text: str,
    file: str,
    left: list[str],
) -> Scene | None:
    """The changed scene; None, with a line in `left`, where its only faults are those from before."""
    try:
        return scene_from(changed, name, text, file)
    except SceneError as error:
        try:
            scene_from(document, name, text, file)
            before: set[Problem] = set()
        except SceneError as earlier:
            before = set(earlier.problems)
        if not before.issuperset(error.problems):
            raise
        first, *more = error.problems
        others = f", and {len(more)} more" if more else ""
        left.append(f"the scene is not complete yet: {first}{others}")
        return None


@dataclass
class _Taking:
    """What is taken of one file, as a map says."""

    file: SourceFile
    map_file: str
    map: MapEntry
    document: dict[str, Any]
    into: str
    used: set[Point] = field(default_factory=set)

    def read(self) -> list[str]:
        """Read the points and their frame; returns lines on what is left of the file."""
        table = next(name for name in POINTS if getattr(self.map, name) is not None)
        entry: FrameEntry = getattr(self.map, table)
        points, left = POINTS[table](self.file, entry)
        self.points, self.by_name = points, named(points)
        self.precision = entry.precision.value
        self.frame = self._frame(entry)
        return left

    def all(self) -> tuple[list[Taken], list[str]]:
        """Everything taken, and lines on what is left."""
        left = self.read()
        others = [*self._impact_point(), *self._marks(), *self._edges(), *self._outlines()]
        taken = [*others, *self._rests(others)]
        for point in self.points:
            if point not in self.used:
                group = f" ({shown(point.group)})" if point.group not in ("", point.name) else ""
                why = point.fault or "not in the map"
                left.append(f"point {shown(point.name)}{group}, {point.where}: {why}")
        return taken, left

    def _frame(self, entry: FrameEntry) -> Frame:
        angles = entry.angles or "counter-clockwise from east"
        x_axis = from_east(entry.x_axis.value, angles) if entry.x_axis else 0.0
        origin = (0.0, 0.0)
        if isinstance(entry.origin, str):
            point = self._one(entry.origin, "origin")
            origin = (entry.metre * point.x, entry.metre * point.y)
        elif entry.origin is not None and entry.unit != "deg":  # these are projected about it
            origin = (entry.origin[0].value, entry.origin[1].value)
        return Frame(entry.metre, entry.axes, angles, origin, x_axis)

    def _impact_point(self) -> Iterator[Taken]:
        if (entry := self.map.impact_point) is None:
            return
        point = self._one(entry.point, "impact_point.point")
        sd = math.hypot(self.precision, entry.uncertainty.value)
        x, y = self.frame.position(point)
        yield self._value("impact.point", [point], [(x, sd), (y, sd)], "m")

    def _rests(self, others: Sequence[Taken]) -> Iterator[Taken]:
        entries = {v: rest for v in ("A", "B") if (rest := getattr(self.map.rest, v)) is not None}
        if not entries:
            return
        vehicles = self._vehicles(entries, others)
        for v, entry in entries.items():
            yield from self._rest(v, entry, vehicles[v])

    def _rest(self, v: str, entry: RestEntry, vehicle: Vehicle) -> Iterator[Taken]:
        spots, key = spots_of(vehicle), f"rest.{v}"
        body = [spots[spot] for spot in entry.points]
        body += [(ahead.value, left.value) for ahead, left in entry.offsets.values()]
        names = [*entry.points.values(), *entry.offsets]
        points = [self._one(name, f"{key}.points") for name in names]
        road = [self.frame.position(point) for point in points]
        sd = math.hypot(self.precision, entry.uncertainty.value)
        remark = ""
        if len(points) == 1:
            heading = self._heading(entry, points[0], key)
            pose = posed(body[0], road[0], heading.value, sd, heading.sd)
        else:
            try:
                pose = fitted_pose(body, road, sd)
            except ValueError:
                fix = "all points are one spot of the vehicle; add another, or a heading"
                raise self._wrong(f"{key}.points", fix) from None
            self._fits(pose.misfit, sd, f"{key}.points", f"vehicle {v} as the scene has it")
            remark = f"misfit {pose.misfit:.3f} m"
            heading = Measured(pose.heading, pose.sd_heading, source=self._source(points))
        table = f"vehicles.{v}.rest"
        xy = [(pose.x, pose.sd_x), (pose.y, pose.sd_y)]
        yield self._value(f"{table}.position", points, xy, "m", remark)
        # what the scene assumes, it is left to assume
        degrees = None if heading.assumed else math.degrees(heading.sd)
        value = quantity(math.degrees(heading.value), degrees, "deg", heading.source)
        yield self._taken(f"{table}.heading", value, points)

    def _heading(self, entry: RestEntry, point: Point, key: str) -> Measured:
        """The heading of a vehicle of which one point was measured, in the scene's frame."""
        if (written := entry.heading) is not None:
            source = "" if written.assumed else written.source
            source = source or f"{shown(Path(self.map_file).name)[1:-1]}, {key}.heading"
            return replace(written, value=self.frame.heading(written.value), source=source[:200])
        if point.heading is None:
            fix = "one point gives no heading; add a second point, or heading"
            raise self._wrong(f"{key}.heading", fix)
        heading = self.frame.heading if self.map.survey else self.frame.drawn_heading
        sd, source = DEFAULTS["rest_heading"].amount(0.0), self._source([point])
        return Measured(heading(point.heading), sd, source=source, assumed="sd")

    def _vehicles(
        self, rests: Mapping[str, RestEntry], others: Sequence[Taken]
    ) -> dict[str, Vehicle]:
        """Vehicles of the scene, which has all but their rest poses."""
        document = deepcopy(self.document)
        there = {f"vehicles.{v}.rest": {"position": ["0 m", "0 m"]} for v in rests}
        write_keys(document, {each.key: each.value for each in others} | there, self.into)
        scene = scene_from(document, "scene", "", self.into)
        return {v: scene.vehicles[v.lower()] for v in rests}

    def _marks(self) -> Iterator[Taken]:
        for v in ("A", "B"):
            marks: list[dict[str, Any]] = []
            used: list[Point] = []
            for i, entry in enumerate(getattr(self.map.marks, v)):
                sd = math.hypot(self.precision, entry.uncertainty.value)
                for point in self._several(entry.points, f"marks.{v}[{i}].points"):
                    used.append(point)
                    x, y = (
                        quantity(each, None, "m", self._source([point]))
                        for each in self.frame.position(point)
                    )
                    across = {"value": rounded(sd), "unit": "m"}
                    marks.append({"point": [x, y], "of": entry.of, "uncertainty": across})
            if marks:
                yield self._taken(f"vehicles.{v}.marks", marks, used)

    def _edges(self) -> Iterator[Taken]:
        for name, entry in self.map.edges.items():
            points = self._several(entry.points, f"edges.{name}.points")
            sd = math.hypot(self.precision, entry.uncertainty.value)
            try:
                place, direction, misfit = fitted_line([self.frame.position(p) for p in points])
            except ValueError:
                fix = "all points are one place; write two or more along the edge"
                raise self._wrong(f"edges.{name}.points", fix) from None
            self._fits(misfit, sd, f"edges.{name}.points", "one straight line")
            source = self._source(points)
            edge = {
                "point": [quantity(each, None, "m", source) for each in place],
                "direction": quantity(math.degrees(direction), None, "deg", source),
                "side": entry.side,
                "uncertainty": {"value": rounded(sd), "unit": "m"},
            }
            yield from replaced(self.document, f"surfaces.{name}.outline")
            yield self._taken(f"surfaces.{name}.edge", edge, points, f"misfit {misfit:.3f} m")

    def _outlines(self) -> Iterator[Taken]:
        for name, entry in self.map.outlines.items():
            points = self._several(entry.points, f"outlines.{name}.points")
            places = [self.frame.position(point) for point in points]
            corners = _distinct(places, _MISFIT * self.precision)
            if wrong := outline_fault(corners):
                raise self._wrong(f"outlines.{name}.points", wrong)
            sd = math.hypot(self.precision, entry.uncertainty.value)
            # one source, and not of every corner: a scene file is a page of text
            outline = {
                "corners": [[f"{round(x, 4)!r} m", f"{round(y, 4)!r} m"] for x, y in corners],
                "uncertainty": {"value": rounded(sd), "unit": "m", "source": self._source(points)},
            }
            again = len(places) - len(corners)
            remark = f"{again} of them at the corner before" if again else ""
            yield from replaced(self.document, f"surfaces.{name}.edge")
            yield self._taken(f"surfaces.{name}.outline", outline, points, remark)

    def _one(self, name: str, key: str) -> Point:
        points = self._several([name], key)
        if len(points) > 1:
            places = ", ".join(point.where for point in points[:5])
            fix = f"{len(points)} points have this name ({places}); name one of them"
            raise self._wrong(key, fix, name)
        return points[0]

    def _several(self, names: Sequence[str], key: str) -> list[Point]:
        found: list[Point] = []
        for name in names:
            points = self.by_name.get(name, [])
            if not points:
                some = ", ".join(shown(each) for each in list(self.by_name)[:12])
                raise self._wrong(key, f"no such point in {self.file.path}; it has {some}", name)
            for point in points:
                if point.fault:
                    fix = f"{point.where} of {self.file.path}: {point.fault}; correct the file"
                    raise self._wrong(key, fix, name)
            found += points
        self.used |= set(found)
        return found

    def _fits(self, misfit: float, sd: float, key: str, what: str) -> None:
        if misfit > _MISFIT * sd:
            fix = (
                f"the points miss {what} by {misfit:.3g} m, with an uncertainty of {sd:.3g} m; check "
                "which point is which, unit and axes, or write a larger uncertainty"
            )
            raise self._wrong(key, fix)

    def _wrong(self, key: str, fix: str, value: str = "") -> SceneError:
        return SceneError(self.map_file, [Problem(key, shown(value) if value else "", fix)])

    def _value(
        self,
        key: str,
        points: Sequence[Point],
        values: Sequence[tuple[float, float]],
        unit: str,
        remark: str = "",
    ) -> Taken:
        """Values with their standard deviations at a key, all from the same points."""
        source = self._source(points)
        written = [quantity(value, sd, unit, source) for value, sd in values]
        return self._taken(key, written if len(written) > 1 else written[0], points, remark)

    def _taken(self, key: str, value: Any, points: Sequence[Point], remark: str = "") -> Taken:
        return Taken(key, value, _places(points), value_at(self.document, key), remark)

    def _source(self, points: Sequence[Point]) -> str:
        return self.file.source(_places(points))


def _distinct(places: Sequence[tuple[float, float]], near: float) -> list[tuple[float, float]]:
    """Places along an outline without those near the one before.

    Lines drawn end to end, and a survey that ends where it began, have corners twice.
    """
    kept: list[tuple[float, float]] = []
    for place in places:
        if not kept or math.dist(place, kept[-1]) > near:
            kept.append(place)
    while len(kept) > 1 and math.dist(kept[-1], kept[0]) <= near:
        kept.pop()
    return kept


def _places(points: Sequence[Point]) -> str:
    """Names of points and where they stand, in a line."""
    if len(points) == 1:
        return f"point {shown(points[0].name)[1:-1]}, {points[0].where}"
    names = ", ".join(shown(point.name)[1:-1] for point in points[:4])
    more = f" and {len(points) - 4} more" if len(points) > 4 else ""
    return f"points {names}{more}"
