"""The scene file of a scene: the text it was read from if that still describes it, else a new one."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from retrodict.scene import fields
from retrodict.scene.asked import Avoidance, Questions
from retrodict.scene.errors import SceneError
from retrodict.scene.load import parse_scene
from retrodict.scene.measured import UNKNOWN
from retrodict.scene.priors import OF_PYTHON, Prior, keys_of
from retrodict.scene.records import (
    WHEELS,
    Approach,
    Edge,
    Items,
    Mark,
    Measured,
    Outline,
    Rest,
    Scene,
    Vehicle,
)
from retrodict.scene.speed_record import SpeedRecord

CANNOT_SAY = "# A scene file cannot say: "
_MADE = "# Made from "
_SOURCE = 200  # characters that a source may have
_LINE = 100  # characters, beyond which a list has a line for each of its items
_NAMED = ("vehicles", "surfaces", "priors")  # tables of tables
# what is estimated from a wheelbase, and stands in with it
_BY_WHEELBASE = ("cg_to_front_axle", "cg_to_rear_axle", "yaw_inertia")
_LARGEST = 1e-9  # relative difference of two numbers that are the same but for rounding
_OF_AVOIDANCE = {
    "reaction": "s",
    "deceleration": "m/s^2",
    "seen_time": "s",
    "seen_distance": "m",
    "clear": "m",
}
_PRIOR_UNITS = {"speed_a": "m/s", "speed_b": "m/s", "impulse": "m/s"} | {
    "omega_a": "rad/s",
    "omega_b": "rad/s",
    "Omega": "rad/s",
}


@dataclass(frozen=True, slots=True)
class SceneText:
    """The scene file that belongs to a scene.

    Args:
        text: text of the file, TOML.
        as_written: whether the text is as somebody wrote it; else it was made from a scene that was
            changed after it was read, or never had a file.
    """

    text: str
    as_written: bool

    @property
    def sha256(self) -> str:
        """Digest of the text in UTF-8."""
        return hashlib.sha256(self.text.encode()).hexdigest()


def scene_text(scene: Scene) -> SceneText:
    """The scene file that describes a scene.

    Args:
        scene: measured scene, as it was read or changed since.

    Returns:
        The scene's own text where reading it gives the same scene, but for whole turns that were not
        measured; else a text made from its values.
    """
    try:
        read = parse_scene(scene.text, scene.name)
    except SceneError:
        return SceneText(scene_toml(scene), False)
    # questions may be added by an option; they change nothing that was measured
    same = replace(scene, text="", approximations={}, questions=read.questions)
    if _comparable(read, scene) == same:
        return SceneText(scene.text, not scene.text.startswith((_MADE, CANNOT_SAY)))
    return SceneText(scene_toml(scene), False)


def _comparable(read: Scene, scene: Scene) -> Scene:
    """A scene as it was read, with the whole turns to rest that a reconstruction found."""
    rest = dict(read.rest)
    for v, pose in rest.items():
        other = scene.rest.get(v)
        if pose.heading is None or pose.turns_known or other is None or other.heading is None:
            continue
        turns = (other.heading.value - pose.heading.value) / math.tau
        if abs(turns - round(turns)) < _LARGEST:
            rest[v] = replace(pose, heading=replace(pose.heading, value=other.heading.value))
    return replace(read, text="", rest=rest)


def scene_toml(scene: Scene) -> str:
    """A scene file made from a scene's values, in SI units and radians.

    Args:
        scene: measured scene.

    Returns:
        TOML; a comment at its head names what a scene file cannot say (such as a mass that is exact),
        and a comment after each assumed quantity says which part of it was assumed.
    """
    lines = [
        f"{_MADE}the values that were computed with: the scene was changed after its file was read.",
        "schema = 1",
        f"title = {_quoted(scene.title)}",
        f"notes = {_value(list(scene.notes))}",
        f"question = [{', '.join(map(_quoted, scene.question))}]",
        f'errors = "{"robust" if scene.robust else "normal"}"',
    ]
    lines += ["alone = true"] if scene.alone else []
    for v in scene.vehicles:
        lines += ["", *_vehicle(scene, v)]
    if barrier := scene.barrier:
        lines += ["", "[barrier]", f'kind = "{barrier.kind}"', f"name = {_quoted(barrier.name)}"]
        lines += [f'diameter = "{float(barrier.diameter)!r} m"'] if barrier.diameter else []
    lines += [] if scene.alone else ["", *_impact(scene)]
    for surface in (*scene.surfaces, *scene.skidded_on):
        lines += ["", f"[surfaces.{surface.name}]", *_fields(surface, fields.SURFACE)]
        lines += _edge(surface.edge) if surface.edge else []
        lines += _outline(surface.outline) if surface.outline else []
    if scene.slope:
        lines += ["", "[slope]", *_fields(scene.slope, fields.SLOPE)]
    for name, prior in scene.priors.items():
        if prior.overridden and prior.family != OF_PYTHON:
            lines += ["", f"[priors.{name}]", *_prior(name, prior)]
    if scene.questions != Questions():
        lines += ["", "[questions]", *_questions(scene.questions)]
    text = "\n".join(lines) + "\n"
    unsaid = _unsaid(scene, text)
    return f"{CANNOT_SAY}{'; '.join(unsaid)}.\n{text}" if unsaid else text


def document_toml(document: Mapping[str, Any]) -> str:
    """A scene file with these tables and keys.

    Args:
        document: tables and keys that the schema accepted: text, numbers, lists and tables.

    Returns:
        TOML that reads as the same tables and keys, every quantity as it was written.
    """
    lines = [f"{_MADE}a scene that was built or changed in Python."]
    tables = {key: table for key, table in document.items() if isinstance(table, dict) and table}
    lines += [f"{key} = {_value(each)}" for key, each in document.items() if key not in tables]
    for key, table in tables.items():
        parts = {f"{key}.{name}": each for name, each in table.items()}
        for name, each in (parts if key in _NAMED else {key: table}).items():
            lines += ["", f"[{name}]", *_entries(each)]
    return "\n".join(lines) + "\n"


def _entries(table: Mapping[str, Any], above: str = "") -> Iterator[str]:
    for key, each in table.items():
        if isinstance(each, dict) and each and "value" not in each:
            yield from _entries(each, f"{above}{key}.")
        else:
            yield f"{above}{key} = {_value(each)}"


def _value(value: Any) -> str:
    match value:
        case str():
            return _quoted(value)
        case dict():
            return "{ " + ", ".join(f"{k} = {_value(each)}" for k, each in value.items()) + " }"
        case list():
            items = [_value(each) for each in value]
            if sum(map(len, items)) > _LINE:
                return "[\n" + "".join(f"  {item},\n" for item in items) + "]"
            return f"[{', '.join(items)}]"
        case bool():
            return str(value).lower()
    return repr(value)


def _impact(scene: Scene) -> Iterator[str]:
    x, y = scene.contact.x, scene.contact.y
    yield "[impact]"
    if "impact.point" not in scene.unwritten:
        yield f"point = [{_quantity(x, 'm')}, {_quantity(y, 'm')}]{_assumed(x, y)}"
    yield from _fields(scene.contact, _written(fields.IMPACT, "impact", scene))
    yield f"interlocked = {str(scene.contact.interlocked).lower()}"
    if scene.contact.together:
        yield "together = true"
    if scene.contact.perhaps_together:
        yield 'together = "perhaps"'
    yield from (_line(key, stated, "J") for key, stated in scene.energy_lost.items())
    yield from (_line(key, measured) for key, measured in scene.coefficients.items())


def _vehicle(scene: Scene, v: str) -> Iterator[str]:
    vehicle, above = scene.vehicles[v], f"vehicles.{v.upper()}"
    yield f"[{above}]"
    yield f"name = {_quoted(vehicle.name)}"
    yield from _fields(vehicle, _written(fields.VEHICLE, above, scene))
    yield f'length = "{float(vehicle.length)!r} m"'
    yield f'width = "{float(vehicle.width)!r} m"'
    if vehicle.articulated:
        yield 'articulation = "locked"'
    yield from _wheels(vehicle)
    missed = vehicle.run_out_error
    yield _line(
        "run_out_error.position", replace(missed.position, value=100 * missed.position.value), "%"
    )
    yield _line("run_out_error.heading", missed.heading, "rad")
    if f"{above}.impact_centre" not in scene.unwritten:
        yield from _fields(vehicle, fields.IMPACT_CENTRE, "impact_centre.")
    yield from _fields(vehicle, fields.POSE_AT_IMPACT, "impact.")
    approach = scene.approach[v]
    if approach.record is not None and approach.speed is not None:
        yield f"approach.speed_record = {_record(approach.record, approach.speed.source)}"
        approach = replace(approach, speed=None)
    yield from _fields(approach, fields.APPROACH, "approach.")
    yield from _marks_before(approach)
    for key in ("direction", "yaw_rate"):
        if getattr(approach, key) is None:
            yield f'approach.{key} = "{UNKNOWN}"'
    for name, own in fields.AFTER.items():
        yield from _items(getattr(scene, name).get(v, {}), own)
    if marks := scene.marks.get(v):
        yield "marks = ["
        yield from (f"  {_mark(mark)}," for mark in marks)
        yield "]"
    if rest := scene.rest.get(v):
        yield from _rest(rest, vehicle.heading.value)


def _written(
    table: Mapping[str, fields.Field], above: str, scene: Scene
) -> dict[str, fields.Field]:
    """The quantities of a table that do not stand in for what the scene's file does not have."""
    left_out = {path for path in scene.unwritten if path.startswith(f"{above}.")}
    if f"{above}.wheelbase" in left_out:
        left_out |= {f"{above}.{key}" for key in _BY_WHEELBASE}
    return {key: field for key, field in table.items() if f"{above}.{key}" not in left_out}


