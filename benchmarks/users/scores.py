"""Rows of all runs against those of the paper's example: the parts of docs/users.md."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from benchmarks import page
from benchmarks.users.catalogue import UserScene
from benchmarks.users.runs import AGAIN, FIRST, QUANTITIES, Row

PAPER = "brach-1977"
PASSES = (FIRST, AGAIN)
PICTURE = "pictures/users.png"
NOT_RUN = ["- This benchmark was not run yet."]
PARTS = ("machine", "summary", "chart", "table", "reasons")
VERDICTS = ("passed", "withheld", "refused", "traceback", "timed out", "failed")
FAR = 3.0  # standard deviations of answer and right answer together
_WITH_NUMBERS = ("passed", "withheld")
_NAMES = {FIRST: "The first time", AGAIN: "Again"}


class Score(NamedTuple):
    """A scene and what its runs took.

    Args:
        scene: the scene.
        rows: rows by pass; a pass that was not run is left out.
        ratios: CPU seconds over the median of the paper's example, by pass.
        clock: seconds by the clock of the paper's example, median, of the pass that is shown.
    """

    scene: UserScene
    rows: dict[str, Row]
    ratios: dict[str, float]
    clock: float

    @property
    def row(self) -> Row:
        """The last run's row, whose answer is shown."""
        return self.rows[AGAIN] if AGAIN in self.rows else self.rows[FIRST]


def paper_seconds(rows: Sequence[Row], column: str = "cpu") -> dict[str, float]:
    """Median seconds of the paper's example by pass: of the CPU, or `wall`."""
    return {
        which: statistics.median(mine)
        for which in PASSES
        if (mine := [float(r[column]) for r in rows if (r["scene"], r["pass"]) == (PAPER, which)])
    }


def all_scores(rows: Sequence[Row], scenes: Mapping[str, UserScene]) -> list[Score]:
    """The scenes that were run, in their order.

    Args:
        rows: rows of all runs, those of the paper's example among them.
        scenes: scenes by name.

    Returns:
        A score for each scene with a row.
    """
    unit, clock = (paper_seconds(rows, column) for column in ("cpu", "wall"))
    found = []
    for scene in scenes.values():
        mine = {row["pass"]: row for row in rows if row["scene"] == scene.name}
        if mine:
            ratios = {k: float(row["cpu"]) / unit[k] for k, row in mine.items() if k in unit}
            shown = AGAIN if AGAIN in mine else FIRST
            found.append(Score(scene, mine, ratios, clock.get(shown, float("nan"))))
    return found


def parts(rows: Sequence[Row], scenes: Mapping[str, UserScene], machine: str = "") -> page.Parts:
    """What stands between the markers of docs/users.md.

    Args:
        rows: rows of all runs.
        scenes: scenes by name.
        machine: the machine, in words.

    Returns:
        Lines by part.
    """
    found = all_scores(rows, scenes)
    if not found:
        return dict.fromkeys(PARTS, NOT_RUN)
    reasons = list(_reasons(found))
    return {
        "machine": [f"- {machine}"],
        "summary": [*_summary(found, paper_seconds(rows))],
        "chart": [f"![CPU seconds of each scene over those of the paper's example]({PICTURE})"],
        "table": page.table(_HEADINGS, map(_cells, found)),
        "reasons": page.table(["scene", "verdict", "why, and what was flagged"], reasons)
        if reasons
        else ["- none"],
    }


