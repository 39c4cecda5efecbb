"""A scene in Python: built from keyword arguments, changed key by key, by the scene file's schema."""

from __future__ import annotations

import re
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from typing import Any

from retrodict.scene.errors import Problem, SceneError, key_path, shown
from retrodict.scene.load import scene_from, tables_of
from retrodict.scene.priors import OF_PYTHON, default_priors
from retrodict.scene.records import Scene
from retrodict.scene.write import CANNOT_SAY, document_toml, scene_text

_PART = re.compile(r"""(?:^|\.)(?:([A-Za-z0-9_-]+)|"([^"\\]*)"|'([^']*)')|\[([0-9]{1,4})\]""")

Part = str | int  # part of a key: the name of a table or key, or the place in a list


def build_scene(name: str = "scene", **tables: object) -> Scene:
    """A scene from keyword arguments: the tables and keys of a scene file.

    Args:
        name: short identifier, used to name output; it stands for the file in messages.
        tables: title, vehicles, impact, surfaces and whatever else a scene file has, see
            docs/scene-file.md; schema may be left out. A quantity is text ("45 ± 2 mph"), a table
            ({"value": 45, "sd": 2, "unit": "mph"}), a pint quantity or measurement, a table whose value
            (and sd) is a pint quantity, or a number if it has no unit. None counts as not written.

    Returns:
        The scene in SI units and radians, with the text of a scene file that says the same.

    Raises:
        SceneError: something in it is wrong; the messages are those of a scene file.

    Examples:
        >>> import retrodict as rd
        >>> car = {"mass": "1500 ± 30 kg", "wheelbase": "2.7 m", "track": "1.5 m"}
        >>> car["impact_centre"] = {"distance": "2 m", "angle": "20 deg"}
        >>> rest_a = {"position": ["0.4 m", "2.6 m"], "heading": "222 deg"}
        >>> rest_b = {"position": ["-0.9 m", "-2.1 m"], "heading": "35 deg"}
        >>> a = car | {"impact": {"heading": "180 deg"}, "rest": rest_a}
        >>> a["approach"] = {"speed": "20 ± 2 mph"}
        >>> b = car | {"impact": {"heading": "0 deg"}, "rest": rest_b}
        >>> scene = rd.build_scene(
        ...     title="A crossed the centre line",
        ...     vehicles={"A": a, "B": b},
        ...     impact={"point": ["0 m", "0 m"], "contact_line": "10 ± 5 deg"},
        ...     surfaces={"road": {"kind": "dry asphalt"}},
        ... )
        >>> scene.vehicles["b"].mass.value, scene.vehicles["b"].mass.sd  # kg
        (1500.0, 30.0)
    """
    return _scene({"schema": 1} | _plain(tables), name)


def change(scene: Scene, changes: Mapping[str, object]) -> Scene:
    """A copy of a scene with other values at some keys of its scene file.

    Args:
        scene: measured scene, which stays as it is.
        changes: new values by dotted key of the scene file ("vehicles.A.approach.speed",
            "impact.point[0]"), each as in `build_scene`: a quantity, a word, or a whole table or list.
            None removes the key. A source beside a changed value is removed, unless it is written anew.

    Returns:
        The changed scene, with the text of a scene file that says the same: all other keys as they
        were written, without the file's comments.

    Raises:
        SceneError: a key cannot be found, or something is wrong with what the scene now says.
    """
    own = {name: prior for name, prior in scene.priors.items() if prior.family == OF_PYTHON}
    if own or scene.extra:  # given in Python: changes of the scene file leave them as they are
        default = {name: prior for name, prior in default_priors().items() if name in own}
        bare = replace(scene, priors=scene.priors | default, extra={})
        changed = change(bare, changes)
        return replace(changed, priors=changed.priors | own, extra=scene.extra)
    found = scene_text(scene)
    if found.text != scene.text and found.text.startswith(CANNOT_SAY):
        unsaid = found.text.split("\n")[0].removeprefix(CANNOT_SAY).rstrip(".")
        fix = f"cannot be changed by key, for a scene file cannot say {unsaid}; change its record"
        raise SceneError(scene.name, [Problem("", "", fix)])
    document = deepcopy(tables_of(found.text, scene.name))
    write_keys(document, {key: _plain(value) for key, value in changes.items()}, scene.name)
    changed = _scene(document, scene.name)
    if any(_parts(scene.name, key)[0] == "questions" for key in changes):
        return changed
    return replace(changed, questions=scene.questions)  # an option may have added some


