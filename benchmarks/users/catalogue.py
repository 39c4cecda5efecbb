"""The scenes and what is known of each: its kind and its right answer."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import NamedTuple

_HERE = Path(__file__).parent
FOLDER = _HERE / "scenes"


class Value(NamedTuple):
    """A right answer.

    Args:
        mean: the value, m/s for a speed.
        sd: its standard deviation; 0 where it is exact.
    """

    mean: float
    sd: float = 0.0


class UserScene(NamedTuple):
    """A scene as a user wrote it.

    Args:
        name: file name without suffix.
        kind: kind of its source.
        truth: right answers by quantity; empty where none is known.
        refused: whether the right answer is a refusal or a flag.
    """

    name: str
    kind: str
    truth: dict[str, Value]
    refused: bool

    @property
    def file(self) -> Path:
        """The scene file."""
        return FOLDER / f"{self.name}.toml"


def scenes() -> dict[str, UserScene]:
    """All scenes by name, in the order of scenes.toml."""
    table = tomllib.loads((_HERE / "scenes.toml").read_text("utf-8"))
    return {
        name: UserScene(
            name,
            entry["kind"],
            {quantity: Value(**value) for quantity, value in entry.get("truth", {}).items()},
            entry.get("refused", False),
        )
        for name, entry in table.items()
    }
