"""Edits of a scene file's text that keep its comments, its order and its spelling."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from retrodict.scene.edit import write_keys
from retrodict.scene.load import toml_of, value_at
from retrodict.scene.units import (
    ANGLE,
    DIRECTION,
    Dimension,
    QuantityError,
    factor,
    in_unit_of,
    read_quantity,
)
from retrodict.scene.write import document_toml

_IN_A_LINE = 12  # items of a list, beyond which each has a line
_SECTIONS = {"vehicles": 2, "surfaces": 2, "priors": 2}  # depth at which tables have a heading
_FINEST = {"length": 1e-3, "angle": math.radians(0.01)}  # m, rad: what a drawing can tell


def edited(text: str, changes: Mapping[str, Any], file: str) -> str:
    """The text of a scene file with other values at some keys.

    Args:
        text: the file as it is written; it need not be complete.
        changes: new values by dotted key, as in `Scene.change`, each in the form that TOML has; None
            removes the key.
        file: name of the file, for messages.

    Returns:
        The new text. Comments, order and everything that no change concerns stay as they were, but
        where the layout cannot be kept: then it is written anew.

    Raises:
        SceneError: a key cannot be found, or the text is too long or not TOML.
    """
    changed = deepcopy(toml_of(text, file))
    write_keys(changed, changes, file)
    new = edited_in_place(text, changes, changed, file) or document_toml(changed)
    toml_of(new, file)  # refuses what is too long to be read again
    return new


def edited_in_place(
    text: str, changes: Mapping[str, Any], changed: Mapping[str, Any], file: str
) -> str:
    """The text of a scene file with changes, its comments kept.

    Args:
        text: the file as it is written.
        changes: new values by dotted key, as in `edited`.
        changed: tables and keys that the new text has to read as.
        file: name of the file, for messages.

    Returns:
        The new text; empty where its layout cannot be kept.
    """
    import tomlkit

    try:
        styled = tomlkit.parse(text)
        write_keys(styled, {key: _item(key, value) for key, value in changes.items()}, file)
        new = tomlkit.dumps(styled)
        if tomllib.loads(new) == changed:
            return new
    except (tomlkit.exceptions.TOMLKitError, ValueError, TypeError, AttributeError):
        pass
    return ""


def in_missing_tables(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Changes of which those that need the same missing table are one: the whole table.

    Args:
        document: tables and keys of a scene file.
        changes: new values by key, whose parts have no dots of their own.

    Returns:
        The changes, by the key of the outermost missing table below a vehicle, a surface or a section.
    """
    found: dict[str, Any] = {}
    for key, value in changes.items():
        parts = key.split(".")
        depth = _SECTIONS.get(parts[0], 1)
        cut = next(
            (
                i
                for i in range(depth, len(parts))
                if value_at(document, ".".join(parts[:i])) is None
            ),
            len(parts),
        )
        if value is None or cut == len(parts):
            found[key] = value
            continue
        table = found.setdefault(".".join(parts[:cut]), {})
        for part in parts[cut:-1]:
            table = table.setdefault(part, {})
        table[parts[-1]] = value
    return found


def emptied(document: Mapping[str, Any], key: str) -> str:
    """The key to remove so that no empty table stays where another key is removed.

    Args:
        document: tables and keys of a scene file.
        key: key to remove, whose parts have no dots of their own.

    Returns:
        The key, or that of the outermost table below a vehicle, a surface or a section that has nothing
        else.
    """
    parts = key.split(".")
    while len(parts) > _SECTIONS.get(parts[0], 1) + 1:
        table = value_at(document, ".".join(parts[:-1]))
        if not isinstance(table, dict) or len(table) > 1 or parts[-1] not in table:
            break
        parts.pop()
    return ".".join(parts)


def rewritten(
    raw: object,
    value: float,
    dimension: Dimension,
    sd: float | None = None,
    *,
    whole_turns: bool = False,
) -> object:
    """A quantity as a file writes it, with another value.

    Args:
        raw: quantity as it is written; None for none.
        value: new value, SI units or radians.
        dimension: dimension of both.
        sd: new standard deviation; None for the one that is written.
        whole_turns: whether angles that differ by whole turns are different.

    Returns:
        The quantity in the form and the unit that were written, to a millimetre or a hundredth of a
        degree, without the source that the old value had; as it was, where the value is the same.
    """
    example = f"1 {dimension.units[0]}" if dimension.units else "1"
    try:
        before = read_quantity(raw, dimension, example)
    except QuantityError:
        raw, before = None, None
    unit = in_unit_of(raw, 1.0, dimension).partition(" ")[2]
    worth = factor(unit, dimension) if unit else 1.0
    finest = _FINEST.get(dimension.name, 0.0)
    digits = max(0, math.ceil(-math.log10(finest / worth) - 1e-9)) if finest else 6
    off = value - before.value if before else math.inf
    if dimension in (ANGLE, DIRECTION) and before and not whole_turns:
        off = math.remainder(off, math.tau)
    if before and sd is None and abs(off) <= finest / 2:
        return raw
    number = round(value / worth, digits) + 0.0  # no minus before 0
    spread = sd if sd is not None else before.sd if before else None
    if isinstance(raw, dict):
        table: dict[str, Any] = {"value": number}
        if spread:
            table["sd"] = (
                raw["sd"] if sd is None and "sd" in raw else float(f"{spread / worth:.4g}")
            )
        return table | ({"unit": unit} if unit else {})
    said = f"{number:.12g}"
    if spread:
        said += f" ± {spread / worth:.4g}"
    return f"{said} {unit}".rstrip()


def _item(key: str, value: Any) -> Any:
    """A value as an item of tomlkit: a section where the key is one, else `in_line`."""
    parts = key.split(".")
    if isinstance(value, dict) and len(parts) == _SECTIONS.get(parts[0], 1):
        import tomlkit

        table = tomlkit.table()
        table.update({inner: in_line(each) for inner, each in value.items()})
        return table
    return in_line(value)


def in_line(value: Any, nested: bool = False) -> Any:
    """A value as an item of tomlkit: tables in a line, a list of tables one a line."""
    import tomlkit

    if value is None:
        return None
    if isinstance(value, dict):
        table = tomlkit.inline_table()
        table.update({key: in_line(each, nested=True) for key, each in value.items()})
        return table
    if isinstance(value, list):
        array = tomlkit.array()
        array.extend(in_line(each, nested=True) for each in value)
        tables = not nested and any(isinstance(each, dict) for each in value)
        array.multiline(tables or len(value) > _IN_A_LINE)
        return array
    return tomlkit.item(value)