def _fields(record: object, table: Mapping[str, fields.Field], above: str = "") -> Iterator[str]:
    """A line for each quantity of a table that a record has."""
    for key, field in table.items():
        if (measured := getattr(record, field.name or key)) is not None:
            unit = field.dimension.stored
            if unit == "%":
                measured = replace(measured, value=100 * measured.value, sd=100 * measured.sd)
            yield _line(f"{above}{key}", measured, unit)


def _items(items: Items, table: fields.Evidence) -> Iterator[str]:
    """A line for each item of a table of evidence."""
    for key, measured in items.items():
        yield _line(f"{table.table}.{key}", measured, table.fields[key].dimension.stored)


def _marks_before(approach: Approach) -> Iterator[str]:
    """The keys of a skid in several pieces, and of a yaw mark."""
    if approach.skids:
        yield "approach.skids = ["
        for piece in approach.skids:
            parts = [] if piece.drag_factor else [f"surface = {_quoted(piece.surface)}"]
            for key, field in fields.SKID.items():
                if (measured := getattr(piece, key)) is not None:
                    parts.append(f"{key} = {_quantity(measured, field.dimension.stored)}")
            yield f"  {{ {', '.join(parts)} }},"
        yield "]"
    if (yaw := approach.yaw_mark) is not None:
        yield from _fields(yaw, fields.YAW_MARK, "approach.yaw_mark.")
        error = replace(yaw.error, value=100 * yaw.error.value)
        yield _line("approach.yaw_mark.error", error, "%")
        yield f"approach.yaw_mark.surface = {_quoted(yaw.surface)}"


