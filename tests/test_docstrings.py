"""Entries of docstrings are noun phrases: none continues the name before it ("seed: of the draws")."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
CONTINUES = re.compile(
    r"(that|which|whose|what|of|by|as|it|its|they|those|these|ones?|from|to|in|on|at|with|where|"
    r"whether it|beside|likewise|there|so|how)\b",
    re.IGNORECASE,
)
SECTIONS = ("Args:", "Attributes:")
ENTRY = re.compile(r"^\s{4,}(\*{0,2}\w[\w, ]*?)(?: \([^)]*\))?:\s+(.*)$")


def entries(doc: str) -> Iterator[tuple[str, str]]:
    """Name and first line of each entry of the arguments and attributes in a docstring."""
    inside = False
    for line in doc.splitlines():
        bare = line.strip()
        if bare.endswith(":") and " " not in bare:
            inside = bare in SECTIONS
        elif inside and (entry := ENTRY.match(line)):
            yield entry[1], entry[2]


def documented(folder: str) -> Iterator[tuple[str, str, str]]:
    """Place, name and first line of every entry in the modules of a folder."""
    for file in sorted((ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
                place = f"{file.relative_to(ROOT)}:{getattr(node, 'lineno', 1)}"
                for name, text in entries(ast.get_docstring(node, clean=False) or ""):
                    yield place, name, text


def test_an_entry_that_continues_its_name_is_found() -> None:
    doc = "A function.\n\n    Args:\n        seed: of the draws.\n        count: number of draws.\n    "
    assert [CONTINUES.match(text) is not None for _, text in entries(doc)] == [True, False]


def test_no_entry_continues_its_name() -> None:
    found = [each for folder in ("src", "models") for each in documented(folder)]
    assert len(found) > 1500
    assert [each for each in found if CONTINUES.match(each[2])] == []
