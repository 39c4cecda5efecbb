"""A value that a scene file takes from another program's file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from retrodict.scene.load import value_at


@dataclass(frozen=True, slots=True)
class Taken:
    """A value that a scene file gets.

    Args:
        key: dotted key of the scene file.
        value: value to write at the key, in TOML's types; None removes the key.
        where: place in the source file that the value comes from.
        before: value that the scene file had at the key; None for none.
        remark: note on the value, such as the misfit of its points; empty for none.
    """

    key: str
    value: Any
    where: str
    before: Any = None
    remark: str = ""


def replaced(document: dict[str, Any], key: str) -> Iterator[Taken]:
    """The removal of a key whose place another key takes; nothing where the scene file lacks it."""
    if (before := value_at(document, key)) is not None:
        yield Taken(key, None, "what is taken stands in its place", before)


def quantity(value: float, sd: float | None, unit: str, source: str) -> dict[str, Any]:
    """A quantity as a table of a scene file, to a ten-thousandth of its unit."""
    written: dict[str, Any] = {"value": round(value, 4)}
    if sd:
        written["sd"] = rounded(sd)
    return written | {"unit": unit, "source": source}


def rounded(sd: float) -> float:
    """A standard deviation to three digits."""
    return float(f"{sd:.3g}")