def _record(record: SpeedRecord, source: str) -> str:
    def several(numbers: tuple[float, ...], unit: str) -> str:
        # one a line: a scene file's lines have an end
        return ",\n  ".join(f'"{float(number)!r} {unit}"' for number in numbers)

    parts = (
        f"times = [{several(record.times, 's')}]",
        f"speeds = [{several(record.speeds, 'm/s')}]",
        f"impact = [{several((record.low, record.high), 's')}]",
        f"uncertainty = {_quantity(Measured(record.sd, source=source), 'm/s')}",
    )
    return "{ " + ", ".join(parts) + " }"


def _wheels(vehicle: Vehicle) -> Iterator[str]:
    if (wheels := vehicle.wheels) is None:
        return
    for wheel in WHEELS:
        yield _line(f"wheels.{wheel}", getattr(wheels, wheel))
    yield _line("steer", wheels.steer, "rad")
    if wheels.factor is not None:
        yield _line("drag_factor", wheels.factor)


def _mark(mark: Mark) -> str:
    across = Measured(mark.sd, source=mark.source)
    parts = [
        f'point = ["{float(mark.x)!r} m", "{float(mark.y)!r} m"]',
        f"of = {_quoted(mark.of)}",
        f"uncertainty = {_quantity(across, 'm')}",
    ]
    for key, measured, unit in (("speed", mark.speed, "m/s"), ("course", mark.course, "rad")):
        if measured is not None:
            parts.append(f"{key} = {_quantity(measured, unit)}")
    return "{ " + ", ".join(parts) + " }"


def _rest(rest: Rest, at_impact: float) -> Iterator[str]:
    x, y = rest.x, rest.y
    yield f"rest.position = [{_quantity(x, 'm')}, {_quantity(y, 'm')}]{_assumed(x, y)}"
    if rest.heading is None:
        return
    rotation = rest.heading.value - at_impact
    once = math.remainder(rest.heading.value, math.tau)
    yield _line("rest.heading", replace(rest.heading, value=once), "rad")
    if rest.turns_known:
        yield f'rest.rotation = "{float(rotation)!r} rad"'


