"""Quantities as people write them ("45 ± 2 mph"), read into SI units and radians."""

from __future__ import annotations

import difflib
import math
import re
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING, cast

from retrodict.constants import GRAVITY
from retrodict.scene.errors import shown

if TYPE_CHECKING:
    from pint import UnitRegistry

_TEXT_LENGTH = 100


@dataclass(frozen=True, slots=True)
class Dimension:
    """Dimension of a quantity.

    Args:
        name: name in `quantities.unit_of`; empty for a dimension that is not reported.
        phrase: noun phrase for messages ("a mass").
        units: units to suggest, the first of them SI (or degrees); none for a plain number.
    """

    name: str
    phrase: str
    units: tuple[str, ...] = ()

    @property
    def stored(self) -> str:
        """Unit in files made from a scene: that of its records, but "%" for shares and grades."""
        first = self.units[0] if self.units else ""
        return {"deg": "rad", "deg/s": "rad/s"}.get(first, first)


MASS = Dimension("mass", "a mass", ("kg", "lb"))
INERTIA = Dimension("inertia", "a yaw inertia", ("kg m^2", "lb ft s^2", "slug ft^2"))
LENGTH = Dimension("length", "a length", ("m", "ft", "in"))
SPEED = Dimension("speed", "a speed", ("m/s", "km/h", "mph", "ft/s"))
ANGLE = Dimension("angle", "an angle", ("deg", "rad"))
DIRECTION = Dimension("angle", "a direction", ("deg", "rad"))  # on the ground: bearings are read
YAW_RATE = Dimension("yaw rate", "a yaw rate", ("deg/s", "rad/s"))
INVERSE_SPEED = Dimension("inverse speed", "an inverse speed", ("s/m", "1/mph"))
TIME = Dimension("time", "a time", ("s",))
DECELERATION = Dimension("", "a deceleration", ("m/s^2", "g", "ft/s^2"))
ENERGY = Dimension("energy", "an energy", ("J", "kJ", "ft lbf"))
SHARE = Dimension("", "a share", ("%",))
GRADE = Dimension("grade", "a grade", ("%",))
NUMBER = Dimension("number", "a plain number")

# what the units above are worth, by definition; pint knows all others, and takes a while to load
_WORTH = {
    "kg": 1.0,
    "lb": 0.45359237,
    "kg m^2": 1.0,
    "lb ft s^2": 1.3558179483314004,
    "slug ft^2": 1.3558179483314004,
    "m": 1.0,
    "ft": 0.3048,
    "in": 0.0254,
    "m/s": 1.0,
    "km/h": 1 / 3.6,
    "mph": 0.44704,
    "ft/s": 0.3048,
    "deg": math.radians(1),
    "rad": 1.0,
    "deg/s": math.radians(1),
    "rad/s": 1.0,
    "s/m": 1.0,
    "1/mph": 1 / 0.44704,
    "s": 1.0,
    "m/s^2": 1.0,
    "g": GRAVITY,
    "ft/s^2": 0.3048,
    "J": 1.0,
    "kJ": 1000.0,
    "ft lbf": 1.3558179483314004,
    "%": 0.01,
}


@dataclass(frozen=True, slots=True)
class Reading:
    """A quantity as it was read, in SI units or radians; `sd` is None where none was written."""

    value: float
    sd: float | None
    source: str


class QuantityError(ValueError):
    """A quantity that cannot be read.

    Args:
        fix: description of the fault, and advice on what to write.
        key: key of the quantity's table that is at fault; empty for the quantity as a whole.
    """

    def __init__(self, fix: str, key: str = "") -> None:
        super().__init__(fix)
        self.fix = fix
        self.key = key


