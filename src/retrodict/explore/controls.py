"""The quantities of a scene that sliders change: generated from what a scene file may say."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, get_args

from pydantic import BaseModel

from retrodict.inference.digits import decimals_of
from retrodict.scene.energy import ENERGY
from retrodict.scene.entries.priors import PriorsEntry
from retrodict.scene.fields import AFTER, COEFFICIENTS
from retrodict.scene.kinds import Kind
from retrodict.scene.load import toml_of, value_at
from retrodict.scene.priors import keys_of
from retrodict.scene.records import Measured, Scene
from retrodict.scene.schema import validated
from retrodict.scene.units import (
    ANGLE,
    DIRECTION,
    LENGTH,
    QuantityError,
    factor,
    in_unit_of,
    read_quantity,
)
from retrodict.scene.write import scene_text, scene_toml

GROUPS = ("Vehicle A", "Vehicle B", "Impact", "Surfaces", "Evidence", "Priors")
_EVIDENCE = ("rest", "marks", *(own.table for own in AFTER.values()))
# a vehicle's size, which is for drawing alone; its rotation, which only selects a number of whole turns;
# and an outline's up to two hundred coordinates, any of which may spoil the outline where it moves far
_NOT_MOVED = ("length", "width", "rotation", "corners")
_REACH = 4.0  # standard deviations to either side
_STEPS = 160  # of a slider
_SHARE = 0.2  # of a positive value without an uncertainty, to either side
_WITHOUT = {
    LENGTH: 1.0,
    ANGLE: math.radians(5),
    DIRECTION: math.radians(5),
}  # of a coordinate or direction without one: m, rad
_CHANGED = "changed on the page of retrodict explore"  # the source of a prior
_OCTAVES = 2.0  # a factor of four to either side, for an uncertainty or the scale of a prior


@dataclass(frozen=True, slots=True)
class Control:
    """A quantity of a scene file that can be changed.

    Args:
        key: dotted, as `Scene.change` takes it.
        group: name of the control's group, in `GROUPS`.
        label: key in words, without the part that the group says.
        unit: unit as in the file, or that of `kind.example` where none is written; empty for a plain
            number.
        written: value as written in the file; None where the quantity has a default.
        source: source of the measurement or of the default.
        value: value of the quantity, in `unit`.
        sd: standard deviation, in `unit`; 0 where there is none.
        span: least and greatest value of the slider.
        by_factor: whether the slider moves by factors, and not by differences.
        takes_sd: whether an uncertainty may be written.
        also: further values that have to be written with the quantity, by key.
        kind: kind of value that the schema accepts there.
    """

    key: str
    group: str
    label: str
    unit: str
    written: object
    source: str
    value: float
    sd: float
    span: tuple[float, float]
    by_factor: bool
    takes_sd: bool
    also: Mapping[str, object]
    kind: Kind

    @property
    def step(self) -> float:
        """Step of the slider: in `unit`, or in the logarithm to base 2 of the factor."""
        low, high = self.slider_range
        return (high - low) / _STEPS

    @property
    def slider_range(self) -> tuple[float, float]:
        """Least and greatest position of the slider."""
        return (-_OCTAVES, _OCTAVES) if self.by_factor else self.span

    def position(self, value: float) -> float:
        """The slider's position at a value, at an end where the value lies beyond."""
        low, high = self.slider_range
        at = math.log2(value / self.value) if self.by_factor and value > 0 else value
        return min(max(at, low), high)

    def value_at(self, position: float) -> float:
        """The value at a slider's position, rounded to the slider's steps."""
        if self.by_factor:
            return float(f"{min(max(self.value * 2**position, self.span[0]), self.span[1]):.3g}")
        return round(position, max(decimals_of(self.step, 1) or 0, 0))

    def sd_position(self, sd: float) -> float:
        """The position of the uncertainty's slider, at an end where the uncertainty lies beyond."""
        return min(max(math.log2(sd / self.sd), -_OCTAVES), _OCTAVES) if sd > 0 else -_OCTAVES

    def sd_at(self, position: float) -> float:
        """The uncertainty at a position of its slider: the file's, times 2 to that power."""
        return float(f"{self.sd * 2**position:.3g}") if position else self.sd

    def text(self, value: float | None = None, sd: float | None = None) -> str:
        """The quantity as it is written in a scene file.

        Args:
            value: value in the control's unit; None for the file's.
            sd: standard deviation in the control's unit; 0 for none, None for the file's.
        """
        value, sd = self.value if value is None else value, self.sd if sd is None else sd
        number = f"{value:.10g}"
        if sd and self.takes_sd:
            number += f" ± {sd:.4g}"
        return f"{number} {self.unit}".rstrip()

    def read(self, text: str) -> tuple[float, float]:
        """Value and standard deviation (0 where none is written) of a text, in the control's unit.

        Raises:
            QuantityError: the text is no quantity.
        """
        found = read_quantity(text, self.kind.dimension, self.kind.example)
        worth = factor(self.unit, self.kind.dimension) if self.unit else 1.0
        return found.value / worth, (found.sd or 0.0) / worth

    def changes(self, text: str) -> dict[str, object]:
        """Changes for `Scene.change` by a text: the file's own value where the text says the same."""
        if self.written is not None and text == self.text():
            return {self.key: self.written}
        return {self.key: text, **self.also}


