"""Which keys of the scene file two scenes differ in, each with both values as they are written."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from retrodict.findings.rounding import NOTHING
from retrodict.scene.write import scene_text, scene_toml

if TYPE_CHECKING:
    from retrodict.scene.records import Scene

_WORDS = ("title", "notes", "name", "source")  # keys that change no number
_SAME = 1e-9  # relative difference of two numbers that are the same but for rounding


def changed_keys(one: Scene, other: Scene) -> dict[str, tuple[str, str]]:
    """The keys of the scene file that two scenes differ in, but for words that change no number.

    Args:
        one: a scene.
        other: the scene compared with it.

    Returns:
        Both values by dotted key, such as vehicles.A.approach.speed, as the files have them, in SI
        units where a file does not spell out the key; a dash where a scene has no value.
    """
    before, after = (dict(_leaves(tomllib.loads(scene_toml(scene)))) for scene in (one, other))
    texts = [dict(_leaves(tomllib.loads(scene_text(scene).text))) for scene in (one, other)]
    found = {}
    for key in {**before, **after}:
        if key.rpartition(".")[2].partition("[")[0] in _WORDS or _same(
            before.get(key), after.get(key)
        ):
            continue
        pair = [_text(text.get(key)) for text in texts]
        if NOTHING in pair or pair[0] == pair[1]:  # spelled differently, or not at all
            pair = [_text(each.get(key)) for each in (before, after)]
        found[key] = (pair[0], pair[1])
    return found


def _leaves(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Quantities, words and numbers by dotted key, places in lists counted from 0."""
    if isinstance(value, dict) and "value" not in value:
        for name, each in value.items():
            yield from _leaves(each, f"{key}.{name}" if key else name)
    elif isinstance(value, list):
        for i, each in enumerate(value):
            yield from _leaves(each, f"{key}[{i}]")
    else:
        yield key, value


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, dict) and isinstance(other, dict):
        numbers = [(each["value"], each.get("sd", 0.0)) for each in (one, other)]
        return all(math.isclose(a, b, rel_tol=_SAME) for a, b in zip(*numbers, strict=True))
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=_SAME)
    return bool(one == other)


def _text(value: Any) -> str:
    if value is None:
        return NOTHING
    if not isinstance(value, dict):
        return str(value).lower() if isinstance(value, bool) else str(value)
    numbers = (value[key] for key in ("value", "sd") if key in value)
    text = " ± ".join(
        f"{number:.6g}" if isinstance(number, float) else str(number) for number in numbers
    )
    return f"{text} {value.get('unit', '')}".rstrip()