# a number is read here and never by pint, which would evaluate an expression
_NUMBER = r"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)(?![0-9.,])"
_UNIT = r"(%|(?:1 ?/ ?)?[A-Za-z°][A-Za-z0-9°²³^*·⋅/ .-]{0,39})?"
_QUANTITY = re.compile(rf"{_NUMBER} ?{_UNIT}(?: ?(?:±|\+/-|\+-) ?{_NUMBER} ?(%)? ?{_UNIT})?")
# all of a unit that pint is given: names with powers up to 4, multiplied or divided
_POWER = r"(?:(?:\^|\*\*)?-?[1-4])?"
_SAFE_UNIT = re.compile(rf"(?:1 ?/ ?)?[A-Za-z]+{_POWER}(?: ?[*/ ] ?[A-Za-z]+{_POWER})*")
# how people write units that pint knows otherwise (to it a kmph is a kilo-mph), or not at all
_ALIASES = {
    "kmph": "km/h", "kph": "km/h", "kmh": "km/h", "km/hr": "km/h", "mi/h": "mph", "mi/hr": "mph",
    "fps": "ft/s", "mps": "m/s", "lbs": "lb", "feet": "ft", "inches": "in",
    "ftus": "sft", "us-ft": "sft", "usft": "sft", "us survey ft": "sft", "us survey foot": "sft",
    "us survey feet": "sft", "survey ft": "sft", "survey feet": "sft",
}  # fmt: skip
_FEET_INCHES = re.compile(
    r"(?P<feet>[0-9]+(?:\.[0-9]*)?) ?(?:'|′|’|ft) ?-? ?"
    r"(?P<inches>[0-9]+(?:\.[0-9]*)?) ?(?:\"|″|”|''|in)(?P<rest>(?: .*|±.*)?)"
)
# seconds of arc and inches have one sign
_DEGREES_MINUTES = re.compile(
    r"(?P<sign>[+-]?)(?P<degrees>[0-9]+) ?(?:°|deg) ?(?P<minutes>[0-9]+(?:\.[0-9]*)?) ?['′’]"
    r"(?: ?(?P<seconds>[0-9]+(?:\.[0-9]*)?) ?(?:\"|″|”|''))?(?P<rest>(?: .*|±.*)?)"
)
_FRACTION = re.compile(
    r"([0-9]+)[ -]([0-9]{1,2})/([1-9][0-9]?)(?= ?(?:[\"″”'′’]|ft|in|feet)(?![A-Za-z]))"
)
_RANGE = re.compile(rf"{_NUMBER} ?{_UNIT} ?(?:to|–|—) ?{_NUMBER} ?{_UNIT}")
# a hyphen is a range between bare numbers, or with spaces about it: 0.5 rad s-1 has a power
_HYPHEN = re.compile(
    rf"{_NUMBER}()-{_NUMBER} ?{_UNIT}|{_NUMBER} ?([A-Za-z/%°]*) - {_NUMBER} ?{_UNIT}"
)
# N 45° E, SW, due north, bearing 135 deg: where +y is north
_QUADRANT = re.compile(
    r"(?P<from>[NSns]) ?(?:(?P<angle>[0-9]+(?:\.[0-9]*)?) ?(?:°|deg)? ?)?(?P<to>[EeWw])"
    r"(?P<rest> ?±.*)?"
)
_BEARING = re.compile(
    r"bearing (?P<angle>[0-9]+(?:\.[0-9]*)?) ?(?:°|deg(?:rees?)?)?(?P<rest> ?±.*)?", re.IGNORECASE
)
_COMPASS = re.compile(r"(?:due )?(?P<point>north|east|south|west)(?P<rest> ?±.*)?", re.IGNORECASE)
_POINTS = {"north": 90.0, "east": 0.0, "south": -90.0, "west": 180.0}
_BOUND = re.compile(rf"(?P<words>[A-Za-z ]{{2,20}}|[<>~≤≥≈]) ?(?P<rest>{_NUMBER}.*)")
_SPELLINGS = ((r"°", "deg"), (r"²", "^2"), (r"³", "^3"), (r"[·⋅]", "*"))
_HINTS = {"lbf": ' (pounds of mass are "lb")', "kgf": ' (kilograms of mass are "kg")'}


