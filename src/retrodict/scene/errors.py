"""Problems of a scene file, a line each: the file, the key, the value, the fix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

_VALUE_LENGTH = 60
_KEY_LENGTH = 40
_FILE_LENGTH = 200
_LINES = 30


@dataclass(frozen=True, slots=True)
class Problem:
    """A single problem of a file.

    Args:
        key: dotted path of the key ("vehicles.A.mass"); empty for the file as a whole.
        value: the value as written, through `shown`; empty where there is none.
        fix: description of the fault, and advice on the value to write.
    """

    key: str
    value: str
    fix: str

    def __str__(self) -> str:
        said = " = ".join(part for part in (self.key, self.value) if part)
        return f"{said}: {self.fix}" if said else self.fix


class SceneError(Exception):
    """A scene file that cannot be used; `str` gives one line for each problem.

    Args:
        file: the file, as the user named it.
        problems: problems of the file, one or more.
    """

    def __init__(self, file: str, problems: Sequence[Problem]) -> None:
        super().__init__(file, problems)
        self.file = file
        self.problems = tuple(problems)

    def __str__(self) -> str:
        file = clipped(_escaped(self.file[: _FILE_LENGTH + 1]), _FILE_LENGTH)
        lines = [f"{file}: {problem}" for problem in self.problems[:_LINES]]
        if len(self.problems) > _LINES:
            lines.append(f"{file}: and {len(self.problems) - _LINES} problems more")
        return "\n".join(lines)


def shown(value: object) -> str:
    """A user's value as TOML would write it, clipped and with control characters escaped.

    Args:
        value: anything that TOML can hold.

    Returns:
        At most about 60 printable characters.
    """
    return clipped(_written(value, nested=True), _VALUE_LENGTH)


def key_path(parts: Sequence[str | int]) -> str:
    """The dotted path of a key.

    Args:
        parts: names of tables and keys, and places in a list.

    Returns:
        For instance "vehicles.A.rest.position[1]".
    """
    path = ""
    for part in parts:
        if isinstance(part, int):
            path += f"[{part}]"
        else:
            path += ("." if path else "") + clipped(_escaped(part[: _KEY_LENGTH + 1]), _KEY_LENGTH)
    return path


def _written(value: object, nested: bool) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case str():
            return f'"{_escaped(value[: _VALUE_LENGTH + 1])}"'
        case int() if value.bit_length() > 200:  # Python refuses to print the longest
            return "a whole number of more than 60 digits"
        case dict() if nested:
            items = islice(value.items(), 8)
            said = (
                f"{_escaped(str(k)[:_KEY_LENGTH])} = {_written(v, nested=False)}" for k, v in items
            )
            return "{" + ", ".join(said) + "}"
        case list() if nested:
            return "[" + ", ".join(_written(v, nested=False) for v in value[:8]) + "]"
        case dict():
            return "{…}"
        case list():
            return "[…]"
    return _escaped(str(value)[: _VALUE_LENGTH + 1])


def _escaped(text: str) -> str:
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text
    )


def clipped(text: str, length: int) -> str:
    """A text of at most so many characters, the last of them a mark where it was cut."""
    return text if len(text) <= length else text[: length - 1] + "…"
