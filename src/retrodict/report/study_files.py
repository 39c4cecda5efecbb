"""The files of a study: its data, table and chart, written together."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from retrodict.report.figures import to_png, to_svg
from retrodict.report.files import write_together


def write_study(
    directory: Path,
    name: str,
    data: Mapping[str, Any],
    table: str,
    figure: Figure,
    page: str | None = None,
) -> None:
    """Write what a study found: NAME.json, NAME.csv, its chart as NAME.png and NAME.svg, and a page.

    Args:
        directory: made where missing; files of the same names in it are replaced together.
        name: of the files.
        data: in SI units, strict JSON.
        table: as CSV.
        figure: the chart.
        page: Markdown, for NAME.md; None for no page.

    Raises:
        OSError: something could not be written; then nothing in the directory has changed.
    """
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
    files = {} if page is None else {f"{name}.md": page.encode()}
    files |= {
        f"{name}.csv": table.encode(),
        f"{name}.json": f"{text}\n".encode(),
        f"{name}.png": to_png(figure),
        f"{name}.svg": to_svg(figure),
    }
    write_together(directory, files)