def read_quantity(raw: object, dimension: Dimension, example: str) -> Reading:
    """A quantity from a TOML value.

    Args:
        raw: text ("45 ± 2 mph", "1857 kg ± 2 %", "5' 1.5\"", "21 to 24 mph"), a table with value, sd,
            unit and source, or a bare number for a dimensionless quantity. ± is one standard deviation;
            a range is its middle with the standard deviation of a uniform distribution between its ends.
        dimension: dimension that the quantity must have.
        example: example of a written quantity, for messages.

    Returns:
        Value and standard deviation in SI units or radians.

    Raises:
        QuantityError: it is malformed, has no unit or a wrong one, or is not finite.
    """
    if isinstance(raw, str):
        reading = _read_text(raw, dimension, example)
    elif isinstance(raw, dict):
        reading = _read_table(raw, dimension)
    elif isinstance(raw, bool) or not isinstance(raw, int | float):
        raise QuantityError(f'not a quantity; write it like "{example}"')
    elif dimension.units:
        raise QuantityError(_no_unit(dimension, shown(raw)))
    else:
        reading = Reading(_number(raw), None, "")
    if not math.isfinite(reading.value):
        raise QuantityError(f'not a finite number; write it like "{example}"')
    if reading.sd is not None and not 0 < reading.sd < math.inf:
        raise QuantityError("the uncertainty (one standard deviation) must be a number above 0")
    return reading


def factor(unit: str, dimension: Dimension) -> float:
    """How many SI units (or radians) a unit is worth.

    Args:
        unit: unit as people write it ("km/h", "kg·m²").
        dimension: dimension that the unit must have.

    Returns:
        The factor from the unit to SI.

    Raises:
        QuantityError: the unit is unknown or measures something else.
    """
    if not dimension.units:
        raise QuantityError("a plain number: write it without a unit")
    text = unit.strip()
    for pattern, spelling in _SPELLINGS:
        text = re.sub(pattern, spelling, text)
    text = _ALIASES.get(text.lower(), text)
    text = re.sub(r"(?<=[A-Za-z0-9])-(?=[A-Za-z])", "*", text)  # lb-ft-s^2
    text = re.sub(r"([A-Za-z])(-?[0-9])", r"\1^\2", text)  # m2, s-1
    text = _ALIASES.get(text.lower(), text)
    text = next((name for name in dimension.units if name.lower() == text.lower()), text)
    if text in dimension.units:
        return _WORTH[text]
    worth = _base(text)
    if worth is None:
        raise QuantityError(f"unknown unit {shown(unit)}; {_unit_hint(unit, dimension)}")
    _, expected = _base(dimension.units[0]) or (1.0, None)
    if worth[1] != expected and dimension in (INERTIA, ENERGY):
        # the pound of lb·ft·s² and of ft·lb is a force
        worth = _base(re.sub(r"\b(?:lbs?|pounds?)\b", "lbf", text)) or worth
    if worth[1] != expected:
        raise QuantityError(
            f"{shown(unit)} does not measure {dimension.phrase}; {_unit_hint(unit, dimension)}"
        )
    return worth[0]


def in_unit_of(raw: object, value: float, dimension: Dimension) -> str:
    """A value in the unit that a file uses there, or in the dimension's first unit where it has none.

    Args:
        raw: quantity as the file has it, of the same dimension.
        value: value to be printed, in SI units or radians.
        dimension: dimension of both.
    """
    written = raw.get("unit") if isinstance(raw, dict) else None
    if isinstance(raw, str) and (match := _parsed(raw)[1]):
        written = match[2] or match[5]
    unit = str(written or _unit(dimension))
    rounded = float(f"{value / (factor(unit, dimension) if unit else 1.0):.4g}")
    return f"{rounded:.12g} {unit}".rstrip()


