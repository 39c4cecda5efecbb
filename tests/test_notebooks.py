"""The notebooks in examples/: whole, small, with what they show, and true to the public names.

CI runs them by `examples/notebooks/run.py`; nothing is run here.
"""

from __future__ import annotations

import ast
import base64
import inspect
import os
import re
import struct
from collections import Counter
from pathlib import Path
from typing import Any

import nbformat
import pytest

import retrodict as rd
from retrodict import mechanics
from tests.shared.pages import ROOT

FOLDER = ROOT / "examples" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
MOST_BYTES, MOST_CODE, MOST_LINES = 300_000, 15, 40
WIDEST = 720  # pixels
# what a variable of such a name is, in every notebook
KINDS = {
    "scene": rd.Scene,
    "result": rd.Result,
    "theirs": rd.Result,
    "ladder": rd.Ladder,
    "session": rd.Session,
}

every_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def cells(path: Path, kind: str) -> list[nbformat.NotebookNode]:
    """Those of one kind."""
    notebook = nbformat.read(path, as_version=4)
    return [cell for cell in notebook.cells if cell.cell_type == kind]


def trees(path: Path) -> list[ast.Module]:
    """Each code cell, parsed."""
    return [ast.parse(cell.source) for cell in cells(path, "code")]


def assigned(tree: ast.Module) -> set[str]:
    """Names that a cell gives a value, but for those inside of functions and comprehensions."""
    names: set[str] = set()

    class Visitor(ast.NodeVisitor):
        def visit_Name(self, node: ast.Name) -> None:
            if isinstance(node.ctx, ast.Store):
                names.add(node.id)

        def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
            names.add(node.name)

        def visit_alias(self, node: ast.alias) -> None:
            names.add((node.asname or node.name).split(".")[0])

        def visit_Lambda(self, node: ast.Lambda) -> None:
            pass

        visit_ListComp = visit_DictComp = visit_SetComp = visit_GeneratorExp = visit_Lambda  # noqa: N815

    Visitor().visit(tree)
    return names


def test_there_are_eight() -> None:
    assert [path.name[:2] for path in NOTEBOOKS] == [f"0{i}" for i in range(1, 9)]


@every_notebook
def test_it_is_a_small_notebook(path: Path) -> None:
    nbformat.validate(nbformat.read(path, as_version=4))
    code = cells(path, "code")
    assert path.stat().st_size <= MOST_BYTES
    assert len(code) <= MOST_CODE
    assert max(len(cell.source.splitlines()) for cell in code) <= MOST_LINES


@every_notebook
def test_it_shows_what_it_draws_and_no_error(path: Path) -> None:
    for cell in cells(path, "code"):
        assert cell.outputs or set(assigned(ast.parse(cell.source))), cell.source
        assert not [each for each in cell.outputs if each.output_type == "error"], cell.source
        if re.search(r"\bplot\w*\(|\.show\(", cell.source):
            data = [each.get("data", {}) for each in cell.outputs]
            images = [base64.b64decode(each["image/png"]) for each in data if "image/png" in each]
            assert images, cell.source
            assert all(struct.unpack(">I", image[16:20])[0] <= WIDEST for image in images)


@every_notebook
def test_nothing_in_it_differs_from_run_to_run(path: Path) -> None:
    """Counts, times, and texts on standard error, which are the machine's own."""
    notebook = nbformat.read(path, as_version=4)
    assert set(notebook.metadata) == {"kernelspec", "language_info"}
    assert set(notebook.metadata.language_info) == {"name"}
    for cell in notebook.cells:
        assert not cell.metadata
        for each in cell.get("outputs", []):
            assert cell.execution_count is None
            assert not each.get("execution_count")
            assert not each.get("metadata")
            assert each.get("name") != "stderr"
            assert not re.search(
                r" at 0x[0-9a-f]{6}|/home/|/root/|/tmp/", str(each.get("text", ""))
            )


@every_notebook
def test_its_links_lead_somewhere(path: Path) -> None:
    for cell in cells(path, "markdown"):
        for target in re.findall(r"\]\(([^)\s:#]+)[^)]*\)", cell.source):
            assert Path(os.path.normpath(path.parent / target)).exists(), target


@every_notebook
def test_each_name_has_its_value_from_one_cell(path: Path) -> None:
    """So that cells may be run again in any order, and marimo can convert the notebook."""
    counted = Counter(name for tree in trees(path) for name in assigned(tree))
    assert not [name for name, count in counted.items() if count > 1]


@every_notebook
def test_public_names_and_arguments_exist(path: Path) -> None:
    homes: dict[str, Any] = {"rd": rd, "mech": mechanics}
    for node in (node for tree in trees(path) for node in ast.walk(tree)):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            of = node.value.id
            if of in homes:
                assert node.attr in homes[of].__all__, f"{of}.{node.attr}"
            elif of in KINDS:
                known = [*dir(KINDS[of]), *getattr(KINDS[of], "__dataclass_fields__", ())]
                made = f"self.{node.attr} = " in inspect.getsource(KINDS[of])
                assert node.attr in known or made, f"{of}.{node.attr}"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            home = homes.get(getattr(node.func.value, "id", ""))
            if home is None or any(isinstance(each, ast.Starred) for each in node.args):
                continue
            given = {each.arg: each.value for each in node.keywords if each.arg}
            inspect.signature(getattr(home, node.func.attr)).bind(*node.args, **given)
