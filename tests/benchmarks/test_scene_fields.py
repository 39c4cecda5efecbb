"""docs/scene-file.md has the rows of the quantities that are declared."""

from __future__ import annotations

from benchmarks.scene_fields import PAGE, refreshed, rows


def test_the_page_has_every_row_as_declared() -> None:
    text = PAGE.read_text("utf-8")
    assert len(list(rows())) > 15
    assert refreshed(text) == text, "python -m benchmarks.scene_fields rewrites it"


def test_a_row_that_lacks_is_put_behind_the_one_declared_before() -> None:
    text = PAGE.read_text("utf-8")
    (_, first), (_, second), *_ = rows()
    assert second in text
    assert f"{first}\n{second}\n" in refreshed(text.replace(f"{second}\n", ""))