def _edge(edge: Edge) -> Iterator[str]:
    yield f'edge.point = ["{float(edge.x)!r} m", "{float(edge.y)!r} m"]'
    yield f'edge.direction = "{float(edge.direction)!r} rad"'
    yield f"edge.side = {_quoted(edge.side)}"
    if edge.offset.sd:
        yield _line("edge.uncertainty", Measured(edge.offset.sd, source=edge.offset.source), "m")


def _outline(outline: Outline) -> Iterator[str]:
    yield "outline.corners = ["
    yield from (f'  ["{float(x)!r} m", "{float(y)!r} m"],' for x, y in outline.corners)
    yield "]"
    if outline.offset.sd:
        offset = Measured(outline.offset.sd, source=outline.offset.source)
        yield _line("outline.uncertainty", offset, "m")


def _prior(name: str, prior: Prior) -> Iterator[str]:
    yield f"source = {_quoted(prior.source[:_SOURCE])}"
    if prior.family:
        yield f"family = {_quoted(prior.family)}"
    for key, number in zip(keys_of(name, prior), prior.numbers, strict=True):
        unit = _PRIOR_UNITS.get(name, "m/s" if key == "over" else "")
        yield _line(key, Measured(number), unit)


def _questions(asked: Questions) -> Iterator[str]:
    both = [
        p.text
        for p in asked.probabilities
        if not p.joined and math.isfinite(p.low) and math.isfinite(p.high)
    ]
    one = [p.text for p in asked.probabilities if p.text not in both]
    yield f"exceeds = [{', '.join(map(_quoted, one))}]"
    yield f"between = [{', '.join(map(_quoted, both))}]"
    pairs = (
        f"{{ first = {_quoted(c.first.text)}, second = {_quoted(c.second.text)} }}"
        for c in asked.comparisons
    )
    yield f"likelihood_ratio = [{', '.join(pairs)}]"
    yield f"avoidable = [{', '.join(map(_avoidance, asked.avoidance))}]"
    if asked.time_distance is not None:
        yield f'time_distance = "{float(asked.time_distance)!r} s"'
    for key in ("corners", "one_at_a_time", "checks"):
        yield f"{key} = {str(getattr(asked, key)).lower()}"


def _avoidance(asked: Avoidance) -> str:
    parts = [f'vehicle = "{asked.vehicle.upper()}"', f'limit = "{float(asked.limit)!r} m/s"']
    for key, unit in _OF_AVOIDANCE.items():
        if (measured := getattr(asked, key)) is not None:
            parts.append(f"{key} = {_quantity(measured, unit)}")
    return "{ " + ", ".join(parts) + " }"


def _line(key: str, measured: Measured, unit: str = "") -> str:
    return f"{key} = {_quantity(measured, unit)}{_assumed(measured)}"


def _quantity(measured: Measured, unit: str) -> str:
    parts = [f"value = {float(measured.value)!r}"]
    parts += [f"sd = {float(measured.measured_sd)!r}"] if measured.sd else []
    parts += [f"unit = {_quoted(unit)}"] if unit else []
    parts += [f"source = {_quoted(measured.source[:_SOURCE])}"] if measured.source else []
    return "{ " + ", ".join(parts) + " }"


def _assumed(*measured: Measured) -> str:
    words = {"sd": "uncertainty assumed", "value": "value and uncertainty assumed"}
    found = {words[m.assumed] for m in measured if m.assumed}
    return f"  # {' and '.join(sorted(found))}" if found else ""


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _unsaid(scene: Scene, text: str) -> list[str]:
    """Names of quantities that a text made from a scene does not hold, or why the text is refused."""
    try:
        read = parse_scene(text, scene.name)
    except SceneError as error:
        return [f"{problem.key}: {problem.fix}" for problem in error.problems]
    known = scene.inputs() | scene.evidence()
    said = read.inputs() | read.evidence()
    own = [f"the prior of {k} as it is" for k, p in scene.priors.items() if p.family == OF_PYTHON]
    own += [f"the term {name} of the user's own" for name in scene.extra]
    return own + [
        f"{name} as it is"
        for name in {**known, **said}
        if name not in scene.approximations
        if name not in known or name not in said or not _same(known[name], said[name])
    ]


def _same(one: Measured, other: Measured) -> bool:
    return one.law == other.law and all(
        math.isclose(a, b, rel_tol=_LARGEST, abs_tol=_LARGEST)
        for a, b in ((one.value, other.value), (one.sd, other.sd))
    )
