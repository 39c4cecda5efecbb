"""The report of a calibration: its verdict, its table of ranks, and files."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from retrodict.interchange.tables import csv_text
from retrodict.report.layout import print_table
from retrodict.storage.files import write_whole
from retrodict.studies.calibration import (
    CLOSING,
    DRAWS,
    MOST_WITHHELD,
    QUANTITIES,
    SLOWLY,
    Calibration,
    Row,
    digest,
)
from retrodict.studies.uniformity import BAND, LEVELS, Uniformity, uniformity

RANKS = "calibration.csv"
# fewest simulations for a verdict; with fewer, one or two that are withheld exceed MOST_WITHHELD
LEAST = 50
_SETTINGS = ("model", "method", "seed", "scene", "closing_from")
_OLDER = {"closing_from": "3.0"}  # m/s, for tables that do not state it
_COLUMNS = (*_SETTINGS, "simulation", *QUANTITIES, "reason", "closing_speed")  # the last in m/s


def calibrated(calibration: Calibration, found: dict[str, Uniformity]) -> bool:
    """Whether nothing speaks against the method: enough ranks, jointly inside, and few runs withheld.

    Args:
        calibration: calibration to be judged.
        found: uniformity of the ranks by quantity, from `uniformity`.
    """
    few = calibration.withheld <= MOST_WITHHELD
    enough = len(calibration.ranked) >= LEAST
    return enough and few and all(each.inside_jointly for each in found.values())


def verdict(calibration: Calibration, found: dict[str, Uniformity]) -> str:
    """The verdict on a calibration in a few sentences.

    Args:
        calibration: calibration to be judged.
        found: uniformity of the ranks by quantity, from `uniformity`.
    """
    done, ranked = len(calibration.rows), len(calibration.ranked)
    withheld = f"{done - ranked} of {done} runs ({calibration.withheld:.1%}) were withheld"
    if calibration.withheld > MOST_WITHHELD:
        withheld += f", more than {MOST_WITHHELD:.0%}"
    if done < LEAST:
        return (
            f"Too few to judge: {done} simulations; from {LEAST} on there is a verdict. {withheld}."
        )
    if ranked < LEAST:
        return f"NOT CALIBRATED: fewer than {LEAST} ranks are too few to decide. {withheld}."
    outside = [name for name, each in found.items() if not each.inside_jointly]
    alone = [name for name, each in found.items() if not each.inside]
    level = 1 - (1 - BAND) / len(found)
    ranks = (
        f"the ranks of {', '.join(outside)} are not uniform"
        if outside
        else f"nothing is seen against uniform ranks in {ranked} simulations"
    )
    compared = (
        f"{len(found)} quantities were compared, each at {level:.2%} for {BAND:.0%} over all; at "
        f"{BAND:.0%} by itself {', '.join(alone) or 'none'} leaves its band"
    )
    word = "Calibrated" if calibrated(calibration, found) else "NOT CALIBRATED"
    if not outside and word != "Calibrated":
        word += ", for too many runs were withheld"
    return f"{word}: {ranks}. {compared}. {withheld}."


def print_calibration(calibration: Calibration, console: Console) -> None:
    """Print coverage and verdict of each quantity, then the verdict on all.

    Args:
        calibration: calibration to be printed.
        console: rich console to print on.
    """
    found = uniformity(calibration)
    table = Table(title=f"{calibration.model}, {calibration.method}", title_justify="left")
    table.add_column("quantity")
    for heading in (*(f"{level} % holds" for level in LEVELS), f"in its {BAND:.0%} band"):
        table.add_column(heading, justify="right")
    for name, each in found.items():
        shares = [f"{share:.1%} ± {error:.1%}" for share, error in each.coverage.values()]
        cells = [name, *shares, "yes" if each.inside else "no"]
        table.add_row(*map(Text, cells), style=None if each.inside else "red")
    print_table(console, table)
    good = calibrated(calibration, found)
    console.print(Text(verdict(calibration, found), style="green" if good else "bold red"))


def calibration_data(calibration: Calibration) -> dict[str, Any]:
    """A calibration's verdict in strict JSON."""
    found, slow = uniformity(calibration), calibration.slow
    reasons: dict[str, int] = {}
    for row in calibration.rows:
        if row.reason:
            kind = row.reason.split(":")[0]
            reasons[kind] = reasons.get(kind, 0) + 1
    return {
        **_settings(calibration),
        "simulations": calibration.simulations,
        "done": len(calibration.rows),
        "ranked": len(calibration.ranked),
        "withheld": calibration.withheld,
        "withheld_because": reasons,
        "draws": DRAWS,
        "calibrated": calibrated(calibration, found),
        "verdict": verdict(calibration, found),
        "quantities": _of_each(found),
        "closing_slowly": {
            "below": SLOWLY,
            "done": len(slow.rows),
            "ranked": len(slow.ranked),
            "withheld": slow.withheld,
            "quantities": _of_each(uniformity(slow)),
        },
    }


