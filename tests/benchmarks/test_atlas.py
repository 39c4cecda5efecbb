"""The page is what its tables make, and every edge is pinned by a test that exists."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import pytest

from benchmarks import page

DOCS = Path(__file__).parents[2] / "docs"
EDGES = Path(__file__).parents[1] / "stability"


@pytest.mark.parametrize("part", ["mechanics", "inference"])
def test_every_edge_names_a_test(part: str) -> None:
    lines = (DOCS / "charts" / f"atlas-{part}.csv").read_text("utf-8").splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("# ")))
    assert len(rows) >= 9
    for row in rows:
        file, name = row["test"].split("::")
        assert f"def {name}(" in (EDGES / file).read_text("utf-8"), row["test"]
        assert row["verdict"] in ("fine", "flagged", "wrong")


def test_the_page_is_what_its_tables_make(tmp_path: Path) -> None:
    copy = tmp_path / "atlas.md"
    shutil.copy(DOCS / "atlas.md", copy)
    page.refresh(copy, page.of_atlas(DOCS / "charts"))
    assert copy.read_text("utf-8") == (DOCS / "atlas.md").read_text("utf-8")
    assert "- none" not in copy.read_text("utf-8")
