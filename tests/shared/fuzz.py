"""Scene files at random, and what the command `check` says of one."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import Any

from hypothesis import strategies as st
from typer.testing import CliRunner

from retrodict.cli import app
from tests.shared.scene_file import OIL, SCENE

DOCUMENT = tomllib.loads(SCENE + OIL)
TOKENS = [
    "±",
    "+/-",
    "%",
    "-",
    "kg",
    "m",
    "deg",
    "mph",
    "^2",
    "/",
    " ",
    "1e9",
    "0",
    "nan",
    ",",
    '"',
]
TOKENS += ["\n", "[", "]", "{", "}", "=", ".", "#", "\x1b", "°", "²", "lb", "9" * 40, "1e-300", "t"]

quantities = st.lists(st.sampled_from(TOKENS) | st.text(max_size=4), max_size=6).map("".join)
written = st.builds(
    "{} ± {} {}".format,
    st.floats(),
    st.floats(),
    st.sampled_from(["kg", "m", "deg", "mph", "", "kg m^2", "s/m", "deg/s", "% m"]),
)
scalars = st.one_of(
    quantities, written, st.integers(), st.floats(), st.booleans(), st.dates(), st.times()
)
KEYS = [
    "value",
    "sd",
    "unit",
    "source",
    "a",
    "A",
    "mass",
    "edge",
    "outline",
    "corners",
    "marks",
    "end_of_rotation",
    "of",
    "departure",
    "rest",
]
keys = st.sampled_from(KEYS) | st.text()
values = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=4),
    max_leaves=6,
)


def places(table: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    items: Any = table.items() if isinstance(table, dict) else enumerate(table)
    found = []
    for key, value in items:
        found.append((*path, key))
        if isinstance(value, dict | list):
            found += places(value, (*path, key))
    return found


def toml(value: Any) -> str:
    """A value as TOML, written apart from the code under test."""
    if isinstance(value, str):
        plain = (c.isprintable() and c not in '"\\' for c in value)
        return (
            '"'
            + "".join(c if p else f"\\U{ord(c):08x}" for c, p in zip(value, plain, strict=True))
            + '"'
        )
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml(str(k))} = {toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return str(value)


@st.composite
def rewritten(draw: st.DrawFn, example: dict[str, Any] = DOCUMENT) -> str:
    """The example with any values under any keys."""
    document = copy.deepcopy(example)
    for _ in range(draw(st.integers(1, 2))):
        *path, last = draw(st.sampled_from(places(document)))
        table: Any = document
        for key in path:
            table = table[key]
        action = draw(st.sampled_from(["replace", "delete", "add"]))
        if action == "delete":
            del table[last]
        elif action == "add" and isinstance(table, dict):
            table[draw(keys)] = draw(values)
        else:
            table[last] = draw(values)
    return "\n".join(f"{toml(key)} = {toml(value)}" for key, value in document.items())


@st.composite
def mistyped(draw: st.DrawFn, example: str = SCENE) -> str:
    """The example with any change of its text."""
    start, length = draw(st.integers(0, len(example))), draw(st.integers(0, 20))
    return example[:start] + draw(quantities | st.text(max_size=20)) + example[start + length :]


texts = rewritten() | mistyped()


def verdict(text: str, folder: Path) -> str:
    """What the command `check` says of a file, which it must say in lines and not in a traceback."""
    file = folder / "fuzz.toml"
    file.write_text(text, encoding="utf-8", errors="surrogatepass")
    done = CliRunner().invoke(app, ["check", str(file)])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    lines = done.output.splitlines()
    assert lines
    known = (str(file), "  assumed: ", "  warning: ")
    assert all(line.startswith(known) and line.isprintable() for line in lines), lines
    assert done.exit_code in (0, 2)
    return "a scene" if done.exit_code == 0 else "refused"
