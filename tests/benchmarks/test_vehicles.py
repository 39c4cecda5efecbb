"""The page of vehicles is what the library makes."""

from __future__ import annotations

import shutil
from pathlib import Path

from benchmarks import page, vehicles

PAGE = Path(__file__).parents[2] / "docs" / "vehicles.md"


def test_the_page_is_what_the_library_makes(tmp_path: Path) -> None:
    copy = tmp_path / PAGE.name
    shutil.copy(PAGE, copy)
    page.refresh(copy, vehicles.parts())
    assert copy.read_text("utf-8") == PAGE.read_text("utf-8")
    assert "- none" not in copy.read_text("utf-8")
