"""Tables of the studies: CSV, and below it what was found, a line each."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

Remark = tuple[str, str]  # its kind, which is where it goes in a page of docs/; its text


def write(
    file: Path, columns: Sequence[str], rows: Iterable[Sequence[Any]], remarks: Iterable[Remark]
) -> None:
    """Write a table and its remarks; numbers to four digits."""
    with file.open("w", newline="", encoding="utf-8") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(columns)
        table.writerows([shown(v) if isinstance(v, float) else v for v in row] for row in rows)
        out.writelines(f"# {kind}: {text}\n" for kind, text in remarks)


def shown(value: float) -> str:
    """A number to four digits; nothing where it is none."""
    return "" if np.isnan(value) else f"{value:.4g}"