def _summary(found: Sequence[Score], unit: Mapping[str, float]) -> Iterator[str]:
    counts = Counter(score.row["verdict"] for score in found)
    named = ", ".join(f"{counts[verdict]} {_PLURAL.get(verdict, verdict)}" for verdict in VERDICTS)
    yield f"- {len(found)} scenes: {named}."
    for which in PASSES:
        ratios = {s.scene.name: s.ratios[which] for s in found if which in s.ratios}
        if not ratios:
            continue
        worst = max(ratios, key=lambda name: ratios[name])
        values = [*ratios.values()]
        yield (
            f"- {_NAMES[which]}: median {_ratio(float(np.median(values)))}, 95 % of scenes at most "
            f"{_ratio(float(np.quantile(values, 0.95, method='inverted_cdf')))}, worst "
            f"{_ratio(ratios[worst])} ({worst}) times the CPU seconds of the paper's example, "
            f"which takes {unit[which]:.1f}."
        )
    compared = [(score, off) for score in found if (off := _off(score)) is not None]
    far = [f"{score.scene.name} ({off:.1f})" for score, off in compared if off > FAR]
    yield (
        f"- Passed, with a known right answer: {len(compared)}. More than {FAR:.0f} standard deviations "
        f"from it: {', '.join(far) or 'none'}."
    )
    flagged = [s for s in found if s.scene.refused]
    said = ", ".join(f"{s.scene.name}: {_with_flags(s.row)}" for s in flagged)
    if flagged:
        yield f"- Numbers that contradict each other: {said}."
    late = [s.scene.name for s in found if AGAIN in s.rows and s.rows[AGAIN]["programs"] != "0"]
    if late:
        yield f"- Compiled something again: {', '.join(late)}."


def _with_flags(row: Row) -> str:
    """A verdict, and whether a passed answer was flagged."""
    if row["verdict"] != "passed":
        return row["verdict"]
    return "passed, flagged" if row["flags"] else "passed, not flagged"


_PLURAL = {"traceback": "tracebacks"}
_HEADINGS = (
    "scene", "kind", "verdict", "answer", "right answer", "CPU ratio, first", "again", "method",
)  # fmt: skip


def _cells(score: Score) -> list[str]:
    row = score.row
    verdict = row["verdict"]
    before = score.rows.get(FIRST, row)["verdict"]
    if before != verdict:
        verdict = f"{verdict} (first: {before})"
    known = score.scene.truth
    right = "; ".join(f"{name} {_value(*value)}" for name, value in known.items())
    return [
        score.scene.name,
        score.scene.kind,
        verdict,
        _answers(row, known) or "–",
        "refused or flagged" if score.scene.refused else right or "–",
        *(_cell(score, which) for which in PASSES),
        " ".join(filter(None, (row["model"], row["method"]))) or "–",
    ]


def _cell(score: Score, which: str) -> str:
    """A ratio; at least that where the command was stopped."""
    if which not in score.ratios:
        return "–"
    stopped = score.rows[which]["verdict"] == "timed out"
    return ("≥ " if stopped else "") + _ratio(score.ratios[which])


def _answers(row: Row, known: Mapping[str, object]) -> str:
    """Speeds, and whatever a right answer is known of; in parentheses where it was withheld."""
    if row["verdict"] not in _WITH_NUMBERS:
        return ""
    shown = [q for q in QUANTITIES if q in known or q.startswith("speed")]
    text = "; ".join(
        f"{q} {_value(float(row[f'{q}_mean']), float(row[f'{q}_sd'] or 0))}"
        for q in shown
        if row[f"{q}_mean"]
    )
    return f"({text})" if text and row["verdict"] == "withheld" else text


def _reasons(found: Sequence[Score]) -> Iterator[list[str]]:
    for score in found:
        row = score.row
        why = "; ".join(filter(None, (row["reason"], row["flags"])))
        if why or row["verdict"] != "passed":
            yield [score.scene.name, row["verdict"], why.replace("|", "\\|").replace("\n", " ")]


def _off(score: Score) -> float | None:
    """Largest distance of a passed answer from the right one, in sd of both; None without either."""
    row = score.row
    if row["verdict"] != "passed":
        return None
    distances = [
        abs(float(row[f"{name}_mean"]) - value.mean)
        / float(np.hypot(float(row[f"{name}_sd"]), value.sd))
        for name, value in score.scene.truth.items()
        if row[f"{name}_mean"] and float(row[f"{name}_sd"] or 0)
    ]
    return max(distances, default=None)


def _value(mean: float, sd: float) -> str:
    return f"{mean:.2f} ± {sd:.2f}" if sd else f"{mean:.2f}"


def _ratio(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}" if value >= 10 else f"{value:.2f}"