def _parsed(raw: str) -> tuple[str, re.Match[str] | None]:
    """A text in plain spaces and signs, and its value, unit, sd, percent sign and unit of the sd."""
    text = " ".join(raw[: _TEXT_LENGTH + 1].split()).replace("\N{MINUS SIGN}", "-")
    text = _FRACTION.sub(lambda m: f"{int(m[1]) + int(m[2]) / int(m[3]):.12g}", text)
    if match := _DEGREES_MINUTES.fullmatch(text):
        parts = [float(match[part] or 0) for part in ("degrees", "minutes", "seconds")]
        angle = parts[0] + parts[1] / 60 + parts[2] / 3600
        text = f"{match['sign']}{angle:.12g} deg{match['rest']}"
    if match := _FEET_INCHES.fullmatch(text):
        text = f"{float(match['feet']) + float(match['inches']) / 12:.12g} ft{match['rest']}"
    text = re.sub(r"^\N{EN DASH}(?=[0-9.])", "-", text)
    return text, _QUANTITY.fullmatch(text) if len(raw) <= _TEXT_LENGTH else None


def _read_text(raw: str, dimension: Dimension, example: str) -> Reading:
    bearing = " ".join(raw[:_TEXT_LENGTH].split())
    if dimension is DIRECTION and (angle := _from_bearing(bearing)):
        reading = _read_text(angle, ANGLE, example)
        return Reading(reading.value, reading.sd, f"{bearing}, where +y is north")
    text, match = _parsed(raw)
    if ends := _RANGE.fullmatch(text) or _HYPHEN.fullmatch(text):
        return _read_range(ends, dimension)
    if match is None:
        if text.isprintable():  # what follows a bound's words is quoted
            _refuse_words(text, dimension)
        comma = " with a decimal point, no comma" if re.search(r"[0-9],[0-9]", text) else ""
        raise QuantityError(f'not a quantity; write it{comma} like "{example}"')
    value, unit, sd, percent, sd_unit = match.groups()
    if percent and dimension.units == ("%",):  # the unit of both, and not of the value
        unit, percent = percent, None
    unit, sd_unit = unit or sd_unit, sd_unit or unit
    if unit is None and dimension.units:
        raise QuantityError(_no_unit(dimension, text))
    worth = factor(unit, dimension) if unit else 1.0
    worth_sd = factor(sd_unit, dimension) if sd_unit else 1.0
    si = float(value) * worth
    if sd is None:
        return Reading(si, None, "")
    return Reading(si, abs(si) * float(sd) / 100 if percent else float(sd) * worth_sd, "")


def _refuse_words(text: str, dimension: Dimension) -> None:
    """Refuse a bearing where none is meant, and a bound, each with the way to write it."""
    if dimension is ANGLE and _from_bearing(text):
        raise QuantityError(
            "a compass bearing, where an angle counter-clockwise from something else is meant; write it "
            "in deg"
        )
    if found := _BOUND.fullmatch(text):
        words, rest = found["words"].strip().lower(), found["rest"]
        if words in ("at most", "up to", "under", "below", "less than", "<", "≤"):
            raise QuantityError(f'a bound; write it as a range, like "0 to {rest}"')
        if words in ("at least", "over", "above", "more than", ">", "≥"):
            raise QuantityError(
                f'a bound; write it as a range with its upper end, like "{rest} to …"'
            )
        if words in ("about", "approx", "around", "roughly", "circa", "ca", "~", "≈"):
            raise QuantityError(
                f'write how far off it may be, one standard deviation: "{rest} ± …"'
            )


def _from_bearing(text: str) -> str:
    """The angle from the x axis, as text, of a compass bearing; empty for what is none."""
    if found := _COMPASS.fullmatch(text):
        angle = _POINTS[found["point"].lower()]
    elif found := _BEARING.fullmatch(text):
        angle = math.remainder(90 - float(found["angle"]), 360)
    elif found := _QUADRANT.fullmatch(text):
        off = float(found["angle"] or 45)  # from north or south, towards east or west
        north, east = found["from"] in "Nn", found["to"] in "Ee"
        angle = (90 - off if east else 90 + off) if north else (off - 90 if east else -90 - off)
        if off > 90:
            raise QuantityError("a bearing within a quadrant is at most 90 deg from north or south")
    else:
        return ""
    return f"{angle:.12g} deg{found['rest'] or ''}"


