"""The files of a batch: an answer is kept as soon as it is known, and all make a table at the end."""

from __future__ import annotations

import hashlib
import io
import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retrodict.findings.summary import strict
from retrodict.report.files import csv_text, write_together, write_whole
from retrodict.scene.quantities import REPORTED, Units, describe, unit_of
from retrodict.studies.batch import Answered
from retrodict.studies.short import STATISTICS

if TYPE_CHECKING:
    import pandas as pd

TABLES = ("table.csv", "table.parquet")
_ROWS, _LOCK = "rows", ".lock"
PASSED = "passed"


class InUse(OSError):
    """Another process works in a folder."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """A context in which no other process writes answers to a folder.

    The lock ends with the process, however it ends. Where a system has no such locks nothing is
    refused; nothing is lost either, for each file of answers is written whole and named after the keys
    of its answers.

    Args:
        folder: folder of the batch, made where missing.

    Raises:
        InUse: another process has locked the folder.
        OSError: nothing can be written to the folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / _LOCK).open("w") as file:
        try:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InUse(
                f"{folder}: another command answers scenes there; wait for it, or choose another folder"
            ) from None
        except (ImportError, OSError):
            pass
        yield


def write_answers(answers: Mapping[str, Answered], folder: Path) -> None:
    """Store some answers in a file of their own.

    Args:
        answers: answers by key, from `retrodict.studies.batch.Entry.kept_under`.
        folder: folder of the batch.

    Raises:
        OSError: the file could not be written; then there is no such file.
    """
    lines = [
        json.dumps({"key": key, **strict(asdict(answer))}, ensure_ascii=False, allow_nan=False)
        for key, answer in answers.items()
    ]
    name = hashlib.sha256(" ".join(answers).encode()).hexdigest()[:32]
    write_whole(folder / _ROWS / f"{name}.jsonl", "".join(f"{line}\n" for line in lines).encode())


def read_answers(folder: Path) -> dict[str, Answered]:
    """All answers that were kept, by key; a file that is damaged is left out, and answered anew."""
    found: dict[str, Answered] = {}
    for file in sorted((folder / _ROWS).glob("*.jsonl")):
        try:
            for line in file.read_text("utf-8").splitlines():
                row = json.loads(line)
                key = row.pop("key")
                row["flags"] = tuple(row["flags"])
                row["numbers"] = {
                    name: {k: math.nan if v is None else float(v) for k, v in numbers.items()}
                    for name, numbers in row["numbers"].items()
                }
                found[key] = Answered(**row)
        except (ValueError, KeyError, TypeError, AttributeError):
            continue
    return found


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
    by = Counter(table["method"][passed])
    kinds = Counter(reason.partition(":")[0] for reason in table["checks"][~passed])
    said = f"{passed.sum()} of {len(table)} scenes answered"
    for before, counted in ((": ", by), (". Without numbers: ", kinds)):
        said += before * bool(counted) + ", ".join(f"{n} {what}" for what, n in counted.items())
    return f"{said}."
