"""The files of a study: its data, table and chart, written together."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from retrodict.report.figures.drawing import to_png, to_svg
from retrodict.storage.files import write_together


def write_study(
    directory: Path,
    name: str,
    data: Mapping[str, Any],
    table: str,
    figure: Figure,
    page: str | None = None,
    more: Mapping[str, Figure] | None = None,
) -> None:
    """Write a study's results: NAME.json, NAME.csv, the chart as NAME.png and NAME.svg, and a page.

    Args:
        directory: output directory, made where missing; files of the same names are replaced together.
        name: name of the files without suffix.
        data: results in SI units, as values for strict JSON.
        table: CSV text.
        figure: the chart.
        page: Markdown text of NAME.md; None for no page.
        more: further charts by the name of their files without suffix.

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
    for other, chart in (more or {}).items():
        files |= {f"{other}.png": to_png(chart), f"{other}.svg": to_svg(chart)}
    write_together(directory, files)