def write_keys(document: dict[str, Any], changes: Mapping[str, Any], name: str) -> None:
    """Write values at keys of a scene file's tables.

    Args:
        document: the tables and keys, which are changed.
        changes: new values by dotted key, as in `change`, each in the form that TOML has.
        name: name of the scene or its file, for messages.

    Raises:
        SceneError: a key cannot be found.
    """
    written = {_parts(name, key): value for key, value in changes.items()}
    for parts, value in written.items():
        _write(document, parts, value, written, name)


def to_toml(scene: Scene) -> str:
    """The text of a scene file that describes a scene.

    Args:
        scene: measured scene.

    Returns:
        TOML: the file as it was written where it still describes the scene, else a text made from the
        scene. Reports attach this text.
    """
    return scene_text(scene).text


def _scene(document: dict[str, Any], name: str) -> Scene:
    scene = scene_from(document, name, "", name)
    text = document_toml(document)
    tables_of(text, name)  # refuses what is too long to be read again
    return replace(scene, text=text)


def _parts(name: str, key: object) -> tuple[Part, ...]:
    """The parts of a dotted key: names of tables and keys, and places in lists."""
    parts: list[Part] = []
    end = 0
    while isinstance(key, str) and end < len(key):
        match = _PART.match(key, end)
        if match is None or (match[4] and not parts):
            break
        parts.append(
            int(match[4]) if match[4] else next(m for m in match.groups() if m is not None)
        )
        end = match.end()
    if not isinstance(key, str) or not key or end < len(key):
        fix = 'not a key; write it like "vehicles.A.approach.speed" or "impact.point[0]"'
        raise SceneError(name, [Problem(shown(key), "", fix)])
    return tuple(parts)


def _write(
    document: dict[str, Any],
    parts: tuple[Part, ...],
    value: Any,
    written: Mapping[tuple[Part, ...], Any],
    name: str,
) -> None:
    """Write a value at a key of a document; None removes the key."""

    def refuse(depth: int, fix: str) -> SceneError:
        return SceneError(name, [Problem(key_path(parts[: depth + 1]), "", fix)])

    inner: Any = document
    for depth, part in enumerate(parts):
        above = parts[:depth]
        if isinstance(part, int):
            count = len(inner) if isinstance(inner, list) else 0
            if part >= count:
                raise refuse(depth, f"not in the scene, which has {count} there; write all of them")
        elif not isinstance(inner, dict):
            raise refuse(depth, f"{key_path(above)} is not a table; write all of it")
        else:
            _as_spelled(inner, above, part)
            if part != "source" and (*above, "source") not in written:
                inner.pop("source", None)  # the source of the value that is replaced
        if depth + 1 < len(parts):
            inner = inner.setdefault(part, {}) if isinstance(inner, dict) else inner[part]
    if value is not None:
        inner[part] = value
    elif isinstance(part, int) or part in inner:
        del inner[part]
    else:
        raise refuse(depth, "not written in the scene, so it cannot be removed")


def _as_spelled(table: dict[str, Any], above: tuple[Part, ...], part: str) -> None:
    """Spell a vehicle's letter in the tables as a key spells it, A or a."""
    if above == ("vehicles",) and part not in table and part.swapcase() in table:
        renamed = {part if key == part.swapcase() else key: each for key, each in table.items()}
        table.clear()
        table.update(renamed)  # in the same order


def _plain(value: Any) -> Any:
    """A value in the form that TOML has; any other stays as it is, for the schema to refuse."""
    if isinstance(value, Mapping):
        return _plain_table(value)
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if hasattr(value, "magnitude") and hasattr(
        value, "units"
    ):  # pint's, which is not imported here
        return _of_pint(value)
    if hasattr(value, "nominal_value") and hasattr(
        value, "std_dev"
    ):  # of the package uncertainties
        return {"value": value.nominal_value, "sd": value.std_dev}
    if hasattr(value, "tolist"):  # NumPy's
        return value.tolist()
    return value


def _plain_table(table: Mapping[Any, Any]) -> dict[str, Any]:
    plain = {str(key): _plain(each) for key, each in table.items() if each is not None}
    quantity, sd = plain.get("value"), table.get("sd", 0.0)
    if isinstance(quantity, dict):  # the value is a quantity of pint; the sd may be one
        if hasattr(sd, "magnitude"):
            try:
                plain["sd"] = _plain(sd.to(table["value"].units).magnitude)
            except Exception:  # pint's, for units of something else: the schema refuses a text
                plain["sd"] = str(sd)
        plain = quantity | {key: each for key, each in plain.items() if key != "value"}
    return plain


def _of_pint(quantity: Any) -> dict[str, Any]:
    number = _plain(quantity.magnitude)
    unit = f"{quantity.units:~C}".replace(
        "g_0", "g"
    )  # standard gravity, which is "g" in scene files
    plain = number if isinstance(number, dict) else {"value": number}
    return plain | ({"unit": unit} if unit else {})
