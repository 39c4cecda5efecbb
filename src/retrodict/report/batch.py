"""The files of a batch: an answer is kept as soon as it is known, and all make a table at the end."""

from __future__ import annotations

import io
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retrodict.findings.summary import strict
from retrodict.interchange.tables import csv_text
from retrodict.scene.quantities import REPORTED, Units, describe, unit_of
from retrodict.storage.files import write_together
from retrodict.storage.rows import read_rows, write_rows
from retrodict.studies.batch import Answered
from retrodict.studies.short import STATISTICS

if TYPE_CHECKING:
    import pandas as pd

TABLES = ("table.csv", "table.parquet")
PASSED = "passed"


def write_answers(answers: Mapping[str, Answered], folder: Path) -> None:
    """Store some answers in a file of their own.

    Args:
        answers: answers by key, from `retrodict.studies.batch.Entry.kept_under`.
        folder: folder of the batch.

    Raises:
        OSError: the file could not be written; then there is no such file.
    """
    write_rows({key: strict(asdict(answer)) for key, answer in answers.items()}, folder)


def read_answers(folder: Path) -> dict[str, Answered]:
    """All answers that were kept, by key; a file that is damaged is left out, and answered anew."""
    found: dict[str, Answered] = {}
    for rows in read_rows(folder):
        with suppress(ValueError, KeyError, TypeError, AttributeError):
            found |= {key: _answer(row) for key, row in rows}
    return found


def _answer(row: dict[str, Any]) -> Answered:
    """An answer from its row."""
    numbers = {
        name: {k: math.nan if v is None else float(v) for k, v in numbers.items()}
        for name, numbers in row["numbers"].items()
    }
    return Answered(**row | {"flags": tuple(row["flags"]), "numbers": numbers})


def table_of(
    labels: Sequence[str], answers: Sequence[Answered | None], units: Units = "si"
) -> pd.DataFrame:
    """Answers in a table.

    Args:
        labels: label of each scene.
        answers: answer of each scene; None leaves the scene out of the table.
        units: "si" or "us".

    Returns:
        One row a scene: `scene`, `model`, `method`, `checks` ("passed", or why there are no numbers),
        `flags`, then mean, sd, median, limits of the central 95 % and the Monte Carlo error of the mean
        of each quantity that some scene reports; NaN where a scene has none. `attrs["units"]` has the
        unit of each column of numbers.
    """
    import pandas as pd

    known = [(label, each) for label, each in zip(labels, answers, strict=True) if each]
    names = [name for name in REPORTED if any(name in each.numbers for _, each in known)]
    unit = {name: unit_of(describe(name)[1], units) for name in names}
    rows = []
    for label, each in known:
        row: dict[str, Any] = {"scene": label, "model": each.model, "method": each.method}
        row |= {"checks": each.reason or PASSED, "flags": "; ".join(each.flags)}
        for name in names:
            numbers = each.numbers.get(name, {})
            for key in STATISTICS:
                row[f"{name}_{key}"] = numbers.get(key, math.nan) / unit[name].worth
        rows.append(row)
    table = pd.DataFrame(rows, columns=None if rows else ["scene", "model", "method", "checks"])
    table.attrs["units"] = {f"{n}_{key}": unit[n].symbol for n in names for key in STATISTICS}
    return table


def write_table(table: pd.DataFrame, folder: Path) -> None:
    """Write table.csv and, where pyarrow is installed, table.parquet, with units in the header.

    Args:
        table: table of answers, from `table_of`.
        folder: folder of the batch.

    Raises:
        OSError: a file could not be written; then no file has changed.
    """
    units = table.attrs["units"]
    headed = table.rename(columns={k: f"{k} [{unit}]" for k, unit in units.items() if unit})
    rows = headed.astype(object).where(headed.notna(), None).to_dict("records")
    contents = [csv_text(list(headed.columns), rows).encode()]
    if find_spec("pyarrow"):
        content = io.BytesIO()
        headed.to_parquet(content, index=False)
        contents.append(content.getvalue())
    write_together(folder, dict(zip(TABLES, contents, strict=False)))
    if len(contents) < len(TABLES):  # an existing file is of an earlier table
        (folder / TABLES[1]).unlink(missing_ok=True)


def files_of(folder: Path) -> list[Path]:
    """The tables that were written to a folder."""
    return [folder / name for name in TABLES if (folder / name).exists()]


def in_words(table: pd.DataFrame) -> str:
    """A sentence or two: scenes answered, by method, and scenes without numbers, by reason."""
    passed = table["checks"] == PASSED
    methods = Counter(table["method"][passed])
    kinds = Counter(reason.partition(":")[0] for reason in table["checks"][~passed])
    said = f"{passed.sum()} of {len(table)} scenes answered"
    for before, counted in ((": ", methods), (". Without numbers: ", kinds)):
        said += before * bool(counted) + ", ".join(f"{n} {what}" for what, n in counted.items())
    return f"{said}."