def _of_each(found: dict[str, Uniformity]) -> dict[str, Any]:
    return {
        name: {
            "inside": each.inside,
            "inside_jointly": each.inside_jointly,
            "furthest": float(abs(each.difference).max()),
            "coverage": {
                str(level): {"share": share, "error": error}
                for level, (share, error) in each.coverage.items()
            },
        }
        for name, each in found.items()
    }


def write_calibration(calibration: Calibration, directory: Path) -> None:
    """Write calibration.csv, calibration.json, and the chart as calibration.png and .svg.

    Args:
        calibration: calibration to be written.
        directory: output directory, made where missing; files of the same names are replaced together.

    Raises:
        OSError: a file could not be written; then no file has changed.
    """
    from retrodict.report.figures.calibration import calibration_figure
    from retrodict.report.study_files import write_study

    figure = calibration_figure(calibration)
    data = calibration_data(calibration)
    write_study(directory, "calibration", data, _table(calibration), figure)


def write_ranks(calibration: Calibration, directory: Path) -> None:
    """Write calibration.csv, one row per simulation; an interrupted calibration goes on from the file.

    Args:
        calibration: calibration whose rows are written.
        directory: output directory, made where missing.

    Raises:
        OSError: the file could not be written.
    """
    write_whole(directory / RANKS, _table(calibration).encode())


def _table(calibration: Calibration) -> str:
    """A CSV table with one row per simulation."""
    settings = _settings(calibration)
    rows = [
        settings
        | {
            "simulation": row.simulation,
            "reason": row.reason,
            "closing_speed": f"{row.closing:.3f}",
        }
        | row.ranks
        for row in calibration.rows
    ]
    return csv_text(_COLUMNS, rows)


def read_ranks(like: Calibration, directory: Path) -> tuple[Row, ...]:
    """The rows that `write_ranks` wrote.

    Args:
        like: calibration with the scene, model, method and seed that the file must have.
        directory: directory of the file calibration.csv.

    Returns:
        The rows; empty where there is no file.

    Raises:
        ValueError: the file is of another calibration, or is no table of ranks.
    """
    file = directory / RANKS
    if not file.exists():
        return ()
    mine = {k: str(v) for k, v in _settings(like).items()}
    rows, seen = list[Row](), set[int]()
    try:
        for row in csv.DictReader(io.StringIO(file.read_text("utf-8"))):
            other = {k: (_OLDER | row)[k] for k in _SETTINGS}
            if other != mine:
                raise ValueError(f"is of another calibration ({_listed(other)})")
            # older tables have no column of A's speed
            ranks = {name: int(row[name]) for name in QUANTITIES if row.get(name)}
            number = int(row["simulation"])
            if number < 0 or number in seen:
                raise ValueError(f"has simulation {number} twice, or has none of that number")
            if not all(0 <= rank <= DRAWS for rank in ranks.values()):
                raise ValueError(f"has a rank in simulation {number} that is not in 0 to {DRAWS}")
            if bool(ranks) == bool(row["reason"]):
                raise ValueError(f"has in simulation {number} not either ranks or a reason")
            seen.add(number)
            rows.append(Row(number, ranks, row["reason"], float(row["closing_speed"])))
    except (KeyError, TypeError, ValueError) as error:
        why = str(error) if str(error).startswith(("is of", "has ")) else "is not a table of ranks"
        raise ValueError(
            f"{file} {why}; this one is {_listed(mine)}: choose another folder, or delete the file"
        ) from None
    return tuple(rows)


def _settings(calibration: Calibration) -> dict[str, Any]:
    return {
        "model": calibration.model,
        "method": calibration.method,
        "seed": calibration.seed,
        "scene": digest(calibration.scene, calibration.model),
        "closing_from": CLOSING,
    }


def _listed(settings: dict[str, Any]) -> str:
    return ", ".join(f"{k} {str(v)[:40]!r}" for k, v in settings.items())