def controls(scene: Scene) -> tuple[Control, ...]:
    """Everything measured or assumed in a scene that has a number.

    Args:
        scene: measured scene.

    Returns:
        The controls by group, in the order of a scene file.
    """
    written = toml_of(scene_text(scene).text, scene.name)
    # a file made from the scene has its defaults too
    every = validated(toml_of(scene_toml(scene), scene.name))
    found = [
        _control(key, kind, measured, in_file)
        for key, kind, measured in _quantities(every, "")
        if not key.startswith("priors.") and key.rpartition(".")[2].split("[")[0] not in _NOT_MOVED
        # what is neither measured nor uncertain is left alone
        if (in_file := value_at(written, key)) is not None or measured.sd
    ]
    found += _priors(scene, written)
    moving = [each for each in found if each is not None]
    return tuple(sorted(moving, key=lambda each: GROUPS.index(each.group)))


def _quantities(table: BaseModel, path: str) -> Iterator[tuple[str, Kind, Measured]]:
    """Key, kind and value of every quantity in a table and in those below it."""
    for name, field in type(table).model_fields.items():
        value = getattr(table, name)
        annotation = (field.annotation, *field.metadata)
        yield from _in(value, f"{path}{name}", _kind(annotation))


def _in(value: object, key: str, kind: Kind | None) -> Iterator[tuple[str, Kind, Measured]]:
    if isinstance(value, Measured) and kind:
        yield key, kind, value
    elif isinstance(value, BaseModel):
        yield from _quantities(value, f"{key}.")
    elif isinstance(value, dict):
        for name, each in value.items():
            yield from _in(each, f"{key}.{name}", kind)
    elif isinstance(value, list | tuple):
        for i, each in enumerate(value):
            yield from _in(each, f"{key}[{i}]", kind)


def _kind(annotation: Any) -> Kind | None:
    """The first kind in an annotation, or in the parts of one."""
    if isinstance(annotation, Kind):
        return annotation
    parts = annotation if isinstance(annotation, tuple) else get_args(annotation)
    return next((kind for kind in map(_kind, parts) if kind), None)


def _control(
    key: str,
    kind: Kind,
    measured: Measured,
    written: object,
    also: Mapping[str, object] | None = None,
) -> Control | None:
    dimension, takes_sd = kind.dimension, kind.uncertainty != "refused"
    unit = in_unit_of(written or kind.example, 1.0, dimension).partition(" ")[2]
    worth = factor(unit, dimension) if unit else 1.0
    first = factor(dimension.units[0], dimension) if dimension.units else 1.0
    low, high = kind.low * first / worth, kind.high * first / worth
    value, sd = measured.value, measured.measured_sd if takes_sd else 0.0
    with suppress(
        QuantityError
    ):  # words have no number, and headings are as written, not unwrapped
        value = read_quantity(written, dimension, kind.example).value
    value, sd = value / worth, sd / worth
    if not low <= value <= high:
        return None
    by_factor = not takes_sd and low >= 0 and value > 0
    if by_factor:
        around = (value / 2**_OCTAVES, value * 2**_OCTAVES)
    elif sd or low >= 0:
        reach = _REACH * sd or _SHARE * abs(value)
        around = (value - reach, value + reach)
    else:
        reach = _WITHOUT.get(dimension, math.inf) / worth
        around = (value - reach, value + reach)
    group, label = _group(key)
    return Control(
        key=key,
        group=group,
        label=label,
        unit=unit,
        written=written,
        source=measured.source,
        value=float(f"{value:.10g}"),
        sd=float(f"{sd:.6g}"),
        span=(max(around[0], low), min(around[1], high)),
        by_factor=by_factor,
        takes_sd=takes_sd,
        also=also or {},
        kind=kind,
    )


def _priors(scene: Scene, written: Mapping[str, Any]) -> Iterator[Control | None]:
    for name, field in PriorsEntry.model_fields.items():
        table = next(t for t in get_args(field.annotation) if issubclass(t, BaseModel))
        if name == "speed_a" and scene.approach["a"].speed is not None:
            continue  # measured, so that its prior has no part in the model
        prior = scene.priors[name]
        if prior.family and value_at(written, f"priors.{name}") is None:
            continue  # fixed by impact.NAME
        for key, number in zip(keys_of(name, prior), prior.numbers, strict=True):
            entry = table.model_fields[key]
            kind = _kind((entry.annotation, *entry.metadata))
            assert kind
            path = f"priors.{name}.{key}"
            also = {} if prior.overridden else {f"priors.{name}.source": _CHANGED}
            yield _control(
                path, kind, Measured(number, source=prior.source), value_at(written, path), also
            )


def _group(key: str) -> tuple[str, str]:
    first, _, rest = key.partition(".")
    match first:
        case "vehicles":
            v, _, inner = rest.partition(".")
            if re.split(r"[.\[]", inner)[0] in _EVIDENCE:
                return "Evidence", f"{v}: {_words(inner)}"
            return f"Vehicle {v}", _words(inner)
        case "impact":
            return "Evidence" if rest in (*ENERGY, *COEFFICIENTS) else "Impact", _words(rest)
        case "surfaces":
            return "Surfaces", _words(rest)
        case "slope":
            return "Surfaces", _words(key)
    return "Priors", _words(rest)


def _words(key: str) -> str:
    """A key in words: "rest.position[0]" is "rest position x"."""
    for index, axis in (("[0]", " x"), ("[1]", " y")):
        for pair in ("position", "point"):
            key = key.replace(f"{pair}{index}", f"{pair}{axis}")
    key = re.sub(r"marks\[(\d+)\]", lambda m: f"mark {int(m[1]) + 1}", key)
    return key.replace(".", " ").replace("_", " ")
