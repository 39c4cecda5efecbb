"""Writes the rows of docs/scene-file.md for the quantities that `scene.fields` declares.

python3 -m uv run --group bench python -m benchmarks.scene_fields
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from benchmarks.__main__ import DOCS
from retrodict.scene.fields import COEFFICIENTS, IMPACT, OF_VEHICLES, SLOPE, SURFACE, Field

PAGE = DOCS / "scene-file.md"
_SD = {"required": "**required**", "refused": "–"}


def rows() -> Iterator[tuple[str, str]]:
    """Key and row of each quantity that its record keeps as it is written, in the order of the page."""
    for prefix, table in [
        *OF_VEHICLES.items(),
        ("", IMPACT),
        ("", COEFFICIENTS),
        ("", SURFACE),
        ("", SLOPE),
    ]:
        for key, field in table.items():
            if not field.computed:
                yield f"{prefix}{key}", _row(f"{prefix}{key}", field)


def _row(key: str, field: Field) -> str:
    sd = _SD.get(field.uncertainty, "*default*" if field.default else "exact")
    unit = field.dimension.units[0] if field.dimension.units else ""
    bounds = f"{field.low:g} to {field.high:g} {unit}".rstrip()
    must = "required" if field.required else "optional"
    return f"| `{key}` | {must} | {sd} | {bounds}: {field.meaning} |"


def refreshed(page: str) -> str:
    """A page with the rows as they are declared: a new one stands behind the row declared before it.

    Args:
        page: text of docs/scene-file.md.
    """
    before = ""
    for key, row in rows():
        there = re.compile(rf"^\| `{re.escape(key)}` \|.*$", re.MULTILINE)
        if there.search(page):
            page = there.sub(lambda _, row=row: row, page, count=1)  # type: ignore[misc]
        else:
            page = page.replace(before, f"{before}\n{row}", 1)
        before = row
    return page


if __name__ == "__main__":
    PAGE.write_text(refreshed(PAGE.read_text("utf-8")), encoding="utf-8")
