"""The page of error rates is what the tables of the other pages make."""

from __future__ import annotations

import shutil
from pathlib import Path

from benchmarks import how_wrong, page

DOCS = Path(__file__).parents[2] / "docs"


def test_the_page_is_what_the_tables_make(tmp_path: Path) -> None:
    copy = tmp_path / "how-wrong.md"
    shutil.copy(DOCS / "how-wrong.md", copy)
    page.refresh(copy, how_wrong.parts(DOCS / "charts"))
    assert copy.read_text("utf-8") == (DOCS / "how-wrong.md").read_text("utf-8")
    assert "- none" not in copy.read_text("utf-8")