def _read_range(found: re.Match[str], dimension: Dimension) -> Reading:
    text, groups = found[0], found.groups()
    low, low_unit, high, high_unit = groups[:4] if groups[0] is not None else groups[4:]
    low_unit, high_unit = low_unit or None, high_unit or None
    low_unit, high_unit = low_unit or high_unit, high_unit or low_unit
    if low_unit is None and dimension.units:
        raise QuantityError(_no_unit(dimension, text))
    ends = [
        float(end) * (factor(unit, dimension) if unit else 1.0)
        for end, unit in ((low, low_unit), (high, high_unit))
    ]
    if not ends[0] < ends[1]:
        raise QuantityError("a range begins with its smaller end")
    source = f"{text}, read as uniform in between: its middle ± half its width over √3"
    return Reading(sum(ends) / 2, (ends[1] - ends[0]) / math.sqrt(12), source)


def _read_table(raw: dict[str, object], dimension: Dimension) -> Reading:
    keys = ("value", "sd", "unit", "source")
    for key in raw:
        if key not in keys:
            near = difflib.get_close_matches(key.lower(), keys, 1)
            instead = f'did you mean "{near[0]}"?' if near else 'one standard deviation is "sd"'
            raise QuantityError(
                f"unknown key; {instead} (a quantity has value, sd, unit, source)", key=key
            )
    if "value" not in raw:
        raise QuantityError(f'no value; write {{value = 45, sd = 2, unit = "{_unit(dimension)}"}}')
    for key in ("value", "sd"):
        if key in raw and (isinstance(raw[key], bool) or not isinstance(raw[key], int | float)):
            raise QuantityError(f"write a number, without quotes: {key} = 2.5", key=key)
    for key in ("unit", "source"):
        text = raw.get(key, "")
        if not isinstance(text, str) or len(text) > 200 or not text.isprintable():
            raise QuantityError("write one short line of text in quotes", key=key)
    unit = str(raw.get("unit", ""))
    if not unit and dimension.units:
        raise QuantityError(f"no unit; add unit = {_either([f'"{u}"' for u in dimension.units])}")
    try:
        worth = factor(unit, dimension) if unit else 1.0
    except QuantityError as fault:
        raise QuantityError(fault.fix, key="unit") from None
    sd = _number(raw["sd"]) * worth if "sd" in raw else None
    return Reading(_number(raw["value"]) * worth, sd, str(raw.get("source", "")))


def _number(raw: object) -> float:
    assert isinstance(raw, int | float)
    try:
        return float(raw)
    except OverflowError:
        return math.inf


@cache
def _registry() -> UnitRegistry:
    import pint  # here, because it takes most of a second, and few scenes need it

    return pint.UnitRegistry()


@lru_cache(maxsize=256)
def _base(unit: str) -> tuple[float, object] | None:
    """A unit's worth in base units and those units, or None for a unit that nobody knows.

    Base units are compared rather than dimensions, because to pint an angle has no dimension.
    """
    if not _SAFE_UNIT.fullmatch(unit):
        return None
    registry = _registry()
    try:
        worth, base = registry.get_base_units(registry.parse_units(unit))
        return cast(float, worth), base
    except Exception:  # pint raises many kinds: its own, ValueError, TypeError, tokenize's
        return None


def _no_unit(dimension: Dimension, text: str) -> str:
    first, *others = dimension.units
    others_too = f" (or in {_either(others)})" if others else ""
    return f'no unit; write "{text} {first}"{others_too}'


def _unit_hint(unit: str, dimension: Dimension) -> str:
    known = {name.lower(): name for name in dimension.units}
    near = difflib.get_close_matches(unit.strip().lower(), known, 1, 0.5)
    force = next((hint for name, hint in _HINTS.items() if name in unit), "")
    if near:
        return f'did you mean "{known[near[0]]}"?{force}'
    return f"write it in {_either(dimension.units)}{force}"


def _unit(dimension: Dimension) -> str:
    return dimension.units[0] if dimension.units else ""


def _either(words: list[str] | tuple[str, ...]) -> str:
    return " or ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]
