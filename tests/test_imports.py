"""Tests and benchmarks meet in `tests.shared` alone; only the tests of benchmarks import benchmarks."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]


def imports(folder: str) -> Iterator[tuple[str, str]]:
    """Every file of a folder with each module of tests or benchmarks that it imports."""
    for file in sorted((ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                assert not node.level, f"{file}: a relative import"
                names = [f"{node.module}.{alias.name}" for alias in node.names]
            for name in names:
                if name.startswith(("tests", "benchmarks")):
                    yield str(file.relative_to(ROOT)), name


def test_benchmarks_import_of_the_tests_only_what_is_shared() -> None:
    found = list(imports("benchmarks"))
    assert ("benchmarks/kinks.py", "tests.shared.reference") in found
    assert not [each for each in found if not each[1].startswith(("tests.shared.", "benchmarks"))]


def test_what_is_shared_imports_neither() -> None:
    found = list(imports("tests/shared"))
    assert not [each for each in found if not each[1].startswith("tests.shared.")]


def test_only_the_tests_of_benchmarks_import_them() -> None:
    found = [file for file, name in imports("tests") if name.startswith("benchmarks")]
    assert found
    assert not [file for file in found if not file.startswith("tests/benchmarks/")]
