"""Values are named by nouns: no argument and no variable has a bare preposition for a name."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "retrodict"
PREPOSITIONS = {"at", "beside", "by", "of", "on"}
ROOMS = ("cli", "findings", "interchange", "mechanics", "report", "scene", "storage", "studies")
NOT_YET = {"cli/explore.py", "studies/batch.py"}


def names_in(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Line and name of every argument and variable; fields are not counted: they are keys of files."""
    fields = {
        id(item.target)
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        for item in node.body
        if isinstance(item, ast.AnnAssign)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif (
            isinstance(node, ast.Name)
            and isinstance(node.ctx, ast.Store)
            and id(node) not in fields
        ):
            yield node.lineno, node.id


def test_a_preposition_is_noticed_and_a_key_of_a_file_is_not() -> None:
    code = "class A:\n    of: str\ndef f(at):\n    by = at\n    return by"
    found = [name for _, name in names_in(ast.parse(code)) if name in PREPOSITIONS]
    assert sorted(found) == ["at", "by"]


def test_no_value_is_named_by_a_preposition() -> None:
    found = []
    for file in [
        *SOURCE.glob("*.py"),
        *(f for room in ROOMS for f in SOURCE.glob(f"{room}/**/*.py")),
    ]:
        place = file.relative_to(SOURCE).as_posix()
        if place not in NOT_YET:
            names = names_in(ast.parse(file.read_text("utf-8")))
            found += [f"{place}:{line}: {name}" for line, name in names if name in PREPOSITIONS]
    assert not found
